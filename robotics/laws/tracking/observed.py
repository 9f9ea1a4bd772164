"""What a learnt policy observes: a row of numbers of one robot, the same in a law and in an environment.

The entries are those of :func:`entries`, each within its limits, which are made of the robot and of its setting:
:func:`observe` writes them, and whoever trains and whoever drives calls it.
"""

import math
from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from fuzzy.compiled.jit import inner
from robotics.laws.equation import AT_HEADING, AT_V, AT_W, AT_X, AT_Y, HEADING, V, W, X, Y
from robotics.laws.setting import Setting
from robotics.paths.posture import wrapped_compiled
from robotics.paths.road import at, timed
from robotics.vehicle.plant import Level
from robotics.vehicle.robot import Robot

AHEAD = (0.2, 0.5, 1.0)  # s: how far it looks ahead along its reference
SHARPEST = 20.0  # 1/m: a curvature beyond is told as this
_FASTER = 2.0  # times the robot's greatest speed: what quantised encoders may tell
_AHEAD = np.array(AHEAD)


class Entry(NamedTuple):
    """An entry of an observation: it lies between ``-high`` and ``high``, or from 0 on where it is ``positive``."""

    name: str
    unit: str
    high: float
    meaning: str
    positive: bool = False


def command_limits(robot: Robot, level: Level) -> tuple[float, float]:
    """The greatest command of a robot: v [m/s] and ω [rad/s], or the torques of both wheels [N m]."""
    return (robot.torque_limit,) * 2 if level == "torque" else (robot.v_max, robot.w_max)


def entries(setting: Setting, level: Level, sensors: Sequence[str] = (), robot: int = 0) -> tuple[Entry, ...]:
    """The entries of an observation in their order.

    Args:
        setting: The robot's setting.
        level: Whether it commands velocities or torques.
        sensors: The names of the range sensors that it observes.
        robot: Its place.
    """
    one, far = setting.robots[robot], float(setting.divergence)
    v, w = _FASTER * one.v_max, _FASTER * one.w_max
    first, second = command_limits(one, level)
    units = ("N m", "N m") if level == "torque" else ("m/s", "rad/s")
    what = ("right wheel's torque", "left wheel's torque") if level == "torque" else ("speed", "turn rate")
    found = [
        Entry("x_error", "m", far, "the reference lies so far ahead, in the robot's frame, as measured"),
        Entry("y_error", "m", far, "the reference lies so far to the left, as measured"),
        Entry("heading_error", "rad", math.pi, "the reference's heading minus the measured one"),
        Entry("v", "m/s", v, "speed by the encoders over the last period"),
        Entry("w", "rad/s", w, "turn rate by the encoders over the last period"),
        Entry("v_reference", "m/s", v, "speed of the reference"),
        Entry("w_reference", "rad/s", w, "turn rate of the reference"),
        Entry("command_1", units[0], first, f"the {what[0]} commanded in the period before"),
        Entry("command_2", units[1], second, f"the {what[1]} commanded in the period before"),
    ]
    for time in AHEAD:
        found.append(Entry(f"v_in_{time:g}_s", "m/s", v, f"speed of the reference {time:g} s from now"))
        found.append(
            Entry(f"curvature_in_{time:g}_s", "1/m", SHARPEST, f"curvature of its path there, {time:g} s from now")
        )
    for name in sensors:
        sensor = setting.sensors[robot][name]
        found.append(
            Entry(f"range_{name}", "m", float(sensor.range), f"what the range sensor {name!r} reads", positive=True)
        )
    return tuple(found)


FIXED = 9 + 2 * len(AHEAD)  # entries before those of the range sensors


@inner
def within_limit(value, high):  # type: ignore[no-untyped-def]
    """A value between -``high`` and ``high``."""
    return min(max(value, -high), high)


@inner
def observe(i, time, seen, ranges, road, path, last, highs, g, out):  # type: ignore[no-untyped-def]
    """Write what robot ``i`` observes at ``time`` [s] into ``out`` (entries,).

    Args:
        i: The lane.
        time: Since the run's start [s].
        seen: As of :class:`robotics.laws.equation.Known` (SEEN, lanes).
        ranges: What the range sensors read that are observed (sensors, lanes) [m].
        road, path: The references, and the path of the lane.
        last: The command of the period before (2, lanes).
        highs: The limits of the entries (entries, columns), of which the lane's is the column ``g``.
        out: What is written.
    """
    dx, dy = seen[AT_X, i] - seen[X, i], seen[AT_Y, i] - seen[Y, i]
    cos, sin = math.cos(seen[HEADING, i]), math.sin(seen[HEADING, i])
    out[0], out[1] = cos * dx + sin * dy, cos * dy - sin * dx  # (5.9)
    out[2] = wrapped_compiled(seen[AT_HEADING, i] - seen[HEADING, i])
    out[3], out[4] = seen[V, i], seen[W, i]
    out[5], out[6] = seen[AT_V, i], seen[AT_W, i]
    out[7], out[8] = last[0, i], last[1, i]
    for n in range(len(_AHEAD)):
        s, v = timed(road, path, time + _AHEAD[n])
        out[9 + 2 * n], out[10 + 2 * n] = v, at(road, path, s)[3]
    for n in range(FIXED):
        out[n] = within_limit(out[n], highs[n, g])
    for n in range(len(ranges)):
        out[FIXED + n] = min(ranges[n, i], highs[FIXED + n, g])


def highs_of(found: Sequence[Entry]) -> np.ndarray[Any, Any]:
    """The limits of entries (entries,)."""
    return np.array([entry.high for entry in found])
