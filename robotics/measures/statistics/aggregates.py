"""One number for the runs of a law: the mean of its costs between two quantiles.

The mean, the interquartile mean and the conditional value at risk are one formula, the mean of the quantile function
between two levels u and v,

    T = 1/(v − u) ∫_u^v F⁻¹(p) dp,

with F the empirical distribution. Runs at the levels count in part, so that T does not jump with the number of runs.
"""

from dataclasses import dataclass, replace

import numpy as np

from robotics.measures.statistics.costs import StatisticsError

_NOTHING = 1e-9  # of one run: what is less is rounding of a level times the number of runs


@dataclass(frozen=True)
class QuantileMean:
    """The mean of costs between two quantiles, of all runs together or of each scenario by itself.

    Called with costs (..., scenarios, seeds) it gives (...). A failed run is the worst there can be: the mean is
    infinite if, and only if, failed runs lie between the two levels.
    """

    name: str
    low: float  # the share of the smallest costs that is left out
    high: float  # the share of costs up to which the mean is taken
    by_scenario: bool = False  # the geometric mean over scenarios of each scenario's own: blind to scenarios' scales
    of_others: bool = False  # by scenario: intervals are about other scenarios of the same sorts, and not these alone

    def __post_init__(self) -> None:
        if not 0 <= self.low < self.high <= 1:
            raise StatisticsError(
                f"the levels are {self.low:g} and {self.high:g}; give two from 0 to 1, the lower first"
            )

    def __call__(self, costs: np.ndarray) -> np.ndarray:
        """The statistic (...) of costs (..., scenarios, seeds)."""
        costs = np.asarray(costs, dtype=float)
        if self.by_scenario:
            each = self._of_rows(costs)
            if (each <= 0).any():
                raise StatisticsError(f"the {self.name} needs costs > 0, since it is a geometric mean over scenarios")
            return np.exp(np.log(each).mean(axis=-1))
        return self._of_rows(costs.reshape(*costs.shape[:-2], -1))

    def _of_rows(self, costs: np.ndarray) -> np.ndarray:
        """The mean between the levels of the last axis."""
        runs = costs.shape[-1]
        low, high = self.low * runs, self.high * runs
        weights = np.diff(np.clip(np.arange(runs + 1), low, high))
        inside = weights > _NOTHING
        return np.asarray((np.sort(costs, axis=-1)[..., inside] * weights[inside]).sum(axis=-1) / (high - low))

    def of_resamples(self, costs: np.ndarray, counts: np.ndarray, weights: np.ndarray | None = None) -> np.ndarray:
        """The statistic (draws,) of one law in each resample.

        The costs are sorted once; a resample is then a number of copies of each, and their cumulated sums say how much
        of each cost lies between the levels.

        Args:
            costs: The costs (scenarios, seeds) of the law.
            counts: How often each run is drawn (scenarios, seeds, draws); as many of each scenario, in every resample.
            weights: The share of each scenario in the mean over them (scenarios, draws); by default all have the same.
        """
        if not self.by_scenario:
            return self._of_counts(costs.ravel(), counts.reshape(costs.size, -1))
        each = [self._of_counts(row, drawn) for row, drawn in zip(costs, counts, strict=True)]
        if (np.asarray(each) <= 0).any():
            raise StatisticsError(f"the {self.name} needs costs > 0, since it is a geometric mean over scenarios")
        if weights is None:
            return np.exp(np.log(each).mean(axis=0))
        with np.errstate(invalid="ignore"):  # a scenario that fails, and is not drawn
            return np.exp(np.where(weights > 0, weights * np.log(each), 0.0).sum(axis=0))

    def _of_counts(self, costs: np.ndarray, counts: np.ndarray) -> np.ndarray:
        """The mean between the levels of costs (runs,) drawn ``counts`` (runs, draws) times."""
        runs, order = int(counts[:, 0].sum()), np.argsort(costs, kind="stable")
        ranked = costs[order]
        finite = int(np.isfinite(ranked).sum())
        if finite == 0:
            return np.full(counts.shape[1], np.inf)
        ranked, low, high = ranked[:finite], self.low * runs, self.high * runs
        below = np.clip(np.cumsum(counts[order[:finite]], axis=0, dtype=float), low, high)
        # Summation by parts: Σ xᵢ (bᵢ − bᵢ₋₁) with b before the first = low
        total = ranked[-1] * below[-1] - ranked[0] * low
        total -= np.einsum("n,nd->d", np.diff(ranked), below[:-1])
        return np.where(below[-1] < high - _NOTHING * runs, np.inf, total / (high - low))

    def slopes(self, costs: np.ndarray, counts: np.ndarray) -> np.ndarray:
        """How much each run moves the statistic of each resample: (scenarios, seeds, draws), the influence function.

        It is the cost winsorised at the two levels over v − u, centred within each scenario [Huber 1981, 3.3]. Where
        the statistic is taken by scenario it is that of its logarithm. Not-a-number where failures lie between the
        levels.

        Args:
            costs: The costs (scenarios, seeds) of one law.
            counts: How often each run is drawn (scenarios, seeds, draws); ones for the runs as they are.
        """
        if self.by_scenario:
            parts = [
                self._winsorised(row[None], drawn[None]) / self._of_counts(row, drawn)
                for row, drawn in zip(costs, counts, strict=True)
            ]
            own = np.concatenate(parts)
        else:
            own = self._winsorised(costs, counts)
        with np.errstate(invalid="ignore"):
            centre = np.sum(own * counts, axis=1, keepdims=True) / counts[0, :, 0].sum()
            return np.asarray((own - centre) / (self.high - self.low))

    def _winsorised(self, costs: np.ndarray, counts: np.ndarray) -> np.ndarray:
        """The costs (scenarios, seeds, draws) between the quantiles of each resample of them all."""
        order = np.argsort(costs, axis=None, kind="stable")
        ranked = costs.ravel()[order]
        reached = np.cumsum(counts.reshape(costs.size, -1)[order], axis=0, dtype=np.int32)
        low, high = (
            ranked[np.argmax(reached >= max(level * reached[-1, 0] - _NOTHING, 1), axis=0)]
            for level in (self.low, self.high)
        )
        return np.clip(costs[..., None], low, high)


MEAN = QuantileMean("mean", 0.0, 1.0)
# Of the middle half of all runs [Agarwal 2021]: failures are trimmed as long as they are at most a quarter of the runs.
IQM = QuantileMean("interquartile mean", 0.25, 0.75)
SCENARIO_IQM = QuantileMean("geometric mean over scenarios of the interquartile mean", 0.25, 0.75, by_scenario=True)
UNSEEN_IQM = replace(SCENARIO_IQM, of_others=True)
# The conditional value at risk [Rockafellar & Uryasev 2002]: one failed run makes it infinite.
CVAR = QuantileMean("mean of the worst tenth", 0.9, 1.0)
