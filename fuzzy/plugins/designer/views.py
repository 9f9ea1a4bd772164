"""What is shown of a design, in JSON's types: numbers, texts, lists and mappings; None is a number that is missing."""

import itertools
import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any, get_args

import numpy as np

from fuzzy.errors import InputError
from fuzzy.inference import forgiving
from fuzzy.insight.diagnosis import Finding, check
from fuzzy.insight.explanation import explain
from fuzzy.insight.surfacegrid import surface, surfaces
from fuzzy.membershipfunction import MATLAB_NAMES, as_number
from fuzzy.plugins.designer.design import CHOICES, TYPE_REDUCTION, Design, RuleLine
from fuzzy.plugins.type2.explanation import explain_type2
from fuzzy.plugins.type2.reduction import Reduction
from fuzzy.plugins.type2.system import Lower, Type2Sugeno
from fuzzy.shown import typeset
from fuzzy.system import FuzzySystemError, Sugeno, Variable

if TYPE_CHECKING:
    from fuzzy.plugins.designer.document import Document

_POINTS = 41  # of a surface along each axis
SMALL_POINTS = 25  # of a small one
MANY_SMALL = 15  # small surfaces, from which on they are coarser: those of 6 inputs are not
MOST_SMALL = 36  # small surfaces: the pairs of 9 inputs


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
    about = {"revision": document.revision, "file": document.path.name, "saved": document.saved}
    return design_data(document.design, **about, undo=document.can_undo, redo=document.can_redo)


def design_data(design: Design, **about: Any) -> dict[str, Any]:
    """The trait ``design``: variables, choices and rules. A problem's ``start`` and ``end`` count UTF-16 units.

    Args:
        design: The design.
        about: Of the document, where there is one: a ``revision`` that grows with every change, the name of the
            ``file``, whether it is ``saved`` there, and the names of the edits that ``undo`` and ``redo`` would take.
    """
    system = design.system
    reduction = {} if design.footprint is None else {TYPE_REDUCTION: design.footprint.reduction}
    lower = None if isinstance(design.shown, Sugeno) else design.shown.lower
    return {
        "name": system.name,
        "choices": {name: getattr(system, name) for name in CHOICES} | reduction,
        "accepted": {name: list(values) for name, values in CHOICES.items()}
        | {k: list(get_args(Reduction)) for k in reduction},
        "inputs": [variable_data(v, None if lower is None else lower[v.name]) for v in system.inputs],
        "outputs": [variable_data(v) for v in system.outputs],
        "rules": [_rule_data(line) for line in design.lines],
        "revision": 0,
        "file": "",
        "saved": True,
        "undo": None,
        "redo": None,
        **about,
    }


def variable_data(variable: Variable, lower: Mapping[str, Lower] | None = None) -> dict[str, Any]:
    """A variable with its terms and their parameters, in MATLAB's order; of a type-2 system also [scale, two lags]."""
    low, high = variable.universe
    terms = [
        {"name": name, "type": term.matlab, "parameters": [as_number(p) for p in term.parameters]}
        for name, term in variable.terms.items()
    ]
    if lower is not None:
        for term, own in zip(terms, lower.values(), strict=True):
            term["lower"] = [as_number(number) for number in (own.scale, *own.lag)]
    return {"name": variable.name, "unit": variable.unit, "low": low, "high": high, "terms": terms}


def _rule_data(line: RuleLine) -> dict[str, Any]:
    rule = line.rule
    return {
        "key": line.key,
        "text": line.text,
        "weight": float(rule.weight),
        "enabled": line.enabled,
        "unread": line.source is not None,
        "connective": rule.connective,
        "when": [
            {"variable": c.variable, "term": c.term, "negated": c.negated, "power": float(c.power)} for c in rule.when
        ],
        "then": [{"variable": output, "term": term} for output, term in rule.then],
        "problem": _problem_data(line) if line.problem else None,
    }


def _problem_data(line: RuleLine) -> dict[str, Any]:
    """What is wrong with a line's sentence, and the last ``good`` one, which is in force, or the line of the file."""
    assert line.problem is not None
    return {
        "message": typeset(line.problem.message),
        "start": _utf16(line.text[: line.problem.start]),
        "end": _utf16(line.text[: line.problem.end]),
        "good": str(line.rule) if line.source is None else line.source,
    }


def refusal_data(error: Exception, message: Any, number: int) -> dict[str, Any]:
    """The trait ``problem``: why a module's message was refused, and the field of the module that asked for it.

    Args:
        error: The error.
        message: The message.
        number: A number that no other refusal on the page has.
    """
    field = message.get("field") if isinstance(message, Mapping) else None
    return {"message": typeset(str(error)), "number": number, "field": field if isinstance(field, str) else None}


def findings_data(design: Design) -> list[dict[str, Any]]:
    """The trait ``findings``: what :func:`fuzzy.insight.diagnosis.check` finds in the rules in force, gravest first.

    Each has a ``severity``, a ``sentence`` and ``places``: {"rule": key, "text"} or {"kind", "variable", "term",
    "text"}, term null for the variable itself. Sentences that are no rules are errors.
    """
    numbers = [number for number, line in enumerate(design.lines, 1) if line.enabled]
    keys = dict(enumerate((line.key for line in design.lines), 1))
    with np.errstate(all="ignore"):
        found = check(design.in_force, numbers=numbers)
    wrong = [
        Finding("error", "sentence", f"the sentence of rule {number} is no rule: {line.problem.message}", (number,))
        for number, line in enumerate(design.lines, 1)
        if line.problem
    ]
    return [
        {
            "severity": finding.severity,
            "sentence": typeset(finding.sentence),
            "places": list(_places(design.system, finding, keys)),
        }
        for finding in (*wrong, *found)
    ]


def _places(system: Sugeno, finding: Finding, keys: Mapping[int, int]) -> Iterator[dict[str, Any]]:
    """Where a finding is: its rules, or its variable's terms, or its variable."""
    yield from ({"rule": keys[n], "text": f"rule {n}"} for n in finding.where if isinstance(n, int))
    names = [name for name in finding.where if isinstance(name, str)]
    if not names:
        return
    first, *terms = names
    inputs, outputs = ([v for v in group if v.name == first] for group in (system.inputs, system.outputs))
    # An input and an output may share a name: the terms tell which is meant, or what kind of finding it is.
    about_output = finding.kind in ("no rule fires", "no rule for an output", "consequent out of range")
    is_input = bool(inputs) and not (outputs and (about_output or not set(terms) <= set(inputs[0].terms)))
    place = {"kind": "input" if is_input else "output", "variable": first}
    for term in (*terms,) or (None,):
        yield {**place, "term": term, "text": f"{term} of {first}" if term else first}


def _utf16(text: str) -> int:
    return len(text) + sum(c > "\uffff" for c in text)


def viewer_data(design: Design, point: Sequence[float] | None = None) -> dict[str, Any]:
    """The trait ``viewer``: what each enabled rule does at ``point`` (inputs,), by default the design's.

    ``fired`` says for each output whether any rule for it fires; ``words`` is
    :func:`fuzzy.insight.explanation.explain`.
    """
    system, shown = design.in_force, design.shown
    at = np.asarray(design.point if point is None else point, dtype=float)
    with np.errstate(all="ignore"):
        told = explain(forgiving(shown), at) if isinstance(shown, Sugeno) else explain_type2(shown, at)
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
                "least": None if row.least is None else _number(row.least),
                "share": _numbers(row.share),
                "proposed": _numbers(row.proposed),
                "contribution": _numbers(row.contribution),
            }
            for key, row in zip(keys, told.rows, strict=True)
        ],
        "output": _numbers(told.output),
        "fired": list(told.fired),
        "interval": [_numbers(ends) for ends in told.interval],
        "outside": list(told.outside),
        "words": typeset(words),
    }


def surface_data(
    design: Design | Sugeno | Type2Sugeno,
    inputs: Sequence[int] | None = None,
    output: int = 0,
    point: Sequence[float] | None = None,
    points: int = _POINTS,
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
    system = design.shown if isinstance(design, Design) else design
    if point is None:
        point = design.point if isinstance(design, Design) else [v.midrange for v in system.inputs]
    if len(point) != len(system.inputs):
        raise FuzzySystemError(f"a point has {len(system.inputs)} numbers, one per input, got {len(point)}")
    axes = list(range(min(2, len(system.inputs)))) if inputs is None else list(inputs)
    fixed = {i: value for i, value in enumerate(point) if i not in axes}
    with np.errstate(all="ignore"):
        grid = surface(forgiving(system), axes, output, fixed, points)
    z, fired = grid.z, grid.fired
    known = z[fired & np.isfinite(z)]
    low, high = (float(known.min()), float(known.max())) if known.size else system.outputs[output].universe
    return {
        "inputs": axes,
        "output": output,
        "x": _numbers(grid.x[0] if grid.y is not None else grid.x),
        "y": None if grid.y is None else _numbers(grid.y[:, 0]),
        "z": numbers(z),
        "fired": fired.tolist(),
        "fixed": _numbers(point),
        "low": low,
        "high": high,
    }


def rounded_for(z: np.ndarray, span: float) -> np.ndarray:
    """``z`` with a thousandth of ``span`` as its last digit or so: all that a small picture shows."""
    digits = 3 - math.floor(math.log10(span)) if span > 0 and math.isfinite(span) else 6
    return np.round(z, min(300, max(-300, digits)))


def several_data(
    design: Design, mode: str, inputs: Sequence[int] | None = None, output: int = 0, points: int = SMALL_POINTS
) -> dict[str, Any]:
    """The trait ``several``: small surfaces beside the large one, the other inputs held at the design's point.

    Each of its ``pictures`` has ``inputs`` (one or two) and ``output`` by number, ``z`` (points, points) or (points,)
    and ``fired``, which is None where rules fire everywhere. ``left_out`` counts those for which there is no room.

    Args:
        design: The design.
        mode: "one": none; "outputs": every output over ``inputs``; "pairs": ``output`` over each pair of inputs.
        inputs: The inputs of the large one's axes; the first two by default.
        output: The output of the large one.
        points: The number of points along each axis; two thirds of it where there are many pictures.
    """
    system = forgiving(design.shown)
    axes = list(range(min(2, len(system.inputs)))) if inputs is None else list(inputs)
    several: list[tuple[list[int], list[int]]] = []  # axes, outputs
    left_out = 0
    if mode == "outputs":
        several = [(axes, list(range(len(system.outputs)))[:MOST_SMALL])]
        left_out = len(system.outputs) - len(several[0][1])
    elif mode == "pairs":
        pairs = list(itertools.islice(itertools.combinations(range(len(system.inputs)), 2), MOST_SMALL))
        several = [([i, j], [output]) for i, j in pairs]
        left_out = math.comb(len(system.inputs), 2) - len(pairs)
    pictures = []
    if len(several) > MANY_SMALL:
        points = 2 * points // 3
    if several:
        with np.errstate(all="ignore"):
            grids = surfaces(system, [axes for axes, _ in several], design.point, points)
        for (axes, outputs), (z, fired) in zip(several, grids, strict=True):
            for j in outputs:
                known = z[..., j][fired[..., j] & np.isfinite(z[..., j])]
                span = float(np.ptp(known)) if known.size else 1.0
                gaps = None if fired[..., j].all() else fired[..., j].tolist()
                pictures.append(
                    {"inputs": axes, "output": j, "z": numbers(rounded_for(z[..., j], span)), "fired": gaps}
                )
    return {"mode": mode, "pictures": pictures, "left_out": left_out}


def compared_data(
    fis: Sugeno | Type2Sugeno,
    name: str,
    inputs: Sequence[int] | None = None,
    output: int = 0,
    point: Sequence[float] | None = None,
) -> dict[str, Any]:
    """The trait ``compared``: another system's variables, and its surface where it has the same axes (else None).

    Args:
        fis: The other system.
        name: Its name on the page.
        inputs: The inputs of the surface's axes, by number.
        output: The surface's output, by number.
        point: The point (inputs,) at which the other inputs are held.
    """
    return {
        "name": name,
        "inputs": [variable_data(v) for v in fis.inputs],
        "outputs": [variable_data(v) for v in fis.outputs],
        "surface": or_none(surface_data, fis, inputs, output, point),
    }


def or_none(view: Callable[..., dict[str, Any]], *args: Any, **more: Any) -> dict[str, Any] | None:
    """What a view shows of its arguments; None for a system that shows nothing there."""
    try:
        return view(*args, **more)
    except InputError:
        return None


def _number(value: float) -> float | None:
    return float(value) if math.isfinite(value) else None


def _numbers(values: Any) -> list[float | None]:
    return [_number(value) for value in values]


def numbers(values: np.ndarray) -> list[Any]:
    """An array of one or two dimensions as lists, None where there is no finite number."""
    if np.isfinite(values).all():
        return values.tolist()
    return [_numbers(row) for row in values] if values.ndim > 1 else _numbers(values)
