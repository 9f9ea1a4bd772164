"""Inference: answers worked by hand, laws that hold for every system, gradients, warnings, and systems as values."""

import pickle
import warnings
from dataclasses import FrozenInstanceError, replace
from typing import Literal

import numpy as np
import pytest
import torch
from hypothesis import given, settings
from hypothesis import strategies as st

import fuzzy
from fuzzy.inference import InferenceWarning, infer
from fuzzy.membership import Gaussian, LinearS, LinearZ, Sigmoid, Triangle
from fuzzy.rule import Clause, Rule
from fuzzy.system import Constant, FuzzySystemError, Linear, Sugeno, Terms, Variable
from tests.fuzzy.random_systems import POSITIVE, conditioning, points, systems, systems_with_points
from tests.randomcases import cases

quiet = pytest.mark.filterwarnings("ignore::fuzzy.inference.InferenceWarning")
law = settings(max_examples=cases(150))

# Two inputs whose degrees are read off: a is high to x/10, b is high to y/4.
A = Variable("a", (0, 10), {"low": LinearZ(0, 10), "high": LinearS(0, 10)}, "m")
B = Variable("b", (0, 4), {"low": LinearZ(0, 4), "high": LinearS(0, 4)})
Y = Variable("y", (-10, 30), {"none": 0, "ten": 10, "plane": Linear((2, -1), 5)})
Z = Variable("z", (0, 1), {"zero": 0.0, "one": 1.0})


def rule(when: dict, then: dict, connective: Literal["and", "or"] = "and", weight: float = 1.0) -> Rule:
    """``when`` maps inputs to a term, or to (term, negated, power)."""
    clauses = [Clause(name, *([c] if isinstance(c, str) else c)) for name, c in when.items()]
    return Rule(tuple(clauses), tuple(then.items()), connective, weight)


def answer(*rules: Rule, at: tuple[float, float], outputs=(Y,), **choices) -> float | list[float]:
    output = infer(Sugeno((A, B), outputs, rules, **choices), at).output
    return float(output[0]) if len(outputs) == 1 else output.tolist()


LOW = rule({"a": "low"}, {"y": "none"})  # at a = 3: fires with 0.7 for 0

HIGH_HIGH = {"a": "high", "b": "high"}  # at (3, 3): 0.3 and 0.75
METHODS = [
    ("and", {}, 0.3 * 0.75),
    ("and", {"and_method": "min"}, 0.3),
    ("or", {}, 0.3 + 0.75 - 0.3 * 0.75),
    ("or", {"or_method": "max"}, 0.75),
    ("or", {"and_method": "min"}, 0.3 + 0.75 - 0.3 * 0.75),
]


@pytest.mark.parametrize(("connective", "choices", "firing"), METHODS)
def test_and_or_by_hand(connective, choices, firing):
    fires = rule(HIGH_HIGH, {"y": "ten"}, connective)
    assert answer(LOW, fires, at=(3, 3), **choices) == pytest.approx(10 * firing / (0.7 + firing), rel=1e-14)


@pytest.mark.parametrize(
    ("negated", "power", "firing"),
    [
        (False, 2.0, 0.3**2),
        (False, 0.5, 0.3**0.5),
        (False, 3.0, 0.3**3),
        (False, 1.3, 0.3**1.3),
        (True, 1.0, 0.7),
        (True, 2.0, 1 - 0.3**2),  # not very: "not" acts on what the hedge leaves
        (True, 0.5, 1 - 0.3**0.5),
    ],
)
def test_not_and_hedges_by_hand(negated, power, firing):
    fires = rule({"a": ("high", negated, power)}, {"y": "ten"})
    assert answer(LOW, fires, at=(3, 3)) == pytest.approx(10 * firing / (0.7 + firing), rel=1e-14)
    or_fires = rule({"a": ("high", negated, power), "b": "high"}, {"y": "ten"}, "or")
    firing = firing + 0.75 - firing * 0.75
    assert answer(LOW, or_fires, at=(3, 3)) == pytest.approx(10 * firing / (0.7 + firing), rel=1e-14)


def test_weights_and_first_order_consequents_by_hand():
    plane = rule(HIGH_HIGH, {"y": "plane"}, weight=0.4)  # fires with 0.4 · 0.225 = 0.09 for 2·3 − 3 + 5 = 8
    assert answer(LOW, plane, at=(3, 3)) == pytest.approx(8 * 0.09 / 0.79, rel=1e-14)
    assert answer(LOW, plane, at=(3, 3), defuzzification="wtsum") == pytest.approx(8 * 0.09, rel=1e-14)
    assert answer(LOW, replace(plane, weight=0.0), at=(3, 3)) == 0


def test_an_output_beyond_the_largest_number_is_infinite_without_a_warning():
    x = Variable("x", (0, 10), {"all": LinearS(-2, -1)})
    y = Variable("y", (0, 1), {"steep": Linear((1e308,), 0.0)})
    steep = Sugeno(inputs=[x], outputs=[y], rules=["if x is all then y is steep"])
    with warnings.catch_warnings(action="error"):
        assert steep([[1.0], [9.0]]).ravel().tolist() == [1e308, np.inf]


def test_a_weighted_sum_counts_equal_consequents_twice():
    ten = rule({"a": "high"}, {"y": "ten"})
    assert answer(ten, ten, LOW, at=(3, 3), defuzzification="wtsum") == pytest.approx(6, rel=1e-14)
    assert answer(ten, ten, LOW, at=(3, 3)) == pytest.approx(10 * 0.6 / 1.3, rel=1e-14)


def test_a_rule_has_no_say_in_an_output_that_it_leaves_out():
    rules = (
        rule({"a": "low"}, {"y": "none", "z": "one"}),  # 0.7
        rule({"a": "high"}, {"y": "ten"}),  # 0.3
        rule({"b": "high"}, {"z": "zero"}),  # 0.75
    )
    expected = [10 * 0.3 / (0.7 + 0.3), 0.7 / (0.7 + 0.75)]
    assert answer(*rules, at=(3, 3), outputs=(Y, Z)) == pytest.approx(expected, rel=1e-14)
    sums = answer(*rules, at=(3, 3), outputs=(Y, Z), defuzzification="wtsum")
    assert sums == pytest.approx([3, 0.7], rel=1e-14)


def test_every_layer_by_hand():
    fis = Sugeno((A, B), (Y,), (LOW, rule(HIGH_HIGH, {"y": "plane"})))
    layers = infer(fis, (3.0, 3.0))
    np.testing.assert_allclose(layers.memberships, [[0.7, 0.3], [0.25, 0.75]])
    np.testing.assert_allclose(layers.firing, [0.7, 0.225])
    np.testing.assert_allclose(layers.weights, [0.7 / 0.925, 0.225 / 0.925])
    np.testing.assert_allclose(layers.rule_outputs, [[0], [8]])
    np.testing.assert_allclose(layers.output, [8 * 0.225 / 0.925])
    assert layers.fired.tolist() == [True]


def gaussians(inputs: int, centers: np.ndarray, sigma: float, consequents: list[float], **choices) -> Sugeno:
    """One rule a row of ``centers`` (rules, inputs)."""
    variables = [
        Variable(f"x{i}", (-100, 100), {f"t{r}": Gaussian(sigma, c) for r, c in enumerate(centers[:, i])})
        for i in range(inputs)
    ]
    rules = [rule({v.name: f"t{r}" for v in variables}, {"y": f"t{r}"}) for r in range(len(centers))]
    output = Variable("y", (0, 10), {f"t{r}": c for r, c in enumerate(consequents)})
    return Sugeno(variables, (output,), rules, **choices)


def test_thirty_dimensions_do_not_underflow():
    # Log strengths −30/2 · (9 ± d)², below −1000: the weights are the logistic function of their difference.
    sigma, far, near = 1.0, 9.01, 9.0
    fis = gaussians(30, np.array([[far] * 30, [-near] * 30]), sigma, [2.0, 5.0])
    difference = 15 * (far**2 - near**2)
    layers = infer(fis, np.zeros(30))
    assert layers.firing.tolist() == [0, 0]
    weight = 1 / (1 + np.exp(difference))
    np.testing.assert_allclose(layers.weights, [weight, 1 - weight], rtol=1e-11)
    np.testing.assert_allclose(layers.output, [2 * weight + 5 * (1 - weight)], rtol=1e-11)


def test_a_rule_without_weight_near_the_point_does_not_drown_the_others():
    fis = gaussians(1, np.array([[0.0], [50.0]]), 1.0, [2.0, 5.0])
    fis = replace(fis, rules=(replace(fis.rules[0], weight=0.0), fis.rules[1]))
    assert infer(fis, [0.0]).output.tolist() == [5]


@quiet
@law
@given(systems_with_points())
def test_weights_sum_to_1_or_to_0_where_nothing_fires(drawn):
    fis, x = drawn
    weights = infer(fis, x).weights
    assert weights.shape == (*x.shape[:-1], len(fis.rules))
    total = weights.sum(axis=-1)
    np.testing.assert_allclose(total, np.where(total > 0, 1, 0), rtol=1e-12)
    assert (weights >= 0).all()


@quiet
@law
@given(systems_with_points(order=0, defuzzification="wtaver"))
def test_an_average_of_constants_lies_between_them(drawn):
    fis, x = drawn
    layers = infer(fis, x)
    for o, output in enumerate(fis.outputs):
        constants = [term.value for term in output.terms.values()]
        values = layers.output[..., o][layers.fired[..., o]]
        assert (values >= min(constants) - 1e-12).all()
        assert (values <= max(constants) + 1e-12).all()


@quiet
@law
@given(systems_with_points(), st.randoms(use_true_random=False))
def test_the_order_of_the_rules_changes_nothing(drawn, random):
    fis, x = drawn
    rules = list(fis.rules)
    random.shuffle(rules)
    np.testing.assert_allclose(infer(replace(fis, rules=rules), x).output, infer(fis, x).output, rtol=1e-12, atol=1e-12)


@quiet
@law
@given(systems_with_points())
def test_a_batch_is_its_points(drawn):
    fis, x = drawn
    batch = infer(fis, x)
    for place in np.ndindex(x.shape[:-1]):
        point = infer(fis, x[place])
        for one, many in zip(point[1:], batch[1:], strict=True):
            np.testing.assert_allclose(one, many[place], rtol=1e-14, atol=1e-14)


@quiet
@law
@given(systems_with_points())
def test_torch_equals_numpy(drawn):
    fis, x = drawn
    expected, got = infer(fis, x), infer(fis, torch.tensor(x))
    # Libraries round their exponentials apart: where hardly a rule fires, that is all there is.
    slack = 1e-14 * conditioning(fis, expected.firing) * np.ones(expected.output.shape)
    sure = np.isfinite(slack) | all(f in POSITIVE for f in functions_of(fis))
    np.testing.assert_allclose(got.firing, expected.firing, rtol=1e-12, atol=1e-14)
    difference = np.abs(got.output.numpy() - expected.output)
    scale = 1e-12 + np.where(np.isfinite(slack), 100 * slack, 0)
    assert (difference <= scale * 50)[sure & ~np.isnan(expected.output)].all()


def functions_of(fis: Sugeno) -> list[type]:
    return [type(f) for v in fis.inputs for f in v.terms.values()]


@quiet
@pytest.mark.parametrize("shape", [(), (5,), (0,), (2, 3, 4), (2, 0, 3)])
def test_leading_shapes(shape):
    fis = Sugeno((A, B), (Y, Z), (LOW, rule(HIGH_HIGH, {"y": "plane", "z": "one"})))
    x = np.random.default_rng(0).uniform(1, 3, (*shape, 2))
    layers = infer(fis, x)
    assert layers.output.shape == layers.fired.shape == (*shape, 2)
    assert layers.firing.shape == layers.weights.shape == (*shape, 2)
    assert layers.rule_outputs.shape == (*shape, 2, 2)
    assert [m.shape for m in layers.memberships] == [(*shape, 2), (*shape, 2)]
    np.testing.assert_array_equal(fis(x), layers.output)


def trainable(value: float) -> torch.Tensor:
    return torch.tensor(value, dtype=torch.float64, requires_grad=True)


@pytest.mark.parametrize("logarithmic", [True, False])
def test_gradients_through_inference_match_finite_differences(logarithmic):
    x = torch.tensor([[0.3, -0.4], [1.2, 0.7], [-0.9, 0.2]], dtype=torch.float64, requires_grad=True)
    premises = [trainable(v) for v in (0.8, -0.5, 1.1, 0.6, 1.7, -0.2, 0.9, 0.4)]
    consequents = torch.tensor([[0.4, -1.2, 0.3], [1.5, 0.2, -0.7]], dtype=torch.float64, requires_grad=True)
    constant = trainable(0.8)

    def output(x, consequents, constant, *p):
        first = Variable("u", (-2, 2), {"a": Gaussian(p[0], p[1]), "b": Gaussian(p[2], p[3])})
        second = Variable("v", (-2, 2), {"a": Sigmoid(p[4], p[5]), "b": Sigmoid(p[6], p[7])})
        y = Variable("y", (-5, 5), {k: Linear(c[:2], c[2]) for k, c in zip("ab", consequents, strict=True)})
        z = Variable("z", (-5, 5), {"a": constant_of(constant), "b": 0.25})
        rules = (
            rule({"u": ("a", False, 2.0), "v": "a"}, {"y": "a", "z": "a"}),
            rule({"u": "b", "v": ("b", not logarithmic, 0.5)}, {"y": "b"}, weight=0.7),
            rule({"u": "b"}, {"z": "b"}),
        )
        return infer(Sugeno((first, second), (y, z), rules), x).output

    def constant_of(value):
        return Constant(value)

    assert torch.autograd.gradcheck(output, (x, consequents, constant, *premises))


def test_gradients_are_finite_where_degrees_are_0():
    x = torch.tensor([[0.0, 4.0], [5.0, 0.0], [10.0, 2.0]], dtype=torch.float64, requires_grad=True)
    rules = (rule({"a": ("high", False, 0.5), "b": ("low", True, 1.3)}, {"y": "plane"}), rule(HIGH_HIGH, {"y": "ten"}))
    output = infer(Sugeno((A, B), (Y,), (*rules, LOW)), x).output
    assert torch.isfinite(torch.autograd.grad(output.sum(), x)[0]).all()


def test_not_a_number_stays_in_its_point():
    x = np.array([[3.0, 3.0], [np.nan, 3.0], [3.0, np.nan], [1.0, 2.0]])
    for fis in (Sugeno((A, B), (Y,), (LOW, rule(HIGH_HIGH, {"y": "ten"}))), gaussians(2, np.eye(2), 3.0, [1.0, 2.0])):
        output = infer(fis, x).output
        assert np.isnan(output[:, 0]).tolist() == [False, True, True, False]
        np.testing.assert_array_equal(output[[0, 3]], infer(fis, x[[0, 3]]).output)
    only_a = Sugeno((A, B), (FLAT,), (LOW,))
    assert np.isnan(infer(only_a, (3.0, np.nan)).output).all()  # also of an input that no rule reads


# Where nothing fires, and outside the universe of discourse ------------------------------------------------------

GAP = Variable("a", (0, 10), {"left": Triangle(0, 1, 2), "right": Triangle(6, 7, 8)})
FLAT = Variable("y", (-10, 30), {"none": 0, "ten": 10})
GAP_RULES = (rule({"a": "left"}, {"y": "none"}), rule({"a": "right"}, {"y": "ten", "z": "one"}))


def gap(**choices) -> Sugeno:
    return Sugeno((GAP,), (FLAT, Z), GAP_RULES, name="gap", **choices)


def test_no_rule_fires_midrange_with_one_warning_a_call():
    with pytest.warns(InferenceWarning, match="gap: no rule fires for output y, z") as caught:
        output = infer(gap(), [[4.0], [7.0], [5.0], [1.0]]).output
    assert len(caught) == 1
    assert output.tolist() == [[10, 0.5], [10, 1], [10, 0.5], [0, 0.5]]
    assert "the middle of its range, 10, 0.5," in str(caught[0].message)
    assert caught[0].filename == __file__


def test_no_rule_fires_for_one_output_names_only_that():
    with pytest.warns(InferenceWarning, match="no rule fires for output z at"):
        infer(gap(), [1.0])


def test_no_rule_fires_nan_and_error():
    with pytest.warns(InferenceWarning, match="not-a-number stands there"):
        assert np.isnan(infer(gap(no_rule_fires="nan"), [4.0]).output).all()
    with pytest.raises(FuzzySystemError, match="gap: no rule fires for output y, z"):
        infer(gap(no_rule_fires="error"), [4.0])
    assert infer(gap(no_rule_fires="error"), [7.0]).output.tolist() == [10, 1]


def test_a_system_without_rules_answers_with_the_middle():
    with pytest.warns(InferenceWarning, match="no rule fires"):
        assert infer(Sugeno((A,), (FLAT,)), [1.0]).output.tolist() == [10]


def test_out_of_range():
    low = rule({"a": "low"}, {"y": "plane"})
    fis = Sugeno((A, B), (Y,), (low,), name="range")
    x = [[3.0, 3.0], [-1.0, 3.0], [2.0, 2.0]]  # the plane is 2 a − b + 5
    with pytest.warns(InferenceWarning, match=r"range: input a outside \[0 10\]; evaluated without clipping") as caught:
        assert infer(fis, x).output[:, 0].tolist() == [8, 0, 7]
    assert len(caught) == 1
    assert infer(replace(fis, out_of_range="ignore"), x).output[:, 0].tolist() == [8, 0, 7]
    assert infer(replace(fis, out_of_range="clip"), x).output[:, 0].tolist() == [8, 2, 7]
    with pytest.raises(FuzzySystemError, match=r"input a outside \[0 10\], b outside \[0 4\]"):
        infer(replace(fis, out_of_range="error"), [-1.0, 4.5])
    both_ends = replace(fis, out_of_range="error", rules=(low, rule({"a": "high"}, {"y": "ten"})))
    assert infer(both_ends, [[0.0, 0.0], [10.0, 4.0]]).output[:, 0].tolist() == [5, 10]


def test_a_warning_is_shown_once_a_line_under_the_default_filter():
    fis = gap()
    with warnings.catch_warnings(record=True) as caught:
        warnings.resetwarnings()
        for _ in range(3):
            infer(fis, [4.0])
        for _ in range(3):
            fis([4.5])  # another line, through the call
    assert len(caught) == 2
    assert {w.filename for w in caught} == {__file__}


# Systems as values ------------------------------------------------------------------------------------------------


@law
@given(systems())
def test_systems_are_values(fis):
    again = pickle.loads(pickle.dumps(fis))
    assert again == fis
    assert hash(again) == hash(fis)
    assert replace(fis, name="other") != fis
    np.testing.assert_array_equal(again.structure.term, fis.structure.term)


def test_nothing_changes_after_construction():
    fis = gap()
    for thing, attribute in [(fis, "rules"), (fis.inputs[0], "terms"), (Linear((1,), 2), "constant"), (LOW, "weight")]:
        with pytest.raises(FrozenInstanceError):
            setattr(thing, attribute, ())
    with pytest.raises(TypeError):
        fis.inputs[0].terms["left"] = Triangle(0, 1, 2)  # type: ignore[index]
    terms = {"left": Triangle(0, 1, 2)}
    variable = Variable("a", (0, 1), terms)
    terms["right"] = Triangle(1, 2, 3)
    assert list(variable.terms) == ["left"]


def test_terms_compare_in_order():
    assert Terms({"a": 1, "b": 2}) == Terms([("a", 1), ("b", 2)])
    assert Terms({"a": 1, "b": 2}) != Terms({"b": 2, "a": 1})


def test_sentences_and_rule_objects_make_equal_systems():
    sentences = ("if a is low then y is none", "if a is high and b is high then y is ten")
    assert Sugeno((A, B), (Y,), sentences) == Sugeno((A, B), (Y,), (LOW, rule(HIGH_HIGH, {"y": "ten"})))


def test_variables_by_name_and_label():
    fis = gap()
    assert fis["y"] is fis.outputs[0]
    assert A.label == "a [m]"
    assert B.label == "b"
    with pytest.raises(KeyError, match="unknown variable 'aa'; did you mean 'a'"):
        fis["aa"]


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: Sugeno((), (Y,)), "needs at least one input"),
        (lambda: Sugeno((A,), ()), "needs at least one output"),
        (lambda: Sugeno((A, A), (Y,)), "two inputs are named 'a'"),
        (lambda: Sugeno((A,), (Y, Y)), "two outputs are named 'y'"),
        (lambda: Sugeno((Y,), (Y,)), "input 'y': term 'none' must be a membership function"),
        (lambda: Sugeno((A,), (A,)), "output 'a': term 'low' must be a consequent"),
        (lambda: Sugeno((A,), (Y,)), r"y is plane: a linear consequent has one slope an input \(1\).* got 2 slopes"),
        (lambda: Sugeno((A, B), (Y,), and_method="product"), "unknown and_method 'product'; did you mean 'prod'"),  # type: ignore[arg-type]
        (lambda: Sugeno((A, B), (Y,), or_method="sum"), "unknown or_method 'sum'"),  # type: ignore[arg-type]
        (lambda: Sugeno((A, B), (Y,), defuzzification="centroid"), "unknown defuzzification 'centroid'"),  # type: ignore[arg-type]
        (lambda: Sugeno((A, B), (Y,), no_rule_fires="zero"), "unknown no_rule_fires 'zero'"),  # type: ignore[arg-type]
        (lambda: Sugeno((A, B), (Y,), out_of_range="warm"), "unknown out_of_range 'warm'; did you mean 'warn'"),  # type: ignore[arg-type]
        (lambda: Sugeno((A, B), (Y,), (rule({"c": "low"}, {"y": "ten"}),)), "rule 1: unknown input 'c'.* Known: a, b"),
        (lambda: Sugeno((A, B), (Y,), (LOW, rule({"a": "lo"}, {"y": "ten"}))), "rule 2: unknown term of 'a' 'lo'; did"),
        (lambda: Sugeno((A, B), (Y,), (rule({"a": "low"}, {"z": "ten"}),)), "rule 1: unknown output 'z'"),
        (lambda: Sugeno((A, B), (Y,), (rule({"a": "low"}, {"y": "tan"}),)), "rule 1: unknown term of 'y' 'tan'; did"),
        (lambda: Sugeno((A, B), (Y,), (rule({}, {"y": "ten"}),)), "rule 1 needs an antecedent and a consequent"),
        (lambda: Sugeno((A, B), (Y,), (rule({"a": "low"}, {}),)), "rule 1 needs an antecedent and a consequent"),
        (lambda: Sugeno((A, B), (Y,), (replace(LOW, connective="xor"),)), "rule 1: unknown connective 'xor'"),  # type: ignore[arg-type]
        (
            lambda: Sugeno((A, B), (Y,), (replace(LOW, weight=1.5),)),
            r"rule 1: the weight must lie in \[0, 1\], got 1.5",
        ),
        (lambda: Sugeno((A, B), (Y,), (replace(LOW, weight=float("nan")),)), "rule 1: the weight .* got nan"),
        (lambda: Sugeno((A, B), (Y,), (replace(LOW, when=LOW.when * 2),)), "rule 1: input 'a' appears twice"),
        (lambda: Sugeno((A, B), (Y,), (replace(LOW, then=LOW.then * 2),)), "rule 1: output 'y' appears twice"),
        (lambda: Sugeno((A, B), (Y,), (rule({"a": ("low", False, 0.0)}, {"y": "ten"}),)), "hedge's power must be > 0"),
        (lambda: Variable("a", (0, 1, 2)), "a: the universe of discourse is a pair"),  # type: ignore[arg-type]
        (lambda: Variable("a", 3), "a: the universe of discourse is a pair"),  # type: ignore[arg-type]
        (lambda: Variable("a", (1, 0)), r"a: the universe of discourse must be finite and ascending, got \[1 0\]"),
        (lambda: Variable("a", (0, np.inf)), r"a: the universe .* got \[0 inf\]"),
        (lambda: Variable("a", (0, 1), {"t": "trimf"}), "a: term 't' must be .* got 'trimf'"),
        (
            lambda: infer(gap(), [1.0, 2.0]),
            r"gap: the last axis of the input must hold 1 values \(a\), got shape \(2,\)",
        ),
        (lambda: infer(gap(), 1.0), r"gap: the last axis .* got shape \(\)"),
    ],
)
def test_errors_name_the_culprit(make, message):
    with pytest.raises(FuzzySystemError, match=message):
        make()


@quiet
@law
@given(points(2), st.integers(0, 100))
def test_a_partition_of_unity_reproduces_its_consequents(x, seed):
    # Terms that sum to 1 and rules for all pairs, each proposing its corner's value: bilinear interpolation.
    corner = np.random.default_rng(seed).normal(size=(2, 2))
    y = Variable("y", (-5, 5), {f"{i}{j}": corner[i, j] for i in (0, 1) for j in (0, 1)})
    names = ("low", "high")
    rules = [rule({"a": names[i], "b": names[j]}, {"y": f"{i}{j}"}) for i in (0, 1) for j in (0, 1)]
    output = infer(Sugeno((A, B), (y,), rules, out_of_range="clip"), x).output
    u, v = np.clip(x[..., 0] / 10, 0, 1), np.clip(x[..., 1] / 4, 0, 1)
    expected = (1 - u) * ((1 - v) * corner[0, 0] + v * corner[0, 1]) + u * ((1 - v) * corner[1, 0] + v * corner[1, 1])
    np.testing.assert_allclose(output[..., 0], expected, atol=1e-13)


def test_a_call_with_several_arguments_says_how_to_call():
    with pytest.raises(FuzzySystemError, match=r"one array of all inputs, fis\(\[\w+\]\).*; got 2 arguments"):
        gap()(1.0, 2.0)


def test_a_rule_is_left_out_as_if_it_had_never_fired():
    x = fuzzy.Variable(
        "x", (0, 1), {"low": fuzzy.LinearZ(0, 1), "high": fuzzy.LinearS(0, 1), "all": fuzzy.trapmf(-1, 0, 1, 2)}
    )
    y = fuzzy.Variable("y", (0, 9), {"a": 1.0, "b": 4.0, "c": 9.0})
    rules = [f"if x is {term} then y is {value}" for term, value in (("low", "a"), ("all", "b"), ("high", "c"))]
    fis = fuzzy.Sugeno([x], [y], rules)
    points = np.linspace(0, 1, 11)[:, None]
    known = fuzzy.infer(fis, points)
    for place, value in enumerate((1.0, 4.0, 9.0)):
        firing = np.asarray(known.firing)
        left = firing.sum(-1) * known.output[:, 0] - firing[:, place] * value
        rest = np.delete(firing, place, axis=-1).sum(-1)
        fewer = fis.without_rule(place)
        assert [str(rule) for rule in fewer.rules] == [rule for k, rule in enumerate(rules) if k != place]
        np.testing.assert_allclose(fewer(points)[:, 0], left / rest, rtol=1e-12)
