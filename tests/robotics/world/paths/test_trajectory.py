"""Trajectories: the timing laws against closed forms, and feasibility of the moving target."""

from math import cos, pi, sin, sqrt

import numpy as np
import pytest
from scipy.integrate import quad

from robotics.world.paths.path import Circle, Line, PathError, Quintic, Sine, compile_path
from robotics.world.paths.trajectory import Timing, compile_trajectory


def trajectory(*pairs):
    return compile_trajectory(tuple(compile_path(shape) for shape, _ in pairs), tuple(t for _, t in pairs))


SINE = Sine(x_end=8.0)
CURVE = Quintic(start=(0.0, -1.0), end=(5.0, 1.0))


@pytest.mark.parametrize("start", [0.0, 0.7])
def test_x_rate_law_is_x_proportional_to_time(start):
    path = trajectory((SINE, Timing(x_rate=0.3, start=start)))
    first = float(path.paths[0].at(start).x)
    assert path.ends[0] == pytest.approx((8 - first) / 0.3, abs=1e-9)
    times = np.linspace(0, path.ends[0] * (1 - 1e-9), 777)
    target = path.sampled(times)
    x = first + 0.3 * times
    np.testing.assert_allclose(target.x[:, 0], x, rtol=0, atol=1e-7)
    np.testing.assert_allclose(target.y[:, 0], np.sin(x), rtol=0, atol=1e-7)
    np.testing.assert_allclose(target.heading[:, 0], np.arctan(np.cos(x)), rtol=0, atol=1e-6)
    np.testing.assert_allclose(target.v[:, 0], 0.3 * np.sqrt(1 + np.cos(x) ** 2), rtol=0, atol=1e-6)
    # ω = d/dt atan(cos x) = −sin x · 0.3 / (1 + cos² x)
    np.testing.assert_allclose(target.w[:, 0], -0.3 * np.sin(x) / (1 + np.cos(x) ** 2), rtol=0, atol=2e-5)
    s = start + quad(lambda c: sqrt(1 + cos(c) ** 2), first, x[500], epsabs=1e-11)[0]
    assert target.s[500, 0] == pytest.approx(s, abs=1e-7)


def test_x_rate_law_runs_leftwards_on_a_path_that_does():
    left = trajectory((Sine(x_start=4.0, x_end=-1.0), Timing(x_rate=0.25)))
    for t in (0.0, 3.3, 19.0):
        target = left.at(t)
        assert (target.x[0], target.y[0]) == pytest.approx((4 - 0.25 * t, sin(4 - 0.25 * t)), abs=1e-7)
        assert target.v[0] > 0
    assert left.ends[0] == pytest.approx(20.0)


def test_speed_and_duration_are_constant_speeds():
    circle = Circle(radius=1.5, start_angle=pi / 2, direction="clockwise")
    both = trajectory((circle, Timing(speed=0.3, start=0.6)), (circle, Timing(duration=20.0)))
    length = 2 * pi * 1.5
    assert both.ends == pytest.approx([(length - 0.6) / 0.3, 20.0], abs=1e-9)
    for t in (0.0, 1.234, 10.0):
        target = both.at(t)
        s = np.array([0.6 + 0.3 * t, length / 20 * t])
        v = np.array([0.3, length / 20])
        np.testing.assert_allclose(target.s, s, rtol=0, atol=1e-9)
        np.testing.assert_allclose(target.v, v, rtol=1e-9)
        np.testing.assert_allclose(target.w, -v / 1.5, rtol=1e-9)
        np.testing.assert_allclose(target.x, 1.5 * np.sin(s / 1.5), rtol=0, atol=1e-9)
        np.testing.assert_allclose(target.y, 1.5 * np.cos(s / 1.5), rtol=0, atol=1e-9)
        np.testing.assert_allclose(target.heading, -s / 1.5, rtol=0, atol=1e-9)


@pytest.mark.parametrize(
    "timing", [Timing(speed=0.2), Timing(duration=12.0), Timing(x_rate=0.4)], ids=["speed", "duration", "x_rate"]
)
def test_after_its_end_a_reference_rests_and_before_its_start_it_waits(timing):
    path = trajectory((CURVE, timing))
    end = float(path.ends[0])
    for t in (end, end + 1e-9, end + 100.0, 1e9):
        target = path.at(t)
        assert (target.x[0], target.y[0]) == pytest.approx((5.0, 1.0), abs=1e-9)
        assert (target.v[0], target.w[0]) == (0, 0)
        assert target.s[0] == path.paths[0].length
        assert target.heading[0] == pytest.approx(0, abs=1e-9)
    just_before = path.at(end - 1e-6)
    assert just_before.v[0] > 0.1
    assert just_before.x[0] == pytest.approx(5, abs=1e-5)
    assert path.at(-5.0).x[0] == path.at(0.0).x[0] == pytest.approx(0)


@pytest.mark.parametrize(
    "timing", [Timing(speed=0.2), Timing(duration=12.0), Timing(x_rate=0.4)], ids=["speed", "duration", "x_rate"]
)
def test_velocities_are_the_derivatives_of_the_posture(timing):
    path = trajectory((CURVE, timing))
    h, times = 1e-4, np.linspace(0.1, path.ends[0] - 0.1, 101)
    here, ahead, behind = (path.sampled(times + d) for d in (0, h, -h))
    speed = ((ahead.x - behind.x) * np.cos(here.heading) + (ahead.y - behind.y) * np.sin(here.heading)) / (2 * h)
    np.testing.assert_allclose(speed, here.v, rtol=0, atol=1e-5)
    np.testing.assert_allclose((ahead.heading - behind.heading) / (2 * h), here.w, rtol=0, atol=1e-3)
    np.testing.assert_allclose((ahead.s - behind.s) / (2 * h), here.v, rtol=0, atol=1e-5)


def test_sampled_is_at_to_the_last_bit_and_robots_do_not_see_each_other():
    pairs = [(SINE, Timing(x_rate=0.3)), (CURVE, Timing(duration=9.0)), (Circle(), Timing(speed=0.1))]
    together = trajectory(*pairs)
    times = np.linspace(-1, 70, 143)
    rows = together.sampled(times)
    assert all(f.shape == (143, 3) for f in rows)
    for k, t in enumerate(times):
        one = together.at(t)
        assert all((f[k] == g).all() for f, g in zip(rows, one, strict=True))
    for i, pair in enumerate(pairs):
        alone = trajectory(pair).sampled(times)
        assert all((f[:, i] == g[:, 0]).all() for f, g in zip(rows, alone, strict=True))


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: Timing(), "give exactly one of speed, duration and x_rate, got none"),
        (lambda: Timing(speed=0.3, duration=5.0), "got speed, duration"),
        (lambda: Timing(speed=0.0), "speed must be a finite number in m/s, > 0; got 0.0"),
        (lambda: Timing(speed=-0.1), "speed must be"),
        (lambda: Timing(duration=float("nan")), "duration must be"),
        (lambda: Timing(x_rate=float("inf")), "x_rate must be"),
        (lambda: Timing(speed=0.1, start=-1.0), "start must be a finite number in m, >= 0; got -1.0"),
        (lambda: Timing(speed="fast"), "speed must be"),  # type: ignore[arg-type]
        (
            lambda: trajectory((Line(start=(0.0, 0.0), end=(2.0, 0.0)), Timing(speed=0.1, start=2.5))),
            "start 2.5 m lies at or beyond the path's end, 2 m",
        ),
        (lambda: trajectory((Circle(), Timing(x_rate=0.3))), "x_rate needs a path on which x always grows"),
        (lambda: trajectory((Line(start=(0.0, 0.0), end=(0.0, 2.0)), Timing(x_rate=0.3))), "x_rate needs a path"),
    ],
)
def test_impossible_timings_are_refused(make, message):
    with pytest.raises(PathError) as caught:
        make()
    assert message in str(caught.value)
