"""What each part of a law is worth: the law drives without it, on the same runs, and the differences are told.

A difference is that of a variant from the whole law, run by run, in runs in which both have a number (of time and
spread those in which all arrive), with Student's 95 % interval. A part is needed where something is worse without it
beyond the interval. Nothing is adjusted for the number of parts that are looked at: 1 in 40 that is worth nothing looks
needed in each number.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from itertools import product
from typing import Any

import numpy as np
import pandas as pd

from fuzzy.quantity import whole
from fuzzy.shell.progress import Begin, unwatched
from robotics.laws.catalogue import as_law
from robotics.measures.evidence import mean_of
from robotics.plugins.ablation.tasks import AblationTask, Numbers, tasks_of
from robotics.plugins.ablation.variants import WHOLE, AblationError, variants
from robotics.studies.executors import Workers
from robotics.studies.pieces import run_pieces


@dataclass(frozen=True, kw_only=True)
class AblationPlan:
    """What is taken from a law, and what it drives then."""

    law: str
    each_rule: tuple[str, ...] = ()  # the rule bases whose rules are left out one at a time
    on: tuple[str, ...] = ()  # scenarios
    crossings: int = whole(40, least=0, doc="Number of random crossings that a team drives; 0: none.")
    courses: int = whole(16, least=0, doc="Number of random obstacle courses that it drives; 0: none.")
    seeds: int = whole(20, least=0, doc="Number of seeds on each scenario; 0: none.")
    shuffles: int = whole(2, least=0, doc="How often each rule base's consequents are shuffled.")
    seed: int = whole(0, least=0, doc="The first seed.")  # of each task, and that of the shuffles

    @property
    def tasks(self) -> list[AblationTask]:
        """What is driven."""
        return tasks_of(self.law, self.crossings, self.courses, self.seeds, self.on)


@dataclass(frozen=True, eq=False)
class Ablation:
    """What was found.

    Attributes:
        table: A row a variant, task and number: variant, base, rule, task, measured, runs (in which both have the
            number), whole and value (the means), difference, low, high, worse ("yes": beyond the interval).
    """

    table: pd.DataFrame

    @property
    def needed(self) -> dict[str, bool]:
        """Whether something is worse without it, by variant."""
        worse = self.table["worse"] == "yes"
        return {str(name): bool(some) for name, some in worse.groupby(self.table["variant"], sort=False).any().items()}

    @property
    def sentences(self) -> list[str]:
        """What is worse without it beyond the interval, in a sentence a variant."""
        found = []
        for name, rows in self.table.groupby("variant", sort=False):
            worse = rows[rows["worse"] == "yes"]
            said = [_said(row) for row in worse.to_dict("records")]
            found.append(f"{name}: {'; '.join(said) if said else 'nothing is worse beyond the interval'}.")
        return found


def _said(row: Mapping[Any, Any]) -> str:
    value, whole = (f"{row[k]:.3g}" for k in ("value", "whole"))
    return f"{row['measured']} {whole} -> {value} ({row['task']})"


def ablate(plan: AblationPlan, workers: Workers | None = None, begin: Begin = unwatched) -> Ablation:
    """Drive a law without each of its parts.

    Args:
        plan: The law, what is taken from it, and what it drives.
        workers: Who does the work, by default this process.
        begin: Starts a bar of a progress display, by its text and total.

    Raises AblationError for a law without rule bases, a rule base that it does not have or an unknown scenario.
    """
    found = variants(as_law(plan.law), plan.each_rule, plan.shuffles, plan.seed)
    tasks = plan.tasks
    if not tasks:
        raise AblationError("nothing is driven: crossings, courses and seeds are all 0")
    pieces = list(product(range(len(found)), range(len(tasks))))
    advance = begin("driving", len(pieces))
    numbers = dict(run_pieces(partial(_driven, plan), pieces, workers, advance=advance))
    rows = [
        {"variant": variant.name, "base": variant.base, "rule": variant.rule, "task": task.name} | row
        for (v, variant), (t, task) in product(enumerate(found), enumerate(tasks))
        if variant.name != WHOLE
        for row in _compared(numbers[0, t], numbers[v, t])
    ]
    return Ablation(pd.DataFrame(rows))


def _driven(plan: AblationPlan, piece: tuple[int, int]) -> Numbers:
    """In a worker, which makes the law by itself: that of a user's file is known only where the file has run."""
    variant = variants(as_law(plan.law), plan.each_rule, plan.shuffles, plan.seed)[piece[0]]
    task = plan.tasks[piece[1]]
    return task.measure(variant.law, range(plan.seed, plan.seed + task.runs))


def _compared(whole: Numbers, without: Numbers) -> Sequence[dict[str, object]]:
    rows = []
    for name, ours in whole.items():
        theirs = without[name]
        both = np.isfinite(ours) & np.isfinite(theirs)
        if not both.any():
            continue
        apart = mean_of(theirs[both] - ours[both])
        means = {"whole": float(ours[both].mean()), "value": float(theirs[both].mean())}
        interval = {"difference": apart.value, "low": apart.low, "high": apart.high}
        worse = "yes" if apart.low > 0 else "no"
        rows.append({"measured": name, "runs": int(both.sum()), **means, **interval, "worse": worse})
    return rows
