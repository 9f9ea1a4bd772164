"""Committed avoidance: which way round an obstacle, kept until it is passed; and along its wall if that leads nowhere.

A robot tracks until a front sonar reads less than ``near``. Then it avoids: it turns away, the side of the first
detection is kept until front and side have been free for a while, and its target must not pull it towards the obstacle
while that is beside it. Where the place on the path does not grow any more (a trap), it follows the wall, always on the
same side [Lumelsky 1987, Bug 2], and leaves it on the path beyond the place where it got stuck. All of a robot's state
is a column of :data:`ROWS` numbers.
"""

from collections.abc import Sequence
from math import sin
from typing import NamedTuple

import numpy as np

from fuzzy.compiled.jit import kernel
from robotics.laws.modes import AVOID, FOLLOW, TRACK
from robotics.paths.posture import wrapped_compiled
from robotics.sensing.sonar import FRONT_LEFT, FRONT_RIGHT, LEFT, RIGHT, RangeSensor

# What is remembered: mode; way round, 1 to the left, -1 to the right; s for which all has been free; since the tracking
# ended, the largest place [m], s since it grew, and the largest place less the distance from the path; s along the
# wall, since the last flip; the angle [rad] turned without a wall; is there a wall? and where it was seen last, x and
# y [m]; by how much the left front reads more than the right one, smoothed [m]
ROWS = 12
MODE, WAY, FREE, BEST, STALLED, NET, ALONG, TURNED, WALL, WALL_X, WALL_Y, LEAN = range(ROWS)

BESIDE = 0.45  # m: what a side sonar reads where an obstacle is beside the robot
HELD = 0.3  # m: with so little ahead a robot's target does not pull it at all towards the obstacle
TIGHT, LOOSE = 0.21, 0.29  # m: nor with TIGHT beside it; more and more up to LOOSE, but by PULL at most
PULL = 1.0  # rad
UNSEEN = 0.5  # rad: the same where nothing is seen beside, for a front sonar may just have lost it
SHY = 4.0  # rad/m: it turns away where there is less than TIGHT beside it
RELIEF = 0.16  # m: an obstacle that only one front sonar sees is not in the way, and may be so much nearer
NOTICED, SMOOTH, ALIKE = 1.0, 0.8, 0.02  # m, s, m: which of the front readings is smaller, and are they alike?
CLEAR = 1.2  # s for which all has to be free before the side is given up
CRUISE = 0.28  # m/s, while avoiding
STOP, SLOW = 0.12, 0.4  # m: the speed falls to 0 where the front reads STOP, from STOP + SLOW on
ANOTHER = 0.3  # m: so much nearer on the other side an obstacle is a new one
GROWTH = 0.05  # m: what counts as progress along the path
STALL = 6.0  # s without
FLIP = 45.0  # s along a wall before the other way round is tried
DISTANCE = 0.25  # m, from the side sonar to the wall that is followed
CORNER = 0.35  # m: radius of the turn round the end of a wall
BLOCKED = 0.27  # m: what a front sonar reads before a corner to turn away from
SEEN = 0.7  # m: a wall that a front sonar sees so near is still there
BEYOND, OPEN = 0.1, 0.35  # m: past where it got stuck, and with so much ahead, a robot may leave the wall
RELAX = 0.3  # m: with every flip it may leave it earlier, for it may have been farther while it still avoided


# What is remembered of what moves: the nearest reading, smoothed, and what it was when it last changed [m]; s since
# then, and since it stands still (0: it does not); so near it stood last [m], s for which there has been room, and how
# far it has gone since it was to stand still [m]
WATCH = 7
NEAREST, CHANGED, QUIET, HALTED, FLOOR, ROOM, GONE = range(WATCH)
TOO_NEAR, SWEEP = 0.11, 0.012  # m; m s/rad: corners are 0.05 m farther out than the sides, and turn with it
CHANGE, SMOOTHED = 0.02, 0.25  # m, s
RESTS, LOST = 1.0, 3.0  # s without a change: it stands still; as long as it takes to pass where nothing is seen
LONGEST_HALT = 6.0  # s
AWAY = 0.6  # m: who has left so far has got away
NEARER = 0.03  # m: so much nearer than what turned out to stand still it stops again
ROOMY, AFTER = 0.25, 2.0  # m, s: with so much room for so long that is forgotten


class Steering(NamedTuple):
    """What the state says to do; each (runs, robots)."""

    alpha: np.ndarray  # rad: where to go, from the heading; Θ is still to be added
    v: np.ndarray  # m/s at most; along a wall: as is
    w: np.ndarray  # rad/s, along a wall only
    front: np.ndarray  # m: the distance that Θ is taken of


class Mounting(NamedTuple):
    """Where the four sonars of each robot are."""

    x: np.ndarray  # (sonars, robots) m
    y: np.ndarray  # (sonars, robots) m
    axis: np.ndarray  # (sonars, robots) rad
    half_cone: np.ndarray  # (sonars, robots) rad
    walls: np.ndarray  # (WALLS, robots): what tells where a wall is

    @classmethod
    def of(cls, robots: Sequence[Sequence[RangeSensor]]) -> "Mounting":
        """Of each robot the sonars in the order of FRONT_LEFT, FRONT_RIGHT, LEFT, RIGHT, alike on both sides."""
        rows = np.array([[(s.x, s.y, s.axis, s.half_cone) for s in sonars] for sonars in robots]).T
        walls = []
        for sonars in robots:
            front, side = sonars[FRONT_LEFT], sonars[LEFT]
            edge = front.axis + front.half_cone
            walls.append([front.x, front.y, side.y, edge, sin(edge), side.y - front.y])
        return cls(rows[0], rows[1], rows[2], rows[3], np.ascontiguousarray(np.array(walls).T))


# Of one robot, rows of Mounting.walls: where the left front sonar is [m], how far to the left the side one is [m], how
# far to the side a front cone reaches [rad]; of a wall beside that is seen there, distance = slant · reading − set back
WALLS = 6
FRONT_X, FRONT_Y, SIDE_Y, EDGE, SLANT, SET_BACK = range(WALLS)


def next_mode(
    state: np.ndarray,
    ranges: np.ndarray,
    fresh: np.ndarray,
    pose: np.ndarray,
    alpha: np.ndarray,
    place: np.ndarray,
    off: np.ndarray,
    remaining: np.ndarray,
    near: float,
    dt: float,
    walls: np.ndarray,
) -> tuple[np.ndarray, Steering]:
    """The next state and what to do.

    ``state`` is (ROWS, runs, robots), ``ranges`` (runs, robots, 4) [m] those of
    :data:`robotics.sensing.sonar.SONAR` without what is missing for a moment, ``fresh`` as read; ``pose``
    (3, runs, robots) x [m], y [m], heading [rad]. ``alpha``
    [rad] is the bearing of a point a little ahead on the path, ``place`` [m] the abscissa of the nearest one, ``off``
    [m] how far that is, ``remaining`` [m] how far the end of the path; all (runs, robots). An obstacle nearer than
    ``near`` [m] is avoided. ``walls`` is that of :class:`Mounting`.
    """
    after, steer = _next_mode(state, ranges, fresh, pose, alpha, place, off, remaining, near, dt, walls)
    return after, Steering(*steer)


def nothing_watched(runs: int, robots: int) -> np.ndarray:
    """Nothing was seen yet: the memory of :func:`stand_still`."""
    watch = np.zeros((WATCH, runs, robots))
    watch[NEAREST] = watch[CHANGED] = watch[FLOOR] = np.inf
    return watch


@kernel
def stand_still(watch, fresh, v, w, dt):  # type: ignore[no-untyped-def]
    """The next ``watch``, and does a robot stand still (runs, robots)? So that not it drives into what comes nearer.

    ``watch`` (WATCH, runs, robots) begins as :func:`nothing_watched`, ``fresh`` (runs, robots, 4) [m] is as read, ``v``
    [m/s] and ``w`` [rad/s] (runs, robots) how it moves. Of what is very near a robot does not know if it moves: it
    stops, looks for a while if the nearest reading changes, and goes on if not, or after LONGEST_HALT; or it leaves,
    for AWAY.
    """
    after, stands = watch.copy(), np.zeros(w.shape, dtype=np.bool_)
    for r in range(w.shape[0]):
        for i in range(w.shape[1]):
            one = after[:, r, i]
            now = min(fresh[r, i].min(), 2 * ROOMY)
            one[NEAREST] = now if one[NEAREST] > 2 * ROOMY else one[NEAREST] + dt / SMOOTHED * (now - one[NEAREST])
            if not abs(one[NEAREST] - one[CHANGED]) <= CHANGE:
                one[CHANGED], one[QUIET] = one[NEAREST], 0.0
            one[QUIET] += dt
            one[ROOM] = one[ROOM] + dt if now > ROOMY else 0.0
            if one[HALTED] > 0:
                one[HALTED] += dt
                one[GONE] += dt * abs(v[r, i])
                if one[GONE] > AWAY and one[NEAREST] > ROOMY:
                    one[HALTED], one[FLOOR], one[ROOM] = 0.0, np.inf, 0.0
                elif one[QUIET] >= (RESTS if one[NEAREST] < ROOMY else LOST) or one[HALTED] > LONGEST_HALT:
                    one[HALTED], one[FLOOR], one[ROOM] = 0.0, min(one[NEAREST], TOO_NEAR) - NEARER, 0.0
            else:
                if one[ROOM] > AFTER:
                    one[FLOOR] = np.inf
                if now < min(TOO_NEAR + SWEEP * abs(w[r, i]), one[FLOOR]):
                    one[HALTED], one[GONE] = dt, 0.0
            stands[r, i] = one[HALTED] > 0
    return after, stands


@kernel
def _next_mode(state, ranges, fresh, pose, alpha, place, off, remaining, near, dt, walls):  # type: ignore[no-untyped-def]
    after, steer = state.copy(), np.zeros((4, *alpha.shape))
    for r in range(alpha.shape[0]):
        for i in range(alpha.shape[1]):
            one = after[:, r, i]
            seen = ranges[r, i]
            front = min(seen[FRONT_LEFT], seen[FRONT_RIGHT])
            # What is behind the end of the path is in nobody's way.
            limit = min(near, remaining[r, i] + 0.05)
            if one[MODE] == TRACK:
                _lean(one, seen, front, dt)
            if one[MODE] == TRACK and front < limit:
                _begin(one, alpha[r, i], place[r, i], off[r, i])
            elif one[MODE] == AVOID:
                _avoid(one, seen, front, limit, place[r, i], off[r, i], dt)
            elif one[MODE] == FOLLOW:
                _follow(one, seen, front, limit, alpha[r, i], place[r, i], off[r, i], dt)
            ease = min(max((front - STOP) / SLOW, 0.0), 1.0)
            steer[0, r, i], steer[1, r, i], steer[3, r, i] = alpha[r, i], CRUISE * ease, front
            if one[MODE] == TRACK:
                steer[1, r, i] = max(1.2 * (front - STOP), 0.0)
            elif one[MODE] == AVOID:
                beside, other = seen[RIGHT], seen[FRONT_LEFT]
                if one[WAY] < 0:
                    beside, other = seen[LEFT], seen[FRONT_RIGHT]
                if other >= limit:
                    steer[3, r, i] += RELIEF
                if alpha[r, i] * one[WAY] < 0:
                    pull = alpha[r, i] * min(max((front - HELD) / (limit - HELD), 0.0), 1.0)
                    most = PULL if beside < BESIDE else UNSEEN
                    pull = min(max(pull, -most), most)
                    if beside < BESIDE:
                        pull *= min(max((beside - TIGHT) / (LOOSE - TIGHT), 0.0), 1.0)
                    steer[0, r, i] = pull
                steer[0, r, i] += one[WAY] * SHY * max(TIGHT - beside, 0.0)
            else:
                steer[1, r, i], steer[2, r, i] = _along(
                    one, seen, fresh[r, i], pose[:, r, i], alpha[r, i], dt, walls[:, i]
                )
    return after, (steer[0], steer[1], steer[2], steer[3])


@kernel
def _lean(one, seen, front, dt):  # type: ignore[no-untyped-def]
    """Which front sonar reads more: of an obstacle that comes nearer, smoothed."""
    apart = min(seen[FRONT_LEFT], 3.0) - min(seen[FRONT_RIGHT], 3.0)
    if front > NOTICED or one[LEAN] == 0:
        one[LEAN] = apart
    one[LEAN] += dt / SMOOTH * (apart - one[LEAN])


@kernel
def _begin(one, alpha, place, off):  # type: ignore[no-untyped-def]
    """Away from the smaller reading; where both are alike, the way that the path goes."""
    apart = one[LEAN] if abs(one[LEAN]) > ALIKE else alpha
    one[MODE], one[WAY] = AVOID, 1.0 if apart >= 0 else -1.0
    one[FREE] = one[STALLED] = 0.0
    one[BEST], one[NET] = place, place - off


@kernel
def _avoid(one, seen, front, limit, place, off, dt):  # type: ignore[no-untyped-def]
    """Back to tracking, or along the wall?"""
    beside, ahead, other = seen[RIGHT], seen[FRONT_RIGHT], seen[FRONT_LEFT]
    if one[WAY] < 0:
        beside, ahead, other = seen[LEFT], other, ahead
    if other < limit and ahead > other + ANOTHER and beside >= BESIDE:
        one[WAY] = -one[WAY]  # another obstacle, on the other side
    one[FREE] = one[FREE] + dt if front >= limit and beside >= BESIDE else 0.0
    one[STALLED] += dt
    one[NET] = max(one[NET], place - off)
    if place > one[BEST] + GROWTH:
        one[BEST], one[STALLED] = place, 0.0
    if one[FREE] >= CLEAR:
        one[MODE] = TRACK
    elif one[STALLED] > STALL:
        one[MODE] = FOLLOW
        one[ALONG] = one[TURNED] = one[WALL] = 0.0


@kernel
def _follow(one, seen, front, limit, alpha, place, off, dt):  # type: ignore[no-untyped-def]
    """Off the wall, or round the other way?"""
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


@kernel
def _along(one, seen, fresh, pose, alpha, dt, wall):  # type: ignore[no-untyped-def]
    """v [m/s] and ω [rad/s] along the wall, which is on the right if the way round is to the left."""
    way = one[WAY]
    front = min(seen[FRONT_LEFT], seen[FRONT_RIGHT])
    ahead, beside = (seen[FRONT_RIGHT], seen[RIGHT]) if way > 0 else (seen[FRONT_LEFT], seen[LEFT])
    _remember(one, fresh, pose, wall)
    speed = 0.25 * min(max((front - STOP) / 0.2, 0.0), 1.0)
    if front < BLOCKED:
        one[WALL], one[TURNED] = 1.0, 0.0
        return speed * 0.5, way * 1.5
    if one[WALL] == 0:  # find one first
        if beside < BESIDE or ahead < 0.4:
            one[WALL] = 1.0
        return speed, min(max(2.0 * alpha, -1.5), 1.5)
    if ahead < SEEN:
        one[TURNED] = 0.0
        edge = (DISTANCE + wall[SET_BACK]) / wall[SLANT]
        away = 4.0 * (edge - ahead) + 3.0 * max(DISTANCE - min(beside, BESIDE), -0.2)
        return speed, way * min(max(away, -1.0), 1.5)
    if beside < BESIDE:
        one[TURNED] = 0.0
        away = 2.0 * (DISTANCE - beside) - 0.2 + 8.0 * max(0.14 - beside, 0.0)
        return speed, way * min(max(away, -0.6), 1.0)
    # Round its end: a circle about where it was seen last
    dx, dy = one[WALL_X] - pose[0], one[WALL_Y] - pose[1]
    distance = max(np.sqrt(dx * dx + dy * dy), 0.1)
    bearing = -way * wrapped_compiled(np.arctan2(dy, dx) - pose[2])  # from ahead, to the wall's side
    wanted = np.pi / 2 + min(max(3.0 * (CORNER - distance), -0.6), 0.6)
    turn = min(max(2.5 * (bearing - wanted) + speed * np.sin(bearing) / distance, -1.5), 1.5)
    one[TURNED] += turn * dt
    if one[TURNED] > 8.0:
        one[WALL] = one[TURNED] = 0.0
    return speed, -way * turn


@kernel
def _remember(one, fresh, pose, wall):  # type: ignore[no-untyped-def]
    """Where the wall is: beside the robot, or else at the outer edge of the front cone, where it is lost first."""
    way = one[WAY]
    ahead, beside = (fresh[FRONT_RIGHT], fresh[RIGHT]) if way > 0 else (fresh[FRONT_LEFT], fresh[LEFT])
    if beside < BESIDE:
        x, y = 0.0, wall[SIDE_Y] + beside
    elif ahead < SEEN:
        x, y = wall[FRONT_X] + ahead * np.cos(wall[EDGE]), wall[FRONT_Y] + ahead * np.sin(wall[EDGE])
    else:
        return
    c, s = np.cos(pose[2]), np.sin(pose[2])
    one[WALL_X], one[WALL_Y] = pose[0] + c * x + s * way * y, pose[1] + s * x - c * way * y
