"""The Lyapunov (Kanayama) tracking law, thesis 2.2.

    v = v_d cos ψ_e + K_x x_e                                   (2.30)
    ω = ω_d + |v_d| (K_y y_e + K_ψ sin ψ_e)                     (2.32)
    ω = ω_d + v_d K_y y_e + K_ψ sin ψ_e                         (2.31)

with the errors of (5.9), desired − actual. From V = (x² + y²)/2 + (1 − cos ψ)/K_y  (2.33):

    V' = −K_x x² − (K_ψ/K_y) |v_d| sin² ψ  for (2.32);   −K_x x² − (K_ψ/K_y) sin² ψ  for (2.31).

Stable for K_x, K_y, K_ψ > 0; the errors converge as long as v_d does not go to 0 (Barbalat), from every start but
ψ_e = π exactly. Along the path the cross-track error obeys wn = √K_y per metre with damping K_ψ / (2 √K_y) in the form
(2.32): the thesis's gains 1, 1, 1 converge slowly where the robot is slow; 1, 10, 5 has damping 0.79.
"""

import math
from dataclasses import dataclass
from typing import Literal

import numpy as np

from fuzzy.compiled.columns import codes
from fuzzy.compiled.jit import compiled_only, kernel
from fuzzy.quantity import quantity
from robotics.laws.equation import AimColumns, EquationLaw, RobotColumns, equation, gain_columns
from robotics.world.paths.posture import wrapped_compiled

Form = Literal["2.31", "2.32"]
FeedForward = Literal["full", "none"]
Signs = Literal["corrected", "literal"]
_FORM, FEED_FORWARD, SIGNS = codes(Form), codes(FeedForward), codes(Signs)


@compiled_only
def track(robot: RobotColumns, aim: AimColumns, gain):  # type: ignore[no-untyped-def]
    """v [m/s] and ω [rad/s] by which a robot at a posture tracks an aim that moves."""
    dx, dy = aim.x - robot.x, aim.y - robot.y
    cos, sin = math.cos(robot.heading), math.sin(robot.heading)
    sign = 1.0 if gain.signs == SIGNS.corrected else -1.0
    x_e, y_e = sign * (cos * dx + sin * dy), sign * (cos * dy - sin * dx)  # (5.9)
    psi_e = wrapped_compiled(aim.heading - robot.heading)
    v_d = aim.v if gain.feed_forward == FEED_FORWARD.full else 0.0
    v = v_d * math.cos(psi_e) + gain.kx * x_e  # (2.30)
    lateral, turning = gain.ky * y_e, gain.kpsi * sign * math.sin(psi_e)
    speed = max(abs(aim.v), min(abs(v), gain.catch_up))
    faster = aim.w + speed * (lateral + turning)  # (2.32)
    plain = aim.w + aim.v * lateral + turning  # (2.31)
    return v, faster if gain.form == _FORM.form_2_32 else plain


@equation
def lyapunov(robot, aim, gain):  # type: ignore[no-untyped-def]
    """Track the reference."""
    return track(robot, aim, gain)


@dataclass(frozen=True, kw_only=True)
class Lyapunov(EquationLaw):
    """Gains and form of the Lyapunov law. Default: the tuned gains, (2.32), lateral feedback kept at standstill."""

    kx: float = quantity(1.0, "1/s", above=0)
    ky: float = quantity(10.0, "1/m²", above=0)
    kpsi: float = quantity(5.0, "1/m", above=0)  # in the form "2.31": 1/s
    form: Form = "2.32"
    # |v_d| → max(|v_d|, min(|v|, catch_up)): lateral feedback also while catching up with a reference at rest
    catch_up: float = quantity(0.3, "m/s", least=0)
    # "none": without v_d in (2.30); the robot then trails by v_d/K_x, which is what thesis Table 5.7 shows
    feed_forward: FeedForward = "full"
    signs: Signs = "corrected"  # literal: the errors as (2.28) prints them; diverges

    knows = ("reference", "reference velocity")
    equation = lyapunov

    def velocities(self, errors: np.ndarray, v_d: np.ndarray, w_d: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return v [m/s] and ω [rad/s] (n,) for tracking errors (n, 3) of (5.9): x [m], y [m], heading [rad].

        ``v_d`` [m/s] and ``w_d`` [rad/s] are the target's (n,).
        """
        found = _of_errors(
            np.ascontiguousarray(errors.T, dtype=float), np.array([v_d, w_d], dtype=float), self.gain_array()
        )
        return found[0], found[1]


@kernel
def _of_errors(errors, moving, gains):  # type: ignore[no-untyped-def]
    """The velocities of robots that see an aim at ``errors`` (3, n), which moves with v_d and ω_d (2, n)."""
    found, here, aims = np.empty((2, errors.shape[1])), np.zeros((5, 1)), np.empty((6, 1))
    robot, aim, gain = RobotColumns(here, 0), AimColumns(aims, 0), Gain(gains, 0)
    for n in range(errors.shape[1]):
        aim.x, aim.y, aim.heading = errors[0, n], errors[1, n], errors[2, n]
        aim.v, aim.w = moving[0, n], moving[1, n]
        found[0, n], found[1, n] = track(robot, aim, gain)
    return found


Gain = gain_columns(Lyapunov)
