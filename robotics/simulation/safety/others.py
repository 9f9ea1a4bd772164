"""The other robots of a team, by radio: each promises how fast it will drive, and keeps to it.

A message says where a robot is, between which speeds, and with what turn rate at most, it drives now, and how fast
these bounds grow, up to what the robot can. It keeps every message for the time of a promise: the stated delay, and
the longest stop of any robot of the team. So whoever has heard it within the stated delay knows a rectangle that it
does not leave until he himself stands.
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
SPEED_SPARE = 0.08  # of its highest speed: what one that wants to drive promises beside that
TURNS = 1.0  # rad/s: likewise of the turn rate
REACH = 1.0  # of its turning circle: what one that stands may cover by the end of a promise, as its bound grows
BACK_GROWS, TURN_GROWS = 0.1, 0.5  # so much more slowly grow the bounds backwards, and of the turn rate
OPEN = 0.4  # of the room to each other robot: what a promise may take beside what is wanted,
SPARE_TIME = 0.5  # within this share of the time of a promise
LEAST_SPARE = 0.1  # of what a robot can: to promise less beside that is not tried
_FAR = 0.5  # m: a gap that is more is not looked at closely


class PromiseColumns(Columns):
    """What a robot keeps to for the time of a promise: bounds, and how they grow."""

    fastest = column("m/s", "forwards")
    slowest = column("m/s", "or how fast backwards, below 0")
    turn = column("rad/s", "the greatest turn rate, either way")
    grows = column("1/s", "by what share of the highest speed; backwards and in turning by less")


class PostureMessage(Columns):
    """What the monitor of each robot broadcasts."""

    x = column("m", "as measured")
    y = column("m")
    heading = column("rad")
    fastest = column("m/s", "as of PromiseColumns")
    slowest = column("m/s")
    turn = column("rad/s")
    grows = column("1/s")


class HeardPosture(HeardColumns):
    """The same as another robot has heard it."""

    x = column("m")
    y = column("m")
    heading = column("rad")
    fastest = column("m/s")
    slowest = column("m/s")
    turn = column("rad/s")
    grows = column("1/s")


@compiled_only
def highest(given):  # type: ignore[no-untyped-def]
    """The highest speed [m/s], and turn rate [rad/s], of a robot."""
    limit = given.limit
    return given.overshoot * min(limit.v_max, limit.wheel_speed_limit), given.overshoot * limit.w_max


@compiled_only
def kept_promise(guard, lane, k, period, late):  # type: ignore[no-untyped-def]
    """The bounds of all promises of a robot that hold, ``late`` [s] after period ``k``: those of (PromiseColumns,
    periods, lanes) before it.
    """
    top, swiftest = highest(GuardColumns(guard.given, lane))
    fastest, slowest, turn, keeps = math.inf, -math.inf, math.inf, guard.promises.shape[1]
    for before in range(1, keeps + 1):
        said = PromiseColumns(guard.promises, (k + keeps - before) % keeps, lane)
        more = said.grows * (before * period + late)
        fastest = min(fastest, said.fastest + more * top)
        slowest = max(slowest, said.slowest - BACK_GROWS * more * top)
        turn = min(turn, said.turn + TURN_GROWS * more * swiftest)
    return fastest, slowest, turn


@compiled_only
def grown(now, most, rise, time):  # type: ignore[no-untyped-def]
    """How far at most in ``time`` [s] at a speed that grows from ``now`` to ``most``, by ``rise`` in each second."""
    until = min(max(most - now, 0.0) / max(rise, 1e-9), time)
    return now * time + rise * until * (time - until / 2)


@compiled_only
def covered(given, fastest, slowest, turn, grows, time):  # type: ignore[no-untyped-def]
    """The rectangle that a robot does not leave in ``time`` [s]: half its length and width, its middle ahead [m].

    And half the length and width of the one that its middle does not leave. ``given`` is GuardColumns of the robot, the
    rest a promise (PromiseColumns).
    """
    top, swiftest = highest(given)
    rise, fastest, slowest = grows * top, max(fastest, 0.0), max(-slowest, 0.0)
    ahead, back = grown(fastest, top, rise, time), grown(slowest, top, BACK_GROWS * rise, time)
    turned = grown(turn, swiftest, TURN_GROWS * grows * swiftest, time)
    # The heading's sine, in the mean of the way, is at most that of its mean; more of the way is at the end.
    most = max(fastest, slowest)
    mean = (most / 2 + rise * time / 3) / max(most + rise * time / 2, 1e-9)
    aside = grown(most, top, rise, time) * math.sin(min(mean * turned + given.turned, math.pi / 2))
    length, width = given.radius, given.radius
    angle = turned + given.turned
    if angle < math.pi / 2:
        c, s = math.cos(angle), math.sin(angle)
        if angle < math.atan2(given.half_width, given.half_length):
            length = given.half_length * c + given.half_width * s
        if angle < math.atan2(given.half_length, given.half_width):
            width = given.half_width * c + given.half_length * s
    else:  # once it has turned round, what it drives ahead leads back
        until = time * max(math.pi / 2 - given.turned, 0.0) / turned
        late_ahead = ahead - grown(fastest, top, rise, until)
        ahead += back - grown(slowest, top, BACK_GROWS * rise, until)
        back += late_ahead
    way = (ahead + back) / 2
    return way + length, aside + width, (ahead - back) / 2, way, aside


@compiled_only
def gap_between(dx, dy, heading, mine, other, theirs, around, spare, turned):  # type: ignore[no-untyped-def]
    """The gap [m] between two rectangles, and what is ``around`` the second; minus infinite: they may overlap.

    Args:
        dx, dy: From the middle of the first to that of the second [m].
        heading, mine: Of the first [rad]; half its length, width and diagonal [m].
        other, theirs: The same of the second.
        around: How far what is counted to the second reaches beyond it [m].
        spare: By how much the gap may be less [m].
        turned: By how much more for each metre between them.
    """
    distance = math.sqrt(dx * dx + dy * dy)
    unsure = spare + turned * distance
    bound = distance - mine[2] - theirs[2] - around - unsure
    if bound > _FAR:
        return bound
    if rectangles_meet(dx, dy, heading, other, mine, theirs):
        return -math.inf
    c, s, cc, ss = math.cos(heading), math.sin(heading), math.cos(other), math.sin(other)
    gap = corner_gap(dx, dy, c, s, cc, ss, mine, theirs) - around
    return gap - unsure if gap > 0 else -math.inf


@compiled_only
def apart(given, other, heard, x, y, heading, body, late, unsure):  # type: ignore[no-untyped-def]
    """The gap [m] between a rectangle and all that another robot can cover by then; minus infinite: they may overlap.

    Args:
        given: GuardColumns of the robot.
        other: GuardColumns of the other.
        heard: HeardPosture: what the robot has heard of it.
        x, y, heading: The middle of the rectangle, as the robot measures its own place.
        body: Half its length, width and diagonal [m].
        late: In how many seconds it is there.
        unsure: 1: the gap is less by what the measured places may be off; 0: it is not.
    """
    half, wide, middle, way, aside = covered(
        other, heard.fastest, heard.slowest, heard.turn, heard.grows, heard.age + late
    )
    dx, dy = heard.x + math.cos(heard.heading) * middle - x, heard.y + math.sin(heard.heading) * middle - y
    # Both are off by themselves: so is the way from one to the other, by the root of the sum of squares.
    off, turned = unsure * math.sqrt(given.place * given.place + other.place * other.place), unsure * given.turned
    theirs = (half, wide, math.sqrt(half * half + wide * wide))
    gap = gap_between(dx, dy, heading, body, heard.heading, theirs, 0.0, off, turned)
    if gap > _FAR:
        return gap
    theirs = (way, aside, math.sqrt(way * way + aside * aside))  # of the two the one that takes less room is true
    return max(gap, gap_between(dx, dy, heading, body, heard.heading, theirs, other.radius, off, turned))


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
        other = GuardColumns(guard.given, first + j)
        radius = other.radius
        top, _ = highest(other)
        dx, dy = heard.x - robot.x, heard.y - robot.y
        unsure = grown(max(heard.fastest, -heard.slowest), top, heard.grows * top, heard.age) + given.place
        ahead, left = c * dx + s * dy, c * dy - s * dx
        if is_echo(reading, sensor.x, sensor.y, axis, half, ahead, left, radius, max(radius, ROBOT_ECHO), unsure):
            return True
    return False


@compiled_only
def room_to_robots(guard, lane, robots, x, y, heading, body, late, unsure):  # type: ignore[no-untyped-def]
    """The least gap [m] of a rectangle to the robots heard within the stated delay; arguments as of :func:`apart`."""
    given, first, least = GuardColumns(guard.given, lane), lane - lane % robots, math.inf
    for j in range(robots):
        heard = HeardPosture(guard.air.heard, lane, j)
        if first + j != lane and heard.age <= guard.delay:
            other = GuardColumns(guard.given, first + j)
            least = min(least, apart(given, other, heard, x, y, heading, body, late, unsure))
    return least


@compiled_only
def room_beside(guard, lane, robots, robot, fastest, slowest, turn, grows):  # type: ignore[no-untyped-def]
    """The least gap [m] between what a robot may soon cover by such a promise, and what the others may have by now."""
    given = GuardColumns(guard.given, lane)
    half, wide, middle, _, _ = covered(given, fastest, slowest, turn, grows, SPARE_TIME * guard.holds)
    x, y = robot.x + math.cos(robot.heading) * middle, robot.y + math.sin(robot.heading) * middle
    mine = (half, wide, math.sqrt(half * half + wide * wide))
    return room_to_robots(guard, lane, robots, x, y, robot.heading, mine, 0.0, 0.0)


@compiled_only
def spare_share(guard, lane, robots, robot, fastest, slowest, turn, grows, more, less, turns):  # type: ignore[no-untyped-def]
    """What share of ``more``, ``less`` and ``turns`` a robot may promise beside the rest, and take OPEN of the room."""
    least, share = (1 - OPEN) * room_beside(guard, lane, robots, robot, fastest, slowest, turn, grows), 1.0
    while least > -math.inf and share > LEAST_SPARE:
        wide = room_beside(
            guard, lane, robots, robot, fastest + share * more, slowest - share * less, turn + share * turns, grows
        )
        if wide >= least:
            return share
        share *= 0.5
    return 0.0
