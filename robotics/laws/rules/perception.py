"""What one robot knows in a period, in compiled code: the quantities of :mod:`robotics.laws.rules.quantities`.

What it measures, hears and remembers is put into the terms of that table. What it remembers and knows before the start
are the rows of :mod:`robotics.laws.rules.situation`; what it finds out in a period stands in :class:`PerceivedColumns`
and, for each other robot, in :class:`OtherColumns`. The tests hold a form on arrays against it, formula by formula.
"""

import math
from typing import Any

import numpy as np

from fuzzy.compiled.columns import Columns, codes, column, several, within
from fuzzy.compiled.jit import compiled_only
from robotics.laws.avoidance.echoes import ROBOT_ECHO, is_echo
from robotics.laws.avoidance.priority import WhereaboutsColumns
from robotics.laws.equation import AimColumns, HeardColumns
from robotics.laws.knowledge import share_of
from robotics.laws.rules.clearances import (
    BEAM,
    LOOKED_PAST,
    MARKED,
    NARROW,
    NEARBY,
    REMEMBERED,
    RISE,
    SECTOR,
    SEEN_LEFT,
    SEEN_RIGHT,
    WORTH_A_MARK,
)
from robotics.laws.rules.meetings import CELL, goes_first, next_meeting, off_the_way
from robotics.laws.rules.of_reference import LATER
from robotics.laws.rules.quantities import CRUISE, NUMBERED, RULE_QUANTITIES
from robotics.laws.rules.situation import (
    ACCELERATING,
    AHEAD_SEEN,
    BACK_TO_PATH,
    BESIDE,
    BEST_GROWTH,
    CORRIDOR,
    EXPECTATION_LOSS,
    FARTHEST,
    LONGEST_WAY_BACK,
    LOOK_ALONG_PATH,
    MARK_COUNT,
    NEAR_END,
    NOTHING_NEAR,
    NOTICED,
    ON_PLAN,
    ONWARD,
    QUICK,
    SIDE_TIME,
    SLOW,
    SMOOTH_TIME,
    SMOOTHING,
    STANDS,
    STUCK_PATIENCE,
    SWING,
    SWINGING,
    SightColumns,
    TeamColumns,
)
from robotics.laws.teams.neighbours import reach
from robotics.world.paths.posture import wrapped_compiled
from robotics.world.paths.road import at, moving, nearest, planned, share
from robotics.world.paths.road import place as place_at
from robotics.world.paths.road import stretch as stretch_at
from robotics.world.radio.channel import predicted

# Every quantity has a number: those of the robot itself, those of each other robot, of a later time, of one robot by
# its number, and the range sensors
_PAIRS = tuple(name for name, q in RULE_QUANTITIES.items() if q.pair)
_OWN = tuple(name for name in RULE_QUANTITIES if name not in _PAIRS)
KNOWN, TOLD = codes(_OWN), codes(_PAIRS)
PLACES = (*_OWN, *_PAIRS, *LATER, *(f"robotN_{name}" for name in NUMBERED), "range:NAME")
FIRST_PAIR, FIRST_LATER = len(_OWN), len(_OWN) + len(_PAIRS)
FIRST_NUMBERED = FIRST_LATER + len(LATER)
FIRST_READING = FIRST_NUMBERED + len(NUMBERED)
# What is computed only where a rule base asks for some of it
OF_TARGET = ("distance", "alpha", "x_err", "y_err", "heading_err", "x_err_smooth", "y_err_smooth", "heading_err_smooth")
OF_PATH = ("cross_track",)
OF_ONWARDS = ("path_bearing", "path_away")
OF_FORMATION = ("leader_ahead", "stretch", "onward_bearing")
OF_MEETING = ("meeting", "their_meeting", "lead")
ALONG = int(np.ceil(LOOK_ALONG_PATH / CELL))


class TeamMessage(Columns):
    """What every robot broadcasts."""

    place = column("m", "the abscissa of its nearest point")
    speed = column("m/s", "the rate of that")
    clock = column("s", "its copy of the clock")
    pace = column("1", "of that clock")
    where = within(WhereaboutsColumns)
    yields = column("1", "how much it gives way")
    stuck = column("s", "without progress")


class FuzzyTeamHeard(HeardColumns):
    """What one robot has heard of another."""

    said = within(TeamMessage)


class OtherColumns(Columns):
    """Another robot as its messages predict it for now; not-a-number: never heard."""

    counts = column("", "1: it is heard, and has been")
    dx = column("m", "from the robot, in the world's axes")
    dy = column("m")
    distance = column("m", "between the centers")
    ahead = column("m")
    left = column("m")
    v_x = column("m/s")
    v_y = column("m/s")
    speed = column("m/s")
    gap = column("m")
    bearing = column("rad")
    closing = column("m/s")
    place = column("m")
    age = column("s", "not-a-number: it is not heard")
    due = column("m", "where it should be by the robot's copy of the clock")
    told = several(len(_PAIRS), "", "the quantities of pairs")


class PerceivedColumns(Columns):
    """What a robot finds out in a period."""

    known = several(len(_OWN), "", "the quantities of the robot itself")
    due = within(AimColumns)  # the sample due by the robot's copy of the clock
    target = within(AimColumns)  # the same some seconds ahead: what the robot tracks
    place = column("m", "the abscissa of the path's nearest point")
    off = column("m", "from the path")
    cos = column("1", "of the heading")
    sin = column("1")
    nearing = column("m", "how much nearer something has come within the last second")
    slow = column("m", "the least room, smoothed over SLOW")
    lean = column("m", "smoothed, > 0: more room on the left")
    driven = column("m", "within the last second")
    best = column("m", "the largest place, less the way back to the path")
    clear = several(len(SECTOR), "m", "the clearances")
    echoes = several(len(SECTOR), "m", "by what sensors read now, robots included")


class WantedColumns(Columns):
    """What rule bases ask for that is computed only then, 1 each; and where things stand in the work."""

    target = column("")
    path = column("")
    onwards = column("")
    formation = column("")
    meeting = column("")
    ahead = column("s", "from the sample due to the target")
    smoothing = column("1", "of a new error in the smoothed one")
    readings = column("", "where (sensors,) and behind them the others' places (robots,) and OtherColumns begin")


_OTHER, _SIGHT = OtherColumns.size, SightColumns.size


# Before the start --------------------------------------------------------------------------------------------------


def asking(names: set[str], period: float, readings: int, ahead: float = 0.0) -> dict[str, float]:
    """The numbers of :class:`WantedColumns` where rule bases ask for quantities of these ``names``."""
    groups = {
        "target": OF_TARGET,
        "path": OF_PATH,
        "onwards": OF_ONWARDS,
        "formation": OF_FORMATION,
        "meeting": OF_MEETING,
    }
    asked = {group: float(bool(names & {*of})) for group, of in groups.items()}
    return asked | {"ahead": ahead, "smoothing": share_of(SMOOTH_TIME, period), "readings": readings}


# In a period -------------------------------------------------------------------------------------------------------


@compiled_only(forceinline=True)
def perceive(robot, memory, asks, known, i, table, now, rest):  # type: ignore[no-untyped-def]
    """Find out all that the robot knows in this period, its target being the reference at a time by its clock.

    Args:
        robot: RobotColumns.
        memory: RecallColumns, of which nothing is changed but the marks.
        asks: WantedColumns.
        known: What the law knows; the message is TeamMessage.
        i: The lane.
        table: What the team knows before the start.
        now: Where it is written, PerceivedColumns.
        rest: Likewise what is told of the sensors and of the others.
    """
    look_up(memory, asks, known, i, table, now)
    find_out(robot, memory, asks, known, i, table, now, rest)


@compiled_only(forceinline=True)
def look_up(memory, asks, known, i, table, now):  # type: ignore[no-untyped-def]
    """What is due by the robot's clock, and its target; the first part of :func:`perceive`."""
    road, path, due, target, end = known.road, known.path[i], now.due, now.target, TeamColumns(table).end
    due.x, due.y, due.heading, due.v, due.w, due.s = moving(road, path, min(memory.clock, end))
    if asks.ahead > 0:
        later = min(memory.clock + asks.ahead, end)
        target.x, target.y, target.heading, target.v, target.w, target.s = moving(road, path, later)
    else:
        target.x, target.y, target.heading = due.x, due.y, due.heading
        target.v, target.w, target.s = due.v, due.w, due.s


@compiled_only(forceinline=True)
def find_out(robot, memory, asks, known, i, table, now, rest):  # type: ignore[no-untyped-def]
    """Find out all that the robot knows, where it is told what is due and its target; the rest of :func:`perceive`."""
    now.cos, now.sin = math.cos(robot.heading), math.sin(robot.heading)
    head = TeamColumns(table)
    _on_the_path(robot, memory, asks, known, i, head, now)
    _others(robot, memory, known, i, head, table, now, rest[int(asks.readings) :])
    if asks.meeting == 1:
        _meetings(robot, known, i, head, table, now, rest[int(asks.readings) :])
    _room(robot, memory, known, i, head, table, now, rest[int(asks.readings) :])
    _aside(robot, memory, known.dt, now)
    if asks.target == 1:
        _target(robot, memory, asks, now)
    if asks.formation == 1:
        know_formation(robot, known, i, head, table, now, rest[int(asks.readings) :])
    _tell_more(robot, memory, known, i, now)


@compiled_only
def other_of(rest, head, robots, j):  # type: ignore[no-untyped-def]
    """What is found out of robot ``j``; ``rest`` begins with the readings."""
    return OtherColumns(rest, int(head.sensors) + robots + j * _OTHER)


@compiled_only(forceinline=True)
def _on_the_path(robot, memory, asks, known, i, head, now):  # type: ignore[no-untyped-def]
    road, path, due, told, planned_too = known.road, known.path[i], now.due, now.known, head.planned == 1
    place = nearest(road, path, robot.x, robot.y, memory.place, reach(known.heard, i, known.time))
    x, y, heading, curvature = at(road, path, place)
    off, length = math.hypot(x - robot.x, y - robot.y), road.lengths[path]
    net, remaining = place - off, length - place + off
    expected = memory.best - (EXPECTATION_LOSS * known.dt if memory.stuck > STUCK_PATIENCE else 0.0)
    now.best = net if net > memory.best + BEST_GROWTH else expected
    waits = memory.yields > 0.5 or remaining < NEAR_END or due.s < net + (ON_PLAN if planned_too else 0.0)
    stuck = memory.stuck + (0.0 if waits else known.dt)
    now.place, now.off = place, off
    told[KNOWN.time], told[KNOWN.v], told[KNOWN.w] = known.time, robot.v, robot.w
    told[KNOWN.v_command], told[KNOWN.w_command] = memory.v_command, memory.w_command
    told[KNOWN.target_v], told[KNOWN.target_w] = now.target.v, now.target.w
    if asks.path == 1:
        told[KNOWN.cross_track] = math.cos(heading) * (robot.y - y) - math.sin(heading) * (robot.x - x)
    told[KNOWN.curvature], told[KNOWN.progress] = curvature, share(road, path, place)
    told[KNOWN.remaining], told[KNOWN.lag] = remaining, due.s - place
    told[KNOWN.late], told[KNOWN.gives_way] = known.time - memory.clock, memory.yields
    told[KNOWN.stuck] = 0.0 if now.best > memory.best else stuck
    if asks.onwards == 1:
        x, y, _, _ = at(road, path, min(place + BACK_TO_PATH, length))
        bearing = wrapped_compiled(math.atan2(y - robot.y, x - robot.x) - robot.heading)
        told[KNOWN.path_bearing] = bearing
        told[KNOWN.path_away] = bearing if memory.side >= 0 else -bearing


@compiled_only(forceinline=True)
def _target(robot, memory, asks, now):  # type: ignore[no-untyped-def]
    """The target as the robot sees it (5.9), and smoothed."""
    told, target = now.known, now.target
    dx, dy = target.x - robot.x, target.y - robot.y
    x, y = now.cos * dx + now.sin * dy, now.cos * dy - now.sin * dx
    heading = wrapped_compiled(target.heading - robot.heading)
    if math.isnan(memory.x_err):
        memory.x_err, memory.y_err, memory.heading_err = x, y, heading
    else:
        memory.x_err += asks.smoothing * (x - memory.x_err)
        memory.y_err += asks.smoothing * (y - memory.y_err)
        memory.heading_err += asks.smoothing * wrapped_compiled(heading - memory.heading_err)
    told[KNOWN.distance], told[KNOWN.alpha] = math.hypot(x, y), math.atan2(y, x)
    told[KNOWN.x_err], told[KNOWN.y_err], told[KNOWN.heading_err] = x, y, heading
    told[KNOWN.x_err_smooth], told[KNOWN.y_err_smooth] = memory.x_err, memory.y_err
    told[KNOWN.heading_err_smooth] = memory.heading_err


@compiled_only(forceinline=True)
def _others(robot, memory, known, i, head, table, now, rest):  # type: ignore[no-untyped-def]
    """The other robots as their messages predict them for now, and who of each two goes first."""
    road, robots, radii, plans = known.road, known.heard.shape[2], int(head.radii), head.planned == 1
    number, level = i % robots, share(known.road, known.path[i], now.due.s)
    v_x, v_y = robot.v * now.cos, robot.v * now.sin
    for j in range(robots):
        heard, other, path = (
            FuzzyTeamHeard(known.heard, i, j),
            other_of(rest, head, robots, j),
            known.path[i] - number + j,
        )
        said, where = heard.said, heard.said.where
        hears = heard.hears > 0
        dx, dy = predicted(where.x, where.v_x, heard.age) - robot.x, predicted(where.y, where.v_y, heard.age) - robot.y
        other.counts = 1.0 if hears and not math.isnan(dx + dy) else 0.0
        other.told[TOLD.age], other.told[TOLD.their_lag] = min(heard.age, NOTHING_NEAR), 0.0
        if other.counts == 0:
            _unknown(other)
            continue
        distance, ahead, left = math.hypot(dx, dy), now.cos * dx + now.sin * dy, now.cos * dy - now.sin * dx
        other.dx, other.dy, other.ahead, other.left, other.distance = dx, dy, ahead, left, distance
        other.v_x, other.v_y, other.age = where.v_x, where.v_y, heard.age
        other.speed = math.hypot(where.v_x, where.v_y)
        other.gap = distance - table[radii + number] - table[radii + j]
        other.bearing = wrapped_compiled(math.atan2(dy, dx) - robot.heading)
        other.closing = (dx * (v_x - where.v_x) + dy * (v_y - where.v_y)) / max(distance, 1e-6)
        other.place = predicted(said.place, said.speed, heard.age)
        if plans:
            due, _ = planned(road, path, memory.clock)
            other.due = due * road.lengths[path]
        else:
            other.due = place_at(road, path, level)
        told = other.told
        told[TOLD.gap], told[TOLD.bearing], told[TOLD.closing] = other.gap, other.bearing, other.closing
        told[TOLD.their_lag] = other.due - other.place
        told[TOLD.their_yield], told[TOLD.their_stuck] = said.yields, said.stuck
        told[TOLD.right_of_way] = _goes_first(head, table, robots, now.place, other.place, number, j)


@compiled_only
def _unknown(other):  # type: ignore[no-untyped-def]
    """Nothing is known of another robot."""
    other.ahead, other.left, other.speed, other.gap = np.nan, np.nan, np.nan, np.nan
    other.bearing, other.closing, other.place = np.nan, np.nan, np.nan


@compiled_only(forceinline=True)
def _goes_first(head, table, robots, place, other, i, j):  # type: ignore[no-untyped-def]
    """1 where robot i goes before j, -1 where j does: by the plan, the ends of the paths, or their numbers."""
    first = int(head.first)
    if head.planned == 1:
        last, peaks = table[int(head.last) : int(head.peaks)], table[int(head.peaks) : int(head.points)]
        order = goes_first(last, peaks, table[int(head.reached) : int(head.sights)], robots, place, other, i, j)
        if order != 0:
            return order
    demanded = table[first + i * robots + j] - table[first + j * robots + i]
    return demanded if demanded != 0 else 1.0 if j > i else -1.0


@compiled_only(forceinline=True)
def _meetings(robot, known, i, head, table, now, rest):  # type: ignore[no-untyped-def]
    """Where the robot's path meets that of each other next. One that is parked is met nowhere."""
    robots, begin, number = known.heard.shape[2], int(head.sensors), i % known.heard.shape[2]
    last, peaks = table[int(head.last) : int(head.peaks)], table[int(head.peaks) : int(head.points)]
    places, room = rest[begin : begin + robots], 2 * table[int(head.radii) + number]
    for j in range(robots):
        other, length = other_of(rest, head, robots, j), known.road.lengths[known.path[i] - number + j]
        places[j] = np.nan if other.place > length - NEAR_END else other.place
    mine = max(abs(robot.v), CRUISE)
    for j in range(robots):
        other = other_of(rest, head, robots, j)
        if other.counts == 1:
            way, through, theirs = next_meeting(last, peaks, now.place, places, room, number, j)
            lead = theirs / max(other.speed, CRUISE) - (max(way, 0.0) + through) / mine
            other.told[TOLD.meeting], other.told[TOLD.their_meeting] = way, theirs
            other.told[TOLD.lead] = min(max(lead, -NOTHING_NEAR), NOTHING_NEAR)


@compiled_only(forceinline=True)
def _room(robot, memory, known, i, head, table, now, rest):  # type: ignore[no-untyped-def]
    """The clearance in each sector [m]; infinite: nothing is seen. What was seen is remembered."""
    clear, robots, dt = now.clear, known.heard.shape[2], known.dt
    number = i % robots
    radius = table[int(head.radii) + number]
    for sector in range(len(SECTOR)):
        clear[sector], now.echoes[sector] = np.inf, np.inf
    if head.sensors > 0:
        sees = _look(robot, known, i, head, table, now, rest)
        _renew_marks(robot, memory, dt, number, radius, sees, head, table, now, rest)
        for k in range(MARK_COUNT):
            if memory.mark_age[k] < np.inf:
                ahead, left = _in_own_frame(now, memory.mark_x[k] - robot.x, memory.mark_y[k] - robot.y)
                _stands(clear, math.hypot(ahead, left) - radius, math.atan2(left, ahead))
    points = int(head.points) + number * int(head.cells) * 2
    for j in range(robots):
        other = other_of(rest, head, robots, j)
        if not other.speed < STANDS or (head.planned == 1 and not abs(other.due - other.place) > ON_PLAN):
            continue  # one that stands where a plan has it stand is in nobody's way
        way = table[points : points + int(head.cells) * 2]
        off = off_the_way(way, now.place, robot.x + other.dx, robot.y + other.dy, ALONG)
        if off < radius + table[int(head.radii) + j] + CORRIDOR:
            _stands(clear, other.gap, other.bearing)
    for sector in range(len(SECTOR)):
        clear[sector] = min(clear[sector], memory.clear[sector] + RISE[sector] * dt)


@compiled_only
def _in_own_frame(now, dx, dy):  # type: ignore[no-untyped-def]
    return now.cos * dx + now.sin * dy, now.cos * dy - now.sin * dx


@compiled_only
def _stands(clear, gap, bearing):  # type: ignore[no-untyped-def]
    """Take something into account that stands so far away [m], in a direction [rad]."""
    for sector in range(len(SEEN_LEFT)):
        if SEEN_LEFT[sector] < bearing < SEEN_RIGHT[sector]:
            clear[sector] = min(clear[sector], max(gap, 0.0))


@compiled_only(forceinline=True)
def _look(robot, known, i, head, table, now, rest):  # type: ignore[no-untyped-def]
    """Read the sensors, into ``rest`` without the robots that are in nobody's way; return whether one sees a thing."""
    sees = False
    robots, sensors = known.heard.shape[2], int(head.sensors)
    number, begin, radii = i % robots, int(head.sights), int(head.radii)
    for q in range(sensors):
        value = known.ranges[q, i]
        rest[q] = value
        if not value < np.inf:
            continue
        sight = SightColumns(table, begin + (number * sensors + q) * _SIGHT)
        room = -np.inf if value <= sight.minimum else value - sight.inner
        for sector in range(len(SECTOR)):
            if sight.sector[sector] == 1:
                now.echoes[sector] = min(now.echoes[sector], room)
        for j in range(robots):
            other, radius = other_of(rest, head, robots, j), table[radii + j]
            if other.counts == 0:
                continue
            far = math.hypot(other.ahead, other.left) > table[radii + number] + radius + NEARBY
            unsure = (other.speed + ACCELERATING * other.age) * other.age
            if (other.speed > STANDS or far) and is_echo(
                value, sight.x, sight.y, sight.axis, sight.half_cone, other.ahead, other.left, radius,
                max(ROBOT_ECHO, radius), unsure,
            ):  # fmt: skip
                rest[q] = np.inf
                break
        sees |= rest[q] < np.inf
        for sector in range(len(SECTOR)):
            if sight.sector[sector] == 1:
                now.clear[sector] = min(now.clear[sector], max(rest[q] - sight.inner, 0.0))
    return sees


@compiled_only(forceinline=True)
def _renew_marks(robot, memory, dt, number, radius, sees, head, table, now, rest):  # type: ignore[no-untyped-def]
    """Remember where the nearest thing in each sector was seen, until it is looked past or forgotten."""
    sensors, begin = int(head.sensors), int(head.sights)
    for k in range(MARK_COUNT):
        age, limit, nearest_q = memory.mark_age[k], WORTH_A_MARK, -1
        if age < np.inf:
            ahead, left = _in_own_frame(now, memory.mark_x[k] - robot.x, memory.mark_y[k] - robot.y)
            gone = age > REMEMBERED
            for q in range(sensors):
                sight = SightColumns(table, begin + (number * sensors + q) * _SIGHT)
                if not gone and sight.half_cone <= BEAM and rest[q] < np.inf:
                    dx, dy = ahead - sight.x, left - sight.y
                    aside = abs(wrapped_compiled(math.atan2(dy, dx) - sight.axis))
                    gone = aside <= BEAM and rest[q] > math.hypot(dx, dy) + LOOKED_PAST
            if gone:
                memory.mark_age[k] = np.inf
            else:
                memory.mark_age[k] = age + dt
                limit = min(math.hypot(ahead, left) - radius, WORTH_A_MARK)
        for q in range(sensors if sees else 0):
            sight = SightColumns(table, begin + (number * sensors + q) * _SIGHT)
            if sight.sector[MARKED[k]] == 1 and sight.half_cone <= NARROW and rest[q] - sight.inner < limit:
                limit, nearest_q = rest[q] - sight.inner, q
        if nearest_q >= 0:
            sight = SightColumns(table, begin + (number * sensors + nearest_q) * _SIGHT)
            x, y = sight.x + rest[nearest_q] * math.cos(sight.axis), sight.y + rest[nearest_q] * math.sin(sight.axis)
            memory.mark_x[k] = robot.x + now.cos * x - now.sin * y
            memory.mark_y[k] = robot.y + now.sin * x + now.cos * y
            memory.mark_age[k] = 0.0


@compiled_only(forceinline=True)
def _aside(robot, memory, dt, now):  # type: ignore[no-untyped-def]
    """What is told of the room around the robot."""
    clear, told, kept_left = now.clear, now.known, memory.side >= 0
    front_left, front_right = clear[SECTOR.front_left], clear[SECTOR.front_right]
    left, right, behind = clear[SECTOR.left], clear[SECTOR.right], clear[SECTOR.behind]
    wall, beyond = (right, left) if kept_left else (left, right)
    front_wall, front_open = (front_right, front_left) if kept_left else (front_left, front_right)
    told[KNOWN.front] = min(min(front_left, front_right), NOTHING_NEAR)
    told[KNOWN.front_left], told[KNOWN.front_right] = min(front_left, NOTHING_NEAR), min(front_right, NOTHING_NEAR)
    told[KNOWN.left], told[KNOWN.right] = min(left, NOTHING_NEAR), min(right, NOTHING_NEAR)
    told[KNOWN.behind], told[KNOWN.kept] = min(behind, NOTHING_NEAR), abs(memory.side)
    told[KNOWN.wall], told[KNOWN.beyond] = min(wall, NOTHING_NEAR), min(beyond, NOTHING_NEAR)
    told[KNOWN.front_wall], told[KNOWN.front_open] = min(front_wall, NOTHING_NEAR), min(front_open, NOTHING_NEAR)
    front_left, front_right = min(front_left, FARTHEST), min(front_right, FARTHEST)
    lean = front_left - front_right
    if min(front_left, front_right) < NOTICED and memory.lean != 0:
        lean = memory.lean + dt / SMOOTHING * (lean - memory.lean)
    now.lean = lean
    told[KNOWN.lean] = lean if kept_left else -lean
    sees = wall < BESIDE or front_wall < AHEAD_SEEN or memory.side == 0
    told[KNOWN.lost] = 0.0 if sees else memory.lost + dt
    back = memory.way_back + dt * (robot.v - SWING * abs(robot.w))
    told[KNOWN.way_back] = min(max(back, 0.0), LONGEST_WAY_BACK)
    least = min(min(min(min(front_left, front_right), left), right), behind)
    least = min(least, FARTHEST)
    room = memory.fast + dt / QUICK * (least - memory.fast)
    now.slow = memory.slow + dt / SLOW * (least - memory.slow)
    now.nearing = now.slow - room
    rate = abs(robot.v) + SWINGING * abs(robot.w)
    now.driven = memory.driven + dt / SLOW * (SLOW * rate - memory.driven)
    told[KNOWN.room], told[KNOWN.coming] = room, now.nearing - now.driven


@compiled_only(forceinline=True)
def know_formation(robot, known, i, head, table, now, rest):  # type: ignore[no-untyped-def]
    """Where the robot is among those of a formation."""
    road, path, told, robots = known.road, known.path[i], now.known, known.heard.shape[2]
    leader, number, begin = path - i % robots, i % robots, table[int(head.begin) :]
    told[KNOWN.onward_bearing] = onward_bearing(road, path, robot, now.place)
    told[KNOWN.leader_ahead], told[KNOWN.stretch] = 0.0, stretched(road, leader, number, now.place, begin)
    if robots == 1:
        return
    if number > 0:
        ahead = other_of(rest, head, robots, 0).place - on_leader(road, leader, number, now.place, begin)
        told[KNOWN.leader_ahead] = 0.0 if math.isnan(ahead) else ahead
        return
    total, heard = 0.0, 0
    for j in range(1, robots):
        other = other_of(rest, head, robots, j)
        if not math.isnan(other.place):
            total += on_leader(road, leader, j, other.place, begin)
            heard += 1
    told[KNOWN.leader_ahead] = now.place - total / heard if heard > 0 else 0.0


@compiled_only
def onward_bearing(road, path, robot, place):  # type: ignore[no-untyped-def]
    """The bearing [rad] of the path's point ONWARD beyond ``place`` [m]; beyond its end the path goes on in an arc."""
    s = place + ONWARD
    x, y, heading, curvature = at(road, path, s)
    beyond = max(s - road.lengths[path], 0.0)
    half = curvature * beyond / 2
    chord = beyond * (math.sin(half) / half if half != 0 else 1.0)
    x, y = x + chord * math.cos(heading + half), y + chord * math.sin(heading + half)
    return wrapped_compiled(math.atan2(y - robot.y, x - robot.x) - robot.heading)


@compiled_only
def stretched(road, leader, number, s, begin):  # type: ignore[no-untyped-def]
    """The way on a robot's path for each metre of the leader's, at ``s`` [m]; arguments as of :func:`on_leader`."""
    path = leader + number
    if number == 0:
        return 1.0
    if road.shares.shape[1] > 0:
        progress = share(road, path, s)
        return stretch_at(road, path, progress) / stretch_at(road, leader, progress)
    return (road.lengths[path] - begin[number]) / (road.lengths[leader] - begin[0])


@compiled_only
def on_leader(road, leader, number, s, begin):  # type: ignore[no-untyped-def]
    """The abscissa [m] on the leader's path that is level with a robot at ``s`` [m] of its own.

    Args:
        road: The paths.
        leader: The leader's path.
        number: The robot's number from 0.
        s: Its abscissa [m].
        begin: Where the references begin (robots,) [m].
    """
    if road.shares.shape[1] > 0:
        return place_at(road, leader, share(road, leader + number, s))
    return _level(s, begin[number], road.lengths[leader + number], begin[0], road.lengths[leader])


@compiled_only
def level_with_leader(road, leader, number, s, begin):  # type: ignore[no-untyped-def]
    """The abscissa [m] of a robot that is level with the leader at ``s`` [m]; arguments as of :func:`on_leader`."""
    if road.shares.shape[1] > 0:
        return place_at(road, leader + number, share(road, leader, s))
    return _level(s, begin[0], road.lengths[leader], begin[number], road.lengths[leader + number])


@compiled_only
def _level(s, begin, length, other_begin, other_length):  # type: ignore[no-untyped-def]
    return other_begin + (s - begin) / (length - begin) * (other_length - other_begin)


@compiled_only(forceinline=True)
def remember(memory, known, i, now, pace, keep, yields, v, w):  # type: ignore[no-untyped-def]
    """Remember this period; the copies of the clock agree on the slowest.

    Args:
        memory: RecallColumns.
        known: What the law knows.
        i: The lane.
        now: PerceivedColumns.
        pace: The rate of the robot's copy of the clock.
        keep: The side of an obstacle to keep: 1 this one, -1 the other, 0 none.
        yields: How much it gives way.
        v: The command [m/s].
        w: Likewise [rad/s].
    """
    clock = memory.clock + known.dt * pace
    for j in range(known.heard.shape[2]):
        heard = FuzzyTeamHeard(known.heard, i, j)
        if heard.hears > 0:
            theirs = predicted(heard.said.clock, heard.said.pace, heard.age) + known.dt * max(heard.said.pace, 1.0)
            if theirs < clock:  # false where nothing was heard yet
                clock = theirs
    told, side = now.known, keep if memory.side >= 0 else -keep
    memory.clock, memory.place, memory.best, memory.stuck = clock, now.place, now.best, told[KNOWN.stuck]
    memory.side += known.dt / SIDE_TIME * (side - memory.side)
    for sector in range(len(SECTOR)):
        memory.clear[sector] = now.clear[sector]
    memory.yields, memory.way_back, memory.lost = yields, told[KNOWN.way_back], told[KNOWN.lost]
    memory.driven, memory.fast, memory.slow, memory.lean = now.driven, told[KNOWN.room], now.slow, now.lean
    memory.v_command, memory.w_command = v, w


@compiled_only(forceinline=True)
def tell(say, robot, memory, now, dt, pace, yields):  # type: ignore[no-untyped-def]
    """Write the message of this period, before it is remembered."""
    say.place, say.speed, say.clock, say.pace = now.place, (now.place - memory.place) / dt, memory.clock, pace
    say.where.x, say.where.y = robot.x, robot.y
    say.where.v_x, say.where.v_y = robot.v * now.cos, robot.v * now.sin
    say.yields, say.stuck = yields, now.known[KNOWN.stuck]


# Of other packages -------------------------------------------------------------------------------------------------


@compiled_only
def _nothing_more(robot, memory, known, i, now):  # type: ignore[no-untyped-def]
    """Tell no other quantity."""


def _and_then(before: Any, place: int, of: Any) -> Any:
    """Tell what ``before`` does, and the quantity of the number ``place``."""

    @compiled_only
    def tell_more(robot, memory, known, i, now):  # type: ignore[no-untyped-def]
        before(robot, memory, known, i, now)
        now.known[place] = of(robot, memory, known, i, now)

    return tell_more


_tell_more = _nothing_more
for _name in _OWN:
    if RULE_QUANTITIES[_name].of is not None:
        _tell_more = _and_then(_tell_more, getattr(KNOWN, _name), RULE_QUANTITIES[_name].of)
