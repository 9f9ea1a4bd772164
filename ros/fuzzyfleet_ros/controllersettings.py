"""The parameters of the controller, and the tasks that they describe: a scenario's, or along way-points that come."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from math import atan2, hypot, inf
from typing import Any

from fuzzyfleet_ros.names import scenario_of
from fuzzyfleet_ros.onboard import Onboard
from fuzzyfleet_ros.parameters import Parameter, ParameterError
from robotics.laws.law import Law
from robotics.laws.setting import Setting
from robotics.simulation.scenario.description import Member, Scenario
from robotics.simulation.scenario.robots import RobotModel, load_robot, standard_robot
from robotics.world.paths.path import Waypoints
from robotics.world.paths.trajectory import Timing

_SETTLE = 2.0  # s that a robot may take after the reference has arrived
_NEAREST = 1e-3  # m: points closer than this to the one before are taken for the same
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
    Parameter("w_max", 0.0, "A bound of the turn rate [rad/s] beside the robot's own; 0: none.", 0, 100),
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


def thinned(points: Sequence[tuple[float, float]], spacing: float) -> tuple[tuple[float, float], ...]:
    """Those of ``points`` [m] that are at least ``spacing`` [m] from the one kept before, and the last one."""
    kept: list[tuple[float, float]] = []
    for point in points:
        if not kept or hypot(point[0] - kept[-1][0], point[1] - kept[-1][1]) >= max(spacing, _NEAREST):
            kept.append(point)
    if points and kept[-1] != points[-1]:
        if len(kept) > 1:
            kept[-1] = points[-1]
        elif hypot(points[-1][0] - kept[0][0], points[-1][1] - kept[0][1]) >= _NEAREST:
            kept.append(points[-1])
    return tuple(kept)


def setting_along(
    points: Sequence[tuple[float, float]],
    model: RobotModel,
    speed: float,
    *,
    ramp: float = 1.0,
    spacing: float = 0.05,
    period: float = 0.05,
) -> Setting:
    """Compile the task of following a spline through way-points at a constant speed.

    Args:
        points: The way-points x, y [m], two or more.
        model: The robot.
        speed: Along the path, between the ramps [m/s].
        ramp: The time in which the speed rises at the start, and in which it falls at the end [s].
        spacing: Points closer than this to the one before are left out [m].
        period: The control period, a multiple of 10 ms [s].

    Raises PathError, or ScenarioError where no command of the robot can follow.
    """
    shape = Waypoints(points=thinned(points, spacing))
    (x0, y0), (x1, y1) = shape.points[:2]
    member = Member(
        start=(x0, y0, atan2(y1 - y0, x1 - x0)),
        path=shape,
        timing=Timing(speed=speed, ramp=ramp),
        robot=model.robot,
        model=model,
    )
    described = Scenario(name="path", robots=(member,), period=period)
    end = float(described.trajectory.ends[0]) + _SETTLE
    return replace(described, duration=max(period, round(end / period) * period)).setting
