"""Plants that an operating variable changes, such as a speed or a flow: what gain scheduling is for.

Between the operating points of transfer functions their coefficients, denominators led by 1, and their dead times are
interpolated linearly, beyond the ends they stay; the states are those of the observable canonical form, in which the
output does not jump as coefficients change. That is the grid-based linear parameter-varying system of W. J. Rugh and
J. S. Shamma, "Research on gain scheduling", Automatica 36 (2000), pp. 1401-1425, section 2, held within a sample. A
Python plant is given the variable itself.
"""

import math
from bisect import bisect_right
from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import lru_cache
from typing import Any, NoReturn

import numpy as np

from fuzzy.plugins.loop.plant import (
    NEEDS_OPERATING,
    LoopPlant,
    PlantError,
    SampledTransferFunction,
    TransferFunction,
    checked_points,
    held_inputs,
)

_LATE = 1e-9  # s: what a sample may come early for a step of the variable
_CACHED = 4096  # models at values of the variable


@dataclass(frozen=True)
class Course:
    """An operating variable over time: straight lines between places; two places at one time are a step.

    Attributes:
        places: (time [s], value) pairs, times ascending; before the first and behind the last the value stays.

    Raises:
        PlantError: Places that make no course.
    """

    places: tuple[tuple[float, float], ...]
    _times: tuple[float, ...] = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        times = tuple(time for time, _ in self.places)
        if not times or list(times) != sorted(times) or not all(math.isfinite(n) for pair in self.places for n in pair):
            raise PlantError(
                "the operating variable is a number, or TIME,VALUE pairs of finite numbers with blanks between and "
                "times ascending, such as '0,1 10,1 20,4'"
            ).about("operating")
        object.__setattr__(self, "_times", times)

    @classmethod
    def of(cls, given: "float | str | Sequence[tuple[float, float]] | Course") -> "Course":
        """The course that a number, pairs or a text such as '2' or '0,1 10,4' say. Raises PlantError."""
        if isinstance(given, Course):
            return given
        try:
            if isinstance(given, str):
                rows = [[float(number) for number in word.split(",")] for word in given.split()]
                given = rows[0][0] if len(rows) == 1 and len(rows[0]) == 1 else [(t, v) for t, v in rows]
            if isinstance(given, (int, float, np.number)):
                return cls(((0.0, float(given)),))
            return cls(tuple((float(time), float(value)) for time, value in given))
        except (TypeError, ValueError) as error:
            if isinstance(error, PlantError):
                raise
            return cls(())

    @classmethod
    def over(cls, points: Sequence[float], duration: float) -> "Course":
        """A ramp from the first of some points to the last, from a quarter to three quarters of a duration [s]."""
        return cls(((duration / 4, points[0]), (3 * duration / 4, points[-1])))

    def __str__(self) -> str:
        if self.constant:
            return repr(self.places[0][1])
        return " ".join(f"{time!r},{value!r}" for time, value in self.places)

    @property
    def constant(self) -> bool:
        """Whether the value is always the same."""
        return len({value for _, value in self.places}) == 1

    def __call__(self, time: float) -> float:
        """The value at a time [s]."""
        k = bisect_right(self._times, time + _LATE)
        if k == 0 or k == len(self.places):
            return self.places[max(k - 1, 0)][1]
        (before, low), (after, high) = self.places[k - 1], self.places[k]
        return low + (high - low) * (time - before) / (after - before)


@dataclass(frozen=True)
class ScheduledTransferFunction:
    """Transfer functions at operating points, and what lies between them.

    Attributes:
        operating: The values of the operating variable, ascending.
        plants: The transfer function at each; their denominators have one degree.
        gains: (Kp, Ki, Kd) of the PID at each, or () by a rule.

    Raises:
        PlantError: Points that do not ascend, other numbers of plants or gains, and denominators of several degrees.
    """

    operating: Sequence[float]
    plants: Sequence[TransferFunction]
    gains: Sequence[Sequence[float]] = ()
    _rows: tuple[tuple[float, ...], ...] = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        points, gains = checked_points(self.operating, self.gains, "the plant")
        plants, degrees = tuple(self.plants), {len(plant.denominator) for plant in self.plants}
        if len(plants) != len(points):
            raise PlantError(f"each operating point has one transfer function, got {len(plants)} of {len(points)}")
        if len(degrees) > 1:
            raise PlantError("the denominators of all operating points must have one degree, to lie between them")
        rows = []
        for plant in plants:
            first, room = plant.denominator[0], len(plant.denominator) - len(plant.numerator)
            rows.append((*[0.0] * room, *(c / first for c in (*plant.numerator, *plant.denominator)), plant.dead_time))
        for name, value in (("operating", points), ("plants", plants), ("gains", gains), ("_rows", tuple(rows))):
            object.__setattr__(self, name, value)

    def __str__(self) -> str:
        return " | ".join(
            f"{at!r}: "
            + "; ".join(
                " ".join(map(repr, row))
                for row in (plant.numerator, plant.denominator, (plant.dead_time,), gains)
                if len(row)
            )
            for at, plant, gains in zip(self.operating, self.plants, self.gains, strict=True)
        )

    def at(self, value: float) -> TransferFunction:
        """The transfer function at a ``value`` of the operating variable, in the variable's unit."""
        if value in self.operating:
            return self.plants[list(self.operating).index(value)]
        *row, dead = (float(np.interp(value, self.operating, column)) for column in zip(*self._rows, strict=True))
        half = len(row) // 2
        return TransferFunction(row[:half], row[half:], dead)

    def along(self, course: Course) -> LoopPlant:
        """The plant as its operating variable follows a ``course``."""
        return self.at(course.places[0][1]) if course.constant else _Along(self, course)

    def sampled(self, sample_time: float) -> NoReturn:
        """The plant sampled at ``sample_time`` [s] needs its operating variable: see ``along``. Raises PlantError."""
        raise PlantError(NEEDS_OPERATING).about("operating")


def operating_points(plant: Any) -> tuple[float, ...]:
    """The values of its operating variable that a plant lists; () for a plant without one."""
    return tuple(getattr(plant, "operating", ()))


def along(plant: Any, course: Course | None) -> LoopPlant:
    """A plant as its operating variable follows a course; one without such a variable stays itself."""
    found: LoopPlant = plant.along(course) if operating_points(plant) and course is not None else plant
    return found


@dataclass(frozen=True)
class _Along:
    plant: ScheduledTransferFunction
    course: Course

    def sampled(self, sample_time: float) -> "_SampledAlong":
        return _SampledAlong(self.plant, self.course, sample_time)


class _SampledAlong:
    """A scheduled transfer function at one sample time: its state is that of the model, the inputs of late, and the
    time."""

    dead_samples = 0  # the dead time changes: the inputs are kept here

    def __init__(self, plant: ScheduledTransferFunction, course: Course, period: float) -> None:
        self._plant, self._course, self._period = plant, course, period
        longest = max(each.dead_time for each in plant.plants)
        order = len(plant.plants[0].denominator) - 1
        self.initial = (np.zeros(order), (0.0,) * (math.ceil(longest / period) + 3), 0.0)

    def _model(self, time: float) -> SampledTransferFunction:
        return _observable(self._plant, self._course(time), self._period)

    def output(self, state: Any, held: float) -> float:
        x, past, time = state
        model = self._model(time)
        return model.output(x, past[-1 - model.dead_samples])

    def advance(self, state: Any, older: float, newer: float, time: float) -> Any:
        x, past, _ = state
        model, past = self._model(time), (*past[1:], newer)
        moved = model.advance(x, past[-2 - model.dead_samples], past[-1 - model.dead_samples], time)
        return moved, past, time + self._period


@lru_cache(maxsize=_CACHED)
def _observable(plant: ScheduledTransferFunction, value: float, period: float) -> SampledTransferFunction:
    """The plant at a value, sampled, with the states of the observable canonical form."""
    now = plant.at(value)
    a = np.array(now.denominator) / now.denominator[0]
    b = np.zeros(len(a))
    b[len(a) - len(now.numerator) :] = np.array(now.numerator) / now.denominator[0]
    order = len(a) - 1
    matrix = np.eye(order, k=1)
    matrix[:, :1] = -a[1:, None]
    return held_inputs(matrix, b[1:] - a[1:] * b[0], np.eye(1, order)[0], float(b[0]), now.dead_time, period)
