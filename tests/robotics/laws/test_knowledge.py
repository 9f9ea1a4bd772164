"""What laws say that they know."""

from dataclasses import dataclass

import pytest

from robotics.laws.law import KNOWLEDGE, Law
from robotics.laws.tracking.lyapunov import Lyapunov


def test_a_law_says_what_it_knows_in_known_words():
    @dataclass(frozen=True, kw_only=True)
    class Knowing(Lyapunov):
        knows = ("reference", "reference velocity")

    assert set(Knowing().knows) <= set(KNOWLEDGE)
    assert isinstance(Law.knows, property)  # so that it may depend on the gains
    with pytest.raises(TypeError, match=r"Wrong\.knows: unknown word 'wheel speed'; did you mean 'wheel speeds'"):

        class Wrong(Lyapunov):
            knows = ("reference", "wheel speed")
