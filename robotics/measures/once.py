"""Measuring once: what is costly to find of a run is found when it is first asked for, and kept as long as the run."""

from collections.abc import Callable
from functools import wraps
from typing import TypeVar
from weakref import WeakKeyDictionary

import numpy as np

from robotics.simulation.run import Run

Found = TypeVar("Found")


def once_a_run(measure: Callable[[Run], Found]) -> Callable[[Run], Found]:
    """A measure, which depends on nothing but the run, that is computed once for each run; an array is read-only."""
    kept: WeakKeyDictionary[Run, Found] = WeakKeyDictionary()

    @wraps(measure)
    def measured(run: Run) -> Found:
        if run not in kept:
            found = kept[run] = measure(run)
            if isinstance(found, np.ndarray):
                found.flags.writeable = False
        return kept[run]

    return measured
