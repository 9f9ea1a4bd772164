"""What the range sensors say of the room around a robot, whatever sensors it carries: the least reading by direction.

A clearance is counted from the circle in which the robot can turn on the spot, so that it means the same for robots
of all sizes. It grows no faster than a thing can go away: an echo that is lost for a moment is no obstacle gone; and
where something was seen something still is, until it is looked past or forgotten.
"""

from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np

from fuzzy.compiled.columns import codes
from robotics.laws.avoidance.echoes import ROBOT_ECHO, in_own_frame, without_echoes
from robotics.laws.law import Observation
from robotics.world.paths.posture import wrapped
from robotics.world.sensing.carried import sensor_names
from robotics.world.sensing.sonar import RangeSensor
from robotics.world.vehicle.robot import Robot

SECTOR = codes(("front_left", "front_right", "left", "right", "behind"))
AHEAD = np.pi / 3  # rad: a sensor whose axis is no farther from straight ahead looks ahead
ABEAM = 2 * np.pi / 3  # rad: one whose axis is no farther looks to the side, one beyond behind
STRAIGHT = 0.05  # rad: a sensor this near to straight ahead counts for both front sectors
RISE = np.array([1.0, 1.0, 0.6, 0.6, 0.6])  # m/s: a clearance grows no faster; a side sensor loses echoes at corners
SEEN_LEFT = np.array([-0.3, -1.0, 1.0, -2.1])  # rad: from here a standing team-mate counts for a sector
SEEN_RIGHT = np.array([1.0, 0.3, 2.1, -1.0])  # rad: to here
MARKED = (SECTOR.front_left, SECTOR.front_right, SECTOR.left, SECTOR.right)
NARROW = 0.3  # rad: half the opening angle of the widest cone that tells where a thing is
WORTH_A_MARK = 0.5  # m between the thing and the turning circle
REMEMBERED = 5.0  # s: with 3 s, 20 of 400 Pioneers touch the end of a wall that they go round, with 5 or 8 s none
LOOKED_PAST = 0.1  # m: a beam that reads so much more looks past a thing
BEAM = 0.05  # rad: half the opening angle of a beam, and how far beside it a thing may lie
NEARBY = 0.3  # m between the turning circles: a robot that stands farther away is no obstacle


class Sensors(NamedTuple):
    """The sensors of all robots, in the order of robotics.world.sensing.carried.sensor_names."""

    names: tuple[str, ...]
    sector: np.ndarray  # (sectors, robots, sensors) bool
    x: np.ndarray  # (robots, sensors) m: where they are mounted
    y: np.ndarray  # (robots, sensors) m
    axis: np.ndarray  # (robots, sensors) rad
    half_cone: np.ndarray  # (robots, sensors) rad
    inner: np.ndarray  # (robots, sensors) m: from the sensor to the robot's turning circle, along its axis
    minimum: np.ndarray  # (robots, sensors) m: what it reads of all that is nearer

    @classmethod
    def of(cls, robots: Sequence[Robot], carried: Sequence[Mapping[str, RangeSensor]]) -> "Sensors":
        """Sort the sensors that each of ``robots`` carries by the direction in which they look."""
        names = sensor_names(carried)
        shape = len(robots), len(names)
        sector = np.zeros((len(SECTOR), *shape), dtype=bool)
        rows = np.zeros((6, *shape))
        for i, (robot, own) in enumerate(zip(robots, carried, strict=True)):
            radius = robot.turning_circle
            for q, name in enumerate(names):
                if name not in own:
                    continue
                s = own[name]
                axis = float(wrapped(np.asarray(s.axis)))
                sector[_sectors(axis), i, q] = True
                along = s.x * np.cos(axis) + s.y * np.sin(axis)
                inner = -along + np.sqrt(max(radius**2 - (s.x**2 + s.y**2 - along**2), 0.0))
                rows[:, i, q] = s.x, s.y, axis, s.half_cone, inner, s.minimum
        return cls(names, sector, *rows)


def _sectors(axis: float) -> list[int]:
    if abs(axis) <= STRAIGHT:
        return [SECTOR.front_left, SECTOR.front_right]
    if abs(axis) <= AHEAD:
        return [SECTOR.front_left if axis > 0 else SECTOR.front_right]
    if abs(axis) <= ABEAM:
        return [SECTOR.left if axis > 0 else SECTOR.right]
    return [SECTOR.behind]


def sensed(sensors: Sensors, values: np.ndarray) -> np.ndarray:
    """The clearance in each sector [m] (sectors, runs, robots) by the readings ``values`` (runs, robots, sensors).

    Infinite where nothing is seen, or no sensor looks.
    """
    return _least(sensors, np.maximum(values - sensors.inner, 0.0))


def room_for_braking(sensors: Sensors, values: np.ndarray) -> np.ndarray:
    """The same below 0 too, within the turning circle; minus infinite where a sensor reads its minimum, or less."""
    return _least(sensors, np.where(values <= sensors.minimum, -np.inf, values - sensors.inner))


def _least(sensors: Sensors, clear: np.ndarray) -> np.ndarray:
    return np.stack([np.where(own, clear, np.inf).min(axis=-1, initial=np.inf) for own in sensors.sector])


def without_robots(
    sensors: Sensors,
    seen: Observation,
    values: np.ndarray,
    dx: np.ndarray,
    dy: np.ndarray,
    moves: np.ndarray,
    unsure: np.ndarray,
    radii: np.ndarray,
) -> np.ndarray:
    """The readings ``values`` without the echoes of other robots that are known, but of those that stand nearby.

    Else two robots that drive side by side would follow each other as a wall.

    Args:
        sensors: The sensors.
        seen: What the robots know of themselves.
        values: The readings [m] (runs, robots, sensors); an echo that is left out reads infinite.
        dx: Where the others are from each robot [m], in the world's axes (runs, robots, others); not-a-number: unknown.
        dy: The same along y.
        moves: Whether the others move (runs, robots, others) bool.
        unsure: How far they may be from there [m] (runs, robots, others).
        radii: Of the circles around the robots [m] (robots,).
    """
    ahead, left = in_own_frame(seen, dx, dy)
    known = moves | (np.hypot(ahead, left) > radii[:, None] + radii + NEARBY)
    mounts = sensors.x, sensors.y, sensors.axis, sensors.half_cone
    nearer = np.maximum(ROBOT_ECHO, radii)  # from the far side of a large robot to its center
    return np.asarray(without_echoes(np.ascontiguousarray(values), *mounts, ahead, left, known, radii, nearer, unsure))


class EchoMarks(NamedTuple):
    """Where a robot last saw the nearest thing in each sector of MARKED; each field is (runs, robots, sectors).

    A thing that no sensor sees any more, as the end of a wall beside the robot's tail, or a thin wall seen end-on, is
    still there. Wide cones do not tell where it is, and make no marks.
    """

    x: np.ndarray  # m, in the world's axes
    y: np.ndarray  # m
    age: np.ndarray  # s since it was seen; infinite: nothing is remembered

    @classmethod
    def none(cls, runs: int, robots: int) -> "EchoMarks":
        """Nothing is remembered."""
        zero = np.zeros((runs, robots, len(MARKED)))
        return cls(zero, zero, zero + np.inf)

    def renewed(
        self, sensors: Sensors, seen: Observation, values: np.ndarray, radii: np.ndarray, dt: float
    ) -> "EchoMarks":
        """What is remembered after a period of ``dt`` [s]; the other arguments are as of :func:`without_robots`."""
        ahead, left = in_own_frame(seen, self.x - seen.x[..., None], self.y - seen.y[..., None])
        away = np.hypot(ahead, left) - radii[:, None]
        gone = (self.age > REMEMBERED) | _looks_past(sensors, values, ahead, left)
        x, y, age = np.array(self.x), np.array(self.y), np.where(gone, np.inf, self.age + dt)
        cos, sin = np.cos(seen.heading), np.sin(seen.heading)
        narrow = sensors.half_cone <= NARROW
        robot = np.arange(len(radii))
        for k, sector in enumerate(MARKED):
            room = np.where(sensors.sector[sector] & narrow, values - sensors.inner, np.inf)
            q = room.argmin(axis=-1)
            nearest = np.take_along_axis(room, q[..., None], axis=-1)[..., 0]
            new = nearest < np.where(np.isinf(age[..., k]), WORTH_A_MARK, np.minimum(away[..., k], WORTH_A_MARK))
            axis, reading = sensors.axis[robot, q], np.take_along_axis(values, q[..., None], axis=-1)[..., 0]
            reading = np.where(new, reading, 0.0)  # infinite where nothing was seen
            there = sensors.x[robot, q] + reading * np.cos(axis), sensors.y[robot, q] + reading * np.sin(axis)
            x[..., k] = np.where(new, seen.x + cos * there[0] - sin * there[1], x[..., k])
            y[..., k] = np.where(new, seen.y + sin * there[0] + cos * there[1], y[..., k])
            age[..., k] = np.where(new, 0.0, age[..., k])
        return EchoMarks(x, y, age)

    def clearances(self, seen: Observation, radii: np.ndarray) -> np.ndarray:
        """The clearance in each sector [m] (sectors, runs, robots) to what is remembered, wherever that lies now."""
        ahead, left = in_own_frame(seen, self.x - seen.x[..., None], self.y - seen.y[..., None])
        gap = np.hypot(ahead, left) - radii[:, None]
        return standing_robots(gap, np.arctan2(left, ahead), np.isfinite(self.age))


def _looks_past(sensors: Sensors, values: np.ndarray, ahead: np.ndarray, left: np.ndarray) -> np.ndarray:
    """Whether a beam reads something farther behind a place (runs, robots, places) in the robot's frame [m].

    A cone that reads farther may have lost the echo of what points at it.
    """
    dx, dy = ahead[..., None] - sensors.x[:, None], left[..., None] - sensors.y[:, None]
    aside = np.abs(wrapped(np.arctan2(dy, dx) - sensors.axis[:, None]))
    at_it = (aside <= BEAM) & (sensors.half_cone <= BEAM)[:, None]
    read = np.where(np.isfinite(values), values, 0.0)[:, :, None]
    return np.asarray((at_it & (read > np.hypot(dx, dy) + LOOKED_PAST)).any(axis=-1))


def standing_robots(gap: np.ndarray, bearing: np.ndarray, counts: np.ndarray) -> np.ndarray:
    """The clearance in each sector [m] (sectors, runs, robots) to those other robots that count as obstacles.

    ``gap`` [m] and ``bearing`` [rad] are (runs, robots, others), ``counts`` (runs, robots, others) bool.
    """
    out = np.full((len(SECTOR), *gap.shape[:2]), np.inf)
    for sector in range(len(SEEN_LEFT)):
        inside = counts & (bearing > SEEN_LEFT[sector]) & (bearing < SEEN_RIGHT[sector])
        out[sector] = np.where(inside, np.maximum(gap, 0.0), np.inf).min(axis=-1, initial=np.inf)
    return out
