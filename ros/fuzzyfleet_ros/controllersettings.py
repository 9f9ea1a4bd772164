"""The parameters of the controller, and the tasks that they describe: a scenario's, or along a path that comes."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from math import inf
from typing import Any

from fuzzyfleet_ros.alongpath import setting_along
from fuzzyfleet_ros.names import scenario_of
from fuzzyfleet_ros.onboard import Onboard
from fuzzyfleet_ros.parameters import Parameter, ParameterError
from robotics.laws.law import Law
from robotics.simulation.scenario.robots import RobotModel, load_robot, standard_robot

PARAMETERS = (
    Parameter("law", "fuzzy", "The law, as the command line names it: fuzzy, csm:k=0.3, mine.fis, mylaw.py:MyLaw."),
    Parameter("scenario", "", "A scenario's name or .toml file; empty: the path comes on path_topic."),
    Parameter("robot", "", "A robot's name or .toml file; empty: the scenario's, or else the EtsRo."),
    Parameter("member", 1, "Which robot of the scenario this is.", 1, 10_000),
    Parameter("rate", 0.0, "Decisions a second [Hz]; a period is a multiple of 10 ms; 0: the scenario's.", 0, 100),
    Parameter("lockstep", False, "Decide once for each period of the simulator, instead of by the clock."),
    Parameter("stamped", True, "Whether the velocity is a TwistStamped, or a Twist."),
    Parameter("odom_timeout", 0.5, "The age of odometry [s] at which the robot is let stand; 0: never.", 0, 60),
    Parameter("range_timeout", 1.0, "The same for the readings that the law needs [s]; 0: never.", 0, 60),
    Parameter("reference_waits", True, "Whether the reference waits while the robot stands."),
    Parameter("v_max", 0.0, "A bound of the speed [m/s] beside the robot's own; 0: none.", 0, 100),
    Parameter("w_max", 0.0, "A bound of the angular velocity [rad/s] beside the robot's own; 0: none.", 0, 100),
    Parameter("torque_as_velocity", False, "Let a law of torques drive by the velocity that it tries to reach."),
    Parameter("origin", "odom", "odom: paths are in odometry's frame; start: the robot stands where its path begins.",
              one_of=("odom", "start")),
    Parameter("radio", "relayed", "relayed: by the simulator, on heard; direct: from the other robots' radio topics.",
              one_of=("relayed", "direct")),
    Parameter("path_speed", 0.2, "The speed along a path that comes [m/s].", 0.001, 10),
    Parameter("path_ramp", 1.0, "The time in which that speed rises and falls [s].", 0, 60),
    Parameter("path_spacing", 0.05, "Points of a path closer than this to the one before are left out [m].", 0, 10),
    Parameter("odom_topic", "odom", "The topic of nav_msgs/Odometry."),
    Parameter("cmd_vel_topic", "cmd_vel", "The topic of the velocity."),
    Parameter("path_topic", "path", "The topic of nav_msgs/Path."),
    Parameter("range_topic", "range", "What the topics of sensor_msgs/Range begin with; then / and the sensor's name."),
    Parameter("odom_frame", "", "The frame of odometry and of paths; empty: odom, in a team robot1/odom."),
    Parameter("base_frame", "", "The frame of the robot; empty: base_link, in a team robot1/base_link."),
)  # fmt: skip


def check(values: Mapping[str, Any]) -> None:
    """Raise ParameterError for parameters that do not suit each other."""
    if values["lockstep"] and not values["stamped"]:
        raise ParameterError("lockstep needs stamped, because the simulator tells commands by their time")
    if values["lockstep"] and values["radio"] == "direct":
        raise ParameterError("lockstep needs radio relayed, because only the simulator knows when messages arrive")
    if values["lockstep"] and not values["scenario"]:
        raise ParameterError("lockstep needs a scenario")
    if not values["scenario"] and values["member"] != 1:
        raise ParameterError("member names a robot of a scenario, and no scenario is given")
    if rate := values["rate"]:
        steps = 100 / rate
        if abs(steps - round(steps)) > 1e-6:
            raise ParameterError(f"rate must be 100 Hz divided by a whole number, such as 20 or 50; got {rate:g}")


def scenario_task(values: Mapping[str, Any], law: Law[Any]) -> Onboard:
    """The task of a scenario's robot. Raises what a scenario that cannot be read raises, and OnboardError."""
    scenario = scenario_of(values["scenario"], values["robot"], values["rate"])
    return _onboard(scenario.setting, law, values)


def _onboard(setting: Any, law: Law[Any], values: Mapping[str, Any]) -> Onboard:
    return Onboard.of(
        setting,
        law,
        values["member"] - 1,
        v_max=values["v_max"] or inf,
        w_max=values["w_max"] or inf,
        torque_as_velocity=values["torque_as_velocity"],
        scales=not values["lockstep"],
    )


@dataclass(frozen=True)
class PathTask:
    """How to follow a path that comes."""

    values: Mapping[str, Any]
    law: Law[Any]
    model: RobotModel

    @classmethod
    def of(cls, values: Mapping[str, Any], law: Law[Any]) -> "PathTask":
        """As the parameters say. Raises RobotError for the robot."""
        return cls(values, law, load_robot(values["robot"]) if values["robot"] else standard_robot())

    def along(self, points: Sequence[tuple[float, float]]) -> Onboard:
        """The task of following ``points`` [m]. Raises PathError, ScenarioError, OnboardError or ControllerError."""
        setting = setting_along(
            points,
            self.model,
            self.values["path_speed"],
            ramp=self.values["path_ramp"],
            spacing=self.values["path_spacing"],
            period=1 / (self.values["rate"] or 20.0),
        )
        return _onboard(setting, self.law, self.values)

    def rehearse(self) -> None:
        """Follow a straight line in thought, so that what cannot be driven is said before a path comes."""
        self.along([(0.0, 0.0), (1.0, 0.0)]).rehearse()
