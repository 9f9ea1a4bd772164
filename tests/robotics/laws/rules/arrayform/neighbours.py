"""What robots have heard of each other, and who is level with whom, of all robots at once."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from robotics.laws.avoidance.planned_way import PlannedTiming
from robotics.laws.teams.neighbours import OUTAGE, SEARCH_REACH, SEARCH_REACH_AFTER_OUTAGE
from robotics.world.paths.joined import PathTable
from robotics.world.paths.references import References
from robotics.world.paths.road import CELLS
from robotics.world.radio.channel import Heard


def smallest_heard(mine: np.ndarray, theirs: np.ndarray, hears: np.ndarray) -> np.ndarray:
    """The smallest of a robot's own value and its neighbours' that were heard (runs, robots).

    ``mine`` is (runs, robots) or one for all, ``theirs`` (runs, receivers, senders), ``hears`` (receivers, senders)
    bool.
    """
    return np.asarray(np.minimum(mine, np.fmin.reduce(np.where(hears, theirs, np.inf), axis=-1)))


def alone_for(heard: Heard, time: float) -> np.ndarray:
    """The time [s] (runs, robots) since the newest message that each robot heard was sent, at most ``time`` [s]."""
    return smallest_heard(np.asarray(time), heard.age, heard.hears)


def search_reach(heard: Heard, time: float) -> np.ndarray:
    """The distance [m] (runs, robots) from its last place within which each robot looks for the next on its path."""
    return np.where(alone_for(heard, time) > OUTAGE, SEARCH_REACH_AFTER_OUTAGE, SEARCH_REACH)


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
            return np.asarray(stretches(self.joined, share) / np.interp(share, *self.joined.shares[0]))
        ways = self.joined.lengths - self.begin
        return np.broadcast_to(ways / ways[..., :1], np.shape(s))


def level_places(paths: PathTable, s: np.ndarray) -> np.ndarray:
    """The abscissae [m] (runs, robots, robots) on all paths, the last axis, level with ``s`` (runs, robots)."""
    share = paths.share(s)[:, :, None]
    if paths.shares is None:
        return np.asarray(share * paths.lengths[..., None, :])
    return paths.place(np.broadcast_to(share, (*s.shape, s.shape[1])))


def planned_share(plan: PlannedTiming, times: np.ndarray) -> np.ndarray:
    """Each robot's planned share of its path at ``times`` (runs, rows, robots) [s]."""
    last = plan.progress.shape[-1] - 1
    tick = np.clip(times / plan.durations[..., None] * CELLS, 0.0, last - 1e-9)
    k = tick.astype(int)
    run = np.arange(len(times))[:, None, None] % len(plan.progress)
    robot = np.arange(times.shape[2])
    a, b = plan.progress[run, robot, k], plan.progress[run, robot, k + 1]
    return np.asarray(a + (tick - k) * (b - a))


def stretches(paths: PathTable, share: np.ndarray) -> np.ndarray:
    """The way [m] on each path for each unit of progress, at ``share`` (..., robots): the lengths, or nearly so."""
    assert paths.shares is not None
    return np.stack([np.interp(share[..., i], *curve) for i, curve in enumerate(paths.shares)], axis=-1)
