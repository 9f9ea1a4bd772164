"""An interval type-2 system compiled for speed: the numbers of :func:`fuzzy.infer_type2`, in float64 on the CPU.

As in :mod:`fuzzy.compiled.kernel`, a row holds one quantity of every point of a block. The upper degrees are those of
the type-1 system; the rules stand there twice, first with their least strengths and then with their greatest ones.
"""

from dataclasses import dataclass, field
from typing import Any

import numpy as np

from fuzzy.compiled.composite import composite_row, type2_at
from fuzzy.compiled.jit import compiled_only, kernel
from fuzzy.compiled.kernel import FEW_POINTS, LANES
from fuzzy.compiled.kernel import _firing as _firing_of_block
from fuzzy.compiled.kernel import _memberships as _memberships_of_block
from fuzzy.compiled.packed import PackedColumns, packed, whole
from fuzzy.compiled.tables import LEAST_STRENGTH, NUMBERS
from fuzzy.compiled.vectors import wide_vectors
from fuzzy.inference import check_points, say_no_rule_fires, say_out_of_range
from fuzzy.membershipfunction import as_number
from fuzzy.plugins.type2.system import Type2Sugeno


@dataclass(frozen=True, eq=False)
class CompiledType2:
    """A type-2 system together with its numbers, which :func:`compile_type2` lays out. It is called as the system is.

    Attributes:
        fis: The system that was laid out.
        system: The numbers (n,) of the upper type-1 system, whose rules stand there twice.
        lower: (5, terms): by term in ``system``'s order the lag and scale / (1 − lag) of the left side, those of the
            right side, and the peak.
    """

    fis: Type2Sugeno
    system: np.ndarray
    lower: np.ndarray
    _nietan: bool = field(init=False, repr=False)

    def __post_init__(self) -> None:
        object.__setattr__(self, "_nietan", self.fis.reduction == "nietan")

    def __call__(self, x: Any) -> np.ndarray:
        """Evaluate the outputs (..., outputs) at ``x`` (..., inputs); warns and raises as ``infer_type2`` does."""
        return self._evaluated(x)[..., 2]

    def interval(self, x: Any) -> np.ndarray:
        """The ends (..., outputs, 2) of the type-reduced sets at ``x`` (..., inputs)."""
        return self._evaluated(x)[..., :2]

    @property
    def row(self) -> np.ndarray:
        """All numbers (n,), as :func:`fuzzy.compiled.composite.evaluate_composite` takes them."""
        header, outputs = PackedColumns(self.system), len(self.fis.outputs)
        room = 2 * int(header.terms) + 3 * int(header.rules) + 4 * outputs + len(self.fis.inputs)
        return composite_row(self.fis, [self.system], room, lower=self.lower, nietan=self._nietan)

    def _evaluated(self, x: Any) -> np.ndarray:
        """The ends and the middles (..., outputs, 3)."""
        upper, points = self.fis.upper, np.asarray(x, dtype=np.float64)
        inputs, outputs = len(upper.inputs), len(upper.outputs)
        check_points(self.fis, points)
        answers = np.empty((*points.shape[:-1], outputs, 3))
        told = np.empty(inputs + outputs, dtype=np.bool_)
        rows = np.ascontiguousarray(points.reshape(-1, inputs))
        if _evaluate(self.system, self.lower, self._nietan, rows, answers.reshape(-1, outputs, 3), told):
            if upper.out_of_range in ("warn", "error") and told[:inputs].any():
                say_out_of_range(upper, told[:inputs])
            if told[inputs:].any():
                say_no_rule_fires(upper, told[inputs:])
        return answers


def compile_type2(fis: Type2Sugeno) -> CompiledType2:
    """Lay a type-2 system out for the compiled inference; its first evaluation in an installation compiles for seconds.

    Args:
        fis: The system; parameters that are arrays are read now, and not again later.

    Returns:
        What is called as the system is, with the same numbers, sooner.

    Raises:
        FuzzySystemError: A membership function for which the compiled inference has no branch.
    """
    inputs = fis.upper.inputs
    order = sorted(
        (i, NUMBERS.get(type(f), 0), t) for i, v in enumerate(inputs) for t, f in enumerate(v.terms.values())
    )
    system = packed(fis.upper)
    lower = np.empty((5, len(order)))
    for k, (i, _, t) in enumerate(order):
        each = list(fis.lower[inputs[i].name].values())[t]
        scale, (left, right) = as_number(each.scale), map(as_number, each.lag)
        lower[:, k] = left, scale / (1 - left), right, scale / (1 - right), fis.peaks[i][t]
    return CompiledType2(fis, _twice(system), lower)


def _twice(system: np.ndarray) -> np.ndarray:
    """The numbers of a type-1 system with its rules twice: of lower terms, which stand last, and of upper ones.

    What a rule negates it takes of the others.
    """
    system = system.copy()
    header = PackedColumns(system)
    terms, rules = int(header.terms), int(header.rules)

    def part(name: str, count: int) -> np.ndarray:
        first = int(getattr(header, name))
        return system[first : first + count]

    end = part("rule_end", rules)
    clauses = int(end[-1]) if rules else 0
    negated = part("clause_negated", clauses)
    lists = {
        "rule_end": [end, end + clauses],
        "is_or": [part("is_or", rules)] * 2,
        "weight": [part("weight", rules)] * 2,
        "clause_term": [part("clause_term", clauses) + terms * side for side in (1 - negated, negated)],
        "clause_power": [part("clause_power", clauses)] * 2,
        "clause_negated": [negated] * 2,
    }
    rows = [system]
    for name, row in lists.items():
        setattr(header, name, sum(map(len, rows)))
        rows.append(np.concatenate(row))
    header.logs = 0.0
    return np.concatenate(rows)


@compiled_only
def _lower_degrees(lower: np.ndarray, rows: np.ndarray, degrees: Any, system: np.ndarray) -> None:
    """The rows of the lower degrees, after those of the upper ones."""
    wide_vectors()
    header = PackedColumns(system)
    begin, terms = np.uint64(0), whole(header.terms)
    inputs, ends = whole(header.segment_input), whole(header.segment_end)
    for s in range(whole(header.segments)):
        i, end = whole(system[inputs + s]), whole(system[ends + s])
        for t in range(begin, end):
            left, up, right, down, peak = lower[0, t], lower[1, t], lower[2, t], lower[3, t], lower[4, t]
            for p in range(LANES):
                is_left = rows[i, p] < peak
                above = rows[degrees + t, p] - (left if is_left else right)
                rows[degrees + terms + t, p] = (above if above > 0.0 else 0.0) * (up if is_left else down)
        begin = end


@compiled_only
def _products(system: np.ndarray, rows: np.ndarray, degrees: Any, firing: Any, rules: Any) -> None:
    """Layer 2 of rules that only multiply degrees, in fewer passes."""
    wide_vectors()
    header = PackedColumns(system)
    ends, weights, term, begin = whole(header.rule_end), whole(header.weight), whole(header.clause_term), np.uint64(0)
    for r in range(rules):
        w, end, weight = firing + r, whole(system[ends + r]), system[weights + r]
        degree = degrees + whole(system[term + begin])
        for p in range(LANES):
            rows[w, p] = rows[degree, p] * weight
        for k in range(begin + np.uint64(1), end):
            degree = degrees + whole(system[term + k])
            for p in range(LANES):
                rows[w, p] *= rows[degree, p]
        begin = end


@compiled_only
def _proposals(system: np.ndarray, rows: np.ndarray, o: Any, rules: Any, proposed: Any) -> None:
    """What the rules propose for output ``o``, in rows from ``proposed`` on."""
    wide_vectors()
    header = PackedColumns(system)
    inputs, place = whole(header.inputs), o * rules
    linear = system[whole(header.linear) + o] != 0.0
    for r in range(rules):
        constant = system[whole(header.constant) + place + r]
        for p in range(LANES):
            rows[proposed + r, p] = constant
        if linear:
            slopes = whole(header.slopes) + (place + r) * inputs
            for i in range(inputs):
                for p in range(LANES):
                    rows[proposed + r, p] += system[slopes + i] * rows[i, p]


@compiled_only
def _reduce(
    system: np.ndarray, rows: np.ndarray, firing: Any, o: Any, rules: Any, proposed: Any, at: Any, nietan: bool
) -> None:
    """Rows ``at`` and ``at + 1`` ← the ends of the type-reduced set of output ``o``; ``at + 2`` > 0 where a rule fires.

    The rows of lower strengths begin at ``firing``, those of upper ones ``rules`` further on; four more rows are used.
    """
    wide_vectors()
    low, high, fires = at, at + np.uint64(1), at + np.uint64(2)
    a, b, c, d = at + np.uint64(3), at + np.uint64(4), at + np.uint64(5), at + np.uint64(6)
    takes_part = whole(PackedColumns(system).takes_part) + o * rules
    for p in range(LANES):
        rows[a, p] = rows[b, p] = rows[fires, p] = 0.0
    for r in range(rules):
        if system[takes_part + r] != 0.0:
            for p in range(LANES):
                least, most = rows[firing + r, p], rows[firing + rules + r, p]
                mean = (least + most) / 2.0
                rows[a, p] += rows[proposed + r, p] * mean
                rows[b, p] += mean
                rows[fires, p] += most
    for p in range(LANES):
        rows[low, p] = rows[a, p] / rows[b, p] if rows[b, p] > 0.0 else 0.0
        rows[high, p] = rows[low, p]
    better = not nietan
    while better:
        for p in range(LANES):
            rows[a, p] = rows[b, p] = rows[c, p] = rows[d, p] = 0.0
        for r in range(rules):
            if system[takes_part + r] != 0.0:
                for p in range(LANES):
                    z, least, most = rows[proposed + r, p], rows[firing + r, p], rows[firing + rules + r, p]
                    under, over = z - rows[low, p], z - rows[high, p]
                    of_low = most if under < 0.0 else least
                    of_high = most if over > 0.0 else least
                    rows[a, p] += under * of_low
                    rows[b, p] += of_low
                    rows[c, p] += over * of_high
                    rows[d, p] += of_high
        closer = 0
        for p in range(LANES):
            new_low = rows[low, p] + (rows[a, p] / rows[b, p] if rows[b, p] > 0.0 else 0.0)
            new_high = rows[high, p] + (rows[c, p] / rows[d, p] if rows[d, p] > 0.0 else 0.0)
            closer |= (new_low < rows[low, p]) | (new_high > rows[high, p])
            rows[low, p] = new_low if new_low < rows[low, p] else rows[low, p]
            rows[high, p] = new_high if new_high > rows[high, p] else rows[high, p]
        better = closer != 0


@kernel(nogil=True)
def _evaluate(
    system: np.ndarray, lower: np.ndarray, nietan: bool, x: np.ndarray, answers: np.ndarray, told: np.ndarray
) -> bool:
    """Write the ends and the middles (n, outputs, 3) at n points (n, inputs).

    ``told`` (inputs + outputs,) ← which inputs are outside, for which outputs no rule fires; returns whether any is.
    A block that is not full is filled up with its last point, or evaluated point by point.
    """
    wide_vectors()
    header = PackedColumns(system)
    n, inputs = np.uint64(x.shape[0]), np.uint64(x.shape[1])
    rules, terms = whole(header.rules), whole(header.terms)
    firing = inputs + terms + terms
    proposed = firing + rules + rules  # also where _firing_of_block writes the strengths once more
    unknown = proposed + rules + rules
    at = unknown + np.uint64(1)
    fires = at + np.uint64(2)
    clip = header.clip != 0.0
    told[:] = False
    memory = np.empty((at + np.uint64(8)) * np.uint64(LANES) + np.uint64(8))
    first = (-memory.ctypes.data // 8) % 8  # as in fuzzy.compiled.kernel
    rows = memory[first : first + len(memory) - 8].reshape(at + np.uint64(8), LANES)
    start = np.uint64(0)
    while start < n:
        count = min(np.uint64(LANES), n - start)
        for i in range(inputs):
            low, high = system[whole(header.low) + i], system[whole(header.high) + i]
            for p in range(count):
                rows[i, p] = x[start + p, i]
            for p in range(count, np.uint64(LANES)):
                rows[i, p] = rows[i, count - np.uint64(1)]
            beyond = 0
            for p in range(LANES):
                beyond |= (rows[i, p] < low) | (rows[i, p] > high)
            if beyond and clip:
                for p in range(LANES):
                    rows[i, p] = low if rows[i, p] < low else (high if rows[i, p] > high else rows[i, p])
            told[i] |= beyond != 0 and not clip
        if count < FEW_POINTS:
            for p in range(count):
                work = memory[len(memory) // 2 :]
                for i in range(inputs):
                    work[i] = rows[i, p]
                type2_at(system, lower, nietan, answers[start + p], told, work)
            break
        _memberships_of_block(system, rows, inputs, unknown)
        _lower_degrees(lower, rows, inputs, system)
        if header.plain != 0.0 and header.and_min == 0.0:
            _products(system, rows, inputs, firing, rules + rules)
        else:
            _firing_of_block(system, rows, inputs, firing, rules + rules, at)
        for r in range(rules + rules):
            for p in range(LANES):
                rows[firing + r, p] = 0.0 if rows[firing + r, p] < LEAST_STRENGTH else rows[firing + r, p]
        for o in range(whole(header.outputs)):
            _proposals(system, rows, o, rules, proposed)
            _reduce(system, rows, firing, o, rules, proposed, at, nietan)
            default, none = system[whole(header.default) + o], 0
            for p in range(LANES):
                none |= rows[fires, p] + rows[unknown, p] <= 0.0
            told[inputs + o] |= none != 0
            for end in range(np.uint64(2)):
                for p in range(LANES):
                    value = rows[at + end, p] if rows[fires, p] > 0.0 else default
                    rows[at + end, p] = value if rows[unknown, p] == rows[unknown, p] else np.nan
            for p in range(count):
                answers[start + p, o, 0], answers[start + p, o, 1] = rows[at, p], rows[at + np.uint64(1), p]
                answers[start + p, o, 2] = (rows[at, p] + rows[at + np.uint64(1), p]) / 2.0
        start += count
    return bool(told.any())
