"""Goals: where a robot shall come to, and stay, at no stated time: a point, a posture, a region, or a moving point.

A goal at rest makes a lane for the quantities of rule bases that speak of a path: the straight line on which the robot
would come to it, which ends there in the goal's heading.
"""

from dataclasses import dataclass
from math import atan2, cos, hypot, sin

import numpy as np

from fuzzy.quantity import check_quantities, described, quantity, turn
from robotics.world.paths.path import Line, PathError, Shape
from robotics.world.paths.trajectory import Timing

_LANE = 1.0  # m: a lane is no shorter


@dataclass(frozen=True)
class Reach:
    """What counts as having come to a goal; a robot is in a region if its center is."""

    within: float  # m: of its center from the goal, without a region
    heading_within: float | None  # rad; None: any heading will do
    hold: float  # s: so long without a break
    region: tuple[tuple[float, float], ...] | None = None  # its corners [m]

    def outside(self, x: np.ndarray | float, y: np.ndarray | float) -> np.ndarray:
        """How far points (...) [m] lie outside the region [m], of their shape; 0 inside it."""
        ends = np.asarray(self.region)
        x, y = np.asarray(x)[..., None], np.asarray(y)[..., None]
        (ax, ay), (bx, by) = ends.T, np.roll(ends, -1, axis=0).T
        share = ((x - ax) * (bx - ax) + (y - ay) * (by - ay)) / np.maximum((bx - ax) ** 2 + (by - ay) ** 2, 1e-300)
        share = np.clip(share, 0.0, 1.0)
        away = np.hypot(x - ax - share * (bx - ax), y - ay - share * (by - ay)).min(axis=-1)
        with np.errstate(divide="ignore", invalid="ignore"):  # a side at one height is crossed by no ray
            crossed = ((ay > y) != (by > y)) & (x < ax + (y - ay) / (by - ay) * (bx - ax))
        return np.where(crossed.sum(axis=-1) % 2 == 1, 0.0, away)


@dataclass(frozen=True, kw_only=True)
class Goal:
    """Where a robot shall come to and stay.

    Raises:
        PathError: Neither a place nor a path, or both.
    """

    at: tuple[float, float] | None = described(
        "The point; of a region the mean of its corners if left out.", None, example=[2.0, 1.0]
    )
    heading: float | None = turn(None, doc="The heading in which it shall stand there; left out: any.", example=0.0)
    region: tuple[tuple[float, float], ...] | None = described(
        "The corners, one after the other, of a region in which its center shall come to lie.",
        None,
        example=[[1.5, 0.5], [2.5, 0.5], [2.5, 1.5], [1.5, 1.5]],
    )
    path: Shape | None = described("The path along which the goal moves, instead of a place.", None)
    timing: Timing | None = described("The timetable of the goal along its path.", None)
    within: float = quantity(0.05, "m", above=0, doc="How near its center shall come; of a region it is not used.")
    heading_within: float = turn(0.1, doc="How near its heading shall come, where there is one.")
    hold: float = quantity(1.0, "s", least=0, doc="How long it shall be there without a break to have reached it.")

    def __post_init__(self) -> None:
        check_quantities(self, PathError)
        if (self.path is None) != (self.timing is None):
            raise PathError("goal: path and timing belong together: a goal that moves needs both")
        if self.path is not None and any(n is not None for n in (self.at, self.heading, self.region)):
            raise PathError("goal: give a place (at, heading, region) or a path with its timing, not both")
        if self.path is None and self.at is None and self.region is None:
            raise PathError("goal: give a point, such as at = [2.0, 1.0], a region, or a path with its timing")
        if self.region is not None:
            if len(self.region) < 3:
                raise PathError(f"goal: a region needs three corners, got {len(self.region)}").about("region")
            if self.reach.outside(*self.point) > 0:
                what = f"goal: at must lie in the region, and {self.point} does not; a region may need a point of it"
                raise PathError(what).about("region" if self.at is None else "at")

    @property
    def point(self) -> tuple[float, float]:
        """The point [m] of a goal that rests."""
        if self.at is not None:
            return self.at
        assert self.region is not None
        x, y = np.mean(self.region, axis=0)
        return float(x), float(y)

    @property
    def reach(self) -> Reach:
        """What counts as having come to it."""
        angle = None if self.heading is None else self.heading_within
        return Reach(self.within, angle, self.hold, self.region)

    def motion(self, start: tuple[float, float, float]) -> tuple[Shape, Timing]:
        """The path and the timing of the reference of a robot with this goal.

        Args:
            start: Where it starts: x [m], y [m], heading [rad].
        """
        if self.path is not None:
            assert self.timing is not None
            return self.path, self.timing
        x, y = self.point
        way = hypot(x - start[0], y - start[1])
        heading = self.heading
        if heading is None:
            heading = atan2(y - start[1], x - start[0]) if way > 0 else start[2]
        length = max(way, _LANE)
        return Line(start=(x - length * cos(heading), y - length * sin(heading)), end=(x, y)), Timing(rest=True)
