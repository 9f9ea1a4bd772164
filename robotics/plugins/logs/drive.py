"""A drive read from a log: where a robot was, what it was commanded, and what it was to follow.

Times are those of the headers, where messages have headers with a time in them; else when they were written. Where the
two clocks differ by more than half a second (a simulator's time beside the computer's), what has no header is brought
to the clock of the odometry's headers by the median of the difference.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from fuzzy.naming import expected
from robotics.plugins.logs.bag import Bag, Topic, TopicColumn, opened
from robotics.plugins.logs.typestore import DEFAULT_DISTRIBUTION, LogError

ODOMETRY, PATH, _TRANSFORMS = "nav_msgs/Odometry", "nav_msgs/Path", "tf2_msgs/TFMessage"
TWISTS = ("geometry_msgs/TwistStamped", "geometry_msgs/Twist")
CLOCKS_APART = 0.5  # s: a header's time farther from when the message was written is another clock's
_OWN_ODOMETRY = ("ground_truth", "reference")  # topics of our own logs that are no odometry


class Track(NamedTuple):
    """Postures and velocities over time, in the order of time and each time once."""

    time: np.ndarray  # (n,) s
    x: np.ndarray  # (n,) m
    y: np.ndarray  # (n,) m
    heading: np.ndarray  # (n,) rad, not wrapped
    v: np.ndarray  # (n,) m/s; not-a-number: not told
    w: np.ndarray  # (n,) rad/s


class Commands(NamedTuple):
    """Commanded velocities, each from its time on."""

    time: np.ndarray  # (n,) s
    v: np.ndarray  # (n,) m/s
    w: np.ndarray  # (n,) rad/s


class PlannedPath(NamedTuple):
    """A path to follow, from a time on."""

    time: float  # s
    points: np.ndarray  # (n, 2) m


@dataclass(frozen=True, eq=False)
class Drive:
    """One robot's drive, as a log tells it.

    Attributes:
        log: The log's name, without its folder.
        robot: The robot's namespace, without the slash; empty: it has none.
        odometry: Where it was, and when.
        commands: What it was told, and when.
        reference: Where it was to be, and when.
        plans: The paths that it was to follow.
        topics: The topics that were read, by what they are: "odometry", "commands", ...
        clocks: Of each of them, "headers" or "arrival".
    """

    log: str
    robot: str
    odometry: Track
    commands: Commands
    reference: Track | None
    plans: tuple[PlannedPath, ...]
    topics: dict[str, str]
    clocks: dict[str, str]


def read_drive(
    log: str | Path,
    robot: str = "",
    *,
    odometry: str = "",
    commands: str = "",
    reference: str = "",
    path: str = "",
    distribution: str = DEFAULT_DISTRIBUTION,
) -> Drive:
    """Read one robot's drive from a rosbag2 folder, or from an .mcap, .db3 or .bag file.

    Args:
        log: The folder or file.
        robot: Its namespace, such as robot2; by default the only one that there is.
        odometry: The topic of its odometry; by default odom, or the only one of nav_msgs/Odometry.
        commands: The topic of its commands; by default cmd_vel, or the only one of Twist or TwistStamped.
        reference: The topic of the moving target, of nav_msgs/Odometry; by default reference, if there is one.
        path: The topic of its path, of nav_msgs/Path; by default path or plan, or the only one, if there is one.
        distribution: The ROS 2 distribution whose types are meant where the log defines none.

    Returns:
        The drive.

    Raises:
        LogError: No log, or a topic that is needed is missing; the message names those that there are.
    """
    with opened(log, distribution) as bag:
        space = _namespace(bag, robot.strip("/"))
        topic = partial(_topic, bag, space)
        odom = topic(odometry, "odometry", (ODOMETRY,), ("odom",), without=_OWN_ODOMETRY)
        command = topic(commands, "commanded velocity", TWISTS, ("cmd_vel",))
        assert odom is not None
        assert command is not None
        seen, frame, shift, clock = _track(bag, odom)
        if not len(seen.time):
            raise LogError(f"{bag.path}: {odom.name} has no messages")
        given, command_clock = _commands(bag, command, shift)
        if not len(given.time):
            raise LogError(f"{bag.path}: {command.name} has no messages")
        topics, clocks = {"odometry": odom.name, "commands": command.name}, {"odometry": clock}
        clocks["commands"] = command_clock
        target: Track | None = None
        plans: tuple[PlannedPath, ...] = ()
        aim = topic(reference, "reference", (ODOMETRY,), ("reference",), needed=False, only=False)
        way = topic(path, "path", (PATH,), ("path", "plan"), needed=False)
        if aim is not None and aim.messages:
            target, aim_frame, _, clocks["reference"] = _track(bag, aim)
            topics["reference"] = aim.name
            if aim_frame.strip("/") != frame.strip("/"):
                apart = f"{aim.name} is in the frame {aim_frame!r}, and {odom.name} in {frame!r}"
                raise LogError(f"{bag.path}: {apart}: they cannot be compared")
        if way is not None and way.messages:
            timed, plans, clocks["path"] = _plans(bag, way, frame, shift)
            target, topics["path"] = target or timed, way.name
    return Drive(Path(log).name, space, seen, given, target, plans, topics, clocks)


# Which topic is which ---------------------------------------------------------------------------------------------


def _namespace(bag: Bag, robot: str) -> str:
    """The namespace that is meant of those in which there is odometry; "" is none. Raises LogError."""
    found = sorted({t.name.rpartition("/")[0].strip("/") for t in bag.topics if t.kind == ODOMETRY})
    if robot:
        if not any(topic.name.startswith(f"/{robot}/") for topic in bag.topics):
            known = [name for name in found if name] or ["none: leave it out"]
            raise LogError(f"{bag.path}: " + expected(robot, known, "robot"))
        return robot
    if "" in found or not found:
        return ""
    if len(found) > 1:
        raise LogError(f"{bag.path}: several robots drive there; choose one with --robot: {', '.join(found)}")
    return found[0]


def _topic(
    bag: Bag,
    space: str,
    named: str,
    what: str,
    kinds: Sequence[str],
    usual: Sequence[str],
    *,
    needed: bool = True,
    only: bool = True,
    without: Sequence[str] = (),
) -> Topic | None:
    """The topic that is meant; None where there is none and none is needed. Raises LogError.

    Args:
        bag: The log.
        space: The namespace of the robot.
        named: As the user names it; "": not at all.
        what: What it is, for messages.
        kinds: The types that it may have.
        usual: The names that it has by custom.
        needed: Whether there must be one.
        only: Whether the only one of its kind is taken whatever its name.
        without: Names that are something else.
    """
    begin = f"/{space}/" if space else "/"
    if named:
        wanted = [t for t in bag.topics if t.name in (named, f"/{named}", f"{begin}{named}")]
        if not wanted:
            raise LogError(f"{bag.path}: there is no topic {named}; {bag.said()}")
        fit = [t for t in wanted if t.kind in kinds]
        if not fit:
            raise LogError(
                f"{bag.path}: {named} is of {wanted[0].kind}, and {what} must be of {' or '.join(kinds)}; {bag.said()}"
            )
        return fit[0]
    mine = [t for t in bag.topics if t.kind in kinds and t.name.startswith(begin)]
    mine = [t for t in mine if t.name.removeprefix(begin) not in without]
    for name in usual:
        called = [t for t in mine if t.name == f"{begin}{name}"]
        if called:
            return max(called, key=lambda topic: topic.messages)
    inside = [t for t in mine if only and (space or "/" not in t.name[1:])] or (mine if only else [])
    if len(inside) == 1:
        return inside[0]
    if not needed:
        return None
    if inside:
        several = ", ".join(t.name for t in inside)
        raise LogError(f"{bag.path}: which topic is the {what}: {several}? Name it")
    raise LogError(f"{bag.path}: there is no {what}, a topic of {' or '.join(kinds)}; {bag.said()}")


# What the messages hold -------------------------------------------------------------------------------------------


def stamp_of(header: Any) -> float:
    """When a message was stamped [s]."""
    return float(header.stamp.sec) + header.stamp.nanosec / 1e9


def heading_of(turn: Any) -> float:
    """The heading [rad] of a rotation."""
    return float(np.arctan2(2 * (turn.w * turn.z + turn.x * turn.y), 1 - 2 * (turn.y**2 + turn.z**2)))


def _odometry(message: Any) -> tuple[Any, ...]:
    pose, twist = message.pose.pose, message.twist.twist
    at = pose.position.x, pose.position.y, heading_of(pose.orientation)
    return stamp_of(message.header), *at, twist.linear.x, twist.angular.z, message.header.frame_id


def _track(bag: Bag, topic: Topic) -> tuple[Track, str, float, str]:
    """A topic of odometry, its frame, by how much its clock is ahead of the log's [s], and whose clock that is."""
    read = bag.read(topic, _odometry)
    table = np.array([row[:6] for row in read.rows], dtype=float).reshape(-1, 6)
    time, shift, clock = _times(read, table[:, 0])
    kept = _in_order(time, np.isfinite(table[:, 1:4]).all(axis=1))
    values = table[kept, 1:].T
    track = Track(time[kept], values[0], values[1], np.unwrap(values[2]), values[3], values[4])
    return track, read.rows[0][6] if read.rows else "", shift, clock


def _times(read: TopicColumn, stamps: np.ndarray, shift: float = 0.0) -> tuple[np.ndarray, float, str]:
    """The times of messages, by how much their clock is ahead of the log's [s], and whose clock that is.

    Those of arrival are brought to a clock that is ahead of the log's by ``shift`` [s].
    """
    if not len(stamps) or not ((stamps > 0).any() or np.array_equal(stamps, read.arrival)):
        return read.arrival + shift, 0.0, "arrival"
    apart = float(np.median(stamps - read.arrival))
    return stamps, apart if abs(apart) > CLOCKS_APART else 0.0, "headers"


def _in_order(time: np.ndarray, good: np.ndarray) -> np.ndarray:
    """The places of the ``good`` messages in the order of ``time``; of several at one time the last."""
    places = np.flatnonzero(good & np.isfinite(time))
    places = places[np.argsort(time[places], kind="stable")]
    last = np.append(np.diff(time[places]) > 0, True) if len(places) else np.zeros(0, dtype=bool)
    return places[last]


def _commands(bag: Bag, topic: Topic, shift: float) -> tuple[Commands, str]:
    """The commanded velocities, and whose clock their times are."""
    stamped = topic.kind == TWISTS[0]

    def row(message: Any) -> tuple[float, ...]:
        twist = message.twist if stamped else message
        return stamp_of(message.header) if stamped else 0.0, twist.linear.x, twist.angular.z

    read = bag.read(topic, row)
    table = np.array(read.rows, dtype=float).reshape(-1, 3)
    time, _, clock = _times(read, table[:, 0], shift)
    kept = _in_order(time, np.isfinite(table).all(axis=1))
    return Commands(time[kept], table[kept, 1], table[kept, 2]), clock


def _plans(bag: Bag, topic: Topic, frame: str, shift: float) -> tuple[Track | None, tuple[PlannedPath, ...], str]:
    """The paths of a topic: as a reference in time, where its poses have times that grow; else one after the other."""

    def row(message: Any) -> tuple[float, str, np.ndarray]:
        poses = [
            (stamp_of(p.header), p.pose.position.x, p.pose.position.y, heading_of(p.pose.orientation))
            for p in message.poses
        ]
        return stamp_of(message.header), message.header.frame_id, np.array(poses, dtype=float).reshape(-1, 4)

    read = bag.read(topic, row)
    times, _, clock = _times(read, np.array([stamp for stamp, _, _ in read.rows]), shift)
    paths = [(t, of, poses) for t, (_, of, poses) in zip(times, read.rows, strict=True) if len(poses) > 1]
    if not paths:
        return None, (), "arrival"
    begin, own, poses = paths[0]
    moved = _mover(bag, topic.name, own, frame)
    if len(paths) == 1 and (np.diff(poses[:, 0]) > 0).all() and poses[0, 0] > 0:
        x, y, heading = moved(poses[:, 1:], begin).T
        heading = np.unwrap(heading)
        v = np.hypot(np.gradient(x, poses[:, 0]), np.gradient(y, poses[:, 0]))
        track = Track(poses[:, 0], x, y, heading, v, np.gradient(heading, poses[:, 0]))
        return track, (PlannedPath(begin, np.stack([x, y], axis=-1)),), "headers"
    found: list[PlannedPath] = []
    for begin, _, poses in paths:
        points = moved(poses[:, 1:], begin)[:, :2]
        if not found or not np.array_equal(found[-1].points, points):
            found.append(PlannedPath(begin, points))
    return None, tuple(found), clock


# Frames -----------------------------------------------------------------------------------------------------------


def _mover(bag: Bag, name: str, frame: str, wanted: str) -> Callable[[np.ndarray, float], np.ndarray]:
    """What brings postures (n, 3) of the topic ``name`` from ``frame`` into the frame ``wanted`` at a time [s].

    Where the frames differ, /tf or /tf_static must tell where the one stands in the other. Raises LogError.
    """
    frame, wanted = frame.strip("/"), wanted.strip("/")
    if frame == wanted:
        return lambda postures, _: postures
    rows: list[tuple[float, ...]] = []
    for topic in bag.topics:
        if topic.kind == _TRANSFORMS:
            for arrival, transforms in zip(*bag.read(topic, lambda m: m.transforms), strict=True):
                for one in transforms:
                    pair = one.header.frame_id.strip("/"), one.child_frame_id.strip("/")
                    at, turn = one.transform.translation, heading_of(one.transform.rotation)
                    time = stamp_of(one.header) or arrival
                    if pair == (frame, wanted):
                        rows.append((time, at.x, at.y, turn))
                    elif pair == (wanted, frame):
                        cos, sin = np.cos(turn), np.sin(turn)
                        rows.append((time, -(cos * at.x + sin * at.y), sin * at.x - cos * at.y, -turn))
    if not rows:
        raise LogError(
            f"{bag.path}: {name} is in the frame {frame!r} and the odometry in {wanted!r}, and neither /tf nor "
            "/tf_static says where the one stands in the other"
        )
    table = np.array(sorted(rows))

    def moved(postures: np.ndarray, time: float) -> np.ndarray:
        """Out of the frame in which ``wanted`` stands at x, y, turned."""
        _, x, y, turn = table[max(int(np.searchsorted(table[:, 0], time, side="right")) - 1, 0)]
        dx, dy = postures[:, 0] - x, postures[:, 1] - y
        cos, sin = np.cos(turn), np.sin(turn)
        return np.stack([cos * dx + sin * dy, cos * dy - sin * dx, postures[:, 2] - turn], axis=-1)

    return moved
