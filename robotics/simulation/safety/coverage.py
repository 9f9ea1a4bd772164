"""Where a robot's range sensors do not look, told before a run: what is there, passive safety cannot see."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from fuzzy.shown import shown
from fuzzy.words import listed
from robotics.laws.law import Law
from robotics.laws.setting import Setting
from robotics.simulation.safety import assumptions as assumed
from robotics.simulation.safety.opening import is_guarded
from robotics.simulation.safety.view import back_speed, covered_speed, only_creeps_back, seen
from robotics.world.sensing.sonar import RangeSensor
from robotics.world.vehicle.robot import Robot

_BEARINGS = np.radians(np.arange(-180.0, 180.0))


def blind_directions(robot: Robot, sensors: Mapping[str, RangeSensor]) -> list[tuple[int, int]]:
    """The directions [degrees, to the left of ahead] in which no sensor sees a thing at the turning circle."""
    radius = robot.turning_circle + assumed.least_gap(robot)
    blind = ~seen(list(sensors.values()), radius * np.cos(_BEARINGS), radius * np.sin(_BEARINGS))
    if blind.all():
        return [(-180, 180)]
    start = int(np.argmin(blind))  # a direction that is seen
    turned, found = np.roll(blind, -start), []
    edges = np.flatnonzero(np.diff(np.concatenate([[0], turned.astype(int), [0]])))
    for first, last in edges.reshape(-1, 2):
        low = (first + start) % 360 - 180
        found.append((int(low), int(low + last - first - 1)))
    return found


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
    if (back := back_speed(robot, sensors, setting)) < most - 0.01:
        parts.append(f"among what moves it goes back at {back:.2f} m/s at most")
        if only_creeps_back(robot, sensors, setting):
            parts.append("nor does an end of its rear edge go back faster in a turn")
    if robot.imperfections:
        has = listed([f"{name} {shown(value)}" for name, value in robot.imperfections.items()])
        parts.append(f"it is proven of wheels that roll, and follow every command, and this robot has {has}")
    if setting.patches:
        least = shown(min(patch.friction for patch in setting.patches))
        parts.append(f"it is proven of one floor, and this one has patches, the most slippery of friction {least}")
    if any(sensor.dropout > 0 for sensor in sensors.values()):
        parts.append("an echo that is lost is taken for free ground")
    return "passive safety: " + "; ".join(parts) if parts else ""
