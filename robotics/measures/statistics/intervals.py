"""Intervals: numbers with the ends between which they lie, Wilson's and the exact one of a rate, Student's of a mean.

Those by the bootstrap are made in :mod:`robotics.measures.statistics.bootstrap`.
"""

from dataclasses import dataclass
from math import isfinite, sqrt
from typing import Any

import numpy as np

LEVEL = 0.95  # how often an interval holds the true value


@dataclass(frozen=True, eq=False)
class Interval:
    """Numbers and the ends of their intervals, three arrays of one shape."""

    value: np.ndarray
    low: np.ndarray
    high: np.ndarray

    def __getitem__(self, index: Any) -> "Interval":
        """The part of all three arrays that ``index`` names: ``ratios[:, 0]``."""
        return Interval(self.value[index], self.low[index], self.high[index])


def wilson(count: np.ndarray | int, trials: np.ndarray | int, level: float = LEVEL) -> Interval:
    """A rate of which ``count`` of ``trials`` are seen, with Wilson's interval [Wilson 1927].

    Args:
        count: How often it happened (...); ties may count half.
        trials: Of how many (...).
        level: How often such intervals hold the true rate.

    >>> found = wilson(0, 20)
    >>> round(float(found.high), 4)
    0.1611
    """
    from scipy.special import ndtri

    count, trials = np.broadcast_arrays(np.asarray(count, dtype=float), np.asarray(trials, dtype=float))
    z = float(ndtri((1 + level) / 2))
    share = count / trials
    middle = (share + z * z / (2 * trials)) / (1 + z * z / trials)
    half = z / (1 + z * z / trials) * np.sqrt(share * (1 - share) / trials + z * z / (4 * trials * trials))
    # At the ends the exact bound is 0 or 1; rounding must not leave it.
    low, high = np.where(count == 0, 0.0, middle - half), np.where(count == trials, 1.0, middle + half)
    return Interval(share, low, high)


def clopper_pearson(count: np.ndarray | int, trials: np.ndarray | int, level: float = LEVEL) -> Interval:
    """A rate of which ``count`` of ``trials`` are seen, with the exact interval [Clopper and Pearson 1934].

    It holds the true rate at least as often as ``level`` says, however few are seen; of none of n it is 0 to
    1 − ((1 − level)/2)^{1/n}.

    Args:
        count: How often it happened, whole numbers (...).
        trials: Of how many independent ones (...), at least 1.
        level: How often such intervals hold the true rate.

    >>> found = clopper_pearson(0, 20)
    >>> round(float(found.high), 4)
    0.1684
    """
    from scipy.special import betaincinv

    count, trials = np.broadcast_arrays(np.asarray(count, dtype=float), np.asarray(trials, dtype=float))
    tail, none, all_ = (1 - level) / 2, count == 0, count == trials
    low = np.where(none, 0.0, betaincinv(np.where(none, 1.0, count), trials - count + 1, tail))
    high = np.where(all_, 1.0, betaincinv(count + 1, np.where(all_, 1.0, trials - count), 1 - tail))
    return Interval(count / trials, low, high)


def student(values: np.ndarray) -> tuple[float, float]:
    """Student's 95 % interval of the mean of ``values`` (seeds,), mean ± t s/√n.

    Not-a-number for fewer than two seeds, and where the mean is not finite.
    """
    from scipy.stats import t

    n, mean = len(values), float(np.mean(values))
    if n < 2 or not isfinite(mean):
        return float("nan"), float("nan")
    half = float(t.ppf(0.975, n - 1) * np.std(values, ddof=1) / sqrt(n))
    return mean - half, mean + half
