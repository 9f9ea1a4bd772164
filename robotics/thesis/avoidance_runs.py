"""The runs of the chapter on avoidance, thesis 6: each scenario under the thesis's rules and under better ones.

All scenarios of a law are driven in one array pass, a run each, which is several times quicker than one by one.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import partial
from typing import Any

from robotics.experiments.stress.crossing_runs import run_ensemble
from robotics.experiments.stress.crossings import crossing_ensemble
from robotics.experiments.stress.outcome import StressOutcome
from robotics.experiments.together import run_together
from robotics.laws.catalogue import make_controller
from robotics.scenario.description import Scenario
from robotics.scenario.reading import load_scenario
from robotics.simulation.run import Run
from robotics.thesis.experiment import Experiment

TESTS = ("two-meetings", "three-cross")  # tests 1 and 2 of 6.1.3
CRASH_LAWS = ("crash-literal", "crash-yielding", "right-of-way")
COURSES = ("obstacles-on-two-paths", "turn-into-neighbour", "trap-u", "obstacles-on-outer-paths")  # 6.3
CASES = ("wait-for-one", "neighbour-stops", "turn-towards-each-other", "trap-u-middle")  # the case studies of 6.2.3
OBSTACLE_LAWS = ("obstacles-literal", "obstacles")
CROSSERS = ("crash-literal", "right-of-way")
CROSSINGS = 24  # number of random crossings
FACTOR = 1.6  # times the nominal duration: a run in which not all have arrived by then counts as a deadlock


@dataclass(frozen=True, eq=False)
class AvoidanceResults:
    """The runs of the chapter on avoidance."""

    scenarios: dict[str, Scenario]  # by name
    runs: dict[tuple[str, str], Run]  # by scenario and controller
    crossings: dict[str, StressOutcome]  # by controller, the same random crossings for all


def experiments(folder: str = "", seed: int = 0) -> list[Experiment]:
    """The experiments of the chapter on avoidance, with ``seed``; ``folder`` does not matter."""
    return [
        *(Experiment(("meetings", law), partial(_meetings, law, seed)) for law in CRASH_LAWS),
        *(Experiment(("courses", law), partial(_courses, law, seed)) for law in OBSTACLE_LAWS),
        *(Experiment(("crossings", law), partial(_crossings, law, seed)) for law in CROSSERS),
    ]


def avoidance_results(found: Mapping[tuple[Any, ...], Any]) -> AvoidanceResults:
    """The results of :func:`experiments`, sorted by what they are."""
    runs = {(run.scenario, law): run for (what, law), passed in found.items() if what != "crossings" for run in passed}
    crossings = {law: outcome for (what, law), outcome in found.items() if what == "crossings"}
    return AvoidanceResults({name: load_scenario(name) for name in dict.fromkeys(n for n, _ in runs)}, runs, crossings)


def _meetings(law: str, seed: int) -> list[Run]:
    return run_together([load_scenario(name) for name in TESTS], law, seed)


def _courses(law: str, seed: int) -> list[Run]:
    """All courses, and the case studies that this law is for."""
    cases = [scenario for scenario in map(load_scenario, CASES) if scenario.controller == law]
    return run_together([*map(load_scenario, COURSES), *cases], law, seed)


def _crossings(law: str, seed: int) -> StressOutcome:
    seeds = range(seed, seed + CROSSINGS)
    return run_ensemble(crossing_ensemble(3, seeds, "A", factor=FACTOR), make_controller(law), seeds)
