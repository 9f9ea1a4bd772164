"""The node that is the simulator: velocities in; odometry, wheels, ranges, what the radio brings, and the clock out.

In real time it moves on by its own clock. In lockstep a period only begins after every robot's command for the one
before has come, so that a drive is that of ``robotics run``, however slow the network is. The tree of frames is on /tf
and /tf_static where tf2_ros is installed, whose wheels are not on the package index.
"""

import time as clocks
from collections.abc import Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import Any

from geometry_msgs.msg import TransformStamped, Twist, TwistStamped
from nav_msgs.msg import Odometry
from rclpy.clock import Clock, ClockType
from rclpy.node import Node
from rclpy.publisher import Publisher
from rosgraph_msgs.msg import Clock as ClockMessage
from sensor_msgs.msg import JointState, Range

from fuzzyfleet_ros import messages
from fuzzyfleet_ros.frames import HERE, Posture, quaternion
from fuzzyfleet_ros.loopback import Loopback, Sensed
from fuzzyfleet_ros.names import prefix, robot_name, scenario_of
from fuzzyfleet_ros.parameters import Parameter, ParameterError, declared
from robotics.laws.catalogue import make_controller
from robotics.plugins.logs.names import MAP, token
from robotics.simulation.safety.opening import is_guarded

_FIRST = messages.NANOSECONDS  # ns: the time of the first period; ROS takes 0 for no time at all
MOST_SENSORS = 16  # of a robot, if its law does not name those that it needs
_AGAIN = 0.1  # s of real time after which a period is told once more, while an answer to it is missing

_PARAMETERS = (
    Parameter("scenario", "reference", "A scenario's name or .toml file."),
    Parameter("robot", "", "A robot's name or .toml file; empty: the scenario's."),
    Parameter("law", "", "The law that the controllers drive by: it says what messages and which sensors there are."),
    Parameter("rate", 0.0, "Periods a second [Hz]; 0: the scenario's.", 0, 100),
    Parameter("duration", 0.0, "How long it lasts [s]; 0: as long as the scenario says.", 0, 86400),
    Parameter("seed", 0, "The seed of all noise.", 0, 2**31 - 1),
    Parameter("lockstep", False, "Wait for every robot's command before a period begins; publishes /clock."),
    Parameter("clock", False, "Stamp by the simulator's own time and publish it on /clock, in real time too."),
    Parameter("stamped", True, "Whether velocities are TwistStamped, or Twist."),
    Parameter("waits", True, "Whether it begins only when every robot has got a command."),
    Parameter("cmd_vel_timeout", 0.5, "The time without a command after which a base stops [s]; 0: never.", 0, 60),
    Parameter("step_timeout", 2.0, "In lockstep: how long it waits for a command, in real time [s].", 0.1, 600),
    Parameter("save", "", "A file .npz for the run, as of robotics run --save, written when it ends."),
)


class Simulator(Node):
    """The simulator as a node; raises InputError for parameters that do not suit each other."""

    def __init__(self, **options: Any) -> None:
        """Open it; ``options`` are those of a node, such as its namespace."""
        super().__init__("simulator", **options)
        values = self.values = declared(self, _PARAMETERS)
        self.lockstep, self.done = values["lockstep"], False
        self.own_clock = self.lockstep or values["clock"]
        if self.lockstep and not values["stamped"]:
            raise ParameterError("lockstep needs stamped, because commands are told by their time")
        if (file := values["save"]) and not file.endswith(".npz"):
            raise ParameterError(f"save must be a file that ends in .npz, got {file}")
        rate = values["rate"]
        scenario = scenario_of(values["scenario"], values["robot"], rate, values["duration"])
        law = make_controller(values["law"]) if values["law"] else None
        patience = values["cmd_vel_timeout"] or float("inf")
        self.loop = Loopback(scenario.setting, law, values["seed"], patience=patience, keeps=bool(values["save"]))
        self.robots, self.words = len(scenario.robots), self.loop.outside.message
        self.guarded = law is not None and is_guarded(scenario.setting, law)
        self.needs = law.needs if law and not self.guarded else ()
        self.complained: set[str] = set()
        self.began = not values["waits"]
        self.idle = 0.0  # s: how long it has waited for commands
        self.answered: set[int] = set()  # robots whose command for this period has come
        self.spoken: set[int] = set()  # likewise their message
        self.told = clocks.monotonic()  # s: when this period was told last,
        self.since = self.told  # and first
        self._open()
        self.sensed = self.loop.sense()
        self._tell()
        self.get_logger().info(
            f"{scenario.name}: {self.robots} robot{'s' * (self.robots > 1)}, {scenario.duration:g} s, "
            + ("in lockstep" if self.lockstep else "in real time")
        )

    def _open(self) -> None:
        """Open the topics and the clock."""
        steady = Clock(clock_type=ClockType.STEADY_TIME)
        self.clock_topic = self.create_publisher(ClockMessage, "/clock", 10) if self.own_clock else None
        sensors = self.loop.setting.sensors
        self.bodies: list[dict[str, Publisher]] = []
        self.eyes: list[dict[str, Publisher]] = []
        for i in range(self.robots):
            inside = prefix(i, self.robots)
            body = {
                "odom": self.create_publisher(Odometry, f"{inside}odom", 10),
                "truth": self.create_publisher(Odometry, f"{inside}ground_truth", 10),
                "wheels": self.create_publisher(JointState, f"{inside}joint_states", 10),
            }
            if self.words:
                body["heard"] = self.create_publisher(JointState, f"{inside}heard", 10)
                self.create_subscription(JointState, f"{inside}radio", partial(self._on_radio, i), 10)
            many = len(sensors[i]) > MOST_SENSORS and not self.guarded
            seen = self.needs or (() if many else sensors[i])
            if many and not self.needs:
                self._complain(
                    f"the {len(sensors[i])} range sensors are not published: no law that needs some is given"
                )
            self.bodies.append(body)
            self.eyes.append(
                {n: self.create_publisher(Range, f"{inside}range/{token(n)}", 10) for n in seen if n in sensors[i]}
            )
            kind = TwistStamped if self.values["stamped"] else Twist
            self.create_subscription(kind, f"{inside}cmd_vel", partial(self._on_command, i), 10)
        mounts = [
            {n: Posture(carried[n].x, carried[n].y, carried[n].axis) for n in eyes}
            for carried, eyes in zip(sensors, self.eyes, strict=True)
        ]
        self.transforms = Transforms(self, self.robots, mounts)
        if self.lockstep:
            self.create_timer(_AGAIN / 2, self._look, clock=steady)
        else:
            self.create_timer(self.loop.setting.period, self._tick, clock=steady)

    # Periods -----------------------------------------------------------------------------------------------------

    @property
    def time(self) -> int:
        """The time of this period by the simulator's own clock [ns]."""
        return _FIRST + round((self.loop.time + self.idle) * messages.NANOSECONDS)

    def _tick(self) -> None:
        """A period of real time."""
        self.began = self.began or len(self.answered) == self.robots
        if self.began:
            self._advance()
        else:
            self.idle += self.loop.setting.period  # who goes by this clock decides only when it goes on
            self._tell()

    def _advance(self) -> None:
        """Move on by a period and tell of it, or end."""
        over = self.loop.over
        self.loop.advance()
        self.answered.clear()
        self.spoken.clear()
        if over:
            self.done = True
            self.get_logger().info(f"it is over after {self.loop.time:.4g} s")
            return
        self.sensed = self.loop.sense()
        self.since = clocks.monotonic()
        self._tell()

    def _move_together(self) -> None:
        """In lockstep: begin the next period if all has come that this one waits for."""
        if not self.lockstep or self.done:
            return
        silent = self.loop.speaks_now and len(self.spoken) < self.robots
        if len(self.answered) == self.robots and not silent:
            self.began = True
            self._advance()

    def _look(self) -> None:
        """In lockstep: ask once more, or go on without those that do not answer."""
        if self.done:
            return
        now = clocks.monotonic()
        if self.began and now - self.since > self.values["step_timeout"]:
            for i in set(range(self.robots)) - self.answered:
                self._complain(f"{robot_name(i)} sent no command within step_timeout: it does not wait for it any more")
            self._advance()
        elif now - self.told > _AGAIN:
            self._tell()

    # What comes ---------------------------------------------------------------------------------------------------

    def _on_command(self, robot: int, message: Twist | TwistStamped) -> None:
        try:
            v, w = messages.velocity_in(message)
        except ValueError as error:
            self._complain(f"a command of {robot_name(robot)} is ignored: {error}")
            return
        if self.lockstep and messages.time_of(message.header.stamp) != self.time:
            return  # the answer to a period that is gone
        self.loop.command(robot, v, w)
        self.answered.add(robot)
        self._move_together()

    def _on_radio(self, robot: int, message: JointState) -> None:
        said = messages.words_in(message)
        if any(word not in said for word in self.words):
            self._complain(f"a message of {robot_name(robot)} is ignored: it lacks some of {', '.join(self.words)}")
            return
        if self.lockstep and messages.time_of(message.header.stamp) != self.time:
            return
        self.loop.speak(robot, [said[word] for word in self.words])
        self.spoken.add(robot)
        self._move_together()

    # What goes ---------------------------------------------------------------------------------------------------

    def _tell(self) -> None:
        """Publish what is sensed, and what the radio has brought; odometry last."""
        now = self.time if self.own_clock else self.get_clock().now().nanoseconds
        self.told = clocks.monotonic()
        if self.clock_topic is not None:
            self.clock_topic.publish(ClockMessage(clock=messages.stamp_of(now)))
        for i in range(self.robots):
            self._tell_robot(i, now, self.sensed)

    def _tell_robot(self, i: int, now: int, sensed: Sensed) -> None:
        inside, body = prefix(i, self.robots), self.bodies[i]
        carried = self.loop.setting.sensors[i]
        for name, eye in self.eyes[i].items():
            distance = float(sensed.ranges[i, self.loop.names.index(name)])
            eye.publish(messages.reading(now, f"{inside}{token(name)}", carried[name], distance))
        if self.words:
            names, values = heard_words(sensed, i)
            body["heard"].publish(messages.words(now, inside.rstrip("/"), names, values))
        wheels = sensed.wheels[:, i].tolist()
        body["wheels"].publish(messages.wheels(now, wheels[:2], wheels[2:]))
        base, posture = f"{inside}base_link", Posture(*sensed.posture[:, i].tolist())
        velocity = sensed.velocity[:, i].tolist()
        truth = Posture(*sensed.truth[:, i].tolist())
        body["truth"].publish(messages.odometry(now, MAP, f"{base}_true", truth, *sensed.speed[:, i].tolist()))
        self.transforms.tell(i, now, posture)
        body["odom"].publish(messages.odometry(now, f"{inside}odom", base, posture, *velocity))

    def _complain(self, what: str) -> None:
        """Say it, once."""
        if what not in self.complained:
            self.complained.add(what)
            self.get_logger().warning(what)

    def leave(self) -> None:
        """Write the run, where that is asked for."""
        file = self.values["save"]
        if file and self.loop.k:
            self.loop.run(self.values["law"] or "outside").save(Path(file))
            self.get_logger().info(f"wrote {file}")


def heard_words(sensed: Sensed, robot: int) -> tuple[list[str], list[float]]:
    """What a robot, counted from 0, has heard: names and numbers of each robot that it has heard at all."""
    names: list[str] = []
    values: list[float] = []
    for j, age in enumerate(sensed.heard.age[0, robot].tolist()):
        if age < float("inf"):
            names += [f"{robot_name(j)}/{word}" for word in ("age", *sensed.heard.fields)]
            values += [age, *sensed.heard.values[:, 0, robot, j].tolist()]
    return names, values


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
