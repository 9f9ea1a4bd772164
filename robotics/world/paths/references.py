"""References of many robots at once: the places where they shall be, and when.

Those of one scenario are a :class:`robotics.world.paths.trajectory.Trajectory`.
"""

from dataclasses import dataclass, field
from functools import cached_property
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


@dataclass(frozen=True, eq=False)
class Level:
    """The level places of robots: who of a formation stands beside whom, on paths of any shape, also closed ones.

    Robots are level with each other at equal shares of their ways. In a formation by offsets
    (:mod:`robotics.world.paths.offset`) the share is that of the virtual path; on other paths it is that of a robot's
    own path from where its reference begins, σ = (s − s_0)/(length − s_0), which goes on below 0 on what lies before.
    Robot 1, the first in every array, leads.
    """

    joined: PathTable
    begin: np.ndarray  # m, as the table's lengths: the abscissae at which the references begin

    @classmethod
    def of(cls, references: References) -> "Level":
        """The level places on the paths of ``references``."""
        return cls(references.joined, references.at(-references.road.since).s)

    @cached_property
    def _leader_nodes(self) -> np.ndarray:
        """The abscissae of the nodes of the leader's path [m]."""
        return np.linspace(0.0, float(self.joined.lengths[0]), int(self.joined.cells[0]) + 1)

    def share(self, s: np.ndarray) -> np.ndarray:
        """The shares of the ways, of robots at the abscissae ``s`` (..., robots) [m]."""
        if self.joined.shares is not None:
            return self.joined.share(s)
        return np.asarray((s - self.begin) / (self.joined.lengths - self.begin))

    def place(self, share: np.ndarray) -> np.ndarray:
        """The abscissae [m] of all robots at the shares ``share`` (..., robots); what :meth:`share` inverts."""
        if self.joined.shares is not None:
            return self.joined.place(share)
        return np.asarray(self.begin + share * (self.joined.lengths - self.begin))

    def on_leader(self, s: np.ndarray) -> np.ndarray:
        """The abscissae [m] on the leader's path that are level with robots at ``s`` (..., robots) [m]."""
        share = self.share(s)
        if self.joined.shares is not None:
            shares = self.joined.shares[0][0]
            return np.interp(share, shares, self._leader_nodes)
        begin, length = self.begin[..., :1], self.joined.lengths[..., :1]
        return np.asarray(begin + share * (length - begin))

    def stretch(self, s: np.ndarray) -> np.ndarray:
        """The way on each robot's path for each metre of the leader's, of robots at ``s`` (..., robots) [m]."""
        if self.joined.shares is not None:
            share = self.joined.share(s)
            return np.asarray(self.joined.stretch(share) / np.interp(share, *self.joined.shares[0]))
        ways = self.joined.lengths - self.begin
        return np.broadcast_to(ways / ways[..., :1], np.shape(s))
