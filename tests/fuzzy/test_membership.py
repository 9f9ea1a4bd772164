"""Membership functions: points worked by hand, scikit-fuzzy as an oracle, three array libraries, gradients."""

import math
import pickle
from collections.abc import Callable
from dataclasses import FrozenInstanceError, fields
from typing import Any

import array_api_strict
import numpy as np
import pytest
import torch
from hypothesis import given, settings
from hypothesis import strategies as st

import fuzzy.membership as mf
from fuzzy.membership import FUNCTIONS, membership_function
from fuzzy.membershipfunction import MATLAB_NAMES, MembershipError
from tests.fuzzy.random_systems import PARAMETERS, POSITION, functions

E = math.e
WORKED: dict[str, list[tuple[Any, dict[float, float]]]] = {
    "trimf": [
        ((0, 2, 6), {-1: 0, 0: 0, 1: 0.5, 2: 1, 3: 0.75, 6: 0, 7: 0}),
        ((2, 2, 6), {1.99: 0, 2: 1, 4: 0.5, 6: 0}),  # a vertical left edge has the value 1
        ((0, 2, 2), {0: 0, 1: 0.5, 2: 1, 2.01: 0}),
        ((2, 2, 2), {1.99: 0, 2: 1, 2.01: 0}),
    ],
    "trapmf": [
        ((0, 2, 3, 7), {-1: 0, 0: 0, 0.5: 0.25, 2: 1, 2.5: 1, 3: 1, 6: 0.25, 7: 0, 8: 0}),
        ((2, 2, 3, 3), {1.99: 0, 2: 1, 3: 1, 3.01: 0}),
        ((0, 4, 2, 6), {0: 0, 2: 0.5, 3: 0.75, 4: 0.5, 6: 0}),  # crossed shoulders: a peak below 1
    ],
    "linsmf": [((1, 5), {0: 0, 1: 0, 2: 0.25, 5: 1, 6: 1}), ((2, 2), {1.99: 0, 2: 1, 2.01: 1})],
    "linzmf": [((1, 5), {0: 1, 1: 1, 2: 0.75, 5: 0, 6: 0}), ((2, 2), {1.99: 1, 2: 0, 2.01: 0})],
    "gaussmf": [
        ((2, 5), {5: 1, 7: E**-0.5, 3: E**-0.5, 9: E**-2}),
        ((-2, 5), {5: 1, 7: E**-0.5, 9: E**-2}),  # only the square of sigma counts
    ],
    "gauss2mf": [
        ((1, 3, 2, 4), {2: E**-0.5, 3: 1, 3.5: 1, 4: 1, 8: E**-2}),
        ((1, 4, 2, 3), {3.5: E ** (-1 / 8 - 1 / 32), 2: E**-2, 7: E**-2}),  # crossed: both shoulders count
        ((-1, 3, -2, 4), {2: E**-0.5, 8: E**-2}),
    ],
    "gbellmf": [
        ((2, 4, 6), {6: 1, 4: 0.5, 8: 0.5, 10: 1 / 257, 5: 256 / 257}),
        ((2, 0.25, 6), {6: 1, 8: 0.5, 14: 1 / 3}),
        ((2, -1, 6), {6: 0, 8: 0.5, 10: 0.8}),  # upside down
        ((2, 0, 6), {6: 0.5, 9: 0.5}),
        ((-2, 4, 6), {6: 1, 4: 0.5, 10: 1 / 257}),
    ],
    "sigmf": [
        ((2, 4), {4: 0.5, 5: 1 / (1 + E**-2), 3: 1 / (1 + E**2)}),
        ((-2, 4), {4: 0.5, 5: 1 / (1 + E**2)}),
        ((1000, 0), {-5: 0, 5: 1}),
        ((0, 3), {-7: 0.5, 9: 0.5}),
    ],
    "dsigmf": [
        ((5, 2, 5, 7), {2: 0.5 - 1 / (1 + E**25), 4.5: 1 / (1 + E**-12.5) - 1 / (1 + E**12.5)}),
        ((5, 7, 5, 2), {2: 0, 4.5: 0}),  # would be negative
        ((1000, 0, 1000, 1), {-1: 0, 0.5: 1, 2: 0}),
    ],
    "psigmf": [
        ((2, 3, -5, 8), {3: 0.5 / (1 + E**-25), 8: 0.5 / (1 + E**-10), 5: 1 / (1 + E**-4) / (1 + E**-15)}),
        ((1000, 0, -1000, 1), {-1: 0, 0.5: 1, 2: 0}),
    ],
    "smf": [
        ((1, 8), {0: 0, 1: 0, 2.75: 0.125, 4.5: 0.5, 6.25: 0.875, 8: 1, 9: 1}),
        ((3, 3), {2.99: 0, 3: 1, 3.01: 1}),  # a step
        ((4, 2), {2.99: 0, 3: 1, 3.5: 1}),  # a step in the middle
    ],
    "zmf": [
        ((1, 8), {0: 1, 1: 1, 2.75: 0.875, 4.5: 0.5, 6.25: 0.125, 8: 0, 9: 0}),
        ((3, 3), {2.99: 1, 3: 1, 3.01: 0}),
        ((4, 2), {2.99: 1, 3: 1, 3.5: 0}),
    ],
    "pimf": [
        ((1, 5, 6, 14), {1: 0, 2: 0.125, 3: 0.5, 5: 1, 5.5: 1, 6: 1, 8: 0.875, 10: 0.5, 14: 0}),
        ((0, 8, 2, 10), {4: 0.5 * 0.875, 5: (1 - 2 * (3 / 8) ** 2) ** 2}),  # crossed
        ((3, 3, 5, 5), {2.99: 0, 3: 1, 5: 1, 5.01: 0}),
    ],
}
CASES = [
    pytest.param(name, parameters, points, id=f"{name}{parameters}")
    for name, cases in WORKED.items()
    for parameters, points in cases
]
# In scikit-fuzzy's own order of arguments; it refuses what is degenerate.
SCIKIT_FUZZY: dict[type[mf.MembershipFunction], Callable[..., Any]] = {
    mf.Triangle: lambda m, x, a, b, c: m.trimf(x, [a, b, c]),
    mf.Trapezoid: lambda m, x, a, b, c, d: m.trapmf(x, [a, b, c, d]),
    mf.Gaussian: lambda m, x, sigma, c: m.gaussmf(x, c, sigma),
    mf.TwoSidedGaussian: lambda m, x, s1, c1, s2, c2: m.gauss2mf(x, c1, s1, c2, s2),
    mf.Bell: lambda m, x, a, b, c: m.gbellmf(x, a, b, c),
    mf.Sigmoid: lambda m, x, a, c: m.sigmf(x, c, a),
    mf.SigmoidDifference: lambda m, x, a1, c1, a2, c2: np.maximum(m.dsigmf(x, c1, a1, c2, a2), 0),
    mf.SigmoidProduct: lambda m, x, a1, c1, a2, c2: m.psigmf(x, c1, a1, c2, a2),
    mf.SShape: lambda m, x, a, b: m.smf(x, a, b),
    mf.ZShape: lambda m, x, a, b: m.zmf(x, a, b),
    mf.PiShape: lambda m, x, a, b, c, d: m.pimf(x, a, b, c, d),
}
# Parameters in general position, and points away from every joint of theirs.
INTERIOR = {
    mf.Triangle: (0.1, 1.2, 3.4),
    mf.Trapezoid: (0.1, 1.2, 1.9, 3.4),
    mf.LinearS: (0.1, 3.4),
    mf.LinearZ: (0.1, 3.4),
    mf.Gaussian: (0.9, 1.3),
    mf.TwoSidedGaussian: (0.9, 1.3, 1.7, 2.1),
    mf.Bell: (0.8, 1.7, 1.3),
    mf.Sigmoid: (2.3, 1.3),
    mf.SigmoidDifference: (2.3, 0.7, 3.1, 2.9),
    mf.SigmoidProduct: (2.3, 0.7, -3.1, 2.9),
    mf.SShape: (0.1, 3.4),
    mf.ZShape: (0.1, 3.4),
    mf.PiShape: (0.1, 1.2, 1.9, 3.4),
}


def by_name(function: type) -> str:
    return function.__name__


def test_the_tables_of_these_tests_cover_every_function():
    assert set(WORKED) == set(MATLAB_NAMES)
    assert set(INTERIOR) == set(PARAMETERS) == set(FUNCTIONS)


@pytest.mark.parametrize(("name", "parameters", "points"), CASES)
def test_points_worked_by_hand(name, parameters, points):
    degree = membership_function(name, parameters)(list(points))
    np.testing.assert_allclose(degree, list(points.values()), rtol=1e-13, atol=1e-16)


@pytest.mark.parametrize(("name", "parameters", "points"), CASES)
@pytest.mark.parametrize("xp", [torch, array_api_strict], ids=["torch", "array-api-strict"])
def test_other_array_libraries_give_the_same_degrees(name, parameters, points, xp):
    function = membership_function(name, parameters)
    x = np.array([*map(float, points), 0.3, -0.7, 55.5])
    degree = function(xp.asarray(x))
    assert type(degree) is type(xp.asarray(x))
    np.testing.assert_allclose(np.asarray(degree), function(x), rtol=1e-12, atol=1e-15)


@settings(max_examples=200)
@given(functions(), st.lists(POSITION, min_size=1))
def test_torch_equals_numpy_and_degrees_lie_in_0_1(function, x):
    degree = function(np.array(x))
    assert ((degree >= 0) & (degree <= 1)).all()
    np.testing.assert_allclose(function(torch.tensor(x, dtype=torch.float64)), degree, rtol=1e-12, atol=1e-15)
    if function.log_formula is not None:
        logarithm = type(function).log_formula(np.array(x), *map(np.float64, function.parameters))
        np.testing.assert_allclose(np.exp(logarithm), degree, rtol=1e-13)


@pytest.mark.parametrize("kind", SCIKIT_FUZZY, ids=by_name)
def test_scikit_fuzzy_gives_the_same_degrees(kind):
    import skfuzzy

    rng = np.random.default_rng(0)
    for _ in range(50):
        parameters = rng.uniform(-3, 3, len(fields(kind)))
        if kind in (mf.Triangle, mf.Trapezoid, mf.SShape, mf.ZShape, mf.PiShape):
            parameters.sort()
        if kind is mf.TwoSidedGaussian:
            parameters[1], parameters[3] = sorted((parameters[1], parameters[3]))
        x = np.sort(np.concatenate([rng.uniform(-5, 5, 200), parameters]))
        with np.errstate(divide="ignore"):  # its bell divides by 0 at the center if b < 0
            expected = SCIKIT_FUZZY[kind](skfuzzy.membership, x, *parameters)
        np.testing.assert_allclose(kind(*parameters)(x), expected, rtol=1e-10, atol=1e-14)


@pytest.mark.parametrize("kind", FUNCTIONS, ids=by_name)
def test_gradients_match_finite_differences(kind):
    x = torch.tensor([[-0.4, 0.6], [1.6, 2.7]], dtype=torch.float64, requires_grad=True)
    parameters = [torch.tensor(p, dtype=torch.float64, requires_grad=True) for p in INTERIOR[kind]]
    assert torch.autograd.gradcheck(lambda x, *p: kind(*p)(x), (x, *parameters))
    if kind.log_formula is not None:
        assert torch.autograd.gradcheck(kind.log_formula, (x, *parameters))


EXTREME = [-1e300, -1e154, -1e9, -745.2, 1e-320, 1e-300, 745.2, 1e9, 1e154, 1e300]


@pytest.mark.parametrize(("name", "parameters", "points"), CASES)
def test_gradients_at_joints_and_far_away_are_finite(name, parameters, points):
    kind = MATLAB_NAMES[name]
    x = torch.tensor([*points, *parameters, *EXTREME], dtype=torch.float64, requires_grad=True)
    leaves = [torch.tensor(float(p), dtype=torch.float64, requires_grad=True) for p in parameters]
    degree = kind(*leaves)(x)
    assert torch.isfinite(degree).all()
    for gradient in torch.autograd.grad(degree.sum(), [x, *leaves]):
        assert torch.isfinite(gradient).all()


@pytest.mark.parametrize(("name", "parameters", "points"), CASES)
def test_far_arguments_give_numbers_without_warnings(name, parameters, points):
    degree = membership_function(name, parameters)(np.array(EXTREME))
    assert ((degree >= 0) & (degree <= 1)).all()


def test_shapes_and_types_of_the_argument():
    triangle = mf.Triangle(0, 1, 2)
    assert triangle(0.5).shape == ()
    assert triangle(0.5) == 0.5
    assert triangle(np.zeros((2, 3, 4))).shape == (2, 3, 4)
    assert triangle([0, 1]).dtype == np.float64
    assert triangle(np.array([0.5], dtype=np.float32)).dtype == np.float32
    assert triangle(torch.tensor([1])).dtype == torch.float64
    assert np.isnan(triangle(np.nan))


@pytest.mark.parametrize(
    ("name", "parameters", "message"),
    [
        ("trimf", (1, 0, 2), r"Triangle\(1, 0, 2\) \(trimf\): .* a <= b <= c"),
        ("trimf", (0, 3, 2), "a <= b <= c"),
        ("trapmf", (1, 0, 2, 3), "a <= b"),
        ("trapmf", (0, 1, 3, 2), "c <= d"),
        ("linsmf", (1, 0), r"linsmf.*a <= b"),
        ("linzmf", (1, 0), r"linzmf.*a <= b"),
        ("gaussmf", (0, 1), "sigma must not be 0"),
        ("gauss2mf", (1, 0, 0, 1), "s1 and s2 must not be 0"),
        ("gauss2mf", (0, 0, 1, 1), "s1 and s2 must not be 0"),
        ("gbellmf", (0, 1, 2), "a must not be 0"),
        ("sigmf", (1, float("inf")), "c must be a finite number, got inf"),
        ("smf", (float("nan"), 1), "a must be a finite number, got nan"),
        ("sigmf", (1, "2"), "a parameter is a number, got '2'"),
        ("sigmf", (True, 2), "a parameter is a number, got True"),
        ("sigmf", (1, np.array([1.0, 2.0])), r"a parameter is one number, got an array of shape \(2,\)"),
        ("gaussmf", (1,), r"gaussmf takes 2 parameters \[sigma c\], got 1"),
        ("pimf", (1, 2, 3, 4, 5), r"pimf takes 4 parameters \[a b c d\], got 5"),
        ("gausmf", (1, 2), "unknown membership function 'gausmf'; did you mean 'gaussmf'"),
    ],
)
def test_refused_parameters_are_named(name, parameters, message):
    with pytest.raises(MembershipError, match=message):
        membership_function(name, parameters)


@pytest.mark.parametrize("kind", FUNCTIONS, ids=by_name)
def test_every_function_counts_its_parameters(kind):
    parameters = INTERIOR[kind]
    assert membership_function(kind.matlab, parameters) == kind(*parameters)
    with pytest.raises(MembershipError, match=f"takes {len(parameters)} parameters"):
        membership_function(kind.matlab, parameters[:-1])


@pytest.mark.parametrize("kind", FUNCTIONS, ids=by_name)
def test_functions_are_values(kind):
    function = kind(*INTERIOR[kind])
    assert getattr(mf, kind.matlab) is kind  # MATLAB's name is an alias
    assert function.parameters == INTERIOR[kind]
    assert pickle.loads(pickle.dumps(function)) == function
    assert hash(function) == hash(kind(*INTERIOR[kind]))
    with pytest.raises(FrozenInstanceError):
        setattr(function, fields(kind)[0].name, 1.0)
