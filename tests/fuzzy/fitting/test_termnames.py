"""Telling names for terms that were made from data."""

import numpy as np
import pytest

from fuzzy.fitting.termnames import with_telling_names
from fuzzy.membership import Gaussian
from fuzzy.system import Constant, Sugeno, Variable


def renamed(centers, universe):
    terms = {f"in1cluster{k}": Gaussian(0.1, c) for k, c in enumerate(centers)}
    zs = {f"out1cluster{k}": Constant(float(k)) for k in range(len(centers))}
    rules = [f"if x is in1cluster{k} then x is out1cluster{k}" for k in range(len(centers))]
    before = Sugeno([Variable("x", universe, terms)], [Variable("x", (0.0, 9.0), zs)], rules)
    return before, with_telling_names(before)


@pytest.mark.parametrize(
    ("centers", "universe", "names"),
    [
        ([-0.9, -0.5, -0.2, 0.05, 0.3, 0.7, 1.5], (-1.0, 1.0), ["neg-large", "neg-medium", "neg-small", "zero"]),
        ([0.0, 1.0, 2.0, 3.0, 4.0], (0.0, 4.0), ["least", "small", "medium", "large", "most"]),
        ([3.0, 2.0, 2.1, 1.9], (0.0, 4.0), ["large", "medium-2", "medium-3", "medium-1"]),
        ([-0.04, 0.9], (-0.5, 9.0), ["zero", "pos-small"]),
    ],
)
def test_terms_are_named_by_where_they_stand(centers, universe, names):
    before, after = renamed(centers, universe)
    assert list(after.inputs[0].terms)[: len(names)] == names
    assert list(after.outputs[0].terms) == [f"rule-{k}" for k in range(1, len(centers) + 1)]
    x = np.linspace(universe[0], universe[1], 50)[:, None]
    np.testing.assert_array_equal(before(x), after(x))  # an input and an output may share a name
