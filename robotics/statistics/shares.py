"""Shares of runs with their intervals: failures, performance profiles, the probability that a law does better."""

import numpy as np

from robotics.statistics.bootstrap import resamples
from robotics.statistics.costs import checked
from robotics.statistics.intervals import Interval, wilson


def failure_rate(costs: np.ndarray, level: float = 0.95) -> Interval:
    """The share of runs that failed, arrays (laws,), with Wilson's interval; costs are (laws, scenarios, seeds)."""
    costs = checked(costs)
    return wilson(np.isinf(costs).sum(axis=(1, 2)), costs[0].size, level)


def performance_profile(
    costs: np.ndarray, limits: np.ndarray, *, generator: np.random.Generator, level: float = 0.95, draws: int = 2000
) -> Interval:
    """The share of runs that cost at most each limit, arrays (laws, limits) [Dolan & Moré 2002; Agarwal 2021].

    The intervals are pointwise, by the bootstrap within scenarios. A failed run is above every finite limit.

    Args:
        costs: The costs (laws, scenarios, seeds).
        limits: The limits τ (limits,).
        generator: Where the resamples come from.
        level: How often such an interval holds the true share.
        draws: The number of resamples.
    """
    costs = checked(costs)
    below = costs[:, None] <= np.asarray(limits, dtype=float)[:, None, None]
    return _shares(below, resamples(costs.shape[1:], draws, generator), level)


def probability_of_improvement(
    costs: np.ndarray,
    *,
    paired: bool = True,
    generator: np.random.Generator,
    level: float = 0.95,
    draws: int = 2000,
) -> Interval:
    """The probability that the row's law costs less than the column's, arrays (laws, laws); ties count half.

    Paired, it is the share of starts and noises on which the row's law does better: what the user of one robot meets.
    Unpaired, it is the chance that a run of one law beats a run of the other with another start and noise, a mean over
    scenarios, as [Agarwal 2021] has it: the Mann-Whitney statistic over the pairs of different seeds. Two failed runs
    are a tie.

    Args:
        costs: The costs (laws, scenarios, seeds).
        paired: Whether runs are compared at the same seed only.
        generator: Where the resamples come from.
        level: How often such an interval holds the true probability.
        draws: The number of resamples.
    """
    costs = checked(costs)
    counts = resamples(costs.shape[1:], draws, generator)
    if paired:
        return _shares(_won(costs[:, None], costs[None]), counts, level)
    return _unpaired(costs, counts, level)


def _won(ours: np.ndarray, theirs: np.ndarray) -> np.ndarray:
    """1 where ours is less, 1/2 where both are equal, 0 elsewhere, as numbers that float32 holds exactly."""
    return (ours < theirs).astype(np.float32) + np.float32(0.5) * (ours == theirs)


def _shares(scores: np.ndarray, counts: np.ndarray, level: float) -> Interval:
    """The means of scores (..., scenarios, seeds) from 0 to 1 with bootstrap intervals.

    Where all runs say the same, resamples do too, and Wilson's interval stands instead of one without width.
    """
    shape, runs = scores.shape[:-2], scores[0].size // int(np.prod(scores.shape[1:-2]))
    flat = scores.reshape(-1, runs).astype(np.float32)  # sums of halves are exact: the order of summation is free
    value = flat.mean(axis=1, dtype=float)
    drawn = flat @ counts.reshape(runs, -1).astype(np.float32) / counts[..., 0].sum()
    return _with_ends(value, drawn.T, np.ptp(flat, axis=1) == 0, runs, level, shape)


def _with_ends(
    value: np.ndarray, drawn: np.ndarray, same: np.ndarray, runs: int, level: float, shape: tuple[int, ...]
) -> Interval:
    """Percentile intervals of value (k,) from drawn (draws, k), Wilson's where all runs are the ``same`` (k,)."""
    low, high = np.quantile(drawn, [(1 - level) / 2, (1 + level) / 2], axis=0)
    instead = wilson(value * runs, runs, level)
    low, high = np.where(same, instead.low, low), np.where(same, instead.high, high)
    return Interval(value.reshape(shape), low.reshape(shape), high.reshape(shape))


def _unpaired(costs: np.ndarray, counts: np.ndarray, level: float) -> Interval:
    """The mean over scenarios of how often one law wins against another at a different seed, for every two laws.

    At one seed both laws meet the same noise, so these pairs are left out: with them resamples, in which a seed comes
    several times, would favour the law that wins pair by pair.
    """
    laws, scenarios, seeds = costs.shape
    weights, others = counts.astype(np.float32), ~np.eye(seeds, dtype=bool)
    among = float(counts[0, :, 0].sum()) ** 2
    pairs = (among - np.einsum("snd,snd->sd", weights, weights)).astype(float)  # at different seeds, of a resample
    pairs[pairs == 0] = np.nan  # one seed alone was drawn
    value, drawn = np.full((laws, laws), 0.5), np.full((counts.shape[2], laws, laws), 0.5)
    same = np.eye(laws, dtype=bool)
    for a in range(laws):
        for b in range(a):
            won = _won(costs[a][:, :, None], costs[b][:, None, :])  # (scenarios, seeds of a, seeds of b)
            value[a, b] = won[:, others].mean(dtype=float)
            same[a, b] = same[b, a] = np.ptp(won[:, others]) == 0
            won *= others
            wins = np.stack([np.einsum("nd,nd->d", w, m @ w) for w, m in zip(weights, won, strict=True)])
            drawn[:, a, b] = np.nan_to_num(wins / pairs, nan=0.5).mean(axis=0)
            value[b, a], drawn[:, b, a] = 1 - value[a, b], 1 - drawn[:, a, b]
    runs = scenarios * seeds
    return _with_ends(value.ravel(), drawn.reshape(len(drawn), -1), same.ravel(), runs, level, (laws, laws))
