"""ORCA by radio: the velocity nearest to what is wanted that avoids all others, who do half of it themselves.

For each other robot that is heard, optimal reciprocal collision avoidance [van den Berg, Guy, Lin and Manocha 2011]
leaves a half-plane of velocities with which the two do not meet within ``horizon``, if both obey; what the sensors see
and no message explains is taken for a disc at rest, which the robot avoids alone. Of the velocities in all half-planes
the nearest to the one wanted is found by linear programs in two and, where there is none, in three dimensions, as in
that paper and in its authors' RVO2.

A robot with two wheels cannot go any way at once. Its disc is therefore around a place ``point`` ahead of its axle,
whose velocity the wheels can choose at will [Snape et al. 2010], as in :mod:`benchmarks.avoidance`; there poses come
without delay, here what is known of others came by the radio, with its loss and latency, and is led on with their
velocities. It looks at them no farther than ``sight``. What is wanted is a direction near that of the path in which the
way is free, which elsewhere a roadmap gives. "keeping right": what is wanted is turned by ``right``, which
breaks symmetries.
"""

import math
from dataclasses import dataclass

from fuzzy.compiled.columns import Columns, within
from fuzzy.compiled.jit import compiled_only
from fuzzy.quantity import quantity
from robotics.laws.avoidance.priority import WhereaboutsColumns, tell_whereabouts
from robotics.laws.equation import HeardColumns, equation
from robotics.plugins.reactive.along import (
    REMEMBERED_POINTS,
    AlongPath,
    around,
    look_around,
    room_for_points,
    tell,
    wanted,
)
from robotics.world.radio.channel import predicted

_ROW = 4  # of a half-plane: a point (x, y) on its edge, and the edge's direction; it is what lies to the left
_TINY = 1e-5
_ECHO = 0.25  # m: what is seen so near to a robot that is heard is that robot


class OrcaMessage(Columns):
    """What every robot broadcasts: where it is."""

    where = within(WhereaboutsColumns)


class OrcaHeard(HeardColumns):
    """What one robot has heard of another."""

    said = within(OrcaMessage)


@compiled_only
def half_plane(planes, n, dx, dy, u_x, u_y, radius, horizon, dt, part):  # type: ignore[no-untyped-def]
    """Write half-plane ``n`` of the velocities that avoid a disc.

    Args:
        planes: Where it is written.
        n: Its number.
        dx, dy: Where the disc is, from the robot's own [m].
        u_x, u_y: The robot's velocity less the disc's [m/s].
        radius: The sum of both radii [m].
        horizon: For so long they shall not meet [s].
        dt: The control period [s], within which overlapping discs shall part.
        part: The share of the change that the robot takes on itself.

    Returns the half-plane's edge relative to the robot's own velocity.
    """
    apart = dx * dx + dy * dy
    inverse = 1 / horizon if apart > radius * radius else 1 / dt
    w_x, w_y = u_x - inverse * dx, u_y - inverse * dy
    size = w_x * w_x + w_y * w_y
    along = w_x * dx + w_y * dy
    if apart <= radius * radius or (along < 0 and along * along > radius * radius * size):
        length = math.sqrt(max(size, 1e-18))
        n_x, n_y = w_x / length, w_y / length
        e_x, e_y = n_y, -n_x
        c_x, c_y = (radius * inverse - length) * n_x, (radius * inverse - length) * n_y
    else:
        leg = math.sqrt(apart - radius * radius)
        if dx * w_y - dy * w_x > 0:
            e_x, e_y = (dx * leg - dy * radius) / apart, (dx * radius + dy * leg) / apart
        else:
            e_x, e_y = -(dx * leg + dy * radius) / apart, -(-dx * radius + dy * leg) / apart
        dot = u_x * e_x + u_y * e_y
        c_x, c_y = dot * e_x - u_x, dot * e_y - u_y
    row = planes[_ROW * n : _ROW * (n + 1)]
    row[0], row[1], row[2], row[3] = part * c_x, part * c_y, e_x, e_y


@compiled_only
def on_edge(planes, n, most, x, y, far):  # type: ignore[no-untyped-def]
    """The best velocity on the edge of half-plane ``n`` within those before it, and whether there is one.

    ``far``: (x, y) is a direction, in which as far as possible is best; otherwise the velocity that is wanted.
    """
    p_x, p_y, e_x, e_y = planes[_ROW * n], planes[_ROW * n + 1], planes[_ROW * n + 2], planes[_ROW * n + 3]
    dot = p_x * e_x + p_y * e_y
    room = dot * dot + most * most - p_x * p_x - p_y * p_y
    if room < 0:
        return False, 0.0, 0.0
    left, right = -dot - math.sqrt(room), -dot + math.sqrt(room)
    for k in range(n):
        q_x, q_y, f_x, f_y = planes[_ROW * k], planes[_ROW * k + 1], planes[_ROW * k + 2], planes[_ROW * k + 3]
        across = e_x * f_y - e_y * f_x
        beyond = f_x * (p_y - q_y) - f_y * (p_x - q_x)
        if abs(across) <= _TINY:
            if beyond < 0:
                return False, 0.0, 0.0
            continue
        t = beyond / across
        if across >= 0:
            right = min(right, t)
        else:
            left = max(left, t)
        if left > right:
            return False, 0.0, 0.0
    if far:
        t = right if e_x * x + e_y * y > 0 else left
    else:
        t = min(max(e_x * (x - p_x) + e_y * (y - p_y), left), right)
    return True, p_x + t * e_x, p_y + t * e_y


@compiled_only
def best_within(planes, count, most, x, y, far):  # type: ignore[no-untyped-def]
    """The best velocity in all half-planes no faster than ``most`` [m/s], and the number of the first that fails."""
    if far:
        v_x, v_y = most * x, most * y
    else:
        size = math.hypot(x, y)
        scale = min(1.0, most / max(size, 1e-12))
        v_x, v_y = scale * x, scale * y
    for n in range(count):
        row = planes[_ROW * n : _ROW * (n + 1)]
        if row[2] * (row[1] - v_y) - row[3] * (row[0] - v_x) > 0:
            found, at_x, at_y = on_edge(planes, n, most, x, y, far)
            if not found:
                return n, v_x, v_y
            v_x, v_y = at_x, at_y
    return count, v_x, v_y


@compiled_only
def least_violation(planes, count, begin, most, v_x, v_y):  # type: ignore[no-untyped-def]
    """The velocity that leaves the half-planes by the least, where none is in all; from number ``begin`` on."""
    other, distance = planes[_ROW * count :], 0.0
    for n in range(begin, count):
        p_x, p_y, e_x, e_y = planes[_ROW * n], planes[_ROW * n + 1], planes[_ROW * n + 2], planes[_ROW * n + 3]
        if e_x * (p_y - v_y) - e_y * (p_x - v_x) <= distance:
            continue
        many = 0
        for k in range(n):
            q_x, q_y, f_x, f_y = planes[_ROW * k], planes[_ROW * k + 1], planes[_ROW * k + 2], planes[_ROW * k + 3]
            across = e_x * f_y - e_y * f_x
            if abs(across) <= _TINY:
                if e_x * f_x + e_y * f_y > 0:
                    continue
                r_x, r_y = 0.5 * (p_x + q_x), 0.5 * (p_y + q_y)
            else:
                t = (f_x * (p_y - q_y) - f_y * (p_x - q_x)) / across
                r_x, r_y = p_x + t * e_x, p_y + t * e_y
            d_x, d_y = f_x - e_x, f_y - e_y
            size = max(math.hypot(d_x, d_y), 1e-12)
            row = other[_ROW * many : _ROW * (many + 1)]
            row[0], row[1], row[2], row[3] = r_x, r_y, d_x / size, d_y / size
            many += 1
        reached, w_x, w_y = best_within(other, many, most, -e_y, e_x, True)
        if reached == many:
            v_x, v_y = w_x, w_y
        distance = e_x * (p_y - v_y) - e_y * (p_x - v_x)
    return v_x, v_y


@equation
def avoid_reciprocally(robot, gain, memory, command, work, known, i, table):  # type: ignore[no-untyped-def]
    """Make the half-planes of all that is heard and seen, and drive the best velocity in them."""
    speed, course = wanted(robot, gain, memory, command, known, i)
    robots, points = known.heard.shape[2], work.points
    planes = points[2 * (3 * known.ranges.shape[0] + REMEMBERED_POINTS) :]
    count = look_for_others(robot, gain, memory, known, i, table, points)
    own = table[i % robots] + gain.point + gain.margin
    course = around(memory, points, count, own, course, robot.heading, gain.clears)
    ahead, left = avoiding_velocity(robot, gain, known, i, table, points, count, planes, speed, course)
    tell(command, ahead, min(max(left / gain.point, -gain.quickest), gain.quickest))
    tell_whereabouts(command.say.where, robot)


@compiled_only
def avoiding_velocity(robot, gain, known, i, table, points, count, planes, speed, course):  # type: ignore[no-untyped-def]
    """The velocity of the point ahead of the axle that ORCA takes, in the robot's frame [m/s].

    Args:
        robot, gain, known, i, table: As an equation has them.
        points, count: What is seen but for robots that are heard, in the robot's frame [m].
        planes: Where half-planes are written.
        speed, course: That are wanted [m/s] and [rad].
    """
    robots, point = known.heard.shape[2], gain.point
    own = table[i % robots] + point + gain.margin
    cos, sin = math.cos(robot.heading), math.sin(robot.heading)
    v_x, v_y = robot.v * cos - point * robot.w * sin, robot.v * sin + point * robot.w * cos
    for n in range(count):
        ahead, left = points[2 * n] - point, points[2 * n + 1]
        dx, dy = cos * ahead - sin * left, sin * ahead + cos * left
        half_plane(planes, n, dx, dy, v_x, v_y, own, gain.horizon_seen, known.dt, 1.0)
    for j in range(robots):
        heard = OrcaHeard(known.heard, i, j)
        where = heard.said.where
        dx = predicted(where.x, where.v_x, heard.age) - robot.x - point * cos
        dy = predicted(where.y, where.v_y, heard.age) - robot.y - point * sin
        if heard.hears > 0 and math.hypot(dx, dy) < gain.sight:  # not-a-number: never heard
            radius = own + table[j] + gain.margin
            half_plane(planes, count, dx, dy, v_x - where.v_x, v_y - where.v_y, radius, gain.horizon, known.dt, 0.5)
            count += 1
    for n in range(count):
        planes[_ROW * n] += v_x
        planes[_ROW * n + 1] += v_y
    course -= gain.right * min(1.0, speed / gain.fastest)
    reached, x, y = best_within(planes, count, gain.fastest, speed * math.cos(course), speed * math.sin(course), False)
    if reached < count:
        x, y = least_violation(planes, count, reached, gain.fastest, x, y)
    return cos * x + sin * y, cos * y - sin * x


@compiled_only
def look_for_others(robot, gain, memory, known, i, table, points):  # type: ignore[no-untyped-def]
    """Write the points that are seen within ``gain.near``, but for those of robots that are heard; return how many."""
    count, cos, sin = 0, math.cos(robot.heading), math.sin(robot.heading)
    for n in range(look_around(robot, gain, memory, known, i, table, gain.near, points)):
        ahead, left = points[2 * n], points[2 * n + 1]
        if not _explained(robot, known, table, i, cos * ahead - sin * left, sin * ahead + cos * left):
            points[2 * count], points[2 * count + 1] = ahead, left
            count += 1
    return count


@compiled_only
def _explained(robot, known, table, i, dx, dy):  # type: ignore[no-untyped-def]
    """Whether what is seen at (dx, dy) [m] from the robot is another one that is heard."""
    for j in range(known.heard.shape[2]):
        heard = OrcaHeard(known.heard, i, j)
        where = heard.said.where
        x = predicted(where.x, where.v_x, heard.age) - robot.x
        y = predicted(where.y, where.v_y, heard.age) - robot.y
        if heard.hears > 0 and math.hypot(x - dx, y - dy) < table[j] + _ECHO:
            return True
    return False


@dataclass(frozen=True, kw_only=True)
class Orca(AlongPath):
    """ORCA: the point ahead of the axle, how far ahead in time it looks, and how far around."""

    point: float = quantity(0.04, "m", above=0, most=2)
    margin: float = quantity(0.02, "m", above=0, most=2)
    horizon: float = quantity(5.0, "s", above=0, most=60)
    horizon_seen: float = quantity(0.5, "s", above=0, most=60)  # of what sensors see
    sight: float = quantity(4.0, "m", above=0, most=100)
    near: float = quantity(1.0, "m", above=0, most=100)  # what is seen farther away does not count
    clears: float = quantity(0.6, "m", above=0, most=10)  # the way that is free in the direction it wants
    quickest: float = quantity(1.5, "rad/s", above=0, most=20)
    right: float = quantity(0.15, "rad", above=0, most=1)

    equation = avoid_reciprocally
    says = OrcaMessage

    def working_for(self, robots: int, sensors: int) -> int:
        """Room for the points, and for the half-planes twice."""
        planes = robots + room_for_points(sensors) // 2
        return self.working + room_for_points(sensors) + 2 * _ROW * planes
