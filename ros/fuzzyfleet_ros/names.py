"""The names of topics and frames: a single robot has no namespace, robot 2 of a team has ``robot2``."""

from dataclasses import replace

from robotics.simulation.scenario.description import Scenario
from robotics.simulation.scenario.reading import load_scenario
from robotics.simulation.scenario.robots import load_robot


def robot_name(robot: int) -> str:
    """The namespace of a team's robot, counted from 0."""
    return f"robot{robot + 1}"


def prefix(robot: int, robots: int) -> str:
    """What the topics and frames of a robot, counted from 0, of so many begin with."""
    return "" if robots == 1 else f"{robot_name(robot)}/"


def scenario_of(name: str, robot: str = "", rate: float = 0.0, duration: float = 0.0) -> Scenario:
    """A scenario by its name or file, with other robots, another rate [Hz] or duration [s] where these are given.

    Raises ScenarioError, RobotError or RadioError.
    """
    scenario = load_scenario(name)
    if robot:
        model = load_robot(robot)
        members = [replace(member, robot=model.robot, model=model) for member in scenario.robots]
        scenario = replace(scenario, robots=tuple(members))
    if rate:
        scenario = replace(scenario, period=1 / rate)
    return replace(scenario, duration=duration) if duration else scenario
