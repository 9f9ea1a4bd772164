"""The table of all metrics, and which of them are shown for a kind of scenario."""

from collections import ChainMap
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import numpy as np

from fuzzy.errors import concerning
from fuzzy.naming import expected
from robotics.measures.avoidance import EMERGENCY_METRICS
from robotics.measures.contacts import CONTACT_METRICS, can_touch, judge, until_contact
from robotics.measures.formations import FORMATION_METRICS
from robotics.measures.goals import GOAL_METRICS
from robotics.measures.own import (
    NO_METRICS,
    MetricError,
    OwnMetrics,
    installed_metrics,
    measured,
    metric_at,
    own_metric,
)
from robotics.measures.teams import TEAM_METRICS
from robotics.measures.tracking import METRICS, Metric
from robotics.simulation.run import Run
from robotics.simulation.scenario.description import Scenario

# A view of the tables, METRICS first, in which an entry that is added to one of them is found too.
ALL_METRICS: Mapping[str, Metric] = ChainMap(
    EMERGENCY_METRICS, CONTACT_METRICS, TEAM_METRICS, FORMATION_METRICS, METRICS, GOAL_METRICS
)


def own_metrics(given: OwnMetrics, kind: str | None = None) -> dict[str, Metric]:
    """Metrics of the user's own, by name: what ``metrics`` means wherever something is measured.

    Args:
        given: A list of specifications (``mymetric.py:comfort``, or a name that another package brings), functions of a
            run, and pairs of a name and either; or these by name.
        kind: The kind of scenarios in which all of them must be measured, if one is given.

    Raises MetricError for one that cannot be used, and for a name that is taken.
    """
    pairs: list[tuple[str, Any]] = []
    for item in given.items() if isinstance(given, Mapping) else given:
        name, thing = item if isinstance(item, tuple) and not isinstance(item, Metric) else ("", item)
        if isinstance(thing, str):
            found, thing = metric_at(thing)
            name = name or found
        elif not name:
            name = getattr(thing, "__name__", "")
            if not name or name == "<lambda>":
                raise MetricError(f"a metric needs a name: hand in a pair (name, metric); got {thing!r}")
        pairs.append((name, own_metric(thing, name)))
    own: dict[str, Metric] = {}
    for name, metric in pairs:
        if name in ALL_METRICS or name in _COLUMNS:
            raise MetricError(f"the metric {name} has the name of one that comes with fuzzyfleet: choose another")
        if name in own:
            raise MetricError(f"the metric {name} is given twice")
        if kind is not None and kind not in metric.kinds:
            raise MetricError(_of_kinds(name, metric, kind))
        own[name] = metric
    return own


def chosen_metrics(names: Sequence[str], kind: str) -> dict[str, Metric]:
    """The metrics that a scenario's file names as those of its task, by their names in tables.

    Args:
        names: Names of ALL_METRICS and of other packages' metrics, and specifications such as ``mymetric.py:comfort``.
        kind: The kind of the scenario.

    Raises MetricError about the number of one that there is not, that is another kind's, or that is named twice.
    """
    found: dict[str, Metric] = {}
    for i, text in enumerate(names):
        with concerning(i):
            if text in ALL_METRICS:
                one = {text: ALL_METRICS[text]}
                if kind not in one[text].kinds:
                    raise MetricError(
                        f"{_of_kinds(text, one[text], kind)}; measured there: {', '.join(metrics_of(kind))}"
                    )
            elif ".py" not in text and text not in (installed := installed_metrics()[0]):
                known = [*metrics_of(kind, True, True), *installed]
                raise MetricError(f"{expected(text, known, 'metric')}; or a file: mymetric.py:comfort")
            else:
                one = own_metrics([text], kind)
            if not found.keys().isdisjoint(one):
                raise MetricError(f"the metric {next(iter(one))} is named twice")
            found |= one
    return found


def named_by_scenarios(scenarios: Iterable[Scenario]) -> dict[str, str]:
    """The user's own metrics that files of scenarios name: their specifications by their names in tables.

    Raises MetricError for two of one name.
    """
    found: dict[str, str] = {}
    for text in dict.fromkeys(text for scenario in scenarios for text in scenario.metrics if text not in ALL_METRICS):
        (name,) = own_metrics([text])
        if found.setdefault(name, text) != text:
            raise MetricError(f"{found[name]} and {text} would both be called {name} in tables; rename one")
    return found


def with_named(scenarios: Iterable[Scenario], given: OwnMetrics = NO_METRICS) -> OwnMetrics:
    """The user's own metrics: those of :func:`named_by_scenarios` that are not also ``given``, and then these."""
    known = own_metrics(given)
    new = {name: text for name, text in named_by_scenarios(scenarios).items() if name not in known}
    return {**new, **given} if isinstance(given, Mapping) else [*new.values(), *given]


def _of_kinds(name: str, metric: Metric, kind: str) -> str:
    return f"the metric {name} is one of scenarios of kind {', '.join(metric.kinds)}, not of {kind}"


_COLUMNS = ("scenario", "point", "controller", "seed", "robot", "diverged", "contact")  # of tables, beside metrics


def metrics_of(
    kind: str, others: bool | None = None, guard: bool = False, own: Mapping[str, Metric] = NO_METRICS
) -> dict[str, Metric]:
    """The metrics of scenarios of a kind, by name.

    Args:
        kind: One of SCENARIO_KINDS.
        others: Whether there is something to touch, several robots or obstacles; by default of formations and teams.
        guard: Whether a law has an emergency rule.
        own: The user's own, of :func:`own_metrics`, which come last.
    """
    others = kind in ("formation", "team") if others is None else others
    found = {n: m for n, m in [*ALL_METRICS.items(), *own.items()] if kind in m.kinds}
    return {n: m for n, m in found.items() if (others or not m.needs_others) and (guard or not m.needs_guard)}


def headlines(
    kind: str, others: bool | None = None, guard: bool = False, own: Mapping[str, Metric] = NO_METRICS
) -> dict[str, Metric]:
    """The few metrics that short tables and pictures show, by name; those of no other kind come first, one's own last.

    The arguments are as of :func:`metrics_of`.
    """
    found = [item for item in metrics_of(kind, others, guard, own).items() if kind in item[1].headline]
    return dict(sorted(found, key=lambda item: (item[0] in own, len(item[1].kinds))))


def short_metrics(
    scenario: Scenario, others: bool | None = None, guard: bool = False, own: Mapping[str, Metric] = NO_METRICS
) -> dict[str, Metric]:
    """What short tables and pictures show of a scenario: those metrics that its file names, and one's own.

    Where it names none that is measured there, they are the :func:`headlines`, of which ``others``, ``guard`` and
    ``own`` are arguments, too.
    """
    there = metrics_of(scenario.kind, scenario.setting.has_others, guard, own)
    named = [name for name in chosen_metrics(scenario.metrics, scenario.kind) if name in there]
    if not named:
        return headlines(scenario.kind, others, guard, own)
    return {name: there[name] for name in dict.fromkeys([*named, *own]) if name in there}


def panel_metrics(kind: str, others: bool | None = None, own: Mapping[str, Metric] = NO_METRICS) -> dict[str, Metric]:
    """The metrics that the designer's panel "Try it" shows, by name, ordered as :func:`headlines`."""
    found = [item for item in metrics_of(kind, others, own=own).items() if kind in item[1].tried]
    return dict(sorted(found, key=lambda item: (item[0] in own, len(item[1].kinds))))


def measure_all(run: Run, metrics: OwnMetrics = NO_METRICS, only: Sequence[str] | None = None) -> dict[str, np.ndarray]:
    """Measure every metric that belongs to the run's scenario, each (runs, robots).

    What comes after a run's first contact is no result: all metrics but those of CONTACT_METRICS are measured on the
    samples up to then. Of a robot that was stopped before it drove there is no number, which would only tell where it
    began. A run's numbers do not depend, to the last bit, on which runs are beside it.

    Args:
        run: The run.
        metrics: The user's own metrics, as :func:`own_metrics` takes them; they come last.
        only: The names of those that are measured; by default all.

    Returns:
        The numbers by the metrics' names, each (runs, robots), in its unit.

    Raises:
        MetricError: One of these cannot be used, or fails.
    """
    own = own_metrics(metrics)
    counted = run.time_innermost()
    wanted = metrics_of(run.about.kind, can_touch(run), run.guarded is not None, own)
    if only is not None:
        wanted = {name: metric for name, metric in wanted.items() if name in only}
    if can_touch(run):
        counted = until_contact(counted, judge(run).first)
    found = {}
    for name, metric in wanted.items():
        if name in own:
            found[name] = measured(name, metric, counted)
        elif name in CONTACT_METRICS:
            found[name] = metric.measure(run)
        else:
            values = metric.measure(counted)
            found[name] = np.where((run.stopped == 0) & np.isfinite(values), np.nan, values)
    return found
