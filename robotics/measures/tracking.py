"""Metrics: functions from a run to one number for each seed and robot, all (runs, robots).

The errors are those of the true posture against the reference at the same time, in the robot's frame (5.9);
the controller saw only the measured posture. A robot that was stopped is measured up to then.
"""

import warnings
from collections.abc import Callable
from functools import partial
from typing import Literal, NamedTuple

import numpy as np

from fuzzy.compiled.jit import kernel
from fuzzy.compiled.trigonometry import sincos
from robotics.measures.once import CachedPerRun
from robotics.simulation.run import Run
from robotics.world.paths.nearest import signed_distances
from robotics.world.paths.posture import PostureError, posture_error, wrapped_compiled
from robotics.world.paths.references import Reference

_SETTLED = 0.05  # m: a robot that stays nearer has settled
UNDER_WAY = 6.0  # s: from then on what is measured is the tracking, not how a robot came to its path
TIMETABLED = ("tracking", "formation", "team")  # kinds of scenarios in which references move
SCENARIO_KINDS = (*TIMETABLED, "goal")


class Metric(NamedTuple):
    """One number that is measured of a run, and where it is shown.

    An entry in METRICS, FORMATION_METRICS, TEAM_METRICS, CONTACT_METRICS or EMERGENCY_METRICS is all that a metric
    needs: tables of results, reports, pictures and the designer read from it what they show.

    Attributes:
        measure: Of a run: makes the numbers (runs, robots).
        unit: Their unit; "1" for none.
        title: What it is, in a line.
        kinds: Of scenarios in which it is measured.
        headline: Kinds in which a comparison's short table and picture show it.
        short: Its title in those.
        tried: Kinds in which the designer's panel "Try it" shows it.
        larger: Whether larger values are better.
        of_run: How the robots' numbers make one of a run, which a table shows.
        needs_others: Whether it is measured only where there are other robots or obstacles.
        needs_guard: Whether it is measured only of laws that have an emergency rule.
    """

    measure: Callable[[Run], np.ndarray]
    unit: str
    title: str
    kinds: tuple[str, ...] = SCENARIO_KINDS
    headline: tuple[str, ...] = ()
    short: str = ""
    tried: tuple[str, ...] = ()
    larger: bool = False
    of_run: Literal["mean", "min", "max"] = "mean"
    needs_others: bool = False
    needs_guard: bool = False


def timetable_error(run: Run) -> PostureError:
    """The posture error (5.9) against the scenario's own timetable, whatever place a law aims at; (5.17).

    Each field is (runs, robots, samples). It is the one measure by which laws with clocks of their own can be compared.
    """
    return posture_error(run["x"], run["y"], run["heading"], Reference(*(rows.T[None] for rows in run.reference)))


def tracking_error(run: Run) -> PostureError:
    """The posture error (5.9) of every sample; each field is (runs, robots, samples).

    The target is the scenario's reference, or in a team's run the place where the law wanted the robot to be.

    Args:
        run: The run.
    """
    if run.team is None:
        return timetable_error(run)
    place = Reference(run["x_target"], run["y_target"], run["heading_target"], *([np.zeros(1)] * 3))
    return posture_error(run["x"], run["y"], run["heading"], place)


@CachedPerRun
def path_errors(run: Run) -> np.ndarray:
    """The :func:`cross_track_error`, and how far robots are beyond the ends of their paths [m].

    As (2, runs, robots, samples).
    """
    x, y = run["x"], run["y"]
    found = [np.array(signed_distances(nodes, x[:, i], y[:, i])) for i, nodes in enumerate(run.paths)]
    return np.stack(found, axis=2)


def cross_track_error(run: Run) -> np.ndarray:
    """The signed distance [m] to the nearest point of the path, > 0 on its left side (runs, robots, samples).

    Past the path's end it is the lateral part alone, beside the tangent there.

    Args:
        run: The run.
    """
    return np.asarray(path_errors(run)[0])


class TrackingErrors(NamedTuple):
    """What metrics tell of :func:`tracking_error`; each field is (runs, robots)."""

    x: np.ndarray  # m: the mean amount, as those that follow
    y: np.ndarray  # m
    heading: np.ndarray  # rad
    norm: np.ndarray  # of all three, 1 rad counted as 1 m
    settled: np.ndarray  # s: from then on the distance stays below 5 cm; infinite: it never does
    final: np.ndarray  # m: the last distance


@CachedPerRun
def tracking_errors(run: Run) -> TrackingErrors:
    """Sum up :func:`tracking_error` over the samples of each robot."""
    if run.team is not None:
        target = [run[name] for name in ("x_target", "y_target", "heading_target")]
    else:
        target = [rows.T[None] for rows in run.reference[:3]]
    found = np.empty((len(TrackingErrors._fields), *run.stopped.shape))
    _sum_up(run["x"], run["y"], run["heading"], *target, run.time, found)
    found.flags.writeable = False
    return TrackingErrors(*found)


@kernel(nogil=True)
def _sum_up(x, y, heading, target_x, target_y, target_heading, time, found):  # type: ignore[no-untyped-def]
    runs, robots, samples = x.shape
    total, known = np.empty(4), np.empty(4)
    for r in range(runs):
        own = r if len(target_x) > 1 else 0
        for i in range(robots):
            total[:] = 0.0
            known[:] = 0.0
            first, last = 0, np.nan
            for k in range(samples):
                dx, dy = target_x[own, i, k] - x[r, i, k], target_y[own, i, k] - y[r, i, k]
                sin, cos = sincos(heading[r, i, k])
                e_x, e_y = cos * dx + sin * dy, cos * dy - sin * dx
                e_heading = wrapped_compiled(target_heading[own, i, k] - heading[r, i, k])
                norm = np.sqrt(e_x * e_x + e_y * e_y + e_heading * e_heading)
                for n, value in enumerate((abs(e_x), abs(e_y), abs(e_heading), norm)):
                    if not np.isnan(value):
                        total[n] += value
                        known[n] += 1
                distance = np.hypot(e_x, e_y)
                if not distance < _SETTLED:
                    first = k + 1
                if np.isfinite(distance) or (k == samples - 1 and not np.isfinite(last)):
                    last = distance
            for n in range(4):
                found[n, r, i] = total[n] / known[n]  # not-a-number of a robot that was stopped at once
            found[4, r, i] = time[first] if first < samples else np.inf
            found[5, r, i] = last


def under_way(run: Run) -> np.ndarray:
    """When the reference of each robot (robots, samples) moves, without the first 6 s, in which a robot may come to it.

    Of a run, or a path, of less than 12 s it is the second half: there is always something to measure.
    """
    return moves_on(run.target("v"), run.time)


def moves_on(v: np.ndarray, time: np.ndarray) -> np.ndarray:
    """The same of references with speeds ``v`` (robots, samples) [m/s] at times (samples,) [s]."""
    moving = v > 1e-6
    last = np.where(moving.any(-1), moving.shape[-1] - 1 - np.argmax(moving[..., ::-1], axis=-1), 0)
    begin = np.minimum(UNDER_WAY, time[last] / 2)
    return np.asarray(moving & (time >= begin[:, None]))


def _mean(values: np.ndarray) -> np.ndarray:
    # A robot that is stopped at once has no sample: its mean is not-a-number
    with warnings.catch_warnings(action="ignore", category=RuntimeWarning):
        return np.asarray(np.nanmean(values, axis=-1))


def at_end(values: np.ndarray) -> np.ndarray:
    """The last known sample (runs, robots) of a channel (runs, robots, samples)."""
    last = values.shape[-1] - 1 - np.argmax(np.isfinite(values)[..., ::-1], axis=-1)
    return np.take_along_axis(values, last[..., None], axis=-1)[..., 0]


def _rate(run: Run, total: np.ndarray) -> np.ndarray:
    """A total divided by the seconds in which the robot was in play."""
    seconds = np.isfinite(run["x"]).sum(-1) - 1
    return total / np.maximum(seconds * (run.time[1] - run.time[0]), np.finfo(float).tiny)


def settling_time(run: Run, distance: np.ndarray) -> np.ndarray:
    """The time [s] (runs, robots) from which a distance stays below 5 cm; infinite if it never does.

    ``distance`` (runs, robots, samples) is in m, and may be signed.
    """
    outside = ~(np.abs(distance) < _SETTLED)
    samples = outside.shape[-1]
    first = np.where(outside.any(-1), samples - np.argmax(outside[..., ::-1], axis=-1), 0)
    return np.where(first < samples, run.time[np.minimum(first, samples - 1)], np.inf)


def same_for_all(measure: Callable[[Run], np.ndarray]) -> Callable[[Run], np.ndarray]:
    """A measure of a whole group (runs,) as one that gives the same number to each robot (runs, robots)."""
    return lambda run: np.repeat(measure(run)[:, None], run.stopped.shape[1], axis=1)


def _variation(run: Run, channel: str) -> np.ndarray:
    return _rate(run, np.nansum(np.abs(np.diff(run[channel], axis=-1)), axis=-1))


def _rms_under_way(run: Run) -> np.ndarray:
    """Infinite for a robot that was stopped before it got under way."""
    return rms_of(np.where(under_way(run), cross_track_error(run), np.nan))


def late(run: Run) -> np.ndarray:
    """The samples (robots, samples) from which :func:`under_way` begins, to the end: also those in which it stands."""
    return np.logical_or.accumulate(under_way(run), axis=-1)


def _late_heading(run: Run) -> np.ndarray:
    """Infinite for a robot that was stopped before."""
    return rms_of(np.where(late(run), tracking_error(run).heading, np.nan))


def _late_distance(run: Run) -> np.ndarray:
    """Infinite as :func:`_late_heading`."""
    error = tracking_error(run)
    return rms_of(np.where(late(run), np.hypot(error.x, error.y), np.nan))


def rms_of(errors: np.ndarray) -> np.ndarray:
    """The root mean square (runs, robots) of the known ``errors`` (runs, robots, samples); infinite without any."""
    found = np.sqrt(_mean(errors**2))
    return np.where(np.isnan(found), np.inf, found)


def _late_turning(run: Run) -> np.ndarray:
    """The total variation of ω_demand a second; infinite as :func:`_late_heading`."""
    between = late(run)[..., 1:] & np.isfinite(run["x"][..., 1:])
    total = np.where(between, np.abs(np.diff(run["w_demand"], axis=-1)), 0.0).sum(-1)
    seconds = between.sum(-1) * (run.time[1] - run.time[0])
    return np.where(seconds > 0, total / np.where(seconds > 0, seconds, 1.0), np.inf)


_timed = partial(Metric, kinds=TIMETABLED)
_headline = partial(_timed, headline=("tracking",))
_tried = partial(_timed, tried=("tracking",))
_both = partial(_headline, tried=("tracking",))
METRICS: dict[str, Metric] = {
    # The totals of thesis (2.26), named for what they are
    "mean_abs_x_error_m": _timed(lambda r: tracking_errors(r).x, "m", "mean |x_err|"),
    "mean_abs_y_error_m": _timed(lambda r: tracking_errors(r).y, "m", "mean |y_err|"),
    "mean_abs_heading_error_rad": _tried(lambda r: tracking_errors(r).heading, "rad", "mean |ψ_err|"),
    "mean_error_norm": _headline(
        lambda r: tracking_errors(r).norm, "m, rad", "mean error norm: 1 rad counted as 1 m", short="error norm"
    ),
    "mean_speed_error_mps": _both(
        lambda r: _mean(np.abs(r["v_demand"] - r["v"])),
        "m/s",
        "mean speed error: demanded minus driven",
        short="speed error",
    ),
    # What the field reports
    "rms_cross_track_m": _timed(
        lambda r: np.sqrt(_mean(cross_track_error(r) ** 2)),
        "m",
        "RMS cross-track error",
        headline=("tracking", "team"),
        short="RMS cross-track",
        tried=("tracking", "team"),
    ),
    "rms_cross_track_under_way_m": _headline(
        _rms_under_way,
        "m",
        "RMS cross-track error under way: from 6 s until the reference stands",
        short="RMS under way",
    ),
    "max_cross_track_m": _tried(
        lambda r: np.nanmax(np.abs(cross_track_error(r)), axis=-1), "m", "largest cross-track error"
    ),
    "settling_time_s": _both(
        lambda r: tracking_errors(r).settled,
        "s",
        "settling time: distance to the reference below 5 cm for good",
        short="settling",
    ),
    "path_settling_time_s": _tried(
        lambda r: settling_time(r, cross_track_error(r)), "s", "settling time: cross-track error below 5 cm for good"
    ),
    "overshoot_m": _timed(
        lambda r: np.nanmax(path_errors(r)[1], axis=-1),
        "m",
        "overshoot: the farthest that it gets beyond the path's end",
    ),
    "final_error_m": _tried(lambda r: tracking_errors(r).final, "m", "distance to the reference at the end"),
    "control_effort": _headline(
        lambda r: _rate(r, at_end(r["effort"])),
        "N² m²",
        "mean square torque, both wheels",
        short="effort",
        kinds=SCENARIO_KINDS,
    ),
    "torque_variation_nmps": _headline(
        lambda r: _rate(r, at_end(r["torque_variation"])),
        "N m/s",
        "total variation of the torques a second: chatter",
        kinds=SCENARIO_KINDS,
        short="torque variation",
        tried=("tracking", "team"),
    ),
    "v_variation_mps2": Metric(
        lambda r: _variation(r, "v_demand"), "m/s²", "total variation of the demanded speed a second"
    ),
    "rms_distance_late_m": _timed(_late_distance, "m", "RMS distance to the reference from 6 s on"),
    "rms_heading_late_rad": _timed(_late_heading, "rad", "RMS heading error from 6 s on"),
    "w_variation_late_radps2": _timed(
        _late_turning, "rad/s²", "total variation of the demanded turn rate a second, from 6 s on"
    ),
    "w_variation_radps2": Metric(
        lambda r: _variation(r, "w_demand"), "rad/s²", "total variation of the demanded turn rate a second"
    ),
}


def measure(run: Run) -> dict[str, np.ndarray]:
    """The metrics of METRICS by name, each (runs, robots), in its unit.

    Args:
        run: The run.
    """
    return {name: metric.measure(run) for name, metric in METRICS.items()}
