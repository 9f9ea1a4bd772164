"""References of many robots at once: the protocol that the trajectories of one scenario and of many share."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Protocol

import numpy as np

from robotics.paths.joined import PathTable
from robotics.paths.road import TIMED, Road, road_of, rows_at
from robotics.paths.trajectory import Reference, Trajectory


class References(Protocol):
    """The places where every robot shall be, and when.

    The shape ``robots`` below is (robots,), or (runs, robots) where each run has its own references.
    """

    @property
    def joined(self) -> PathTable:
        """The paths of all robots in one table; its lengths [m] have the shape ``robots``."""
        ...

    @property
    def ends(self) -> np.ndarray:
        """The times [s] at which the references reach the ends of their paths, of the shape ``robots``."""
        ...

    @property
    def road(self) -> Road:
        """The same as plain arrays, for compiled functions."""
        ...

    def at(self, time: float) -> Reference:
        """Every robot's reference at ``time`` [s]; each field has the shape ``robots``."""
        ...

    def each_at(self, times: np.ndarray) -> Reference:
        """Each robot's reference at a time of its own, ``times`` (runs, robots) [s]; each field is (runs, robots)."""
        ...


def sampled(references: References, times: np.ndarray) -> Reference:
    """The references of one run at ``times`` (n,) [s]; each field is (n, robots)."""
    times = np.asarray(times, dtype=float)
    return references.each_at(np.repeat(times[:, None], references.joined.lengths.size, axis=1))


def _by_run(road: Road, times: np.ndarray) -> Reference:
    """The references at ``times`` (runs, robots) [s] where each run has its own paths."""
    return Reference(*rows_at(road, np.ravel(times)).reshape(-1, *np.shape(times)))


@dataclass(frozen=True, eq=False)
class Later:
    """References whose time begins later: what is left of ``whole`` after ``time`` [s]."""

    whole: References
    time: float

    @property
    def joined(self) -> PathTable:
        """The paths, from their beginnings."""
        return self.whole.joined

    @property
    def ends(self) -> np.ndarray:
        """The times [s] at which the references reach the ends of their paths."""
        return self.whole.ends - self.time

    @cached_property
    def road(self) -> Road:
        """The same as plain arrays."""
        return self.whole.road._replace(since=self.whole.road.since + float(self.time))

    def at(self, time: float) -> Reference:
        """Every robot's reference at ``time`` [s]."""
        return self.whole.at(time + self.time)

    def each_at(self, times: np.ndarray) -> Reference:
        """Each robot's reference at a time of its own, ``times`` (runs, robots) [s]."""
        return self.whole.each_at(times + self.time)


@dataclass(frozen=True, eq=False)
class EvenTiming:
    """Paths that are driven at constant speed; each run has its own paths and its own duration."""

    joined: PathTable  # lengths (runs, robots)
    durations: np.ndarray  # (runs,) s

    @property
    def ends(self) -> np.ndarray:
        """The times [s] (runs, robots) at which the references reach the ends of their paths."""
        return np.broadcast_to(self.durations[:, None], self.joined.lengths.shape)

    @cached_property
    def road(self) -> Road:
        """The same as plain arrays."""
        return road_of(self.joined, TIMED.evenly, self.ends, durations=self.durations[:, None])

    def at(self, time: float) -> Reference:
        """Every robot's reference at ``time`` [s]; each field is (runs, robots)."""
        return self.each_at(np.full(self.joined.lengths.shape, float(time)))

    def each_at(self, times: np.ndarray) -> Reference:
        """Each robot's reference at a time of its own, ``times`` (runs, robots) [s]."""
        return _by_run(self.road, times)


@dataclass(frozen=True, eq=False)
class SideBySide:
    """The trajectories of several scenarios, one for each run; to the last bit as each alone."""

    flat: Trajectory  # all robots of the first run, then those of the second ...
    joined: PathTable  # lengths (runs, robots)

    @property
    def ends(self) -> np.ndarray:
        """The times [s] (runs, robots) at which the references reach the ends of their paths."""
        return self.flat.ends.reshape(self.joined.lengths.shape)

    @cached_property
    def road(self) -> Road:
        """The same as plain arrays."""
        return self.flat.road

    def at(self, time: float) -> Reference:
        """Every robot's reference at ``time`` [s]; each field is (runs, robots)."""
        return self.each_at(np.full(self.joined.lengths.shape, float(time)))

    def each_at(self, times: np.ndarray) -> Reference:
        """Each robot's reference at a time of its own, ``times`` (runs, robots) [s]."""
        return _by_run(self.road, times)


def side_by_side(trajectories: Sequence[Trajectory]) -> SideBySide:
    """Join ``trajectories``, one for each run, which must have the same number of robots."""
    flat = Trajectory(
        tuple(path for t in trajectories for path in t.paths),
        np.concatenate([t.tables for t in trajectories]),
        np.concatenate([t.ends for t in trajectories]),
    )
    return SideBySide(flat, replace(flat.joined, lengths=flat.joined.lengths.reshape(len(trajectories), -1)))
