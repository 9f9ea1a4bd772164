"""Worlds: compiled obstacles against closed forms and shapely, and random fields against what they promise."""

from math import cos, hypot, inf, nan, pi, sin

import numpy as np
import pytest
import shapely
from hypothesis import given, settings
from hypothesis import strategies as st
from shapely import affinity

from robotics.plugins.stress.obstaclecourse import GAP, random_field, random_trap
from robotics.world.environment.world import (
    BodyColumns,
    Disc,
    Polygon,
    Wall,
    World,
    WorldError,
    box,
    compile_world,
    compile_worlds,
    outlines,
    regular,
    u_shape,
)
from robotics.world.paths.path import Circle, Line, PathError, Quintic, Waypoints, compile_path
from robotics.world.paths.trajectory import Timing

SQUARE = box(0.4, 0.4)
L_SHAPE = ((0.0, 0.0), (1.0, 0.0), (1.0, 0.3), (0.3, 0.3), (0.3, 1.0), (0.0, 1.0))
STILL = World(
    obstacles=(
        Disc(position=(1.0, 2.0), radius=0.3),
        Polygon(corners=L_SHAPE, position=(-1.0, 0.5), heading=0.7),
        Wall(points=((0.0, 0.0), (2.0, 0.0), (2.0, 3.0)), position=(0.0, -1.0)),
        Polygon(corners=L_SHAPE[::-1]),
    )
)
LANES = [compile_path(Quintic(start=(0.0, y), end=(7.0, y + d))) for y, d in ((1.5, 1.0), (0.0, 0.5), (-1.5, -1.2))]


def shapes(geometry, run=0):
    """What an independent library makes of the outlines: discs as true circles would be, 64 corners."""
    made = []
    for line, body in zip(
        outlines(geometry, run), geometry.bodies[run if len(geometry.counts) > 1 else 0], strict=False
    ):
        solid = BodyColumns(body).closed or len(line) == 65
        made.append(shapely.Polygon(line) if solid else shapely.LineString(line))
    return made


# Compiled -------------------------------------------------------------------------------------------------------


def test_obstacles_stand_where_they_are_said_to():
    disc, polygon, first, second, other = shapes(compile_world(STILL).at(0.0))
    assert disc.symmetric_difference(shapely.Point(1, 2).buffer(0.3, quad_segs=16)).area < 1e-12
    expected = affinity.translate(affinity.rotate(shapely.Polygon(L_SHAPE), 0.7, (0, 0), use_radians=True), -1.0, 0.5)
    assert polygon.symmetric_difference(expected).area < 1e-12
    assert other.symmetric_difference(shapely.Polygon(L_SHAPE)).area < 1e-12
    assert list(first.coords) == [(0, -1), (2, -1)]
    assert list(second.coords) == [(2, -1), (2, 2)]


def test_pieces_know_their_obstacle_and_polygons_run_counter_clockwise():
    geometry = compile_world(STILL).at(0.0)
    assert BodyColumns(geometry.bodies[0].T).owner.tolist() == [0, 1, 2, 2, 3]
    assert BodyColumns(geometry.bodies[0].T).closed.tolist() == [0, 1, 0, 0, 1]
    for shape in shapes(geometry):
        if shape.geom_type == "Polygon":
            assert shape.exterior.is_ccw


def test_the_circle_around_a_body_holds_it():
    geometry = compile_world(STILL).at(0.0)
    for circle, line in zip(geometry.circles[0], outlines(geometry), strict=True):
        away = np.hypot(*(line - circle[:2]).T)
        assert away.max() <= circle[2] * (1 + 1e-15)
        assert away.max() >= 0.999 * circle[2]


def test_nothing_is_copied_where_nothing_moves():
    obstacles = compile_world(STILL)
    assert obstacles.at(0.0) is obstacles.at(7.0) is obstacles.rest


def test_a_disc_on_a_circle_goes_round_and_rests_at_the_end():
    round_ = Disc(radius=0.2, path=Circle(center=(1.0, -1.0), radius=2.0, turns=0.5), timing=Timing(speed=0.4))
    obstacles = compile_world(World(obstacles=(round_,)))
    for t in (0.0, 1.3, 7.0, pi * 2 / 0.4, 100.0):
        angle = min(0.4 * t / 2, pi)
        expected = [1 + 2 * cos(angle), -1 + 2 * sin(angle), 0.2]
        np.testing.assert_allclose(obstacles.at(t).circles[0, 0], expected, atol=1e-9)


@pytest.mark.parametrize("orientation", ["along", "fixed"])
def test_a_moving_polygon_is_carried_along_its_path(orientation):
    """Position and heading count from the point on the path, seen from its tangent or not."""
    box_ = Polygon(
        corners=SQUARE,
        position=(0.5, 0.2),
        heading=0.3,
        path=Circle(radius=3.0),
        timing=Timing(duration=60.0),
        orientation=orientation,
    )
    obstacles = compile_world(World(obstacles=(Disc(position=(9.0, 9.0)), box_, Wall(points=((0.0, 0.0), (1.0, 0.0))))))
    for t in (0.0, 11.0, 42.0):
        angle = 2 * pi * t / 60
        turn = angle + pi / 2 if orientation == "along" else 0.0
        own = affinity.translate(affinity.rotate(shapely.Polygon(SQUARE), 0.3, (0, 0), use_radians=True), 0.5, 0.2)
        carried = affinity.rotate(own, turn, (0, 0), use_radians=True)
        expected = affinity.translate(carried, 3 * cos(angle), 3 * sin(angle))
        still, moving, wall = shapes(obstacles.at(t))
        assert moving.symmetric_difference(expected).area < 1e-8
        assert still.centroid.distance(shapely.Point(9, 9)) < 1e-12
        assert list(wall.coords) == [(0, 0), (1, 0)]


def test_worlds_of_several_runs_are_each_as_by_itself():
    moving = World(
        obstacles=(
            Disc(position=(4.0, 0.0)),
            Polygon(corners=u_shape(0.9, 0.8), path=Line(start=(0.0, 0.0), end=(3.0, 1.0)), timing=Timing(speed=0.1)),
        )
    )
    other = World(
        obstacles=(Wall(points=SQUARE, path=Circle(radius=1.0), timing=Timing(speed=0.3), orientation="fixed"),)
    )
    worlds = [STILL, moving, World(), other, moving]
    together = compile_worlds(worlds)
    assert together.runs == 5
    for t in (0.0, 3.3):
        placed = together.at(t)
        assert placed.counts.tolist() == [5, 2, 0, 3, 2]
        for r, world in enumerate(worlds):
            alone = compile_world(world).at(t)
            for ours, theirs in zip(outlines(placed, r), outlines(alone), strict=True):
                np.testing.assert_array_equal(ours, theirs)
            np.testing.assert_array_equal(placed.circles[r, : alone.counts[0]], alone.circles[0])
            np.testing.assert_array_equal(placed.bodies[r, : alone.counts[0]], alone.bodies[0])


def test_an_empty_world_has_nothing_in_it():
    for obstacles in (compile_world(World()), compile_worlds([World()] * 3)):
        assert obstacles.at(1.0).counts.sum() == 0
        assert outlines(obstacles.at(1.0)) == []


def test_placing_leaves_what_is_at_rest_alone():
    world = World(obstacles=(Disc(path=Line(start=(0.0, 0.0), end=(3.0, 0.0)), timing=Timing(speed=1.0)),))
    obstacles = compile_world(world)
    before = obstacles.at(0.0).circles.copy()
    obstacles.at(2.0)
    np.testing.assert_array_equal(obstacles.at(0.0).circles, before)


def test_a_u_has_the_free_space_that_was_asked_for():
    shape = shapely.Polygon(u_shape(0.9, 0.8, 0.06))
    assert shape.is_valid
    free = shapely.box(-0.4, -0.45, 0.4, 0.45)
    assert not shape.intersects(free.buffer(-1e-9))
    assert shape.area == pytest.approx(2 * 0.06 * 0.86 + 0.06 * 0.9)
    assert not shape.intersects(shapely.LineString([(0, 0), (-9, 0)])), "its mouth opens towards -x"


# What is refused ------------------------------------------------------------------------------------------------

LINE = Line(start=(0.0, 0.0), end=(1.0, 0.0))


@pytest.mark.parametrize(
    ("make", "field", "message"),
    [
        (lambda: Disc(radius=0.0), "radius", r"radius must be a finite number in m, > 0"),
        (lambda: Disc(radius=nan), "radius", "radius must be a finite number"),
        (lambda: Disc(position=(0.0, inf)), "position", r"position must be points \[x, y\] of finite numbers in m"),
        (lambda: Disc(heading=90.0), "heading", "heading must be a finite number in rad"),
        (lambda: Disc(path=LINE), "timing", "timing is missing: a moving obstacle needs both"),
        (lambda: Disc(timing=Timing(speed=1.0)), "path", "path is missing"),
        (lambda: Disc(orientation="round"), "orientation", "must be 'along' or 'fixed', got 'round'"),  # type: ignore[arg-type]
        (lambda: Wall(points=((0.0, 0.0),)), "points", r"points must be at least 2 points \[x, y\] in m, got 1"),
        (lambda: Wall(points=((0.0, 0.0), (0.0, 0.0))), "points", "points 1 and 2 are the same"),
        (lambda: Polygon(corners=((0.0, 0.0), (1.0, 0.0))), "corners", "corners must be at least 3 points"),
        (lambda: Polygon(corners=(*SQUARE, SQUARE[0])), "corners", "corners 5 and 1 are the same"),
        (lambda: Polygon(corners=((0.0, 0.0), (1.0, 1.0), (1.0, 0.0), (0.0, 1.0))), "corners", "sides 1 and 3"),
        (lambda: Polygon(corners=((0.0, 0.0), (2.0, 0.0), (1.0, 0.0))), "corners", "go back over a side"),
        (lambda: Polygon(corners=((0.0, 0.0), (1.0,), (0.0, 1.0))), "corners", r"corners must be points \[x, y\]"),  # type: ignore[arg-type]
    ],
)
def test_what_cannot_be_is_refused(make, field, message):
    with pytest.raises(WorldError, match=message) as caught:
        make()
    assert caught.value.at[-1] == field


def test_a_path_that_cannot_be_driven_names_the_obstacle():
    cusp = Waypoints(points=((0.0, 0.0), (1.0, 0.0), (0.0, 0.0), (1.0, 0.0)))
    world = World(obstacles=(Disc(), Disc(path=cusp, timing=Timing(speed=0.1))))
    with pytest.raises(PathError) as caught:
        compile_world(world)
    assert caught.value.at[:3] == ("obstacles", 1, "path")
    late = World(obstacles=(Disc(path=LINE, timing=Timing(speed=0.1, start=5.0)),))
    with pytest.raises(PathError) as caught:
        compile_world(late)
    assert caught.value.at[:3] == ("obstacles", 0, "timing")


@settings(max_examples=300, derandomize=True, database=None)
@given(st.lists(st.tuples(st.integers(-3, 3), st.integers(-3, 3)), min_size=3, max_size=7, unique=True))
def test_a_polygon_is_taken_exactly_if_it_is_simple(corners):
    corners = tuple((float(x), float(y)) for x, y in corners)
    simple = shapely.Polygon(corners).is_valid and shapely.Polygon(corners).area > 0
    if simple:
        assert Polygon(corners=corners).corners == corners
    else:
        with pytest.raises(WorldError):
            Polygon(corners=corners)


# Random fields --------------------------------------------------------------------------------------------------


def field_of(seed, gap=GAP):
    return random_field(np.random.default_rng([seed, 6]), LANES[:1], gap=gap)


def test_class_a_keeps_its_gaps_and_the_ends_clear():
    counts = []
    for seed in range(150):
        world = field_of(seed)
        assert not world.known
        shapes_ = shapes(compile_world(world).at(0.0))
        counts.append(len(shapes_))
        for k, shape in enumerate(shapes_):
            assert shape.is_valid
            assert shape.convex_hull.area == pytest.approx(shape.area)
            assert shapely.minimum_bounding_radius(shape) >= 0.15 - 1e-9
            assert shapely.minimum_bounding_radius(shape) <= 0.45 + 1e-12
            assert shape.distance(shapely.Point(0.0, 1.5)) >= 0.6 - 1e-12
            assert shape.distance(shapely.Point(7.0, 2.5)) >= 0.6 - 1e-12
            for other in shapes_[:k]:
                assert shape.distance(other) >= GAP - 1e-12
    assert sorted(set(counts)) == [1, 2, 3, 4, 5, 6]


def test_corners_are_seen_head_on_by_a_sonar():
    """No angle is below 67 degrees: each side of a corner that points at the sonar is met at 56 degrees or less."""
    for seed in range(100):
        for polygon in field_of(seed).obstacles:
            corners = np.array(polygon.corners)
            before, after = np.roll(corners, 1, 0) - corners, np.roll(corners, -1, 0) - corners
            angle = np.arccos((before * after).sum(1) / np.hypot(*before.T) / np.hypot(*after.T))
            assert angle.min() > 67 * pi / 180


def test_class_b_may_overlap():
    overlaps = 0
    for seed in range(100):
        made = shapes(compile_world(field_of(seed, gap=None)).at(0.0))
        overlaps += any(a.intersects(b) for k, a in enumerate(made) for b in made[:k])
    assert 30 <= overlaps <= 80


def test_a_field_for_a_team_uses_every_lane():
    near = np.zeros(3, dtype=int)
    for seed in range(60):
        world = random_field(np.random.default_rng(seed), LANES)
        for polygon in world.obstacles:
            x, y = polygon.position
            near[np.argmin([np.hypot(p.table[0] - x, p.table[1] - y).min() for p in LANES])] += 1
            assert all(hypot(p.table[0, k] - x, p.table[1, k] - y) > 0.75 for p in LANES for k in (0, -1))
    assert near.min() > 30


def test_a_seed_gives_its_field_again():
    assert field_of(3) == field_of(3)
    assert field_of(3) != field_of(4)
    traps = [random_trap(np.random.default_rng(s), LANES[1]) for s in (1, 1, 2)]
    assert traps[0] == traps[1] != traps[2]


def test_a_trap_stands_across_the_path_and_opens_towards_its_beginning():
    turns, widths, depths = [], [], []
    for seed in range(200):
        (u,) = random_trap(np.random.default_rng([seed, 6]), LANES[1]).obstacles
        (shape,) = shapes(compile_world(World(obstacles=(u,))).at(0.0))
        assert shape.is_valid
        assert shape.convex_hull.area > 1.5 * shape.area
        path = shapely.LineString(LANES[1].table[:2].T)
        assert shape.intersects(path)
        s = LANES[1].length * np.linspace(0, 1, 500)
        on = LANES[1].at(s)
        k = int(np.argmin(np.hypot(on.x - u.position[0], on.y - u.position[1])))
        assert 0.44 < s[k] / LANES[1].length < 0.56
        assert not shape.intersects(shapely.LineString(np.stack([on.x, on.y], axis=1)[: k + 1])), "free up to there"
        assert shape.distance(shapely.Point(0.0, 0.0)) >= 0.6
        turns.append(u.heading - on.heading[k])
        assert isinstance(u, Polygon)
        (left, right, top, _) = u.corners[:4]
        widths.append(top[1] - right[1])
        depths.append(right[0] - left[0])
    for values, low, high in ((turns, -0.4, 0.4), (widths, 0.7, 1.4), (depths, 0.4, 1.2)):
        assert low - 0.01 <= min(values) < low + 0.1 * (high - low)
        assert high - 0.1 * (high - low) < max(values) <= high + 0.01


def test_what_does_not_fit_is_refused(monkeypatch):
    short = compile_path(Line(start=(0.0, 0.0), end=(1.0, 0.0)))
    rng = np.random.default_rng(0)
    monkeypatch.setattr("robotics.plugins.stress.obstaclecourse._SPREAD", 0.1)
    with pytest.raises(WorldError, match=r"no obstacle finds a place 0.6 m clear"):
        random_field(rng, [short])
    with pytest.raises(WorldError, match=r"begin and end 0.6 m or more from a trap"):
        random_trap(rng, short)
    with pytest.raises(WorldError, match="paths: at least one"):
        random_field(rng, [])


def test_regular_corners_lie_on_their_circle():
    np.testing.assert_allclose(np.hypot(*np.array(regular(12, 0.22)).T), 0.22)
    assert shapely.Polygon(regular(12, 0.22)).area == pytest.approx(6 * 0.22**2 * sin(pi / 6))
