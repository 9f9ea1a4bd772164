"""Metrics of leader-follower formations, thesis 5.2: how level robots drive, and how near their paths.

Robot 1 leads. A run counts until the leader reaches the end of its path, where all robots stop. Where x grows along
all paths, as in the thesis, a robot is where its x is; on other paths, also closed ones, it is at the abscissa of its
path's nearest point, which is followed from the start on. The places of two robots are level with each other where
their references are at one time.
"""

from functools import partial

import numpy as np

from robotics.measures.once import CachedPerRun
from robotics.measures.tracking import Metric, cross_track_error, rms_of, same_for_all
from robotics.simulation.run import Run
from robotics.world.paths.joined import PathTable, join_paths, table_length
from robotics.world.paths.path import Path

SETTLING = 10.0  # s from the start until a robot should be in its place
_REACH = 0.5  # m: how far along its path a robot is looked for, from where it was a period before
ALIGNED = 0.1  # m: leader and followers are level
_AT_END = 0.01  # m: the leader is at its path's end; a noisy measurement stops it some mm before or after


def leads(run: Run) -> np.ndarray:
    """The lead [m] (runs, samples): the leader's true x, or its abscissa, minus the mean of the followers'."""
    x = run["x"] if x_grows(run) else on_leader(run)
    return np.asarray(x[:, 0] - x[:, 1:].mean(axis=1))


def last_samples(run: Run) -> np.ndarray:
    """The sample (runs,) at which the leader reaches the end of its path (to 1 cm); -1 if it never does."""
    if x_grows(run):
        there = run["x"][:, 0] >= run.paths[0][0, -1] - _AT_END
    else:
        there = abscissae(run)[:, 0] >= _paths(run).lengths[0] - _AT_END
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
    """The distance [m] (runs,) between the foremost and the rearmost robot at the leader's end; infinite without one.

    It is that in x, or along the leader's path.
    """
    x, last = run["x"] if x_grows(run) else on_leader(run), last_samples(run)
    now = np.take_along_axis(x, last[:, None, None], axis=-1)[..., 0]
    return np.where(last >= 0, now.max(axis=1) - now.min(axis=1), np.inf)


def lateral_error(run: Run) -> np.ndarray:
    """Each robot's largest distance [m] from its own path (runs, robots), until the leader's end or that of the run."""
    counted = np.arange(len(run.time)) <= np.where(last_samples(run) >= 0, last_samples(run), len(run.time))[:, None]
    distance = np.where(counted[:, None], np.abs(cross_track_error(run)), 0.0)
    return np.asarray(np.nanmax(distance, axis=-1))


def x_grows(run: Run) -> bool:
    """Whether x grows along all paths."""
    return all(bool(np.all(np.diff(nodes[0]) > 0)) for nodes in run.paths)


@CachedPerRun
def _paths(run: Run) -> PathTable:
    """The paths of a run, of which it keeps nodes at equal steps of the abscissa."""
    found = []
    for nodes in run.paths:
        heading = np.unwrap(np.arctan2(*np.gradient(nodes, axis=1, edge_order=2)[::-1]))
        unknown = np.zeros_like(heading)
        length = table_length(np.stack([*nodes, heading, unknown, unknown]))
        curvature = np.gradient(heading, length / (nodes.shape[1] - 1))
        found.append(Path(length, np.stack([*nodes, heading, curvature, unknown])))
    return join_paths(found)


@CachedPerRun
def abscissae(run: Run) -> np.ndarray:
    """The abscissae [m] (runs, robots, samples) of the nearest points of the own paths, each followed from the start.

    At the start a robot is looked for about its reference, as far along the path as it is away from that.
    """
    paths, x, y = _paths(run), run["x"], run["y"]
    found = np.full(x.shape, np.nan)
    s = np.broadcast_to(run.target("s")[:, 0], x.shape[:2])
    begin_x, begin_y = run.target("x")[:, 0], run.target("y")[:, 0]
    reach = _REACH + 1.2 * np.hypot(x[..., 0] - begin_x, y[..., 0] - begin_y)
    for k in range(x.shape[-1]):
        near = paths.nearest(x[..., k], y[..., k], s, reach)
        found[..., k] = np.where(np.isfinite(x[..., k]), near, np.nan)  # a robot that was stopped is nowhere
        s, reach = np.where(np.isfinite(x[..., k]), near, s), np.full_like(reach, _REACH)
    return found


@CachedPerRun
def _level(run: Run) -> np.ndarray:
    """Level abscissae [m] (robots, places): those of the references, and the ends, where a run is over before them."""
    due, ends = run.target("s"), _paths(run).lengths
    return due if due[0, -1] >= ends[0] - _AT_END else np.concatenate([due, ends[:, None]], axis=1)


def on_leader(run: Run) -> np.ndarray:
    """The abscissae [m] (runs, robots, samples) on the leader's path that are level with the robots."""
    places, due = abscissae(run).copy(), _level(run)
    for i in range(1, len(due)):
        steps, which = np.unique(due[i], return_index=True)
        places[:, i] = np.interp(places[:, i], steps, due[0, which])
    return places


@CachedPerRun
def place_error(run: Run) -> np.ndarray:
    """How far each robot is from its place in the formation [m] (runs, robots, samples).

    That is the point of its path level with the leader; of the leader itself, the nearest point of its path.
    """
    paths, due = _paths(run), _level(run)
    steps, which = np.unique(due[0], return_index=True)
    leader = abscissae(run)[:, 0]
    s = np.stack(
        [leader, *(np.interp(leader, steps, row[which]) for row in due[1:])], axis=-1
    )  # (runs, samples, robots)
    point = paths.at(np.nan_to_num(s))
    x, y = np.moveaxis(point.x, -1, 1), np.moveaxis(point.y, -1, 1)
    return np.asarray(np.hypot(run["x"] - x, run["y"] - y))


def _in_formation(run: Run) -> np.ndarray:
    """The place errors after SETTLING and until the leader's end (runs, robots, samples), otherwise not-a-number."""
    last = last_samples(run)
    samples = np.arange(len(run.time))
    counted = (run.time >= SETTLING) & (samples <= np.where(last >= 0, last, len(samples))[:, None])
    return np.where(counted[:, None], place_error(run), np.nan)


def largest_place_error(run: Run) -> np.ndarray:
    """The largest place error [m] (runs, robots), from 10 s after the start until the leader's end; infinite: none."""
    return np.asarray(np.nan_to_num(np.fmax.reduce(_in_formation(run), axis=-1), nan=np.inf))


def rms_place_error(run: Run) -> np.ndarray:
    """The root mean square of the place errors [m] (runs, robots), over the same time; infinite where there is none."""
    return rms_of(_in_formation(run))


_FORMATION = ("formation",)
_headline = partial(Metric, kinds=_FORMATION, headline=_FORMATION)
_tried = partial(Metric, kinds=_FORMATION, tried=_FORMATION)
FORMATION_METRICS: dict[str, Metric] = {
    "alignment_time_s": _headline(
        same_for_all(alignment_time), "s", "leader level with followers (10 cm) for good", short="alignment"
    ),
    "final_spread_m": _headline(
        same_for_all(final_spread), "m", "spread of x when the leader ends", short="spread at the end"
    ),
    "max_lateral_error_m": _headline(
        lateral_error, "m", "largest distance from the own path until then", short="largest lateral"
    ),
    "max_place_error_m": _tried(
        largest_place_error, "m", "largest distance from the own place beside the leader, after 10 s", of_run="max"
    ),
    "rms_place_error_m": _tried(rms_place_error, "m", "RMS of that distance"),
}


def measure_formation(run: Run) -> dict[str, np.ndarray]:
    """The formation metrics of a run by name, each (runs, robots), in its unit.

    Args:
        run: The run of a formation.
    """
    return {name: metric.measure(run) for name, metric in FORMATION_METRICS.items()}
