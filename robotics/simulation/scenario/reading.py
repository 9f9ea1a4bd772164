"""Reading scenario files: TOML into :class:`robotics.simulation.scenario.description.Scenario`.

Any fault of a file is a ScenarioError that names the file, the line, the field and what is accepted.
"""

from pathlib import Path as FilePath
from typing import Any

from fuzzy.errors import InputError, concerning
from fuzzy.naming import expected
from robotics.laws.catalogue import located, make_controller
from robotics.laws.foreign import checked_init
from robotics.laws.law import check_needs
from robotics.simulation.scenario.description import Member, Scenario, ScenarioError, VirtualRobot
from robotics.simulation.scenario.robots import RobotChoice, chosen_robot, sensors_from_table, standard_robot
from robotics.tables.build import Builder, Keys, plain_value
from robotics.tables.files import TomlFile, TomlFiles, placed_beside
from robotics.tables.text import reading
from robotics.world.environment.world import OBSTACLES, Obstacle
from robotics.world.paths.goal import Goal
from robotics.world.paths.offset import Offset, offset_start
from robotics.world.paths.path import Shape, shapes
from robotics.world.radio.description import RADIO_PRESETS, Radio, RadioError

ALSO = ("robot", "robots", "sensors", "virtual")  # what a file may say beside the fields of Scenario


_FILES = TomlFiles("scenarios", "scenario", ScenarioError)


def scenario_names(kind: str | None = None) -> list[str]:
    """The names of the scenarios that come with the package.

    Args:
        kind: Only those of one kind, such as "team".
    """
    names = _FILES.names()
    return names if kind is None else [name for name in names if load_scenario(name).kind == kind]


def load_scenario(name: str | FilePath, beside: FilePath = FilePath()) -> Scenario:
    """Read a scenario.

    Args:
        name: One of :func:`scenario_names`, or a ``.toml`` file.
        beside: The folder in which a file is looked for first.

    Returns:
        The scenario.

    Raises:
        ScenarioError: No such scenario, or a file that makes none; the message names file, line and key.
    """
    found = _FILES.find(str(name), beside)
    return parse_scenario(found.text, found.name, found.file, found.folder)


def scenario_file(name: str | FilePath, beside: FilePath = FilePath()) -> TomlFile:
    """The file from which :func:`load_scenario` reads. Raises ScenarioError."""
    return _FILES.find(str(name), beside)


def parse_scenario(text: str, name: str, file: str = "<text>", folder: FilePath | None = None) -> Scenario:
    """The scenario that a TOML text describes.

    Args:
        text: The TOML text.
        name: The name of the scenario.
        file: The name of the file in messages.
        folder: Where files of robots and those that ``controller`` names are looked for first; by default in the folder
            of ``file``. Then in the current one.

    Raises:
        ScenarioError: A text that makes no scenario; the message names line and key.
    """
    with reading(text, file, ScenarioError) as table:
        return scenario_from_table(table, name, FilePath(file).parent if folder is None else folder)


def scenario_from_table(table: dict[str, Any], name: str, folder: FilePath = FilePath()) -> Scenario:
    """Make the scenario called ``name`` of a TOML file's ``table``, which is left as it is.

    The files of robots, and those that its controller and its metrics name, are looked for in ``folder`` before the
    current one.
    Raises an InputError whose ``at`` holds the keys of the table that it is about.
    """
    rest = dict(table)
    if isinstance(rest.get("controller"), str):
        rest["controller"] = located(rest["controller"], folder)
    if (metrics := plain_value("texts", rest.get("metrics"))) is not None:
        rest["metrics"] = [located(metric, folder) for metric in metrics]
    common = None
    if "robot" in rest:
        common = chosen_robot(None, rest.pop("robot"), ("robot",), _BUILDER, folder)
    shared = rest.pop("sensors", None)
    members = rest.pop("robots", [])
    if not (isinstance(members, list) and members):
        raise ScenarioError("at least one [[robots]] table is needed").about("robots")
    virtual: VirtualRobot | None = None
    if "virtual" in rest:
        table = _placed(_BUILDER.table(rest.pop("virtual"), ("virtual",)), folder)
        virtual = _BUILDER.build(VirtualRobot, table, ("virtual",))
    robots = tuple(_member(m, ("robots", i), virtual, common, shared, folder) for i, m in enumerate(members))
    if virtual is not None and not any(isinstance(member.path, Offset) for member in robots):
        what = "no robot has an offset from the virtual robot, such as offset = [0.0, 0.5]"
        raise ScenarioError(what).about("virtual")
    scenario: Scenario = _BUILDER.build(Scenario, rest, (), ALSO, name=name, robots=robots, sensors=None)
    if scenario.controller:
        try:  # its gains may not suit the graph, its messages not the radio
            law = make_controller(scenario.controller)
            check_needs(scenario.setting, law)
            checked_init(law, scenario.setting, 1)
            scenario.radio.check_bandwidth(len(robots), len(law.message))
        except RadioError as error:
            raise error.about("radio") from None
        except InputError as error:
            raise error.about("controller") from None
    return scenario


def _member(
    value: Any, keys: Keys, virtual: VirtualRobot | None, common: RobotChoice | None, shared: Any, folder: FilePath
) -> Member:
    """A robot of a file, which says of all of them which robot is ``common`` and which sensors are ``shared``."""
    table = _placed(_BUILDER.table(value, keys), folder)
    choice = common
    if "robot" in table:
        choice = chosen_robot(choice, table.pop("robot"), (*keys, "robot"), _BUILDER, folder)
    choice = choice or RobotChoice(standard_robot(), {}, standard_robot().robot)
    given: dict[str, Any] = {"robot": choice.robot, "model": choice.model}
    at, carried = (keys, table.pop("sensors")) if "sensors" in table else ((), shared)
    if carried is not None:
        given["sensors"] = sensors_from_table(carried, (*at, "sensors"), _BUILDER, choice.robot)
    if "offset" in table:
        return _offset_member(table, keys, virtual, given)
    if "goal" in table:
        return _goal_member(table, keys, given, folder)
    return _BUILDER.build(Member, table, keys, ("offset", "robot", "sensors"), **given)


def _placed(table: dict[str, Any], folder: FilePath) -> dict[str, Any]:
    """A table with a path, the file of which is looked for in ``folder`` first."""
    path = table.get("path")
    if isinstance(path, dict) and isinstance(path.get("file"), str):
        return table | {"path": path | {"file": str(placed_beside(FilePath(path["file"]), folder))}}
    return dict(table)


def _goal_member(table: dict[str, Any], keys: Keys, given: dict[str, Any], folder: FilePath) -> Member:
    """A robot with a goal, of which its path and its timing follow."""
    for key in ("path", "timing"):
        if key in table:
            raise ScenarioError(f"give goal or {key}, not both: one that moves has them in goal").about(*keys, key)
    at = (*keys, "goal")
    goal: Goal = _BUILDER.build(Goal, _placed(_BUILDER.table(table["goal"], at), folder), at)
    start = plain_value("pose", table.get("start")) or (0.0, 0.0, 0.0)  # what is none is refused below
    path, timing = goal.motion(start)
    return _BUILDER.build(Member, table, keys, ("offset", "robot", "sensors"), path=path, timing=timing, **given)


def _offset_member(table: dict[str, Any], keys: Keys, virtual: VirtualRobot | None, given: dict[str, Any]) -> Member:
    """A robot of a formation: its path follows from its offset; without a start it begins in its place."""
    at = (*keys, "offset")
    if virtual is None:
        what = "an offset needs a table [virtual] with the path and the timing it is measured from"
        raise ScenarioError(what).about(*at)
    for key in ("path", "timing"):
        if key in table:
            what = f"give offset or {key}, not both: in a formation it is that of [virtual]"
            raise ScenarioError(what).about(*keys, key)

    path: Offset = _BUILDER.build(Offset, {"offset": table.pop("offset")}, keys, path=virtual.path)
    with concerning(*at):
        start = offset_start(path, virtual.timing)
    table = {"start": list(start), **table}
    return _BUILDER.build(
        Member, table, keys, ("offset", "robot", "sensors"), path=path, timing=virtual.timing, **given
    )


def _radio(value: Any, keys: Keys) -> Radio:
    """Read the radio, of a preset whose fields it may change."""
    table = dict(_BUILDER.table(value, keys))
    if "preset" in table:
        preset = table.pop("preset")
        if not isinstance(preset, str) or preset not in RADIO_PRESETS:
            raise ScenarioError(expected(str(preset), RADIO_PRESETS, "radio preset")).about(*keys, "preset")
        table = {**RADIO_PRESETS[preset], **table}
    radio: Radio = _BUILDER.build(Radio, table, keys, ("preset",))
    return radio


def _path(value: Any, keys: Keys) -> Shape:
    made: Shape = _BUILDER.shaped(value, keys, shapes(), "path")
    return made


def _obstacles(value: Any, keys: Keys) -> tuple[Obstacle, ...]:
    rows = _BUILDER.tables(value, keys)
    return tuple(_BUILDER.shaped(row, (*keys, i), OBSTACLES, "an obstacle") for i, row in enumerate(rows))


_BUILDER = Builder(ScenarioError, {Shape: _path, Radio: _radio, tuple[Obstacle, ...]: _obstacles})
