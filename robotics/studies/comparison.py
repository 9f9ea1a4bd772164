"""The comparison: scenarios × controllers × seeds, measured into one table with a row for each seed and robot."""

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import partial
from html import escape
from types import MappingProxyType
from typing import Any, NamedTuple

import numpy as np
import pandas as pd

from fuzzy.errors import InputError
from fuzzy.shown import shown
from fuzzy.sketch import table, titled
from fuzzy.words import counted
from robotics.laws.catalogue import OwnLaws, as_law, chosen_laws, gains_of, law_title, named_laws, shown_gain
from robotics.laws.law import Law
from robotics.measures.outside import OutsideInput, outside
from robotics.measures.own import NO_METRICS, OwnMetrics
from robotics.measures.registry import ALL_METRICS, measure_all, own_metrics, short_metrics, with_named
from robotics.measures.statistics.intervals import student
from robotics.measures.tracking import Metric
from robotics.simulation.loop import simulate
from robotics.simulation.run import Run
from robotics.simulation.scenario.description import Scenario
from robotics.studies.executors import Workers
from robotics.studies.pieces import run_pieces

DEFAULT_CONTROLLERS: dict[str, tuple[str, ...]] = {  # by the scenarios' kind
    "tracking": ("fuzzy", "lyapunov", "csm", "assm", "qssm", "esm"),
    "formation": ("formation", "formation-teacher"),
    "team": ("cooperation", "graph-esm", "virtual-structure"),
    "goal": ("fuzzy-park", "polar"),
}

_TITLES = {  # of columns that are no metrics
    "scenario": "name of the scenario",
    "condition": "condition of the study",
    "point": "number of the point of the design, from 1",
    "controller": "name of the controller",
    "seed": "seed of the run",
    "robot": "number of the robot, from 1",
    "diverged": "whether the robot lost its reference and was stopped",
    "contact": "whether any robot of the run touched another or an obstacle",
}
DRAWN_SEEDS = 100  # seeds that are simulated in one go, and of which pictures show the runs, at most


class ComparisonError(InputError):
    """Scenarios or controllers that cannot be compared with each other."""


class RunNotes(NamedTuple):
    """What is to be said of the runs of a controller on a scenario, beside their numbers."""

    divergences: tuple[str, ...]  # a sentence for every robot that was stopped
    outside: tuple[OutsideInput, ...]  # the inputs of learnt systems that left their data, the farthest first

    @classmethod
    def of(cls, run: Run) -> "RunNotes":
        """The notes on a run."""
        return cls(tuple(run.divergences()), tuple(outside(run)))


class RunsAgain(Mapping[tuple[str, str], Run]):
    """The runs of a comparison whose numbers are known: simulated again when asked for, the same to the last bit.

    Those of one scenario stay at hand. Of many seeds the first DRAWN_SEEDS are simulated, so that memory does not grow
    with their number.
    """

    def __init__(
        self,
        scenarios: Sequence[Scenario],
        laws: Mapping[str, Law[Any] | str],
        seeds: Sequence[int],
        there: Mapping[tuple[str, str], Run] = MappingProxyType({}),
    ) -> None:
        """``there`` are runs that are in memory already."""
        self.scenarios, self.laws = {scenario.name: scenario for scenario in scenarios}, laws
        self.seeds, self.there = tuple(seeds[:DRAWN_SEEDS]), there
        self.last: dict[tuple[str, str], Run] = {}

    def __getitem__(self, key: tuple[str, str]) -> Run:
        """The runs of a controller on a scenario."""
        if key in self.there:
            return self.there[key]
        if key not in self.last:
            self.last = {known: run for known, run in self.last.items() if known[0] == key[0]}
            self.last[key] = self.simulated(key, self.seeds)
        return self.last[key]

    def simulated(self, key: tuple[str, str], seeds: Sequence[int]) -> Run:
        """The runs of a controller on a scenario with some seeds."""
        scenario, law = key
        return simulate(self.scenarios[scenario], as_law(self.laws[law]), seeds, name=law)

    def __iter__(self) -> Iterator[tuple[str, str]]:
        """The names of scenarios and controllers."""
        return ((scenario, law) for scenario in self.scenarios for law in self.laws)

    def __len__(self) -> int:
        """The number of scenarios times that of controllers."""
        return len(self.scenarios) * len(self.laws)


@dataclass(frozen=True, eq=False)
class Comparison:
    """What was compared, and the table that came out.

    Attributes:
        scenarios: The scenarios, of one kind.
        controllers: The laws by their specifications, such as "csm" or "csm:k=0.3", or by the user's names.
        seeds: The seeds that each ran with.
        table: One row a seed and robot: scenario, controller, seed and robot, the metrics, diverged and contact (bool).
        runs: The runs by the names of scenario and controller.
        metrics: The user's own metrics, by name; those that scenarios' files name are among them.
        notes: What is to be said of the runs, by the same names.
        points: At how many points of a design each seed drove: seeds then number the runs of all of them.
        values: The numbers (seeds,) of claims, by scenario, controller, metric and whose number of a run it is.
    """

    scenarios: tuple[Scenario, ...]
    controllers: dict[str, Law[Any]]
    seeds: tuple[int, ...]
    table: pd.DataFrame
    runs: Mapping[tuple[str, str], Run]
    metrics: Mapping[str, Metric] = field(default_factory=dict)
    notes: Mapping[tuple[str, str], RunNotes] = field(default_factory=dict)
    values: Mapping[tuple[str, str, str, str], np.ndarray] = field(default_factory=dict)
    points: int = 1

    def __repr__(self) -> str:
        names = ", ".join(scenario.name for scenario in self.scenarios)
        return f"Comparison({names}: {', '.join(self.controllers)}; {counted(len(self.seeds), 'seed')})"

    def _repr_html_(self) -> str:
        """What a notebook shows: for each scenario the means of its most telling metrics, a row a controller."""
        parts = []
        for scenario in self.scenarios:
            found = short_metrics(scenario, own=self.metrics)
            names = [name for name in found if name in self.table and self.table[name].notna().any()]
            mine = self.table[self.table["scenario"] == scenario.name]
            rows = [
                [law, *(shown(float(mine.loc[mine["controller"] == law, name].mean()), 1.0) for name in names)]
                for law in self.controllers
            ]
            heads = [f"{found[name].short or found[name].title} [{found[name].unit}]" for name in names]
            parts.append(f"<p>{escape(scenario.name)}</p>" + table(("controller", *heads), rows))
        return titled("Comparison", f"means over {counted(len(self.seeds), 'seed')}", *parts)

    @property
    def counted_runs(self) -> str:
        """Of how many runs numbers are, in words."""
        seeds = counted(len(self.seeds) // self.points, "seed")
        return seeds if self.points == 1 else f"{counted(self.points, 'point')} × {seeds}"

    @property
    def drawn_seeds(self) -> int:
        """Of how many seeds pictures show runs."""
        return len(self.runs.seeds if isinstance(self.runs, RunsAgain) else self.seeds)

    @property
    def divergences(self) -> list[str]:
        """A sentence for every robot that was stopped."""
        return [line for note in self.notes.values() for line in note.divergences]


def compare(
    scenarios: Sequence[Scenario],
    controllers: OwnLaws,
    seeds: Sequence[int],
    *,
    metrics: OwnMetrics = NO_METRICS,
    workers: Workers | None = None,
    advance: Callable[[], None] | None = None,
) -> Comparison:
    """Run every controller on every scenario with the same seeds: same plant, sensors, noise and limits.

    Args:
        scenarios: Scenarios of one kind.
        controllers: A list of specifications, such as "csm:k=0.3" or "mylaw.py:MyLaw", of laws, and of pairs
            (name, law); or laws by name.
        seeds: The seeds; each gives one run of each controller on each scenario.
        metrics: The user's own metrics: a list of specifications, such as "mymetric.py:comfort", and of functions of
            a run; or these by name. They are measured and shown as the others are.
        workers: Simulate in other processes, with the same numbers; by default in this one.
        advance: Called after every simulated period; with ``workers`` after every scenario and controller.

    Returns:
        The table, a row a seed and robot, and the runs.

    Raises:
        ComparisonError: Nothing to compare, or scenarios of several kinds; told before anything is run.
        ControllerError: A controller that is unknown, or cannot drive a scenario; likewise.
        MetricError: A metric that cannot be used; likewise.
    """
    check_comparison(scenarios, controllers, metrics)
    laws, own = chosen_laws(controllers), own_metrics(with_named(scenarios, metrics))
    runs: dict[tuple[str, str], Run] = {}
    rows: list[pd.DataFrame] = []
    # A specification is made anew in another process, whose modules are its own
    given = laws if workers is None else dict(named_laws(controllers))
    progress, advance = (advance, None) if workers is None else (None, advance)
    for (scenario, name, _), run in run_pieces(
        partial(_run_of, seeds=tuple(seeds), progress=progress),
        [(scenario, name, law) for scenario in scenarios for name, law in given.items()],
        workers,
        called=lambda piece: f"scenario {piece[0].name!r}, controller {piece[1]!r}",
        ordered=True,
        advance=advance,
    ):
        runs[scenario.name, name] = run
        rows.append(rows_of(run, own))
    notes = {key: RunNotes.of(run) for key, run in runs.items()}
    return Comparison(tuple(scenarios), laws, tuple(seeds), pd.concat(rows, ignore_index=True), runs, own, notes)


def _run_of(
    piece: tuple[Scenario, str, Law[Any] | str], seeds: tuple[int, ...], progress: Callable[[], None] | None = None
) -> Run:
    """The runs of a scenario with a controller, of which the name comes first."""
    scenario, name, law = piece
    return simulate(scenario, as_law(law), seeds, name=name, progress=progress)


def check_comparison(scenarios: Sequence[Scenario], controllers: OwnLaws, metrics: OwnMetrics = NO_METRICS) -> None:
    """Raise ComparisonError unless the scenarios are of one kind and no name is given twice.

    Raises ControllerError for a specification that no controller has, and MetricError for a metric that cannot be used.
    """
    for what, names in (
        ("scenario", [s.name for s in scenarios]),
        ("controller", [name for name, _ in named_laws(controllers)]),
    ):
        for name in names:
            if names.count(name) > 1:
                raise ComparisonError(f"{what} {name!r} is given twice")
    kinds = sorted({scenario.kind for scenario in scenarios})
    if len(kinds) > 1:
        raise ComparisonError(f"scenarios of one kind can be compared; these are {', '.join(kinds)}")
    chosen_laws(controllers)
    for kind in kinds:
        own_metrics(with_named(scenarios, metrics), kind)


def rows_of(run: Run, metrics: OwnMetrics = NO_METRICS) -> pd.DataFrame:
    """The rows of the table that belong to ``run``, with ``metrics`` of the user's own.

    Where there is something to touch, ``contact`` says of all robots of a run whether one of them had a contact: their
    metrics are those up to the first one.
    """
    runs, robots = run.stopped.shape
    columns: dict[str, Any] = {
        "scenario": run.scenario,
        "controller": run.controller,
        "seed": np.repeat(run.seeds, robots),
        "robot": np.tile(np.arange(1, robots + 1), runs),
    }
    values = measure_all(run, metrics)
    columns |= {name: found.ravel() for name, found in values.items()}
    columns["diverged"] = run.diverged.ravel()
    if "contacts" in values:
        columns["contact"] = np.repeat((values["contacts"] > 0).any(axis=1), robots)
    return pd.DataFrame(columns)


def column_titles(names: Iterable[str], metrics: OwnMetrics = NO_METRICS) -> dict[str, tuple[str, str]]:
    """What columns of a comparison's table are, and their units ("" for none), by their names.

    Args:
        names: The columns. One that is neither a metric nor in every table is an axis, which its name explains.
        metrics: The user's own metrics with which the table was made.
    """
    known = {name: (about.title, about.unit) for name, about in {**ALL_METRICS, **own_metrics(metrics)}.items()}
    return {name: known.get(name) or (_TITLES.get(name, f"value of {name}"), "") for name in names}


def contact_runs(table: pd.DataFrame, scenario: str, controller: str) -> tuple[int, int]:
    """The number of runs with a contact, and of all runs, of a controller on a scenario in a comparison's table."""
    rows = table[(table["scenario"] == scenario) & (table["controller"] == controller)]
    if "contact" not in rows:
        return 0, rows["seed"].nunique()
    touched = rows["contact"].eq(True).groupby(rows["seed"]).any()
    return int(touched.sum()), len(touched)


def has_guard(table: pd.DataFrame) -> bool:
    """Whether one of the controllers in a comparison's table has an emergency rule."""
    return "emergency_share" in table and bool(table["emergency_share"].notna().any())


def values_of_runs(table: pd.DataFrame, metric: str, about: Metric) -> np.ndarray:
    """One number a run (seeds,) of the rows of one scenario and controller, as the metric's ``of_run`` says."""
    return np.asarray(table.groupby("seed")[metric].agg(about.of_run).to_numpy(dtype=float))


def summarise(table: pd.DataFrame, metrics: OwnMetrics = NO_METRICS) -> pd.DataFrame:
    """The mean and 95 % confidence interval of every metric, one row for each scenario, controller and metric.

    The interval is Student's over the seeds, mean ± t s/√n: it says how well n seeds fix the mean, not how far runs
    scatter. A metric that is infinite in any run (never settled, never arrived) has the mean inf and no interval.

    Args:
        table: The table of a :class:`Comparison`.
        metrics: The user's own metrics with which the table was made, such as ``comparison.metrics``.
    """
    rows = []
    present = {metric: about for metric, about in {**ALL_METRICS, **own_metrics(metrics)}.items() if metric in table}
    for (scenario, name), group in table.groupby(["scenario", "controller"], sort=False):
        for metric, about in present.items():
            # A single robot in an empty world has no contacts, and not every law has an emergency rule.
            if (about.needs_others or about.needs_guard) and group[metric].isna().all():
                continue
            # Robots of one run are not independent: the run's mean counts once.
            values = values_of_runs(group, metric, about)
            low, high = student(values)
            row = {"scenario": scenario, "controller": name, "metric": metric, "unit": about.unit, "seeds": len(values)}
            rows.append(row | {"mean": float(np.mean(values)), "low": low, "high": high})
    return pd.DataFrame(rows)


def terms(comparison: Comparison) -> pd.DataFrame:
    """The command level and the gains with which each controller entered, one row a controller."""
    rows = []
    for specification, law in comparison.controllers.items():
        gains = {k: v for k, v in gains_of(law).items() if k != "mode"}
        rows.append(
            {
                "controller": specification,
                "label": law_title(specification),
                "level": law.level,
                "gains": ", ".join(f"{k} = {shown_gain(v)}" for k, v in gains.items()),
            }
        )
    return pd.DataFrame(rows)
