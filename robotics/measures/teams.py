"""Teams: metrics of robots that shall arrive together."""

from collections.abc import Callable

import numpy as np
from numba import njit

from robotics.measures.tracking import Metric, cross_track_error
from robotics.simulation.run import Run

ARRIVED = 0.995  # of the path
NEAR = 0.05  # m
WINDOW = 0.5  # m: how far from the last place on the path the next is looked for
START = 0.25  # of the path: where the first place is looked for


def true_progress(run: Run) -> np.ndarray:
    """Where each robot truly is on its path, from 0 to 1, (runs, robots, samples): the nearest point, followed.

    The place is looked for within half a metre of the one before, so that crossing or closed paths are followed along
    their branch. Not-a-number once a robot is stopped.
    """
    result = np.empty(run["x"].shape)
    for i, nodes in enumerate(run.paths):
        length = float(np.hypot(*np.diff(nodes, axis=1)).sum())
        spacing = length / (nodes.shape[1] - 1)
        window = max(2, int(WINDOW / spacing))
        x, y = (np.ascontiguousarray(run[name][:, i]) for name in ("x", "y"))
        result[:, i] = _follow(np.ascontiguousarray(nodes), x, y, window, max(2, int(START * nodes.shape[1])))
    return result


@njit(cache=True, error_model="numpy")
def _follow(nodes, x, y, window, first):  # type: ignore[no-untyped-def]
    out = np.empty(x.shape)
    last = nodes.shape[1] - 1
    for r in range(x.shape[0]):
        low, high = 0, first
        for k in range(x.shape[1]):
            best = low
            least = np.inf
            for n in range(low, high + 1):
                d = (nodes[0, n] - x[r, k]) ** 2 + (nodes[1, n] - y[r, k]) ** 2
                if d < least:
                    least = d
                    best = n
            if not least < np.inf:
                out[r, k] = np.nan
                continue
            place = 0.0
            nearest = np.inf
            for n in (best - 1, best):  # the two chords that meet in the node
                if n < 0 or n >= last:
                    continue
                cx = nodes[0, n + 1] - nodes[0, n]
                cy = nodes[1, n + 1] - nodes[1, n]
                dx = x[r, k] - nodes[0, n]
                dy = y[r, k] - nodes[1, n]
                t = min(max((dx * cx + dy * cy) / (cx * cx + cy * cy), 0.0), 1.0)
                d = (dx - t * cx) ** 2 + (dy - t * cy) ** 2
                if d < nearest:
                    nearest = d
                    place = n + t
            out[r, k] = place / last
            low = max(best - window, 0)
            high = min(best + window, last)
    return out


def arrival_time(run: Run) -> np.ndarray:
    """(runs, robots) s: when 99.5 % of the path are behind the robot and it is within 10 cm of it; infinite: never."""
    there = (true_progress(run) >= ARRIVED) & (np.abs(cross_track_error(run)) < 2 * NEAR)
    return _first(run, there)


def end_time(run: Run) -> np.ndarray:
    """(runs, robots) s: when the robot comes within 5 cm of the end of its path; infinite if it never does."""
    ends = np.array([nodes[:, -1] for nodes in run.paths])
    gap = np.hypot(run["x"] - ends[:, :1], run["y"] - ends[:, 1:])
    return _first(run, (gap < NEAR) & (true_progress(run) > 0.5))  # a closed path ends where it begins


def _first(run: Run, there: np.ndarray) -> np.ndarray:
    return np.where(there.any(axis=-1), run.time[np.argmax(there, axis=-1)], np.inf)


def spread(times: np.ndarray) -> np.ndarray:
    """(runs,) s: between the first and the last of ``times`` (runs, robots); infinite if one never arrives."""
    last, first = times.max(axis=1), times.min(axis=1)
    return np.where(np.isfinite(last), last - np.where(np.isfinite(first), first, 0.0), np.inf)


def progress_gap(run: Run) -> np.ndarray:
    """(runs, samples): the foremost robot's progress less the rearmost's, by where they truly are."""
    progress = true_progress(run)
    return np.asarray(progress.max(axis=1) - progress.min(axis=1))


def nearest_distance(run: Run) -> np.ndarray:
    """(runs, robots) m: the smallest distance between a robot's center and another's."""
    x, y = run["x"], run["y"]
    result = np.full(x.shape[:2], np.inf)
    for i in range(x.shape[1] - 1):
        gap = np.hypot(x[:, i + 1 :] - x[:, i : i + 1], y[:, i + 1 :] - y[:, i : i + 1])
        gap = np.where(np.isfinite(gap), gap, np.inf).min(axis=-1)
        result[:, i] = np.minimum(result[:, i], gap.min(axis=1))
        result[:, i + 1 :] = np.minimum(result[:, i + 1 :], gap)
    return result


def _same_for_all(measure: Callable[[Run], np.ndarray]) -> Callable[[Run], np.ndarray]:
    """A figure of the whole team (runs,) as one a robot (runs, robots)."""
    return lambda run: np.repeat(measure(run)[:, None], run.stopped.shape[1], axis=1)


_TEAM = ("team",)
TEAM_METRICS: dict[str, Metric] = {
    "arrival_time_s": Metric(
        arrival_time,
        "s",
        "arrival: 99.5 % of the path, within 10 cm of it",
        kinds=_TEAM,
        headline=_TEAM,
        short="arrival",
        tried=_TEAM,
    ),
    "arrival_spread_s": Metric(
        _same_for_all(lambda r: spread(arrival_time(r))),
        "s",
        "spread of the arrivals",
        kinds=_TEAM,
        headline=_TEAM,
        short="arrival spread",
        tried=_TEAM,
    ),
    "end_spread_s": Metric(
        _same_for_all(lambda r: spread(end_time(r))), "s", "spread of coming within 5 cm of the end", kinds=_TEAM
    ),
    "max_progress_gap": Metric(
        _same_for_all(lambda r: np.nanmax(progress_gap(r), axis=1)),
        "1",
        "largest s_i − s_j, by the true places",
        kinds=_TEAM,
        headline=_TEAM,
        short="largest s_i − s_j",
        tried=_TEAM,
    ),
    "mean_progress_gap": Metric(
        _same_for_all(lambda r: np.nanmean(progress_gap(r), axis=1)), "1", "mean s_i − s_j", kinds=_TEAM
    ),
    "min_distance_m": Metric(
        nearest_distance,
        "m",
        "smallest distance to another robot's center",
        kinds=_TEAM,
        headline=_TEAM,
        short="least distance",
        tried=_TEAM,
        larger=True,
    ),
}


def measure_team(run: Run) -> dict[str, np.ndarray]:
    """Every team metric of a run, each (runs, robots)."""
    return {name: metric.measure(run) for name, metric in TEAM_METRICS.items()}
