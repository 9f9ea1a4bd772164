"""A tree of systems or an interval type-2 system in one row of numbers, evaluated at one point for compiled callers.

The row begins with the header of a packed system that tells the inputs, the outputs, the universes and how many numbers
:func:`fuzzy.compiled.packed.packed_work` says, and has no rules; then what it is made of, and the packed systems.
"""

from collections.abc import Sequence
from typing import Any

import numpy as np

from fuzzy.compiled.columns import column
from fuzzy.compiled.jit import compiled_only, without_refcounts
from fuzzy.compiled.packed import NO_RULE, OUTSIDE, PackedColumns, _hedged, _memberships, evaluate_packed, whole
from fuzzy.compiled.tables import LEAST_STRENGTH


class CompositeColumns(PackedColumns):
    """The header of a packed system, and what a tree or a type-2 system is made of, and where in the row it stands."""

    systems = column("1", "of a tree")
    type2 = column("", "1: it is a type-2 system")
    nietan = column("", "1: that is its type reduction")
    most = column("1", "inputs of a system")
    begins = column("", "(systems,): where each packed one begins")
    wires = column("", "(inputs of all systems,): the columns that they take, of the inputs and then of all outputs")
    answers = column("", "(outputs,): the columns that are the answer")
    lower = column("", "(5, terms): the lower degrees of type-2")


def composite_row(
    fis: Any,
    systems: Sequence[np.ndarray],
    room: int,
    *,
    wires: Any = (),
    answers: Any = (),
    lower: np.ndarray | None = None,
    nietan: bool = False,
) -> np.ndarray:
    """Lay a tree or a type-2 system out in one row.

    Args:
        fis: It.
        systems: Its packed systems in the order of evaluation; of type-2 the one whose rules stand there twice.
        room: How many numbers it is evaluated in, beside those of the point.
        wires: Of a tree, see :class:`CompositeColumns`.
        answers: Likewise.
        lower: Of a type-2 system, likewise.
        nietan: Likewise.
    """
    lists = {
        "low": [v.universe[0] for v in fis.inputs],
        "high": [v.universe[1] for v in fis.inputs],
        "begins": np.zeros(len(systems)),
        "wires": wires,
        "answers": answers,
        "lower": () if lower is None else lower.ravel(),
    }
    rows = {name: np.asarray(values, dtype=float) for name, values in lists.items()}
    ends = np.cumsum([CompositeColumns.size, *map(len, rows.values()), *map(len, systems)])
    rows["begins"][:] = ends[len(rows) : -1]
    header = dict.fromkeys(CompositeColumns.columns, 0) | {
        "inputs": len(fis.inputs),
        "outputs": len(fis.outputs),
        "terms": room,
        "systems": len(systems),
        "type2": lower is not None,
        "nietan": nietan,
        "most": max(int(PackedColumns(row).inputs) for row in systems),
    }
    header |= dict(zip(rows, ends.tolist(), strict=False))
    return np.concatenate([np.array(CompositeColumns.stacked(header), dtype=float), *rows.values(), *systems])


@without_refcounts
def evaluate_composite(row: np.ndarray, x: np.ndarray, output: np.ndarray, work: np.ndarray) -> int:
    """Evaluate a tree or a type-2 system at one point, as :func:`fuzzy.compiled.packed.evaluate_packed` does a system.

    Args:
        row: As :func:`composite_row` lays it out.
        x: The point (inputs,), each number in the unit of its variable.
        output: Where the outputs (outputs,) are written.
        work: ``packed_work(row)`` numbers or more, of one thread.

    Returns:
        As evaluate_packed, of any of a tree's systems.
    """
    parts = CompositeColumns(row)
    inputs = int(parts.inputs)
    for i in range(inputs):
        work[i] = x[i]
    if parts.type2 == 1:
        return _type2(row, output, work)
    made, wire, told = inputs, int(parts.wires), 0
    for s in range(int(parts.systems)):
        made += int(PackedColumns(row[int(row[int(parts.begins) + s]) :]).outputs)
    asked, rest, made = work[made:], work[made + int(parts.most) :], inputs
    for s in range(int(parts.systems)):
        system = row[int(row[int(parts.begins) + s]) :]
        header = PackedColumns(system)
        for i in range(int(header.inputs)):
            asked[i] = work[int(row[wire + i])]
        told |= evaluate_packed(system, asked, work[made:], rest)
        made, wire = made + int(header.outputs), wire + int(header.inputs)
    for o in range(int(parts.outputs)):
        output[o] = work[int(row[int(parts.answers) + o])]
    return told


@compiled_only
def _type2(row: np.ndarray, output: np.ndarray, work: np.ndarray) -> int:
    """Evaluate a type-2 system at the point at the beginning of ``work``."""
    parts = CompositeColumns(row)
    system = row[int(row[int(parts.begins)]) :]
    header = PackedColumns(system)
    inputs, terms, outputs, told = int(header.inputs), int(header.terms), int(header.outputs), 0
    for i in range(inputs):
        low, high = system[whole(header.low) + i], system[whole(header.high) + i]
        if work[i] < low or work[i] > high:
            if header.clip != 0.0:
                work[i] = low if work[i] < low else high
            else:
                told = OUTSIDE
    lower = row[int(parts.lower) : int(parts.lower) + 5 * terms].reshape(5, terms)
    room = inputs + 2 * terms + 3 * int(header.rules)
    answers = work[room : room + 3 * outputs].reshape(outputs, 3)
    marks = work[room + 3 * outputs : room + 4 * outputs + inputs]
    marks[:] = 0.0
    type2_at(system, lower, parts.nietan == 1, answers, marks, work)
    for o in range(outputs):
        output[o] = answers[o, 2]
        told |= NO_RULE if marks[inputs + o] != 0.0 else 0
    return told


@compiled_only
def type2_at(
    system: np.ndarray, lower: np.ndarray, nietan: bool, answers: np.ndarray, told: np.ndarray, work: np.ndarray
) -> None:
    """Evaluate a type-2 system at the point at the beginning of ``work``.

    Args:
        system: Its upper system, whose rules stand there twice: of lower degrees, and of upper ones.
        lower: (5, terms), as of :class:`fuzzy.CompiledType2`.
        nietan: Whether that is the type reduction.
        answers: (outputs, 3), where the ends and the middles are written.
        told: (inputs + outputs,), where is written for which outputs no rule fires.
        work: inputs + 2 terms + 3 rules numbers; the point (inputs,) within the universes, if it is to be.
    """
    header = PackedColumns(system)
    inputs, terms, rules = whole(header.inputs), whole(header.terms), whole(header.rules)
    and_min, or_max = header.and_min != 0.0, header.or_max != 0.0
    unknown = _memberships(system, work, inputs, False)
    for i in range(inputs):
        unknown |= work[i] != work[i]
    begin, number, ends_of = np.uint64(0), whole(header.segment_input), whole(header.segment_end)
    for s in range(whole(header.segments)):
        i, end = whole(system[number + s]), whole(system[ends_of + s])
        for t in range(begin, end):
            side = np.uint64(0) if work[i] < lower[4, t] else np.uint64(2)
            above = work[inputs + t] - lower[side, t]
            work[inputs + terms + t] = above * lower[side + np.uint64(1), t] if above > 0.0 else 0.0
        begin = end
    firing, begin = inputs + terms + terms, np.uint64(0)
    for r in range(rules + rules):
        either, end = system[whole(header.is_or) + r] != 0.0, whole(system[whole(header.rule_end) + r])
        w = 0.0 if either else 1.0
        for k in range(begin, end):
            degree = work[inputs + whole(system[whole(header.clause_term) + k])]
            negated = system[whole(header.clause_negated) + k] != 0.0
            degree = _hedged(degree, system[whole(header.clause_power) + k], negated)
            if either:
                w = max(w, degree) if or_max else w + degree - w * degree
            else:
                w = min(w, degree) if and_min else w * degree
        w *= system[whole(header.weight) + r]
        work[firing + r] = 0.0 if w < LEAST_STRENGTH else w
        begin = end
    proposed = firing + rules + rules
    for o in range(whole(header.outputs)):
        place, a, b, fires = o * rules, 0.0, 0.0, 0.0
        for r in range(rules):
            z, slopes = system[whole(header.constant) + place + r], whole(header.slopes) + (place + r) * inputs
            if system[whole(header.linear) + o] != 0.0:
                for i in range(inputs):
                    z += system[slopes + i] * work[i]
            work[proposed + r] = z
            if system[whole(header.takes_part) + place + r] != 0.0:
                mean = (work[firing + r] + work[firing + rules + r]) / 2.0
                a, b, fires = a + z * mean, b + mean, fires + work[firing + rules + r]
        for end in range(np.uint64(2)):
            best = a / b if b > 0.0 else 0.0
            better = not nietan
            while better:
                sum_, total = 0.0, 0.0
                for r in range(rules):
                    if system[whole(header.takes_part) + place + r] != 0.0:
                        off = work[proposed + r] - best
                        near = off < 0.0 if end == 0 else off > 0.0
                        w = work[firing + (rules if near else np.uint64(0)) + r]
                        sum_, total = sum_ + off * w, total + w
                new = best + (sum_ / total if total > 0.0 else 0.0)
                better = new < best if end == 0 else new > best
                best = new if better else best
            answers[o, end] = np.nan if unknown else best if fires > 0.0 else system[whole(header.default) + o]
        answers[o, 2] = (answers[o, 0] + answers[o, 1]) / 2.0
        if not unknown and not fires > 0.0:
            told[inputs + o] = True
