"""What a simulation begins with: the columns of its lanes, and the random numbers that come as time goes on."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from fuzzy.compiled.columns import check
from robotics.laws.equation import EquationLaw, Known, SeenColumns, Setup, fresh_commands
from robotics.laws.law import ControllerError, Law, check_needs
from robotics.laws.setting import Setting
from robotics.simulation.lanes import Lanes, PlantLanes, keeping, looking
from robotics.simulation.safety.monitor import keep_safe, let_pass
from robotics.simulation.safety.opening import channel_of, is_guarded, no_guard, opened_guard
from robotics.world.environment.collision import footprints
from robotics.world.radio.channel import Channel
from robotics.world.radio.faults import Faults, untroubled
from robotics.world.sensing.carried import CarriedSensors, Looks, look, nothing_to_see, see_nothing
from robotics.world.sensing.posture import PostureNoise, Sensing, SensingError, read_encoders, wheel_errors
from robotics.world.vehicle import plant as p
from robotics.world.vehicle.floor import compiled_floor


class Driver(NamedTuple):
    """A law that drives some of the runs of a pass, and the setting as it is in these: the robots are its own."""

    setting: Setting
    law: Law[Any]


def has_equation(law: Law[Any]) -> bool:
    """Whether compiled code drives by a law."""
    return isinstance(law, EquationLaw) and law.has_equation


def looks(setting: Setting, law: Law[Any]) -> bool:
    """Whether robots look at something with range sensors: for their law, or for the monitor below it."""
    return (law.looks or is_guarded(setting, law)) and setting.world is not None and any(setting.sensors)


@dataclass(frozen=True, eq=False)
class RandomNumbers:
    """The random numbers of some lanes, which are drawn as time goes on."""

    noise: PostureNoise
    channel: Channel
    monitors: Channel | None  # that of the monitors of passive safety; None: there are none
    sensors: CarriedSensors | None  # None: nobody looks
    looks: Looks

    @property
    def look(self) -> Any:
        """The compiled function that reads the range sensors; it is compiled where robots look only."""
        function = see_nothing if self.sensors is None else look
        looking(function)
        return function

    @property
    def keep(self) -> Any:
        """The compiled monitor of passive safety; it is compiled where there is one only."""
        function = let_pass if self.monitors is None else keep_safe
        keeping(function)
        return function

    def to(self, lanes: Lanes, k: int) -> Lanes:
        """The lanes with the random numbers of period ``k``."""
        if self.sensors is not None:
            self.sensors.supply(self.looks, k)
        senses, air = self.noise.supplied(lanes.senses, k, lanes.goes_on), self.channel.supplied(lanes.air, k)
        guard = lanes.guard
        if self.monitors is not None:
            said = self.monitors.supplied(guard.air, k)
            guard = guard if said is guard.air else guard._replace(air=said)
        if senses is lanes.senses and air is lanes.air and guard is lanes.guard:
            return lanes
        return lanes._replace(senses=senses, air=air, guard=guard)

    def last_period(self, lanes: Lanes, k: int) -> int:
        """The period up to which random numbers are there, ``k`` being one for which they are."""
        ends: list[float] = []
        if noise := max(lanes.senses.draws.shape[1], lanes.senses.relative_draws.shape[1]):
            ends.append(lanes.senses.drawn + noise)
        for air in (lanes.air, lanes.guard.air):
            if len(air.draws):
                ends.append((air.drawn + len(air.draws)) * air.every)
        if self.sensors is not None:
            ends.append(self.sensors.last_period(self.looks))
        return int(min([*ends, k + 1_000_000]))


@dataclass(frozen=True, eq=False)
class PreparedRuns:
    """A simulation before its start: every driver's runs, one for each seed, driver after driver.

    All settings are the same but for their robots, and all laws have one equation, or there is but one law.
    """

    drivers: tuple[Driver, ...]
    seeds: tuple[int, ...]  # of each driver's runs
    faults: Faults | None
    references: np.ndarray  # (6, samples, robots): of all runs; no samples: each run has its own
    setups: tuple[Setup, ...]  # of each driver; none for a law without an equation
    memories: tuple[np.ndarray, ...]  # likewise: (numbers, lanes of the driver)

    @classmethod
    def of(cls, drivers: Sequence[Driver], seeds: Sequence[int], faults: Faults | None = None) -> "PreparedRuns":
        """Look at all laws and settings. Raises RadioError, or ControllerError where a law cannot drive."""
        drivers = [Driver(own.seeded(seeds), law) for own, law in drivers]
        setting = drivers[0].setting
        setups, memories = [], []
        for own, law in drivers:
            check_needs(own, law)
            _sensing(own, law)
            if isinstance(law, EquationLaw) and law.has_equation:
                memory = law.init(own, len(seeds))
                setups.append(memory.setup)
                memories.append(memory.rows)
        if faults is None and setting.faults:
            faults = Faults.drawn(setting.faults, len(setting.robots), seeds)
        shared = np.empty((6, 0, 0)) if setting.ensemble else np.stack(setting.references.sampled(setting.times))
        return cls(tuple(drivers), tuple(seeds), faults, shared, tuple(setups), tuple(memories))

    @property
    def runs(self) -> int:
        """The number of all runs."""
        return len(self.drivers) * len(self.seeds)

    def lanes(self, first: int, last: int) -> tuple[Lanes, RandomNumbers]:
        """Begin the runs from ``first`` to before ``last``."""
        setting, law = self.drivers[0]
        robots, each, runs = len(setting.robots), len(self.seeds), last - first
        seeds = [self.seeds[run % each] for run in range(first, last)]
        generators = [np.random.default_rng(seed) for seed in seeds]
        parameters = self._parameters(first, last)
        sensing = _sensing(setting, law)
        if (errors := wheel_errors(sensing, seeds)) is not None:
            p.ParameterColumns(parameters).odometry.array[...] *= errors
        starts = setting.starts
        if starts.ndim == 3:
            starts = starts[np.arange(first, last) % len(starts)]
        body = self._body(_start(setting, starts, generators), parameters)
        counts = np.zeros((2, runs * robots))
        read_encoders(parameters, body.truth, counts, setting.period, np.empty((2, runs * robots)))
        noise = PostureNoise.opened(sensing, setting.ticks, generators, seeds)
        channel = Channel.opened(setting.radio, law.message, robots, seeds, setting.period)
        air = channel.silence(runs, robots)
        known, memory = self._known(first, last, air.heard)
        sensors, looks = self._looks(first, last)
        guarded = is_guarded(setting, law)
        monitors = channel_of(setting, law, seeds)
        said = monitors.silence(runs, robots)
        kinds = sensors.kinds if sensors is not None else ()
        guard = opened_guard(setting, runs, looks, kinds, said) if guarded else no_guard(runs * robots, said)
        places = np.arange(first, last) % each
        trouble = untroubled(runs, robots) if self.faults is None else self.faults.trouble(places)
        road = setting.references.road
        lanes = Lanes(
            robots,
            setting.period,
            float(setting.divergence),
            float(law.watchdog),
            body,
            noise.senses(counts),
            looks.readings,
            road,
            np.arange(first * robots, last * robots) % len(road.lengths),
            self.references,
            trouble,
            air,
            known,
            memory,
            fresh_commands(known.seen, law),
            self._work(),
            np.zeros((2, runs * robots)),
            np.zeros(runs * robots),
            np.full(runs * robots, -1),
            np.zeros(runs * robots, dtype=bool),
            np.ones(runs, dtype=bool),
            guard,
        )
        check(lanes)
        check(looks)
        return lanes, RandomNumbers(noise, channel, monitors if guarded else None, sensors, looks)

    def _parameters(self, first: int, last: int) -> np.ndarray:
        """The plant's parameters of the lanes (ParameterColumns, lanes)."""
        each = len(self.seeds)
        rows = {}
        for d in {run // each for run in range(first, last)}:
            told = self.drivers[d].setting
            robots = told.truth.robots if told.truth else told.robots
            pairs = zip(robots, told.robots, strict=True)
            rows[d] = np.stack([p.parameters(robot, p.STEP, believed) for robot, believed in pairs], axis=1)
        return np.concatenate([rows[run // each] for run in range(first, last)], axis=1)

    def _body(self, truth: np.ndarray, parameters: np.ndarray) -> PlantLanes:
        setting, law = self.drivers[0]
        steps = round(setting.period / p.STEP)
        latency = setting.truth.latency if setting.truth else setting.latency
        late_periods, late_steps = divmod(round(latency / p.STEP), steps)
        code = p.KINEMATIC if setting.plant == "kinematic" else p.CODES[law.level]
        pending = np.zeros((late_periods + 2, 2, truth.shape[1]))
        floor = compiled_floor(setting.patches, parameters)
        return PlantLanes(
            parameters, truth, pending, np.empty(p.SCRATCH), steps, p.STEP, code, late_periods, late_steps, floor
        )

    def _reads(self) -> tuple[str, ...]:
        """The range sensors that the equation of the law is told of."""
        setting, law = self.drivers[0]
        return law.reads(setting) if self.setups and isinstance(law, EquationLaw) else ()

    def _work(self) -> np.ndarray:
        """What the equation of each law works in."""
        setting, read = self.drivers[0].setting, len(self._reads())
        laws = (law for _, law in self.drivers if isinstance(law, EquationLaw))
        return np.empty(max((law.working_for(len(setting.robots), read) for law in laws), default=0))

    def _looks(self, first: int, last: int) -> tuple[CarriedSensors | None, Looks]:
        """The range sensors of the lanes, and their columns."""
        setting, law = self.drivers[0]
        robots, each = len(setting.robots), len(self.seeds)
        if setting.world is None or not looks(setting, law):
            return None, nothing_to_see(robots * (last - first))
        runs = np.arange(first, last)
        carried = [sensors for run in runs for sensors in self.drivers[run // each].setting.sensors]
        seeds = [self.seeds[run % each] for run in runs]
        sensors = CarriedSensors.opened(carried, robots, seeds, setting.period)
        worlds = runs % setting.world.runs if setting.world.runs > 1 else np.zeros(1, dtype=np.int64)
        here, moving = setting.world.during(setting.times, worlds)
        sizes = {d: footprints(self.drivers[d].setting.robots) for d in {run // each for run in runs}}
        lanes = np.concatenate([sizes[run // each] for run in runs], axis=1)
        return sensors, sensors.looks(here, moving, lanes, self._reads())

    def _known(self, first: int, last: int, heard: np.ndarray) -> tuple[Known, np.ndarray]:
        """What the equation may read, and the memory with which it begins (numbers, lanes)."""
        setting = self.drivers[0].setting
        robots, each = len(setting.robots), len(self.seeds)
        lanes = np.arange(first * robots, last * robots)
        seen = np.zeros((SeenColumns.size, len(lanes)))
        ranges = np.full((len(self._reads()), len(lanes)), np.inf)
        if not self.setups:
            road, none = setting.references.road, np.zeros_like(lanes)
            gains, row = np.zeros((0, 1)), np.zeros((1, 0))
            path = lanes % len(road.lengths)
            known = Known(0.0, setting.period, seen, heard, ranges, road, path, none, gains, none, row, none, row)
            return known, np.zeros((0, len(lanes)))
        of, place = lanes // (robots * each), lanes % (robots * each)
        used = range(of[0], of[-1] + 1)
        setup = self.setups[used[0]]
        begin = np.cumsum([0, *(self.setups[d].gains.shape[1] for d in used)])
        rules, _ = _stacked([self.setups[d].rules for d in used])
        tables, row = _stacked([self.setups[d].tables for d in used])
        column, table = np.empty_like(lanes), np.empty_like(lanes)
        memory = np.empty((len(self.memories[0]), len(lanes)))
        for n, d in enumerate(used):
            here = of == d
            table[here] = row[n] + self.setups[d].table[place[here]]
            column[here] = begin[n] + self.setups[d].column[place[here]]
            memory[:, here] = self.memories[d][:, place[here]]
        gains = np.concatenate([self.setups[d].gains for d in used], axis=1)
        path = setup.path[place]
        own = setup.road, path, column, gains, of - used[0], rules, table, tables
        return Known(0.0, setting.period, seen, heard, ranges, *own), memory


def _stacked(parts: Sequence[np.ndarray]) -> tuple[np.ndarray, np.ndarray]:
    """Rows of several laws below each other, each as long as the longest; and where those of each begin."""
    begin = np.cumsum([0, *map(len, parts)])
    if len(parts) == 1:
        return np.ascontiguousarray(parts[0]), begin
    rows = np.zeros((begin[-1], max(part.shape[1] for part in parts)))
    for first, part in zip(begin, parts, strict=False):
        rows[first : first + len(part), : part.shape[1]] = part
    return rows, begin


def _sensing(setting: Setting, law: Law[Any]) -> tuple[Sensing, ...]:
    """How the robots know where they are under a law. Raises ControllerError where its estimator has no pose sensor."""
    try:
        return tuple(own.joined_by(law.estimator) for own in setting.sensing)
    except SensingError:
        raise ControllerError(
            f"{setting.name}: estimator of {type(law).__name__} joins a pose sensor with odometry, and there is none; "
            'accepted with [sensing] posture = "pose"'
        ).about("estimator") from None


def _start(setting: Setting, starts: np.ndarray, generators: Sequence[np.random.Generator]) -> np.ndarray:
    """The state at time 0: each robot a little off where it believes to stand, as its sensing says."""
    shape = (len(generators), len(setting.robots), 3)
    believed = np.broadcast_to(starts, shape).reshape(-1, 3)
    spread = [(s.start_position, s.start_position, s.start_heading) for s in setting.sensing]
    draws = np.concatenate([g.standard_normal(shape[1:]) for g in generators])
    return p.initial_state(believed + draws * np.tile(spread, (len(generators), 1)), believed)
