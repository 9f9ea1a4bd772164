"""Several seeds of a trial: how each ended, its metrics and its paths, and which of them is the worst.

As in :mod:`robotics.plugins.designer.tryout`, everything is in JSON's types. Seeds that are run together have, to the
last bit, the numbers that each has alone.
"""

import warnings
from collections.abc import Sequence
from math import inf, isnan
from statistics import median
from typing import Any

from fuzzy.errors import InputError
from fuzzy.system import Sugeno
from robotics.laws.law import Law
from robotics.measures.contacts import can_touch, contacts
from robotics.measures.own import installed_metrics
from robotics.measures.registry import measure_all
from robotics.measures.tracking import cross_track_error
from robotics.plugins.designer.moments import evenly, rounded_list
from robotics.plugins.designer.tryout import (
    TryoutTrial,
    contact_mark,
    driven_law,
    outcomes,
    reduced_metrics,
    rival_law,
    settled,
)
from robotics.simulation.loop import simulate
from robotics.simulation.run import Run

# The metric by which runs without a contact are ranked, by the kind of the scenario
RANKED_BY = {"tracking": "rms_cross_track_m", "team": "arrival_time_s", "formation": "max_lateral_error_m"}
_NUMBERS = 24_000  # of the paths of all seeds and robots, at most: they are drawn again and again
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
    return seed_rows(driven_law(fis, trial), trial, seeds, points)


def rival_seeds(specification: str, trial: TryoutTrial, seeds: Sequence[int]) -> list[dict[str, Any]]:
    """The runs of another law, as of :func:`design_seeds`, without paths. Raises an InputError."""
    return seed_rows(rival_law(specification), trial, seeds, 0)


def system_seeds(fis: Sugeno, trial: TryoutTrial, file: str, seeds: Sequence[int]) -> list[dict[str, Any]]:
    """The runs of another system, as of :func:`design_seeds`, without paths. Raises an InputError.

    With the name of its ``file`` it drives in a law that it fits, if it does not fit the trial's.
    """
    if file:
        trial = settled(fis, trial, file)
    return seed_rows(driven_law(fis, trial), trial, seeds, 0)


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
    measured = measure_all(run, installed_metrics()[0])
    rows = []
    for place, seed in enumerate(run.seeds):
        row: dict[str, Any] = {
            "seed": seed,
            "outcomes": outcomes(run, scenario.divergence, place),
            "metrics": reduced_metrics(scenario.kind, measured, place),
            "contacts": [contact_mark(c) for c in contacts(run, place, _MARKS)],
        }
        rows.append(row | (_paths(run, place, points) if points else {}))
    return rows


def _paths(run: Run, place: int, points: int) -> dict[str, Any]:
    kept = evenly(len(run.time), points)
    drawn: dict[str, Any] = {name: [rounded_list(row[kept]) for row in run[name][place]] for name in ("x", "y")}
    if run.about.kind == "tracking" and not can_touch(run):
        error = cross_track_error(run)[place]
        drawn |= {"cross_track": [rounded_list(row[kept]) for row in error], "time": rounded_list(run.time[kept])}
    return drawn


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

    seed: int = max(rows, key=badness)["seed"]
    return seed


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


def _value(value: float | str | None, larger: bool) -> float:
    """A metric's value as a number; what never came, and what is not known, is the worst that there can be."""
    return float(value) if isinstance(value, (int, float)) else (-inf if larger else inf)
