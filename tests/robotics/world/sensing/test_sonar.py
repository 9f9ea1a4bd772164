"""Range sensors: echoes against a plain search ray by ray and closed forms, what is missed, noise, updates, runs."""

import os
import subprocess
import sys
from dataclasses import replace
from math import cos, hypot, inf, nan, pi, sin, sqrt
from typing import Any

import numpy as np
import pytest
import shapely
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from shapely import affinity

from robotics.plugins.stress.obstaclecourse import random_field, random_trap
from robotics.world.environment.collision import footprints
from robotics.world.environment.world import (
    Disc,
    Geometry,
    Polygon,
    Wall,
    World,
    box,
    compile_world,
    compile_worlds,
    regular,
    u_shape,
)
from robotics.world.paths.path import Line, Quintic, compile_path
from robotics.world.paths.trajectory import Timing
from robotics.world.random_streams import SONAR_STREAM
from robotics.world.sensing.carried import CarriedSensors
from robotics.world.sensing.sonar import (
    LIDAR,
    SENSOR_PRESETS,
    SONAR,
    RangeSensor,
    SonarError,
    lidar,
)
from tests.robotics.world.sensing.echoes import exact_echoes
from tests.robotics.world.sensing.readings import TICK, Readings
from tests.robotics.world.vehicle.etsro import ETSRO

BEAM = RangeSensor(range=3.0)  # straight ahead, exact
FOUR = tuple(SONAR.values())
QUIET = tuple(replace(s, noise=0.0, relative_noise=0.0) for s in FOUR)
EMPTY = compile_world(World()).at(0.0)

Pose = tuple[np.ndarray, np.ndarray, np.ndarray]  # x, y, heading


def placed(*obstacles):
    return compile_world(World(obstacles=obstacles)).at(0.0)


def at(*rows) -> Pose:
    """One run of robots at rows of x, y, heading."""
    x, y, heading = np.array(rows, dtype=float).T[:, None, :]
    return x, y, heading


def echo(sensors, geometry, *rows, robots=None):
    """The exact echoes of one run (robots, sensors)."""
    poses, sizes = at(*(rows or [(0.0, 0.0, 0.0)])), footprints(robots or [ETSRO] * max(len(rows), 1))
    return exact_echoes(sensors, *poses, sizes, geometry)[0]


# Ray by ray -----------------------------------------------------------------------------------------------------


def surfaces(world, others):
    """Segments, discs and solids of the world and of the other robots' rectangles, as shapely has them."""
    segments: list[Any] = []
    discs, solids = [], []
    for obstacle in world.obstacles:
        if isinstance(obstacle, Disc):
            discs.append((*obstacle.position, obstacle.radius))
            continue
        closed = isinstance(obstacle, Polygon)
        own = shapely.LinearRing(obstacle.corners) if closed else shapely.LineString(obstacle.points)
        own = affinity.translate(affinity.rotate(own, obstacle.heading, (0, 0), use_radians=True), *obstacle.position)
        segments += zip(own.coords[:-1], own.coords[1:], strict=True)
        solids += [shapely.Polygon(own)] if closed else []
    for (x, y, heading), robot in others:
        own = shapely.LinearRing(box(robot.length, robot.width))
        own = affinity.translate(affinity.rotate(own, heading, (0, 0), use_radians=True), x, y)
        segments += zip(own.coords[:-1], own.coords[1:], strict=True)
        solids.append(shapely.Polygon(own))
    return np.array(segments).reshape(-1, 2, 2), np.array(discs).reshape(-1, 3), solids


def search(sensor, pose, segments, discs, solids):
    """One sensor's echo: for every ray the nearest surface, then the shortest whose incidence is small enough."""
    c, s = cos(pose[2]), sin(pose[2])
    eye = np.array([pose[0] + c * sensor.x - s * sensor.y, pose[1] + s * sensor.x + c * sensor.y])
    if any(solid.contains(shapely.Point(eye)) for solid in solids):
        return 0.0
    if any(hypot(*(disc[:2] - eye)) < disc[2] for disc in discs):
        return 0.0
    angles = sensor.axis + np.linspace(-sensor.half_cone, sensor.half_cone, sensor.rays)
    best = inf
    for angle in pose[2] + (angles if sensor.rays > 1 else [sensor.axis]):
        d = np.array([cos(angle), sin(angle)])
        nearest, incidence = inf, 0.0
        for a, b in segments:
            t, u = np.linalg.solve(np.stack([d, a - b], axis=1), a - eye)
            if 0 <= t < nearest and 0 <= u <= 1:
                normal = np.array([a[1] - b[1], b[0] - a[0]]) / hypot(*(b - a))
                nearest, incidence = t, np.arccos(min(abs(normal @ d), 1))
        for x, y, radius in discs:
            away = np.array([x, y]) - eye
            roots = np.roots([1.0, -2 * d @ away, away @ away - radius**2])
            if np.isreal(roots).all() and 0 <= roots.real.min() < nearest:
                nearest = roots.real.min()
                incidence = np.arccos(min((away - nearest * d) @ d / radius, 1))
        if nearest <= sensor.range and incidence <= sensor.incidence:
            best = min(best, nearest)
    return best


def scenes(count):
    lanes = [compile_path(Quintic(start=(0.0, y), end=(5.0, y))) for y in (0.4, -0.4)]
    for seed in range(count):
        rng = np.random.default_rng(seed)
        base = random_field(rng, lanes, gap=None) if seed % 3 else random_trap(rng, lanes[0])
        spots = rng.uniform((0.5, -1.5), (4.5, 1.5), (3, 2))
        more = (
            Disc(position=tuple(spots[0].tolist()), radius=float(rng.uniform(0.05, 0.3))),
            Wall(points=tuple(map(tuple, spots[1:].tolist()))),
        )
        poses = np.concatenate([rng.uniform((0.5, -1.0), (4.5, 1.0), (3, 2)), rng.uniform(-7, 7, (3, 1))], axis=1)
        yield World(obstacles=base.obstacles + more), poses


@pytest.mark.parametrize(
    "sensors",
    [
        QUIET,
        (replace(QUIET[0], half_cone=2.0, rays=9), replace(QUIET[0], half_cone=pi, rays=8, incidence=0.6), BEAM),
        tuple(lidar(13).values()),
    ],
    ids=["sonar", "wide", "lidar"],
)
def test_echoes_are_those_of_a_plain_search(sensors):
    robots = [ETSRO, replace(ETSRO, length=0.6, width=0.1), ETSRO]
    worlds, poses = zip(*scenes(25), strict=True)
    x, y, heading = np.moveaxis(np.array(poses), 2, 0)
    together = exact_echoes(sensors, x, y, heading, footprints(robots), compile_worlds(worlds).at(0.0))
    for r, (world, rows) in enumerate(zip(worlds, poses, strict=True)):
        for i in range(3):
            others = [(rows[j], robots[j]) for j in range(3) if j != i]
            for q, sensor in enumerate(sensors):
                expected = search(sensor, rows[i], *surfaces(world, others))
                assert together[r, i, q] == pytest.approx(expected, abs=1e-9), (r, i, q)
    seen = np.isfinite(together)
    assert 0.1 < seen.mean() < 0.95
    assert (together == 0).any() or len(sensors) != 4


# Closed forms ---------------------------------------------------------------------------------------------------


@settings(max_examples=60, derandomize=True, database=None)
@given(st.floats(0.2, 1.5), st.floats(-1.2, 1.2), st.floats(0.1, 1.5))
def test_a_cone_before_a_wall(distance, tilt, incidence):
    """Of a long wall a ray at φ from its normal tells distance / cos φ, if φ is within the incidence angle."""
    sensor = RangeSensor(half_cone=0.6, rays=7, range=1.8, incidence=incidence)
    across = np.array([-sin(tilt), cos(tilt)])
    foot = distance * np.array([cos(tilt), sin(tilt)])
    wall = Wall(points=(tuple((foot - 50 * across).tolist()), tuple((foot + 50 * across).tolist())))
    phi = np.abs(np.linspace(-0.6, 0.6, 7) - tilt)
    assume(np.abs(phi - incidence).min() > 1e-9)  # a ray just at the limit may fall to either side
    seen = distance / np.cos(phi[phi <= incidence])
    seen = seen[seen <= 1.8]
    assert echo([sensor], placed(wall))[0, 0] == pytest.approx(seen.min() if len(seen) else inf, rel=1e-9)


@settings(max_examples=60, derandomize=True, database=None)
@given(st.floats(0.5, 2.5), st.floats(-0.6, 0.6), st.floats(0.05, 0.4), st.floats(0.1, pi / 2))
def test_a_beam_and_a_disc(x, y, radius, incidence):
    """A beam that passes the center at y meets the disc at asin(y / radius) from its normal."""
    sensor = replace(BEAM, incidence=incidence)
    lost = abs(y) > radius or np.arcsin(min(abs(y) / radius, 1)) > incidence
    expected = inf if lost else x - sqrt(radius**2 - y**2)
    assert echo([sensor], placed(Disc(position=(x, y), radius=radius)))[0, 0] == pytest.approx(expected, abs=1e-9)


def test_a_sensor_looks_from_its_mount_along_its_axis():
    wall = placed(Wall(points=((2.0, -50.0), (2.0, 50.0))))
    sensor = replace(BEAM, x=0.1, y=0.3, axis=0.4)
    for heading in (0.0, 0.5, -1.0):
        x = 0.7 + 0.1 * cos(heading) - 0.3 * sin(heading)
        expected = (2.0 - x) / cos(heading + 0.4)
        assert echo([sensor], wall, (0.7, 5.0, heading))[0, 0] == pytest.approx(expected)


def test_robots_see_each_other_but_not_themselves():
    ahead = [BEAM, replace(BEAM, axis=pi), replace(BEAM, axis=pi / 2)]
    seen = echo(ahead, EMPTY, (0.0, 0.0, 0.0), (1.0, 0.0, pi / 2), (0.0, 0.7, 0.0))
    np.testing.assert_allclose(seen[0], [1.0 - 0.1, inf, 0.7 - 0.1])
    np.testing.assert_allclose(seen[1], [inf, inf, 1.0 - 0.115])
    np.testing.assert_allclose(seen[2], [inf, inf, inf])
    long = echo(ahead, EMPTY, (0.0, 0.0, 0.0), (1.0, 0.0, 0.0), robots=[ETSRO, replace(ETSRO, length=0.5)])
    assert long[0, 0] == pytest.approx(0.75)


def test_the_front_pair_covers_57_degrees_to_either_side_and_the_flanks_15():
    for degrees in range(-180, 180, 3):
        angle = degrees * pi / 180
        # At 1 m from each mount, larger than between two rays
        seen = [
            np.isfinite(echo(QUIET, placed(Disc(position=(s.x + cos(angle), s.y + sin(angle)), radius=0.14)))[0, q])
            for q, s in enumerate(QUIET)
        ]
        margin = np.arcsin(0.14) * 180 / pi * 0.87  # a disc's edge is lost beyond 60 degrees
        for q, (axis, half) in enumerate(((20, 37), (-20, 37), (90, 15), (-90, 15))):
            off = abs((degrees - axis + 180) % 360 - 180)
            if off <= half:
                assert seen[q], (degrees, q)
            if off > half + margin + 1:
                assert not seen[q], (degrees, q)


def test_nothing_is_seen_beyond_the_range_or_through_something_else():
    near, far = Disc(position=(1.0, 0.0), radius=0.1), Disc(position=(2.0, 0.0), radius=0.5)
    assert echo([BEAM], placed(far, near))[0, 0] == pytest.approx(0.9)
    assert echo([replace(BEAM, range=0.89)], placed(far, near))[0, 0] == inf
    # What lies before it swallows the sound even if it sends none back.
    slanted = Wall(points=((0.4, -1.0), (0.6, 1.0)))
    assert echo([replace(BEAM, incidence=0.05)], placed(far, slanted))[0, 0] == inf
    assert echo([replace(BEAM, incidence=0.15)], placed(far, slanted))[0, 0] == pytest.approx(0.5)


@pytest.mark.parametrize(("degrees", "seen"), [(59.0, True), (61.0, False)])
def test_a_smooth_wall_sends_nothing_back_beyond_the_incidence_angle(degrees, seen):
    tilt = degrees * pi / 180
    wall = Wall(points=((1 + 9 * sin(tilt), 9 * cos(tilt)), (1 - 9 * sin(tilt), -9 * cos(tilt))))
    assert np.isfinite(echo([replace(BEAM, incidence=pi / 3)], placed(wall))[0, 0]) == seen


def test_a_sensor_inside_something_solid_reads_nothing_but_contact():
    for solid in (Disc(radius=1.0), Polygon(corners=box(1.0, 2.0)), Polygon(corners=regular(5, 0.9)[::-1])):
        assert echo([BEAM], placed(solid))[0, 0] == 0.0
    assert echo([BEAM], placed(Polygon(corners=u_shape(1.0, 2.0))))[0, 0] == pytest.approx(1.0), "in its notch"
    assert echo([BEAM], placed(Wall(points=(*box(4.0, 2.0), (-2.0, -1.0)))))[0, 0] == pytest.approx(2.0), "in an arena"
    assert echo([BEAM], EMPTY, (0.0, 0.0, 0.0), (0.05, 0.0, 0.3))[0, 0] == 0.0, "in another robot"


def test_a_moving_obstacle_is_seen_where_it_is():
    ball = Disc(radius=0.2, path=Line(start=(3.0, 0.0), end=(0.0, 0.0)), timing=Timing(speed=0.5))
    obstacles = compile_world(World(obstacles=(ball,)))
    for t in (0.0, 1.0, 3.5):
        assert echo([BEAM], obstacles.at(t))[0, 0] == pytest.approx(3.0 - 0.5 * t - 0.2)


def test_a_robot_without_a_pose_neither_sees_nor_is_seen():
    for channel in range(3):
        rows = np.array([(0.0, 0.0, 0.0), (0.5, 0.0, 0.0), (1.5, 0.0, 0.0)])
        rows[1, channel] = nan
        seen = echo([BEAM], placed(Disc(position=(1.0, 1.0))), *rows)[:, 0]
        np.testing.assert_allclose(seen, [1.385, inf, inf])


def test_the_lidar_scans_a_room():
    room = placed(Wall(points=(*box(5.0, 3.0), (-2.5, -1.5))))
    axes = np.array([s.axis for s in LIDAR.values()])
    expected = 1 / np.maximum(np.abs(np.cos(axes)) / 2.5, np.abs(np.sin(axes)) / 1.5)
    np.testing.assert_allclose(echo(tuple(LIDAR.values()), room)[0], expected)
    assert np.diff(axes) == pytest.approx(2 * pi / 180)


# Readings -------------------------------------------------------------------------------------------------------


def flat(count, distance=1.0) -> tuple[Pose, np.ndarray, Geometry]:
    """Many robots in one run, each ``distance`` before a wall and out of the others' sight."""
    geometry = placed(Wall(points=((distance, -1e4), (distance, 1e4))))
    y = np.arange(count) * 1.0
    return (np.zeros((1, count)), y[None] - y.mean(), np.zeros((1, count))), footprints([ETSRO] * count), geometry


def read(sensors, count=3000, distance=1.0, seed=0, updates=1):
    poses, sizes, geometry = flat(count, distance)
    readings = Readings(sensors, (seed,), sizes, geometry)
    return np.array([readings.at(k, *poses)[0] for k in range(updates)])


def test_noise_has_the_standard_deviation_that_was_asked_for():
    for noise, relative, distance in ((0.01, 0.0, 1.0), (0.0, 0.02, 1.5), (0.01, 0.02, 0.5)):
        readings = read([replace(BEAM, noise=noise, relative_noise=relative)] * 2, distance=distance, updates=4)
        deviation = sqrt(noise**2 + (relative * distance) ** 2)
        off = (readings - distance) / deviation
        assert abs(off.mean()) < 4 / sqrt(off.size)
        assert off.std() == pytest.approx(1.0, abs=4 / sqrt(2 * off.size))
        assert abs((off**3).mean()) < 0.1
        assert (off**4).mean() == pytest.approx(3.0, abs=0.2)
        # Between sensors, robots and updates there is nothing in common.
        for a, b in ((off[:, :, 0], off[:, :, 1]), (off[:, 1:], off[:, :-1]), (off[1:], off[:-1])):
            assert abs((a * b).mean()) < 4 / sqrt(a.size)


def test_readings_stay_between_the_minimum_and_the_range():
    sensor = replace(BEAM, range=1.05, minimum=0.95, noise=0.1)
    readings = read([sensor])
    assert readings.min() == 0.95
    assert readings.max() == 1.05
    assert np.all(read([replace(BEAM, minimum=1.2)]) == 1.2), "what is nearer reads the minimum"
    assert np.all(np.isinf(read([replace(BEAM, range=0.9, noise=0.5)]))), "what is beyond is not seen, noise or not"


def test_echoes_are_lost_as_often_as_said_and_independently():
    lost = np.isinf(read([replace(BEAM, dropout=0.2, noise=0.01)] * 2, updates=4))
    assert lost.mean() == pytest.approx(0.2, abs=4 * sqrt(0.16 / lost.size))
    assert (lost[..., 0] & lost[..., 1]).mean() == pytest.approx(0.04, abs=0.01)
    assert (lost[1:] & lost[:-1]).mean() == pytest.approx(0.04, abs=0.01)


def test_what_is_lost_does_not_shift_the_noise():
    plain = read([replace(BEAM, noise=0.01)])
    lossy = read([replace(BEAM, noise=0.01, dropout=0.3)])
    heard = np.isfinite(lossy)
    np.testing.assert_array_equal(lossy[heard], plain[heard])


def test_each_sensor_keeps_its_reading_until_its_next_update():
    sensors = [replace(BEAM, period=0.1), replace(BEAM, period=0.15), BEAM]
    readings = Readings(sensors, (0,), footprints([ETSRO]), placed(Wall(points=((2.0, -9.0), (2.0, 9.0)))))
    assert np.isinf(readings.looks.readings).all()
    for k in range(13):
        expected = [2.0 - 0.1 * (k - k % every) for every in (2, 3, 1)]
        np.testing.assert_allclose(readings.at(k, *at((0.1 * k, 0.0, 0.0)))[0, 0], expected)


def test_a_periods_readings_depend_on_the_seed_and_the_period_alone():
    """Neither on what was asked before, nor on how often."""
    poses, sizes, geometry = flat(2)
    sensors = [replace(BEAM, noise=0.01, dropout=0.1)] * 4
    readings = Readings(sensors, (7,), sizes, geometry)
    rows = [readings.at(k, *poses) for k in range(1200)]  # more than two blocks of random numbers
    assert readings.looks.drawn.tolist() == [2]
    for k in (1199, 3, 600):
        np.testing.assert_array_equal(Readings(sensors, (7,), sizes, geometry).at(k, *poses), rows[k])
        np.testing.assert_array_equal(readings.at(k, *poses), rows[k])
    assert not np.array_equal(rows[3], rows[600])


def test_the_noise_of_a_seed_is_that_of_its_generator():
    """Block by block of 4096 numbers and fewer, update by update, robot by robot, sensor by sensor."""
    poses, sizes, geometry = flat(2)
    readings = Readings([replace(BEAM, noise=0.01, period=0.1)] * 4, (7,), sizes, geometry)
    for k, block, place in ((0, 0, 0), (2, 0, 8), (1024, 1, 0), (2050, 2, 8)):  # blocks of 512 updates of 8 numbers
        drawn = np.random.default_rng([7, SONAR_STREAM, 1, block]).standard_normal(4096)[place : place + 8]
        np.testing.assert_array_equal(readings.at(k, *poses).ravel(), 1.0 + 0.01 * drawn)


# Crosstalk ------------------------------------------------------------------------------------------------------

FACING = ((0.0, 0.0, 0.0), (1.6, 0.0, pi))
OPEN = RangeSensor(x=0.115, half_cone=0.5, rays=5, range=2.0, crosstalk=1.0)


def talk(sensors, geometry, *rows, seed=0, k=0):
    return Readings(sensors, (seed,), footprints([ETSRO] * len(rows)), geometry).at(k, *at(*rows))[0]


def test_a_ping_straight_on_reads_as_half_its_way():
    """The sensors are 1.37 m apart: the echo from the other's nose says that, its ping half of it."""
    np.testing.assert_allclose(talk([OPEN], EMPTY, *FACING), 1.37 / 2)
    np.testing.assert_allclose(talk([replace(OPEN, crosstalk=0.0)], EMPTY, *FACING), 1.37)


@pytest.mark.parametrize(
    ("obstacles", "rows"),
    [
        ((), ((0.0, 0.0, 0.0), (1.6, 0.0, 0.0))),  # it looks away
        ((), ((0.0, 0.0, pi), (1.6, 0.0, pi))),  # this one does
        ((), ((0.0, 0.0, 0.6), (1.6, 0.0, pi))),  # beside the cone
        ((), ((0.0, 0.0, 0.0), (2.4, 0.0, pi))),  # too far
        ((Disc(position=(0.8, 0.0), radius=0.05),), FACING),
        ((Wall(points=((0.8, -0.1), (0.8, 0.1))),), FACING),
        ((Polygon(corners=u_shape(0.1, 0.3), position=(0.8, 0.0)),), FACING),
        ((), (*FACING, (0.8, 0.0, pi / 2))),  # a robot between
    ],
)
def test_no_ping_is_heard_from_beside_or_behind_something(obstacles, rows):
    quiet = talk([replace(OPEN, crosstalk=0.0)], placed(*obstacles), *rows)
    np.testing.assert_array_equal(talk([OPEN], placed(*obstacles), *rows)[:2], quiet[:2])


def test_obstacles_beside_the_line_hide_nothing():
    beside = placed(
        Disc(position=(0.8, 0.06), radius=0.05), Wall(points=((0.8, -0.02), (0.8, -0.5))), Disc(position=(3, 0))
    )
    np.testing.assert_allclose(talk([OPEN], beside, *FACING), 1.37 / 2)


def test_a_ping_is_heard_as_often_as_said():
    sensor = replace(OPEN, crosstalk=0.3)
    heard = np.array([talk([sensor], EMPTY, *FACING, seed=s)[:, 0] < 1.0 for s in range(1500)])
    assert heard.mean() == pytest.approx(0.3, abs=4 * sqrt(0.21 / heard.size))
    assert (heard[:, 0] & heard[:, 1]).mean() == pytest.approx(0.09, abs=0.03)


def test_only_sensors_that_ping_in_the_same_period_are_heard():
    pair = [OPEN, replace(OPEN, axis=pi, x=-0.115, period=0.1)]
    rows = ((0.0, 0.0, 0.0), (1.6, 0.0, 0.0))  # the rear sensor of the second looks at the first
    assert talk(pair, EMPTY, *rows, k=0)[0, 0] == pytest.approx(1.37 / 2)
    assert talk(pair, EMPTY, *rows, k=1)[0, 0] == pytest.approx(1.37)


# Runs ------------------------------------------------------------------------------------------------------------

ALL = tuple(replace(s, dropout=0.1, crosstalk=0.5, period=0.05 * (1 + q % 2)) for q, s in enumerate(FOUR))


def fleet(seeds) -> tuple[Pose, list[World]]:
    lanes = [compile_path(Line(start=(0.0, y), end=(5.0, y))) for y in (0.3, -0.3)]
    worlds = [random_field(np.random.default_rng([s, 6]), lanes, gap=None) for s in seeds]
    poses = np.array([np.random.default_rng(s).uniform((0, -1, -3), (5, 1, 3), (4, 3)) for s in seeds])
    x, y, heading = np.moveaxis(poses, 2, 0)
    return (x, y, heading), worlds


def driven(seeds, ticks=5, start=0):
    poses, worlds = fleet(seeds)
    readings = Readings(ALL, seeds, footprints([ETSRO] * 4), compile_worlds(worlds).at(0.0))
    return np.array([readings.at(k, *poses) for k in range(start, start + ticks)])


def test_a_run_does_not_depend_on_its_neighbours():
    together = driven(range(12))
    assert 0.1 < np.isfinite(together).mean() < 0.9
    for seeds in ((5,), (3, 5), (11, 5, 2)):
        np.testing.assert_array_equal(driven(seeds)[:, seeds.index(5)], together[:, 5])
    assert not np.array_equal(driven((5,)), driven((5,), start=2)[:5])


WITHOUT_COMPILER = """
import sys
import numpy as np
from numba import config
assert config.DISABLE_JIT
from tests.robotics.world.sensing.test_sonar import everything
np.savez(sys.argv[2], **everything())
"""


def everything():
    """What the compiled passes of world, collision and sonar compute, for a few robots in a few runs."""
    from robotics.world.environment.collision import (
        obstacle_clearance,
        obstacle_contacts,
        robot_clearance,
        robot_contacts,
    )

    (x, y, heading), worlds = fleet(range(4))
    moving = [
        World(obstacles=(*w.obstacles, Disc(path=Line(start=(0.0, 0.0), end=(5.0, 0.0)), timing=Timing(speed=0.5))))
        for w in worlds
    ]
    geometry, sizes = compile_worlds(moving).at(3.0), footprints([ETSRO] * 4)
    x, y = x * 0.5, y * 0.5  # closer, for contacts
    return {
        "circles": geometry.circles,
        "robots": robot_contacts(x, y, heading, sizes),
        "obstacles": obstacle_contacts(x, y, heading, sizes, geometry),
        "between": robot_clearance(x, y, heading, sizes),
        "around": obstacle_clearance(x, y, heading, sizes, geometry),
        "echoes": exact_echoes(FOUR, x, y, heading, sizes, geometry),
        "readings": driven(range(4), 2),
    }


def test_interpreted_the_same_code_gives_the_same_numbers(tmp_path):
    arguments = [os.path.dirname(__file__), str(tmp_path / "out.npz")]  # noqa: PTH120
    subprocess.run(
        [sys.executable, "-c", WITHOUT_COMPILER, *arguments], env=os.environ | {"NUMBA_DISABLE_JIT": "1"}, check=True
    )
    interpreted, compiled = np.load(tmp_path / "out.npz"), everything()
    assert (compiled["robots"] >= 0).any()
    assert (compiled["obstacles"] >= 0).any()
    for name, values in compiled.items():
        np.testing.assert_allclose(interpreted[name], values, rtol=1e-12, atol=1e-12, err_msg=name)


# What is refused ------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("field", "values", "message"),
    [
        ("range", {"range": 0.0}, "range must be a finite number in m, > 0"),
        ("half_cone", {"half_cone": 37.0}, "half_cone must be a finite number in rad, >= 0 and <= 3.14159; got 37.0"),
        ("incidence", {"incidence": 0.0}, "incidence must be a finite number in rad, > 0"),
        ("dropout", {"dropout": 1.5}, "dropout must be a finite number, >= 0 and <= 1; got 1.5"),
        ("rays", {"rays": 0}, "rays must be a whole number >= 1"),
        ("rays", {"rays": 2.0}, "rays must be a whole number >= 1"),
        ("rays", {"half_cone": 0.3}, "rays must be >= 2 to fill a half_cone of 0.3 rad, got 1"),
        ("minimum", {"minimum": 2.0}, "minimum must be < range, 2 m; got 2"),
    ],
)
def test_a_sensor_that_cannot_be_is_refused(field, values, message):
    with pytest.raises(SonarError, match=message) as caught:
        RangeSensor(**values)
    assert caught.value.at[-1] == field


def test_sensors_that_do_not_fit_the_control_period_are_refused():
    with pytest.raises(SonarError, match=r"period must be a multiple of 0.05 s, got 0.07"):
        CarriedSensors.opened([{"a": replace(BEAM, period=0.07)}], 1, (0,), TICK)
    with pytest.raises(SonarError, match="period must be a multiple"):
        CarriedSensors.opened([{"a": replace(BEAM, period=0.01)}], 1, (0,), TICK)
    with pytest.raises(SonarError, match="beams must be a whole number >= 2"):
        lidar(1)


def test_the_presets_are_what_they_are_called():
    assert SENSOR_PRESETS == {"sonar": SONAR, "lidar": LIDAR}
    assert len(SONAR) == 4
    front_left, front_right, on_left, on_right = FOUR
    for left, right in ((front_left, front_right), (on_left, on_right)):
        assert left == replace(right, y=-right.y, axis=-right.axis)
    body = shapely.box(-0.115, -0.1, 0.115, 0.1)
    assert all(body.exterior.distance(shapely.Point(s.x, s.y)) < 1e-12 for s in FOUR), "on the robot's outline"
