"""Messages of ROS from postures, readings and words of the radio, and back.

A message of the radio is a ``sensor_msgs/JointState`` taken as a list of named numbers with a time: standard packages
have no other, and one of our own would need a compiler. On ``radio`` it holds what a robot says, on ``heard`` what the
radio has brought a robot: ``robot2/x`` is a value, ``robot2/age`` [s] its age.
"""

from collections.abc import Mapping, Sequence
from math import inf, isfinite

from builtin_interfaces.msg import Time
from geometry_msgs.msg import PoseStamped, Twist, TwistStamped
from nav_msgs.msg import Odometry
from nav_msgs.msg import Path as PathMessage
from sensor_msgs.msg import JointState, Range
from std_msgs.msg import Header

from fuzzyfleet_ros.frames import Posture, heading_of, quaternion
from robotics.plugins.logs.names import WHEELS
from robotics.world.sensing.sonar import RangeSensor

NANOSECONDS = 1_000_000_000


def time_of(stamp: Time) -> int:
    """A stamp as nanoseconds."""
    return int(stamp.sec) * NANOSECONDS + int(stamp.nanosec)


def stamp_of(time: int) -> Time:
    """Nanoseconds as a stamp."""
    return Time(sec=time // NANOSECONDS, nanosec=time % NANOSECONDS)


def header(time: int, frame: str) -> Header:
    """A header of a time [ns] and a frame."""
    return Header(stamp=stamp_of(time), frame_id=frame)


def odometry(time: int, frame: str, child: str, posture: Posture, v: float, w: float) -> Odometry:
    """Where a robot is, and how fast."""
    message = Odometry(header=header(time, frame), child_frame_id=child)
    _place(message.pose.pose, posture)
    message.twist.twist.linear.x, message.twist.twist.angular.z = float(v), float(w)
    return message


def posture_in(message: Odometry) -> tuple[Posture, float, float]:
    """The posture, v [m/s] and ω [rad/s] of odometry. Raises ValueError where one is no finite number."""
    pose, twist = message.pose.pose, message.twist.twist
    q = pose.orientation
    posture = Posture(pose.position.x, pose.position.y, heading_of(q.x, q.y, q.z, q.w))
    v, w = twist.linear.x, twist.angular.z
    if not all(map(isfinite, (*posture, v, w))):
        raise ValueError("a number of it is not finite")
    return posture, v, w


def posed(time: int, frame: str, posture: Posture) -> PoseStamped:
    """A posture with a time [ns] and a frame."""
    message = PoseStamped(header=header(time, frame))
    _place(message.pose, posture)
    return message


def path(time: int, frame: str, postures: Sequence[Posture]) -> PathMessage:
    """A path of some postures."""
    return PathMessage(header=header(time, frame), poses=[posed(time, frame, posture) for posture in postures])


def twist(v: float, w: float) -> Twist:
    """A velocity."""
    message = Twist()
    message.linear.x, message.angular.z = float(v), float(w)  # messages check no types, and write nonsense for an int
    return message


def twist_stamped(time: int, frame: str, v: float, w: float) -> TwistStamped:
    """A velocity with a time [ns] and a frame."""
    return TwistStamped(header=header(time, frame), twist=twist(v, w))


def velocity_in(message: Twist | TwistStamped) -> tuple[float, float]:
    """v [m/s] and ω [rad/s] of a velocity. Raises ValueError where one is no finite number."""
    inner = message.twist if isinstance(message, TwistStamped) else message
    v, w = inner.linear.x, inner.angular.z
    if not (isfinite(v) and isfinite(w)):
        raise ValueError("a number of it is not finite")
    return v, w


def wheels(time: int, angles: Sequence[float], speeds: Sequence[float]) -> JointState:
    """The angles [rad] and speeds [rad/s] of the left and of the right wheel."""
    return JointState(header=header(time, ""), name=list(WHEELS), position=list(angles), velocity=list(speeds))


def reading(time: int, frame: str, sensor: RangeSensor, distance: float) -> Range:
    """A reading [m] of a range sensor; infinite: nothing seen, as REP-117 says."""
    return Range(
        header=header(time, frame),
        radiation_type=Range.ULTRASOUND if sensor.half_cone > 0 else Range.INFRARED,
        field_of_view=2 * sensor.half_cone,
        min_range=sensor.minimum,
        max_range=sensor.range,
        range=distance,
    )


def distance_in(message: Range) -> float:
    """The distance [m] that a reading says; infinite where nothing is seen, or farther than the sensor reaches."""
    seen = float(message.range)
    if seen != seen or seen > message.max_range:
        return inf
    return max(seen, 0.0)


def words(time: int, frame: str, names: Sequence[str], values: Sequence[float]) -> JointState:
    """Named numbers with the time [ns] at which they were said."""
    return JointState(header=header(time, frame), name=list(names), position=list(values))


def words_in(message: JointState) -> Mapping[str, float]:
    """Named numbers."""
    return dict(zip(message.name, message.position, strict=False))


def _place(pose: object, posture: Posture) -> None:
    pose.position.x, pose.position.y = float(posture.x), float(posture.y)  # type: ignore[attr-defined]
    pose.orientation.z, pose.orientation.w = quaternion(posture.heading)  # type: ignore[attr-defined]
