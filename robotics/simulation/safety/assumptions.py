"""What passive safety assumes, in numbers: how a robot stops, how sure its sensors are, and how others move.

``docs/explanation/passive-safety.md`` states each assumption in words and proves what follows from all of them.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cache

import numpy as np

from robotics.laws.setting import Setting
from robotics.world.radio.description import Radio
from robotics.world.vehicle.plant import STEP, Plant, TruthColumns, initial_state, parameters
from robotics.world.vehicle.robot import Robot

AT_REST = 0.02  # m/s: a robot of which no point is faster stands
CREEPS = 0.85  # of that: told to drive so slowly it stands, with all that wheels overshoot and encoders' steps turn it
DEVIATIONS = 3.5  # standard deviations by which a reading, or a posture, is off at most
OVERSHOOT = 1.06  # a wheel turns no faster than this share of what was commanded
WINDOW_CELLS = 48  # of the ground that a robot remembers, along x and along y
CELLS_A_RADIUS = 5.0  # of the robot's turning circle
UNHEARD = 1e-5  # the probability with which a robot is not heard within the stated delay
SPARE = 1.05  # the stopping model goes so much farther than the plant
SPEEDS_UP = 1.25  # of what motors can, by their greatest torque: how fast wheels are taken to grow faster
_STEPS = 400  # of 10 ms: by then every robot stands
_SPEEDS = np.linspace(0.1, 1.0, 10)  # of the highest: from where it is stopped
GENTLE = 0.7  # of how hard wheels brake: where orders fall no faster, none of them swings back
STOP_NEAR = 0.02  # of the turning circle: by so much the model may go less far
_BESIDE = np.array([0.0, 0.5, 1.0])  # of what its wheels have left: how it turns, or drives, beside that


@dataclass(frozen=True)
class StoppingModel:
    """How a robot stops: its command falls at a rate, and each wheel follows with a time constant, within a bound.

        u' = -rate,   r' = -min((r - u)/lag, braking)     r: the speed of the rim; and the other wheel likewise

    Straight on, after d = v²/(2 rate) + v lag it stands; where the command falls at once, and v > b lag, after
    (v² - b² lag²)/(2 b) + b lag².
    """

    lag: float  # s
    braking: float  # m/s²: what motors and tyres can, of the rim of a wheel
    v_rate: float  # m/s²: how fast a commanded speed may change; infinite: at once
    w_rate: float  # rad/s²: likewise a commanded turn rate
    rise: float  # m/s²: how fast the speed of a rim may grow before that

    def distance(self, speed: float) -> float:
        """How far it goes straight on [m] from a steady ``speed`` [m/s] until it stands."""
        slow = self.braking * self.lag
        if self.v_rate < math.inf or speed <= slow:
            return speed**2 / (2 * self.v_rate) + speed * self.lag
        return (speed**2 - slow**2) / (2 * self.braking) + slow * self.lag

    def ways(self, v: np.ndarray, w: np.ndarray, half_axle: float) -> tuple[np.ndarray, np.ndarray]:
        """How far it goes [m], and turns [rad], from steady speeds [m/s] and turn rates [rad/s] until it stands."""
        held_v, held_w, gone, turned = v.copy(), w.copy(), np.zeros(len(v)), np.zeros(len(v))
        right, left = v + half_axle * w, v - half_axle * w
        for _ in range(_STEPS):
            held_v = np.maximum(held_v - self.v_rate * STEP, 0.0)
            held_w = np.maximum(held_w - self.w_rate * STEP, 0.0)
            right = self._slower(right, held_v + half_axle * held_w)
            left = self._slower(left, held_v - half_axle * held_w)
            gone += STEP * np.maximum(right + left, 0.0) / 2
            turned += STEP * np.maximum(right - left, 0.0) / (2 * half_axle)
        return gone, turned

    def _slower(self, speed: np.ndarray, held: np.ndarray) -> np.ndarray:
        less = np.minimum(np.abs(speed - held) * min(STEP / max(self.lag, STEP), 1.0), self.braking * STEP)
        return np.asarray(speed - np.sign(speed - held) * less)


@cache
def stopping(robot: Robot, kinematic: bool = False, gentle: bool = False) -> StoppingModel:
    """The model of a robot's stop: the shortest lag that its plant keeps from any motion.

    The plant, with wheel loops, motors and friction, is braked from sixty motions; the model goes SPARE times as far.
    A ``kinematic`` plant stops at once, within the bounds of its command. In a ``gentle`` stop commands fall so that no
    wheel swings back.
    """
    if gentle:
        hard = stopping(robot, kinematic)
        rate = GENTLE * hard.braking
        return replace(hard, v_rate=min(hard.v_rate, rate), w_rate=min(hard.w_rate, rate / robot.half_axle))
    rates = robot.v_rate_max or math.inf, robot.w_rate_max or math.inf
    if kinematic:
        return StoppingModel(0.0, math.inf, *rates, math.inf)
    force = max(2 * (robot.torque_limit - robot.friction_torque), 1e-3) / robot.wheel_radius
    light = 1 / robot.effective_mass, robot.half_axle**2 / robot.effective_inertia
    braking, rise = 0.9 * force * min(light), SPEEDS_UP * 2 * robot.torque_limit / robot.wheel_radius * max(light)
    v, w, gone, turned, _ = _braked(robot)
    low, high, near = 0.0, 2.0, STOP_NEAR * robot.turning_circle
    for _ in range(30):
        middle = (low + high) / 2
        model = StoppingModel(middle, braking, *rates, rise)
        goes, turns = model.ways(v, w, robot.half_axle)
        far = (goes >= SPARE * gone - near).all() and (turns >= SPARE * turned - near / robot.half_axle).all()
        low, high = (low, middle) if far else (middle, high)
    return StoppingModel(high, braking, *rates, rise)


@cache
def _braked(robot: Robot) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray, float]:
    """From which v and ω the plant was told to stop, how far it went [m] and turned [rad], and when [s] all stood.

    Along with driving it turns, and along with turning it drives, by some share of what its wheels have left.
    """
    most = min(robot.v_max, robot.wheel_speed_limit), min(robot.w_max, robot.wheel_speed_limit / robot.half_axle)
    mine, other = (grid.ravel() for grid in np.meshgrid(_SPEEDS, _BESIDE))
    scale, commands = (1.0, robot.half_axle), []
    for axis in (0, 1):
        left = np.maximum(robot.wheel_speed_limit - scale[axis] * mine * most[axis], 0.0) / scale[1 - axis]
        pair = mine * most[axis], other * np.minimum(most[1 - axis], left)
        commands.append(pair if axis == 0 else pair[::-1])
    command = np.concatenate(commands, axis=1)
    lanes = command.shape[1]
    plant = Plant(np.repeat(parameters(robot)[:, None], lanes, axis=1), steps=1)
    state, gone, turned, stood = initial_state(np.zeros((lanes, 3))), np.zeros(lanes), np.zeros(lanes), 0
    for _ in range(_STEPS):
        state = plant.advance(state, command, command, 0, "velocity")
    begin = TruthColumns(state.copy())
    for step in range(_STEPS):
        now = TruthColumns(state)
        if (np.abs(now.v) + robot.turning_circle * np.abs(now.w)).max() > AT_REST:
            stood = step + 1
        gone += STEP * np.maximum(now.v, 0.0)
        turned += STEP * np.maximum(now.w, 0.0)
        state = plant.advance(state, np.zeros_like(command), np.zeros_like(command), 0, "velocity")
    return np.array(begin.v), np.array(begin.w), gone, turned, STEP * stood


@cache
def stopping_time(robot: Robot, kinematic: bool = False, gentle: bool = False) -> float:
    """The time [s] from the command to stop until a robot stands, from its fastest motions."""
    if gentle:
        model = stopping(robot, kinematic, gentle)
        return stopping_time(robot, kinematic) + max(robot.v_max / model.v_rate, robot.w_max / model.w_rate)
    if kinematic:
        rates = (robot.v_max / (robot.v_rate_max or math.inf), robot.w_max / (robot.w_rate_max or math.inf))
        return max(rates)
    return SPARE * _braked(robot)[4]


def radio_delay(radio: Radio, period: float) -> float:
    """The stated delay [s]: older messages than this are as good as none; they are as rare as UNHEARD."""
    loss = max(radio.loss, radio.burst_loss if radio.burst_start > 0 else 0.0)
    missed = 0 if loss == 0 else math.ceil(math.log(UNHEARD) / math.log(min(loss, 0.99)))
    if radio.burst_start > 0:
        missed = max(missed, math.ceil(math.log(UNHEARD) / math.log(max(1 - radio.burst_end, 1e-9))))
    return radio.latency + radio.jitter + (1 + missed) * radio.period + period


def fastest_other(setting: Setting) -> float:
    """The greatest speed [m/s] of what moves among the obstacles: as stated, or else that of the fastest one."""
    if setting.others_speed is not None:
        return setting.others_speed
    if setting.world is None or setting.world.motion is None:
        return 0.0
    return float(np.abs(setting.world.motion.sampled(setting.times).v).max())


def cell_size(robot: Robot) -> float:
    """The size [m] of the cells of the ground that a robot remembers."""
    return robot.turning_circle / CELLS_A_RADIUS


def least_gap(robot: Robot) -> float:
    """What is left [m] between a robot's body and the middle of the nearest cell that is not known to be free.

    A thing at the body has the middle of a cell within 1.12 cells (a flat side, a cell and a half thick); between two
    looks along the way the body goes a quarter of a cell, a corner hides an eighth, and the model of the stop may be
    short by a tenth (STOP_NEAR).
    """
    return 1.6 * cell_size(robot)


def posture_spread(setting: Setting) -> Sequence[tuple[float, float]]:
    """By how much the measured posture of each robot may be off: [m], [rad]."""
    found = []
    for sensing in setting.sensing:
        place, turn = (DEVIATIONS * getattr(sensing, name) for name in ("position_noise", "heading_noise"))
        found.append((place + DEVIATIONS * sensing.start_position, turn + DEVIATIONS * sensing.start_heading))
    return found
