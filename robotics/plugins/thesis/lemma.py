"""Lemma 4.1 of the thesis, (4.17)-(4.22), judged: each of its conditions on a dense grid of tracking errors.

With ξ = (x, y, ψ) of (5.9), |ψ| < π/2, and v̄, ω̄ of (4.1), (4.2), the thesis claims for (4.7) and

    V = (x² + y²)/2 + (1 − cos ψ)/K_y                                        (4.8)
    ξ' = f(ξ) + g(ξ, S̃')   g = S̃' (v̄ cos ψ, v̄ sin ψ, ω̄)                      (4.6), (4.17)

the conditions below, and from them that ξ goes to 0 exponentially (4.22).

    1   c1 |ξ|² <= V <= c2 |ξ|²     printed c1 = min{1/2, 1/K_y}, c2 = max{1/2, 1/K_y}
                                    true    c1 = min{1/2, (4/π²)/K_y}, c2 = max{1/2, 1/(2 K_y)}
    2   |∂V/∂ξ| <= c3 |ξ|           printed c3 = √(2 + 1/K_y²), true max{1, 1/K_y}
    3   ∂V/∂ξ f <= −c4 |ξ|²         printed c4 = max{1, K_x, K_ψ/K_y}; no c4 > 0 exists: at (0, y, 0) it is 0
    4   |g| <= c5 |ξ| e^(−βt)       printed c5 = max{v̄, ω̄/K_y}; no c5 exists: g(0) = S̃' (v̄, 0, ω̄), which is not 0
    4Λ  |Λ| <= c5 |ξ|               what stands for |g| in the thesis's proof of 4, Λ being that of (4.9); true
                                    √(v̄² + ω̄²/K_y²)

So the lemma cannot be applied. That the error goes to 0 is nevertheless true: the nominal system is uniformly locally
exponentially stable where v_r does not go to 0, and g is an input that vanishes exponentially [Panteley & Loria
1998]; and with v_d = v̄ s' as (4.1) says, there is no g at all.
"""

from dataclasses import dataclass
from math import hypot, pi, sqrt

import numpy as np

from robotics.laws.tracking.lyapunov import Lyapunov

# v̄ of (4.1) [m], the length of a path that is parametrised evenly; ω̄ of (4.2) [rad]; v_L of (4.3) [1/s]
_LENGTH, _TURN, _PACE = 7.0, 3.0, 1 / 60
_REACH = 1.0  # m: the greatest |x| and |y| of the grid
_TOLERANCE = 1e-9  # relative: a bound that is met exactly, but for rounding, holds


@dataclass(frozen=True, kw_only=True)
class LemmaCondition:
    """One condition of lemma 4.1: the constant that is printed, and what was found in its place."""

    name: str  # "1 lower", "1 upper", "2", "3", "4" or "4Λ"
    statement: str
    printed: float  # the printed constant
    worst: float  # the greatest, or for "1 lower" and "3" the least, value on the grid that the constant must bound
    at: tuple[float, float, float]  # x [m], y [m], ψ [rad] where it was found
    holds: bool  # the printed constant bounds it
    corrected: float | None  # the best constant for all errors; None: there is none
    corrected_holds: bool  # there is one, and it bounds what was found


def judge_lemma(law: Lyapunov | None = None, points: int = 41) -> list[LemmaCondition]:
    """Check each condition of lemma 4.1 on a grid of tracking errors.

    Args:
        law: The tracker, by default with the thesis's gains 1, 1, 1. (4.7) has its form (2.32), without catch_up.
        points: The number of values of each error; odd, so that 0 is one of them.

    Raises ValueError for an even number of points.
    """
    if points < 3 or points % 2 == 0:
        raise ValueError(f"points must be odd and 3 or more, so that 0 is on the grid; got {points!r}")
    law = law or Lyapunov(ky=1.0, kpsi=1.0, catch_up=0.0)
    kx, ky, kpsi, v, w = law.kx, law.ky, law.kpsi, _LENGTH, _TURN
    line = np.linspace(-1.0, 1.0, points)
    grid = np.meshgrid(_REACH * line, _REACH * line, pi / 2 * line, indexing="ij")
    e = np.stack([part.ravel() for part in grid], axis=-1)
    e = e[(e != 0).any(axis=-1)]  # all but the origin, where every ratio is 0 / 0
    x, y, psi = e.T
    sin, cos, square = np.sin(psi), np.cos(psi), (e**2).sum(axis=-1)
    size = np.sqrt(square)

    level = (x**2 + y**2) / 2 + (1 - cos) / ky  # (4.8)
    gradient = np.sqrt(x**2 + y**2 + (sin / ky) ** 2)
    fall = kx * x**2 + kpsi / ky * v * _PACE * sin**2  # −∂V/∂ξ f, (4.9) with S̃' = 0
    push = np.full_like(x, hypot(v, w))  # |g| / |S̃'|, the same for every error
    product = np.abs(x * v * cos + y * v * sin + sin / ky * w)  # |Λ| of (4.9)

    half = 0.5
    return [
        _judged("1 lower", "c1 |ξ|² <= V", level / square, e, min(half, 1 / ky), min(half, 4 / pi**2 / ky), lower=True),
        _judged("1 upper", "V <= c2 |ξ|²", level / square, e, max(half, 1 / ky), max(half, half / ky)),
        _judged("2", "|∂V/∂ξ| <= c3 |ξ|", gradient / size, e, sqrt(2 + ky**-2), max(1.0, 1 / ky)),
        _judged("3", "c4 |ξ|² <= −∂V/∂ξ f", fall / square, e, max(1.0, kx, kpsi / ky), None, lower=True),
        _judged("4", "|g| <= c5 |ξ| |S̃'|", push / size, e, max(v, w / ky), None),
        _judged("4Λ", "|Λ| <= c5 |ξ|", product / size, e, max(v, w / ky), hypot(v, w / ky)),
    ]


def _judged(
    name: str,
    statement: str,
    ratio: np.ndarray,
    e: np.ndarray,
    printed: float,
    corrected: float | None,
    lower: bool = False,
) -> LemmaCondition:
    """A condition whose constant must be at least ``ratio`` (n,) at all errors ``e`` (n, 3); if ``lower``, at most."""
    k = int(ratio.argmin() if lower else ratio.argmax())
    worst, (x, y, psi) = float(ratio[k]), e[k].tolist()

    def bounds(constant: float) -> bool:
        return worst >= constant * (1 - _TOLERANCE) if lower else worst <= constant * (1 + _TOLERANCE)

    return LemmaCondition(
        name=name,
        statement=statement,
        printed=printed,
        worst=worst,
        at=(x, y, psi),
        holds=bounds(printed),
        corrected=corrected,
        corrected_holds=corrected is not None and bounds(corrected),
    )
