"""The steps of a period over all lanes: sense, hear, decide, obey, record, say, move.

Every step reads and writes columns of :class:`robotics.simulation.lanes.Lanes`, those that it needs: handing all of
them on would take the compiler minutes. No lane's numbers depend on which lanes are beside it, but for what a robot
hears of the others of its run, and sees of them. To look is :func:`robotics.world.sensing.carried.look`.
"""

import math

from fuzzy.compiled.jit import compiled_only, without_refcounts
from robotics.laws.equation import AimColumns, CommandColumns, Known, RobotColumns, SeenColumns, WrittenColumns
from robotics.world.paths.road import moving
from robotics.world.radio.channel import broadcast, receive
from robotics.world.radio.faults import notice
from robotics.world.sensing.posture import encoders_of, measure_of
from robotics.world.vehicle.floor import tread
from robotics.world.vehicle.plant import SUBSTEPS, TruthColumns, tick_lanes

VELOCITY = RobotColumns.v.row


@without_refcounts
def sense(k, period, parameters, truth, senses, seen, road, path, references, goes_on):  # type: ignore[no-untyped-def]
    """Measure encoders and postures, and look up where the references are in period ``k``, of the runs that go on.

    Args:
        k: The control period.
        period: Its length [s].
        parameters, truth: Of the plant.
        senses: How the robots know where they are.
        seen: What is written (SeenColumns, lanes).
        road, path: The references' road, and each lane's path on it.
        references: Those that all runs share, looked up at once; or no samples.
        goes_on: (runs,).
    """
    posture, velocity = seen[:VELOCITY], seen[VELOCITY : VELOCITY + 2]
    robots, drawn = seen.shape[1] // len(goes_on), k - senses.drawn
    for run in range(len(goes_on)):
        for robot in range(robots if goes_on[run] else 0):
            i = run * robots + robot
            encoders_of(i, parameters, truth, senses.counts, period, velocity)
            measure_of(i, run, robot, senses, parameters, truth, posture, velocity, k, drawn, period)
            lane = SeenColumns(seen, i)
            if references.shape[1] > 0:
                lane.aim = AimColumns(references, k, robot)
            else:
                aim = lane.aim
                aim.x, aim.y, aim.heading, aim.v, aim.w, aim.s = moving(road, path[i], k * period)


@without_refcounts
def hear(k, period, trouble, air):  # type: ignore[no-untyped-def]
    """Find out who is at fault, and receive what the radio brings in period ``k``, of ``period`` [s]."""
    notice(trouble, k * period, len(air.graph))
    receive(air, k, period, trouble.cut)


@compiled_only
def decide(law, k, robots, goes_on, old, memory, command, work):  # type: ignore[no-untyped-def]
    """Ask the equation of the law for the commands of the runs that go on, in period ``k``.

    What is known is ``old``, but for the time.
    """
    first, last = _going(goes_on, 0)
    while first < last:
        _decide(law, k, first * robots, last * robots, old, memory, command, work)
        first, last = _going(goes_on, last)


@compiled_only
def _going(goes_on, run):  # type: ignore[no-untyped-def]
    """The next runs from ``run`` on that go on, one after the other: the first, and the one behind the last."""
    while run < len(goes_on) and not goes_on[run]:
        run += 1
    last = run
    while last < len(goes_on) and goes_on[last]:
        last += 1
    return run, last


@compiled_only
def _decide(law, k, first, last, old, memory, command, work):  # type: ignore[no-untyped-def]
    """Ask for those of the lanes from ``first`` to before ``last``."""
    for i in range(first, last):
        out = CommandColumns(command, i)
        out.target = SeenColumns(old.seen, i).aim
    known = Known(
        k * old.dt, old.dt, old.seen, old.heard, old.ranges,
        old.road, old.path, old.column, old.gains, old.base, old.rules, old.table, old.tables,
    )  # fmt: skip
    law(first, last, known, memory, command, work)


@without_refcounts
def obey(period, divergence, watchdog, truth, trouble, command, order, held_for, stopped, lost):  # type: ignore[no-untyped-def]
    """Make the order of the command: a robot at fault holds its last one or stands. Notice who is lost.

    The arguments are the fields of :class:`robotics.simulation.lanes.Lanes` of these names, and of its body.
    """
    for i in range(truth.shape[1]):
        out = CommandColumns(command, i)
        first, second = out.first, out.second
        lost[i] = not on_course(first, second, TruthColumns(truth, i), out.target, divergence) and stopped[i] < 0
        # Without a new command a robot holds its last, until its watchdog stops it.
        held = trouble.held[i]
        held_for[i] = held_for[i] + period if held else 0.0
        if not held:
            order[0, i], order[1, i] = first, second
        if trouble.failed[i] or held_for[i] > watchdog + 1e-9:
            order[0, i], order[1, i] = 0.0, 0.0


@compiled_only
def on_course(first, second, here, target, divergence):  # type: ignore[no-untyped-def]
    """Whether a command is finite, and the robot ``here`` nearer than ``divergence`` [m] to its ``target``."""
    dx, dy = here.x - target.x, here.y - target.y
    return math.isfinite(first) and math.isfinite(second) and dx * dx + dy * dy < divergence * divergence


@without_refcounts
def say(k, period, cut, air, command, truth):  # type: ignore[no-untyped-def]
    """Broadcast the message of every robot, where period ``k``, of ``period`` [s], is one for it."""
    here = TruthColumns(truth)
    broadcast(air, k, period, cut, WrittenColumns(command).values, here.x, here.y)


@without_refcounts
def move(k, body, order, stopped, lost, goes_on):  # type: ignore[no-untyped-def]
    """Stop the robots that are lost, and move the plant of the runs that go on by period ``k``."""
    for i in range(order.shape[1]):
        if lost[i]:
            stopped[i] = k
        if stopped[i] >= 0:
            order[0, i], order[1, i] = 0.0, 0.0
    robots = order.shape[1] // len(goes_on)
    first, last = _going(goes_on, 0)
    while first < last:
        move_lanes(first * robots, last * robots, k, body, order, body.scratch)
        first, last = _going(goes_on, last)


@compiled_only
def move_lanes(first, last, k, body, order, scratch):  # type: ignore[no-untyped-def]
    """Move the plant of the lanes from ``first`` to before ``last`` by period ``k``; it works in ``scratch``."""
    flights = len(body.pending)
    now = body.pending[k % flights]
    for i in range(first, last):
        now[0, i], now[1, i] = order[0, i], order[1, i]
    earlier = body.pending[(k - body.late_periods - 1) % flights]
    command = body.pending[(k - body.late_periods) % flights]
    if len(body.floor.friction) > 0:
        tread(first, last, body.floor, body.truth, body.parameters)
    tick_lanes(
        first, last, body.truth, body.truth, body.parameters, earlier, command,
        body.late_steps, body.steps, body.step, SUBSTEPS, body.code, scratch,
    )  # fmt: skip
