"""The thesis's experiments on avoidance, run: chapter 6, each scenario under the thesis's rules and under better ones.

All scenarios of a law are driven in one array pass, a run each, which is several times quicker than one by one.
"""

from collections.abc import Callable
from dataclasses import dataclass

from robotics.experiments.stress.crossing_runs import run_ensemble
from robotics.experiments.stress.crossings import crossing_ensemble
from robotics.experiments.stress.outcome import Outcome
from robotics.experiments.together import run_together
from robotics.laws.catalogue import make_controller
from robotics.scenario.description import Scenario
from robotics.scenario.reading import load_scenario, scenario_names
from robotics.simulation.run import Run

TESTS = ("chapter-6-test-1", "chapter-6-test-2")
CRASH_LAWS = ("crash-literal", "crash-yielding", "right-of-way")
COURSES = ("chapter-6-simulation-1", "chapter-6-simulation-2", "chapter-6-simulation-3", "chapter-6-experiment")
OBSTACLE_LAWS = ("obstacles-literal", "obstacles")
CROSSERS = ("crash-literal", "right-of-way")
CROSSINGS = 24  # random ones
FACTOR = 1.6  # times the nominal duration: who has not arrived by then counts as waiting for ever

# How many times run_avoidance_experiments calls ``advance``
STEPS = len(CRASH_LAWS) + len(OBSTACLE_LAWS) + len(CROSSERS)


@dataclass(frozen=True, eq=False)
class AvoidanceResults:
    """Everything that was run."""

    scenarios: dict[str, Scenario]  # by name
    runs: dict[tuple[str, str], Run]  # by scenario and controller
    crossings: dict[str, Outcome]  # by controller, the same random crossings for all


def case_studies() -> list[str]:
    """The scenarios of thesis 6.2.3 that come with the package."""
    return [name for name in scenario_names("team") if name.startswith("chapter-6-case-")]


def run_avoidance_experiments(seed: int = 0, advance: Callable[[], None] | None = None) -> AvoidanceResults:
    """Run them all with ``seed``; ``advance`` is called after every pass, STEPS times."""
    step = advance or (lambda: None)
    cases = case_studies()
    scenarios = {name: load_scenario(name) for name in (*TESTS, *COURSES, *cases)}
    runs: dict[tuple[str, str], Run] = {}
    for law in CRASH_LAWS:
        runs |= {(run.scenario, law): run for run in run_together([scenarios[n] for n in TESTS], law, seed)}
        step()
    for law in OBSTACLE_LAWS:
        settings = [scenarios[name] for name in (*COURSES, *(c for c in cases if scenarios[c].controller == law))]
        runs |= {(run.scenario, law): run for run in run_together(settings, law, seed)}
        step()
    seeds = range(seed, seed + CROSSINGS)
    ensemble = crossing_ensemble(3, seeds, "A", factor=FACTOR)
    crossings = {}
    for law in CROSSERS:
        crossings[law] = run_ensemble(ensemble, make_controller(law), seeds)
        step()
    return AvoidanceResults(scenarios, runs, crossings)
