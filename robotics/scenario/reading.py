"""Reading scenario files: TOML into :class:`robotics.scenario.description.Scenario`.

Any fault of a file is a ScenarioError that names the file, the line, the field and what is accepted.
"""

import re
import tomllib
import types
from collections.abc import Mapping, Sequence
from dataclasses import MISSING, fields
from importlib import resources
from pathlib import Path as FilePath
from typing import Any, Literal, Union, get_args, get_origin, get_type_hints

from fuzzy.errors import InputError
from fuzzy.naming import expected
from robotics.environment.world import Obstacle
from robotics.laws.catalogue import make_controller
from robotics.laws.law import check_needs
from robotics.paths.offset import Offset, offset_start
from robotics.paths.path import SHAPES, PathError, Shape, compile_path
from robotics.paths.trajectory import Timing, compile_trajectory
from robotics.quantity import accepted, is_number
from robotics.radio.description import PRESETS, Radio, RadioError
from robotics.radio.faults import Fault
from robotics.scenario.description import Member, Scenario, ScenarioError
from robotics.scenario.lines import line_of
from robotics.scenario.obstacletable import obstacle_from_table
from robotics.scenario.renamed import current_name
from robotics.sensing.posture import Sensing
from robotics.sensing.sonar import PRESETS as SENSOR_PRESETS
from robotics.sensing.sonar import RangeSensor
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
    try:
        text = path.read_text(encoding="utf-8")
    except (OSError, ValueError) as error:
        reason = "it is not UTF-8 text" if isinstance(error, UnicodeDecodeError) else str(error)
        reason = (error.strerror or reason) if isinstance(error, OSError) else reason
        raise ScenarioError(f"{path}: cannot be read: {reason}") from None
    return parse_scenario(text, path.stem, str(path))


def parse_scenario(text: str, name: str, file: str = "<text>") -> Scenario:
    """Make the scenario that a TOML text describes. Raises ScenarioError.

    Args:
        text: The TOML text.
        name: The name of the scenario.
        file: The name of the file in messages.
    """
    try:
        table = tomllib.loads(text)
    except (ValueError, RecursionError) as error:  # TOMLDecodeError, or a number or a nesting that does not end
        line = re.search(r"at line (\d+)", str(error))
        end = f":{text.count(chr(10)) + 1}" if isinstance(error, tomllib.TOMLDecodeError) else ""
        where = f":{line[1]}" if line else end
        raise ScenarioError(f"{file}{where}: this is not TOML: {error}") from None
    try:
        return scenario_from_table(table, name)
    except InputError as error:
        raise ScenarioError(f"{file}:{line_of(text, error.at)}: {error}") from None


def scenario_from_table(table: dict[str, Any], name: str) -> Scenario:
    """Make the scenario called ``name`` of a TOML file's ``table``, which is left as it is.

    Raises an InputError whose ``at`` holds the keys of the table that it is about.
    """
    rest = dict(table)
    common = rest.pop("robot", {})
    _expect_table(common, ("robot",))
    members = rest.pop("robots", [])
    if not (isinstance(members, list) and members):
        raise ScenarioError("at least one [[robots]] table is needed").about("robots")
    virtual = _virtual(rest.pop("virtual")) if "virtual" in rest else None
    robots = tuple(_member(m, common, ("robots", i), virtual) for i, m in enumerate(members))
    if virtual is not None and not any(isinstance(member.path, Offset) for member in robots):
        raise ScenarioError("no robot has an offset from the virtual robot, such as offset = [0.0, 0.5]").about(
            "virtual"
        )
    scenario: Scenario = _build(Scenario, rest, (), name=name, robots=robots)
    if scenario.controller:
        try:  # its gains may not suit the graph, its messages not the radio
            law = make_controller(scenario.controller)
            check_needs(scenario.setting, law)
            law.init(scenario.setting, 1)
            scenario.radio.check_bandwidth(len(robots), len(law.message))
        except RadioError as error:
            raise error.about("radio") from None
        except InputError as error:
            raise error.about("controller") from None
    return scenario


def _virtual(table: Any) -> tuple[Shape, Timing]:
    """The path and the timing of a formation's virtual robot, thesis (3.3)."""
    keys = ("virtual",)
    _expect_table(table, keys)
    for key in table:
        if key not in ("path", "timing"):
            raise ScenarioError(expected(key, ("path", "timing"), "key")).about(*keys, key)
    if "timing" not in table:
        raise ScenarioError("the virtual robot needs a timing, such as timing = { duration = 30.0 }").about(*keys)
    path = _path(table, keys)
    _expect_table(table["timing"], (*keys, "timing"))
    timing = _build(Timing, table["timing"], (*keys, "timing"))
    at = "path"
    try:
        compiled = compile_path(path)
        at = "timing"
        compile_trajectory((compiled,), (timing,))
    except PathError as error:
        raise error.about(*keys, at) from None
    return path, timing


def _path(table: dict[str, Any], keys: tuple[str | int, ...]) -> Shape:
    if "path" not in table:
        raise ScenarioError("a robot needs a path, such as path = { shape = 'sine', amplitude = 1.0 }").about(*keys)
    shape = table["path"]
    _expect_table(shape, (*keys, "path"))
    shape = dict(shape)
    if "shape" not in shape:
        raise ScenarioError(f"path lacks shape, one of {', '.join(SHAPES)}").about(*keys, "path")
    kind = shape.pop("shape")
    if not isinstance(kind, str) or kind not in SHAPES:
        raise ScenarioError(expected(str(kind), SHAPES, "path shape")).about(*keys, "path", "shape")
    made: Shape = _build(SHAPES[kind], shape, (*keys, "path"))
    return made


def _member(
    table: Any, common: dict[str, Any], keys: tuple[str | int, ...], virtual: tuple[Shape, Timing] | None
) -> Member:
    _expect_table(table, keys)
    table = dict(table)
    own = table.pop("robot", {})
    _expect_table(own, (*keys, "robot"))
    robot = _build(Robot, common, ("robot",))
    if own:
        robot = _build(Robot, {**common, **own}, (*keys, "robot"))
    if "offset" in table:
        return _offset_member(table, keys, virtual, robot)
    path = _path(table, keys)
    del table["path"]
    return _build(Member, table, keys, path=path, robot=robot)


def _offset_member(
    table: dict[str, Any], keys: tuple[str | int, ...], virtual: tuple[Shape, Timing] | None, robot: Robot
) -> Member:
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

    def refuse(_: str) -> ValueError:
        what = "offset must be 2 finite numbers [ahead, left] in m, from the virtual robot"
        return ScenarioError(f"{what}; got {value!r}").about(*at)

    value = table.pop("offset")
    ahead, left = _numbers(value, 2, refuse)
    path, timing = Offset(path=virtual[0], offset=(ahead, left)), virtual[1]
    try:
        start = offset_start(path, timing)
    except PathError as error:
        raise error.about(*at) from None
    table = {"start": list(start), **table}
    return _build(Member, table, keys, path=path, timing=timing, robot=robot)


def _expect_table(value: Any, keys: tuple[str | int, ...]) -> None:
    if not isinstance(value, dict):
        raise ScenarioError(f"{keys[-1]} must be a table, got {value!r}").about(*keys)


def _build(kind: type, table: dict[str, Any], keys: tuple[str | int, ...], **given: Any) -> Any:
    """Make a dataclass of a TOML table: every key known, every value of the field's type, nothing missing."""
    hints = get_type_hints(kind)
    known = {f.name: f for f in fields(kind) if f.init and f.name not in given and f.name != "name"}
    values = dict(given)
    for key, value in table.items():
        if key not in known:
            also: tuple[str, ...] = () if keys else ("robot", "robots", "virtual")
            raise ScenarioError(expected(key, [*known, *also], "key")).about(*keys, key)
        values[key] = _convert(value, hints[key], known[key], (*keys, key))
    missing = [n for n, f in known.items() if n not in values and f.default is MISSING and f.default_factory is MISSING]
    if missing:
        raise ScenarioError(f"{kind.__name__.lower()} lacks {', '.join(missing)}").about(*keys)
    try:
        return kind(**values)
    except InputError as error:
        raise error.about(*keys) from None


def _convert(value: Any, hint: Any, f: Any, keys: tuple[str | int, ...]) -> Any:
    def refuse(what: str) -> ValueError:
        return ScenarioError(f"{f.name} must be {what}; got {value!r}").about(*keys)

    origin = get_origin(hint)
    if origin in (Union, types.UnionType):
        hint = next(h for h in get_args(hint) if h is not type(None))
        origin = get_origin(hint)
    if hint in (Sensing, Timing, Radio):
        _expect_table(value, keys)
        if hint is Radio and "preset" in value:
            value = dict(value)
            preset = value.pop("preset")
            if not isinstance(preset, str) or preset not in PRESETS:
                raise ScenarioError(expected(str(preset), PRESETS, "radio preset")).about(*keys, "preset")
            value = {**PRESETS[preset], **value}
        return _build(hint, value, keys)
    if hint == tuple[Obstacle, ...]:
        if not isinstance(value, list):
            raise refuse("tables [[obstacles]]")
        for i, row in enumerate(value):
            _expect_table(row, (*keys, i))
        return tuple(obstacle_from_table(row, (*keys, i), _build) for i, row in enumerate(value))
    if hint == tuple[Fault, ...]:
        if not isinstance(value, list):
            raise refuse("tables [[faults]]")
        for i, row in enumerate(value):
            _expect_table(row, (*keys, i))
        return tuple(_build(Fault, row, (*keys, i)) for i, row in enumerate(value))
    if origin is Mapping:
        if not isinstance(value, list):
            raise refuse("tables [[sensors]]")
        return _sensors(value, keys)
    if hint is int:
        if isinstance(value, bool) or not isinstance(value, int):
            raise refuse("a whole number")
        return value
    if origin is Literal:
        if value not in get_args(hint):
            raise refuse("one of " + ", ".join(map(repr, get_args(hint))))
        return value
    if hint is float:
        if not is_number(value):
            raise refuse(accepted(f.metadata) if "unit" in f.metadata else "a finite number")
        return float(value)
    if hint is str:
        if not isinstance(value, str):
            raise refuse("text in quotes")
        return value
    if origin is tuple:
        inner = get_args(hint)
        if inner == (tuple[int, int], Ellipsis):
            good = isinstance(value, list) and all(isinstance(e, list) and len(e) == 2 for e in value)
            if not (good and all(type(i) is int for e in value for i in e)):
                raise refuse("a list of pairs [sender, receiver], robots counted from 1")
            return tuple((a, b) for a, b in value)
        if inner[-1] is Ellipsis:
            if not isinstance(value, list):
                raise refuse("a list of points [x, y]")
            return tuple(_numbers(row, 2, refuse) for row in value)
        return _numbers(value, len(inner), refuse)
    raise TypeError(f"a field of type {hint!r} cannot be read from TOML")


def _sensors(rows: list[Any], keys: tuple[str | int, ...]) -> dict[str, RangeSensor]:
    """Read range sensors by name: one table for each, or one for all of a preset, whose fields it may change."""
    found: dict[str, RangeSensor] = {}
    for i, row in enumerate(rows):
        at = (*keys, i)
        _expect_table(row, at)
        own = {key: value for key, value in row.items() if key not in ("name", "preset")}
        if "preset" in row:
            preset = row["preset"]
            if "name" in row or not isinstance(preset, str) or preset not in SENSOR_PRESETS:
                what = expected(str(preset), SENSOR_PRESETS, "sensor preset")
                raise ScenarioError(what if "name" not in row else "give name or preset, not both").about(*at, "preset")
            made = {
                name: _build(RangeSensor, {k: v for k, v in vars(sensor).items() if v is not None} | own, at)
                for name, sensor in SENSOR_PRESETS[preset].items()
            }
        else:
            name = row.get("name")
            if not isinstance(name, str) or not name:
                text = f'a sensor needs a name such as "rear", or preset, one of {", ".join(SENSOR_PRESETS)}'
                raise ScenarioError(text).about(*at)
            made = {name: _build(RangeSensor, own, at)}
        for name in made:
            if name in found:
                raise ScenarioError(f"there are two sensors called {name!r}").about(*at)
        found |= made
    return found


def _numbers(value: Any, count: int, refuse: Any) -> tuple[float, ...]:
    shape = {2: "[x, y] in m", 3: "[x, y, heading] in m, m, rad"}[count]
    good = isinstance(value, Sequence) and not isinstance(value, str) and len(value) == count
    if not (good and all(is_number(v) for v in value)):
        raise refuse(f"{count} finite numbers {shape}")
    return tuple(float(v) for v in value)
