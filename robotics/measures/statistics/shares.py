"""Shares of runs with their intervals: failures, the probability that a law does better."""

import numpy as np

from robotics.measures.statistics.bootstrap import resamples
from robotics.measures.statistics.costs import checked
from robotics.measures.statistics.intervals import LEVEL, Interval, wilson


def failure_rate(costs: np.ndarray) -> Interval:
    """The share of runs that failed, arrays (laws,), with Wilson's interval; costs are (laws, scenarios, seeds)."""
    costs = checked(costs)
    return wilson(np.isinf(costs).sum(axis=(1, 2)), costs[0].size)


def probability_of_improvement(costs: np.ndarray, *, generator: np.random.Generator, draws: int = 2000) -> Interval:
    """The probability that the row's law costs less than the column's, arrays (laws, laws); ties count half.

    It is the share of starts and noises on which the row's law does better: what the user of one robot meets. Two
    failed runs are a tie.

    Args:
        costs: The costs (laws, scenarios, seeds).
        generator: Where the resamples come from.
        draws: The number of resamples.
    """
    costs = checked(costs)
    ours, theirs = costs[:, None], costs[None]
    won = (ours < theirs).astype(np.float32) + np.float32(0.5) * (ours == theirs)  # which float32 holds exactly
    return _shares(won, resamples(costs.shape[1:], draws, generator))


def _shares(scores: np.ndarray, counts: np.ndarray) -> Interval:
    """The means of scores (..., scenarios, seeds) from 0 to 1 with percentile intervals by the bootstrap.

    Where all runs say the same, resamples do too, and Wilson's interval stands instead of one without width.
    """
    shape, runs = scores.shape[:-2], scores[0].size // int(np.prod(scores.shape[1:-2]))
    flat = scores.reshape(-1, runs).astype(np.float32)  # sums of halves are exact: the order of summation is free
    value = flat.mean(axis=1, dtype=float)
    drawn = flat @ counts.reshape(runs, -1).astype(np.float32) / counts[..., 0].sum()
    low, high = np.quantile(drawn.T, [(1 - LEVEL) / 2, (1 + LEVEL) / 2], axis=0)
    same, instead = np.ptp(flat, axis=1) == 0, wilson(value * runs, runs)
    low, high = np.where(same, instead.low, low), np.where(same, instead.high, high)
    return Interval(value.reshape(shape), low.reshape(shape), high.reshape(shape))
