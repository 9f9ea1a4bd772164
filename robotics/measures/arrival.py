"""Arriving, and arriving together: the one place that defines both."""

from typing import Any

import numpy as np

from robotics.measures.once import CachedPerRun
from robotics.measures.progress import true_progress
from robotics.measures.tracking import cross_track_error
from robotics.simulation.run import Run

ARRIVAL_PROGRESS = 0.995  # of the path: what must be behind a robot that has arrived
ARRIVAL_OFFSET = 0.1  # m: and it is no farther from its path
END_DISTANCE = 0.05  # m: a robot this near the end of its path is at the end: laws stop within 3 cm, and noise is 3 mm
GOAL_SHARE = 0.005  # of the path's length: on a longer path it is there so near
ARRIVAL_SPREAD = 1.0  # s: between the first and the last arrival of robots that arrive together


@CachedPerRun
def arrival_time(run: Run) -> np.ndarray:
    """The time [s] of each robot's arrival (runs, robots); infinite if it never arrives.

    A robot has arrived when 99.5 % of its path are behind it and it is within 10 cm of the path.

    Args:
        run: The run.
    """
    return _first(run, (true_progress(run) >= ARRIVAL_PROGRESS) & (np.abs(cross_track_error(run)) < ARRIVAL_OFFSET))


def end_time(run: Run) -> np.ndarray:
    """The time [s] (runs, robots) at which the robot comes within 5 cm of the end of its path; infinite: never."""
    ends = np.array([nodes[:, -1] for nodes in run.paths])
    gap = np.hypot(run["x"] - ends[:, :1], run["y"] - ends[:, 1:])
    return _first(run, (gap < END_DISTANCE) & (true_progress(run) > 0.5))  # a closed path ends where it begins


def at_goal(x: np.ndarray, y: np.ndarray, goals: Any, lengths: np.ndarray) -> np.ndarray:
    """Whether each robot of a run that is still going on is at the end of its path (runs, robots) bool.

    Args:
        x: The robots' centers (runs, robots) [m].
        y: Likewise.
        goals: The ends of the paths, as ``x`` and ``y`` (runs, robots) [m].
        lengths: The lengths of the paths (runs, robots) [m].
    """
    return np.asarray(np.hypot(x - goals.x, y - goals.y) < reached_within(lengths))


def reached_within(lengths: np.ndarray) -> np.ndarray:
    """The distance [m] of its goal within which a robot is there, for paths of ``lengths`` [m]."""
    return np.asarray(np.maximum(GOAL_SHARE * lengths, END_DISTANCE))


def spread(times: np.ndarray) -> np.ndarray:
    """The time [s] (runs,) between the first and the last of ``times`` (runs, robots); infinite if one is."""
    last, first = times.max(axis=1), times.min(axis=1)
    return np.where(np.isfinite(last), last - np.where(np.isfinite(first), first, 0.0), np.inf)


def together(times: np.ndarray, within: float = ARRIVAL_SPREAD) -> np.ndarray:
    """Whether the arrivals ``times`` (runs, robots) [s] of a run lie ``within`` that many seconds (runs,) bool."""
    return np.asarray(spread(times) <= within)


def _first(run: Run, there: np.ndarray) -> np.ndarray:
    return np.where(there.any(axis=-1), run.time[np.argmax(there, axis=-1)], np.inf)
