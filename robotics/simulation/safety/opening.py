"""What the monitor begins with: its columns, made of a setting and of the assumptions."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import astuple
from typing import Any

import numpy as np

from robotics.laws.law import ControllerError, Law
from robotics.laws.setting import Setting
from robotics.simulation.safety import assumptions as assumed
from robotics.simulation.safety.ground import GuardColumns
from robotics.simulation.safety.monitor import MonitorLanes
from robotics.simulation.safety.others import PostureMessage, PromiseColumns
from robotics.simulation.safety.view import back_speed, beam_halves, only_creeps_back
from robotics.world.environment.collision import footprints
from robotics.world.environment.world import Geometry, Moving
from robotics.world.radio.channel import Channel
from robotics.world.sensing.carried import CarriedSensors, Looks
from robotics.world.sensing.sonar import RangeSensor
from robotics.world.vehicle.plant import velocity_limits
from robotics.world.vehicle.robot import Robot

_AT_ONCE = 1e300  # m/s²


def is_guarded(setting: Setting, law: Law[Any]) -> bool:
    """Whether the monitor is below ``law``: by its own word, or else by the setting's.

    Raises ControllerError where the law commands torques, of which no stop is known.
    """
    guarded = law.safe == "yes" or (law.safe == "" and setting.safety == "passive")
    if guarded and law.level == "torque":
        raise ControllerError(
            f"{setting.name}: {type(law).__name__} commands torques, and passive safety is for laws that command "
            "velocities"
        ).about("safe")
    return guarded


def told_by(setting: Setting, law: Law[Any]) -> tuple[str, ...]:
    """What the monitors below ``law`` tell each other: the names of the values; none where there is no team of them."""
    team = is_guarded(setting, law) and len(setting.robots) > 1
    return tuple(f"monitor_{name}" for name in PostureMessage.columns) if team else ()


def channel_of(setting: Setting, law: Law[Any], seeds: Sequence[int]) -> Channel:
    """The channel over which monitors tell each other of their robots, for runs with these ``seeds``."""
    return Channel.opened(setting.radio, told_by(setting, law), len(setting.robots), seeds, setting.period)


def given_rows(robot: Robot, setting: Setting, number: int, fresh: float) -> list[float]:
    """The numbers of GuardColumns of one robot, the ``number``-th; its sensors look every ``fresh`` [s] at least."""
    kinematic = setting.plant == "kinematic"
    place, turned = assumed.posture_spread(setting)[number]
    own = setting.sensors[number]
    stop = assumed.stopping(robot, kinematic, only_creeps_back(robot, own, setting))
    return GuardColumns.stacked(
        {
            "half_length": robot.length / 2,
            "half_width": robot.width / 2,
            "radius": robot.turning_circle,
            "cell": assumed.cell_size(robot),
            "least": assumed.least_gap(robot),
            "others": assumed.fastest_other(setting),
            "back": min(back_speed(robot, own, setting), _AT_ONCE),
            "fresh": fresh,
            "place": place,
            "turned": turned,
            "latency": setting.latency,
            "overshoot": 1.0 if kinematic else assumed.OVERSHOOT,
            "limit": velocity_limits([robot])[:, 0].tolist(),
            "stop": [min(value, _AT_ONCE) for value in astuple(stop)],
        }
    )


def rays_of(sensors: Sequence[RangeSensor], reach: float, cell: float) -> tuple[np.ndarray, np.ndarray]:
    """Directions that fill the sensors' cones (2, rays), and where those of each begin (sensors + 1,)."""
    spacing, angles = 0.7 * cell / reach, []
    for sensor, half in zip(sensors, beam_halves(sensors), strict=True):
        count = max(1, math.ceil(2 * half / spacing) + 1) if half > 0 else 1
        angles.append(sensor.axis + (np.linspace(-half, half, count) if count > 1 else np.zeros(1)))
    joined = np.concatenate([np.empty(0), *angles])
    return np.stack([np.cos(joined), np.sin(joined)]), np.cumsum([0, *map(len, angles)])


def no_guard(lanes: int, air: Any) -> MonitorLanes:
    """The monitor's columns where there is none."""
    none = np.zeros(0, dtype=np.int64)
    empty = np.zeros((0, lanes))
    return MonitorLanes(
        0, 0, 0.0, 0.0, 0.0, empty, np.zeros((0, 0, 0), dtype=np.int64), np.zeros((0, 2), dtype=np.int64),
        np.zeros((0, 0), dtype=np.int64), np.empty((0, 0)), none, none, none, none, np.zeros((2, 0)),
        np.zeros(1, dtype=np.int64), np.zeros((0, 2, lanes)), empty, np.zeros((0, 0, lanes)), empty, air, empty, none,
    )  # fmt: skip


def opened_guard(
    setting: Setting, runs: int, looks: Looks, kinds: Sequence[Mapping[str, RangeSensor]], air: Any
) -> MonitorLanes:
    """The monitor's columns at the start of ``runs`` runs.

    Args:
        setting: What is driven.
        runs: Their number.
        looks: The columns of the range sensors.
        kinds: What robots carry, each once, as Looks counts it; in the simulator none where there is nothing to see.
        air: Of the monitors' radio.
    """
    robots, period = setting.robots, setting.period
    lanes = len(robots) * runs
    carried = [max((s.period for s in own.values()), default=period) for own in setting.sensors]
    given = np.array([given_rows(r, setting, i, carried[i]) for i, r in enumerate(robots)]).T
    sees = setting.world is not None or bool(kinds)
    begin, end = np.zeros(lanes, dtype=np.int64), np.zeros(lanes, dtype=np.int64)
    sensors = [sensor for own in kinds for sensor in own.values()]
    firsts = np.cumsum([0, *map(len, kinds)])
    for lane, kind in enumerate(looks.kind[:lanes] if kinds else []):
        if kind >= 0:
            begin[lane], end[lane] = firsts[kind], firsts[kind + 1]
    cell = min((assumed.cell_size(robot) for robot in robots), default=1.0)
    rays, first_ray = rays_of(sensors, assumed.WINDOW_CELLS / 2 * cell, cell)
    stops = max(
        assumed.stopping_time(robot, setting.plant == "kinematic", only_creeps_back(robot, own, setting))
        for robot, own in zip(robots, setting.sensors, strict=True)
    )
    delay = assumed.radio_delay(setting.radio, period)
    holds = delay + setting.latency + period + stops
    keeps = math.ceil(holds / period) + 1 if air.values else 1
    promises = np.zeros((PromiseColumns.size, keeps, lanes))
    promises[0], promises[1], promises[2] = _AT_ONCE, -_AT_ONCE, _AT_ONCE
    side = assumed.WINDOW_CELLS if sees else 0
    return MonitorLanes(
        1,
        int(sees),
        float(setting.latency),
        float(delay),
        float(holds),
        np.ascontiguousarray(np.tile(given, runs)),
        np.zeros((lanes, side, side), dtype=np.int64),
        np.zeros((lanes, 2), dtype=np.int64),
        np.zeros((side, side), dtype=np.int64),
        looks.eyes.table,
        looks.every,
        looks.column,
        begin,
        end,
        rays,
        first_ray,
        np.zeros((math.ceil(setting.latency / period - 1e-9) + 2, 2, lanes)),
        np.zeros((2, lanes)),
        promises,
        np.zeros((PostureMessage.size, lanes)),
        air,
        np.zeros((1, lanes)),
        np.zeros(lanes, dtype=np.int64),
    )


def guard_on_board(setting: Setting, law: Law[Any]) -> MonitorLanes:
    """The monitor's columns where each robot has a computer of its own, which fills in what it hears and reads.

    The robots of ``setting`` are its lanes. They look wherever they have sensors: what is there nobody knows.
    """
    robots = len(setting.robots)
    sensors = CarriedSensors.opened(setting.sensors, robots, (0,), setting.period)
    looks = sensors.looks(Geometry.nothing(), Moving.nothing(), footprints(setting.robots))
    return opened_guard(setting, 1, looks, sensors.kinds, channel_of(setting, law, ()).silence(1, robots))
