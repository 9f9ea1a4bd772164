"""Bags as other people's robots write them: by rosbags directly, with topics, rates and clocks of their own."""

from collections.abc import Iterable
from pathlib import Path
from typing import Any

import numpy as np
from rosbags.rosbag2 import StoragePlugin, Writer
from rosbags.typesys import Stores, get_typestore

from robotics.simulation.run import Run

STORE = get_typestore(Stores.ROS2_HUMBLE)
EPOCH = 1_700_000_000.0  # s: when such robots drive


def make(name: str, **fields: Any) -> Any:
    package, _, kind = name.partition("/")
    return STORE.types[f"{package}/msg/{kind}"](**fields)


def header(time: float, frame: str = "odom") -> Any:
    sec, nanosec = divmod(round(time * 1e9), 10**9)
    return make("std_msgs/Header", stamp=make("builtin_interfaces/Time", sec=sec, nanosec=nanosec), frame_id=frame)


def pose(x: float, y: float, heading: float) -> Any:
    turn = make("geometry_msgs/Quaternion", x=0.0, y=0.0, z=np.sin(heading / 2), w=np.cos(heading / 2))
    return make("geometry_msgs/Pose", position=make("geometry_msgs/Point", x=x, y=y, z=0.0), orientation=turn)


def twist(v: float, w: float) -> Any:
    def vector(x: float, z: float) -> Any:
        return make("geometry_msgs/Vector3", x=float(x), y=0.0, z=float(z))

    return make("geometry_msgs/Twist", linear=vector(v, 0.0), angular=vector(0.0, w))


def twist_stamped(time: float, v: float, w: float) -> Any:
    return make("geometry_msgs/TwistStamped", header=header(time, "base_link"), twist=twist(v, w))


def odometry(time: float, posture: Iterable[float], v: float, w: float, frame: str = "odom") -> Any:
    none = np.zeros(36)
    at = make("geometry_msgs/PoseWithCovariance", pose=pose(*map(float, posture)), covariance=none)
    moving = make("geometry_msgs/TwistWithCovariance", twist=twist(v, w), covariance=none)
    return make("nav_msgs/Odometry", header=header(time, frame), child_frame_id="base_link", pose=at, twist=moving)


def path(time: float, points: np.ndarray, frame: str = "odom", times: np.ndarray | None = None) -> Any:
    stamps = np.zeros(len(points)) if times is None else times
    poses = [
        make("geometry_msgs/PoseStamped", header=header(float(t), frame), pose=pose(float(x), float(y), 0.0))
        for t, (x, y) in zip(stamps, points, strict=True)
    ]
    return make("nav_msgs/Path", header=header(time, frame), poses=poses)


def transform(time: float, frame: str, child: str, x: float, y: float, heading: float) -> Any:
    at = pose(x, y, heading)
    shift = make("geometry_msgs/Vector3", x=x, y=y, z=0.0)
    turned = make("geometry_msgs/Transform", translation=shift, rotation=at.orientation)
    one = make("geometry_msgs/TransformStamped", header=header(time, frame), child_frame_id=child, transform=turned)
    return make("tf2_msgs/TFMessage", transforms=[one])


def write(folder: Path, rows: Iterable[tuple[float, str, Any]], storage: str = "sqlite3") -> Path:
    """Write messages: when each was written [s], its topic, and itself."""
    with Writer(folder, version=8, storage_plugin=StoragePlugin[storage.upper()]) as writer:
        known: dict[str, Any] = {}
        for time, topic, message in sorted(rows, key=lambda row: row[0]):
            kind = message.__msgtype__
            if topic not in known:
                known[topic] = writer.add_connection(topic, kind, typestore=STORE)
            writer.write(known[topic], round(time * 1e9), STORE.serialize_cdr(message, kind))
    return folder


def as_a_robot_writes_it(run: Run, folder: Path, seed: int, noise: tuple[float, float] = (0.0, 0.0)) -> Path:
    """The first robot's drive with odometry at 30 Hz and commands without headers at 20 Hz, both with jitter.

    The odometry is the truth between the samples, with noise [m, rad], in the frame and the clock of a robot; nothing
    else is said, neither of a reference nor of a path.
    """
    rng = np.random.default_rng(seed)
    end = float(run.time[-1])
    true = [
        np.interp(times := np.arange(0.0, end, 1 / 30), run.time, run[n][0, 0]) for n in ("x", "y", "heading", "v", "w")
    ]
    rows: list[tuple[float, str, Any]] = []
    for k, time in enumerate(times.tolist()):
        off = rng.normal(size=3) * (noise[0], noise[0], noise[1])
        stamp = EPOCH + time
        message = odometry(stamp, np.array([column[k] for column in true[:3]]) + off, true[3][k], true[4][k])
        rows.append((stamp + 0.002 + 0.004 * rng.random(), "/odom", message))
    for k, time in enumerate(run.time.tolist()):
        given = run["command_1"][0, 0, k], run["command_2"][0, 0, k]
        rows.append((EPOCH + time + 0.001 + 0.006 * rng.random(), "/cmd_vel", twist(*given)))
    return write(folder, rows)
