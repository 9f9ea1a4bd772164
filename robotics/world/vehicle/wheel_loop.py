"""The wheel loop of a robot: its response to a step of the command, and gains tuned by simulating it."""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Literal, NamedTuple

import numpy as np

from robotics.world.vehicle import plant
from robotics.world.vehicle.plant import STEP, ParameterColumns, Plant, TruthColumns
from robotics.world.vehicle.robot import RULES, Robot

Motion = Literal["straight", "spot"]
MOTIONS: tuple[Motion, ...] = ("straight", "spot")  # straight on, and turning on the spot
_SHOWN = 0.5  # of the top speed: the step that is shown
TRIED = (0.2, 0.35, 0.5, 0.65, 0.8)  # of the top speed: the steps by which gains are judged
_BAND = 0.02  # of the step: a wheel has settled when it stays within it
MOST_OVERSHOOT = 0.05  # of the step
DAMPING = (0.0, 0.5, 1.0)  # kd that are tried, in kp times the loop's period
_FACTORS = np.geomspace(0.125, 8.0, 17)  # of the derived gains, that are tried first
_FILTER_DAMPING = 0.7  # of the low-pass on the measured wheel speed
_FINER = np.geomspace(0.75, 1.333, 9)  # of the best of those, that are tried then


@dataclass(frozen=True, eq=False)
class WheelResponse:
    """A wheel's response to a step of the command from rest, every 10 ms; bounds of the acceleration are left out."""

    motion: Motion
    command: float  # rad/s: what the right wheel is to turn
    time: np.ndarray  # (samples,) s
    speed: np.ndarray  # (samples,) rad/s: of the right wheel
    voltage: np.ndarray  # (samples,) V: of its motor

    @property
    def overshoot(self) -> float:
        """By how much of the step the speed exceeds it at most."""
        return float(_overshoot(self.speed / self.command))

    @property
    def settling_time(self) -> float:
        """The time [s] from which the speed stays within 2 % of the step; infinite if it does not by the end."""
        return float(_settling_time(self.speed / self.command))


class Gains(NamedTuple):
    """The gains of a wheel loop."""

    kp: float  # V s/rad
    ki: float  # V/rad
    kd: float  # V s²/rad


def wheel_lag(robot: Robot) -> float:
    """τ [s]: the time constant with which the wheels follow a command; 0 where the loop is faster than its period.

    A loop without an integral part never arrives; of it the time constant is given with which it comes to rest.
    """
    if robot.ki == 0:
        return robot.wheel_load / (robot.torque_constant * (robot.back_emf + robot.kp))
    late = _FILTER_DAMPING / (math.pi * robot.filter_frequency) if robot.filter_frequency > 0 else 0.0
    return max(robot.back_emf / robot.ki - STEP - late, 0.0)


def top_speed(robot: Robot, motion: Motion) -> float:
    """The speed [rad/s] that a wheel reaches at most when the robot drives straight on, or turns on the spot."""
    most = robot.v_max if motion == "straight" else robot.w_max * robot.half_axle
    return min(most / robot.wheel_radius, robot.wheel_speed_max)


def step_response(robot: Robot, motion: Motion, level: float = _SHOWN) -> WheelResponse:
    """The response to a step from rest to ``level`` of the top speed, of the dynamic plant."""
    command = level * top_speed(robot, motion)
    states = TruthColumns(_driven(_lane(robot)[:, None], np.array([command]), (motion,), robot)[:, :, 0].T)
    wheel = states.right
    rate = (wheel.speed - wheel.past) / STEP
    voltage = robot.kp * (command - wheel.speed) + wheel.integral - robot.kd * rate
    bounded = np.clip(voltage, -robot.supply_voltage, robot.supply_voltage)
    speed = _right_wheel(states, robot)
    return WheelResponse(motion, command, STEP * np.arange(len(speed)), speed, bounded)


def tuned(robot: Robot) -> Gains:
    """The gains with the shortest settling time of the simulated wheel, at an overshoot of 5 % or less.

    Judged is the worst of ten steps from rest, to 20 % up to 80 % of the top speed, straight on and on the spot; of
    equal ones the smallest integral of the absolute error decides. Tried are gains around the derived ones, in a grid
    that is refined three times; kd only where it saves a period of the loop. The plant has no noise but that of its
    encoders, so that the gains follow from the robot alone. Where no gains keep the bound, those of the least overshoot
    are given.
    """
    usual = Gains(RULES["kp"].value(robot), 0.0, 0.0)
    usual = usual._replace(ki=RULES["ki"].value(replace(robot, kp=usual.kp)))
    best, least = _best(robot, _grid(usual, _FACTORS, 0.0))
    for _ in range(3):
        best, least = _best(robot, _grid(best, _FINER, 0.0))
    for share in DAMPING[1:]:
        damped, cost = _best(robot, _grid(best, _FINER, share * best.kp * STEP))
        if cost < least - STEP:
            best, least = damped, cost
    return best


def _grid(around: Gains, factors: np.ndarray, kd: float) -> list[Gains]:
    return [Gains(_rounded(around.kp * a), _rounded(around.ki * b), _rounded(kd)) for a in factors for b in factors]


def _rounded(gain: float) -> float:
    return float(f"{gain:.3g}")  # as it is printed and written: what is tried is what is given


def _best(robot: Robot, tried: Sequence[Gains]) -> tuple[Gains, float]:
    """The best of some gains, and its cost: about the settling time [s]."""
    cases = [(motion, level) for motion in MOTIONS for level in TRIED]
    motions = tuple(motion for motion, _ in cases) * len(tried)
    commands = np.array([level * top_speed(robot, motion) for motion, level in cases] * len(tried))
    lanes = np.repeat(np.array(tried), len(cases), axis=0)
    table = np.repeat(_lane(robot)[:, None], len(lanes), axis=1)
    gains = ParameterColumns(table)
    gains.kp, gains.ki, gains.kd = lanes.T
    share = _right_wheel(TruthColumns(_driven(table, commands, motions, robot).swapaxes(0, 1)), robot) / commands
    worst = np.stack([_settling_time(share), _overshoot(share), np.abs(1 - share).sum(axis=0) * STEP])
    settling, overshoot, error = worst.reshape(3, len(tried), len(cases)).max(axis=2)
    fair = (overshoot <= MOST_OVERSHOOT) & np.isfinite(settling)
    # What does not keep the bounds costs more than any time, and the more, the farther it is off.
    late = STEP * len(share) * (1 + np.maximum(overshoot, 0.0))
    cost = np.where(fair, settling, late) + 1e-3 * STEP * error  # the error decides among equals only
    k = int(np.argmin(cost))
    return tried[k], float(cost[k])


def _lane(robot: Robot) -> np.ndarray:
    return plant.parameters(replace(robot, v_rate_max=None, w_rate_max=None))


def _driven(table: np.ndarray, commands: np.ndarray, motions: Sequence[Motion], robot: Robot) -> np.ndarray:
    """The states (samples, TruthColumns, lanes) from rest to ``commands`` of the wheels [rad/s]."""
    ground = commands * robot.wheel_radius
    straight = np.array([motion == "straight" for motion in motions])
    command = np.stack([np.where(straight, ground, 0.0), np.where(straight, 0.0, ground / robot.half_axle)])
    machine = Plant(table, steps=1)
    state = plant.initial_state(np.zeros((len(commands), 3)))
    kept = [state]
    seconds = max(1.0, 20 * robot.loop_time, 4 * robot.motor_time)
    for _ in range(round(seconds / STEP)):
        state = machine.advance(state, command, command, 0, "velocity")
        kept.append(state)
    return np.stack(kept)


def _right_wheel(states: TruthColumns, robot: Robot) -> np.ndarray:
    """The speed [rad/s] of the right wheel (samples, ...)."""
    return np.asarray((states.v + robot.half_axle * states.w) / robot.wheel_radius)


def _overshoot(share: np.ndarray) -> np.ndarray:
    """By how much ``share`` (samples, ...) of the step exceeds 1."""
    return np.maximum(share.max(axis=0) - 1, 0.0)


def _settling_time(share: np.ndarray) -> np.ndarray:
    """The time [s] from which ``share`` (samples, ...) of the step stays within the band around 1."""
    outside = np.abs(share - 1) > _BAND
    last = len(share) - np.argmax(outside[::-1], axis=0)  # samples up to the last one outside
    return np.where(outside[-1], np.inf, np.where(outside.any(axis=0), last * STEP, 0.0))
