"""The modes of committed obstacle avoidance: track, avoid on one side, follow the wall.

    track  → avoid     a front sonar reads less than ``near``
    avoid  → track     front and side have been free for FREE_TIME
    avoid  → follow    the place on the path has not grown for STALL seconds (a trap)
    follow → avoid     the robot is BEYOND the place where it got stuck, and its way is free

A robot that avoids turns away from the obstacle and keeps the side of the first detection; while the obstacle is beside
it, its target must not pull it there. A robot that follows the wall keeps it on the same side [Lumelsky 1987, Bug 2],
and tries the other way round after FLIP seconds. The thesis has none of this: (6.7) alone forgets an obstacle as soon
as no cone sees it. The numbers below were tuned by simulation; no proof goes with them.

A robot's state is a column of :data:`ROWS` numbers.
"""

from collections.abc import Sequence
from math import sin
from typing import NamedTuple

import numpy as np

from fuzzy.compiled.jit import uncounted
from robotics.laws.modes import AVOID, FOLLOW, TRACK
from robotics.paths.posture import wrapped_compiled
from robotics.sensing.sonar import FRONT_LEFT, FRONT_RIGHT, LEFT, RIGHT, RangeSensor

# Rows of a robot's state
MODE = 0  # TRACK, AVOID or FOLLOW
WAY = 1  # round the obstacle: 1 to the left, -1 to the right
FREE = 2  # s for which front and side have been free
BEST = 3  # m: the largest place on the path since the robot stopped tracking
STALLED = 4  # s since BEST grew
NET = 5  # m: the largest place minus the distance from the path, since the robot stopped tracking
ALONG = 6  # s along the wall, since the robot last changed its way round
TURNED = 7  # rad turned without a wall in sight
WALL = 8  # 1: there is a wall; 0: there is none yet
WALL_X = 9  # m: where the wall was seen last
WALL_Y = 10  # m
LEAN = 11  # m: by how much the left front sonar reads more than the right one, smoothed
ROWS = 12

# Noticing an obstacle
NOTICED = 1.0  # m: from here on it is smoothed which of the front readings is smaller
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
CRUISE = 0.28  # m/s, while avoiding
STOP_DISTANCE = 0.12  # m: the speed is 0 where the front reads this or less
SLOWING_DISTANCE = 0.4  # m: it falls over this distance before STOP_DISTANCE

# Getting stuck, and following a wall
GROWTH = 0.05  # m: a place on the path that has grown by more is progress
STALL = 6.0  # s without progress: the robot follows the wall
FLIP = 45.0  # s along a wall before the other way round is tried
WALL_DISTANCE = 0.25  # m, from the side sonar to the wall that is followed
CORNER = 0.35  # m: radius of the turn round the end of a wall
BLOCKED = 0.27  # m: with less in front, the robot turns away from the corner it is in
SEEN = 0.7  # m: a wall that a front sonar sees no farther away is still there
BEYOND = 0.1  # m: so far past the place where it got stuck a robot may leave the wall
OPEN = 0.35  # m: and with so much ahead
RELAX = 0.3  # m: with every flip it may leave earlier, for it may have been farther while it still avoided


# Rows of what is remembered of things that may move
NEAREST_READING = 0  # m, smoothed
READING_AT_CHANGE = 1  # m: NEAREST_READING when it last changed
QUIET = 2  # s since then
HALTED = 3  # s for which the robot has stood still; 0: it does not
FLOOR = 4  # m: the robot stops only for what is nearer; infinite: for all that is too near
ROOMY_FOR = 5  # s for which there has been room
GONE = 6  # m driven since the robot was to stand still
WATCH = 7

TOO_NEAR = 0.11  # m: the robot stops for what is nearer
SWEEP = 0.012  # m s/rad: and a little earlier when it turns, for its corners are 0.05 m farther out than its sides
CHANGE = 0.02  # m: a reading that differs by more has changed
WATCH_SMOOTHING = 0.25  # s: the time constant of NEAREST_READING
RESTS = 1.0  # s without a change: the thing stands still
LOST = 3.0  # s: the same where nothing is seen; as long as something takes to pass
LONGEST_HALT = 6.0  # s
AWAY = 0.6  # m: a robot that has driven so far has got away
NEARER = 0.03  # m: for a thing that turned out to stand still, it stops again when it is so much nearer
ENOUGH_ROOM = 0.25  # m: with so much room
ROOM_TIME = 2.0  # s: for so long, FLOOR is forgotten


class Mounting(NamedTuple):
    """The places of the four sonars of each robot, in its own frame."""

    x: np.ndarray  # (sonars, robots) m
    y: np.ndarray  # (sonars, robots) m
    axis: np.ndarray  # (sonars, robots) rad
    half_cone: np.ndarray  # (sonars, robots) rad
    walls: np.ndarray  # (WALLS, robots): the numbers from which the place of a wall follows

    @classmethod
    def of(cls, robots: Sequence[Sequence[RangeSensor]]) -> "Mounting":
        """Make it from each robot's sonars, in the order FRONT_LEFT, FRONT_RIGHT, LEFT, RIGHT, alike on both sides."""
        rows = np.array([[(s.x, s.y, s.axis, s.half_cone) for s in sonars] for sonars in robots]).T
        walls = []
        for sonars in robots:
            front, side = sonars[FRONT_LEFT], sonars[LEFT]
            edge = front.axis + front.half_cone
            walls.append([front.x, front.y, side.y, edge, sin(edge), side.y - front.y])
        return cls(rows[0], rows[1], rows[2], rows[3], np.ascontiguousarray(np.array(walls).T))


# Rows of Mounting.walls. A front sonar sees a wall beside the robot at the edge of its cone; the wall's distance from
# the side sonar is then SLANT · reading − SET_BACK.
FRONT_X = 0  # m: the left front sonar
FRONT_Y = 1  # m
SIDE_Y = 2  # m: how far to the left the left side sonar is
EDGE = 3  # rad: the outer edge of the left front cone
SLANT = 4  # 1: sin EDGE
SET_BACK = 5  # m: how much farther out the side sonar is than the front one
WALLS = 6


def nothing_watched(runs: int, robots: int) -> np.ndarray:
    """Return the memory of :func:`stand_still` at the start (WATCH, runs, robots): nothing was seen yet."""
    watch = np.zeros((WATCH, runs, robots))
    watch[NEAREST_READING] = watch[READING_AT_CHANGE] = watch[FLOOR] = np.inf
    return watch


@uncounted
def stand_still(watch, fresh, v, w, dt):  # type: ignore[no-untyped-def]
    """Stop a robot that has something very near, so that it does not drive into a thing that comes nearer.

    A robot does not know whether a near thing moves. It stops and watches whether its nearest reading changes; it goes
    on when that has not changed for a while, after LONGEST_HALT, or once it has driven AWAY.

    Args:
        watch: What is remembered (WATCH,), brought up to date; at the start :func:`nothing_watched`.
        fresh: What its sonars read (4,) [m].
        v: Its speed [m/s].
        w: Its angular velocity [rad/s].
        dt: The control period [s].

    Returns whether it stands still.
    """
    now = min(fresh[FRONT_LEFT], fresh[FRONT_RIGHT], fresh[LEFT], fresh[RIGHT], 2 * ENOUGH_ROOM)
    nearest = watch[NEAREST_READING]
    smoothed = nearest + dt / WATCH_SMOOTHING * (now - nearest)
    watch[NEAREST_READING] = now if nearest > 2 * ENOUGH_ROOM else smoothed
    if not abs(watch[NEAREST_READING] - watch[READING_AT_CHANGE]) <= CHANGE:
        watch[READING_AT_CHANGE], watch[QUIET] = watch[NEAREST_READING], 0.0
    watch[QUIET] += dt
    watch[ROOMY_FOR] = watch[ROOMY_FOR] + dt if now > ENOUGH_ROOM else 0.0
    if watch[HALTED] > 0:
        watch[HALTED] += dt
        watch[GONE] += dt * abs(v)
        quiet = watch[QUIET] >= (RESTS if watch[NEAREST_READING] < ENOUGH_ROOM else LOST)
        if watch[GONE] > AWAY and watch[NEAREST_READING] > ENOUGH_ROOM:
            watch[HALTED], watch[FLOOR], watch[ROOMY_FOR] = 0.0, np.inf, 0.0
        elif quiet or watch[HALTED] > LONGEST_HALT:
            watch[HALTED], watch[FLOOR], watch[ROOMY_FOR] = 0.0, min(watch[NEAREST_READING], TOO_NEAR) - NEARER, 0.0
    else:
        if watch[ROOMY_FOR] > ROOM_TIME:
            watch[FLOOR] = np.inf
        if now < min(TOO_NEAR + SWEEP * abs(w), watch[FLOOR]):
            watch[HALTED], watch[GONE] = dt, 0.0
    return watch[HALTED] > 0


@uncounted
def next_mode(  # type: ignore[no-untyped-def]
    one, seen, fresh, x, y, heading, alpha, place, off, remaining, near, dt, walls
):
    """Choose a robot's mode for this period, and the motion that it asks for.

    Args:
        one: Its state (ROWS,), brought up to date.
        seen: What the sonars of :data:`robotics.sensing.sonar.SONAR` read (4,) [m], echoes that are lost for a moment
            filled in.
        fresh: The same as read, with the gaps.
        x: Its place [m], as ``y``.
        y: See there.
        heading: Its heading [rad].
        alpha: The bearing of a point a little ahead on the path [rad].
        place: The abscissa of the path's nearest point [m].
        off: The distance from that point [m].
        remaining: The distance from the end of the path [m].
        near: An obstacle that is nearer is avoided [m].
        dt: The control period [s].
        walls: As of :class:`Mounting` (WALLS,).

    Returns where to go from the heading [rad], to which Θ is still to be added; v [m/s] at most, along a wall as is; ω
    [rad/s], along a wall only; and the distance [m] that Θ is taken of.
    """
    front = min(seen[FRONT_LEFT], seen[FRONT_RIGHT])
    # An obstacle beyond the end of the path is in nobody's way.
    limit = min(near, remaining + 0.05)
    if one[MODE] == TRACK:
        _lean(one, seen, front, dt)
    if one[MODE] == TRACK and front < limit:
        _begin(one, alpha, place, off)
    elif one[MODE] == AVOID:
        _avoid(one, seen, front, limit, place, off, dt)
    elif one[MODE] == FOLLOW:
        _follow(one, seen, front, limit, alpha, place, off, dt)
    if one[MODE] == TRACK:
        return alpha, max(1.2 * (front - STOP_DISTANCE), 0.0), 0.0, front
    if one[MODE] != AVOID:
        v, w = _along(one, seen, fresh, x, y, heading, alpha, dt, walls)
        return alpha, v, w, front
    ease = min(max((front - STOP_DISTANCE) / SLOWING_DISTANCE, 0.0), 1.0)
    beside, other = seen[RIGHT], seen[FRONT_LEFT]
    if one[WAY] < 0:
        beside, other = seen[LEFT], seen[FRONT_RIGHT]
    to, distance = alpha, front
    if other >= limit:
        distance += RELIEF
    if alpha * one[WAY] < 0:
        to = alpha * min(max((front - NO_PULL_AHEAD) / (limit - NO_PULL_AHEAD), 0.0), 1.0)
        most = MOST_PULL if beside < SIDE_REACH else UNSEEN
        to = min(max(to, -most), most)
        if beside < SIDE_REACH:
            to *= min(max((beside - TIGHT) / (LOOSE - TIGHT), 0.0), 1.0)
    to += one[WAY] * SHY * max(TIGHT - beside, 0.0)
    return to, CRUISE * ease, 0.0, distance


@uncounted
def _lean(one, seen, front, dt):  # type: ignore[no-untyped-def]
    """Update LEAN: which front sonar reads more. It is smoothed while an obstacle comes nearer."""
    apart = min(seen[FRONT_LEFT], 3.0) - min(seen[FRONT_RIGHT], 3.0)
    if front > NOTICED or one[LEAN] == 0:
        one[LEAN] = apart
    one[LEAN] += dt / LEAN_SMOOTHING * (apart - one[LEAN])


@uncounted
def _begin(one, alpha, place, off):  # type: ignore[no-untyped-def]
    """Begin to avoid: away from the smaller front reading, or, where both are alike, the way that the path goes."""
    apart = one[LEAN] if abs(one[LEAN]) > ALIKE else alpha
    one[MODE], one[WAY] = AVOID, 1.0 if apart >= 0 else -1.0
    one[FREE] = one[STALLED] = 0.0
    one[BEST], one[NET] = place, place - off


@uncounted
def _avoid(one, seen, front, limit, place, off, dt):  # type: ignore[no-untyped-def]
    """Go on avoiding, or go back to tracking, or begin to follow the wall."""
    beside, ahead, other = seen[RIGHT], seen[FRONT_RIGHT], seen[FRONT_LEFT]
    if one[WAY] < 0:
        beside, ahead, other = seen[LEFT], other, ahead
    if other < limit and ahead > other + NEW_OBSTACLE and beside >= SIDE_REACH:
        one[WAY] = -one[WAY]  # another obstacle, on the other side
    one[FREE] = one[FREE] + dt if front >= limit and beside >= SIDE_REACH else 0.0
    one[STALLED] += dt
    one[NET] = max(one[NET], place - off)
    if place > one[BEST] + GROWTH:
        one[BEST], one[STALLED] = place, 0.0
    if one[FREE] >= FREE_TIME:
        one[MODE] = TRACK
    elif one[STALLED] > STALL:
        one[MODE] = FOLLOW
        one[ALONG] = one[TURNED] = one[WALL] = 0.0


@uncounted
def _follow(one, seen, front, limit, alpha, place, off, dt):  # type: ignore[no-untyped-def]
    """Go on along the wall, or leave it, or try the other way round."""
    one[STALLED] += dt
    one[ALONG] += dt
    beyond = max(place - one[BEST], place - off - one[NET]) > BEYOND  # at the path's end the place does not grow
    if beyond and alpha * one[WAY] > -0.2 and front >= min(limit, OPEN):
        one[MODE], one[BEST] = AVOID, place
        one[FREE] = one[STALLED] = 0.0
    elif one[ALONG] > FLIP:
        one[WAY] = -one[WAY]
        one[BEST] -= RELAX
        one[NET] -= RELAX
        one[ALONG] = one[TURNED] = one[WALL] = 0.0


@uncounted
def _along(one, seen, fresh, x, y, heading, alpha, dt, wall):  # type: ignore[no-untyped-def]
    """v [m/s] and ω [rad/s] along the wall, which is on the right where the way round is to the left."""
    way = one[WAY]
    front = min(seen[FRONT_LEFT], seen[FRONT_RIGHT])
    ahead, beside = (seen[FRONT_RIGHT], seen[RIGHT]) if way > 0 else (seen[FRONT_LEFT], seen[LEFT])
    _remember(one, fresh, x, y, heading, wall)
    speed = 0.25 * min(max((front - STOP_DISTANCE) / 0.2, 0.0), 1.0)
    if front < BLOCKED:
        one[WALL], one[TURNED] = 1.0, 0.0
        return speed * 0.5, way * 1.5
    if one[WALL] == 0:  # find one first
        if beside < SIDE_REACH or ahead < 0.4:
            one[WALL] = 1.0
        return speed, min(max(2.0 * alpha, -1.5), 1.5)
    if ahead < SEEN:
        one[TURNED] = 0.0
        edge = (WALL_DISTANCE + wall[SET_BACK]) / wall[SLANT]
        away = 4.0 * (edge - ahead) + 3.0 * max(WALL_DISTANCE - min(beside, SIDE_REACH), -0.2)
        return speed, way * min(max(away, -1.0), 1.5)
    if beside < SIDE_REACH:
        one[TURNED] = 0.0
        away = 2.0 * (WALL_DISTANCE - beside) - 0.2 + 8.0 * max(0.14 - beside, 0.0)
        return speed, way * min(max(away, -0.6), 1.0)
    # Round the end of the wall: a circle about where it was seen last
    dx, dy = one[WALL_X] - x, one[WALL_Y] - y
    distance = max(np.sqrt(dx * dx + dy * dy), 0.1)
    bearing = -way * wrapped_compiled(np.arctan2(dy, dx) - heading)  # from ahead, to the wall's side
    wanted = np.pi / 2 + min(max(3.0 * (CORNER - distance), -0.6), 0.6)
    turn = min(max(2.5 * (bearing - wanted) + speed * np.sin(bearing) / distance, -1.5), 1.5)
    one[TURNED] += turn * dt
    if one[TURNED] > 8.0:
        one[WALL] = one[TURNED] = 0.0
    return speed, -way * turn


@uncounted
def _remember(one, fresh, x, y, heading, wall):  # type: ignore[no-untyped-def]
    """Remember where the wall is: beside the robot, or else at the front cone's outer edge, where it is lost first."""
    way = one[WAY]
    ahead, beside = (fresh[FRONT_RIGHT], fresh[RIGHT]) if way > 0 else (fresh[FRONT_LEFT], fresh[LEFT])
    if beside < SIDE_REACH:
        forward, aside = 0.0, wall[SIDE_Y] + beside
    elif ahead < SEEN:
        forward, aside = wall[FRONT_X] + ahead * np.cos(wall[EDGE]), wall[FRONT_Y] + ahead * np.sin(wall[EDGE])
    else:
        return
    c, s = np.cos(heading), np.sin(heading)
    one[WALL_X], one[WALL_Y] = x + c * forward + s * way * aside, y + s * forward - c * way * aside
