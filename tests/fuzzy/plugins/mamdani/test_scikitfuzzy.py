"""scikit-fuzzy's systems: terms recognised exactly, rules of every kind, and outputs beside its own."""

import warnings
from dataclasses import replace

import numpy as np
import pytest
import skfuzzy
from skfuzzy import control

import fuzzy
from fuzzy.plugins.mamdani.sampled import recognise
from fuzzy.plugins.mamdani.scikitfuzzy import from_skfuzzy
from fuzzy.system import FuzzySystemError

pytestmark = pytest.mark.filterwarnings("ignore:Passing more than 2 positional:DeprecationWarning")  # scikit-fuzzy's
X = np.linspace(0, 10, 101)
KINDS = {
    "trimf": (1, 3.33, 5), "trapmf": (1.234, 3, 4.1, 6.7), "gaussmf": (1.3, 4.4), "sigmf": (2, 3.3),
    "gbellmf": (2, 3, 5),
    "smf": (2, 7), "zmf": (1, 8), "pimf": (1, 3, 5, 8), "gauss2mf": (1, 3, 2, 5), "dsigmf": (3, 2, 4, 7),
}  # fmt: skip


@pytest.mark.parametrize("kind", KINDS)
def test_a_sampled_function_is_recognised(kind):
    wanted = fuzzy.membership_function(kind, KINDS[kind])
    found = recognise(X, wanted(X))
    assert found.function.matlab == kind
    assert found.function.numbers == pytest.approx(KINDS[kind], abs=1e-6)
    assert found.error < 1e-7


def test_another_shape_becomes_the_nearest_with_its_error():
    degrees = np.abs(np.sin(X)) * 0.9
    found = recognise(X, degrees)
    assert found.error == pytest.approx(np.abs(found.function(X) - degrees).max())
    assert found.error > 0.05
    for bad in (np.zeros(101), np.full(101, np.nan), np.ones(100)):
        with pytest.raises(FuzzySystemError, match="sampled membership"):
            recognise(X, bad)


def parts(points=2001):
    a = control.Antecedent(np.linspace(0, 10, 101), "a")
    b = control.Antecedent(np.linspace(-1, 1, 101), "b")
    y = control.Consequent(np.linspace(0, 20, points), "y")
    for v in (a, b):
        v.automf(3, names=["low", "mid", "high"])
    y["small"] = skfuzzy.trimf(y.universe, [0, 4, 8])
    y["large"] = skfuzzy.gaussmf(y.universe, 14, 1.5)
    return a, b, y


def outputs(system, x):
    simulation = control.ControlSystemSimulation(system, cache=False)
    found = []
    for row in x:
        simulation.input["a"], simulation.input["b"] = map(float, row)
        simulation.compute()
        found.append(simulation.output["y"])
    return np.array(found)


def rules_of(a, b, y, and_func=np.fmin, or_func=np.fmax):
    chosen = {"and_func": and_func, "or_func": or_func}
    return [
        control.Rule(a["low"] & ~b["low"], y["small"], **chosen),
        control.Rule(a["mid"] | b["high"], y["large"] % 0.7, **chosen),
        control.Rule(a["high"] & b["mid"], (y["large"] % 0.5,), **chosen),
        control.Rule(~b["mid"], y["small"], **chosen),
    ]


@pytest.mark.parametrize("method", ["centroid", "mom", "som", "lom", "bisector"])
@pytest.mark.parametrize("functions", [(np.fmin, np.fmax), (np.multiply, lambda p, q: p + q - p * q)])
def test_the_original_answers_as_scikit_fuzzy_does(method, functions, monkeypatch):
    monkeypatch.setattr("fuzzy.plugins.mamdani.scikitfuzzy._COMPARED", 4)  # its own comparison has a test of its own
    a, b, y = parts()
    y.defuzzify_method = method
    system = control.ControlSystem(rules_of(a, b, y, *functions))
    found = from_skfuzzy(system)
    assert not any("samples" in change for change in found.changes)
    assert found.original.defuzzification == method
    x = np.random.default_rng(3).uniform([0, -1], [10, 1], (12, 2))
    mine = replace(found.original, points=2001)(x)[:, 0]
    # It integrates between the places, which are 0.01 apart.
    assert np.abs(mine - outputs(system, x)).max() < (1e-3 if method == "centroid" else 0.02)


@pytest.mark.long
def test_the_difference_is_that_of_the_outputs():
    a, b, y = parts(51)
    system = control.ControlSystem(rules_of(a, b, y))
    found = from_skfuzzy(system)
    (told,) = found.difference
    axes = np.meshgrid(np.linspace(0, 10, 16), np.linspace(-1, 1, 16), indexing="ij")
    x = np.stack(axes, axis=-1).reshape(-1, 2)
    gap = np.abs(found.system(x)[:, 0] - outputs(system, x)) / 20
    assert (told.greatest, told.mean, told.points) == pytest.approx((gap.max(), gap.mean(), 256))


def test_brackets_become_several_rules_with_the_same_output():
    a, b, y = parts()
    rule = control.Rule((a["low"] | b["high"]) & ~(a["mid"] & b["mid"]), y["small"])
    with pytest.raises(FuzzySystemError, match="rule 1: 'a' stands twice in one 'and'"):
        from_skfuzzy(control.ControlSystem([rule]))
    system = control.ControlSystem(
        [control.Rule((a["low"] | a["mid"]) & b["low"], y["small"]), control.Rule(a["high"] | b["high"], y["large"])]
    )
    found = from_skfuzzy(system)
    assert [len(rule.when) for rule in found.system.rules] == [2, 2, 2]
    assert "rule 1 became 2 rules" in found.changes[0]
    x = np.random.default_rng(4).uniform([0, -1], [10, -0.1], (8, 2))
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", fuzzy.InferenceWarning)
        np.testing.assert_allclose(found.original(x)[:, 0], outputs(system, x), atol=0.02)


def test_several_outputs_with_their_weights():
    a, _b, y = parts()
    z = control.Consequent(np.linspace(0, 1, 11), "z")
    z["on"] = skfuzzy.trimf(z.universe, [0, 0.5, 1])
    found = from_skfuzzy(control.ControlSystem([control.Rule(a["low"], (y["small"] % 0.5, z["on"] % 0.2))]))
    assert {(rule.weight, rule.then) for rule in found.system.rules} == {
        (0.5, (("y", "small"),)),
        (0.2, (("z", "on"),)),
    }


def test_what_has_no_equivalent_is_refused():
    a, b, y = parts()
    hamacher = lambda p, q: p * q / (p + q - p * q)  # noqa: E731
    for rules, said in (
        ([control.Rule(a["low"] & b["low"], y["small"], and_func=hamacher)], "rule 1: and_func must be min, prod"),
        (
            [control.Rule((a["low"] | b["low"]) & b["mid"], y["small"], and_func=np.multiply)],
            "rule 1: brackets.*only with min and max",
        ),
    ):
        with pytest.raises(FuzzySystemError, match=said):
            from_skfuzzy(control.ControlSystem(rules))
    with pytest.raises(FuzzySystemError, match=r"expected a skfuzzy\.control\.ControlSystem, got int"):
        from_skfuzzy(3)
