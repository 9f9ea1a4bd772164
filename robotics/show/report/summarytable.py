"""The numbers of one scenario as a table to read: a row for each metric, a column for each controller."""

from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np
import pandas as pd

from robotics.laws.catalogue import law_title
from robotics.measures.leading import Lead, lead
from robotics.measures.registry import chosen_metrics, metrics_of, short_metrics
from robotics.measures.tracking import Metric
from robotics.show.report.wording import digits
from robotics.simulation.scenario.description import Scenario
from robotics.studies.comparison import Comparison, contact_runs, has_guard, summarise, values_of_runs

_PREFIXED = ("m", "rad", "m/s")  # units that may take the prefix milli


class Cell(NamedTuple):
    """One metric of one controller."""

    mean: str
    half: str  # half the width of the 95 % interval; "" where there is none, "0" where none of its digits is seen
    mark: str  # "lowest", "≈ lowest" or ""


class MetricRow(NamedTuple):
    """One metric of every controller."""

    title: str
    unit: str
    larger: bool  # whether larger is better
    cells: list[Cell]


class SummaryTable(NamedTuple):
    """The table of one scenario, how many robots of each controller were stopped, and how many runs had a contact."""

    controllers: list[str]  # as titles
    rows: list[MetricRow]
    diverged: list[tuple[int, int]]  # robots that were stopped, and all robots
    contacts: list[tuple[int, int]]  # runs with a contact, and all runs; empty where there is nothing to touch


def summary_table(
    comparison: Comparison, scenario: str, first: Sequence[str] = (), only: Mapping[str, Metric] | None = None
) -> SummaryTable:
    """Make the table of the scenario with that name, from :func:`robotics.studies.comparison.summarise`.

    The metrics ``first`` come before the others, and then those that the scenario's file names; ``only`` some are in
    it, if these are given.
    """
    table = comparison.table[comparison.table["scenario"] == scenario]
    summary = summarise(table, comparison.metrics).set_index(["metric", "controller"])
    names, by_law = list(comparison.controllers), _by_law(comparison, scenario)
    rows = []
    about_it = next(s for s in comparison.scenarios if s.name == scenario)
    setting, first = about_it.setting, [*first, *chosen_metrics(about_it.metrics, about_it.kind)]
    contacts = {name: contact_runs(table, scenario, name) for name in names} if setting.has_others else {}
    touched = {name: count for name, (count, _) in contacts.items()}
    known = only or metrics_of(setting.kind, setting.has_others, has_guard(table), comparison.metrics)
    for metric in dict.fromkeys([*(name for name in first if name in known), *known]):
        about = known[metric]
        found = summary.loc[metric]
        numbers = found.reindex(names)[["mean", "low", "high"]].to_numpy(dtype=float)
        by_seed = {name: values_of_runs(own, metric, about) for name, own in by_law.items()}
        factor, unit = scale(about.unit, numbers[:, 0])
        marks = [""] * len(names)
        if not about.larger and len(found) > 1:
            marks = _marks(lead(scenario, about.title, about.unit, by_seed, touched))
        cells = [
            _cell(factor * row, int(np.isposinf(by_seed[name]).sum()), len(by_seed[name]), mark)
            if name in found.index
            else Cell("–", "", "")  # it has no emergency rule
            for name, row, mark in zip(names, numbers, marks, strict=True)
        ]
        rows.append(MetricRow(about.title, unit, about.larger, cells))
    stopped = [own["diverged"] for own in by_law.values()]
    return SummaryTable(
        [law_title(n) for n in names], rows, [(int(s.sum()), len(s)) for s in stopped], [*contacts.values()]
    )


def _by_law(comparison: Comparison, scenario: str) -> dict[str, pd.DataFrame]:
    """The rows of a scenario's runs, by controller."""
    table = comparison.table[comparison.table["scenario"] == scenario]
    return {name: table[table["controller"] == name] for name in comparison.controllers}


def shown_metrics(
    comparison: Comparison,
    scenario: Scenario,
    first: Sequence[str] = (),
    others: bool | None = None,
    guard: bool = False,
) -> dict[str, Metric]:
    """The few metrics that a report shows on a scenario: those of ``first`` that are measured there, then its own few.

    What its own few are says :func:`robotics.measures.registry.short_metrics`, of which ``others`` and ``guard`` are.
    """
    table = comparison.table[comparison.table["scenario"] == scenario.name]
    known = metrics_of(scenario.kind, scenario.setting.has_others, has_guard(table), comparison.metrics)
    head = {name: known[name] for name in first if name in known}
    return head | short_metrics(scenario, others, guard, comparison.metrics)


def printed_metrics(comparison: Comparison, scenario: Scenario, first: Sequence[str] = ()) -> dict[str, Metric]:
    """The metrics of :func:`shown_metrics` that a command line prints, that of emergency rules where there are some."""
    table = comparison.table[comparison.table["scenario"] == scenario.name]
    return shown_metrics(comparison, scenario, first, scenario.setting.has_others, has_guard(table))


def leading_metric(comparison: Comparison, scenario: Scenario, first: Sequence[str] = ()) -> tuple[str, Metric]:
    """The metric that says who leads: the first that somebody wants ``first``, or of which less is better."""
    shown = shown_metrics(comparison, scenario, first)
    return next(item for item in shown.items() if first or scenario.metrics or not item[1].larger)


def comparison_leads(comparison: Comparison, first: Sequence[str] = ()) -> list[Lead]:
    """Who leads in each scenario, by its :func:`leading_metric`."""
    found = []
    for scenario in comparison.scenarios:
        metric, about = leading_metric(comparison, scenario, first)
        found.append(lead_by(metric, about, _by_law(comparison, scenario.name), scenario.name))
    return found


def lead_by(metric: str, about: Metric, by_law: Mapping[str, pd.DataFrame], name: str) -> Lead:
    """Who leads by a ``metric`` in a scenario called ``name``, from the rows of its runs by law."""
    values = {law: values_of_runs(rows, metric, about) for law, rows in by_law.items()}
    contacts = {law: contact_runs(rows, rows["scenario"].iloc[0], law)[0] for law, rows in by_law.items()}
    return lead(name, about.short or about.title, about.unit, values, contacts, about.larger)


def scale(unit: str, means: np.ndarray) -> tuple[float, str]:
    """The factor and the unit with which a row is easiest to read: thousandths where every mean is below 1."""
    known = means[np.isfinite(means)]
    if unit in _PREFIXED and known.size and 0 < np.abs(known).max() < 1:
        return 1000.0, f"m{unit}"
    return 1.0, unit


def _cell(numbers: np.ndarray, never: int, seeds: int, mark: str) -> Cell:
    mean, low, high = (float(v) for v in numbers)
    if never:
        return Cell("never" if never == seeds else f"never in {never} of {seeds}", "", mark)
    if not np.isfinite(mean):
        return Cell("no sample", "", mark)
    number, half = digits(mean, (high - low) / 2)
    return Cell(number, half or ("0" if np.isfinite(high) else ""), mark)


def _marks(found: Lead) -> list[str]:
    """Mark the controller with the lowest mean, and those that the seeds, paired, cannot tell apart from it.

    One with contacts is none of them, whatever its numbers.
    """
    means = [each.value.value for each in found.standings]
    if len(means) < 2 or np.isnan(found.best) or np.ptp(means) == 0:
        return [""] * len(means)
    return [
        "" if each.contacts else "lowest" if mean == found.best else "≈ lowest" if each.leads else ""
        for each, mean in zip(found.standings, means, strict=True)
    ]
