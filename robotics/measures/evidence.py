"""Evidence: numbers with their 95 % intervals, and the one rule that makes verdicts of them.

A claim consists of parts. A part is a number that must lie on one side of a bound, and its interval decides: it holds
where the whole interval lies on that side, fails where the whole interval lies on the other, and is open otherwise.
Of a bound on a number of each run that number is the share of runs that keep it, which must be more than one half
unless the part asks for more: one run that never arrives does not make all of them late. The parts of all claims of a
study are one family: a part that Holm's step-down over all of them does not leave below 5 % is open, too.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from math import inf
from typing import Literal, NamedTuple

import numpy as np

from robotics.measures.statistics.intervals import LEVEL, student, wilson
from robotics.measures.statistics.pairs import holm

FEWEST_RUNS = 20  # of a mean that decides
FEWEST_TRIALS = 200  # of a rate that decides

# The forms of the laws of a publication: as its text has them, corrected, corrected without noise, and corrected with
# the gains and rules that equal tuning found; "": no forms
Form = Literal["", "as printed", "corrected", "ideal", "tuned"]
FORMS: tuple[Form, ...] = ("as printed", "corrected", "ideal", "tuned")
CLOSE = 0.1  # of a bound: a number that is not farther from it is marked
Outcome = Literal["holds", "fails", "open"]
Verdict = Literal["holds", "holds in part", "does not hold", "cannot be told"]


@dataclass(frozen=True)
class Estimate:
    """A number and its 95 % interval; of one exact number both ends are that number."""

    value: float
    low: float
    high: float
    runs: int  # from which it comes; 1: exact
    kind: Literal["mean", "rate", "exact"] = "mean"
    lost: int = 0  # of the runs, whose number is infinite: a mean leaves them out

    def p_value(self, bound: float) -> float:
        """How probable a number as far from ``bound`` is if the bound is the truth, two-sided.

        By Student's test or the score test, whose p is below 5 % where the interval leaves the bound out.
        """
        from scipy.stats import norm, t

        apart = abs(self.value - bound)
        if self.kind == "rate":
            spread = np.sqrt(bound * (1 - bound) / self.runs)
            return float(2 * norm.sf(apart / spread)) if spread else float(apart == 0)
        half, freedom = (self.high - self.low) / 2, self.runs - self.lost - 1
        if not np.isfinite(half):
            return 1.0
        return float(2 * t.sf(apart / half * t.ppf((1 + LEVEL) / 2, freedom), freedom)) if half else float(apart == 0)


def exact(value: float) -> Estimate:
    """A number without chance: of a formula, or of a run without noise."""
    return Estimate(float(value), float(value), float(value), 1, "exact")


def mean_of(values: np.ndarray) -> Estimate:
    """The mean of the finite ``values`` (seeds,) with Student's interval, mean ± t s/√n; infinite ones are counted.

    A robot that never arrives has no time of arrival, which says nothing of the other runs. Where no value is finite
    the mean is infinite, and its interval too. Of fewer than two values the interval is everything.
    """
    values = np.asarray(values, dtype=float)
    known = values[~np.isinf(values)]
    lost = len(values) - len(known)
    if not len(known) and len(values) > 1:
        return Estimate(values[0], values[0], values[0], len(values), lost=lost)
    mean = float(np.mean(known)) if len(known) else float(values[0])
    if np.isnan(mean) or len(known) < 2:
        return Estimate(mean, -inf, inf, len(values), lost=lost)
    low, high = student(known)
    return Estimate(mean, low, high, len(values), lost=lost)


def rate_of(happened: np.ndarray) -> Estimate:
    """The share of ``happened`` (trials,) bool with Wilson's 95 % interval [Wilson 1927]."""
    happened = np.asarray(happened, dtype=bool)
    n, share = len(happened), float(np.mean(happened))
    found = wilson(int(happened.sum()), n)
    return Estimate(share, float(found.low), float(found.high), n, "rate")


class Limit(NamedTuple):
    """A bound on the number of each run."""

    sense: Literal["below", "above"]
    value: float  # in the unit of the number

    def keeps(self, values: np.ndarray) -> np.ndarray:
        """Which ``values`` keep it."""
        return values < self.value if self.sense == "below" else values > self.value


class Room(NamedTuple):
    """How far a number must lie beyond a rival's to be less (or more); below 0: how far it may fall behind."""

    margin: float = 0.0  # in the unit of the numbers
    share: float = 0.0  # of the size of the rival's number, seed by seed


def compared(
    ours: np.ndarray, others: Sequence[np.ndarray], more: bool = False, room: Room | None = None
) -> tuple[Estimate, float, Literal["below", "above"], int]:
    """How ``ours`` (seeds,) lies to the least of ``others`` seed by seed, and the bound that it must keep to be less.

    Last, in how many seeds it is less.

    Where every value is finite this is the mean difference, which must be below 0. Otherwise it is the share of seeds
    in which ours is not less, which must be below one half. With ``more`` it is the greatest of the others, and ours
    must be greater. With ``room`` the difference must be below minus the margin; a share of the rival's number is taken
    off that number in every seed, so that the interval also tells how well the share itself is known.
    """
    room = room or Room()
    ours, several = np.asarray(ours, dtype=float), np.stack([np.asarray(other, dtype=float) for other in others])
    rival = several.max(axis=0) if more else several.min(axis=0)
    if room.share:
        rival = np.where(np.isfinite(rival), rival + (1 if more else -1) * room.share * np.abs(rival), rival)
    lost = ~(ours > rival + room.margin if more else ours < rival - room.margin)
    if min(room) < 0:  # both never: neither is worse
        lost &= ours != rival
    kept = int((~lost).sum())
    if np.isfinite(ours).all() and np.isfinite(rival).all():
        apart = ours - rival
        bound = room.margin if more else 0.0 - room.margin
        return (exact(apart[0]) if len(apart) == 1 else mean_of(apart)), bound, "above" if more else "below", kept
    return (exact(float(lost[0])) if len(lost) == 1 else rate_of(lost)), 0.5, "below", kept


@dataclass(frozen=True, kw_only=True)
class Part:
    """One thing that a claim says, of one form of the laws, and the number that decides it."""

    says: str
    form: Form = ""
    estimate: Estimate
    bound: float
    sense: Literal["below", "above"]  # on which side of the bound the number must lie
    unit: str
    quantity: str  # what was measured
    on: str  # the scenario or experiment
    robots: str = "worst"  # whose number it is: "worst", "mean", or that of one, from "1"
    of: str  # the law
    against: tuple[str, ...] = ()  # the laws to which it is compared: the number is then a difference
    sides: tuple[Estimate, ...] = ()  # of a comparison: ``of`` and ``against`` by themselves; of a limit: the number
    scale: float = 1.0  # of a comparison with a share of the rival's number: 0.9 for "10 % less"
    fewest: int = 1  # runs without which nothing is told
    note: str = ""  # what a reader must know of the runs, such as contacts, in a sentence
    kept: int = 0  # of the runs: in which it is so
    limit: Limit | None = None  # a bound on each run's number: ``estimate`` is the share of runs that keep it
    origin: str = ""  # where the bound comes from, in a few words
    adjusted: float | None = None  # the p-value, for the number of all parts of the study (:func:`adjusted`)

    @property
    def close(self) -> bool:
        """Whether the number lies within a tenth of the bound on it: a little other bound would judge otherwise."""
        if self.limit is None:
            return False
        return abs(self.sides[0].value - self.limit.value) <= CLOSE * abs(self.limit.value)

    @property
    def outcome(self) -> Outcome:
        """Whether the part holds, fails, or cannot be told."""
        if self.estimate.runs < self.fewest:
            return "open"
        if self.adjusted is not None and self.adjusted >= 1 - LEVEL:
            return "open"
        low, high = self.estimate.low, self.estimate.high
        if self.sense == "above":
            low, high = -high, -low
        bound = self.bound if self.sense == "below" else -self.bound
        return "holds" if high < bound else "fails" if low >= bound else "open"


def adjusted(parts: Sequence[Part]) -> list[Part]:
    """The same parts, each with its p-value adjusted by Holm's step-down over all of them that depend on chance."""
    found = list(parts)
    chance = [i for i, p in enumerate(parts) if p.estimate.kind != "exact" and p.estimate.runs >= p.fewest]
    p_values = np.array([parts[i].estimate.p_value(parts[i].bound) for i in chance])
    for i, p in zip(chance, holm(p_values), strict=True):
        found[i] = replace(found[i], adjusted=float(p))
    return found


def judge(parts: Sequence[Part]) -> Verdict:
    """The verdict on a claim, by what became of its parts.

    All hold: it holds. Some part fails: it holds in part if another holds, and otherwise does not hold. No part fails,
    but some are open: it cannot be told.
    """
    found = {part.outcome for part in parts}
    if found == {"holds"}:
        return "holds"
    if "fails" in found:
        return "holds in part" if "holds" in found else "does not hold"
    return "cannot be told"
