"""The modes of committed obstacle avoidance: track, avoid on one side, follow the wall.

    track  → avoid     a front sonar reads less than ``near``
    avoid  → track     front and side have been free for FREE_TIME
    avoid  → follow    the place on the path has not grown for STALL seconds (a trap)
    follow → avoid     the robot is BEYOND the place where it got stuck, and its way is free

A robot that avoids turns away from the obstacle and keeps the side of the first detection; while the obstacle is beside
it, its target must not pull it there. A robot that follows the wall keeps it on the same side [Lumelsky 1987, Bug 2],
and tries the other way round after FLIP seconds. The thesis has none of this: (6.7) alone forgets an obstacle as soon
as no cone sees it. The numbers below were tuned by simulation; no proof goes with them.
"""

from collections.abc import Mapping, Sequence
from math import sin
from typing import Any

import numpy as np

from fuzzy.compiled.columns import Columns, column, several, within
from fuzzy.compiled.jit import compiled_only
from robotics.laws.modes import AVOID, FOLLOW, TRACK
from robotics.world.paths.posture import wrapped_compiled
from robotics.world.sensing.sonar import SONAR, RangeSensor


class SonarColumns(Columns):
    """What the sonars of :data:`robotics.world.sensing.sonar.SONAR` read."""

    front_left = column("m")
    front_right = column("m")
    left = column("m")
    right = column("m")


class ModeMemory(Columns):
    """A robot's state."""

    mode = column("", "TRACK, AVOID or FOLLOW")
    way = column("", "round the obstacle: 1 to the left, -1 to the right")
    free = column("s", "for which front and side have been free")
    best = column("m", "the largest place on the path since the robot stopped tracking")
    stalled = column("s", "since that grew")
    net = column("m", "the largest place minus the distance from the path, since the robot stopped tracking")
    along = column("s", "along the wall, since the robot last changed its way round")
    turned = column("rad", "turned without a wall in sight")
    wall = column("", "1: there is a wall; 0: there is none yet")
    wall_x = column("m", "where the wall was seen last")
    wall_y = column("m")
    lean = column("m", "by how much the left front sonar reads more than the right one, smoothed")


class WatchMemory(Columns):
    """What is remembered of things that may move."""

    nearest = column("m", "the nearest reading, smoothed")
    at_change = column("m", "the same when it last changed")
    quiet = column("s", "since then")
    halted = column("s", "for which the robot has stood still; 0: it does not")
    floor = column("m", "the robot stops only for what is nearer; infinite: for all that is too near")
    roomy_for = column("s", "for which there has been room")
    gone = column("m", "driven since the robot was to stand still")


class WallColumns(Columns):
    """The numbers from which the place of a wall follows.

    A front sonar sees a wall beside the robot at the edge of its cone; the wall's distance from the side sonar is then
    slant · reading − set_back.
    """

    front_x = column("m", "of the left front sonar")
    front_y = column("m")
    side_y = column("m", "how far to the left the left side sonar is")
    edge = column("rad", "the outer edge of the left front cone")
    slant = column("1", "the sine of that")
    set_back = column("m", "how much farther out the side sonar is than the front one")


class MountColumns(Columns):
    """The places of the four sonars of a robot in its own frame."""

    x = several(SonarColumns.size, "m")
    y = several(SonarColumns.size, "m")
    axis = several(SonarColumns.size, "rad")
    half_cone = several(SonarColumns.size, "rad")
    walls = within(WallColumns)


# Noticing an obstacle
_NOTICED = 1.0  # m: from here on it is smoothed which of the front readings is smaller
LEAN_SMOOTHING = 0.8  # s: the time constant of that
ALIKE = 0.02  # m: front readings that differ by no more are alike
NEW_OBSTACLE = 0.3  # m: an obstacle that is so much nearer on the other side is another one

# Avoiding: how far the target may pull the robot towards the obstacle beside it
SIDE_REACH = 0.45  # m: where a side sonar reads less, there is an obstacle beside the robot
NO_PULL_AHEAD = 0.3  # m: with less ahead the target does not pull
TIGHT = 0.21  # m: with less beside the robot it does not pull either, and the robot turns away
LOOSE = 0.29  # m: with more beside the robot it pulls in full
MOST_PULL = 1.0  # rad: it never pulls by more
UNSEEN = 0.5  # rad: the same where nothing is seen beside the robot, for a front sonar may just have lost it
SHY = 4.0  # rad/m: how the robot turns away where there is less than TIGHT beside it
RELIEF = 0.16  # m: an obstacle that only one front sonar sees counts as so much farther away
FREE_TIME = 1.2  # s for which all has to be free before the robot tracks again

# Speed
_CRUISE = 0.28  # m/s, while avoiding
STOP_DISTANCE = 0.12  # m: the speed is 0 where the front reads this or less
SLOWING_DISTANCE = 0.4  # m: it falls over this distance before STOP_DISTANCE

# Getting stuck, and following a wall
GROWTH = 0.05  # m: a place on the path that has grown by more is progress
STALL = 6.0  # s without progress: the robot follows the wall
FLIP = 45.0  # s along a wall before the other way round is tried
WALL_DISTANCE = 0.25  # m, from the side sonar to the wall that is followed
CORNER = 0.35  # m: radius of the turn round the end of a wall
BLOCKED = 0.27  # m: with less in front, the robot turns away from the corner it is in
_SEEN = 0.7  # m: a wall that a front sonar sees no farther away is still there
BEYOND = 0.1  # m: so far past the place where it got stuck a robot may leave the wall
_OPEN = 0.35  # m: and with so much ahead
RELAX = 0.3  # m: with every flip it may leave earlier, for it may have been farther while it still avoided


# Standing still before what may move
TOO_NEAR = 0.11  # m: the robot stops for what is nearer
SWEEP = 0.012  # m s/rad: and a little earlier when it turns, for its corners are 0.05 m farther out than its sides
CHANGE = 0.02  # m: a reading that differs by more has changed
WATCH_SMOOTHING = 0.25  # s: the time constant of NEAREST_READING
RESTS = 1.0  # s without a change: the thing stands still
LOST = 3.0  # s: the same where nothing is seen; as long as something takes to pass
LONGEST_HALT = 6.0  # s
_AWAY = 0.6  # m: a robot that has driven so far has got away
_NEARER = 0.03  # m: for a thing that turned out to stand still, it stops again when it is so much nearer
ENOUGH_ROOM = 0.25  # m: with so much room
ROOM_TIME = 2.0  # s: for so long, FLOOR is forgotten


def mounting(robots: Sequence[Mapping[str, RangeSensor]]) -> dict[str, Any]:
    """Return the values of :class:`MountColumns` by each robot's sonars, which are alike on both sides."""
    fronts, sides = ([sonars[name] for sonars in robots] for name in ("front-left", "left"))
    edges = [front.axis + front.half_cone for front in fronts]
    walls = {
        "front_x": [front.x for front in fronts],
        "front_y": [front.y for front in fronts],
        "side_y": [side.y for side in sides],
        "edge": edges,
        "slant": [sin(edge) for edge in edges],
        "set_back": [side.y - front.y for side, front in zip(sides, fronts, strict=True)],
    }
    places = ("x", "y", "axis", "half_cone")
    return {what: [[getattr(s[name], what) for s in robots] for name in SONAR] for what in places} | {"walls": walls}


def nothing_watched(watch: WatchMemory) -> None:
    """Begin the memory of :func:`stand_still`: nothing was seen yet."""
    watch.nearest = watch.at_change = watch.floor = np.inf


@compiled_only
def stand_still(watch, fresh, v, w, dt):  # type: ignore[no-untyped-def]
    """Stop a robot that has something very near, so that it does not drive into a thing that comes nearer.

    A robot does not know whether a near thing moves. It stops and watches whether its nearest reading changes; it goes
    on when that has not changed for a while, after LONGEST_HALT, or once it has driven _AWAY.

    Args:
        watch: What is remembered, WatchMemory, brought up to date; at the start :func:`nothing_watched`.
        fresh: What its sonars read, SonarColumns.
        v: Its speed [m/s].
        w: Its turn rate [rad/s].
        dt: The control period [s].

    Returns whether it stands still.
    """
    now = min(fresh.front_left, fresh.front_right, fresh.left, fresh.right, 2 * ENOUGH_ROOM)
    nearest = watch.nearest
    smoothed = nearest + dt / WATCH_SMOOTHING * (now - nearest)
    watch.nearest = now if nearest > 2 * ENOUGH_ROOM else smoothed
    if not abs(watch.nearest - watch.at_change) <= CHANGE:
        watch.at_change, watch.quiet = watch.nearest, 0.0
    watch.quiet += dt
    watch.roomy_for = watch.roomy_for + dt if now > ENOUGH_ROOM else 0.0
    if watch.halted > 0:
        watch.halted += dt
        watch.gone += dt * abs(v)
        quiet = watch.quiet >= (RESTS if watch.nearest < ENOUGH_ROOM else LOST)
        if watch.gone > _AWAY and watch.nearest > ENOUGH_ROOM:
            watch.halted, watch.floor, watch.roomy_for = 0.0, np.inf, 0.0
        elif quiet or watch.halted > LONGEST_HALT:
            watch.halted, watch.floor, watch.roomy_for = 0.0, min(watch.nearest, TOO_NEAR) - _NEARER, 0.0
    else:
        if watch.roomy_for > ROOM_TIME:
            watch.floor = np.inf
        if now < min(TOO_NEAR + SWEEP * abs(w), watch.floor):
            watch.halted, watch.gone = dt, 0.0
    return watch.halted > 0


@compiled_only
def next_mode(one, seen, fresh, robot, alpha, place, off, remaining, near, dt, walls):  # type: ignore[no-untyped-def]
    """Choose a robot's mode for this period, and the motion that it asks for.

    Args:
        one: Its state, ModeMemory, brought up to date.
        seen: What its sonars read, SonarColumns, echoes that are lost for a moment filled in.
        fresh: The same as read, with the gaps.
        robot: Its posture.
        alpha: The bearing of a point a little ahead on the path [rad].
        place: The abscissa of the path's nearest point [m].
        off: The distance from that point [m].
        remaining: The distance from the end of the path [m].
        near: An obstacle that is nearer is avoided [m].
        dt: The control period [s].
        walls: WallColumns.

    Returns where to go from the heading [rad], to which Θ is still to be added; v [m/s] at most, along a wall as is; ω
    [rad/s], along a wall only; and the distance [m] that Θ is taken of.
    """
    front = min(seen.front_left, seen.front_right)
    # An obstacle beyond the end of the path is in nobody's way.
    limit = min(near, remaining + 0.05)
    if one.mode == TRACK:
        _lean(one, seen, front, dt)
    if one.mode == TRACK and front < limit:
        _begin(one, alpha, place, off)
    elif one.mode == AVOID:
        _avoid(one, seen, front, limit, place, off, dt)
    elif one.mode == FOLLOW:
        _follow(one, seen, front, limit, alpha, place, off, dt)
    if one.mode == TRACK:
        return alpha, max(1.2 * (front - STOP_DISTANCE), 0.0), 0.0, front
    if one.mode != AVOID:
        v, w = _along(one, seen, fresh, robot, alpha, dt, walls)
        return alpha, v, w, front
    ease = min(max((front - STOP_DISTANCE) / SLOWING_DISTANCE, 0.0), 1.0)
    beside, other = seen.right, seen.front_left
    if one.way < 0:
        beside, other = seen.left, seen.front_right
    to, distance = alpha, front
    if other >= limit:
        distance += RELIEF
    if alpha * one.way < 0:
        to = alpha * min(max((front - NO_PULL_AHEAD) / (limit - NO_PULL_AHEAD), 0.0), 1.0)
        most = MOST_PULL if beside < SIDE_REACH else UNSEEN
        to = min(max(to, -most), most)
        if beside < SIDE_REACH:
            to *= min(max((beside - TIGHT) / (LOOSE - TIGHT), 0.0), 1.0)
    to += one.way * SHY * max(TIGHT - beside, 0.0)
    return to, _CRUISE * ease, 0.0, distance


@compiled_only
def _lean(one, seen, front, dt):  # type: ignore[no-untyped-def]
    """Update LEAN: which front sonar reads more. It is smoothed while an obstacle comes nearer."""
    apart = min(seen.front_left, 3.0) - min(seen.front_right, 3.0)
    if front > _NOTICED or one.lean == 0:
        one.lean = apart
    one.lean += dt / LEAN_SMOOTHING * (apart - one.lean)


@compiled_only
def _begin(one, alpha, place, off):  # type: ignore[no-untyped-def]
    """Begin to avoid: away from the smaller front reading, or, where both are alike, the way that the path goes."""
    apart = one.lean if abs(one.lean) > ALIKE else alpha
    one.mode, one.way = AVOID, 1.0 if apart >= 0 else -1.0
    one.free = one.stalled = 0.0
    one.best, one.net = place, place - off


@compiled_only
def _avoid(one, seen, front, limit, place, off, dt):  # type: ignore[no-untyped-def]
    """Go on avoiding, or go back to tracking, or begin to follow the wall."""
    beside, ahead, other = seen.right, seen.front_right, seen.front_left
    if one.way < 0:
        beside, ahead, other = seen.left, other, ahead
    if other < limit and ahead > other + NEW_OBSTACLE and beside >= SIDE_REACH:
        one.way = -one.way  # another obstacle, on the other side
    one.free = one.free + dt if front >= limit and beside >= SIDE_REACH else 0.0
    one.stalled += dt
    one.net = max(one.net, place - off)
    if place > one.best + GROWTH:
        one.best, one.stalled = place, 0.0
    if one.free >= FREE_TIME:
        one.mode = TRACK
    elif one.stalled > STALL:
        one.mode = FOLLOW
        one.along = one.turned = one.wall = 0.0


@compiled_only
def _follow(one, seen, front, limit, alpha, place, off, dt):  # type: ignore[no-untyped-def]
    """Go on along the wall, or leave it, or try the other way round."""
    one.stalled += dt
    one.along += dt
    beyond = max(place - one.best, place - off - one.net) > BEYOND  # at the path's end the place does not grow
    if beyond and alpha * one.way > -0.2 and front >= min(limit, _OPEN):
        one.mode, one.best = AVOID, place
        one.free = one.stalled = 0.0
    elif one.along > FLIP:
        one.way = -one.way
        one.best -= RELAX
        one.net -= RELAX
        one.along = one.turned = one.wall = 0.0


@compiled_only
def _along(one, seen, fresh, robot, alpha, dt, wall):  # type: ignore[no-untyped-def]
    """v [m/s] and ω [rad/s] along the wall, which is on the right where the way round is to the left."""
    way = one.way
    front = min(seen.front_left, seen.front_right)
    ahead, beside = (seen.front_right, seen.right) if way > 0 else (seen.front_left, seen.left)
    _remember(one, fresh, robot, wall)
    speed = 0.25 * min(max((front - STOP_DISTANCE) / 0.2, 0.0), 1.0)
    if front < BLOCKED:
        one.wall, one.turned = 1.0, 0.0
        return speed * 0.5, way * 1.5
    if one.wall == 0:  # find one first
        if beside < SIDE_REACH or ahead < 0.4:
            one.wall = 1.0
        return speed, min(max(2.0 * alpha, -1.5), 1.5)
    if ahead < _SEEN:
        one.turned = 0.0
        edge = (WALL_DISTANCE + wall.set_back) / wall.slant
        away = 4.0 * (edge - ahead) + 3.0 * max(WALL_DISTANCE - min(beside, SIDE_REACH), -0.2)
        return speed, way * min(max(away, -1.0), 1.5)
    if beside < SIDE_REACH:
        one.turned = 0.0
        away = 2.0 * (WALL_DISTANCE - beside) - 0.2 + 8.0 * max(0.14 - beside, 0.0)
        return speed, way * min(max(away, -0.6), 1.0)
    # Round the end of the wall: a circle about where it was seen last
    dx, dy = one.wall_x - robot.x, one.wall_y - robot.y
    distance = max(np.sqrt(dx * dx + dy * dy), 0.1)
    bearing = -way * wrapped_compiled(np.arctan2(dy, dx) - robot.heading)  # from ahead, to the wall's side
    wanted = np.pi / 2 + min(max(3.0 * (CORNER - distance), -0.6), 0.6)
    turn = min(max(2.5 * (bearing - wanted) + speed * np.sin(bearing) / distance, -1.5), 1.5)
    one.turned += turn * dt
    if one.turned > 8.0:
        one.wall = one.turned = 0.0
    return speed, -way * turn


@compiled_only
def _remember(one, fresh, robot, wall):  # type: ignore[no-untyped-def]
    """Remember where the wall is: beside the robot, or else at the front cone's outer edge, where it is lost first."""
    way = one.way
    ahead, beside = (fresh.front_right, fresh.right) if way > 0 else (fresh.front_left, fresh.left)
    if beside < SIDE_REACH:
        forward, aside = 0.0, wall.side_y + beside
    elif ahead < _SEEN:
        forward, aside = wall.front_x + ahead * np.cos(wall.edge), wall.front_y + ahead * np.sin(wall.edge)
    else:
        return
    c, s = np.cos(robot.heading), np.sin(robot.heading)
    one.wall_x, one.wall_y = robot.x + c * forward + s * way * aside, robot.y + s * forward - c * way * aside
