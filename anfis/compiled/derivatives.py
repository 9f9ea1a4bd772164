"""Degrees of membership and how they change with the parameters of their functions, a row of samples at a time.

The functions of one number are those of :mod:`fuzzy.compiled.degrees`, beside each its derivatives; a bell has its own
logarithm here, of which vector instructions can be made. At a joint, where a function has a derivative on either side
only, the same one is taken as torch takes of :mod:`fuzzy.membership`.
"""

import math

import numpy as np

from fuzzy.compiled.degrees import exp_nonpositive, fill_degrees, log_sigmoid, rise, spline
from fuzzy.compiled.jit import compiled_only
from fuzzy.compiled.tables import KIND

_LN2_HIGH = float.fromhex("0x1.62e42fefa3800p-1")  # 42 bits, so that k times it is exact
_LN2_LOW = float.fromhex("0x1.ef35793c76730p-45")  # the rest of ln 2
_MANTISSA = (1 << 52) - 1
_ONE = 1023 << 52  # 1.0 as an integer
_ROOT = math.sqrt(2.0)
_LEAST = 1e-300  # what stands for 0 where a logarithm is taken


@compiled_only(forceinline=True)
def log_positive(v: float) -> float:
    """Compute log v of a normal number v > 0, within two units in the last place.

    v = 2^k m with m in [√½, √2), and log m = 2 artanh(s), s = (m − 1)/(m + 1), by its Taylor series.
    """
    bits = np.float64(v).view(np.int64)
    k = np.float64(np.int64(bits >> 52) - 1023)
    m = np.int64(np.int64(bits & _MANTISSA) | _ONE).view(np.float64)
    above = m > _ROOT
    m = 0.5 * m if above else m
    k = k + 1.0 if above else k
    s = (m - 1.0) / (m + 1.0)
    q = s * s
    q2 = q * q
    low = (1 / 3 + q * (1 / 5)) + q2 * (1 / 7 + q * (1 / 9))
    high = (1 / 11 + q * (1 / 13)) + q2 * ((1 / 15 + q * (1 / 17)) + q2 * (1 / 19 + q * (1 / 21)))
    t = low + (q2 * q2) * high
    return k * _LN2_HIGH + (2.0 * s + (2.0 * s * q * t + k * _LN2_LOW))


@compiled_only(forceinline=True)
def _log1p(u: float) -> float:
    """Compute log(1 + u) for u ≥ 0: the logarithm of the rounded sum, and what the rounding took away."""
    v = 1.0 + u
    return log_positive(v) + (u - (v - 1.0)) / v


@compiled_only(forceinline=True)
def _bell_exponent(x: float, a: float, b: float, c: float) -> float:
    """2b log |(x − c)/a|, and what it tends to at the center."""
    z = abs((x - c) / a)
    center = -math.inf if b > 0.0 else (math.inf if b < 0.0 else 0.0)
    away = 2.0 * b * log_positive(z if z > _LEAST else _LEAST)
    return away if z > 0.0 else center


@compiled_only(forceinline=True)
def fill_terms(kind: int, parameters: np.ndarray, x: np.ndarray, degree: np.ndarray, row: np.ndarray) -> None:
    """Write a row of degrees, as :func:`fuzzy.compiled.degrees.fill_degrees`.

    ``row`` is memory to work in, as long as the others.
    """
    a, b, c, d = parameters[0], parameters[1], parameters[2], parameters[3]
    if kind != KIND.Bell:
        fill_degrees(kind, a, b, c, d, x, degree, len(x))
        return
    # One after the other: all in one loop have more constants than there are registers, and take twice the time.
    for p in range(len(x)):
        degree[p] = _bell_exponent(x[p], a, b, c)
    for p in range(len(x)):
        row[p] = exp_nonpositive(-abs(degree[p]))
    for p in range(len(x)):
        degree[p] = -((degree[p] if degree[p] > 0.0 else 0.0) + _log1p(row[p]))


# Derivatives ----------------------------------------------------------------------------------------------------------


@compiled_only(forceinline=True)
def _ramp_slopes(x: float, a: float, b: float) -> tuple[float, float]:
    """The derivatives of a straight edge that rises from ``a`` to ``b``, to both."""
    steep = b > a
    width = b - a if steep else 1.0
    z = (x - a) / width
    inside = 1.0 if (steep and z >= 0.0 and z <= 1.0) else 0.0
    return inside * (z - 1.0) / width, -inside * z / width


@compiled_only(forceinline=True)
def _spline_slopes(x: float, a: float, b: float) -> tuple[float, float]:
    """The derivatives of a quadratic spline that rises from ``a`` to ``b``, to both."""
    smooth = b > a
    width = b - a if smooth else 1.0
    z = (x - a) / width
    inside = 1.0 if (smooth and z >= 0.0 and z <= 1.0) else 0.0
    slope = inside * (4.0 * z if z < 0.5 else 4.0 * (1.0 - z)) / width
    return slope * (z - 1.0), -slope * z


@compiled_only(forceinline=True)
def _left_share(left: float, right: float) -> float:
    """Of a minimum, the part of its slope that its first argument has: half where both are equal, as in torch."""
    return 1.0 if left < right else (0.5 if left == right else 0.0)


@compiled_only(forceinline=True)
def _sigmoid_slopes(x: float, a: float, c: float) -> tuple[float, float]:
    """The derivatives of the logarithm of a sigmoid to a and c: 1 minus the sigmoid, times x − c or −a."""
    z = a * (x - c)
    u = exp_nonpositive(-abs(z))
    rest = (1.0 if z < 0.0 else u) / (1.0 + u)
    return rest * (x - c), -rest * a


@compiled_only(forceinline=True)
def _edges(kind: int, a: float, b: float, c: float, d: float, x: np.ndarray, partial: np.ndarray) -> None:
    """Derivatives of a function made of straight lines and parabolas."""
    if kind == KIND.Triangle:
        for p in range(len(x)):
            left = _left_share(rise(x[p], a, b), rise(-x[p], -c, -b))
            up_a, up_b = _ramp_slopes(x[p], a, b)
            down_c, down_b = _ramp_slopes(-x[p], -c, -b)
            partial[0, p] = left * up_a
            partial[1, p] = left * up_b - (1.0 - left) * down_b
            partial[2, p] = (left - 1.0) * down_c
    elif kind == KIND.Trapezoid:
        for p in range(len(x)):
            left = _left_share(rise(x[p], a, b), rise(-x[p], -d, -c))
            up_a, up_b = _ramp_slopes(x[p], a, b)
            down_d, down_c = _ramp_slopes(-x[p], -d, -c)
            partial[0, p] = left * up_a
            partial[1, p] = left * up_b
            partial[2, p] = (left - 1.0) * down_c
            partial[3, p] = (left - 1.0) * down_d
    elif kind in (KIND.LinearS, KIND.LinearZ):
        sign = 1.0 if kind == KIND.LinearS else -1.0
        for p in range(len(x)):
            up_a, up_b = _ramp_slopes(x[p], a, b)
            partial[0, p] = sign * up_a
            partial[1, p] = sign * up_b
    elif kind == KIND.SShape:
        for p in range(len(x)):
            partial[0, p], partial[1, p] = _spline_slopes(x[p], a, b)
    elif kind == KIND.ZShape:
        for p in range(len(x)):
            down_b, down_a = _spline_slopes(-x[p], -b, -a)
            partial[0, p] = -down_a
            partial[1, p] = -down_b
    elif kind == KIND.PiShape:
        for p in range(len(x)):
            up, down = spline(x[p], a, b), spline(-x[p], -d, -c)
            up_a, up_b = _spline_slopes(x[p], a, b)
            down_d, down_c = _spline_slopes(-x[p], -d, -c)
            partial[0, p] = up_a * down
            partial[1, p] = up_b * down
            partial[2, p] = -down_c * up
            partial[3, p] = -down_d * up


@compiled_only(forceinline=True)
def _smooth(kind: int, a: float, b: float, c: float, d: float, x: np.ndarray, partial: np.ndarray) -> None:
    """Derivatives of the logarithm of a function that is positive everywhere."""
    if kind == KIND.Gaussian:
        for p in range(len(x)):
            z = (x[p] - b) / a
            partial[0, p] = z * z / a
            partial[1, p] = z / a
    elif kind == KIND.TwoSidedGaussian:
        for p in range(len(x)):
            left, right = x[p] - b, x[p] - d
            left = (0.0 if left > 0.0 else left) / a
            right = (0.0 if right < 0.0 else right) / c
            partial[0, p] = left * left / a
            partial[1, p] = left / a
            partial[2, p] = right * right / c
            partial[3, p] = right / c
    elif kind == KIND.Bell:
        for p in range(len(x)):
            z = abs((x[p] - c) / a)
            partial[1, p] = log_positive(z if z > _LEAST else _LEAST)
        for p in range(len(x)):
            partial[0, p] = exp_nonpositive(-abs(2.0 * b * partial[1, p]))
        for p in range(len(x)):
            u, log, away = partial[0, p], partial[1, p], x[p] - c
            share = (1.0 if b * log > 0.0 else u) / (1.0 + u)  # |z|^2b / (1 + |z|^2b)
            share = 0.0 if away == 0.0 else share
            partial[0, p] = share * (2.0 * b / a)
            partial[1, p] = share * (-2.0 * log)
            partial[2, p] = share * (2.0 * b) / (1.0 if away == 0.0 else away)
    elif kind in (KIND.Sigmoid, KIND.SigmoidProduct):
        for p in range(len(x)):
            partial[0, p], partial[1, p] = _sigmoid_slopes(x[p], a, b)
    if kind == KIND.SigmoidProduct:
        for p in range(len(x)):
            partial[2, p], partial[3, p] = _sigmoid_slopes(x[p], c, d)


@compiled_only(forceinline=True)
def _sigmoid_difference(a: float, b: float, c: float, d: float, x: np.ndarray, partial: np.ndarray) -> None:
    """Derivatives of a difference of two sigmoids, which is held at 0 where it would be negative."""
    for p in range(len(x)):
        first, second = exp_nonpositive(log_sigmoid(x[p], a, b)), exp_nonpositive(log_sigmoid(x[p], c, d))
        first, second = (first, second) if first >= second else (0.0, 0.0)
        to_a, to_c = _sigmoid_slopes(x[p], a, b)
        partial[0, p] = first * to_a
        partial[1, p] = first * to_c
        to_a, to_c = _sigmoid_slopes(x[p], c, d)
        partial[2, p] = -second * to_a
        partial[3, p] = -second * to_c


@compiled_only(forceinline=True)
def fill_derivatives(
    kind: int, parameters: np.ndarray, x: np.ndarray, degree: np.ndarray, logs: bool, partial: np.ndarray
) -> None:
    """Write the derivatives of a row of degrees, or of their logarithms if ``logs``, to the function's parameters.

    ``partial`` is (4, lanes); the rows without a parameter become 0.
    """
    a, b, c, d = parameters[0], parameters[1], parameters[2], parameters[3]
    for k in range(4):
        for p in range(len(x)):
            partial[k, p] = 0.0
    if kind < KIND.SigmoidDifference:
        _edges(kind, a, b, c, d, x, partial)
        return
    if kind == KIND.SigmoidDifference:
        _sigmoid_difference(a, b, c, d, x, partial)
        return
    _smooth(kind, a, b, c, d, x, partial)
    for k in range(4):
        for p in range(len(x)):
            # Where the degree is 0 to the last digit, infinity times 0 may stand here.
            if logs:
                partial[k, p] = partial[k, p] if degree[p] > -1e290 else 0.0
            else:
                partial[k, p] = partial[k, p] * degree[p] if degree[p] > 0.0 else 0.0
