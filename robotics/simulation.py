"""The one simulation: sense, hear, decide, say, move; all seeds of a scenario in one array pass.

Every run draws from its own generator, seeded by its own seed: a run's result does not depend, to the last bit,
on which runs are beside it.
"""

from collections.abc import Callable, Iterator, Sequence
from math import inf
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from fuzzy.errors import InputError
from robotics import plant as p
from robotics.controller import Command, Controller, Observation
from robotics.environment.collision import footprints
from robotics.environment.world import Geometry
from robotics.modes import STOPPED
from robotics.radio import Channel, Condition, Faults, Heard
from robotics.robot import Robot
from robotics.run import CHANNELS, TEAM_CHANNELS, Run
from robotics.scenario import STEP, Scenario
from robotics.sensing.sensors import PostureSensors, wheel_errors, wheel_odometry
from robotics.sensing.sonar import RangeSensor, SensorArray
from robotics.trajectory import Reference

if TYPE_CHECKING:
    from robotics.ensemble import Ensemble


class SimulationError(InputError):
    """A simulation that cannot start: no seeds, or a seed that is no whole number >= 0."""


class Period(NamedTuple):
    """One period of all runs, at its end; arrays are (runs, robots) unless they say otherwise."""

    k: int
    time: float  # s
    state: np.ndarray  # (plant channels, runs, robots): the truth
    posture: np.ndarray  # (3, runs, robots): x [m], y [m], heading [rad] as measured
    target: Reference  # where the law wants the robots to be
    command: Command
    order: np.ndarray  # (2, runs, robots): the command after faults and stops
    condition: Condition | None  # who is at fault
    heard: Heard | None
    stopped: np.ndarray  # int: the period before in which the robot was stopped, or -1
    lost: np.ndarray  # bool: it is stopped in this one
    ranges: np.ndarray | None = None  # (runs, robots, sensors) m: what their sensors read


def drive(
    setting: "Scenario | Ensemble", controller: Controller, seeds: Sequence[int], faults: Faults | None = None
) -> Iterator[Period]:
    """The periods of ``controller`` on a scenario or ensemble, a run for every seed: sense, hear, decide, say, move.

    A robot whose command is not finite, or that is farther than its ``divergence`` from its target, is stopped.
    ``faults`` are those of the scenario, if not given.
    """
    scenario: Any = setting  # an ensemble has what a scenario has, with runs in front
    seeds = _checked(seeds)
    runs, robots, ticks = len(seeds), len(scenario.robots), scenario.ticks
    shape, lanes = (runs, robots), runs * robots
    parameters = np.tile(np.stack([p.parameters(m.robot, STEP) for m in scenario.robots], axis=1), (1, runs))
    errors = wheel_errors(scenario, seeds)
    if errors is not None:
        parameters[p.P_ODO_RIGHT : p.P_ODO_HALF_AXLE + 1] *= errors
    machine = p.Plant(
        parameters,
        steps=round(scenario.period / STEP),
        step=STEP,
        kinematic=scenario.plant == "kinematic",
    )
    late_periods, late_steps = divmod(round(scenario.latency / STEP), machine.steps)
    generators = [np.random.default_rng(seed) for seed in seeds]
    state = _start(scenario, generators)
    sensors = PostureSensors.of(scenario, generators, seeds)
    fields: tuple[str, ...] = getattr(controller, "message", ())
    channel = Channel.opened(scenario.radio, robots, seeds, scenario.period) if fields else None
    air = channel.init(len(fields), runs) if channel else None
    if faults is None and scenario.faults:
        faults = Faults.drawn(scenario.faults, robots, seeds)
    watchdog: float = getattr(controller, "watchdog", inf)
    looks: tuple[RangeSensor, ...] = getattr(controller, "sensors", ())
    sonar = SensorArray.opened(looks, seeds, scenario.period) if looks and scenario.world is not None else None
    echoes = sonar.init(robots) if sonar else None
    sizes = footprints([member.robot for member in scenario.robots])
    memory = controller.init(scenario, runs)
    pending = [np.zeros((2, lanes))] * (late_periods + 2)  # commands on their way, newest first
    counts, _ = wheel_odometry(machine.parameters, state, np.zeros((2, lanes)), scenario.period)
    posture: np.ndarray | None = None
    order = np.zeros((2, *shape))
    held_for: np.ndarray | float = 0.0
    stopped, gone = np.full(shape, -1), False
    # A scenario's references are the same for all runs, and are looked up at once.
    known = np.stack(setting.trajectory.sampled(setting.times)) if isinstance(setting, Scenario) else None
    for k in range(ticks + 1):
        time = k * scenario.period
        target = Reference(*known[:, k]) if known is not None else scenario.trajectory.at(time)
        condition = faults.at(time) if faults else None
        # sense
        counts, velocities = wheel_odometry(machine.parameters, state, counts, scenario.period)
        v, w = velocities.reshape(2, *shape)
        now = state.reshape(-1, *shape)
        posture = sensors.measure(time, now, posture, v, w, scenario.period)
        ranges = None
        if sonar is not None and echoes is not None:
            here = scenario.world.at(time)
            ranges, echoes = sonar.sense(echoes, k, now[p.X], now[p.Y], now[p.HEADING], sizes, here)
        # hear
        heard = None
        if channel and air is not None:
            heard, air = channel.hear(air, k, condition)
        # decide
        x, y, heading = posture
        seen = Observation(time, x, y, heading, v, w, target, scenario.trajectory, heard, ranges)
        command, memory = controller.control(seen, memory, scenario.period)
        aim = command.target or target
        wish = np.empty((2, *shape))
        wish[0], wish[1] = command.first, command.second
        # stop what is lost
        offset = (now[p.X] - aim.x) ** 2 + (now[p.Y] - aim.y) ** 2
        finite = np.isfinite(wish)
        lost = ~(finite[0] & finite[1] & (offset < scenario.divergence**2)) & (stopped < 0)
        if condition is None:
            held_for = 0.0
        else:
            # Without a new command a robot holds its last, until its watchdog stops it.
            held_for = np.where(condition.held, held_for + scenario.period, 0.0)
            alone = held_for > watchdog + 1e-9
            wish = np.where(condition.held, order, wish)
            wish = np.where(condition.failed | alone, 0.0, wish)
        yield Period(k, time, now, posture, aim, command, wish, condition, heard, stopped, lost, ranges)
        order = wish
        gone = gone or bool(lost.any())
        if gone:
            stopped = np.where(lost, k, stopped)
            order = np.where(stopped >= 0, 0.0, order)
        # say
        if channel and air is not None and command.message is not None:
            air = channel.send(air, k, command.message, now[p.X], now[p.Y], condition)
        # move
        if k < ticks:
            pending = [order.reshape(2, lanes), *pending[:-1]]
            state = machine.advance(
                state, pending[late_periods + 1], pending[late_periods], late_steps, controller.level
            )


def simulate(
    scenario: Scenario,
    controller: Controller,
    seeds: Sequence[int] = (0,),
    *,
    name: str = "",
    links: bool = False,
    faults: Faults | None = None,
    progress: Callable[[], None] | None = None,
) -> Run:
    """Run ``controller`` on ``scenario`` once for every seed.

    ``name`` is what the run calls the controller (default: its class); ``progress`` is called every period. With
    ``links`` the run keeps how old each robot's knowledge of each other was, (samples, runs, robots, robots).
    ``faults`` may differ from run to run; those of the scenario, if not given.
    A robot whose command is not finite, or that is farther than ``scenario.divergence`` from its target, is
    stopped: ``Run.stopped`` says when, and its samples after that are not-a-number.
    """
    seeds = _checked(seeds)
    robots = [member.robot for member in scenario.robots]
    recorded = Recorder(scenario.ticks + 1, len(seeds), robots, team=scenario.kind == "team", links=links)
    for period in drive(scenario, controller, seeds, faults):
        recorded.keep(period)
        if progress is not None:
            progress()
    return recorded.run(scenario, controller.level, seeds, name or type(controller).__name__)


class Recorder:
    """The samples of a simulation as it goes on, and the runs made of them."""

    def __init__(self, samples: int, runs: int, robots: Sequence[Robot], *, team: bool, links: bool = False) -> None:
        """Room for so many ``samples`` of all ``runs``."""
        shape = (runs, len(robots))
        self.limits = p.velocity_limits(robots)
        self.kept = self.limited = 0  # samples; those whose command has been brought within the plant's limits
        self.samples = np.empty((samples, len(CHANNELS), *shape))
        self.team = np.empty((samples, len(TEAM_CHANNELS), *shape)) if team else None
        self.links = np.full((samples, *shape, len(robots)), np.inf, dtype=np.float32) if links else None
        self.modes: np.ndarray | None = None
        self.ranges: np.ndarray | None = None
        self.stopped = np.full(shape, -1)

    def keep(self, period: Period) -> None:
        """Keep one period; they come in their order."""
        k, now, command, target = period.k, period.state, period.command, period.target
        gone = self.stopped >= 0
        stops = bool(gone.any())
        if command.mode is not None:
            if self.modes is None:
                self.modes = np.zeros((len(self.samples), *gone.shape), dtype=np.int8)
            self.modes[k] = np.where(gone, STOPPED, command.mode)
        if period.ranges is not None:
            if self.ranges is None:
                self.ranges = np.empty((len(self.samples), *period.ranges.shape), dtype=np.float32)
            self.ranges[k] = period.ranges
        row = self.samples[k]
        row[:5], row[5:8], row[8:10] = now[: p.W + 1], period.posture, period.order
        row[10], row[11] = command.v, command.w  # without the plant's limits until all is kept
        row[12], row[13] = now[p.EFFORT], now[p.VARIATION]
        if stops:
            row[:, gone] = np.nan
        if self.team is not None:
            row = self.team[k]
            row[0] = np.nan if command.progress is None else command.progress
            row[1], row[2], row[3] = target.x, target.y, target.heading
            row[4] = 0 if period.condition is None else period.condition.code
            if stops:
                row[:, gone] = np.nan
        if self.links is not None and period.heard is not None:
            self.links[k] = np.where(period.heard.hears, period.heard.age, np.inf)
        self.stopped = np.where(period.lost, k, period.stopped)
        self.kept = k + 1

    def run(self, scenario: Scenario, level: str, seeds: tuple[int, ...], name: str, which: slice = slice(None)) -> Run:
        """The run of ``scenario`` with the law called ``name``; ``which`` of the runs of the pass are its seeds.

        It ends with the scenario, or before, if no more was kept.
        """
        end = min(scenario.ticks + 1, self.kept)
        times = scenario.times[:end]
        new = self.samples[self.limited : self.kept]
        new[:, 10], new[:, 11] = p.saturate(self.limits, new[:, 10], new[:, 11])
        self.limited = self.kept

        def mine(kept: np.ndarray | None, axis: int = 1) -> np.ndarray | None:
            return None if kept is None else kept[:end, :, which] if axis == 2 else kept[:end, which]

        return Run(
            scenario.name,
            name,
            level,
            seeds,
            times,
            self.samples[:end, :, which],
            np.stack(scenario.trajectory.sampled(times)),
            tuple(path.table[:2] for path in scenario.trajectory.paths),
            np.where(self.stopped[which] < end, self.stopped[which], -1),
            mine(self.team, axis=2),
            mine(self.links),
            mine(self.modes),
            None if scenario.world is None else mine(self.ranges),
            _obstacles(scenario, times),
        )


def _obstacles(scenario: Scenario, times: np.ndarray) -> Geometry | None:
    """Where the obstacles are at ``times`` [s]; once, if none moves."""
    world = scenario.world
    if world is None or world.motion is None:
        return None if world is None else world.rest
    seen = [world.at(time) for time in times]
    circles, segments = (np.concatenate([getattr(g, name) for g in seen]) for name in ("circles", "segments"))
    bodies, counts = (np.repeat(getattr(world.rest, name), len(seen), axis=0) for name in ("bodies", "counts"))
    return Geometry(circles, bodies, segments, counts)


def _checked(seeds: Sequence[int]) -> tuple[int, ...]:
    for seed in seeds:
        if isinstance(seed, bool) or not isinstance(seed, (int, np.integer)) or seed < 0:
            raise SimulationError(f"a seed is a whole number >= 0, got {seed!r}")
    if len(seeds) == 0:
        raise SimulationError("at least one seed is needed")
    return tuple(int(seed) for seed in seeds)


def _start(scenario: "Scenario | Ensemble", generators: Sequence[np.random.Generator]) -> np.ndarray:
    """The state at time 0: each robot a little off where it believes to stand, as the scenario's sensing says."""
    shape = (len(generators), len(scenario.robots), 3)
    believed = np.broadcast_to(scenario.starts, shape).reshape(-1, 3)
    sensing = [m.sensing or scenario.sensing for m in scenario.robots]
    spread = np.tile([(s.start_position, s.start_position, s.start_heading) for s in sensing], (len(generators), 1))
    draws = np.concatenate([g.standard_normal((len(scenario.robots), 3)) for g in generators])
    return p.initial_state(believed + draws * spread, believed)
