"""What reactive laws share: the way along a path, what the range sensors see, and the wheels' commands.

A robot wants to drive to a point of its own path, ``reach`` ahead of its place there, as fast as its timing says and
faster where it is late:

    speed = min(max(v_d + catch_up (s_d − s), 0), fastest)

with s the abscissa of its nearest point, s_d and v_d those that are due. What it wants is
bent by the law, and driven as v = speed cos α₊, ω = turn α, α being the bearing of the velocity that came out.

Of what a sensor sees there are points. Few wide cones tell less than a lidar: what a sonar has seen is remembered for
``keeps`` seconds, or until a sonar looks past it, as a local map of the field's planners does.
"""

import math
from dataclasses import dataclass

import numpy as np

from fuzzy.compiled.columns import Columns, column, several
from fuzzy.compiled.jit import compiled_only
from fuzzy.quantity import quantity
from robotics.laws.equation import EquationLaw
from robotics.laws.law import check_team
from robotics.laws.rules.clearances import Sensors
from robotics.laws.rules.perception import SightColumns
from robotics.laws.setting import Setting
from robotics.laws.teams.neighbours import SEARCH_REACH_AFTER_OUTAGE
from robotics.world.paths.posture import wrapped_compiled
from robotics.world.paths.road import at, moving, nearest, share
from robotics.world.sensing.carried import sensor_names

_SIGHT = SightColumns.size
_NARROW = 0.1  # rad: a cone that is wider may have its echo beside its axis
_SIDE = 0.7  # of its half: there
REMEMBERED_POINTS = 24  # points that are remembered
_SAME = 0.1  # m: a point nearer to another is that one
_WAYS, _STEP = 15, math.radians(10)  # directions to either side that are looked at, and the angle between two
_OTHER_SIDE = 3  # steps by which a direction on the other side must be nearer to what is wanted
DRIVEN_OFF = 0.95  # of the distance of what is nearer than the robot needs: the robot counts as so wide
_PAST = 0.3  # m: a sonar that reads so much more looks past a point


class AlongMemory(Columns):
    """What a reactive law remembers."""

    place = column("m", "the abscissa of the robot's nearest point")
    side = column("1", "on which side of what is wanted it goes round a thing: 1 left, -1 right, 0 neither")
    seen_x = several(REMEMBERED_POINTS, "m", "points that a sonar has seen, in the world")
    seen_y = several(REMEMBERED_POINTS, "m")
    seen_age = several(REMEMBERED_POINTS, "s", "infinite: there is none")


class PointsWork(Columns):
    """What a law works in: the points that are seen, ahead and to the left [m], and behind them what else it needs."""

    points = several(0, "m")


@dataclass(frozen=True, kw_only=True)
class AlongPath(EquationLaw):
    """A law that drives along its path, on time as far as it can, and is bent by what is near."""

    reach: float = quantity(0.6, "m", above=0, most=10)  # to the point that it steers to
    fastest: float = quantity(0.44, "m/s", above=0, most=5)
    catch_up: float = quantity(1.0, "1/s", above=0, most=20)
    turn: float = quantity(2.0, "1/s", above=0, most=20)
    keeps: float = quantity(6.0, "s", above=0, most=60)

    yields = True
    looks = True
    remembers, works = AlongMemory, PointsWork
    aims = progresses = True

    def reads(self, setting: Setting) -> tuple[str, ...]:
        """All sensors that robots carry."""
        return sensor_names(setting.sensors)

    def tables(self, setting: Setting) -> np.ndarray:
        """The circles in which the robots turn (robots,) [m], and their sensors (robots, sensors, SightColumns)."""
        every = Sensors.of(setting.robots, setting.sensors)
        sights = np.zeros((len(setting.robots), len(every.names), _SIGHT))
        if every.names:
            sights[:, :, -6:] = np.stack(every[2:], axis=-1)
        radii = [robot.turning_circle for robot in setting.robots]
        return np.concatenate([radii, sights.ravel()])[None]

    def working_for(self, robots: int, sensors: int) -> int:
        """Room for the points, too."""
        return self.working + room_for_points(sensors)

    def begin(self, setting: Setting, runs: int) -> np.ndarray:
        """Where on its path each robot starts. Raises ControllerError for several robots that are no team."""
        if len(setting.robots) > 1:
            check_team(setting)
        memory = AlongMemory.zeros(runs, len(setting.robots))
        memory.place = setting.starting_places(runs, np.zeros(1), SEARCH_REACH_AFTER_OUTAGE)
        memory.seen_age[...] = np.inf
        return np.asarray(memory.array)


@compiled_only
def sight(table, robots, sensors, i, q):  # type: ignore[no-untyped-def]
    """Sensor ``q`` of the robot in lane ``i``, as SightColumns."""
    return SightColumns(table, robots + (i % robots * sensors + q) * _SIGHT)


def room_for_points(sensors: int) -> int:
    """How many numbers the points take that so many sensors see, and those that are remembered."""
    return 2 * (3 * sensors + REMEMBERED_POINTS)


@compiled_only
def look_around(robot, gain, memory, known, i, table, far, points):  # type: ignore[no-untyped-def]
    """Write the points that are seen no farther than ``far`` [m], and those remembered; return how many they are."""
    robots, sensors, count = known.heard.shape[2], known.ranges.shape[0], 0
    cos, sin = math.cos(robot.heading), math.sin(robot.heading)
    for k in range(REMEMBERED_POINTS):
        memory.seen_age[k] = memory.seen_age[k] + known.dt if memory.seen_age[k] < gain.keeps else math.inf
    for q in range(sensors):
        seen, reading = sight(table, robots, sensors, i, q), known.ranges[q, i]
        wide = seen.half_cone > _NARROW
        if wide:
            _look_past(robot, memory, seen, reading, cos, sin)
        if not reading < far:
            continue
        for n in range(3 if wide else 1):
            angle = seen.axis + (0.0 if n == 0 else _SIDE * seen.half_cone if n == 1 else -_SIDE * seen.half_cone)
            ahead, left = seen.x + reading * math.cos(angle), seen.y + reading * math.sin(angle)
            points[2 * count], points[2 * count + 1] = ahead, left
            count += 1
            if wide and n == 0:
                _remember(memory, robot.x + cos * ahead - sin * left, robot.y + sin * ahead + cos * left)
    for k in range(REMEMBERED_POINTS):
        if 0 < memory.seen_age[k] < math.inf:
            dx, dy = memory.seen_x[k] - robot.x, memory.seen_y[k] - robot.y
            if math.hypot(dx, dy) < far:
                points[2 * count], points[2 * count + 1] = cos * dx + sin * dy, cos * dy - sin * dx
                count += 1
    return count


@compiled_only
def _look_past(robot, memory, seen, reading, cos, sin):  # type: ignore[no-untyped-def]
    """Forget the points that a sonar looks past."""
    for k in range(REMEMBERED_POINTS):
        if memory.seen_age[k] < math.inf:
            dx, dy = memory.seen_x[k] - robot.x, memory.seen_y[k] - robot.y
            ahead, left = cos * dx + sin * dy - seen.x, cos * dy - sin * dx - seen.y
            aside = abs(wrapped_compiled(math.atan2(left, ahead) - seen.axis))
            if aside < _SIDE * seen.half_cone and reading > math.hypot(ahead, left) + _PAST:
                memory.seen_age[k] = math.inf


@compiled_only
def _remember(memory, x, y):  # type: ignore[no-untyped-def]
    """Remember a point of the world [m], in the place of the same one, or of the oldest."""
    oldest = 0
    for k in range(REMEMBERED_POINTS):
        if memory.seen_age[k] < math.inf and math.hypot(memory.seen_x[k] - x, memory.seen_y[k] - y) < _SAME:
            oldest = k
            break
        if memory.seen_age[k] > memory.seen_age[oldest]:
            oldest = k
    memory.seen_x[oldest], memory.seen_y[oldest], memory.seen_age[oldest] = x, y, 0.0


@compiled_only
def wanted(robot, gain, memory, command, known, i):  # type: ignore[no-untyped-def]
    """Look along the path: the speed wanted [m/s] and its direction [rad] in the world; the target is written."""
    road, path, target = known.road, known.path[i], command.target
    place = nearest(road, path, robot.x, robot.y, memory.place, SEARCH_REACH_AFTER_OUTAGE)
    target.x, target.y, target.heading, target.v, target.w, target.s = moving(road, path, known.time)
    length = road.lengths[path]
    x, y, _, _ = at(road, path, min(place + gain.reach, length))
    dx, dy = x - robot.x, y - robot.y
    behind = target.s - place
    if place + gain.reach >= length and target.s >= length:
        behind = math.hypot(dx, dy)  # to the end, wherever the robot is beside it
    memory.place, command.progress = place, share(road, path, place)
    return min(max(target.v + gain.catch_up * behind, 0.0), gain.fastest), math.atan2(dy, dx)


@compiled_only
def around(memory, points, count, radius, course, heading, clears):  # type: ignore[no-untyped-def]
    """The direction [rad] nearest to the ``course`` wanted in which the way is free, as a planner's; the side is kept.

    Args:
        memory: AlongMemory.
        points: What is seen, in the robot's frame [m].
        count: How many points.
        radius: Half the width that the robot needs [m].
        course: The direction wanted in the world [rad].
        heading: The robot's [rad].
        clears: The way that has to be free [m].
    """
    best, found, side = 2.0 * _WAYS, course, memory.side
    for k in range(-_WAYS, _WAYS + 1):
        sign = 1.0 if k > 0 else -1.0 if k < 0 else 0.0
        value = abs(k) + (_OTHER_SIDE if sign * memory.side < 0 else 0.0)
        if value < best:
            angle = course + k * _STEP - heading
            cos, sin, free = math.cos(angle), math.sin(angle), True
            for n in range(count):
                x, y = points[2 * n], points[2 * n + 1]
                along, wide = cos * x + sin * y, min(radius, DRIVEN_OFF * math.hypot(x, y))
                free = free and not (0 < along < clears + radius and abs(cos * y - sin * x) < wide)
            if free:
                best, found, side = value, course + k * _STEP, sign
    memory.side = side
    return found


@compiled_only
def drive(command, robot, gain, v_x, v_y):  # type: ignore[no-untyped-def]
    """Command a velocity in the world [m/s]: the robot turns to it, and drives by its share ahead."""
    speed = math.hypot(v_x, v_y)
    alpha = wrapped_compiled(math.atan2(v_y, v_x) - robot.heading) if speed > 1e-3 else 0.0
    tell(command, speed * max(math.cos(alpha), 0.0), gain.turn * alpha)


@compiled_only
def tell(command, v, w):  # type: ignore[no-untyped-def]
    """Write v [m/s] and ω [rad/s]."""
    command.first, command.second, command.wish_v, command.wish_w = v, w, v, w
