"""The sine and cosine of an angle at once, for loops that the compiler turns into vector instructions.

The mathematics library's functions are calls, and a loop with a call is not vectorised. These are arithmetic only,
without a branch, and give the same bits in a vector as alone.
"""

import numpy as np

from fuzzy.compiled.jit import kernel

_PER_QUARTER = 2 / np.pi
# π/2 in three parts, of which the first two have 33 bits: a multiple below 2^20 of each is exact.
_QUARTER_1 = 1.57079632673412561417e00
_QUARTER_2 = 6.07710050630396597660e-11
_QUARTER_3 = 2.02226624879595063154e-21


@kernel
def sincos(angle):  # type: ignore[no-untyped-def]
    """Return sin and cos of ``angle`` [rad], each within 1.5 ulp for |angle| < 1e6 rad.

    The angle is reduced to |x| <= π/4 by multiples of π/2 in three parts (Cody and Waite 1980), and the polynomials
    are those of fdlibm (Sun Microsystems 1993, k_sin.c and k_cos.c). An infinite angle gives NaN.
    """
    n = np.floor(angle * _PER_QUARTER + 0.5)
    high = angle - n * _QUARTER_1
    middle = n * _QUARTER_2
    x = high - middle
    x = x - (n * _QUARTER_3 - ((high - x) - middle))
    q = x * x
    s = 2.75573137070700676789e-06 + q * (-2.50507602534068634195e-08 + q * 1.58969099521155010221e-10)
    s = 8.33333333332248946124e-03 + q * (-1.98412698298579493134e-04 + q * s)
    sine = x + x * q * (-1.66666666666666324348e-01 + q * s)
    c = -2.75573143513906633035e-07 + q * (2.08757232129817482790e-09 - q * 1.13596475577881948265e-11)
    c = 4.16666666666666019037e-02 + q * (-1.38888888888741095749e-03 + q * (2.48015872894767294178e-05 + q * c))
    half = 0.5 * q
    whole = 1 - half
    cosine = whole + (((1 - whole) - half) + q * q * c)
    quarter = n - 4 * np.floor(0.25 * n)
    swapped = quarter == 1.0 or quarter == 3.0
    first = cosine if swapped else sine
    second = sine if swapped else cosine
    return (-first if quarter >= 2.0 else first), (-second if quarter == 1.0 or quarter == 2.0 else second)
