"""Reading sweeps from TOML: all that is wrong is a SweepError with file, line, field and what is accepted."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import MISSING, dataclass, fields, replace
from functools import cache
from math import inf
from pathlib import Path
from typing import Any, Literal

import numpy as np

from fuzzy.errors import InputError
from fuzzy.quantity import accepted, check_quantities, described, got, is_number, quantity, whole
from robotics.laws.catalogue import located, make_controller
from robotics.measures.registry import own_metrics
from robotics.simulation.scenario.reading import parse_scenario, scenario_file
from robotics.studies.sweeps.plan import MOST_POINTS, ROW_KEYS, Axis, Method, Sweep, SweepError, metrics_at
from robotics.tables.build import Builder, Keys
from robotics.tables.files import TomlFiles
from robotics.tables.keys import Key, KeyTable, first_line, keys_of, table_of
from robotics.tables.text import line_of, parse_table, reading

_MOST = 2**62  # whole numbers are smaller: a file of 64 bits holds them
Target = Literal["scenario", "controller"]
_SECTIONS: dict[str, Target] = {"scenario_fields": "scenario", "controller_parameters": "controller"}


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


@dataclass(frozen=True, kw_only=True)
class SweepFile:
    """A sweep's file: every point × every controller × every seed. :func:`parse_sweep` reads it."""

    title: str = described("What is swept, in a line.", "", example="What is swept")
    scenario: str = described(
        "The scenario that is varied: a name, or a .toml file's path relative to this file.",
        example="lyapunov-sine",
        accepts="a scenario's name or a .toml file's path",
        missing="scenario must be a scenario's name or a .toml file's path; got None",
    )
    controllers: tuple[str, ...] | None = described(
        "The controllers, each a name or name:gain=value,...; left out: the scenario's own.",
        None,
        example=["lyapunov"],
        accepts='a list of names, such as ["lyapunov", "csm:k=0.3"]',
    )
    metrics: tuple[str, ...] = described(
        "Metrics of your own besides: functions in Python files, relative to this file.",
        (),
        example=["mymetric.py:comfort"],
        accepts='a list, such as ["mymetric.py:comfort"]',
    )
    seeds: int = whole(1, least=1, doc="How many seeds each point and controller runs with.")
    first_seed: int = whole(0, least=0, doc="The first of the seeds.")
    chunk: int = whole(100, least=1, doc="How many runs are computed and written at a time.")
    method: Method = described(
        "How points are chosen: all combinations of the axes' values (grid), at random, or as a Latin hypercube.",
        "grid",
    )
    samples: int | None = whole(None, least=1, doc="How many points a random design has.", example=50)
    seed: int | None = whole(None, least=0, doc="The seed of a random design; left out: 0.", example=0)
    scenario_fields: Mapping[str, Range] | None = described(
        'Keys of the scenario\'s file by their dotted names; robots.0 is the first robot, "robots.*" every one.', None
    )
    controller_parameters: Mapping[str, Range] | None = described("Gains, of every controller.", None)

    def __post_init__(self) -> None:
        check_quantities(self, SweepError)
        for f in fields(self):
            value = getattr(self, f.name)
            if "whole" in f.metadata and value is not None and value >= _MOST:
                raise SweepError(f"{f.name} must be {accepted(f.metadata)}; {got(value)}").about(f.name)
        check_design(self.method, self.samples, self.seed)


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

    def __post_init__(self) -> None:
        if bool(self.key) == bool(self.gain):
            raise SweepError('an axis needs key = "...", of the scenarios, or gain = "...", of the controllers')


AXIS_VALUES = {Range: lambda value, keys: value}  # how the values of a study's axes are read


def axis_values_key(name: str) -> Key:
    """The description of the key of an axis's values."""
    return Key(name=name, doc="", holds="table", table=table_of(Range, "range"), or_list=True)


def study_axes(axes: Sequence[StudyAxis], method: Method, text: str) -> tuple[Axis, ...]:
    """The axes of a study's file, whose ``text`` says their lines. Raises SweepError about what is wrong."""
    found = []
    for i, axis in enumerate(axes):
        name, target = axis.key or axis.gain, _SECTIONS["scenario_fields" if axis.key else "controller_parameters"]
        try:
            found.append(_axis(name, target, axis.values, method, line_of(text, ("axes", i))))
        except InputError as error:
            raise SweepError(f"axes: {name}: {error}").about("axes", i, "values") from None
        if name in {*ROW_KEYS, "diverged", "contact", "condition", *(other.name for other in found[:-1])}:
            raise SweepError(f"axes: the table would have two columns {name!r}").about("axes", i)
    if method != "grid" and not axes:
        raise SweepError("a random design needs [[axes]]").about("method")
    return tuple(found)


@cache
def sweep_table() -> KeyTable:
    """The description of a sweep's file."""
    keys = keys_of(SweepFile, {Mapping[str, Range] | None: _axes_key})
    return KeyTable(name="sweep", doc=first_line(SweepFile), keys=keys)


def _axes_key(name: str) -> Key:
    doc = "The values of an axis: a range, or a list of values."
    axis = Key(name="KEY", doc=doc, holds="table", table=table_of(Range, "range"), or_list=True)
    return Key(name=name, doc="", holds="table", table=KeyTable(name=name, doc="Axes by name.", any_key=axis))


def _section(value: Any, keys: Keys) -> dict[str, Any]:
    if not isinstance(value, dict):
        raise SweepError(f"{keys[0]} must be a table, such as [{keys[0]}]; {got(value)}").about(*keys)
    return value


_BUILDER = Builder(SweepError, {Mapping[str, Range] | None: _section})
_FILES = TomlFiles("sweeps", "sweep", SweepError)


def load_sweep(name: str | Path) -> Sweep:
    """Read the sweep of that name, or in that ``.toml`` file. Raises SweepError."""
    found = _FILES.find(name)
    return parse_sweep(found.text, found.name, found.file, found.folder)


def parse_sweep(text: str, name: str = "sweep", file: str = "<text>", folder: Path = Path()) -> Sweep:
    """Read the sweep that a TOML text describes. Raises SweepError.

    Args:
        text: The TOML text.
        name: The sweep's name.
        file: The file's name in messages.
        folder: The folder to which a scenario's path is relative, by default the current one; controllers' files are
            looked for there before the current one.
    """
    with reading(text, file, SweepError) as table:
        said: SweepFile = _BUILDER.build(SweepFile, table, ())
        scenario, content, default, home = scenario_source(said.scenario, folder)
        axes = tuple(axis for section in _SECTIONS for axis in _axes(said, section, text))
        _check_columns(axes)
        if said.method != "grid" and not axes:
            raise SweepError("a random design needs [scenario_fields] or [controller_parameters]").about("method")
        controllers = said.controllers if said.controllers is not None or not default else (default,)
        return Sweep(
            scenario=scenario,
            table=content,
            controllers=_checked_controllers(controllers, folder),
            axes=axes,
            metrics=_checked_metrics(said.metrics, folder, content.get("kind", "tracking")),
            seeds=said.seeds,
            first_seed=said.first_seed,
            method=said.method,
            samples=said.samples or 0,
            seed=said.seed or 0,
            chunk=said.chunk,
            name=name,
            file=file,
            line=line_of(text, ("controllers",)),
            folder=folder,
            home=home,
        )


def with_own(sweep: Sweep, laws: Sequence[str], metrics: Sequence[str]) -> Sweep:
    """A sweep with more controllers and more metrics, by their specifications, seen from the current folder.

    Raises SweepError for one that is there already, ControllerError and MetricError for one that cannot be used.
    """
    for name in laws:
        if name in sweep.controllers or laws.count(name) > 1:
            raise SweepError(f"the controller {name!r} is given twice")
        make_controller(name)
    sweep = replace(sweep, controllers=(*sweep.controllers, *laws), metrics=(*sweep.metrics, *metrics))
    own_metrics(metrics_at(sweep), sweep.table.get("kind", "tracking"))
    return sweep


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


def _checked_controllers(listed: Sequence[str] | None, folder: Path) -> tuple[str, ...]:
    if not listed:
        such = 'controllers must be a list of names, such as ["lyapunov", "csm:k=0.3"]'
        raise SweepError(f"{such}; got {None if listed is None else []}").about("controllers")
    for controller in listed:
        if listed.count(controller) > 1:
            raise SweepError(f"controllers: {controller!r} is given twice").about("controllers")
        try:
            make_controller(located(controller, folder))
        except InputError as error:
            raise SweepError(str(error)).about("controllers") from None
    return tuple(listed)


def _checked_metrics(listed: tuple[str, ...], folder: Path, kind: str) -> tuple[str, ...]:
    try:
        own_metrics([located(name, folder) for name in listed], kind)
    except InputError as error:
        raise SweepError(f"metrics: {error}").about("metrics") from None
    return listed


def _axes(said: SweepFile, section: str, text: str) -> Iterator[Axis]:
    """The axes of a section of the file whose ``text`` says their lines."""
    for name, value in dotted(getattr(said, section) or {}):
        at = (section, *name.split("."))
        try:
            yield _axis(name, _SECTIONS[section], value, said.method, line_of(text, at))
        except InputError as error:
            raise SweepError(f"{section}: {name}: {error}").about(*at) from None


def _axis(name: str, target: Target, value: Any, method: Method, line: int) -> Axis:
    if target == "scenario" and name == "kind":
        raise SweepError("kind decides which metrics there are: make one sweep for each")
    if isinstance(value, list):
        return Axis(name, target, _levels(value, target), line=line)
    if not isinstance(value, dict):
        raise SweepError(f"must be a list of values or a range {{ low, high, ... }}; got {value!r}")
    span: Range = _BUILDER.build(Range, value, ())
    if method != "grid" and span.count is not None:
        raise SweepError(f"count belongs to method = 'grid'; samples is the number of points of {method!r}")
    if span.step is not None or span.count is not None:
        return Axis(name, target, span.levels(), line=line)
    if method == "grid":
        raise SweepError("a grid needs count = N, how many values, or step, how far apart")
    return Axis(name, target, low=span.low, high=span.high, log=span.scale == "log", line=line)


def dotted(table: dict[str, Any], prefix: str = "") -> Iterator[tuple[str, Any]]:
    """The values of a table by their dotted names; a key may be quoted as a whole, or dotted as TOML has it."""
    for key, value in table.items():
        if isinstance(value, dict) and value and not set(value) & {f.name for f in fields(Range)}:
            yield from dotted(value, f"{prefix}{key}.")
        else:
            yield prefix + key, value


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


def _check_columns(axes: tuple[Axis, ...]) -> None:
    """Every axis is a column of the table beside the ones that are always there."""
    seen = {*ROW_KEYS, "diverged", "contact"}
    for axis in axes:
        if axis.name in seen:
            section = next(section for section, target in _SECTIONS.items() if target == axis.target)
            message = f"{section}: the table would have two columns {axis.name!r}"
            raise SweepError(message).about(section, *axis.name.split("."))
        seen.add(axis.name)
