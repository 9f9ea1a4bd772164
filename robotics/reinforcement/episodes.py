"""Episodes side by side: how they begin, each with its own scenario and seed, and how all take a step at once.

The random numbers of an episode are those of a run with the same seed, in the same order.
"""

from collections.abc import Sequence
from typing import Any

import numpy as np

from fuzzy.compiled.threads import processors, share_out
from robotics.environment.collision import footprints
from robotics.environment.swept import Watch
from robotics.environment.world import Geometry, Moving
from robotics.laws.equation import SeenColumns
from robotics.laws.tracking.observed import highs_of
from robotics.random_streams import RELATIVE_STREAM
from robotics.reinforcement.stepping import (
    END,
    REWARD,
    EpisodeLanes,
    SumColumns,
    advance,
    collide,
    costs,
    look_around,
    observe_all,
    observe_these,
    sense_first,
)
from robotics.reinforcement.task import FAILED_COST, SCALES, Task, TaskError
from robotics.sensing.carried import CarriedSensors, Looks
from robotics.sensing.posture import PostureNoise, wheel_errors
from robotics.vehicle import plant as p

_SHARE = 256  # lanes of a thread at least: fewer are not worth one


class Episodes:
    """Episodes of a task in lanes, which begin and end each in its own time; all arrays are (lanes, ...)."""

    def __init__(self, task: Task, count: int, threads: int | None = None) -> None:
        """Open ``count`` lanes, none of which has begun; ``threads`` share them out, by default as many as cores."""
        if type(count) is not int or count < 1:
            raise TaskError(f"the number of environments must be a whole number >= 1; got {count!r}")
        self.task, self.count, self.turn = task, count, 0
        self.lanes = _columns(task, count)
        self.looks, self.sensors = _looks(task, count)
        self.watch: Watch | None = None
        wanted = processors() if threads is None else threads
        parts = max(1, min(wanted, count // _SHARE))
        step = -(-count // parts // 32) * 32 if parts > 1 else count
        self.parts = [(a, min(a + step, count)) for a in range(0, count, step)]
        self.scratch = [np.empty(p.SCRATCH) for _ in self.parts]
        self.seeds = np.zeros(count, dtype=np.int64)
        self.high = np.asarray(task.action_limits, dtype=float)

    def begin(self, chosen: np.ndarray, scenarios: np.ndarray, seeds: Sequence[int]) -> None:
        """Begin an episode in each of the ``chosen`` lanes, of one of the ``scenarios`` by its place, with a seed."""
        lanes, task = self.lanes, self.task
        chosen, setting = np.asarray(chosen, dtype=np.int64), task.scenarios[0].setting
        sensing = setting.sensing[0]
        spread = np.array([sensing.start_position, sensing.start_position, sensing.start_heading])
        believed = task.starts[scenarios]
        draws = np.empty((len(chosen), 3))
        absolute, relative = lanes.senses.draws, lanes.senses.relative_draws
        for n, (lane, scenario, seed) in enumerate(zip(chosen.tolist(), scenarios.tolist(), seeds, strict=True)):
            generator, samples = np.random.default_rng(seed), int(task.ticks[scenario]) + 1
            draws[n] = generator.standard_normal((1, 3))[0]
            if len(absolute):
                generator.standard_normal(out=absolute[lane, :samples])
            if len(relative):
                np.random.default_rng([seed, RELATIVE_STREAM]).standard_normal(out=relative[lane, :samples])
        lanes.truth[:, chosen] = p.initial_state(believed + draws * spread, believed)
        parameters = task.parameters[:, scenarios]
        if (errors := wheel_errors(setting.sensing, seeds)) is not None:
            p.ParameterColumns(parameters).odometry.array[...] *= errors
        lanes.parameters[:, chosen] = parameters
        lanes.pending[:, :, chosen] = 0.0
        for array in (lanes.senses.counts, lanes.seen, lanes.last, lanes.sums):
            array[:, chosen] = 0.0
        lanes.path[chosen], lanes.clock[chosen], lanes.ended[chosen] = scenarios, 0, END.running
        lanes.wished[chosen], lanes.touched[chosen] = np.nan, False
        self.seeds[chosen] = seeds
        sense_first(lanes, chosen)
        if self.looks is not None:
            self._place(chosen, scenarios)
            self._watch_from(chosen)
            self._look(chosen)
        observe_these(lanes, chosen)

    def step(self, actions: np.ndarray) -> None:
        """Take a step in every lane, with ``actions`` (lanes, 2); what came of it stands in :attr:`lanes`."""
        actions = np.ascontiguousarray(actions, dtype=float)
        if len(self.parts) == 1:
            self._advance(0, actions)
        else:
            share_out(lambda part: self._advance(part, actions), range(len(self.parts)), len(self.parts))
        self.turn += 1
        if self.looks is not None:
            self._touch()
            self._look(None)
            observe_all(self.lanes, 0, self.count)

    def _advance(self, part: int, actions: np.ndarray) -> None:
        first, last = self.parts[part]
        advance(self.lanes, first, last, self.turn, actions, self.high, self.scratch[part])
        if self.looks is None:
            observe_all(self.lanes, first, last)

    def costs(self, chosen: np.ndarray) -> np.ndarray:
        """The arena's cost of the episodes that have ended in the ``chosen`` lanes."""
        found = np.empty(len(chosen))
        costs(self.lanes, np.asarray(chosen, dtype=np.int64), found)
        return found

    # Among obstacles ---------------------------------------------------------------------------------------------

    def _place(self, chosen: np.ndarray, scenarios: np.ndarray) -> None:
        """Put the obstacles of the scenarios around the robots of the chosen lanes."""
        assert self.looks is not None
        for here, there in zip(self.looks.here, self.task.obstacles.rest, strict=True):
            here[chosen] = there[scenarios]
        self.looks.readings[chosen] = np.inf

    def _poses(self) -> np.ndarray:
        return self.lanes.truth[:5, :, None].copy()

    def _watch_from(self, chosen: np.ndarray) -> None:
        """Watch the chosen lanes for contacts from now on."""
        assert self.looks is not None
        robot, time = self.task.scenarios[0].setting.robots[:1], self.turn * self.lanes.period
        poses = self._poses()
        if self.watch is None:
            self.watch = Watch.opened(robot, time, poses, self.looks.here)
        fresh = Watch.opened(robot, time, poses, self.looks.here)
        for name, new in fresh.known._asdict().items():
            here: Any = (slice(None), chosen) if name in ("least", "first") else chosen
            getattr(self.watch.known, name)[here] = new[here]
        self.watch.poses[:, chosen] = poses[:, chosen]
        self.lanes.touched[chosen] = self.watch.known.counts[chosen, 0] > 0

    def _touch(self) -> None:
        """End the episodes whose robots have touched an obstacle on the way to this sample."""
        assert self.watch is not None
        assert self.looks is not None
        self.watch, _ = self.watch.to(self.turn * self.lanes.period, self._poses(), self.looks.here)
        self.lanes.touched[:] = self.watch.known.counts[:, 0] > 0
        collide(self.lanes, 0, self.count)

    def _look(self, chosen: np.ndarray | None) -> None:
        """Read the range sensors, of the chosen lanes or of all."""
        assert self.looks is not None
        assert self.sensors is not None
        self._supply(np.arange(self.count) if chosen is None else chosen)
        if chosen is None:
            look_around(self.lanes, self.looks, 0, self.count)
        else:
            for lane in chosen:
                look_around(self.lanes, self.looks, lane, lane + 1)

    def _supply(self, chosen: np.ndarray) -> None:
        """Draw the random numbers of the range sensors where a clock asks for new ones."""
        looks, clock = self.looks, self.lanes.clock
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


def _columns(task: Task, count: int) -> EpisodeLanes:
    """The columns of lanes that have not begun."""
    first, references = task.scenarios[0], task.references
    setting = first.setting
    samples = int(task.ticks.max()) + 1
    noise = PostureNoise.opened(setting.sensing, samples, [np.random.default_rng(0)], [0])
    draws = np.zeros((count if noise.generators else 0, samples, 3, 1))
    relative = np.zeros((count if noise.relative else 0, samples, 3, 1))
    senses = noise.senses(np.zeros((2, count)))._replace(draws=draws, relative_draws=relative)
    steps = round(setting.period / p.STEP)
    late_periods, late_steps = divmod(round(setting.latency / p.STEP), steps)
    code = p.KINEMATIC if setting.plant == "kinematic" else p.CODES[task.level]
    scenarios = len(task.scenarios)
    highs = np.tile(highs_of(task.entries)[:, None], scenarios)
    none = np.zeros(count, dtype=np.int64)
    return EpisodeLanes(
        float(setting.period), float(setting.divergence), steps, code, late_periods, late_steps,
        getattr(REWARD, task.reward), float(task.approach), float(FAILED_COST), np.array(SCALES),
        np.ones((2, scenarios)) if task.units else task.most_of, task.limits, highs,
        np.stack([task.ticks, task.counted_from, task.ticks + 1 - task.counted_from]).astype(np.int64),
        references.road, senses, np.ones((p.ParameterColumns.size, count)), np.zeros((p.TruthColumns.size, count)),
        np.zeros((late_periods + 2, 2, count)), np.zeros((SeenColumns.size, count)),
        np.full((len(task.sensors), count), np.inf),
        none.copy(), none.copy(), none, np.zeros(count, dtype=bool), np.zeros((2, count)),
        np.full(count, np.nan), np.zeros((SumColumns.size, count)), np.zeros(count),
        np.zeros((count, len(task.entries))),
    )  # fmt: skip


def _looks(task: Task, count: int) -> tuple[Looks | None, CarriedSensors | None]:
    """The range sensors of all lanes, and room for what stands around them; None where there are no obstacles."""
    if task.obstacles is None:
        return None, None
    setting = task.scenarios[0].setting
    carried = dict(setting.sensors[0])
    sensors = CarriedSensors.opened([carried], 1, [0] * count, setting.period)
    rest: Geometry = task.obstacles.rest
    here = Geometry(*(np.zeros((count, *rows.shape[1:]), dtype=rows.dtype) for rows in rest))
    sizes: Any = np.tile(footprints(setting.robots[:1]), count)
    return sensors.looks(here, Moving.nothing(), sizes, task.sensors), sensors
