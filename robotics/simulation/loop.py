"""The one simulation: sense, look, hear, decide, obey, watch, say, move, for all robots of all runs.

The loop over periods exists twice, with the same steps, observers and bits: compiled, for laws that have an equation,
and in Python, for any other law and for whoever wants to step by hand. Every run draws from its own generators, seeded
by its own seed, and no lane's arithmetic depends on another run: a run's result does not depend, to the last bit, on
which runs are beside it, nor on how many threads share them out.
"""

from collections.abc import Callable, Collection, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cache, partial
from itertools import count
from multiprocessing import parent_process
from threading import Lock
from typing import Any, cast

import numpy as np

from fuzzy.compiled.jit import kernel, types
from fuzzy.compiled.threads import share_out
from fuzzy.errors import InputError
from robotics.laws.catalogue import as_law
from robotics.laws.equation import EQUATION_TYPE, RobotColumns, SeenColumns, WrittenColumns, compiled
from robotics.laws.foreign import checked_control, checked_init
from robotics.laws.law import Command, Law, Observation
from robotics.laws.setting import Setting
from robotics.laws.universe import say_of_inputs
from robotics.simulation.lanes import KEEP_TYPE, LOOK_TYPE, LOOKS_TYPE, Lanes, keeping, looking, machine_code
from robotics.simulation.observer import Moment, Observer, moment_of, noted_type, watch_type
from robotics.simulation.opening import Driver, PreparedRuns, has_equation
from robotics.simulation.physics import Physics, PhysicsError, as_physics
from robotics.simulation.recorder import OPTIONAL, Recorder
from robotics.simulation.run import Run
from robotics.simulation.safety.monitor import keep_safe
from robotics.simulation.scenario.description import Scenario
from robotics.simulation.steps import decide, hear, move, obey, say, sense
from robotics.world.paths.references import Reference
from robotics.world.radio.channel import Heard
from robotics.world.radio.faults import Faults
from robotics.world.sensing.carried import look as read_ranges
from robotics.world.sensing.sonar import Ranges

CHUNK = 96  # lanes that a compiled loop drives together: their columns stay in a core's own cache
_BLOCK = 100_000  # periods of lanes that it drives at a time: between two blocks it can be interrupted


class SimulationError(InputError):
    """A simulation that cannot start: no seeds, or a seed that is no whole number >= 0."""


# The loop, compiled ----------------------------------------------------------------------------------------------


@kernel(nogil=True, _nrt=False)
def _periods(law, look, keep, watch, looks, notes, k, end, last, halfway, lanes):  # type: ignore[no-untyped-def]
    """Drive from period ``k`` to before ``end``; in ``last``, the last of all, nobody moves any more.

    Returns ``end``, or the period in which the observer wants to be asked something: it is then driven ``halfway``.
    """
    body, known, air, trouble, period = lanes.body, lanes.known, lanes.air, lanes.trouble, lanes.period
    truth, seen, command, order, stops = body.truth, known.seen, lanes.command, lanes.order, lanes.stopped
    while k < end:
        if not halfway:
            sense(
                k, period, body.parameters, truth, lanes.senses, seen, lanes.road, lanes.path, lanes.references,
                lanes.goes_on,
            )  # fmt: skip
            look(looks, k, truth, lanes.robots, known.ranges, lanes.goes_on)
            hear(k, period, trouble, air)
            decide(law, k, lanes.robots, lanes.goes_on, known, lanes.memory, command, lanes.work)
            obey(
                period, lanes.divergence, lanes.watchdog, truth, trouble, command, order, lanes.held_for, stops,
                lanes.lost,
            )  # fmt: skip
            keep(
                lanes.guard, k, period, lanes.robots, truth, seen, lanes.readings, trouble.cut, lanes.goes_on, command,
                order,
            )  # fmt: skip
            moment = Moment(
                k, period, lanes.robots, air.values, air.every, truth, seen, command, order, trouble.code, air.heard,
                lanes.readings, stops, lanes.goes_on,
            )  # fmt: skip
            if watch(moment, notes):
                return k
        halfway = False
        if k < last:
            say(k, period, trouble.cut, air, command, truth)
            move(k, body, order, stops, lanes.lost, lanes.goes_on)
        k += 1
    return k


def drive_chunk(
    opening: PreparedRuns,
    first: int,
    last: int,
    observer: Observer,
    ticks: int,
    advance: Callable[[int], None] | None = None,
) -> tuple[np.ndarray, int]:
    """Drive the runs from ``first`` to before ``last``, under the eyes of ``observer``.

    ``advance`` is called with how many periods of how many runs have gone by. Returns when each robot was stopped, or
    -1, and the last period that was driven: ``ticks``, unless the observer asked for less.
    """
    lanes, supply = opening.lanes(first, last)
    one: Any = opening.drivers[0].law
    law = compiled(type(one).equation)
    loop, look, keep, watch = _loop(observer.classes), supply.look, supply.keep, observer.pointer
    k, halfway, end = 0, False, ticks
    block = max(16, _BLOCK // len(lanes.lost))
    while k <= end:
        lanes = lanes if halfway else supply.to(lanes, k)
        until = min(k + block, supply.last_period(lanes, k), end + 1)
        came = loop(law, look, keep, watch, supply.looks, observer.notes, k, until, ticks, halfway, lanes)
        if advance is not None:
            advance((came - k) * (last - first))
        k, halfway = came, came < until
        if halfway and (found := observer.asked(k)) is not None:
            end = min(end, found)
    if advance is not None:
        advance((ticks + 1 - k) * (last - first))
    return when_stopped(lanes, end), end


@cache
def _loop(classes: Any) -> Any:
    """The machine code of the loop under an observer whose notes are of ``classes``."""
    functions = (types.FunctionType(kind) for kind in (EQUATION_TYPE, LOOK_TYPE, KEEP_TYPE, watch_type(classes)))
    numbers = (types.int64, types.int64, types.int64, types.boolean)
    return machine_code(_periods, *functions, LOOKS_TYPE, noted_type(classes), *numbers)


def when_stopped(lanes: Lanes, k: int) -> np.ndarray:
    """The period in which each robot was stopped, or -1 (runs, robots), after period ``k``."""
    return np.where(lanes.lost, k, lanes.stopped).reshape(-1, lanes.robots)


# The loop, in Python ---------------------------------------------------------------------------------------------


@dataclass(frozen=True, eq=False)
class State:
    """All runs in one period, after the law has decided and before the robots move; arrays are copies.

    They are (runs, robots) unless they say otherwise.
    """

    k: int  # the period
    time: float  # s
    truth: np.ndarray  # (plant channels, runs, robots): the plant's state
    posture: np.ndarray  # (3, runs, robots): x [m], y [m], heading [rad] as measured
    v: np.ndarray  # m/s, from the encoders
    w: np.ndarray  # rad/s, from the encoders
    reference: Reference  # the setting's
    heard: Heard
    ranges: Ranges | None  # what the range sensors read
    memory: Any  # of the law
    command: Command
    target: Reference  # where the law wants the robots to be
    fault: np.ndarray  # int: of robotics.world.radio.faults.FAULTS, or 0
    order: np.ndarray  # (2, runs, robots): the command after faults
    stopped: np.ndarray  # int: the period before this one in which the robot was stopped, or -1
    lost: np.ndarray  # bool: it is stopped in this one


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
    simulation = Simulation(setting, law, checked_seeds(seeds), faults)
    for k, command in simulation.periods():
        yield simulation.state(k, command)


class Simulation:
    """The simulation that the loop in Python drives: the steps of a period, one after the other.

    Its columns, :attr:`lanes`, are those of the compiled loop, and its steps call the same compiled functions.
    """

    def __init__(
        self,
        setting: Setting,
        law: Law[Any],
        seeds: tuple[int, ...],
        faults: Faults | None = None,
        recorder: Recorder | None = None,
        name: str = "",
        observers: Sequence[Observer] = (),
        physics: Physics | None = None,
    ) -> None:
        """Open it; arguments as of :func:`drive`. Raises RadioError, ControllerError, or PhysicsError."""
        setting = setting.seeded(seeds)
        self.setting, self.law, self.runs, self.robots = setting, law, len(seeds), len(setting.robots)
        self.name, self.recorder = name, recorder
        self.observers = [*observers] if recorder is None else [recorder.observer(0, len(seeds)), *observers]
        self.lanes, self.supply = PreparedRuns.of([Driver(setting, law)], seeds, faults).lanes(0, len(seeds))
        own = partial(move, goes_on=self.lanes.goes_on)
        self.mover = own if physics is None else physics.opened(setting, self.lanes.body)
        self.end = setting.ticks
        self.ranges: Ranges | None = None
        self.memory = self.lanes.memory if has_equation(law) else checked_init(law, setting, len(seeds))
        self.speaks = True

    def periods(self) -> Iterator[tuple[int, Command]]:
        """Drive to the end; yield each period and what the law has commanded in it, before anybody speaks or moves."""
        for k in count():
            self.sense(k)
            self.look(k)
            self.hear(k)
            command = self.decide(k)
            self.obey()
            self.keep(k)
            self.watch(k)
            yield k, command
            if k >= self.end:
                break
            self.say(k)
            self.move(k)

    def sense(self, k: int) -> None:
        """Measure encoders and postures, and look up where the references are."""
        self.lanes = self.supply.to(self.lanes, k)
        one = self.lanes
        truth, seen, road = one.body.truth, one.known.seen, one.road
        sense(k, one.period, one.body.parameters, truth, one.senses, seen, road, one.path, one.references, one.goes_on)

    def look(self, k: int) -> None:
        """Read the range sensors."""
        if self.supply.sensors is not None:
            lanes = self.lanes
            looks, ranges = self.supply.looks, lanes.known.ranges
            looking(read_ranges)(looks, k, lanes.body.truth, self.robots, ranges, lanes.goes_on)
            readings = lanes.readings.reshape(self.runs, self.robots, -1).copy()
            self.ranges = Ranges(self.supply.sensors.names, readings)

    def hear(self, k: int) -> None:
        """Find out who is at fault, and receive what the radio brings."""
        hear(k, self.lanes.period, self.lanes.trouble, self.lanes.air)

    def decide(self, k: int) -> Command:
        """Ask the law for its command."""
        if has_equation(self.law):
            law, one = cast(Any, self.law), self.lanes
            WrittenColumns(one.command).target = SeenColumns(one.known.seen).aim
            known = one.known._replace(time=k * one.period)
            compiled(type(law).equation)(0, len(one.lost), known, one.memory, one.command, one.work)
            return cast(Command, law.commanded(self.rows(one.command.copy())))
        lanes = self.lanes
        seen = SeenColumns(self.rows(lanes.known.seen.copy()))  # a law may keep what it is given
        x, y, heading, v, w = seen.robot.array
        now, aim, references = k * self.setting.period, Reference(*seen.aim.array), self.setting.references
        observation = Observation(now, x, y, heading, v, w, aim, references, self.heard(), self.ranges)
        command, self.memory = checked_control(self.law, observation, self.memory, self.setting.period)
        self.told(command)
        return command

    def told(self, command: Command) -> None:
        """Write a command into the columns."""
        out, seen = WrittenColumns(self.rows(self.lanes.command)), SeenColumns(self.rows(self.lanes.known.seen))
        out.first, out.second, out.wish_v, out.wish_w = command[:4]
        for row, of in zip(out.target.array, seen.aim.array if command.target is None else command.target, strict=True):
            row[...] = of
        out.progress = np.nan if command.progress is None else command.progress
        out.mode = 0 if command.mode is None else command.mode
        out.guarded = 0 if command.guarded is None else command.guarded
        out.refused = 0 if command.refused is None else command.refused[:, None]
        if self.recorder is not None and self.recorder.makes_room(command, self.name):
            self.observers[0] = self.recorder.observer(0, self.runs)
        if command.message is not None:
            for row, name in zip(out.values, self.law.message, strict=False):
                row[...] = command.message[name]
        if command.inputs is not None:
            first = len(self.law.message)
            out.values[first : first + len(command.inputs)] = command.inputs
        self.speaks = command.message is not None

    def obey(self) -> None:
        """Make the order of the command, and notice who is lost."""
        one = self.lanes
        obey(
            one.period, one.divergence, one.watchdog, one.body.truth, one.trouble, one.command, one.order,
            one.held_for, one.stopped, one.lost,
        )  # fmt: skip

    def keep(self, k: int) -> None:
        """Let the monitor of passive safety look at the order, where there is one."""
        one = self.lanes
        if one.guard.on == 1:
            keeping(keep_safe)(
                one.guard, k, one.period, self.robots, one.body.truth, one.known.seen, one.readings, one.trouble.cut,
                one.goes_on, one.command, one.order,
            )  # fmt: skip

    def watch(self, k: int) -> None:
        """Let the observers look at the period."""
        moment = moment_of(self.lanes, k)
        for observer in self.observers:
            if observer.look(moment) and (end := observer.asked(k)) is not None:
                self.end = min(self.end, end)

    def say(self, k: int) -> None:
        """Broadcast the message of every robot."""
        if self.speaks:
            one = self.lanes
            say(k, one.period, one.trouble.cut, one.air, one.command, one.body.truth)

    def move(self, k: int) -> None:
        """Stop the robots that are lost, and move the plant by one period."""
        one = self.lanes
        self.mover(k, one.body, one.order, one.stopped, one.lost)

    def rows(self, columns: np.ndarray) -> np.ndarray:
        """Columns (..., lanes) as (..., runs, robots)."""
        return columns.reshape(*columns.shape[:-1], self.runs, self.robots)

    def heard(self) -> Heard:
        """What the radio has brought, of which nothing changes any more."""
        air = self.lanes.air
        return self.supply.channel.heard(air._replace(heard=air.heard.copy()))

    def state(self, k: int, command: Command) -> State:
        """The state of period ``k``, of which nothing changes any more."""
        lanes = self.lanes
        seen = SeenColumns(self.rows(lanes.known.seen.copy()))
        robot, reference = seen.robot, Reference(*seen.aim.array)
        return State(
            k,
            k * self.setting.period,
            self.rows(lanes.body.truth.copy()),
            robot.array[: RobotColumns.v.row],
            robot.v,
            robot.w,
            reference,
            self.heard(),
            self.ranges,
            self.memory.copy() if has_equation(self.law) else self.memory,
            command,
            command.target or reference,
            self.rows(lanes.trouble.code.copy()),
            self.rows(lanes.order.copy()),
            self.rows(lanes.stopped.copy()),
            self.rows(lanes.lost.copy()),
        )


# Whole runs ------------------------------------------------------------------------------------------------------


def simulate(
    scenario: Scenario,
    controller: Law[Any] | str,
    seeds: Sequence[int] = (0,),
    *,
    name: str = "",
    message_ages: bool = False,
    torques: bool = False,
    encoders: bool = False,
    messages: bool = False,
    faults: Faults | None = None,
    progress: Callable[[], None] | None = None,
    threads: int | None = None,
    observer: Observer | None = None,
    plant: Physics | str = "",
) -> Run:
    """Run ``controller`` on ``scenario`` once for every seed.

    A robot whose command is not finite, or that is farther than ``scenario.divergence`` from its target, is
    stopped: ``Run.stopped`` says when, and its samples after that are not-a-number.

    Args:
        scenario: The scenario.
        controller: The law that drives all robots, or its specification, as :func:`make_controller` takes it.
        seeds: Whole numbers >= 0, one for each run.
        name: What the run calls the controller; by default its specification, or else its class.
        message_ages: Whether the run keeps how old each robot's knowledge of each other was, as ``Run.message_ages``.
        torques: Whether the run keeps the torques of the wheels, as ``Run.torques``.
        encoders: Whether the run keeps what the encoders tell, as ``Run.encoders``.
        messages: Whether the run keeps what the robots broadcast, as ``Run.messages``.
        faults: The faults of every run, which may differ; by default those of the scenario.
        progress: Called after every period.
        threads: How many threads share out the runs; by default as many as there are cores. The result is the same.
        observer: Looks at every period of all runs, and may end them: :mod:`robotics.simulation.observer`.
        plant: Other physics that move the robots, such as "mujoco" or "mujoco:friction=0.3"; the loop is then the one
            in Python. By default it is the simulator's own plant.

    Returns:
        All samples of all seeds and robots.

    Raises:
        SimulationError: No seeds, or one that is no whole number >= 0.
        ControllerError: The law cannot drive the scenario.
        PhysicsError: There is no such plant, or it cannot move what the scenario has.
    """
    law = as_law(controller)
    name = name or (controller if isinstance(controller, str) else "")
    asked = dict(zip(OPTIONAL, (message_ages, torques, encoders, messages), strict=True))
    besides = [what for what, kept in asked.items() if kept]
    return record_run(
        scenario.setting, law, seeds, name=name, besides=besides, faults=faults, progress=progress, threads=threads,
        observer=observer, plant=plant,
    )  # fmt: skip


def record_run(
    setting: Setting,
    law: Law[Any],
    seeds: Sequence[int],
    *,
    name: str = "",
    besides: Collection[str] = (),
    faults: Faults | None = None,
    progress: Callable[[], None] | None = None,
    threads: int | None = None,
    observer: Observer | None = None,
    plant: Physics | str = "",
) -> Run:
    """:func:`simulate` for a setting: a compiled scenario, or an ensemble of one run.

    ``besides`` names what is kept of :data:`robotics.simulation.recorder.OPTIONAL`. An ``observer`` looks at all runs,
    as one chunk; the run ends where it wants.
    """
    seeds, name = checked_seeds(seeds), name or type(law).__name__
    physics = as_physics(plant)
    if physics is not None:
        if setting.patches:
            raise PhysicsError(f"the scenario {setting.name} has patches of another friction, and {plant} knows none")
        setting = replace(setting, name=f"{setting.name} in {plant}")
    recorder = Recorder(setting, law, len(seeds), besides=besides)
    if physics is not None or not has_equation(law):
        watching = [observer] if observer else []
        simulation = Simulation(setting, law, seeds, faults, recorder, name, watching, physics)
        for _ in simulation.periods():
            if progress is not None:
                progress()
        end = simulation.end
        return recorder.run(setting, seeds, name, when_stopped(simulation.lanes, end), end + 1)
    opening = PreparedRuns.of([Driver(setting, law)], seeds, faults)
    periods = Periods(setting.ticks + 1, len(seeds), progress)
    if observer is not None:
        both = recorder.observer(0, len(seeds)).beside(observer)
        gone, end = drive_chunk(opening, 0, len(seeds), both, setting.ticks, periods)
    else:
        gone, end = driven(opening, recorder.observer, periods, threads), setting.ticks
    shared = None if setting.ensemble else opening.references
    run = recorder.run(setting, seeds, name, gone, end + 1, references=shared)
    if run.inputs is not None:
        say_of_inputs(law.fuzzy_systems, run.inputs)
    return run


class Periods:
    """Tells a display of periods how far runs are that go on apart from each other."""

    def __init__(self, periods: int, runs: int, progress: Callable[[], None] | None) -> None:
        """``progress`` is called ``periods`` times in all, for ``runs`` runs of so many."""
        self.periods, self.runs, self.progress = periods, runs, progress
        self.done = self.told = 0
        self.lock = Lock()

    def __call__(self, more: int) -> None:
        """Count ``more`` periods of single runs."""
        if self.progress is None:
            return
        with self.lock:
            self.done += more
            while self.told < self.done // self.runs:
                self.told += 1
                self.progress()


def driven(
    opening: PreparedRuns,
    observers: Callable[[int, int], Observer],
    advance: Callable[[int], None],
    threads: int | None = None,
) -> np.ndarray:
    """Drive all runs of a law with an equation, shared out over ``threads``.

    ``observers`` gives the observer of the runs from one number to before another. Returns when each robot was stopped,
    or -1 (runs, robots).
    """
    setting = opening.drivers[0].setting
    size = max(1, CHUNK // len(setting.robots))
    chunks = [(first, min(first + size, opening.runs)) for first in range(0, opening.runs, size)]

    def one(chunk: tuple[int, int]) -> np.ndarray:
        return drive_chunk(opening, *chunk, observers(*chunk), setting.ticks, advance)[0]

    return np.concatenate(share_out(one, chunks, threads_for(threads)))


def threads_for(threads: int | None) -> int | None:
    """The number of ``threads`` of a simulation; by default one in a worker process, which has others beside it."""
    return 1 if threads is None and parent_process() is not None else threads


def checked_seeds(seeds: Sequence[int]) -> tuple[int, ...]:
    """``seeds`` as whole numbers. Raises SimulationError where there are none, or one is none."""
    for seed in seeds:
        if isinstance(seed, bool) or not isinstance(seed, (int, np.integer)) or seed < 0:
            raise SimulationError(f"a seed is a whole number >= 0, got {seed!r}")
    if len(seeds) == 0:
        raise SimulationError("at least one seed is needed")
    return tuple(int(seed) for seed in seeds)
