"""Telling names for terms that were made from data."""

import numpy as np
import pytest

from fuzzy.files.fisfile import format_fis, parse_fis
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
        ([-0.9, -0.5, -0.2, 0.05, 0.3, 0.7], (-1.0, 1.0), "neg-large neg-medium neg-small zero pos-small pos-medium"),
        ([-0.9, -0.8, 0.3], (-1.0, 1.0), "low middle high"),  # two would be neg-large
        ([0.0, 1.0, 2.0, 3.0, 4.0], (0.0, 4.0), "very-low low middle high very-high"),
        ([3.0, 2.0, 2.1, 1.9], (0.0, 4.0), "very-low low high very-high"),
        ([3.0], (0.0, 4.0), "middle"),
        ([1.0, 0.5], (0.0, 4.0), "low high"),
        ([6, 5, 4, 3, 2, 1], (0.0, 9.0), "lowest very-low low high very-high highest"),
        ([6, 5, 4, 3, 2, 1, 0], (0.0, 9.0), "lowest very-low low middle high very-high highest"),
        ([-0.04, 0.9], (-0.5, 9.0), "zero pos-small"),
    ],
)
def test_terms_are_named_by_where_they_stand(centers, universe, names):
    before, after = renamed(centers, universe)
    assert list(after.inputs[0].terms) == names.split()
    places = [term.c for term in after.inputs[0].terms.values()]
    assert places == sorted(places)
    assert list(after.outputs[0].terms) == [f"rule-{k}" for k in range(1, len(centers) + 1)]
    x = np.linspace(universe[0], universe[1], 50)[:, None]
    np.testing.assert_array_equal(before(x), after(x))  # an input and an output may share a name


def test_many_terms_are_named_by_their_places():
    before, after = renamed([3.14159, 3.2, -1, 0, 9, 8, 7, 6], (-2.0, 9.0))
    names = ["about -1", "about 0", "about 3.1", "about 3.2", "about 6", "about 7", "about 8", "about 9"]
    assert list(after.inputs[0].terms) == names
    assert list(renamed([1.0] * 8, (0.0, 4.0))[1].inputs[0].terms)[6:] == ["about 1, 7", "about 1, 8"]
    x = np.linspace(-2, 9, 50)[:, None]
    np.testing.assert_array_equal(before(x), after(x))
    assert parse_fis(format_fis(after)).rules == after.rules
    assert str(after.rules[0]) == "if x is 'about 3.1' then x is rule-1"
