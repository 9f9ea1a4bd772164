"""Distances between surfaces: of robots from each other and from obstacles, with what a run shows of both."""

from dataclasses import dataclass
from itertools import combinations

import numpy as np

from robotics.environment.collision import footprints, obstacle_clearance, obstacle_contacts, robot_contacts
from robotics.laws.modes import LEFT_BEHIND, STOPPED
from robotics.measures.arrival import arrival_time
from robotics.measures.tracking import cross_track_error
from robotics.scenario.description import Scenario
from robotics.simulation.run import Run


def robot_gaps(run: Run, place: int) -> dict[tuple[int, int], np.ndarray]:
    """(6.1) for every pair of robots: the distance between their centers (samples,) [m], of the seed at that place."""
    x, y = run["x"][place], run["y"][place]
    return {(i, j): np.hypot(x[i] - x[j], y[i] - y[j]) for i, j in combinations(range(len(x)), 2)}


def clearances(run: Run, place: int) -> np.ndarray:
    """The distance [m] of each robot's rectangle from the nearest obstacle (robots, samples); infinite without any."""
    x, y, heading = (run[name][place].T for name in ("x", "y", "heading"))
    if run.obstacles is None:
        return np.full(x.T.shape, np.inf)
    return obstacle_clearance(x, y, heading, footprints(run.about.robots), run.obstacles).T


_OFF = 0.1  # m from the path: off it; from the goal: there
_STANDS = 0.01  # m/s


@dataclass(frozen=True)
class Merits:
    """What a run came to, against the exact rectangles."""

    collided: bool  # two robots touched
    hit: bool  # a robot touched an obstacle
    nearest: float  # m between the centers of two robots
    clearance: float  # m between a robot's rectangle and an obstacle; infinite without obstacles
    arrived: tuple[bool, ...]  # by robot
    spread: float  # s between the first and the last arrival, of those that arrive
    ratio: float  # the last arrival over the nominal duration; infinite if nobody arrives
    off: float  # m: the largest distance from a path
    away: float  # s: the longest that a robot was farther than 0.1 m from its path
    stood: tuple[float, ...]  # s, by robot: the longest that it stood still on its way
    left: tuple[int, ...]  # robots, from 1, that the group went on without

    @property
    def safe(self) -> bool:
        """Nothing touched anything."""
        return not (self.collided or self.hit)

    @property
    def together(self) -> bool:
        """All arrived within 0.2 s of each other."""
        return all(self.arrived) and self.spread <= 0.2 + 1e-9


def merits(run: Run, scenario: Scenario) -> Merits:
    """What the first seed of a team's ``run`` of ``scenario`` came to."""
    x, y, heading = (run[name][0].T for name in ("x", "y", "heading"))
    sizes = footprints([member.robot for member in scenario.robots])
    arrivals = arrival_time(run)[0]
    there = np.isfinite(arrivals)
    cross = np.abs(cross_track_error(run)[0])
    step = float(run.time[1] - run.time[0])
    still = np.abs(run["v"][0]) < _STANDS
    # Not the start, and not the goal
    on_way = (run.time > 2.0) & (run.time < np.where(there, arrivals, run.time[-1])[:, None] - 0.5)
    modes = np.zeros((1, x.shape[1]), dtype=int) if run.modes is None else run.modes[:, 0].astype(int)
    left = ((modes & LEFT_BEHIND > 0) & (modes < STOPPED)).any(axis=0)
    nominal = float(scenario.trajectory.ends[0])
    return Merits(
        bool((robot_contacts(x, y, heading, sizes) >= 0).any()),
        run.obstacles is not None and bool((obstacle_contacts(x, y, heading, sizes, run.obstacles) >= 0).any()),
        float(min(np.nanmin(gap) for gap in robot_gaps(run, 0).values())),
        float(clearances(run, 0).min()),
        tuple(there.tolist()),
        float(np.ptp(arrivals[there])) if there.any() else np.inf,
        float(arrivals[there].max() / nominal) if there.any() else np.inf,
        float(np.nanmax(cross)),
        max(_longest(row, step) for row in cross > _OFF),
        tuple(_longest(row, step) for row in still & on_way),
        tuple(int(i) + 1 for i in np.flatnonzero(left)),
    )


def _longest(flags: np.ndarray, step: float) -> float:
    """How long [s] ``flags`` (samples,) hold without a break, at most."""
    edges = np.flatnonzero(np.diff(np.concatenate([[0], flags.astype(int), [0]])))
    return float((edges[1::2] - edges[::2]).max(initial=0) * step)
