"""How degrees of membership change with the parameters of their functions: rows of partial derivatives.

As in :mod:`fuzzy.compiled.kernel` a row holds a quantity of every sample of a block, its lanes. At a joint, where a
function has a derivative on either side only, the same one is taken as torch takes of :mod:`fuzzy.membership`.
"""

import math

import numpy as np

from fuzzy.compiled.jit import kernel
from fuzzy.compiled.kernel import exp_nonpositive, inlined, uncounted
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
)

_LN2_HIGH = float.fromhex("0x1.62e42fefa3800p-1")  # 42 bits, so that k times it is exact
_LN2_LOW = float.fromhex("0x1.ef35793c76730p-45")  # the rest of ln 2
_MANTISSA = (1 << 52) - 1
_ONE = 1023 << 52  # 1.0 as an integer


@inlined
def log_positive(values: np.ndarray, scale: np.ndarray, bits: np.ndarray) -> None:
    """Replace ``values`` (n,), normal numbers > 0, by their logarithms, within two units in the last place.

    v = 2^k m with m in [√½, √2), and log m = 2 artanh(s), s = (m − 1)/(m + 1), by its Taylor series.

    Args:
        values: The numbers (n,), which become the results.
        scale: Memory to work in, (n,) or longer.
        bits: The memory of ``scale`` as int64.
    """
    n = len(values)
    for p in range(n):
        scale[p] = values[p]
    for p in range(n):
        values[p] = (bits[p] >> 52) - 1023
        bits[p] = (bits[p] & _MANTISSA) | _ONE
    for p in range(n):
        m, k = scale[p], values[p]
        above = m > math.sqrt(2.0)
        m = 0.5 * m if above else m
        k = k + 1.0 if above else k
        s = (m - 1.0) / (m + 1.0)
        q = s * s
        t = 1 / 13 + q * (1 / 15 + q * (1 / 17 + q * (1 / 19 + q * (1 / 21 + q * (1 / 23)))))
        t = 1 / 3 + q * (1 / 5 + q * (1 / 7 + q * (1 / 9 + q * (1 / 11 + q * t))))
        values[p] = k * _LN2_HIGH + (2.0 * s + (2.0 * s * q * t + k * _LN2_LOW))


@uncounted
def _share(first: float, second: float) -> float:
    """Of a minimum, the part of its slope that its first argument has: half where both are equal, as in torch."""
    return 1.0 if first < second else (0.5 if first == second else 0.0)


@uncounted
def _unit(z: float) -> float:
    return 0.0 if z < 0.0 else (1.0 if z > 1.0 else z)


@uncounted
def _ramp(x: float, a: float, b: float) -> tuple[float, float, float]:
    """A straight edge that rises from ``a`` to ``b``: its degree and the derivatives to both."""
    steep = b > a
    width = b - a if steep else 1.0
    z = (x - a) / width
    inside = 1.0 if (steep and z >= 0.0 and z <= 1.0) else 0.0
    step = 1.0 if x >= b else 0.0
    return _unit(z) if steep else step, inside * (z - 1.0) / width, -inside * z / width


@uncounted
def _spline(x: float, a: float, b: float) -> tuple[float, float, float]:
    """A quadratic spline that rises from ``a`` to ``b``: its degree and the derivatives to both."""
    smooth = b > a
    width = b - a if smooth else 1.0
    z = (x - a) / width
    inside = 1.0 if (smooth and z >= 0.0 and z <= 1.0) else 0.0
    z = _unit(z)
    value = 2.0 * (z * z) if z < 0.5 else 1.0 - 2.0 * ((1.0 - z) * (1.0 - z))
    slope = inside * (4.0 * z if z < 0.5 else 4.0 * (1.0 - z)) / width
    step = 1.0 if x >= (a + b) / 2.0 else 0.0
    return value if smooth else step, slope * (z - 1.0), -slope * z


@uncounted
def _edges(kind: int, a: float, b: float, c: float, d: float, x: np.ndarray, partial: np.ndarray) -> None:
    """Rows ``partial`` (parameters, lanes) of a function made of straight lines and parabolas."""
    if kind in (TRIANGLE, TRAPEZOID):
        shoulder, foot = (b, c) if kind == TRIANGLE else (c, d)
        for p in range(len(x)):
            up, up_a, up_b = _ramp(x[p], a, b)
            down, down_foot, down_shoulder = _ramp(-x[p], -foot, -shoulder)
            left = _share(up, down)
            right = 1.0 - left
            partial[0, p] = left * up_a
            if kind == TRIANGLE:
                partial[1, p] = left * up_b - right * down_shoulder
                partial[2, p] = -right * down_foot
            else:
                partial[1, p] = left * up_b
                partial[2, p] = -right * down_shoulder
                partial[3, p] = -right * down_foot
    elif kind in (LINEAR_S, LINEAR_Z):
        sign = 1.0 if kind == LINEAR_S else -1.0
        for p in range(len(x)):
            _, up_a, up_b = _ramp(x[p], a, b)
            partial[0, p] = sign * up_a
            partial[1, p] = sign * up_b
    elif kind == S_SHAPE:
        for p in range(len(x)):
            _, partial[0, p], partial[1, p] = _spline(x[p], a, b)
    elif kind == Z_SHAPE:
        for p in range(len(x)):
            _, down_b, down_a = _spline(-x[p], -b, -a)
            partial[0, p] = -down_a
            partial[1, p] = -down_b
    elif kind == PI_SHAPE:
        for p in range(len(x)):
            up, up_a, up_b = _spline(x[p], a, b)
            down, down_d, down_c = _spline(-x[p], -d, -c)
            partial[0, p] = up_a * down
            partial[1, p] = up_b * down
            partial[2, p] = -down_c * up
            partial[3, p] = -down_d * up


@uncounted
def _sigmoid(x: np.ndarray, a: float, c: float, row: np.ndarray, scale: np.ndarray, bits: np.ndarray) -> None:
    """``row`` ← e^-|z|, z = a (x − c), of which a sigmoid and its slope are made."""
    for p in range(len(x)):
        row[p] = -abs(a * (x[p] - c))
    exp_nonpositive(row, scale, bits)


@uncounted
def _log_sigmoids(
    parameters: np.ndarray, count: int, x: np.ndarray, partial: np.ndarray, rows: np.ndarray, bits: np.ndarray
) -> None:
    """Rows ``partial`` of the logarithm of a product of ``count`` sigmoids."""
    for k in range(count):
        a, c = parameters[2 * k], parameters[2 * k + 1]
        _sigmoid(x, a, c, rows[0], rows[1], bits)
        for p in range(len(x)):
            u, away = rows[0, p], x[p] - c
            rest = (1.0 if a * away < 0.0 else u) / (1.0 + u)  # 1 minus the sigmoid
            partial[2 * k, p] = rest * away
            partial[2 * k + 1, p] = -rest * a


@uncounted
def _sigmoid_difference(
    parameters: np.ndarray, x: np.ndarray, partial: np.ndarray, rows: np.ndarray, bits: np.ndarray
) -> None:
    """Rows ``partial`` of a difference of two sigmoids, which is held at 0 where it would be negative."""
    for k in range(2):
        a, c = parameters[2 * k], parameters[2 * k + 1]
        sign = 1.0 if k == 0 else -1.0
        _sigmoid(x, a, c, rows[0], rows[1], bits)
        for p in range(len(x)):
            u, away = rows[0, p], x[p] - c
            slope = sign * u / ((1.0 + u) * (1.0 + u))
            rows[2 + k, p] = (u if a * away < 0.0 else 1.0) / (1.0 + u)
            partial[2 * k, p] = slope * away
            partial[2 * k + 1, p] = -slope * a
    for p in range(len(x)):
        inside = 1.0 if rows[2, p] >= rows[3, p] else 0.0
        for k in range(4):
            partial[k, p] *= inside


@uncounted
def _log_bell(
    a: float, b: float, c: float, x: np.ndarray, partial: np.ndarray, rows: np.ndarray, bits: np.ndarray
) -> None:
    """Rows ``partial`` of −log(1 + |z|^2b), z = (x − c)/a; 0 at the center."""
    log, power = rows[0], rows[2]
    for p in range(len(x)):
        z = abs((x[p] - c) / a)
        log[p] = z if z > 1e-300 else 1e-300
    log_positive(log, rows[1], bits)
    for p in range(len(x)):
        power[p] = -abs(2.0 * b * log[p])
    exp_nonpositive(power, rows[1], bits)
    for p in range(len(x)):
        u, away = power[p], x[p] - c
        share = (1.0 if b * log[p] > 0.0 else u) / (1.0 + u)  # |z|^2b / (1 + |z|^2b)
        share = 0.0 if away == 0.0 else share
        partial[0, p] = share * (2.0 * b / a)
        partial[1, p] = share * (-2.0 * log[p])
        partial[2, p] = share * (2.0 * b) / (1.0 if away == 0.0 else away)


@uncounted
def _gaussian(
    sigma: float, center: float, side: int, x: np.ndarray, to_sigma: np.ndarray, to_center: np.ndarray
) -> None:
    """Two rows of −z²/2, z = (x − c)/σ: of both sides (0), of the left one only (−1) or of the right one (1)."""
    for p in range(len(x)):
        away = x[p] - center
        away = 0.0 if (side < 0 and away > 0.0) or (side > 0 and away < 0.0) else away
        z = away / sigma
        to_sigma[p] = z * z / sigma
        to_center[p] = z / sigma


@kernel(nogil=True, _nrt=False)
def derivatives(
    kind: int,
    parameters: np.ndarray,
    x: np.ndarray,
    degree: np.ndarray,
    logarithmic: bool,
    partial: np.ndarray,
    rows: np.ndarray,
    bits: np.ndarray,
) -> None:
    """Write the derivatives of a row of degrees, or of their logarithms, to the parameters of the function.

    Args:
        kind: The function's number, of :data:`fuzzy.compiled.tables.NUMBERS`.
        parameters: Its parameters, filled up (4,).
        x: The inputs (lanes,).
        degree: The degrees (lanes,) there, or their logarithms.
        logarithmic: Which of the two.
        partial: Where the derivatives (4, lanes) are written; rows without a parameter stay as they are.
        rows: Memory to work in (4, lanes).
        bits: The memory of ``rows[1]`` as int64.
    """
    a, b, c, d = parameters[0], parameters[1], parameters[2], parameters[3]
    count = 2
    if kind < SIGMOID_DIFFERENCE:
        _edges(kind, a, b, c, d, x, partial)
        return
    if kind == SIGMOID_DIFFERENCE:
        _sigmoid_difference(parameters, x, partial, rows, bits)
        return
    if kind == GAUSSIAN:
        _gaussian(a, b, 0, x, partial[0], partial[1])
    elif kind == TWO_SIDED_GAUSSIAN:
        _gaussian(a, b, -1, x, partial[0], partial[1])
        _gaussian(c, d, 1, x, partial[2], partial[3])
        count = 4
    elif kind == BELL:
        _log_bell(a, b, c, x, partial, rows, bits)
        count = 3
    elif kind == SIGMOID:
        _log_sigmoids(parameters, 1, x, partial, rows, bits)
    elif kind == SIGMOID_PRODUCT:
        _log_sigmoids(parameters, 2, x, partial, rows, bits)
        count = 4
    for k in range(count):
        for p in range(len(x)):
            # Where the degree is 0 to the last digit, infinity times 0 may stand here.
            if logarithmic:
                partial[k, p] = partial[k, p] if degree[p] > -1e290 else 0.0
            else:
                partial[k, p] = partial[k, p] * degree[p] if degree[p] > 0.0 else 0.0
