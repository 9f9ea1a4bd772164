"""The pictures of an arena: who leads and how surely, at which budget, at what effort, and what a change does to it."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal, NamedTuple

import numpy as np
from matplotlib.figure import Figure

from fuzzy.figures.drawing import COLORS
from fuzzy.figures.palette import ROLES, STRONG
from robotics.statistics.bootstrap import Interval

WIDTH = 6.3  # inches: 16 cm, the text of a printed page

Family = Literal["fuzzy", "lyapunov", "geometric", "linear", "predictive", "other"]


class _Look(NamedTuple):
    words: str
    color: str
    marker: str


_FAMILIES: dict[Family, _Look] = {
    "fuzzy": _Look("fuzzy", COLORS[0], "o"),
    "lyapunov": _Look("Lyapunov, sliding mode", COLORS[1], "s"),
    "geometric": _Look("geometric", COLORS[2], "^"),
    "linear": _Look("linear", STRONG[3], "D"),
    "predictive": _Look("predictive", COLORS[6], "P"),
    "other": _Look("other", ROLES["quiet"].light, "X"),
}


@dataclass(frozen=True)
class Entrant:
    """A law as pictures name and colour it."""

    title: str  # short: at most some 22 characters
    family: Family = "other"


@dataclass(frozen=True, eq=False)
class Standings:
    """What the one look shows; every array has a place for each law, not-a-number where nothing is known."""

    laws: Sequence[Entrant]
    reference: str  # the title of the law whose tuned cost is 1
    published: Interval  # (laws,), cost over the reference's, with the gains as published
    tuned: Interval  # (laws,), likewise tuned; infinite: fails
    failures: Interval  # (laws,), share of the tuned law's runs that failed, 0 to 1
    effort: np.ndarray  # (laws,), of the tuned law
    effort_title: str  # with its unit: "effort\n[rad/s²]"
    computing: np.ndarray  # (laws,) [µs], of one period
    numbers: np.ndarray  # (laws,), how many numbers were tuned


def plot_ranking(standings: Standings, width: float = WIDTH) -> Figure:
    """Draw the one look: laws from the least tuned cost down, as published and tuned, beside what they ask for.

    Hollow marks are costs as published, filled ones tuned, each with its 95 % interval, over the reference's tuned
    cost. A law whose statistic is infinite stands at the right edge as "fails".

    Args:
        standings: The laws and their numbers.
        width: The width of the figure in inches.
    """
    raise NotImplementedError


def plot_budget(
    laws: Sequence[Entrant], budgets: np.ndarray, curves: Interval, cost: str = "cost of the best so far [1]",
    width: float = WIDTH,
) -> Figure:  # fmt: skip
    """Draw the cost of the best so far over the number of evaluations, a line a law with a band over the repeats.

    Args:
        laws: The laws.
        budgets: The numbers of evaluations (budgets,).
        curves: Median and range over repeats (laws, budgets), of robotics.statistics.budget.over_budget.
        cost: What the axis of costs says, with its unit in brackets.
        width: The width of the figure in inches.
    """
    raise NotImplementedError


def plot_profiles(
    laws: Sequence[Entrant], limits: np.ndarray, profiles: Interval, cost: str = "cost [1]", width: float = WIDTH
) -> Figure:
    """Draw the share of runs that cost at most a limit, a panel a family, in it the other families' laws in grey.

    Args:
        laws: The laws.
        limits: The limits (limits,), > 0.
        profiles: The shares (laws, limits), of robotics.statistics.shares.performance_profile.
        cost: What the axis of costs says, with its unit in brackets.
        width: The width of the figure in inches.
    """
    raise NotImplementedError


def plot_improvement(laws: Sequence[Entrant], chances: Interval, verdicts: np.ndarray, width: float = WIDTH) -> Figure:
    """Draw the probability that the row's law costs less than the column's, with the verdict on each pair.

    Args:
        laws: The laws, in the order of rows and columns.
        chances: The probabilities (laws, laws), of robotics.statistics.shares.probability_of_improvement.
        verdicts: What robotics.statistics.pairs.verdicts says (laws, laws).
        width: The width of the figure in inches.
    """
    raise NotImplementedError


def plot_robustness(laws: Sequence[Entrant], changes: Sequence[str], ratios: Interval, width: float = WIDTH) -> Figure:
    """Draw what a change that no law was tuned for does to its cost: a heat map with numbers, rows laws.

    Args:
        laws: The laws, in the order of rows.
        changes: What is changed, in the order of columns: "mass +20 %".
        ratios: The cost with the change over the cost without (laws, changes); infinite: fails.
        width: The width of the figure in inches.
    """
    raise NotImplementedError


def plot_pareto(
    laws: Sequence[Entrant], effort: np.ndarray, precision: np.ndarray, titles: tuple[str, str],
    published: np.ndarray | None = None, width: float = WIDTH,
) -> Figure:  # fmt: skip
    """Draw precision against effort, a named point a law, and the front of those that none beats in both.

    Args:
        laws: The laws.
        effort: The tuned laws' effort (laws,), less is better.
        precision: The tuned laws' error (laws,), less is better.
        titles: What the axes of effort and of precision say, each with its unit in brackets.
        published: Effort and error as published (laws, 2), drawn hollow and joined to the tuned ones; None: not drawn.
        width: The width of the figure in inches.
    """
    raise NotImplementedError
