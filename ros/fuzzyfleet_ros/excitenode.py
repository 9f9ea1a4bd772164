"""The node that drives a minute that tells most of a robot, and identifies the robot from it.

It stops for good, and says why, when odometry is older than ``odom_timeout``, when the robot's outline comes to the
edge of the square, when another node commands too, and when it is told to end. The log holds what was driven.
"""

from pathlib import Path
from typing import Any

import numpy as np
from geometry_msgs.msg import Twist, TwistStamped
from rclpy.clock import Clock, ClockType
from rclpy.duration import Duration

from fuzzy.files.table import read_table
from fuzzyfleet_ros import messages
from fuzzyfleet_ros.frames import HERE, Posture
from fuzzyfleet_ros.identifynode import LOG_PARAMETERS, Identifier
from fuzzyfleet_ros.parameters import Parameter, ParameterError
from robotics.plugins.identify.excitation import excite
from robotics.plugins.identify.replay import COMMAND_PERIOD, COMMANDS, Program

_PARAMETERS = (
    *LOG_PARAMETERS,
    Parameter("square", 3.0, "Side [m] of the square in whose middle the robot stands.", 0.1, 1000),
    Parameter("seconds", 60.0, "How long the commands are [s].", 20, 600),
    Parameter("commands", "", "A .csv file of robotics excite; empty: they are chosen for the robot and the square."),
    Parameter("lockstep", False, "Command once for each period of the simulator, instead of by the clock."),
)


class Exciter(Identifier):
    """A driver of the commands that tell most; raises InputError for parameters that do not suit each other."""

    def __init__(self, **options: Any) -> None:
        """Open it; ``options`` are those of a node, such as its namespace."""
        super().__init__("excite", _PARAMETERS, **options)

    def _attend(self) -> None:
        """Choose the commands, and open their topic."""
        values = self.values
        if self.lockstep and not values["stamped"]:
            raise ParameterError("lockstep needs stamped, because the simulator tells commands by their time")
        file, robot = values["commands"], self.model.robot
        self.program = _program(file) if file else excite(robot, values["square"], values["seconds"]).program
        self.room = values["square"] / 2 - robot.turning_circle  # m: for the middle of the robot
        self.inverse: Posture | None = None  # of the posture in which it began
        kind = TwistStamped if values["stamped"] else Twist
        self.velocity = self.create_publisher(kind, values["cmd_vel_topic"], 1)
        self.topic = self.resolve_topic_name(values["cmd_vel_topic"])
        if not self.lockstep:
            self.create_timer(COMMAND_PERIOD, self._tick, clock=Clock(clock_type=ClockType.STEADY_TIME))
        self.get_logger().info(
            f"{self.program.time[-1]:.3g} s of {kind.__name__} on {self.topic} within a square of "
            f"{values['square']:g} m, whose middle is where the robot stands: keep a hand at the switch"
        )

    def _on_odometry(self, stamp: int) -> None:
        if self.lockstep and not self.done:
            self._drive(stamp)

    def _tick(self) -> None:
        """A period of a clock that nobody can stop."""
        if not self.done:
            self._drive(self.get_clock().now().nanoseconds)

    def _drive(self, now: int) -> None:
        """Send the command of the moment, or wait for what is missing, or stop for good."""
        if self.begin is None and (waits := self._waits()):
            if self.standing.stands(waits):
                self.get_logger().warning(f"it waits: {waits}")
            return
        if self.inverse is None:
            self.inverse = HERE.frame_of(self.posture)
        self.why = self._danger(self.posture.inside(self.inverse))
        begin, (time, v, w) = now if self.begin is None else self.begin, self.program
        elapsed = (now - begin) / messages.NANOSECONDS
        k = int(np.searchsorted(time, elapsed + COMMAND_PERIOD / 2, side="right")) - 1
        over = elapsed > time[-1] + COMMAND_PERIOD / 2
        if self.why or over:
            self.done = True
            self._command(now, 0.0, 0.0)
            return
        self._command(now, float(v[max(k, 0)]), float(w[max(k, 0)]))

    def _waits(self) -> str:
        """What is missing before it can begin, in words; nothing: it begins."""
        if not self.velocity.get_subscription_count():
            other = "Twist" if self.values["stamped"] else "TwistStamped"
            return f"nobody takes the commands on {self.topic}; does the robot want {other} (stamped)?"
        return self.standing.odometry_is_old()

    def _danger(self, place: Posture) -> str:
        """Why the robot must stop, in words; nothing: it may go on."""
        if self.count_publishers(self.topic) > 1:
            return f"another node commands on {self.topic}, too"
        far = max(abs(place.x), abs(place.y))
        if far > self.room:
            return f"it is {far:.3g} m from the middle of its square, of {self.room:.3g} m that its outline leaves"
        return "" if self.lockstep else self.standing.odometry_is_old()

    def _command(self, now: int, v: float, w: float) -> None:
        stamped = self.values["stamped"]
        self.velocity.publish(messages.twist_stamped(now, "base_link", v, w) if stamped else messages.twist(v, w))
        self._note(now, COMMANDS, (v, w))

    def leave(self) -> None:
        """Let the robot stand; then as :meth:`Identifier.leave`."""
        if self.begin is not None:
            if not self.done:
                self.done, self.why = True, "it was told to end"
                now = max(self.told["v"]) if self.lockstep else self.get_clock().now().nanoseconds
                self._command(now, 0.0, 0.0)
            self.velocity.wait_for_all_acked(Duration(seconds=0.5))
        super().leave()


def _program(file: str) -> Program:
    """The commands of a file. Raises DataError, or ParameterError for times that do not grow."""
    time, v, w = read_table(Path(file), columns=["time", "v_command", "w_command"]).values.T
    if not (np.diff(time) > 0).all():
        raise ParameterError(f"{file}: its times do not grow")
    return Program(time - time[0], v, w)
