"""Axes of a design as files have them: a list of values, or a range. What is wrong names file, line and field."""

from collections.abc import Iterator, Sequence
from dataclasses import MISSING, dataclass, fields
from math import inf
from pathlib import Path
from typing import Any, Literal

import numpy as np

from fuzzy.errors import InputError
from fuzzy.quantity import check_quantities, described, got, is_number, quantity, whole
from robotics.simulation.scenario.reading import parse_scenario, scenario_file
from robotics.studies.design import MOST_POINTS, Axis, Method, SweepError
from robotics.tables.build import Builder, Keys
from robotics.tables.keys import Key, table_of
from robotics.tables.text import line_of, parse_table

ROW_KEYS = ("scenario", "condition", "point", "controller", "seed", "robot")  # the columns that identify a row
_TAKEN = {*ROW_KEYS, "diverged", "contact"}
_SECTIONS = {"scenario_fields": "key", "controller_parameters": "gain"}  # of a sweep's file: what varies
SWEEP_KEYS = frozenset({"scenario", *_SECTIONS})  # which only a sweep's file has


@dataclass(frozen=True, kw_only=True)
class Range:
    """The values of an axis that is a range; others are a list of values."""

    low: float = quantity(MISSING, "1", doc="The least value.", example=0.1)
    high: float = quantity(MISSING, "1", doc="The greatest value, above low.", example=1.0)
    count: int | None = whole(None, least=2, most=MOST_POINTS, doc="Of a grid: how many values.", example=5)
    step: float | None = quantity(
        None, "1", above=0, doc="Of a grid: how far apart values are, instead of count.", example=0.1
    )
    scale: Literal["linear", "log"] = described(
        "Whether values are spread evenly, or by logarithm.", "linear", accepts="'linear' or 'log'"
    )

    def __post_init__(self) -> None:
        check_quantities(self, SweepError)
        low, high = self.low, self.high
        if not low < high or high - low == inf:
            raise SweepError(f"low must be below high; got {low:g} and {high:g}")
        if self.scale == "log" and low <= 0:
            raise SweepError(f"low must be > 0 where scale is 'log'; got {low:g}")
        if self.step is not None:
            if self.count is not None or self.scale == "log":
                raise SweepError("step goes neither with count nor with scale = 'log'")
            if self.step > high - low:
                raise SweepError(f"step must be > 0 and at most high - low = {high - low:g}; got {self.step:g}")

    def levels(self) -> tuple[float, ...]:
        """The values of a grid, of which ``step`` or ``count`` is given."""
        low, high = self.low, self.high
        if self.step is not None:
            values = low + self.step * np.arange(int(min((high - low) / self.step * (1 + 1e-12), MOST_POINTS)) + 1)
        else:
            assert self.count is not None
            values = (np.geomspace if self.scale == "log" else np.linspace)(low, high, self.count)
        # 0.3 and not 0.30000000000000004, but the ends as they are written
        found = [float(f"{v:.15g}") for v in values]
        found[0] = low
        if abs(found[-1] - high) <= 1e-12 * (high - low):
            found[-1] = high
        return tuple(found)


def check_design(method: Method, samples: int | None, seed: int | None) -> None:
    """Raise SweepError where the keys of a design do not go together."""
    if method != "grid" and samples is None:
        raise SweepError(f"method = {method!r} needs samples = N, the number of points").about("method")
    for key, value, hint in (
        ("samples", samples, "the axes' values make a grid's points"),
        ("seed", seed, "first_seed is that of the runs"),
    ):
        if method == "grid" and value is not None:
            raise SweepError(f"{key} belongs to method = 'random' or 'latin-hypercube'; {hint}").about(key)


@dataclass(frozen=True, kw_only=True)
class StudyAxis:
    """An axis of a study: a key of the scenarios' files, or a gain of the controllers, that is varied."""

    key: str = described(
        'A key of the scenarios\' files by its dotted name; robots.0 is the first robot, "robots.*" every one.',
        "",
        example="latency",
    )
    gain: str = described("Instead of a key: a gain, of every controller.", "", example="ky")
    values: Range = described(
        "Its values: a list, or a range { low, high } with count, step, or scale, as a sweep has it.",
        example=[0.0, 0.1],
    )
    at: Keys = ()  # where the file has it, if not in its place among the tables [[axes]]

    def __post_init__(self) -> None:
        if bool(self.key) == bool(self.gain):
            raise SweepError('an axis needs key = "...", of the scenarios, or gain = "...", of the controllers')


AXIS_VALUES = {Range: lambda value, keys: value}  # how the values of a study's axes are read


def axis_values_key(name: str) -> Key:
    """The description of the key of an axis's values."""
    return Key(name=name, doc="", holds="table", table=table_of(Range, "range"), or_list=True)


def study_axes(axes: Sequence[StudyAxis], method: Method, text: str) -> tuple[Axis, ...]:
    """The axes of a study's file, whose ``text`` says their lines. Raises SweepError about what is wrong."""
    found = dict[str, Axis]()
    for i, axis in enumerate(axes):
        name, at = axis.key or axis.gain, axis.at or ("axes", i)
        try:
            if name in {*_TAKEN, *found}:
                raise SweepError(f"the table would have two columns {name!r}")
            target: Literal["scenario", "controller"] = "scenario" if axis.key else "controller"
            found[name] = _axis(name, target, axis.values, method, line_of(text, at))
        except InputError as error:
            raise SweepError(f"{at[0]}: {name}: {error}").about(*at, *(() if axis.at else ("values",))) from None
    if method != "grid" and not axes:
        raise SweepError("a random design needs [[axes]]").about("method")
    return tuple(found.values())


def sweep_as_study(table: dict[str, Any], folder: Path) -> tuple[StudyAxis, ...]:
    """Make the table of a study of a sweep's, an older form; return its axes. Raises SweepError.

    Args:
        table: The table of the sweep's file, which is changed.
        folder: The folder to which the scenario's path is relative.
    """
    if not isinstance(name := table.pop("scenario", None), str):
        such = "scenario must be a scenario's name or a .toml file's path"
        raise SweepError(f"{such}; {got(name)}").about("scenario")
    own = scenario_source(name, folder)[2]
    for key, value in (("scenarios", [name]), ("seeds", 1), ("controllers", [own])):
        if value != [""]:  # the scenario names no controller
            table.setdefault(key, value)
    found = []
    for section, role in _SECTIONS.items():
        if not isinstance(axes := table.pop(section, {}), dict):
            raise SweepError(f"{section} must be a table, such as [{section}]; {got(axes)}").about(section)
        for key, values in dotted(axes):
            found.append(StudyAxis(**{role: key, "values": values}, at=(section, *key.split("."))))
    return tuple(found)


def scenario_source(name: str, folder: Path) -> tuple[str, dict[str, Any], str, Path]:
    """The scenario's name, its TOML table, the controller that it names itself, if any, and its folder."""
    try:
        found = scenario_file(name, folder)
        base = parse_scenario(found.text, found.name, found.file, found.folder)
        content = parse_table(found.text, found.file, SweepError)
    except InputError as error:
        raise SweepError(f"scenario: {error}").about("scenario") from None
    if base.controller:
        content["controller"] = base.controller  # with its files as seen from here
    return base.name, content, base.controller, found.folder


def dotted(table: dict[str, Any], prefix: str = "") -> Iterator[tuple[str, Any]]:
    """The values of a table by their dotted names; a key may be quoted as a whole, or dotted as TOML has it."""
    for key, value in table.items():
        if isinstance(value, dict) and value and not set(value) & {f.name for f in fields(Range)}:
            yield from dotted(value, f"{prefix}{key}.")
        else:
            yield prefix + key, value


def _axis(name: str, target: Literal["scenario", "controller"], value: Any, method: Method, line: int) -> Axis:
    if target == "scenario" and name == "kind":
        raise SweepError("kind decides which metrics there are: make one sweep for each")
    if isinstance(value, list):
        return Axis(name, target, _levels(value, target), line=line)
    if not isinstance(value, dict):
        raise SweepError(f"must be a list of values or a range {{ low, high, ... }}; got {value!r}")
    span: Range = Builder(SweepError).build(Range, value, ())
    if method != "grid" and span.count is not None:
        raise SweepError(f"count belongs to method = 'grid'; samples is the number of points of {method!r}")
    if span.step is not None or span.count is not None:
        return Axis(name, target, span.levels(), line=line)
    if method == "grid":
        raise SweepError("a grid needs count = N, how many values, or step, how far apart")
    return Axis(name, target, low=span.low, high=span.high, log=span.scale == "log", line=line)


def _levels(values: list[Any], target: str) -> tuple[Any, ...]:
    if not values:
        raise SweepError("at least one value is needed")
    for value in values:
        number = is_number(value) and (isinstance(value, float) or abs(value) < 2**63)
        if isinstance(value, (int, float)) and not isinstance(value, bool) and not number:
            raise SweepError(f"numbers must be finite, of 64 bits; got {value!r}")
        if target == "controller" and not (number or isinstance(value, str)):
            raise SweepError(f"a gain is a number or text in quotes; got {value!r}")
        if target == "controller" and isinstance(value, str) and ("," in value or not value.strip()):
            raise SweepError(f"a gain's text has no comma and is not empty; got {value!r}")
        if values.count(value) > 1:
            raise SweepError(f"{value!r} is given twice")
    kinds = {"number" if is_number(v) else type(v).__name__ for v in values}
    if len(kinds) > 1:
        raise SweepError(f"all values must be of one kind; got {values!r}")
    if any(isinstance(v, float) for v in values):
        return tuple(float(v) for v in values)
    return tuple(values)
