"""The table of all metrics, and which of them are shown for a kind of scenario."""

from collections import ChainMap
from collections.abc import Mapping

import numpy as np

from robotics.measures.formations import FORMATION_METRICS
from robotics.measures.teams import TEAM_METRICS
from robotics.measures.tracking import METRICS, Metric
from robotics.simulation.run import Run

# A view of the three tables, METRICS first, in which an entry that is added to one of them is found too.
ALL_METRICS: Mapping[str, Metric] = ChainMap(TEAM_METRICS, FORMATION_METRICS, METRICS)


def metrics_of(kind: str) -> dict[str, Metric]:
    """The metrics of scenarios of a ``kind`` ("tracking", "formation" or "team"), by name."""
    return {name: metric for name, metric in ALL_METRICS.items() if kind in metric.kinds}


def headlines(kind: str) -> dict[str, Metric]:
    """The few metrics that short tables and pictures show of a ``kind``, by name; those of no other kind come first."""
    found = [item for item in metrics_of(kind).items() if kind in item[1].headline]
    return dict(sorted(found, key=lambda item: len(item[1].kinds)))


def tried(kind: str) -> dict[str, Metric]:
    """The metrics that the designer's panel "Try it" shows of a ``kind``, by name, ordered as :func:`headlines`."""
    found = [item for item in metrics_of(kind).items() if kind in item[1].tried]
    return dict(sorted(found, key=lambda item: len(item[1].kinds)))


def measure_all(run: Run) -> dict[str, np.ndarray]:
    """Measure every metric that belongs to the kind of the run's scenario, each (runs, robots).

    A run's numbers do not depend, to the last bit, on which runs are beside it.
    """
    laid = run.time_innermost()
    return {name: metric.measure(laid) for name, metric in metrics_of(run.about.kind).items()}
