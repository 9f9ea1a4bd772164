"""A step of all episodes in compiled code: obey, reward, move, sense, observe; each lane has a clock of its own.

A lane is an episode: a run of one robot. The steps are those of :mod:`robotics.simulation.steps`, lane by lane, with
the same functions of one lane below them, so that the same commands give the same run to the last bit.
"""

import math
from typing import NamedTuple

import numpy as np

from fuzzy.compiled.jit import inner, uncounted
from robotics.laws.equation import AT_HEADING, AT_X, AT_Y, V, X
from robotics.laws.tracking.observed import observe
from robotics.paths.posture import wrapped_compiled
from robotics.paths.road import Road, moving
from robotics.sensing.carried import look_of
from robotics.sensing.posture import Senses, encoders_of, measure_of
from robotics.vehicle import plant
from robotics.vehicle.plant import STEP, SUBSTEPS, tick_lanes, within

TRUE_X, TRUE_Y, TRUE_HEADING, TRUE_W = plant.X, plant.Y, plant.HEADING, plant.W

# Rows of Lanes.sums, which the cost of an episode is made of
DISTANCE, HEADING, TURNING, PAID = range(4)  # Σ d² [m²], Σ ψ² [rad²], Σ |Δω| [rad/s], and the cost told so far
SUMS = 4
ENDS, COUNTED, MANY = range(3)  # rows of Lanes.spans: the last sample, the first that is counted, how many are
DENSE, COST = range(2)  # kinds of reward
RUNNING, DIVERGED, COLLIDED, TIME = range(4)  # how an episode stands, or how it has ended


class Lanes(NamedTuple):
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
    spans: np.ndarray  # (3, scenarios) int
    road: Road  # a path for each scenario
    senses: Senses  # of one robot; its random numbers are (lanes, samples, 3, 1)
    parameters: np.ndarray  # (PARAMETERS, lanes)
    truth: np.ndarray  # (CHANNELS, lanes)
    pending: np.ndarray  # (late periods + 2, 2, lanes): orders; that of a turn stands at it modulo their number
    seen: np.ndarray  # (SEEN, lanes), as of robotics.laws.equation
    ranges: np.ndarray  # (sensors, lanes) m
    path: np.ndarray  # (lanes,) int: the scenario
    clock: np.ndarray  # (lanes,) int: the sample
    ended: np.ndarray  # (lanes,) int: RUNNING, or how it has ended
    touched: np.ndarray  # (lanes,) bool: the robot has touched an obstacle
    last: np.ndarray  # (2, lanes): the command of the sample before
    wished: np.ndarray  # (lanes,) rad/s: the turn rate demanded then; not-a-number: nothing was
    sums: np.ndarray  # (SUMS, lanes)
    rewards: np.ndarray  # (lanes,)
    observed: np.ndarray  # (lanes, entries)


@uncounted
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


@inner
def _clipped(value, high):  # type: ignore[no-untyped-def]
    """A value between -``high`` and ``high``; not-a-number stays."""
    return value if not abs(value) > high else (high if value > 0 else -high)


@uncounted
def judge(lanes, commands):  # type: ignore[no-untyped-def]
    """Write the rewards of all lanes' samples, and how they stand; ``commands`` (2, lanes) are those of the samples."""
    for i in range(commands.shape[1]):
        if lanes.ended[i] == RUNNING:
            _judge(lanes, i, lanes.path[i], commands[0, i], commands[1, i])


@inner
def _judge(lanes, i, s, one, two):  # type: ignore[no-untyped-def]
    """Write the reward of a lane's sample and of the command in it; return whether the episode goes on."""
    k, truth, seen = lanes.clock[i], lanes.truth, lanes.seen
    dx, dy = truth[TRUE_X, i] - seen[AT_X, i], truth[TRUE_Y, i] - seen[AT_Y, i]
    square = dx * dx + dy * dy
    psi = wrapped_compiled(seen[AT_HEADING, i] - truth[TRUE_HEADING, i])
    if lanes.code == 1:
        w = truth[TRUE_W, i]  # who commands torques demands no turn rate: the robot's own stands for it
    else:
        w = within(lanes.limits, s, one, two)[1]
    turned = 0.0 if k == 0 else abs(w - lanes.wished[i])
    lanes.wished[i] = w
    near = square < lanes.divergence * lanes.divergence and math.isfinite(one) and math.isfinite(two)
    failed = not near or lanes.touched[i]
    begin, many = lanes.spans[COUNTED, s], lanes.spans[MANY, s]
    if k >= begin:
        lanes.sums[DISTANCE, i] += square
        lanes.sums[HEADING, i] += psi * psi
        lanes.sums[TURNING, i] += turned
    if lanes.kind == COST:
        cost = lanes.failed if failed else cost_of(lanes, i, s, k)
        lanes.rewards[i] = lanes.sums[PAID, i] - cost
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
    lanes.sums[PAID, i] -= 0.0 if lanes.kind == DENSE else lanes.rewards[i]
    if failed:
        lanes.ended[i] = COLLIDED if lanes.touched[i] else DIVERGED
    elif k >= lanes.spans[ENDS, s]:
        lanes.ended[i] = TIME
    return near


@inner
def cost_of(lanes, i, s, k):  # type: ignore[no-untyped-def]
    """The arena's cost of a lane's samples up to ``k``, at most that of a failure."""
    samples = k + 1 - lanes.spans[COUNTED, s]
    if samples <= 0:
        return 0.0
    changes = samples if lanes.spans[COUNTED, s] > 0 else samples - 1
    cost = lanes.scales[0] * math.sqrt(lanes.sums[DISTANCE, i] / samples)
    cost += lanes.scales[1] * math.sqrt(lanes.sums[HEADING, i] / samples)
    if changes > 0:
        cost += lanes.scales[2] * lanes.sums[TURNING, i] / (changes * lanes.period)
    return min(cost, lanes.failed)


@inner
def _rest(lanes, s, k):  # type: ignore[no-untyped-def]
    """What the samples after ``k`` cost of an episode that has failed: each as much as can be."""
    early = max(lanes.spans[COUNTED, s] - (k + 1), 0)
    return lanes.failed * (min(lanes.spans[ENDS, s] - k, lanes.spans[MANY, s]) + early * lanes.approach)


@uncounted
def collide(lanes, first, last):  # type: ignore[no-untyped-def]
    """End the episodes that go on, and whose robots have touched something on the way to this sample."""
    for i in range(first, last):
        if not (lanes.touched[i] and lanes.ended[i] == RUNNING):
            continue
        lanes.ended[i] = COLLIDED
        s = lanes.path[i]
        if lanes.kind == COST:
            lanes.rewards[i] -= lanes.failed - lanes.sums[PAID, i]
            lanes.sums[PAID, i] = lanes.failed
        else:
            lanes.rewards[i] -= _rest(lanes, s, lanes.clock[i] - 1) / lanes.spans[MANY, s]


@uncounted
def costs(lanes, chosen, found):  # type: ignore[no-untyped-def]
    """Write the arena's cost of some lanes, whose episodes have ended, into ``found``."""
    for n in range(len(chosen)):
        i = chosen[n]
        gone = lanes.ended[i] == DIVERGED or lanes.ended[i] == COLLIDED
        found[n] = lanes.failed if gone else cost_of(lanes, i, lanes.path[i], lanes.clock[i] - 1)


@inner
def _sense(lanes, i):  # type: ignore[no-untyped-def]
    """Measure in one lane, and look up where its reference is."""
    k, period, seen = lanes.clock[i], lanes.period, lanes.seen
    encoders_of(i, lanes.parameters, lanes.truth, lanes.senses.counts, period, seen[V : V + 2])
    place = min(k, max(lanes.senses.draws.shape[1], lanes.senses.relative_draws.shape[1]) - 1)
    measure_of(i, i, 0, lanes.senses, lanes.truth, seen[X : X + 3], seen[V : V + 2], k, place, period)
    x, y, heading, v, w, s = moving(lanes.road, lanes.path[i], k * period)
    seen[AT_X, i], seen[AT_Y, i], seen[AT_HEADING, i] = x, y, heading
    seen[AT_X + 3, i], seen[AT_X + 4, i], seen[AT_X + 5, i] = v, w, s


@uncounted
def sense_first(lanes, chosen):  # type: ignore[no-untyped-def]
    """Measure for the first time in some lanes, whose episodes begin."""
    for i in chosen:
        _sense(lanes, i)


@uncounted
def look_around(lanes, looks, first, last):  # type: ignore[no-untyped-def]
    """Read the range sensors of the lanes from ``first`` to before ``last`` that are due by their clocks."""
    turned, truth = looks.turned, lanes.truth
    for i in range(first, last):
        k = lanes.clock[i]
        due = False
        for q in range(len(looks.every)):
            looks.eyes.due[q] = k % looks.every[q] == 0
            due |= looks.eyes.due[q]
        if due:
            turned[0, i], turned[1, i] = np.cos(truth[TRUE_HEADING, i]), np.sin(truth[TRUE_HEADING, i])
            look_of(looks, k, i, 1, truth)
        for n in range(len(looks.wanted)):
            lanes.ranges[n, i] = looks.readings[i, looks.wanted[n]]


@uncounted
def observe_all(lanes, first, last):  # type: ignore[no-untyped-def]
    """Write what is observed in the lanes from ``first`` to before ``last``."""
    for i in range(first, last):
        _observe(lanes, i)


@uncounted
def observe_these(lanes, chosen):  # type: ignore[no-untyped-def]
    """Write what is observed in some lanes."""
    for i in chosen:
        _observe(lanes, i)


@inner
def _observe(lanes, i):  # type: ignore[no-untyped-def]
    time = lanes.clock[i] * lanes.period
    observe(
        i, time, lanes.seen, lanes.ranges, lanes.road, lanes.path[i], lanes.last, lanes.highs, lanes.path[i],
        lanes.observed[i],
    )  # fmt: skip
