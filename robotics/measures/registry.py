"""The table of all metrics, and which of them are shown for a kind of scenario."""

from collections import ChainMap
from collections.abc import Mapping

import numpy as np

from robotics.measures.contacts import CONTACT_METRICS, can_touch, judge, until_contact
from robotics.measures.emergencies import EMERGENCY_METRICS
from robotics.measures.formations import FORMATION_METRICS
from robotics.measures.teams import TEAM_METRICS
from robotics.measures.tracking import METRICS, Metric
from robotics.simulation.run import Run

# A view of the five tables, METRICS first, in which an entry that is added to one of them is found too.
ALL_METRICS: Mapping[str, Metric] = ChainMap(
    EMERGENCY_METRICS, CONTACT_METRICS, TEAM_METRICS, FORMATION_METRICS, METRICS
)


def metrics_of(kind: str, others: bool | None = None, guard: bool = False) -> dict[str, Metric]:
    """The metrics of scenarios of a kind, by name.

    Args:
        kind: "tracking", "formation" or "team".
        others: Whether there is something to touch, several robots or obstacles; by default not in "tracking".
        guard: Whether a law has an emergency rule.
    """
    others = kind != "tracking" if others is None else others
    found = {n: m for n, m in ALL_METRICS.items() if kind in m.kinds}
    return {n: m for n, m in found.items() if (others or not m.needs_others) and (guard or not m.needs_guard)}


def headlines(kind: str, others: bool | None = None, guard: bool = False) -> dict[str, Metric]:
    """The few metrics that short tables and pictures show, by name; those of no other kind come first.

    The arguments are as of :func:`metrics_of`.
    """
    found = [item for item in metrics_of(kind, others, guard).items() if kind in item[1].headline]
    return dict(sorted(found, key=lambda item: len(item[1].kinds)))


def tried(kind: str, others: bool | None = None) -> dict[str, Metric]:
    """The metrics that the designer's panel "Try it" shows, by name, ordered as :func:`headlines`."""
    found = [item for item in metrics_of(kind, others).items() if kind in item[1].tried]
    return dict(sorted(found, key=lambda item: len(item[1].kinds)))


def measure_all(run: Run, own: Mapping[str, Metric] | None = None) -> dict[str, np.ndarray]:
    """Measure every metric that belongs to the run's scenario, and those of one's ``own``, each (runs, robots).

    What comes after a run's first contact is no result: all metrics but those of CONTACT_METRICS are measured on the
    samples up to then. A run's numbers do not depend, to the last bit, on which runs are beside it.
    """
    laid = run.time_innermost()
    wanted = metrics_of(run.about.kind, can_touch(run), run.guarded is not None) | dict(own or {})
    if not can_touch(run):
        return {name: metric.measure(laid) for name, metric in wanted.items()}
    judged = judge(run)
    whole, counted = judged.measured(), until_contact(laid, judged.first)
    return {name: whole[name] if name in whole else metric.measure(counted) for name, metric in wanted.items()}
