"""The other robots of a team, by radio: each promises how fast it will drive, and keeps to it.

A message says where a robot is and between which speeds, and with what turn rate at most, it will drive for the time
of a promise: the stated delay, and the longest stop of any robot of the team. A robot that wants to drive faster says
so, and drives faster when its older promises have run out. So whoever has heard it within the stated delay knows a
rectangle that it does not leave until he himself stands.
"""

import math

from fuzzy.compiled.columns import Columns, column
from fuzzy.compiled.jit import compiled_only
from robotics.laws.avoidance.echoes import ROBOT_ECHO, is_echo
from robotics.simulation.safety.ground import GuardColumns
from robotics.world.environment.collision import corner_gap, rectangles_meet
from robotics.world.radio.channel import HeardColumns

CREEP = 0.02  # m/s: what a robot that stands promises
SLACK = 1.1  # what is promised over what is wanted: a little more needs no new promise
SPEED_SPARE = 0.14  # of its highest speed: what one that wants to drive promises beside that
OPEN = 0.4  # of the room to the nearest robot: what it may cover beside what it wants, by the end of the promise
TURNS = 1.0  # rad/s: likewise of the turn rate


class PromiseColumns(Columns):
    """What a robot keeps to for the time of a promise."""

    fastest = column("m/s", "forwards")
    slowest = column("m/s", "or how fast backwards, below 0")
    turn = column("rad/s", "the greatest turn rate, either way")


class PostureMessage(Columns):
    """What the monitor of each robot broadcasts."""

    x = column("m", "as measured")
    y = column("m")
    heading = column("rad")
    fastest = column("m/s", "as of PromiseColumns")
    slowest = column("m/s")
    turn = column("rad/s")


class HeardPosture(HeardColumns):
    """The same as another robot has heard it."""

    x = column("m")
    y = column("m")
    heading = column("rad")
    fastest = column("m/s")
    slowest = column("m/s")
    turn = column("rad/s")


@compiled_only
def kept_promise(promises, lane):  # type: ignore[no-untyped-def]
    """What a robot may do now, by all its promises (PromiseColumns, periods, lanes) that hold."""
    fastest, slowest, turn = math.inf, -math.inf, math.inf
    for n in range(promises.shape[1]):
        fastest = min(fastest, promises[0, n, lane])
        slowest = max(slowest, promises[1, n, lane])
        turn = min(turn, promises[2, n, lane])
    return fastest, slowest, turn


@compiled_only
def apart(given, other, heard, x, y, heading, late):  # type: ignore[no-untyped-def]
    """The gap [m] between a body and all that another robot can cover by then; minus infinite: they may overlap.

    Args:
        given: GuardColumns of the robot.
        other: GuardColumns of the other.
        heard: HeardPosture: what the robot has heard of it.
        x, y, heading: The body, as the robot measures its own.
        late: In how many seconds it is there.
    """
    time = heard.age + late
    turn = heard.turn * time + other.turned
    ahead, back = max(heard.fastest, 0.0) * time, max(-heard.slowest, 0.0) * time
    # An arc of length s that turns by θ leaves the straight line by s θ/2 at most, and by no more than s.
    aside = max(ahead, back) * min(turn / 2, 1.0)
    if turn < math.pi / 2:
        c, s = math.cos(turn), math.sin(turn)
        length = min(other.half_length + other.half_width * s, other.radius)
        width = min(other.half_width * c + other.half_length * s, other.radius)
        if turn > math.atan2(other.half_length, other.half_width):
            width = other.radius
    else:
        length, width = other.radius, other.radius
    half = (ahead + back) / 2 + length
    middle = (ahead - back) / 2
    c, s = math.cos(heard.heading), math.sin(heard.heading)
    dx, dy = heard.x + c * middle - x, heard.y + s * middle - y
    spare = given.place + other.place + given.turned * math.sqrt(dx * dx + dy * dy)
    bound = math.sqrt(dx * dx + dy * dy) - given.radius - math.sqrt(half * half + (width + aside) ** 2) - spare
    if bound > 0.5:
        return bound
    mine, theirs = (given.half_length, given.half_width, given.radius), (half, width + aside, 0.0)
    if rectangles_meet(dx, dy, heading, heard.heading, mine, theirs):
        return -math.inf
    return corner_gap(dx, dy, math.cos(heading), math.sin(heading), c, s, mine, theirs) - spare


@compiled_only
def is_a_robot(guard, lane, robots, robot, sensor, reading):  # type: ignore[no-untyped-def]
    """Whether a robot that was heard within the stated delay explains an echo: it will not stay there."""
    given, first = GuardColumns(guard.given, lane), lane - lane % robots
    axis = math.atan2(sensor.sin_axis, sensor.cos_axis)
    half = math.atan2(sensor.sin_half, sensor.cos_half)
    c, s = math.cos(robot.heading), math.sin(robot.heading)
    for j in range(robots):
        heard = HeardPosture(guard.air.heard, lane, j)
        if first + j == lane or not heard.age <= guard.delay:
            continue
        radius = GuardColumns(guard.given, first + j).radius
        dx, dy = heard.x - robot.x, heard.y - robot.y
        unsure = max(heard.fastest, -heard.slowest) * heard.age + given.place
        ahead, left = c * dx + s * dy, c * dy - s * dx
        if is_echo(reading, sensor.x, sensor.y, axis, half, ahead, left, radius, max(radius, ROBOT_ECHO), unsure):
            return True
    return False


@compiled_only
def room_to_robots(guard, lane, robots, x, y, heading, late):  # type: ignore[no-untyped-def]
    """The least gap [m] of a body to the robots heard within the stated delay; arguments as of :func:`apart`."""
    given, first, least = GuardColumns(guard.given, lane), lane - lane % robots, math.inf
    for j in range(robots):
        heard = HeardPosture(guard.air.heard, lane, j)
        if first + j != lane and heard.age <= guard.delay:
            least = min(least, apart(given, GuardColumns(guard.given, first + j), heard, x, y, heading, late))
    return least
