"""Rankings: how sure each rank is, whether it hangs on the cost's weights, and who is beaten in nothing."""

from dataclasses import dataclass

import numpy as np

from robotics.measures.statistics.aggregates import IQM
from robotics.measures.statistics.bootstrap import Statistic, drawn_again, percentiles
from robotics.measures.statistics.costs import StatisticsError, checked
from robotics.measures.statistics.intervals import LEVEL, Interval


@dataclass(frozen=True, eq=False)
class Reweighted:
    """The ranking of laws under other weights of the cost's terms."""

    weights: np.ndarray  # (cases, terms); the first case has the weights as they are
    values: np.ndarray  # (cases, laws), the statistic of the cost
    order: np.ndarray  # (cases, laws), the laws from the least cost to the greatest

    @property
    def changed(self) -> np.ndarray:
        """Whether the order differs from that of the first case: (cases,) bool."""
        return np.asarray((self.order != self.order[0]).any(axis=1))

    @property
    def swapped(self) -> np.ndarray:
        """How many pairs of laws stand the other way round than in the first case: (cases,)."""
        return swapped_pairs(self.order)


def swapped_pairs(orders: np.ndarray) -> np.ndarray:
    """How many pairs stand the other way round than in the first of the orders (cases, laws): Kendall's distance."""
    first, second = np.triu_indices(orders.shape[1], k=1)
    ranks = np.argsort(orders, axis=1)
    ahead = ranks[:, first] < ranks[:, second]
    return np.asarray((ahead != ahead[0]).sum(axis=1))


def reweighted(terms: np.ndarray, weights: np.ndarray, statistic: Statistic = IQM) -> Reweighted:
    """Rank the laws with the weight of each term in turn halved, and doubled.

    Args:
        terms: The terms of the cost (terms, laws, scenarios, seeds), each over its scale; infinite where a run failed.
        weights: The weights (terms,), > 0: the cost is their sum over terms.
        statistic: What ranks the laws.
    """
    terms, weights = np.asarray(terms, dtype=float), np.asarray(weights, dtype=float)
    if terms.ndim != 4 or weights.shape != terms.shape[:1] or not (weights > 0).all():
        raise StatisticsError("give terms (terms, laws, scenarios, seeds) and a weight > 0 for each term")
    own = np.eye(len(weights), dtype=bool)
    cases = np.array([weights, *(np.where(term, factor * weights, weights) for term in own for factor in (0.5, 2.0))])
    values = np.stack([statistic(checked(np.tensordot(case, terms, axes=1))) for case in cases])
    return Reweighted(cases, values, np.argsort(values, axis=1, kind="stable"))


def gap_closed(
    before: np.ndarray,
    after: np.ndarray,
    reference: np.ndarray,
    statistic: Statistic = IQM,
    *,
    generator: np.random.Generator,
    draws: int = 2000,
) -> Interval:
    """The share of the gap to a reference law that tuning closes, (before − after)/(before − reference), arrays
    (laws,).

    1 reaches the reference, 0 gains nothing, below 0 loses. Not-a-number where there is no gap, because the law was not
    worse than the reference; such resamples widen the interval on both sides.

    Args:
        before: The costs (laws, scenarios, seeds) as published.
        after: The costs (laws, scenarios, seeds) tuned, on the same seeds.
        reference: The costs (scenarios, seeds) of the reference law, on the same seeds.
        statistic: What is compared.
        generator: Where the resamples come from.
        draws: The number of resamples.
    """
    costs = checked(np.concatenate([before, after, reference[None]]))
    found = np.concatenate([statistic(costs)[None], drawn_again(costs, statistic, draws, generator)[1]])
    laws = len(before)
    first, second, third = found[:, :laws], found[:, laws : 2 * laws], found[:, -1:]
    with np.errstate(invalid="ignore", divide="ignore"):
        share = np.where(first > third, (first - second) / (first - third), np.nan)
    return Interval(share[0], *percentiles(share[1:], LEVEL))


def pareto_front(objectives: np.ndarray) -> np.ndarray:
    """Which points are beaten by no other in all objectives at once: (points,) bool.

    A point is beaten by one that is nowhere greater and somewhere less; equal points do not beat each other. A point
    with an infinite objective is never on the front.

    Args:
        objectives: The points (points, objectives); less is better.
    """
    objectives = np.asarray(objectives, dtype=float)
    nowhere = (objectives[None] <= objectives[:, None]).all(axis=2)
    somewhere = (objectives[None] < objectives[:, None]).any(axis=2)
    beaten = np.asarray(nowhere & somewhere).any(axis=1)
    return ~beaten & np.isfinite(objectives).all(axis=1)
