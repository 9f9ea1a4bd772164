"""The steps of a period over all lanes: sense, hear, decide, obey, record, say, move.

Every step reads and writes the columns of :class:`robotics.simulation.lanes.Lanes`. No lane's numbers depend on which
lanes are beside it, but for what a robot hears of the others of its run.
"""

import math

import numpy as np

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
    uncounted,
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
def sense(k, lanes):  # type: ignore[no-untyped-def]
    """Measure encoders and postures, and look up where the references are in period ``k``."""
    known, truth = lanes.known, lanes.body.truth
    seen, shared = known.seen, lanes.references
    velocity = seen[V : V + 2]
    read_encoders(lanes.body.parameters, truth, lanes.senses.counts, lanes.period, velocity)
    measure(lanes.senses, truth, seen[X : X + 3], velocity, k, lanes.period)
    if shared.shape[1] > 0:
        for c in range(AT_S - AT_X + 1):
            for i in range(seen.shape[1]):
                seen[AT_X + c, i] = shared[c, k, i % lanes.robots]
        return
    for i in range(seen.shape[1]):
        x, y, heading, v, w, s = moving(lanes.road, lanes.path[i], k * lanes.period)
        seen[AT_X, i], seen[AT_X + 1, i], seen[AT_X + 2, i] = x, y, heading
        seen[AT_X + 3, i], seen[AT_X + 4, i], seen[AT_X + 5, i] = v, w, s


@uncounted
def hear(k, lanes):  # type: ignore[no-untyped-def]
    """Find out who is at fault, and receive what the radio brings in period ``k``."""
    notice(lanes.trouble, k * lanes.period, lanes.robots)
    receive(lanes.air, k, lanes.period, lanes.trouble.cut)


@uncounted
def decide(law, k, lanes):  # type: ignore[no-untyped-def]
    """Ask the equation of the law for its commands."""
    decide_for(law, k, 0, lanes.command.shape[1], lanes)


@uncounted
def decide_for(law, k, first, last, lanes):  # type: ignore[no-untyped-def]
    """The same for the lanes from ``first`` to before ``last`` only."""
    old, command = lanes.known, lanes.command
    for c in range(TO_S - TO_X + 1):
        for i in range(first, last):
            command[TO_X + c, i] = old.seen[AT_X + c, i]
    known = Known(
        k * lanes.period, old.dt, old.seen, old.heard, old.ranges,
        old.road, old.path, old.column, old.gains, old.base, old.rules,
    )  # fmt: skip
    law(first, last, known, lanes.memory, command, lanes.work)


@uncounted
def obey(lanes):  # type: ignore[no-untyped-def]
    """Make the order of the command: a robot at fault holds its last one or stands. Notice who is lost."""
    command, truth, order, trouble = lanes.command, lanes.body.truth, lanes.order, lanes.trouble
    for i in range(truth.shape[1]):
        first, second = command[FIRST, i], command[SECOND, i]
        dx, dy = truth[TRUE_X, i] - command[TO_X, i], truth[TRUE_Y, i] - command[TO_Y, i]
        near = dx * dx + dy * dy < lanes.divergence * lanes.divergence
        good = math.isfinite(first) and math.isfinite(second) and near
        lanes.lost[i] = not good and lanes.stopped[i] < 0
        # Without a new command a robot holds its last, until its watchdog stops it.
        held = trouble.held[i]
        lanes.held_for[i] = lanes.held_for[i] + lanes.period if held else 0.0
        if not held:
            order[0, i], order[1, i] = first, second
        if trouble.failed[i] or lanes.held_for[i] > lanes.watchdog + 1e-9:
            order[0, i], order[1, i] = 0.0, 0.0


@uncounted
def record(k, lanes):  # type: ignore[no-untyped-def]
    """Keep the samples of period ``k``; of stopped robots what stands for them."""
    kept, robots = lanes.kept, lanes.robots
    for i in range(lanes.command.shape[1]):
        run, robot, gone = i // robots, i % robots, lanes.stopped[i] >= 0
        if len(kept.samples) > 0:
            _sample(k, i, run, robot, gone, lanes)
        if len(kept.team) > 0:
            kept.team[k, 0, run, robot] = np.nan if gone else lanes.command[PROGRESS, i]
            for c in range(TO_HEADING - TO_X + 1):
                kept.team[k, 1 + c, run, robot] = np.nan if gone else lanes.command[TO_X + c, i]
            kept.team[k, 4, run, robot] = np.nan if gone else float(lanes.trouble.code[i])
        if len(kept.modes) > 0:
            kept.modes[k, run, robot] = STOPPED if gone else np.int8(lanes.command[MODE, i])
        if len(kept.guarded) > 0:
            kept.guarded[k, run, robot] = not gone and lanes.command[GUARDED, i] > 0
        if len(kept.inputs) > 0:
            first = SAYS + lanes.air.values
            for n in range(kept.inputs.shape[1]):
                kept.inputs[k, n, run, robot] = np.nan if gone else lanes.command[first + n, i]
        if len(kept.links) > 0:
            for j in range(robots):
                hears = lanes.air.heard[HEARS, i, j] > 0
                kept.links[k, run, robot, j] = lanes.air.heard[AGE, i, j] if hears else np.inf
        if len(kept.ranges) > 0:
            for n in range(kept.ranges.shape[3]):
                kept.ranges[k, run, robot, n] = lanes.readings[i, n]


@uncounted
def _sample(k, i, run, robot, gone, lanes):  # type: ignore[no-untyped-def]
    """The channels of every run, in the order of robotics.simulation.channels.CHANNELS."""
    samples, truth, seen, order = lanes.kept.samples, lanes.body.truth, lanes.known.seen, lanes.order
    if gone:
        for c in range(samples.shape[1]):
            samples[k, c, run, robot] = np.nan
        return
    for c in range(5):
        samples[k, c, run, robot] = truth[c, i]
    for c in range(3):
        samples[k, 5 + c, run, robot] = seen[c, i]
    samples[k, 8, run, robot], samples[k, 9, run, robot] = order[0, i], order[1, i]
    v, w = within(lanes.kept.limits, i, lanes.command[WISH_V, i], lanes.command[WISH_W, i])
    samples[k, 10, run, robot], samples[k, 11, run, robot] = v, w
    samples[k, 12, run, robot], samples[k, 13, run, robot] = truth[EFFORT, i], truth[VARIATION, i]


@uncounted
def say(k, lanes):  # type: ignore[no-untyped-def]
    """Broadcast the message of every robot, where period ``k`` is one for it."""
    truth = lanes.body.truth
    broadcast(lanes.air, k, lanes.period, lanes.trouble.cut, lanes.command, SAYS, truth[TRUE_X], truth[TRUE_Y])


@uncounted
def move(k, lanes):  # type: ignore[no-untyped-def]
    """Stop the robots that are lost, and move the plant by period ``k``."""
    body, order = lanes.body, lanes.order
    flights = len(body.pending)
    now = body.pending[k % flights]
    for i in range(order.shape[1]):
        if lanes.lost[i]:
            lanes.stopped[i] = k
        if lanes.stopped[i] >= 0:
            order[0, i], order[1, i] = 0.0, 0.0
        now[0, i], now[1, i] = order[0, i], order[1, i]
    earlier = body.pending[(k - body.late_periods - 1) % flights]
    command = body.pending[(k - body.late_periods) % flights]
    tick_into(
        body.truth, body.truth, body.parameters, earlier, command,
        body.late_steps, body.steps, body.step, SUBSTEPS, body.code, body.scratch,
    )  # fmt: skip
