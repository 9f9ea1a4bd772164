"""Where a robot's range sensors do not look, told before a run: what is there, passive safety cannot see."""

import math
from collections.abc import Mapping
from typing import Any

import numpy as np

from fuzzy.shown import shown
from fuzzy.words import listed
from robotics.laws.law import Law
from robotics.laws.setting import Setting
from robotics.simulation.safety import assumptions as assumed
from robotics.simulation.safety.opening import beam_halves, is_guarded
from robotics.world.sensing.sonar import RangeSensor
from robotics.world.vehicle.robot import Robot

_BEARINGS = np.radians(np.arange(-180.0, 180.0))
_ACROSS = 41  # places across the way straight on
_FARTHEST = 400  # steps of 1 cm ahead of the nose


def seen(sensors: Mapping[str, RangeSensor], x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """Whether any sensor looks at points (x, y) [m] in the robot's frame; a beam stands for half way to the next."""
    found = np.zeros(np.broadcast_shapes(x.shape, y.shape), dtype=bool)
    carried = list(sensors.values())
    for sensor, half in zip(carried, beam_halves(carried), strict=True):
        dx, dy = x - sensor.x, y - sensor.y
        off = np.abs(np.remainder(np.arctan2(dy, dx) - sensor.axis + math.pi, 2 * math.pi) - math.pi)
        found |= (off <= half + 1e-9) & (np.hypot(dx, dy) <= sensor.range)
    return found


def blind_directions(robot: Robot, sensors: Mapping[str, RangeSensor]) -> list[tuple[int, int]]:
    """The directions [degrees, to the left of ahead] in which no sensor sees a thing at the turning circle."""
    radius = robot.turning_circle + assumed.least_gap(robot)
    blind = ~seen(sensors, radius * np.cos(_BEARINGS), radius * np.sin(_BEARINGS))
    if blind.all():
        return [(-180, 180)]
    start = int(np.argmin(blind))  # a direction that is seen
    turned, found = np.roll(blind, -start), []
    edges = np.flatnonzero(np.diff(np.concatenate([[0], turned.astype(int), [0]])))
    for first, last in edges.reshape(-1, 2):
        low = (first + start) % 360 - 180
        found.append((int(low), int(low + last - first - 1)))
    return found


def covered_speed(robot: Robot, sensors: Mapping[str, RangeSensor], setting: Setting) -> float:
    """The highest speed [m/s] straight on from which the robot stops on ground all of which is seen before it comes.

    0 where no sensor looks at some of that ground at any distance.
    """
    need = assumed.least_gap(robot)
    across = np.linspace(-1, 1, _ACROSS) * (robot.width / 2 + need)
    ahead = robot.length / 2 + 0.01 * np.arange(1, _FARTHEST)
    whole = seen(sensors, ahead[:, None], across[None, :]).all(axis=1)
    if not whole.any():
        return 0.0
    room = min(float(ahead[whole].max()), assumed.WINDOW_CELLS / 2 * assumed.cell_size(robot)) - robot.length / 2 - need
    model = assumed.stopping(robot, setting.plant == "kinematic")
    old = max(sensor.period for sensor in sensors.values())
    speeds = np.linspace(0.0, min(robot.v_max, robot.wheel_speed_limit), 200)
    ways = [v * (setting.period + setting.latency + old) + model.distance(v) for v in speeds.tolist()]
    return float(speeds[np.searchsorted(ways, room, side="right") - 1])


def blind_spots(setting: Setting, law: Law[Any], *, on_board: bool = False) -> list[str]:
    """A sentence for each sort of robot, on what the monitor below ``law`` cannot see; none where there is none.

    Where there are no obstacles nothing is said, unless it is ``on_board`` of a robot: there nobody knows.
    """
    if not (on_board or setting.world is not None) or not is_guarded(setting, law):
        return []
    found: dict[str, list[int]] = {}
    for i, (robot, sensors) in enumerate(zip(setting.robots, setting.sensors, strict=True), start=1):
        found.setdefault(_told(robot, sensors, setting), []).append(i)
    return [f"robot{'s' * (len(who) > 1)} {', '.join(map(str, who))}: {told}" for told, who in found.items() if told]


def _told(robot: Robot, sensors: Mapping[str, RangeSensor], setting: Setting) -> str:
    if not sensors:
        return "passive safety sees no obstacles: there is no range sensor"
    parts, fast = [], covered_speed(robot, sensors, setting)
    most = min(robot.v_max, robot.wheel_speed_limit)
    if gaps := blind_directions(robot, sensors):
        where = ", ".join(f"{low}° to {high}°" for low, high in gaps)
        parts.append(f"no sensor looks at {where} (to the left of ahead), and what comes from there is not seen")
    if fast < most - 0.01:
        parts.append(f"the way ahead is seen up to {fast:.2f} m/s only")
    elif gaps:
        parts.append(f"the way ahead is seen at all speeds, up to {fast:.2f} m/s")
    if robot.imperfections:
        has = listed([f"{name} {shown(value)}" for name, value in robot.imperfections.items()])
        parts.append(f"it is proven of wheels that roll, and follow every command, and this robot has {has}")
    if setting.patches:
        least = shown(min(patch.friction for patch in setting.patches))
        parts.append(f"it is proven of one floor, and this one has patches, the most slippery of friction {least}")
    if any(sensor.dropout > 0 for sensor in sensors.values()):
        parts.append("an echo that is lost is taken for free ground")
    return "passive safety: " + "; ".join(parts) if parts else ""
