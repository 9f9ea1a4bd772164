"""Episodes side by side: how they begin, each with its own scenario and seed, and how all take a step at once.

The random numbers of an episode are those of a run with the same seed, in the same order.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from fuzzy.compiled.threads import processors, share_out
from robotics.laws.equation import RobotColumns
from robotics.laws.law import Command, Law, Observation
from robotics.laws.setting import Setting
from robotics.plugins.reinforcement.observed import highs_of
from robotics.plugins.reinforcement.reward import END, RewardColumns, RewardNotes, costs, opened, settle
from robotics.plugins.reinforcement.stepping import EpisodeLanes, advance, look_around, observe_lanes, sense_lanes
from robotics.plugins.reinforcement.task import Task, TaskError
from robotics.simulation.observer import moment_of
from robotics.simulation.opening import Driver, PreparedRuns
from robotics.world.environment.collision import footprints
from robotics.world.environment.swept import ContactNotes, ContactWatch, body_spans
from robotics.world.environment.world import Geometry, Moving
from robotics.world.paths.trajectory import side_by_side
from robotics.world.random_streams import RELATIVE_STREAM
from robotics.world.sensing.carried import CarriedSensors, Looks
from robotics.world.sensing.posture import wheel_errors
from robotics.world.vehicle import plant as p
from robotics.world.vehicle.floor import usual

BROADCAST = RobotColumns.leaves()  # what every robot broadcasts
_SHARE = 256  # lanes of a thread at least: fewer are not worth one


@dataclass(frozen=True)
class Agents(Law[None]):
    """The law of robots that somebody else drives; each broadcasts where it is, and how fast, as it knows it."""

    level: p.Level = "velocity"  # what the agents command
    looks: bool = False  # whether the robots carry range sensors among obstacles
    message = BROADCAST

    def init(self, setting: Setting, runs: int) -> None:
        """It remembers nothing."""

    def control(self, seen: Observation, memory: None, dt: float) -> tuple[Command, None]:
        """Nobody asks it."""
        raise NotImplementedError


class Episodes:
    """Episodes of a task in lanes, which begin and end each in its own time; all arrays are (lanes, ...)."""

    def __init__(self, task: Task, count: int, threads: int | None = None) -> None:
        """Open ``count`` lanes, none of which has begun; ``threads`` share them out, by default as many as cores."""
        if type(count) is not int or count < 1:
            raise TaskError(f"the number of environments must be a whole number >= 1; got {count!r}")
        self.task, self.count, self.turn = task, count, 0
        self.everyone = np.arange(count)
        self.ticks = np.array([s.ticks for s in task.scenarios])  # the last sample of each scenario
        self.starts = np.concatenate([s.starts for s in task.scenarios])  # (scenarios, 3): m, m, rad
        self.parameters = np.stack([p.parameters(s.setting.robots[0]) for s in task.scenarios], axis=1)
        self.lanes = _columns(task, count, int(self.ticks.max()) + 1)
        self.looks, self.sensors = _looks(task, count)
        here = Geometry.nothing() if self.looks is None else self.looks.here
        watch = ContactWatch.opened(task.scenarios[0].setting.robots, count, here, Moving.nothing())
        if task.obstacles is not None:
            self.spans = body_spans(task.obstacles.rest)  # of the obstacles of each scenario
            watch = watch._replace(contacts=ContactNotes.nothing(count, 1, np.repeat(self.spans[:1], count, axis=0)))
        self.notes = RewardNotes(self.lanes.notes, watch)
        wanted = processors() if threads is None else threads
        parts = max(1, min(wanted, count // _SHARE))
        step = -(-count // parts // 32) * 32 if parts > 1 else count
        self.parts = [self.everyone[a : a + step] for a in range(0, count, step)]
        self.scratch = [np.empty(p.SCRATCH) for _ in self.parts]
        self.seeds = np.zeros(count, dtype=np.int64)
        self.high = np.asarray(task.action_limits, dtype=float)

    def begin(self, chosen: np.ndarray, scenarios: np.ndarray, seeds: Sequence[int]) -> None:
        """Begin an episode in each of the ``chosen`` lanes, of one of the ``scenarios`` by its place, with a seed."""
        lanes, notes, task = self.lanes, self.lanes.notes, self.task
        chosen, setting = np.asarray(chosen, dtype=np.int64), task.scenarios[0].setting
        sensing = setting.sensing[0]
        spread = np.array([sensing.start_position, sensing.start_position, sensing.start_heading])
        believed = self.starts[scenarios]
        draws = np.empty((len(chosen), 3))
        absolute, relative = lanes.senses.draws, lanes.senses.relative_draws
        for n, (lane, scenario, seed) in enumerate(zip(chosen.tolist(), scenarios.tolist(), seeds, strict=True)):
            generator, samples = np.random.default_rng(seed), int(self.ticks[scenario]) + 1
            draws[n] = generator.standard_normal((1, 3))[0]
            if len(absolute):
                generator.standard_normal(out=absolute[lane, :samples])
            if len(relative):
                np.random.default_rng([seed, RELATIVE_STREAM]).standard_normal(out=relative[lane, :samples])
        lanes.body.truth[:, chosen] = p.initial_state(believed + draws * spread, believed)
        parameters = self.parameters[:, scenarios]
        if (errors := wheel_errors(setting.sensing, seeds)) is not None:
            p.ParameterColumns(parameters).odometry.array[...] *= errors
        lanes.body.parameters[:, chosen] = parameters
        lanes.body.floor.usual[:, chosen] = usual(parameters)
        lanes.body.pending[:, :, chosen] = 0.0
        for array in (lanes.senses.counts, lanes.moment.seen, lanes.moment.command, notes.columns):
            array[:, chosen] = 0.0
        RewardColumns(notes.columns).turn_rate[chosen] = np.nan
        notes.robot[chosen], notes.clock[chosen], notes.ended[chosen] = scenarios, 0, END.running
        self.seeds[chosen] = seeds
        sense_lanes(lanes, chosen)
        if self.looks is not None:
            self._place(chosen, scenarios)
            self._settle(np.isin(self.everyone, chosen))
            self._look(chosen)
        observe_lanes(lanes, chosen)

    def step(self, actions: np.ndarray) -> None:
        """Take a step in every lane, with ``actions`` (lanes, 2); what came of it stands in :attr:`lanes`."""
        actions = np.ascontiguousarray(actions, dtype=float)
        if len(self.parts) == 1:
            self._advance(0, actions)
        else:
            share_out(lambda part: self._advance(part, actions), range(len(self.parts)), len(self.parts))
        self.turn += 1
        if self.looks is not None:
            self._settle(self.lanes.notes.ended == END.running)
            self._look(self.everyone)
            observe_lanes(self.lanes, self.everyone)

    def _advance(self, part: int, actions: np.ndarray) -> None:
        advance(self.lanes, self.parts[part], self.turn, actions, self.high, self.looks is None, self.scratch[part])

    def costs(self, chosen: np.ndarray) -> np.ndarray:
        """The arena's cost of the episodes that have ended in the ``chosen`` lanes."""
        found = np.empty(len(chosen))
        costs(self.lanes.notes, np.asarray(chosen, dtype=np.int64), found)
        return found

    # Among obstacles ---------------------------------------------------------------------------------------------

    def _place(self, chosen: np.ndarray, scenarios: np.ndarray) -> None:
        """Put the obstacles of the scenarios around the robots of the chosen lanes, which have touched none yet."""
        assert self.looks is not None
        for here, there in zip(self.looks.here, self.task.obstacles.rest, strict=True):
            here[chosen] = there[scenarios]
        self.looks.readings[chosen] = np.inf
        watch = self.notes.watch
        watch.poses[:, chosen] = np.nan
        fresh = ContactNotes.nothing(len(chosen), 1, self.spans[scenarios])
        for name, known, new in zip(fresh._fields, watch.contacts, fresh, strict=True):
            at: Any = (slice(None), chosen) if name in ("least", "first") else chosen
            known[at] = new

    def _settle(self, going: np.ndarray) -> None:
        """End the episodes of the lanes that are ``going`` whose robots have touched an obstacle up to this sample."""
        self.notes.watch.going[:] = going
        settle(self.lanes.moment, self.notes)

    def _look(self, chosen: np.ndarray) -> None:
        """Read the range sensors of the chosen lanes."""
        self._supply(chosen)
        look_around(self.lanes, self.looks, chosen)

    def _supply(self, chosen: np.ndarray) -> None:
        """Draw the random numbers of the range sensors where a clock asks for new ones."""
        looks, clock = self.looks, self.lanes.notes.clock
        assert looks is not None
        assert self.sensors is not None
        if looks.draws.shape[2] == 0 or not len(looks.kinds.T):
            return
        stride, length = int(looks.kinds[2, 0]), int(looks.kinds[3, 0])
        for lane in chosen[clock[chosen] % (stride * length) == 0].tolist():
            own = CarriedSensors(
                self.sensors.names, self.sensors.kinds, np.zeros(1, np.int64), 1, (int(self.seeds[lane]),),
                self.sensors.tick,
            )  # fmt: skip
            drawn = looks.drawn.copy()
            drawn[:] = -1
            own.supply(looks._replace(draws=looks.draws[:, lane : lane + 1], drawn=drawn), int(clock[lane]))


def _columns(task: Task, count: int, samples: int) -> EpisodeLanes:
    """The columns of lanes that have not begun: those of the simulator, with clocks and scenarios of their own.

    An episode has so many ``samples`` at most.
    """
    scenarios = len(task.scenarios)
    drivers = [Driver(task.scenarios[0].setting, Agents(task.level))]
    lanes, supply = PreparedRuns.of(drivers, [0] * count).lanes(0, count)
    noise, shape = supply.noise, (samples, 3, 1)
    draws = np.zeros((count if noise.generators else 0, *shape))
    relative = np.zeros((count if noise.relative else 0, *shape))
    return EpisodeLanes(
        moment_of(lanes, 0),
        opened(task.scenarios, np.zeros(count, dtype=np.int64), task.level, task.reward, task.approach),
        lanes.body,
        lanes.senses._replace(draws=draws, relative_draws=relative),
        side_by_side([s.trajectory for s in task.scenarios]).road,
        np.ones((2, scenarios)) if task.units else task.most_of,
        np.tile(highs_of(task.entries)[:, None], scenarios),
        np.full((len(task.sensors), count), np.inf),
        np.zeros((count, len(task.entries))),
    )


def _looks(task: Task, count: int) -> tuple[Looks | None, CarriedSensors | None]:
    """The range sensors of all lanes, and room for what stands around them; None where there are no obstacles."""
    if task.obstacles is None:
        return None, None
    setting = task.scenarios[0].setting
    sensors = CarriedSensors.opened([dict(setting.sensors[0])], 1, [0] * count, setting.period)
    here = Geometry(*(np.zeros((count, *rows.shape[1:]), dtype=rows.dtype) for rows in task.obstacles.rest))
    sizes: Any = np.tile(footprints(setting.robots[:1]), count)
    return sensors.looks(here, Moving.nothing(), sizes, task.sensors), sensors
