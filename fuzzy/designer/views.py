"""What is shown of a design, in JSON's types: numbers, texts, lists and mappings; None is a number that is missing."""

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from fuzzy.designer.design import CHOICES, Design, Problem, RuleLine
from fuzzy.insight.explanation import explain
from fuzzy.insight.surfacegrid import surface
from fuzzy.membershipfunction import MATLAB_NAMES, as_number
from fuzzy.system import Constant, FuzzySystemError, Linear, Sugeno, Variable

if TYPE_CHECKING:
    from fuzzy.designer.document import Document

POINTS = 41  # of a surface along each axis


def functions_data() -> dict[str, Any]:
    """The trait ``functions``: the facts about each membership function other than its formula, by MATLAB's name.

    ``title`` is the function in words. ``words`` and ``roles`` say what each parameter is, ``vertices`` which of them
    (by place) stand from left to right.
    """
    return {
        name: {
            "title": function.title,
            "words": list(function.words),
            "roles": list(function.roles),
            "vertices": list(function.vertices),
        }
        for name, function in MATLAB_NAMES.items()
    }


def document_data(document: "Document") -> dict[str, Any]:
    """The trait ``design`` of a document: :func:`design_data` with its file and history."""
    return design_data(
        document.design,
        revision=document.revision,
        file=document.path.name,
        saved=document.saved,
        undo=document.can_undo,
        redo=document.can_redo,
    )


def design_data(
    design: Design,
    *,
    revision: int = 0,
    file: str = "",
    saved: bool = True,
    undo: str | None = None,
    redo: str | None = None,
) -> dict[str, Any]:
    """The trait ``design``: variables, choices and rules. A problem's ``start`` and ``end`` count UTF-16 units.

    Args:
        design: The design.
        revision: A number that grows with every change.
        file: The file's name.
        saved: Whether the file holds the design.
        undo: The name of the edit that can be undone.
        redo: The name of the edit that can be made again.
    """
    system = design.system
    return {
        "revision": revision,
        "name": system.name,
        "file": file,
        "saved": saved,
        "choices": {name: getattr(system, name) for name in CHOICES},
        "accepted": {name: list(values) for name, values in CHOICES.items()},
        "inputs": [variable_data(v) for v in system.inputs],
        "outputs": [variable_data(v) for v in system.outputs],
        "rules": [_rule_data(line) for line in design.lines],
        "undo": undo,
        "redo": redo,
    }


def variable_data(variable: Variable) -> dict[str, Any]:
    """A variable with its terms and their parameters, in MATLAB's order."""
    low, high = variable.universe
    terms = [
        {"name": name, "type": _type(term), "parameters": [as_number(p) for p in term.parameters]}
        for name, term in variable.terms.items()
    ]
    return {"name": variable.name, "unit": variable.unit, "low": low, "high": high, "terms": terms}


def _type(term: Any) -> str:
    return type(term).__name__.casefold() if isinstance(term, (Constant, Linear)) else term.matlab


def _rule_data(line: RuleLine) -> dict[str, Any]:
    rule = line.rule
    return {
        "key": line.key,
        "text": line.text,
        "weight": float(rule.weight),
        "enabled": line.enabled,
        "connective": rule.connective,
        "when": [
            {"variable": c.variable, "term": c.term, "negated": c.negated, "power": float(c.power)} for c in rule.when
        ],
        "then": [{"variable": output, "term": term} for output, term in rule.then],
        "problem": _problem_data(line.problem, line.text) if line.problem else None,
    }


def _problem_data(problem: Problem, text: str) -> dict[str, Any]:
    return {
        "message": problem.message,
        "start": _utf16(text[: problem.start]),
        "end": _utf16(text[: problem.end]),
    }


def _utf16(text: str) -> int:
    return len(text) + sum(c > "\uffff" for c in text)


def _quiet(system: Sugeno) -> Sugeno:
    """The system without errors where no rule fires or an input lies outside: both are shown instead."""
    if system.out_of_range in ("error", "warn"):
        system = replace(system, out_of_range="ignore")
    return replace(system, no_rule_fires="nan") if system.no_rule_fires == "error" else system


def viewer_data(design: Design, point: Sequence[float] | None = None) -> dict[str, Any]:
    """The trait ``viewer``: what each enabled rule does at ``point`` (inputs,), by default the design's.

    ``fired`` says for each output whether any rule for it fires; ``words`` is
    :func:`fuzzy.insight.explanation.explain`.
    """
    system = design.in_force
    at = np.asarray(design.point if point is None else point, dtype=float)
    with np.errstate(all="ignore"):
        told = explain(_quiet(system), at)
    keys = [line.key for line in design.lines if line.enabled]
    words = str(replace(told, system=system))
    if told.outside and system.out_of_range == "error":
        words += f"\n{system.name} refuses such a point: {', '.join(told.outside)} outside the universe."
    return {
        "point": _numbers(told.x),
        "memberships": [_numbers(degrees.values()) for degrees in told.memberships],
        "rules": [
            {
                "key": key,
                "degrees": _numbers(row.degrees),
                "firing": _number(row.firing),
                "share": _numbers(row.share),
                "proposed": _numbers(row.proposed),
                "contribution": _numbers(row.contribution),
            }
            for key, row in zip(keys, told.rows, strict=True)
        ],
        "output": _numbers(told.output),
        "fired": list(told.fired),
        "outside": list(told.outside),
        "words": words,
    }


def surface_data(
    design: Design | Sugeno,
    inputs: Sequence[int] | None = None,
    output: int = 0,
    point: Sequence[float] | None = None,
    points: int = POINTS,
) -> dict[str, Any]:
    """The trait ``surface``: an output over one or two inputs, the others held at a point.

    ``z`` (points, points) has the second input along its first axis; where ``fired`` is false no rule fires and ``z``
    is what the system says there, or None. ``low`` and ``high`` are the least and greatest ``z`` where a rule fires,
    or the output's universe if none does anywhere.

    Args:
        design: The design, or a system.
        inputs: The inputs of the axes, by number; the first two by default.
        output: The output, by number.
        point: The point (inputs,), by default the design's.
        points: The number of points along each axis.

    Raises FuzzySystemError for inputs and outputs that do not exist.
    """
    system = design if isinstance(design, Sugeno) else design.in_force
    if point is None:
        point = [v.midrange for v in system.inputs] if isinstance(design, Sugeno) else design.point
    if len(point) != len(system.inputs):
        raise FuzzySystemError(f"a point has {len(system.inputs)} numbers, one per input, got {len(point)}")
    axes = list(range(min(2, len(system.inputs)))) if inputs is None else list(inputs)
    fixed = {i: value for i, value in enumerate(point) if i not in axes}
    with np.errstate(all="ignore"):
        grid = surface(_quiet(system), axes, output, fixed, points)
    z, fired = grid.z, grid.fired
    known = z[fired & np.isfinite(z)]
    low, high = (float(known.min()), float(known.max())) if known.size else system.outputs[output].universe
    return {
        "inputs": axes,
        "output": output,
        "x": _numbers(grid.x[0] if grid.y is not None else grid.x),
        "y": None if grid.y is None else _numbers(grid.y[:, 0]),
        "z": _array(z),
        "fired": fired.tolist(),
        "fixed": _numbers(point),
        "low": low,
        "high": high,
    }


def compared_data(
    fis: Sugeno, name: str, inputs: Sequence[int] | None = None, output: int = 0, point: Sequence[float] | None = None
) -> dict[str, Any]:
    """The trait ``compared``: another system's variables, and its surface where it has the same axes (else None).

    Args:
        fis: The other system.
        name: Its name on the page.
        inputs: The inputs of the surface's axes, by number.
        output: The surface's output, by number.
        point: The point (inputs,) at which the other inputs are held.
    """
    try:
        other = surface_data(fis, inputs, output, point)
    except FuzzySystemError:
        other = None
    return {
        "name": name,
        "inputs": [variable_data(v) for v in fis.inputs],
        "outputs": [variable_data(v) for v in fis.outputs],
        "surface": other,
    }


def _number(value: float) -> float | None:
    return float(value) if math.isfinite(value) else None


def _numbers(values: Any) -> list[float | None]:
    return [_number(value) for value in values]


def _array(values: np.ndarray) -> list[Any]:
    if np.isfinite(values).all():
        return values.tolist()
    return [_numbers(row) for row in values] if values.ndim > 1 else _numbers(values)
