"""Which figures of merit belong to which kind of scenario."""

import numpy as np

from robotics.measures.tracking import METRICS, Metric
from robotics.simulation.run import Run


def metrics_of(kind: str) -> dict[str, Metric]:
    """The metrics of a scenario of that kind ("tracking", "formation" or "team"), by name."""
    if kind == "formation":
        from robotics.measures.formations import FORMATION_METRICS

        return METRICS | FORMATION_METRICS
    if kind == "team":
        from robotics.measures.teams import TEAM_METRICS

        return METRICS | TEAM_METRICS
    return METRICS


def measure_all(run: Run, kind: str) -> dict[str, np.ndarray]:
    """Every metric of a run of a scenario of that kind, each (runs, robots).

    A run's numbers do not depend, to the last bit, on which runs are beside it.
    """
    laid = run.time_innermost()
    return {name: metric.measure(laid) for name, metric in metrics_of(kind).items()}
