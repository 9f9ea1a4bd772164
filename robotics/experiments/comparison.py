"""The comparison: scenarios × controllers × seeds, measured into one table with a row for each seed and robot."""

from collections import deque
from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import Future
from dataclasses import dataclass, field
from itertools import islice
from typing import Any

import numpy as np
import pandas as pd

from fuzzy.errors import InputError
from robotics.experiments.executors import Workers
from robotics.laws.catalogue import gains_of, law_title, make_controller
from robotics.laws.law import Law
from robotics.measures.evidence import student
from robotics.measures.registry import ALL_METRICS, measure_all
from robotics.measures.tracking import Metric
from robotics.scenario.description import Scenario
from robotics.simulation.loop import simulate
from robotics.simulation.run import Run

DEFAULT_CONTROLLERS: dict[str, tuple[str, ...]] = {  # by the scenarios' kind
    "tracking": ("fuzzy", "lyapunov", "csm", "assm", "qssm", "esm"),
    "formation": ("formation", "formation-teacher"),
    "team": ("cooperation", "graph-esm", "virtual-structure"),
}
KEYS = ["scenario", "controller", "seed", "robot"]


class ComparisonError(InputError):
    """Scenarios or controllers that cannot be compared with each other."""


@dataclass(frozen=True, eq=False)
class Comparison:
    """What was compared, and the table that came out."""

    scenarios: tuple[Scenario, ...]
    controllers: dict[str, Law[Any]]  # by specification, such as "csm:k=0.3", or by the name that was given to it
    seeds: tuple[int, ...]
    table: pd.DataFrame  # one row a seed and robot: KEYS, the metrics, diverged and contact (bool) as of rows_of
    runs: dict[tuple[str, str], Run]  # by scenario name and controller
    specifications: Mapping[str, str] = field(default_factory=dict)  # of the controllers that have other names
    metrics: Mapping[str, Metric] = field(default_factory=dict)  # of one's own, beside those of the package

    def specification(self, controller: str) -> str:
        """The specification of a controller."""
        return self.specifications.get(controller, controller)

    @property
    def divergences(self) -> list[str]:
        """A sentence for every robot that was stopped."""
        return [line for run in self.runs.values() for line in run.divergences()]


def compare(
    scenarios: Sequence[Scenario],
    specifications: Sequence[str] | Mapping[str, str],
    seeds: Sequence[int],
    *,
    metrics: Mapping[str, Metric] | None = None,
    workers: Workers | None = None,
    advance: Callable[[], None] | None = None,
    finished: Callable[[pd.DataFrame], None] | None = None,
) -> Comparison:
    """Run every controller on every scenario with the same seeds: same plant, sensors, noise and limits.

    Args:
        scenarios: Scenarios of one kind.
        specifications: Controllers, such as "csm" or "csm:k=0.3"; or by the names that tables and pictures give them.
        seeds: The seeds; each gives one run of each controller on each scenario.
        metrics: Metrics of one's own, by their names, that are measured beside those of the package.
        workers: Simulate in other processes, with the same numbers; by default in this one.
        advance: Called after every simulated period; with ``workers`` after every scenario and controller.
        finished: Called with the table so far after every scenario and controller, so that an interrupted comparison
            loses nothing that is done.

    Raises ComparisonError and ControllerError, as :func:`check_comparison` does, before anything is run.
    """
    named = dict(specifications) if isinstance(specifications, Mapping) else {name: name for name in specifications}
    check_comparison(scenarios, list(named.values() if isinstance(specifications, Mapping) else specifications))
    laws = {name: make_controller(specification) for name, specification in named.items()}
    pairs = [(scenario, name) for scenario in scenarios for name in laws]
    runs: dict[tuple[str, str], Run] = {}
    rows: list[pd.DataFrame] = []
    for (scenario, name), run in zip(pairs, _simulated(pairs, named, laws, seeds, workers, advance), strict=True):
        runs[scenario.name, name] = run
        rows.append(rows_of(run, metrics))
        if finished is not None:
            finished(pd.concat(rows, ignore_index=True))
    table = pd.concat(rows, ignore_index=True)
    return Comparison(tuple(scenarios), laws, tuple(seeds), table, runs, named, dict(metrics or {}))


def _simulated(
    pairs: Sequence[tuple[Scenario, str]],
    named: Mapping[str, str],
    laws: Mapping[str, Law[Any]],
    seeds: Sequence[int],
    workers: Workers | None,
    advance: Callable[[], None] | None,
) -> Iterator[Run]:
    """The runs of the pairs of a scenario and a controller, in their order."""
    if workers is None:
        for scenario, name in pairs:
            yield simulate(scenario, laws[name], seeds, name=name, progress=advance)
        return
    waiting = iter(pairs)
    flying: deque[Future[Run]] = deque()
    while True:
        for scenario, name in islice(waiting, workers.in_flight - len(flying)):
            flying.append(workers.executor.submit(_run_of, scenario, named[name], tuple(seeds), name))
        if not flying:
            return
        yield flying.popleft().result()
        if advance is not None:
            advance()


def _run_of(scenario: Scenario, specification: str, seeds: tuple[int, ...], name: str) -> Run:
    """In a worker: the runs of one scenario and controller."""
    return simulate(scenario, make_controller(specification), seeds, name=name)


def check_comparison(scenarios: Sequence[Scenario], specifications: Sequence[str]) -> None:
    """Raise ComparisonError unless the scenarios are of one kind and no name is given twice.

    Raises ControllerError for a specification that no controller has.
    """
    for what, names in (("scenario", [s.name for s in scenarios]), ("controller", list(specifications))):
        for name in names:
            if names.count(name) > 1:
                raise ComparisonError(f"{what} {name!r} is given twice")
    kinds = sorted({scenario.kind for scenario in scenarios})
    if len(kinds) > 1:
        raise ComparisonError(f"scenarios of one kind can be compared; these are {', '.join(kinds)}")
    for specification in specifications:
        make_controller(specification)


def rows_of(run: Run, metrics: Mapping[str, Metric] | None = None) -> pd.DataFrame:
    """The rows of the table that belong to ``run``, with ``metrics`` of one's own beside those of the package.

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


def values_of_runs(table: pd.DataFrame, metric: str, about: Metric | None = None) -> np.ndarray:
    """One number a run (seeds,) of the rows of one scenario and controller, as the metric's ``of_run`` says.

    What the metric is ``about`` is given where it is none of the package's.
    """
    of_run = (about or ALL_METRICS[metric]).of_run
    return np.asarray(table.groupby("seed")[metric].agg(of_run).to_numpy(dtype=float))


def summarise(table: pd.DataFrame, metrics: Mapping[str, Metric] | None = None) -> pd.DataFrame:
    """The mean and 95 % confidence interval of every metric, one row for each scenario, controller and metric.

    The interval is Student's over the seeds, mean ± t s/√n: it says how well n seeds fix the mean, not how far runs
    scatter. A metric that is infinite in any run (never settled, never arrived) has the mean inf and no interval.
    ``metrics`` are those of one's own.
    """
    rows = []
    present = {metric: about for metric, about in {**ALL_METRICS, **(metrics or {})}.items() if metric in table}
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
    for name, law in comparison.controllers.items():
        gains = {k: v for k, v in gains_of(law).items() if k != "mode"}
        rows.append(
            {
                "controller": name,
                "label": law_title(name),
                "level": law.level,
                "gains": ", ".join(f"{k} = {v:g}" if isinstance(v, float) else f"{k} = {v}" for k, v in gains.items()),
            }
        )
    return pd.DataFrame(rows)
