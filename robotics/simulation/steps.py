"""The steps of a period over all lanes: sense, hear, decide, obey, record, say, move.

Every step reads and writes columns of :class:`robotics.simulation.lanes.Lanes`, those that it needs: handing all of
them on would take the compiler minutes. No lane's numbers depend on which lanes are beside it, but for what a robot
hears of the others of its run, and sees of them. To look is :func:`robotics.sensing.carried.look`.
"""

import math

import numpy as np

from fuzzy.compiled.jit import inner, uncounted
from robotics.laws.equation import (
    AT_S,
    AT_X,
    FIRST,
    GUARDED,
    MODE,
    PROGRESS,
    SAYS,
    SECOND,
    TO_HEADING,
    TO_S,
    TO_X,
    TO_Y,
    WISH_V,
    WISH_W,
    Known,
    V,
    X,
)
from robotics.laws.modes import STOPPED
from robotics.paths.road import moving
from robotics.radio.channel import AGE, HEARS, broadcast, receive
from robotics.radio.faults import notice
from robotics.sensing.posture import measure, read_encoders
from robotics.vehicle import plant
from robotics.vehicle.plant import EFFORT, SUBSTEPS, VARIATION, tick_into, within

TRUE_X, TRUE_Y = plant.X, plant.Y


@uncounted
def sense(k, period, parameters, truth, senses, seen, road, path, references):  # type: ignore[no-untyped-def]
    """Measure encoders and postures, and look up where the references are in period ``k``.

    Args:
        k: The control period.
        period: Its length [s].
        parameters, truth: Of the plant.
        senses: How the robots know where they are.
        seen: What is written (SEEN, lanes).
        road, path: The references' road, and each lane's path on it.
        references: Those that all runs share, looked up at once; or no samples.
    """
    velocity, lanes = seen[V : V + 2], seen.shape[1]
    read_encoders(parameters, truth, senses.counts, period, velocity)
    measure(senses, truth, seen[X : X + 3], velocity, k, period)
    if references.shape[1] > 0:
        for c in range(AT_S - AT_X + 1):
            for i in range(lanes):
                seen[AT_X + c, i] = references[c, k, i % references.shape[2]]
        return
    for i in range(lanes):
        x, y, heading, v, w, s = moving(road, path[i], k * period)
        seen[AT_X, i], seen[AT_X + 1, i], seen[AT_X + 2, i] = x, y, heading
        seen[AT_X + 3, i], seen[AT_X + 4, i], seen[AT_X + 5, i] = v, w, s


@uncounted
def hear(k, period, trouble, air):  # type: ignore[no-untyped-def]
    """Find out who is at fault, and receive what the radio brings in period ``k``, of ``period`` [s]."""
    notice(trouble, k * period, len(air.graph))
    receive(air, k, period, trouble.cut)


@inner
def decide(law, k, first, last, old, memory, command, work):  # type: ignore[no-untyped-def]
    """Ask the equation of the law for the commands of the lanes from ``first`` to before ``last`` in period ``k``.

    What is known is ``old``, but for the time.
    """
    for c in range(TO_S - TO_X + 1):
        for i in range(first, last):
            command[TO_X + c, i] = old.seen[AT_X + c, i]
    known = Known(
        k * old.dt, old.dt, old.seen, old.heard, old.ranges,
        old.road, old.path, old.column, old.gains, old.base, old.rules,
    )  # fmt: skip
    law(first, last, known, memory, command, work)


@uncounted
def obey(period, divergence, watchdog, truth, trouble, command, order, held_for, stopped, lost):  # type: ignore[no-untyped-def]
    """Make the order of the command: a robot at fault holds its last one or stands. Notice who is lost.

    The arguments are the fields of :class:`robotics.simulation.lanes.Lanes` of these names, and of its body.
    """
    for i in range(truth.shape[1]):
        first, second = command[FIRST, i], command[SECOND, i]
        dx, dy = truth[TRUE_X, i] - command[TO_X, i], truth[TRUE_Y, i] - command[TO_Y, i]
        near = dx * dx + dy * dy < divergence * divergence
        good = math.isfinite(first) and math.isfinite(second) and near
        lost[i] = not good and stopped[i] < 0
        # Without a new command a robot holds its last, until its watchdog stops it.
        held = trouble.held[i]
        held_for[i] = held_for[i] + period if held else 0.0
        if not held:
            order[0, i], order[1, i] = first, second
        if trouble.failed[i] or held_for[i] > watchdog + 1e-9:
            order[0, i], order[1, i] = 0.0, 0.0


@uncounted
def record(k, kept, truth, seen, command, order, code, air, readings, stopped):  # type: ignore[no-untyped-def]
    """Keep the samples of period ``k``; of stopped robots what stands for them.

    ``code`` is that of the faults and ``readings`` those of the range sensors; else the arguments are as of
    :func:`obey`.
    """
    robots = len(air.graph)
    for i in range(command.shape[1]):
        run, robot, gone = i // robots, i % robots, stopped[i] >= 0
        if len(kept.samples) > 0:
            _sample(k, i, run, robot, gone, kept.samples, kept.limits, truth, seen, command, order)
        if len(kept.team) > 0:
            kept.team[k, 0, run, robot] = np.nan if gone else command[PROGRESS, i]
            for c in range(TO_HEADING - TO_X + 1):
                kept.team[k, 1 + c, run, robot] = np.nan if gone else command[TO_X + c, i]
            kept.team[k, 4, run, robot] = np.nan if gone else float(code[i])
        if len(kept.modes) > 0:
            kept.modes[k, run, robot] = STOPPED if gone else np.int8(command[MODE, i])
        if len(kept.guarded) > 0:
            kept.guarded[k, run, robot] = not gone and command[GUARDED, i] > 0
        if len(kept.inputs) > 0:
            for n in range(kept.inputs.shape[1]):
                kept.inputs[k, n, run, robot] = np.nan if gone else command[SAYS + air.values + n, i]
        if len(kept.links) > 0:
            for j in range(robots):
                kept.links[k, run, robot, j] = air.heard[AGE, i, j] if air.heard[HEARS, i, j] > 0 else np.inf
        if len(kept.ranges) > 0:
            for n in range(kept.ranges.shape[3]):
                kept.ranges[k, run, robot, n] = readings[i, n]
        if len(kept.torques) > 0:
            kept.torques[k, 0, run, robot] = np.nan if gone else truth[plant.TORQUE_R, i]
            kept.torques[k, 1, run, robot] = np.nan if gone else truth[plant.TORQUE_L, i]
        if len(kept.encoders) > 0:
            for c in range(2):
                kept.encoders[k, c, run, robot] = np.nan if gone else truth[plant.ANGLE_R + c, i]
                kept.encoders[k, 2 + c, run, robot] = np.nan if gone else seen[V + c, i]
        if len(kept.messages) > 0:
            for n in range(kept.messages.shape[1]):
                due = k % air.every == 0 and not gone
                kept.messages[k, n, run, robot] = command[SAYS + n, i] if due else np.nan


@inner
def _sample(k, i, run, robot, gone, samples, limits, truth, seen, command, order):  # type: ignore[no-untyped-def]
    """The channels of every run, in the order of robotics.simulation.channels.CHANNELS."""
    if gone:
        for c in range(samples.shape[1]):
            samples[k, c, run, robot] = np.nan
        return
    for c in range(5):
        samples[k, c, run, robot] = truth[c, i]
    for c in range(3):
        samples[k, 5 + c, run, robot] = seen[c, i]
    samples[k, 8, run, robot], samples[k, 9, run, robot] = order[0, i], order[1, i]
    v, w = within(limits, i, command[WISH_V, i], command[WISH_W, i])
    samples[k, 10, run, robot], samples[k, 11, run, robot] = v, w
    samples[k, 12, run, robot], samples[k, 13, run, robot] = truth[EFFORT, i], truth[VARIATION, i]


@uncounted
def say(k, period, cut, air, command, truth):  # type: ignore[no-untyped-def]
    """Broadcast the message of every robot, where period ``k``, of ``period`` [s], is one for it."""
    broadcast(air, k, period, cut, command, SAYS, truth[TRUE_X], truth[TRUE_Y])


@uncounted
def move(k, body, order, stopped, lost):  # type: ignore[no-untyped-def]
    """Stop the robots that are lost, and move the plant by period ``k``."""
    flights = len(body.pending)
    now = body.pending[k % flights]
    for i in range(order.shape[1]):
        if lost[i]:
            stopped[i] = k
        if stopped[i] >= 0:
            order[0, i], order[1, i] = 0.0, 0.0
        now[0, i], now[1, i] = order[0, i], order[1, i]
    earlier = body.pending[(k - body.late_periods - 1) % flights]
    command = body.pending[(k - body.late_periods) % flights]
    tick_into(
        body.truth, body.truth, body.parameters, earlier, command,
        body.late_steps, body.steps, body.step, SUBSTEPS, body.code, body.scratch,
    )  # fmt: skip
