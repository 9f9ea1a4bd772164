"""The conditions of a trial that its scenario leaves to the user: with another robot, and without noise."""

from dataclasses import replace
from functools import lru_cache
from importlib import resources
from math import degrees
from pathlib import PurePath
from typing import Any

from fuzzy.errors import InputError
from fuzzy.naming import expected
from robotics.designer.uses import TryoutError
from robotics.laws.specification import Specification
from robotics.scenario.description import Member, Scenario, ScenarioError
from robotics.scenario.reading import load_scenario, scenario_from_table, scenario_names
from robotics.sensing.posture import Sensing
from robotics.sensing.sonar import RangeSensor
from robotics.tables.build import Builder
from robotics.tables.text import parse_table, placed
from robotics.vehicle.robot import Robot, RobotError


# The user's files are read anew when they change; a scenario that is read stays, which takes longer than a drag may.
@lru_cache(maxsize=64)
def scenario_of(name: str, text: str | None) -> Scenario:
    """The scenario called ``name`` of the package, or that of a ``text``. Raises ScenarioError or TryoutError."""
    if text is not None:
        table = parse_table(text, file_name(name), ScenarioError)
        with placed(text, file_name(name), ScenarioError):
            return scenario_from_table(_without_files(table), PurePath(name).stem)
    if name not in scenario_names():
        raise TryoutError(expected(name, scenario_names(), "scenario"))
    return load_scenario(name)


def _without_files(table: dict[str, Any]) -> dict[str, Any]:
    """A scenario's table whose controller names no file: choosing a scenario runs no Python, and reads nothing else.

    The law of a trial is chosen on the page.
    """
    controller = table.get("controller")
    if not isinstance(controller, str):
        return table
    said = Specification.of(controller)
    if said.file or "/" in said.gains or "\\" in said.gains or ".fis" in said.gains:
        return {**table, "controller": said.name if not said.file else ""}
    return table


def file_name(name: str) -> str:
    """The name of the file of a scenario or a robot, also of one that comes with the package."""
    return name if name.lower().endswith(".toml") else f"{name}.toml"


def packaged_text(what: str, name: str) -> str:
    """The text of a "scenario" or a "robot" that comes with the package. Raises TryoutError."""
    names = scenario_names() if what == "scenario" else robot_names()
    if name not in names:
        raise TryoutError(expected(name, names, what))
    return (resources.files("robotics") / f"{what}s" / f"{name}.toml").read_text(encoding="utf-8")


@lru_cache(maxsize=64)
def conditioned(
    name: str, text: str | None, robot: str, robot_text: str | None, robot_of: int, noise: bool
) -> Scenario:
    """A scenario under the conditions of a trial. Raises ScenarioError, RobotError or TryoutError.

    Args:
        name: The scenario of the package, or the name of the file that holds ``text``.
        text: That of a scenario file.
        robot: Empty: as the scenario says; else a robot of the package, or the name of the file with ``robot_text``.
        robot_text: That of a robot file.
        robot_of: The number of the robot that is another, from 1; 0: all of them.
        noise: Whether there is noise, see :func:`exact`.
    """
    scenario = scenario_of(name, text)
    if robot:
        scenario = with_robot(scenario, robot_from(robot, robot_text), robot, robot_of)
    return scenario if noise else exact(scenario)


def with_robot(scenario: Scenario, robot: Robot, name: str, number: int = 0) -> Scenario:
    """The scenario with another robot, called ``name``, in the place of one ``number`` (from 1), or of all (0).

    Raises TryoutError where it cannot drive there.
    """
    count = len(scenario.robots)
    if number > count:
        raise TryoutError(f"{scenario.name} has the robots 1 to {count}; there is no robot {number}")
    members: list[Member] = [
        replace(member, robot=robot) if number in (0, i) else member for i, member in enumerate(scenario.robots, 1)
    ]
    try:
        return replace(scenario, robots=tuple(members))
    except InputError as error:
        raise TryoutError(f"{scenario.name} cannot be driven with the robot {name}: {error}") from None


@lru_cache(maxsize=64)
def robot_from(name: str, text: str | None) -> Robot:
    """The robot called ``name`` of the package, or that of a ``text``. Raises RobotError or TryoutError."""
    if text is None:
        raise TryoutError(expected(name, robot_names(), "robot"))
    table = parse_table(text, file_name(name), RobotError)
    with placed(text, file_name(name), RobotError):
        robot: Robot = Builder(RobotError, {}).build(Robot, table.get("robot", table), ("robot",))
    return robot


def robot_names() -> list[str]:
    """The robots that come with the package, by name."""
    return []


# Without noise --------------------------------------------------------------------------------------------------


def exact(scenario: Scenario) -> Scenario:
    """The same scenario without noise: nothing in it is drawn at random but the time of a fault.

    Poses and ranges are measured exactly and no echo is lost; wheels, axle and start are as the robot believes them to
    be; no message is lost or late by chance. Encoders still count whole steps; latencies, ranges, failures of a sensor
    and faults stay.
    """
    carried = [{n: _exact_sensor(s) for n, s in sensors.items()} for sensors in scenario.setting.sensors]
    robots = tuple(
        replace(member, sensors=sensors, sensing=member.sensing and Sensing(posture=member.sensing.posture))
        for member, sensors in zip(scenario.robots, carried, strict=True)
    )
    radio = replace(scenario.radio, jitter=0.0, loss=0.0, burst_start=0.0)
    return replace(scenario, robots=robots, sensing=Sensing(posture=scenario.sensing.posture), radio=radio)


def _exact_sensor(sensor: RangeSensor) -> RangeSensor:
    return replace(sensor, noise=0.0, relative_noise=0.0, dropout=0.0, crosstalk=0.0)


def noises(scenario: Scenario) -> list[str]:
    """What :func:`exact` takes from a scenario, in words with the largest values; empty where there is no noise."""

    def most(name: str) -> float:
        return max(float(getattr(each, name)) for each in scenario.setting.sensing)

    found = [
        (most("position_noise"), "position ± {:g} mm", 1e3),
        (most("heading_noise"), "heading ± {:.2g}°", degrees(1)),
        (most("relative_noise"), "x and y ± {:g} %", 100),
        (max(most("wheel_error"), most("axle_error")), "wheels and axle ± {:g} %", 100),
        (most("start_position"), "start ± {:g} mm", 1e3),
        (most("start_heading"), "heading at the start ± {:.2g}°", degrees(1)),
    ]
    words = [text.format(round(size * factor, 6)) for size, text, factor in found if size > 0]
    carried = [sensor for sensors in scenario.setting.sensors for sensor in sensors.values()]
    if scenario.obstacles and any(s.noise or s.relative_noise or s.dropout or s.crosstalk for s in carried):
        words.append("range sensors")
    radio = scenario.radio
    if scenario.kind == "team" and (radio.loss or radio.burst_start):
        words.append("lost messages")
    if scenario.kind == "team" and radio.jitter:
        words.append(f"messages late by up to {radio.jitter:g} s")
    return words
