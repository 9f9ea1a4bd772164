"""The one simulation: sense, decide, move, record; all seeds of a scenario in one array pass.

Every run draws from its own generator, seeded by its own seed: a run's result does not depend, to the last bit,
on which runs are beside it.
"""

from collections.abc import Callable, Iterator, Sequence

import numpy as np

from fuzzy.errors import InputError
from robotics import plant as p
from robotics.controller import Controller, Observation
from robotics.run import CHANNELS, REFERENCE, Run
from robotics.scenario import STEP, Scenario

_NOISE_BLOCK = 256  # periods of noise drawn at a time: bounds memory without a call a period and run


class SimulationError(InputError):
    """A simulation that cannot start: no seeds, or a seed that is no whole number >= 0."""


def simulate(
    scenario: Scenario,
    controller: Controller,
    seeds: Sequence[int] = (0,),
    *,
    name: str = "",
    progress: Callable[[], None] | None = None,
) -> Run:
    """Run ``controller`` on ``scenario`` once for every seed.

    ``name`` is what the run calls the controller (default: its class); ``progress`` is called every period.
    A robot whose command is not finite, or that is farther than ``scenario.divergence`` from its reference, is
    stopped: ``Run.stopped`` says when, and its samples after that are not-a-number.
    """
    seeds = _checked(seeds)
    runs, robots, ticks = len(seeds), len(scenario.robots), scenario.ticks
    shape, lanes = (runs, robots), runs * robots
    machine = p.Plant(
        np.tile(np.stack([p.parameters(m.robot, STEP) for m in scenario.robots], axis=1), (1, runs)),
        steps=round(scenario.period / STEP),
        step=STEP,
        kinematic=scenario.plant == "kinematic",
    )
    limits = p.velocity_limits([m.robot for m in scenario.robots])
    late_periods, late_steps = divmod(round(scenario.latency / STEP), machine.steps)
    generators = [np.random.default_rng(seed) for seed in seeds]
    state = _start(scenario, generators)
    noise = _posture_noise(scenario, generators)
    memory = controller.init(scenario, runs)
    pending = [np.zeros((2, lanes))] * (late_periods + 2)  # commands on their way, newest first
    counts = encoder_counts(machine.parameters, state)
    stopped = np.full(shape, -1)
    samples = np.empty((ticks + 1, len(CHANNELS), runs, robots))
    reference = np.empty((len(REFERENCE), ticks + 1, robots))
    for k in range(ticks + 1):
        target = scenario.trajectory.at(k * scenario.period)
        reference[:, k] = target
        # sense
        before, counts = counts, encoder_counts(machine.parameters, state)
        v, w = wheel_odometry(machine.parameters, (counts - before) / scenario.period)
        now = state.reshape(-1, *shape)
        posture = now[p.ODO_X : p.ODO_HEADING + 1] if noise is None else now[p.X : p.HEADING + 1] + next(noise)
        # decide
        x, y, heading = posture
        seen = Observation(
            k * scenario.period, x, y, heading, v.reshape(shape), w.reshape(shape), target, scenario.trajectory
        )
        command, memory = controller.control(seen, memory, scenario.period)
        # record
        row = samples[k]
        row[:5] = now[: p.W + 1]
        row[5:8] = posture
        row[8], row[9] = command.first, command.second
        row[10:12] = p.saturate(limits, command.v, command.w)
        row[12], row[13] = now[p.EFFORT], now[p.VARIATION]
        # stop what is lost
        offset = (now[p.X] - target.x) ** 2 + (now[p.Y] - target.y) ** 2
        lost = ~(np.isfinite(row[8]) & np.isfinite(row[9]) & (offset < scenario.divergence**2)) & (stopped < 0)
        order = row[8:10]
        if lost.any() or (stopped >= 0).any():
            row[:, (stopped >= 0)] = np.nan
            stopped = np.where(lost, k, stopped)
            order = np.where(stopped >= 0, 0.0, order)
        # move
        if k < ticks:
            pending = [order.reshape(2, lanes), *pending[:-1]]
            state = machine.advance(
                state, pending[late_periods + 1], pending[late_periods], late_steps, controller.level
            )
        if progress is not None:
            progress()
    return Run(
        scenario.name,
        name or type(controller).__name__,
        controller.level,
        seeds,
        scenario.times,
        samples,
        reference,
        tuple(path.table[:2] for path in scenario.trajectory.paths),
        stopped,
    )


def _checked(seeds: Sequence[int]) -> tuple[int, ...]:
    for seed in seeds:
        if isinstance(seed, bool) or not isinstance(seed, (int, np.integer)) or seed < 0:
            raise SimulationError(f"a seed is a whole number >= 0, got {seed!r}")
    if len(seeds) == 0:
        raise SimulationError("at least one seed is needed")
    return tuple(int(seed) for seed in seeds)


def _start(scenario: Scenario, generators: Sequence[np.random.Generator]) -> np.ndarray:
    """The state at time 0: each robot a little off where it believes to stand, as the scenario's sensing says."""
    believed = np.tile(np.array([m.start for m in scenario.robots]), (len(generators), 1))
    sensing = scenario.sensing
    spread = np.array([sensing.start_position, sensing.start_position, sensing.start_heading])
    draws = np.concatenate([g.standard_normal((len(scenario.robots), 3)) for g in generators])
    return p.initial_state(believed + draws * spread, believed)


def _posture_noise(scenario: Scenario, generators: Sequence[np.random.Generator]) -> Iterator[np.ndarray] | None:
    """Noise on the measured posture (3, runs, robots), period by period; None where odometry measures instead."""
    sensing = scenario.sensing
    if sensing.posture == "odometry":
        return None
    scale = np.array([sensing.position_noise, sensing.position_noise, sensing.heading_noise])
    robots = len(scenario.robots)

    def draw() -> Iterator[np.ndarray]:
        periods = min(_NOISE_BLOCK, scenario.ticks + 1)
        draws = np.empty((len(generators), periods, 3, robots))
        while True:
            for generator, rows in zip(generators, draws, strict=True):
                generator.standard_normal(out=rows)
            draws *= scale[:, None]
            yield from draws.transpose(1, 2, 0, 3)  # a view: the sum of truth and noise is a new array

    def none() -> Iterator[np.ndarray]:
        while True:
            yield np.zeros((3, len(generators), robots))

    return draw() if scale.any() else none()


def encoder_counts(parameters: np.ndarray, state: np.ndarray) -> np.ndarray:
    """What the encoders have counted so far (2, lanes), right and left: whole numbers."""
    return np.floor(state[p.ANGLE_R : p.ANGLE_L + 1] * parameters[p.P_COUNT])


def wheel_odometry(parameters: np.ndarray, counts: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Velocities v [m/s] and ω [rad/s], each (lanes,), from encoder counts a second (2, lanes)   thesis (2.25)."""
    right, left = counts / parameters[p.P_COUNT] * parameters[p.P_RADIUS]
    return (right + left) / 2, (right - left) / (2 * parameters[p.P_HALF_AXLE])
