"""Metrics of avoidance: how long robots stood, were off their paths, were left behind, or obeyed an emergency rule."""

import numpy as np

from robotics.laws.modes import LEFT_BEHIND, STOPPED
from robotics.measures.arrival import arrival_time
from robotics.measures.standing import stands_still
from robotics.measures.tracking import Metric, cross_track_error
from robotics.simulation.run import Run

OFF_PATH = 0.1  # m: a robot farther from its path is off it
STARTING = 2.0  # s after the start in which a robot that stands still is not counted
_KINDS = ("tracking", "team")  # of scenarios
STOPPING = 0.5  # s before its arrival in which it is not counted either


def off_path_times(run: Run) -> np.ndarray:
    """The longest time [s] for which each robot was more than 0.1 m from its path without a break (runs, robots)."""
    return _longest(run, np.abs(cross_track_error(run)) > OFF_PATH)


def standing_times(run: Run) -> np.ndarray:
    """The longest time [s] for which each robot stood still on its way (runs, robots).

    The first 2 s do not count, nor does what comes after half a second before its arrival.
    """
    arrivals = arrival_time(run)
    ends = np.where(np.isfinite(arrivals), arrivals, run.time[-1])[..., None] - STOPPING
    return _longest(run, stands_still(run["v"]) & (run.time > STARTING) & (run.time < ends))


def left_behind_times(run: Run) -> np.ndarray:
    """The longest time [s] for which the group went on without each robot (runs, robots)."""
    if run.modes is None:
        return np.zeros(run.stopped.shape)
    modes = np.moveaxis(run.modes, 0, -1)
    return _longest(run, (modes & LEFT_BEHIND > 0) & (modes < STOPPED))


def _longest(run: Run, flags: np.ndarray) -> np.ndarray:
    """How long [s] ``flags`` (runs, robots, samples) hold without a break, at most (runs, robots)."""
    count, most = np.zeros(flags.shape[:2], dtype=int), np.zeros(flags.shape[:2], dtype=int)
    for k in range(flags.shape[2]):
        count = np.where(flags[..., k], count + 1, 0)
        most = np.maximum(most, count)
    return np.asarray(most * float(run.time[1] - run.time[0]))


def emergency_share(run: Run) -> np.ndarray:
    """The share of the time on its way in which the emergency rule overrode each robot's law (runs, robots).

    A robot is on its way until it arrives, as :func:`robotics.measures.arrival.arrival_time` says, until it is stopped
    or the run ends. Not-a-number for a law without such a rule, and for a robot that was never on its way.
    """
    if run.guarded is None:
        return np.full(run.stopped.shape, np.nan)
    on_way = np.isfinite(run["x"]) & (run.time < arrival_time(run)[..., None])
    on_way[..., -1] = False  # no period follows the last sample
    acted = np.moveaxis(run.guarded, 0, -1) & on_way
    with np.errstate(invalid="ignore"):
        return np.asarray(acted.sum(axis=-1) / on_way.sum(axis=-1))


EMERGENCY_METRICS: dict[str, Metric] = {
    "emergency_share": Metric(
        emergency_share,
        "1",
        "share of the way on which the emergency rule overrode the law",
        kinds=_KINDS,
        headline=_KINDS,
        short="emergency share",
        needs_guard=True,
    ),
}
