"""What references demand of robots: the greatest speeds along them against what the robots can do."""

from collections.abc import Sequence
from typing import Literal, NamedTuple

import numpy as np

from robotics.world.paths.trajectory import Trajectory
from robotics.world.vehicle.plant import STEP
from robotics.world.vehicle.robot import Robot

Limit = Literal["wheels", "speed", "turn rate"]
_MOST_SAMPLES = 100_000


class Demand(NamedTuple):
    """The greatest demand of one kind along one robot's reference."""

    robot: int  # from 0
    limit: Limit
    need: float  # m/s; of a turn rate rad/s
    most: float  # what the robot can do, in the same unit
    time: float  # s: when it is needed
    x: float  # m: where
    y: float  # m
    s: float  # m: the abscissa there

    @property
    def reserve(self) -> float:
        """The share of what the robot can do that is left; < 0: the reference is infeasible."""
        return 1 - self.need / self.most

    @property
    def feasible(self) -> bool:
        """Whether a command can follow; what rounding makes of an exact limit is forgiven."""
        return self.need <= self.most * (1 + 1e-9)

    @property
    def words(self) -> str:
        """The demand beside the limit, such as "|v| = 0.9 m/s exceeds v_max = 0.8 m/s by 0.1 (12.5 %)"."""
        what, name, unit = {
            "wheels": ("|v| + L |ω|", "r ω_wheel", "m/s"),
            "speed": ("|v|", "v_max", "m/s"),
            "turn rate": ("|ω|", "w_max", "rad/s"),
        }[self.limit]
        beyond = f"by {self.need - self.most:.3g} ({100 * (self.need / self.most - 1):.1f} %)"
        return f"{what} = {self.need:.4g} {unit} exceeds {name} = {self.most:.4g} {beyond}"


def demands(robots: Sequence[Robot], trajectory: Trajectory, duration: float) -> list[Demand]:
    """The greatest demands on each robot's wheels, speed and turn rate: |v| + L |ω|, |v| and |ω|.

    Args:
        robots: The robots.
        trajectory: Their references.
        duration: Of the run [s]; what comes after it is not demanded.
    """
    # The times are 10 ms apart, not a period: a sharp corner lasts no longer.
    span = min(duration, trajectory.ends.max())
    times = np.linspace(0.0, span, min(round(span / STEP), _MOST_SAMPLES) + 1)
    reference = trajectory.sampled(times)
    found = []
    for i, robot in enumerate(robots):
        v, w = np.abs(reference.v[:, i]), np.abs(reference.w[:, i])
        limits: tuple[tuple[Limit, np.ndarray, float], ...] = (
            ("wheels", v + robot.half_axle * w, robot.wheel_speed_limit),
            ("speed", v, robot.v_max),
            ("turn rate", w, robot.w_max),
        )
        for limit, need, most in limits:
            k = int(np.argmax(need))
            place = (float(row[k, i]) for row in (reference.x, reference.y, reference.s))
            found.append(Demand(i, limit, float(need[k]), most, float(times[k]), *place))
    return found
