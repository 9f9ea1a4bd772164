"""The one simulation: sense, hear, decide, say, move; all seeds of a scenario in one array pass.

Every run draws from its own generator, seeded by its own seed: a run's result does not depend, to the last bit,
on which runs are beside it.
"""

from collections.abc import Callable, Iterator, Sequence
from math import inf
from typing import TYPE_CHECKING, Any

import numpy as np

from fuzzy.errors import InputError
from robotics.environment.collision import footprints
from robotics.laws.law import Controller, Observation
from robotics.paths.trajectory import Reference
from robotics.radio.channel import Channel
from robotics.radio.faults import Faults
from robotics.scenario.description import STEP, Scenario
from robotics.sensing.posture import PostureSensors, wheel_errors, wheel_odometry
from robotics.sensing.sonar import RangeSensor, SensorArray
from robotics.simulation.recorder import Period, Recorder
from robotics.simulation.run import Run
from robotics.vehicle import plant as p

if TYPE_CHECKING:
    from robotics.scenario.ensemble import Ensemble


class SimulationError(InputError):
    """A simulation that cannot start: no seeds, or a seed that is no whole number >= 0."""


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
    sensing = [member.sensing or scenario.sensing for member in scenario.robots]
    errors = wheel_errors(sensing, seeds)
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
    sensors = PostureSensors.of(sensing, ticks, generators, seeds)
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
