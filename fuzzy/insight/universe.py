"""Points in the universes of discourse, grids of them, and the values that a consequent reaches there."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from fuzzy.naming import check_known
from fuzzy.system import FuzzySystemError, Linear, Sugeno, Variable


def universe_grid(variable: Variable, points: int = 401) -> np.ndarray:
    """Make a grid (points + a few,) over the universe that has a point at every corner of the membership functions."""
    low, high = variable.universe
    corners = [float(p) for function in variable.terms.values() for p in function.parameters]
    inside = [c for c in corners if low <= c <= high]
    # Just beside a corner too, so that a vertical edge is drawn vertical.
    beside = [c + side * 1e-9 * (high - low) for c in inside for side in (-1, 1)]
    return np.unique(np.clip([*np.linspace(low, high, points), *inside, *beside], low, high))


def place_of(which: str | int, variables: Sequence[Variable], what: str) -> int:
    """Find the place of a variable that is given by name or by place; negative places count from the end."""
    names = [v.name for v in variables]
    if isinstance(which, str):
        check_known(which, names, what, FuzzySystemError)
        return names.index(which)
    if not -len(names) <= which < len(names):
        raise FuzzySystemError(f"there is no {what} {which}; the system has {len(names)}, counted from 0")
    return which % len(names)


def point_of(fis: Any, fixed: Mapping[Any, float] | None) -> np.ndarray:
    """Make the point (inputs,) in the middle of every universe, except for the inputs that ``fixed`` gives values.

    ``fixed`` has inputs by name or by place.
    """
    point = np.array([v.midrange for v in fis.inputs])
    for which, value in (fixed or {}).items():
        if not np.isfinite(value):
            raise FuzzySystemError(f"the value of input {which!r} must be a finite number, got {value!r}")
        point[place_of(which, fis.inputs, "input")] = value
    return point


def consequent_range(fis: Sugeno, term: Any) -> tuple[float, float]:
    """Find the lowest and the highest value of a consequent over the universes of the inputs."""
    if not isinstance(term, Linear):
        return term.value, term.value
    ends = np.array([v.universe for v in fis.inputs]) * np.array(term.slopes)[:, None]  # (inputs, 2)
    return term.constant + ends.min(axis=1).sum(), term.constant + ends.max(axis=1).sum()
