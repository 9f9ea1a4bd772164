"""Degrees of membership of one number, as :mod:`fuzzy.compiled` computes them in loops over terms and over points.

Every function is written for one number, has no branch that a select cannot replace and calls no library function
(but the bell, for its logarithm), so that the compiler makes vector instructions of a loop over it, and is compiled
into the loops that call it. No operation is reordered (no fast-math): a number has the same bits in every loop.
"""

import math

import numpy as np

from fuzzy.compiled.jit import compiled_only, kernel
from fuzzy.compiled.tables import KIND, READ_STEPS
from fuzzy.compiled.vectors import wide_vectors

# Without Numba's reference counts (NRT): these functions make no arrays, and counting the users of arrays takes
# longer than the inference of a point.

# Exponential and logarithm ------------------------------------------------------------------------------------

_LOWEST = -746.0  # e to this rounds to 0
_LOG2_E = 1 / math.log(2)
_LN2_HIGH = float.fromhex("0x1.62e42fefa3800p-1")  # 42 bits, so that k times it is exact
_LN2_LOW = float.fromhex("0x1.ef35793c76730p-45")  # the rest of ln 2
_ROUND = 1.5 * 2.0**52  # added and taken away, it rounds to an integer, which the sum carries in its last bits
_HALF_RANGE = 537  # 2^k as 2^(k + 537) · 2^-537: the first is never subnormal, the second a constant
_E2, _E3, _E4, _E5, _E6, _E7 = (1 / math.factorial(n) for n in range(2, 8))
_E8, _E9, _E10, _E11, _E12, _E13 = (1 / math.factorial(n) for n in range(8, 14))


@compiled_only(forceinline=True)
def exp_nonpositive(v: float) -> float:
    """Compute e^v for v ≤ 0, within one unit in the last place. -inf gives 0, not-a-number stays.

    e^v = 2^k e^r with r = v − k ln 2, |r| ≤ ln(2)/2, and e^r by its Taylor series, whose remainder is below 4e-18.
    """
    v = _LOWEST if v < _LOWEST else v
    shifted = v * _LOG2_E + _ROUND
    # The last twelve bits of k + 1023 + 537 are moved to where a float64 has its sign and exponent.
    bits = np.int64(np.float64(shifted).view(np.int64) + (1023 + _HALF_RANGE))
    scale = np.int64(bits << 52).view(np.float64)
    k = shifted - _ROUND
    r = (v - k * _LN2_HIGH) - k * _LN2_LOW
    # Estrin's order: half of the operations wait for none of the others.
    q = r * r
    low = (_E2 + r * _E3) + q * (_E4 + r * _E5)
    middle = (_E6 + r * _E7) + q * (_E8 + r * _E9)
    high = (_E10 + r * _E11) + q * (_E12 + r * _E13)
    e = low + q * q * (middle + q * q * high)
    return (1.0 + (r + q * e)) * scale * 2.0**-_HALF_RANGE


@kernel(nogil=True, _nrt=False, forceinline=True)
def log1p_unit(u: float) -> float:
    """Compute log(1 + u) for 0 ≤ u ≤ 1, as 2 artanh(s) with s = u / (2 + u) ≤ 1/3, by its Taylor series."""
    s = u / (2.0 + u)
    q = s * s
    t = 1 / 27 + q * (1 / 29 + q * (1 / 31 + q * (1 / 33 + q * (1 / 35))))
    t = 1 / 15 + q * (1 / 17 + q * (1 / 19 + q * (1 / 21 + q * (1 / 23 + q * (1 / 25 + q * t)))))
    t = 1 / 3 + q * (1 / 5 + q * (1 / 7 + q * (1 / 9 + q * (1 / 11 + q * (1 / 13 + q * t)))))
    return 2.0 * (s + s * q * t)


# Membership functions of straight lines and parabolas ---------------------------------------------------------


@compiled_only(forceinline=True)
def _unit(z: float) -> float:
    z = 0.0 if z < 0.0 else z
    return 1.0 if z > 1.0 else z


@compiled_only(forceinline=True)
def minimum(a: float, b: float) -> float:
    """Return the smaller of two numbers, the first where one is not-a-number."""
    return b if b < a else a


@compiled_only(forceinline=True)
def rise(x: float, a: float, b: float) -> float:
    """0 up to a, 1 from b on, straight between; a = b is a vertical edge with the value 1 at the edge."""
    slope = _unit((x - a) / (b - a if b > a else 1.0))
    edge = 1.0 if x >= b else 0.0
    return slope if b > a else edge


@compiled_only(forceinline=True)
def spline(x: float, a: float, b: float) -> float:
    """Quadratic spline from 0 at a to 1 at b; a >= b is a step, 1 from the middle on."""
    z = _unit((x - a) / (b - a if b > a else 1.0))
    smooth = 2.0 * (z * z) if z < 0.5 else 1.0 - 2.0 * ((1.0 - z) * (1.0 - z))
    step = 1.0 if x >= (a + b) / 2.0 else 0.0
    return smooth if b > a else step


@compiled_only(forceinline=True)
def trapezoid(x: float, a: float, b: float, c: float, d: float) -> float:
    """Trapezoid with the feet a, d and the shoulders b, c; with b = c a triangle."""
    return minimum(rise(x, a, b), rise(-x, -d, -c))


@compiled_only(forceinline=True)
def sampled(x: float, values: np.ndarray, low: float, high: float) -> float:
    """Straight between READ_STEPS + 1 values from ``low`` to ``high``, of which the outermost go on."""
    place = _unit((x - low) / (high - low)) * READ_STEPS if x == x else 0.0  # who evaluates asks whether x is known
    k = min(int(place), READ_STEPS - 1)
    return values[k] + (place - k) * (values[k + 1] - values[k])


# Logarithms of those that are positive everywhere -------------------------------------------------------------


@compiled_only(forceinline=True)
def log_gaussian(x: float, sigma: float, c: float) -> float:
    """Logarithm of the Gaussian."""
    z = (x - c) * (1.0 / sigma)
    return -0.5 * (z * z)


@compiled_only(forceinline=True)
def log_two_sided(x: float, s1: float, c1: float, s2: float, c2: float) -> float:
    """Logarithm of the Gaussian left of c1 times that right of c2."""
    left, right = x - c1, x - c2
    left = (0.0 if left > 0.0 else left) / s1
    right = (0.0 if right < 0.0 else right) / s2
    return -0.5 * (left * left) + -0.5 * (right * right)


@compiled_only(forceinline=True)
def log_sigmoid(x: float, a: float, c: float) -> float:
    """−log(1 + e^-z), z = a (x − c), as −(max(0, −z) + log(1 + e^-|z|)), which does not overflow."""
    z = a * (x - c)
    return -((-z if z < 0.0 else 0.0) + log1p_unit(exp_nonpositive(-abs(z))))


@compiled_only(forceinline=True)
def log_bell(x: float, a: float, b: float, c: float) -> float:
    """−log(1 + |z|^2b), z = (x − c)/a, with |z|^2b = exp(2b log |z|) set apart at the center."""
    center = -math.inf if b > 0.0 else (math.inf if b < 0.0 else 0.0)
    z = abs((x - c) / a)
    exponent = 2.0 * b * math.log(z) if z > 0.0 else center
    return -((exponent if exponent > 0.0 else 0.0) + log1p_unit(exp_nonpositive(-abs(exponent))))


@compiled_only(forceinline=True)
def sigmoid_difference(x: float, a1: float, c1: float, a2: float, c2: float) -> float:
    """Difference of two sigmoids."""
    return _unit(exp_nonpositive(log_sigmoid(x, a1, c1)) - exp_nonpositive(log_sigmoid(x, a2, c2)))


# Rows of numbers ----------------------------------------------------------------------------------------------


@compiled_only(forceinline=True)
def fill_degrees(
    kind: int, a: float, b: float, c: float, d: float, x: np.ndarray, degree: np.ndarray, lanes: int
) -> None:
    """Write a row of degrees; from Gaussian on their logarithms, of an unknown kind not-a-number.

    Each kind has a loop of its own, which has no branch then.
    """
    wide_vectors()
    if kind == KIND.Triangle:
        for p in range(lanes):
            degree[p] = trapezoid(x[p], a, b, b, c)
    elif kind == KIND.Trapezoid:
        for p in range(lanes):
            degree[p] = trapezoid(x[p], a, b, c, d)
    elif kind == KIND.LinearS:
        for p in range(lanes):
            degree[p] = rise(x[p], a, b)
    elif kind == KIND.LinearZ:
        for p in range(lanes):
            degree[p] = 1.0 - rise(x[p], a, b)
    elif kind == KIND.SShape:
        for p in range(lanes):
            degree[p] = spline(x[p], a, b)
    elif kind == KIND.ZShape:
        for p in range(lanes):
            degree[p] = spline(-x[p], -b, -a)
    elif kind == KIND.PiShape:
        for p in range(lanes):
            degree[p] = spline(x[p], a, b) * spline(-x[p], -d, -c)
    elif kind == KIND.SigmoidDifference:
        for p in range(lanes):
            degree[p] = sigmoid_difference(x[p], a, b, c, d)
    elif kind == KIND.Gaussian:
        for p in range(lanes):
            degree[p] = log_gaussian(x[p], a, b)
    elif kind == KIND.TwoSidedGaussian:
        for p in range(lanes):
            degree[p] = log_two_sided(x[p], a, b, c, d)
    elif kind == KIND.Bell:
        for p in range(lanes):
            degree[p] = log_bell(x[p], a, b, c)
    elif kind == KIND.Sigmoid:
        for p in range(lanes):
            degree[p] = log_sigmoid(x[p], a, b)
    elif kind == KIND.SigmoidProduct:
        for p in range(lanes):
            degree[p] = log_sigmoid(x[p], a, b) + log_sigmoid(x[p], c, d)
    else:
        for p in range(lanes):
            degree[p] = math.nan
