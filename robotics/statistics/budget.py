"""What a search is worth at each budget: the best cost so far, over repeats of the search."""

import numpy as np

from robotics.statistics.bootstrap import Interval
from robotics.statistics.costs import StatisticsError


def best_so_far(costs: np.ndarray) -> np.ndarray:
    """The least of the first n costs, for every n: (..., evaluations); not-a-number counts as a failure."""
    costs = np.asarray(costs, dtype=float)
    return np.minimum.accumulate(np.where(np.isnan(costs), np.inf, costs), axis=-1)


def over_budget(costs: np.ndarray, budgets: np.ndarray) -> Interval:
    """The best so far at each budget: the median over repeats, and their range, arrays (..., budgets).

    Of five repeats a percentile would be no more than the range, so the range is what is given. If the curves of two
    laws cross, the better law depends on the budget [Dodge 2019].

    Args:
        costs: The cost of each evaluation (..., repeats, evaluations), in the order in which the search made them.
        budgets: Numbers of evaluations (budgets,), from 1 to all.
    """
    best, budgets = best_so_far(costs), np.asarray(budgets)
    if ((budgets < 1) | (budgets > best.shape[-1])).any():
        raise StatisticsError(f"budgets must be from 1 to the {best.shape[-1]} evaluations that were made")
    at = np.sort(best[..., budgets - 1], axis=-2)
    lower, upper = at[..., (at.shape[-2] - 1) // 2, :], at[..., at.shape[-2] // 2, :]
    return Interval((lower + upper) / 2, at[..., 0, :], at[..., -1, :])


def expected_best(costs: np.ndarray, number: int) -> np.ndarray:
    """The expected least (...) of ``number`` evaluations drawn without replacement from costs (..., evaluations).

    It is the unbiased estimator of [Tang 2020], Σ C(N−i, n−1)/C(N, n) x₍ᵢ₎; that of [Dodge 2019], which draws with
    replacement, is too small. It is meant for evaluations that are independent of each other: those of a random search,
    or the ends of repeats. It is infinite if ``number`` evaluations can all have failed.

    Args:
        costs: The costs (..., evaluations); infinite where an evaluation failed.
        number: How many are drawn, from 1 to all.
    """
    from scipy.special import gammaln

    ranked = np.sort(np.asarray(costs, dtype=float), axis=-1)
    total = ranked.shape[-1]
    if not 1 <= number <= total:
        raise StatisticsError(f"the best of {number} cannot be told from {total} evaluations; ask for 1 to {total}")
    kept = total - number + 1  # the least of a draw is never among the others
    left = total - np.arange(1, kept + 1)
    weights = np.exp(_log_choose(gammaln, left, number - 1) - _log_choose(gammaln, np.array(total), number))
    weights /= weights.sum()
    some = weights > 0  # the rest are too small for a float; a failure among them is none
    return np.asarray((ranked[..., :kept][..., some] * weights[some]).sum(axis=-1))


def _log_choose(gammaln: np.ufunc, n: np.ndarray, k: int) -> np.ndarray:
    return np.asarray(gammaln(n + 1) - gammaln(k + 1) - gammaln(n - k + 1))
