"""The answer of an arena of tasks in ten sentences at most, made of its numbers."""

from collections.abc import Iterator

import numpy as np

from fuzzy.shown import shown
from fuzzy.words import counted, listed
from robotics.measures.statistics.intervals import Interval
from robotics.plugins.arena.answer import MOST_SENTENCES
from robotics.plugins.tasks.outcome import BY_CHANCE, TaskOutcome

_WORDS = {
    "caused": "contacts caused",
    "deadlock": "deadlocks",
    "time": "time",
    "spread_s": "the spread of the arrivals",
    "gap": "the gap",
    "restlessness": "restlessness",
    "clearance_m": "the least clearance",
}


def answer(outcome: TaskOutcome) -> list[str]:
    """The sentences, MOST_SENTENCES at most."""
    found = [*(_of_class(outcome, knowledge) for knowledge in outcome.filled), *_across(outcome), *_none(outcome)]
    found += [*_guards(outcome), *_hardest(outcome), *_time(outcome), *_refused(outcome), *_tuning(outcome)]
    return [*found[: MOST_SENTENCES - 1], _protocol(outcome)]


def per_thousand(found: Interval, k: int) -> str:
    """A share with its exact bounds, in words."""
    value, low, high = (1000 * float(part[k]) for part in (found.value, found.low, found.high))
    return f"{value:.3g} of 1,000 ({low:.3g} to {high:.3g})"


def _of_class(outcome: TaskOutcome, knowledge: str) -> str:
    """Who is first of those that know the same, by what, and how surely."""
    first, *others = outcome.among(knowledge)
    caused, locked = outcome.share("caused"), outcome.share("deadlock")
    text = (
        f"With {knowledge}, {outcome.titles[first]} is first: it causes contacts in {per_thousand(caused, first)} runs"
    )
    text += f" and deadlocks in {per_thousand(locked, first)}"
    if not others:
        return f"{text}; nobody else in this class takes part."
    second = others[0]
    by = outcome.decided_by(first, second)
    text += f"; {outcome.titles[second]}, the next, "
    if by in ("caused", "deadlock"):
        share = caused if by == "caused" else locked
        text += f"has {_WORDS[by]} in {per_thousand(share, second)}"
        if outcome.surely(by, first, second) >= BY_CHANCE:
            text += ", a difference that may be chance"
    elif by:
        text += f"is as good in contacts and deadlocks, and behind it in {_WORDS[by]}"
    else:
        text += "is as good"
    return text + "."


def _across(outcome: TaskOutcome) -> Iterator[str]:
    """What knowing more is worth: the first of each class."""
    firsts = [outcome.among(knowledge)[0] for knowledge in outcome.filled]
    if len(firsts) > 1:
        best = min(firsts, key=lambda k: outcome.keys[k])
        others = [k for k in firsts if k != best]
        sure = [k for k in others if outcome.surely("caused", best, k) < BY_CHANCE]
        text = f"Of the firsts {outcome.titles[best]}, with {outcome.classes[best]}, causes the fewest contacts"
        if len(sure) == len(others):
            text += ", and that is no chance"
        else:
            alike = [outcome.titles[k] for k in others if k not in sure]
            text += f"; from {listed(alike, 'or')} these runs cannot tell it apart in this"
        yield text + "."


def _none(outcome: TaskOutcome) -> Iterator[str]:
    """Who caused no contact at all, and what cannot be ruled out."""
    caused = outcome.share("caused")
    clean = [k for k in outcome.order if caused.value[k] == 0]
    if clean:
        bound = 1000 * float(caused.high[clean[0]])
        yield (
            f"No contact in {outcome.runs:,} runs was caused by {listed([outcome.titles[k] for k in clean])}; "
            f"a rate of up to {shown(bound, digits=2)} of 1,000 cannot be ruled out."
        )
    else:
        yield f"Every law caused contacts in {counted(outcome.runs, 'run')}."


def _guards(outcome: TaskOutcome) -> Iterator[str]:
    """What the emergency rules are worth."""
    without, caused = outcome.share("caused", unguarded=True), outcome.share("caused")
    own = [k for k in outcome.order if np.isfinite(without.value[k])]
    if own:
        said = [
            f"{outcome.titles[k]} {1000 * float(without.value[k]):.3g} instead of {1000 * float(caused.value[k]):.3g}"
            for k in own
        ]
        yield f"Without their emergency rule contacts are caused per 1,000 runs by {listed(said)}."


def _hardest(outcome: TaskOutcome) -> Iterator[str]:
    """Where contacts and deadlocks are."""
    caused, locked = outcome.by_family("caused"), outcome.by_family("deadlock")
    usual, stuck = caused.median(axis=1), locked.median(axis=1)
    if len(usual) > 1:
        yield (
            f"Most contacts are caused in {usual.idxmax()}, by the median law in {100 * usual.max():.3g} % of runs, "
            f"and most deadlocks are in {stuck.idxmax()}, of the median law in {100 * stuck.max():.3g} %."
        )


def _time(outcome: TaskOutcome) -> Iterator[str]:
    """What caution costs."""
    time = outcome.mean("time")
    quick = min(outcome.order, key=lambda k: float(time.value[k]))
    first = outcome.order[0]
    if quick != first:
        yield (
            f"{outcome.titles[quick]} is quickest with {time.value[quick]:.3g} times the nominal time; "
            f"{outcome.titles[first]}, which causes the fewest contacts of all, takes {time.value[first]:.3g} times."
        )


def _refused(outcome: TaskOutcome) -> Iterator[str]:
    """Who did not start."""
    refused = outcome.share("refused")
    said = [(k, float(refused.value[k])) for k in outcome.order if refused.value[k] > 0]
    if said:
        words = [f"{outcome.titles[k]} {100 * share:.3g} %" for k, share in said]
        yield f"Runs that a law refused, or whose robots lack its sensors, count as deadlocks: {listed(words)}."


def _tuning(outcome: TaskOutcome) -> Iterator[str]:
    """Whose numbers the search has changed."""
    changed = [outcome.titles[k] for k, entry in enumerate(outcome.entries) if entry.chosen]
    kept = [outcome.titles[k] for k, entry in enumerate(outcome.entries) if not entry.chosen]
    text = f"The search found better numbers for {listed(changed)}" if changed else "No search found better numbers"
    yield (
        f"{text}; {listed(kept)} {'drives' if len(kept) == 1 else 'drive'} with the published ones."
        if kept
        else text + "."
    )


def _protocol(outcome: TaskOutcome) -> str:
    """What was done."""
    arena = outcome.arena
    tuned = len(arena.laws) - len(arena.untuned)
    searches = arena.repeats * len(arena.engines)
    alike = ", the same budget for all" if not arena.exceptions else ""
    return (
        f"{counted(tuned, 'law')} had {arena.evaluations} evaluations on {counted(arena.count('tune'), 'scenario')} in "
        f"{'one search' if searches == 1 else f'each of {searches} searches'}{alike}, and everybody drove the same "
        f"{outcome.runs:,} random scenarios that no search had seen, {len(arena.test)} sorts of them."
    )
