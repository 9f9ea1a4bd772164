"""The reward of episodes: an observer that pays every robot for every sample of its run.

The reward of a sample is known when the next one is: a robot that touches something on the way there pays for it. So
an observer of :func:`reward_observer` settles the last sample and then pays the present one, and an environment, whose
step ends with the next sample, pays and then settles. A plain run is given the return of the environment that is fed
the same commands, to the last bit.
"""

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from fuzzy.compiled.columns import Bools1, Columns, Floats1, Floats2, Ints1, Ints2, codes, column
from fuzzy.compiled.jit import compiled_only, kernel, without_refcounts
from robotics.laws.equation import CommandColumns, SeenColumns
from robotics.measures.tracking import moves_on
from robotics.plugins.reinforcement.task import RewardKind, check_reward
from robotics.simulation.observer import Observer, observer
from robotics.simulation.scenario.description import Scenario
from robotics.simulation.steps import on_course
from robotics.studies.tuning.cost import COST_TERMS, FAILED_COST
from robotics.world.environment.swept import ContactWatch, watch_contacts
from robotics.world.environment.world import Geometry, Moving
from robotics.world.paths.posture import wrapped_compiled
from robotics.world.vehicle.plant import Level, TruthColumns, velocity_limits, within

REWARD = codes(RewardKind)
END = codes(("running", "diverged", "collided", "time"))  # how an episode stands, or how it has ended
SCALES = tuple(term.weight / term.scale for term in COST_TERMS)  # 1/m, 1/rad, s²/rad: of the arena's cost


class RewardColumns(Columns):
    """What is known of a lane's episode."""

    distance = column("m²", "Σ d²")
    heading = column("rad²", "Σ ψ²")
    turning = column("rad/s", "Σ |Δω|")
    turn_rate = column("rad/s", "demanded in the last sample; not-a-number: nothing was")
    reward = column("1", "of the last sample")
    earned = column("1", "the rewards of those before it")


class SpanColumns(Columns):
    """The samples of a robot's episode; whole numbers."""

    last = column("1", "the last sample")
    counted = column("1", "the first that is counted")
    many = column("1", "how many are counted")


class EpisodeNotes(NamedTuple):
    """What is known of the episode of every lane; each has a clock and a scenario of its own."""

    period: float  # s
    kind: int  # of REWARD
    torques: int  # 1: these are commanded, and no turn rate is demanded
    approach: float  # what a sample before the counted ones counts
    failed: float  # what an episode costs in which the robot was stopped or touched something
    divergence: float  # m
    scales: Floats1  # (3,) of the cost's terms
    limits: Floats2  # (4, robots of all scenarios): as of robotics.world.vehicle.plant.velocity_limits
    spans: Ints2  # (SpanColumns, robots of all scenarios)
    robot: Ints1  # (lanes,): its robot among these
    clock: Ints1  # (lanes,): the sample that is paid next
    ended: Ints1  # (lanes,): of END
    touched: Bools1  # (lanes,): the robot has touched something
    columns: Floats2  # (RewardColumns, lanes)


class RewardNotes(NamedTuple):
    """The notes of the observer: all episodes, and the contacts of their robots."""

    episodes: EpisodeNotes
    watch: ContactWatch

    @property
    def returned(self) -> np.ndarray:
        """The return of each lane's episode (lanes,), so far or in all."""
        known = RewardColumns(self.episodes.columns)
        return np.asarray(known.earned + known.reward)


def reward_observer(
    scenario: Scenario, runs: int = 1, *, level: Level = "velocity", reward: RewardKind = "dense", approach: float = 0.0
) -> Observer:
    """The observer that pays ``runs`` runs of a scenario; ``notes.returned`` is what each robot's episode returns.

    The other arguments are as of :class:`robotics.plugins.reinforcement.vector.TrackingVectorEnv`. Raises TaskError.
    """
    check_reward(level, reward, approach)
    setting, robots = scenario.setting, len(scenario.setting.robots)
    here, moving = Geometry.nothing(), Moving.nothing()
    if setting.world is not None:
        here, moving = setting.world.during(setting.times, np.zeros(1, dtype=np.int64))
    episodes = opened((scenario,), np.tile(np.arange(robots), runs), level, reward, approach)
    return Observer(settle_and_pay, RewardNotes(episodes, ContactWatch.opened(setting.robots, runs, here, moving)))


def opened(
    scenarios: Sequence[Scenario], robot: np.ndarray, level: Level, kind: RewardKind, approach: float
) -> EpisodeNotes:
    """Before the first sample of all lanes, each with the ``robot`` (lanes,) of its number among all scenarios'."""
    columns = RewardColumns.zeros(len(robot))
    columns.turn_rate = np.nan
    return EpisodeNotes(
        float(scenarios[0].period),
        getattr(REWARD, kind),
        int(level == "torque"),
        float(approach),
        float(FAILED_COST),
        float(scenarios[0].divergence),
        np.array(SCALES),
        np.ascontiguousarray(velocity_limits([robot for s in scenarios for robot in s.setting.robots])),
        np.ascontiguousarray(np.concatenate([spans(s) for s in scenarios], axis=1)),
        robot,
        np.zeros(len(robot), dtype=np.int64),
        np.full(len(robot), END.running),
        np.zeros(len(robot), dtype=bool),
        columns.array,
    )


def spans(scenario: Scenario) -> np.ndarray:
    """The samples of the episodes of a scenario's robots (SpanColumns, robots) int: J counts from 6 s on."""
    counted = np.argmax(moves_on(scenario.trajectory.sampled(scenario.times).v.T, scenario.times), axis=1)
    last = np.full_like(counted, scenario.ticks)
    return np.stack([last, counted, last + 1 - counted])


@observer
def settle_and_pay(moment, notes):  # type: ignore[no-untyped-def]
    """Settle the last sample and pay the present one, in all lanes whose episodes go on."""
    settle(moment, notes)
    pay(0, len(notes.episodes.ended), moment, notes.episodes)
    return False


@kernel(nogil=True)
def settle(moment, notes):  # type: ignore[no-untyped-def]
    """Look for contacts in the runs that are watched; end the episodes whose robots touch something by this moment.

    The period of the moment counts where obstacles move.
    """
    known, watch = notes.episodes, notes.watch
    if watch.contacts.since.shape[1] == 0:  # there is nothing to touch
        return
    watch_contacts(moment.k, np.array([0.0, moment.period]), moment.truth, watch)
    robots = watch.contacts.counts.shape[1]
    for i in range(len(known.ended)):
        known.touched[i] = watch.contacts.counts[i // robots, i % robots] > 0
        k = known.clock[i]
        if not known.touched[i] or known.ended[i] != END.running or k == 0:
            continue
        known.ended[i] = END.collided
        own, span = RewardColumns(known.columns, i), SpanColumns(known.spans, known.robot[i])
        if known.kind == REWARD.cost:
            own.reward -= known.failed + (own.earned + own.reward)
        else:
            own.reward -= _rest(span, k - 1, known.approach, known.failed) / span.many


@without_refcounts
def pay(first, last, moment, notes):  # type: ignore[no-untyped-def]
    """Pay the samples of the lanes from ``first`` to before ``last`` whose episodes go on, each by its own clock.

    Their ``notes``, EpisodeNotes, tell how they stand after that.
    """
    scales = notes.scales
    for i in range(first, last):
        if notes.ended[i] != END.running:
            continue
        k, command = notes.clock[i], CommandColumns(moment.command, i)
        truth, aim = TruthColumns(moment.truth, i), SeenColumns(moment.seen, i).aim
        own, span = RewardColumns(notes.columns, i), SpanColumns(notes.spans, notes.robot[i])
        dx, dy = truth.x - aim.x, truth.y - aim.y
        square = dx * dx + dy * dy
        psi = wrapped_compiled(aim.heading - truth.heading)
        if notes.torques == 1:
            w = truth.w  # who commands torques demands no turn rate: the robot's own stands for it
        else:
            w = within(notes.limits, notes.robot[i], command.first, command.second)[1]
        turned = 0.0 if k == 0 else abs(w - own.turn_rate)
        own.turn_rate = w
        failed = notes.touched[i] or not on_course(command.first, command.second, truth, aim, notes.divergence)
        if k >= span.counted:
            own.distance += square
            own.heading += psi * psi
            own.turning += turned
        own.earned += own.reward
        if notes.kind == REWARD.cost:
            cost = notes.failed if failed else _cost(own, span, k, notes.period, scales, notes.failed)
            own.reward = -(own.earned + cost)
        else:
            now = scales[0] * math.sqrt(square) + scales[1] * abs(psi) + scales[2] * turned / notes.period
            if k >= span.counted and span.counted == 0:  # there is one change less than there are samples
                now += scales[2] * turned / notes.period / (span.many - 1)
            now = min(now, notes.failed) if now == now else notes.failed
            cost = now if k >= span.counted else notes.approach * now
            if failed:
                cost += _rest(span, k, notes.approach, notes.failed)
            own.reward = -cost / span.many
        if failed:
            notes.ended[i] = END.collided if notes.touched[i] else END.diverged
        elif k >= span.last:
            notes.ended[i] = END.time
        notes.clock[i] = k + 1


@compiled_only
def _cost(own, span, k, period, scales, most):  # type: ignore[no-untyped-def]
    """The arena's cost of a lane's samples up to ``k``, at ``most`` that of a failure."""
    samples = k + 1 - span.counted
    if samples <= 0:
        return 0.0
    changes = samples if span.counted > 0 else samples - 1
    cost = scales[0] * math.sqrt(own.distance / samples)
    cost += scales[1] * math.sqrt(own.heading / samples)
    if changes > 0:
        cost += scales[2] * own.turning / (changes * period)
    return min(cost, most)


@compiled_only
def _rest(span, k, approach, most):  # type: ignore[no-untyped-def]
    """What the samples after ``k`` cost of an episode that has failed: each as much as can be."""
    early = max(span.counted - (k + 1), 0)
    return most * (min(span.last - k, span.many) + early * approach)


@without_refcounts
def costs(notes, chosen, found):  # type: ignore[no-untyped-def]
    """Write the arena's cost of the ``chosen`` lanes, whose episodes have ended, into ``found``."""
    for n in range(len(chosen)):
        i = chosen[n]
        own, span = RewardColumns(notes.columns, i), SpanColumns(notes.spans, notes.robot[i])
        gone = notes.ended[i] == END.diverged or notes.ended[i] == END.collided
        cost = _cost(own, span, notes.clock[i] - 1, notes.period, notes.scales, notes.failed)
        found[n] = notes.failed if gone else cost
