"""Parameters of a search: numbers between bounds, on a linear or a logarithmic scale, and choices.

Engines work in unit coordinates, where every number runs from 0 to 1, so that one step size suits all of them.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from math import exp, isfinite, log
from typing import Literal

import numpy as np

from fuzzy.errors import InputError
from fuzzy.naming import check_known

Scale = Literal["linear", "log"]


class TuningError(InputError):
    """The error for what cannot be tuned, or not so: a parameter, an engine, a cost, a folder of another search."""


@dataclass(frozen=True, kw_only=True)
class SearchParameter:
    """One number, or one choice, that a search may change."""

    name: str
    start: float  # the value from which the search starts; of a choice its place in ``choices``
    lower: float = 0.0
    upper: float = 1.0
    scale: Scale = "linear"
    choices: tuple[str, ...] = ()  # what may be chosen; none: the parameter is a number
    unit: str = ""

    def __post_init__(self) -> None:
        if self.choices:
            object.__setattr__(self, "lower", 0.0)
            object.__setattr__(self, "upper", float(len(self.choices) - 1))
        check_known(self.scale, ("linear", "log"), "scale", TuningError, where=self.name)
        if not (isfinite(self.lower) and isfinite(self.upper) and self.lower < self.upper):
            raise TuningError(f"{self.name}: low must be less than high; got {self.lower:g} and {self.upper:g}")
        if self.scale == "log" and not self.lower > 0:
            raise TuningError(f'{self.name}: on the scale "log" low must be > 0; got {self.lower:g}')
        if not self.lower <= self.start <= self.upper:
            raise TuningError(
                f"{self.name} starts at {self.start:g}, which is not from {self.lower:g} to {self.upper:g}"
            )

    def unit_of(self, value: float) -> float:
        """The unit coordinate of a value; a choice keeps its place."""
        if self.choices:
            return value
        if self.scale == "log":
            return log(value / self.lower) / log(self.upper / self.lower)
        return (value - self.lower) / (self.upper - self.lower)

    def value_of(self, unit: float) -> float:
        """The value at a unit coordinate, never beyond the bounds by rounding."""
        if self.choices:
            return float(round(unit))
        if self.scale == "log":
            value = self.lower * exp(unit * log(self.upper / self.lower))
        else:
            value = self.lower + unit * (self.upper - self.lower)
        return min(max(value, self.lower), self.upper)


def start_of(parameters: Sequence[SearchParameter]) -> np.ndarray:
    """The unit coordinates (parameters,) from which a search starts."""
    return np.array([p.unit_of(p.start) for p in parameters])


def values_at(parameters: Sequence[SearchParameter], points: np.ndarray) -> np.ndarray:
    """The values (points, parameters) at unit coordinates of the same shape."""
    return np.array([[p.value_of(float(u)) for p, u in zip(parameters, row, strict=True)] for row in points])
