"""Interval type-2 systems: lower functions, degenerate ones, "not", gradients, compiled code, errors."""

import warnings

import numpy as np
import pytest
import torch
from hypothesis import given, settings

import fuzzy
from tests.fuzzy.plugins.type2.drawn import drawn, lower_triangle
from tests.fuzzy.random_systems import systems_with_points
from tests.randomcases import cases

TRACKING = fuzzy.read_fis(fuzzy.find_fis("tracking"))


def test_the_lower_function_of_a_triangle_is_a_triangle_with_its_feet_moved_inwards():
    function, lower = fuzzy.Triangle(5, 7, 9), fuzzy.Lower(0.8, (0.3, 0.1))
    variable = fuzzy.Variable("x", (0, 10), {"t": function})
    fis = fuzzy.Sugeno([variable], [fuzzy.Variable("y", (0, 1), {"c": 1})], ["if x is t then y is c"])
    x = np.linspace(0, 10, 101)
    low, high = fuzzy.Type2Sugeno(fis, {"x": {"t": lower}}).degrees("x", "t", x)
    assert low == pytest.approx([lower_triangle(function, lower, at) for at in x], abs=1e-15)
    assert high == pytest.approx(function(x))


@pytest.mark.parametrize("matlab", ["gaussmf", "gauss2mf", "gbellmf", "pimf", "trapmf", "zmf", "smf", "linzmf"])
def test_a_lower_function_begins_at_the_lag_of_its_side_and_is_never_above(matlab):
    numbers = {"gauss2mf": (1, 4, 2, 6), "gaussmf": (1.5, 5), "gbellmf": (2, 2, 5)}
    two, four = (3, 7), (1, 4, 6, 8)
    function = fuzzy.membership_function(matlab, numbers.get(matlab, four if matlab in ("pimf", "trapmf") else two))
    fis = fuzzy.Sugeno(
        [fuzzy.Variable("x", (0, 10), {"t": function})],
        [fuzzy.Variable("y", (0, 1), {"c": 1})],
        ["if x is t then y is c"],
    )
    x = np.linspace(-2, 12, 2801)
    low, high = fuzzy.Type2Sugeno(fis, {"x": {"t": fuzzy.Lower(0.9, (0.3, 0.1))}}).degrees("x", "t", x)
    assert (low <= high).all()
    assert low.max() == pytest.approx(0.9)
    assert np.abs(np.diff(low)).max() < 0.02  # no step at the peak, where the sides meet
    left = x <= x[np.argmax(high)]
    assert high[left & (low > 0)].min(initial=1) >= 0.3
    assert high[~left & (low > 0)].min(initial=1) >= 0.1
    assert high[(low == 0) & left].max(initial=0) <= 0.3
    assert high[(low == 0) & ~left].max(initial=0) <= 0.1


@given(systems_with_points(shape=(20,), defuzzification="wtaver"))
@settings(max_examples=cases(60), deadline=None)
def test_without_lag_and_with_a_scale_of_1_it_answers_as_type_1(drawing):
    fis, x = drawing
    type2 = fuzzy.to_type2(fis, 0, 1)
    with warnings.catch_warnings(action="ignore"):
        one, two = fuzzy.infer(fis, x), fuzzy.infer_type2(type2, x)
    strong = (one.firing.max(axis=-1) > 1e-6)[..., None] & one.fired
    assert two.output[strong] == pytest.approx(one.output[strong], rel=1e-9, abs=1e-9)
    assert (two.low == two.high)[strong].all() or two.low[strong] == pytest.approx(two.high[strong])


def test_the_packaged_tracking_rules_answer_as_type_1_to_1e_12():
    low, high = np.array([v.universe for v in TRACKING.inputs]).T
    x = np.random.default_rng(0).uniform(low, high, (500, len(TRACKING.inputs)))
    one = TRACKING(x)
    for reduction in ("karnikmendel", "nietan"):
        assert fuzzy.to_type2(TRACKING, 0, 1, reduction)(x) == pytest.approx(one, rel=1e-12, abs=1e-12)


def test_not_turns_the_bounds_round():
    x = fuzzy.Variable("x", (0, 1), {"low": fuzzy.LinearZ(0, 1)})
    y = fuzzy.Variable("y", (0, 1), {"a": 0, "b": 1})
    fis = fuzzy.Sugeno([x], [y], ["if x is low then y is a", "if x is not low then y is b"])
    found = fuzzy.infer_type2(fuzzy.to_type2(fis, lag=0, scale=0.5), [0.25])
    assert found.lower.tolist() == [0.375, 0.25]
    assert found.upper.tolist() == [0.75, 0.625]
    assert found.low.tolist() == pytest.approx([0.25 / (0.25 + 0.75)])
    assert found.high.tolist() == pytest.approx([0.625 / (0.625 + 0.375)])


def test_gradients_are_those_of_differences():
    fis = drawn(np.random.default_rng(5), gaussian=False)
    x = torch.tensor(np.random.default_rng(1).uniform(2, 8, (40, 2)))

    def mean(numbers: torch.Tensor) -> torch.Tensor:
        scale, lag, center = numbers
        terms = dict(fis.inputs[0].terms) | {"t0": fuzzy.Triangle(-2.0, center, 12.0)}
        upper = fuzzy.Sugeno(
            [fuzzy.Variable("x", (0, 10), terms), fis.inputs[1]], fis.outputs, fis.rules, out_of_range="ignore"
        )
        return fuzzy.to_type2(upper, {"x": {"t0": lag}}, {"x": {"t0": scale}})(x).mean()

    at = torch.tensor([0.7, 0.2, 4.0], dtype=torch.float64, requires_grad=True)
    mean(at).backward()
    step = 1e-6 * torch.eye(3, dtype=torch.float64)
    with torch.no_grad():
        differences = [float(mean(at + row) - mean(at - row)) / 2e-6 for row in step]
    assert np.abs(differences).min() > 1e-4
    assert at.grad.tolist() == pytest.approx(differences, rel=1e-5)


@given(systems_with_points(shape=(70,), defuzzification="wtaver"))
@settings(max_examples=cases(30), deadline=None)
def test_compiled_code_gives_the_same_ends_in_blocks_and_point_by_point(drawing):
    fis, x = drawing
    x[3, 0] = np.nan
    for reduction in ("iasc", "nietan"):
        type2 = fuzzy.to_type2(fis, 0.25, 0.75, reduction)
        compiled = fuzzy.compile_type2(type2)
        with warnings.catch_warnings(action="ignore"):
            found, ends = fuzzy.infer_type2(type2, x), compiled.interval(x)
            some = compiled.interval(x[:5])
            assert compiled(x) == pytest.approx(ends.mean(axis=-1), nan_ok=True)
        strong = (found.upper.max(axis=-1) > 1e-6)[:, None] & np.ones(found.low.shape, bool)
        for k, expected in enumerate((found.low, found.high)):
            assert ends[..., k][strong] == pytest.approx(expected[strong], rel=1e-6, abs=1e-6, nan_ok=True)
            assert some[..., k][strong[:5]] == pytest.approx(expected[:5][strong[:5]], rel=1e-6, abs=1e-6, nan_ok=True)


def test_compiled_code_is_exact_where_strengths_are_not_small_differences():
    rng, looked_at = np.random.default_rng(2), 0
    for _ in range(10):
        fis = drawn(rng)
        x = rng.uniform(0, 10, (200, 2))
        with warnings.catch_warnings(action="ignore"):
            found, ends = fuzzy.infer_type2(fis, x), fuzzy.compile_type2(fis).interval(x)
        sure = (found.upper.max(axis=-1) > 1e-3) & (
            (found.lower > 1e-3) | (found.lower == 0) & (found.upper > 1e-3) | (found.upper == 0)
        ).all(axis=-1)
        looked_at += sure.sum()
        assert ends[sure, :, 0] == pytest.approx(found.low[sure], rel=1e-12, abs=1e-12)
        assert ends[sure, :, 1] == pytest.approx(found.high[sure], rel=1e-12, abs=1e-12)
    assert looked_at > 100


def test_where_no_rule_fires_and_outside_it_says_what_type_1_says():
    x = fuzzy.Variable("x", (0, 1), {"left": fuzzy.Triangle(0, 0.1, 0.2)})
    fis = fuzzy.Sugeno([x], [fuzzy.Variable("y", (0, 4), {"c": 1})], ["if x is left then y is c"])
    type2 = fuzzy.to_type2(fis)
    for call in (type2, fuzzy.compile_type2(type2)):
        with pytest.warns(fuzzy.InferenceWarning, match="no rule fires for output y"):
            assert call([0.5]).tolist() == [2.0]
        with pytest.warns(match="no rule fires"), pytest.warns(match=r"x outside \[0 1\]"):
            call([[1.5], [0.1]])
        with pytest.raises(fuzzy.FuzzySystemError, match="must hold 1 values"):
            call([0.1, 0.2])


@pytest.mark.parametrize(
    ("make", "says"),
    [
        (lambda: fuzzy.to_type2(TRACKING, scale=0), r"scale .* must lie in \(0, 1\], got 0"),
        (lambda: fuzzy.to_type2(TRACKING, lag=1.0), r"one number or two in \[0, 1\)"),
        (lambda: fuzzy.to_type2(TRACKING, lag=(0.1, 0.2, 0.3)), r"one number or two"),  # type: ignore[arg-type]
        (lambda: fuzzy.to_type2(TRACKING, lag={"nothing": 0.2}), "unknown input 'nothing'"),
        (lambda: fuzzy.Type2Sugeno(TRACKING, {"nothing": {}}), "unknown input 'nothing'"),
        (lambda: fuzzy.to_type2(TRACKING, reduction="km"), "unknown type reduction 'km'"),  # type: ignore[arg-type]
    ],
)
def test_what_is_wrong_is_said(make, says):
    with pytest.raises(fuzzy.InputError, match=says):
        make()


def test_the_weighted_sum_and_two_lags_below_degree_1_are_refused():
    sigmoid = fuzzy.Variable("x", (0, 1), {"t": fuzzy.Sigmoid(2, 0.5)})
    fis = fuzzy.Sugeno([sigmoid], [fuzzy.Variable("y", (0, 1), {"c": 1})], ["if x is t then y is c"])
    with pytest.raises(fuzzy.FuzzySystemError, match="does not reach the degree 1"):
        fuzzy.to_type2(fis, lag=(0.1, 0.2))
    fuzzy.to_type2(fis, lag=0.1)
    summed = fuzzy.Sugeno(fis.inputs, fis.outputs, fis.rules, defuzzification="wtsum")
    with pytest.raises(fuzzy.FuzzySystemError, match="weighted average"):
        fuzzy.to_type2(summed)


def test_the_footprint_is_filled_between_both_functions():
    fis = fuzzy.to_type2(TRACKING, lag=0.3)
    figure = fuzzy.plot_footprint(fis)
    assert len(figure.axes) == len(TRACKING.inputs)
    areas = figure.axes[0].collections
    assert len(areas) == len(TRACKING.inputs[0].terms)
    term = next(iter(TRACKING.inputs[0].terms))
    corners = np.asarray(areas[0].get_paths()[0].vertices)
    low, high = fis.degrees(TRACKING.inputs[0].name, term, corners[:, 0])
    assert np.minimum(np.abs(corners[:, 1] - low), np.abs(corners[:, 1] - high)).max() < 1e-6


def test_rules_that_are_too_weak_to_count_fire_nowhere():
    """From a strength of 1e-300 down, compiled or not, at one point or at many."""
    x = fuzzy.Variable("x", (0, 40), {"a": fuzzy.Gaussian(1.0, 0.0), "b": fuzzy.Gaussian(1.0, 0.5)})
    y = fuzzy.Variable("y", (-5, 5), {"down": -3.0, "up": 4.0})
    rules = ["if x is a then y is down", "if x is b then y is up"]
    fis = fuzzy.to_type2(fuzzy.Sugeno([x], [y], rules, name="weak"), lag=0.0, scale=0.5)
    points = np.linspace(36.5, 39.0, 101)[:, None]
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        told, compiled = fuzzy.infer_type2(fis, points), fuzzy.compile_type2(fis)
        ends, alone = compiled.interval(points), [compiled.interval(point)[0] for point in points]
    assert 0 < told.fired.sum() < len(points)
    assert (told.fired[:, 0] == (told.upper >= 1e-300).any(axis=1)).all()
    assert ends[:, 0] == pytest.approx(np.column_stack([told.low, told.high]), rel=1e-12)
    assert np.array(alone) == pytest.approx(ends[:, 0], rel=1e-12)
    assert (np.abs(ends[told.fired[:, 0], 0] - 0.5) <= 3.5 + 1e-12).all()  # among the proposals
