"""What a certificate assumes of a robot's wheels: measured on the simulated plant, not derived from a lag.

Over a period of the law the mean of v, and that of ω, is a weighted mean of the newest commands, within a share of the
width of the hull of all commands of the last :data:`WINDOW` periods and a constant; where a wheel may have turned round
shortly before, friction adds another. At any time of the period v and ω lie in the hull of the newest commands, widened
likewise. Weights are least squares, constants the greatest that were seen, times _MARGIN: in oscillations of the
command about a steady drive, which decay as those of a loop that converges.
"""

import itertools
import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from robotics.world.vehicle import plant
from robotics.world.vehicle.plant import STEP, Plant, TruthColumns
from robotics.world.vehicle.robot import Robot
from robotics.world.vehicle.wheel_loop import wheel_lag

WINDOW = 14  # periods, beyond which an old command no longer tells
TURNING_PERIODS = 6  # periods for which a wheel that turned round tells
SLOW_RIM = 0.004  # m/s, of a wheel's rim: below it the wheel may turn round
_MARGIN = 1.3
RIPPLES = 1.5  # the same of what encoders and friction add at any time
_TURNED = 2.5  # the same of what friction adds, which depends on the moment at which a wheel turns round
HULL_SHARE = 0.01  # of the width of the hull
RIPPLE_SHARE = 0.05  # of the width of the hull of the newest commands
_DRIVES, _PERIODS = 800, 70
_SLOWEST = 0.05  # m/s, at which wheels turn round in curves
USABLE = 0.9  # of the wheels' greatest speed: beyond it friction and the supply keep a wheel from its command


@dataclass(frozen=True)
class WheelModel:
    """What is assumed of a robot's wheels, for v [m/s] and ω [rad/s] in turn; errors are bounds.

    Attributes:
        weights: Of the command of each age in the mean of a period (ages, 2).
        prompt: How many commands beside the newest bound v and ω at any time of a period.
        error: Of the mean, beside the share of the hull's width (2,).
        reversal: The same, in addition, where a wheel may have turned round (2,).
        ripple: Beyond the hull at any time (2,).
    """

    weights: np.ndarray
    prompt: int
    error: np.ndarray
    reversal: np.ndarray
    ripple: np.ndarray


@dataclass(frozen=True)
class Drives:
    """Commands and what the wheels made of them: (periods, 2, drives), at any time (periods, steps + 1, 2, drives)."""

    commands: np.ndarray
    means: np.ndarray
    instants: np.ndarray


def drive(robot: Robot, commands: np.ndarray, period: float, latency: float = 0.0) -> Drives:
    """Let the simulated plant follow ``commands`` (periods, 2, drives), the first of which it has settled at."""
    n, steps = commands.shape[2], round(period / STEP)
    machine = Plant(np.repeat(plant.parameters(robot)[:, None], n, axis=1), steps=1)
    state = plant.initial_state(np.zeros((n, 3)))
    for _ in range(round(2 / STEP)):
        state = machine.advance(state, commands[0], commands[0], 0, "velocity")
    late = round(latency / STEP)
    means, instants = [], []
    for k in range(len(commands)):
        held = [commands[max((k * steps + i - late) // steps, 0)] for i in range(steps)]
        state, mean, row = driven_period(machine, state, held, period)
        means.append(mean)
        instants.append(row)
    return Drives(commands, np.array(means), np.array(instants))


def driven_period(
    machine: Plant, state: np.ndarray, held: Sequence[np.ndarray], period: float
) -> tuple[np.ndarray, np.ndarray, list[np.ndarray]]:
    """Let the plant follow ``held``, a command (2, drives) each step of a ``period`` [s].

    Returns its state, the means of v [m/s] and ω [rad/s] (2, drives), and both at each end of a step.
    """
    heading, row = TruthColumns(state).heading.copy(), [_velocity(state)]
    for command in held:
        state = machine.advance(state, command, command, 0, "velocity")
        row.append(_velocity(state))
    speed = np.mean([(a[0] + b[0]) / 2 for a, b in itertools.pairwise(row)], axis=0)
    return state, np.array([speed, (TruthColumns(state).heading - heading) / period]), row


def _velocity(state: np.ndarray) -> np.ndarray:
    here = TruthColumns(state)
    return np.array([here.v, here.w])


def measure_wheels(
    robot: Robot, speeds: tuple[float, float], curvature: float, period: float, latency: float = 0.0, seed: int = 0
) -> WheelModel:
    """Measure what may be assumed of a robot's wheels about references of some speeds [m/s] and curvatures [1/m]."""
    rng = np.random.default_rng(seed)
    v = rng.uniform(min(_SLOWEST, speeds[0]), speeds[1], _DRIVES)
    base = np.stack([v, v * rng.uniform(-curvature, curvature, _DRIVES)])
    time = np.maximum(np.arange(_PERIODS) - WINDOW, 0)[:, None] * period
    parts = []
    for size in (np.minimum(0.5 * v, 0.15), 0.8 / max(robot.half_axle / 0.1, 0.5)):
        rate, damping = rng.uniform(1.0, 5.0, _DRIVES), rng.uniform(0.4, 1.0, _DRIVES)
        turn = rate * np.sqrt(1 - damping**2) * time + rng.uniform(0, math.pi, _DRIVES)
        parts.append(rng.uniform(-1, 1, _DRIVES) * size * np.exp(-damping * rate * time) * np.cos(turn))
    commands = base[None] + np.stack(parts, axis=1)
    limits = plant.velocity_limits([robot]) * np.array([[1.0], [1.0], [1.0], [USABLE]])
    v, w = plant.saturate(np.repeat(limits, _DRIVES, axis=1), commands[:, 0], commands[:, 1])
    drives = drive(robot, np.stack([v, w], axis=1), period, latency)
    ages = 2 + math.ceil((latency + wheel_lag(robot)) / period)
    weights = np.array([_weights(drives, axis, ages) for axis in range(2)]).T
    model = WheelModel(weights, ages + 1, np.zeros(2), np.zeros(2), np.zeros(2))
    steady, reversing, beyond = differences(robot, model, drives)
    return WheelModel(
        weights, ages + 1, _MARGIN * steady, _TURNED * np.maximum(reversing - steady, 0.0), RIPPLES * beyond
    )


def _weights(drives: Drives, axis: int, ages: int) -> np.ndarray:
    """The weights (ages,), whose sum is 1, by least squares."""
    past = _past(drives.commands[:, axis], ages)
    newer = (past[:-1] - past[-1]).reshape(ages - 1, -1)
    found = np.linalg.lstsq(newer.T, (drives.means[WINDOW:, axis] - past[-1]).ravel(), rcond=None)[0]
    return np.append(found, 1 - found.sum())


def _past(commands: np.ndarray, ages: int) -> np.ndarray:
    """The commands of each age (ages, periods from WINDOW on, ...)."""
    at = np.arange(WINDOW, len(commands))
    return np.array([commands[at - age] for age in range(ages)])


def differences(robot: Robot, model: WheelModel, drives: Drives) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """By how much drives differ from the weighted mean (2,), where a wheel turned round (2,), and from the hull (2,).

    Beside the shares of the widths of the hulls: what ``error``, ``error + reversal`` and ``ripple`` must bound.
    """
    all_past = _past(drives.commands, WINDOW)
    wide = all_past.max(axis=0) - all_past.min(axis=0)
    turning = all_past[: TURNING_PERIODS + 1]
    low, high, rim = turning.min(axis=0), turning.max(axis=0), robot.half_axle
    turns = np.zeros(low[:, 0].shape, bool)
    for sign in (1, -1):
        ends = sign * rim * np.stack([low[:, 1], high[:, 1]])
        turns |= (low[:, 0] + ends.min(axis=0) < SLOW_RIM) & (high[:, 0] + ends.max(axis=0) > -SLOW_RIM)
    mean = np.einsum("ia,ikan->kan", model.weights, all_past[: len(model.weights)])
    off = np.abs(drives.means[WINDOW:] - mean) - HULL_SHARE * wide
    newest = all_past[: model.prompt + 1]
    low, high = newest.min(axis=0), newest.max(axis=0)
    at = drives.instants[WINDOW:]
    out = np.maximum(at - high[:, None], low[:, None] - at).max(axis=1) - RIPPLE_SHARE * (high - low)
    axes = range(2)
    steady = np.array([off[:, a][~turns].max(initial=0.0) for a in axes])
    reversing = np.array([off[:, a][turns].max(initial=0.0) for a in axes])
    rest = np.where(turns, out.min(), 1.0)
    beyond = np.array([np.where(rest == 1.0, out[:, a], -np.inf).max(initial=0.0) for a in axes])
    return steady, reversing, beyond
