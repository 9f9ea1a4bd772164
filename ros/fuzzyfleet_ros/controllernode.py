"""The node that drives one robot by a law: odometry, ranges and messages in, a velocity out.

It decides in every period of its own clock, or, in lockstep, once for each period of the simulator. It lets the robot
stand while its odometry, or a reading that its law needs, is missing or old, and when it ends.
"""

import time as clocks
from functools import partial
from math import inf
from typing import Any

from geometry_msgs.msg import PoseStamped, Twist, TwistStamped
from nav_msgs.msg import Odometry
from nav_msgs.msg import Path as PathMessage
from rclpy.clock import Clock, ClockType
from rclpy.duration import Duration
from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy
from sensor_msgs.msg import JointState, Range

from fuzzy.errors import InputError
from fuzzyfleet_ros import messages
from fuzzyfleet_ros.controllersettings import PARAMETERS, PathTask, check, scenario_task
from fuzzyfleet_ros.frames import HERE, Posture, continued
from fuzzyfleet_ros.names import prefix, robot_name
from fuzzyfleet_ros.onboard import Onboard, Order, OwnState, Perceived, Remembered
from fuzzyfleet_ros.parameters import declared
from fuzzyfleet_ros.standing import CommandWatchdog
from robotics.laws.catalogue import make_controller
from robotics.plugins.logs.names import token
from robotics.simulation.safety.coverage import blind_spots
from robotics.world.sensing.carried import sensor_names

_SHOWN = 400  # points of the plan that is shown


class Controller(Node):
    """A robot's law as a node; raises InputError for parameters that do not suit each other."""

    def __init__(self, **options: Any) -> None:
        """Open it; ``options`` are those of a node, such as its namespace."""
        super().__init__("controller", **options)
        values = self.values = declared(self, PARAMETERS)
        check(values)
        self.law = make_controller(values["law"])
        self.path_task = None if values["scenario"] else PathTask.of(values, self.law)
        self.task: Onboard | None = None if self.path_task else scenario_task(values, self.law)
        if self.path_task:
            self.path_task.rehearse()
        self.lockstep, self.done = values["lockstep"], False
        self.standing = CommandWatchdog(values["odom_timeout"], values["range_timeout"], clocks.monotonic)
        robots = len(self.task.setting.robots) if self.task else 1
        self.own = self.task.robot if self.task else 0
        inside = prefix(self.own, robots)
        self.odom_frame = values["odom_frame"] or f"{inside}odom"
        self.base_frame = values["base_frame"] or f"{inside}base_link"
        self.known: dict[int, OwnState] = {}  # of each robot, from 0, as odometry says
        self.stamps: dict[str, int] = {}  # ns: of the last message, by what it is
        self.ranges: dict[str, float] = {}  # m, by the sensor's name
        self.looked: set[str] = set()  # the sensors whose readings have come since the last decision
        self.frame = HERE  # of odometry, in the frame of the paths
        self.memory: Remembered | None = None  # of the task
        self.odometry = HERE  # the robot's posture as odometry says
        self.begin: int | None = None  # ns: when the task began
        self.first: int | None = None  # ns: when the first did
        self.last = 0  # ns: when the last decision was made
        self.waited = 0  # ns: how long the robot has stood since
        self.order: Order | None = None
        self.ended = ""  # why it stands until another task comes
        self.opened: set[str] = set()  # topics of tasks
        self._open()
        if self.task:
            self._take(self.task)
        if self.law.estimator is not None:
            self.get_logger().warning(
                f"estimator={self.law.estimator} is of the simulator's pose sensor; here the odometry topic should "
                "come from a filter, such as that of robot_localization"
            )
        self.get_logger().info(f"{values['law']} drives {self.resolve_topic_name(values['cmd_vel_topic'])}")

    # What comes and goes -----------------------------------------------------------------------------------------

    def _open(self) -> None:
        """Open the topics that do not depend on the task, and the clocks."""
        values = self.values
        kind = TwistStamped if values["stamped"] else Twist
        once = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
        self.velocity = self.create_publisher(kind, values["cmd_vel_topic"], 1)
        says = self.task.fields if self.task else self.law.message
        self.radio = self.create_publisher(JointState, "radio", 10) if says else None
        self.plan = self.create_publisher(PathMessage, "plan", once)
        self.target = self.create_publisher(PoseStamped, "target", 1)
        # Whoever publishes odometry reliably or not is heard; in lockstep nothing may be lost
        policy = ReliabilityPolicy.RELIABLE if self.lockstep else ReliabilityPolicy.BEST_EFFORT
        self.sensed = QoSProfile(depth=10, reliability=policy)
        self.create_subscription(Odometry, values["odom_topic"], self._on_odometry, self.sensed)
        if self.path_task:
            self.create_subscription(PathMessage, values["path_topic"], self._on_path, 1)
        steady = Clock(clock_type=ClockType.STEADY_TIME)
        if self.standing.odom_timeout:
            self.create_timer(self.standing.odom_timeout / 4, self._watch, clock=steady)
        if not self.lockstep:
            period = self.task.setting.period if self.task else 1 / (self.values["rate"] or 20.0)
            self.ticker = self.create_timer(period, self._tick)

    def _take(self, task: Onboard) -> None:
        """Take up a task, which begins with the next odometry."""
        task.rehearse()
        self.task, self.memory, self.received = task, task.begin(self.memory), task.silence()
        self.begin, self.waited, self.order, self.ended = None, 0, None, ""
        self.wanted = list(task.needs) or (sensor_names(task.setting.sensors) if self.law.looks else ())
        for name in self.wanted:
            self._listen(Range, f"{self.values['range_topic']}/{token(name)}", partial(self._on_range, name))
        for other in range(len(task.setting.robots)) if task.sees_others else ():
            if other != task.robot:
                topic = f"/{robot_name(other)}/{self.values['odom_topic']}"
                self._listen(Odometry, topic, partial(self._on_other, other))
        for told in blind_spots(task.setting, self.law, on_board=True) if task.guarded else ():
            self.get_logger().warning(told)
        if task.fields and self.values["radio"] == "relayed":
            self._listen(JointState, "heard", self._on_heard)
        elif task.fields:
            for other in task.senders:
                self._listen(JointState, f"/{robot_name(other)}/radio", partial(self._on_radio, other))

    def _listen(self, kind: Any, topic: str, callback: Any) -> None:
        """Listen to a topic, unless a task before has opened it."""
        if topic not in self.opened:
            self.opened.add(topic)
            self.create_subscription(kind, topic, callback, self.sensed)

    def _on_odometry(self, message: Odometry) -> None:
        if self._known(message, self.own, self.frame) and self.lockstep:
            self._decide_together()

    def _known(self, message: Odometry, robot: int, frame: Posture) -> bool:
        """Note where a robot is, unless the message does not say; return whether it does."""
        what = f"odometry of {robot_name(robot)}"
        try:
            posture, v, w = messages.posture_in(message)
        except ValueError as error:
            self._ignored(what, str(error))
            return False
        stamp = messages.time_of(message.header.stamp)
        if self._ignores(what, stamp, self.standing.odom_timeout):
            return False
        if robot == self.own:
            self.odometry = posture
        posture, task = posture.inside(frame), self.task
        near = task.start_of(robot).heading if task else 0.0
        if robot in self.known:
            near = self.known[robot].posture.heading
        posture = posture._replace(heading=continued(posture.heading, near))
        self.known[robot] = OwnState(posture, v, w)
        self.stamps[f"odometry {robot}"] = stamp
        self.standing.odometry_came("" if robot == self.own else robot_name(robot))
        return True

    def _on_other(self, robot: int, message: Odometry) -> None:
        self._known(message, robot, HERE)
        self._decide_together()

    def _on_range(self, name: str, message: Range) -> None:
        stamp = messages.time_of(message.header.stamp)
        if self._ignores(f"the reading of {name}", stamp, self.standing.range_timeout):
            return
        self.ranges[name], self.stamps[f"range {name}"] = messages.distance_in(message), stamp
        self.looked.add(name)
        self.standing.reading_came(name)
        self._decide_together()

    def _on_heard(self, message: JointState) -> None:
        """What the radio of the simulator has brought."""
        if self.task is None:
            return
        said, now = messages.words_in(message), messages.time_of(message.header.stamp)
        if self._ignores("what the radio brings", now):
            return
        for other in self.task.senders:
            age = said.get(f"{robot_name(other)}/age")
            if age is not None:
                words = {field: said.get(f"{robot_name(other)}/{field}") for field in self.task.fields}
                self._received(other, now, age, words)
        self.stamps["heard"] = now
        self._decide_together()

    def _on_radio(self, other: int, message: JointState) -> None:
        sent = messages.time_of(message.header.stamp)
        if self._ignores(f"a message of {robot_name(other)}", sent):
            return
        said, fields = messages.words_in(message), self.task.fields if self.task else ()
        self._received(other, sent, 0.0, {field: said.get(field) for field in fields})

    def _ignores(self, what: str, stamp: int, most: float = 0.0) -> bool:
        """Whether a message is ignored as a repetition, or of another time.

        ``most`` is its age at most [s]; 0: a law counts with any. In lockstep the simulator repeats what it asks.
        """
        if self.lockstep:
            return False
        now = self.get_clock().now().nanoseconds / messages.NANOSECONDS
        why = self.standing.refusal(what, stamp / messages.NANOSECONDS, now, most or inf)
        if why:
            self._ignored(what, why)
        return bool(why)

    def _received(self, sender: int, noted: int, age: float, words: dict[str, float | None]) -> None:
        values = [value for value in words.values() if value is not None]
        if len(values) < len(words):
            self._ignored(f"a message of {robot_name(sender)}", f"it lacks {', '.join(words)}; another law?")
            return
        self.received = self.received.with_message(sender, noted / messages.NANOSECONDS, age, values)

    def _on_path(self, message: PathMessage) -> None:
        """Take up a new path; one that cannot be driven is refused, and the old one goes on."""
        assert self.path_task is not None
        try:
            if message.header.frame_id not in ("", self.odom_frame):
                raise InputError(f"its frame is {message.header.frame_id}, and odometry's is {self.odom_frame}")
            task = self.path_task.along([(p.pose.position.x, p.pose.position.y) for p in message.poses])
        except InputError as error:
            self.get_logger().error(f"the path is refused: {error}")
            return
        self._take(task)
        self.get_logger().info(f"a path of {task.setting.references.joined.lengths[0]:.3g} m, {task.duration:.3g} s")

    # Decisions ---------------------------------------------------------------------------------------------------

    def _tick(self) -> None:
        """A period of the node's own clock."""
        if self.task is not None and self.own in self.known:
            self._decide(self.get_clock().now().nanoseconds)

    def _decide_together(self) -> None:
        """In lockstep: decide when all has come that belongs to the period of the last odometry."""
        task, now = self.task, self.stamps.get(f"odometry {self.own}", -1)
        if not self.lockstep or task is None or now < 0:
            return
        if self.begin is not None and now <= self.last:
            if now == self.last:
                self._send(now)  # it asks once more
            return
        wants = [f"range {name}" for name in self.wanted]
        wants += ["heard"] if task.fields else []
        wants += [f"odometry {j}" for j in range(len(task.setting.robots))] if task.sees_others else []
        if all(self.stamps.get(what, -1) >= now for what in wants):
            self._decide(now)

    def _decide(self, now: int) -> None:
        """Ask the law for its command at ``now`` [ns], unless the robot must stand."""
        task = self.task
        assert task is not None
        robots = range(len(task.setting.robots)) if task.sees_others else ()
        missing = [robot_name(j) for j in robots if j not in self.known]
        waits = f"it waits for the odometry of {missing[0]}, which its law reads" if missing else ""
        if reason := self.ended or waits or self.standing.reason(task.needs):
            self._stand(reason, now)
            return
        if self.begin is None:
            self._begin(now)
        assert self.begin is not None
        if came_back := self.standing.moves():
            self.get_logger().info(came_back)
            if self.values["reference_waits"]:
                self.waited += max(0, now - self.last - round(task.setting.period * messages.NANOSECONDS))
        time, period = (now - self.begin - self.waited) / messages.NANOSECONDS, task.setting.period
        if self.lockstep:
            time = round(time / period) * period  # to the last bit
        if time > task.duration + 1e-6:
            self.ended = f"the task is over after {task.duration:.4g} s"
            self._stand(self.ended, now)
            return
        received = self.received._replace(noted=self.received.noted - now / messages.NANOSECONDS + time)
        others = {j: known for j, known in self.known.items() if j != self.own} if task.sees_others else {}
        ranges, looked = self.ranges if self.wanted else None, None if self.lockstep else self.looked
        assert self.memory is not None
        assert self.first is not None
        clock = (now - self.first) / messages.NANOSECONDS
        seen = Perceived(time, self.known[self.own], others, received, ranges, looked, self.odometry, clock)
        self.looked = set()
        self.order, self.memory = task.step(seen, self.memory)
        self.last = now
        if self.order.lost:
            self.ended = f"it is stopped for good: {self.order.lost}"
            self._stand(self.ended, now)
        self._send(now)

    def _begin(self, now: int) -> None:
        """Begin the task where the robot is now."""
        assert self.task is not None
        self.first = now if self.first is None else self.first
        self.begin, self.last, known = now, now, self.known[self.own]  # what it stood for before is no waiting
        if self.values["origin"] == "start":
            frame = self.task.start.frame_of(known.posture)
            self.frame = frame.inside(self.frame) if self.frame != HERE else frame
            posture = known.posture.inside(frame)
            near = continued(posture.heading, self.task.start.heading)
            self.known[self.own] = known._replace(posture=posture._replace(heading=near))
        plan = [self._in_odometry(posture) for posture in self.task.plan(_SHOWN)]
        self.plan.publish(messages.path(now, self.odom_frame, plan))

    def _in_odometry(self, posture: Posture) -> Posture:
        """A posture of the paths' frame in that of odometry."""
        return posture.inside(HERE.frame_of(self.frame))

    # What is sent ------------------------------------------------------------------------------------------------

    def _send(self, now: int) -> None:
        """Say and do what was decided."""
        order = self.order
        if order is None:
            return
        if self.radio is not None and self.task is not None and order.message:
            self.radio.publish(messages.words(now, robot_name(self.own), self.task.fields, order.message))
        self._command(now, order.v, order.w)
        self.target.publish(messages.posed(now, self.odom_frame, self._in_odometry(order.target)))

    def _command(self, now: int, v: float, w: float) -> None:
        stamped = self.values["stamped"]
        self.velocity.publish(messages.twist_stamped(now, self.base_frame, v, w) if stamped else messages.twist(v, w))

    def _stand(self, reason: str, now: int) -> None:
        """Let the robot stand, and say why, once."""
        if self.standing.stands(reason):
            self.get_logger().warning(f"the robot stands: {reason}")
        self._command(now, 0.0, 0.0)

    def _watch(self) -> None:
        """Look whether odometry still comes, by a clock that nobody can stop."""
        if self.begin is not None and (reason := self.standing.odometry_is_old()):
            self._stand(self.ended or reason, self._now())

    def _now(self) -> int:
        return self.stamps[f"odometry {self.own}"] if self.lockstep else self.get_clock().now().nanoseconds

    def _ignored(self, what: str, why: str) -> None:
        """Say that a message is ignored, once."""
        if self.standing.refused(what):
            self.get_logger().warning(f"{what} is ignored: {why}")

    def leave(self) -> None:
        """Let the robot stand for good."""
        if self.own in self.known:
            self._command(self._now(), 0.0, 0.0)
            self.velocity.wait_for_all_acked(Duration(seconds=0.5))
            self.get_logger().info("the robot stands: the controller ends")
