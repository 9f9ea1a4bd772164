"""Noise, encoders' rounding and wheels: each against a closed form."""

import numpy as np
import pytest

from robotics.plugins.identify.calibration import calibrated, track
from robotics.plugins.identify.fit import autoregression, long_run
from robotics.plugins.identify.noise import counts_per_turn, deviation, whiteness
from robotics.plugins.identify.signals import MeasuredVelocities, Poses, Signals, YawRates
from robotics.plugins.logs.drive import Commands
from robotics.simulation.scenario.robots import load_robot

SHEET = load_robot("etsro").robot


def test_white_noise_is_white_and_an_average_of_neighbours_is_not() -> None:
    drawn = np.random.default_rng(1).standard_normal(2000)
    assert whiteness(drawn, 0.05).p_value > 0.01
    smooth = whiteness((drawn[1:] + drawn[:-1]) / 2, 0.05)
    assert smooth.p_value < 1e-6
    assert smooth.first == pytest.approx(0.5, abs=0.07)


def test_white_noise_passes_as_often_as_its_level_says() -> None:
    generator = np.random.default_rng(2)
    passed = np.mean([whiteness(generator.standard_normal(800), 0.05).p_value > 0.05 for _ in range(400)])
    assert passed == pytest.approx(0.95, abs=0.035)


def test_an_autoregression_is_found() -> None:
    generator, series = np.random.default_rng(3), np.zeros(4000)
    for k in range(2, 4000):
        series[k] = 0.8 * series[k - 1] - 0.3 * series[k - 2] + generator.standard_normal()
    coefficients, left = autoregression(series)
    assert coefficients[:2] == pytest.approx([0.8, -0.3], abs=0.06)
    assert left == pytest.approx(1.0, abs=0.05)


def test_the_long_run_variance_of_a_mean_is_that_of_its_spectrum() -> None:
    """A moving average of two has four times the variance of its mean's white noise, not twice."""
    drawn = np.random.default_rng(4).standard_normal(40_000)
    series = drawn[1:] + drawn[:-1]
    found = long_run(np.ones((1, len(series), 1)), series[None])[0, 0] * len(series)
    assert found == pytest.approx(4.0, rel=0.25)


@pytest.mark.parametrize("counts", [360.0, 4096.0])
def test_counts_are_read_off_rounded_speeds_and_not_off_noise(counts: float) -> None:
    generator, time = np.random.default_rng(5), 0.05 * np.arange(1200)
    speed = 0.3 * np.sin(0.7 * time) + 0.1 * np.sin(3.1 * time)
    turn = np.sin(1.3 * time)
    ticks = [
        np.floor(np.cumsum(speed + side * 0.1 * turn) * 0.05 / SHEET.wheel_radius * counts / 2 / np.pi)
        for side in (1, -1)
    ]
    right, left = (np.diff(each, prepend=0) / 0.05 * 2 * np.pi / counts * SHEET.wheel_radius for each in ticks)
    found = counts_per_turn(MeasuredVelocities(time, (right + left) / 2, (right - left) / 0.2), SHEET)
    assert found is not None
    assert found[0] == pytest.approx(counts, rel=1e-3)
    noisy = (right + left) / 2 + 0.01 * generator.standard_normal(1200)
    assert counts_per_turn(MeasuredVelocities(time, noisy, (right - left) / 0.2), SHEET) is None


def test_the_interval_of_a_deviation_covers() -> None:
    generator = np.random.default_rng(6)
    ends = [deviation(0.3 * generator.standard_normal(400))[1] for _ in range(300)]
    assert np.mean([low <= 0.3 <= high for low, high in ends]) == pytest.approx(0.95, abs=0.04)


def drive(seed: int, right: float, left: float, axle: float) -> Signals:
    """Odometry of a robot whose wheels and axle are these times what odometry takes them for, and its noisy poses."""
    generator, time = np.random.default_rng(seed), 0.05 * np.arange(1200)
    v, w = 0.3 * np.sin(0.4 * time) + 0.1, 1.2 * np.sin(0.9 * time)
    ways = np.stack([(v + 0.1 * w) * right, (v - 0.1 * w) * left]) * 0.05
    x, y, heading = track(np.array([1.0, 2.0, 0.5]), ways, 0.1 * axle)
    noisy = (each + 0.003 * generator.standard_normal(1200) for each in (x, y, heading))
    yaw = np.append(np.diff(heading), 0.0) / 0.05 + 0.02 + 0.002 * generator.standard_normal(1200)
    commands, seen = Commands(time, v, w), MeasuredVelocities(time, v, w)
    return Signals("x", commands, seen, Poses(time, *noisy), YawRates(time, yaw))


def test_wheels_and_axle_are_known_by_poses_and_their_intervals_cover() -> None:
    hits = []
    for seed in range(12):
        found, why = calibrated(drive(seed, 1.03, 1.01, 0.95), SHEET, True)
        assert found is not None
        assert not why
        true = {"scale": 1.02, "wheel_ratio": 1.03 / 1.01, "axle_ratio": 0.95}
        assert found.values == pytest.approx(true, rel=3e-3)
        hits += [found.intervals[name].low <= value <= found.intervals[name].high for name, value in true.items()]
        assert found.noise["position_noise"] == pytest.approx(0.003, rel=0.1)
    assert np.mean(hits) >= 0.8


def slipping(seed: int, grip: float) -> Signals:
    """Odometry whose wheels spin where they speed up by more than ``grip`` [m/s²], and the noisy poses of the robot."""
    generator, time = np.random.default_rng(seed), 0.05 * np.arange(1200)
    v, w = (np.repeat(generator.uniform(-size, size, 30), 40) for size in (0.5, 1.5))
    rims = np.stack([v + 0.1 * w, v - 0.1 * w])
    for k in range(1, 1200):  # wheels follow their commands within some periods
        rims[:, k] = rims[:, k - 1] + np.clip(rims[:, k] - rims[:, k - 1], -0.1, 0.1)
    faster = np.diff(np.abs(rims), axis=1, prepend=0) / 0.05
    rolled = 1.02 * rims * np.where(faster > grip, 0.6, 1.0) * 0.05
    x, y, heading = track(np.zeros(3), rolled, 0.1)
    noisy = (each + 0.003 * generator.standard_normal(1200) for each in (x, y, heading))
    v, w = rims.mean(axis=0), (rims[0] - rims[1]) / 0.2
    return Signals("x", Commands(time, v, w), MeasuredVelocities(time, v, w), Poses(time, *noisy))


def test_wheels_that_slip_are_known_by_what_they_roll() -> None:
    hits = []
    for seed in range(12):
        found, why = calibrated(slipping(seed, 1.8), SHEET, True)
        assert found is not None
        assert "slip" in why
        assert "smaller" in why
        true = {"scale": 1.02, "wheel_ratio": 1.0, "axle_ratio": 1.0}
        assert found.values == pytest.approx(true, rel=0.012)
        hits += [found.intervals[name].low <= value <= found.intervals[name].high for name, value in true.items()]
        gripping, why = calibrated(slipping(seed, 9.0), SHEET, True)
        assert gripping is not None
        assert not why
        assert np.ptp(gripping.intervals["scale"]) < np.ptp(found.intervals["scale"])
    assert np.mean(hits) >= 0.8


def test_poses_of_odometry_tell_nothing_of_wheels() -> None:
    one = drive(1, 1.0, 1.0, 1.0)
    seen = one.velocities
    ways = np.stack([seen.v + 0.1 * seen.w, seen.v - 0.1 * seen.w]) * 0.05
    own = Poses(seen.time, *track(np.zeros(3), ways, 0.1))
    found, why = calibrated(Signals("x", one.commands, seen, own), SHEET, True)
    assert found is None
    assert "--pose" in why


def test_a_gyroscope_tells_turns_only() -> None:
    one = drive(2, 1.02, 1.02, 0.96)
    found, why = calibrated(Signals("x", one.commands, one.velocities, None, one.yaw), SHEET, False)
    assert found is not None
    assert found.values["turn_scale"] == pytest.approx(1.02 / 0.96, rel=0.02)
    assert "turns" in why
