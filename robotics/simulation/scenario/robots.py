"""Robots as data: files that describe one with what it carries, packaged ones by name, and tables that change one."""

import re
from collections.abc import Mapping
from dataclasses import dataclass, field, fields
from functools import cache
from pathlib import Path
from typing import Any

from fuzzy.errors import concerning
from fuzzy.files.atomic import write_whole
from fuzzy.naming import expected
from fuzzy.quantity import described
from robotics.tables.build import Builder, Keys
from robotics.tables.files import TomlFile, TomlFiles, placed_beside
from robotics.tables.text import reading
from robotics.world.sensing.sonar import SENSOR_PRESETS, RangeSensor, lidar, sonar
from robotics.world.vehicle.robot import Robot, RobotError, merged, missing_numbers
from robotics.world.vehicle.wheel_loop import Gains

STANDARD = "etsro"  # the robot of a scenario that names none
PRESET_KEYS = ("name", "preset", "prefix", "beams", "span")  # those that are no fields of RangeSensor
SCANNER = ("beams", "span", "axis")  # of the preset "lidar", whose beams have no axis in common


@dataclass(frozen=True, kw_only=True)
class RobotModel:
    """A robot as a file describes it: its numbers, and the range sensors that it carries.

    Attributes:
        name: The name of its file.
    """

    name: str
    title: str = described("What it is, in a line.", "")
    source: str = described("Where its numbers come from.", "")
    robot: Robot = field(metadata={"doc": "Its numbers."})
    sensors: Mapping[str, RangeSensor] = described("The range sensors that it carries, by name.", default_factory=dict)


_FILES = TomlFiles("robots", "robot", RobotError)


def robot_names() -> list[str]:
    """The names of the robots that come with the package."""
    return _FILES.names()


def load_robot(name: str | Path, folder: Path = Path()) -> RobotModel:
    """Read the robot of that name, or a ``.toml`` file.

    Args:
        name: A name of :func:`robot_names`, or the path of a file.
        folder: Where a relative path is looked for first; then in the current folder.

    Returns:
        Its numbers and its sensors.

    Raises:
        RobotError: No such robot, or a file that makes none; the message names file, line and key.
    """
    if str(name) in robot_names():
        return _packaged(str(name))
    found = robot_file(name, folder)
    return parse_robot(found.text, found.name, found.file)


def standard_robot() -> RobotModel:
    """The robot of a scenario that names none; no folder is listed for it, since every member of a team asks."""
    return _packaged(STANDARD)


def robot_file(name: str | Path, folder: Path = Path()) -> TomlFile:
    """The file that describes a robot; the arguments are as of :func:`load_robot`. Raises RobotError."""
    return _FILES.find(name, folder)


def with_numbers(text: str, numbers: Mapping[str, float]) -> str:
    """The ``text`` of a robot's file with other ``numbers``, by the names of fields; comments stay as they are.

    A number that the file does not give is added before its first table.
    """
    lines = text.splitlines()
    end = next((k for k, line in enumerate(lines) if line.lstrip().startswith("[")), len(lines))
    while end and not lines[end - 1].split("#")[0].strip():  # comments and empty lines before it belong to the table
        end -= 1
    for name, value in numbers.items():
        pattern = re.compile(rf"^(\s*{re.escape(name)}\s*=\s*)[^#\s]+")
        places = [k for k in range(end) if pattern.match(lines[k])]
        if places:
            lines[places[0]] = pattern.sub(rf"\g<1>{value!r}", lines[places[0]])
        else:
            lines.insert(end, f"{name} = {value!r}")
            end += 1
    return "\n".join(lines) + "\n"


def write_tuned(name: str | Path, gains: Gains, target: Path, force: bool = False) -> None:
    """Write a copy of a robot's file with other gains of its wheel loop; comments stay as they are.

    Args:
        name: As of :func:`load_robot`.
        gains: The gains.
        target: The file to write, whole or not at all.
        force: Whether a file that is there already is overwritten.

    Raises RobotError where there is a file already, and OSError where none can be written.
    """
    file = robot_file(name)
    if target.suffix != ".toml":
        raise RobotError(f"{target}: the file of a robot ends in .toml")
    if str(name) in robot_names() and target.exists() and target.samefile(file.path):
        raise RobotError(f"{target} is the packaged file itself: write another one")
    if target.exists() and not force:
        raise RobotError(f"{target} exists already, nothing was written; --force overwrites")
    changed = {key: value for key, value in gains._asdict().items() if value or key != "kd"}
    write_whole(target, with_numbers(file.text, changed))


@cache
def _packaged(name: str) -> RobotModel:
    found = robot_file(name)
    return parse_robot(found.text, found.name, found.file)


def parse_robot(text: str, name: str, file: str = "<text>") -> RobotModel:
    """Make the robot that a TOML text describes. Raises RobotError.

    Args:
        text: The TOML text.
        name: The name of the robot.
        file: The name of the file in messages.
    """
    with reading(text, file, RobotError) as table:
        numbers = {key: value for key, value in table.items() if key not in ("title", "source", "sensors")}
        robot: Robot = _BUILDER.build(Robot, numbers, (), ("title", "source", "sensors"))
        sensors = sensors_from_table(table.get("sensors", []), ("sensors",), _BUILDER, robot)
        said: dict[str, Any] = {key: table[key] for key in ("title", "source") if key in table}
        model: RobotModel = _BUILDER.build(RobotModel, said, (), name=name, robot=robot, sensors=sensors)
        return model


def sensors_from_table(value: Any, keys: Keys, builder: Builder, robot: Robot) -> dict[str, RangeSensor]:
    """Read range sensors by name: one table for each, or one for all of a preset, whose fields it may change.

    The sonars of the preset "sonar" sit on the outline of the robot that carries them. A lidar may have another number
    of ``beams`` and another ``span`` [rad], and be turned by ``axis`` [rad]. A ``prefix`` begins the names of a
    preset's sensors, so that a robot can carry two of them.

    Args:
        value: What stands in the file.
        keys: Its place in the file.
        builder: Makes the dataclasses; its errors are raised.
        robot: The robot that carries them.
    """
    found: dict[str, RangeSensor] = {}
    for i, row in enumerate(builder.tables(value, keys)):
        made = _sensors(row, (*keys, i), builder, robot)
        for name in made:
            if name in found:
                raise builder.fault(f"there are two sensors called {name!r}").about(*keys, i)
        found |= made
    return found


def _sensors(row: dict[str, Any], at: Keys, builder: Builder, robot: Robot) -> dict[str, RangeSensor]:
    own = {key: value for key, value in row.items() if key not in ("name", "preset", "prefix")}
    if "preset" not in row:
        name = row.get("name")
        if not isinstance(name, str) or not name:
            text = f'a sensor needs a name such as "rear", or preset, one of {", ".join(SENSOR_PRESETS)}'
            raise builder.fault(text).about(*at)
        if "prefix" in row:
            raise builder.fault("prefix belongs to a preset, whose sensors' names it begins").about(*at, "prefix")
        return {name: builder.build(RangeSensor, own, at, PRESET_KEYS)}
    preset, prefix = row["preset"], row.get("prefix", "")
    if "name" in row or not isinstance(preset, str) or preset not in SENSOR_PRESETS:
        what = expected(str(preset), SENSOR_PRESETS, "sensor preset")
        raise builder.fault(what if "name" not in row else "give name or preset, not both").about(*at, "preset")
    if not isinstance(prefix, str):
        raise builder.fault(f"prefix must be text in quotes; got {prefix!r}").about(*at, "prefix")
    sensors = SENSOR_PRESETS[preset]
    if preset == "sonar":
        sensors = sonar(robot.length, robot.width)
    elif preset == "lidar":
        with concerning(*at):
            sensors = lidar(**{key: own.pop(key) for key in SCANNER if key in own})
    return {
        prefix + name: builder.build(
            RangeSensor, {k: v for k, v in vars(sensor).items() if v is not None} | own, at, PRESET_KEYS
        )
        for name, sensor in sensors.items()
    }


@dataclass(frozen=True)
class RobotChoice:
    """What a scenario's file says of a robot: its model, if it names one, and the numbers that it changes or gives."""

    model: RobotModel | None
    numbers: Mapping[str, Any]
    robot: Robot  # of these, and what follows from them


def chosen_robot(base: RobotChoice | None, value: Any, keys: Keys, builder: Builder, folder: Path) -> RobotChoice:
    """Read what stands in a scenario's file as ``robot``: a name, the path of a file, or a table.

    A table changes the ``model`` that it names, or the robot that all share, and is a whole robot otherwise. Numbers
    are changed before others are derived from them.

    Args:
        base: What the file says of all robots, if it does.
        value: What stands in the file.
        keys: Its place in the file.
        builder: Makes the robot; its errors are raised.
        folder: Where the paths of files are looked for first; then in the current folder.
    """
    if isinstance(value, str):
        try:
            named = load_robot(value, folder)
        except RobotError as error:
            raise builder.fault(str(error)).about(*keys) from None
        return RobotChoice(named, {}, named.robot)
    if not isinstance(value, dict):
        what = f'robot must be a name such as "{STANDARD}", the path of a .toml file, or a table'
        raise builder.fault(f"{what}; got {value!r}").about(*keys)
    numbers = {key: number for key, number in value.items() if key != "model"}
    if "model" in value:
        at = (*keys, "model")
        if not isinstance(value["model"], str):
            what = f'model must be the name of a robot, such as "{STANDARD}", or the path of a .toml file'
            raise builder.fault(f"{what}; got {value['model']!r}").about(*at)
        base = chosen_robot(None, value["model"], at, builder, folder)
    known = {f.name for f in fields(Robot)}
    lacking = missing_numbers(numbers)
    if base is None and lacking and numbers.keys() <= known:
        what = f"robot is neither whole, it lacks {', '.join(lacking)}, nor does it name the model that it changes"
        raise builder.fault(f'{what}: model = "{STANDARD}" changes the EtsRo').about(*keys)
    model = base.model if base else None
    numbers = merged(base.numbers, numbers) if base else numbers
    whole = merged(model.robot.given, numbers) if model else numbers
    return RobotChoice(model, numbers, builder.build(Robot, whole, keys, ("model",)))


def robot_tables(table: Mapping[str, Any]) -> dict[str, Any]:
    """A scenario's ``table`` in which every robot is a table that names its model, so that its numbers can be set."""
    found = {"robot": {"model": STANDARD}, **table}
    if isinstance(found["robot"], str):
        found["robot"] = {"model": found["robot"]}
    members = found.get("robots")
    if isinstance(members, list):
        found["robots"] = [
            {**each, "robot": {"model": each["robot"]}}
            if isinstance(each, dict) and isinstance(each.get("robot"), str)
            else each
            for each in members
        ]
    return found


def robot_files(table: Mapping[str, Any], folder: Path) -> dict[str, Path]:
    """The files of robots that a scenario's ``table`` names, by what it calls them; ``folder`` is that of its file."""
    members = table.get("robots")
    places = [table, *(members if isinstance(members, list) else ())]
    said = [each.get("robot") for each in places if isinstance(each, dict)]
    names = [each.get("model") if isinstance(each, dict) else each for each in said]
    files = [name for name in names if isinstance(name, str) and name.endswith(".toml")]
    return {name: placed_beside(Path(name), folder) for name in files}


_BUILDER = Builder(RobotError)
