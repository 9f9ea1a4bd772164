"""Which figures of merit belong to which kind of scenario."""

import numpy as np

from robotics.metrics import METRICS, Metric
from robotics.run import Run


def metrics_of(kind: str) -> dict[str, Metric]:
    """The metrics of a scenario of that kind ("tracking", "formation" or "team"), by name."""
    if kind == "formation":
        from robotics.formation import FORMATION_METRICS

        return METRICS | FORMATION_METRICS
    if kind == "team":
        from robotics.team import TEAM_METRICS

        return METRICS | TEAM_METRICS
    return METRICS


def measure_all(run: Run, kind: str) -> dict[str, np.ndarray]:
    """Every metric of a run of a scenario of that kind, each (runs, robots)."""
    return {name: metric.measure(run) for name, metric in metrics_of(kind).items()}
