"""Random Sugeno systems and points for Hypothesis: every function, method, hedge and kind of rule.

Numbers are sixteenths, so that points fall on feet, centers and edges often. A strategy is made once: Hypothesis looks
through each new one, which takes longer than to draw from it.
"""

from functools import cache
from typing import Any, Literal

import numpy as np
from hypothesis import strategies as st
from hypothesis.extra.numpy import array_shapes, arrays

from fuzzy import membership as mf
from fuzzy.rule import Clause, Rule
from fuzzy.system import Constant, Linear, Sugeno, Variable

UNIVERSE = (-3.0, 4.0)


def sixteenths(low: float, high: float) -> st.SearchStrategy[float]:
    return st.integers(int(low * 16), int(high * 16)).map(lambda k: k / 16)


POSITION = sixteenths(*UNIVERSE)
WIDTH = sixteenths(0.25, 3) | sixteenths(-3, -0.25)
SLOPE = sixteenths(-6, 6)


BY_ROLE = {"location": POSITION, "width": WIDTH, "slope": SLOPE, "shape": sixteenths(-2, 4)}


def legal(function: type[mf.MembershipFunction]) -> st.SearchStrategy[tuple[float, ...]]:
    """Parameters that the class accepts: those that must ascend are sorted, others may cross."""

    def in_order(values: tuple[float, ...]) -> tuple[float, ...]:
        out = list(values)
        for group in function.ascending():
            for i, value in zip(group, sorted(values[i] for i in group), strict=True):
                out[i] = value
        return tuple(out)

    return st.tuples(*(BY_ROLE[role] for role in function.roles)).map(in_order)


PARAMETERS = {function: legal(function) for function in mf.FUNCTIONS}
POSITIVE = tuple(f for f in mf.FUNCTIONS if f.log_formula is not None)


@st.composite
def functions(draw: st.DrawFn, kinds: tuple[type[mf.MembershipFunction], ...] = mf.FUNCTIONS) -> mf.MembershipFunction:
    kind = draw(one_of(kinds))
    return kind(*draw(PARAMETERS[kind]))


@cache
def one_of(choices: tuple[Any, ...]) -> st.SearchStrategy[Any]:
    return st.sampled_from(choices)


@cache
def some_of(count: int) -> st.SearchStrategy[list[int]]:
    """Some of 0, 1, ..., in any order."""
    return st.lists(st.sampled_from(range(count)), min_size=1, unique=True)


@cache
def up_to(most: int) -> st.SearchStrategy[int]:
    return st.integers(1, most)


@cache
def terms(kinds: tuple[type[mf.MembershipFunction], ...]) -> st.SearchStrategy[list[mf.MembershipFunction]]:
    return st.lists(functions(kinds), min_size=1, max_size=3)


@cache
def proposals(count: int, order: int) -> st.SearchStrategy[list[Constant | Linear]]:
    """The terms of an output where there are ``count`` inputs."""
    value = sixteenths(-5, 5)
    linear = st.builds(Linear, st.lists(value, min_size=count, max_size=count), value)
    return st.lists(st.builds(Constant, value) | (linear if order else st.nothing()), min_size=1, max_size=3)


YES_OR_NO = st.booleans()


@st.composite
def systems(
    draw: st.DrawFn,
    *,
    kinds: tuple[type[mf.MembershipFunction], ...] = mf.FUNCTIONS,
    order: int = 1,
    plain: bool = False,
    defuzzification: Literal["wtaver", "wtsum"] | None = None,
) -> Sugeno:
    """A system of 1 to 3 inputs. ``plain``: only "and" of terms, multiplied; ``order`` 0: only constants."""
    count = draw(up_to(3))
    inputs = [Variable(f"x{i}", UNIVERSE, {f"t{k}": f for k, f in enumerate(draw(terms(kinds)))}) for i in range(count)]
    outputs = [
        Variable(f"y{o}", (-5.0, 6.0), {f"c{k}": c for k, c in enumerate(draw(proposals(count, order)))})
        for o in range(draw(up_to(2)))
    ]

    def part(variables: list[Variable]) -> list[Variable]:
        return [variables[k] for k in draw(some_of(len(variables)))]

    def clause(variable: Variable) -> Clause:
        negated = not plain and draw(YES_OR_NO)
        power = draw(one_of((1.0, 1.0, 0.5, 2.0, 3.0, 1.3)))
        return Clause(variable.name, draw(one_of(tuple(variable.terms))), negated, power)

    rules = [
        Rule(
            tuple(clause(v) for v in part(inputs)),
            tuple((v.name, draw(one_of(tuple(v.terms)))) for v in part(outputs)),
            "and" if plain else draw(one_of(("and", "or"))),
            draw(one_of((1.0, 1.0, 0.5, 0.125, 0.0))),
        )
        for _ in range(draw(up_to(5)))
    ]
    return Sugeno(
        inputs,
        outputs,
        rules,
        and_method="prod" if plain else draw(one_of(("prod", "min"))),
        or_method=draw(one_of(("probor", "max"))),
        defuzzification=defuzzification or draw(one_of(("wtaver", "wtsum"))),
        no_rule_fires=draw(one_of(("midrange", "nan"))),
        out_of_range=draw(one_of(("ignore", "clip"))),
    )


@cache
def points(inputs: int, shape: tuple[int, ...] | None = None) -> st.SearchStrategy[np.ndarray]:
    """Points (..., inputs), some of them outside the universe of discourse."""
    shapes = array_shapes(max_dims=3, max_side=4) if shape is None else st.just(shape)
    return shapes.flatmap(lambda s: arrays(np.float64, (*s, inputs), elements=sixteenths(-3.5, 4.5)))


@st.composite
def systems_with_points(draw: st.DrawFn, shape: tuple[int, ...] | None = None, **choices) -> tuple[Sugeno, np.ndarray]:
    fis = draw(one_kind(**choices))
    return fis, draw(points(len(fis.inputs), shape))


@cache
def one_kind(**choices: Any) -> st.SearchStrategy[Sugeno]:
    return systems(**choices)


def conditioning(fis: Sugeno, firing: np.ndarray) -> np.ndarray:
    """By how much an average over rules (..., outputs) magnifies a rounding error in the degrees.

    A degree is rounded at 1e-16, also where it is a small difference of large ones (1 − μ): an average over
    weakly firing rules then has fewer true digits. Infinite where nothing fires to speak of.
    """
    takes_part = (fis.structure.consequent >= 0).astype(float)
    strength = firing @ takes_part.T
    return np.where(strength > 1e-9, 1 / np.clip(strength, 1e-300, 1), np.inf)
