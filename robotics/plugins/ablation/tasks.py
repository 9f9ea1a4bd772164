"""What a law does while parts of it are missing: random crossings and courses of teams, and scenarios by name."""

from collections.abc import Callable, Mapping, Sequence
from functools import partial
from typing import Any, NamedTuple

import numpy as np

from fuzzy.naming import check_known
from robotics.laws.catalogue import preset_of
from robotics.laws.law import Law
from robotics.measures.quantities import measured
from robotics.plugins.ablation.variants import AblationError
from robotics.plugins.stress.crossings import stress_crossing
from robotics.plugins.stress.obstaclecourse import stress_obstacles
from robotics.plugins.stress.outcome import StressOutcome
from robotics.simulation.loop import simulate
from robotics.simulation.scenario.reading import load_scenario, scenario_names

# What is measured of every run, with its unit; more is worse
MEASURED = {
    "contacts": "share of runs",
    "deadlocks": "share of runs",
    "time": "times the nominal duration",
    "spread": "s",
    "gap": "share of the path",
    "distance": "m",
    "settling": "s",
    "unsettled": "share of runs",
    "restlessness": "rad/s²",
    "unreached": "share of runs",
    "time to the goal": "s",
    "final error": "m",
}
_ROBOTS = 3
_TRACKING = ("fuzzy-on-path", "fuzzy-off-path", "lyapunov-sine", "lyapunov-circle")
_USUAL = {"team": ("no-slack",), "goal": ("parking", "come-in", "moving-goal")}  # scenarios, by the law's kind
Numbers = Mapping[str, np.ndarray]  # of MEASURED: (runs,), infinite or not-a-number where there is none


class AblationTask(NamedTuple):
    """Runs that a law drives, and what is measured of them."""

    name: str
    runs: int
    measure: Callable[[Law[Any], Sequence[int]], Numbers]


def tasks_of(law: str, crossings: int, courses: int, seeds: int, on: Sequence[str] = ()) -> list[AblationTask]:
    """The tasks for a law.

    Args:
        law: Its specification, which tells of which kind it is.
        crossings: How many random crossings a law of teams drives.
        courses: Through how many random obstacle courses it does.
        seeds: With how many seeds each scenario is driven.
        on: The scenarios; by default those of its kind.
    """
    team = preset_of(law).kind == "team"
    found = []
    if team:
        found = [AblationTask("crossings", crossings, _crossings), AblationTask("courses", courses, _courses)]
    for name in on or _USUAL.get(preset_of(law).kind, _TRACKING):
        if not name.endswith(".toml"):
            check_known(name, scenario_names(), "scenario", AblationError)
        found.append(AblationTask(name, seeds, partial(_scenario, name)))
    return [task for task in found if task.runs]


def _crossings(law: Law[Any], seeds: Sequence[int]) -> Numbers:
    return _of_stress(found := stress_crossing(law, _ROBOTS, seeds), found.collided)


def _courses(law: Law[Any], seeds: Sequence[int]) -> Numbers:
    found = stress_obstacles(law, seeds, robots=_ROBOTS, lanes="crossing")
    return _of_stress(found, found.collided | found.hit)


def _of_stress(found: StressOutcome, touched: np.ndarray) -> Numbers:
    time = found.arrivals.max(axis=1) / found.nominal
    return {
        "contacts": touched.astype(float),
        "deadlocks": found.deadlocked.astype(float),
        "time": time,
        "spread": found.spread,
    }


def _scenario(name: str, law: Law[Any], seeds: Sequence[int]) -> Numbers:
    scenario = load_scenario(name)
    run = simulate(scenario, law, seeds)
    touched = ~measured(run, "untouched").astype(bool)
    if scenario.kind == "goal":
        time = measured(run, "goal_time_s")
        return {
            "contacts": touched.astype(float),
            "unreached": np.isinf(time).astype(float),
            "time to the goal": time,
            "final error": measured(run, "goal_error_m"),
        }
    if scenario.kind != "team":
        settling = measured(run, "settling_time_s")
        return {
            "contacts": touched.astype(float),
            "unsettled": np.isinf(settling).astype(float),
            "distance": measured(run, "rms_distance_late_m"),
            "settling": settling,
            "restlessness": measured(run, "w_variation_late_radps2"),
        }
    arrival = measured(run, "arrival_time_s")
    return {
        "contacts": touched.astype(float),
        "deadlocks": np.isinf(arrival).astype(float),
        "time": arrival / float(np.max(scenario.trajectory.ends)),
        "spread": measured(run, "arrival_spread_s"),
        "gap": measured(run, "max_progress_gap"),
    }
