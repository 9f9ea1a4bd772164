"""Identification from data: the grid's closed forms, clusters, least squares against direct equations."""

import re
from dataclasses import replace
from itertools import product
from typing import Literal

import numpy as np
import pytest
import torch
from hypothesis import given, settings
from hypothesis import strategies as st

import fuzzy
from fuzzy.files.fisfile import format_fis, parse_fis
from fuzzy.fitting.clustering import ClusteringError, ClusteringOptions, DataWarning, subtractive_clusters
from fuzzy.fitting.consequents import IdentificationError, fit_consequents, least_squares
from fuzzy.fitting.identification import grid_terms, identify
from fuzzy.inference import infer
from fuzzy.membership import Gaussian, Triangle
from fuzzy.system import Constant, Linear, Sugeno, Variable

RNG = np.random.default_rng(20)
X = RNG.uniform([-1, 10], [3, 30], (120, 2))
Y = np.sin(X[:, 0]) + 0.1 * X[:, 1]
KINDS = ["gbellmf", "gaussmf", "gauss2mf", "trimf", "trapmf", "pimf", "dsigmf", "psigmf"]


def direct(fis: Sugeno, x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """What the best consequents, one a rule, answer at ``x``: the equations as written in the book."""
    weights = infer(fis, x).weights
    linear = isinstance(next(iter(fis.outputs[0].terms.values())), Linear)
    columns = np.column_stack([x, np.ones(len(x))]) if linear else np.ones((len(x), 1))
    design = (weights[:, :, None] * columns[:, None, :]).reshape(len(x), -1)
    return design @ np.linalg.lstsq(design, y, rcond=None)[0]


# The grid ---------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("count", [2, 3, 5])
def test_neighbours_cross_at_a_half(kind, count) -> None:
    low, high = -3.0, 7.0
    terms = grid_terms(kind, low, high, count)
    centers = np.linspace(low, high, count)
    tolerance = 5e-5 if kind in ("dsigmf", "psigmf") else 1e-12
    for left, right, a, b in zip(terms, terms[1:], centers, centers[1:], strict=False):
        assert left.matlab == kind
        assert left((a + b) / 2) == pytest.approx(0.5, abs=tolerance)
        assert right((a + b) / 2) == pytest.approx(0.5, abs=tolerance)
    # Sigmoids of slope 10 n / range reach tanh(5 n / 4(n − 1)) of 1 at the center.
    top = {"dsigmf": np.tanh(2.5 * count / (count - 1)), "psigmf": 1 / (1 + np.exp(-5 * count / (count - 1))) ** 2}
    for term, center in zip(terms, centers, strict=True):
        assert term(center) == pytest.approx(top.get(kind, 1.0), rel=1e-12)
        assert term(center + 0.3) == pytest.approx(term(center - 0.3), rel=1e-12)


@pytest.mark.parametrize(
    ("kind", "expected"),
    [
        # [0 4] with 3 terms: centers 0 2 4, h = 1; the second term.
        ("gbellmf", [1, 2, 2]),
        ("gaussmf", [0.8493218002880191, 2]),
        ("gauss2mf", [0.33972872011520763, 1.4, 0.33972872011520763, 2.6]),
        ("trimf", [0, 2, 4]),
        ("trapmf", [0.6, 1.4, 2.6, 3.4]),
        ("pimf", [0.6, 1.4, 2.6, 3.4]),
        ("dsigmf", [7.5, 1, 7.5, 3]),
        ("psigmf", [7.5, 1, -7.5, 3]),
    ],
)
def test_grid_parameters_by_hand(kind, expected) -> None:
    assert grid_terms(kind, 0.0, 4.0, 3)[1].parameters == pytest.approx(expected, rel=1e-14)


def test_the_grid_is_matlabs() -> None:
    fis = identify(X, Y, mfs=[2, 3], kind=["trimf", "gaussmf"], fit=False, input_names=["a", "b"], output_units=["m"])
    assert [list(v.terms) for v in fis.inputs] == [["in1mf1", "in1mf2"], ["in2mf1", "in2mf2", "in2mf3"]]
    assert [v.name for v in (*fis.inputs, *fis.outputs)] == ["a", "b", "output1"]
    assert fis.outputs[0].unit == "m"
    assert list(fis.outputs[0].terms) == [f"out1mf{k}" for k in range(1, 7)]
    # The last input varies fastest.
    assert fis.structure.term.T.tolist() == [list(each) for each in product(range(2), range(3))]
    assert fis.structure.consequent.tolist() == [list(range(6))]
    assert all(term == Linear((0.0, 0.0), 0.0) for term in fis.outputs[0].terms.values())
    assert fis.inputs[1].universe == (X[:, 1].min(), X[:, 1].max())
    assert fis.outputs[0].universe == (Y.min(), Y.max())


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.filterwarnings("ignore:the .* samples determine")  # more parameters than the data tell apart
def test_a_grid_fits_as_well_as_the_equations(kind) -> None:
    fis = identify(X, Y, kind=kind)
    assert np.asarray(fis(X))[:, 0] == pytest.approx(direct(fis, X, Y), abs=1e-9)


@pytest.mark.parametrize("order", [0, 1])
@pytest.mark.filterwarnings("ignore:the .* samples determine")  # more parameters than the data tell apart
def test_a_plane_needs_no_more_than_a_grid(order) -> None:
    y = 2 * X[:, 0] - 0.3 * X[:, 1] + 5
    fis = identify(X, y, kind="trimf", order=order, ridge=0.0)
    if order:
        assert np.asarray(fis(X))[:, 0] == pytest.approx(y, abs=1e-9)
    else:
        # Triangles interpolate: the constants are the plane at the corners.
        low, high = X.min(axis=0), X.max(axis=0)
        corners = np.array(list(product(*zip(low, high, strict=True))))
        values = [term.value for term in fis.outputs[0].terms.values()]
        assert values == pytest.approx(corners @ [2, -0.3] + 5, abs=1e-9)


# The clusters -----------------------------------------------------------------------------------------------


def test_subtractive_antecedents_are_the_clusters_of_inputs_and_outputs() -> None:
    y = np.column_stack([Y, Y**2])
    found = subtractive_clusters(np.column_stack([X, y]), 0.6, options=ClusteringOptions(1.0, 0.4, 0.1))
    fis = identify(X, y, "subtractive", radius=0.6, options=ClusteringOptions(1.0, 0.4, 0.1))
    assert len(fis.rules) == len(found.rows) > 2
    for i, variable in enumerate(fis.inputs):
        assert list(variable.terms) == [f"in{i + 1}cluster{k + 1}" for k in range(len(found.rows))]
        for term, center in zip(variable.terms.values(), found.centers[:, i], strict=True):
            assert isinstance(term, Gaussian)
            assert term.c == center
            assert term.sigma == pytest.approx(found.sigma[i], rel=1e-14)
    assert [next(iter(v.terms)) for v in fis.outputs] == ["out1cluster1", "out2cluster1"]
    assert (fis.structure.term == np.arange(len(found.rows))).all()
    for j in range(2):
        assert np.asarray(fis(X))[:, j] == pytest.approx(direct(fis, X, y[:, j]), abs=1e-8)


def test_survives_a_matlab_file() -> None:
    fis = identify(X, Y, "subtractive", input_units=["m", "s"], input_names=["x", "t"])
    again = parse_fis(format_fis(fis))
    assert again == fis


def test_fcm_equals_scikit_fuzzy() -> None:
    from skfuzzy.cluster import cmeans

    fis = identify(X, Y, "fcm", clusters=4, seed=3, improvement=1e-9, iterations=1000)
    both = np.column_stack([X, Y])
    low, span = both.min(axis=0), np.ptp(both, axis=0)
    unit = (both - low) / span
    start = np.random.default_rng(99).random((4, len(X)))
    centers, u, *_ = cmeans(unit.T, 4, 2.0, 1e-9, 1000, init=start / start.sum(axis=0))
    sigma = np.sqrt(
        [
            [np.average((unit[:, i] - c[i]) ** 2, weights=m**2) for i in range(2)]
            for c, m in zip(centers, u, strict=True)
        ]
    )
    theirs = sorted(zip(*(low + centers * span).T[:2], *(sigma * span[:2]).T, strict=True))
    ours = sorted(
        (a.c, b.c, a.sigma, b.sigma)
        for a, b in zip(fis.inputs[0].terms.values(), fis.inputs[1].terms.values(), strict=True)
    )
    # Another start, the same optimum: the order of the clusters differs.
    assert np.array(ours) == pytest.approx(np.array(theirs), rel=1e-5)
    assert next(iter(fis.inputs[0].terms)) == "in1cluster1"


def test_fcm_is_repeatable_and_takes_a_generator() -> None:
    state = np.random.get_state(legacy=False)["state"]["key"].tolist()  # noqa: NPY002
    one, two = (identify(X, Y, "fcm", clusters=5, seed=7) for _ in range(2))
    three = identify(X, Y, "fcm", clusters=5, seed=np.random.default_rng(7))
    assert one == two == three
    assert identify(X, Y, "fcm", clusters=5, seed=8, iterations=1) != one
    assert np.random.get_state(legacy=False)["state"]["key"].tolist() == state  # noqa: NPY002


def test_fcm_finds_its_number_by_subtractive_clustering() -> None:
    both = np.column_stack([X, Y])
    assert len(identify(X, Y, "fcm").rules) == len(subtractive_clusters(both).rows)


def test_fcm_of_fewer_places_than_clusters_says_so() -> None:
    x = np.repeat([[0.0], [1.0]], 10, axis=0)
    with pytest.warns(DataWarning, match="3 parameters|clusters coincide"):
        fis = identify(x, x[:, 0], "fcm", clusters=3, order=0)
    assert all(term.sigma > 0 for term in fis.inputs[0].terms.values())
    assert np.asarray(fis([[0.0], [1.0]]))[:, 0] == pytest.approx([0, 1], abs=1e-6)


# Least squares ----------------------------------------------------------------------------------------------


@settings(max_examples=25)
@given(
    seed=st.integers(0, 2**32 - 1),
    rules=st.integers(1, 5),
    inputs=st.integers(1, 3),
    order=st.integers(0, 1),
    offset=st.sampled_from([0.0, 1e4]),
)
def test_the_system_that_made_the_data_is_found_again(seed, rules, inputs, order, offset) -> None:
    rng = np.random.default_rng(seed)
    centers = offset + (np.arange(rules)[:, None] + rng.uniform(-0.2, 0.2, (rules, inputs)))
    width = max(rules, 1)
    variables = [
        Variable(
            f"x{i}", (offset - width, offset + 2 * width), {f"t{k}": Gaussian(0.4, centers[k, i]) for k in range(rules)}
        )
        for i in range(inputs)
    ]
    terms = {
        f"z{k}": Linear(rng.normal(size=inputs).tolist(), rng.normal()) if order else Constant(rng.normal())
        for k in range(rules)
    }
    sentences = [
        "if " + " and ".join(f"x{i} is t{k}" for i in range(inputs)) + f" then y is z{k}" for k in range(rules)
    ]
    made = Sugeno(variables, [Variable("y", (-9, 9), terms)], sentences, out_of_range="ignore")
    x = np.repeat(centers, 40, axis=0) + rng.normal(scale=0.5, size=(40 * rules, inputs))
    y = made(x)
    blank = {name: Linear((0.0,) * inputs, 0.0) if order else Constant(0.0) for name in terms}
    found = fit_consequents(replace(made, outputs=[Variable("y", (-9, 9), blank)]), x, y)
    for name, term in terms.items():
        expected = np.array(term.parameters)
        got = np.array(found.outputs[0].terms[name].parameters)
        assert got[:-1] == pytest.approx(expected[:-1], abs=1e-5)
        value = (got[:-1] - expected[:-1]) @ np.full(len(got) - 1, offset) + got[-1] - expected[-1]
        assert abs(value) < 1e-5


def shared(defuzzification: Literal["wtaver", "wtsum"] = "wtaver") -> Sugeno:
    return Sugeno(
        [Variable("a", (0, 2), {"low": Triangle(-2, 0, 2), "high": Triangle(0, 2, 4), "mid": Triangle(0, 1, 2)})],
        [
            Variable("u", (0, 1), {"one": Linear([1.0], 2.0), "two": 3.0, "idle": 7.0}),
            Variable("v", (0, 1), {"z": Linear([-1.0], 0.5)}),
        ],
        [
            "if a is low then u is one and v is z",
            "if a is high then u is one with 0.5",
            "if a is mid then u is two",
        ],
        defuzzification=defuzzification,
    )


@pytest.mark.parametrize("defuzzification", ["wtaver", "wtsum"])
def test_shared_and_missing_consequents_and_both_defuzzifications(defuzzification) -> None:
    made = shared(defuzzification)
    x = np.linspace(0.01, 1.9, 50)[:, None]
    y = made(x)
    blank = replace(
        made,
        outputs=[
            Variable("u", (0, 1), {"one": Linear([0.0], 0.0), "two": 0.0, "idle": 7.0}),
            Variable("v", (0, 1), {"z": Linear([0.0], 0.0)}),
        ],
    )
    found = fit_consequents(blank, x, y)
    for ours, theirs in zip(found.outputs, made.outputs, strict=True):
        assert list(ours.terms) == list(theirs.terms)
        for name, term in theirs.terms.items():
            assert ours.terms[name].parameters == pytest.approx(term.parameters, abs=1e-9)


@pytest.mark.filterwarnings("ignore::fuzzy.inference.InferenceWarning")
@pytest.mark.filterwarnings("ignore:no rule fires")
def test_clipped_inputs_are_clipped_in_the_consequents_too() -> None:
    made = replace(shared(), out_of_range="clip")
    x = np.linspace(-3, 5, 81)[:, None]
    fit = least_squares(made, x, made(x))
    assert fit.rmse == pytest.approx([0, 0], abs=1e-9)


def test_samples_without_a_rule_do_not_count_and_are_told() -> None:
    fis = replace(shared(), out_of_range="ignore", no_rule_fires="error")
    x = np.append(np.linspace(0.01, 1.9, 50), [40.0, 50.0])[:, None]
    y = np.vstack([np.asarray(fis(x[:50])), [[1e6, 1e6], [1e6, 1e6]]])
    with pytest.warns(DataWarning, match="no rule fires at 2 of 52 samples"):
        found = fit_consequents(fis, x, y)
    assert found.outputs[0].terms["one"].parameters == pytest.approx([1, 2], abs=1e-9)
    with pytest.raises(IdentificationError, match="no rule fires for output u at any sample"):
        fit_consequents(fis, x[50:], y[50:])


@pytest.mark.filterwarnings("ignore:the .* samples determine")  # more parameters than the data tell apart
def test_many_inputs_do_not_underflow() -> None:
    rng = np.random.default_rng(1)
    x, centers = rng.random((400, 60)), rng.random((3, 60))
    inputs = [Variable(f"x{i}", (0, 1), {f"t{k}": Gaussian(0.02, centers[k, i]) for k in range(3)}) for i in range(60)]
    lines = {f"z{k}": Linear(rng.normal(size=60).tolist(), rng.normal()) for k in range(3)}
    sentences = ["if " + " and ".join(f"x{i} is t{k}" for i in range(60)) + f" then y is z{k}" for k in range(3)]
    made = Sugeno(inputs, [Variable("y", (-9, 9), lines)], sentences)
    assert (infer(made, x).firing == 0).all()  # the products underflow
    found = fit_consequents(made, x, made(x) + 1)
    for name, term in lines.items():
        expected = np.array(term.parameters) + np.append(np.zeros(60), 1)
        assert found.outputs[0].terms[name].parameters == pytest.approx(expected, abs=1e-8)


def test_too_few_samples_take_the_least_norm_with_a_warning() -> None:
    x, y = X[:5], Y[:5]
    with pytest.warns(DataWarning, match=r"5 samples determine 5 of 12 parameters .*ridge"):
        fis = identify(x, y)
    assert np.asarray(fis(x))[:, 0] == pytest.approx(y, abs=1e-9)
    # Of all consequents that fit as well none is smaller, measured with scaled inputs.
    half, middle = np.ptp(x, axis=0) / 2, (x.max(axis=0) + x.min(axis=0)) / 2
    weights = infer(fis, x).weights
    scaled = np.column_stack([(x - middle) / half, np.ones(5)])
    design = (weights[:, :, None] * scaled[:, None, :]).reshape(5, -1)
    rows = np.array([term.parameters for term in fis.outputs[0].terms.values()])
    theta = np.column_stack([rows[:, :2] * half, rows[:, 2] + rows[:, :2] @ middle - y.mean()]).ravel()
    assert theta == pytest.approx(np.linalg.pinv(design) @ (y - y.mean()), abs=1e-9)


def test_ridge_is_the_penalised_solution_in_any_unit() -> None:
    fis = identify(X, Y, fit=False)
    ridge = 1e-3
    found = fit_consequents(fis, X, Y, ridge)
    half, middle = np.ptp(X, axis=0) / 2, (X.max(axis=0) + X.min(axis=0)) / 2
    scaled = np.column_stack([(X - middle) / half, np.ones(len(X))])
    design = (infer(fis, X).weights[:, :, None] * scaled[:, None, :]).reshape(len(X), -1)
    normal = design.T @ design / len(X) + ridge * np.eye(12)
    theta = np.linalg.solve(normal, design.T @ (Y - Y.mean()) / len(X))
    assert np.asarray(found(X))[:, 0] == pytest.approx(design @ theta + Y.mean(), abs=1e-9)
    other = identify(X * 1000 - 7, Y * 5 + 100, ridge=ridge)
    assert np.asarray(other(X * 1000 - 7))[:, 0] == pytest.approx(np.asarray(found(X))[:, 0] * 5 + 100, abs=1e-8)
    assert identify(X[:5], Y[:5], ridge=ridge) is not None  # determined, so no warning


def test_large_offsets_cost_no_digits() -> None:
    fis = identify(X + np.array([1e9, 0]), 2 * X[:, 0] + Y, "subtractive")
    near = identify(X, 2 * X[:, 0] + Y, "subtractive")
    assert len(fis.rules) == len(near.rules)
    assert np.asarray(fis(X + np.array([1e9, 0]))) == pytest.approx(np.asarray(near(X)), abs=2e-5)


def test_constant_columns_are_told_and_take_no_part() -> None:
    x = np.column_stack([X, np.full(len(X), 4.0)])
    with pytest.warns(DataWarning) as said:
        fis = identify(x, Y, "subtractive", input_names=["a", "b", "c"])
    messages = [str(w.message) for w in said]
    assert len(messages) == 2
    assert "constant, so nothing can be learnt from it: c (4)" in messages[0]
    assert "the rank" in messages[1]
    low, high = fis["c"].universe
    assert low < 4 < high
    assert np.asarray(fis(x)) == pytest.approx(np.asarray(identify(X, Y, "subtractive")(X)), abs=1e-7)
    assert all(abs(term.slopes[2]) < 1e-9 for term in fis.outputs[0].terms.values())
    with pytest.warns(DataWarning):
        assert np.asarray(identify(x, Y, mfs=2)(x))[:, 0] == pytest.approx(
            np.asarray(identify(X, Y)(X))[:, 0], abs=1e-7
        )
    with pytest.warns(DataWarning, match=r"output1 \(1\)"):
        assert np.asarray(identify(X, np.ones(len(X)), "subtractive")(X)) == pytest.approx(1, abs=1e-12)


def test_parameters_in_training_are_read_as_numbers() -> None:
    fis = identify(X, Y, "subtractive")
    tensors = replace(
        fis,
        inputs=[
            replace(
                v,
                terms={
                    n: Gaussian(
                        *(torch.tensor(float(p), dtype=torch.float64, requires_grad=True) for p in t.parameters)
                    )
                    for n, t in v.terms.items()
                },
            )
            for v in fis.inputs
        ],
    )
    again = fit_consequents(tensors, X, Y)
    for ours, theirs in zip(again.outputs[0].terms.values(), fis.outputs[0].terms.values(), strict=True):
        assert ours.parameters == pytest.approx(theirs.parameters, rel=1e-6)


# Refusals ---------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("error", "arguments", "message"),
    [
        (ClusteringError, {"x": [[1.0, 2.0], [3.0, np.nan]], "y": [1.0, 2.0]}, "x: row 2, column 2 is nan"),
        (
            ClusteringError,
            {"x": [[1.0, 2.0], [3.0, np.inf]], "y": [1.0, 2.0], "input_names": ["a", "b"]},
            "row 2, column 2 (b) is inf",
        ),
        (ClusteringError, {"y": [np.nan] * 120}, "y: row 1, column 1 is nan"),
        (ClusteringError, {"x": X[:, 0]}, "x must be (samples, columns)"),
        (IdentificationError, {"y": Y[:-1]}, "x has 120 samples, y 119"),
        (IdentificationError, {"method": "fmc"}, "unknown method 'fmc'; did you mean 'fcm'?"),
        (IdentificationError, {"radus": 0.5, "method": "subtractive"}, "did you mean 'radius'?"),
        (IdentificationError, {"radius": 0.5}, "grid: unknown setting 'radius'"),
        (IdentificationError, {"order": 2}, "order must be 0 (constants) or 1 (linear), got 2"),
        (IdentificationError, {"ridge": -1.0}, "ridge must be a number >= 0 and <= 1e+12, got -1.0"),
        (IdentificationError, {"ridge": 1e308}, "ridge must be a number >= 0 and <= 1e+12, got 1e+308"),
        (IdentificationError, {"mfs": 1}, "mfs of input1 must be a whole number >= 2, got 1"),
        (IdentificationError, {"mfs": [2, 3, 4]}, "one for each of 2 inputs, got 3"),
        (IdentificationError, {"mfs": 1000}, "has 1000000 rules"),
        (IdentificationError, {"mfs": 60, "x": np.tile(X, (100, 1)), "y": np.tile(Y, 100)}, "too large a system"),
        (IdentificationError, {"kind": "sigmf"}, "unknown kind of membership function for a grid 'sigmf'"),
        (IdentificationError, {"input_names": ["a"]}, "1 names for 2 inputs: a"),
        (IdentificationError, {"output_units": ["m", "s"]}, "2 units for 1 outputs"),
        (IdentificationError, {"method": "fcm", "clusters": 121}, "121 clusters, but only 120 samples"),
        (IdentificationError, {"method": "fcm", "clusters": 0}, "'auto' or a whole number >= 1"),
        (
            IdentificationError,
            {"method": "fcm", "clusters": 2, "exponent": 1.0},
            "exponent must be a finite number > 1",
        ),
        (fuzzy.FuzzySystemError, {"input_names": ["a", "a"]}, "two inputs are named 'a'"),
    ],
)
def test_refusals_say_what_is_wrong(error, arguments, message) -> None:
    call = {"x": X, "y": Y, **arguments}
    with pytest.raises(error, match=re.escape(message)):
        identify(**call)


def test_fit_refuses_other_shapes_and_no_rules() -> None:
    fis = identify(X, Y, fit=False)
    with pytest.raises(IdentificationError, match="has 2 inputs and 1 outputs; x has 1 columns and y 1"):
        fit_consequents(fis, X[:, :1], Y)
    with pytest.raises(IdentificationError, match="x has 120 samples, y 3"):
        fit_consequents(fis, X, Y[:3])
    with pytest.raises(IdentificationError, match="no rules"):
        fit_consequents(replace(fis, rules=[]), X, Y)
