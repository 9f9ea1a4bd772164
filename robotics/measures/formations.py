"""Leader-follower formations, thesis 5.2: the scenario, and metrics of a run.

Robot 1 leads. The sine of the thesis's figures is lost; the centers of its Tables 5.2 and 5.3 lie on y = 0.5 cos x,
and its initial poses [-3, 0.5, 0] and [3, -0.5, 0] on it too if a straight line y = 0.5 leads in before x = 0. The
followers drive the same curve one metre to the left and to the right, from x = 0.

A formation has no reference in time. Each robot's trajectory runs along its own path with the desired speed from
x = 0 on, so the leader's reference drives beside the followers'; the laws of
:mod:`robotics.laws.formation.leader_follower` use the paths only. A run counts until the leader reaches the end of its
path, where all robots stop.
"""

from collections.abc import Callable

import numpy as np

from robotics.measures.tracking import Metric, cross_track_error
from robotics.simulation.run import Run

ALIGNED = 0.1  # m: leader and followers are level


def leads(run: Run) -> np.ndarray:
    """dx [m] (runs, samples): the leader's true x less the followers' mean."""
    x = run["x"]
    return np.asarray(x[:, 0] - x[:, 1:].mean(axis=1))


def last_samples(run: Run) -> np.ndarray:
    """(runs,) int: the sample at which the leader reaches the end of its path; -1 if it never does."""
    there = run["x"][:, 0] >= run.paths[0][0, -1]
    return np.where(there.any(-1), np.argmax(there, axis=-1), -1)


def alignment_time(run: Run) -> np.ndarray:
    """(runs,) s: from when on |dx| stays below 10 cm until the leader's end; infinite if it does not, or never ends."""
    gap, last = np.abs(leads(run)), last_samples(run)
    counted = np.arange(gap.shape[1]) <= last[:, None]
    apart = counted & ~(gap < ALIGNED)
    first = np.where(apart.any(-1), gap.shape[1] - np.argmax(apart[:, ::-1], axis=-1), 0)
    return np.where((last >= 0) & (first <= last), run.time[np.minimum(first, gap.shape[1] - 1)], np.inf)


def final_spread(run: Run) -> np.ndarray:
    """(runs,) m: between the foremost and the rearmost x when the leader ends; infinite if it never does."""
    x, last = run["x"], last_samples(run)
    now = np.take_along_axis(x, last[:, None, None], axis=-1)[..., 0]
    return np.where(last >= 0, now.max(axis=1) - now.min(axis=1), np.inf)


def lateral_error(run: Run) -> np.ndarray:
    """(runs, robots) m: each robot's largest distance from its own path until the leader ends (or the run does)."""
    counted = np.arange(len(run.time)) <= np.where(last_samples(run) >= 0, last_samples(run), len(run.time))[:, None]
    distance = np.where(counted[:, None], np.abs(cross_track_error(run)), 0.0)
    return np.asarray(np.nanmax(distance, axis=-1))


def _same_for_all(measure: Callable[[Run], np.ndarray]) -> Callable[[Run], np.ndarray]:
    """A figure of the whole formation (runs,) as one a robot (runs, robots)."""
    return lambda run: np.repeat(measure(run)[:, None], run.stopped.shape[1], axis=1)


_FORMATION = ("formation",)
FORMATION_METRICS: dict[str, Metric] = {
    "alignment_time_s": Metric(
        _same_for_all(alignment_time),
        "s",
        "leader level with followers (10 cm) for good",
        kinds=_FORMATION,
        headline=_FORMATION,
        short="alignment",
    ),
    "final_spread_m": Metric(
        _same_for_all(final_spread),
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
    """Every formation metric of a run, each (runs, robots)."""
    return {name: metric.measure(run) for name, metric in FORMATION_METRICS.items()}
