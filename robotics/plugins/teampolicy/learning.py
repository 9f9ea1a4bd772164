"""Learning a policy for teams: imitation of ORCA, then proximal policy optimisation [Schulman 2017].

Whole runs of drawn scenarios are driven in the one compiled loop by a law that notes what it observes, what it answers
and what ORCA would have: :class:`Pupil`. So nothing of the simulator or of the law is written twice.

Imitation [Ross 2011]: ORCA drives, then the network, in round after round; of all that was met so
far the network learns ORCA's commands. Then it is paid, a period of T seconds,

    progress · nominal time − T (near · max(1 − clearance/0.1 m, 0) + rough · |Δanswer|)
                            − contact · [it drives into something]

until it arrives or drives into something. Advantages are generalised ones [Schulman 2016], for each robot by
itself.
"""

import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import asdict, dataclass, field
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np

from fuzzy.compiled.columns import Floats3
from fuzzy.quantity import check_quantities, part, quantity, whole
from robotics.laws.equation import WrittenColumns, equation
from robotics.laws.setting import Setting
from robotics.plugins.reactive.along import REMEMBERED_POINTS
from robotics.plugins.reactive.orca import Orca, avoiding_velocity
from robotics.plugins.reinforcement.neural import answer
from robotics.plugins.reinforcement.policyfile import Policy, PolicyColumns
from robotics.plugins.reinforcement.task import TaskError
from robotics.plugins.stress.tally import Tally
from robotics.plugins.tasks.families import TaskFamily, TaskScenario
from robotics.plugins.teampolicy.law import (
    ALL,
    TEAM_INPUTS,
    TeamPolicy,
    drive_answer,
    look,
    observe_team,
    plain,
    within_bounds,
)
from robotics.simulation.loop import drive_chunk
from robotics.simulation.observer import Observer, observer
from robotics.simulation.opening import Driver, PreparedRuns
from robotics.world.environment.collision import footprints, obstacle_clearance, robot_clearance
from robotics.world.environment.world import place
from robotics.world.vehicle.plant import TruthColumns

_NEAR = 0.1  # m
_LONGEST = 2.0  # nominal times: who stands longer learns nothing from it
_FIRST = 7_000_000  # the number of the first scenario that is learnt on: no arena's block has it
_MOST = (0.6, 3.0)  # m/s and rad/s: what an answer of 1 adds
_POSE = 3  # x [m], y [m], heading [rad], before what the law notes


@dataclass(frozen=True, kw_only=True)
class TeamLearning:
    """How a policy for teams is learnt. Raises TaskError for numbers that cannot be."""

    rounds: int = whole(10, least=0, most=1000, doc="Rounds of imitation.")
    updates: int = whole(60, least=0, most=10**6, doc="How often what was driven then changes the network.")
    scenarios: int = whole(24, least=1, most=10_000, doc="Scenarios that are driven in a round, and before an update.")
    epochs: int = whole(4, least=1, most=100, doc="How often an update sees each sample.")
    batch: int = whole(4096, least=2, doc="Samples of a gradient.")
    rate: float = quantity(1e-3, "1", above=0, doc="The learning rate of imitation; that of updates begins at a third.")
    discount: float = quantity(0.995, "1", above=0, most=0.9999, doc="What a reward counts one period later.")
    smoothing: float = part(0.95, doc="λ of the advantages.")
    clip: float = quantity(0.2, "1", above=0, doc="How far the ratio of probabilities may go.")
    spread: float = quantity(0.1, "1", above=0, doc="The standard deviation of answers; it falls to a third.")
    units: int = whole(64, least=1, most=4096, doc="Units of each of the two hidden layers.")
    contact: float = quantity(80.0, "s", least=0, doc="What it costs to drive into something.")
    near: float = quantity(4.0, "1", least=0, doc="What it costs to be nearer than 10 cm to something, a second.")
    rough: float = quantity(0.2, "1", least=0, doc="What changes of answers cost, a second.")

    def __post_init__(self) -> None:
        check_quantities(self, TaskError)


# Driving to learn --------------------------------------------------------------------------------------------------


@equation
def try_out(robot, gain, memory, command, work, rules, known, i, table):  # type: ignore[no-untyped-def]
    """Drive as the policy, or as its teacher, with noise; note what is observed, answered, and taught."""
    points, policy, notes = work.points, PolicyColumns(rules), command.inputs
    units = points[2 * (3 * known.ranges.shape[0] + REMEMBERED_POINTS) :]
    speed, course, path, count = look(robot, gain, memory, command, known, i, table, points)
    teacher, (v, w) = gain.teacher, plain(robot, gain, speed, course)
    ahead, left = avoiding_velocity(robot, teacher, known, i, table, points, count, units, speed, course)
    best_v, best_w = within_bounds(gain, ahead, left / teacher.point)
    notes[ALL + 2], notes[ALL + 3] = (best_v - v) / policy.first, (best_w - w) / policy.second
    observe_team(robot, gain, memory, command, known, i, table, speed, course, path, count, points, units)
    for n in range(ALL):
        notes[n] = units[n]
    one, two = answer(policy, units)
    if gain.follows:
        one, two = notes[ALL + 2], notes[ALL + 3]
    robots = known.heard.shape[2]
    drawn = len(table) - 2 * (round(known.time / known.dt) * robots + i % robots)
    one, two = one + table[drawn - 1], two + table[drawn - 2]
    notes[ALL], notes[ALL + 1] = one, two
    drive_answer(robot, gain, memory, command, policy, speed, course, one, two)


@dataclass(frozen=True, kw_only=True)
class Pupil(TeamPolicy):
    """A policy for teams that tries out, and notes what comes of it."""

    teacher: Orca = field(default_factory=lambda: Orca(margin=0.06, horizon=4.0, horizon_seen=1.0))
    follows: bool = False  # whether the teacher drives
    spread: float = quantity(0.0, "1", least=0)  # the standard deviation of what is added to its answers
    seed: float = quantity(1.0, "1", least=0)  # of that

    equation = try_out

    @property
    def rule_inputs(self) -> int:
        """What it notes: the observation, its answer, and that of the teacher."""
        return ALL + 4

    def working_for(self, robots: int, sensors: int) -> int:
        """Room for what the teacher works in, too."""
        return super().working_for(robots, sensors) + self.teacher.working_for(robots, sensors)

    def tables(self, setting: Setting) -> np.ndarray:
        """As the policy's; behind it what is added to the answers, two numbers a period and robot, the last first."""
        noise = np.random.default_rng(int(self.seed)).normal(
            0, self.spread, (setting.ticks + 1) * 2 * len(setting.robots)
        )
        return np.concatenate([super().tables(setting), noise[None]], axis=1)


class PeriodNotes(NamedTuple):
    """What was noted of one run."""

    values: Floats3  # (periods, numbers, robots): the pose, the law's notes, and the share of the path


@observer
def note_period(moment, notes):  # type: ignore[no-untyped-def]
    """Note a period."""
    for i in range(moment.robots):
        truth, row, out = TruthColumns(moment.truth, i), notes.values[moment.k, :, i], WrittenColumns(moment.command, i)
        row[0], row[1], row[2] = truth.x, truth.y, truth.heading
        for n in range(len(out.values) - moment.values):
            row[_POSE + n] = out.values[moment.values + n]
        row[-1] = out.progress
    return False


class _Blame(Tally):
    """A tally that knows when a robot drove into something."""

    def asked(self, k: int) -> int | None:
        before, end = self.caused.copy(), super().asked(k)
        self.when = np.where(self.caused & ~before, k, getattr(self, "when", np.full(self.caused.shape, -1)))
        return end


class Driven(NamedTuple):
    """What one robot met in one run."""

    observed: np.ndarray  # (periods + 1, ALL)
    answered: np.ndarray  # (periods, 2)
    taught: np.ndarray  # (periods, 2): what the teacher would have answered
    paid: np.ndarray  # (periods,) s
    over: bool  # nothing comes after it: the robot has arrived, or has driven into something
    caused: bool  # the latter


def driven(scenario: TaskScenario, law: Pupil, about: TeamLearning) -> list[Driven]:
    """Drive a scenario, and tell of each robot what is learnt from."""
    setting, robots = scenario.setting, len(scenario.setting.robots)
    nominal, period = float(setting.references.ends[0, 0]), setting.period
    limit = _LONGEST * nominal + scenario.facts["held_up_s"]
    ticks = min(setting.ticks, round(limit / period))
    tally = _Blame(setting, np.array([limit]), 0, 1)
    notes = PeriodNotes(np.zeros((ticks + 1, _POSE + law.rule_inputs + 1, robots)))
    opening = PreparedRuns.of([Driver(setting, law)], (scenario.seed,), scenario.faults)
    _, end = drive_chunk(opening, 0, 1, tally.observer.beside(Observer(note_period, notes)), ticks)
    values, arrived = notes.values[: end + 1], tally.known.arrivals[0]
    gaps = clearances(setting, values[:, :_POSE])
    own = values[:, _POSE:]
    found = []
    for i in range(robots):
        caused = bool(tally.caused[0, i])
        last = tally.when[0, i] if caused else min(end, arrived[i] / period)
        some = own[: round(last) + 1, :, i]
        changed = np.abs(np.diff(np.clip(some[:, ALL : ALL + 2], -1, 1), axis=0)).sum(axis=1)
        near = np.maximum(1 - np.maximum(gaps[1 : len(some), i], 0) / _NEAR, 0)
        paid = nominal * np.diff(some[:, -1]) - period * (about.near * near + about.rough * changed)
        if len(paid) and caused:
            paid[-1] -= about.contact
        over = caused or bool(np.isfinite(arrived[i]))
        found.append(Driven(some[:, :ALL], some[:-1, ALL : ALL + 2], some[:-1, ALL + 2 : -1], paid, over, caused))
    return [one for one in found if len(one.paid)]


def clearances(setting: Setting, poses: np.ndarray) -> np.ndarray:
    """How far robots were from all else (periods, robots) [m]; ``poses`` are (periods, 3, robots) [m, rad]."""
    sizes, (x, y, heading) = footprints(setting.robots), np.ascontiguousarray(poses.transpose(1, 0, 2))
    gaps, world = robot_clearance(x, y, heading, sizes), setting.world
    if world is None:
        return gaps
    if world.motion is None:
        return np.minimum(gaps, obstacle_clearance(x, y, heading, sizes, world.rest))
    here, moving = world.during(setting.times[: len(x)], np.zeros(1, dtype=np.int64))
    for k in range(len(x)):
        place(here, moving, k)
        now = slice(k, k + 1)
        gaps[now] = np.minimum(gaps[now], obstacle_clearance(x[now], y[now], heading[now], sizes, here))
    return gaps


def advantages(paid: np.ndarray, values: np.ndarray, discount: float, smoothing: float) -> np.ndarray:
    """Generalised advantages (periods,) of what was ``paid`` (periods,), by the ``values`` (periods + 1,) of states."""
    from scipy.signal import lfilter

    delta = paid + discount * values[1:] - values[:-1]
    return np.asarray(lfilter([1.0], [1.0, -discount * smoothing], delta[::-1])[::-1])


# Learning ----------------------------------------------------------------------------------------------------------


def learn_team(
    families: Sequence[TaskFamily],
    about: TeamLearning | None = None,
    *,
    seed: int = 0,
    announce: Callable[[str, int, Sequence[Driven], Policy], None] = lambda *said: None,
) -> Policy:
    """Learn a policy on scenarios of ``families``, with numbers that no arena has.

    Args:
        families: How scenarios are drawn, each as often as its count says.
        about: How it is learnt.
        seed: Of the network, of what is drawn and of the exploration.
        announce: Called after each round ("imitation") and update ("ppo") with its number, what was driven before it,
            and the policy after it.
    """
    about, began = about or TeamLearning(), time.process_time()
    networks, weights = Networks(about, seed), np.array([f.count for f in families], dtype=float)
    drawn, samples = 0, 0

    def drive(**how: Any) -> list[Driven]:
        nonlocal drawn, samples
        law, runs = Pupil(policy=networks.policy({}), seed=drawn, **how), []
        for family in networks.rng.choice(len(families), about.scenarios, p=weights / weights.sum()):
            runs += driven(families[family].scenario(_FIRST + 100_000 * seed + drawn), law, about)
            drawn += 1
        samples += sum(len(one.paid) for one in runs)
        return runs

    def tell() -> Policy:
        minutes = round((time.process_time() - began) / 60, 1)
        told = {
            "algorithm": "imitation of ORCA, then PPO",
            "seed": seed,
            "steps": samples,
            "minutes": minutes,
            "cores": 1,
        }
        return networks.policy(told | asdict(about))

    met: list[Driven] = []
    for k in range(about.rounds):
        runs = drive(follows=k == 0, spread=about.spread / 2)
        met += runs
        networks.imitate(met)
        announce("imitation", k, runs, tell())
    for k in range(about.updates):
        left = 1 - k / about.updates
        spread = about.spread * (1 + 2 * left) / 3
        runs = drive(spread=spread)
        # At first only the critic learns: it knows nothing
        networks.improve(runs, spread, about.rate / 3 * max(left, 0.05), only_critic=k < about.updates // 20)
        announce("ppo", k, runs, tell())
    return tell()


class Networks:
    """The networks of torch while they learn: of answers, and of values."""

    def __init__(self, about: TeamLearning, seed: int = 0) -> None:
        """Draw their weights by ``seed``, and later the batches."""
        import torch

        torch.manual_seed(seed)
        torch.set_num_threads(1)
        self.torch, self.about, self.rng = torch, about, np.random.default_rng(seed)
        self.actor, self.critic = self._network(2), self._network(1)
        self.weights = [*self.actor.parameters(), *self.critic.parameters()]
        self.imitating = torch.optim.Adam(self.actor.parameters(), lr=about.rate)
        self.improving = torch.optim.Adam(self.weights)

    def _network(self, outputs: int) -> Any:
        nn, sizes = self.torch.nn, (len(TEAM_INPUTS), self.about.units, self.about.units, outputs)
        layers = [nn.Linear(a, b) for a, b in pairwise(sizes)]
        with self.torch.no_grad():
            layers[-1].weight *= 0.01  # it begins by adding next to nothing
            layers[-1].bias[:] = 0.0
        return nn.Sequential(layers[0], nn.Tanh(), layers[1], nn.Tanh(), layers[2])

    def policy(self, told: dict[str, Any]) -> Policy:
        """The policy as it is; ``told`` is how it was learnt."""
        parts = [p.detach().double().numpy().copy() for p in self.actor.parameters()]
        layers = tuple(zip(parts[::2], parts[1::2], strict=True))
        return Policy("velocity", TEAM_INPUTS, np.zeros(ALL), np.ones(ALL), 10.0, layers, _MOST, told)

    def _joined(self, parts: Sequence[np.ndarray]) -> Any:
        return self.torch.from_numpy(np.concatenate(parts)).float()

    def _batches(self, samples: int, size: int) -> Iterator[Any]:
        for _ in range(self.about.epochs):
            yield from self.torch.from_numpy(self.rng.permutation(samples)).split(size)

    def _follow(self, optimiser: Any, loss: Any) -> None:
        optimiser.zero_grad()
        loss.backward()
        self.torch.nn.utils.clip_grad_norm_(self.weights, 0.5)
        optimiser.step()

    def imitate(self, met: Sequence[Driven]) -> None:
        """Learn what the teacher would have answered."""
        o, taught = self._joined([r.observed[:-1] for r in met]), self._joined([r.taught for r in met])
        for some in self._batches(len(o), self.about.batch // 4):
            self._follow(self.imitating, ((self.actor(o[some]) - taught[some]) ** 2).mean())

    def improve(self, runs: Sequence[Driven], spread: float, rate: float, *, only_critic: bool = False) -> None:
        """Make an update of PPO.

        Args:
            runs: What robots met under the actor.
            spread: The standard deviation of the noise that was added to its answers.
            rate: The learning rate.
            only_critic: Whether the actor stays.
        """
        torch, actor, critic, about = self.torch, self.actor, self.critic, self.about
        self.improving.param_groups[0]["lr"] = rate
        o, a = self._joined([r.observed[:-1] for r in runs]), self._joined([r.answered for r in runs])
        gains, aims = [], []
        with torch.no_grad():
            before = -0.5 * (((a - actor(o)) / spread) ** 2).sum(-1)
            for r in runs:
                values = critic(torch.from_numpy(r.observed).float())[:, 0].double().numpy()
                values[-1] *= not r.over
                gains.append(advantages(r.paid, values, about.discount, about.smoothing))
                aims.append(gains[-1] + values[:-1])
        g, aimed = self._joined(gains), self._joined(aims)
        g = (g - g.mean()) / (g.std() + 1e-8)
        for some in self._batches(len(o), about.batch):
            loss = ((critic(o[some])[:, 0] - aimed[some]) ** 2).mean() / (1 + aimed.var())
            if not only_critic:
                ratio = torch.exp(-0.5 * (((a[some] - actor(o[some])) / spread) ** 2).sum(-1) - before[some])
                clipped = ratio.clamp(1 - about.clip, 1 + about.clip)
                loss = loss - torch.minimum(ratio * g[some], clipped * g[some]).mean()
            self._follow(self.improving, loss)
