"""The time-varying linear-quadratic regulator of tracking: discrete-time, on the error model (5.9) linearised.

With e = (x_e, y_e, ψ_e) of (5.9), desired − actual, and the commands v = v_d cos ψ_e + δv, ω = ω_d + δω, the errors
near the reference obey (Kanayama et al. 1990; Samson and Ait-Abderrahim 1991)

         |  0    ω_d   0  |       | −1   0 |
    e' = | −ω_d   0   v_d |  e  + |  0   0 | (δv, δω)
         |  0     0    0  |       |  0  −1 |

Held for a control period T, that is e⁺ = F e + G (δv, δω), in closed form (:func:`discretised`). The regulator's

    (δv, δω) = −K e,   K = (R + GᵀPG)⁻¹ GᵀPF,   P = Q + Fᵀ P (I + G R⁻¹ Gᵀ P)⁻¹ F

makes Σ eᵀQe + (δv, δω)ᵀR(δv, δω) least. It is solved anew in every period for the reference's v_d and ω_d of that time
by structured doubling (Chu, Fan, Lin and Wang 2004), some ten steps. Q and R are Bryson's: an error of its scale
counts as much as a command of its scale.

Stability: local. At constant v_d ≠ 0 and ω_d the linearised loop is stable for every choice of the scales, with a gain
margin of at least 1/2; on a reference whose v_d and ω_d change, that holds as long as they change slowly against the
loop's poles. From afar convergence is shown by sampling, not proved.

At rest y_e cannot be controlled, and P has no limit, but K has: as v → 0, K_ωy goes to ± the ratio of the scales. So
the model's speed is never taken as less than ``slowest``, and below it K_ωy fades in proportion: at standstill the
robot turns to the heading and drives along it. Where the robot is faster than its reference, as when it catches up with
one at rest, its own speed counts, up to ``catch_up``. Forwards or backwards is what the reference drives: by the
direction of their own speed, robots that begin facing away settle beside it, going backwards.

It knows the posture, the speed by the encoders and the reference at the present time; it does not know the wheel lag,
the latency, or what the path does ahead.
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from fuzzy.compiled.columns import Columns, column
from fuzzy.compiled.jit import compiled_only
from fuzzy.quantity import quantity
from robotics.laws.equation import EquationLaw, equation
from robotics.laws.setting import Setting
from robotics.laws.tracking.lyapunov import FEED_FORWARD, FeedForward
from robotics.world.paths.posture import wrapped_compiled

_DOUBLINGS = 60  # at most: 2^60 periods
ENOUGH = 1e-15  # the share of its trace by which P changes in a step that is the last one


class WeightColumns(Columns):
    """The weights of the errors, Q, and of the commands, R."""

    q_x = column("1/m²")
    q_y = column("1/m²")
    q_heading = column("1/rad²")
    r_v = column("s²/m²")
    r_w = column("s²/rad²")


# 3 x 3 matrices are tuples of their nine entries, row by row -------------------------------------------------------


@compiled_only
def _times(a, b):  # type: ignore[no-untyped-def]
    return (
        a[0] * b[0] + a[1] * b[3] + a[2] * b[6],
        a[0] * b[1] + a[1] * b[4] + a[2] * b[7],
        a[0] * b[2] + a[1] * b[5] + a[2] * b[8],
        a[3] * b[0] + a[4] * b[3] + a[5] * b[6],
        a[3] * b[1] + a[4] * b[4] + a[5] * b[7],
        a[3] * b[2] + a[4] * b[5] + a[5] * b[8],
        a[6] * b[0] + a[7] * b[3] + a[8] * b[6],
        a[6] * b[1] + a[7] * b[4] + a[8] * b[7],
        a[6] * b[2] + a[7] * b[5] + a[8] * b[8],
    )


@compiled_only
def _turned(a):  # type: ignore[no-untyped-def]
    """The transpose."""
    return a[0], a[3], a[6], a[1], a[4], a[7], a[2], a[5], a[8]


@compiled_only
def _plus(a, b):  # type: ignore[no-untyped-def]
    """a + b, made symmetric."""
    xy, xz, yz = 0.5 * (b[1] + b[3]), 0.5 * (b[2] + b[6]), 0.5 * (b[5] + b[7])
    xy, xz, yz = a[1] + xy, a[2] + xz, a[5] + yz
    return a[0] + b[0], xy, xz, xy, a[4] + b[4], yz, xz, yz, a[8] + b[8]


@compiled_only
def _inverse_of_one_plus(a):  # type: ignore[no-untyped-def]
    """(I + a)⁻¹."""
    a0, a4, a8 = 1 + a[0], 1 + a[4], 1 + a[8]
    c0, c1, c2 = a4 * a8 - a[5] * a[7], a[5] * a[6] - a[3] * a8, a[3] * a[7] - a4 * a[6]
    per = 1 / (a0 * c0 + a[1] * c1 + a[2] * c2)
    return (
        c0 * per, (a[2] * a[7] - a[1] * a8) * per, (a[1] * a[5] - a[2] * a4) * per,
        c1 * per, (a0 * a8 - a[2] * a[6]) * per, (a[2] * a[3] - a0 * a[5]) * per,
        c2 * per, (a[1] * a[6] - a0 * a[7]) * per, (a0 * a4 - a[1] * a[3]) * per,
    )  # fmt: skip


# The regulator ----------------------------------------------------------------------------------------------------


@compiled_only
def discretised(v, w, dt):  # type: ignore[no-untyped-def]
    """F and G, each row by row, of the error model about v [m/s] and ω [rad/s], held for ``dt`` [s].

    With θ = ω T, and R(t) the turn by −ω t that A's first block makes of (x, y): F's last column is ∫ R(t) (0, v) dt,
    G's first one −∫ R(t) (1, 0) dt, and G's last one −∫ (T − t) R(t) (0, v) dt, each from 0 to T.
    """
    angle = w * dt
    square = angle * angle
    if square < 0.0625:  # series, since differences such as θ − sin θ lose their digits; exact to rounding below 1/4
        s1 = 1 - square / 6 * (1 - square / 20 * (1 - square / 42 * (1 - square / 72 * (1 - square / 110))))
        c2 = 0.5 * (1 - square / 12 * (1 - square / 30 * (1 - square / 56 * (1 - square / 90 * (1 - square / 132)))))
        s2 = angle / 6 * (1 - square / 20 * (1 - square / 42 * (1 - square / 72 * (1 - square / 110))))
    else:
        s1 = math.sin(angle) / angle
        c2 = (1 - math.cos(angle)) / square
        s2 = (1 - s1) / angle
    sin, cos = s1 * angle, 1 - c2 * square
    s1, c1, s2, c2 = dt * s1, dt * c2 * angle, dt * dt * s2, dt * dt * c2
    return (cos, sin, v * c1, -sin, cos, v * s1, 0.0, 0.0, 1.0), (-s1, -v * s2, c1, -v * c2, 0.0, -dt)


@compiled_only
def feedback(v, w, dt, gain):  # type: ignore[no-untyped-def]
    """K, row by row, of the regulator about v [m/s], not 0, and ω [rad/s], with the weights of ``gain``."""
    a, b = discretised(v, w, dt)
    p = (gain.q_x, 0.0, 0.0, 0.0, gain.q_y, 0.0, 0.0, 0.0, gain.q_heading)
    per_v, per_w = 1 / gain.r_v, 1 / gain.r_w
    b0, b1, b2, b3, b5 = b[0], b[1], b[2], b[3], b[5]  # G R⁻¹ Gᵀ; the last row of G is (0, −T)
    xy, xh, yh = per_v * b0 * b2 + per_w * b1 * b3, per_w * b1 * b5, per_w * b3 * b5
    c = (per_v * b0 * b0 + per_w * b1 * b1, xy, xh, xy, per_v * b2 * b2 + per_w * b3 * b3, yh, xh, yh, per_w * b5 * b5)
    f = a
    for _ in range(_DOUBLINGS):
        inverse = _inverse_of_one_plus(_times(c, p))
        left = _times(a, inverse)
        more = _times(_turned(a), _times(_times(p, inverse), a))
        c = _plus(c, _times(_times(left, c), _turned(a)))
        a = _times(left, a)
        p = _plus(p, more)
        if not more[0] + more[4] + more[8] > ENOUGH * (p[0] + p[4] + p[8]):
            break
    # GᵀP, then (R + GᵀPG)⁻¹ GᵀP F
    u0, u1, u2 = b0 * p[0] + b2 * p[3], b0 * p[1] + b2 * p[4], b0 * p[2] + b2 * p[5]
    w0 = b1 * p[0] + b3 * p[3] + b5 * p[6]
    w1 = b1 * p[1] + b3 * p[4] + b5 * p[7]
    w2 = b1 * p[2] + b3 * p[5] + b5 * p[8]
    vv, vw = gain.r_v + u0 * b0 + u1 * b2, u0 * b1 + u1 * b3 + u2 * b5
    ww = gain.r_w + w0 * b1 + w1 * b3 + w2 * b5
    per = 1 / (vv * ww - vw * vw)
    k0, k1, k2 = (ww * u0 - vw * w0) * per, (ww * u1 - vw * w1) * per, (ww * u2 - vw * w2) * per
    l0, l1, l2 = (vv * w0 - vw * u0) * per, (vv * w1 - vw * u1) * per, (vv * w2 - vw * u2) * per
    return (
        k0 * f[0] + k1 * f[3], k0 * f[1] + k1 * f[4], k0 * f[2] + k1 * f[5] + k2,
        l0 * f[0] + l1 * f[3], l0 * f[1] + l1 * f[4], l0 * f[2] + l1 * f[5] + l2,
    )  # fmt: skip


@equation
def regulate(robot, aim, gain, dt):  # type: ignore[no-untyped-def]
    """Command the reference's velocities minus K e."""
    dx, dy = aim.x - robot.x, aim.y - robot.y
    cos, sin = math.cos(robot.heading), math.sin(robot.heading)
    x_e, y_e = cos * dx + sin * dy, cos * dy - sin * dx  # (5.9)
    psi_e = wrapped_compiled(aim.heading - robot.heading)
    forwards = aim.v if aim.v != 0 else robot.v
    speed = math.copysign(max(abs(aim.v), min(abs(robot.v), gain.catch_up)), forwards)
    about = speed if abs(speed) >= gain.slowest else math.copysign(gain.slowest, speed)
    k = feedback(about, aim.w, dt, gain)
    full = 1.0 if gain.feed_forward == FEED_FORWARD.full else 0.0
    v = full * aim.v * math.cos(psi_e) - (k[0] * x_e + k[1] * y_e + k[2] * psi_e)
    w = full * aim.w - (k[3] * x_e + k[4] * (speed / about) * y_e + k[5] * psi_e)
    return v, w


@dataclass(frozen=True, kw_only=True)
class LinearQuadratic(EquationLaw):
    """The linear-quadratic regulator: the scales of errors and commands, and what it does near standstill.

    The default scales are those of parallel compensation (:mod:`robotics.laws.tracking.pdc`), y_e as x_e.
    """

    # Errors and commands that weigh alike: Bryson's rule
    x_scale: float = quantity(0.1, "m", above=0)
    y_scale: float = quantity(0.1, "m", above=0)
    heading_scale: float = quantity(0.5, "rad", above=0)
    v_scale: float = quantity(0.2, "m/s", above=0)
    w_scale: float = quantity(1.0, "rad/s", above=0)
    slowest: float = quantity(0.05, "m/s", least=1e-3)  # below it the gain of y_e fades
    catch_up: float = quantity(0.3, "m/s", least=0)  # up to it a robot's own speed counts, where it is the greater
    feed_forward: FeedForward = "full"  # none: without v_d cos ψ_e and ω_d in the commands

    equation, derived = regulate, WeightColumns
    knows = ("reference", "reference velocity", "wheel speeds")

    def derive(self, setting: Setting) -> Mapping[str, Any]:
        """The weights by Bryson's rule."""
        scales = self.x_scale, self.y_scale, self.heading_scale, self.v_scale, self.w_scale
        return dict(zip(WeightColumns.columns, (scale**-2 for scale in scales), strict=True))
