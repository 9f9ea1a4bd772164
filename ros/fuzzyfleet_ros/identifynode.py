"""The node that records a drive, and identifies the robot from it when the drive is over.

The log is a CSV or an MCAP file as ``robotics identify`` reads it: a row tells what came at its time. Times are those
of the messages' headers; as in the controller, a message whose time is more than ``odom_timeout`` off the clock is
ignored.
"""

import time as clocks
from collections.abc import Callable, Sequence
from functools import partial
from math import inf, isfinite, nan
from pathlib import Path
from typing import Any

import numpy as np
from geometry_msgs.msg import PoseStamped, Twist, TwistStamped
from nav_msgs.msg import Odometry
from rclpy.node import Node
from rclpy.qos import QoSProfile, ReliabilityPolicy
from sensor_msgs.msg import Imu, JointState

from fuzzy.files.atomic import check_target
from fuzzyfleet_ros import messages
from fuzzyfleet_ros.frames import Posture, heading_of
from fuzzyfleet_ros.parameters import Parameter, declared
from fuzzyfleet_ros.standing import CommandWatchdog
from robotics.plugins.identify.replay import COMMANDS, ODOMETRY_POSES, POSES, VELOCITIES, WHEEL_SPEEDS, YAW, write_log
from robotics.plugins.identify.signals import IdentifyError
from robotics.plugins.logs.names import WHEELS as JOINTS
from robotics.simulation.scenario.robots import load_robot

LOG_PARAMETERS = (
    Parameter("robot", "etsro", "The data sheet: a robot's name or .toml file."),
    Parameter("log", "drive.csv", "The log that is written: .csv or .mcap."),
    Parameter("out", "myrobot.toml", "The identified robot's file; empty: the drive is only recorded."),
    Parameter("page", "", "A page .html of fits, numbers and advice; empty: none."),
    Parameter("stamped", True, "Whether velocities are TwistStamped, or Twist."),
    Parameter("odom_timeout", 0.5, "The age of a message [s] at which it is ignored; 0: never.", 0, 60),
    Parameter("odom_topic", "odom", "The topic of nav_msgs/Odometry."),
    Parameter("cmd_vel_topic", "cmd_vel", "The topic of the velocity."),
    Parameter("joint_topic", "joint_states", "The topic of sensor_msgs/JointState of the wheels; it may be silent."),
    Parameter("imu_topic", "imu", "The topic of sensor_msgs/Imu, a gyroscope; it may be silent."),
    Parameter("pose_topic", "", "A topic of PoseStamped by other means than the wheels; empty: odometry's poses."),
)  # fmt: skip
IDENTIFY_PARAMETERS = (
    *LOG_PARAMETERS,
    Parameter("seconds", 60.0, "How long it records from the first command on [s]; 0: until Ctrl-C.", 0, 3600),
)
Columns = dict[str, str]  # the unit of each column of the log, by its name


class Identifier(Node):
    """A recorder of one robot's drive; raises InputError for parameters that do not suit each other."""

    def __init__(
        self, name: str = "identify", parameters: Sequence[Parameter] = IDENTIFY_PARAMETERS, **options: Any
    ) -> None:
        """Open it; ``options`` are those of a node, such as its namespace."""
        super().__init__(name, **options)
        values = self.values = declared(self, parameters)
        for key, endings in {"log": (".csv", ".mcap"), "out": (".toml",), "page": (".html",)}.items():
            check_target(Path(values[key]) if values[key] or key == "log" else None, *endings)
        self.model = load_robot(values["robot"])
        self.lockstep, self.done = values.get("lockstep", False), False
        self.standing = CommandWatchdog(values["odom_timeout"], 0.0, clocks.monotonic)
        self.told: dict[str, dict[int, float]] = {}  # of each column: its numbers by their time [ns]
        self.units: Columns = {}
        self.posture = Posture(0.0, 0.0, 0.0)  # as odometry says
        self.begin: int | None = None  # ns: of the first command
        self.why = ""  # it was stopped
        policy = ReliabilityPolicy.RELIABLE if self.lockstep else ReliabilityPolicy.BEST_EFFORT
        self.sensed = QoSProfile(depth=50, reliability=policy)
        own = ODOMETRY_POSES if values["pose_topic"] else POSES
        self._listen(Odometry, values["odom_topic"], VELOCITIES | own, self._odometry)
        self._listen(JointState, values["joint_topic"], WHEEL_SPEEDS, _of_wheels)
        self._listen(Imu, values["imu_topic"], YAW, lambda message: (message.angular_velocity.z,))
        if values["pose_topic"]:
            self._listen(PoseStamped, values["pose_topic"], POSES, _of_pose)
        self._attend()

    def _attend(self) -> None:
        """Hear the commands of others."""
        kind = TwistStamped if self.values["stamped"] else Twist
        self._listen(kind, self.values["cmd_vel_topic"], COMMANDS, messages.velocity_in)
        heard = self.resolve_topic_name(self.values["cmd_vel_topic"])
        self.get_logger().info(f"it records what is commanded as {kind.__name__} on {heard}")

    def _listen(self, kind: Any, topic: str, columns: Columns, read: Callable[[Any], Sequence[float]]) -> None:
        note = partial(self._on_message, topic, columns, read)
        self.create_subscription(kind, topic, note, self.sensed)

    def _on_message(self, topic: str, columns: Columns, read: Callable[[Any], Sequence[float]], message: Any) -> None:
        """Note what a message tells, unless it is no number or of another time."""
        now = self.get_clock().now().nanoseconds
        stamp = messages.time_of(message.header.stamp) if hasattr(message, "header") else now
        if columns is COMMANDS:
            stamp = stamp or now  # what drives by hand often sets none
        most = self.standing.odom_timeout or inf
        try:
            numbers = read(message)
        except ValueError as error:
            why = str(error)
        else:
            if not numbers:
                return
            bad = "" if all(map(isfinite, numbers)) else "a number of it is not finite"
            # In lockstep the simulator repeats what it asks
            late = "" if self.lockstep else self.standing.refusal(topic, stamp / 1e9, now / 1e9, most)
            why = bad or late
        if why:
            if self.standing.refused(topic):
                self.get_logger().warning(f"a message of {topic} is ignored: {why}")
            return
        self._note(stamp, columns, numbers)

    def _note(self, stamp: int, columns: Columns, numbers: Sequence[float]) -> None:
        self.units |= columns
        for name, number in zip(columns, numbers, strict=True):
            self.told.setdefault(name, {})[stamp] = number
        if columns is COMMANDS and self.begin is None:
            self.begin = stamp
        elif "v" in columns:
            self.standing.odometry_came()
            self._on_odometry(stamp)

    def _on_odometry(self, stamp: int) -> None:
        """End when the time is over."""
        seconds = self.values["seconds"]
        self.done = self.begin is not None and 0 < seconds <= (stamp - self.begin) / messages.NANOSECONDS

    def _odometry(self, message: Odometry) -> Sequence[float]:
        self.posture, v, w = messages.posture_in(message)
        return (v, w, *self.posture)

    def _write(self) -> None:
        """Write the log. Raises IdentifyError where nothing came."""
        for name, topic in {"v_command": "cmd_vel_topic", "v": "odom_topic"}.items():
            if name not in self.told:
                raise IdentifyError(f"nothing came on {self.resolve_topic_name(self.values[topic])}: there is no log")
        stamps = sorted(set().union(*self.told.values()))
        seconds = (np.array(stamps) - stamps[0]) / messages.NANOSECONDS
        others = [[self.told[name].get(stamp, nan) for stamp in stamps] for name in self.units]
        write_log(Path(self.values["log"]), self.units, np.column_stack([seconds, *others]))

    def leave(self) -> None:
        """Write the log, and identify the robot. Raises IdentifyError where it was stopped, and as identify does."""
        from robotics.plugins.identify.commands import identify

        self._write()
        values, log = self.values, self.values["log"]
        if self.why:
            raise IdentifyError(f"the robot was stopped: {self.why}; {log} holds what it drove")
        self.get_logger().info(f"wrote {log}")
        if values["out"]:
            page = Path(values["page"]) if values["page"] else None
            named: dict[str, Any] = {}
            if Path(log).suffix.lower() == ".mcap":  # as write_log names them
                named = {
                    "pose": "pose" if values["pose_topic"] else "",
                    "imu": "imu" if "yaw_rate" in self.told else "",
                }
            identify(Path(log), out=Path(values["out"]), robot=values["robot"], page=page, **named)


def _of_wheels(message: JointState) -> Sequence[float]:
    speeds = dict(zip(message.name, message.velocity, strict=False))
    return [speeds[name] for name in JOINTS] if all(name in speeds for name in JOINTS) else []


def _of_pose(message: PoseStamped) -> Sequence[float]:
    at, turn = message.pose.position, message.pose.orientation
    return at.x, at.y, heading_of(turn.x, turn.y, turn.z, turn.w)
