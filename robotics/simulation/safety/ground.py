"""The ground that a robot remembers: which of it its range sensors have seen to be free, in the frame of its odometry.

A square window of cells goes with the robot. A cell is free where the middle of it lay before an echo by more than the
noise, in the cone of a sensor; below the robot's body; and, at the start, around it. An echo takes that back from the
cells from which it may have come, unless another sensor sees past them at the same time. All else is unknown, and not
free: the monitor lets no robot go there.
"""

import math

from fuzzy.compiled.columns import Columns, column, within
from fuzzy.compiled.jit import compiled_only
from robotics.simulation.safety.assumptions import DEVIATIONS
from robotics.world.vehicle.plant import LimitColumns

THICK = 1.5  # cells behind an echo that are taken for the thing
RAY_STEP = 0.7  # cells from one place on a ray to the next
RAY_HALF = 0.36  # cells from a ray to the middle of a cell: half of what lies between two rays
NEVER_SEEN, FREE_GROUND = 0, -1  # a cell; above 0: the period of an echo from there, plus 1
OF_ROBOT, OF_MOVING = -2, -3  # minus twice that: it was of a robot that was heard, or of what has moved: it soon fades
FADES_AFTER = 0.3  # s after the next look
TOUCHES = 1.15  # cells to the middle of the nearest one: what moves may touch the body
STEEP_WITHIN = 8.0  # cells from a sensor: up to there an echo stays of what may be too steep to be heard again
STEEP_BESIDE = 1.0  # cells outside the edge of a cone: there such a thing is looked for
_TWO = 64  # more than a row has cells: two of its columns are one number


class StopColumns(Columns):
    """How a robot stops, as of robotics.simulation.safety.assumptions.StoppingModel."""

    lag = column("s")
    braking = column("m/s²")
    v_rate = column("m/s²")
    w_rate = column("rad/s²")
    rise = column("m/s²")


class GuardColumns(Columns):
    """What passive safety assumes of one robot."""

    half_length = column("m")
    half_width = column("m")
    radius = column("m", "of its turning circle")
    cell = column("m")
    least = column("m", "between its body and the middle of a cell that is not free")
    others = column("m/s", "the greatest speed of what moves among the obstacles")
    back = column("m/s", "how fast it may go back: among what moves, as fast as its sensors see the way")
    fresh = column("s", "the longest time from look to look of its sensors: what is older is out of view")
    place = column("m", "by how much its measured place is off at most")
    turned = column("rad", "likewise its heading")
    latency = column("s")
    overshoot = column("1", "of the wheels")
    limit = within(LimitColumns)
    stop = within(StopColumns)


@compiled_only
def age_of(value, stamp, period):  # type: ignore[no-untyped-def]
    """How old [s] the echo of a cell is."""
    return (stamp - value if value > NEVER_SEEN else stamp - (OF_MOVING - value + 1) // 2) * period


@compiled_only
def put(ground, x, y, value):  # type: ignore[no-untyped-def]
    """Write a cell of the world; the window is a torus."""
    size = ground.shape[0]
    ground[x % size, y % size] = value


@compiled_only
def on_torus(place, size):  # type: ignore[no-untyped-def]
    """Where a place below twice the ``size`` lies on a torus; a remainder takes ten times as long."""
    return place - size if place >= size else place


@compiled_only
def follow(ground, window, given, x, y):  # type: ignore[no-untyped-def]
    """Let the window go with a robot at (x, y) [m]: the cells that come in are unknown."""
    size = ground.shape[0]
    to_x, to_y = math.floor(x / given.cell) - size // 2, math.floor(y / given.cell) - size // 2
    while window[0] != to_x:
        step = 1 if to_x > window[0] else -1
        row = window[0] + size if step > 0 else window[0] - 1
        for j in range(size):
            ground[row % size, j] = NEVER_SEEN
        window[0] += step
    while window[1] != to_y:
        step = 1 if to_y > window[1] else -1
        row = window[1] + size if step > 0 else window[1] - 1
        for i in range(size):
            ground[i, row % size] = NEVER_SEEN
        window[1] += step


@compiled_only
def stand_free(ground, window, given, x, y, c, s, around):  # type: ignore[no-untyped-def]
    """Take the ground below a body, and ``around`` [m] it, to be free."""
    size, cell, low_x, low_y = ground.shape[0], given.cell, window[0], window[1]
    first_x, first_y = low_x % size, low_y % size
    reach = math.ceil((given.radius + around) / cell)
    at_x, at_y = math.floor(x / cell) - low_x, math.floor(y / cell) - low_y
    for i in range(max(at_x - reach, 0), min(at_x + reach + 1, size)):
        row = on_torus(first_x + i, size)
        for j in range(max(at_y - reach, 0), min(at_y + reach + 1, size)):
            dx, dy = (low_x + i + 0.5) * cell - x, (low_y + j + 0.5) * cell - y
            if body_gap(given, c * dx + s * dy, c * dy - s * dx) <= around:
                ground[row, on_torus(first_y + j, size)] = FREE_GROUND


@compiled_only
def body_gap(given, ahead, left):  # type: ignore[no-untyped-def]
    """The distance [m] from a body to a point in its frame."""
    over, beside = max(abs(ahead) - given.half_length, 0.0), max(abs(left) - given.half_width, 0.0)
    return math.sqrt(over * over + beside * beside)


@compiled_only
def find_free(ground, window, near):  # type: ignore[no-untyped-def]
    """Write into ``near`` (cells, cells) how far each of the window is from one that is not free, or the edge.

    The distance, in cells, is the greater one along x and y, found forwards and backwards from that of the neighbours.
    """
    size = ground.shape[0]
    first_x, first_y, last = window[0] % size, window[1] % size, size - 1
    for i in range(size):
        row, beside = on_torus(first_x + i, size), 0
        for j in range(size):
            if 0 < i < last and 0 < j < last and ground[row, on_torus(first_y + j, size)] == FREE_GROUND:
                beside = 1 + min(min(near[i - 1, j - 1], near[i - 1, j]), min(near[i - 1, j + 1], beside))
            else:
                beside = 0
            near[i, j] = beside
    for m in range(1, last):
        before, after = last - m, 0
        for n in range(1, last):
            at = last - n
            least = min(min(near[before + 1, at + 1], near[before + 1, at]), min(near[before + 1, at - 1], after))
            after = min(near[before, at], 1 + least)
            near[before, at] = after


@compiled_only
def set_free(ground, window, given, near, sensor, rays, first, last, reading, x, y, c, s):  # type: ignore[no-untyped-def]
    """Take in what is free before the echo of a reading; arguments as of :func:`take_in`.

    A ray goes past what is free already, by as many of its steps as ``near`` (:func:`find_free`) leaves room for. Where
    a surface that comes in at the edge of the cone may be too steep to be heard, an echo near the sensor stays, and
    ground that was never seen where nothing but robots moves.
    """
    cell, size, low_x, low_y = given.cell, ground.shape[0], window[0], window[1]
    first_x, first_y = low_x % size, low_y % size
    sees, off = echo_at(sensor, reading)
    if reading <= sensor.minimum + off:  # it may be anywhere from the sensor to there: nothing is free before it
        return
    end = sees - max(off, RAY_HALF * cell)
    mount_x, mount_y = x + c * sensor.x - s * sensor.y, y + s * sensor.x + c * sensor.y
    step, beside, far = RAY_STEP * cell, RAY_HALF * cell, end * end
    right, left = math.inf, math.inf  # m: to the first echo that the map has beside each edge of the cone
    if sensor.sin_half > 0 and sensor.cos_incidence > 0:
        right = _first_echo(ground, given, rays, first, -1, end, mount_x, mount_y, c, s) - cell
        left = _first_echo(ground, given, rays, last - 1, 1, end, mount_x, mount_y, c, s) - cell
    for n in range(first, last):
        ux, uy = c * rays[0, n] - s * rays[1, n], s * rays[0, n] + c * rays[1, n]
        r = 0.0
        while r <= end:
            i, j = math.floor((mount_x + r * ux) / cell) - low_x, math.floor((mount_y + r * uy) / cell) - low_y
            if not (0 <= i < size and 0 <= j < size):
                break
            passed = near[i, j]
            if passed == 0:
                dx, dy = (low_x + i + 0.5) * cell - mount_x, (low_y + j + 0.5) * cell - mount_y
                # The middle of the cell lies before the echo, and by this ray, not by the next one.
                if dx * dx + dy * dy <= far and abs(ux * dy - uy * dx) <= beside:
                    row, line = on_torus(first_x + i, size), on_torus(first_y + j, size)
                    value = ground[row, line]
                    unsure = (value > NEVER_SEEN and math.sqrt(dx * dx + dy * dy) < STEEP_WITHIN * cell) or (
                        value == NEVER_SEEN and given.others == 0
                    )
                    if not (
                        unsure and _too_steep(sensor, rays, first, last, right, left, c * dx + s * dy, c * dy - s * dx)
                    ):
                        ground[row, line] = FREE_GROUND
                passed = 1
            for _ in range(1 + (passed - 1) * 7 // 5):  # 7 steps of 0.7 cells end at most 5 cells further on
                r += step


@compiled_only
def _first_echo(ground, given, rays, n, side, end, mount_x, mount_y, c, s):  # type: ignore[no-untyped-def]
    """How far [m] along the ``n``-th ray from a mount, up to ``end``, the map has an echo of what stands beside it.

    The ``side`` is 1 to the left, -1 to the right: what comes into the cone there is outside it, too.
    """
    cell, size = given.cell, ground.shape[0]
    ux, uy = c * rays[0, n] - s * rays[1, n], s * rays[0, n] + c * rays[1, n]
    aside = side * STEEP_BESIDE * cell
    mount_x, mount_y = mount_x - aside * uy, mount_y + aside * ux
    r = 0.0
    while r <= end:
        i, j = math.floor((mount_x + r * ux) / cell), math.floor((mount_y + r * uy) / cell)
        if ground[i % size, j % size] > NEVER_SEEN:
            return r
        r += RAY_STEP * cell
    return math.inf


@compiled_only
def _too_steep(sensor, rays, first, last, right, left, x, y):  # type: ignore[no-untyped-def]
    """Whether a surface may be at (x, y) [m] from a sensor and give no echo, as it is too steep.

    It comes in at an edge of the cone, its first or last ray, at ``right`` or ``left`` [m] or farther, at less than 90°
    less the incidence angle; a convex one lies behind its tangent there.
    """
    sine = sensor.cos_incidence
    cosine = math.sqrt(1 - sine * sine)
    for edge, near in ((first, right), (last - 1, left)):
        along, across = rays[0, edge] * x + rays[1, edge] * y, abs(rays[0, edge] * y - rays[1, edge] * x)
        if near * sine <= along * sine - across * cosine:
            return True
    return False


@compiled_only
def echo_at(sensor, reading):  # type: ignore[no-untyped-def]
    """How far a sensor sees, by its reading [m], and by how much that may be off [m]."""
    sees = min(reading, sensor.range)
    relative = sensor.relative_noise * sees
    return sees, DEVIATIONS * math.sqrt(sensor.noise * sensor.noise + relative * relative)


@compiled_only
def take_in(ground, window, given, sensor, rays, first, last, reading, stamp, of_robot, x, y, c, s):  # type: ignore[no-untyped-def]
    """Take in the echo of one reading [m], along the rays of a sensor.

    Args:
        ground, window: Of the robot.
        given: GuardColumns.
        sensor: SensorColumns.
        rays: Directions in the robot's frame (2, rays).
        first, last: The sensor's.
        reading: Infinite: no echo.
        stamp: The present period, plus 1.
        of_robot: Whether it is of a robot that was heard.
        x, y: Where the robot is, by odometry [m].
        c, s: Cosine and sine of its heading.
    """
    if reading == math.inf:
        return
    cell, size, low_x, low_y = given.cell, ground.shape[0], window[0], window[1]
    first_x, first_y = low_x % size, low_y % size
    sees, off = echo_at(sensor, reading)
    begin, end = (0.0 if reading <= sensor.minimum + off else sees - off), sees + max(off, THICK * cell)
    mount_x, mount_y = x + c * sensor.x - s * sensor.y, y + s * sensor.x + c * sensor.y
    for n in range(first, last):
        ux, uy = c * rays[0, n] - s * rays[1, n], s * rays[0, n] + c * rays[1, n]
        r = begin
        while r <= end:
            i, j = math.floor((mount_x + r * ux) / cell) - low_x, math.floor((mount_y + r * uy) / cell) - low_y
            if not (0 <= i < size and 0 <= j < size):
                break
            row, line = on_torus(first_x + i, size), on_torus(first_y + j, size)
            known = ground[row, line]
            if of_robot or (known <= FREE_GROUND and given.others > 0):
                if known <= FREE_GROUND:  # what stands is not where the ground was once free
                    ground[row, line] = (OF_ROBOT if of_robot else OF_MOVING) - 2 * stamp
            else:
                ground[row, line] = stamp
            r += RAY_STEP * cell


@compiled_only
def faded(value, age, given):  # type: ignore[no-untyped-def]
    """What a cell is after ``age`` [s]: the echo of a robot, or of what has moved, is one no longer."""
    if value < FREE_GROUND and age > given.fresh + FADES_AFTER:
        return FREE_GROUND if value % 2 == 0 else NEVER_SEEN
    return value


@compiled_only
def find_barred(ground, window, given, barred, stamp, period):  # type: ignore[no-untyped-def]
    """Write into ``barred`` (cells, cells) where from each cell of the window on its row has the next that is not free.

    Most are free: who looks at a part of the window goes from one of those to the next. It is the column of the next
    echo, and _TWO times that of the next echo or cell that was never seen; the number of cells where there is none.
    """
    size = ground.shape[0]
    first_x, first_y = window[0] % size, window[1] % size
    for i in range(size):
        row, echo, unknown = on_torus(first_x + i, size), size, size
        for n in range(size):
            j = size - 1 - n
            value = ground[row, on_torus(first_y + j, size)]
            if value < FREE_GROUND:
                value = faded(value, age_of(value, stamp, period), given)
            if value != FREE_GROUND:
                unknown = j
                if value != NEVER_SEEN:
                    echo = j
            barred[i, j] = echo + _TWO * unknown


@compiled_only
def _beside_echo(ground, x, y):  # type: ignore[no-untyped-def]
    """Whether a cell has a neighbour from which an echo came of what stands.

    Asked of cells near a body only: asked of the whole window once a period, runs take 1.4 to 1.5 times as long.
    """
    size = ground.shape[0]
    for i in range(x - 1, x + 2):
        for j in range(y - 1, y + 2):
            if ground[i % size, j % size] > NEVER_SEEN:
                return True
    return False


@compiled_only
def is_clear(  # type: ignore[no-untyped-def]
    ground, window, given, barred, x, y, c, s, now_x, now_y, now_c, now_s, from_x, from_y, from_c, from_s,
    need, late, period, stamp, backs, away,
):  # fmt: skip
    """Whether a body keeps clear of what is not free, well in the window; what is too near now may not come nearer.

    Args:
        ground, window: Of the robot.
        given: GuardColumns.
        barred: Where ground is not free, as of :func:`find_barred`.
        x, y: Where its body will be, by odometry [m].
        c, s: Cosine and sine of its heading then.
        now_x, now_y, now_c, now_s: The same as it is now.
        from_x, from_y, from_c, from_s: And a moment before: what moves may not come nearer on any part of the way, as
            it may be there by then.
        need: The least gap [m].
        late: In how many seconds it is there: what gave an echo may have come nearer, by then and since it was heard.
        period: The control period [s].
        stamp: The present period, plus 1.
        backs: Whether ground that was never seen is not free: a robot backs over ground only that it knows. Ahead it
            is, but beside an echo where nothing but robots moves: it may be of the same thing.
        away: By how much farther [m] it has to be, than that moment before, from what has moved and may touch it: a
            cell cannot tell where that ends, and so not whether a corner of the body comes nearer to it.
    """
    cell, size, others, low_x, low_y = given.cell, ground.shape[0], given.others, window[0], window[1]
    known = backs or others == 0  # such ground is looked at
    # What has come into the window since the last look was not looked at: an echo from there was not written down.
    new = given.limit.v_max * given.fresh
    wide = given.half_length * abs(c) + given.half_width * abs(s) + need
    high = given.half_length * abs(s) + given.half_width * abs(c) + need
    if (
        math.floor((x - wide - new) / cell) < low_x
        or math.floor((y - high - new) / cell) < low_y
        or math.floor((x + wide + new) / cell) >= low_x + size
        or math.floor((y + high + new) / cell) >= low_y + size
    ):
        return False
    moves = others * (late + given.fresh + FADES_AFTER)
    first_x, first_y = low_x % size, low_y % size
    begin = max(math.floor((y - high - moves) / cell) - low_y, 0)
    end = min(math.floor((y + high + moves) / cell) - low_y + 1, size)
    for i in range(
        max(math.floor((x - wide - moves) / cell) - low_x, 0),
        min(math.floor((x + wide + moves) / cell) - low_x + 1, size),
    ):
        j = begin
        while j < end:
            j = barred[i, j] // _TWO if known else barred[i, j] % _TWO
            if j >= end:
                break
            value = ground[on_torus(first_x + i, size), on_torus(first_y + j, size)]
            if value == NEVER_SEEN and not backs and not _beside_echo(ground, low_x + i, low_y + j):
                j += 1
                continue
            age, of_robot = age_of(value, stamp, period), value < FREE_GROUND and value % 2 == 0
            value = faded(value, age, given)
            at_x, at_y = (low_x + i + 0.5) * cell, (low_y + j + 0.5) * cell
            j += 1
            gap = body_gap(given, c * (at_x - x) + s * (at_y - y), c * (at_y - y) - s * (at_x - x))
            # What moves was seen there lately; what was not seen again stands, or has gone where nothing looks.
            may_move = value != NEVER_SEEN and not of_robot and age <= given.fresh + FADES_AFTER
            if gap >= need + (others * (late + age) if may_move else 0.0):
                continue
            dx, dy = at_x - now_x, at_y - now_y
            if gap < body_gap(given, now_c * dx + now_s * dy, now_c * dy - now_s * dx) - 1e-9 or gap == 0:
                return False
            if may_move and others > 0:
                dx, dy = at_x - from_x, at_y - from_y
                before = body_gap(given, from_c * dx + from_s * dy, from_c * dy - from_s * dx)
                if gap < before + (away if value < FREE_GROUND and gap < TOUCHES * cell else 0.0) - 1e-9:
                    return False
    return True
