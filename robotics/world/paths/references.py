"""References of many robots at once: the places where they shall be, and when.

Those of one scenario are a :class:`robotics.world.paths.trajectory.Trajectory`.
"""

from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np

from robotics.world.paths.joined import PathTable
from robotics.world.paths.road import TIMED, Road, road_of, rows_at


class Reference(NamedTuple):
    """The moving target of every robot at one time; each field is (robots,)."""

    x: np.ndarray  # m
    y: np.ndarray  # m
    heading: np.ndarray  # rad, continuous
    v: np.ndarray  # m/s
    w: np.ndarray  # rad/s
    s: np.ndarray  # m, the abscissa on the robot's path


@dataclass(frozen=True, eq=False)
class References:
    """The places where every robot shall be, and when.

    The shape ``robots`` below is (robots,), or (runs, robots) where each run has its own references.

    Attributes:
        joined: The paths of all robots in one table; its lengths [m] have the shape ``robots``.
        ends: The times [s] at which the references reach the ends of their paths, of the shape ``robots``.
        road: The same as plain arrays, for compiled functions.
    """

    joined: PathTable = field(repr=False)
    ends: np.ndarray = field(repr=False)
    road: Road = field(repr=False)

    def at(self, time: float) -> Reference:
        """Every robot's reference at ``time`` [s], of the shape ``robots``; after its end a reference rests there."""
        return self.each_at(np.full(self.joined.lengths.shape, float(time)))

    def each_at(self, times: np.ndarray) -> Reference:
        """Each robot's reference at a time of its own, ``times`` (..., robots) [s]; each field has that shape."""
        return Reference(*rows_at(self.road, times))

    def sampled(self, times: np.ndarray) -> Reference:
        """The references of one run at ``times`` (n,) [s]; each field is (n, robots)."""
        times = np.asarray(times, dtype=float)
        return self.each_at(np.repeat(times[:, None], self.joined.lengths.size, axis=1))


def later(references: References, time: float) -> References:
    """What is left of ``references`` after ``time`` [s], which is then their time 0."""
    road = references.road
    return References(references.joined, references.ends - time, road._replace(since=road.since + float(time)))


def even_timing(joined: PathTable, durations: np.ndarray) -> References:
    """Paths of lengths (runs, robots) that are driven at constant speed, each run's in its duration (runs,) [s]."""
    ends = np.broadcast_to(durations[:, None], joined.lengths.shape)
    return References(joined, ends, road_of(joined, TIMED.evenly, ends, durations=durations[:, None]))
