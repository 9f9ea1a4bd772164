"""What a log tells of a drive: commands, measured velocities, and where there are any poses and a turn rate.

A log is a rosbag2 folder, an .mcap, .db3 or .bag file, or a CSV file whose header names the columns below with their
units. Columns may come at rates of their own: a row tells what it has numbers for.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from math import pi
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from fuzzy.errors import InputError
from fuzzy.files.header import DataError
from fuzzy.files.table import TableText, open_table
from fuzzy.naming import expected
from fuzzy.words import listed
from robotics.plugins.logs.bag import Bag, opened
from robotics.plugins.logs.drive import Commands, heading_of, read_drive, stamp_of
from robotics.plugins.logs.typestore import DEFAULT_DISTRIBUTION
from robotics.world.vehicle.robot import Robot

_FASTEST_HEADING = 20.0  # rad/s
LOG_GAP = 0.5  # s: what is missing for longer is not filled in


class IdentifyError(InputError):
    """A log that tells nothing of a robot. The message says what is wrong with it, and what to do."""


class MeasuredVelocities(NamedTuple):
    """Measured velocities over time."""

    time: np.ndarray  # (n,) s
    v: np.ndarray  # (n,) m/s
    w: np.ndarray  # (n,) rad/s


class Poses(NamedTuple):
    """Measured poses over time."""

    time: np.ndarray  # (n,) s
    x: np.ndarray  # (n,) m
    y: np.ndarray  # (n,) m
    heading: np.ndarray  # (n,) rad, not wrapped


class YawRates(NamedTuple):
    """What a gyroscope told."""

    time: np.ndarray  # (n,) s
    w: np.ndarray  # (n,) rad/s


@dataclass(frozen=True, eq=False)
class Signals:
    """All that is known of a drive; times count from the first sample."""

    log: str
    commands: Commands
    velocities: MeasuredVelocities
    poses: Poses | None = None
    yaw: YawRates | None = None
    sources: Mapping[str, str] = field(default_factory=dict)  # the topic or the columns of each
    remarks: tuple[str, ...] = ()  # what was left out while reading, in sentences


# Columns of a CSV file, with the units that they may have and what makes them SI
_LENGTHS = {"m": 1.0, "cm": 0.01, "mm": 0.001, "km": 1000.0}
_ANGLES = {"rad": 1.0, "deg": pi / 180, "°": pi / 180, "turn": 2 * pi}
_TIMES = {"s": 1.0, "ms": 1e-3, "us": 1e-6, "µs": 1e-6, "ns": 1e-9, "min": 60.0}
_SPEEDS = {f"{length}/{per}": a / b for length, a in _LENGTHS.items() for per, b in (("s", 1.0), ("h", 3600.0))}
_RATES = {f"{angle}/s": a for angle, a in _ANGLES.items()} | {"rpm": 2 * pi / 60}
LOG_COLUMNS: Mapping[str, tuple[Mapping[str, float], tuple[str, ...], str]] = {
    "time": (_TIMES, ("t", "stamp", "timestamp", "__time"), "since any moment"),
    "v_command": (
        _SPEEDS,
        ("v_cmd", "cmd_v", "v_commanded", "cmd_vel.linear.x", "cmd_vel.twist.linear.x"),
        "commanded speed",
    ),
    "w_command": (
        _RATES,
        ("w_cmd", "cmd_w", "w_commanded", "cmd_vel.angular.z", "cmd_vel.twist.angular.z"),
        "commanded turn rate",
    ),
    "right_command": (_RATES, ("wheel_right_command",), "commanded speed of the right wheel"),
    "left_command": (_RATES, ("wheel_left_command",), "commanded speed of the left wheel"),
    "v": (_SPEEDS, ("v_measured", "odom_v", "odom.linear.x", "odom.twist.twist.linear.x"), "speed by odometry"),
    "w": (_RATES, ("w_measured", "odom_w", "odom.angular.z", "odom.twist.twist.angular.z"), "turn rate by odometry"),
    "right": (_RATES, ("wheel_right",), "measured speed of the right wheel"),
    "left": (_RATES, ("wheel_left",), "measured speed of the left wheel"),
    "x": (_LENGTHS, ("x_measured", "odom.pose.pose.position.x"), "position by something else than the wheels"),
    "y": (_LENGTHS, ("y_measured", "odom.pose.pose.position.y"), "likewise"),
    "heading": (_ANGLES, ("heading_measured", "yaw", "odom.pose.pose.orientation.yaw"), "heading likewise"),
    "yaw_rate": (_RATES, ("imu_w", "gyro_z", "imu.angular_velocity.z"), "turn rate by a gyroscope"),
}
_GROUPS = {
    "commands": (("v_command", "w_command"), ("right_command", "left_command")),
    "velocities": (("v", "w"), ("right", "left")),
    "poses": (("x", "y", "heading"),),
    "yaw": (("yaw_rate",),),
}


def read_signals(
    log: str | Path,
    base: Robot,
    robot: str = "",
    *,
    odometry: str = "",
    commands: str = "",
    pose: str = "",
    imu: str = "",
    distribution: str = DEFAULT_DISTRIBUTION,
) -> Signals:
    """Read one robot's drive.

    Args:
        log: A rosbag2 folder, an .mcap, .db3, .bag or .csv file.
        base: The robot by its data sheet: wheel speeds become velocities by its wheels and axle.
        robot: Its namespace in a log of several.
        odometry: The topic of its odometry; by default odom, or the only one.
        commands: The topic of its commands; by default cmd_vel, or the only one.
        pose: A topic of poses that the wheels have no part in; by default those of the odometry, if they are such.
        imu: A topic of sensor_msgs/Imu; by default none.
        distribution: The ROS 2 distribution whose types are meant where the log defines none.

    Raises:
        IdentifyError: Columns or clocks that cannot be.
        LogError: No log, or a topic that is missing.
    """
    path = Path(log)
    if path.is_file() and path.suffix.lower() == ".csv":
        for name, topic in {"--odom": odometry, "--cmd-vel": commands, "--pose": pose, "--imu": imu}.items():
            if topic:
                raise IdentifyError(f"{path}: {name} names a topic, and a CSV file has columns: rename the column")
        return _from_table(open_table(path), path.name, base)
    drive = read_drive(path, robot, odometry=odometry, commands=commands, distribution=distribution)
    remarks: list[str] = []
    with opened(path, distribution) as bag:
        for name in drive.topics.values():
            _check_clock(bag, name, str(path))
        seen = drive.odometry
        poses: Poses | None = Poses(*seen[:4])
        yaw = None
        sources = dict(drive.topics) | {"poses": drive.topics["odometry"]}
        if pose:
            sources["poses"], poses = pose, _poses(bag, pose)
        if imu:
            sources["yaw"], yaw = imu, _yaw(bag, imu)
    told = np.isfinite(seen.v) & np.isfinite(seen.w)
    if not told.any():
        raise IdentifyError(f"{path}: {drive.topics['odometry']} tells poses and no velocities, which are needed")
    if not told.all():
        remarks.append(f"{np.count_nonzero(~told)} of {len(told)} messages of odometry lack a velocity: left out.")
    velocities = MeasuredVelocities(seen.time[told], seen.v[told], seen.w[told])
    return _from_zero(Signals(path.name, drive.commands, velocities, poses, yaw, sources, tuple(remarks)))


def _from_zero(signals: Signals) -> Signals:
    """The same with times from the first sample on."""
    start = float(min(signals.velocities.time[0], signals.commands.time[0]))
    moved = {
        name: part and part._replace(time=part.time - start)
        for name, part in (
            *(("commands", signals.commands), ("velocities", signals.velocities)),
            *(("poses", signals.poses), ("yaw", signals.yaw)),
        )
    }
    return Signals(signals.log, **moved, sources=signals.sources, remarks=signals.remarks)  # type: ignore[arg-type]


# Topics -----------------------------------------------------------------------------------------------------------


def _check_clock(bag: Bag, name: str, log: str) -> None:
    """Raise IdentifyError where the stamps of a topic jump back in the order in which it was written."""
    topic = next(each for each in bag.topics if each.name == name)
    read = bag.read(topic, lambda m: stamp_of(m.header) if hasattr(m, "header") else 0.0)
    stamps = np.array(read.rows)
    _refuse_jump(stamps if (stamps > 0).any() else read.arrival, f"{log}: {name}", "message", np.arange(len(stamps)))


def _refuse_jump(time: np.ndarray, where: str, what: str, places: np.ndarray) -> None:
    back = np.flatnonzero(np.diff(time) < -LOG_GAP)
    if len(back):
        k = int(back[0])
        start = time[0] if abs(time[0]) < 1e6 else time.min()
        raise IdentifyError(
            f"{where}, {what} {places[k + 1] + (what == 'message')}: the clock jumps back from {time[k] - start:.2f} s "
            f"to {time[k + 1] - start:.2f} s: cut the log there, and identify each part"
        )


def _topic_of(bag: Bag, name: str, kinds: Sequence[str]) -> Any:
    found = [each for each in bag.topics if each.name in (name, f"/{name}")]
    if not found or found[0].kind not in kinds:
        what = f"is of {found[0].kind}" if found else "is not there"
        raise IdentifyError(
            f"{bag.path}: the topic {name} {what}; wanted is one of {listed(kinds, 'or')}; {bag.said()}"
        )
    return found[0]


_POSED = {
    "nav_msgs/Odometry": lambda m: m.pose.pose,
    "geometry_msgs/PoseWithCovarianceStamped": lambda m: m.pose.pose,
    "geometry_msgs/PoseStamped": lambda m: m.pose,
}


def _poses(bag: Bag, name: str) -> Poses:
    topic = _topic_of(bag, name, tuple(_POSED))
    take = _POSED[topic.kind]

    def row(message: Any) -> tuple[float, ...]:
        at, turn = take(message).position, take(message).orientation
        return stamp_of(message.header), at.x, at.y, heading_of(turn)

    time, x, y, heading = _ordered(bag.read(topic, row).rows, 4)
    return Poses(time, x, y, np.unwrap(heading))


def _yaw(bag: Bag, name: str) -> YawRates:
    topic = _topic_of(bag, name, ("sensor_msgs/Imu",))
    return YawRates(*_ordered(bag.read(topic, lambda m: (stamp_of(m.header), m.angular_velocity.z)).rows, 2))


def _ordered(rows: Any, width: int) -> np.ndarray:
    """Rows (columns, n) in the order of time, each time once, without those that lack a number."""
    table = np.array(rows, dtype=float).reshape(-1, width)
    table = table[np.isfinite(table).all(axis=1)]
    _, places = np.unique(table[:, 0], return_index=True)
    return table[places].T


# Columns ----------------------------------------------------------------------------------------------------------


def _from_table(table: TableText, log: str, base: Robot) -> Signals:
    found = _columns(table, log)
    read = table.all_columns()
    if "time" not in found:
        there, wanted = (
            listed([column.name for column in table.columns[:12]]),
            listed(("time", *LOG_COLUMNS["time"][1])),
        )
        raise IdentifyError(f"{log}: there is no column {wanted}; it has {there}: rename them to {listed(LOG_COLUMNS)}")
    time = read.values[:, found["time"][0]] * found["time"][1]
    if not np.isfinite(time).any():
        raise IdentifyError(f"{log}: no row has a number in the column time: dates are not read, write seconds")
    told = np.flatnonzero(np.isfinite(time))
    _refuse_jump(time[told], log, "line", read.lines[told])
    groups, remarks, sources, counts = {}, [], {}, {}
    steps = np.diff(time[told])
    back = steps < -2 * np.quantile(np.abs([0.0, *steps]), 0.5)
    if back.any():
        remarks.append(
            f"The clock steps back, by up to {-steps.min():.2f} s: rows are sorted by it, and some are mixed up."
        )
    for group, choices in _GROUPS.items():
        names = next((each for each in choices if all(name in found for name in each)), None)
        if names is None:
            continue
        rows = np.column_stack([time, *(read.values[:, found[n][0]] * found[n][1] for n in names)])
        good = np.asarray(np.isfinite(rows).all(axis=1))
        if not good.any():
            raise IdentifyError(f"{log}: no row has numbers in {listed(names)}")
        if not good.all():
            remarks.append(
                f"{np.count_nonzero(~good)} of {len(good)} rows have no number in {listed(names)}: left out."
            )
        groups[group], sources[group] = _ordered(rows[good], len(names) + 1), listed(names)
        counts[group] = np.count_nonzero(good)
        if names[0] in ("right", "right_command"):
            right, left = groups[group][1:] * base.wheel_radius
            groups[group][1:] = (right + left) / 2, (right - left) / (2 * base.half_axle)
    for group in ("commands", "velocities"):
        if group not in groups:
            wanted = " or ".join(listed(each) for each in _GROUPS[group])
            raise IdentifyError(f"{log}: {group} need the columns {wanted}; it has {listed(found)}")
    for group, (times, *_) in groups.items():
        if 2 * len(times) < counts[group]:
            raise IdentifyError(
                f"{log}: {counts[group]} rows with {sources[group]} have only {len(times)} different times: write the "
                "time with more digits"
            )
    poses = Poses(*groups["poses"]) if "poses" in groups else None
    if poses is not None:
        poses = poses._replace(heading=_unwrapped(poses, log))
    yaw = YawRates(*groups["yaw"]) if "yaw" in groups else None
    commands, velocities = Commands(*groups["commands"]), MeasuredVelocities(*groups["velocities"])
    return _from_zero(Signals(log, commands, velocities, poses, yaw, sources, tuple(remarks)))


def _unwrapped(poses: Poses, log: str) -> np.ndarray:
    """The heading without its jumps of 2π. Raises IdentifyError where it changes as only degrees do."""
    steps = np.abs(np.diff(poses.heading))
    rates = (steps / np.diff(poses.time))[steps < 6.0]
    if len(rates) and np.quantile(rates, 0.9) > _FASTEST_HEADING:
        raise IdentifyError(
            f"{log}: the heading changes by {np.quantile(rates, 0.9):.0f} rad/s: is it in degrees? Then call "
            "the column heading [deg]"
        )
    return np.unwrap(poses.heading)


def _columns(table: TableText, log: str) -> dict[str, tuple[int, float]]:
    """The place of each known column, and what makes its numbers SI. Raises IdentifyError, or DataError."""
    if not table.headed:
        raise DataError(f"{log}: its columns have no names; the first line must name them: {', '.join(LOG_COLUMNS)}")
    known = {name: name for name in LOG_COLUMNS} | {
        other: n for n, (_, others, _) in LOG_COLUMNS.items() for other in others
    }
    found: dict[str, tuple[int, float]] = {}
    for place, column in enumerate(table.columns):
        name = known.get(column.name.strip().casefold().strip("/").replace("/", "."))
        if name is None:
            continue
        if name in found:
            raise IdentifyError(f"{log}: two columns are {name}, the second is {column.name}: leave one out")
        units = LOG_COLUMNS[name][0]
        if column.unit and column.unit not in units:
            raise IdentifyError(f"{log}: the column {column.name}: " + expected(column.unit, units, "unit"))
        found[name] = place, units[column.unit] if column.unit else 1.0
    return found
