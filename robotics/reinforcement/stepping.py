"""A step of all episodes in compiled code: obey, reward, move, sense, observe; each lane has a clock of its own.

A lane is an episode: a run of one robot. The steps are those of :mod:`robotics.simulation.steps`, lane by lane, with
the same functions of one lane below them, so that the same commands give the same run to the last bit.
"""

import math
from typing import NamedTuple

import numpy as np

from fuzzy.compiled.columns import Columns, codes, column
from fuzzy.compiled.jit import compiled_only, without_refcounts
from robotics.laws.equation import SeenColumns
from robotics.laws.tracking.observed import LastColumns, observe
from robotics.paths.posture import wrapped_compiled
from robotics.paths.road import Road, moving
from robotics.sensing.carried import look_of
from robotics.sensing.posture import Senses, encoders_of, measure_of
from robotics.simulation.steps import VELOCITY
from robotics.vehicle.plant import STEP, SUBSTEPS, TruthColumns, tick_lanes, within

REWARD = codes(("dense", "cost"))
END = codes(("running", "diverged", "collided", "time"))  # how an episode stands, or how it has ended


class SumColumns(Columns):
    """What the cost of an episode is made of."""

    distance = column("m²", "Σ d²")
    heading = column("rad²", "Σ ψ²")
    turning = column("rad/s", "Σ |Δω|")
    paid = column("1", "the cost told so far")


class SpanColumns(Columns):
    """The samples of a scenario's episode; whole numbers."""

    last = column("1", "the last sample")
    counted = column("1", "the first that is counted")
    many = column("1", "how many are counted")


class EpisodeLanes(NamedTuple):
    """All episodes as columns, and what does not change; the arrays of one lane are its column."""

    period: float  # s
    divergence: float  # m
    steps: int  # of the plant a period
    code: int  # of robotics.vehicle.plant
    late_periods: int  # latency: whole periods,
    late_steps: int  # and steps of the plant beyond them
    kind: int  # of the reward
    approach: float  # what a sample before the counted ones counts
    failed: float  # what an episode costs in which the robot was stopped or touched something
    scales: np.ndarray  # (3,) of the cost's terms
    most: np.ndarray  # (2, scenarios): the command of an action 1, or 1 where actions are in units
    limits: np.ndarray  # (4, scenarios): as of robotics.vehicle.plant.velocity_limits
    highs: np.ndarray  # (entries, scenarios): the limits of an observation
    spans: np.ndarray  # (SpanColumns, scenarios) int
    road: Road  # a path for each scenario
    senses: Senses  # of one robot; its random numbers are (lanes, samples, 3, 1)
    parameters: np.ndarray  # (ParameterColumns, lanes)
    truth: np.ndarray  # (TruthColumns, lanes)
    pending: np.ndarray  # (late periods + 2, 2, lanes): orders; that of a turn stands at it modulo their number
    seen: np.ndarray  # (SeenColumns, lanes)
    ranges: np.ndarray  # (sensors, lanes) m
    path: np.ndarray  # (lanes,) int: the scenario
    clock: np.ndarray  # (lanes,) int: the sample
    ended: np.ndarray  # (lanes,) int: RUNNING, or how it has ended
    touched: np.ndarray  # (lanes,) bool: the robot has touched an obstacle
    last: np.ndarray  # (2, lanes): the command of the sample before
    wished: np.ndarray  # (lanes,) rad/s: the turn rate demanded then; not-a-number: nothing was
    sums: np.ndarray  # (SumColumns, lanes)
    rewards: np.ndarray  # (lanes,)
    observed: np.ndarray  # (lanes, entries)


@without_refcounts
def advance(lanes, first, last, turn, actions, high, scratch):  # type: ignore[no-untyped-def]
    """Take a step in the lanes from ``first`` to before ``last``: all but looking and observing.

    Args:
        lanes: All lanes.
        first: A multiple of the plant's block, unless it is 0.
        last: Likewise, or the number of lanes.
        turn: How many steps were taken before, by whichever lane.
        actions: (lanes, 2).
        high: The limits of an action (2,).
        scratch: The plant works in it.
    """
    flights = len(lanes.pending)
    now = lanes.pending[turn % flights]
    for i in range(first, last):
        one, two = _clipped(actions[i, 0], high[0]), _clipped(actions[i, 1], high[1])
        s = lanes.path[i]
        one, two = one * lanes.most[0, s], two * lanes.most[1, s]
        stays = _judge(lanes, i, s, one, two)
        now[0, i], now[1, i] = (one, two) if stays else (0.0, 0.0)
        lanes.last[0, i], lanes.last[1, i] = one, two
    earlier = lanes.pending[(turn - lanes.late_periods - 1) % flights]
    command = lanes.pending[(turn - lanes.late_periods) % flights]
    tick_lanes(
        first, last, lanes.truth, lanes.truth, lanes.parameters, earlier, command, lanes.late_steps, lanes.steps,
        STEP, SUBSTEPS, lanes.code, scratch,
    )  # fmt: skip
    for i in range(first, last):
        lanes.clock[i] += 1
        _sense(lanes, i)


@compiled_only
def _clipped(value, high):  # type: ignore[no-untyped-def]
    """A value between -``high`` and ``high``; not-a-number stays."""
    return value if not abs(value) > high else (high if value > 0 else -high)


@without_refcounts
def judge(lanes, commands):  # type: ignore[no-untyped-def]
    """Write the rewards of all lanes' samples, and how they stand; ``commands`` (2, lanes) are those of the samples."""
    for i in range(commands.shape[1]):
        if lanes.ended[i] == END.running:
            _judge(lanes, i, lanes.path[i], commands[0, i], commands[1, i])


@compiled_only
def _judge(lanes, i, s, one, two):  # type: ignore[no-untyped-def]
    """Write the reward of a lane's sample and of the command in it; return whether the episode goes on."""
    k, truth, aim = lanes.clock[i], TruthColumns(lanes.truth, i), SeenColumns(lanes.seen, i).aim
    sums, span = SumColumns(lanes.sums, i), SpanColumns(lanes.spans, s)
    dx, dy = truth.x - aim.x, truth.y - aim.y
    square = dx * dx + dy * dy
    psi = wrapped_compiled(aim.heading - truth.heading)
    if lanes.code == 1:
        w = truth.w  # who commands torques demands no turn rate: the robot's own stands for it
    else:
        w = within(lanes.limits, s, one, two)[1]
    turned = 0.0 if k == 0 else abs(w - lanes.wished[i])
    lanes.wished[i] = w
    near = square < lanes.divergence * lanes.divergence and math.isfinite(one) and math.isfinite(two)
    failed = not near or lanes.touched[i]
    begin, many = span.counted, span.many
    if k >= begin:
        sums.distance += square
        sums.heading += psi * psi
        sums.turning += turned
    if lanes.kind == REWARD.cost:
        cost = lanes.failed if failed else cost_of(lanes, i, s, k)
        lanes.rewards[i] = sums.paid - cost
    else:
        scales = lanes.scales
        now = scales[0] * math.sqrt(square) + scales[1] * abs(psi) + scales[2] * turned / lanes.period
        if k >= begin and begin == 0:  # there is one change less than there are samples
            now += scales[2] * turned / lanes.period / (many - 1)
        now = min(now, lanes.failed) if now == now else lanes.failed
        share = 1.0 if k >= begin else lanes.approach
        cost = share * now
        if failed:
            cost += _rest(lanes, s, k)
        lanes.rewards[i] = -cost / many
    sums.paid -= 0.0 if lanes.kind == REWARD.dense else lanes.rewards[i]
    if failed:
        lanes.ended[i] = END.collided if lanes.touched[i] else END.diverged
    elif k >= span.last:
        lanes.ended[i] = END.time
    return near


@compiled_only
def cost_of(lanes, i, s, k):  # type: ignore[no-untyped-def]
    """The arena's cost of a lane's samples up to ``k``, at most that of a failure."""
    sums, span = SumColumns(lanes.sums, i), SpanColumns(lanes.spans, s)
    samples = k + 1 - span.counted
    if samples <= 0:
        return 0.0
    changes = samples if span.counted > 0 else samples - 1
    cost = lanes.scales[0] * math.sqrt(sums.distance / samples)
    cost += lanes.scales[1] * math.sqrt(sums.heading / samples)
    if changes > 0:
        cost += lanes.scales[2] * sums.turning / (changes * lanes.period)
    return min(cost, lanes.failed)


@compiled_only
def _rest(lanes, s, k):  # type: ignore[no-untyped-def]
    """What the samples after ``k`` cost of an episode that has failed: each as much as can be."""
    span = SpanColumns(lanes.spans, s)
    early = max(span.counted - (k + 1), 0)
    return lanes.failed * (min(span.last - k, span.many) + early * lanes.approach)


@without_refcounts
def collide(lanes, first, last):  # type: ignore[no-untyped-def]
    """End the episodes that go on, and whose robots have touched something on the way to this sample."""
    for i in range(first, last):
        if not (lanes.touched[i] and lanes.ended[i] == END.running):
            continue
        lanes.ended[i] = END.collided
        s, sums = lanes.path[i], SumColumns(lanes.sums, i)
        if lanes.kind == REWARD.cost:
            lanes.rewards[i] -= lanes.failed - sums.paid
            sums.paid = lanes.failed
        else:
            lanes.rewards[i] -= _rest(lanes, s, lanes.clock[i] - 1) / SpanColumns(lanes.spans, s).many


@without_refcounts
def costs(lanes, chosen, found):  # type: ignore[no-untyped-def]
    """Write the arena's cost of some lanes, whose episodes have ended, into ``found``."""
    for n in range(len(chosen)):
        i = chosen[n]
        gone = lanes.ended[i] == END.diverged or lanes.ended[i] == END.collided
        found[n] = lanes.failed if gone else cost_of(lanes, i, lanes.path[i], lanes.clock[i] - 1)


@compiled_only
def _sense(lanes, i):  # type: ignore[no-untyped-def]
    """Measure in one lane, and look up where its reference is."""
    k, period, seen = lanes.clock[i], lanes.period, lanes.seen
    encoders_of(i, lanes.parameters, lanes.truth, lanes.senses.counts, period, seen[VELOCITY : VELOCITY + 2])
    place = min(k, max(lanes.senses.draws.shape[1], lanes.senses.relative_draws.shape[1]) - 1)
    measure_of(i, i, 0, lanes.senses, lanes.truth, seen[:VELOCITY], seen[VELOCITY : VELOCITY + 2], k, place, period)
    aim = SeenColumns(seen, i).aim
    aim.x, aim.y, aim.heading, aim.v, aim.w, aim.s = moving(lanes.road, lanes.path[i], k * period)


@without_refcounts
def sense_first(lanes, chosen):  # type: ignore[no-untyped-def]
    """Measure for the first time in some lanes, whose episodes begin."""
    for i in chosen:
        _sense(lanes, i)


@without_refcounts
def look_around(lanes, looks, first, last):  # type: ignore[no-untyped-def]
    """Read the range sensors of the lanes from ``first`` to before ``last`` that are due by their clocks."""
    turned, here = looks.turned, TruthColumns(lanes.truth)
    for i in range(first, last):
        k = lanes.clock[i]
        due = False
        for q in range(len(looks.every)):
            looks.eyes.due[q] = k % looks.every[q] == 0
            due |= looks.eyes.due[q]
        if due:
            turned[0, i], turned[1, i] = np.cos(here.heading[i]), np.sin(here.heading[i])
            look_of(looks, k, i, 1, lanes.truth)
        for n in range(len(looks.wanted)):
            lanes.ranges[n, i] = looks.readings[i, looks.wanted[n]]


@without_refcounts
def observe_all(lanes, first, last):  # type: ignore[no-untyped-def]
    """Write what is observed in the lanes from ``first`` to before ``last``."""
    for i in range(first, last):
        _observe(lanes, i)


@without_refcounts
def observe_these(lanes, chosen):  # type: ignore[no-untyped-def]
    """Write what is observed in some lanes."""
    for i in chosen:
        _observe(lanes, i)


@compiled_only
def _observe(lanes, i):  # type: ignore[no-untyped-def]
    seen, s = SeenColumns(lanes.seen, i), lanes.path[i]
    last, time = LastColumns(lanes.last, i), lanes.clock[i] * lanes.period
    observe(seen.robot, seen.aim, last, time, lanes.ranges, i, lanes.road, s, lanes.highs[:, s], lanes.observed[i])
