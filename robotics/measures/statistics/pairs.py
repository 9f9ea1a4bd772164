"""Which of two laws is better: tests over all pairs, and verdicts by a margin that matters."""

import numpy as np

from robotics.measures.statistics.aggregates import IQM
from robotics.measures.statistics.bootstrap import Statistic, contrasts
from robotics.measures.statistics.costs import StatisticsError, checked

MARGIN = 0.05  # of the cost: what is less makes no difference to whoever chooses a controller


def signed_rank_p_values(costs: np.ndarray) -> np.ndarray:
    """Two-sided p-values (laws, laws) of Wilcoxon's signed-rank test over all runs [Wilcoxon 1945].

    The test is on the differences of cost at the same scenario and seed, by the normal approximation with corrections
    for ties and zeros [Pratt 1959]. A run that one law alone failed is the largest difference; one that both failed is
    none. The diagonal, and laws that cost the same in every run, have p = 1. The values are not adjusted: see
    :func:`holm`.

    Args:
        costs: The costs (laws, scenarios, seeds).
    """
    from scipy.stats import wilcoxon

    costs = checked(costs)
    flat, found = costs.reshape(len(costs), -1), np.ones((len(costs), len(costs)))
    rows, columns = np.triu_indices(len(costs), k=1)
    with np.errstate(invalid="ignore"):
        apart = flat[rows] - flat[columns]
    apart[np.isnan(apart)] = 0.0  # ∞ − ∞
    some = (apart != 0).any(axis=1)
    if some.any():
        p = wilcoxon(apart[some], axis=1, zero_method="pratt", method="asymptotic").pvalue
        found[rows[some], columns[some]] = found[columns[some], rows[some]] = p
    return found


def holm(p_values: np.ndarray) -> np.ndarray:
    """The p-values adjusted by Holm's step-down: all that are at most α hold together at level α [Holm 1979].

    Sorted, the k-th of m becomes the largest of (m + 1 − j) p_j for j ≤ k, at most 1.

    Args:
        p_values: The p-values (m,) of all tests; or a symmetric matrix (laws, laws) of them, of which each pair counts
            once and the diagonal not at all.
    """
    p_values = np.asarray(p_values, dtype=float)
    if p_values.ndim == 2:
        if p_values.shape[0] != p_values.shape[1] or not np.array_equal(p_values, p_values.T, equal_nan=True):
            raise StatisticsError("a matrix of p-values must be symmetric: each pair of laws is tested once")
        adjusted, upper = np.ones_like(p_values), np.triu_indices(len(p_values), k=1)
        adjusted[upper] = holm(p_values[upper])
        return np.minimum(adjusted, adjusted.T)
    if not ((p_values >= 0) & (p_values <= 1)).all():
        raise StatisticsError("p-values must lie between 0 and 1")
    order, m = np.argsort(p_values, kind="stable"), len(p_values)
    adjusted = np.empty(m)
    adjusted[order] = np.minimum(1.0, np.maximum.accumulate((m - np.arange(m)) * p_values[order]))
    return adjusted


def verdicts(
    costs: np.ndarray,
    statistic: Statistic = IQM,
    *,
    generator: np.random.Generator,
    margin: float = MARGIN,
    draws: int = 2000,
    p_values: np.ndarray | None = None,
) -> np.ndarray:
    """What can be said of the row's law against the column's: a :data:`PairVerdict` in each place (laws, laws).

    It is about the ratio of the statistic. "equivalent" is said first: the ratio's 90 % interval lies between 1 −
    margin and 1/(1 − margin), which is the two one-sided tests at 5 % [Schuirmann 1987]. These limits, and not 1 ±
    margin, mirror each other, so that a law is equivalent to another if and only if the other is to it. A law is
    "better" if the ratio's 95 % interval lies below 1, and "worse" if it lies above. Otherwise the pair is "undecided":
    more runs may tell. A law that fails too often for a finite statistic is worse than one that does not; of two that
    do nothing is said.

    Args:
        costs: The costs (laws, scenarios, seeds).
        statistic: What is compared; it must be > 0.
        generator: Where the resamples come from.
        margin: The share of the cost that makes no difference.
        draws: The number of resamples.
        p_values: Adjusted p-values (laws, laws), of :func:`holm`; if given, "better" and "worse" ask for p < 0.05, too.
    """
    if not 0 < margin < 1:
        raise StatisticsError(f"the margin is {margin:g}; it must lie between 0 and 1")
    # Both intervals come from the same resamples, so that the narrower one lies inside the wider.
    seed = int(generator.integers(2**63))
    narrow, wide = (
        contrasts(costs, statistic, generator=np.random.default_rng(seed), level=level, draws=draws)
        for level in (0.90, 0.95)
    )
    told = np.full(narrow.value.shape, True) if p_values is None else np.asarray(p_values) < 0.05
    equivalent = (narrow.low >= 1 - margin) & (narrow.high <= 1 / (1 - margin))
    found = np.full(narrow.value.shape, "undecided", dtype="<U10")
    found[told & (wide.high < 1)] = "better"
    found[told & (wide.low > 1)] = "worse"
    found[equivalent] = "equivalent"
    # A scenario on which a law fails may be left out of a resample, but not of the statistic
    found[np.isinf(narrow.value)] = "worse"
    found[narrow.value == 0] = "better"
    return found
