"""The quantities that decide claims: functions from a run to one number for each seed and robot."""

from collections.abc import Mapping
from functools import partial

import numpy as np

from robotics.measures.arrival import arrival_time, spread
from robotics.measures.avoidance import left_behind_times, off_path_times, standing_times
from robotics.measures.contacts import Judgement, can_touch, judge, until_contact
from robotics.measures.once import CachedPerRun
from robotics.measures.own import measured as measured_own
from robotics.measures.progress import true_progress
from robotics.measures.registry import ALL_METRICS
from robotics.measures.tracking import Metric, cross_track_error, same_for_all, settling_time, timetable_error
from robotics.simulation.run import Run
from robotics.world.paths.posture import PostureError

_START = 6.0  # s: the start is over
_LATE = (15.0, 20.0)  # s: the span in which a robot that started off its path must have reached it
_LAST = 5.0  # s: the end of a run


def _norm(e: PostureError) -> np.ndarray:
    return np.sqrt(e.x**2 + e.y**2 + e.heading**2)


def _distance(run: Run) -> np.ndarray:
    e = timetable_error(run)
    return np.hypot(e.x, e.y)


def _between(run: Run, start: float, end: float = np.inf) -> np.ndarray:
    return (run.time > start) & (run.time < end)


def _rms(values: np.ndarray) -> np.ndarray:
    return np.asarray(np.sqrt(np.mean(values**2, axis=-1)))


def _short_of_goal(run: Run) -> np.ndarray:
    """The length [m] of path that each robot has not driven at the end."""
    lengths = np.array([np.hypot(*np.diff(nodes, axis=1)).sum() for nodes in run.paths])
    return np.asarray((1 - np.nanmax(true_progress(run), axis=-1)) * lengths)


@CachedPerRun
def _judged(run: Run) -> tuple[Judgement, Run]:
    """The contacts of a run, and what counts of it."""
    found = judge(run)
    return found, until_contact(run, found.first)


# Those of ALL_METRICS, contacts as of the whole run, and what is measured for claims alone
MEASURED_QUANTITIES: Mapping[str, Metric] = {
    **ALL_METRICS,
    "contacts": ALL_METRICS["contacts"]._replace(measure=lambda r: _judged(r)[0].counts),
    "min_clearance_m": ALL_METRICS["min_clearance_m"]._replace(measure=lambda r: _judged(r)[0].least),
    "late_error_norm": Metric(
        lambda r: np.asarray(np.mean(_norm(timetable_error(r))[..., _between(r, _START)], axis=-1)),
        "m, rad",
        f"mean error norm against the timetable after the first {_START:g} s",
    ),
    "timetable_error_norm": Metric(
        lambda r: np.asarray(np.nanmean(_norm(timetable_error(r)), axis=-1)),
        "m, rad",
        "mean error norm against the timetable",
    ),
    "last_distance_m": Metric(
        lambda r: _rms(_distance(r)[..., _between(r, r.time[-1] - _LAST)]),
        "m",
        f"RMS distance to the timetable's place in the last {_LAST:g} s",
    ),
    "largest_distance_m": Metric(
        lambda r: np.asarray(np.nanmax(_distance(r), axis=-1)), "m", "largest distance to the timetable's place"
    ),
    "late_cross_track_m": Metric(
        lambda r: _rms(cross_track_error(r)[..., _between(r, *_LATE)]),
        "m",
        f"RMS cross-track error from {_LATE[0]:g} to {_LATE[1]:g} s",
    ),
    "settles": Metric(
        lambda r: np.isfinite(settling_time(r, _distance(r))),
        "1",
        "runs that settle: distance to the timetable's place below 5 cm for good",
        larger=True,
    ),
    "untouched": Metric(lambda r: _judged(r)[0].counts == 0, "1", "runs without contact", larger=True),
    "off_path_s": Metric(off_path_times, "s", "longest time more than 0.1 m off the path"),
    "stood_s": Metric(standing_times, "s", "longest time of standing still on the way"),
    "left_behind_s": Metric(left_behind_times, "s", "longest time for which the group went on without it"),
    "short_of_goal_m": Metric(_short_of_goal, "m", "length of path that is not driven at the end"),
    "others_spread_s": Metric(
        same_for_all(lambda r: spread(arrival_time(r)[:, 1:])), "s", "spread of the arrivals without robot 1"
    ),
}


def quantity_called(name: str, own: Mapping[str, Metric]) -> Metric:
    """What a claim calls ``name``: a metric of the user's ``own``, or else one of MEASURED_QUANTITIES."""
    if name not in own:
        return MEASURED_QUANTITIES[name]
    return own[name]._replace(measure=partial(measured_own, name, own[name]))


_WHOLE = ("contacts", "min_clearance_m", "untouched")  # these are of the whole run, the others end with a contact


def measured(run: Run, quantity: str | Metric, robots: str = "worst") -> np.ndarray:
    """The quantity of every seed (runs,), in its unit; what comes after a seed's first contact does not count.

    Args:
        run: The run.
        quantity: A name of MEASURED_QUANTITIES, or what is measured itself, such as a metric of one's own.
        robots: Whose number is taken: "worst", "mean", or one robot from "1".
    """
    about = MEASURED_QUANTITIES[quantity] if isinstance(quantity, str) else quantity
    values = about.measure(_judged(run)[1] if can_touch(run) and quantity not in _WHOLE else run)
    if robots == "mean":
        return np.asarray(values.mean(axis=1))
    if robots != "worst":
        return np.asarray(values[:, int(robots) - 1])
    return np.asarray(values.min(axis=1) if about.larger else values.max(axis=1))


def runs_touched(run: Run) -> int:
    """The number of seeds in which a robot touched something."""
    return int((measured(run, "contacts") > 0).sum())
