"""Wheels and axle by a pose or a yaw rate that the wheels have no part in: how wrong odometry's sizes are.

The measured wheel speeds are integrated with a scale of each wheel and of the axle, from a start that is fitted too;
what is left between that track and the measured poses is least squares. The intervals widen by the long-run variance of
the scores, for odometry's errors add up along the way.
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
            return _by_poses(signals.poses, signals.velocities, base, averaged), ""
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
    """The poses (3, n) of a robot whose wheels go ``ways`` (2, n) [m] from the pose ``start`` (3,) on."""
    turn = (ways[0] - ways[1]) / (2 * half_axle)
    heading = start[2] + np.cumsum(turn)
    middle, forward = heading - turn / 2, (ways[0] + ways[1]) / 2
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


def _by_poses(poses: Poses, seen: MeasuredVelocities, base: Robot, averaged: bool) -> Calibration:
    inside, rows = _matched(poses, seen)
    time, rows = poses.time[inside], rows[:, inside]
    ways, half = _ways(seen, averaged, base.half_axle), base.half_axle

    def wrong(x: np.ndarray) -> np.ndarray:
        """Poses of the model minus those measured (3, n), for start, scale, and the ratios of wheels and axle."""
        scales = x[3] * np.array([2 * x[4], 2.0]) / (1 + x[4])
        at = track(x[:3], ways * scales[:, None], half * x[5])
        return np.stack([np.interp(time, seen.time, each) for each in at]) - rows

    x = np.array([*rows[:, 0], 1.0, 1.0, 1.0])
    scale, filters = np.array([0.01, 0.01, 0.01]), [np.ones(1)] * 3
    for _ in range(3):
        x = least_squares(lambda x, s=scale, h=filters: _filtered(wrong(x), s, h).ravel(), x, x_scale="jac").x
        left = wrong(x)
        fits = [autoregression(each) for each in left]
        scale = np.array([max(deviation, 1e-7) for _, deviation in fits])
        filters = [np.concatenate([[1.0], -coefficients]) for coefficients, _ in fits]
    found: Any = least_squares(lambda x: _filtered(wrong(x), scale, filters).ravel(), x, x_scale="jac")
    spread = np.sqrt(np.diag(long_run(found.jac.reshape(3, -1, len(x)), found.fun.reshape(3, -1))))
    size = float(t_distribution.ppf((1 + CONFIDENCE) / 2, found.fun.size - len(x)))
    places = range(3, 6)
    values = {name: float(found.x[k]) for name, k in zip(_NAMES, places, strict=True)}
    ends = {
        n: Ends(values[n] - size * spread[k], values[n] + size * spread[k]) for n, k in zip(_NAMES, places, strict=True)
    }
    left = wrong(found.x)
    noise = {"position_noise": float(np.sqrt((scale[:2] ** 2).mean())), "heading_noise": float(scale[2])}
    return Calibration(values, ends, noise, len(time), float(np.sqrt((left[:2] ** 2).sum(axis=0).mean())))


def _filtered(rows: np.ndarray, scale: np.ndarray, filters: list[np.ndarray]) -> np.ndarray:
    return np.stack([np.convolve(each, h)[: len(each)] / s for each, s, h in zip(rows, scale, filters, strict=True)])


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
