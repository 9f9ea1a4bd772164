"""Intervals by the bootstrap: seeds are drawn again within each scenario, the same ones for every law.

Drawing the same seeds for every law keeps the pairs together, so that what all laws share (a hard start, much noise)
goes out of differences and ratios. Drawing within scenarios keeps the share of each scenario [Agarwal 2021].
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np

from robotics.statistics.aggregates import IQM, QuantileMean
from robotics.statistics.costs import StatisticsError, checked

Statistic = Callable[[np.ndarray], np.ndarray]  # costs (..., scenarios, seeds) to (...)
Method = Literal["percentile", "bca"]
_AT_ONCE = 1 << 24  # numbers resampled at a time, where a statistic is no quantile mean


@dataclass(frozen=True, eq=False)
class Interval:
    """Numbers and the ends of their intervals, three arrays of one shape."""

    value: np.ndarray
    low: np.ndarray
    high: np.ndarray

    def __getitem__(self, index: Any) -> "Interval":
        """The part of all three arrays that ``index`` names: ``ratios[:, 0]``."""
        return Interval(self.value[index], self.low[index], self.high[index])


def resamples(shape: tuple[int, ...], draws: int, generator: np.random.Generator) -> np.ndarray:
    """How often each run is drawn: (scenarios, seeds, draws), of each scenario as many as there are, with replacement.

    Args:
        shape: The number of scenarios and the number of seeds.
        draws: The number of resamples.
        generator: Where they come from.
    """
    scenarios, seeds = shape
    chosen = generator.integers(0, seeds, size=(scenarios, seeds, draws), dtype=np.int32)
    places = chosen + seeds * np.arange(scenarios, dtype=np.int32)[:, None, None]
    flat = places.astype(np.int64) * draws + np.arange(draws)
    counts = np.bincount(flat.ravel(), minlength=scenarios * seeds * draws)
    return counts.astype(np.int16 if seeds < 2**15 else np.int32).reshape(scenarios, seeds, draws)


def resampled(costs: np.ndarray, statistic: Statistic, counts: np.ndarray) -> np.ndarray:
    """A statistic of every law in every resample: (draws, laws).

    Args:
        costs: The costs (laws, scenarios, seeds).
        statistic: A :class:`QuantileMean`, or any function from costs (..., scenarios, seeds) to (...), which is
        slower. counts: The resamples, of :func:`resamples`.
    """
    if isinstance(statistic, QuantileMean):
        return np.stack([statistic.of_resamples(own, counts) for own in costs], axis=1)
    scenarios, seeds, draws = counts.shape
    found = np.empty((draws, len(costs)))
    step = max(1, _AT_ONCE // costs.size)
    for first in range(0, draws, step):
        part = counts[..., first : first + step]
        # Each scenario's runs are repeated as often as they were drawn, and stand side by side again.
        runs = np.repeat(np.tile(np.arange(seeds), scenarios * part.shape[2]), np.moveaxis(part, 2, 0).ravel())
        chosen = runs.reshape(part.shape[2], 1, scenarios, seeds)
        found[first : first + step] = statistic(np.take_along_axis(costs[None], chosen, axis=3))
    return found


def interval(
    costs: np.ndarray,
    statistic: Statistic = IQM,
    *,
    generator: np.random.Generator,
    level: float = 0.95,
    draws: int = 2000,
    method: Method = "percentile",
) -> Interval:
    """A statistic of each law with its bootstrap interval, arrays (laws,).

    Args:
        costs: The costs (laws, scenarios, seeds).
        statistic: What is estimated, such as IQM or CVAR of robotics.statistics.aggregates.
        generator: Where the resamples come from.
        level: How often such intervals hold the true value.
        draws: The number of resamples.
        method: "percentile", or "bca", corrected for bias and skewness [Efron 1987]: for a :class:`QuantileMean` only.

    An end is infinite where failures are frequent enough in the resamples. Raises StatisticsError for costs that
    :func:`checked` refuses.
    """
    costs = checked(costs)
    counts = resamples(costs.shape[1:], draws, generator)
    value, drawn = statistic(costs), resampled(costs, statistic, counts)
    slopes = _slopes(costs, statistic, value) if method == "bca" else None
    return Interval(value, *_ends(value, drawn, level, slopes))


def contrasts(
    costs: np.ndarray,
    statistic: Statistic = IQM,
    kind: Literal["ratio", "difference"] = "ratio",
    *,
    generator: np.random.Generator,
    level: float = 0.95,
    draws: int = 2000,
    method: Method = "percentile",
) -> Interval:
    """The ratio or difference of a statistic for every two laws, arrays (laws, laws): row over, or minus, column.

    ``contrasts(...)[:, k]`` compares every law with law k. Where only the column's law fails, the ratio is 0 and the
    difference minus infinity; where both fail nothing can be said, the value is not-a-number, and such a resample
    widens the interval on both sides.

    Args:
        costs: The costs (laws, scenarios, seeds); for ratios the statistic must be > 0 for every law.
        statistic: What is compared.
        kind: "ratio" or "difference".
        generator: Where the resamples come from.
        level: How often such intervals hold the true value.
        draws: The number of resamples.
        method: As for :func:`interval`.
    """
    costs = checked(costs)
    counts = resamples(costs.shape[1:], draws, generator)
    value, drawn = statistic(costs), resampled(costs, statistic, counts)
    if kind == "ratio" and ((value <= 0).any() or (drawn <= 0).any()):
        raise StatisticsError("a ratio needs costs > 0; take the difference")
    slopes = None
    if method == "bca":
        own = _slopes(costs, statistic, value)
        own = own / value[:, None, None] if kind == "ratio" else own
        slopes = own[:, None] - own[None]
    low, high = _ends(_contrast(value, kind), _contrast(drawn, kind), level, slopes)
    return Interval(_contrast(value, kind), np.maximum(low, 0.0) if kind == "ratio" else low, high)


def _contrast(values: np.ndarray, kind: str) -> np.ndarray:
    """Row over or minus column (..., laws, laws) of values (..., laws)."""
    row, column = values[..., :, None], values[..., None, :]
    with np.errstate(invalid="ignore"):  # ∞/∞ and ∞ − ∞ are not-a-number
        return np.asarray(row / column if kind == "ratio" else row - column)


def _slopes(costs: np.ndarray, statistic: Statistic, value: np.ndarray) -> np.ndarray:
    """The influence (laws, scenarios, seeds) of each run on the statistic of each law."""
    if not isinstance(statistic, QuantileMean):
        raise StatisticsError('the method "bca" is for quantile means, such as IQM and CVAR; take "percentile"')
    slopes = np.stack([statistic.influence(own) for own in costs])
    return slopes * value[:, None, None] if statistic.by_scenario else slopes


def _ends(
    value: np.ndarray, drawn: np.ndarray, level: float, slopes: np.ndarray | None
) -> tuple[np.ndarray, np.ndarray]:
    """The ends (...) of the interval of value (...) from drawn (draws, ...); what is unknown widens both.

    Ends are order statistics, not interpolated, so that infinities stay what they are.
    """
    tails = np.array([(1 - level) / 2, (1 + level) / 2])
    levels = np.broadcast_to(tails.reshape(2, *[1] * value.ndim), (2, *value.shape))
    if slopes is not None:
        levels = _corrected_levels(value, drawn, tails, slopes)
    unknown, last = np.isnan(drawn), len(drawn) - 1
    low = np.sort(np.where(unknown, -np.inf, drawn), axis=0)
    high = np.sort(np.where(unknown, np.inf, drawn), axis=0)
    first = np.floor(levels[0] * last).astype(int)[None]
    second = np.ceil(levels[1] * last).astype(int)[None]
    return np.take_along_axis(low, first, axis=0)[0], np.take_along_axis(high, second, axis=0)[0]


def _corrected_levels(value: np.ndarray, drawn: np.ndarray, tails: np.ndarray, slopes: np.ndarray) -> np.ndarray:
    """The levels (2, ...) of the bias-corrected and accelerated interval [Efron 1987].

    They are those given where the correction is undefined, such as for an infinite value.
    """
    from scipy.special import ndtr, ndtri

    shape = (2, *[1] * value.ndim)
    below = np.mean((drawn < value) + 0.5 * (drawn == value), axis=0)
    with np.errstate(all="ignore"):
        bias = ndtri(below)
        skewness = np.sum(slopes**3, axis=(-2, -1)) / np.sum(slopes**2, axis=(-2, -1)) ** 1.5 / 6
        z = bias + ndtri(tails).reshape(shape)
        levels = ndtr(bias + z / (1 - skewness * z))
    usable = np.isfinite(bias) & np.isfinite(skewness) & np.isfinite(value)
    return np.where(usable, levels, tails.reshape(shape))
