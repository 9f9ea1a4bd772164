"""What a run costs: a sum of metrics, each in a unit of its own, fixed before anything is tuned.

The default is what the field would choose for tracking: J = RMS distance to the reference / 1 cm + RMS heading error /
5° + variation of the demanded turn rate / 1 rad/s². The distance, and not the cross-track error alone, which a robot
that lags or stands still can make as small as it likes. All of it is measured from 6 s on: what a start off the path
costs no law can avoid, and it would drown the rest. A run in which a robot was stopped, or touched anything, costs
FAILED_COST.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from math import pi
from typing import Any

import numpy as np

from fuzzy.naming import check_known
from fuzzy.quantity import check_quantities, described, quantity
from fuzzy.tuning.parameter import TuningError
from robotics.laws.law import Law
from robotics.measures.registry import own_metrics
from robotics.measures.tracking import Metric
from robotics.simulation.run import Run
from robotics.simulation.scenario.description import Scenario
from robotics.studies.population import simulate_many

FAILED_COST = 100.0
CONTACTS = "contacts"


@dataclass(frozen=True, kw_only=True)
class Term:
    """A metric in a cost: ``weight`` for each ``scale`` of it.

    Attributes:
        measure: Of a run: makes numbers (runs, robots), instead of a metric that has a name already.
    """

    metric: str = described(
        "The metric: a name, or a function of your own, mycost.py:comfort.", example="rms_cross_track_under_way_m"
    )
    scale: float = quantity(1.0, "1", above=0, doc="What of the metric, in its unit, costs 1.")
    weight: float = quantity(1.0, "1", least=0, doc="By which that is multiplied.")
    objective: str = described(
        'To which objective it is added, such as "precision" and "effort"; a front is looked for between two.', "cost"
    )

    measure: Callable[[Run], Any] | None = None

    def __post_init__(self) -> None:
        check_quantities(self, TuningError)

    @cached_property
    def own(self) -> dict[str, Metric]:
        """The metric, if it is one of the user's own, by the name that tables of results give it."""
        if self.measure is not None:
            return own_metrics([(self.metric, self.measure)])
        return own_metrics([self.metric]) if ":" in self.metric else {}

    @property
    def name(self) -> str:
        """What tables of results call the metric."""
        return next(iter(self.own), self.metric)


COST_TERMS = (
    Term(metric="rms_distance_late_m", scale=0.01, objective="precision"),
    Term(metric="rms_heading_late_rad", scale=5 * pi / 180, objective="precision"),
    Term(metric="w_variation_late_radps2", scale=1.0, objective="effort"),
)


@dataclass(frozen=True, kw_only=True)
class Cost:
    """A sum of terms, and what a run costs that failed.

    Attributes:
        terms: The terms, whose sum it is.
        failed: What a run costs in all in which a robot was stopped or touched something, and the most of any run.

    Raises:
        TuningError: A cost without terms.
    """

    terms: tuple[Term, ...] = COST_TERMS
    failed: float = FAILED_COST

    def __post_init__(self) -> None:
        if not self.terms:
            raise TuningError("a cost needs at least one term")

    @property
    def objectives(self) -> tuple[str, ...]:
        """The names of the objectives, in the order of the terms."""
        return tuple(dict.fromkeys(term.objective for term in self.terms))

    @property
    def metrics(self) -> tuple[str, ...]:
        """The names of the metrics that it needs, by which a table of results calls them."""
        return tuple(dict.fromkeys(term.name for term in self.terms))

    @property
    def own(self) -> dict[str, Metric]:
        """The metrics of the user's own, by name."""
        return {name: metric for term in self.terms for name, metric in term.own.items()}

    def weighted(self, factors: Mapping[str, float]) -> "Cost":
        """The same cost with the weights of some metrics multiplied.

        Args:
            factors: The factors by the names of metrics.

        Raises:
            TuningError: A metric without a term.
        """
        for metric in factors:
            check_known(metric, [t.metric for t in self.terms], "metric of the cost", TuningError)
        terms = (replace(term, weight=term.weight * factors.get(term.metric, 1.0)) for term in self.terms)
        return replace(self, terms=tuple(terms))

    def parts_of(self, metrics: Mapping[str, np.ndarray]) -> list[np.ndarray]:
        """What each of the terms adds.

        Args:
            metrics: The metrics by name, each (..., robots); the mean of a run's robots counts.

        Returns:
            The parts of the cost in the order of ``terms``, each (...,).
        """
        with np.errstate(invalid="ignore"):
            return [np.asarray(t.weight * metrics[t.name].mean(axis=-1) / t.scale) for t in self.terms]

    def objectives_of(self, metrics: Mapping[str, np.ndarray], stopped: np.ndarray) -> np.ndarray:
        """What runs cost (..., objectives).

        A metric is the mean of a run's robots. A run that failed, or costs more than one, costs ``failed`` in all: each
        objective has an equal share of it.

        Args:
            metrics: The metrics by name, each (..., robots).
            stopped: Whether robots were stopped (..., robots) bool.
        """
        names = self.objectives
        found = np.zeros((*stopped.shape[:-1], len(names)))
        for term, part in zip(self.terms, self.parts_of(metrics), strict=True):
            found[..., names.index(term.objective)] += part
        failed = stopped.any(axis=-1)
        if CONTACTS in metrics:
            failed |= (metrics[CONTACTS] > 0).any(axis=-1)
        failed |= ~(found.sum(axis=-1) < self.failed)
        found[failed] = self.failed / len(names)
        return found

    def of(self, metrics: Mapping[str, np.ndarray], stopped: np.ndarray) -> np.ndarray:
        """What runs cost (...,) in all; ``metrics`` and ``stopped`` are those of :meth:`objectives_of`."""
        return np.asarray(self.objectives_of(metrics, stopped).sum(axis=-1))

    def about(self) -> dict[str, Any]:
        """The cost as JSON can hold it."""
        terms = [
            {"metric": t.metric, "scale": t.scale, "weight": t.weight, "objective": t.objective} for t in self.terms
        ]
        return {"terms": terms, "failed": self.failed}


def costs_of(
    cost: Cost,
    scenarios: Sequence[Scenario],
    laws: Sequence[Law[Any] | str],
    seeds: Sequence[int],
    threads: int | None = None,
) -> np.ndarray:
    """What ``laws`` cost (laws, scenarios, seeds, objectives): every law drives every scenario with every seed.

    Raises as :func:`robotics.simulate_many`.
    """
    found = []
    for scenario in scenarios:
        names = [name for name in cost.metrics if name not in cost.own]
        names += [CONTACTS] if scenario.setting.has_others else []
        runs = simulate_many(scenario, laws, seeds, keep="metrics", metrics=names, own=cost.own, threads=threads)
        found.append(cost.objectives_of(runs.metrics, runs.stopped))
    return np.stack(found, axis=1)
