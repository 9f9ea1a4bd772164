"""Wheels and axle by a pose or a turn rate that the wheels have no part in: how wrong odometry's sizes are.

The measured wheel speeds are integrated with a scale of each wheel and of the axle, from a start that is fitted too;
what is left between that track and the measured poses is least squares. The intervals widen by the long-run variance of
the scores, for odometry's errors add up along the way.

Tyres slip where a robot speeds up or brakes hard, and what it stays behind then would make its wheels smaller. So the
stretches of steady driving are fitted by themselves as well, each from a start of its own, and count alone where they
tell the scale more surely: what slips leaves a track that no scale fits.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.optimize import least_squares
from scipy.stats import t as t_distribution

from robotics.plugins.identify.fit import CONFIDENCE, Ends, autoregression, long_run
from robotics.plugins.identify.signals import LOG_GAP, MeasuredVelocities, Poses, Signals, YawRates
from robotics.world.vehicle.robot import Robot

_SAME = 3e-4  # m and rad from sample to sample: poses that differ by less from odometry's are odometry's
_NAMES = ("scale", "wheel_ratio", "axle_ratio")
_STEADY = 0.4  # m/s²: the change of a rim's speed over a fifth of a second, up to which a drive is steady
_CALMING = 0.4  # s after a faster change, in which tyres may slip on
_SHORTEST, _ENOUGH = 0.6, 6.0  # s of a steady stretch, and of all of them together

Stretch = tuple[int, int]  # the first sample of odometry and the one behind the last


@dataclass(frozen=True, eq=False)
class Calibration:
    """What poses tell of wheels and axle.

    Attributes:
        values: By name: "scale" (true way over odometry's), "wheel_ratio" (right over left radius), "axle_ratio"
            (true over assumed axle); of a gyroscope alone "turn_scale" (true turn over odometry's).
        intervals: Their 95 % intervals.
        noise: Standard deviations of the poses' own noise: "position_noise" [m], "heading_noise" [rad]; of a gyroscope
            "yaw_noise" [rad/s].
        samples: By how many values each of these noises is known.
        error: RMS distance [m] from the poses to the fitted track.
    """

    values: dict[str, float]
    intervals: dict[str, Ends]
    noise: dict[str, float]
    samples: int
    error: float = float("nan")


def calibrated(signals: Signals, base: Robot, averaged: bool) -> tuple[Calibration | None, str]:
    """Calibrate wheels and axle; None and why, in a sentence, where the log does not tell them."""
    if signals.poses is not None:
        if len(signals.poses.time) < 30:
            return None, "There are too few poses to tell wheels and axle."
        if _are_odometry(signals, base, averaged):
            if signals.yaw is None:
                return None, (
                    "The poses are what odometry made of the wheels: wheel radii and axle are not known by them. Name "
                    "a pose that does not come from the wheels with --pose, or a gyroscope with --imu."
                )
        else:
            return _by_poses_or_steadily(signals.poses, signals.velocities, base, averaged)
    if signals.yaw is not None:
        return _by_gyroscope(signals.yaw, signals.velocities, averaged)
    return None, "There are no poses: wheel radii and axle are only known as odometry has them."


def _ways(seen: MeasuredVelocities, averaged: bool, half_axle: float) -> np.ndarray:
    """How far each wheel went by odometry from sample to sample (2, n): right, left; nothing over a gap's length."""
    right, left = seen.v + half_axle * seen.w, seen.v - half_axle * seen.w
    since = np.diff(seen.time, prepend=seen.time[0])
    if averaged:
        return np.stack([right, left]) * since
    means = [(each + np.concatenate([each[:1], each[:-1]])) / 2 for each in (right, left)]
    return np.stack(means) * since


def track(start: np.ndarray, ways: np.ndarray, half_axle: float) -> np.ndarray:
    """The poses (3, n) of a robot whose wheels go ``ways`` (2, n) [m] from the pose ``start`` (3,) on, by arcs."""
    turn = (ways[0] - ways[1]) / (2 * half_axle)
    heading = start[2] + np.cumsum(turn)
    middle, forward = heading - turn / 2, (ways[0] + ways[1]) / 2 * np.sinc(turn / (2 * np.pi))  # the arc's chord
    return np.stack([
        start[0] + np.cumsum(forward * np.cos(middle)), start[1] + np.cumsum(forward * np.sin(middle)), heading
    ])  # fmt: skip


def _matched(poses: Poses, seen: MeasuredVelocities) -> tuple[np.ndarray, np.ndarray]:
    """Which poses lie between samples of odometry without a gap, and all poses as rows (3, n)."""
    place = np.clip(np.searchsorted(seen.time, poses.time), 1, len(seen.time) - 1)
    near = seen.time[place] - seen.time[place - 1] <= LOG_GAP
    inside = (poses.time >= seen.time[0]) & (poses.time <= seen.time[-1]) & near
    return inside, np.stack(poses[1:])


def _are_odometry(signals: Signals, base: Robot, averaged: bool) -> bool:
    poses, seen = signals.poses, signals.velocities
    assert poses is not None
    inside, rows = _matched(poses, seen)
    ways = track(
        np.array([poses.x[0], poses.y[0], poses.heading[0]]), _ways(seen, averaged, base.half_axle), base.half_axle
    )
    told = np.stack([np.interp(poses.time, seen.time, each) for each in ways])
    steps = np.diff(rows[:, inside], axis=1), np.diff(told[:, inside], axis=1)
    forward = np.hypot(*steps[0][:2]) - np.hypot(*steps[1][:2])
    turned = steps[0][2] - steps[1][2]
    return bool(
        max(np.std(forward), np.std(turned)) < _SAME and abs(turned.sum()) < 1e-2 * np.abs(steps[0][2]).sum() + 1e-9
    )


def steady_stretches(seen: MeasuredVelocities, half_axle: float) -> list[Stretch]:
    """The stretches of odometry in which no wheel's speed has changed much for a while."""
    period = float(np.median(np.diff(seen.time)))
    back = max(1, round(0.2 / period))
    rims = np.stack([seen.v + half_axle * seen.w, seen.v - half_axle * seen.w])
    fast = np.zeros(len(seen.time), dtype=bool)
    hard = np.abs(rims[:, back:] - rims[:, :-back]).max(axis=0) > _STEADY * (seen.time[back:] - seen.time[:-back])
    gap = np.diff(seen.time, prepend=seen.time[0]) > LOG_GAP
    for k in np.flatnonzero(hard):
        fast[k : k + back + round(_CALMING / period)] = True
    edges = np.flatnonzero(np.diff(np.concatenate([[True], fast | gap, [True]]).astype(int)))
    return [
        (int(first), int(last))
        for first, last in edges.reshape(-1, 2)
        if seen.time[last - 1] - seen.time[first] >= _SHORTEST
    ]


def _by_poses_or_steadily(
    poses: Poses, seen: MeasuredVelocities, base: Robot, averaged: bool
) -> tuple[Calibration, str]:
    """By the whole drive, or where that says something else by its steady stretches, with a sentence."""
    whole = _by_poses(poses, seen, base, averaged, [(0, len(seen.time))])
    parts = steady_stretches(seen, base.half_axle)
    lasting = sum(seen.time[last - 1] - seen.time[first] for first, last in parts)
    if lasting < _ENOUGH:
        return whole, ""
    steady = _by_poses(poses, seen, base, averaged, parts)
    if np.ptp(whole.intervals["scale"]) <= np.ptp(steady.intervals["scale"]):
        return whole, ""
    smaller = 1 - whole.values["scale"] / steady.values["scale"]
    return steady, (
        f"The wheels slip where the robot speeds up or brakes: by the whole drive they would be "
        f"{abs(100 * smaller):.2g} % {'smaller' if smaller > 0 else 'larger'}. Wheels and axle are those of the "
        f"{lasting:.0f} s of steady driving."
    )


def _by_poses(
    poses: Poses, seen: MeasuredVelocities, base: Robot, averaged: bool, stretches: list[Stretch]
) -> Calibration:
    inside, rows = _matched(poses, seen)
    time, rows = poses.time[inside], rows[:, inside]
    ways, half = _ways(seen, averaged, base.half_axle), base.half_axle
    parts = []
    for first, last in stretches:
        chosen = np.flatnonzero((time >= seen.time[first]) & (time <= seen.time[last - 1]))
        if len(chosen) > 3:
            way = ways[:, first:last].copy()
            way[:, 0] = 0.0
            parts.append((seen.time[first:last], way, chosen))
    rows = np.concatenate([rows[:, chosen] for *_, chosen in parts], axis=1)
    ends_of = np.cumsum([len(chosen) for *_, chosen in parts])

    def wrong(x: np.ndarray) -> np.ndarray:
        """Poses of the model minus those measured (3, n), for the starts, and the ratios of scale, wheels and axle."""
        size, ratio, axle = x[-3:]
        scales = size * np.array([2 * ratio, 2.0]) / (1 + ratio)
        told = []
        for start, (when, way, chosen) in zip(x[:-3].reshape(-1, 3), parts, strict=True):
            at = track(start, way * scales[:, None], half * axle)
            told.append([np.interp(time[chosen], when, each) for each in at])
        return np.concatenate(told, axis=1) - rows

    x = np.array([*(rows[:, [0, *ends_of[:-1]]].T.ravel()), 1.0, 1.0, 1.0])
    scale, filters = np.array([0.01, 0.01, 0.01]), [np.ones(1)] * 3
    for _ in range(3):
        x = least_squares(lambda x, s=scale, h=filters: _filtered(wrong(x), s, h, ends_of).ravel(), x, x_scale="jac").x
        left = wrong(x)
        fits = [autoregression(each) for each in left]
        scale = np.array([max(deviation, 1e-7) for _, deviation in fits])
        filters = [np.concatenate([[1.0], -coefficients]) for coefficients, _ in fits]
    found: Any = least_squares(lambda x: _filtered(wrong(x), scale, filters, ends_of).ravel(), x, x_scale="jac")
    spread = np.sqrt(np.diag(long_run(found.jac.reshape(3, -1, len(x)), found.fun.reshape(3, -1))))
    size = float(t_distribution.ppf((1 + CONFIDENCE) / 2, found.fun.size - len(x)))
    places = range(len(x) - 3, len(x))
    values = {name: float(found.x[k]) for name, k in zip(_NAMES, places, strict=True)}
    ends = {
        n: Ends(values[n] - size * spread[k], values[n] + size * spread[k]) for n, k in zip(_NAMES, places, strict=True)
    }
    left = wrong(found.x)
    noise = {"position_noise": float(np.sqrt((scale[:2] ** 2).mean())), "heading_noise": float(scale[2])}
    return Calibration(values, ends, noise, rows.shape[1], float(np.sqrt((left[:2] ** 2).sum(axis=0).mean())))


def _filtered(rows: np.ndarray, scale: np.ndarray, filters: list[np.ndarray], ends: np.ndarray) -> np.ndarray:
    """Rows (3, n) whitened stretch by stretch; ``ends`` are the places behind each stretch."""
    return np.stack([
        np.concatenate([np.convolve(part, h)[: len(part)] for part in np.split(each, ends[:-1])]) / s
        for each, s, h in zip(rows, scale, filters, strict=True)
    ])  # fmt: skip


def _by_gyroscope(yaw: YawRates, seen: MeasuredVelocities, averaged: bool) -> tuple[Calibration | None, str]:
    period = float(np.median(np.diff(seen.time)))
    turned = np.concatenate([[0.0], np.cumsum(np.diff(yaw.time) * (yaw.w[1:] + yaw.w[:-1]) / 2)])
    inside = (seen.time - period > yaw.time[0]) & (seen.time < yaw.time[-1])
    ends = (np.interp(seen.time[inside] - back, yaw.time, turned) for back in (0.0, period))
    now, before = ends
    mean = (now - before) / period if averaged else np.interp(seen.time[inside], yaw.time, yaw.w)
    given = seen.w[inside]
    if np.ptp(given) < 0.2:
        return None, "The robot hardly turned: the gyroscope tells nothing of the axle."
    columns = np.stack([np.ones_like(given), given], axis=1)
    (_, slope), *_ = np.linalg.lstsq(columns, mean, rcond=None)
    left = mean - columns @ np.linalg.lstsq(columns, mean, rcond=None)[0]
    spread = float(np.sqrt(long_run(columns[None], left[None])[1, 1]))
    size = float(t_distribution.ppf((1 + CONFIDENCE) / 2, len(given) - 2))
    rest = np.abs(given) < 1e-9
    noise = float(np.std(left[rest])) if np.count_nonzero(rest) > 30 else float(np.std(left))
    values, intervals = {"turn_scale": float(slope)}, {"turn_scale": Ends(slope - size * spread, slope + size * spread)}
    return Calibration(values, intervals, {"yaw_noise": noise}, len(given)), (
        "The gyroscope alone tells how true turns are to odometry's, not whether wheels or axle are the cause."
    )
