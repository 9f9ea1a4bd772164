"""PID control of tracking: PI on the cross-track error, PD on the heading error, and PI along the path.

With the errors of (5.9), desired − actual in the robot's frame, of which y_e near the path is the cross-track error,

    v = v_d cos ψ_e + K_x x_e + I_x ∫ x_e dt
    ω = ω_d + K_y y_e + I_y ∫ y_e dt + K_ψ ψ_e + D_ψ ψ_e'

Near the path y_e' = v ψ_e: the heading error is the derivative of the cross-track error, only less noisy, so that the
four terms of ω are one PID chain, and D_ψ is its second derivative, which shortens the wheel lag τ to τ / (1 + D_ψ).
Without that lag and the derivative's filter, the closed loop's characteristic polynomials at a speed v are

    s² + K_x s + I_x                       and        (1 + D_ψ) s³ + K_ψ s² + v K_y s + v I_y

The default gains place all poles at −p, p = 1 1/s, at v = 0.3 m/s: K_x = 2p, I_x = p², K_ψ = 3p (1 + D_ψ),
K_y = 3p² (1 + D_ψ) / v, I_y = p³ (1 + D_ψ) / v; a third of the rate at which the loop of ψ then crosses, 3p, in keeping
with the 0.1 s that control period, latency and wheels take (a phase of 0.3 rad there). D_ψ = 1/2 leaves the loop of
the derivative a gain margin of 2 however late the wheels are. :func:`placed` makes the gains for another p.

Stability: the linearised loop is stable at every speed v > 0 if and only if K_ψ K_y > (1 + D_ψ) I_y (Hurwitz), with
K_x, I_x > 0; from afar convergence is shown by sampling, not proved.

Chosen here: ψ_e' is filtered by a first-order low-pass of the time T_f. Each integral's part of the command is held
within a bound, and stands still while the command is beyond what the wheels can do, or the error beyond ``band``
(anti-windup, and no integral of the way to the path). At rest y_e cannot be controlled: below ``slowest`` its terms
fade with the speed, which is the reference's or, when it catches up with one at rest, the robot's own, up to
``catch_up``; their sign is that of the reference's speed.

It knows the posture, the speed by the encoders and the reference at the present time; not the wheel lag, the latency,
or what the path does ahead.
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from fuzzy.compiled.columns import Columns, column, within
from fuzzy.compiled.jit import compiled_only
from fuzzy.quantity import quantity
from robotics.laws.equation import EquationLaw, equation
from robotics.laws.setting import Setting
from robotics.laws.tracking.lyapunov import FEED_FORWARD, FeedForward
from robotics.world.paths.posture import wrapped_compiled
from robotics.world.vehicle.plant import LimitColumns, velocity_limits, within_limits


class PIDMemory(Columns):
    """What the law remembers."""

    along = column("m s", "∫ x_e dt")
    aside = column("m s", "∫ y_e dt")
    before = column("rad", "the heading error of the period before; not-a-number: there was none")
    rate = column("rad/s", "of the heading error, filtered")


class PIDDerived(Columns):
    """What the law reads of its robot."""

    limit = within(LimitColumns)


def placed(p: float, speed: float, dpsi: float = 0.5) -> dict[str, float]:
    """The gains kx, ix, ky, iy, kpsi that place all poles at −``p`` [1/s] at a ``speed`` [m/s], for a ``dpsi``."""
    lateral = 1 + dpsi
    return {
        "kx": 2 * p,
        "ix": p**2,
        "ky": 3 * p**2 * lateral / speed,
        "iy": p**3 * lateral / speed,
        "kpsi": 3 * p * lateral,
    }


@compiled_only
def integrated(integral, error, gain, most, band, dt, free):  # type: ignore[no-untyped-def]
    """An integral [m s] a period on, its part of the command held to ``most``; it stands unless the command is free."""
    if not free or abs(error) > band or gain == 0:
        return integral
    bound = most / gain
    return min(max(integral + dt * error, -bound), bound)


@equation
def pid(robot, aim, gain, memory, dt):  # type: ignore[no-untyped-def]
    """Command the sums of the terms."""
    dx, dy = aim.x - robot.x, aim.y - robot.y
    cos, sin = math.cos(robot.heading), math.sin(robot.heading)
    x_e, y_e = cos * dx + sin * dy, cos * dy - sin * dx  # (5.9)
    psi_e = wrapped_compiled(aim.heading - robot.heading)
    forward = 1.0 if gain.feed_forward == FEED_FORWARD.full else 0.0
    v_d, w_d = forward * aim.v, forward * aim.w
    if not math.isnan(memory.before):
        rate = wrapped_compiled(psi_e - memory.before) / dt
        memory.rate += dt / (gain.filter_time + dt) * (rate - memory.rate)
    memory.before = psi_e
    forwards = aim.v if aim.v != 0 else robot.v
    speed = max(abs(aim.v), min(abs(robot.v), gain.catch_up))
    share = math.copysign(min(speed / gain.slowest, 1.0), forwards)
    v = v_d * math.cos(psi_e) + gain.kx * x_e + gain.ix * memory.along
    w = w_d + share * (gain.ky * y_e + gain.iy * memory.aside)
    w += gain.kpsi * psi_e + gain.dpsi * memory.rate
    can_v, can_w = within_limits(gain.limit, v, w)
    free = can_v == v and can_w == w
    memory.along = integrated(memory.along, x_e, gain.ix, gain.most_v, gain.band, dt, free)
    memory.aside = integrated(memory.aside, abs(share) * y_e, gain.iy, gain.most_w, gain.band, dt, free)
    return v, w


@dataclass(frozen=True, kw_only=True)
class TrackingPID(EquationLaw):
    """PID control: the gains of the three errors, the filter, and the bounds of the integrals.

    The defaults are ``placed(1.0, 0.3)``.
    """

    kx: float = quantity(2.0, "1/s", least=0)
    ix: float = quantity(1.0, "1/s²", least=0)
    ky: float = quantity(15.0, "rad/(m s)", least=0)
    iy: float = quantity(5.0, "rad/(m s²)", least=0)
    kpsi: float = quantity(4.5, "1/s", least=0)
    dpsi: float = quantity(0.5, "1", least=0)
    filter_time: float = quantity(0.1, "s", least=0)  # T_f: two control periods
    # Anti-windup. The bounds are what wheels that turn a tenth too slowly take at 0.5 m/s and 1 rad/s
    band: float = quantity(0.1, "m", least=0)  # an error beyond it is not integrated
    most_v: float = quantity(0.05, "m/s", least=0)  # I_x ∫ x_e dt is held within it
    most_w: float = quantity(0.1, "rad/s", least=0)  # I_y ∫ y_e dt is held within it
    slowest: float = quantity(0.05, "m/s", least=1e-3)  # below it the terms of y_e fade
    catch_up: float = quantity(0.3, "m/s", least=0)  # up to it a robot's own speed counts, where it is the greater
    feed_forward: FeedForward = "full"  # none: without v_d cos ψ_e and ω_d

    equation = pid
    remembers, derived = PIDMemory, PIDDerived
    knows = ("reference", "reference velocity", "wheel speeds")

    def derive(self, setting: Setting) -> Mapping[str, Any]:
        """The limits of the velocities."""
        return {"limit": velocity_limits(setting.robots)}

    def begin(self, setting: Setting, runs: int) -> np.ndarray:
        """Begin with integrals of 0, and nothing known of a period before."""
        memory = PIDMemory.zeros(runs, len(setting.robots))
        memory.before = np.nan
        return memory.array
