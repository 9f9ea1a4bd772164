"""Measuring once: what is costly to find of a run is found when it is first asked for, and kept as long as the run."""

from collections.abc import Callable
from functools import wraps
from weakref import WeakKeyDictionary

import numpy as np

from robotics.simulation.run import Run


def once_a_run(measure: Callable[[Run], np.ndarray]) -> Callable[[Run], np.ndarray]:
    """A measure, which depends on nothing but the run, that is computed once for each run; its arrays are read-only."""
    kept: WeakKeyDictionary[Run, np.ndarray] = WeakKeyDictionary()

    @wraps(measure)
    def measured(run: Run) -> np.ndarray:
        found = kept.get(run)
        if found is None:
            found = kept[run] = measure(run)
            found.flags.writeable = False
        return found

    return measured
