"""The model that is fitted to a drive: the simulator's own plant, in coordinates that a drive can tell.

A drive tells no masses and no volts, only how fast wheels answer. Each coordinate is therefore a time, a speed, an
acceleration or a ratio, and :func:`robot_with` turns them into the fields of a :class:`Robot` of a given mass, size and
back EMF. Two things are no part of a robot: the latency, which belongs to a scenario, and what wheels and odometry
make of a command (gains).

The encoders of the fitted model count so finely that its output is smooth in all coordinates but the dead band.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from math import pi, sqrt
from typing import NamedTuple

import numpy as np

from fuzzy.compiled.jit import without_refcounts
from fuzzy.compiled.threads import share_out
from robotics.world.vehicle import plant
from robotics.world.vehicle.plant import ParameterColumns, TruthColumns
from robotics.world.vehicle.robot import Robot
from robotics.world.vehicle.wheel_loop import wheel_lag

MODEL_STEP = plant.STEP
FINE_COUNTS = 1e7  # counts a turn: the smooth model's
_NEVER = 1e3  # what a limit that the base leaves out begins with, in its unit
MODEL_SUBSTEPS = 2  # of Runge-Kutta a step, half of the simulator's: they differ by 1e-6 of a speed
_LANES = 16  # that a thread drives together


class Coordinate(NamedTuple):
    """One number of the model."""

    unit: str
    title: str  # what it is, for people
    field: str  # of Robot that it becomes; "": of none
    least: float
    most: float
    limit: bool = False  # whether it only matters where a drive reaches it
    logarithmic: bool = True  # whether it is fitted by its logarithm


COORDINATES: Mapping[str, Coordinate] = {
    "latency": Coordinate("s", "latency from command to motion", "", 0.0, 1.0, logarithmic=False),
    "lag": Coordinate("s", "lag of the wheel loops: mean delay of a small step", "ki", 2e-3, 2.0),
    "rise_time": Coordinate("s", "rise of the wheel loops: step over first acceleration", "kp", 0.012, 2.0),
    "motor_time": Coordinate("s", "time constant of a motor alone", "torque_constant", 0.01, 3.0),
    "gyration": Coordinate("m", "radius of gyration, wheels and rotors included", "body_inertia", 1e-4, 10.0),
    "friction": Coordinate("m/s²", "deceleration by dry friction", "friction_torque", 0.0, 3.0, logarithmic=False),
    "right_gain": Coordinate("1", "right wheel: measured over commanded speed", "", 0.5, 2.0, logarithmic=False),
    "left_gain": Coordinate("1", "left wheel: measured over commanded speed", "", 0.5, 2.0, logarithmic=False),
    "turn_gain": Coordinate(
        "1", "measured over commanded turn rate, beside the wheels'", "", 0.3, 2.0, logarithmic=False
    ),
    "dead_band": Coordinate("m/s", "dead band of a wheel, at its rim", "dead_band", 0.0, 1.0, logarithmic=False),
    "v_max": Coordinate("m/s", "highest speed", "v_max", 1e-2, 1e4, limit=True),
    "w_max": Coordinate("rad/s", "highest turn rate", "w_max", 1e-2, 1e4, limit=True),
    "wheel_max": Coordinate("m/s", "highest speed of a wheel's rim", "wheel_speed_max", 1e-2, 1e4, limit=True),
    "v_rate_max": Coordinate("m/s²", "limit of the commanded acceleration", "v_rate_max", 1e-2, 1e4, limit=True),
    "w_rate_max": Coordinate(
        "rad/s²", "limit of the commanded angular acceleration", "w_rate_max", 1e-2, 1e4, limit=True
    ),
    "force_limit": Coordinate("m/s²", "acceleration that the wheels' torque can give", "torque_limit", 1e-2, 1e3, True),
}
COORDINATE_NAMES = tuple(COORDINATES)
LIMIT_NAMES = tuple(name for name, each in COORDINATES.items() if each.limit)
DEAD = COORDINATE_NAMES.index("dead_band")
_LOGS = np.array([each.logarithmic for each in COORDINATES.values()])


def to_fit(values: np.ndarray) -> np.ndarray:
    """Values (coordinates, ...) as they are fitted: logarithms of those that are fitted by them."""
    logs = _LOGS.reshape(-1, *(1,) * (values.ndim - 1))
    return np.where(logs, np.log(np.maximum(values, 1e-12)), values)


def from_fit(fitted: np.ndarray) -> np.ndarray:
    """The inverse of :func:`to_fit`."""
    logs = _LOGS.reshape(-1, *(1,) * (fitted.ndim - 1))
    return np.where(logs, np.exp(np.where(logs, fitted, 0.0)), fitted)


# Robots and coordinates -------------------------------------------------------------------------------------------


def values_of(robot: Robot, latency: float = 0.0) -> np.ndarray:
    """The coordinates (coordinates,) of a robot that commands reach after ``latency`` [s]."""
    per_force = 2 / (robot.wheel_radius * robot.effective_mass)
    values = {
        "latency": latency,
        "lag": max(wheel_lag(robot), COORDINATES["lag"].least),
        "rise_time": robot.wheel_load / (robot.torque_constant * max(robot.kp, 1e-9)),
        "motor_time": robot.motor_time,
        "gyration": sqrt(robot.effective_inertia / robot.effective_mass),
        "friction": robot.friction_torque * per_force,
        "right_gain": 1.0,
        "left_gain": 1.0,
        "turn_gain": 1.0,
        "dead_band": robot.dead_band,
        "v_max": robot.v_max,
        "w_max": robot.w_max,
        "wheel_max": robot.wheel_speed_limit,
        "v_rate_max": robot.v_rate_max or _NEVER,
        "w_rate_max": robot.w_rate_max or _NEVER,
        "force_limit": robot.torque_limit * per_force,
    }
    return np.array([values[name] for name in COORDINATE_NAMES])


def fields_of(base: Robot, values: np.ndarray) -> dict[str, float]:
    """The fields of a robot with the mass and size of ``base`` that moves by ``values`` (coordinates,)."""
    at = dict(zip(COORDINATE_NAMES, values.tolist(), strict=True))
    per_force = 2 / (base.wheel_radius * base.effective_mass)
    # The speed without load keeps its share of the highest speed of a wheel
    emf = base.back_emf * base.wheel_speed_limit / at["wheel_max"]
    constant = base.wheel_load / (at["motor_time"] * emf)
    others = base.effective_inertia - base.body_inertia  # the wheels and the offset of the body
    return {
        "back_emf": emf,
        "wheel_speed_max": at["wheel_max"] / base.wheel_radius,
        "torque_constant": constant,
        "kp": base.wheel_load / (constant * at["rise_time"]),
        "ki": emf / (at["lag"] + _sampling_delay(base)),
        "body_inertia": max(at["gyration"] ** 2 * base.effective_mass - others, 1e-3 * base.body_inertia),
        "friction_torque": at["friction"] / per_force,
        "torque_limit": at["force_limit"] / per_force,
        "dead_band": at["dead_band"],
        "v_max": at["v_max"],
        "w_max": at["w_max"],
        "v_rate_max": at["v_rate_max"],
        "w_rate_max": at["w_rate_max"],
    }


def _sampling_delay(base: Robot) -> float:
    """What :func:`wheel_lag` takes off for the sampling and the filter of the wheel loops [s]."""
    lag = wheel_lag(base)
    return base.back_emf / base.ki - lag if base.ki and lag else MODEL_STEP


def least_gyration(base: Robot) -> float:
    """The least radius of gyration [m] that a robot with the mass and the wheels of ``base`` can have."""
    return sqrt((base.effective_inertia - 0.999 * base.body_inertia) / base.effective_mass)


def _parameters(base: Robot, lanes: np.ndarray, counts: float) -> np.ndarray:
    """The plant's parameters (ParameterColumns, lanes) by values (coordinates, lanes), with so many counts a turn.

    The fields of :func:`fields_of` are written at once, for a robot that is made costs as much as its drive.
    """
    table = np.repeat(plant.parameters(base)[:, None], lanes.shape[1], axis=1)
    columns = ParameterColumns(table)
    fields = {name: np.empty(lanes.shape[1]) for name in fields_of(base, lanes[:, 0])}
    for i in range(lanes.shape[1]):
        for name, value in fields_of(base, lanes[:, i]).items():
            fields[name][i] = value
    columns.ke, columns.kt, columns.kp, columns.ki = (
        fields[name] for name in ("back_emf", "torque_constant", "kp", "ki")
    )
    columns.friction, columns.torque_limit = fields["friction_torque"], fields["torque_limit"]
    columns.inertia = base.effective_inertia - base.body_inertia + fields["body_inertia"]
    columns.v_max, columns.w_max = fields["v_max"], fields["w_max"]
    columns.v_rate, columns.w_rate = fields["v_rate_max"], fields["w_rate_max"]
    columns.wheel_max = fields["wheel_speed_max"]
    columns.dead_band = fields["dead_band"]
    columns.imperfect = np.maximum(columns.imperfect, fields["dead_band"] > 0)
    columns.count = counts / (2 * pi)
    return table


# Drives of the model ----------------------------------------------------------------------------------------------


@dataclass(frozen=True, eq=False)
class Stimulus:
    """Commands over time, each from its time on, and the grid of the plant's steps on which the model follows them."""

    start: float  # s
    steps: int
    knots: np.ndarray  # (n,) s
    sums: np.ndarray  # (2, n): the integral of v [m] and of ω [rad] up to each

    @classmethod
    def of(cls, time: np.ndarray, v: np.ndarray, w: np.ndarray, start: float, end: float) -> "Stimulus":
        """Commands ``v`` [m/s] and ``w`` [rad/s] (n,) from their ``time`` [s] on; before the first nothing."""
        knots = np.concatenate([[min(start, time[0]) - 2.0], time, [max(end, time[-1]) + 2.0]])
        ways = np.stack([np.concatenate([[0.0], each]) for each in (v, w)]) * np.diff(knots)
        sums = np.concatenate([np.zeros((2, 1)), np.cumsum(ways, axis=1)], axis=1)
        aligned = time[0] - MODEL_STEP * np.ceil(
            (time[0] - start) / MODEL_STEP
        )  # commands of a regular log begin with a step
        return cls(float(aligned), int(np.ceil((end - aligned) / MODEL_STEP)) + 1, knots, sums)

    def held(self) -> np.ndarray:
        """The mean command of each step (2, steps)."""
        edges = self.start + MODEL_STEP * np.arange(self.steps + 1)
        return np.stack([np.diff(np.interp(edges, self.knots, row)) for row in self.sums]) / MODEL_STEP


class ModelDrives(NamedTuple):
    """What the model did without latency, at the ends of the plant's steps and at the start (steps + 1, lanes).

    Whatever the latency, a robot does the same so much later: :func:`sampled` looks so much earlier. Unlike a plant
    whose steps are delayed, this is smooth in the latency.
    """

    time: np.ndarray  # (steps + 1,) s
    forward: np.ndarray  # m: driven since the start, by the wheels
    turn: np.ndarray  # rad
    v: np.ndarray  # m/s
    w: np.ndarray  # rad/s
    latency: np.ndarray  # (lanes,) s
    gains: np.ndarray  # (2, 2, lanes): what odometry makes of the wheels' v and ω


def drive(base: Robot, lanes: np.ndarray, stimulus: Stimulus, counts: float = FINE_COUNTS) -> ModelDrives:
    """Let the model follow commands from rest.

    Args:
        base: The robot by its data sheet.
        lanes: Values (coordinates, lanes).
        stimulus: The commands.
        counts: What its encoders count in a turn of the wheel; by default so many that it does not matter.
    """
    blocks = [lanes[:, k : k + _LANES] for k in range(0, lanes.shape[1], _LANES)]
    held = stimulus.held()
    parts = share_out(lambda block: _drive(base, block, held, counts), blocks)
    columns = [np.concatenate(each, axis=1) for each in zip(*parts, strict=True)]
    right, left, v, w = columns
    time = stimulus.start + MODEL_STEP * np.arange(stimulus.steps + 1)
    forward, turn = (right + left) * base.wheel_radius / 2, (right - left) * base.wheel_radius / (2 * base.half_axle)
    at, half = dict(zip(COORDINATE_NAMES, lanes, strict=True)), base.half_axle
    mean, apart = (at["right_gain"] + at["left_gain"]) / 2, (at["right_gain"] - at["left_gain"]) / 2
    gains = np.array([[mean, half * apart], [at["turn_gain"] * apart / half, at["turn_gain"] * mean]])
    return ModelDrives(time, forward, turn, v, w, at["latency"], gains)


def _drive(base: Robot, lanes: np.ndarray, held: np.ndarray, counts: float) -> tuple[np.ndarray, ...]:
    count = lanes.shape[1]
    commands = np.repeat(held.T[:, :, None], count, axis=2)
    out = np.zeros((4, len(commands) + 1, count))
    state = plant.initial_state(np.zeros((count, 3)))
    _follow(state, _parameters(base, lanes, counts), commands, np.empty(plant.SCRATCH), out)
    return tuple(out)


@without_refcounts
def _follow(state, parameters, commands, z, out):  # type: ignore[no-untyped-def]
    """Drive all lanes by ``commands`` (steps, 2, lanes); write angles of the wheels, v and ω into ``out``."""
    lanes = state.shape[1]
    for k in range(len(commands)):
        plant.tick_lanes(
            0, lanes, state, state, parameters, commands[k], commands[k], 0, 1, plant.STEP, MODEL_SUBSTEPS, 0, z
        )
        for i in range(lanes):
            lane = TruthColumns(state, i)
            out[0, k + 1, i], out[1, k + 1, i] = lane.right.angle, lane.left.angle
            out[2, k + 1, i], out[3, k + 1, i] = lane.v, lane.w


def sampled(drives: ModelDrives, time: np.ndarray, window: np.ndarray | Sequence[float]) -> np.ndarray:
    """v [m/s] and ω [rad/s] of the model as odometry tells them at ``time`` (2, samples, lanes).

    ``window`` (samples,) [s] is the time over which each sample is a mean; 0: it is of the moment.
    """
    when = time[:, None] - drives.latency
    moment = np.einsum(
        "ijl,jnl->inl", drives.gains, np.stack([_at(drives, each, when) for each in (drives.v, drives.w)])
    )
    span = np.asarray(window, dtype=float)[:, None]
    if not span.any():
        return moment
    ways = ((drives.forward, drives.v), (drives.turn, drives.w))
    means = np.stack([_way_at(drives, *each, when) - _way_at(drives, *each, when - span) for each in ways])
    means = np.einsum("ijl,jnl->inl", drives.gains, means)
    return np.where(span > 0, means / np.where(span > 0, span, 1.0), moment)


def _between(drives: ModelDrives, when: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """The step before each of the times (samples, lanes), the lane, and the share of the step that went by since."""
    place = np.clip((when - drives.time[0]) / MODEL_STEP, 0.0, len(drives.time) - 1.000001)
    before = place.astype(int)
    return before, np.broadcast_to(np.arange(when.shape[1]), when.shape), place - before


def _at(drives: ModelDrives, rows: np.ndarray, when: np.ndarray) -> np.ndarray:
    """``rows`` (steps + 1, lanes) at other times (samples, lanes), between steps on a line."""
    before, lane, share = _between(drives, when)
    return rows[before, lane] * (1 - share) + rows[before + 1, lane] * share


def _way_at(drives: ModelDrives, way: np.ndarray, speed: np.ndarray, when: np.ndarray) -> np.ndarray:
    """The same of a way and its speed, between steps on Hermite's cubic."""
    before, lane, u = _between(drives, when)
    first, last = way[before, lane], way[before + 1, lane]
    begin, end = MODEL_STEP * speed[before, lane], MODEL_STEP * speed[before + 1, lane]
    return first + u * (begin + u * (3 * (last - first) - 2 * begin - end + u * (2 * (first - last) + begin + end)))
