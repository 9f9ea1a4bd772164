"""Paths against closed forms, scipy's quadrature and elliptic integrals, and the property of arc length itself."""

from itertools import pairwise
from math import cos, hypot, nan, pi, sin, sqrt
from typing import Any

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from scipy.integrate import quad
from scipy.interpolate import CubicSpline
from scipy.special import ellipe

from robotics.world.paths.path import (
    SHAPES,
    Circle,
    Eight,
    Line,
    PathError,
    Quintic,
    Sine,
    Waypoints,
    compile_path,
)
from tests.randomcases import cases

SINE = Sine(amplitude=1.0, wavenumber=1.0, x_end=8.0)
COSINE = Sine(amplitude=0.902258, wavenumber=4 * pi / 7, phase=pi / 2, offset=3 - 0.902258, x_end=7.0)
CURVE = Quintic(start=(0.0, -1.0), end=(5.0, 1.0))
SLOPED = Quintic(start=(0.0, 2.0), end=(6.0, -1.5), start_slope=0.3, end_slope=-0.5)
LOOP = Quintic(start=(0.0, 0.0), end=(1.0, 0.0), start_tangent=(3.0, 3.0), end_tangent=(3.0, -3.0))
OPEN = Waypoints(points=((0.0, 0.0), (1.0, 0.5), (2.0, -0.5), (3.0, 1.0), (2.5, 2.0)))
CLOSED = Waypoints(points=((0.0, 0.0), (2.0, 0.0), (2.0, 1.5), (0.0, 1.5), (0.0, 0.0)))
EVERY: dict[str, Any] = {
    "sine": SINE,
    "cosine": COSINE,
    "circle": Circle(center=(1.0, -2.0), radius=0.5, start_angle=1.0, turns=1.25),
    "eight": Eight(center=(0.5, 1.0), width=3.0, angle=0.7, turns=1.5),
    "clockwise": Circle(radius=2.0, start_angle=pi / 2, direction="clockwise", turns=0.4),
    "line": Line(start=(1.0, 2.0), end=(-3.0, 5.0)),
    "quintic": CURVE,
    "sloped": SLOPED,
    "loop": LOOP,
    "waypoints": OPEN,
    "closed": CLOSED,
}
every = pytest.mark.parametrize("shape", EVERY.values(), ids=EVERY)


# Lengths --------------------------------------------------------------------------------------------------------


def test_sine_length_is_the_elliptic_integral():
    """∫ √(1 + a²k² cos² kx) dx over a quarter wave is √(1 + a²k²)/k · E(a²k²/(1 + a²k²))."""
    for a, k in ((1.0, 1.0), (0.5, 1.5), (2.0, 3.0)):
        bend = (a * k) ** 2
        quarter = sqrt(1 + bend) / k * ellipe(bend / (1 + bend))
        path = compile_path(Sine(amplitude=a, wavenumber=k, x_end=2 * pi / k))
        assert path.length == pytest.approx(4 * quarter, abs=1e-9)
        backwards = compile_path(Sine(amplitude=-a, wavenumber=k, x_start=2 * pi / k, x_end=0.0))
        assert backwards.length == pytest.approx(4 * quarter, abs=1e-9)


def test_published_lengths():
    """[F]: 10.41 m for A = 0.902258; [G]: 7.24, 5.04 and 8.39 m for the three quintics."""
    assert compile_path(COSINE).length == pytest.approx(10.410, abs=5e-4)
    for start, end, length in (
        ((0.0, 2.0), (6.0, -1.5), 7.24),
        ((0.0, 1.0), (5.0, 0.5), 5.04),
        ((0.0, -2.0), (7.0, 2.0), 8.39),
    ):
        assert compile_path(Quintic(start=start, end=end)).length == pytest.approx(length, abs=5e-3)


def test_circle_and_line_lengths_are_their_closed_forms():
    assert compile_path(EVERY["circle"]).length == pytest.approx(2 * pi * 0.5 * 1.25, abs=1e-12)
    assert compile_path(EVERY["clockwise"]).length == pytest.approx(2 * pi * 2.0 * 0.4, abs=1e-12)
    assert compile_path(EVERY["line"]).length == pytest.approx(5.0, abs=1e-12)


def slope_of_y(shape):
    """y(x) and y'(x) of a quintic with slopes: the polynomial through its six conditions, by linear equations."""
    (x0, y0), (x1, y1) = shape.start, shape.end
    rows, right = [], []
    for x, y, dy in ((x0, y0, shape.start_slope), (x1, y1, shape.end_slope)):
        rows += [[x**i for i in range(6)], [i * x ** max(i - 1, 0) for i in range(6)]]
        rows += [[i * (i - 1) * x ** max(i - 2, 0) for i in range(6)]]
        right += [y, dy, 0.0]
    return np.polynomial.Polynomial(np.linalg.solve(np.array(rows, dtype=float), right))


@pytest.mark.parametrize("shape", [CURVE, SLOPED], ids=["flat", "sloped"])
def test_quintic_with_slopes_is_the_fifth_order_polynomial_of_x(shape):
    y = slope_of_y(shape)
    path = compile_path(shape)
    length, _ = quad(lambda x: hypot(1, y.deriv()(x)), shape.start[0], shape.end[0], epsabs=1e-10)
    assert path.length == pytest.approx(length, abs=1e-8)
    point = path.at(np.linspace(0, path.length, 1001))
    np.testing.assert_allclose(point.y, y(point.x), rtol=0, atol=1e-9)
    np.testing.assert_allclose(point.heading, np.arctan(y.deriv()(point.x)), rtol=0, atol=1e-8)
    curvature = y.deriv(2)(point.x) / (1 + y.deriv()(point.x) ** 2) ** 1.5  # (5.6)
    np.testing.assert_allclose(point.curvature, curvature, rtol=0, atol=2e-5)


def test_waypoints_are_the_natural_spline_over_the_chords():
    points = np.array(OPEN.points)
    chord = np.concatenate([[0], np.cumsum([hypot(*d) for d in np.diff(points, axis=0)])])
    x, y = (CubicSpline(chord, points[:, i], bc_type="natural") for i in (0, 1))
    length = sum(quad(lambda c: hypot(x(c, 1), y(c, 1)), a, b, epsabs=1e-11)[0] for a, b in pairwise(chord))
    path = compile_path(OPEN)
    assert path.length == pytest.approx(length, abs=1e-6)
    place = path.abscissa(chord / chord[-1])
    np.testing.assert_allclose(path.at(place).x, points[:, 0], rtol=0, atol=1e-5)
    np.testing.assert_allclose(path.at(place).y, points[:, 1], rtol=0, atol=1e-5)
    assert path.at(np.array([0.0, path.length])).curvature == pytest.approx([0, 0], abs=1e-9)  # natural ends


def test_closed_waypoints_close_smoothly():
    path = compile_path(CLOSED)
    start, end = path.at(0.0), path.at(path.length)
    assert np.hypot(end.x - start.x, end.y - start.y) < 1e-12
    assert end.heading - start.heading == pytest.approx(2 * pi, abs=1e-9)
    assert end.curvature == pytest.approx(float(start.curvature), abs=1e-9)
    two = compile_path(Waypoints(points=((0.0, 0.0), (3.0, 4.0))))
    assert two.length == pytest.approx(5.0, abs=1e-12)


# Points ---------------------------------------------------------------------------------------------------------


def test_circle_points_are_the_closed_form():
    for shape, sign in ((EVERY["circle"], 1), (EVERY["clockwise"], -1)):
        path = compile_path(shape)
        s = np.linspace(0, path.length, 777)
        angle = shape.start_angle + sign * s / shape.radius
        point = path.at(s)
        np.testing.assert_allclose(point.x, shape.center[0] + shape.radius * np.cos(angle), rtol=0, atol=1e-10)
        np.testing.assert_allclose(point.y, shape.center[1] + shape.radius * np.sin(angle), rtol=0, atol=1e-10)
        np.testing.assert_allclose(np.sin(point.heading - angle), sign, rtol=0, atol=1e-12)
        np.testing.assert_allclose(point.curvature, sign / shape.radius, rtol=1e-12)
        assert np.ptp(point.heading) == pytest.approx(2 * pi * shape.turns, abs=1e-9)  # continuous, not wrapped


def test_line_points_are_the_closed_form():
    point = compile_path(EVERY["line"]).at(np.array([0.0, 2.5, 5.0]))
    np.testing.assert_allclose(point.x, [1, -1, -3], atol=1e-14)
    np.testing.assert_allclose(point.y, [2, 3.5, 5], atol=1e-14)
    np.testing.assert_allclose(point.heading, np.arctan2(3, -4), rtol=1e-15)
    assert (point.curvature == 0).all()


def test_sine_heading_and_curvature_are_analytic():
    path = compile_path(SINE)
    point = path.at(np.linspace(0, path.length, 999))
    np.testing.assert_allclose(point.y, np.sin(point.x), rtol=0, atol=1e-9)
    np.testing.assert_allclose(point.heading, np.arctan(np.cos(point.x)), rtol=0, atol=1e-8)
    np.testing.assert_allclose(point.curvature, -np.sin(point.x) / (1 + np.cos(point.x) ** 2) ** 1.5, rtol=0, atol=2e-5)
    # Where the abscissa says, by an independent integral
    for s, x in zip(np.linspace(0, path.length, 9), point.x[:: 998 // 8], strict=False):
        at = float(path.at(s).x)
        assert quad(lambda c: sqrt(1 + cos(c) ** 2), 0, at, epsabs=1e-11)[0] == pytest.approx(s, abs=1e-8), x


@every
def test_shape_derivatives_are_those_of_its_curve(shape):
    u, h = np.linspace(0.05, 0.95, 19), 1e-5
    position, slope, bend = shape.curve(u)
    np.testing.assert_allclose(
        (shape.curve(u + h)[0] - shape.curve(u - h)[0]) / (2 * h), slope, rtol=1e-6, atol=1e-6 * np.abs(slope).max()
    )
    scale = max(1.0, np.abs(bend).max())
    np.testing.assert_allclose(
        (shape.curve(u + h)[1] - shape.curve(u - h)[1]) / (2 * h), bend, rtol=1e-4, atol=1e-4 * scale
    )
    assert position.shape == slope.shape == bend.shape == (2, 19)


def check_arc_length(path, tolerance):
    """|dp/ds| = 1 and its direction is the heading; dψ/ds is the curvature."""
    h = path.spacing / 4
    s = np.linspace(2 * h, path.length - 2 * h, 301)
    ahead, behind, here = path.at(s + h), path.at(s - h), path.at(s)
    dx, dy = (ahead.x - behind.x) / (2 * h), (ahead.y - behind.y) / (2 * h)
    np.testing.assert_allclose(np.hypot(dx, dy), 1, rtol=0, atol=tolerance)
    np.testing.assert_allclose(dx * np.sin(here.heading) - dy * np.cos(here.heading), 0, atol=tolerance)
    assert (dx * np.cos(here.heading) + dy * np.sin(here.heading) > 0).all()
    turn = (ahead.heading - behind.heading) / (2 * h)
    step = np.abs(np.diff(path.table[3])).max()  # of the curvature, from node to node
    np.testing.assert_allclose(turn, here.curvature, rtol=0, atol=1e-3 + step)


@every
def test_abscissa_is_arc_length_and_heading_is_the_tangents(shape):
    check_arc_length(compile_path(shape), 1e-4)


coordinate = st.floats(-5, 5)
tangent = st.tuples(st.floats(0.5, 6), st.floats(-pi, pi)).map(lambda t: (t[0] * cos(t[1]), t[0] * sin(t[1])))


@given(st.tuples(coordinate, coordinate), st.tuples(coordinate, coordinate), tangent, tangent)
@settings(max_examples=cases(40))
def test_random_quintics_are_parametrised_by_their_arc_length(start, end, t0, t1):
    assume(hypot(end[0] - start[0], end[1] - start[1]) > 0.5)
    shape = Quintic(start=start, end=end, start_tangent=t0, end_tangent=t1)
    u = np.linspace(0, 1, 2001)
    position, slope, bend = shape.curve(u)
    speed = np.hypot(*slope)
    curvature = np.abs(slope[0] * bend[1] - slope[1] * bend[0]) / speed**3
    assume(speed.min() > 0.1 and curvature.max() < 20)  # no near-cusps: there the table is coarse
    path = compile_path(shape)
    # In pieces: over the whole at once, quad overlooks a sharp corner.
    pieces = pairwise(np.linspace(0, 1, 41))
    exact = sum(quad(lambda q: float(np.hypot(*shape.curve(np.array(q))[1])), a, b, epsabs=1e-10)[0] for a, b in pieces)
    assert path.length == pytest.approx(exact, abs=1e-6)
    check_arc_length(path, 2e-3)
    ends = path.at(np.array([0.0, path.length]))
    np.testing.assert_allclose(ends.x, [start[0], end[0]], rtol=0, atol=1e-9)
    np.testing.assert_allclose(ends.y, [start[1], end[1]], rtol=0, atol=1e-9)
    np.testing.assert_allclose(np.cos(ends.heading - np.arctan2([t0[1], t1[1]], [t0[0], t1[0]])), 1, atol=1e-9)
    assert ends.curvature == pytest.approx([0, 0], abs=1e-6)  # p'' = 0 at both ends
    # A point of the table lies on the curve, but for what a line between two nodes of u(s) leaves:
    # h²/8 (ds/du)' / (ds/du)²
    rate = np.abs((slope * bend).sum(axis=0) / speed) / speed**2
    left = path.spacing**2 / 8 * rate.max()
    np.testing.assert_allclose(path.at(path.abscissa(u)).x, position[0], rtol=0, atol=1.5 * left + 1e-6)


@every
def test_batches_keep_their_shape_and_each_point_its_bits(shape):
    path = compile_path(shape)
    s = np.linspace(-1.0, path.length + 1.0, 24).reshape(2, 3, 4)
    whole = path.at(s)
    assert all(field.shape == (2, 3, 4) for field in whole)
    for index in np.ndindex(s.shape):
        one = path.at(s[index])
        assert all(f.shape == () for f in one)
        assert [float(f) for f in one] == [f[index] for f in whole]
    assert path.at(np.empty((0,))).x.shape == (0,)


@every
def test_beyond_its_ends_a_path_stays_there(shape):
    path = compile_path(shape)
    for outside, end in ((-3.0, 0.0), (path.length + 3.0, path.length)):
        assert [float(f) for f in path.at(outside)] == [float(f) for f in path.at(end)]
    first, last = shape.curve(np.array([0.0, 1.0]))[0].T
    assert (path.at(0.0).x, path.at(0.0).y) == pytest.approx(tuple(first), abs=1e-12)
    assert (path.at(path.length).x, path.at(path.length).y) == pytest.approx(tuple(last), abs=1e-9)


def test_a_finer_table_has_the_same_length_and_nearer_points():
    coarse, fine = compile_path(LOOP, spacing=0.02), compile_path(LOOP, spacing=0.001)
    assert coarse.length == fine.length
    assert fine.spacing <= 0.001 < coarse.spacing <= 0.02
    s = np.linspace(0, fine.length, 333)
    assert np.abs(coarse.at(s).x - fine.at(s).x).max() < 1e-5


def test_beyond_a_kilometre_nodes_are_farther_apart_and_points_still_true():
    """A table of nodes 5 mm apart took 0.8 GB to make, for a circle that needs none of them."""
    near = compile_path(Circle(radius=159.0))
    assert near.table.shape[1] == int(np.ceil(near.length / 0.005)) + 1 < 200_001
    for radius, turns in ((1000.0, 1.0), (1.0, 1500.0)):
        path = compile_path(Circle(radius=radius, turns=turns))
        assert path.table.shape == (5, 200_001)
        middles = (np.arange(1000) * 199 + 0.5) * path.spacing
        point, angle = path.at(middles), middles / radius
        error = np.hypot(point.x - radius * np.cos(angle), point.y - radius * np.sin(angle))
        assert error.max() < path.spacing**4 / radius**3 / 384 + 1e-9


# Refusals -------------------------------------------------------------------------------------------------------

REFUSED = [
    (lambda: Line(start=(1.0, 1.0), end=(1.0, 1.0)), "start and end are the same point"),
    (lambda: Line(start=(1.0, nan), end=(2.0, 1.0)), "start must be finite"),
    (lambda: Sine(x_start=2.0, x_end=2.0), "x_end must differ from x_start, got 2.0"),
    (lambda: Sine(amplitude=float("inf")), "amplitude must be a finite number in m"),
    (lambda: Sine(phase=90.0), "phase must be a finite number in rad, >= -6.28319 and <= 6.28319; got 90.0"),
    (lambda: Circle(radius=0.0), "radius must be a finite number in m, > 0; got 0.0"),
    (lambda: Circle(radius=-1.0), "radius must be"),
    (lambda: Circle(turns=0.0), "turns must be"),
    (lambda: Circle(start_angle=180.0), "start_angle must be"),
    (lambda: Circle(direction="left"), "'counter-clockwise' or 'clockwise', got 'left'"),  # type: ignore[arg-type]
    (lambda: Circle(center=(nan, 0.0)), "center must be finite"),
    (lambda: Quintic(start=(0.0, 0.0), end=(0.0, 0.0)), "same point (0.0, 0.0): its length is 0"),
    (lambda: Quintic(start=(1.0, 0.0), end=(1.0, 2.0)), "give start_tangent and end_tangent"),
    (lambda: Quintic(start=(1.0, 0.0), end=(1.0, 2.0), start_tangent=(1.0, 0.0)), "give start_tangent and end"),
    (lambda: Quintic(start=(0.0, 0.0), end=(1.0, 2.0), start_tangent=(0.0, 0.0)), "start_tangent must not be zero"),
    (lambda: Quintic(start=(0.0, 0.0), end=(1.0, 2.0), end_tangent=(nan, 0.0)), "end_tangent must be finite"),
    (lambda: Quintic(start=(0.0, 0.0), end=(1.0, 2.0), start_slope=nan), "start_slope must be a finite number"),
    (lambda: Waypoints(points=((0.0, 0.0),)), "at least two points are needed, got 1"),
    (lambda: Waypoints(points=()), "at least two points"),
    (lambda: Waypoints(points=((0.0, 0.0), (1.0, 0.0), (1.0, 0.0))), "points 2 and 3 are the same"),
    (lambda: Waypoints(points=((0.0, 0.0), (100.0, 0.0), (100.0, 1e-15))), "points 2 and 3 are 1e-15 m apart"),
    (lambda: Waypoints(points=((0.0, 0.0), (1e308, 0.0))), "may be 1e+15 in size at most"),
    (lambda: Waypoints(points=((0.0, 0.0), (1.0, float("inf")))), "points must be finite"),
    # Refused when compiled
    (lambda: compile_path(Waypoints(points=((0.0, 0.0), (1.0, 0.0), (0.0, 0.0)))), "near (1, 0) m (a cusp)"),
    # The turn lies between two nodes of the table
    (lambda: compile_path(Waypoints(points=((0.0, 0.0), (2.0, 0.0), (0.5, 0.0)))), "on the spot near (2, 0) m"),
    (lambda: compile_path(Waypoints(points=((0.0, 0.0), (1.0, 0.0), (0.0, 0.05)))), "near (0.997, 0.00117) m"),
    (lambda: compile_path(Line(start=(0.0, 0.0), end=(1e-12, 0.0))), "a path needs a length > 0"),
]


@pytest.mark.parametrize(("make", "message"), REFUSED, ids=[m for _, m in REFUSED])
def test_undrivable_paths_are_refused(make, message):
    with pytest.raises(PathError) as caught:
        make()
    assert message in str(caught.value)


def test_every_shape_is_reachable_by_name():
    curved = {"sine": Sine, "circle": Circle, "eight": Eight, "quintic": Quintic, "waypoints": Waypoints}
    assert curved | {"line": Line} == SHAPES
