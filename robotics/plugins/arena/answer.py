"""The answer of an arena in ten sentences at most, made of its numbers: for whoever chooses a controller tomorrow."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np

from fuzzy.words import listed
from robotics.laws.catalogue import law_title
from robotics.measures.statistics.intervals import Interval
from robotics.measures.statistics.pairs import MARGIN
from robotics.measures.statistics.ranking import swapped_pairs
from robotics.plugins.arena.changes import CHANGES
from robotics.plugins.arena.design import Cells, Knowledge, called
from robotics.plugins.arena.entrants import Sort, sort_of
from robotics.plugins.arena.outcome import Outcome

MOST_SENTENCES = 10  # sentences
_FEW = 6  # laws that a sentence lists
_TIMES = 2.0  # from here on a cost is "2.9 times as much", below "8 % more"
_GIVEN = "What a law is given counts, a lead of its reference, a low-pass of its correction, a filter of its pose"
_CHEAP = 0.1  # of the leader's computing time


def answer(outcome: Outcome) -> list[str]:
    """The sentences, MOST_SENTENCES at most."""
    said = _Said(outcome)
    if not said.finite:
        nobody = "No law leads: each fails in more than a quarter of the runs of some scenario."
        return [nobody, *said.failures(), said.protocol()]
    known = said.conditions()
    found = [said.leader(), *said.fuzzy_or_nonlinear(), *known, *said.distances(), *said.computing()]
    found += [
        *([] if known else said.effort()),
        *said.failures(),
        *said.robustness(),
        said.stands(),
        *said.tuning(),
        said.protocol(),
    ]
    return found[:MOST_SENTENCES]


@dataclass(frozen=True)
class _Said:
    """What is said of an outcome, sentence by sentence."""

    of: Outcome

    @property
    def finite(self) -> list[int]:
        """The laws that do not fail, from the least cost up."""
        return [k for k in self.of.order if np.isfinite(self.of.cost.value[k])]

    def sort(self, k: int) -> Sort:
        return sort_of(self.of.made[k])

    def title(self, k: int) -> str:
        return self.of.titles[k]

    def verdict(self, row: int, column: int) -> str:
        return str(self.of.verdicts[row, column])

    def protocol(self) -> str:
        """What was done."""
        arena = self.of.arena
        runs = arena.runs * len(arena.scenarios("tune"))
        searches = arena.repeats * len(arena.engines)
        less = [f"{law_title(law)} only {count}" for law, count in arena.exceptions.items()]
        alike = f", {listed(less)}" if less else ""
        tuned = len(self.of.laws) - len(arena.untuned)
        as_published = [self.title(self.of.laws.index(law)) for law in arena.untuned]
        if as_published:
            alike += f"; {listed(as_published)}, of which nothing moves, took part as published"
        return (
            f"{_number(tuned).capitalize()} law{'s were' if tuned > 1 else ' was'} tuned from their published gains "
            f"with {'the same budget, ' if not less else ''}{arena.evaluations} evaluations of {_runs(runs)} in "
            f"{f'each of {_number(searches)} searches' if searches > 1 else 'one search'}{alike}, and each drove "
            f"{_number(len(arena.scenarios('test')))} scenarios that no search had seen, {arena.testing_runs} times "
            "each."
        )

    def leader(self) -> str:
        """Who leads, by how much, and how surely."""
        first, *others = self.finite
        alike = [k for k in others if self.verdict(first, k) == "equivalent"]
        open_ = [k for k in others if self.verdict(first, k) == "undecided"]
        mixed = [k for k in open_ if self.of.pairs.low[k, first] > 1]
        open_ = [k for k in open_ if k not in mixed]
        if not others:
            return f"{self.title(first)} leads: every other law fails in more than a quarter of some scenario's runs."
        if not alike and not open_:
            text = f"{self.title(first)} leads: its cost is the least, and {self.title(others[0])}, the next, "
            text += compared(self.of.pairs[others[0], first])
        else:
            text = f"{self.title(first)} has the least cost"
            if alike:
                text += f", and {listed(self.titles(alike))} {'is' if len(alike) == 1 else 'are'} as good within "
                text += f"{100 * MARGIN:.0f} %"
            if open_:
                text += "; " if alike else ", but "
                text += f"from {listed(self.titles(open_), 'or')} these runs cannot tell it apart"
            after = [k for k in others if k not in (*alike, *open_)]
            if after:
                text += f"; {self.title(after[0])}, the next, {compared(self.of.pairs[after[0], first])}"
        if mixed:
            text += f"; yet in {self.share(mixed[0], first)} of the runs {self.title(mixed[0])} costs less"
        return text + "."

    def share(self, row: int, column: int) -> str:
        """In how many runs the row's law costs less than the column's."""
        return f"{100 * float(self.of.improvement.value[row, column]):.0f} %"

    def titles(self, places: Iterable[int]) -> list[str]:
        return [self.title(k) for k in places]

    def fuzzy_or_nonlinear(self) -> list[str]:
        """Whether a fuzzy law leads those that do not predict: fuzzy or nonlinear?"""
        of_sort = {k: self.sort(k) for k in self.of.order}
        fuzzy = [k for k in self.of.order if of_sort[k] == "fuzzy"]
        rivals = [k for k in self.of.order if of_sort[k] in ("lyapunov", "geometric", "linear")]
        if not fuzzy or not rivals:
            return []
        mine, rival = fuzzy[0], rivals[0]
        ratio, values = self.of.pairs[rival, mine], self.of.cost.value
        head = "Fuzzy or nonlinear? "
        if not np.isfinite(values[[mine, rival]]).any():
            return [head + "Neither: the best law of both sorts fails too often."]
        verdict, best = self.verdict(mine, rival), f"{self.title(mine)}, the best fuzzy law,"
        against = f"{self.title(rival)}, the best that is neither fuzzy nor predicts,"
        if verdict == "equivalent":
            text = f"Either: {best} and {against} are equivalent within {100 * MARGIN:.0f} %"
        elif verdict == "undecided":
            text = f"These runs do not decide it: {against} {compared(ratio, self.title(mine))}"
            text += f", and less in {self.share(rival, mine)} of them"
        elif verdict == "better":
            text = f"A fuzzy law leads the entrants: {against} {compared(ratio, self.title(mine))}"
        else:
            text = f"A law that is not fuzzy leads the entrants: {best} "
            text += compared(self.of.pairs[mine, rival], self.title(rival))
        if len(fuzzy) > 1:
            rows = [(self.title(k), compared(self.of.pairs[k, rival], self.title(rival))) for k in fuzzy[1:3]]
            text += "; " + listed(f"{title}, also fuzzy, {words}" for title, words in rows)
        return [f"{head}{text}."]

    def conditions(self) -> list[str]:
        """Under each of the conditions: what knowledge is worth, and what the law is among those that know alike."""
        each = [(title if self.of.under else _GIVEN, Cells(of)) for title, of in self.of.by_condition.items()]
        worth = [(said, cells, [*cells.worth()]) for said, cells in each]
        return [_of_condition(said, cells, found) for said, cells, found in worth if found]

    def distances(self) -> list[str]:
        """How far each law is from the reference."""
        of, reference = self.of, self.of.reference
        if of.laws[reference] != of.arena.reference:
            return []
        others = [k for k in self.finite if k != reference][:_FEW]
        ratios = [(self.title(k), of.tuned_ratio[k]) for k in others]
        said = [
            f"{title} {float(r.value):.3g} ({_plain(float(r.low))} to {_plain(float(r.high))})" for title, r in ratios
        ]
        words = f"As multiples of {self.title(reference)}'s cost, with 95 % intervals: {', '.join(said)}."
        return [words] if said else []

    def tuning(self) -> list[str]:
        """What tuning was worth."""
        gain = self.of.gain
        helped = [k for k in self.of.order if gain.high[k] < 1]
        worse = [k for k in self.of.order if gain.low[k] > 1]
        left = len(self.of.order) - len(self.of.arena.untuned) - len(helped) - len(worse)
        helped.sort(key=lambda k: float(gain.value[k]))
        said = [f"of {self.title(k)} by {_percent(1 - float(gain.value[k]))}" for k in helped[:_FEW]]
        text = f"Tuning lowered the cost {listed(said)}" if said else "Tuning lowered no law's cost on the test"
        if len(helped) > _FEW:
            text += f", and that of {_number(len(helped) - _FEW)} more"
        if worse:
            text += f"; it raised that of {listed(self.titles(worse[:_FEW]))}"
        if left:
            other = "" if not (helped or worse) else "other "
            text += f"; for {_number(left)} {other}law{'s' * (left != 1)} it makes no difference that shows"
        reference = self.of.reference
        shares = {k: float(self.of.closed.value[k]) for k in self.finite if self.sort(k) in ("fuzzy", "lyapunov")}
        shares = {k: share for k, share in shares.items() if k != reference and np.isfinite(share)}
        closed = [f"{_percent(share)} of {self.title(k)}'s" for k, share in shares.items() if share > 0.005]
        if closed:
            text += f"; of the gap to {self.title(reference)} it closed {listed(closed[:4])}"
        return [text + "."]

    def computing(self) -> list[str]:
        """What the leader computes, and who is the best of those that compute much less."""
        if not self.of.clocked:
            return []
        times = np.array([self.of.computing[law] for law in self.of.laws])
        first = self.finite[0]
        cheap = [k for k in self.finite if times[k] <= _CHEAP * times[first]]
        text = f"{self.title(first)} computes for {microseconds(times[first])} a period"
        if cheap:
            best = cheap[0]
            text += f"; {self.title(best)}, the best of the laws that take at most a tenth of it "
            text += f"({microseconds(times[best])}), {compared(self.of.pairs[best, first])}"
        else:
            text += ", and no law that does not fail computes for less than a tenth of that"
        return [text + "."]

    def effort(self) -> list[str]:
        """Who turns the least, and what it costs."""
        effort = self.of.effort("tuned")
        if effort is None:
            return []
        least = min(self.finite, key=lambda k: float(effort[k]))
        first = self.finite[0]
        own = f"{effort[first]:.2g} rad/s²"
        if least == first:
            return [f"{self.title(first)} also has the least effort, {own} of turn rate variation."]
        return [
            f"The least effort has {self.title(least)}: its turn rate varies by {effort[least]:.2g} rad/s², that of "
            f"{self.title(first)} by {own}."
        ]

    def failures(self) -> list[str]:
        """Which laws failed in how many runs."""
        rates = self.of.failures
        failed = [k for k in self.of.order if rates.value[k] > 0]
        runs = self.of.tuned[0].size
        if not failed:
            return [f"No run of a tuned law failed; with {runs} runs each, a rate of {_share(float(rates.high[0]))} "
                    "cannot be ruled out."]  # fmt: skip
        failed.sort(key=lambda k: -float(rates.value[k]))
        said = [
            f"{self.title(k)} in {_share(float(rates.value[k]))} ({_share(float(rates.low[k]))} to "
            f"{_share(float(rates.high[k]))})"
            for k in failed[:_FEW]
        ]
        more = f", and {_number(len(failed) - _FEW)} others less often" if len(failed) > _FEW else ""
        return [f"Of {runs} runs each, these failed: {listed(said)}{more}."]

    def stands(self) -> str:
        """Whether the ranking hangs on the engine or on the cost's weights."""
        of = self.of
        orders = np.argsort(of.by_engine, axis=1, kind="stable")
        if len(orders) < 2:
            text = "Only one engine searched"
        elif (orders == orders[0]).all():
            text = "Both engines rank the laws alike" if len(orders) == 2 else "All engines rank the laws alike"
        else:
            pairs, same = int(swapped_pairs(orders)[1]), (orders[:, 0] == orders[0, 0]).all()
            text = f"The engines differ in {_number(pairs)} pair{'s' * (pairs != 1)} of laws"
            leads = zip(of.arena.engines, self.titles(orders[:, 0]), strict=True)
            text += ", not in who leads" if same else f": {listed(f'by {name} {law} leads' for name, law in leads)}"
        weights = of.reweighted
        if not weights.changed.any():
            return text + "; with any weight of the cost halved or doubled the order stays."
        first = {int(order[0]) for order in weights.order} - {int(weights.order[0][0])}
        most = int(weights.swapped.max())
        text += f"; a weight of the cost halved or doubled changes the order of up to {_number(most)} "
        text += f"pair{'s' * (most != 1)}"
        led = f"and {listed(self.titles(sorted(first)), 'or')} may lead then" if first else "not who leads"
        return f"{text}, {led}."

    def robustness(self) -> list[str]:
        """Which change hurts the most, and whom the least."""
        ratios = self.of.robustness.value[self.finite]
        worst = int(np.argmax(np.median(ratios, axis=0)))
        change, middle = list(CHANGES)[worst], float(np.median(ratios[:, worst]))
        if middle < 1 + MARGIN:
            return ["No change that the laws were not told of raises the median law's cost by 5 % or more."]
        then = self.of.robust_costs[:, worst]
        if not np.isfinite(then).any():
            return [f"Under {change}, of which no law is told, every law fails."]
        usual = f"the median law {f'costs {middle:.2g} times as much' if np.isfinite(middle) else 'fails'}"
        least = int(np.argmin(then))
        whose = "the leader" if least == self.finite[0] else self.title(least)
        return [
            f"Of the changes that no law was told of, {change} hurts the most: {usual}, and {whose} costs least then."
        ]


def _of_condition(said: str, cells: Cells, worth: Sequence[tuple[Knowledge, int, Interval]]) -> str:
    ratios = [f"with {_parts(parts)} {_multiple(ratio)}" for parts, _, ratio in worth]
    text = f"{said[:1].upper()}{said[1:]}: a tuned law costs {listed(ratios)} times what it costs without"
    most = max(cells.columns, key=lambda parts: (len(cells.among(parts)), len(parts)))
    alike = cells.among(most)
    if len(alike) > 1:
        first, last = (cells.of.titles[k] for k in (alike[0], alike[-1]))
        text += f"; of the {_number(len(alike))} laws with {_parts(most)} {last}, the last, "
        text += compared(cells.spread(most), first)
    return f"{text}."


def _parts(parts: Knowledge) -> str:
    return listed([f"a {word}" for word in called(parts).split(", ")]) if parts else "nothing beside"


def _multiple(ratio: Interval) -> str:
    return f"{float(ratio.value):.2f} ({float(ratio.low):.2f} to {float(ratio.high):.2f})"


# Words --------------------------------------------------------------------------------------------------------------


def compared(ratio: Interval, than: str = "") -> str:
    """How much one law costs against another, with the interval: "costs 8 % more than X (95 %: 6 to 11 %)"."""
    value, low, high = float(ratio.value), float(ratio.low), float(ratio.high)
    if np.isnan(value):
        return f"fails as {than or 'the other'} does"
    if not np.isfinite(value):
        return "fails"
    if value == 0:
        return f"does not fail as {than or 'the other'} does"
    if value >= _TIMES:
        other = f" as {than}" if than else ""
        return f"costs {value:.2g} times as much{other} (95 %: {_plain(low)} to {_plain(high)})"
    more = value >= 1
    ends = (low - 1, high - 1) if more else (1 - high, 1 - low)
    if min(ends) >= 0:
        between = f"{_bare(ends[0])} to {_percent(ends[1])}" if np.isfinite(ends[1]) else f"{_percent(ends[0])} or more"
    else:
        less, greater = ("less", "more") if more else ("more", "less")
        end = f"{_percent(ends[1])} {greater}" if np.isfinite(ends[1]) else "without bound"
        between = f"{_percent(-ends[0])} {less} to {end}"
    other = f" than {than}" if than else ""
    return f"costs {_percent(abs(value - 1))} {'more' if more else 'less'}{other} (95 %: {between})"


def _plain(value: float) -> str:
    return f"{value:.3g}" if np.isfinite(value) else "without bound"


def _bare(share: float) -> str:
    return f"{100 * share:.1f}" if abs(share) < 0.0995 else f"{100 * share:.0f}"


def _percent(share: float) -> str:
    return f"{_bare(share)} %"


def _share(share: float) -> str:
    return f"{100 * share:.2g} %" if share < 0.0995 else f"{100 * share:.0f} %"


def microseconds(value: float) -> str:
    """A computing time [µs] in two digits, or whole."""
    return f"{value:.2g} µs" if value < 100 else f"{value:.0f} µs"


def _number(count: int) -> str:
    words = ("no", "one", "two", "three", "four", "five", "six", "seven", "eight", "nine", "ten", "eleven", "twelve")
    return words[count] if count < len(words) else str(count)


def _runs(count: int) -> str:
    return f"{_number(count)} run{'s' * (count != 1)}"
