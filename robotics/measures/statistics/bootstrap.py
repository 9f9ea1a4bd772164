"""Intervals by the bootstrap: seeds are drawn again within each scenario, the same ones for every law.

Drawing the same seeds for every law keeps the pairs together, so that what all laws share (a hard start, much noise)
goes out of differences and ratios. Drawing within scenarios keeps the share of each scenario [Agarwal 2021]. Of n seeds
n − 1 are drawn: with n, the resamples of a mean would vary too little, by the share 1/n, which with few seeds and many
scenarios does not average out [Rao & Wu 1988].

A statistic that is to hold of other scenarios, too (``of_others``), is resampled on both levels: the scenarios are
drawn again, and the seeds within each [Davison & Hinkley 1997, 3.8]. Of n scenarios (n − 1)(z/t)² are drawn, t and z
being Student's and the normal quantile: the resamples then spread as wide as Student's interval of a mean.
"""

from collections.abc import Callable
from typing import Literal

import numpy as np

from robotics.measures.statistics.aggregates import IQM, QuantileMean
from robotics.measures.statistics.costs import StatisticsError, checked
from robotics.measures.statistics.intervals import LEVEL, Interval

Statistic = Callable[[np.ndarray], np.ndarray]  # costs (..., scenarios, seeds) to (...)
Method = Literal["percentile", "studentised"]
_AT_ONCE = 1 << 22  # numbers resampled at a time, where the runs of a resample are needed and not only its statistic


def resamples(shape: tuple[int, ...], draws: int, generator: np.random.Generator) -> np.ndarray:
    """How often each run is drawn: (scenarios, seeds, draws), of each scenario's n runs n − 1, with replacement.

    Args:
        shape: The number of scenarios and the number of seeds.
        draws: The number of resamples.
        generator: Where they come from.
    """
    scenarios, seeds = shape
    chosen = generator.integers(0, seeds, size=(scenarios, seeds - 1, draws), dtype=np.int32)
    places = chosen + seeds * np.arange(scenarios, dtype=np.int32)[:, None, None]
    flat = places.astype(np.int64) * draws + np.arange(draws)
    counts = np.bincount(flat.ravel(), minlength=scenarios * seeds * draws)
    return counts.astype(np.int16 if seeds < 2**15 else np.int32).reshape(scenarios, seeds, draws)


def drawn_again(
    costs: np.ndarray, statistic: Statistic, draws: int, generator: np.random.Generator
) -> tuple[np.ndarray, np.ndarray]:
    """The resamples of the runs (scenarios, seeds, draws), and the statistic of every law in each (draws, laws)."""
    scenarios = costs.shape[1]
    counts = resamples(costs.shape[1:], draws, generator)
    if not (isinstance(statistic, QuantileMean) and statistic.of_others) or scenarios == 1:
        return counts, resampled(costs, statistic, counts)
    chosen = generator.integers(0, scenarios, size=(draws, _scenarios_drawn(scenarios)))
    weights = np.stack([np.bincount(own, minlength=scenarios) for own in chosen], axis=1) / chosen.shape[1]
    return counts, np.stack([statistic.of_resamples(own, counts, weights) for own in costs], axis=1)


def _scenarios_drawn(scenarios: int) -> int:
    from scipy.special import ndtri, stdtrit

    half = (1 + LEVEL) / 2
    return max(1, round(float((scenarios - 1) * (ndtri(half) / stdtrit(scenarios - 1, half)) ** 2)))


def resampled(costs: np.ndarray, statistic: Statistic, counts: np.ndarray) -> np.ndarray:
    """A statistic of every law in every resample: (draws, laws).

    Args:
        costs: The costs (laws, scenarios, seeds).
        statistic: A :class:`QuantileMean`, or any function from costs (..., scenarios, seeds) to (...), which is
            slower.
        counts: The resamples, of :func:`resamples`.
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
        chosen = runs.reshape(part.shape[2], 1, scenarios, -1)
        found[first : first + step] = statistic(np.take_along_axis(costs[None], chosen, axis=3))
    return found


def interval(
    costs: np.ndarray,
    statistic: Statistic = IQM,
    *,
    generator: np.random.Generator,
    draws: int = 2000,
    method: Method | None = None,
) -> Interval:
    """A statistic of each law with its bootstrap interval, arrays (laws,).

    Args:
        costs: The costs (laws, scenarios, seeds).
        statistic: What is estimated, such as IQM or CVAR of robotics.measures.statistics.aggregates.
        generator: Where the resamples come from.
        draws: The number of resamples.
        method: "percentile"; or "studentised", by the resamples' own standard errors [Hall 1988], of the logarithm
            where all costs are > 0, for a :class:`QuantileMean` only. By default the latter for one that reaches the
            greatest costs, such as MEAN and CVAR: long tails make the percentiles too narrow there. (Of a thousand
            synthetic comparisons with 30 seeds the percentiles of CVAR held the truth in 91.6 %, this in 94.1 %.)

    An end is infinite where failures are frequent enough in the resamples, and percentiles are then given whatever the
    method. Raises StatisticsError for costs that :func:`checked` refuses.
    """
    costs = checked(costs)
    value, (counts, drawn) = statistic(costs), drawn_again(costs, statistic, draws, generator)
    own = _studentises(statistic, method)
    if own is None:
        return Interval(value, *percentiles(drawn, LEVEL))
    logarithmic = bool((costs > 0).all())
    errors = [np.sqrt(np.diagonal(part, axis1=1, axis2=2)) for part in _both(costs, own, counts, logarithmic)]
    return Interval(value, *_studentised(value, drawn, errors[0][0], errors[1], LEVEL, logarithmic))


def contrasts(
    costs: np.ndarray,
    statistic: Statistic = IQM,
    kind: Literal["ratio", "difference"] = "ratio",
    *,
    generator: np.random.Generator,
    level: float = LEVEL,
    draws: int = 2000,
    method: Method | None = None,
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
    value, (counts, drawn) = statistic(costs), drawn_again(costs, statistic, draws, generator)
    if kind == "ratio" and ((value <= 0).any() or (drawn <= 0).any()):
        raise StatisticsError("a ratio needs costs > 0; take the difference")
    one, many = _contrast(value, kind), _contrast(drawn, kind)
    own = _studentises(statistic, method)
    if own is None:
        low, high = percentiles(many, level)
    else:
        errors = [_apart(part) for part in _both(costs, own, counts, kind == "ratio")]
        low, high = _studentised(one, many, errors[0][0], errors[1], level, kind == "ratio")
    return Interval(one, np.maximum(low, 0.0) if kind == "ratio" else low, high)


def _contrast(values: np.ndarray, kind: str) -> np.ndarray:
    """Row over or minus column (..., laws, laws) of values (..., laws)."""
    row, column = values[..., :, None], values[..., None, :]
    with np.errstate(invalid="ignore"):  # ∞/∞ and ∞ − ∞ are not-a-number
        return np.asarray(row / column if kind == "ratio" else row - column)


def _studentises(statistic: Statistic, method: Method | None) -> QuantileMean | None:
    """The statistic, if its intervals are to be studentised; None for percentiles."""
    if isinstance(statistic, QuantileMean):
        return statistic if method == "studentised" or (method is None and statistic.high == 1) else None
    if method == "studentised":
        raise StatisticsError('the method "studentised" is for quantile means, such as IQM; take "percentile"')
    return None


def _to_scale(statistic: QuantileMean, value: np.ndarray, logarithmic: bool) -> np.ndarray:
    """What slopes are multiplied by, so that they are those of the statistic, or of its logarithm."""
    if statistic.by_scenario == logarithmic:
        return np.ones_like(value)
    return value if statistic.by_scenario else 1 / value


def _both(costs: np.ndarray, statistic: QuantileMean, counts: np.ndarray, logarithmic: bool) -> list[np.ndarray]:
    """The covariances (draws, laws, laws) of the laws' statistics, or of their logarithms: as it is, and resampled."""
    ones = np.ones((*costs.shape[1:], 1), dtype=counts.dtype)
    step = max(1, _AT_ONCE // costs.size)
    parts = [counts[..., first : first + step] for first in range(0, counts.shape[2], step)]
    found = [_covariances(costs, statistic, part, logarithmic) for part in (ones, *parts)]
    return [found[0], np.concatenate(found[1:])]


def _covariances(costs: np.ndarray, statistic: QuantileMean, counts: np.ndarray, logarithmic: bool) -> np.ndarray:
    """The covariances (draws, laws, laws) by the influence functions; scenarios are independent of each other."""
    scenarios, seeds, draws = counts.shape
    drawn = int(counts[0, :, 0].sum())
    slopes = np.empty((scenarios, draws, len(costs), seeds))
    roots = np.sqrt(counts, dtype=float)
    with np.errstate(invalid="ignore"):  # not-a-number where failures reach the statistic
        for law, own in enumerate(costs):
            scale = _to_scale(statistic, statistic.of_resamples(own, counts), logarithmic)
            slopes[:, :, law] = np.moveaxis(statistic.slopes(own, counts) * roots * scale, 1, 2)
        return np.asarray((slopes @ np.swapaxes(slopes, 2, 3)).sum(axis=0) / (scenarios**2 * drawn * max(drawn - 1, 1)))


def _apart(covariances: np.ndarray) -> np.ndarray:
    """The standard errors (..., laws, laws) of the differences of every two laws."""
    own = np.diagonal(covariances, axis1=-2, axis2=-1)
    return np.sqrt(np.maximum(own[..., :, None] + own[..., None, :] - 2 * covariances, 0.0))


def _studentised(
    value: np.ndarray, drawn: np.ndarray, error: np.ndarray, errors: np.ndarray, level: float, logarithmic: bool
) -> tuple[np.ndarray, np.ndarray]:
    """The ends (...) of the studentised interval; percentiles where some resample is not finite, or has no error."""
    low, high = percentiles(drawn, level)
    with np.errstate(all="ignore"):
        middle, others = (np.log(value), np.log(drawn)) if logarithmic else (value, drawn)
        t = np.sort((others - middle) / errors, axis=0)
    last = len(t) - 1
    usable = np.isfinite(t).all(axis=0) & np.isfinite(error)
    with np.errstate(invalid="ignore"):
        first = middle - t[int(np.ceil((1 + level) / 2 * last))] * error
        second = middle - t[int(np.floor((1 - level) / 2 * last))] * error
    if logarithmic:
        first, second = np.exp(np.where(usable, first, 0.0)), np.exp(np.where(usable, second, 0.0))
    return np.where(usable, first, low), np.where(usable, second, high)


def percentiles(drawn: np.ndarray, level: float) -> tuple[np.ndarray, np.ndarray]:
    """The ends (...) of the interval from drawn (draws, ...); what is unknown widens both.

    Ends are order statistics, not interpolated, so that infinities stay what they are.
    """
    unknown, last = np.isnan(drawn), len(drawn) - 1
    low = np.sort(np.where(unknown, -np.inf, drawn), axis=0)[int(np.floor((1 - level) / 2 * last))]
    high = np.sort(np.where(unknown, np.inf, drawn), axis=0)[int(np.ceil((1 + level) / 2 * last))]
    return low, high
