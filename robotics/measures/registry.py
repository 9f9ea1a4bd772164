"""Every metric in one table, and which of them belong to a kind of scenario, to a short table, to the designer."""

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
    """The metrics of a scenario of that kind ("tracking", "formation" or "team"), by name."""
    return {name: metric for name, metric in ALL_METRICS.items() if kind in metric.kinds}


def headlines(kind: str) -> dict[str, Metric]:
    """The few metrics that a short table or picture shows of that kind, by name: those of no other kind come first."""
    found = [item for item in metrics_of(kind).items() if kind in item[1].headline]
    return dict(sorted(found, key=lambda item: len(item[1].kinds)))


def tried(kind: str) -> dict[str, Metric]:
    """The metrics that the designer's panel "Try it" shows of that kind, by name, in the same order."""
    found = [item for item in metrics_of(kind).items() if kind in item[1].tried]
    return dict(sorted(found, key=lambda item: len(item[1].kinds)))


def measure_all(run: Run) -> dict[str, np.ndarray]:
    """Every metric of a run of a scenario of that kind, each (runs, robots).

    A run's numbers do not depend, to the last bit, on which runs are beside it.
    """
    laid = run.time_innermost()
    return {name: metric.measure(laid) for name, metric in metrics_of(run.about.kind).items()}
