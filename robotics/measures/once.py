"""Measuring once: what is costly to find of a run is found when it is first asked for, and kept as long as the run."""

from collections.abc import Callable
from functools import update_wrapper
from typing import Generic, TypeVar
from weakref import WeakKeyDictionary

import numpy as np

from robotics.simulation.run import Run

Found = TypeVar("Found")


class CachedPerRun(Generic[Found]):
    """A measure, which depends on nothing but the run, that is computed once for each run; an array is read-only."""

    def __init__(self, measure: Callable[[Run], Found]) -> None:
        self._measure = measure
        self._kept: WeakKeyDictionary[Run, Found] = WeakKeyDictionary()
        update_wrapper(self, measure)

    def __call__(self, run: Run) -> Found:
        """What the measure finds of ``run``."""
        if run not in self._kept:
            found = self._kept[run] = self._measure(run)
            if isinstance(found, np.ndarray):
                found.flags.writeable = False
        return self._kept[run]

    def known(self, run: Run) -> bool:
        """Whether the run has been measured already."""
        return run in self._kept
