"""Demonstrations: what a teacher would do in the states that robots meet, as samples of inputs and outputs.

A learner that saw only the teacher's own runs does not know the way back to them. Half of the runs are therefore
disturbed: they start off the path, and their robots are pushed about [Laskey et al. 2017]. In later rounds the pupil
drives and the teacher says what it would do there [Ross, Gordon & Bagnell 2011].

M. Laskey, J. Lee, R. Fox, A. Dragan, K. Goldberg, "DART: noise injection for robust imitation learning", CoRL 2017.
S. Ross, G. Gordon, J. A. Bagnell, "A reduction of imitation learning and structured prediction to no-regret online
learning", AISTATS 2011.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np

from robotics.laws.equation import EquationLaw
from robotics.laws.law import Command, Law
from robotics.laws.rules.of_reference import CORRECTIONS
from robotics.laws.setting import Setting
from robotics.measures.arrival import at_end
from robotics.measures.contacts import can_touch
from robotics.measures.registry import headlines, measure_all
from robotics.plugins.learning.tandem import TandemMemory, TeacherAndPupil
from robotics.plugins.stress.crossings import crossing_ensemble
from robotics.plugins.stress.obstaclecourse import ObstacleOutcome, obstacle_ensemble
from robotics.plugins.stress.outcome import StressOutcome
from robotics.plugins.stress.tally import run_ensemble
from robotics.simulation.loop import State, drive, simulate
from robotics.simulation.scenario.description import Scenario
from robotics.world.environment.swept import Watch
from robotics.world.paths.posture import wrapped
from robotics.world.paths.road import rows_at
from robotics.world.vehicle.plant import TruthColumns

DISTURBANCE_STREAM = 8  # of a seed's random streams: see robotics.world.random_streams
OFF_START = np.array([0.2, 0.2, 0.3])  # m, m, rad: standard deviations of where a disturbed run starts
PUSHED = np.array([0.05, 0.3])  # m/s, rad/s: standard deviations of what is added to a disturbed run's commands
PUSH_TIME = 1.0  # s: the time constant with which pushes change
_EVERY = 4  # periods from sample to sample
HELD_BACK = 0.5  # of the timing's speed: a teacher that drives no faster holds the robot back
_AFTER = 1.0  # s: samples are taken so long after a robot's arrival
# m/s: a curvature is shown from this speed on. Slower, the same turn rate is a curvature of thousands, of a robot that
# hardly moves, and such samples decided what least squares found.
_SLOWEST = 0.1
_TURNS = ("w", "dw", "bend")  # the outputs of which the teacher's turn rate tells; of the others its speed

_MOMENTS = ("said", "seed", "round", "held_back")  # the fields of Demonstrations that have one row a moment


@dataclass(frozen=True)
class ImitationTask:
    """What is driven."""

    name: str
    setting: Callable[[Sequence[int]], Setting]  # for these seeds
    # The outcome of a law, which has a name, on these seeds: numbers by what they are, with their unit
    judged: Callable[[Law[Any], str, Sequence[int]], dict[str, float]]


def scenario_course(scenario: Scenario) -> ImitationTask:
    """A scenario, judged by what a comparison's short table shows: means over seeds and robots."""

    def judged(law: Law[Any], name: str, seeds: Sequence[int]) -> dict[str, float]:
        run = simulate(scenario, law, seeds, name=name)
        values = measure_all(run)
        found: dict[str, float] = {"robots stopped": float(run.diverged.sum())}
        if can_touch(run):
            found["runs with a contact"] = float((values["contacts"] > 0).any(axis=1).sum())
        for metric, about in headlines(scenario.kind, can_touch(run)).items():
            found[f"{about.short or about.title} [{about.unit}]"] = float(np.mean(values[metric]))
        return found

    return ImitationTask(scenario.name, lambda seeds: scenario.setting, judged)


def crossing_course(robots: int = 3) -> ImitationTask:
    """Random crossings of class A, one for each seed, judged as by ``robotics stress crossing``."""
    name = f"{robots} robots on random crossings"
    return _stress_course(name, StressOutcome, lambda seeds: crossing_ensemble(robots, seeds))


def obstacle_course(robots: int = 1) -> ImitationTask:
    """Random obstacle courses of class A, one for each seed, judged as by ``robotics stress obstacles``."""

    name = f"{robots} robots among random obstacles"
    return _stress_course(name, ObstacleOutcome, lambda seeds: obstacle_ensemble(seeds, "A", robots))


def _stress_course(
    title: str, kind: type[StressOutcome], ensemble: Callable[[Sequence[int]], Setting]
) -> ImitationTask:
    def judged(law: Law[Any], name: str, seeds: Sequence[int]) -> dict[str, float]:
        found = run_ensemble(kind, ensemble(seeds), law, seeds).summary()
        return {what: np.nan if value is None else value for what, value in found.items() if what != "failed_seeds"}

    return ImitationTask(title, ensemble, judged)


class Demonstrations(NamedTuple):
    """Samples of a rule base's inputs, and what the teacher did. Of pairs a robot's moment has several samples."""

    known: np.ndarray  # (samples, inputs), each in its quantity's unit
    moment: np.ndarray  # (samples,) int: the moment of one robot to which it belongs
    said: np.ndarray  # (moments, outputs) m/s, rad/s: by the teacher
    seed: np.ndarray  # (moments,) int
    round: np.ndarray  # (moments,) int: 0: the teacher drove
    held_back: np.ndarray  # (moments,) bool: the teacher is slower than the robot's timing asks

    def where(self, chosen: np.ndarray) -> "Demonstrations":
        """The samples of the moments ``chosen`` (moments,) bool."""
        place = np.cumsum(chosen) - 1
        rows = chosen[self.moment]
        moments = (getattr(self, name)[chosen] for name in _MOMENTS)
        return Demonstrations(self.known[rows], place[self.moment[rows]], *moments)


def joined(parts: Sequence[Demonstrations]) -> Demonstrations:
    """The samples of several drives as one."""
    firsts = np.cumsum([0, *(len(part.said) for part in parts[:-1])])
    moments = [part.moment + first for part, first in zip(parts, firsts, strict=True)]
    known = np.concatenate([part.known for part in parts])
    others = (np.concatenate([getattr(part, name) for part in parts]) for name in _MOMENTS)
    return Demonstrations(known, np.concatenate(moments), *others)


class RunOutcome(NamedTuple):
    """What became of the runs of one course, (runs,) each."""

    touched: np.ndarray  # bool: a robot touched another, or an obstacle
    missing: np.ndarray  # int: robots that were stopped, or did not come to the end of their path in time
    refused: np.ndarray  # bool: the teacher knows no safe way


def demonstrate(
    course: ImitationTask,
    tandem: TeacherAndPupil,
    outputs: Sequence[str],
    seeds: Sequence[int],
    number: int,
    disturbance: float = 0.0,
    advance: Callable[[], None] | None = None,
) -> tuple[Demonstrations, RunOutcome]:
    """Drive a course once for every seed, and take samples of what the teacher would do.

    Args:
        course: What is driven.
        tandem: The teacher and the pupil, and who of them drives.
        outputs: Names of COMMAND_UNITS of :mod:`robotics.plugins.learning.lesson`.
        seeds: One run for each.
        number: Of the round, to be kept with the samples.
        disturbance: How much every second run is disturbed: 1 by OFF_START and PUSHED, 0 not at all.
        advance: Called after every run, when all are done.
    """
    setting = course.setting(seeds)
    # Twice as many values are sent as by one law alone, which no channel was laid out for.
    setting = replace(setting, radio=replace(setting.radio, baud=None))
    if disturbance:
        setting, pushes = disturbed(setting, seeds, disturbance)
        tandem = replace(tandem, pushes=pushes)
    tandem = replace(tandem, every=_EVERY)
    taken = _Taken(setting, np.asarray(seeds), tandem.pupil, number)
    for state in drive(setting, tandem, seeds):
        taken.look(state, outputs)
        if taken.done:
            break
    if advance is not None:
        for _ in seeds:
            advance()
    return joined(taken.parts), taken.outcome


def disturbed(setting: Setting, seeds: Sequence[int], disturbance: float) -> tuple[Setting, np.ndarray]:
    """The setting with every second run's start moved, and pushes (periods, 2, runs, robots) [m/s, rad/s].

    They depend on each run's own seed alone.
    """
    robots = len(setting.robots)
    starts = np.array(np.broadcast_to(setting.starts, (len(seeds), robots, 3)))
    pushes = np.zeros((setting.ticks + 1, 2, len(seeds), robots))
    keep = np.exp(-setting.period / PUSH_TIME)
    for run, seed in enumerate(seeds):
        if (run + run // 4) % 2 == 0:  # of the checking seeds, every fourth, too
            continue
        rng = np.random.default_rng([seed, DISTURBANCE_STREAM])
        starts[run] += disturbance * OFF_START * rng.standard_normal((robots, 3))
        now = rng.standard_normal((2, robots))
        for k in range(len(pushes)):
            pushes[k, :, run] = disturbance * PUSHED[:, None] * now
            now = keep * now + np.sqrt(1 - keep**2) * rng.standard_normal((2, robots))
    return replace(setting, starts=starts), pushes


class _Taken:
    """The samples taken so far of one drive, and what became of its runs."""

    def __init__(self, setting: Setting, seeds: np.ndarray, pupil: Law[Any], number: int) -> None:
        self.setting, self._seeds, self._number = setting, seeds, number
        lead = pupil.knowledge_rows(setting)[0] if isinstance(pupil, EquationLaw) else 0.0
        self._lead = np.broadcast_to(lead, len(setting.robots))  # s: so far ahead it reads the velocity it corrects
        self.parts: list[Demonstrations] = []
        self._catch_up = getattr(pupil, "catch_up", 0.0)
        paths = setting.references.joined
        self._lengths = paths.lengths
        self._goals = paths.at(paths.lengths)
        self._arrivals = np.full((len(seeds), len(setting.robots)), np.inf)
        self._stopped = np.zeros(self._arrivals.shape, dtype=bool)
        self._refused = np.zeros(len(seeds), dtype=bool)
        self._watch: Watch | None = None
        self._time = 0.0

    @property
    def done(self) -> bool:
        """Whether no robot gives samples any more."""
        return not self._going.any()

    @property
    def _going(self) -> np.ndarray:
        going = (self._time <= self._arrivals + _AFTER) & ~self._stopped & ~self._refused[:, None]
        # A run goes on after a contact as if robots could overlap: nothing can be learnt from that
        return going if self._watch is None else going & np.isinf(self._watch.known.first).all(axis=(0, 2))[:, None]

    @property
    def outcome(self) -> RunOutcome:
        """What became of the runs."""
        assert self._watch is not None
        touched = np.isfinite(self._watch.known.first).any(axis=(0, 2))
        # Of a scenario that is over before its reference has arrived nobody arrives
        due = self.setting.references.ends <= self.setting.ticks * self.setting.period
        missing = (~np.isfinite(self._arrivals) & due) | self._stopped
        return RunOutcome(touched, missing.sum(axis=1), self._refused)

    def look(self, state: State, outputs: Sequence[str]) -> None:
        """Take a sample of every robot, if it is time for one, and see what happened."""
        memory: TandemMemory = state.memory
        assert memory.said is not None
        self._time = state.time
        truth = TruthColumns(state.truth)
        poses = state.truth[: TruthColumns.w.row + 1]
        if state.k == 0 and memory.said.refused is not None:
            self._refused = memory.said.refused
        geometry = None if self.setting.world is None else self.setting.world.at(state.time)
        if self._watch is None:
            self._watch = Watch.opened(self.setting.robots, state.time, poses, geometry)
        else:
            self._watch, _ = self._watch.to(state.time, poses, geometry)
        self._stopped |= state.lost | (state.stopped >= 0)
        # The end of a closed path is its start.
        goals = self._goals
        there = at_end(truth.x, truth.y, goals.x, goals.y, goals.heading, self._lengths)
        there = there & (state.time > self.setting.references.ends / 2)
        self._arrivals = np.where(there & np.isinf(self._arrivals), state.time, self._arrivals)
        if state.k % _EVERY == 0:
            said = np.stack([self._label(name, memory.said, state) for name in outputs], axis=-1)
            held_back = memory.said.v < HELD_BACK * state.reference.v
            self._keep(memory, np.broadcast_to(said, (*self._arrivals.shape, len(outputs))), held_back)

    def _label(self, output: str, said: Command, state: State) -> np.ndarray:
        """What the rule base should have said for the teacher's command."""
        # Brought down to what the robots can do, which is all that it comes to
        turns = output in _TURNS
        most = np.array([r.w_max if turns else r.v_max for r in self.setting.robots])
        wish = np.clip(said.w if turns else said.v, -most, most)
        if output not in CORRECTIONS:
            return wish
        # Less the reference's velocity, which the rule base corrects; a bend is multiplied by a speed
        road = self.setting.references.road
        times = state.time + np.resize(self._lead, len(road.lengths))
        v, w = rows_at(road, times)[3:5].reshape(2, -1, len(self._lead))
        if output == "dw":
            return np.asarray(wish - w)
        if output == "bend":
            speed = np.maximum(np.abs(v), np.minimum(np.abs(said.v), self._catch_up))
            return np.asarray((wish - w) / np.where(speed >= _SLOWEST, speed, np.nan))
        return np.asarray(wish - v * np.cos(wrapped(state.reference.heading - state.posture[2])))

    def _keep(self, memory: TandemMemory, said: np.ndarray, held_back: np.ndarray) -> None:
        known = memory.known
        asked = ~np.isnan(known).all(axis=-1) & (self._going & np.isfinite(said).all(axis=-1))[..., None]
        run, robot, _ = np.nonzero(asked)
        moments, of = np.unique(run * said.shape[1] + robot, return_inverse=True)
        runs, robots = np.divmod(moments, said.shape[1])
        seed, number = self._seeds[runs], np.full(len(runs), self._number)
        self.parts.append(Demonstrations(known[asked], of, said[runs, robots], seed, number, held_back[runs, robots]))
