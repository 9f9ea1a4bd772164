"""The one simulation: sense, hear, decide, obey, say, move; all seeds of a setting in one array pass.

Every run draws from its own generator, seeded by its own seed: a run's result does not depend, to the last bit,
on which runs are beside it.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from fuzzy.errors import InputError
from robotics.environment.collision import footprints
from robotics.laws.catalogue import as_law
from robotics.laws.foreign import begun, commanded
from robotics.laws.law import Command, Law, Observation, check_needs
from robotics.laws.setting import Setting
from robotics.paths.references import sampled
from robotics.paths.trajectory import Reference
from robotics.radio.channel import Channel, Heard
from robotics.radio.faults import Faults
from robotics.scenario.description import Scenario
from robotics.sensing.carried import CarriedSensors
from robotics.sensing.posture import PostureSensors, wheel_errors, wheel_odometry
from robotics.simulation.recorder import Recorder
from robotics.simulation.run import Run
from robotics.simulation.state import State
from robotics.vehicle import plant as p


class SimulationError(InputError):
    """A simulation that cannot start: no seeds, or a seed that is no whole number >= 0."""


def drive(setting: Setting, law: Law[Any], seeds: Sequence[int], faults: Faults | None = None) -> Iterator[State]:
    """Drive robots period by period; yield the state of each period before its robots move.

    A robot whose command is not finite, or that is farther than ``setting.divergence`` from its target, is stopped.

    Args:
        setting: A compiled scenario, or an ensemble.
        law: The law that drives all robots.
        seeds: The seeds, one for each run.
        faults: The faults of every run; by default those of the setting.

    Raises SimulationError, and what the law raises.
    """
    simulation = Simulation.opened(setting, law, seeds, faults)
    state = simulation.start()
    while True:
        for step in (simulation.sense, simulation.hear, simulation.decide, simulation.obey):
            state = step(state)
        yield state
        if state.k == setting.ticks:
            return
        state = simulation.move(simulation.say(state))


@dataclass(frozen=True, eq=False)
class Simulation:
    """What does not change while a simulation goes on, and the steps of a period, each from a State to a State.

    A step changes no state. Noise and losses are drawn from the seeds' generators in the order of time, so a step with
    noise is taken once in every period.
    """

    setting: Setting
    law: Law[Any]
    seeds: tuple[int, ...]
    faults: Faults | None
    plant: p.Plant
    postures: PostureSensors
    sensors: CarriedSensors | None  # none: the law needs none, or there is nothing to see
    channel: Channel | None  # none: the law says nothing
    sizes: np.ndarray  # of the robots, as of robotics.environment.collision
    known: np.ndarray | None  # (fields, samples, robots): references that are the same for all runs, looked up at once
    late: tuple[int, int]  # latency: whole periods, and steps of the plant beyond them
    begin: np.ndarray  # (plant channels, lanes)

    @classmethod
    def opened(
        cls, setting: Setting, law: Law[Any], seeds: Sequence[int], faults: Faults | None = None
    ) -> "Simulation":
        """Open a simulation; arguments as of :func:`drive`. Raises SimulationError, RadioError, or ControllerError."""
        seeds = checked_seeds(seeds)
        check_needs(setting, law)
        robots = len(setting.robots)
        parameters = np.tile(np.stack([p.parameters(robot, p.STEP) for robot in setting.robots], axis=1), len(seeds))
        errors = wheel_errors(setting.sensing, seeds)
        if errors is not None:
            parameters[p.P_ODO_RIGHT : p.P_ODO_HALF_AXLE + 1] *= errors
        steps = round(setting.period / p.STEP)
        generators = [np.random.default_rng(seed) for seed in seeds]
        begin = _start(setting, generators)
        looks = law.looks and setting.world is not None and any(setting.sensors)
        if faults is None and setting.faults:
            faults = Faults.drawn(setting.faults, robots, seeds)
        return cls(
            setting,
            law,
            seeds,
            faults,
            p.Plant(parameters, steps=steps, step=p.STEP, kinematic=setting.plant == "kinematic"),
            PostureSensors.of(setting.sensing, setting.ticks, generators, seeds),
            CarriedSensors.opened(setting.sensors, seeds, setting.period) if looks else None,
            Channel.opened(setting.radio, law.message, robots, seeds, setting.period) if law.message else None,
            footprints(setting.robots),
            None if setting.ensemble else np.stack(sampled(setting.references, setting.times)),
            divmod(round(setting.latency / p.STEP), steps),
            begin,
        )

    def start(self) -> State:
        """The state before the first period: at rest, nothing sensed, nothing heard."""
        shape = len(self.seeds), len(self.setting.robots)
        rest, none = np.zeros((2, shape[0] * shape[1])), np.zeros(shape)
        counts, _ = wheel_odometry(self.plant.parameters, self.begin, rest, self.setting.period)
        reference = self._reference(0, 0.0)
        return State(
            k=0,
            time=0.0,
            truth=self.begin.reshape(-1, *shape),
            counts=counts,
            reference=reference,
            posture=None,
            v=none,
            w=none,
            echoes=self.sensors.init() if self.sensors else (),
            ranges=None,
            air=self.channel.init(shape[0]) if self.channel else None,
            condition=None,
            heard=Heard.nothing(*shape),
            memory=begun(self.law, self.setting, shape[0]),
            command=Command(none, none, none, none),
            target=reference,
            order=np.zeros((2, *shape)),
            held_for=0.0,
            stopped=np.full(shape, -1),
            lost=np.zeros(shape, dtype=bool),
            all_drive=True,
            pending=(rest,) * (self.late[0] + 2),
        )

    def sense(self, state: State) -> State:
        """Measure encoders, postures and ranges, and look up where the reference is by now."""
        period, truth = self.setting.period, state.truth
        lanes = truth.reshape(len(truth), -1)
        counts, velocities = wheel_odometry(self.plant.parameters, lanes, state.counts, period)
        v, w = velocities.reshape(2, *truth.shape[1:])
        posture = self.postures.measure(state.time, truth, state.posture, v, w, period)
        state = state.then(counts=counts, v=v, w=w, posture=posture, reference=self._reference(state.k, state.time))
        if self.sensors is None or self.setting.world is None:
            return state
        pose, here = truth[: p.HEADING + 1], self.setting.world.at(state.time)
        ranges, echoes = self.sensors.sense(state.echoes, state.k, pose, self.sizes, here)
        return state.then(ranges=ranges, echoes=echoes)

    def hear(self, state: State) -> State:
        """Find out who is at fault, and receive what the radio brings."""
        if self.faults is not None:
            state = state.then(condition=self.faults.at(state.time))
        if self.channel is None or state.air is None:
            return state
        heard, air = self.channel.hear(state.air, state.k, state.condition)
        return state.then(heard=heard, air=air)

    def decide(self, state: State) -> State:
        """Ask the law for its command."""
        assert state.posture is not None
        x, y, heading = state.posture
        references = self.setting.references
        seen = Observation(
            state.time, x, y, heading, state.v, state.w, state.reference, references, state.heard, state.ranges
        )
        command, memory = commanded(self.law, seen, state.memory, self.setting.period)
        return state.then(command=command, memory=memory, target=command.target or state.reference)

    def obey(self, state: State) -> State:
        """Make the order of the command: a robot at fault holds its last one or stands. Notice who is lost."""
        command, target, condition = state.command, state.target, state.condition
        wish = np.empty_like(state.order)
        wish[0], wish[1] = command.first, command.second
        offset = (state.truth[p.X] - target.x) ** 2 + (state.truth[p.Y] - target.y) ** 2
        finite = np.isfinite(wish)
        lost = ~(finite[0] & finite[1] & (offset < self.setting.divergence**2))
        if not state.all_drive:
            lost &= state.stopped < 0
        if condition is None:
            return state.then(order=wish, lost=lost, held_for=0.0)
        # Without a new command a robot holds its last, until its watchdog stops it.
        held_for = np.where(condition.held, state.held_for + self.setting.period, 0.0)
        wish = np.where(condition.held, state.order, wish)
        wish = np.where(condition.failed | (held_for > self.law.watchdog + 1e-9), 0.0, wish)
        return state.then(order=wish, lost=lost, held_for=held_for)

    def say(self, state: State) -> State:
        """Broadcast the message of every robot."""
        if self.channel is None or state.air is None or state.command.message is None:
            return state
        x, y = state.truth[p.X], state.truth[p.Y]
        return state.then(air=self.channel.send(state.air, state.k, state.command.message, x, y, state.condition))

    def move(self, state: State) -> State:
        """Stop the robots that are lost, and move the plant by one period."""
        order, stopped = state.order, state.stopped
        all_drive = state.all_drive and np.count_nonzero(state.lost) == 0
        if not all_drive:
            stopped = np.where(state.lost, state.k, stopped)
            order = np.where(stopped >= 0, 0.0, order)
        periods, steps = self.late
        pending = (order.reshape(2, -1), *state.pending[:-1])
        lanes = state.truth.reshape(len(state.truth), -1)
        moved = self.plant.advance(lanes, pending[periods + 1], pending[periods], steps, self.law.level)
        k = state.k + 1
        return state.then(
            k=k,
            time=k * self.setting.period,
            truth=moved.reshape(state.truth.shape),
            order=order,
            stopped=stopped,
            all_drive=all_drive,
            pending=pending,
        )

    def _reference(self, k: int, time: float) -> Reference:
        return self.setting.references.at(time) if self.known is None else Reference(*self.known[:, k])


def simulate(
    scenario: Scenario,
    controller: Law[Any] | str,
    seeds: Sequence[int] = (0,),
    *,
    name: str = "",
    links: bool = False,
    faults: Faults | None = None,
    progress: Callable[[], None] | None = None,
) -> Run:
    """Run ``controller`` on ``scenario`` once for every seed.

    A robot whose command is not finite, or that is farther than ``scenario.divergence`` from its target, is
    stopped: ``Run.stopped`` says when, and its samples after that are not-a-number.

    Args:
        scenario: The scenario.
        controller: The law that drives all robots, or its specification, as :func:`make_controller` takes it.
        seeds: Whole numbers >= 0, one for each run.
        name: What the run calls the controller; by default its specification, or else its class.
        links: Whether the run keeps how old each robot's knowledge of each other was, as ``Run.links``.
        faults: The faults of every run, which may differ; by default those of the scenario.
        progress: Called after every period.

    Raises SimulationError for the seeds, ControllerError where the law cannot drive the scenario.
    """
    law = as_law(controller)
    name = name or (controller if isinstance(controller, str) else "")
    return record(scenario.setting, law, seeds, name=name, links=links, faults=faults, progress=progress)


def record(
    setting: Setting,
    law: Law[Any],
    seeds: Sequence[int],
    *,
    name: str = "",
    links: bool = False,
    faults: Faults | None = None,
    progress: Callable[[], None] | None = None,
) -> Run:
    """:func:`simulate` for a setting: a compiled scenario, or an ensemble of one run."""
    seeds = checked_seeds(seeds)
    recorded = Recorder(setting, law, len(seeds), links=links)
    for state in drive(setting, law, seeds, faults):
        recorded.keep(state)
        if progress is not None:
            progress()
    return recorded.run(setting, seeds, name or type(law).__name__)


def checked_seeds(seeds: Sequence[int]) -> tuple[int, ...]:
    """``seeds`` as whole numbers. Raises SimulationError where there are none, or one is none."""
    for seed in seeds:
        if isinstance(seed, bool) or not isinstance(seed, (int, np.integer)) or seed < 0:
            raise SimulationError(f"a seed is a whole number >= 0, got {seed!r}")
    if len(seeds) == 0:
        raise SimulationError("at least one seed is needed")
    return tuple(int(seed) for seed in seeds)


def _start(setting: Setting, generators: Sequence[np.random.Generator]) -> np.ndarray:
    """The state at time 0: each robot a little off where it believes to stand, as its sensing says."""
    shape = (len(generators), len(setting.robots), 3)
    believed = np.broadcast_to(setting.starts, shape).reshape(-1, 3)
    spread = [(s.start_position, s.start_position, s.start_heading) for s in setting.sensing]
    draws = np.concatenate([g.standard_normal(shape[1:]) for g in generators])
    return p.initial_state(believed + draws * np.tile(spread, (len(generators), 1)), believed)
