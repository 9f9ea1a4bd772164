"""Metrics of avoidance: how robots that meet each other or obstacles fared; contacts are those of their true sizes."""

from dataclasses import dataclass

import numpy as np

from robotics.environment.swept import OBSTACLE, OTHER
from robotics.laws.modes import LEFT_BEHIND, STOPPED
from robotics.measures.arrival import arrival_time
from robotics.measures.clearance import clearances, robot_gaps
from robotics.measures.contacts import judge
from robotics.measures.standing import stands_still
from robotics.measures.tracking import cross_track_error
from robotics.simulation.run import Run

OFF_PATH = 0.1  # m: a robot farther from its path is off it
STARTING = 2.0  # s after the start in which a robot that stands still is not counted
STOPPING = 0.5  # s before its arrival in which it is not counted either


@dataclass(frozen=True, eq=False)
class AvoidanceMetrics:
    """The metrics of one seed of a team's run."""

    collided: bool  # two robots touched
    hit: bool  # a robot touched an obstacle
    nearest: float  # m between the centers of two robots
    clearance: float  # m between a robot's rectangle and an obstacle; infinite without obstacles
    arrivals: np.ndarray  # (robots,) s; infinite: never
    ratio: float  # the last arrival over the nominal duration; infinite if nobody arrives
    off: float  # m: the largest distance from a path
    away: float  # s: the longest time that a robot was off its path
    stood: tuple[float, ...]  # s, by robot: the longest time that it stood still on its way
    left: tuple[int, ...]  # robots, from 1, that the group went on without

    @property
    def arrived(self) -> tuple[bool, ...]:
        """Whether each robot arrived."""
        return tuple(np.isfinite(self.arrivals).tolist())

    @property
    def spread(self) -> float:
        """The time [s] between the first and the last arrival of those that arrive; infinite if nobody does."""
        there = self.arrivals[np.isfinite(self.arrivals)]
        return float(np.ptp(there)) if there.size else np.inf

    @property
    def safe(self) -> bool:
        """Whether nothing touched anything."""
        return not (self.collided or self.hit)


def avoidance_metrics(run: Run, nominal: float) -> AvoidanceMetrics:
    """The metrics of the first seed of a team's ``run``, whose paths take ``nominal`` [s] without detours."""
    episodes = judge(run.only(run.seeds[0])).episodes
    arrivals, free = arrival_time(run)[0], clearances(run, 0)
    there = np.isfinite(arrivals)
    cross = np.abs(cross_track_error(run)[0])
    step = float(run.time[1] - run.time[0])
    ends = np.where(there, arrivals, run.time[-1])[:, None] - STOPPING
    standing = stands_still(run["v"][0]) & (run.time > STARTING) & (run.time < ends)
    modes = np.zeros((1, len(arrivals)), dtype=int) if run.modes is None else run.modes[:, 0].astype(int)
    left = ((modes & LEFT_BEHIND > 0) & (modes < STOPPED)).any(axis=0)
    return AvoidanceMetrics(
        bool((episodes[:, OTHER] >= 0).any()),
        bool((episodes[:, OBSTACLE] >= 0).any()),
        float(min(np.nanmin(gap) for gap in robot_gaps(run, 0).values())),
        float(free.min()),
        arrivals,
        float(arrivals[there].max() / nominal) if there.any() else np.inf,
        float(np.nanmax(cross)),
        max(_longest(row, step) for row in cross > OFF_PATH),
        tuple(_longest(row, step) for row in standing),
        tuple(int(i) + 1 for i in np.flatnonzero(left)),
    )


def _longest(flags: np.ndarray, step: float) -> float:
    """How long [s] ``flags`` (samples,) hold without a break, at most."""
    edges = np.flatnonzero(np.diff(np.concatenate([[0], flags.astype(int), [0]])))
    return float((edges[1::2] - edges[::2]).max(initial=0) * step)
