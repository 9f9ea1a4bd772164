"""Messages of a log made of plain numbers, in the types of one typestore."""

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

_NONE = np.zeros(36)  # no covariance is known
_EMPTY = np.zeros(0, np.uint8)


def nanoseconds(time: float) -> int:
    """A time [s] in whole nanoseconds, as stamps count it."""
    return round(time * 1e9)


@dataclass(frozen=True, eq=False)
class Composer:
    """Makes messages of the types of ``store``, a typestore of ``rosbags``. Angles are in rad, lengths in m."""

    store: Any

    def make(self, kind: str, /, **fields: Any) -> Any:
        """A message of the type ``kind``, such as ``nav_msgs/Odometry``."""
        package, _, name = kind.partition("/")
        return self.store.types[f"{package}/msg/{name}"](**fields)

    def stamp(self, time: float) -> Any:
        """A time [s] since the run's start."""
        seconds, rest = divmod(nanoseconds(time), 10**9)
        return self.make("builtin_interfaces/Time", sec=seconds, nanosec=rest)

    def header(self, time: float, frame: str) -> Any:
        """The header of a message."""
        return self.make("std_msgs/Header", stamp=self.stamp(time), frame_id=frame)

    def vector(self, x: float = 0.0, y: float = 0.0, z: float = 0.0) -> Any:
        """A vector."""
        return self.make("geometry_msgs/Vector3", x=float(x), y=float(y), z=float(z))

    def point(self, x: float, y: float, z: float = 0.0) -> Any:
        """A point."""
        return self.make("geometry_msgs/Point", x=float(x), y=float(y), z=float(z))

    def turn(self, heading: float) -> Any:
        """A rotation about z."""
        z, w = math.sin(heading / 2), math.cos(heading / 2)
        return self.make("geometry_msgs/Quaternion", x=0.0, y=0.0, z=z, w=w)

    def pose(self, x: float, y: float, heading: float) -> Any:
        """A pose on the floor."""
        return self.make("geometry_msgs/Pose", position=self.point(x, y), orientation=self.turn(heading))

    def twist(self, v: float, w: float) -> Any:
        """A velocity: ``v`` [m/s] ahead and ``w`` [rad/s] to the left."""
        return self.make("geometry_msgs/Twist", linear=self.vector(v), angular=self.vector(z=w))

    def odometry(self, header: Any, child: str, posture: Sequence[float], v: float, w: float) -> Any:
        """Where a robot is, x, y and heading, and how it moves."""
        pose = self.make("geometry_msgs/PoseWithCovariance", pose=self.pose(*posture), covariance=_NONE)
        twist = self.make("geometry_msgs/TwistWithCovariance", twist=self.twist(v, w), covariance=_NONE)
        return self.make("nav_msgs/Odometry", header=header, child_frame_id=child, pose=pose, twist=twist)

    def turn_rate(self, header: Any, w: float) -> Any:
        """What a gyroscope tells: a turn rate [rad/s], and nothing else (by the message's own rule, -1)."""
        unknown = np.append(-1.0, np.zeros(8))
        return self.make(
            "sensor_msgs/Imu",
            header=header,
            orientation=self.turn(0.0),
            orientation_covariance=unknown,
            angular_velocity=self.vector(z=w),
            angular_velocity_covariance=np.zeros(9),
            linear_acceleration=self.vector(),
            linear_acceleration_covariance=unknown,
        )

    def transform(self, header: Any, child: str, x: float, y: float, heading: float) -> Any:
        """Where the frame ``child`` stands in that of the header."""
        turned = self.make("geometry_msgs/Transform", translation=self.vector(x, y), rotation=self.turn(heading))
        return self.make("geometry_msgs/TransformStamped", header=header, child_frame_id=child, transform=turned)

    def path(self, header: Any, points: np.ndarray) -> Any:
        """A path through ``points`` (n, 3): x, y and heading of each; none of them has a time of its own."""
        poses = [self.make("geometry_msgs/PoseStamped", header=header, pose=self.pose(*p)) for p in points.tolist()]
        return self.make("nav_msgs/Path", header=header, poses=poses)

    def marker(
        self,
        header: Any,
        group: str,
        number: int,
        kind: int,
        place: Sequence[float],
        scale: Sequence[float],
        colour: str,
        points: Iterable[Sequence[float]] = (),
        *,
        carried: bool = False,
    ) -> Any:
        """A body to be drawn: one of the kinds 1 cube, 3 cylinder and 5 list of lines.

        Args:
            header: Its frame and time.
            group: Of which group of bodies it is.
            number: Its number there.
            kind: Of visualization_msgs/Marker.
            place: x, y, z and heading.
            scale: Its extent in x, y and z; of lines their width.
            colour: As CSS writes it, # and six digits.
            points: The ends of lines.
            carried: Whether it goes with its frame.
        """
        red, green, blue = (int(colour[k : k + 2], 16) / 255 for k in (1, 3, 5))
        x, y, z, heading = place
        picture = self.make("sensor_msgs/CompressedImage", header=self.header(0.0, ""), format="", data=_EMPTY)
        return self.make(
            "visualization_msgs/Marker",
            header=header,
            ns=group,
            id=number,
            type=kind,
            action=0,
            pose=self.make("geometry_msgs/Pose", position=self.point(x, y, z), orientation=self.turn(heading)),
            scale=self.vector(*scale),
            color=self.make("std_msgs/ColorRGBA", r=red, g=green, b=blue, a=0.9),
            lifetime=self.make("builtin_interfaces/Duration", sec=0, nanosec=0),
            frame_locked=carried,
            points=[self.point(*p) for p in points],
            colors=[],
            texture_resource="",
            texture=picture,
            uv_coordinates=[],
            text="",
            mesh_resource="",
            mesh_file=self.make("visualization_msgs/MeshFile", filename="", data=_EMPTY),
            mesh_use_embedded_materials=False,
        )

    def range(self, header: Any, *, cone: float, least: float, most: float, reading: float) -> Any:
        """What a range sensor reads, in single precision; infinite: it sees nothing."""
        fields = {
            "header": header,
            "radiation_type": 0 if cone > 0 else 1,  # a cone of sound, or a beam of light
            "field_of_view": float(cone),
            "min_range": float(least),
            "max_range": float(most),
            "range": float(reading),
            "variance": 0.0,  # from Iron on; 0: unknown
        }
        known = dict(self.store.fielddefs["sensor_msgs/msg/Range"][1])
        return self.make("sensor_msgs/Range", **{name: fields[name] for name in known})
