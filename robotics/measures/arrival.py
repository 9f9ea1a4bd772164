"""Arriving, and arriving together: the one place that defines both."""

import numpy as np

from fuzzy.compiled.jit import kernel
from robotics.measures.once import CachedPerRun
from robotics.measures.progress import true_progress
from robotics.simulation.run import Run

ARRIVAL_PROGRESS = 0.995  # of the path: what must be behind a robot that has arrived
ARRIVAL_OFFSET = 0.1  # m: it is no farther beside the end of its path, nor beyond it
ARRIVAL_SPREAD = 1.0  # s: between the first and the last arrival of robots that arrive together


def at_end(x, y, end_x, end_y, heading, length):  # type: ignore[no-untyped-def]
    """Whether robots at (x, y) [m] are at the ends of paths of a ``length`` [m], with a ``heading`` [rad] there.

    Of numbers or arrays of one shape. A robot is there when 99.5 % of the path are behind it, along the tangent at its
    end, and it is at most 10 cm beside that and beyond. Whoever asks knows that it has not only just begun: a closed
    path ends where it begins.
    """
    dx, dy = end_x - x, end_y - y
    left, across = np.cos(heading) * dx + np.sin(heading) * dy, np.cos(heading) * dy - np.sin(heading) * dx
    near = (left <= (1 - ARRIVAL_PROGRESS) * length) & (left >= -ARRIVAL_OFFSET)
    return near & (np.abs(across) < ARRIVAL_OFFSET)


_at_end = kernel(at_end)


@kernel
def at_end_compiled(x, y, end_x, end_y, heading, length):  # type: ignore[no-untyped-def]
    """The same, of one robot in a compiled loop; of one that is far away no cosine is taken."""
    near = 2 * ARRIVAL_OFFSET + (1 - ARRIVAL_PROGRESS) * length
    return abs(end_x - x) < near and abs(end_y - y) < near and _at_end(x, y, end_x, end_y, heading, length)


@CachedPerRun
def arrival_time(run: Run) -> np.ndarray:
    """The time [s] of each robot's arrival (runs, robots); infinite if it never arrives.

    A robot has arrived when it is :func:`at_end`, with more than half of its path behind it.

    Args:
        run: The run.
    """
    ends = np.array([nodes[:, -1] for nodes in run.paths])
    chords = np.array([nodes[:, -1] - nodes[:, -2] for nodes in run.paths])
    lengths = np.array([np.hypot(*np.diff(nodes)).sum() for nodes in run.paths])
    x, y, heading, length = (row[:, None] for row in (*ends.T, np.arctan2(*chords.T[::-1]), lengths))
    there = at_end(run["x"], run["y"], x, y, heading, length) & (true_progress(run) > 0.5)
    return np.where(there.any(axis=-1), run.time[np.argmax(there, axis=-1)], np.inf)


def spread(times: np.ndarray) -> np.ndarray:
    """The time [s] (runs,) between the first and the last of ``times`` (runs, robots); infinite if one is."""
    last, first = times.max(axis=1), times.min(axis=1)
    return np.where(np.isfinite(last), last - np.where(np.isfinite(first), first, 0.0), np.inf)


def together(times: np.ndarray, within: float = ARRIVAL_SPREAD) -> np.ndarray:
    """Whether the arrivals ``times`` (runs, robots) [s] of a run lie ``within`` that many seconds (runs,) bool."""
    return np.asarray(spread(times) <= within)
