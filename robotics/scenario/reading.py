"""Reading scenario files: TOML into :class:`robotics.scenario.description.Scenario`.

Any fault of a file is a ScenarioError that names the file, the line, the field and what is accepted.
"""

from collections.abc import Mapping
from importlib import resources
from pathlib import Path as FilePath
from typing import Any

from fuzzy.errors import InputError
from fuzzy.naming import expected
from robotics.environment.world import Obstacle
from robotics.laws.catalogue import located, make_controller
from robotics.laws.foreign import begun
from robotics.laws.law import check_needs
from robotics.paths.offset import Offset, offset_start
from robotics.paths.path import SHAPES, PathError, Shape, compile_path
from robotics.paths.trajectory import Timing, compile_trajectory
from robotics.radio.description import PRESETS, Radio, RadioError
from robotics.scenario.description import Member, Scenario, ScenarioError
from robotics.scenario.obstacletable import obstacle_from_table
from robotics.scenario.renamed import current_name
from robotics.sensing.sonar import PRESETS as SENSOR_PRESETS
from robotics.sensing.sonar import RangeSensor
from robotics.tables.build import Builder, Keys, numbers
from robotics.tables.text import parse_table, placed, read_text
from robotics.vehicle.robot import Robot


def scenario_names(kind: str | None = None) -> list[str]:
    """The names of the scenarios that come with the package; with ``kind`` those of one kind, such as "team"."""
    folder = resources.files("robotics") / "scenarios"
    names = sorted(f.name.removesuffix(".toml") for f in folder.iterdir() if f.name.endswith(".toml"))
    return names if kind is None else [name for name in names if load_scenario(name).kind == kind]


def load_scenario(name: str | FilePath) -> Scenario:
    """Read the scenario of that name, or a ``.toml`` file. Raises ScenarioError; warns of an old name."""
    name = current_name(str(name))
    if name in scenario_names():
        file = resources.files("robotics") / "scenarios" / f"{name}.toml"
        return parse_scenario(file.read_text(encoding="utf-8"), name, f"{name}.toml")
    path = FilePath(name)
    if path.suffix != ".toml":
        raise ScenarioError(f"{expected(name, scenario_names(), 'scenario')}; or the path of a .toml file")
    return parse_scenario(read_text(path, ScenarioError), path.stem, str(path), path.parent)


def parse_scenario(text: str, name: str, file: str = "<text>", folder: FilePath | None = None) -> Scenario:
    """Make the scenario that a TOML text describes. Raises ScenarioError.

    Args:
        text: The TOML text.
        name: The name of the scenario.
        file: The name of the file in messages.
        folder: Where files that ``controller`` names are looked for before the current folder.
    """
    table = parse_table(text, file, ScenarioError)
    with placed(text, file, ScenarioError):
        return scenario_from_table(table, name, folder)


def scenario_from_table(table: dict[str, Any], name: str, folder: FilePath | None = None) -> Scenario:
    """Make the scenario called ``name`` of a TOML file's ``table``, which is left as it is.

    Files that its controller names are looked for in ``folder``, if one is given, before the current folder.

    Raises an InputError whose ``at`` holds the keys of the table that it is about.
    """
    rest = dict(table)
    common = rest.pop("robot", {})
    _BUILDER.table(common, ("robot",))
    if folder is not None and isinstance(rest.get("controller"), str):
        rest["controller"] = located(rest["controller"], folder)
    members = rest.pop("robots", [])
    if not (isinstance(members, list) and members):
        raise ScenarioError("at least one [[robots]] table is needed").about("robots")
    virtual = _virtual(rest.pop("virtual")) if "virtual" in rest else None
    robots = tuple(_member(m, common, ("robots", i), virtual) for i, m in enumerate(members))
    if virtual is not None and not any(isinstance(member.path, Offset) for member in robots):
        raise ScenarioError("no robot has an offset from the virtual robot, such as offset = [0.0, 0.5]").about(
            "virtual"
        )
    scenario: Scenario = _BUILDER.build(Scenario, rest, (), ("robot", "robots", "virtual"), name=name, robots=robots)
    if scenario.controller:
        try:  # its gains may not suit the graph, its messages not the radio
            law = make_controller(scenario.controller)
            check_needs(scenario.setting, law)
            begun(law, scenario.setting, 1)
            scenario.radio.check_bandwidth(len(robots), len(law.message))
        except RadioError as error:
            raise error.about("radio") from None
        except InputError as error:
            raise error.about("controller") from None
    return scenario


def _virtual(table: Any) -> tuple[Shape, Timing]:
    """The path and the timing of a formation's virtual robot, thesis (3.3)."""
    keys = ("virtual",)
    _BUILDER.table(table, keys)
    for key in table:
        if key not in ("path", "timing"):
            raise ScenarioError(expected(key, ("path", "timing"), "key")).about(*keys, key)
    if "timing" not in table:
        raise ScenarioError("the virtual robot needs a timing, such as timing = { duration = 30.0 }").about(*keys)
    path = _path(table, keys)
    _BUILDER.table(table["timing"], (*keys, "timing"))
    timing = _BUILDER.build(Timing, table["timing"], (*keys, "timing"))
    at = "path"
    try:
        compiled = compile_path(path)
        at = "timing"
        compile_trajectory((compiled,), (timing,))
    except PathError as error:
        raise error.about(*keys, at) from None
    return path, timing


def _path(table: dict[str, Any], keys: Keys) -> Shape:
    if "path" not in table:
        raise ScenarioError("a robot needs a path, such as path = { shape = 'sine', amplitude = 1.0 }").about(*keys)
    shape = table["path"]
    _BUILDER.table(shape, (*keys, "path"))
    shape = dict(shape)
    if "shape" not in shape:
        raise ScenarioError(f"path lacks shape, one of {', '.join(SHAPES)}").about(*keys, "path")
    kind = shape.pop("shape")
    if not isinstance(kind, str) or kind not in SHAPES:
        raise ScenarioError(expected(str(kind), SHAPES, "path shape")).about(*keys, "path", "shape")
    made: Shape = _BUILDER.build(SHAPES[kind], shape, (*keys, "path"), ("shape",))
    return made


def _member(table: Any, common: dict[str, Any], keys: Keys, virtual: tuple[Shape, Timing] | None) -> Member:
    _BUILDER.table(table, keys)
    table = dict(table)
    own = table.pop("robot", {})
    _BUILDER.table(own, (*keys, "robot"))
    robot = _BUILDER.build(Robot, common, ("robot",))
    if own:
        robot = _BUILDER.build(Robot, {**common, **own}, (*keys, "robot"))
    if "offset" in table:
        return _offset_member(table, keys, virtual, robot)
    path = _path(table, keys)
    del table["path"]
    return _BUILDER.build(Member, table, keys, ("path", "offset", "robot"), path=path, robot=robot)


def _offset_member(table: dict[str, Any], keys: Keys, virtual: tuple[Shape, Timing] | None, robot: Robot) -> Member:
    """A robot of a formation: its path follows from its offset; without a start it begins in its place."""
    at = (*keys, "offset")
    if virtual is None:
        raise ScenarioError("an offset needs a table [virtual] with the path and the timing it is measured from").about(
            *at
        )
    for key in ("path", "timing"):
        if key in table:
            raise ScenarioError(f"give offset or {key}, not both: in a formation it is that of [virtual]").about(
                *keys, key
            )

    def refuse(_: str) -> InputError:
        what = "offset must be 2 finite numbers [ahead, left] in m, from the virtual robot"
        return ScenarioError(f"{what}; got {value!r}").about(*at)

    value = table.pop("offset")
    ahead, left = numbers(value, 2, refuse)
    path, timing = Offset(path=virtual[0], offset=(ahead, left)), virtual[1]
    try:
        start = offset_start(path, timing)
    except PathError as error:
        raise error.about(*at) from None
    table = {"start": list(start), **table}
    return _BUILDER.build(Member, table, keys, ("offset", "robot"), path=path, timing=timing, robot=robot)


def _radio(value: Any, keys: Keys) -> Radio:
    """Read the radio, of a preset whose fields it may change."""
    table = dict(_BUILDER.table(value, keys))
    if "preset" in table:
        preset = table.pop("preset")
        if not isinstance(preset, str) or preset not in PRESETS:
            raise ScenarioError(expected(str(preset), PRESETS, "radio preset")).about(*keys, "preset")
        table = {**PRESETS[preset], **table}
    radio: Radio = _BUILDER.build(Radio, table, keys, ("preset",))
    return radio


def _obstacles(value: Any, keys: Keys) -> tuple[Obstacle, ...]:
    rows = _BUILDER.tables(value, keys)
    return tuple(obstacle_from_table(row, (*keys, i), _BUILDER.build) for i, row in enumerate(rows))


def _sensors(value: Any, keys: Keys) -> dict[str, RangeSensor]:
    """Read range sensors by name: one table for each, or one for all of a preset, whose fields it may change."""
    found: dict[str, RangeSensor] = {}
    for i, row in enumerate(_BUILDER.tables(value, keys)):
        at = (*keys, i)
        own = {key: value for key, value in row.items() if key not in ("name", "preset")}
        if "preset" in row:
            preset = row["preset"]
            if "name" in row or not isinstance(preset, str) or preset not in SENSOR_PRESETS:
                what = expected(str(preset), SENSOR_PRESETS, "sensor preset")
                raise ScenarioError(what if "name" not in row else "give name or preset, not both").about(*at, "preset")
            made = {
                name: _BUILDER.build(RangeSensor, {k: v for k, v in vars(sensor).items() if v is not None} | own, at)
                for name, sensor in SENSOR_PRESETS[preset].items()
            }
        else:
            name = row.get("name")
            if not isinstance(name, str) or not name:
                text = f'a sensor needs a name such as "rear", or preset, one of {", ".join(SENSOR_PRESETS)}'
                raise ScenarioError(text).about(*at)
            made = {name: _BUILDER.build(RangeSensor, own, at, ("name", "preset"))}
        for name in made:
            if name in found:
                raise ScenarioError(f"there are two sensors called {name!r}").about(*at)
        found |= made
    return found


_BUILDER = Builder(
    ScenarioError,
    {
        Radio: _radio,
        tuple[Obstacle, ...]: _obstacles,
        Mapping[str, RangeSensor]: _sensors,
    },
)
