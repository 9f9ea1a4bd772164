"""Metrics of leader-follower formations, thesis 5.2: how level robots drive, and how near their paths.

Robot 1 leads. A run counts until the leader reaches the end of its path, where all robots stop; the scenarios are those
of :mod:`robotics.scenario.formations`.
"""

import numpy as np

from robotics.measures.tracking import Metric, cross_track_error, same_for_all
from robotics.simulation.run import Run

ALIGNED = 0.1  # m: leader and followers are level
AT_END = 0.01  # m: the leader is at its path's end; a noisy measurement stops it some mm before or after


def leads(run: Run) -> np.ndarray:
    """The lead dx [m] (runs, samples): the leader's true x minus the mean of the followers'."""
    x = run["x"]
    return np.asarray(x[:, 0] - x[:, 1:].mean(axis=1))


def last_samples(run: Run) -> np.ndarray:
    """The sample (runs,) at which the leader reaches the end of its path (to 1 cm); -1 if it never does."""
    there = run["x"][:, 0] >= run.paths[0][0, -1] - AT_END
    return np.where(there.any(-1), np.argmax(there, axis=-1), -1)


def alignment_time(run: Run) -> np.ndarray:
    """The time [s] (runs,) from which |dx| stays below 10 cm until the leader's end.

    It is infinite if |dx| does not stay below, or the leader never reaches the end.
    """
    gap, last = np.abs(leads(run)), last_samples(run)
    counted = np.arange(gap.shape[1]) <= last[:, None]
    apart = counted & ~(gap < ALIGNED)
    first = np.where(apart.any(-1), gap.shape[1] - np.argmax(apart[:, ::-1], axis=-1), 0)
    return np.where((last >= 0) & (first <= last), run.time[np.minimum(first, gap.shape[1] - 1)], np.inf)


def final_spread(run: Run) -> np.ndarray:
    """The distance [m] (runs,) between the foremost and the rearmost x at the leader's end; infinite without one."""
    x, last = run["x"], last_samples(run)
    now = np.take_along_axis(x, last[:, None, None], axis=-1)[..., 0]
    return np.where(last >= 0, now.max(axis=1) - now.min(axis=1), np.inf)


def lateral_error(run: Run) -> np.ndarray:
    """Each robot's largest distance [m] from its own path (runs, robots), until the leader's end or that of the run."""
    counted = np.arange(len(run.time)) <= np.where(last_samples(run) >= 0, last_samples(run), len(run.time))[:, None]
    distance = np.where(counted[:, None], np.abs(cross_track_error(run)), 0.0)
    return np.asarray(np.nanmax(distance, axis=-1))


_FORMATION = ("formation",)
FORMATION_METRICS: dict[str, Metric] = {
    "alignment_time_s": Metric(
        same_for_all(alignment_time),
        "s",
        "leader level with followers (10 cm) for good",
        kinds=_FORMATION,
        headline=_FORMATION,
        short="alignment",
    ),
    "final_spread_m": Metric(
        same_for_all(final_spread),
        "m",
        "spread of x when the leader ends",
        kinds=_FORMATION,
        headline=_FORMATION,
        short="spread at the end",
    ),
    "max_lateral_error_m": Metric(
        lateral_error,
        "m",
        "largest distance from the own path until then",
        kinds=_FORMATION,
        headline=_FORMATION,
        short="largest lateral",
    ),
}


def measure_formation(run: Run) -> dict[str, np.ndarray]:
    """Measure every formation metric of a run, each (runs, robots)."""
    return {name: metric.measure(run) for name, metric in FORMATION_METRICS.items()}
