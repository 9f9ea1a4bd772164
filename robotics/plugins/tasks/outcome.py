"""What came of an arena of tasks: who is first in each class of knowledge, and how surely.

Laws are ranked in the order of dictionaries: by the share of runs in which one of their robots drove into something;
where that is the same by the share of deadlocks; then by the time over nominal, the spread of the arrivals, the gap,
restlessness and the least clearance. A run is one scenario, and scenarios are drawn independently: the bounds of the
shares are exact, those of means are by a bootstrap of scenarios, and two laws are compared on the same scenarios.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
import pandas as pd

from robotics.measures.statistics.intervals import LEVEL, Interval, clopper_pearson
from robotics.plugins.arena.entered import ArenaOutcome
from robotics.plugins.arena.work import Search
from robotics.plugins.tasks.description import CLASSES, TaskArena, knowledge_of

SHARES = ("caused", "deadlock")
MEANS = ("time", "spread_s", "gap", "restlessness")  # less is better
KEY = (*SHARES, *MEANS, "clearance_m")  # the order of the ranking
_DRAWS = 2000
BY_CHANCE = 0.05  # p below which two shares differ


def key_of(table: pd.DataFrame) -> tuple[float, ...]:
    """What a table of runs is ranked by, the first number first; what no run has counts as worst."""
    means = [float(table[name].mean()) for name in (*SHARES, *MEANS)]
    least = float(table["clearance_m"].min())
    return tuple(np.inf if np.isnan(value) else value for value in (*means, -least))


@dataclass(frozen=True, eq=False)
class TaskEntry:
    """What is known of one law."""

    law: str  # its specification
    parameters: tuple[str, ...]  # that were tuned
    searches: tuple[Search, ...]
    ends: tuple[int, ...]  # the candidates that were chosen among; 0: the law as published
    chosen: int  # of these
    values: tuple[float, ...] | None  # of the chosen one; None: as published
    choosing: pd.DataFrame = field(repr=False)  # a row a candidate and run
    runs: pd.DataFrame = field(repr=False)  # of the test, a row a scenario
    unguarded: pd.DataFrame | None = field(repr=False)  # the same without the emergency rule; None: there is none


@dataclass(frozen=True, eq=False)
class TaskOutcome(ArenaOutcome):
    """What came of an arena of tasks; arrays have a place for each law, in the arena's order."""

    arena: TaskArena
    entries: tuple[TaskEntry, ...]

    @cached_property
    def classes(self) -> list[str]:
        """What each law knows, one of CLASSES."""
        return [knowledge_of(law) for law in self.made]

    @property
    def runs(self) -> int:
        """How many scenarios were tested on."""
        return self.arena.count("test")

    @cached_property
    def keys(self) -> list[tuple[float, ...]]:
        """What each law is ranked by."""
        return [key_of(entry.runs) for entry in self.entries]

    @cached_property
    def order(self) -> list[int]:
        """The places of all laws, the first in the ranking first."""
        return sorted(range(len(self.entries)), key=lambda k: (self.keys[k], k))

    def among(self, knowledge: str) -> list[int]:
        """The places of the laws of one class, likewise."""
        return [k for k in self.order if self.classes[k] == knowledge]

    @property
    def filled(self) -> list[str]:
        """The classes that have a law."""
        return [knowledge for knowledge in CLASSES if self.among(knowledge)]

    def share(self, name: str, unguarded: bool = False) -> Interval:
        """The share of each law's runs with a contact caused, a deadlock and the like, with the exact bounds.

        It is of the runs of which this is known: of contacts those that the law drove.
        """
        tables = [entry.unguarded if unguarded else entry.runs for entry in self.entries]
        counts = np.array([0.0 if t is None else float(t[name].sum()) for t in tables])
        trials = np.array([0 if t is None else int(t[name].notna().sum()) for t in tables])
        found, none = clopper_pearson(counts, np.maximum(trials, 1)), trials == 0
        return Interval(*(np.where(none, np.nan, part) for part in (found.value, found.low, found.high)))

    def mean(self, name: str) -> Interval:
        """The mean of each law's runs that have the number, with its interval by a bootstrap of scenarios."""
        rows = np.stack([entry.runs[name].to_numpy(dtype=float) for entry in self.entries])
        generator = np.random.default_rng([self.arena.seed, len(rows)])
        drawn = generator.integers(rows.shape[1], size=(_DRAWS, rows.shape[1]))
        there = ~np.isnan(rows)
        filled = np.nan_to_num(rows)
        with np.errstate(invalid="ignore", divide="ignore"):
            value = filled.sum(axis=1) / there.sum(axis=1)
            again = np.stack([f[drawn].sum(axis=1) / t[drawn].sum(axis=1) for f, t in zip(filled, there, strict=True)])
        low, high = np.full(len(rows), np.nan), np.full(len(rows), np.nan)
        for k, row in enumerate(again):
            if np.isfinite(row).any():
                low[k], high[k] = np.nanquantile(row, [(1 - LEVEL) / 2, (1 + LEVEL) / 2])
        return Interval(value, low, high)

    def least_clearance(self, k: int) -> float:
        """The least clearance of a law in all its runs [m]; less than 0: so deep it was in something."""
        return float(self.entries[k].runs["clearance_m"].min())

    def surely(self, name: str, k: int, other: int) -> float:
        """How likely a share that differs so much on the same scenarios is by chance: McNemar's exact p."""
        return paired_p(self.entries[k].runs[name].to_numpy(), self.entries[other].runs[name].to_numpy())

    def decided_by(self, k: int, other: int) -> str:
        """By which number of KEY one law is before another; "" if by none."""
        pairs = zip(KEY, self.keys[k], self.keys[other], strict=True)
        return next((name for name, a, b in pairs if a != b), "")

    def by_family(self, name: str) -> pd.DataFrame:
        """The share of runs in which something happened, a row a family of the test, a column a law."""
        labels = [family.label for family in self.arena.test for _ in range(family.count)]
        columns = {
            title: entry.runs.sort_values("scenario")[name].to_numpy()
            for title, entry in zip(self.titles, self.entries, strict=True)
        }
        return pd.DataFrame(columns).groupby(labels, sort=False).mean()


def paired_p(first: Sequence[float] | np.ndarray, second: Sequence[float] | np.ndarray) -> float:
    """McNemar's exact two-sided p of two rows of 0 and 1 on the same runs: by those in which only one has 1.

    Runs of which one is not known, not-a-number, do not count.
    """
    from scipy.stats import binomtest

    rows = np.array([first, second], dtype=float)
    a, b = rows[:, ~np.isnan(rows).any(axis=0)] > 0
    only, other = int((a & ~b).sum()), int((b & ~a).sum())
    return 1.0 if only + other == 0 else float(binomtest(only, only + other, 0.5).pvalue)
