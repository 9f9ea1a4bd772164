"""The Lyapunov (Kanayama) tracking law, thesis 2.2.

    v = v_d cos ψ_e + K_x x_e                                   (2.30)
    ω = ω_d + |v_d| (K_y y_e + K_ψ sin ψ_e)                     (2.32)
    ω = ω_d + v_d K_y y_e + K_ψ sin ψ_e                         (2.31)

with the errors of (5.9), desired − actual. From V = (x² + y²)/2 + (1 − cos ψ)/K_y  (2.33):

    V' = −K_x x² − (K_ψ/K_y) |v_d| sin² ψ  for (2.32);   −K_x x² − (K_ψ/K_y) sin² ψ  for (2.31).

Stable for K_x, K_y, K_ψ > 0; the errors converge as long as v_d does not go to 0 (Barbalat), from every start but
ψ_e = π exactly. Along the path the lateral error obeys wn = √K_y per metre with damping K_ψ / (2 √K_y) in the form
(2.32): the thesis's gains 1, 1, 1 converge slowly where the robot is slow; 1, 10, 5 has damping 0.79.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from fuzzy.compiled.jit import inner, kernel
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
    X,
    Y,
    equation,
)
from robotics.laws.law import ControllerError
from robotics.laws.setting import Setting
from robotics.paths.posture import wrapped_compiled
from robotics.quantity import check_quantities, quantity

KX, KY, KPSI, CATCH_UP, FORM_2_32, FULL, CORRECTED = range(7)  # places of the gains
GAINS = 7


@inner
def track(x, y, heading, to_x, to_y, to_heading, v_d, w_d, gains, at, g):  # type: ignore[no-untyped-def]
    """v [m/s] and ω [rad/s] by which a robot at a posture tracks a target that moves with v_d and ω_d.

    Its gains begin at row ``at`` of column ``g`` of ``gains``.
    """
    dx, dy = to_x - x, to_y - y
    cos, sin = math.cos(heading), math.sin(heading)
    sign = 2 * gains[at + CORRECTED, g] - 1
    x_e, y_e = sign * (cos * dx + sin * dy), sign * (cos * dy - sin * dx)  # (5.9)
    psi_e = wrapped_compiled(to_heading - heading)
    v = gains[at + FULL, g] * v_d * math.cos(psi_e) + gains[at + KX, g] * x_e  # (2.30)
    lateral, turning = gains[at + KY, g] * y_e, gains[at + KPSI, g] * sign * math.sin(psi_e)
    speed = max(abs(v_d), min(abs(v), gains[at + CATCH_UP, g]))
    faster = w_d + speed * (lateral + turning)  # (2.32)
    plain = w_d + v_d * lateral + turning  # (2.31)
    return v, faster if gains[at + FORM_2_32, g] > 0 else plain


@kernel
def _of_errors(errors, v_d, w_d, gains):  # type: ignore[no-untyped-def]
    """The velocities of robots that see a target at ``errors`` (n, 3) from themselves."""
    found = np.empty((2, len(errors)))
    for n in range(len(errors)):
        x, y, heading = errors[n, 0], errors[n, 1], errors[n, 2]
        found[0, n], found[1, n] = track(0.0, 0.0, 0.0, x, y, heading, v_d[n], w_d[n], gains, 0, 0)
    return found


@equation
def lyapunov(i, known, memory, command, work):  # type: ignore[no-untyped-def]
    """Track the reference."""
    seen = known.seen
    v, w = track(
        seen[X, i], seen[Y, i], seen[HEADING, i],
        seen[AT_X, i], seen[AT_Y, i], seen[AT_HEADING, i], seen[AT_V, i], seen[AT_W, i],
        known.gains, 0, known.column[i],
    )  # fmt: skip
    command[FIRST, i] = command[WISH_V, i] = v
    command[SECOND, i] = command[WISH_W, i] = w


@dataclass(frozen=True, kw_only=True)
class Lyapunov(EquationLaw):
    """Gains and form of the Lyapunov law. Default: the tuned gains, (2.32), lateral feedback kept at standstill."""

    kx: float = quantity(1.0, "1/s", above=0)
    ky: float = quantity(10.0, "1/m²", above=0)
    kpsi: float = quantity(5.0, "1/m", above=0)  # in the form "2.31": 1/s
    form: Literal["2.31", "2.32"] = "2.32"
    # |v_d| → max(|v_d|, min(|v|, catch_up)): lateral feedback also while catching up with a reference at rest
    catch_up: float = quantity(0.3, "m/s", least=0)
    # "none": without v_d in (2.30); the robot then trails by v_d/K_x, which is what thesis Table 5.7 shows
    feed_forward: Literal["full", "none"] = "full"
    signs: Literal["corrected", "literal"] = "corrected"  # literal: the errors as (2.28) prints them; diverges

    def __post_init__(self) -> None:
        check_quantities(self, ControllerError)

    knows = ("reference", "reference velocity")
    equation = lyapunov

    def velocities(self, errors: np.ndarray, v_d: np.ndarray, w_d: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return v [m/s] and ω [rad/s] (n,) for tracking errors (n, 3) of (5.9): x [m], y [m], heading [rad].

        ``v_d`` [m/s] and ``w_d`` [rad/s] are the target's (n,).
        """
        gains = np.array(self.gain_rows(), dtype=float)[:, None]
        v, w = _of_errors(np.ascontiguousarray(errors, dtype=float), v_d, w_d, gains)
        return v, w

    def gain_rows(self, setting: Setting | None = None) -> Sequence[float]:
        """The gains in the order that :func:`track` reads them."""
        options = self.form == "2.32", self.feed_forward == "full", self.signs == "corrected"
        return self.kx, self.ky, self.kpsi, self.catch_up, *map(float, options)
