"""What range sensors say of the room around a robot: like walls for unlike sensors, sectors, and team-mates' echoes."""

from dataclasses import replace

import numpy as np
import pytest

from robotics.laws.law import Observation
from robotics.laws.rules.clearances import REMEMBERED, SECTOR, Sensors
from robotics.world.environment.collision import footprints
from robotics.world.environment.world import Polygon, World, box, compile_world
from robotics.world.sensing.sonar import LIDAR, SONAR, RangeSensor
from tests.robotics.laws.rules.arrayform.clearances import (
    EchoMarks,
    room_for_braking,
    sensed,
    standing_robots,
    without_robots,
)
from tests.robotics.world.sensing.echoes import exact_echoes
from tests.robotics.world.vehicle.etsro import ETSRO

ROBOT = ETSRO
RADIUS = float(np.hypot(ROBOT.length, ROBOT.width)) / 2  # 0.152 m
CELL = 0.05  # m
NOISELESS = {
    name: {key: replace(s, noise=0.0, relative_noise=0.0) for key, s in carried.items()}
    for name, carried in {"sonar": SONAR, "lidar": LIDAR}.items()
}
WALL = 0.1  # m thick


def clearances(carried, *walls, heading=0.0):
    """The clearance in each sector [m] of one robot at the origin between ``walls``."""
    pose = np.zeros((1, 1)), np.zeros((1, 1)), np.full((1, 1), heading)
    values = exact_echoes(
        [*carried.values()], *pose, footprints([ROBOT]), compile_world(World(obstacles=walls)).at(0.0)
    )
    return sensed(Sensors.of([ROBOT], [carried]), values)[:, 0, 0]


def ahead(distance):
    return Polygon(corners=box(WALL, 6.0), position=(distance + WALL / 2, 0.0))


def beside(distance):
    return Polygon(corners=box(6.0, WALL), position=(0.0, distance + np.sign(distance) * WALL / 2))


@pytest.mark.parametrize("sensors", ["sonar", "lidar"])
@pytest.mark.parametrize("distance", [0.4, 0.7, 1.1])
def test_a_wall_is_as_far_from_the_turning_circle_for_all_sensors(sensors, distance):
    near = pytest.approx(distance - RADIUS, abs=CELL)
    front = clearances(NOISELESS[sensors], ahead(distance))
    assert front[SECTOR.front_left] == near
    assert front[SECTOR.front_right] == near
    left = clearances(NOISELESS[sensors], beside(distance))
    assert left[SECTOR.left] == near
    assert np.isinf(left[SECTOR.right])
    assert clearances(NOISELESS[sensors], beside(-distance))[SECTOR.right] == near


@pytest.mark.parametrize("sensors", ["sonar", "lidar"])
def test_a_thing_on_one_side_ahead_is_in_that_front_sector_only(sensors):
    left = clearances(NOISELESS[sensors], Polygon(corners=box(0.2, 0.2), position=(0.6, 0.5)))
    assert left[SECTOR.front_left] < 0.6
    assert left[SECTOR.front_left] < left[SECTOR.front_right] - 0.05
    right = clearances(NOISELESS[sensors], Polygon(corners=box(0.2, 0.2), position=(0.6, -0.5)))
    np.testing.assert_allclose(
        right[[SECTOR.front_left, SECTOR.front_right]], left[[SECTOR.front_right, SECTOR.front_left]], atol=1e-6
    )


def test_axes_are_sorted_by_direction_whatever_turn_they_are_written_with():
    axes = {"ahead": 0.0, "a": 0.5, "b": -0.5, "c": 1.5, "d": -1.5, "e": 3.0, "f": 2 * np.pi - 0.5}
    sensors = Sensors.of([ROBOT], [{name: RangeSensor(axis=axis) for name, axis in axes.items()}])
    found = {name: {k for k in range(5) if sensors.sector[k, 0, q]} for q, name in enumerate(sensors.names)}
    assert found == {
        "ahead": {SECTOR.front_left, SECTOR.front_right},
        "a": {SECTOR.front_left},
        "b": {SECTOR.front_right},
        "c": {SECTOR.left},
        "d": {SECTOR.right},
        "e": {SECTOR.behind},
        "f": {SECTOR.front_right},
    }


def test_where_no_sensor_looks_nothing_is_seen():
    clear = clearances(NOISELESS["sonar"], Polygon(corners=box(WALL, 6.0), position=(-0.4, 0.0)))
    assert np.isinf(clear).all()
    assert np.isinf(clearances({"ahead": RangeSensor()}, beside(0.4))).all()


def test_robots_that_carry_unlike_sensors_are_told_of_their_own():
    sensors = Sensors.of([ROBOT, ROBOT], [{"a": RangeSensor()}, {"b": RangeSensor(axis=np.pi / 2)}])
    clear = sensed(sensors, np.full((1, 2, 2), 1.0))
    assert np.isfinite(clear[:, 0, 0]).tolist() == [True, True, False, False, False]
    assert np.isfinite(clear[:, 0, 1]).tolist() == [False, False, True, False, False]


@pytest.mark.parametrize("sensors", ["sonar", "lidar"])
def test_within_the_turning_circle_there_is_no_room_to_brake(sensors):
    """Clearances end at 0; what is nearer to the nose than a sonar's minimum may touch it."""
    carried = NOISELESS[sensors]
    sorted_by_axis = Sensors.of([ROBOT], [carried])
    for gap, room in ((0.3, 0.3), (0.01, None)):  # m from the nose
        world = compile_world(World(obstacles=(ahead(ROBOT.length / 2 + gap),))).at(0.0)
        here = np.zeros((1, 1))
        values = exact_echoes([*carried.values()], here, here, here, footprints([ROBOT]), world)
        values = np.maximum(values, [s.minimum for s in carried.values()])
        found = room_for_braking(sorted_by_axis, values)[:, 0, 0]
        if room is None:
            assert found[SECTOR.front_left] < -0.02
            assert sensed(sorted_by_axis, values)[SECTOR.front_left, 0, 0] < 0.01
        else:
            np.testing.assert_allclose(found, sensed(sorted_by_axis, values)[:, 0, 0])


def echo_of_the_other(place, moves, robot=ROBOT, reading=None):
    """What remains of the readings of a robot at the origin, of another of its kind at ``place`` in its frame."""
    carried = NOISELESS["sonar"]
    x, y, heading = np.array([[0.0, place[0]]]), np.array([[0.0, place[1]]]), np.zeros((1, 2))
    nothing = compile_world(World()).at(0.0)
    values = exact_echoes([*carried.values()], x, y, heading, footprints([robot, robot]), nothing)
    assert np.isfinite(values[0, 0]).any()  # it sees the other
    if reading is not None:
        values = np.where(np.isfinite(values), reading, values)
    seen = Observation(0.0, x, y, heading, x * 0, x * 0, None, None)
    dx, dy = x[:, None, :] - x[:, :, None], y[:, None, :] - y[:, :, None]
    unknown = np.where(np.eye(2, dtype=bool), np.nan, 0.0)
    radii = np.full(2, np.hypot(robot.length, robot.width) / 2)
    moving = np.full((1, 2, 2), moves)
    sensors = Sensors.of([robot, robot], [carried, carried])
    return without_robots(sensors, seen, values, dx + unknown, dy + unknown, moving, np.zeros((1, 2, 2)), radii)[0, 0]


@pytest.mark.parametrize("place", [(0.5, 0.0), (0.6, 0.25), (0.0, 0.5), (0.0, -0.5), (1.2, 0.1)])
def test_the_echo_of_a_known_robot_that_moves_is_left_out(place):
    assert np.isinf(echo_of_the_other(place, True)).all()


def test_that_of_a_robot_that_stands_is_kept_nearby_only():
    assert np.isfinite(echo_of_the_other((0.5, 0.0), False)).any()
    assert np.isinf(echo_of_the_other((1.2, 0.0), False)).all()


def test_what_is_much_nearer_than_the_robot_is_something_else():
    assert np.isfinite(echo_of_the_other((1.2, 0.0), True, reading=0.5)).any()


def test_the_echo_of_a_large_robot_is_left_out_too():
    assert np.isinf(echo_of_the_other((1.2, 0.0), True, robot=replace(ROBOT, length=0.8, width=0.6))).all()


def test_standing_robots_count_in_the_sectors_in_which_they_are():
    gap = np.array([[[0.4, 0.7, 0.9, 0.2]]])
    bearing = np.array([[[0.0, 1.5, -0.8, 0.5]]])
    counts = np.array([[[True, True, True, False]]])
    clear = standing_robots(gap, bearing, counts)[:, 0, 0]
    np.testing.assert_array_equal(clear, [0.4, 0.4, 0.7, np.inf, np.inf])


TAIL = {"side": RangeSensor(x=0.1, y=-0.1, axis=-np.pi / 2, half_cone=0.2, rays=7)}


def remembered(carried, sights, dt=0.1):
    """The clearance in each sector [m] after a robot has been at places and read what ``sights`` say, one a period."""
    sensors, radii = Sensors.of([ROBOT], [carried]), np.array([RADIUS])
    marks = EchoMarks.none(1, 1)
    for x, reading in sights:
        pose = np.full((1, 1), x), np.zeros((1, 1)), np.zeros((1, 1))
        seen = Observation(0.0, *pose, pose[1], pose[1], None, None)
        marks = marks.renewed(sensors, seen, np.full((1, 1, len(carried)), reading), radii, dt)
    return marks.clearances(seen, radii)[:, 0, 0]


def test_a_wall_beside_the_tail_that_its_sensor_has_passed_is_still_there():
    """An end of a wall 0.2 m from the side, at x = 0.1: the robot is 0.25 m farther on."""
    passed = remembered(TAIL, [(0.0, 0.2), (0.1, np.inf), (0.25, np.inf)])
    assert passed[SECTOR.right] == pytest.approx(np.hypot(0.15, 0.3) - RADIUS)
    assert np.isinf(np.delete(passed, SECTOR.right)).all()
    turned_up_ahead = remembered(TAIL, [(0.0, 0.2), (-0.3, np.inf)])  # from behind it
    assert turned_up_ahead[SECTOR.front_right] == pytest.approx(np.hypot(0.4, 0.3) - RADIUS)


def test_what_is_remembered_is_forgotten_in_time_and_nearer_things_take_its_place():
    long = [(0.0, np.inf)] * round(REMEMBERED / 0.1)
    assert np.isfinite(remembered(TAIL, [(0.0, 0.2), *long])[SECTOR.right])
    assert np.isinf(remembered(TAIL, [(0.0, 0.2), *long, (0.0, np.inf), (0.0, np.inf)])).all()
    nearer = remembered(TAIL, [(0.0, 0.3), (0.0, 0.15), (0.0, 0.3)])
    assert nearer[SECTOR.right] == pytest.approx(np.hypot(0.1, 0.25) - RADIUS)


def test_wide_cones_and_what_is_far_make_no_marks_and_only_beams_look_past_one():
    wide = {"side": replace(TAIL["side"], half_cone=0.6)}
    assert np.isinf(remembered(wide, [(0.0, 0.2)])).all()
    assert np.isinf(remembered(TAIL, [(0.0, 1.0)])).all()
    assert np.isfinite(remembered(TAIL, [(0.0, 0.2), (0.0, 1.0)])[SECTOR.right])
    beam = {"side": RangeSensor(x=0.1, y=-0.1, axis=-np.pi / 2)}
    assert np.isfinite(remembered(beam, [(0.0, 0.2), (0.0, np.inf)])[SECTOR.right])
    assert np.isinf(remembered(beam, [(0.0, 0.2), (0.0, 1.0)])).all()
