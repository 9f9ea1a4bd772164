"""Formulas and paths made of them: against closed forms, differences, and what a file must not be able to do."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from robotics.plugins.shapes.formula import FORMULA_FUNCTIONS, FormulaError, evaluate
from robotics.plugins.shapes.parametric import Parametric
from robotics.simulation.loop import simulate
from robotics.simulation.scenario.description import ScenarioError
from robotics.simulation.scenario.reading import parse_scenario
from robotics.world.paths.path import Circle, PathError, compile_path

U = np.linspace(0.3, 1.2, 7)
NUMBERS = st.integers(1, 4).map(str)


def formulas() -> st.SearchStrategy[str]:
    """Formulas that stay finite on U: powers of what is positive, functions of what is small."""

    def more(inner: st.SearchStrategy[str]) -> st.SearchStrategy[str]:
        pairs = st.tuples(inner, st.sampled_from(["+", "-", "*"]), inner).map(lambda p: f"({p[0]} {p[1]} {p[2]})")
        calls = st.tuples(st.sampled_from(["sin", "cos", "tanh", "atan"]), inner).map(lambda p: f"{p[0]}({p[1]})")
        shares = st.tuples(inner, inner).map(lambda p: f"{p[0]} / (2 + sin({p[1]}))")
        return (
            pairs
            | calls
            | shares
            | inner.map(lambda f: f"-({f})")
            | st.tuples(inner, NUMBERS).map(lambda p: f"({p[0]})**{p[1]}")
        )

    return st.recursive(NUMBERS | st.just("u") | st.just("pi"), more, max_leaves=6)


@settings(max_examples=100)
@given(formulas())
def test_a_formula_is_pythons_value_and_its_slopes_are_differences(formula: str) -> None:
    names = {name: getattr(np, {"atan": "arctan"}.get(name, name)) for name in FORMULA_FUNCTIONS} | {"pi": math.pi}
    found = evaluate(formula, U)
    np.testing.assert_allclose(found.value, eval(formula, {"__builtins__": {}}, names | {"u": U}) + 0 * U, rtol=1e-12)
    h = 1e-4
    near = [evaluate(formula, U + k * h).value for k in (-2, -1, 0, 1, 2)]
    size = 1 + max(np.abs(row).max() for row in near) + np.abs(found.second).max()
    first = (near[0] - 8 * near[1] + 8 * near[3] - near[4]) / (12 * h)
    np.testing.assert_allclose(found.first, first, atol=1e-6 * size, rtol=1e-5)
    np.testing.assert_allclose(found.second, (near[3] - 2 * near[2] + near[1]) / h**2, atol=2e-4 * size, rtol=1e-3)


@pytest.mark.parametrize(("formula", "first", "second"), [
    ("tan(u)", 1 / np.cos(U) ** 2, 2 * np.sin(U) / np.cos(U) ** 3),
    ("log(u)", 1 / U, -1 / U**2),
    ("sqrt(u)", 0.5 / np.sqrt(U), -0.25 * U**-1.5),
    ("exp(2*u)", 2 * np.exp(2 * U), 4 * np.exp(2 * U)),
    ("u**1.5", 1.5 * U**0.5, 0.75 * U**-0.5),
])  # fmt: skip
def test_slopes_are_those_of_the_textbook(formula: str, first: np.ndarray, second: np.ndarray) -> None:
    found = evaluate(formula, U)
    np.testing.assert_allclose(found.first, first, rtol=1e-12)
    np.testing.assert_allclose(found.second, second, rtol=1e-12)


def test_powers_are_smooth_where_their_base_is_0() -> None:
    for power, second in ((1, 0.0), (2, 2.0), (3, 0.0)):
        found = evaluate(f"u**{power}", np.zeros(1))
        assert (found.first[0], found.second[0]) == (float(power == 1), second)


@pytest.mark.parametrize(
    "formula",
    ["__import__('os').system('true')", "u.real", "[u]", "lambda: u", "u if u else 1", "'u'", "True", "open(u)",
     "sin(u, u)", "6*sin(2*u", "", "2**u", "x+1", "u" * 1001, "(" * 400 + "u" + ")" * 400, "1e999*u j"],
)  # fmt: skip
def test_nothing_else_is_read(formula: str) -> None:
    with pytest.raises(FormulaError):
        evaluate(formula, U)


def test_a_circle_by_formulas_is_the_circle() -> None:
    made = compile_path(Parametric(x="1 + 2*cos(u)", y="-1 + 2*sin(u)", begin=0.0, end=2 * math.pi))
    circle = compile_path(Circle(center=(1.0, -1.0), radius=2.0))
    assert made.length == pytest.approx(4 * math.pi, rel=1e-10)
    s = np.linspace(0.0, made.length, 50)
    for ours, theirs in zip(made.at(s), circle.at(s), strict=True):
        np.testing.assert_allclose(ours, theirs, atol=1e-6)


def test_a_spiral_has_its_length_and_is_driven_both_ways() -> None:
    a, turns = 0.3, 4 * math.pi
    there = compile_path(Parametric(x="0.3*u*cos(u)", y="0.3*u*sin(u)", begin=1.0, end=turns))

    def arc(u: float) -> float:
        return a / 2 * (u * math.hypot(1, u) + math.asinh(u))

    assert there.length == pytest.approx(arc(turns) - arc(1.0), rel=1e-9)
    back = compile_path(Parametric(x="0.3*u*cos(u)", y="0.3*u*sin(u)", begin=turns, end=1.0))
    np.testing.assert_allclose(
        [back.at(0.0).x, back.at(0.0).y], [there.at(there.length).x, there.at(there.length).y], atol=1e-9
    )
    np.testing.assert_allclose(back.at(1.0).curvature, -there.at(there.length - 1.0).curvature, rtol=1e-6)


@pytest.mark.parametrize(("x", "y", "said"), [
    ("sqrt(u - 1)", "u", "x or its slope is not finite at u = 0"),
    ("u", "6*sin(2*v)", "unknown name 'v'"),
    ("u", "sinus(u)", "did you mean 'sin'"),
    ("u**2", "u**3", "a cusp"),
    ("2", "3", "its length is 0 m"),
])  # fmt: skip
def test_what_cannot_be_driven_is_said(x: str, y: str, said: str) -> None:
    with pytest.raises(PathError, match=said):
        compile_path(Parametric(x=x, y=y, begin=-1.0 if "3" in y else 0.0, end=1.0))


SCENARIO = """
duration = 20.0
[[robots]]
start = [0.0, 0.0, 0.785]
path = { shape = "parametric", x = "2*sin(u)", y = "sin(2*u)", begin = 0.0, end = %s }
timing = { speed = 0.3 }
"""


def test_a_robot_follows_a_formula_of_a_file_and_a_wrong_one_is_told_with_its_line() -> None:
    run = simulate(parse_scenario(SCENARIO % "6.2832", "lissajous"), "fuzzy", [0])
    assert np.hypot(run["x"] - run.target("x"), run["y"] - run.target("y"))[0, 0, 200:].max() < 0.05
    with pytest.raises(ScenarioError, match=r"lissajous.toml:5: .*unknown name 'v'"):
        parse_scenario((SCENARIO % "6.2832").replace("2*sin(u)", "2*sin(v)"), "lissajous", "lissajous.toml")
