"""A system of one or two inputs as a table of its answers, interpolated between them."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from fuzzy.plugins.ccode.fixedpoint import check_range, q16
from fuzzy.plugins.ccode.identifier import comment
from fuzzy.plugins.ccode.numbertype import FIXED_POINT, FLOATING, ExportError, Floating, c_type, checked_number
from fuzzy.plugins.ccode.phrases import called, limited_to, rendered, signature, table
from fuzzy.plugins.ccode.plan import CodePlan, planned
from fuzzy.plugins.ccode.proofpoints import answers_of, proof_points
from fuzzy.plugins.ccode.source import CSources, header
from fuzzy.shown import shown
from fuzzy.system import Sugeno

_MOST = 65_536  # points of a table
_BETWEEN = 4  # how often an interval is looked at to find the error
_LOOKED_AT = 20_000  # points besides, many of them at the edges of membership functions


@dataclass(frozen=True)
class Lookup:
    """A table of answers, and how far it is from the rules between its points, a share of each output's range.

    Attributes:
        points: How many along each input.
        values: (points of input 1, ..., outputs): the answers, in the outputs' units.
        greatest: (outputs,): the greatest distance from the rules, in the output's unit.
        mean: (outputs,): the mean distance, in the output's unit.
    """

    points: tuple[int, ...]
    values: np.ndarray
    greatest: tuple[float, ...]
    mean: tuple[float, ...]

    def answers(self, fis: Sugeno, x: np.ndarray) -> np.ndarray:
        """What the table says (n, outputs) at points ``x`` (n, inputs) in the universes of discourse of ``fis``."""
        return _interpolated(self.values, fis, x)


def lookup_of(fis: Sugeno, points: tuple[int, ...]) -> Lookup:
    """Ask a system at evenly spread points. Raises ExportError for other than one or two inputs, or a wrong shape."""
    inputs = len(fis.inputs)
    if inputs > 2:
        raise ExportError(f"{fis.name}: a lookup table is for one or two inputs, and this system has {inputs}")
    points = points * inputs if len(points) == 1 else points
    if len(points) != inputs or min(points) < 2 or np.prod(points) > _MOST:
        shape = "N" if inputs == 1 else "N or NxM"
        raise ExportError(
            f"{fis.name}: a lookup table has {shape} points, at least 2 along each input and {_MOST} in all; got "
            + "x".join(map(str, points))
        )
    for variable in fis.inputs:
        if variable.universe[0] == variable.universe[1]:
            raise ExportError(f"{fis.name}: {variable.name} has a single value, over which no table can be spread")
    values = answers_of(fis, _grid(fis, points))
    dense = _grid(fis, tuple((n - 1) * _BETWEEN + 1 for n in points)).reshape(-1, inputs)
    x = np.concatenate([dense, proof_points(fis, _LOOKED_AT, 0, inside=True)])
    error = np.abs(_interpolated(values, fis, x) - answers_of(fis, x))
    return Lookup(points, values, tuple(error.max(axis=0).tolist()), tuple(error[: len(dense)].mean(axis=0).tolist()))


def _grid(fis: Sugeno, points: tuple[int, ...]) -> np.ndarray:
    axes = [np.linspace(*variable.universe, n) for variable, n in zip(fis.inputs, points, strict=True)]
    return np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1)


def _interpolated(values: np.ndarray, fis: Sugeno, x: np.ndarray) -> np.ndarray:
    """Linear between the points of a table, along each input."""
    corners: list[tuple[tuple[Any, ...], Any]] = [((), 1.0)]
    for k, variable in enumerate(fis.inputs):
        low, high = variable.universe
        at = (np.clip(x[:, k], low, high) - low) * ((values.shape[k] - 1) / (high - low))
        cell = np.minimum(at.astype(int), values.shape[k] - 2)
        share = (at - cell)[:, None]
        corners = [
            ((*place, cell + step), weight * (share if step else 1 - share))
            for place, weight in corners
            for step in (0, 1)
        ]
    return np.asarray(sum(values[place] * weight for place, weight in corners))


def with_lookup(fis: Sugeno, lookup: Lookup, name: str = "", number: str = "double") -> CSources:
    """A system in C as its table. Raises ExportError for numbers that the type does not have."""
    checked_number(number)
    plan = planned(fis, name)
    errors = [
        f"{v.name}: {shown(g)} at most, {shown(m)} on average"
        for v, g, m in zip(fis.outputs, lookup.greatest, lookup.mean, strict=True)
    ]
    shape = " x ".join(map(str, lookup.points))
    about = f"A table of {shape} points in place of the rules; inputs are limited to their ranges. Its error: "
    told = comment(about + "; ".join(errors))
    fixed = number == FIXED_POINT
    if fixed:
        check_range(plan)
    top = header(plan, c_type(number)).replace(" *\n * Inputs,", f" * {told}\n *\n * Inputs,", 1)
    text = _fixed(plan, lookup) if fixed else _floating(plan, lookup, FLOATING[number])
    return CSources(plan.name, top, f'/* {told} */\n#include "{plan.name}.h"\n\n{text}')


def _floating(plan: CodePlan, lookup: Lookup, kind: Floating) -> str:
    values = table(kind.name, f"{plan.name}_table", [kind.constant(float(v)) for v in lookup.values.ravel()])
    inputs = []
    for variable, n in zip(plan.fis.inputs, lookup.points, strict=True):
        low, high = map(kind.constant, variable.universe)
        step = kind.constant((n - 1) / variable.span)
        inputs.append({"low": low, "high": high, "step": step})
    return values + _function(plan, lookup, inputs, kind.name, number=kind, zero=kind.constant(0), one=kind.constant(1))


def _fixed(plan: CodePlan, lookup: Lookup) -> str:
    values = table("int32_t", f"{plan.name}_table", [str(q16(float(v))) for v in lookup.values.ravel()])
    inputs = [dict(zip(("low", "high"), map(q16, variable.universe), strict=True)) for variable in plan.fis.inputs]
    function = _function(plan, lookup, inputs, "int32_t", fixed=True)
    return f"{called('fixed.c', function)}\n{values}{function}"


def _function(
    plan: CodePlan, lookup: Lookup, inputs: list[dict[str, Any]], real: str, *, fixed: bool = False, **values: Any
) -> str:
    """The function that interpolates; ``inputs`` say of each the ends of its range, as C writes them."""
    for k, (about, points) in enumerate(zip(inputs, lookup.points, strict=True)):
        about |= {"place": k, "points": points, "taken": limited_to(f"x[{k}]", about["low"], about["high"])}
    outputs = len(plan.outputs)
    return rendered(
        "lookup_infer.c.j2",
        plan,
        inputs=inputs,
        outputs=outputs,
        row=outputs * lookup.points[-1],
        real=real,
        fixed=fixed,
        signature=signature(plan.name, real),
        **values,
    )
