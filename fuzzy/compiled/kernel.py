"""The inference of :mod:`fuzzy.inference` for many points, as loops that Numba compiles.

Work goes row by row: a row holds one quantity (an input, a term's degree, a rule's strength) of every point of
a block, its lanes. The loops over lanes have no branches and call no library function, so that the compiler
makes vector instructions of them and a block stays in the cache. No operation mixes lanes and none is
reordered (no fast-math): the result of a point has the same bits in any batch, and those of
:func:`fuzzy.compiled.packed.evaluate_packed`, which evaluates what does not fill a block. Without Numba
(``NUMBA_DISABLE_JIT=1``) the same code runs as Python, slowly.
"""

from typing import Any

import numpy as np

from fuzzy.compiled.degrees import exp_nonpositive, fill_degrees, minimum, sampled
from fuzzy.compiled.jit import compiled_only, kernel
from fuzzy.compiled.packed import NEVER, PackedColumns, clipped, evaluate_packed, whole, without_refcounts
from fuzzy.compiled.tables import KIND
from fuzzy.compiled.vectors import wide_vectors

LANES = 64  # points a block: enough to outweigh the loops' starts, few enough for the rows to stay in the first cache
FOUR = np.uint64(4)
FEW_POINTS = np.uint64(12)  # fewer points than this are evaluated one by one


@without_refcounts
def _memberships(system: np.ndarray, rows: np.ndarray, degrees: Any, unknown: Any) -> None:
    """Layer 1: degrees of membership, or their logarithms; row ``unknown`` ← not-a-number where an input or one is."""
    wide_vectors()
    header = PackedColumns(system)
    logs = header.logs != 0.0
    for p in range(LANES):
        rows[unknown, p] = 0.0
    for i in range(whole(header.inputs)):
        for p in range(LANES):
            rows[unknown, p] += 0.0 if rows[i, p] == rows[i, p] else np.nan
    begin = np.uint64(0)
    inputs, kinds, ends = whole(header.segment_input), whole(header.segment_kind), whole(header.segment_end)
    a, b, c, d = whole(header.a), whole(header.b), whole(header.c), whole(header.d)
    for s in range(whole(header.segments)):
        kind, i, end = np.int64(system[kinds + s]), whole(system[inputs + s]), whole(system[ends + s])
        for t in range(begin, end):
            row = degrees + t
            if kind == KIND.Sampled:
                values = system[whole(header.samples + system[a + t]) :]
                for p in range(LANES):
                    rows[row, p] = sampled(rows[i, p], values, system[b + t], system[c + t])
            else:
                fill_degrees(
                    kind, system[a + t], system[b + t], system[c + t], system[d + t], rows[i], rows[row], LANES
                )
            if kind >= KIND.Gaussian and not logs:
                for p in range(LANES):
                    rows[row, p] = exp_nonpositive(rows[row, p])
            for p in range(LANES):
                rows[unknown, p] += 0.0 if rows[row, p] == rows[row, p] else np.nan
                rows[row, p] = clipped(rows[row, p])
        begin = end


@compiled_only(forceinline=True)
def _clause(rows: np.ndarray, degree: Any, power: float, negated: bool, result: Any) -> None:
    """Row ``result`` ← the row ``degree`` after hedge and "not"."""
    wide_vectors()
    if power == 1.0:
        for p in range(LANES):
            rows[result, p] = rows[degree, p]
    elif power == 2.0:
        for p in range(LANES):
            rows[result, p] = rows[degree, p] * rows[degree, p]
    elif power == 0.5:
        for p in range(LANES):
            rows[result, p] = np.sqrt(rows[degree, p])
    else:
        for p in range(LANES):
            rows[result, p] = rows[degree, p] ** power
    if negated:
        for p in range(LANES):
            rows[result, p] = 1.0 - rows[result, p]


@compiled_only(forceinline=True)
def _firing(system: np.ndarray, rows: np.ndarray, degrees: Any, firing: Any, rules: Any, clause: Any) -> None:
    """Layer 2 from degrees."""
    wide_vectors()
    header = PackedColumns(system)
    ends, is_or, weight = whole(header.rule_end), whole(header.is_or), whole(header.weight)
    term, power, negated = whole(header.clause_term), whole(header.clause_power), whole(header.clause_negated)
    and_min, or_max = header.and_min != 0.0, header.or_max != 0.0
    begin = np.uint64(0)
    for r in range(rules):
        w, end = firing + r, whole(system[ends + r])
        either = system[is_or + r] != 0.0
        for p in range(LANES):
            rows[w, p] = 0.0 if either else 1.0
        for k in range(begin, end):
            degree = degrees + whole(system[term + k])
            _clause(rows, degree, system[power + k], system[negated + k] != 0.0, clause)
            if either and or_max:
                for p in range(LANES):
                    rows[w, p] = rows[clause, p] if rows[clause, p] > rows[w, p] else rows[w, p]
            elif either:
                for p in range(LANES):
                    rows[w, p] = rows[w, p] + rows[clause, p] - rows[w, p] * rows[clause, p]
            elif and_min:
                for p in range(LANES):
                    rows[w, p] = minimum(rows[w, p], rows[clause, p])
            else:
                for p in range(LANES):
                    rows[w, p] *= rows[clause, p]
        for p in range(LANES):
            rows[w, p] *= system[weight + r]
            rows[w + rules, p] = rows[w, p]
        begin = end


@compiled_only(forceinline=True)
def _log_firing(
    system: np.ndarray, rows: np.ndarray, degrees: Any, firing: Any, rules: Any, top: Any, zero: Any
) -> None:
    """Layer 2 from logarithms; the weights ← the strengths over the greatest one, as a softmax has them."""
    wide_vectors()
    header = PackedColumns(system)
    ends, weight = whole(header.rule_end), whole(header.weight)
    term, power = whole(header.clause_term), whole(header.clause_power)
    begin = np.uint64(0)
    for p in range(LANES):
        rows[top, p] = -np.inf
    for r in range(rules):
        w, end = firing + r, whole(system[ends + r])
        sum_ = zero
        for k in range(begin, end, FOUR):
            k1, k2, k3 = k + np.uint64(1), k + np.uint64(2), k + np.uint64(3)
            d0 = degrees + whole(system[term + k])
            d1 = degrees + whole(system[term + k1]) if k1 < end else zero
            d2 = degrees + whole(system[term + k2]) if k2 < end else zero
            d3 = degrees + whole(system[term + k3]) if k3 < end else zero
            e0, e1 = system[power + k], system[power + k1] if k1 < end else 0.0
            e2, e3 = system[power + k2] if k2 < end else 0.0, system[power + k3] if k3 < end else 0.0
            for p in range(LANES):
                rows[w, p] = rows[sum_, p] + rows[d0, p] * e0 + rows[d1, p] * e1 + rows[d2, p] * e2 + rows[d3, p] * e3
            sum_ = w
        if system[weight + r] > 0.0:
            for p in range(LANES):
                rows[top, p] = rows[w, p] if rows[w, p] > rows[top, p] else rows[top, p]
        begin = end
    for p in range(LANES):
        rows[top, p] = rows[top, p] if rows[top, p] > NEVER / 1e6 else 0.0
    for r in range(rules):
        w, factor = firing + r, system[weight + r]
        for p in range(LANES):
            log = rows[w, p] - rows[top, p]
            log = 0.0 if log > 0.0 else log  # a rule without weight is no part of the greatest strength
            rows[w + rules, p] = exp_nonpositive(log) * factor
        if header.weighted_sum != 0.0:
            for p in range(LANES):
                rows[w, p] = exp_nonpositive(rows[w, p]) * factor


@without_refcounts
def _weights(system: np.ndarray, rows: np.ndarray, degrees: Any, firing: Any, rules: Any, row: Any) -> None:
    """Layers 2 and 3: firing strengths, and their shares w / Σ w, 0 where nothing fires."""
    wide_vectors()
    header = PackedColumns(system)
    if header.logs != 0.0:
        _log_firing(system, rows, degrees, firing, rules, row, row + np.uint64(3))
        return
    _firing(system, rows, degrees, firing, rules, row)
    weights = firing + rules
    for p in range(LANES):
        rows[row, p] = 0.0
    for r in range(rules):
        for p in range(LANES):
            rows[row, p] += rows[weights + r, p]
    for p in range(LANES):
        rows[row, p] = 1.0 if rows[row, p] == 0.0 else rows[row, p]
    for r in range(rules):
        for p in range(LANES):
            rows[weights + r, p] /= rows[row, p]


@without_refcounts
def _defuzzify(system: np.ndarray, rows: np.ndarray, firing: Any, o: Any, rules: Any, total: Any) -> None:
    """Layers 4 and 5 of output ``o`` into row ``total + 2``; ``total`` ← the sum of the weights with a say in it."""
    wide_vectors()
    header = PackedColumns(system)
    place, inputs = o * rules, whole(header.inputs)
    takes_part, constant = whole(header.takes_part) + place, whole(header.constant) + place
    linear = system[whole(header.linear) + o] != 0.0
    weighted_sum = header.weighted_sum != 0.0
    weights = firing + rules
    share = firing if weighted_sum else weights
    proposal, output, zero = total + np.uint64(1), total + np.uint64(2), total + np.uint64(3)
    everyone = header.logs == 0.0
    for p in range(LANES):
        rows[total, p] = 0.0
        rows[output, p] = 0.0
    for r in range(rules):
        if system[takes_part + r] == 0.0:
            everyone = False
            continue
        start, slopes = system[constant + r], whole(header.slopes) + (place + r) * inputs
        if not linear:
            for p in range(LANES):
                rows[proposal, p] = start
        else:
            sum_ = zero
            for i in range(np.uint64(0), inputs, FOUR):
                i1, i2, i3 = i + np.uint64(1), i + np.uint64(2), i + np.uint64(3)
                x1, x2, x3 = i1 if i1 < inputs else zero, i2 if i2 < inputs else zero, i3 if i3 < inputs else zero
                s0, s1 = system[slopes + i], system[slopes + i1] if i1 < inputs else 0.0
                s2, s3 = system[slopes + i2] if i2 < inputs else 0.0, system[slopes + i3] if i3 < inputs else 0.0
                for p in range(LANES):
                    value = rows[sum_, p] + start
                    rows[proposal, p] = value + s0 * rows[i, p] + s1 * rows[x1, p] + s2 * rows[x2, p] + s3 * rows[x3, p]
                sum_, start = proposal, 0.0
        for p in range(LANES):
            rows[total, p] += rows[weights + r, p]
            rows[output, p] += rows[share + r, p] * rows[proposal, p]
    if not weighted_sum and not everyone:
        for p in range(LANES):
            rows[output, p] /= rows[total, p] if rows[total, p] > 0.0 else 1.0


@compiled_only(forceinline=True)
def _evaluate_block(
    system: np.ndarray, rows: np.ndarray, output: np.ndarray, start: int, count: int, missing: np.ndarray
) -> None:
    """Write the outputs of the points ``start`` to ``start + count``, whose inputs are the first of ``rows``."""
    wide_vectors()
    header = PackedColumns(system)
    rules = whole(header.rules)
    degrees = whole(header.inputs)
    firing = degrees + whole(header.terms)
    unknown = firing + rules + rules
    total = unknown + np.uint64(1)
    values = total + np.uint64(2)
    _memberships(system, rows, degrees, unknown)
    _weights(system, rows, degrees, firing, rules, total)
    for o in range(whole(header.outputs)):
        _defuzzify(system, rows, firing, o, rules, total)
        default = system[whole(header.default) + o]
        none = 0
        for p in range(LANES):
            none |= rows[total, p] + rows[unknown, p] <= 0.0
        for p in range(LANES):
            value = rows[values, p] if rows[total, p] > 0.0 else default
            rows[values, p] = value if rows[unknown, p] == rows[unknown, p] else np.nan
        missing[o] |= none != 0
        for p in range(count):
            output[start + p, o] = rows[values, p]


@kernel(nogil=True)
def evaluate_batch(
    system: np.ndarray, x: np.ndarray, output: np.ndarray, outside: np.ndarray, missing: np.ndarray
) -> bool:
    """Evaluate n points; return whether anything is written in ``outside`` or ``missing``.

    A block that is not full is filled up with its last point, or evaluated point by point.

    Args:
        system: The system, see :func:`fuzzy.compiled.packed.packed`.
        x: The points (n, inputs), each number in the unit of its variable.
        output: Where the outputs (n, outputs) are written.
        outside: Where is written (inputs,) whether any point leaves the universe of that input and is not clipped.
        missing: Where is written (outputs,) whether no rule fires for that output at any of the points.
    """
    wide_vectors()
    header = PackedColumns(system)
    n, inputs = x.shape
    clip = header.clip != 0.0
    outside[:] = False
    missing[:] = False
    count = inputs + int(header.terms) + 2 * int(header.rules) + 5
    memory = np.empty(count * LANES + 8)
    first = (-memory.ctypes.data // 8) % 8  # a vector that straddles two lines of the cache takes twice the time
    rows = memory[first : first + count * LANES].reshape(count, LANES)
    rows[-1] = 0.0
    start, end = np.uint64(0), np.uint64(n)
    while start < end:
        count = min(np.uint64(LANES), end - start)
        if count < FEW_POINTS:
            told = 0
            for p in range(start, end):
                told |= evaluate_packed(system, x[p], output[p], memory)
            if told == 0:
                break
        for i in range(np.uint64(inputs)):
            for p in range(count):
                rows[i, p] = x[start + p, i]
            for p in range(count, np.uint64(LANES)):
                rows[i, p] = rows[i, count - np.uint64(1)]
            low, high = system[whole(header.low) + i], system[whole(header.high) + i]
            beyond = 0
            for p in range(LANES):
                beyond |= (rows[i, p] < low) | (rows[i, p] > high)
            if beyond and clip:
                for p in range(LANES):
                    rows[i, p] = low if rows[i, p] < low else (high if rows[i, p] > high else rows[i, p])
            outside[i] |= beyond != 0 and not clip
        _evaluate_block(system, rows, output, start, count, missing)
        start += count
    return bool(outside.any() or missing.any())
