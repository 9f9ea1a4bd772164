"""A search: an engine asked and told until the budget of evaluations is spent.

Nothing but the costs is remembered. Who kept those of a search that was stopped hands them in again: the engine is
asked the same questions, answered from what is known, and goes on from there to the same last bit.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
import pandas as pd

from fuzzy.tuning.engines import engine_of
from fuzzy.tuning.parameter import SearchParameter, TuningError, start_of, values_at

Cost = Callable[[np.ndarray], np.ndarray]  # of values (points, parameters): (points,), or (points, objectives)


@dataclass(frozen=True, eq=False)
class Evaluations:
    """All that a search has evaluated, in its order; the first one is the start."""

    parameters: tuple[SearchParameter, ...]
    values: np.ndarray = field(repr=False)  # (evaluations, parameters)
    objectives: np.ndarray = field(repr=False)  # (evaluations, objectives): what was measured
    names: tuple[str, ...] = ("cost",)  # of the objectives

    def __len__(self) -> int:
        return len(self.values)

    @cached_property
    def costs(self) -> np.ndarray:
        """What the engine made smaller (evaluations,): the sum of the objectives."""
        return np.asarray(self.objectives.sum(axis=1))

    @property
    def best(self) -> int:
        """The place of the best evaluation, of equal ones the first."""
        return int(np.argmin(self.costs))

    def best_within(self, evaluations: int) -> int:
        """The place of the best of the first ``evaluations``."""
        return int(np.argmin(self.costs[: max(evaluations, 1)]))

    @property
    def front(self) -> np.ndarray:
        """The places of the evaluations that no other one beats in all objectives, by the first objective."""
        return pareto_front(self.objectives)

    def table(self) -> pd.DataFrame:
        """A row an evaluation: its number, its cost, the best so far, its objectives and its parameters."""
        columns = {"evaluation": np.arange(1, len(self) + 1), "cost": self.costs}
        columns["best"] = np.minimum.accumulate(self.costs)
        if len(self.names) > 1:
            columns |= dict(zip(self.names, self.objectives.T, strict=True))
        for parameter, column in zip(self.parameters, self.values.T, strict=True):
            columns[parameter.name] = (
                np.array(parameter.choices, dtype=object)[column.astype(int)] if parameter.choices else column
            )
        return pd.DataFrame(columns)


def search(
    cost: Cost,
    parameters: Sequence[SearchParameter],
    *,
    evaluations: int,
    seed: int,
    engine: str = "cmaes",
    names: Sequence[str] = ("cost",),
    known: np.ndarray | None = None,
    after: Callable[[Evaluations], bool | None] | None = None,
) -> Evaluations:
    """Look for the parameters with the least cost.

    Args:
        cost: The cost of a generation of values (points, parameters): (points,), or (points, objectives), whose sum is
            made smaller. Infinite and not-a-number are the worst.
        parameters: What may change.
        evaluations: The budget, the start included.
        seed: That of the engine.
        engine: "cmaes" or "random".
        names: What the objectives are called.
        known: The objectives (evaluations, objectives) of the beginning of the same search, whole generations of it,
            which are not computed again.
        after: Called after every generation that is not known, and after the last one that is, with all evaluations so
            far; True ends the search.

    Raises TuningError for an unknown engine, for a budget of less than one, and where nothing may change.
    """
    if evaluations < 1:
        raise TuningError(f"evaluations must be a whole number >= 1; got {evaluations}")
    if not parameters:
        raise TuningError("nothing may change: there is no parameter to tune")
    parameters = tuple(parameters)
    told = np.empty((0, len(names))) if known is None else np.asarray(known, dtype=float).reshape(-1, len(names))
    searcher, points = engine_of(engine, parameters, seed), start_of(parameters)[None]
    values, found = np.empty((0, len(parameters))), np.empty((0, len(names)))
    while True:
        count = len(values)
        rows = values_at(parameters, points[: evaluations - count])
        if not count:
            rows = np.array([[p.start for p in parameters]])  # not rounded by the way there and back
        if count + len(rows) <= len(told):
            costs = told[count : count + len(rows)]
        else:
            costs = np.asarray(cost(rows), dtype=float).reshape(len(rows), len(names))
            costs = np.where(np.isnan(costs), np.inf, costs)
        values, found = np.concatenate([values, rows]), np.concatenate([found, costs])
        so_far = Evaluations(parameters, values, found, tuple(names))
        repeated = len(values) < min(len(told), evaluations)
        if (after is not None and not repeated and after(so_far)) or len(values) >= evaluations:
            return so_far
        if count:
            searcher.tell(points, costs)
        else:
            searcher.begin(float(costs.sum()))
        points = searcher.ask()


def pareto_front(objectives: np.ndarray) -> np.ndarray:
    """The places of the rows (rows, objectives) that no other row beats: nowhere worse, and somewhere better.

    Of equal rows the first counts; rows with an infinite objective do not. They are in the order of the first
    objective.
    """
    finite = np.flatnonzero(np.isfinite(objectives).all(axis=1))
    order = finite[np.lexsort(objectives[finite].T[::-1])]
    kept: list[int] = []
    for place in order:
        if not any((objectives[other] <= objectives[place]).all() for other in kept):
            kept.append(int(place))
    return np.array(kept, dtype=int)
