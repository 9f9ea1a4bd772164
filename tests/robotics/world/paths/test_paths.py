"""PathTable in one table: each as by itself, and nearest points against a dense search and scipy's minimiser."""

from dataclasses import replace
from math import pi
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import minimize_scalar

from robotics.world.paths.joined import join_paths
from robotics.world.paths.path import Circle, Line, Quintic, Sine, Waypoints, compile_path
from robotics.world.paths.trajectory import Timing, compile_trajectory

LOOP = Waypoints(points=((0.0, 0.0), (2.0, 1.0), (2.0, -1.0), (0.0, 1.0), (3.0, 3.0)))  # crosses itself
CLOSED = Waypoints(points=((0.0, 0.0), (1.0, 0.2), (1.0, 1.0), (0.0, 1.0), (0.0, 0.0)))
SHAPES: dict[str, Any] = {
    "line": Line(start=(1.0, -1.0), end=(4.0, 2.0)),
    "circle": Circle(center=(1.0, 2.0), radius=0.7, start_angle=0.3),
    "clockwise": Circle(radius=1.3, direction="clockwise", turns=0.6),
    "sine": Sine(amplitude=0.8, wavenumber=1.4, lead_in=0.5),
    "quintic": Quintic(start=(0.0, 0.0), end=(5.0, 2.0)),
    "loop": LOOP,
    "closed": CLOSED,
}
COMPILED = {name: compile_path(shape) for name, shape in SHAPES.items()}
JOINED = join_paths(list(COMPILED.values()))
COUNT = len(SHAPES)


def nearest(path, x, y, around, reach):
    """Of one path and one point."""
    row = [np.array([value], dtype=float) for value in (x, y, around, reach)]
    return float(join_paths([path]).nearest(*row)[0])


def distance(path, s, x, y):
    point = path.at(s)
    return np.hypot(point.x - x, point.y - y)


def test_every_path_is_as_by_itself():
    for batch in ((), (4,), (3, 2)):
        s = np.random.default_rng(1).uniform(-0.5, 1.5, (*batch, COUNT)) * JOINED.lengths
        together = JOINED.at(s)
        for i, path in enumerate(COMPILED.values()):
            alone = path.at(s[..., i])
            for ours, theirs in zip(together, alone, strict=True):
                assert ours.shape == s.shape
                np.testing.assert_allclose(ours[..., i], theirs, rtol=0, atol=1e-12)


def test_beyond_its_ends_a_path_stays_there():
    for s, at in ((-3.0, 0.0), (100.0, 1.0)):
        beyond, there = JOINED.at(np.full(COUNT, s)), JOINED.at(at * JOINED.lengths)
        for ours, theirs in zip(beyond, there, strict=True):
            np.testing.assert_array_equal(ours, theirs)


def brute_force(path, x, y, low, high):
    """The smallest distance between two abscissae: a sample every 0.5 mm, then scipy's minimiser around the best."""
    s = np.linspace(low, high, max(2, int((high - low) / 5e-4)))
    d = distance(path, s, x, y)
    k = int(np.argmin(d))
    bounds = (s[max(k - 1, 0)], s[min(k + 1, len(s) - 1)])
    found = minimize_scalar(lambda q: distance(path, q, x, y), bounds=bounds, method="bounded", options={"xatol": 1e-9})
    best = min([(float(found.fun), float(found.x)), *((float(distance(path, q, x, y)), q) for q in bounds)])
    # A rival elsewhere that is about as near makes the abscissa, not the distance, a matter of rounding.
    rivals = d[np.abs(s - best[1]) > 0.1]
    return best, bool(len(rivals) and rivals.min() < best[0] + 2e-3)


@given(
    name=st.sampled_from(list(SHAPES)),
    place=st.floats(0, 1),
    off=st.tuples(st.floats(-0.6, 0.6), st.floats(-0.6, 0.6)),
    around=st.floats(0, 1),
    share=st.sampled_from([0.02, 0.05, 0.25, 1.0]),
)
@settings(max_examples=300)
def test_nearest_points_are_those_of_a_dense_search_within_the_window(name, place, off, around, share):
    path = COMPILED[name]
    here = path.at(place * path.length)
    x, y = float(here.x) + off[0], float(here.y) + off[1]
    low, high = (np.clip((around + sign * share) * path.length, 0, path.length) for sign in (-1, 1))
    found = nearest(path, x, y, around * path.length, share * path.length)
    assert low - 1e-12 <= found <= high + 1e-12
    (least, where), ambiguous = brute_force(path, x, y, low, high)
    ours = distance(path, found, x, y)
    assert ours <= least + (5e-3 if ambiguous else 1e-8)  # 5 mm: the nodes, by which branches are told apart
    point = path.at(found)
    across = np.cos(point.heading) * (y - point.y) - np.sin(point.heading) * (x - point.x)
    if not ambiguous and abs(1 - point.curvature * across) > 0.05:  # not near the center of curvature
        assert found == pytest.approx(where, abs=2e-5)


@given(
    name=st.sampled_from(list(SHAPES)),
    place=st.floats(0.01, 0.99),
    off=st.floats(-0.1, 0.1),
    stale=st.floats(-0.04, 0.04),
)
@settings(max_examples=200)
def test_the_foot_of_a_normal_is_found_again(name, place, off, stale):
    """Closed form: a point beside the path by less than its radius of curvature has its foot where it came from."""
    path = COMPILED[name]
    s = place * path.length
    around = np.clip(place + stale, 0, 1) * path.length
    here = path.at(s)
    nodes = path.table[3][np.abs(np.linspace(0, path.length, path.table.shape[1]) - s) < 0.3]
    off = np.clip(off, -0.3 / np.abs(nodes).max(initial=1.0), 0.3 / np.abs(nodes).max(initial=1.0))
    x, y = here.x - off * np.sin(here.heading), here.y + off * np.cos(here.heading)
    found = nearest(path, x, y, around, 0.05 * path.length)
    if name == "loop" and distance(path, found, x, y) < abs(off) - 1e-9:
        return  # another branch lies nearer
    assert found == pytest.approx(s, abs=2e-6)


def test_a_crossing_is_passed_on_the_branch_one_is_on():
    """Driven along with a narrow window, the place goes on through the crossing; at large it may jump."""
    path = COMPILED["loop"]
    s = 0.0
    for place in np.arange(0.0, path.length, 0.02):
        here = path.at(place)
        s = nearest(path, here.x, here.y, s, 0.05 * path.length)
        assert s == pytest.approx(place, abs=1e-7)


def test_the_seam_of_a_closed_path_keeps_start_and_end_apart():
    for name in ("circle", "closed"):
        path = COMPILED[name]
        for s, around in ((0.0, 0.0), (path.length, path.length), (0.01, 0.0), (path.length - 0.01, path.length)):
            here = path.at(s)
            assert nearest(path, here.x, here.y, around, 0.25 * path.length) == pytest.approx(s, abs=1e-8)
        beside = path.at(0.05)
        end = nearest(path, beside.x, beside.y, path.length, 0.05 * path.length)
        assert end == pytest.approx(path.length, abs=1e-9)  # the nearest within the window is its end


def test_beyond_the_ends_of_the_window_its_end_is_nearest():
    line = COMPILED["line"]
    for place, around, reach, expected in (
        (2.0, 1.0, 0.3, 1.3),
        (0.2, 1.0, 0.3, 0.7),
        (4.2426, 4.0, 1.0, line.length),
        (2.0, 2.0, 0.0, 2.0),  # a window of no width
        (2.0, 1.0, 1e-4, 1.0 + 1e-4),  # between two nodes
        (1.0, 9.0, 0.5, line.length),  # a window beyond the end
        (1.0, -9.0, 0.5, 0.0),
    ):
        p = line.at(place)
        assert nearest(line, p.x, p.y, around, reach) == pytest.approx(expected, abs=1e-9 + abs(place == 4.2426) * 1e-4)
    for x, y, expected in ((-9.0, -9.0, 0.0), (99.0, 99.0, line.length)):
        assert nearest(line, x, y, line.length / 2, line.length) == expected


def test_a_circle_seen_from_its_center_gives_a_point_of_the_window():
    circle = COMPILED["circle"]
    found = nearest(circle, 1.0, 2.0, 1.0, 0.3)
    assert 0.7 <= found <= 1.3
    for angle in np.linspace(-1.2, 1.2, 9):  # closed form: the angle tells the abscissa
        x, y = 1 + 0.02 * np.cos(0.3 + 2 + angle), 2 + 0.02 * np.sin(0.3 + 2 + angle)
        assert nearest(circle, x, y, 1.4, 1.4) == pytest.approx(0.7 * (2 + angle), abs=1e-7)


def test_all_robots_of_all_runs_are_looked_up_as_one_by_one():
    rng = np.random.default_rng(3)
    near = JOINED.at(rng.random((5, COUNT)) * JOINED.lengths)
    x, y = near.x + rng.normal(0, 0.2, near.x.shape), near.y + rng.normal(0, 0.2, near.y.shape)
    around, reach = rng.random((5, COUNT)) * JOINED.lengths, 0.2 * JOINED.lengths
    together = JOINED.nearest(x, y, around, reach)
    assert together.shape == (5, COUNT)
    for r in range(5):
        for i, path in enumerate(COMPILED.values()):
            assert together[r, i] == nearest(path, x[r, i], y[r, i], around[r, i], reach[i])
    turned = JOINED.nearest(np.asfortranarray(x), np.asfortranarray(y), np.asfortranarray(around), reach)
    np.testing.assert_array_equal(turned, together)


# Each robot at a time of its own --------------------------------------------------------------------------------


def team(timing):
    shapes = ("line", "circle", "quintic")
    return compile_trajectory(tuple(COMPILED[name] for name in shapes), (timing,) * 3)


@pytest.mark.parametrize("timing", [Timing(speed=0.2), Timing(duration=12.0), Timing(duration=12.0, ramp=2.0)])
def test_each_at_its_own_time_is_as_all_at_that_time(timing):
    trajectory = team(timing)
    times = np.random.default_rng(0).uniform(-1, 30, (7, 3))
    each = trajectory.each_at(times)
    for n in range(7):
        for i in range(3):
            alone = trajectory.at(times[n, i])
            assert [f[n, i] for f in each] == [f[i] for f in alone]
    for other in (np.asfortranarray(times), times[:, ::-1][:, ::-1]):
        assert all((a == b).all() for a, b in zip(each, trajectory.each_at(other), strict=True))
    whole = trajectory.each_at(np.array([[1, 2, 3]]))
    assert [f[0, 1] for f in whole] == [f[1] for f in trajectory.at(2.0)]


# Ramps ----------------------------------------------------------------------------------------------------------


def trapezoid(t, length, end, ramp):
    """Abscissa and speed of a trapezoidal profile: up to length / (end − ramp) in ``ramp``, and down again."""
    top = length / (end - ramp)
    t = np.clip(t, 0, end)
    up, down = np.minimum(t, ramp), np.maximum(t - (end - ramp), 0)
    return top * up**2 / (2 * ramp) + top * (t - up) - top * down**2 / (2 * ramp), np.where(
        (t <= 0) | (t >= end), 0.0, top * np.minimum(1, np.minimum(t, end - t) / ramp)
    )


@pytest.mark.parametrize("ramp", [0.5, 2.0, 6.0])
@pytest.mark.parametrize("begin", [0.0, 0.4])
def test_ramps_make_a_trapezoid_of_the_speed(ramp, begin):
    trajectory = team(Timing(duration=12.0, ramp=ramp, start=begin))
    times = np.linspace(-1, 14, 1501)
    reference = trajectory.sampled(times)
    for i, path in enumerate(trajectory.paths):
        s, v = trapezoid(times, path.length - begin, 12.0, ramp)
        np.testing.assert_allclose(reference.s[:, i], begin + s, rtol=0, atol=5e-6)
        np.testing.assert_allclose(reference.v[:, i], v, rtol=0, atol=2e-3 * v.max())
        point = path.at(reference.s[:, i])
        np.testing.assert_allclose(reference.w[:, i], reference.v[:, i] * point.curvature, rtol=0, atol=1e-12)
    assert trajectory.ends.tolist() == [12.0] * 3
    end = trajectory.at(12.0)
    assert (end.v == 0).all()
    assert end.s.tolist() == [path.length for path in trajectory.paths]
    assert (trajectory.at(0.0).v == 0).all()
    assert trajectory.at(12.0 - 1e-3).v.max() < 1e-3 * reference.v.max() / min(ramp, 1) * 1.1


def test_a_given_speed_is_reached_and_held():
    trajectory = team(Timing(speed=0.25, ramp=1.0))
    for i, path in enumerate(trajectory.paths):
        end = path.length / 0.25 + 1.0  # each ramp costs half of its time
        assert trajectory.ends[i] == pytest.approx(end, abs=1e-12)
        times = np.linspace(0, end, 400)
        s, _ = trapezoid(times, path.length, end, 1.0)
        found = trajectory.sampled(times)
        np.testing.assert_allclose(found.s[:, i], s, rtol=0, atol=5e-6)
        assert found.v[:, i].max() == pytest.approx(0.25, rel=1e-12)


def test_a_path_too_short_for_the_speed_is_driven_in_a_triangle():
    short = compile_path(replace(SHAPES["line"], end=(1.3, -0.6)))
    assert short.length == pytest.approx(0.5)
    trajectory = compile_trajectory((short,), (Timing(speed=0.5, ramp=4.0),))
    assert trajectory.ends[0] == pytest.approx(2.0)
    s, _ = trapezoid(np.linspace(0, 2, 101), 0.5, 2.0, 1.0)
    np.testing.assert_allclose(trajectory.sampled(np.linspace(0, 2, 101)).s[:, 0], s, rtol=0, atol=2e-6)
    assert trajectory.at(1.0).v[0] == pytest.approx(0.5, rel=1e-3)


def test_without_a_ramp_the_speed_is_even():
    reference = team(Timing(duration=10.0)).sampled(np.linspace(0, 9.99, 50))
    np.testing.assert_allclose(reference.v, np.broadcast_to(reference.v[0], reference.v.shape), rtol=1e-12)
    assert reference.v[0, 1] == pytest.approx(2 * pi * 0.7 / 10)
