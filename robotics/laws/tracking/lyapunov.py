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

from dataclasses import dataclass
from typing import Literal

import numpy as np

from robotics.laws.law import Command, ControllerError, Law, Observation
from robotics.laws.setting import Setting
from robotics.paths.posture import posture_error
from robotics.quantity import check_quantities, quantity


@dataclass(frozen=True, kw_only=True)
class Lyapunov(Law[None]):
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

    def init(self, setting: Setting, runs: int) -> None:
        """Remember nothing."""

    def control(self, seen: Observation, memory: None, dt: float) -> tuple[Command, None]:
        """Command (2.30) with (2.31) or (2.32)."""
        target = seen.reference
        e = posture_error(seen.x, seen.y, seen.heading, target)
        sign = 1.0 if self.signs == "corrected" else -1.0
        x, y, sin = sign * e.x, sign * e.y, sign * np.sin(e.heading)
        ahead = 1.0 if self.feed_forward == "full" else 0.0
        v = ahead * target.v * np.cos(e.heading) + self.kx * x  # (2.30)
        if self.form == "2.32":
            speed = np.maximum(np.abs(target.v), np.minimum(np.abs(v), self.catch_up))
            w = target.w + speed * (self.ky * y + self.kpsi * sin)  # (2.32)
        else:
            w = target.w + target.v * self.ky * y + self.kpsi * sin  # (2.31)
        return Command(v, w, v, w), None
