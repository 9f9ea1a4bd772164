"""A system of one or two inputs as a table of its answers, interpolated between them."""

from dataclasses import dataclass
from textwrap import indent
from typing import Any

import numpy as np

from fuzzy.plugins.ccode.fixedpoint import check_range, q16
from fuzzy.plugins.ccode.identifier import comment
from fuzzy.plugins.ccode.numbertype import FIXED_POINT, FLOATING, ExportError, Floating, c_type, checked_number
from fuzzy.plugins.ccode.phrases import called, limited_to, signature, table
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
    real, outputs, upper = kind.name, len(plan.outputs), plan.name.upper()
    values = table(real, f"{plan.name}_table", [kind.constant(float(v)) for v in lookup.values.ravel()])
    zero, one = kind.constant(0.0), kind.constant(1.0)
    nan = " + ".join(f"(x[{k}] - x[{k}])" for k in range(len(plan.inputs)))
    lines = []
    for k, (variable, n) in enumerate(zip(plan.fis.inputs, lookup.points, strict=True)):
        low, high = map(kind.constant, variable.universe)
        step = kind.constant((n - 1) / (variable.universe[1] - variable.universe[0]))
        lines += [
            f"const {real} in{k} = {limited_to(f'x[{k}]', low, high)};",
            f"const {real} at{k} = (in{k} - ({low})) * {step}; /* in cells */",
            f"const int near{k} = at{k} > {zero} ? (at{k} < {float(n)}{kind.suffix} ? (int)at{k} : {n}) : 0;",
            f"const int cell{k} = near{k} > {n - 2} ? {n - 2} : near{k};",
            f"const {real} share{k} = at{k} - ({real})cell{k};",
            f"if (x[{k}] < {low} || x[{k}] > {high}) told = {upper}_OUTSIDE;",
        ]
    lines += _corners(plan, lookup, real)
    if len(plan.inputs) == 1:
        value = f"low[o] * ({one} - share0) + low[{outputs} + o] * share0"
    else:
        near = f"(low[o] * ({one} - share1) + low[{outputs} + o] * share1)"
        far = f"(next[o] * ({one} - share1) + next[{outputs} + o] * share1)"
        value = f"{near} * ({one} - share0) + {far} * share0"
    lines += [f"for (int o = 0; o < {outputs}; o++) y[o] = {value};"]
    lines += [f"if ({' || '.join(f'x[{k}] != x[{k}]' for k in range(len(plan.inputs)))})"]
    lines += [f"    for (int o = 0; o < {outputs}; o++) y[o] = {nan};"]
    return values + _function(plan, real, lines)


def _fixed(plan: CodePlan, lookup: Lookup) -> str:
    outputs, upper = len(plan.outputs), plan.name.upper()
    values = table("int32_t", f"{plan.name}_table", [str(q16(float(v))) for v in lookup.values.ravel()])
    lines = []
    for k, (variable, n) in enumerate(zip(plan.fis.inputs, lookup.points, strict=True)):
        low, high = map(q16, variable.universe)
        span = high - low
        lines += [
            f"const int32_t in{k} = {limited_to(f'x[{k}]', low, high)};",
            f"const int64_t at{k} = (((int64_t)in{k} - ({low})) * {n - 1} << 16) / {span}; /* in cells, Q16 */",
            f"const int cell{k} = (int)(at{k} >> 16) > {n - 2} ? {n - 2} : (int)(at{k} >> 16);",
            f"const int64_t share{k} = at{k} - ((int64_t)cell{k} << 16);",
            f"if (x[{k}] < {low} || x[{k}] > {high}) told = {upper}_OUTSIDE;",
        ]
    lines += _corners(plan, lookup, "int32_t")
    if len(plan.inputs) == 1:
        lines.append(
            f"for (int o = 0; o < {outputs}; o++)\n"
            f"    y[o] = (int32_t)(low[o] + shifted(((int64_t)low[{outputs} + o] - low[o]) * share0, 16));"
        )
    else:
        lines += [
            f"for (int o = 0; o < {outputs}; o++) {{",
            f"    const int64_t near = low[o] + shifted(((int64_t)low[{outputs} + o] - low[o]) * share1, 16);",
            f"    const int64_t far = next[o] + shifted(((int64_t)next[{outputs} + o] - next[o]) * share1, 16);",
            "    y[o] = (int32_t)(near + shifted((far - near) * share0, 16));",
            "}",
        ]
    function = _function(plan, "int32_t", lines)
    return f"{called('fixed.c', function)}\n{values}{function}"


def _corners(plan: CodePlan, lookup: Lookup, real: str) -> list[str]:
    outputs = len(plan.outputs)
    if len(plan.inputs) == 1:
        return [f"const {real} *const low = {plan.name}_table + {outputs} * cell0;"]
    row = outputs * lookup.points[1]
    return [
        f"const {real} *const low = {plan.name}_table + {row} * cell0 + {outputs} * cell1;",
        f"const {real} *const next = low + {row};",
    ]


def _function(plan: CodePlan, real: str, lines: list[str]) -> str:
    body = indent("\n".join(["int told = 0;", *lines, "return told;"]), "    ")
    return f"\n\n{signature(plan.name, real)} {{\n{body}\n}}\n"
