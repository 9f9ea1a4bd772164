"""Metrics on runs small enough to compute by hand."""

from dataclasses import replace
from math import hypot, inf, nan, pi, sqrt

import numpy as np
import pytest

from robotics.laws.catalogue import make_controller
from robotics.measures.arrival import at_end, at_end_compiled
from robotics.measures.tracking import (
    METRICS,
    cross_track_error,
    measure,
    settling_time,
    tracking_error,
    tracking_errors,
)
from robotics.simulation.loop import simulate
from robotics.simulation.run import CHANNELS, REFERENCE
from robotics.simulation.scenario.reading import load_scenario
from robotics.world.paths.path import Circle, Line, Sine, compile_path
from tests.robotics.handmade import handmade

LINE = compile_path(Line(start=(0.0, 0.0), end=(10.0, 0.0)))


def run_of(path=LINE, stopped=-1, reference=None, **channels):
    """One robot of one seed, a sample a half second; what is not given is 0."""
    n = len(next(iter(channels.values())))
    samples = np.zeros((n, len(CHANNELS), 1, 1))
    for name, values in channels.items():
        samples[:, list(CHANNELS).index(name), 0, 0] = values
    target = np.zeros((len(REFERENCE), n, 1))
    for name, values in (reference or {}).items():
        target[list(REFERENCE).index(name), :, 0] = values
    if stopped >= 0:
        samples[stopped + 1 :] = nan
    nodes = (path.table[:2],)
    return handmade((0,), 0.5 * np.arange(n), samples, target, nodes, np.array([[stopped]]))


def value(name, run):
    result = METRICS[name].measure(run)
    assert result.shape == (1, 1)
    return float(result[0, 0])


def test_tracking_error_is_desired_minus_actual_in_the_robots_frame():
    run = run_of(
        x=[1.0, 0.0], y=[1.0, 0.0], heading=[pi / 2, pi], reference={"x": [2, 3], "y": [4, 4], "heading": [0, -pi]}
    )
    e = tracking_error(run)
    np.testing.assert_allclose(e.x[0, 0], [3, -3], atol=1e-12)  # ahead: +y; then -x
    np.testing.assert_allclose(e.y[0, 0], [-1, -4], atol=1e-12)  # the target lies to the right
    np.testing.assert_allclose(e.heading[0, 0], [-pi / 2, 0], atol=1e-12)  # wrapped


def test_the_totals_of_2_26():
    """Four samples: errors (3, 4) and (0, 0) with headings 0 and 0.5; v_d − v of 0.1, −0.3, 0, 0."""
    run = run_of(
        x=[0, 0, 0, 0], heading=[0, 0, 0, 0], v=[0.1, 0.4, 0.2, 0.2], v_demand=[0.2, 0.1, 0.2, 0.2],
        reference={"x": [3, -3, 0, 0], "y": [4, 0, 0, 0], "heading": [0, 0, 0.5, 2 * pi]},
    )  # fmt: skip
    assert value("mean_abs_x_error_m", run) == pytest.approx(6 / 4)
    assert value("mean_abs_y_error_m", run) == pytest.approx(1)
    assert value("mean_abs_heading_error_rad", run) == pytest.approx(0.5 / 4)
    assert value("mean_error_norm", run) == pytest.approx((5 + 3 + 0.5 + 0) / 4)
    assert value("mean_speed_error_mps", run) == pytest.approx(0.4 / 4)
    assert value("final_error_m", run) == 0


def test_mean_error_norm_lies_between_the_norm_of_means_and_their_sum():
    """Erratum A18."""
    rng = np.random.default_rng(1)
    run = run_of(x=rng.normal(size=50), y=rng.normal(size=50), heading=rng.normal(size=50))
    means = [value(f"mean_abs_{n}", run) for n in ("x_error_m", "y_error_m", "heading_error_rad")]
    assert hypot(*means) <= value("mean_error_norm", run) <= sum(means)


def test_cross_track_error_of_a_line_is_its_distance_left_positive():
    run = run_of(x=[1.003, 5.0, 9.999, -3.0, 12.0], y=[0.2, -0.3, 0.0, 4.0, 0.003])
    np.testing.assert_allclose(np.abs(cross_track_error(run)[0, 0]), [0.2, 0.3, 0, 5, 0.003], atol=1e-12)
    np.testing.assert_allclose(cross_track_error(run)[0, 0, :2], [0.2, -0.3], atol=1e-12)
    assert value("rms_cross_track_m", run) == pytest.approx(sqrt((0.04 + 0.09 + 25 + 9e-6) / 5))
    assert value("max_cross_track_m", run) == pytest.approx(5)
    assert value("overshoot_m", run) == pytest.approx(2)


def test_a_robot_that_stops_beyond_the_end_of_its_path_has_settled_on_it():
    run = run_of(x=[0.0, 5.0, 10.06, 10.06], y=[0.2, 0.003, 0.003, 0.003])
    assert value("path_settling_time_s", run) == run.time[1]
    assert value("overshoot_m", run) == pytest.approx(0.06)


@pytest.mark.parametrize("direction", ["clockwise", "counter-clockwise"])
def test_cross_track_error_of_a_circle_is_the_difference_of_radii(direction):
    path = compile_path(Circle(radius=1.5, center=(1.0, 2.0), direction=direction))
    angle, radius = np.linspace(0.1, 6.2, 60), 1.5 + 0.4 * np.sin(np.arange(60))
    run = run_of(path, x=1 + radius * np.cos(angle), y=2 + radius * np.sin(angle))
    outside = radius - 1.5
    expected = outside if direction == "clockwise" else -outside  # the center lies right or left
    np.testing.assert_allclose(cross_track_error(run)[0, 0], expected, rtol=0, atol=3e-6)  # chords of 5 mm


def test_cross_track_error_of_a_point_on_the_path_is_none():
    path = compile_path(Sine(x_end=6.0))
    points = path.at(np.linspace(0, path.length, 333))
    run = run_of(path, x=points.x, y=points.y)
    assert np.abs(cross_track_error(run)).max() < 5e-6


def test_settling_time_is_from_when_it_stays_within_5_cm():
    run = run_of(x=np.zeros(6))

    def settled(*distance):
        return float(settling_time(run, np.array([[distance]]))[0, 0])

    assert settled(1, 0.2, 0.04, 0.03, 0.0, 0.01) == 1.0
    assert settled(1, 0.04, 0.2, 0.03, 0.0, 0.01) == 1.5  # it left once more
    assert settled(-1, 0.04, -0.2, -0.03, 0.0, 0.01) == 1.5
    assert settled(0.04, 0.04, 0.04, 0.04, 0.04, 0.049) == 0
    assert settled(0, 0, 0, 0, 0, 0.05) == inf  # not at the end
    assert settled(1, 1, 1, 1, 1, 0) == 2.5
    assert settled(1, 1, 1, 1, 1, 1) == inf
    assert settled(0, 0, 0, nan, nan, nan) == inf  # stopped


def test_both_settling_times():
    """It reaches its path at 1 s, its reference never."""
    run = run_of(x=[0, 0, 0, 0], y=[1, 0.5, 0.01, 0.01], reference={"x": [1, 1, 1, 1]})
    assert value("path_settling_time_s", run) == 1.0
    assert value("settling_time_s", run) == inf


def test_rates_are_totals_a_second():
    run = run_of(
        x=np.zeros(5), effort=[0, 1, 2, 3, 5], torque_variation=[0, 0, 4, 4, 8], v_demand=[0, 1, -1, -1, 0],
        w_demand=[2, 2, 0, 0, 1],
    )  # fmt: skip
    assert value("control_effort", run) == pytest.approx(5 / 2)  # in 2 s
    assert value("torque_variation_nmps", run) == pytest.approx(8 / 2)
    assert value("v_variation_mps2", run) == pytest.approx((1 + 2 + 0 + 1) / 2)
    assert value("w_variation_radps2", run) == pytest.approx(3 / 2)


def test_what_varies_late_counts_from_6_s_on():
    ticks = np.arange(30)  # 14.5 s
    early = np.where(ticks < 10, ticks % 2, 0.0)
    w = early + 2.0 * (ticks >= 25)
    run = run_of(x=ticks, w_demand=w, reference={"x": ticks, "v": np.ones(30)})
    assert value("w_variation_late_radps2", run) == pytest.approx(2 / 9.0)


def test_a_stopped_robot_is_measured_up_to_then():
    run = run_of(x=[0, 1, 2, 3, 4], y=[0, 0, 0.3, 9, 9], effort=[0, 1, 3, 7, 7], v_demand=[0, 1, 0, 5, 0], stopped=2)
    assert value("final_error_m", run) == pytest.approx(hypot(2, 0.3))
    assert value("mean_abs_x_error_m", run) == pytest.approx(1)
    assert value("max_cross_track_m", run) == pytest.approx(0.3)
    assert value("control_effort", run) == pytest.approx(3 / 1)  # in 1 s
    assert value("v_variation_mps2", run) == pytest.approx(2 / 1)
    assert value("settling_time_s", run) == inf
    at_once = run_of(x=[7, 1], y=[0, 0], stopped=0)
    assert value("final_error_m", at_once) == 7
    assert value("control_effort", at_once) == 0


def test_measure_gives_every_metric_for_every_seed_and_robot():
    n, runs, robots = 4, 3, 2
    rng = np.random.default_rng(0)
    samples = rng.normal(size=(n, len(CHANNELS), runs, robots))
    reference = rng.normal(size=(len(REFERENCE), n, robots))
    other = compile_path(Circle())
    run = handmade(
        (1, 2, 3), 0.5 * np.arange(n), samples, reference,
        (LINE.table[:2], other.table[:2]), np.full((runs, robots), -1),
    )  # fmt: skip
    found = measure(run)
    assert list(found) == list(METRICS)
    for i in range(runs):
        for k in range(robots):
            one = handmade(
                (i,), run.time, samples[:, :, i : i + 1, k : k + 1], reference[:, :, k : k + 1],
                run.paths[k : k + 1], np.array([[-1]]),
            )  # fmt: skip
            for name, values in measure(one).items():
                assert values[0, 0] == found[name][i, k], name
    for metric in METRICS.values():
        assert metric.unit
        assert metric.title


def test_sums_of_the_tracking_error_are_those_of_its_samples():
    """The compiled sums beside numpy's over the samples, of runs in which robots are stopped too."""
    about = replace(load_scenario("lyapunov-sine"), divergence=0.9, duration=12.0)
    stopped = simulate(about, make_controller("lyapunov"), range(3))
    assert (stopped.stopped >= 0).any()
    for run in (stopped, simulate(load_scenario("three-cross"), make_controller("right-of-way"), range(2))):
        e, sums = tracking_error(run), tracking_errors(run)
        for name in ("x", "y", "heading"):
            expected = np.nanmean(np.abs(getattr(e, name)), axis=-1)
            np.testing.assert_allclose(getattr(sums, name), expected, rtol=0, atol=1e-12)
        distance = np.hypot(e.x, e.y)
        norm = np.nanmean(np.sqrt(distance**2 + e.heading**2), axis=-1)
        np.testing.assert_allclose(sums.norm, norm, rtol=0, atol=1e-12)
        np.testing.assert_array_equal(sums.settled, settling_time(run, distance))
        last = [[robot[np.isfinite(robot)][-1] for robot in one] for one in distance]
        np.testing.assert_allclose(sums.final, last, rtol=0, atol=1e-12)


def test_one_robot_has_arrived_where_many_have():
    """About the end of a path, where the compiled form says at once who is far away."""
    rng = np.random.default_rng(4)
    for length in (2.0, 60.0):
        x, y, heading = rng.uniform(-0.6, 0.6, (2, 5000)), rng.uniform(-0.6, 0.6, (2, 5000)), rng.uniform(-4, 4, 5000)
        there = at_end(x[0], y[0], x[1], y[1], heading, length)
        alone = [at_end_compiled(*place, length) for place in zip(x[0], y[0], x[1], y[1], heading, strict=True)]
        np.testing.assert_array_equal(alone, there)
        assert 40 < there.sum() < 4900
