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
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np

from fuzzy.compiled.jit import inner
from robotics.laws.equation import (
    AT_HEADING,
    AT_V,
    AT_W,
    AT_X,
    AT_Y,
    FIRST,
    HEADING,
    SECOND,
    WISH_V,
    WISH_W,
    EquationLaw,
    V,
    X,
    Y,
    equation,
)
from robotics.laws.law import ControllerError
from robotics.laws.setting import Setting
from robotics.paths.posture import wrapped_compiled
from robotics.quantity import check_quantities, quantity
from robotics.vehicle.plant import velocity_limits, within

# Places of the gains: first the limits of the velocities
LIMITS, KX, IX, KY, IY, KPSI, DPSI, FILTER, BAND, MOST_V, MOST_W, SLOWEST, CATCH_UP, FULL = 0, *range(4, 17)
# Places of what is remembered: the integrals [m s], the heading error of the period before [rad], and its rate [rad/s]
ALONG, ASIDE, BEFORE, RATE = range(4)


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


@inner
def integrated(integral, error, gain, most, band, dt, free):  # type: ignore[no-untyped-def]
    """An integral [m s] a period on, its part of the command held to ``most``; it stands unless the command is free."""
    if not free or abs(error) > band or gain == 0:
        return integral
    bound = most / gain
    return min(max(integral + dt * error, -bound), bound)


@equation
def pid(i, known, memory, command, work):  # type: ignore[no-untyped-def]
    """Command the sums of the terms."""
    seen, gains, g, dt = known.seen, known.gains, known.column[i], known.dt
    dx, dy = seen[AT_X, i] - seen[X, i], seen[AT_Y, i] - seen[Y, i]
    cos, sin = math.cos(seen[HEADING, i]), math.sin(seen[HEADING, i])
    x_e, y_e = cos * dx + sin * dy, cos * dy - sin * dx  # (5.9)
    psi_e = wrapped_compiled(seen[AT_HEADING, i] - seen[HEADING, i])
    v_d, w_d = gains[FULL, g] * seen[AT_V, i], gains[FULL, g] * seen[AT_W, i]
    if not math.isnan(memory[BEFORE, i]):
        rate = wrapped_compiled(psi_e - memory[BEFORE, i]) / dt
        memory[RATE, i] += dt / (gains[FILTER, g] + dt) * (rate - memory[RATE, i])
    memory[BEFORE, i] = psi_e
    forwards = seen[AT_V, i] if seen[AT_V, i] != 0 else seen[V, i]
    speed = max(abs(seen[AT_V, i]), min(abs(seen[V, i]), gains[CATCH_UP, g]))
    share = math.copysign(min(speed / gains[SLOWEST, g], 1.0), forwards)
    v = v_d * math.cos(psi_e) + gains[KX, g] * x_e + gains[IX, g] * memory[ALONG, i]
    w = w_d + share * (gains[KY, g] * y_e + gains[IY, g] * memory[ASIDE, i])
    w += gains[KPSI, g] * psi_e + gains[DPSI, g] * memory[RATE, i]
    can_v, can_w = within(gains, g, v, w)
    free = can_v == v and can_w == w
    memory[ALONG, i] = integrated(memory[ALONG, i], x_e, gains[IX, g], gains[MOST_V, g], gains[BAND, g], dt, free)
    aside = abs(share) * y_e
    memory[ASIDE, i] = integrated(memory[ASIDE, i], aside, gains[IY, g], gains[MOST_W, g], gains[BAND, g], dt, free)
    command[FIRST, i] = command[WISH_V, i] = v
    command[SECOND, i] = command[WISH_W, i] = w


@dataclass(frozen=True, kw_only=True)
class PID(EquationLaw):
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
    feed_forward: Literal["full", "none"] = "full"  # none: without v_d cos ψ_e and ω_d

    def __post_init__(self) -> None:
        check_quantities(self, ControllerError)

    equation = pid
    knows = ("reference", "reference velocity", "wheel speeds")

    def gain_rows(self, setting: Setting) -> Sequence[Any]:
        """The limits and the gains, in the order of the places above."""
        gains = self.kx, self.ix, self.ky, self.iy, self.kpsi, self.dpsi, self.filter_time
        rest = self.band, self.most_v, self.most_w, self.slowest, self.catch_up
        return *velocity_limits(setting.robots), *gains, *rest, float(self.feed_forward == "full")

    def begin(self, setting: Setting, runs: int) -> np.ndarray:
        """Begin with integrals of 0, and nothing known of a period before."""
        rows = np.zeros((4, runs, len(setting.robots)))
        rows[BEFORE] = np.nan
        return rows
