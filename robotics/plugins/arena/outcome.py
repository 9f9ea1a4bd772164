"""What came of an arena: the costs of all runs, and what the statistics say of them."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
import pandas as pd

from robotics.measures.statistics.aggregates import CVAR, IQM, UNSEEN_IQM
from robotics.measures.statistics.bootstrap import contrasts, interval
from robotics.measures.statistics.intervals import Interval
from robotics.measures.statistics.pairs import holm, signed_rank_p_values, verdicts
from robotics.measures.statistics.ranking import Reweighted, gap_closed, reweighted
from robotics.measures.statistics.shares import failure_rate, probability_of_improvement
from robotics.plugins.arena.changes import CHANGES
from robotics.plugins.arena.description import Arena
from robotics.plugins.arena.entered import ArenaOutcome
from robotics.plugins.arena.work import Search

STATISTIC = UNSEEN_IQM  # by which laws are ranked; intervals are over scenarios and seeds
_DRAWS = 2000
_FEW_DRAWS = 500  # of intervals that are many


@dataclass(frozen=True, eq=False)
class ArenaEntry:
    """What is known of one law."""

    law: str  # its specification
    parameters: tuple[str, ...]  # that were tuned
    chosen: int  # the place of the candidate that was; 0: the law as published
    budgets: tuple[int, ...]  # evaluations at which its searches were looked at
    searches: tuple[Search, ...]
    looked_at: np.ndarray = field(repr=False)  # (searches, budgets) int: the candidate that was best then
    choosing: np.ndarray = field(repr=False)  # (candidates, scenarios, seeds): costs, the law as published first
    runs: Mapping[str, pd.DataFrame] = field(repr=False)  # of the test: "published" and "tuned"
    changed: Mapping[str, pd.DataFrame] = field(repr=False)  # by the change that no law was told of

    @cached_property
    def means(self) -> np.ndarray:
        """What the candidates cost on the choosing runs (candidates,)."""
        return np.asarray(self.choosing.mean(axis=(1, 2)))

    def best_of(self, engine: str) -> float:
        """The least of them, of the law as published and of the ends of an engine's searches."""
        ends = [row[-1] for search, row in zip(self.searches, self.looked_at, strict=True) if search.engine == engine]
        return float(self.means[[0, *ends]].min())

    @property
    def by(self) -> str:
        """The search that found the chosen values, such as cmaes-2; "": the law is as published."""
        ends = zip(self.searches, self.looked_at, strict=True)
        return min(search.name for search, row in ends if row[-1] == self.chosen) if self.chosen else ""


@dataclass(frozen=True, eq=False)
class Outcome(ArenaOutcome):
    """What came of an arena; arrays have a place for each law, in the arena's order."""

    arena: Arena
    entries: tuple[ArenaEntry, ...]
    computing: Mapping[str, float]  # µs a period, by law
    machine: str
    draws: int = _DRAWS
    under: Mapping[str, "Outcome"] = field(default_factory=dict)  # held again, by the titles of conditions

    @property
    def by_condition(self) -> dict[str, "Outcome"]:
        """This outcome and those under other conditions, by the titles of conditions."""
        return {self.arena.conditions.title or "as it is": self, **self.under}

    @property
    def clocked(self) -> bool:
        """Whether computing times were measured."""
        return bool(np.isfinite(list(self.computing.values())).all())

    @property
    def generator(self) -> np.random.Generator:
        """A generator for resamples, each time from the same seed."""
        return np.random.default_rng([self.arena.seed, len(self.entries)])

    # Costs -----------------------------------------------------------------------------------------------------

    def _terms_in(self, table: pd.DataFrame, seeds: int) -> np.ndarray:
        """The terms of the cost over their scales, unweighted (terms, scenarios, seeds); infinite where a run failed.

        Failed is a run in which the robot was stopped, or which costs as much as one.
        """
        cost = self.arena.made_cost
        terms = np.stack([table[term.name].to_numpy(dtype=float) / term.scale for term in cost.terms])
        with np.errstate(invalid="ignore"):
            failed = (table["stopped"].to_numpy() > 0) | ~(self.weights @ terms < cost.failed)
        terms[:, failed] = np.inf
        return terms.reshape(len(terms), -1, seeds)

    def terms(self, part: str) -> np.ndarray:
        """The terms of the cost over their scales (terms, laws, scenarios, seeds) of "published" or "tuned" laws."""
        return np.stack([self._terms_in(e.runs[part], self.arena.testing_runs) for e in self.entries], axis=1)

    @cached_property
    def weights(self) -> np.ndarray:
        """The weights of the cost's terms (terms,)."""
        return np.array([term.weight for term in self.arena.made_cost.terms])

    def _costs(self, terms: np.ndarray) -> np.ndarray:
        return np.asarray(np.tensordot(self.weights[self.weights > 0], terms[self.weights > 0], axes=1))

    @cached_property
    def published(self) -> np.ndarray:
        """What the laws as published cost on the test (laws, scenarios, seeds); infinite: failed."""
        return self._costs(self.terms("published"))

    @cached_property
    def tuned(self) -> np.ndarray:
        """What the chosen laws cost on the test (laws, scenarios, seeds); infinite: failed."""
        return self._costs(self.terms("tuned"))

    @cached_property
    def reference(self) -> int:
        """The place of the law to which costs are told: the arena's, or where that fails the law with the least."""
        values = STATISTIC(self.tuned)
        if self.arena.reference:
            place = self.laws.index(self.arena.reference)
            if np.isfinite(values[place]):
                return place
        return int(np.argmin(values))

    # Statistics ------------------------------------------------------------------------------------------------

    @cached_property
    def cost(self) -> Interval:
        """The cost of each tuned law, with its 95 % interval."""
        return interval(self.tuned, STATISTIC, generator=self.generator, draws=self.draws)

    def _compared(self, costs: np.ndarray, draws: int | None = None) -> Interval:
        """The ratio of each two of some costs (..., scenarios, seeds), row over column."""
        return contrasts(costs, STATISTIC, generator=self.generator, draws=draws or self.draws)

    @cached_property
    def _ratios(self) -> Interval:
        both = np.concatenate([self.published, self.tuned])
        return self._compared(both)[:, len(self.entries) + self.reference]

    @cached_property
    def pairs(self) -> Interval:
        """The ratio of each two tuned laws' costs, arrays (laws, laws): row over column."""
        return self._compared(self.tuned)

    @property
    def published_ratio(self) -> Interval:
        """The cost of each law as published, over the tuned reference's."""
        return self._ratios[: len(self.entries)]

    @property
    def tuned_ratio(self) -> Interval:
        """The cost of each tuned law over the tuned reference's."""
        return self._ratios[len(self.entries) :]

    @cached_property
    def gain(self) -> Interval:
        """What tuning makes of a law's cost, arrays (laws,): tuned over published."""
        pairs = zip(self.tuned, self.published, strict=True)
        return _joined([self._compared(np.stack(pair))[0, 1] for pair in pairs])

    @cached_property
    def closed(self) -> Interval:
        """The share of each law's gap to the reference that tuning closes."""
        before, after = self.published, self.tuned
        reference = after[self.reference]
        return gap_closed(before, after, reference, STATISTIC, generator=self.generator, draws=self.draws)

    @cached_property
    def order(self) -> list[int]:
        """The places of the laws from the least tuned cost up; of those that fail, those that fail less first."""
        rates = self.failures.value
        return sorted(range(len(self.entries)), key=lambda k: (float(self.cost.value[k]), float(rates[k])))

    @cached_property
    def p_values(self) -> np.ndarray:
        """Holm's p-values of the signed-rank test over scenarios between each two tuned laws (laws, laws)."""
        costs = self.scenario_costs
        if costs.shape[1] < 2:  # one scenario says nothing of others
            return np.ones((len(costs), len(costs)))
        return holm(signed_rank_p_values(costs[:, None, :]))

    @cached_property
    def verdicts(self) -> np.ndarray:
        """What can be said of the row's law against the column's, tuned (laws, laws)."""
        return verdicts(self.tuned, STATISTIC, generator=self.generator, draws=self.draws, p_values=self.p_values)

    @cached_property
    def improvement(self) -> Interval:
        """The probability that the row's law costs less than the column's (laws, laws), tuned, run by run."""
        return probability_of_improvement(self.tuned, generator=self.generator, draws=self.draws)

    @cached_property
    def failures(self) -> Interval:
        """The share of each tuned law's runs that failed, with Wilson's interval."""
        return failure_rate(self.tuned)

    @cached_property
    def relative(self) -> np.ndarray:
        """The tuned laws' costs over the reference's interquartile mean on that scenario (laws, scenarios, seeds).

        Where the reference fails, they are over the least of the laws' means.
        """
        unit = self.scenario_costs[self.reference]
        unit = np.where(np.isfinite(unit), unit, self.scenario_costs.min(axis=0))
        return np.where(np.isfinite(self.tuned), self.tuned / unit[:, None], np.inf)

    @cached_property
    def pooled(self) -> Interval:
        """The interquartile mean of all runs' relative costs, with its interval."""
        return interval(self.relative, IQM, generator=self.generator, draws=self.draws)

    @cached_property
    def tail(self) -> Interval:
        """The mean of the worst tenth of all runs' costs, in the cost's own unit; infinite: one of them failed."""
        return interval(self.tuned, CVAR, generator=self.generator, draws=self.draws)

    @cached_property
    def scenario_costs(self) -> np.ndarray:
        """The interquartile mean of each tuned law's cost on each scenario (laws, scenarios)."""
        return np.asarray(IQM(self.tuned[:, :, None, :]))

    @property
    def mean(self) -> np.ndarray:
        """The arithmetic mean over scenarios of the interquartile mean of each tuned law's cost (laws,)."""
        return self.scenario_costs.mean(axis=1)

    @cached_property
    def by_scenario(self) -> np.ndarray:
        """The interquartile mean of each law's cost on each scenario, over the reference's (laws, scenarios)."""
        return np.asarray(IQM(self.relative[:, :, None, :]))

    @cached_property
    def reweighted(self) -> Reweighted:
        """The ranking under each of the cost's weights halved and doubled."""
        some = self.weights > 0
        return reweighted(self.terms("tuned")[some], self.weights[some], STATISTIC)

    def term_means(self, part: str) -> np.ndarray:
        """The interquartile mean of each metric of the cost in its own unit (terms, laws); infinite: fails."""
        terms, cost = self.terms(part), self.arena.made_cost
        return np.stack([IQM(own) * term.scale for own, term in zip(terms, cost.terms, strict=True)])

    def effort(self, part: str) -> np.ndarray | None:
        """The variation of the turn rate that laws demand (laws,) [rad/s²]; None: the cost has no such term."""
        place = next((n for n, term in enumerate(self.arena.made_cost.terms) if "w_variation" in term.metric), None)
        return None if place is None else self.term_means(part)[place]

    # Engines and budgets ---------------------------------------------------------------------------------------

    @cached_property
    def by_engine(self) -> np.ndarray:
        """What the best end of each engine's searches, or the law as published, costs when chosen by: (engines, laws).

        It is the mean on the runs for choosing.
        """
        return np.array([[entry.best_of(engine) for entry in self.entries] for engine in self.arena.engines])

    @cached_property
    def budgets(self) -> np.ndarray:
        """Numbers of evaluations at which the curves are taken (budgets,)."""
        return np.array(sorted({n for entry in self.entries for n in entry.budgets}))

    @cached_property
    def curves(self) -> Interval:
        """The cost on the choosing runs of each search's best so far: median and range over searches (laws, budgets).

        A law with a smaller budget stays where it was at its end.
        """
        found = np.empty((3, len(self.entries), len(self.budgets)))
        for n, entry in enumerate(self.entries):
            for k, budget in enumerate(self.budgets):
                at = max((b for b, e in enumerate(entry.budgets) if e <= budget), default=0)
                values = entry.means[entry.looked_at[:, at]] if entry.searches else entry.means[:1]
                found[:, n, k] = np.median(values), values.min(), values.max()
        return Interval(*found)

    # Robustness ------------------------------------------------------------------------------------------------

    @cached_property
    def _changed_costs(self) -> np.ndarray:
        """What the laws cost with each change (laws, changes, scenarios, seeds); infinite: failed."""
        seeds = len(self.arena.seeds("test", self.arena.robustness_runs))
        return np.stack(
            [[self._costs(self._terms_in(entry.changed[c], seeds)) for c in CHANGES] for entry in self.entries]
        )

    @cached_property
    def robustness(self) -> Interval:
        """The cost with each change over that without, on the same seeds (laws, changes); infinite: it fails then."""
        changed, draws = self._changed_costs, min(self.draws, _FEW_DRAWS)
        told = np.broadcast_to(self.tuned[:, None, :, : changed.shape[-1]], changed.shape)
        pairs = np.stack([changed, told], axis=2)
        return _joined([_joined([self._compared(pair, draws)[0, 1] for pair in of_law]) for of_law in pairs])

    @cached_property
    def robust_costs(self) -> np.ndarray:
        """The cost with each change (laws, changes); infinite: it fails then."""
        return np.stack([STATISTIC(own) for own in self._changed_costs.swapaxes(0, 1)], axis=1)

    @property
    def robust_failures(self) -> np.ndarray:
        """The share of runs that failed with each change (laws, changes)."""
        return np.asarray(np.isinf(self._changed_costs).mean(axis=(2, 3)))


def _joined(parts: list[Interval]) -> Interval:
    """Intervals of one shape as one, with a first axis more."""
    return Interval(*(np.stack([getattr(part, f) for part in parts]) for f in ("value", "low", "high")))
