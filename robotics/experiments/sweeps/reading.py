"""Reading sweeps from TOML: all that is wrong is a SweepError with file, line, field and what is accepted."""

import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import MISSING, dataclass, fields, replace
from math import inf
from pathlib import Path
from typing import Any, Literal

import numpy as np

from fuzzy.errors import InputError
from fuzzy.naming import expected
from robotics.experiments.sweeps.plan import DESIGNS, MOST_POINTS, ROW_KEYS, Axis, Method, Sweep, SweepError, metrics_at
from robotics.laws.catalogue import located, make_controller
from robotics.measures.registry import own_metrics
from robotics.quantity import described, is_number, quantity, whole
from robotics.scenario.reading import parse_scenario, scenario_file
from robotics.tables.files import TomlFiles
from robotics.tables.text import parse_table


@dataclass(frozen=True, kw_only=True)
class SweepFile:
    """A sweep's file: every point × every controller × every seed. :func:`parse_sweep` reads it."""

    title: str = described("What is swept, in a line.", "", example="What is swept")
    scenario: str = described(
        "The scenario that is varied: a name, or a .toml file's path relative to this file.", example="lyapunov-sine"
    )
    controllers: tuple[str, ...] = described(
        "The controllers, each a name or name:gain=value,...; left out: the scenario's own.", (), example=["lyapunov"]
    )
    metrics: tuple[str, ...] = described(
        "Metrics of your own besides: functions in Python files, relative to this file.",
        (),
        example=["mymetric.py:comfort"],
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
    scenario_fields: Mapping[str, "AxisRange"] | None = described(
        'Keys of the scenario\'s file by their dotted names; robots.0 is the first robot, "robots.*" every one.', None
    )
    controller_parameters: Mapping[str, "AxisRange"] | None = described("Gains, of every controller.", None)


@dataclass(frozen=True, kw_only=True)
class AxisRange:
    """The values of an axis that is a range; others are a list of values."""

    low: float = quantity(MISSING, "1", doc="The least value.", example=0.1)
    high: float = quantity(MISSING, "1", doc="The greatest value, above low.", example=1.0)
    count: int | None = whole(None, least=2, most=MOST_POINTS, doc="Of a grid: how many values.", example=5)
    step: float | None = quantity(
        None, "1", above=0, doc="Of a grid: how far apart values are, instead of count.", example=0.1
    )
    scale: Literal["linear", "log"] = described("Whether values are spread evenly, or by logarithm.", "linear")


FIELDS = tuple(f.name for f in fields(SweepFile))
RANGE = tuple(f.name for f in fields(AxisRange))


_FILES = TomlFiles("sweeps", "sweep", SweepError)


def load_sweep(name: str | Path) -> Sweep:
    """Read the sweep of that name, or in that ``.toml`` file. Raises SweepError."""
    found = _FILES.find(name)
    return parse_sweep(found.text, found.name, found.file, found.folder)


def parse_sweep(text: str, name: str = "sweep", file: str = "<text>", folder: Path | None = None) -> Sweep:
    """Read the sweep that a TOML text describes. Raises SweepError.

    Args:
        text: The TOML text.
        name: The sweep's name.
        file: The file's name in messages.
        folder: The folder to which a scenario's path is relative, by default the current one; controllers' files are
            looked for there before the current one.
    """
    source = _Source(text, file)
    table = parse_table(text, file, SweepError)
    for key in table:
        if key not in FIELDS:
            raise source.refuse(expected(key, FIELDS, "key"), key)
    if not isinstance(table.get("title", ""), str):
        raise source.refuse(f"title must be text in quotes; got {table['title']!r}", "title")
    method = table.get("method", "grid")
    if method not in DESIGNS:
        raise source.refuse(f"method must be one of {', '.join(map(repr, DESIGNS))}; got {method!r}", "method")
    for key in ("samples", "seed"):
        if method == "grid" and key in table:
            hint = "the axes' values make a grid's points" if key == "samples" else "first_seed is that of the runs"
            raise source.refuse(f"{key} belongs to method = 'random' or 'latin-hypercube'; {hint}", key)
    if method != "grid" and "samples" not in table:
        raise source.refuse(f"method = {method!r} needs samples = N, the number of points", "method")
    scenario, content, default, home = _scenario(source, table, folder)
    axes = (
        *_axes(source, table, "scenario_fields", method),
        *_axes(source, table, "controller_parameters", method),
    )
    _check_columns(source, axes)
    if method != "grid" and not axes:
        raise source.refuse("a random design needs [scenario_fields] or [controller_parameters]", "method")
    return Sweep(
        scenario=scenario,
        table=content,
        controllers=_controllers(source, table, default, folder),
        axes=axes,
        metrics=_metrics(source, table, folder, content.get("kind", "tracking")),
        seeds=source.whole(table, "seeds", 1, 1),
        first_seed=source.whole(table, "first_seed", 0, 0),
        method=method,
        samples=source.whole(table, "samples", 0, 1),
        seed=source.whole(table, "seed", 0, 0),
        chunk=source.whole(table, "chunk", 100, 1),
        name=name,
        file=file,
        line=source.line("controllers"),
        folder=folder or Path(),
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


@dataclass(frozen=True)
class _Source:
    """The text of a file, for the line in a message."""

    text: str
    file: str

    def line(self, key: str, section: str = "") -> int:
        """The line (from 1) where ``key`` is set, in [section] or as section.key; that of the section otherwise."""
        names = r'["\']?\.["\']?'.join(re.escape(part) for part in key.split("."))
        here, best = "", 1
        for number, line in enumerate(self.text.splitlines(), start=1):
            header = re.match(r"\s*\[+\s*([^\]]+?)\s*\]", line)
            if header:
                here = header[1].replace('"', "").replace("'", "")
                best = number if section and here == section else best
            inside = f"{section}." if section and here != section else ""
            if here in ("", section) and re.match(rf'\s*{re.escape(inside)}["\']?{names}["\']?\s*=', line):
                return number
            if section and re.match(rf"\s*{re.escape(section)}\s*=", line):
                best = number
        return best

    def refuse(self, message: str, key: str, section: str = "") -> SweepError:
        return SweepError(f"{self.file}:{self.line(key, section)}: {message}")

    def whole(self, table: dict[str, Any], key: str, default: int, least: int) -> int:
        """A whole number of at least ``least``, of at most what a 64-bit file can hold."""
        value = table.get(key, default)
        if type(value) is not int or (key in table and value < least) or value >= 2**62:
            raise self.refuse(f"{key} must be a whole number >= {least}; got {value!r}", key)
        return value


def _scenario(source: _Source, table: dict[str, Any], folder: Path | None) -> tuple[str, dict[str, Any], str, Path]:
    """The scenario's name, its TOML table, the controller that it names itself, if any, and its folder."""
    name = table.get("scenario")
    if not isinstance(name, str) or not name:
        raise source.refuse(f"scenario must be a scenario's name or a .toml file's path; got {name!r}", "scenario")
    try:
        found = scenario_file(name, folder or Path())
        base = parse_scenario(found.text, found.name, found.file, found.folder)
        content = parse_table(found.text, found.file, SweepError)
        if base.controller:
            content["controller"] = base.controller  # with its files as seen from here
        return base.name, content, base.controller, found.folder
    except InputError as error:
        raise source.refuse(f"scenario: {error}", "scenario") from None


def _controllers(source: _Source, table: dict[str, Any], default: str, folder: Path | None) -> tuple[str, ...]:
    listed = table.get("controllers", [default] if default else None)
    if not (isinstance(listed, list) and listed and all(isinstance(c, str) for c in listed)):
        raise source.refuse(
            f'controllers must be a list of names, such as ["lyapunov", "csm:k=0.3"]; got {listed!r}', "controllers"
        )
    for controller in listed:
        if listed.count(controller) > 1:
            raise source.refuse(f"controllers: {controller!r} is given twice", "controllers")
        try:
            make_controller(located(controller, folder or Path()))
        except InputError as error:
            raise source.refuse(str(error), "controllers") from None
    return tuple(listed)


def _metrics(source: _Source, table: dict[str, Any], folder: Path | None, kind: str) -> tuple[str, ...]:
    listed = table.get("metrics", [])
    if not (isinstance(listed, list) and all(isinstance(name, str) for name in listed)):
        raise source.refuse(f'metrics must be a list, such as ["mymetric.py:comfort"]; got {listed!r}', "metrics")
    try:
        own_metrics([located(name, folder or Path()) for name in listed], kind)
    except InputError as error:
        raise source.refuse(f"metrics: {error}", "metrics") from None
    return tuple(listed)


def _axes(source: _Source, table: dict[str, Any], section: str, method: str) -> Iterator[Axis]:
    given = table.get(section, {})
    if not isinstance(given, dict):
        raise source.refuse(f"{section} must be a table, such as [{section}]; got {given!r}", section)
    target: Literal["scenario", "controller"] = "scenario" if section == "scenario_fields" else "controller"
    for name, value in _flat(given):
        try:
            if target == "scenario" and name == "kind":
                raise ValueError("kind decides which metrics there are: make one sweep for each")
            if isinstance(value, list):
                axis = Axis(name, target, _levels(value, target))
            elif isinstance(value, dict):
                axis = _range(name, target, value, method)
            else:
                raise ValueError(f"must be a list of values or a range {{ low, high, ... }}; got {value!r}")
        except ValueError as error:
            raise source.refuse(f"{section}: {name}: {error}", name, section) from None
        yield Axis(axis.name, target, axis.levels, axis.low, axis.high, axis.log, source.line(name, section))


def _flat(table: dict[str, Any], prefix: str = "") -> Iterator[tuple[str, Any]]:
    """Axes by their dotted names; a key may be quoted as a whole or dotted as TOML has it."""
    for key, value in table.items():
        if isinstance(value, dict) and value and not set(value) & set(RANGE):
            yield from _flat(value, f"{prefix}{key}.")
        else:
            yield prefix + key, value


def _levels(values: list[Any], target: str) -> tuple[Any, ...]:
    if not values:
        raise ValueError("at least one value is needed")
    for value in values:
        number = is_number(value) and (isinstance(value, float) or abs(value) < 2**63)
        if isinstance(value, (int, float)) and not isinstance(value, bool) and not number:
            raise ValueError(f"numbers must be finite, of 64 bits; got {value!r}")
        if target == "controller" and not (number or isinstance(value, str)):
            raise ValueError(f"a gain is a number or text in quotes; got {value!r}")
        if target == "controller" and isinstance(value, str) and ("," in value or not value.strip()):
            raise ValueError(f"a gain's text has no comma and is not empty; got {value!r}")
        if values.count(value) > 1:
            raise ValueError(f"{value!r} is given twice")
    kinds = {"number" if is_number(v) else type(v).__name__ for v in values}
    if len(kinds) > 1:
        raise ValueError(f"all values must be of one kind; got {values!r}")
    if any(isinstance(v, float) for v in values):
        return tuple(float(v) for v in values)
    return tuple(values)


def _range(name: str, target: Literal["scenario", "controller"], given: dict[str, Any], method: str) -> Axis:
    for key in given:
        if key not in RANGE:
            raise ValueError(expected(key, RANGE, "key"))
    for key in ("low", "high", "step"):
        if (key != "step" or key in given) and not is_number(given.get(key)):
            raise ValueError(f"{key} must be a finite number; got {given.get(key)!r}")
    low, high = float(given["low"]), float(given["high"])
    if not low < high or high - low == inf:
        raise ValueError(f"low must be below high; got {low:g} and {high:g}")
    scale = given.get("scale", "linear")
    if scale not in ("linear", "log"):
        raise ValueError(f"scale must be 'linear' or 'log'; got {scale!r}")
    if scale == "log" and low <= 0:
        raise ValueError(f"low must be > 0 where scale is 'log'; got {low:g}")
    if "step" in given:
        if "count" in given or scale == "log":
            raise ValueError("step goes neither with count nor with scale = 'log'")
        step = float(given["step"])
        if not 0 < step <= high - low:
            raise ValueError(f"step must be > 0 and at most high - low = {high - low:g}; got {step:g}")
        count = int(min((high - low) / step * (1 + 1e-12), MOST_POINTS)) + 1
        values = low + step * np.arange(count)
    elif "count" in given:
        count = given["count"]
        if type(count) is not int or not 2 <= count <= MOST_POINTS:
            raise ValueError(f"count must be a whole number >= 2 and <= {MOST_POINTS}; got {count!r}")
        if method != "grid":
            raise ValueError(f"count belongs to method = 'grid'; samples is the number of points of {method!r}")
        values = np.geomspace(low, high, count) if scale == "log" else np.linspace(low, high, count)
    elif method == "grid":
        raise ValueError("a grid needs count = N, how many values, or step, how far apart")
    else:
        return Axis(name, target, low=low, high=high, log=scale == "log")
    # 0.3 and not 0.30000000000000004, but the ends as they are written
    levels = [float(f"{v:.15g}") for v in values]
    levels[0] = low
    if abs(levels[-1] - high) <= 1e-12 * (high - low):
        levels[-1] = high
    return Axis(name, target, tuple(levels))


def _check_columns(source: _Source, axes: tuple[Axis, ...]) -> None:
    """Every axis is a column of the table beside the ones that are always there."""
    seen = {*ROW_KEYS, "diverged", "contact"}
    for axis in axes:
        if axis.name in seen:
            section = "scenario_fields" if axis.target == "scenario" else "controller_parameters"
            raise source.refuse(f"{section}: the table would have two columns {axis.name!r}", axis.name, section)
        seen.add(axis.name)
