"""Parameter sweeps: scenario fields and controller gains × controllers × seeds, planned as chunks of runs.

A sweep says what varies (:class:`Axis`) and how it is sampled; its plan is a pure function of it. The runs are
numbered by point, controller and seed, the seed fastest, and a chunk is a stretch of them in that order: however the
work is split, interrupted or spread over machines, the table is the same.
"""

import copy
import json
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from functools import lru_cache
from itertools import groupby, product
from math import prod
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from fuzzy.errors import InputError
from robotics.laws.catalogue import files_of, fis_files_named, located, make_controller
from robotics.laws.foreign import checked_init
from robotics.laws.specification import Specification
from robotics.simulation.scenario.description import Scenario
from robotics.simulation.scenario.reading import scenario_from_table
from robotics.simulation.scenario.robots import robot_files, robot_tables
from robotics.studies.chunks import Chunk
from robotics.studies.versions import digest, digest_of, versions

if TYPE_CHECKING:
    from robotics.laws.law import Law

Method = Literal["grid", "random", "latin-hypercube"]
DESIGNS: tuple[Method, ...] = ("grid", "random", "latin-hypercube")
ROW_KEYS = ("scenario", "point", "controller", "seed", "robot")  # the columns that identify a row; points are from 1
MOST_POINTS = 1_000_000
PACKAGES = ("fuzzyfleet", "numba", "numpy", "pyarrow", "scipy")  # on which the numbers and the files' bytes depend


class SweepError(InputError):
    """A sweep that cannot be planned or carried on. The message says where, what, and what is accepted."""


@dataclass(frozen=True)
class Axis:
    """One dimension of a sweep: a field of the scenario's TOML, by its dotted key, or a gain of the controllers.

    It takes one of its ``levels``; without levels, any value from ``low`` to ``high``, spread evenly or by logarithm.
    """

    name: str
    target: Literal["scenario", "controller"]
    levels: tuple[Any, ...] = ()
    low: float = 0.0
    high: float = 1.0
    log: bool = False
    line: int = field(default=1, compare=False)  # of the file that it stands in

    def at(self, u: np.ndarray) -> list[Any]:
        """The values of the axis at the places ``u`` (points,) in [0, 1); its levels have equal shares of it."""
        if self.levels:
            count = len(self.levels)
            return [self.levels[min(int(i), count - 1)] for i in np.floor(u * count)]
        low, high = (np.log(self.low), np.log(self.high)) if self.log else (self.low, self.high)
        values = low + (high - low) * u
        return [float(v) for v in np.clip(np.exp(values) if self.log else values, self.low, self.high)]


@dataclass(frozen=True, kw_only=True)
class Sweep:
    """A sweep: every point of the design × every controller × every seed."""

    scenario: str  # its name
    table: dict[str, Any] = field(repr=False)  # its TOML table, which the axes change
    controllers: tuple[str, ...]  # specifications, such as "fuzzy" or "csm:k=0.3"
    axes: tuple[Axis, ...] = ()
    metrics: tuple[str, ...] = ()  # of the user's own: specifications, such as "mymetric.py:comfort"
    seeds: int = 1  # number of seeds
    first_seed: int = 0
    method: Method = "grid"
    samples: int = 0  # points of a random design
    seed: int = 0  # of a random design
    chunk: int = 100  # runs, computed and written at a time
    name: str = field(default="sweep", compare=False)
    file: str = field(default="<text>", compare=False)
    line: int = field(default=1, compare=False)  # where the file names its controllers
    folder: Path = field(default=Path(), compare=False)  # in which the controllers' files are looked for first
    home: Path = field(default=Path(), compare=False)  # of the scenario's file: where its robots' files are


@dataclass(frozen=True)
class Pass:
    """The runs that are simulated in one go: one point, one controller, some seeds."""

    point: int  # from 1
    values: tuple[Any, ...]  # of the axes
    controller: str  # as the sweep lists it, without the axes' gains
    seeds: tuple[int, ...]


@dataclass(frozen=True)
class SweepPlan:
    """A sweep with its points; ``points[i]`` holds a value for each axis."""

    sweep: Sweep
    points: tuple[tuple[Any, ...], ...] = field(repr=False)

    @property
    def runs(self) -> int:
        """The number of runs: points × controllers × seeds."""
        return len(self.points) * len(self.sweep.controllers) * self.sweep.seeds

    @property
    def chunks(self) -> int:
        """The number of chunks."""
        return -(-self.runs // self.sweep.chunk)

    def chunk(self, number: int) -> Chunk[Pass]:
        """The chunk with that ``number``, from 1."""
        sweep = self.sweep
        runs = range((number - 1) * sweep.chunk, min(number * sweep.chunk, self.runs))
        passes = []
        for index, group in groupby(runs, key=lambda run: run // sweep.seeds):
            point, controller = divmod(index, len(sweep.controllers))
            seeds = tuple(sweep.first_seed + run % sweep.seeds for run in group)
            passes.append(Pass(point + 1, self.points[point], sweep.controllers[controller], seeds))
        return Chunk(number, tuple(passes))


def plan_sweep(sweep: Sweep) -> SweepPlan:
    """Plan a sweep: the design's points in order. Raises SweepError where there are too many of them."""
    count = prod(len(axis.levels) for axis in sweep.axes) if sweep.method == "grid" else sweep.samples
    if count > MOST_POINTS:
        raise SweepError(f"{sweep.file}: the design has {count} points; at most {MOST_POINTS} are accepted")
    if sweep.method == "grid":
        return SweepPlan(sweep, tuple(product(*(axis.levels for axis in sweep.axes))))
    columns = [axis.at(u) for axis, u in zip(sweep.axes, unit_design(sweep).T, strict=True)]
    return SweepPlan(sweep, tuple(zip(*columns, strict=True)))


def unit_design(sweep: Sweep) -> np.ndarray:
    """A random design in the unit cube (samples, axes), seeded by the sweep.

    A Latin hypercube has one point in each of an axis's strata. Source: McKay, Beckman and Conover, Technometrics 21
    (1979) 239-245.
    """
    generator = np.random.default_rng(sweep.seed)
    if sweep.method == "random":
        return generator.random((sweep.samples, len(sweep.axes)))
    from scipy.stats import qmc

    return np.asarray(qmc.LatinHypercube(len(sweep.axes), seed=generator).random(sweep.samples))


# From a point to what is simulated -------------------------------------------------------------------------------


def scenario_at(sweep: Sweep, values: Sequence[Any]) -> Scenario:
    """The scenario at a point's ``values``. Raises an InputError, with ``keys`` if it is about a key of the table."""
    table = robot_tables(copy.deepcopy(sweep.table))
    for axis, value in zip(sweep.axes, values, strict=True):
        if axis.target == "scenario":
            keys = axis.name.split(".")
            assign(table, keys, value, axis.name)
    return scenario_from_table(table, sweep.scenario, sweep.home)


def assign(node: Any, keys: Sequence[str], value: Any, name: str) -> None:
    """Put ``value`` where ``keys`` lead in tables and lists; "*" is every entry of a list."""
    key, rest = keys[0], keys[1:]
    places: Sequence[Any] = [key]
    if isinstance(node, list):
        if not (key == "*" or (key.isdecimal() and int(key) < len(node))):
            raise SweepError(f"{name}: {key!r} is no entry of a list of {len(node)}: 0 to {len(node) - 1}, or *")
        places = range(len(node)) if key == "*" else [int(key)]
    elif not isinstance(node, dict):
        raise SweepError(f"{name}: {key!r} stands below {node!r}, which is neither a table nor a list")
    for place in places:
        if not rest:
            node[place] = copy.deepcopy(value)
        else:
            assign(node.setdefault(place, {}) if isinstance(node, dict) else node[place], rest, value, name)


def column_value(value: Any) -> bool | int | float | str:
    """A level of an axis as its column has it: JSON text for what is neither number, text nor truth value."""
    if isinstance(value, (bool, int, float, str)):
        return value
    return json.dumps(value, ensure_ascii=False, default=str)


def controller_at(sweep: Sweep, controller: str, values: Sequence[Any]) -> str:
    """The specification of a controller with the gains of a point, and with its files as seen from the current folder.

    Args:
        sweep: The sweep, whose axes name the gains.
        controller: A specification as the sweep lists it.
        values: The point: a value for each axis.
    """
    gains = [
        f"{axis.name}={value}" for axis, value in zip(sweep.axes, values, strict=True) if axis.target == "controller"
    ]
    here = located(controller, sweep.folder)
    return str(Specification.of(here).with_gains(gains)) if gains else here


def metrics_at(sweep: Sweep) -> list[str]:
    """The specifications of a sweep's own metrics, with their files as seen from the current folder."""
    return [located(name, sweep.folder) for name in sweep.metrics]


def described(sweep: Sweep, point: int, values: Sequence[Any]) -> str:
    """A point in words, such as "point 3 (latency = 0.1, ky = 10)".

    Args:
        sweep: The sweep, whose axes are named.
        point: The point's number, from 1.
        values: A value for each axis.
    """
    pairs = zip(sweep.axes, values, strict=True)
    shown = ", ".join(f"{a.name} = {v:.6g}" if isinstance(v, float) else f"{a.name} = {v}" for a, v in pairs)
    return f"point {point}" + (f" ({shown})" if shown else "")


def check_plan(plan: SweepPlan, advance: Callable[[], None] | None = None) -> None:
    """Build the scenario and the controllers of every point; ``advance`` is called after each.

    Raises SweepError, with the file, line and point, where one is refused.
    """
    sweep = plan.sweep

    @lru_cache(maxsize=1024)
    def law(specification: str) -> "Law[Any]":
        return make_controller(specification)

    last: tuple[list[Any], Scenario] | None = None
    for number, values in enumerate(plan.points, start=1):
        own = [value for axis, value in zip(sweep.axes, values, strict=True) if axis.target == "scenario"]
        try:
            if last is None or own != last[0]:  # neighbours in a grid often differ in a gain only
                last = own, scenario_at(sweep, values)
            for controller in sweep.controllers:
                checked_init(law(controller_at(sweep, controller, values)), last[1].setting, 1)
        except InputError as error:
            line = _line_about(sweep, error)
            raise SweepError(f"{sweep.file}:{line}: {described(sweep, number, values)}: {error}") from None
        if advance is not None:
            advance()


def _line_about(sweep: Sweep, error: InputError) -> int:
    """The line of the axis that an error is about, as far as one can tell."""
    keys = [str(key) for key in error.at]
    fields = [axis for axis in sweep.axes if axis.target == "scenario"]
    for axis in sweep.axes:
        own = axis.name.split(".")
        if axis.target == "scenario":
            alike = all(a in (b, "*") for a, b in zip(own, keys, strict=False))
            if (keys and alike) or str(error).startswith(f"{axis.name}: "):
                return axis.line
        elif not keys and axis.name in str(error).replace("'", " ").split():
            return axis.line
    return fields[0].line if keys and fields else sweep.line


# What makes two sweeps the same ----------------------------------------------------------------------------------


def identity(plan: SweepPlan) -> dict[str, Any]:
    """What the results of a plan depend on, in JSON's types: sweep, scenario, files that controllers read, versions."""
    sweep = plan.sweep
    return {
        "sweep": {
            "scenario": sweep.scenario,
            "controllers": list(sweep.controllers),
            "metrics": list(sweep.metrics),
            **{name: getattr(sweep, name) for name in ("seeds", "first_seed", "method", "samples", "seed", "chunk")},
            "axes": [
                {"name": a.name, "target": a.target}
                | ({"levels": list(a.levels)} if a.levels else {"low": a.low, "high": a.high, "log": a.log})
                for a in sweep.axes
            ],
        },
        "scenario_sha256": digest(sweep.table),
        "files_sha256": {name: digest_of(path) for name, path in sorted(_files(sweep))},
        "versions": versions(*PACKAGES),
    }


def touchable(sweep: Sweep) -> bool:
    """Whether robots may touch something in any of the runs of ``sweep``: several robots, or obstacles."""
    whole = {axis.name for axis in sweep.axes if axis.target == "scenario"} & {"robots", "obstacles"}
    return len(sweep.table.get("robots", ())) > 1 or bool(sweep.table.get("obstacles")) or bool(whole)


def _files(sweep: Sweep) -> Iterator[tuple[str, Path]]:
    """The files of robots, laws and metrics, and of rule bases that gains name; by name, from the sweep's folder."""
    found = dict(robot_files(sweep.table, sweep.home))
    robots = {v for a in sweep.axes if a.name.split(".")[-1] in ("robot", "model") for v in a.levels}
    found |= robot_files({"robots": [{"robot": name} for name in robots]}, sweep.home)
    for controller in sweep.controllers:
        found |= files_of(located(controller, sweep.folder))
    for axis in sweep.axes:
        for level in axis.levels:
            if axis.target == "controller" and isinstance(level, str):
                found |= fis_files_named(level)
    named = [file for name in metrics_at(sweep) if (file := Specification.of(name).file)]
    found |= {file: Path(file) for file in named}
    for text, path in found.items():
        inside = sweep.folder and path.is_relative_to(sweep.folder)
        yield (path.relative_to(sweep.folder).as_posix() if inside else text), path
