"""The inference of :mod:`fuzzy.inference` as loops that Numba compiles: one point, or blocks of points.

Work goes row by row: a row holds one quantity (an input, a term's degree, a rule's strength) of every point of
a block, its lanes. The loops over lanes have no branches and call no library function, so that the compiler
makes vector instructions of them and a block stays in the cache. No operation mixes lanes and none is
reordered (no fast-math): the result of a point has the same bits in any batch. Without Numba
(``NUMBA_DISABLE_JIT=1``) the same code runs as Python, slowly.
"""

import math

import numpy as np

from fuzzy.compiled.jit import kernel
from fuzzy.compiled.tables import (
    BELL,
    GAUSSIAN,
    LINEAR_S,
    LINEAR_Z,
    PI_SHAPE,
    S_SHAPE,
    SIGMOID,
    SIGMOID_DIFFERENCE,
    SIGMOID_PRODUCT,
    TRAPEZOID,
    TRIANGLE,
    TWO_SIDED_GAUSSIAN,
    Z_SHAPE,
    Tables,
    Workspace,
)
from fuzzy.inference import never

NEVER = never(np.float64)
LANES = 256  # points a block: enough to outweigh the calls, few enough for the rows to stay in the second cache

# Without Numba's reference counts (NRT): these functions make no arrays, and counting the users of some thirty
# arrays takes five times as long as the inference of a point.
uncounted = kernel(nogil=True, _nrt=False)
inlined = kernel(nogil=True, _nrt=False, forceinline=True)


@kernel(nogil=True)
def workspace(tables: Tables, lanes: int) -> Workspace:
    """Make the rows for blocks of ``lanes`` points of a system (1 for :func:`evaluate_point`), once for many calls."""
    rules, inputs = tables.clause.shape
    terms, outputs = len(tables.kind), len(tables.default)
    firing, weights = np.empty(rules * lanes), np.empty(rules * lanes)
    scale = np.empty(max(rules, 1) * lanes)
    return Workspace(
        np.empty((inputs, lanes)),
        np.empty((terms, lanes)),
        firing.reshape(rules, lanes),
        weights.reshape(rules, lanes),
        firing,
        weights,
        scale,
        scale.view(np.int64),
        np.empty((2, lanes)),
        np.empty((outputs, lanes)),
        np.empty((outputs, lanes), dtype=np.bool_),
    )


# Exponential and logarithm ------------------------------------------------------------------------------------
# The C library's are calls, one a number; these are loops that become vector instructions.

_LOWEST = -746.0  # e to this rounds to 0
_LOG2_E = 1 / math.log(2)
_LN2_HIGH = float.fromhex("0x1.62e42fefa3800p-1")  # 42 bits, so that k times it is exact
_LN2_LOW = float.fromhex("0x1.ef35793c76730p-45")  # the rest of ln 2
_ROUND = 1.5 * 2.0**52  # added and taken away, it rounds to an integer, which the sum carries in its last bits
_HALF_RANGE = 537  # 2^k as 2^(k + 537) · 2^-537: the first is never subnormal, the second a constant
_E2, _E3, _E4, _E5, _E6, _E7 = (1 / math.factorial(n) for n in range(2, 8))
_E8, _E9, _E10, _E11, _E12, _E13 = (1 / math.factorial(n) for n in range(8, 14))


@inlined
def exp_nonpositive(values: np.ndarray, scale: np.ndarray, bits: np.ndarray) -> None:
    """Replace ``values`` (n,), all ≤ 0, by their exponentials, within one unit in the last place.

    e^v = 2^k e^r with r = v − k ln 2, |r| ≤ ln(2)/2, and e^r by its Taylor series, whose remainder is below
    4e-18. -inf gives 0, not-a-number stays.

    Args:
        values: The exponents (n,), which become the results.
        scale: Memory to work in, (n,) or longer.
        bits: The memory of ``scale`` as int64.
    """
    n = len(values)
    for p in range(n):
        v = values[p]
        scale[p] = (_LOWEST if v < _LOWEST else v) * _LOG2_E + _ROUND
    # The last twelve bits of k + 1023 + 537 are moved to where a float64 has its sign and exponent. This passes
    # through memory because Numba has no reinterpretation of one number, and in a loop of its own because the
    # compiler must not see one memory as two types.
    for p in range(n):
        bits[p] = (bits[p] + (1023 + _HALF_RANGE)) << 52
    for p in range(n):
        v = values[p]
        v = _LOWEST if v < _LOWEST else v
        k = (v * _LOG2_E + _ROUND) - _ROUND
        r = (v - k * _LN2_HIGH) - k * _LN2_LOW
        e = _E8 + r * (_E9 + r * (_E10 + r * (_E11 + r * (_E12 + r * _E13))))
        e = _E2 + r * (_E3 + r * (_E4 + r * (_E5 + r * (_E6 + r * (_E7 + r * e)))))
        values[p] = (1.0 + (r + r * r * e)) * scale[p] * 2.0**-_HALF_RANGE


@uncounted
def log1p_unit(u: float) -> float:
    """Compute log(1 + u) for 0 ≤ u ≤ 1, as 2 artanh(s) with s = u / (2 + u) ≤ 1/3, by its Taylor series."""
    s = u / (2.0 + u)
    q = s * s
    t = 1 / 27 + q * (1 / 29 + q * (1 / 31 + q * (1 / 33 + q * (1 / 35))))
    t = 1 / 15 + q * (1 / 17 + q * (1 / 19 + q * (1 / 21 + q * (1 / 23 + q * (1 / 25 + q * t)))))
    t = 1 / 3 + q * (1 / 5 + q * (1 / 7 + q * (1 / 9 + q * (1 / 11 + q * (1 / 13 + q * t)))))
    return 2.0 * (s + s * q * t)


# Layer 1: degrees of membership -------------------------------------------------------------------------------


@uncounted
def _unit(z: float) -> float:
    return 0.0 if z < 0.0 else (1.0 if z > 1.0 else z)


@uncounted
def _rise(x: float, a: float, b: float) -> float:
    slope = _unit((x - a) / (b - a if b > a else 1.0))
    edge = 1.0 if x >= b else 0.0
    return slope if b > a else edge


@uncounted
def _fall(x: float, c: float, d: float) -> float:
    return _rise(-x, -d, -c)


@uncounted
def _s(x: float, a: float, b: float) -> float:
    z = _unit((x - a) / (b - a if b > a else 1.0))
    spline = 2.0 * (z * z) if z < 0.5 else 1.0 - 2.0 * ((1.0 - z) * (1.0 - z))
    step = 1.0 if x >= (a + b) / 2.0 else 0.0
    return spline if b > a else step


@uncounted
def _minimum(a: float, b: float) -> float:
    return b if b < a else a


@inlined
def _piecewise(
    kind: int, parameters: np.ndarray, t: int, x: np.ndarray, i: int, degree: np.ndarray, lanes: int
) -> None:
    """Row ``t`` of degrees, from row ``i`` of x, of a function made of straight lines and parabolas.

    The degrees of an unknown number ``kind`` are not-a-number.
    """
    a, b, c, d = parameters[t, 0], parameters[t, 1], parameters[t, 2], parameters[t, 3]
    if kind == TRIANGLE:
        for p in range(lanes):
            degree[t, p] = _minimum(_rise(x[i, p], a, b), _fall(x[i, p], b, c))
    elif kind == TRAPEZOID:
        for p in range(lanes):
            degree[t, p] = _minimum(_rise(x[i, p], a, b), _fall(x[i, p], c, d))
    elif kind == LINEAR_S:
        for p in range(lanes):
            degree[t, p] = _rise(x[i, p], a, b)
    elif kind == LINEAR_Z:
        for p in range(lanes):
            degree[t, p] = 1.0 - _rise(x[i, p], a, b)
    elif kind == S_SHAPE:
        for p in range(lanes):
            degree[t, p] = _s(x[i, p], a, b)
    elif kind == Z_SHAPE:
        for p in range(lanes):
            degree[t, p] = _s(-x[i, p], -b, -a)
    elif kind == PI_SHAPE:
        for p in range(lanes):
            degree[t, p] = _s(x[i, p], a, b) * _s(-x[i, p], -d, -c)
    else:
        for p in range(lanes):
            degree[t, p] = math.nan


@uncounted
def _log_sigmoid(x: np.ndarray, a: float, c: float, result: np.ndarray, work: Workspace) -> None:
    """A row of −log(1 + e^-z), z = a (x − c), as −(max(0, −z) + log(1 + e^-|z|)), which does not overflow."""
    for p in range(len(x)):
        result[p] = -abs(a * (x[p] - c))
    exp_nonpositive(result, work.scale, work.bits)
    for p in range(len(x)):
        z = a * (x[p] - c)
        result[p] = -((-z if z < 0.0 else 0.0) + log1p_unit(result[p]))


@uncounted
def _log_bell(x: np.ndarray, a: float, b: float, c: float, result: np.ndarray, work: Workspace) -> None:
    """A row of −log(1 + |z|^2b), z = (x − c)/a, with |z|^2b = exp(2b log |z|) set apart at the center."""
    row = work.row[0]
    center = -math.inf if b > 0.0 else (math.inf if b < 0.0 else 0.0)
    for p in range(len(x)):
        z = abs((x[p] - c) / a)
        row[p] = 2.0 * b * math.log(z) if z > 0.0 else center
        result[p] = -abs(row[p])
    exp_nonpositive(result, work.scale, work.bits)
    for p in range(len(x)):
        result[p] = -((row[p] if row[p] > 0.0 else 0.0) + log1p_unit(result[p]))


@uncounted
def _log_degree(kind: int, parameters: np.ndarray, x: np.ndarray, degree: np.ndarray, work: Workspace) -> None:
    """A row of logarithms of the degrees of a function that is positive everywhere, but not a Gaussian.

    The logarithms of an unknown number ``kind`` are not-a-number.
    """
    a, b, c, d = parameters[0], parameters[1], parameters[2], parameters[3]
    if kind == TWO_SIDED_GAUSSIAN:
        for p in range(len(x)):
            left, right = x[p] - b, x[p] - d
            left = (0.0 if left > 0.0 else left) / a
            right = (0.0 if right < 0.0 else right) / c
            degree[p] = -0.5 * (left * left) + -0.5 * (right * right)
    elif kind == BELL:
        _log_bell(x, a, b, c, degree, work)
    elif kind == SIGMOID:
        _log_sigmoid(x, a, b, degree, work)
    elif kind == SIGMOID_PRODUCT:
        row = work.row[0]
        _log_sigmoid(x, a, b, degree, work)
        _log_sigmoid(x, c, d, row, work)
        for p in range(len(x)):
            degree[p] += row[p]
    else:
        for p in range(len(x)):
            degree[p] = math.nan


@uncounted
def _difference(parameters: np.ndarray, x: np.ndarray, degree: np.ndarray, work: Workspace) -> None:
    """A row of differences of two sigmoids."""
    row = work.row[0]
    _log_sigmoid(x, parameters[0], parameters[1], degree, work)
    _log_sigmoid(x, parameters[2], parameters[3], row, work)
    exp_nonpositive(degree, work.scale, work.bits)
    exp_nonpositive(row, work.scale, work.bits)
    for p in range(len(x)):
        degree[p] = _unit(degree[p] - row[p])


@inlined
def _memberships(tables: Tables, work: Workspace, lanes: int) -> None:
    """Layer 1: degrees of membership, or their logarithms."""
    parameters, x, degree = tables.parameters, work.x, work.degree
    for t in range(len(tables.kind)):
        kind, i = tables.kind[t], tables.place[t]
        if kind == GAUSSIAN:  # by far the most usual in systems that learn
            sigma, center = parameters[t, 0], parameters[t, 1]
            for p in range(lanes):
                z = (x[i, p] - center) / sigma
                degree[t, p] = -0.5 * (z * z)
        elif kind < SIGMOID_DIFFERENCE:
            _piecewise(kind, parameters, t, x, i, degree, lanes)
        elif kind == SIGMOID_DIFFERENCE:
            _difference(parameters[t], x[i], degree[t], work)
        else:
            _log_degree(kind, parameters[t], x[i], degree[t], work)
        if kind >= GAUSSIAN and not tables.logarithmic:
            exp_nonpositive(degree[t], work.scale, work.bits)


# Layers 2 and 3: firing strengths and weights -----------------------------------------------------------------


@inlined
def _clause(degree: np.ndarray, t: int, power: float, negated: bool, result: np.ndarray, lanes: int) -> None:
    """Row 0 of ``result`` ← row ``t`` of degrees after hedge and "not".

    1 − μ has few true digits where μ is close to 1, whose last one is 1e-16. Where all rules that fire do so by such a
    difference, of the sum w, the output is exact to about 1e-16 / w of its range, here as in fuzzy.inference: the two
    agree within 5e-7 of the range in 5,000 random systems.
    """
    if power == 1.0:
        for p in range(lanes):
            result[0, p] = degree[t, p]
    elif power == 2.0:
        for p in range(lanes):
            result[0, p] = degree[t, p] * degree[t, p]
    elif power == 0.5:
        for p in range(lanes):
            result[0, p] = math.sqrt(degree[t, p])
    else:
        for p in range(lanes):
            result[0, p] = degree[t, p] ** power
    if negated:
        for p in range(lanes):
            result[0, p] = 1.0 - result[0, p]


@inlined
def _firing(tables: Tables, work: Workspace, lanes: int) -> None:
    """Layer 2 from degrees."""
    degree, firing, weights, row = work.degree, work.firing, work.weights, work.row
    rules, inputs = tables.clause.shape
    for r in range(rules):
        is_or, weight = tables.is_or[r], tables.weight[r]
        for p in range(lanes):
            firing[r, p] = 0.0 if is_or else 1.0
        for i in range(inputs):
            t = tables.clause[r, i]
            if t < 0:
                continue
            _clause(degree, t, tables.power[r, i], tables.negated[r, i], row, lanes)
            if is_or and tables.or_max:
                for p in range(lanes):
                    firing[r, p] = row[0, p] if row[0, p] > firing[r, p] else firing[r, p]
            elif is_or:
                for p in range(lanes):
                    firing[r, p] = firing[r, p] + row[0, p] - firing[r, p] * row[0, p]
            elif tables.and_min:
                for p in range(lanes):
                    firing[r, p] = _minimum(firing[r, p], row[0, p])
            else:
                for p in range(lanes):
                    firing[r, p] *= row[0, p]
        for p in range(lanes):
            firing[r, p] *= weight
            weights[r, p] = firing[r, p]


@inlined
def _log_firing(tables: Tables, work: Workspace, lanes: int) -> None:
    """Layer 2 from logarithms; ``weights`` ← the strengths over the greatest one, as a softmax has them."""
    clause, power, weight = tables.clause, tables.power, tables.weight
    degree, firing, weights, row = work.degree, work.firing, work.weights, work.row
    rules, inputs = clause.shape
    for t in range(len(degree)):
        for p in range(lanes):
            degree[t, p] = NEVER if degree[t, p] < NEVER else degree[t, p]
    for p in range(lanes):
        row[0, p] = -math.inf
    for r in range(rules):
        for p in range(lanes):
            firing[r, p] = 0.0
        for i in range(inputs):
            t, exponent = clause[r, i], power[r, i]
            if t >= 0:
                for p in range(lanes):
                    firing[r, p] += degree[t, p] * exponent
        if weight[r] > 0.0:
            for p in range(lanes):
                row[0, p] = firing[r, p] if firing[r, p] > row[0, p] else row[0, p]
    for p in range(lanes):
        row[0, p] = row[0, p] if row[0, p] > NEVER / 1e6 else 0.0
    for r in range(rules):
        # A rule without weight is no part of the greatest strength, and might overflow over it.
        reach = 0.0 if weight[r] > 0.0 else -math.inf
        for p in range(lanes):
            weights[r, p] = firing[r, p] - row[0, p] + reach
    exp_nonpositive(work.weights_flat, work.scale, work.bits)
    for r in range(rules):
        for p in range(lanes):
            weights[r, p] *= weight[r]
    if tables.weighted_sum:
        exp_nonpositive(work.firing_flat, work.scale, work.bits)
        for r in range(rules):
            for p in range(lanes):
                firing[r, p] *= weight[r]


# Layers 4 and 5: consequents and their weighted average or sum ------------------------------------------------


@inlined
def _normalise(work: Workspace, lanes: int) -> None:
    """Layer 3: w / Σ w; 0 where nothing fires."""
    weights, row = work.weights, work.row
    rules = len(weights)
    for p in range(lanes):
        row[0, p] = 0.0
    for r in range(rules):
        for p in range(lanes):
            row[0, p] += weights[r, p]
    for p in range(lanes):
        row[0, p] = 1.0 if row[0, p] == 0.0 else row[0, p]
    for r in range(rules):
        for p in range(lanes):
            weights[r, p] /= row[0, p]


@inlined
def _defuzzify(tables: Tables, work: Workspace, o: int, lanes: int) -> None:
    """Layers 4 and 5 of output ``o``; ``work.row[0]`` ← the sum of the weights that have a say in it."""
    slopes, constant, takes_part = tables.slopes, tables.constant, tables.takes_part
    x, weights, output, row = work.x, work.weights, work.output, work.row
    share = work.firing if tables.weighted_sum else weights
    inputs = len(x)
    everyone = True
    for p in range(lanes):
        row[0, p] = 0.0
        output[o, p] = 0.0
    for r in range(len(weights)):
        if not takes_part[o, r]:
            everyone = False
            continue
        for p in range(lanes):
            row[0, p] += weights[r, p]
            row[1, p] = constant[o, r]
        if tables.linear[o]:
            for i in range(inputs):
                slope = slopes[o, r, i]
                for p in range(lanes):
                    row[1, p] += slope * x[i, p]
        for p in range(lanes):
            output[o, p] += share[r, p] * row[1, p]
    if not tables.weighted_sum and not everyone:
        for p in range(lanes):
            output[o, p] /= row[0, p] if row[0, p] > 0.0 else 1.0


@inlined
def _evaluate(tables: Tables, work: Workspace, lanes: int) -> None:
    """``work.output`` and ``work.missing`` from ``work.x``, which has ``lanes`` lanes.

    The number is an argument for the sake of :func:`evaluate_point`: inlined with a 1, its loops vanish.
    """
    x, degree, output, missing, row = work.x, work.degree, work.output, work.missing, work.row
    inputs = len(x)
    outputs = len(output)
    _memberships(tables, work, lanes)
    if tables.logarithmic:
        _log_firing(tables, work, lanes)
    else:
        _firing(tables, work, lanes)
    _normalise(work, lanes)
    for o in range(outputs):
        _defuzzify(tables, work, o, lanes)
        default = tables.default[o]
        for p in range(lanes):
            missing[o, p] = not row[0, p] > 0.0
            output[o, p] = default if missing[o, p] else output[o, p]
    # Not-a-number in an input or a degree (of an unknown function, or of 0 · ∞) makes the sum so. A minimum or "no
    # rule fires" would lose it.
    for p in range(lanes):
        row[1, p] = 0.0
    for i in range(inputs):
        for p in range(lanes):
            row[1, p] += 0.0 if x[i, p] == x[i, p] else math.nan
    for t in range(len(degree)):
        for p in range(lanes):
            row[1, p] += degree[t, p]
    for p in range(lanes):
        if math.isnan(row[1, p]):
            for o in range(outputs):
                output[o, p] = math.nan
                missing[o, p] = False


@uncounted
def evaluate_point(tables: Tables, x: np.ndarray, output: np.ndarray, work: Workspace) -> None:
    """Evaluate one point, for calls from other compiled functions.

    Inputs outside their universe are clipped if the system says so. No warning is given of them, nor of a point where
    no rule fires.

    Args:
        tables: The system, see :func:`fuzzy.compiled.sugeno.compile_sugeno`.
        x: The point (inputs,), each number in the unit of its variable.
        output: Where the outputs (outputs,) are written.
        work: ``workspace(tables, 1)``, made once for each thread.
    """
    for i in range(len(x)):
        value = x[i]
        if tables.clip:
            value = tables.low[i] if value < tables.low[i] else value
            value = tables.high[i] if value > tables.high[i] else value
        work.x[i, 0] = value
    _evaluate(tables, work, 1)
    for o in range(len(output)):
        output[o] = work.output[o, 0]


@kernel(nogil=True)
def evaluate_batch(tables: Tables, x: np.ndarray, output: np.ndarray, outside: np.ndarray, missing: np.ndarray) -> bool:
    """Evaluate n points; return whether no rule fired at one of them, or an input was outside and not clipped.

    The last block is filled up with its last point.

    Args:
        tables: The system, see :func:`fuzzy.compiled.sugeno.compile_sugeno`.
        x: The points (n, inputs), each number in the unit of its variable.
        output: Where the outputs (n, outputs) are written.
        outside: Where is written (inputs,) whether any point leaves the universe of that input.
        missing: Where is written (outputs,) whether no rule fires for that output at any of the points.
    """
    n = len(x)
    lanes = max(1, min(n, LANES))
    work = workspace(tables, lanes)
    outside[:] = False
    missing[:] = False
    for start in range(0, n, lanes):
        count = min(lanes, n - start)
        for i in range(x.shape[1]):
            low, high, row = tables.low[i], tables.high[i], work.x[i]
            for p in range(lanes):
                row[p] = x[start + min(p, count - 1), i]
            beyond = 0
            for p in range(lanes):
                beyond |= (row[p] < low) | (row[p] > high)
            if beyond and tables.clip:
                for p in range(lanes):
                    row[p] = low if row[p] < low else (high if row[p] > high else row[p])
            outside[i] |= beyond != 0
        _evaluate(tables, work, lanes)
        for o in range(output.shape[1]):
            row = work.output[o]
            for p in range(count):
                output[start + p, o] = row[p]
            missing[o] |= work.missing[o].any()
    return bool(missing.any() or (outside.any() and not tables.clip))
