"""The one simulation: sense, look, hear, decide, obey, record, say, move, for all robots of all runs.

The loop over periods exists twice, with the same steps and the same bits: compiled, for laws that have an equation, and
in Python, for any other law and for whoever looks at every period. Every run draws from its own generators, seeded by
its own seed, and no lane's arithmetic depends on another run: a run's result does not depend, to the last bit, on which
runs are beside it, nor on how many threads share them out.
"""

from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from multiprocessing import parent_process
from threading import Lock
from typing import Any, cast

import numpy as np

from fuzzy.compiled.jit import kernel, types
from fuzzy.compiled.threads import processors
from fuzzy.errors import InputError
from robotics.laws.catalogue import as_law
from robotics.laws.equation import (
    AT_S,
    AT_X,
    EQUATION_TYPE,
    FIRST,
    GUARDED,
    HEADING,
    MODE,
    PROGRESS,
    REFUSED,
    SAYS,
    SECOND,
    TO_S,
    TO_X,
    WISH_V,
    WISH_W,
    V,
    W,
    X,
    Y,
    compiled,
)
from robotics.laws.foreign import begun, commanded
from robotics.laws.law import Command, Law, Observation
from robotics.laws.setting import Setting
from robotics.laws.universe import say_of_inputs
from robotics.paths.trajectory import Reference
from robotics.radio.faults import Faults
from robotics.scenario.description import Scenario
from robotics.sensing.carried import look as read_ranges
from robotics.sensing.sonar import Ranges
from robotics.simulation.lanes import LOOK_TYPE, LOOKS_TYPE, Kept, Lanes, looking, machine_code
from robotics.simulation.opening import Driver, Opening, has_equation
from robotics.simulation.recorder import Recorder
from robotics.simulation.run import Run
from robotics.simulation.state import State
from robotics.simulation.steps import decide, hear, move, obey, record, say, sense

CHUNK = 96  # lanes that a compiled loop drives together: their columns stay in a core's own cache
BLOCK = 100_000  # periods of lanes that it drives at a time: between two blocks it can be interrupted


class SimulationError(InputError):
    """A simulation that cannot start: no seeds, or a seed that is no whole number >= 0."""


# The loop, compiled ----------------------------------------------------------------------------------------------


@kernel(nogil=True, _nrt=False)
def _periods(law, look, looks, k, end, last, lanes):  # type: ignore[no-untyped-def]
    """Drive from period ``k`` to before ``end``; in ``last``, the last of all, nobody moves any more."""
    body, known, air, trouble, period = lanes.body, lanes.known, lanes.air, lanes.trouble, lanes.period
    truth, seen, command, order, stops = body.truth, known.seen, lanes.command, lanes.order, lanes.stopped
    count = len(stops)
    while k < end:
        sense(k, period, body.parameters, truth, lanes.senses, seen, lanes.road, lanes.path, lanes.references)
        look(looks, k, truth, lanes.robots, known.ranges)
        hear(k, period, trouble, air)
        decide(law, k, 0, count, known, lanes.memory, command, lanes.work)
        obey(
            period, lanes.divergence, lanes.watchdog, truth, trouble, command, order, lanes.held_for, stops, lanes.lost
        )
        record(k, lanes.kept, truth, seen, command, order, trouble.code, air, lanes.readings, stops)
        if k < last:
            say(k, period, trouble.cut, air, command, truth)
            move(k, body, order, stops, lanes.lost)
        k += 1


def drive_chunk(
    opening: Opening, first: int, last: int, kept: Kept, ticks: int, advance: Callable[[int], None] | None = None
) -> np.ndarray:
    """Drive the runs from ``first`` to before ``last`` to their end; return when each robot was stopped, or -1.

    ``advance`` is called with how many periods of how many runs have gone by.
    """
    lanes, supply = opening.lanes(first, last, kept)
    one: Any = opening.drivers[0].law
    law = compiled(type(one).equation)
    functions = types.FunctionType(EQUATION_TYPE), types.FunctionType(LOOK_TYPE)
    loop, k = machine_code(_periods, *functions, LOOKS_TYPE, *(types.int64,) * 3), 0
    look = supply.look
    block = max(16, BLOCK // len(lanes.lost))
    while k <= ticks:
        lanes = supply.to(lanes, k)
        end = min(k + block, supply.lasts(lanes, k), ticks + 1)
        loop(law, look, supply.looks, k, end, ticks, lanes)
        if advance is not None:
            advance((end - k) * (last - first))
        k = end
    return when_stopped(lanes, ticks)


def when_stopped(lanes: Lanes, k: int) -> np.ndarray:
    """The period in which each robot was stopped, or -1 (runs, robots), after period ``k``."""
    return np.where(lanes.lost, k, lanes.stopped).reshape(-1, lanes.robots)


# The loop, in Python ---------------------------------------------------------------------------------------------


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
    ) -> None:
        """Open it; arguments as of :func:`drive`. Raises RadioError, or ControllerError."""
        self.setting, self.law, self.runs, self.robots = setting, law, len(seeds), len(setting.robots)
        self.name, self.recorder = name, recorder or Recorder(setting, law, len(seeds), nothing=True)
        opening = Opening.of([Driver(setting, law)], seeds, faults)
        self.lanes, self.supply = opening.lanes(0, len(seeds), self.recorder.kept(0, len(seeds)))
        self.ranges: Ranges | None = None
        self.memory = self.lanes.memory if has_equation(law) else begun(law, setting, len(seeds))
        self.speaks = True

    def periods(self) -> Iterator[tuple[int, Command]]:
        """Drive to the end; yield each period and what the law has commanded in it, before anybody speaks or moves."""
        for k in range(self.setting.ticks + 1):
            self.sense(k)
            self.look(k)
            self.hear(k)
            command = self.decide(k)
            self.obey()
            self.record(k)
            yield k, command
            if k < self.setting.ticks:
                self.say(k)
                self.move(k)

    def sense(self, k: int) -> None:
        """Measure encoders and postures, and look up where the references are."""
        self.lanes = self.supply.to(self.lanes, k)
        one = self.lanes
        truth, seen, road = one.body.truth, one.known.seen, one.road
        sense(k, one.period, one.body.parameters, truth, one.senses, seen, road, one.path, one.references)

    def look(self, k: int) -> None:
        """Read the range sensors."""
        if self.supply.sensors is not None:
            lanes = self.lanes
            looking(read_ranges)(self.supply.looks, k, lanes.body.truth, self.robots, lanes.known.ranges)
            readings = lanes.readings.reshape(self.runs, self.robots, -1).copy()
            self.ranges = Ranges(self.supply.sensors.names, readings)

    def hear(self, k: int) -> None:
        """Find out who is at fault, and receive what the radio brings."""
        hear(k, self.lanes.period, self.lanes.trouble, self.lanes.air)

    def decide(self, k: int) -> Command:
        """Ask the law for its command."""
        if has_equation(self.law):
            law, one = cast(Any, self.law), self.lanes
            one.command[TO_X : TO_S + 1] = one.known.seen[AT_X : AT_S + 1]
            known = one.known._replace(time=k * one.period)
            compiled(type(law).equation)(0, len(one.lost), known, one.memory, one.command, one.work)
            return cast(Command, law.commanded(self.rows(one.command.copy())))
        lanes = self.lanes
        seen = self.rows(lanes.known.seen.copy())  # a law may keep what it is given
        observation = Observation(
            k * self.setting.period,
            seen[X],
            seen[Y],
            seen[HEADING],
            seen[V],
            seen[W],
            Reference(*seen[AT_X : AT_S + 1]),
            self.setting.references,
            self.supply.channel.heard(lanes.air._replace(heard=lanes.air.heard.copy())),
            self.ranges,
        )
        command, self.memory = commanded(self.law, observation, self.memory, self.setting.period)
        self.told(command)
        return command

    def told(self, command: Command) -> None:
        """Write a command into the columns."""
        rows = self.rows(self.lanes.command)
        rows[FIRST], rows[SECOND], rows[WISH_V], rows[WISH_W] = command[:4]
        target = self.rows(self.lanes.known.seen)[AT_X : AT_S + 1] if command.target is None else command.target
        for row, of in zip(rows[TO_X : TO_S + 1], target, strict=True):
            row[...] = of
        rows[PROGRESS] = np.nan if command.progress is None else command.progress
        rows[MODE] = 0 if command.mode is None else command.mode
        rows[GUARDED] = 0 if command.guarded is None else command.guarded
        rows[REFUSED] = 0 if command.refused is None else command.refused[:, None]
        if self.recorder.makes_room(command, self.name):
            self.lanes = self.lanes._replace(kept=self.recorder.kept(0, self.runs))
        if command.message is not None:
            for row, name in enumerate(self.law.message, start=SAYS):
                rows[row] = command.message[name]
        if command.inputs is not None:
            first = SAYS + len(self.law.message)
            rows[first : first + len(command.inputs)] = command.inputs
        self.speaks = command.message is not None

    def obey(self) -> None:
        """Make the order of the command, and notice who is lost."""
        one = self.lanes
        obey(
            one.period, one.divergence, one.watchdog, one.body.truth, one.trouble, one.command, one.order,
            one.held_for, one.stopped, one.lost,
        )  # fmt: skip

    def record(self, k: int) -> None:
        """Keep the samples of the period."""
        one = self.lanes
        truth, seen, code = one.body.truth, one.known.seen, one.trouble.code
        record(k, one.kept, truth, seen, one.command, one.order, code, one.air, one.readings, one.stopped)

    def say(self, k: int) -> None:
        """Broadcast the message of every robot."""
        if self.speaks:
            one = self.lanes
            say(k, one.period, one.trouble.cut, one.air, one.command, one.body.truth)

    def move(self, k: int) -> None:
        """Stop the robots that are lost, and move the plant by one period."""
        one = self.lanes
        move(k, one.body, one.order, one.stopped, one.lost)

    def rows(self, columns: np.ndarray) -> np.ndarray:
        """Columns (..., lanes) as (..., runs, robots)."""
        return columns.reshape(*columns.shape[:-1], self.runs, self.robots)

    def state(self, k: int, command: Command) -> State:
        """The state of period ``k``, of which nothing changes any more."""
        lanes = self.lanes
        seen = self.rows(lanes.known.seen.copy())
        reference = Reference(*seen[AT_X : AT_S + 1])
        return State(
            k,
            k * self.setting.period,
            self.rows(lanes.body.truth.copy()),
            seen[X : HEADING + 1],
            seen[V],
            seen[W],
            reference,
            self.supply.channel.heard(lanes.air._replace(heard=lanes.air.heard.copy())),
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
    links: bool = False,
    torques: bool = False,
    encoders: bool = False,
    messages: bool = False,
    faults: Faults | None = None,
    progress: Callable[[], None] | None = None,
    threads: int | None = None,
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
        torques: Whether the run keeps the torques of the wheels, as ``Run.torques``.
        encoders: Whether the run keeps what the encoders tell, as ``Run.encoders``.
        messages: Whether the run keeps what the robots broadcast, as ``Run.messages``.
        faults: The faults of every run, which may differ; by default those of the scenario.
        progress: Called after every period.
        threads: How many threads share out the runs; by default as many as there are cores. The result is the same.

    Returns:
        All samples of all seeds and robots.

    Raises:
        SimulationError: No seeds, or one that is no whole number >= 0.
        ControllerError: The law cannot drive the scenario.
    """
    law = as_law(controller)
    name = name or (controller if isinstance(controller, str) else "")
    setting = scenario.setting
    kept = {"links": links, "torques": torques, "encoders": encoders, "messages": messages}
    return record_run(setting, law, seeds, name=name, **kept, faults=faults, progress=progress, threads=threads)


def record_run(
    setting: Setting,
    law: Law[Any],
    seeds: Sequence[int],
    *,
    name: str = "",
    links: bool = False,
    torques: bool = False,
    encoders: bool = False,
    messages: bool = False,
    faults: Faults | None = None,
    progress: Callable[[], None] | None = None,
    threads: int | None = None,
) -> Run:
    """:func:`simulate` for a setting: a compiled scenario, or an ensemble of one run."""
    seeds, name = checked_seeds(seeds), name or type(law).__name__
    recorder = Recorder(setting, law, len(seeds), links=links, torques=torques, encoders=encoders, messages=messages)
    if has_equation(law):
        opening = Opening.of([Driver(setting, law)], seeds, faults)
        gone = np.concatenate(driven(opening, recorder.kept, Periods(setting.ticks + 1, len(seeds), progress), threads))
        shared = None if setting.ensemble else opening.references
        run = recorder.run(setting, seeds, name, gone, setting.ticks + 1, references=shared)
        if run.inputs is not None:
            say_of_inputs(law.fuzzy_systems, run.inputs)
        return run
    simulation = Simulation(setting, law, seeds, faults, recorder, name)
    for _ in simulation.periods():
        if progress is not None:
            progress()
    return recorder.run(setting, seeds, name, when_stopped(simulation.lanes, setting.ticks), setting.ticks + 1)


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
    opening: Opening, kept: Callable[[int, int], Kept], advance: Callable[[int], None], threads: int | None = None
) -> list[np.ndarray]:
    """Drive all runs of a law with an equation, shared out over ``threads``; ``kept`` is where runs are recorded.

    Returns when each robot was stopped, or -1, chunk by chunk (runs, robots).
    """
    setting = opening.drivers[0].setting
    size = max(1, CHUNK // len(setting.robots))
    chunks = [(first, min(first + size, opening.runs)) for first in range(0, opening.runs, size)]

    def one(chunk: tuple[int, int]) -> np.ndarray:
        return drive_chunk(opening, *chunk, kept(*chunk), setting.ticks, advance)

    return share_out(one, chunks, threads)


def share_out(one: Callable[[Any], Any], jobs: Sequence[Any], threads: int | None = None) -> list[Any]:
    """Do ``one`` thing for each of ``jobs``, shared out over ``threads``.

    By default there are as many as there are cores; but one in a worker process, which has others beside it.
    """
    if threads is None:
        threads = 1 if parent_process() is not None else processors()
    workers = min(len(jobs), threads)
    if workers <= 1:
        return [one(job) for job in jobs]
    with ThreadPoolExecutor(workers) as pool:
        return list(pool.map(one, jobs))


def checked_seeds(seeds: Sequence[int]) -> tuple[int, ...]:
    """``seeds`` as whole numbers. Raises SimulationError where there are none, or one is none."""
    for seed in seeds:
        if isinstance(seed, bool) or not isinstance(seed, (int, np.integer)) or seed < 0:
            raise SimulationError(f"a seed is a whole number >= 0, got {seed!r}")
    if len(seeds) == 0:
        raise SimulationError("at least one seed is needed")
    return tuple(int(seed) for seed in seeds)
