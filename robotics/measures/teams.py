"""Metrics of teams, whose robots shall arrive together."""

from functools import partial

import numpy as np

from robotics.measures.arrival import arrival_time, spread
from robotics.measures.progress import progress_gap
from robotics.measures.tracking import Metric, same_for_all
from robotics.simulation.run import Run


def nearest_distance(run: Run) -> np.ndarray:
    """The smallest distance [m] between a robot's center and any other robot's (runs, robots).

    Args:
        run: The run of two robots or more.
    """
    x, y = run["x"], run["y"]
    result = np.full(x.shape[:2], np.inf)
    for i in range(x.shape[1] - 1):
        gap = np.hypot(x[:, i + 1 :] - x[:, i : i + 1], y[:, i + 1 :] - y[:, i : i + 1])
        gap = np.where(np.isfinite(gap), gap, np.inf).min(axis=-1)
        result[:, i] = np.minimum(result[:, i], gap.min(axis=1))
        result[:, i + 1 :] = np.minimum(result[:, i + 1 :], gap)
    return result


_TEAM = ("team",)
_of_team = partial(Metric, kinds=_TEAM)
_shown = partial(_of_team, headline=_TEAM, tried=_TEAM)
TEAM_METRICS: dict[str, Metric] = {
    "arrival_time_s": _shown(arrival_time, "s", "arrival: 99.5 % of the path, within 10 cm of it", short="arrival"),
    "arrival_spread_s": _shown(
        same_for_all(lambda r: spread(arrival_time(r))), "s", "spread of the arrivals", short="arrival spread"
    ),
    "max_progress_gap": _shown(
        same_for_all(lambda r: np.nanmax(progress_gap(r), axis=1)),
        "1",
        "largest s_i − s_j, by the true places",
        short="largest s_i − s_j",
    ),
    "mean_progress_gap": _of_team(same_for_all(lambda r: np.nanmean(progress_gap(r), axis=1)), "1", "mean s_i − s_j"),
    "min_distance_m": _shown(
        nearest_distance, "m", "smallest distance to another robot's center", short="least distance", larger=True
    ),
}


def measure_team(run: Run) -> dict[str, np.ndarray]:
    """The team metrics of a run by name, each (runs, robots), in its unit.

    Args:
        run: The run of a team.
    """
    return {name: metric.measure(run) for name, metric in TEAM_METRICS.items()}
