"""The conditions of a trial that its scenario leaves to the user: another robot, no noise, and what laws are given."""

import tomllib
from contextlib import suppress
from dataclasses import replace
from functools import lru_cache
from pathlib import Path, PurePath
from typing import Any

from fuzzy.errors import InputError
from fuzzy.naming import check_known
from robotics.laws.knowledge import Knowledge
from robotics.laws.specification import Specification
from robotics.plugins.designer.uses import TryoutError
from robotics.simulation.scenario import robots as models
from robotics.simulation.scenario.description import Member, Scenario, ScenarioError
from robotics.simulation.scenario.reading import load_scenario, scenario_file, scenario_from_table, scenario_names
from robotics.simulation.scenario.robots import RobotModel, load_robot, parse_robot, robot_names
from robotics.tables.text import reading
from robotics.world.sensing.posture import KALMAN, Sensing

# What every law that can use it is given, by how a trial calls it; "": what the scenario says
GIVEN_TO_LAWS: dict[str, tuple[Knowledge, str | None]] = {
    "lead": (Knowledge(lead="auto"), None),
    "lead, low-pass": (Knowledge(lead="auto", smooth=0.2), None),
    "lead, low-pass, filter": (Knowledge(lead="auto", smooth=0.2), KALMAN),
}


def scenario_of(name: str, text: str | None, folder: str = "") -> Scenario:
    """The scenario called ``name`` of the package, or that of a ``text``.

    Args:
        name: The scenario of the package, or the name of the file that holds ``text``.
        text: That of a scenario file.
        folder: The opened folder, in which alone the files of robots are looked for that the text names.

    Raises ScenarioError or TryoutError.
    """
    return _scenario(name, text, folder, _states(name, text, folder))


# The user's files are read anew when they change; a scenario that is read stays, which takes longer than a drag may.
@lru_cache(maxsize=64)
def _scenario(name: str, text: str | None, folder: str, _: object) -> Scenario:
    if text is not None:
        with reading(text, file_name(name), ScenarioError) as table:
            return scenario_from_table(_without_files(table), PurePath(name).stem, _home(name, folder))
    check_known(name, scenario_names(), "scenario", TryoutError)
    return load_scenario(name)


def _home(name: str, folder: str) -> Path:
    """The folder in which a scenario's file stands."""
    return Path(folder) / PurePath(name).parent


def _states(name: str, text: str | None, folder: str) -> tuple[object, ...]:
    """The robots' files that a scenario names, and when they were changed last [ns]."""
    found = []
    for path in () if text is None else _named_robots(name, text, folder):
        with suppress(OSError):
            found.append((path, path.stat().st_mtime_ns))
    return tuple(found)


@lru_cache(maxsize=64)
def _named_robots(name: str, text: str, folder: str) -> tuple[Path, ...]:
    """The robots' files that a scenario names. Raises TryoutError for one that is not in the opened folder."""
    try:
        table = tomllib.loads(text)
    except (ValueError, RecursionError):  # it is said where the text is read
        return ()
    home, found = _home(name, folder), []
    for said in models.robot_files(table, home):
        path = (home / said).resolve()
        if folder and not (path.is_relative_to(folder) and path.is_file()):
            raise TryoutError(f"{file_name(name)}: there is no robot {said!r} in the opened folder")
        found.append(path)
    return tuple(found)


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
    check_known(name, names, what, TryoutError)
    return (scenario_file if what == "scenario" else models.robot_file)(name).text


def conditioned(
    file: tuple[str, str | None, str], driver: tuple[str, str | None, int], noise: bool, given: str = ""
) -> Scenario:
    """A scenario under the conditions of a trial. Raises ScenarioError, RobotError or TryoutError.

    Args:
        file: As of :func:`scenario_of`: the scenario of the package, or a file's name and its text; and the folder.
        driver: Empty: as the scenario says; else a robot of the package, or a file's name, and its text; and the number
            of the robot that is another, from 1; 0: all of them.
        noise: Whether there is noise, see :func:`exact`.
        given: What laws are given, a name in GIVEN_TO_LAWS; empty: as the scenario says.
    """
    return _conditioned(file, driver, noise, given, _states(*file))


@lru_cache(maxsize=64)
def _conditioned(
    file: tuple[str, str | None, str], driver: tuple[str, str | None, int], noise: bool, given: str, _: object
) -> Scenario:
    scenario = scenario_of(*file)
    name, text, number = driver
    if name:
        scenario = with_robot(scenario, robot_from(name, text), number)
    scenario = scenario if noise else exact(scenario)
    if not given:
        return scenario
    knowledge, estimator = GIVEN_TO_LAWS[given]
    joined = scenario.sensing.joined_by(estimator if scenario.sensing.posture == "pose" else None)
    return replace(scenario, knowledge=knowledge, sensing=joined)


def with_robot(scenario: Scenario, model: RobotModel, number: int = 0) -> Scenario:
    """The scenario with another robot in the place of one, its ``number`` (from 1), or of all (0).

    It carries its own range sensors, unless the scenario says what robots carry. Raises TryoutError where it cannot
    drive there.
    """
    count = len(scenario.robots)
    if number > count:
        raise TryoutError(f"{scenario.name} has the robots 1 to {count}; there is no robot {number}")
    members: list[Member] = [
        replace(member, robot=model.robot, model=model) if number in (0, i) else member
        for i, member in enumerate(scenario.robots, 1)
    ]
    try:
        return replace(scenario, robots=tuple(members))
    except InputError as error:
        raise TryoutError(f"{scenario.name} cannot be driven with the robot {model.name}: {error}") from None


@lru_cache(maxsize=64)
def robot_from(name: str, text: str | None) -> RobotModel:
    """The robot called ``name`` of the package, or that of a ``text``. Raises RobotError or TryoutError."""
    if text is not None:
        return parse_robot(text, PurePath(name).stem, file_name(name))
    check_known(name, robot_names(), "robot", TryoutError)
    return load_robot(name)


# Without noise --------------------------------------------------------------------------------------------------


def exact(scenario: Scenario) -> Scenario:
    """The same scenario without noise: nothing in it is drawn at random but the time of a fault.

    Poses and ranges are measured exactly and no echo is lost; wheels, axle and start are as the robot believes them to
    be; no message is lost or late by chance. Encoders still count whole steps; latencies, ranges, failures of a sensor
    and faults stay.
    """
    carried = [
        {n: replace(s, noise=0.0, relative_noise=0.0, dropout=0.0, crosstalk=0.0) for n, s in sensors.items()}
        for sensors in scenario.setting.sensors
    ]
    robots = tuple(
        replace(member, sensors=sensors, sensing=member.sensing and Sensing(posture=member.sensing.posture))
        for member, sensors in zip(scenario.robots, carried, strict=True)
    )
    radio = replace(scenario.radio, jitter=0.0, loss=0.0, burst_start=0.0)
    return replace(scenario, robots=robots, sensing=Sensing(posture=scenario.sensing.posture), radio=radio)
