"""A law and a metric of one's own."""

from dataclasses import dataclass

import numpy as np

from fuzzy.quantity import quantity
from robotics import Command, Law, Observation, Run, Setting, metric
from robotics.world.paths.posture import posture_error


@dataclass(frozen=True, kw_only=True)
class Stanley(Law[None]):
    """Steer by the heading error and the arctangent of the lateral error [Hoffmann et al. 2007].

    v = v_d cos ψ_e + pull x_e,  ω = ω_d + turn (ψ_e + arctan(k y_e / max(|v|, slow)))
    """

    k: float = quantity(1.5, "1/s", above=0, doc="How fast the lateral error goes to 0.")
    turn: float = quantity(3.0, "1/s", above=0, doc="How fast the robot turns to where it wants to head.")
    pull: float = quantity(1.0, "1/s", least=0, doc="How fast it catches up along the path.")
    slow: float = quantity(0.1, "m/s", above=0, doc="The speed below which the steering becomes no sharper.")

    def init(self, setting: Setting, runs: int) -> None:
        """Remember nothing."""

    def control(self, seen: Observation, memory: None, dt: float) -> tuple[Command, None]:
        """Command v and ω."""
        e = posture_error(seen.x, seen.y, seen.heading, seen.reference)
        v = seen.reference.v * np.cos(e.heading) + self.pull * e.x
        aim = e.heading + np.arctan2(self.k * e.y, np.maximum(np.abs(v), self.slow))
        w = seen.reference.w + self.turn * aim
        return Command(v, w, v, w), None


@metric(unit="rad", title="swerving: how far the robot turns in all, left and right, minus how far the reference does")
def swerving_rad(run: Run) -> np.ndarray:
    """Turning [rad] (runs, robots) that the path does not ask for."""
    turned = np.nansum(np.abs(np.diff(run["heading"], axis=-1)), axis=-1)
    asked = np.abs(np.diff(np.unwrap(run.target("heading"), axis=-1), axis=-1)).sum(axis=-1)
    return np.asarray(turned - asked)
