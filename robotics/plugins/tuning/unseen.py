"""Before against after on runs that tuning has not seen: other seeds, and other scenarios."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from robotics.measures.statistics.aggregates import MEAN
from robotics.measures.statistics.bootstrap import contrasts
from robotics.measures.statistics.intervals import Interval
from robotics.simulation.scenario.description import Scenario
from robotics.studies.tuning.cost import costs_of
from robotics.studies.tuning.tune import TESTING, Tuned

_DRAWS = 2000  # of the bootstrap
BOOTSTRAP_SEED = 0


@dataclass(frozen=True, eq=False)
class Unseen:
    """What a law costs before and after tuning, on the same runs, none of which it was tuned on."""

    scenarios: tuple[str, ...]
    tuned_on: bool  # whether these are the scenarios it was tuned on, with other seeds
    costs: np.ndarray  # (2, scenarios, seeds): before, after
    ratio: Interval  # of the mean cost, after to before, with its 95 % interval

    @property
    def better(self) -> bool:
        """Whether the whole interval is on the better side."""
        return bool(self.ratio.high < 1)

    def row(self) -> dict[str, Any]:
        """The comparison as JSON can hold it."""
        before, after = self.costs.mean(axis=(1, 2)).tolist()
        return {
            "scenarios": list(self.scenarios),
            "tuned_on": self.tuned_on,
            "seeds": self.costs.shape[2],
            "before": before,
            "after": after,
            "ratio": float(self.ratio.value),
            "interval_95": [float(self.ratio.low), float(self.ratio.high)],
            "better": self.better,
        }

    def sentence(self) -> str:
        """The comparison in words."""
        before, after = self.costs.mean(axis=(1, 2))
        low, high = (100 * (1 - float(end)) for end in (self.ratio.high, self.ratio.low))
        seeds = self.costs.shape[2]
        where = (
            f"on {seeds} unseen seeds of "
            if np.ptp(self.costs, axis=2).any()
            else "where every seed gives the same, in "
        )
        where += ("the same scenarios" if self.tuned_on else "unseen scenarios") + f" ({', '.join(self.scenarios)})"
        numbers = f"{before:.3g} before, {after:.3g} after"
        if self.better:
            said = f"{100 * (1 - float(self.ratio.value)):.0f} % less, 95 % interval {low:.0f} to {high:.0f} %"
        elif self.ratio.low > 1:
            said = (
                f"{-100 * (1 - float(self.ratio.value)):.0f} % more, 95 % interval {-high:.0f} to {-low:.0f} %: worse"
            )
        else:
            said = f"not shown to be better: between {round(-low)} % more and {round(high)} % less at 95 %"
            said = "every run costs the same" if np.array_equal(*self.costs) else said
        return f"{where}: {numbers}; {said}"


def compared(
    tuned: Tuned,
    scenarios: Sequence[Scenario],
    others: Sequence[Scenario] = (),
    seeds: int = 200,
    threads: int | None = None,
) -> list[Unseen]:
    """Compare a law before and after tuning with seeds from TESTING on, which no search uses.

    Args:
        tuned: What was found.
        scenarios: Those that it was tuned on.
        others: Scenarios that it was not tuned on.
        seeds: How many seeds each scenario has, at least 2.
        threads: How many threads share out the runs.

    Returns one comparison for ``scenarios`` and one for ``others``, if there are any.
    """
    laws = [tuned.space.law, tuned.law]
    block = range(TESTING, TESTING + max(seeds, 2))
    found = []
    for group, tuned_on in ((scenarios, True), (others, False)):
        if not group:
            continue
        costs = costs_of(tuned.cost, group, laws, block, threads).sum(axis=-1)
        generator = np.random.default_rng(BOOTSTRAP_SEED)
        ratio = contrasts(costs, MEAN, "ratio", generator=generator, draws=_DRAWS)[1, 0]
        found.append(Unseen(tuple(s.name for s in group), tuned_on, costs, ratio))
    return found
