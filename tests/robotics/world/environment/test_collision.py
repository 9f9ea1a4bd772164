"""Contacts and clearances against shapely, by hand at the edges, and unchanged by moving or swapping everything."""

from dataclasses import replace
from math import cos, pi, sin

import numpy as np
import pytest
import shapely
from hypothesis import given, settings
from hypothesis import strategies as st
from shapely import affinity

from robotics.world.environment.collision import (
    footprints,
    obstacle_clearance,
    obstacle_contacts,
    robot_clearance,
    robot_contacts,
)
from robotics.world.environment.world import Disc, Polygon, Wall, World, box, compile_world, compile_worlds, u_shape
from tests.robotics.world.vehicle.etsro import ETSRO

LONG = replace(ETSRO, length=0.5, width=0.1)
MIXED = [ETSRO, LONG, ETSRO, replace(ETSRO, length=0.15, width=0.3)]
UNIT = [replace(ETSRO, length=1.0, width=0.5)] * 2  # sides that binary numbers hold


def rectangle(x, y, heading, robot):
    own = shapely.box(-robot.length / 2, -robot.width / 2, robot.length / 2, robot.width / 2)
    return affinity.translate(affinity.rotate(own, heading, (0, 0), use_radians=True), x, y)


def star(rng):
    """A polygon that need not be convex: corners all round at uneven distances."""
    count = int(rng.integers(3, 9))
    angles = 2 * pi * (np.arange(count) + rng.uniform(-0.3, 0.3, count)) / count
    away = rng.uniform(0.1, 0.7, count)
    return tuple((float(r * np.cos(a)), float(r * np.sin(a))) for r, a in zip(away, angles, strict=True))


def random_world(rng):
    spots = rng.uniform(-1.5, 1.5, (5, 2)).tolist()
    headings = rng.uniform(-pi, pi, 5).tolist()
    walls = tuple(map(tuple, rng.uniform(-1.5, 1.5, (3, 2)).tolist()))
    return World(
        obstacles=(
            Polygon(corners=star(rng), position=tuple(spots[0]), heading=headings[0]),
            Disc(position=tuple(spots[1]), radius=float(rng.uniform(0.05, 0.4))),
            Polygon(corners=u_shape(0.6, 0.7), position=tuple(spots[2]), heading=headings[2]),
            Wall(points=walls),
        )
    )


def expected_of(world):
    """Each obstacle as shapely's, a disc as its center and radius."""
    made = []
    for obstacle in world.obstacles:
        if isinstance(obstacle, Disc):
            made.append((shapely.Point(obstacle.position), obstacle.radius))
            continue
        own = (
            shapely.Polygon(obstacle.corners) if isinstance(obstacle, Polygon) else shapely.LineString(obstacle.points)
        )
        turned = affinity.rotate(own, obstacle.heading, (0, 0), use_radians=True)
        made.append((affinity.translate(turned, *obstacle.position), 0.0))
    return made


def poses(rng, runs, robots, size=1.5):
    return (*rng.uniform(-size, size, (2, runs, robots)), rng.uniform(-7, 7, (runs, robots)))


def at(*rows) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """One run of robots at rows of x, y, heading."""
    x, y, heading = np.array(rows, dtype=float).T[:, None, :]
    return x, y, heading


# Against shapely ------------------------------------------------------------------------------------------------


def test_robots_among_each_other():
    rng = np.random.default_rng(1)
    x, y, heading = poses(rng, 400, 4, 0.5)
    touched = robot_contacts(x, y, heading, footprints(MIXED))
    gaps = robot_clearance(x, y, heading, footprints(MIXED))
    some = 0
    for r in range(400):
        made = [rectangle(x[r, i], y[r, i], heading[r, i], MIXED[i]) for i in range(4)]
        for i in range(4):
            others = [j for j in range(4) if j != i]
            hits = [j for j in others if made[i].intersects(made[j])]
            assert touched[r, i] == (hits[0] if hits else -1)
            assert gaps[r, i] == pytest.approx(min(made[i].distance(made[j]) for j in others), abs=1e-12)
            some += bool(hits)
    assert 300 < some < 1300


def test_robots_among_obstacles():
    rng = np.random.default_rng(2)
    worlds = [random_world(rng) for _ in range(300)]
    x, y, heading = poses(rng, 300, 3)
    robots = MIXED[:3]
    geometry = compile_worlds(worlds).at(0.0)
    touched = obstacle_contacts(x, y, heading, footprints(robots), geometry)
    gaps = obstacle_clearance(x, y, heading, footprints(robots), geometry)
    for r, world in enumerate(worlds):
        obstacles = expected_of(world)
        for i, robot in enumerate(robots):
            made = rectangle(x[r, i], y[r, i], heading[r, i], robot)
            distances = np.array([max(made.distance(shape) - radius, 0.0) for shape, radius in obstacles])
            hits = np.flatnonzero(distances == 0)
            assert touched[r, i] == (hits[0] if len(hits) else -1)
            assert gaps[r, i] == pytest.approx(distances.min(), abs=1e-12)
    assert 150 < (touched >= 0).sum() < 700
    assert set(touched.ravel()) == {-1, 0, 1, 2, 3}


# By hand --------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("second", "gap"),
    [
        ((1.0, 0.0, 0.0), 0.0),  # nose to tail, flush
        ((1.25, 0.0, 0.0), 0.25),
        ((0.0, 0.5, 0.0), 0.0),  # side by side, flush
        ((1.0, 0.5, 0.0), 0.0),  # corner to corner
        ((1.3, 0.9, 0.0), 0.5),  # 0.3 and 0.4 between the corners
        ((0.75 + 2.0**-30, 0.0, pi / 2), 2.0**-30),  # nose to flank, a nanometre apart
        ((0.0, 0.0, 1.0), 0.0),  # one in the other
        ((0.5 + 0.5 * cos(pi / 4) + 0.25 * sin(pi / 4) + 0.125, 0.0, pi / 4), 0.125),  # a corner points at the nose
    ],
)
def test_two_robots_by_hand(second, gap):
    x, y, heading = at((0.0, 0.0, 0.0), second)
    sizes = footprints(UNIT)
    np.testing.assert_allclose(robot_clearance(x, y, heading, sizes), [[gap, gap]], atol=1e-12)
    assert robot_contacts(x, y, heading, sizes).tolist() == ([[1, 0]] if gap == 0 else [[-1, -1]])


ARENA = Wall(points=(*box(8.0, 6.0), (-4.0, -3.0)))
SMALL = Polygon(corners=box(0.1, 0.1), position=(0.1, 0.1))


@pytest.mark.parametrize(
    ("obstacle", "pose", "gap"),
    [
        (Polygon(corners=box(9.0, 9.0)), (1.0, 2.0, 0.3), 0.0),  # inside a polygon
        (Disc(radius=3.0), (1.0, 1.0, 0.3), 0.0),  # inside a disc
        (SMALL, (0.0, 0.0, 0.0), 0.0),  # a polygon inside the robot
        (Disc(radius=0.01), (0.1, 0.1, 2.0), 0.0),  # a disc inside the robot
        (Wall(points=((-0.1, 0.0), (0.1, 0.1))), (0.0, 0.0, 0.0), 0.0),  # a wall inside the robot
        (ARENA, (0.0, 0.0, 0.0), 2.75),  # in an arena one is free
        (ARENA, (3.5, 0.0, 0.0), 0.0),  # the nose at its wall
        (ARENA, (9.0, 0.0, 0.0), 4.5),
        (Polygon(corners=u_shape(1.0, 2.0, 0.25)), (0.0, 0.0, 0.0), 0.25),  # in the notch of a U
        (Polygon(corners=u_shape(1.0, 2.0, 0.25)), (1.0, 0.0, pi / 2), 0.0),  # across its bottom
        (Disc(position=(1.0, 0.75), radius=0.25), (0.0, 0.0, 0.0), 2**0.5 / 2 - 0.25),  # at the corner
        (Disc(position=(1.0, 0.0), radius=0.5), (0.0, 0.0, 0.0), 0.0),  # touching
    ],
)
def test_a_robot_and_an_obstacle_by_hand(obstacle, pose, gap):
    geometry = compile_world(World(obstacles=(obstacle,))).at(0.0)
    x, y, heading = at(pose)
    sizes = footprints(UNIT[:1])
    assert obstacle_clearance(x, y, heading, sizes, geometry)[0, 0] == pytest.approx(gap, abs=1e-12)
    assert obstacle_contacts(x, y, heading, sizes, geometry)[0, 0] == (0 if gap == 0 else -1)


def test_alone_there_is_nothing_to_touch():
    x, y, heading = at((0.0, 0.0, 0.0))
    sizes, nothing = footprints([ETSRO]), compile_world(World()).at(0.0)
    assert robot_contacts(x, y, heading, sizes).tolist() == [[-1]]
    assert obstacle_contacts(x, y, heading, sizes, nothing).tolist() == [[-1]]
    assert robot_clearance(x, y, heading, sizes).tolist() == [[np.inf]]
    assert obstacle_clearance(x, y, heading, sizes, nothing).tolist() == [[np.inf]]


def test_the_rectangle_is_the_robots():
    np.testing.assert_allclose(footprints([ETSRO, LONG]), [[0.115, 0.25], [0.1, 0.05], [0.1524, 0.25495]], atol=1e-5)


# Moved, turned, swapped -----------------------------------------------------------------------------------------

place = st.tuples(*[st.floats(-0.6, 0.6, allow_subnormal=False)] * 2, st.floats(-7, 7))


@settings(max_examples=200, derandomize=True, database=None)
@given(place, place, st.tuples(*[st.floats(-5, 5)] * 2, st.floats(-pi, pi)))
def test_moving_and_swapping_both_robots_changes_nothing(first, second, shift):
    dx, dy, turn = shift
    robots = [ETSRO, LONG]

    def moved(p):
        c, s = cos(turn), sin(turn)
        return dx + c * p[0] - s * p[1], dy + s * p[0] + c * p[1], p[2] + turn

    gap = robot_clearance(*at(first, second), footprints(robots))
    np.testing.assert_array_equal(gap[:, ::-1], gap)
    np.testing.assert_allclose(robot_clearance(*at(moved(first), moved(second)), footprints(robots)), gap, atol=1e-12)
    np.testing.assert_allclose(robot_clearance(*at(second, first), footprints(robots[::-1])), gap, atol=1e-12)
    around = (*second[:2], second[2] + pi)  # a rectangle turned round is the same
    np.testing.assert_allclose(robot_clearance(*at(first, around), footprints(robots)), gap, atol=1e-12)


@settings(max_examples=100, derandomize=True, database=None)
@given(st.integers(0, 10**6), place, st.tuples(*[st.floats(-5, 5)] * 2, st.floats(-pi, pi)))
def test_moving_robot_and_obstacles_changes_nothing(seed, pose, shift):
    dx, dy, turn = shift
    world = random_world(np.random.default_rng(seed))
    c, s = cos(turn), sin(turn)

    def moved(p):
        return dx + c * p[0] - s * p[1], dy + s * p[0] + c * p[1]

    polygon, disc, u, wall = world.obstacles
    other = World(
        obstacles=(
            Polygon(corners=polygon.corners[::-1], position=moved(polygon.position), heading=_wrap(polygon, turn)),
            Disc(position=moved(disc.position), radius=disc.radius),
            Polygon(corners=u.corners, position=moved(u.position), heading=_wrap(u, turn)),
            Wall(points=tuple(moved(p) for p in wall.points[::-1])),
        )
    )
    sizes = footprints([LONG])
    gap = obstacle_clearance(*at(pose), sizes, compile_world(world).at(0.0))
    again = obstacle_clearance(*at((*moved(pose), pose[2] + turn)), sizes, compile_world(other).at(0.0))
    np.testing.assert_allclose(again, gap, atol=1e-12)


def _wrap(obstacle, turn):
    return (obstacle.heading + turn + pi) % (2 * pi) - pi


def test_contact_is_where_the_clearance_is_zero():
    rng = np.random.default_rng(5)
    x, y, heading = poses(rng, 500, 4, 0.8)
    sizes = footprints(MIXED)
    geometry = compile_worlds([random_world(rng) for _ in range(500)]).at(0.0)
    contacts = robot_contacts(x, y, heading, sizes) >= 0
    np.testing.assert_array_equal(contacts, robot_clearance(x, y, heading, sizes) == 0)
    contacts = obstacle_contacts(x, y, heading, sizes, geometry) >= 0
    np.testing.assert_array_equal(contacts, obstacle_clearance(x, y, heading, sizes, geometry) == 0)


# Runs ------------------------------------------------------------------------------------------------------------


def test_a_run_does_not_depend_on_its_neighbours():
    rng = np.random.default_rng(3)
    worlds = [random_world(rng) for _ in range(20)]
    x, y, heading = poses(rng, 20, 4, 0.8)
    sizes = footprints(MIXED)
    obstacles = compile_worlds(worlds).at(0.0)
    for r in (0, 7, 19):
        own, alone = (x[r : r + 1], y[r : r + 1], heading[r : r + 1]), compile_world(worlds[r]).at(0.0)
        for ours, theirs in (
            (robot_contacts(x, y, heading, sizes), robot_contacts(*own, sizes)),
            (robot_clearance(x, y, heading, sizes), robot_clearance(*own, sizes)),
            (obstacle_contacts(x, y, heading, sizes, obstacles), obstacle_contacts(*own, sizes, alone)),
            (obstacle_clearance(x, y, heading, sizes, obstacles), obstacle_clearance(*own, sizes, alone)),
        ):
            assert ours[r].tobytes() == theirs[0].tobytes()


def test_one_world_serves_all_runs():
    rng = np.random.default_rng(4)
    world = random_world(rng)
    x, y, heading = poses(rng, 30, 2, 0.8)
    sizes = footprints(MIXED[:2])
    for ask in (obstacle_contacts, obstacle_clearance):
        shared = ask(x, y, heading, sizes, compile_world(world).at(0.0))
        np.testing.assert_array_equal(shared, ask(x, y, heading, sizes, compile_worlds([world] * 30).at(0.0)))
    with pytest.raises(ValueError, match="a world for each of 30 runs, or one for all, is needed; got 2"):
        obstacle_contacts(x, y, heading, sizes, compile_worlds([world] * 2).at(0.0))


def test_a_robot_without_a_pose_touches_nothing():
    """A stopped robot's samples are not-a-number; the others must not notice."""
    x, y, heading = at((0.0, 0.0, 0.0), (0.1, 0.0, 0.0), (0.2, 0.0, 0.5))
    sizes, world = footprints([ETSRO] * 3), compile_world(World(obstacles=(Disc(radius=1.0),))).at(0.0)
    for channel in (x, y, heading):
        before = channel[0, 1]
        channel[0, 1] = np.nan
        assert robot_contacts(x, y, heading, sizes).tolist() == [[2, -1, 0]]
        assert robot_clearance(x, y, heading, sizes).tolist() == [[0, np.inf, 0]]
        assert obstacle_contacts(x, y, heading, sizes, world).tolist() == [[0, -1, 0]]
        assert obstacle_clearance(x, y, heading, sizes, world).tolist() == [[0, np.inf, 0]]
        channel[0, 1] = before
