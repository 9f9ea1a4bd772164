"""What a learnt policy observes: a row of numbers of one robot, the same in a law and in an environment.

The entries are those of :func:`entries`, each within its limits, which are made of the robot and of its setting:
:func:`observe` writes them, and whoever trains and whoever drives calls it.
"""

import math
from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from fuzzy.compiled.columns import Columns, column, several, within
from fuzzy.compiled.jit import compiled_only
from robotics.laws.equation import AimColumns, HeardColumns, RobotColumns
from robotics.laws.setting import Setting
from robotics.world.paths.posture import posture_error, wrapped_compiled
from robotics.world.paths.road import at, timed
from robotics.world.vehicle.plant import Level
from robotics.world.vehicle.robot import Robot

_AHEAD = np.array((0.2, 0.5, 1.0))  # s: how far it looks ahead along its reference
_SHARPEST = 20.0  # 1/m: a curvature beyond is told as this
OLDEST = 5.0  # s: a message is told to be no older; also before the first
_FASTER = 2.0  # times the robot's greatest speed: what quantised encoders may tell


class ObservedColumns(Columns):
    """The numbers of an observation."""

    x_error = column("m", "the reference lies so far ahead, in the robot's frame, as measured")
    y_error = column("m", "the reference lies so far to the left, as measured")
    heading_error = column("rad", "the reference's heading minus the measured one")
    v = column("m/s", "speed by the encoders over the last period")
    w = column("rad/s", "turn rate by the encoders over the last period")
    v_reference = column("m/s", "speed of the reference")
    w_reference = column("rad/s", "turn rate of the reference")
    command_1 = column("m/s (N m)", "commanded in the period before")
    command_2 = column("rad/s (N m)", "commanded in the period before")
    ahead = several(2 * len(_AHEAD), "m/s, 1/m", "speed and curvature of the reference, at each time in turn")
    ranges = several(0, "m", "what the range sensors read")


FIXED_ENTRIES = ObservedColumns.size  # entries before those of the range sensors


class LastColumns(Columns):
    """The command of the period before."""

    first = column("m/s (N m)")
    second = column("rad/s (N m)")


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
    highs = {"x_error": far, "y_error": far, "heading_error": math.pi, "v": v, "w": w}
    highs |= {"v_reference": v, "w_reference": w}
    columns = ObservedColumns.columns
    found = [Entry(name, columns[name].unit, high, columns[name].meaning) for name, high in highs.items()]
    found += [
        Entry("command_1", units[0], first, f"the {what[0]} commanded in the period before"),
        Entry("command_2", units[1], second, f"the {what[1]} commanded in the period before"),
    ]
    for time in _AHEAD:
        found.append(Entry(f"v_in_{time:g}_s", "m/s", v, f"speed of the reference {time:g} s from now"))
        found.append(
            Entry(f"curvature_in_{time:g}_s", "1/m", _SHARPEST, f"curvature of its path there, {time:g} s from now")
        )
    for name in sensors:
        sensor = setting.sensors[robot][name]
        found.append(
            Entry(f"range_{name}", "m", float(sensor.range), f"what the range sensor {name!r} reads", positive=True)
        )
    return tuple(found)


@compiled_only
def observe(  # type: ignore[no-untyped-def]
    robot: RobotColumns, aim: AimColumns, last: LastColumns, time, ranges, lane, road, path, high, out
):
    """Write what a robot observes at ``time`` [s] into ``out`` (entries,).

    Args:
        robot, aim: What the robot knows of itself, and its reference, as of :mod:`robotics.laws.equation`.
        last: The command of the period before, as LastColumns.
        time: Since the run's start [s].
        ranges: What the range sensors read that are observed (sensors, lanes) [m].
        lane: The robot's among them.
        road, path: The references, and the path of the lane.
        high: The limits of the entries (entries,).
        out: What is written.
    """
    observed = ObservedColumns(out)
    dx, dy = aim.x - robot.x, aim.y - robot.y
    cos, sin = math.cos(robot.heading), math.sin(robot.heading)
    observed.x_error, observed.y_error = cos * dx + sin * dy, cos * dy - sin * dx  # (5.9)
    observed.heading_error = wrapped_compiled(aim.heading - robot.heading)
    observed.v, observed.w = robot.v, robot.w
    observed.v_reference, observed.w_reference = aim.v, aim.w
    observed.command_1, observed.command_2 = last.first, last.second
    for n in range(len(_AHEAD)):
        s, v = timed(road, path, time + _AHEAD[n])
        observed.ahead[2 * n], observed.ahead[2 * n + 1] = v, at(road, path, s)[3]
    for n in range(FIXED_ENTRIES):
        out[n] = min(max(out[n], -high[n]), high[n])
    for n in range(len(ranges)):
        observed.ranges[n] = min(ranges[n, lane], high[FIXED_ENTRIES + n])


def highs_of(found: Sequence[Entry]) -> np.ndarray[Any, Any]:
    """The limits of entries (entries,)."""
    return np.array([entry.high for entry in found])


# What the agents of a team observe of each other ---------------------------------------------------------------------


class TeamHeard(HeardColumns):
    """What one robot has heard of another."""

    said = within(RobotColumns)


def team_entries(setting: Setting, level: Level, robot: int, sees: bool) -> tuple[Entry, ...]:
    """The entries of what one robot of a team observes: those of a robot alone, then five of each other robot.

    Args:
        setting: The team's.
        level: What is commanded.
        robot: Its place.
        sees: Whether it reads its range sensors.
    """
    found = list(entries(setting, level, tuple(setting.sensors[robot]) if sees else (), robot))
    on = setting.references
    ends = [on.at(float(t)) for t in np.linspace(0.0, setting.ticks * setting.period, 50)]
    far = 2 * setting.divergence + max(float(np.hypot(np.ptp(at.x), np.ptp(at.y))) for at in ends)
    fastest = max(one.v_max for one in setting.robots)
    for n in range(len(setting.robots)):
        if n != robot:
            who = f"robot{n + 1}"
            found += [
                Entry(f"{who}_ahead", "m", far, f"{who} was so far ahead when it sent the last message that was heard"),
                Entry(f"{who}_left", "m", far, f"{who} was then so far to the left"),
                Entry(f"{who}_heading", "rad", math.pi, f"{who} was then turned so far to the left of this robot"),
                Entry(f"{who}_v", "m/s", 2 * fastest, f"{who} then had this speed"),
                Entry(f"{who}_age", "s", OLDEST, "so long ago; this much and more: nothing was heard", positive=True),
            ]
    return tuple(found)


def heard_of(robot: int, seen: np.ndarray, heard: np.ndarray) -> np.ndarray:
    """What one robot has heard of the others (5 a robot,), in its own frame; 0 before the first message.

    Args:
        robot: Its place.
        seen: What the robots measure (SeenColumns, robots).
        heard: What they have heard (HeardColumns and values, receivers, senders).
    """
    others = np.arange(heard.shape[2]) != robot
    theirs, own = TeamHeard(heard[:, robot][:, others]), RobotColumns(seen, robot)
    where = posture_error(own.x, own.y, own.heading, theirs.said)
    rows = np.stack([*where, theirs.said.v, np.minimum(theirs.age, OLDEST)])
    return np.nan_to_num(rows).T.ravel()
