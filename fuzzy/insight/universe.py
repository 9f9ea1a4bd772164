"""Places in the universes of discourse: grids, points, and the values that a consequent reaches."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from fuzzy.naming import expected
from fuzzy.system import FuzzySystemError, Linear, Sugeno, Variable


def universe_grid(variable: Variable, points: int = 401) -> np.ndarray:
    """Places (points + a few,) over the universe that hit every corner of the membership functions."""
    low, high = variable.universe
    corners = [float(p) for function in variable.terms.values() for p in function.parameters]
    inside = [c for c in corners if low <= c <= high]
    # Just beside a corner too, so that a vertical edge is drawn vertical.
    beside = [c + side * 1e-9 * (high - low) for c in inside for side in (-1, 1)]
    return np.unique(np.clip([*np.linspace(low, high, points), *inside, *beside], low, high))


def place_of(which: str | int, variables: Sequence[Variable], what: str) -> int:
    """The place of a variable given by name or by place (negative places count from the end)."""
    names = [v.name for v in variables]
    if isinstance(which, str):
        if which not in names:
            raise FuzzySystemError(expected(which, names, what))
        return names.index(which)
    if not -len(names) <= which < len(names):
        raise FuzzySystemError(f"there is no {what} {which}; the system has {len(names)}, counted from 0")
    return which % len(names)


def point_of(fis: Sugeno, fixed: Mapping[Any, float] | None) -> np.ndarray:
    """The middle of every input's universe (inputs,), with the values of ``fixed`` (by name or place) in it."""
    point = np.array([v.midrange for v in fis.inputs])
    for which, value in (fixed or {}).items():
        if not np.isfinite(value):
            raise FuzzySystemError(f"the value of input {which!r} must be a finite number, got {value!r}")
        point[place_of(which, fis.inputs, "input")] = value
    return point


def consequent_range(fis: Sugeno, term: Any) -> tuple[float, float]:
    """The lowest and highest value of a consequent over the inputs' universes."""
    if not isinstance(term, Linear):
        return term.value, term.value
    ends = np.array([v.universe for v in fis.inputs]) * np.array(term.slopes)[:, None]  # (inputs, 2)
    return term.constant + ends.min(axis=1).sum(), term.constant + ends.max(axis=1).sum()
