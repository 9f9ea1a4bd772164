"""Several seeds of a trial: how each ended, its metrics and its paths, which of them is the worst, and their rounds.

As in :mod:`robotics.plugins.designer.tryout`, everything is in JSON's types. Seeds that are run together have, to the
last bit, the numbers that each has alone.
"""

import asyncio
import warnings
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from math import inf, isnan
from statistics import median
from typing import Any

from fuzzy.errors import InputError
from fuzzy.plugins.designer.workers import WorkError
from fuzzy.system import Sugeno
from robotics.laws.law import Law
from robotics.measures.own import installed_metrics
from robotics.measures.registry import measure_all
from robotics.plugins.designer import tryout
from robotics.plugins.designer.tryout import TryoutTrial
from robotics.simulation.loop import simulate

# The metric by which runs without a contact are ranked, by the kind of the scenario
RANKED_BY = {
    "tracking": "rms_cross_track_m",
    "team": "arrival_time_s",
    "formation": "max_lateral_error_m",
    "goal": "goal_time_s",
}
_NUMBERS = 24_000  # of the paths of all seeds and robots, at most: they are drawn again and again
COUNTS = (1, 5, 20)
_PAUSE = 0.5  # s without an edit before several seeds are run
_PORTION = 10  # seeds at a time: between two portions an edit ends the round
Work = tuple[Any, ...]  # the first seed, a function for a background process, and its arguments but the seeds
_MARKS = 5  # contacts of a seed that are drawn


def design_seeds(fis: Sugeno, trial: TryoutTrial, of: int, seeds: Sequence[int]) -> list[dict[str, Any]]:
    """The runs of ``fis`` in a settled trial, a row each as of :func:`seed_rows`, with paths. Raises an InputError.

    Args:
        fis: The system.
        trial: The trial, whose own seed is not looked at.
        of: How many seeds will be drawn together.
        seeds: The seeds to run now.
    """
    points = max(20, _NUMBERS // (3 * of * len(trial.conditioned().robots)))
    return seed_rows(tryout.driven_law(fis, trial), trial, seeds, points)


def rival_seeds(rival: Sugeno | str, trial: TryoutTrial, file: str, seeds: Sequence[int]) -> list[dict[str, Any]]:
    """The runs of another law or system, as of :func:`design_seeds`, without paths. Raises an InputError.

    With the name of its ``file`` a system drives in a law that it fits, if it does not fit the trial's.
    """
    if isinstance(rival, str):
        return seed_rows(tryout.rival_law(rival), trial, seeds, 0)
    if file:
        trial = tryout.settled(rival, trial, file)
    return seed_rows(tryout.driven_law(rival, trial), trial, seeds, 0)


def seed_rows(law: Law[Any], trial: TryoutTrial, seeds: Sequence[int], points: int) -> list[dict[str, Any]]:
    """A row for each seed, in their order.

    A row has its seed and, of a run that the law refused, why; else its outcomes, metrics, contacts, and with
    ``points`` > 0 the paths x, y [m] of the robots over as many times, and the cross_track error [m] of one that is
    alone. Where the law refuses the runs together, each is tried by itself.
    """
    scenario = trial.conditioned()
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # the panel tells them of the run that it shows
            run = simulate(scenario, law, tuple(seeds))
    except InputError as error:
        if len(seeds) == 1:
            return [{"seed": seeds[0], "why": str(error)}]
        return [row for seed in seeds for row in seed_rows(law, trial, [seed], points)]
    measured, cost = measure_all(run, installed_metrics()[0]), tryout.cost_of(trial, scenario.kind)
    rows = []
    for place in range(len(run.seeds)):
        row = tryout.seed_data(run, measured, scenario.divergence, place, _MARKS, cost)
        rows.append(row | (tryout.path_data(run, points, place) if points else {}))
    return rows


# All of them together -------------------------------------------------------------------------------------------


def state_of(row: dict[str, Any]) -> str:
    """What became of a row's run: "refused", "contact", "stopped" or "done"."""
    if "why" in row:
        return "refused"
    kinds = [kind for kind, _ in row["outcomes"]]
    return "contact" if "contact" in kinds else "stopped" if kinds else "done"


def worst_seed(rows: Sequence[dict[str, Any]], by: str) -> int:
    """The seed of the worst run: with the earliest contact, or else stopped, or refused, or with the largest ``by``."""

    def badness(row: dict[str, Any]) -> tuple[int, float]:
        state = state_of(row)
        if state == "contact":
            return 3, -float(row["contacts"][0][0])
        if state == "refused":
            return 1, 0.0
        return 2 * (state == "stopped"), _value(row["metrics"].get(by), False)

    return int(max(rows, key=badness)["seed"])


def summary(rows: Sequence[dict[str, Any]], metrics: Sequence[dict[str, Any]]) -> dict[str, Any]:
    """How many runs there are and how many of each state, and of each metric the median and the worst.

    Metrics are those of the runs that the law did not refuse; the median of an even number is the worse of the two in
    the middle if the better of them never came.

    Args:
        rows: The rows of all seeds.
        metrics: Those of the course, as of :func:`robotics.plugins.designer.tryout.course_data`.
    """
    states = [state_of(row) for row in rows]
    driven = [row for row in rows if "why" not in row]
    told: dict[str, Any] = {"median": {}, "worst": {}}
    for metric in metrics:
        name, larger = metric["name"], metric["larger"]
        values = [_value(row["metrics"][name], larger) for row in driven if name in row["metrics"]]
        for what, of in (("median", median), ("worst", min if larger else max)):
            value = of(values) if values else inf
            told[what][name] = None if not values or isnan(value) else "never" if abs(value) == inf else value
    whys = dict.fromkeys(row["why"] for row in rows if "why" in row)
    counts = {state: states.count(state) for state in ("contact", "stopped", "refused")}
    return {"runs": len(rows), **counts, "whys": list(whys), **told}


def without_rules(fis: Sugeno) -> dict[str, Sugeno]:
    """The system without one of its rules, by the name that its rows have."""
    return {f"without {n + 1}": fis.without_rule(n) for n in range(len(fis.rules))}


def rules_worth(
    fis: Sugeno, whole: dict[str, Any], without: dict[str, dict[str, Any]], metric: dict[str, Any] | None
) -> list[dict[str, Any]]:
    """What became of the runs without each rule, beside those with it: the rule that is missed most comes first.

    Args:
        fis: The system.
        whole: Its :func:`summary`.
        without: Those of :func:`without_rules` that are known, by name.
        metric: By which runs are ranked, as of :func:`robotics.plugins.designer.tryout.course_data`; None: nothing is.

    Returns:
        A row each: the rule's number from 1, its text, what is "told", and whether something is worse.
    """
    if metric is None:
        return []
    name, words = metric["name"], {"contact": "touch", "stopped": "are stopped", "refused": "are refused"}
    title, unit = metric["title"].partition(":")[0], "" if metric["unit"] == "1" else f" {metric['unit']}"
    rows = []
    for key, found in without.items():
        number = int(key.removeprefix("without "))
        more = {state: found[state] - whole[state] for state in words}
        medians = [
            _value(None if s["median"][name] == "never" else s["median"][name], metric["larger"])
            for s in (found, whole)
        ]
        worse = (medians[0] - medians[1]) * (-1 if metric["larger"] else 1)
        said = [
            f"{found[state]} of {found['runs']} {words[state]} ({whole[state]} with it)"
            for state in words
            if more[state]
        ]
        here, there = ("never" if abs(m) == inf else f"{m:.3g}" for m in medians)
        if here != there:
            said.append(f"{title} {here}{'' if here == 'never' else unit} ({there})")
        rank = (*(more[state] for state in words), worse if here != there else 0.0)
        row = {"rule": number, "text": str(fis.rules[number - 1]), "told": ", ".join(said) or "nothing changes"}
        rows.append((rank, row | {"worse": rank > (0, 0, 0, 0.0)}))
    return [row for _, row in sorted(rows, key=lambda item: item[0], reverse=True)]


def _value(value: float | str | None, larger: bool) -> float:
    """A metric's value as a number; what never came, and what is not known, is the worst that there can be."""
    return float(value) if isinstance(value, (int, float)) else (-inf if larger else inf)


# Run in small portions once nothing else is to be run: the newest wins ----------------------------------------------


@dataclass
class SeedRounds:
    """The rounds of one page."""

    background: Callable[..., Any]
    work: Callable[[], dict[str, Work]]  # of "tried", "before" and "rival"; empty: there is nothing to run
    progress: Callable[[], None]  # told when ``done`` is another
    publish: Callable[[str], None]  # told what has new rows
    count: int = 1
    picked: int | None = None  # the seed that was chosen by hand
    worst: int | None = None
    done: int | None = None  # seeds of the present round; None: there is no round
    rows: dict[str, tuple[Any, list[dict[str, Any]]]] = field(default_factory=dict)  # by name, with what made them
    _round: asyncio.Task[None] | None = None

    def shown(self, first: int) -> int:
        """The seed that is drawn and played, if the ``first`` is the trial's own."""
        if self.count == 1:
            return first
        return next((seed for seed in (self.picked, self.worst) if seed is not None), first)

    def seeds(self, first: int) -> list[int]:
        """All seeds."""
        return list(range(first, first + self.count))

    def forget(self) -> None:
        """Begin anew: the conditions are others."""
        self.rest()
        self.picked = self.worst = None
        self.rows.clear()

    def rest(self) -> None:
        """End the round: something else is to be run first."""
        if self._round is not None:
            self._round.cancel()
        if self.done is not None:
            self.done = None
            self.progress()

    def wake(self) -> None:
        """Begin a round after a pause, unless all is known."""
        self.rest()
        work = self.work() if self.count > 1 else {}
        if any(self._known(name, made) is None for name, made in work.items()):
            self.done = 0
            self.progress()
            self._round = asyncio.get_running_loop().create_task(self._run())

    def known(self) -> dict[str, list[dict[str, Any]]]:
        """The rows of all work that is known, by name."""
        work = self.work() if self.count > 1 else {}
        return {name: rows for name, made in work.items() if (rows := self._known(name, made)) is not None}

    def _known(self, name: str, made: Work) -> list[dict[str, Any]] | None:
        have = self.rows.get(name)
        return have[1] if have is not None and have[0] == (made, self.count) else None

    async def _run(self) -> None:
        await asyncio.sleep(_PAUSE)
        for name, made in self.work().items():
            if self._known(name, made) is None:
                self.rows[name] = (made, self.count), await self._rows(made)
                self.publish(name)
        self.done = None
        self.progress()

    async def _rows(self, made: Work) -> list[dict[str, Any]]:
        """The rows of all seeds."""
        first, function, *rest = made
        seeds = self.seeds(first)
        rows: list[dict[str, Any]] = []
        for begin in range(0, len(seeds), _PORTION):
            part: Sequence[int] = seeds[begin : begin + _PORTION]
            try:
                rows += await self.background(function, *rest, part)
            except (InputError, WorkError) as error:
                rows += [{"seed": seed, "why": str(error)} for seed in part]
            self.done = (self.done or 0) + len(part)
            self.progress()
        return rows
