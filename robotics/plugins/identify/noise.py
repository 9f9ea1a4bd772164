"""What residuals are like: encoders' rounding, the size of noise, and whether one tells of the next."""

from dataclasses import dataclass
from math import pi

import numpy as np
from scipy.stats import chi2

from robotics.plugins.identify.fit import CONFIDENCE, Ends
from robotics.plugins.identify.signals import MeasuredVelocities
from robotics.world.vehicle.robot import Robot

_LAGS = 20  # of the test for whiteness
_ON_LATTICE = 0.12  # of a step, RMS: values at random are 0.29 off
_LEAST_VALUES, _LOOKED_AT = 12, 480  # different values that are needed, and the smallest that show the step
_MOST_COUNTS = 40_000.0  # in a turn
_AXLES = np.linspace(-0.04, 0.04, 321)  # of the base's axle: what odometry may take it for


@dataclass(frozen=True)
class Whiteness:
    """The test of Ljung and Box: whether residuals tell of each other."""

    statistic: float
    p_value: float
    first: float  # the correlation of neighbours
    reach: float  # s: up to which a correlation is outside its 95 % bound


def whiteness(residuals: np.ndarray, period: float) -> Whiteness:
    """Test residuals (n,) that are ``period`` [s] apart for the first 20 correlations."""
    n, centred = len(residuals), residuals - residuals.mean()
    power = max(float(centred @ centred), 1e-300)
    lags = min(_LAGS, n // 4)
    found = np.array([float(centred[k:] @ centred[:-k]) / power for k in range(1, lags + 1)])
    statistic = n * (n + 2) * float((found**2 / (n - np.arange(1, lags + 1))).sum())
    outside = np.flatnonzero(np.abs(found) > 1.96 / np.sqrt(n))
    reach = float(outside[-1] + 1) * period if len(outside) else 0.0
    return Whiteness(statistic, float(chi2.sf(statistic, lags)), float(found[0]), reach)


def deviation(residuals: np.ndarray) -> tuple[float, Ends]:
    """The standard deviation of residuals (n,), with an interval for as many values as their correlation leaves."""
    n, centred = len(residuals), residuals - residuals.mean()
    power = max(float(centred @ centred), 1e-300)
    total = sum((float(centred[k:] @ centred[:-k]) / power) ** 2 for k in range(1, min(_LAGS, n // 4)))
    kurtosis = float((centred**4).mean() / max((centred**2).mean() ** 2, 1e-300))
    free = max(n / (1 + 2 * total) * 2 / max(kurtosis - 1, 0.5), 4.0)  # Gauss has 3; a uniform noise is known better
    value = float(np.sqrt(power / n))
    low, high = (value * float(np.sqrt(free / chi2.ppf(q, free))) for q in ((1 + CONFIDENCE) / 2, (1 - CONFIDENCE) / 2))
    return value, Ends(low, high)


def counts_per_turn(seen: MeasuredVelocities, base: Robot) -> tuple[float, Ends] | None:
    """What an encoder counts in a turn of a wheel of the base's radius; None: the speeds are on no lattice.

    The mean of two equal wheels that count whole numbers is a whole number of half counts. If it is on no lattice, the
    right wheel's speed is tried, for axles around the base's: odometry may take its wheels for unequal.
    """
    since = np.diff(seen.time)
    period = np.median(since) if np.ptp(since) < 1e-3 * np.median(since) else since
    for axles, per_step in ((np.zeros(1), 1.0), (base.half_axle * (1 + _AXLES), 2.0)):
        least = per_step * pi * base.wheel_radius / _MOST_COUNTS
        found = [_lattice((seen.v[1:] + axle * seen.w[1:]) * period, least) for axle in axles]
        on = [each for each in found if each is not None]
        if on:
            step, off, whole = min(on, key=lambda each: each[1])
            value = per_step * pi * base.wheel_radius / step
            # Wheels of different radii have different steps: by so much the fast speeds may be off the grid
            spread = 2 * off / whole + 1e-7
            return value, Ends(value * (1 - spread), value * (1 + spread))
    return None


def _lattice(ways: np.ndarray, least: float) -> tuple[float, float, float] | None:
    """The step [m] of which all ``ways`` (n,) are multiples, how far (RMS) they are off, and how many a long one is.

    Values that are nearer to each other than ``least`` [m], and steps below it, do not count.
    """
    small = np.unique(np.round(np.abs(ways), 12))
    small = small[small > 0]
    gaps = np.diff(small[:_LOOKED_AT])
    gaps = gaps[gaps > least]
    if len(small) < _LEAST_VALUES or not len(gaps):
        return None
    begun = float(np.median(gaps[gaps < 1.5 * np.quantile(gaps, 0.1)]))
    for part in (1, 2, 3):
        step = begun / part
        for many in (20, 100, 1000, np.inf):  # from few steps to many, so that the number of steps is never in doubt
            some = small[small < many * step]
            if len(some) > 2:
                whole = np.round(some / step)
                step = float(some @ whole / max(float(whole @ whole), 1.0))
        if step <= least:
            continue
        whole = np.round(small / step)
        off = float(np.sqrt(((small / step - whole) ** 2).mean()))
        if off < _ON_LATTICE:
            return step, off, float(np.quantile(whole, 0.9))
    return None
