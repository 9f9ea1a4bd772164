"""Interval arithmetic and the interval extension of a rule base, in compiled code.

An interval is two numbers, low and high. Every operation rounds outwards by one unit in the last place, and so does
each call of the mathematics library by four (glibc and macOS state less than one for those that are used).

The rule base is that of a packed row (:mod:`fuzzy.compiled.packed`): all thirteen membership functions, hedges, "not",
weights, both "and", both "or", constant and linear consequents, weighted average and weighted sum. The mean of
intervals is as sharp as they are [Karnik & Mendel 2001]: with w_r between its bounds, Σ w_r y_r / Σ w_r is greatest
where w_r is its upper bound for y_r above that maximum, and its lower bound for those below. Slopes that
rules share are taken out of that mean first: Σ w̄_r (a_r·x + b_r) = a·x + Σ w̄_r ((a_r − a)·x + b_r), since Σ w̄_r = 1.
"""

import math

import numpy as np

from fuzzy.compiled.jit import compiled_only, kernel
from fuzzy.compiled.packed import PackedColumns, whole
from fuzzy.compiled.tables import KIND

_ULP, _TINY = 2.3e-16, 1e-300  # more than a unit in the last place, and than the least normal number
_LIBRARY = 1e-15  # four units in the last place
_COMPUTED = 1e-12  # relative: more than the rounding of an inference
_ROUNDS = 8  # of the iteration for the weighted mean; it is checked, and falls back to the consequents' hull
# The compiled degrees are within 1e-13 of the formulas (tests/fuzzy/compiled), for terms no steeper than their universe
_DEGREE = 1e-12


@compiled_only(forceinline=True)
def down(x):  # type: ignore[no-untyped-def]
    """A number below the real number whose rounded value is ``x``."""
    return x - (abs(x) * _ULP + _TINY)


@compiled_only(forceinline=True)
def up(x):  # type: ignore[no-untyped-def]
    """A number above it."""
    return x + (abs(x) * _ULP + _TINY)


@compiled_only(forceinline=True)
def add(a, b):  # type: ignore[no-untyped-def]
    """The sum."""
    return down(a[0] + b[0]), up(a[1] + b[1])


@compiled_only(forceinline=True)
def sub(a, b):  # type: ignore[no-untyped-def]
    """The difference."""
    return down(a[0] - b[1]), up(a[1] - b[0])


@compiled_only(forceinline=True)
def mul(a, b):  # type: ignore[no-untyped-def]
    """The product."""
    p, q, r, s = a[0] * b[0], a[0] * b[1], a[1] * b[0], a[1] * b[1]
    return down(min(min(p, q), min(r, s))), up(max(max(p, q), max(r, s)))


@compiled_only(forceinline=True)
def scale(k, a):  # type: ignore[no-untyped-def]
    """A number times an interval."""
    return (down(k * a[0]), up(k * a[1])) if k >= 0 else (down(k * a[1]), up(k * a[0]))


@compiled_only(forceinline=True)
def square(a):  # type: ignore[no-untyped-def]
    """The square."""
    p, q = a[0] * a[0], a[1] * a[1]
    return (0.0 if a[0] <= 0.0 <= a[1] else down(min(p, q))), up(max(p, q))


@compiled_only(forceinline=True)
def hull(a, b):  # type: ignore[no-untyped-def]
    """The least interval that holds both."""
    return min(a[0], b[0]), max(a[1], b[1])


@compiled_only(forceinline=True)
def wider(a, by):  # type: ignore[no-untyped-def]
    """An interval wider by a number on both sides."""
    return down(a[0] - by), up(a[1] + by)


@compiled_only
def cosine(a):  # type: ignore[no-untyped-def]
    """The cosine of angles [rad] in −4π to 4π."""
    if a[1] - a[0] > 6.28:
        return -1.0, 1.0
    p, q = math.cos(a[0]), math.cos(a[1])
    low, high = min(p, q) - _LIBRARY, max(p, q) + _LIBRARY
    for n in range(-4, 5):
        at = n * math.pi
        if a[0] - 1e-14 <= at <= a[1] + 1e-14:
            if n % 2 == 0:
                high = 1.0
            else:
                low = -1.0
    return max(low, -1.0), min(high, 1.0)


@compiled_only
def sine(a):  # type: ignore[no-untyped-def]
    """The sine of angles [rad] in −3π to 3π."""
    return cosine((down(a[0] - math.pi / 2), up(a[1] - math.pi / 2)))


# Degrees of membership -----------------------------------------------------------------------------------------


@compiled_only
def _rise(x, a, b):  # type: ignore[no-untyped-def]
    """0 up to a, 1 from b on; a = b is a step that is 1 at the edge."""
    if b > a:
        return min(max((x - a) / (b - a), 0.0), 1.0)
    return 1.0 if x >= b else 0.0


@compiled_only
def _spline(x, a, b):  # type: ignore[no-untyped-def]
    if not b > a:
        return 1.0 if x >= (a + b) / 2 else 0.0
    z = min(max((x - a) / (b - a), 0.0), 1.0)
    return 2 * z * z if z < 0.5 else 1 - 2 * (1 - z) * (1 - z)


@compiled_only
def _sigmoid(x, a, c):  # type: ignore[no-untyped-def]
    z = a * (x - c)
    return 1 / (1 + math.exp(-z)) if z > -700 else math.exp(max(z, -745.0))


@compiled_only
def _bump(x, kind, a, b, c, d):  # type: ignore[no-untyped-def]
    """The degree of a term that rises up to a place and falls from there, or does only one of both."""
    if kind == KIND.Triangle:
        return min(_rise(x, a, b), _rise(-x, -c, -b))
    if kind == KIND.Trapezoid:
        return min(_rise(x, a, b), _rise(-x, -d, -c))
    if kind == KIND.LinearS:
        return _rise(x, a, b)
    if kind == KIND.LinearZ:
        return 1 - _rise(x, a, b)
    if kind == KIND.SShape:
        return _spline(x, a, b)
    if kind == KIND.ZShape:
        return _spline(-x, -b, -a)
    if kind == KIND.Gaussian:
        return math.exp(max(-0.5 * ((x - b) / a) ** 2, -745.0))
    if kind == KIND.TwoSidedGaussian:
        left, right = min(x - b, 0.0) / a, max(x - d, 0.0) / c
        return math.exp(max(-0.5 * left * left, -745.0)) * math.exp(max(-0.5 * right * right, -745.0))
    if kind == KIND.Bell:
        z = abs((x - c) / a)
        if z == 0.0:
            return 1.0 if b > 0 else (0.0 if b < 0 else 0.5)
        power = 2 * b * math.log(z)
        return 1 / (1 + math.exp(power)) if power < 700 else 0.0
    return _sigmoid(x, a, b)  # KIND.Sigmoid


@compiled_only
def _of_two(p, q, product):  # type: ignore[no-untyped-def]
    """The product or the difference of two degrees that lie in intervals."""
    if product:
        return p[0] * q[0], p[1] * q[1]
    return max(p[0] - q[1], 0.0), min(max(p[1] - q[0], 0.0), 1.0)


@compiled_only
def _monotone(f, g):  # type: ignore[no-untyped-def]
    return min(f, g), max(f, g)


@compiled_only
def degree(x, kind, a, b, c, d):  # type: ignore[no-untyped-def]
    """The degrees of a term at the places in ``x``."""
    if kind == KIND.PiShape:
        rising = _monotone(_spline(x[0], a, b), _spline(x[1], a, b))
        falling = _monotone(_spline(-x[0], -d, -c), _spline(-x[1], -d, -c))
        low, high = _of_two(rising, falling, True)
    elif kind == KIND.SigmoidProduct or kind == KIND.SigmoidDifference:
        first = _monotone(_sigmoid(x[0], a, b), _sigmoid(x[1], a, b))
        second = _monotone(_sigmoid(x[0], c, d), _sigmoid(x[1], c, d))
        low, high = _of_two(first, second, kind == KIND.SigmoidProduct)
    else:
        p, q = _bump(x[0], kind, a, b, c, d), _bump(x[1], kind, a, b, c, d)
        low, high = min(p, q), max(p, q)
        # The top, or the bottom, between the ends
        first, last, top = 1.0, 0.0, 1.0
        if kind == KIND.Triangle:
            first, last = b, b
        elif kind == KIND.Trapezoid:
            first, last = b, c
        elif kind == KIND.Gaussian:
            first, last = b, b
        elif kind == KIND.TwoSidedGaussian:
            first, last = min(b, d), max(b, d)
            if b > d and x[1] >= d and x[0] <= b:  # the two halves overlap: both count between
                low = min(low, _least_of_two_sided(x, a, b, c, d))
        elif kind == KIND.Bell:
            first, last = c, c
            top = 1.0 if b > 0 else 0.0 if b < 0 else 0.5
        if first <= last and x[0] <= last and x[1] >= first:
            low, high = min(low, top), max(high, top)
    # Gaussians and bells keep their relative accuracy, which their tails need
    if kind == KIND.Gaussian or kind == KIND.TwoSidedGaussian or kind == KIND.Bell or kind == KIND.Sigmoid:
        return max(low * (1 - _DEGREE) - _TINY, 0.0), min(high * (1 + _DEGREE) + _TINY, 1.0)
    return (max(low - _DEGREE, 0.0) if low < 1.0 else 1.0), (min(high + _DEGREE, 1.0) if high > 0.0 else 0.0)


@compiled_only
def _least_of_two_sided(x, a, b, c, d):  # type: ignore[no-untyped-def]
    """A lower bound of a two-sided Gaussian with c1 > c2 over ``x``: each side at its worst end."""
    left, right = min(x[0] - b, 0.0) / a, max(x[1] - d, 0.0) / c
    return math.exp(max(-0.5 * (left * left + right * right), -745.0))


@compiled_only(forceinline=True)
def _hedged(w, power, negated):  # type: ignore[no-untyped-def]
    if power == 2.0:
        w = down(w[0] * w[0]), up(w[1] * w[1])
    elif power != 1.0:
        w = w[0] ** power * (1 - _LIBRARY), w[1] ** power * (1 + _LIBRARY)
    if negated:
        w = down(1 - w[1]), up(1 - w[0])
    return max(w[0], 0.0), min(w[1], 1.0)


# Inference -----------------------------------------------------------------------------------------------------


@kernel(nogil=True)
def work_size(system):  # type: ignore[no-untyped-def]
    """How many numbers :func:`rule_base_range` works in."""
    header = PackedColumns(system)
    return int(2 * header.terms + 4 * header.rules + 2 * header.inputs)


@compiled_only
def rule_base_range(system, x, out, work):  # type: ignore[no-untyped-def]
    """Enclose the outputs of a rule base over a box of inputs; return 1 where no rule may fire, or 0.

    Args:
        system: The packed rule base.
        x: The box (2, inputs): the lower ends, and the upper ones.
        out: Where the enclosures (2, outputs) are written.
        work: ``work_size(system)`` numbers.
    """
    header = PackedColumns(system)
    inputs, outputs, rules = int(header.inputs), int(header.outputs), int(header.rules)
    terms, low, high = int(header.terms), whole(header.low), whole(header.high)
    at, to, weak = 2 * inputs, 2 * inputs + terms, 2 * inputs + 2 * terms
    strong, lows, highs = weak + rules, weak + 2 * rules, weak + 3 * rules
    for i in range(inputs):
        p, q = x[0, i], x[1, i]
        if header.clip != 0.0:
            p = min(max(p, system[low + i]), system[high + i])
            q = min(max(q, system[low + i]), system[high + i])
        work[i], work[inputs + i] = p, q
    begin = 0
    for s in range(int(header.segments)):
        i = int(system[whole(header.segment_input) + s])
        kind, end = int(system[whole(header.segment_kind) + s]), int(system[whole(header.segment_end) + s])
        for t in range(begin, end):
            work[at + t], work[to + t] = degree(
                (work[i], work[inputs + i]), kind, system[whole(header.a) + t], system[whole(header.b) + t],
                system[whole(header.c) + t], system[whole(header.d) + t],
            )  # fmt: skip
        begin = end
    begin = 0
    for r in range(rules):
        end, either = int(system[whole(header.rule_end) + r]), system[whole(header.is_or) + r] != 0.0
        w = (0.0, 0.0) if either else (1.0, 1.0)
        for k in range(begin, end):
            t = int(system[whole(header.clause_term) + k])
            m = _hedged(
                (work[at + t], work[to + t]), system[whole(header.clause_power) + k],
                system[whole(header.clause_negated) + k] != 0.0,
            )  # fmt: skip
            if either and header.or_max != 0.0:
                w = max(w[0], m[0]), max(w[1], m[1])
            elif either:
                w = down(w[0] + m[0] - w[0] * m[0]), up(w[1] + m[1] - w[1] * m[1])
                w = max(w[0] - 1e-15, 0.0), w[1] + 1e-15
            elif header.and_min != 0.0:
                w = min(w[0], m[0]), min(w[1], m[1])
            else:
                w = down(w[0] * m[0]), up(w[1] * m[1])
        weight = system[whole(header.weight) + r]
        work[weak + r], work[strong + r] = max(down(w[0] * weight), 0.0), up(w[1] * weight) if w[1] > 0 else 0.0
        if work[strong + r] < 1e-290:
            work[strong + r] = 0.0 if w[1] == 0.0 else 1e-290
        begin = end
    hole = 0
    for o in range(outputs):
        hole |= _defuzzified(system, o, inputs, rules, work, weak, strong, lows, highs, out)
    return hole


@compiled_only
def _defuzzified(system, o, inputs, rules, work, weak, strong, lows, highs, out):  # type: ignore[no-untyped-def]
    header = PackedColumns(system)
    part, constant = whole(header.takes_part) + o * rules, whole(header.constant) + o * rules
    slopes = whole(header.slopes) + o * rules * inputs
    linear, total_low, total_high = system[whole(header.linear) + o] != 0.0, 0.0, 0.0
    best, most = -1, -1.0
    for r in range(rules):
        if system[part + r] != 0.0:
            total_low, total_high = down(total_low + work[weak + r]), up(total_high + work[strong + r])
            if work[weak + r] + work[strong + r] > most:
                best, most = r, work[weak + r] + work[strong + r]
    total_low = max(total_low, 0.0)
    midrange = system[whole(header.default) + o]
    if not total_high > 1e-289:
        out[0, o], out[1, o] = midrange, midrange
        return 1
    summed = header.weighted_sum != 0.0
    common = (0.0, 0.0)
    for r in range(rules):
        y = (system[constant + r], system[constant + r])
        if linear and system[part + r] != 0.0:
            for i in range(inputs):
                slope = system[slopes + r * inputs + i]
                base = 0.0 if summed else system[slopes + best * inputs + i]
                if slope != base:
                    y = add(y, mul((down(slope - base), up(slope - base)), (work[i], work[inputs + i])))
        work[lows + r], work[highs + r] = y
    if linear and not summed:
        for i in range(inputs):
            common = add(common, scale(system[slopes + best * inputs + i], (work[i], work[inputs + i])))
    if summed:
        found = (0.0, 0.0)
        for r in range(rules):
            if system[part + r] != 0.0:
                found = add(found, mul((work[weak + r], work[strong + r]), (work[lows + r], work[highs + r])))
        out[0, o], out[1, o] = found
        return 0 if total_low > 0.0 else 1
    above = greatest(system, part, rules, work, weak, strong, highs, 1.0)
    below = -greatest(system, part, rules, work, weak, strong, lows, -1.0)
    found = add((below, above), common)
    # What is computed of the exact mean differs from it by some rounding
    most = _COMPUTED * (max(abs(below), abs(above)) + max(abs(common[0]), abs(common[1])))
    found = down(found[0] - most), up(found[1] + most)
    if total_low > 0.0:
        out[0, o], out[1, o] = found
        return 0
    out[0, o], out[1, o] = min(found[0], midrange), max(found[1], midrange)
    return 1


@compiled_only
def greatest(system, part, rules, work, weak, strong, y, sign):  # type: ignore[no-untyped-def]
    """An upper bound of the weighted mean of sign · y over all weights between their bounds."""
    top, bottom, mean, total = -math.inf, math.inf, 0.0, 0.0
    for r in range(rules):
        if system[part + r] != 0.0 and work[strong + r] > 0.0:
            value = sign * work[y + r]
            top, bottom = max(top, value), min(bottom, value)
            mean, total = mean + work[strong + r] * value, total + work[strong + r]
    bound = mean / total if total > 0.0 else top
    for _ in range(_ROUNDS):
        above, weight = 0.0, 0.0
        for r in range(rules):
            if system[part + r] != 0.0 and work[strong + r] > 0.0:
                value = sign * work[y + r]
                w = work[strong + r] if value > bound else work[weak + r]
                above, weight = above + w * value, weight + w
        better = above / weight if weight > 0.0 else top
        if not better > bound:
            break
        bound = better
    bound += 1e-13 * (top - bottom) + 1e-15 * abs(bound)
    excess = 0.0
    for r in range(rules):
        if system[part + r] != 0.0 and work[strong + r] > 0.0:
            over = sign * work[y + r] - bound
            excess = up(excess + up(up(over) * (work[strong + r] if over > 0 else work[weak + r])))
    return min(bound, top) if excess <= 0.0 else top


@kernel(nogil=True)
def ranges(system, boxes, out):  # type: ignore[no-untyped-def]
    """Enclose a rule base over boxes (n, 2, inputs), in ``out`` (n, 2, outputs); returns where no rule may fire."""
    work, holes = np.empty(work_size(system)), np.zeros(len(boxes), dtype=np.bool_)
    for n in range(len(boxes)):
        holes[n] = rule_base_range(system, boxes[n], out[n], work) != 0
    return holes
