"""What range sensors say of the room around robots, on arrays; see :mod:`robotics.laws.rules.clearances`."""

from typing import NamedTuple

import numpy as np

from fuzzy.compiled.jit import kernel
from robotics.laws.avoidance.echoes import ROBOT_ECHO, is_echo
from robotics.laws.law import Observation
from robotics.laws.rules.clearances import (
    BEAM,
    LOOKED_PAST,
    MARKED,
    NARROW,
    NEARBY,
    REMEMBERED,
    SECTOR,
    SEEN_LEFT,
    SEEN_RIGHT,
    WORTH_A_MARK,
    Sensors,
)
from robotics.world.paths.posture import wrapped


def in_own_frame(seen: Observation, dx: np.ndarray, dy: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Places ``dx``, ``dy`` [m] (runs, robots, others) from each robot in its own frame: ahead, and to the left."""
    cos, sin = np.cos(seen.heading)[:, :, None], np.sin(seen.heading)[:, :, None]
    return cos * dx + sin * dy, cos * dy - sin * dx


@kernel
def without_echoes(readings, x, y, axis, half_cone, ahead, left, known, radius, nearer, unsure):
    """``readings`` [m] (runs, robots, sensors) without the echoes of ``known`` robots; one left out reads infinite.

    Args:
        readings: What the sensors read.
        x: Where the sensors are [m] (robots, sensors).
        y: Likewise [m].
        axis: Where they look [rad].
        half_cone: Half their cones [rad].
        ahead: The others' places in each robot's frame [m] (runs, robots, others).
        left: The same to the left.
        known: Whose echoes are left out (runs, robots, others) bool.
        radius: Of the other robots [m] (others,).
        nearer: By how much less than their distance they may read [m] (others,).
        unsure: How far they may be from those places [m] (runs, robots, others).
    """
    out = readings.copy()
    for r in range(readings.shape[0]):
        for i in range(readings.shape[1]):
            for q in range(readings.shape[2]):
                for j in range(ahead.shape[2]):
                    if known[r, i, j] and is_echo(
                        readings[r, i, q], x[i, q], y[i, q], axis[i, q], half_cone[i, q],
                        ahead[r, i, j], left[r, i, j], radius[j], nearer[j], unsure[r, i, j],
                    ):  # fmt: skip
                        out[r, i, q] = np.inf
                        break
    return out


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
