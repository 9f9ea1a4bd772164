"""The tree of frames on /tf and /tf_static, where tf2_ros is installed; its wheels are not on the package index."""

from collections.abc import Mapping, Sequence
from typing import Any

from geometry_msgs.msg import TransformStamped
from rclpy.node import Node

from fuzzyfleet_ros import messages
from fuzzyfleet_ros.frames import HERE, Posture, quaternion
from fuzzyfleet_ros.names import prefix
from robotics.plugins.logs.names import MAP, token


class Transforms:
    """map → odom → base_link → sensors, of every robot."""

    def __init__(self, node: Node, robots: int, mounts: Sequence[Mapping[str, Posture]]) -> None:
        """Open the topics of ``node``; ``mounts`` are the postures of each robot's sensors on it, by name."""
        self.robots, self.moving = robots, None
        try:
            import tf2_ros
        except ImportError:
            return
        self.moving = tf2_ros.TransformBroadcaster(node)
        self.resting = tf2_ros.StaticTransformBroadcaster(node)
        fixed = []
        for i, sensors in enumerate(mounts):
            inside = prefix(i, robots)
            fixed.append(transform(0, MAP, f"{inside}odom", HERE))
            fixed += [transform(0, f"{inside}base_link", f"{inside}{token(n)}", at) for n, at in sensors.items()]
        self.resting.sendTransform(fixed)

    def tell(self, robot: int, time: int, posture: Posture) -> None:
        """Say where a robot, counted from 0, is at ``time`` [ns]."""
        if self.moving is not None:
            inside = prefix(robot, self.robots)
            self.moving.sendTransform([transform(time, f"{inside}odom", f"{inside}base_link", posture)])


def transform(time: int, frame: str, child: str, posture: Posture) -> Any:
    """The posture of the frame ``child`` in ``frame`` at ``time`` [ns]."""
    made = TransformStamped(header=messages.header(time, frame), child_frame_id=child)
    made.transform.translation.x, made.transform.translation.y = posture.x, posture.y
    made.transform.rotation.z, made.transform.rotation.w = quaternion(posture.heading)
    return made
