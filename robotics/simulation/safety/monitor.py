"""The monitor: no order reaches the wheels from which the robot could not stop on ground that is known to be free.

In every period the way is foreseen that a robot goes if the order acts for one period, after those that are still on
their way to the wheels, and from then on it is told to stop. Along all of that way its body must keep clear of what is
not known to be free (:mod:`robotics.simulation.safety.ground`), and of wherever robots that were heard may be by then
(:mod:`robotics.simulation.safety.others`). If it does not, less is tried: the same arc more slowly, turning on the
spot, and last a stop, of which the period before has made sure.

    stop:  x(t) = x + ∫ v(t), v' = -min(v/lag, braking) from t + T + L on     [Mitsch et al. 2017], passive safety, with
           the wheels' lag, the latency L and the period T of this plant in the place of A, b and ε
"""

import math
from typing import NamedTuple

from fuzzy.compiled.columns import Floats2, Floats3, Ints1, Ints2, Ints3
from fuzzy.compiled.jit import compiled_only, without_refcounts
from robotics.laws.equation import CommandColumns, SeenColumns
from robotics.simulation.safety.assumptions import AT_REST, CREEPS
from robotics.simulation.safety.ground import (
    GuardColumns,
    find_barred,
    find_free,
    follow,
    is_clear,
    set_free,
    stand_free,
    take_in,
)
from robotics.simulation.safety.others import (
    CREEP,
    REACH,
    SLACK,
    SPEED_SPARE,
    TURNS,
    PostureMessage,
    PromiseColumns,
    highest,
    is_a_robot,
    kept_promise,
    room_to_robots,
    spare_share,
)
from robotics.world.radio.channel import Air, broadcast, receive
from robotics.world.sensing.raycasting import SensorColumns
from robotics.world.vehicle.plant import STEP, TruthColumns, within_limits

ACTS, ACTS_TURN = 0.01, 0.2  # m/s, rad/s: what the monitor takes off less than this is not said
SLOWED = (1.0, 0.7, 0.45, 0.25, 0.12)  # of an order, along the same arc
SPOT = (1.0, 0.3)  # of its turn rate, on the spot; of its speed, straight on
BACK = 0.1  # of its highest speed: how fast it goes back where it cannot turn
BACKS_AT_FIRST = 3.0  # s: who has backed for longer lately does not see from there what bars its way;
BACKS_MORE = 0.05  # m in each second beyond that: so much more room it wants ahead,
BACKS_FOR = 1.0  # of its turning circle at most,
FORGETS = 0.1  # and less by so much in each second in which it does not back
FALLBACKS = len(SLOWED) + 2 * len(SPOT) + 1
CREEPING = 3  # more among what moves: along the arc, on the spot and back, so slowly that it stands
AWAY = 0.5  # of its way: so much farther is a robot that moves from what may touch it
NO_BARRIER, BY_GROUND, BY_ROBOT = 0.0, 1.0, 2.0  # what bars a way
_LONGEST = 1000  # steps of 10 ms of a foreseen way
_NEARLY = 5e-4  # m: a robot that goes no farther than this stands
_WANTS = 1e-3  # m/s: who wants to drive no faster wants to stand
# Of its turning circle: the least gap to where another robot may be. Between two poses that are looked at lies a
# quarter of a cell, half of which is lost; the model of the stop may be short by STOP_NEAR.
_ROBOTS_APART = 0.045


class MonitorLanes(NamedTuple):
    """All that the monitor knows; a lane is one robot of one run."""

    on: int  # 1: there is one
    sees: int  # 1: there are obstacles to see
    latency: float  # s, of commands
    delay: float  # s: messages that are older say nothing
    holds: float  # s: the time of a promise
    given: Floats2  # (GuardColumns, lanes)
    ground: Ints3  # (lanes, cells, cells)
    window: Ints2  # (lanes, 2): the first cell of each window in x and in y
    barred: Ints2  # (cells, cells): of the robot that is looked at, as of find_free, and then as of find_barred
    table: Floats2  # (SensorColumns, sensors), as of robotics.world.sensing.raycasting.Eyes
    every: Ints1  # (sensors,): periods from look to look
    column: Ints1  # (sensors,): its place in the readings
    begin: Ints1  # (lanes,): the first sensor of each robot
    end: Ints1  # (lanes,): the first that is not its
    rays: Floats2  # (2, rays): unit directions in the robot's frame, as close to each other as cells
    first_ray: Ints1  # (sensors + 1,)
    sent: Floats3  # (periods, 2, lanes): orders; that of period k stands at k modulo their number
    held: (
        Floats2  # (2, lanes): the commanded velocity within the bounds of how fast it may change, as the wheels have it
    )
    promises: Floats3  # (PromiseColumns, periods, lanes)
    said: Floats2  # (PostureMessage, lanes)
    air: Air
    backed: Floats2  # (1, lanes): for how long [s] it has backed lately
    acted: Ints1  # (lanes,): periods in which it took something off an order


@without_refcounts
def keep_safe(guard, k, period, robots, truth, seen, readings, cut, going, command, order):  # type: ignore[no-untyped-def]
    """Bring the orders of period ``k`` down to what is safe.

    Args:
        guard: The monitor's.
        k: The period.
        period: Its length [s].
        robots: Of a run.
        truth: The plant's state, of which only odometry is read (TruthColumns, lanes).
        seen: What the robots know of themselves (SeenColumns, lanes).
        readings: Of the range sensors [m] (lanes, sensors).
        cut: Links that are cut (lanes, robots).
        going: (runs,): those that go on.
        command: The command, of which ``guarded`` is written (CommandColumns, lanes).
        order: What the wheels are told (2, lanes).
    """
    receive(guard.air, k, period, cut)
    for lane in range(order.shape[1]):
        if going[lane // robots] and keep_one(guard, lane, k, period, robots, truth, seen, readings, order):
            CommandColumns(command, lane).guarded = 1.0
            guard.acted[lane] += 1
    if guard.air.values > 0:
        here = TruthColumns(truth)
        broadcast(guard.air, k, period, cut, guard.said, here.x, here.y)


@without_refcounts
def keep_one(guard, lane, k, period, robots, truth, seen, readings, order):  # type: ignore[no-untyped-def]
    """Bring the order of one robot down to what is safe; return whether that takes something off it.

    What it has heard is there, and what it says stands in ``guard.said``; the other arguments are as of
    :func:`keep_safe`.
    """
    odometry, given = TruthColumns(truth, lane), GuardColumns(guard.given, lane)
    robot = SeenColumns(seen, lane).robot
    wish_v, wish_w = order[0, lane], order[1, lane]
    if not (math.isfinite(wish_v) and math.isfinite(wish_w)):
        wish_v, wish_w = 0.0, 0.0
    wish_v, wish_w = within_limits(given.limit, wish_v, wish_w)
    if guard.sees == 1:
        _look_around(guard, lane, k, robots, odometry, robot, given, readings)
    v, w = _safe(guard, lane, k, period, robots, odometry, robot, given, wish_v, wish_w)
    order[0, lane], order[1, lane] = v, w
    note_order(guard, lane, k, period, v, w)
    return abs(v - wish_v) > ACTS or abs(w - wish_w) > ACTS_TURN


@without_refcounts
def note_order(guard, lane, k, period, v, w):  # type: ignore[no-untyped-def]
    """Note the order (v, w) of period ``k``, and what the wheels have by the end of it."""
    stop = GuardColumns(guard.given, lane).stop
    for step in range(round(period / STEP)):
        to_v, to_w = in_force(guard, lane, k, period, step * STEP, v, w)
        guard.held[0, lane] = next_held(stop.v_rate, guard.held[0, lane], to_v)
        guard.held[1, lane] = next_held(stop.w_rate, guard.held[1, lane], to_w)
    slot = k % len(guard.sent)
    guard.sent[slot, 0, lane], guard.sent[slot, 1, lane] = v, w


@compiled_only
def _look_around(guard, lane, k, robots, odometry, robot, given, readings):  # type: ignore[no-untyped-def]
    """Bring what is known of the ground up to date."""
    ground, window = guard.ground[lane], guard.window[lane]
    x, y = odometry.odo_x, odometry.odo_y
    c, s = math.cos(odometry.odo_heading), math.sin(odometry.odo_heading)
    follow(ground, window, given, x, y)
    if k == 0:
        stand_free(ground, window, given, x, y, c, s, given.radius - given.half_width + given.least + 2 * given.cell)
    # A beam's echo is where it says, and the last word; of a cone's arc another sensor may know better.
    for beams, free in ((True, True), (True, False), (False, False), (False, True)):
        if free and _looks(guard, lane, k, beams):
            find_free(ground, window, guard.barred)
        for q in range(guard.begin[lane], guard.end[lane]):
            sensor, reading = SensorColumns(guard.table, q), readings[lane, guard.column[q]]
            if beams != (sensor.sin_half == 0) or k % guard.every[q] != 0:
                continue
            first, last = guard.first_ray[q], guard.first_ray[q + 1]
            if not free:
                known = robots > 1 and is_a_robot(guard, lane, robots, robot, sensor, reading)
                take_in(ground, window, given, sensor, guard.rays, first, last, reading, k + 1, known, x, y, c, s)
                continue
            if beams:  # what one beam hits may reach as far as the next one
                for p in (q - 1, q + 1):
                    if guard.begin[lane] <= p < guard.end[lane]:
                        beside = SensorColumns(guard.table, p)
                        if beside.sin_half == 0 and beside.x == sensor.x and beside.y == sensor.y:
                            reading = min(reading, readings[lane, guard.column[p]])
            set_free(ground, window, given, guard.barred, sensor, guard.rays, first, last, reading, x, y, c, s)
    stand_free(ground, window, given, x, y, c, s, 0.0)


@compiled_only
def _looks(guard, lane, k, beams):  # type: ignore[no-untyped-def]
    """Whether a sensor looks in period ``k``: a beam, or a cone."""
    for q in range(guard.begin[lane], guard.end[lane]):
        if beams == (SensorColumns(guard.table, q).sin_half == 0) and k % guard.every[q] == 0:
            return True
    return False


@compiled_only
def _safe(guard, lane, k, period, robots, odometry, robot, given, wish_v, wish_w):  # type: ignore[no-untyped-def]
    """The safe order that is nearest to what is wanted; make the promise of this period."""
    team = guard.air.values > 0
    if wish_v < -given.back:  # the same arc more slowly
        wish_w *= -given.back / wish_v
        wish_v = -given.back
    bound_v, bound_w, backwards, room = wish_v, wish_w, -given.back, math.inf
    if team:
        fastest, slowest, turn = kept_promise(guard, lane, k, period, guard.latency)
        backwards = max(backwards, slowest / given.overshoot)
        bound_v = min(max(wish_v, backwards), fastest / given.overshoot)
        bound_w = min(max(wish_w, -turn / given.overshoot), turn / given.overshoot)
        room = _room_there(guard, lane, robots, given, robot.x, robot.y, robot.heading, 0.0)
    v, w, n, bars = bound_v, bound_w, 0, NO_BARRIER
    before = (k + len(guard.sent) - 1) % len(guard.sent)
    last_v, last_w = guard.sent[before, 0, lane], guard.sent[before, 1, lane]
    stands = wish_v == 0 and wish_w == 0 and robot.v == 0 and robot.w == 0
    # Until what is wanted is clear: else it may go back and ahead by turns for ever.
    backs = last_v < 0 <= wish_v and given.others == 0
    backed = guard.backed[0, lane]
    if not stands:
        nearest = min(room, 0.0)  # m: the room to other robots, where it is less than it should be
        if guard.sees == 1:
            find_barred(guard.ground[lane], guard.window[lane], given, guard.barred, k + 1, period)
        places = FALLBACKS + (CREEPING if given.others > 0 else 0)
        while n < places:
            v, w = tried(n, bound_v, bound_w, given, backwards, bars == BY_GROUND, backs)
            v, w = bounded_behind(given, v, w, last_v, last_w, period)
            if n == 0 or abs(v) + abs(w) * given.radius > ACTS:  # to stand is last
                more = 0.0
                if backs and n == 0:
                    more = min(max(BACKS_MORE * (backed - BACKS_AT_FIRST), 0.0), BACKS_FOR * given.radius)
                bars = _barrier(guard, lane, k, period, robots, odometry, robot, given, v, w, nearest, more)
                if bars == NO_BARRIER:
                    break
            n += 1
        if n == places:
            v, w = bounded_behind(given, 0.0, 0.0, last_v, last_w, period)
    guard.backed[0, lane] = backed + period if v < 0 <= wish_v else max(backed - FORGETS * period, 0.0)
    if team:
        # Of two that block each other, the one with the lower number goes on wanting.
        gives_way = n > 0 and lane % robots > 0
        plan_v, plan_w = (v, w) if gives_way else (wish_v, wish_w)
        _make_promise(guard, lane, k, robots, robot, given, v, w, plan_v, plan_w, gives_way, fastest, slowest, turn)
    return v, w


@compiled_only
def _room_there(guard, lane, robots, given, x, y, heading, late):  # type: ignore[no-untyped-def]
    """The room [m] that a body there has to where robots may be ``late`` [s] from now; below 0: less than it should."""
    body = given.half_length, given.half_width, given.radius
    return room_to_robots(guard, lane, robots, x, y, heading, body, late, 1.0) - _ROBOTS_APART * given.radius


@compiled_only
def _make_promise(  # type: ignore[no-untyped-def]
    guard, lane, k, robots, robot, given, v, w, plan_v, plan_w, gives_way, fastest, slowest, turn
):
    """Make the promise of period ``k``, and write the message that tells it.

    It covers the order (v, w), what the robot does, what is on its way to the wheels, and what it plans to do. Where it
    grows it is no wider than those that hold are by then: ``fastest``, ``slowest`` and ``turn``.
    """
    held_v, held_w = guard.held[0, lane], guard.held[1, lane]
    ahead, back = max(plan_v, robot.v, v, held_v, 0.0), min(plan_v, robot.v, v, held_v, 0.0)
    swift = max(abs(plan_w), abs(robot.w), abs(w), abs(held_w))
    for n in range(guard.sent.shape[0]):  # and what is on its way to the wheels
        ahead, back = max(ahead, guard.sent[n, 0, lane]), min(back, guard.sent[n, 0, lane])
        swift = max(swift, abs(guard.sent[n, 1, lane]))
    top, swiftest = highest(given)
    drives = k == 0 or abs(plan_v) > _WANTS
    ahead = min(SLACK * ahead + (SPEED_SPARE * top if drives and plan_v >= 0 else CREEP), top)
    back = max(SLACK * back - CREEP, -top)
    swift = min(SLACK * swift + TURNS, swiftest)
    # Who is in nobody's way hinders nobody by what it does not use of its promise; who stands does not grow.
    grows = 2 * REACH * given.radius / (guard.holds * guard.holds * top)
    if gives_way and abs(plan_v) <= _WANTS and abs(robot.v) <= CREEP:
        grows = 0.0
    more = top - ahead
    ahead += spare_share(guard, lane, robots, robot, ahead, back, swift, grows, more, 0.0, 0.0) * more
    more = swiftest - swift
    swift += spare_share(guard, lane, robots, robot, ahead, back, swift, grows, 0.0, 0.0, more) * more
    more = top + back
    back -= spare_share(guard, lane, robots, robot, ahead, back, swift, grows, 0.0, more, 0.0) * more
    if grows > 0:  # to what the older ones grow: a jump would be heard long before it may be driven
        ahead, back, swift = min(ahead, fastest), max(back, slowest), min(swift, turn)
    mine = PromiseColumns(guard.promises, k % guard.promises.shape[1], lane)
    mine.fastest, mine.slowest, mine.turn, mine.grows = ahead, back, swift, grows
    said = PostureMessage(guard.said, lane)
    said.x, said.y, said.heading = robot.x, robot.y, robot.heading
    said.fastest, said.slowest, said.turn, said.grows = ahead, back, swift, grows


@compiled_only
def tried(n, v, w, given, backwards, by_ground, backs):  # type: ignore[no-untyped-def]
    """What is tried in the ``n``-th place instead of an order (v, w); ``backwards`` [m/s] it may go at most.

    The same arc, turning on the spot, straight on; back, to have room to turn, or away ``by_ground`` that bars the way:
    an echo that no sensor sees past from here; and the arc, the turn and back creeping. Who ``backs`` already tries
    that after the order itself.
    """
    arcs, spots = len(SLOWED), len(SPOT)
    if backs and n > 0:
        n = FALLBACKS - 1 if n == 1 else n - 1
    if n < arcs:
        return SLOWED[n] * v, SLOWED[n] * w
    if n < arcs + spots:
        return 0.0, SPOT[n - arcs] * w
    if n < arcs + spots + len(SPOT):
        return SPOT[n - arcs - spots] * v, 0.0
    if n >= FALLBACKS:
        if n > FALLBACKS:
            v, w = (0.0, w) if n == FALLBACKS + 1 else (max(-given.limit.v_max, backwards), 0.0)
        less = min(CREEPS * AT_REST / max(abs(v) + abs(w) * given.radius, 1e-9), 1.0)
        return less * v, less * w
    away = (by_ground and v > 0) or abs(w) * given.radius > abs(v)
    return (max(-BACK * given.limit.v_max, backwards) if away else 0.0), 0.0


@compiled_only
def bounded_behind(given, v, w, last_v, last_w, period):  # type: ignore[no-untyped-def]
    """An order by which no point of the rear edge goes back, where nothing looks behind; or the robot stands by it.

    It is near the last one: wheels that brake harder swing back.
    """
    if given.back > CREEP:
        return v, w
    change, turn = given.stop.v_rate * period, given.stop.w_rate * period
    v = min(max(v, last_v - change), last_v + change)
    if v < 0:
        less = min(given.back / (abs(w) * given.radius - v), 1.0)
        v, w = less * v, less * w
    else:
        most = max(v / given.half_width, (given.back - v) / given.radius)
        w = min(max(w, -most), most)
    return v, min(max(w, last_w - turn), last_w + turn)


@compiled_only
def in_force(guard, lane, k, period, time, v, w):  # type: ignore[no-untyped-def]
    """The order that the wheels have ``time`` [s] after period ``k``, of which the order is (v, w); then a stop."""
    if time > guard.latency + period - 1e-9:
        return 0.0, 0.0
    if time > guard.latency - 1e-9:
        return v, w
    before = math.ceil((guard.latency - time) / period - 1e-9)
    if before > k:
        return 0.0, 0.0
    sent = guard.sent[(k - before) % len(guard.sent)]
    return sent[0, lane], sent[1, lane]


@compiled_only
def next_held(rate, held, order):  # type: ignore[no-untyped-def]
    """The commanded speed one step later, within its rate."""
    most = rate * STEP
    return min(max(order, held - most), held + most)


@compiled_only
def next_rim(stop, overshoot, side, now, held):  # type: ignore[no-untyped-def]
    """The speed of a wheel's rim one step later: of all that the plant may do what is farthest on one ``side``.

    1: forwards, -1: backwards, at once; 0: away from standing, as fast as motors can. Back it changes as in a stop.
    """
    far = overshoot * held
    if side > 0:
        far = max(far, held)
        if far >= now:
            return far
    elif side < 0:
        far = min(far, held)
        if far <= now:
            return far
    elif now * held >= 0 and abs(far) >= abs(now):
        return now + math.copysign(min(abs(far - now), stop.rise * STEP), far - now)
    return _slow_rim(stop, now, held)


@compiled_only
def _slow_rim(stop, now, held):  # type: ignore[no-untyped-def]
    """The same as in a stop, whether it falls or grows."""
    less = min(abs(now - held) * min(STEP / max(stop.lag, STEP), 1.0), stop.braking * STEP)
    return now - math.copysign(less, now - held)


@compiled_only
def _turns_back(guard, lane, k, period, robot, half, order_v, order_w):  # type: ignore[no-untyped-def]
    """Whether a wheel turns forwards and backwards before the stop, by what it does and by what it is told."""
    orders = math.ceil(guard.latency / period - 1e-9)
    for wheel in (-half, half):
        first, second = robot.v + wheel * robot.w, guard.held[0, lane] + wheel * guard.held[1, lane]
        low, high = min(first, second), max(first, second)
        for before in range(orders + 1):
            v, w = in_force(guard, lane, k, period, guard.latency - before * period, order_v, order_w)
            low, high = min(low, v + wheel * w), max(high, v + wheel * w)
        if low < -CREEP and high > CREEP:
            return True
    return False


@compiled_only
def _barrier(guard, lane, k, period, robots, odometry, robot, given, order_v, order_w, nearest, more):  # type: ignore[no-untyped-def]
    """What bars the foreseen way: the orders on their way, this one for a period, and a stop.

    Where a wheel turns back, what goes farthest one way is not what goes farthest the other way: all four ways between
    which the robot goes have to be clear.
    """
    if not _turns_back(guard, lane, k, period, robot, given.limit.half_axle, order_v, order_w):
        return _way_barrier(
            guard, lane, k, period, robots, odometry, robot, given, order_v, order_w, nearest, more, 0, 0
        )
    for right in range(-1, 2, 2):
        for left in range(-1, 2, 2):
            bars = _way_barrier(
                guard, lane, k, period, robots, odometry, robot, given, order_v, order_w, nearest, more, right, left
            )
            if bars != NO_BARRIER:
                return bars
    return NO_BARRIER


@compiled_only
def _way_barrier(  # type: ignore[no-untyped-def]
    guard, lane, k, period, robots, odometry, robot, given, order_v, order_w, nearest, more, side_right, side_left
):
    """The same of the way on which the wheels go farthest to these sides."""
    stop, half, held_v, held_w = given.stop, given.limit.half_axle, guard.held[0, lane], guard.held[1, lane]
    rim_right, rim_left = robot.v + half * robot.w, robot.v - half * robot.w
    late_right, late_left, behind, off = rim_right, rim_left, 0.0, 0.0
    time, ahead, left, turn, gone, swept, swift = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    now_x, now_y, now = odometry.odo_x, odometry.odo_y, odometry.odo_heading
    now_c, now_s = math.cos(now), math.sin(now)
    from_x, from_y, from_c, from_s = now_x, now_y, now_c, now_s  # where it was looked at before
    own_c, own_s = math.cos(robot.heading), math.sin(robot.heading)
    for _ in range(_LONGEST):
        to_v, to_w = in_force(guard, lane, k, period, time, order_v, order_w)
        held_v, held_w = next_held(stop.v_rate, held_v, to_v), next_held(stop.w_rate, held_w, to_w)
        to_right, to_left = held_v + half * held_w, held_v - half * held_w
        rim_right = next_rim(stop, given.overshoot, side_right, rim_right, to_right)
        rim_left = next_rim(stop, given.overshoot, side_left, rim_left, to_left)
        # A robot whose speed grows as slowly as it falls has another heading on the way: by so much it is beside it.
        late_right = _slow_rim(stop, late_right, to_right)
        late_left = _slow_rim(stop, late_left, to_left)
        v, w = (rim_right + rim_left) / 2, (rim_right - rim_left) / (2 * half)
        behind += (w - (late_right - late_left) / (2 * half)) * STEP
        off = max(off, abs(behind))
        middle = turn + w * STEP / 2
        ahead += v * STEP * math.cos(middle)
        left += v * STEP * math.sin(middle)
        turn += w * STEP
        gone += abs(v) * STEP
        fast = abs(v) + abs(w) * given.radius
        swept, swift = swept + fast * STEP, max(swift, fast)
        time += STEP
        rest = fast * stop.lag
        stands = time > guard.latency + period and held_v == 0 and held_w == 0 and rest < _NEARLY
        if stands or swept >= given.cell / 4:
            if guard.sees == 1:
                x, y = now_x + now_c * ahead - now_s * left, now_y + now_s * ahead + now_c * left
                c, s = math.cos(now + turn), math.sin(now + turn)
                if not is_clear(
                    guard.ground[lane], guard.window[lane], given, guard.barred, x, y, c, s, now_x, now_y, now_c, now_s,
                    from_x, from_y, from_c, from_s, given.least + gone * off + more, time, period, k + 1,
                    ahead < 0, AWAY * swept if swift > AT_REST else 0.0,
                ):  # fmt: skip
                    return BY_GROUND
                from_x, from_y, from_c, from_s = x, y, c, s
            if guard.air.values > 0:
                x, y = robot.x + own_c * ahead - own_s * left, robot.y + own_s * ahead + own_c * left
                free = _room_there(guard, lane, robots, given, x, y, robot.heading + turn, time)
                # Where there is less room than there should be, it keeps what it has.
                if free < (gone * off if nearest >= 0 else nearest - 1e-9) or free == -math.inf:
                    return BY_ROBOT
            swept, swift = 0.0, 0.0
        if stands:
            return NO_BARRIER
    return BY_GROUND


@without_refcounts
def let_pass(guard, k, period, robots, truth, seen, readings, cut, going, command, order):  # type: ignore[no-untyped-def]
    """Do nothing, in place of :func:`keep_safe`, where there is no monitor."""
