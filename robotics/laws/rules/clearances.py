"""What the range sensors say of the room around a robot, whatever sensors it carries: the least reading by direction.

A clearance is counted from the circle in which the robot can turn on the spot, so that it means the same for robots
of all sizes. It grows no faster than a thing can go away: an echo that is lost for a moment is no obstacle gone; and
where something was seen something still is, until it is looked past or forgotten.
"""

from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np

from fuzzy.compiled.columns import codes
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
