"""Driving a law through scenarios of teams: a row a run, with all that the ranking asks."""

import warnings
from collections.abc import Iterable, Mapping
from typing import Any, NamedTuple

import numpy as np
import pandas as pd

from fuzzy.compiled.columns import Floats1, Ints1
from robotics.laws.equation import CommandColumns
from robotics.laws.law import ControllerError, Law
from robotics.plugins.stress.outcome import StressOutcome
from robotics.plugins.stress.tally import run_ensemble
from robotics.plugins.tasks.families import TaskScenario
from robotics.simulation.observer import Observer, observer
from robotics.world.paths.road import Road, nearest, share
from robotics.world.vehicle.plant import TruthColumns

_REACH = 0.5  # m, within which a robot's place on its path is looked for from one period to the next
_THERE = 0.98  # of the path: who is beyond has arrived, as far as restlessness counts


class TeamNotes(NamedTuple):
    """What is noted of one run: how far the robots are from each other in progress, and how they turn."""

    road: Road
    place: Floats1  # (robots,) m: on their paths
    gap: Floats1  # (1,): the greatest difference of two robots' shares of their ways so far
    before: Floats1  # (robots,) rad/s: the turn rate commanded one period ago
    turned: Floats1  # (robots,) rad/s: by how much it has varied
    counted: Ints1  # (robots,): in so many periods


@observer
def watch_team(moment, notes):  # type: ignore[no-untyped-def]
    """Note progress and turn rates of the one run there is."""
    least, greatest = 1.0, 0.0
    for i in range(moment.robots):
        truth, w = TruthColumns(moment.truth, i), CommandColumns(moment.command, i).wish_w
        notes.place[i] = nearest(notes.road, i, truth.x, truth.y, notes.place[i], _REACH)
        progress = share(notes.road, i, notes.place[i])
        least, greatest = min(least, progress), max(greatest, progress)
        if progress < _THERE and moment.goes_on[0]:
            if moment.k > 0 and w == w and notes.before[i] == notes.before[i]:
                notes.turned[i] += abs(w - notes.before[i])
                notes.counted[i] += 1
            notes.before[i] = w
    if moment.goes_on[0]:
        notes.gap[0] = max(notes.gap[0], greatest - least)
    return False


def drive(scenarios: Iterable[tuple[int, TaskScenario]], law: Law[Any]) -> pd.DataFrame:
    """Drive scenarios, given with their places; a row each, as :func:`run_row` makes it."""
    return pd.DataFrame([{"scenario": place, **run_row(scenario, law)} for place, scenario in scenarios])


def run_row(scenario: TaskScenario, law: Law[Any]) -> Mapping[str, float]:
    """What became of one run.

    ``caused``: whether a robot drove into something; ``touched``: whether anything touched; ``deadlock``: whether not
    all robots arrived, also because the law refused or cannot drive these robots (``refused``): of such a run nothing
    else is known, and contacts are counted of the others, so that to refuse makes nobody safer; ``time``: of the last
    arrival over the nominal time, at a deadlock the limit; ``spread_s``: between the first and the last arrival;
    ``gap``: the greatest difference of two robots' progress; ``restlessness``: how much the turn rates commanded vary
    [rad/s²]; ``clearance_m``: the least distance to anything, less than 0 inside of it; ``emergency``: the share of the
    time in which an emergency rule acted.
    """
    setting, robots = scenario.setting, len(scenario.setting.robots)
    noted = TeamNotes(
        setting.references.road,
        np.zeros(robots),
        np.zeros(1),
        np.full(robots, np.nan),
        np.zeros(robots),
        np.zeros(robots, dtype=np.int64),
    )
    try:
        with warnings.catch_warnings(action="ignore"):  # a rule base that is asked outside of its universe
            outcome = run_ensemble(
                StressOutcome,
                setting,
                law,
                [scenario.seed],
                scenario.faults,
                extra=scenario.extra,
                beside=lambda first, last: Observer(watch_team, noted),
            )
    except ControllerError:  # it lacks a sensor that the law needs, say: the robots stay where they are
        return _stayed(scenario)
    if outcome.refused[0]:
        return _stayed(scenario)
    arrived, ratio = bool(outcome.arrived[0]), float(outcome.arrivals.max() / outcome.nominal[0])
    varied = noted.turned / np.maximum(noted.counted, 1) / setting.period
    return {
        "caused": float(outcome.caused.any()),
        "touched": float(outcome.collided[0] or outcome.column("hit")[0, 0]),
        "deadlock": float(not arrived),
        "refused": 0.0,
        "time": min(ratio, scenario.limit) if arrived else scenario.limit,
        "spread_s": float(outcome.spread[0]) if arrived else np.nan,
        "gap": float(noted.gap[0]),
        "restlessness": float(varied.mean()),
        "clearance_m": float(outcome.clearance[0]),
        "emergency": float(outcome.overridden[0] / max(outcome.driven[0], setting.period)),
    }


def _stayed(scenario: TaskScenario) -> Mapping[str, float]:
    unknown = ("caused", "touched", "spread_s", "gap", "restlessness", "clearance_m", "emergency")
    return {"deadlock": 1.0, "refused": 1.0, "time": scenario.limit, **dict.fromkeys(unknown, np.nan)}
