"""What a robot's range sensors see of the ground around it, and up to what speed they see the way ahead, or back."""

import math
from collections.abc import Mapping, Sequence
from functools import cache

import numpy as np

from robotics.laws.setting import Setting
from robotics.simulation.safety import assumptions as assumed
from robotics.world.paths.posture import wrapped
from robotics.world.sensing.sonar import RangeSensor
from robotics.world.vehicle.robot import Robot

_WIDEST_BEAM = 0.06  # rad: half of the widest wedge that a beam stands for
_ACROSS = 41  # places across the way straight on
_FARTHEST = 400  # steps of 1 cm ahead of the nose


def beam_halves(sensors: Sequence[RangeSensor]) -> list[float]:
    """Half the cone [rad] that each sensor stands for: a beam for what is nearer to it than to its neighbours."""
    places: dict[tuple[float, float], list[float]] = {}
    for sensor in sensors:
        places.setdefault((sensor.x, sensor.y), []).append(sensor.axis)
    found = []
    for sensor in sensors:
        beside = np.abs(wrapped(np.array(places[sensor.x, sensor.y]) - sensor.axis))
        half = float(beside[beside > 1e-6].min(initial=0.0 if (beside <= 1e-6).all() else np.inf)) / 2
        found.append(sensor.half_cone or (half if half <= _WIDEST_BEAM else 0.0))
    return found


def seen(sensors: Sequence[RangeSensor], x: np.ndarray, y: np.ndarray, facing: np.ndarray | None = None) -> np.ndarray:
    """Whether any sensor looks at points (x, y) [m] in the robot's frame; a beam stands for half way to the next.

    A surface that is ``facing`` [rad] so gives an echo within the sensor's incidence angle only.
    """
    found = np.zeros(np.broadcast_shapes(x.shape, y.shape), dtype=bool)
    for sensor, half in zip(sensors, beam_halves(sensors), strict=True):
        dx, dy = x - sensor.x, y - sensor.y
        bearing = np.arctan2(dy, dx)
        met = (np.abs(wrapped(bearing - sensor.axis)) <= half + 1e-4) & (np.hypot(dx, dy) <= sensor.range)
        if facing is not None:
            met &= np.abs(wrapped(facing - bearing + math.pi)) <= sensor.incidence
        found |= met
    return found


def covered_speed(
    robot: Robot, sensors: Mapping[str, RangeSensor], setting: Setting, *, backwards: bool = False
) -> float:
    """The highest speed [m/s] straight on from which the robot stops on ground all of which is seen before it comes.

    Or straight ``backwards``. 0 where no sensor looks at some of that ground at any distance.
    """
    old = max((sensor.period for sensor in sensors.values()), default=0.0)
    room = _seen_way(robot, tuple(sensors.values()), backwards)
    gentle = not backwards and only_creeps_back(robot, sensors, setting)
    model = assumed.stopping(robot, setting.plant == "kinematic", gentle)
    speeds = np.linspace(0.0, min(robot.v_max, robot.wheel_speed_limit), 200)
    ways = [v * (setting.period + setting.latency + old) + model.distance(v) for v in speeds.tolist()]
    return float(speeds[np.searchsorted(ways, room, side="right") - 1])


def back_speed(robot: Robot, sensors: Mapping[str, RangeSensor], setting: Setting) -> float:
    """How fast [m/s] the robot may go back: as covered, where things move; it stands if it is slower than AT_REST."""
    if assumed.fastest_other(setting) == 0:
        return math.inf
    return max(covered_speed(robot, sensors, setting, backwards=True), assumed.CREEPS * assumed.AT_REST)


def only_creeps_back(robot: Robot, sensors: Mapping[str, RangeSensor], setting: Setting) -> bool:
    """Whether it may go back only so slowly that it stands: it also brakes gently then, and turns no rear edge back."""
    return back_speed(robot, sensors, setting) <= assumed.AT_REST


@cache
def _seen_way(robot: Robot, sensors: tuple[RangeSensor, ...], backwards: bool) -> float:
    """How far [m] straight on, or back, the robot may go on ground all of which is seen before it comes."""
    need = assumed.least_gap(robot)
    across = np.linspace(-1, 1, _ACROSS) * (robot.width / 2 + need)
    ahead = robot.length / 2 + 0.01 * np.arange(1, _FARTHEST)
    whole = seen(sensors, (-ahead if backwards else ahead)[:, None], across[None, :]).all(axis=1)
    far = min(float(ahead[whole].max(initial=0.0)), assumed.WINDOW_CELLS / 2 * assumed.cell_size(robot))
    return max(far - robot.length / 2 - need, 0.0)
