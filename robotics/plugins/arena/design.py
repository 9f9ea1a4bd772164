"""What knowledge is worth under an arena's conditions, and what the law is: the cells of a design of experiments.

A law takes part several times, with other parts of knowledge; an arena whose file has ``[[under]]`` is held again under
each of these conditions, every law tuned anew with the same budget. A cell is a law, its knowledge and a condition.
"""

from collections.abc import Collection, Iterator
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from robotics.laws.catalogue import gains_of, with_gains
from robotics.laws.equation import KNOWLEDGE_FIELDS
from robotics.laws.law import Law
from robotics.measures.statistics.bootstrap import drawn_again, percentiles
from robotics.measures.statistics.costs import checked
from robotics.measures.statistics.intervals import LEVEL, Interval
from robotics.measures.tracking import UNDER_WAY
from robotics.plugins.arena.entered import short_title
from robotics.plugins.arena.entrants import sort_of
from robotics.plugins.arena.outcome import STATISTIC, Outcome
from robotics.simulation.scenario.description import Scenario

Knowledge = frozenset[str]  # parts, of KNOWLEDGE_FIELDS
_WORDS = {"lead": "lead", "smooth": "low-pass", "estimator": "filter"}
BARE: Knowledge = frozenset()
_OWN: Knowledge = frozenset({"lead", "smooth"})  # that predictive laws have by themselves
# Metrics that are not 0 on the reference: of which velocity they are the variation, and from when on [s]
_VARIATIONS = {
    "w_variation_late_radps2": ("w", UNDER_WAY),
    "w_variation_radps2": ("w", 0.0),
    "v_variation_mps2": ("v", 0.0),
}


def called(parts: Collection[str]) -> str:
    """A set of parts, in a word each."""
    return ", ".join(word for part, word in _WORDS.items() if part in parts) or "as it is"


@dataclass(frozen=True, eq=False)
class Cells:
    """The tuned laws of an arena under one condition, by law and knowledge; arrays have a place for each entry."""

    of: Outcome

    @cached_property
    def given(self) -> list[Knowledge]:
        """What parts each entry is given."""
        gains = [gains_of(made) for made in self.of.made]
        return [frozenset(part for part in KNOWLEDGE_FIELDS if own.get(part)) for own in gains]

    @cached_property
    def bare(self) -> list[Law[object]]:
        """The law of each entry without them."""
        said = [{*KNOWLEDGE_FIELDS} & {*gains_of(made)} for made in self.of.made]
        return [with_gains(m, dict.fromkeys(s)) if s else m for m, s in zip(self.of.made, said, strict=True)]

    @cached_property
    def predicts(self) -> list[bool]:
        """Whether each entry is a predictive law, which reads ahead and filters by itself."""
        return [sort_of(made) == "predictive" for made in self.of.made]

    @cached_property
    def knowledge(self) -> list[Knowledge]:
        """What each entry knows: what it is given, and what it has by itself."""
        return [own | _OWN if ahead else own for own, ahead in zip(self.given, self.predicts, strict=True)]

    @cached_property
    def columns(self) -> list[Knowledge]:
        """The sets of parts that some entry knows, the fewest first."""
        return sorted({*self.knowledge}, key=lambda parts: (len(parts), "estimator" in parts))

    @cached_property
    def rows(self) -> list[list[int]]:
        """The places of the entries of each law."""
        found: list[list[int]] = []
        for k, law in enumerate(self.bare):
            own = next((row for row in found if self.bare[row[0]] == law), None)
            if own is None:
                found.append([k])
            else:
                own.append(k)
        return found

    def title(self, row: list[int]) -> str:
        """What the law of a row is called."""
        return short_title(self.of.laws[row[0]])

    @cached_property
    def _logarithms(self) -> np.ndarray:
        """Of the costs, as they are and in every resample (1 + draws, entries)."""
        costs = checked(self.of.tuned)
        drawn = drawn_again(costs, STATISTIC, self.of.draws, self.of.generator)[1]
        return np.log(np.vstack([STATISTIC(costs), drawn]))

    def _ratio(self, over: list[tuple[int, int]]) -> Interval:
        """The geometric mean over pairs of entries of the first one's cost over the second's."""
        with np.errstate(invalid="ignore"):  # ∞ − ∞ is not-a-number
            found = np.exp(np.mean([self._logarithms[:, a] - self._logarithms[:, b] for a, b in over], axis=0))
        return Interval(found[0], *percentiles(found[1:], LEVEL))

    def worth(self) -> Iterator[tuple[Knowledge, int, Interval]]:
        """Of each set of parts: how many laws have it, and their cost with it over that without any."""
        place = {(n, self.given[k]): k for n, row in enumerate(self.rows) for k in row if not self.predicts[k]}
        for column in self.columns:
            laws = [n for n in range(len(self.rows)) if {(n, column), (n, BARE)} <= {*place}]
            if column and laws:
                yield column, len(laws), self._ratio([(place[n, column], place[n, BARE]) for n in laws])

    def among(self, column: Knowledge) -> list[int]:
        """The entries with that knowledge that do not fail, from the least cost up."""
        return [k for k in self.of.order if self.knowledge[k] == column and np.isfinite(self.of.cost.value[k])]

    def spread(self, column: Knowledge) -> Interval:
        """What the dearest of them costs over the cheapest."""
        first, *_, last = self.among(column)
        return self._ratio([(last, first)])

    @cached_property
    def floor(self) -> float:
        """What a law would cost that stands on the reference and demands its velocity: the reference's own variation.

        As the laws' costs it is a geometric mean over the scenarios.
        """
        own = np.zeros(len(self.of.arena.scenarios("test")))
        for term in self.of.arena.made_cost.terms:
            if term.metric in _VARIATIONS:
                varied = [_variation(s, *_VARIATIONS[term.metric]) for s in self.of.arena.scenarios("test")]
                own += term.weight / term.scale * np.array(varied)
        with np.errstate(divide="ignore"):  # a straight path at constant speed
            return float(np.exp(np.mean(np.log(own))))


def _variation(scenario: Scenario, name: str, begin: float) -> float:
    """How much the reference's v or ω varies a second, from ``begin`` [s] on."""
    values = getattr(scenario.trajectory.sampled(scenario.times), name)[:, 0]
    late = scenario.times[1:] > begin
    return float(np.abs(np.diff(values))[late].sum() / (late.sum() * scenario.period))
