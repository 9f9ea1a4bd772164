"""Designs: a scenario that is varied, with the gains of the controllers that drive it, and the points of its axes."""

import copy
import json
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field
from functools import lru_cache
from itertools import product
from math import prod
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from fuzzy.errors import InputError
from robotics.laws.catalogue import make_controller
from robotics.laws.foreign import checked_init
from robotics.laws.specification import Specification
from robotics.simulation.scenario.description import Scenario
from robotics.simulation.scenario.reading import scenario_from_table
from robotics.simulation.scenario.robots import robot_tables

if TYPE_CHECKING:
    from robotics.laws.law import Law

Method = Literal["grid", "random", "latin-hypercube"]
Point = tuple[Any, ...]  # a value for each axis
MOST_POINTS = 1_000_000


class SweepError(InputError):
    """A sweep that cannot be planned or carried on. The message says where, what, and what is accepted."""


@dataclass(frozen=True)
class Axis:
    """One dimension of a design: a field of the scenario's TOML, by its dotted key, or a gain of the controllers.

    It takes one of its ``levels``; without levels, any value from ``low`` to ``high``, spread evenly or by logarithm.
    """

    name: str
    target: Literal["scenario", "controller"]
    levels: tuple[Any, ...] = ()
    low: float = 0.0
    high: float = 1.0
    log: bool = False
    line: int = field(default=1, compare=False, repr=False)  # of the file that it stands in

    def at(self, u: np.ndarray) -> list[Any]:
        """The values of the axis at the places ``u`` (points,) in [0, 1); its levels have equal shares of it."""
        if self.levels:
            count = len(self.levels)
            return [self.levels[min(int(i), count - 1)] for i in np.floor(u * count)]
        low, high = (np.log(self.low), np.log(self.high)) if self.log else (self.low, self.high)
        values = low + (high - low) * u
        return [float(v) for v in np.clip(np.exp(values) if self.log else values, self.low, self.high)]


def design_points(axes: Sequence[Axis], method: Method, samples: int, seed: int, file: str = "") -> tuple[Point, ...]:
    """The points of a design, in order: the last axis of a grid varies fastest.

    Raises SweepError, which names the ``file``, where there are too many of them.
    """
    count = prod(len(axis.levels) for axis in axes) if method == "grid" else samples
    if count > MOST_POINTS:
        raise SweepError(f"{file}: the design has {count} points; at most {MOST_POINTS} are accepted")
    if method == "grid":
        return tuple(product(*(axis.levels for axis in axes)))
    places = unit_design(method, samples, len(axes), seed)
    return tuple(zip(*(axis.at(u) for axis, u in zip(axes, places.T, strict=True)), strict=True))


def unit_design(method: Method, samples: int, axes: int, seed: int) -> np.ndarray:
    """A random design in the unit cube (samples, axes).

    A Latin hypercube has one point in each of an axis's strata. Source: McKay, Beckman and Conover, Technometrics 21
    (1979) 239-245.
    """
    generator = np.random.default_rng(seed)
    if method == "random":
        return generator.random((samples, axes))
    from scipy.stats import qmc

    return np.asarray(qmc.LatinHypercube(axes, seed=generator).random(samples))


@dataclass(frozen=True, kw_only=True)
class ScenarioDesign:
    """What a point changes: keys of a scenario's TOML table, and gains of the controllers.

    Attributes:
        scenario: The name of the scenario.
        table: Its table.
        axes: What varies.
        home: The folder of the scenario's file, where its robots' files are.
        file: The file that names the axes, in messages.
        line: Its line about what no axis is to blame for.
    """

    scenario: str
    table: dict[str, Any] = field(repr=False)
    axes: tuple[Axis, ...] = ()
    home: Path = field(default=Path(), compare=False)
    file: str = field(default="<text>", compare=False)
    line: int = field(default=1, compare=False)

    def scenario_at(self, values: Point) -> Scenario:
        """The scenario at a point. Raises an InputError, with ``keys`` if it is about a key of the table."""
        table = robot_tables(copy.deepcopy(self.table))
        for axis, value in zip(self.axes, values, strict=True):
            if axis.target == "scenario":
                assign(table, axis.name.split("."), value, axis.name)
        return scenario_from_table(table, self.scenario, self.home)

    def law_at(self, specification: str, values: Point) -> str:
        """The specification of a controller with the gains of a point."""
        pairs = zip(self.axes, values, strict=True)
        gains = [f"{axis.name}={value}" for axis, value in pairs if axis.target == "controller"]
        return str(Specification.of(specification).with_gains(gains)) if gains else specification

    def columns(self, values: Point) -> dict[str, bool | int | float | str]:
        """What a point has in the columns of the axes: JSON text for what is neither number, text nor truth value."""
        return {
            axis.name: v if isinstance(v, (bool, int, float, str)) else json.dumps(v, ensure_ascii=False, default=str)
            for axis, v in zip(self.axes, values, strict=True)
        }

    def described(self, point: int, values: Point) -> str:
        """A point, by its number from 1, in words, such as "point 3 (latency = 0.1, ky = 10)"."""
        pairs = zip(self.axes, values, strict=True)
        shown = ", ".join(f"{a.name} = {v:.6g}" if isinstance(v, float) else f"{a.name} = {v}" for a, v in pairs)
        return f"point {point}" + (f" ({shown})" if shown else "")

    def check(self, points: Sequence[Point], laws: Iterable[str], advance: Callable[[], None] = lambda: None) -> None:
        """Build the scenario and the controllers of every point; ``advance`` is called after each.

        Raises SweepError, with the file, line and point, where one is refused.
        """

        @lru_cache(maxsize=1024)
        def law(specification: str) -> "Law[Any]":
            return make_controller(specification)

        laws = list(laws)
        last: tuple[list[Any], Scenario] | None = None
        for number, values in enumerate(points, start=1):
            own = [value for axis, value in zip(self.axes, values, strict=True) if axis.target == "scenario"]
            try:
                if last is None or own != last[0]:  # neighbours in a grid often differ in a gain only
                    last = own, self.scenario_at(values)
                for specification in laws:
                    checked_init(law(self.law_at(specification, values)), last[1].setting, 1)
            except InputError as error:
                place = f"{self.file}:{self._line_about(error)}: {self.described(number, values)}"
                raise SweepError(f"{place}: {error}") from None
            advance()

    def _line_about(self, error: InputError) -> int:
        """The line of the axis that an error is about, as far as one can tell."""
        keys = [str(key) for key in error.at]
        fields = [axis for axis in self.axes if axis.target == "scenario"]
        for axis in self.axes:
            own = axis.name.split(".")
            if axis.target == "scenario":
                alike = all(a in (b, "*") for a, b in zip(own, keys, strict=False))
                if (keys and alike) or str(error).startswith(f"{axis.name}: "):
                    return axis.line
            elif not keys and axis.name in str(error).replace("'", " ").split():
                return axis.line
        return fields[0].line if keys and fields else self.line


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
