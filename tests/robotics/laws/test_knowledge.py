"""What laws say that they know."""

from dataclasses import dataclass, replace

import numpy as np
import pytest

import robotics
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


# What is changed of an observation to see whether a law uses what the word means
LAWS = ("fuzzy", "lyapunov", "pdc", "csm", "esm")


def _commanded(law, **changes):
    made, scenario = robotics.make_controller(law), robotics.load_scenario("lyapunov-sine")
    references = changes.pop("references", scenario.trajectory)
    at = scenario.trajectory.at(1.0)
    one = np.ones((1, 1))
    values = {"time": 1.0, "x": 0.1 * one, "y": 0.2 * one, "heading": 0.3 * one, "v": 0.2 * one, "w": 0.1 * one}
    reference = at._replace(**changes.pop("reference", {}))
    seen = robotics.Observation(**{**values, **changes}, reference=reference, references=references)
    setting = replace(scenario.setting, references=references)
    memory = made.init(setting, 1)
    command = None
    for _ in range(2):  # what a law makes of a rate needs two periods
        command, memory = made.control(seen, memory, 0.05)
    return command.first.item(), command.second.item()


def _later():
    """The references of lyapunov-sine, driven faster: elsewhere at later times."""
    scenario = robotics.load_scenario("lyapunov-sine")
    timing = replace(scenario.robots[0].timing, x_rate=0.45)
    return replace(scenario, robots=(replace(scenario.robots[0], timing=timing),)).trajectory


@pytest.mark.parametrize("law", LAWS)
def test_a_law_uses_what_it_says_and_nothing_else(law):
    knows, usual = robotics.make_controller(law).knows, _commanded(law)
    used = {
        "reference": _commanded(law, reference={"x": np.array([0.6])}) != usual,
        "wheel speeds": _commanded(law, v=np.full((1, 1), 0.25)) != usual,
        "preview": _commanded(law, references=_later()) != usual,
    }
    if not used["preview"]:  # a law that looks ahead reads the velocity there
        used["reference velocity"] = _commanded(law, reference={"v": np.array([0.4])}) != usual
    else:
        used["reference"] = True
    assert {word for word, is_used in used.items() if is_used} == set(knows) & set(used)
