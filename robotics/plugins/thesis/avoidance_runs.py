"""The runs of the chapter on avoidance, thesis 6: each scenario under the thesis's rules and under better ones.

All scenarios of a law are driven in one array pass, a run each, which is several times quicker than one by one.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np

from robotics.laws.catalogue import make_controller
from robotics.measures.quantities import measured
from robotics.plugins.stress.crossings import crossing_ensemble
from robotics.plugins.stress.outcome import StressOutcome
from robotics.plugins.stress.tally import run_ensemble
from robotics.plugins.thesis.claims import Needed, needed
from robotics.plugins.thesis.experiment import Effort, Experiment
from robotics.show.report.claims import run_name
from robotics.simulation.loop import record_run
from robotics.simulation.run import Run
from robotics.simulation.scenario.reading import load_scenario
from robotics.studies.together import run_together

AVOIDANCE_TESTS = ("two-meetings", "three-cross")  # tests 1 and 2 of 6.1.3
CRASH_LAWS = ("crash-literal", "crash-yielding", "right-of-way")
COURSES = ("obstacles-on-two-paths", "turn-into-neighbour", "trap-u", "obstacles-on-outer-paths")  # 6.3
CASES = ("wait-for-one", "neighbour-stops", "turn-towards-each-other", "trap-u-middle")  # the case studies of 6.2.3
OBSTACLE_LAWS = ("obstacles-literal", "obstacles")
JOINED = "fuzzy-team"  # one law for robots and obstacles, Fig 6.26
# Side by side in a table of their own: the printed rules in one law, one law for robots and obstacles, and a plan
SIDE_BY_SIDE = ("hierarchy-literal", JOINED, "right-of-way")
LATEST = 1.6  # times the nominal duration: side by side, who arrives later has not arrived
FACTOR = 1.6  # times the nominal duration: a run in which not all have arrived by then counts as a deadlock


_FEW = 5  # seeds of what is shown beside, and decides nothing
_LONGEST = 100.0  # s: robots that leave a trap, or wait for one that does not, need more than their nominal 32 s
RANDOM_CROSSINGS, ALL_COURSES = "random crossings", "all courses"  # as claims call them

Results = Mapping[Any, Any]


def experiments(folder: str, seed: int, effort: Effort) -> list[Experiment]:
    """The experiments of the chapter, with ``effort.seeds`` seeds from ``seed`` on; ``folder`` does not matter."""
    seeds, many = effort.row(seed), effort.many(seed)
    judged = {need.of for need in needed("avoidance") if need.on == RANDOM_CROSSINGS}
    beside = [law for law in SIDE_BY_SIDE if law not in CRASH_LAWS]
    looks = {law: make_controller(law).looks for law in SIDE_BY_SIDE if law not in OBSTACLE_LAWS}
    shared = range(seed, seed + -(-effort.trials // len(COURSES)))  # contacts on all courses together are a rate
    return [
        *(Experiment(("meetings", law), partial(_together, AVOIDANCE_TESTS, law, seeds)) for law in CRASH_LAWS),
        *(Experiment(("meetings", law), partial(_in_time, AVOIDANCE_TESTS, law, seeds)) for law in beside),
        *(Experiment(("courses", law), partial(_together, COURSES, law, shared, _LONGEST)) for law in OBSTACLE_LAWS),
        *(
            Experiment(("courses", law), partial(_in_time, COURSES, law, seeds if sees else seeds[:_FEW]))
            for law, sees in looks.items()  # those that drive blind are only shown beside
        ),
        *(Experiment(("cases", law), partial(_cases, law, seeds[:_FEW])) for law in OBSTACLE_LAWS),
        *(
            Experiment(
                (RANDOM_CROSSINGS, law),
                partial(_crossings, law, many),
                partial(_crossing_files, law, many) if law in judged else None,
            )
            for law in (*CRASH_LAWS, JOINED)
        ),
    ]


def runs_of(results: Results) -> dict[tuple[str, str], Run]:
    """The runs of every scenario and law, from the results of :func:`experiments`."""
    passes = [found for key, found in results.items() if key[0] in ("meetings", "courses", "cases")]
    return {(run.scenario, run.controller): run for found in passes for run in found}


def values(results: Results, need: Needed, quantity: str, robots: str) -> np.ndarray:
    """The numbers of a law's seeds that claims ask for, from the results of :func:`experiments`."""
    if need.on == RANDOM_CROSSINGS:
        outcome: StressOutcome = results[RANDOM_CROSSINGS, need.of]
        return ~outcome.collided if quantity == "untouched" else outcome.arrived & ~outcome.collided
    if need.on == ALL_COURSES:
        return np.concatenate([measured(run, quantity, robots) for run in results["courses", need.of]])
    return measured(runs_of(results)[need.on, need.of], quantity, robots)


def nominal_time(scenario: str) -> float:
    """The time [s] at which the last robot of the package's ``scenario`` is due at its end."""
    return float(load_scenario(scenario).trajectory.ends.max())


def _together(scenarios: Sequence[str], law: str, seeds: Sequence[int], *longest: float) -> list[Run]:
    return run_together([load_scenario(name) for name in scenarios], law, seeds, *longest)


def _in_time(scenarios: Sequence[str], law: str, seeds: Sequence[int]) -> list[Run]:
    """The scenarios of a table side by side, until it is too late to arrive."""
    return _together(scenarios, law, seeds, LATEST * max(map(nominal_time, scenarios)))


def _cases(law: str, seeds: Sequence[int]) -> list[Run]:
    """The case studies that this law is for."""
    cases = [scenario for scenario in map(load_scenario, CASES) if scenario.controller == law]
    return run_together(cases, law, seeds, _LONGEST) if cases else []


def _crossings(law: str, seeds: Sequence[int]) -> StressOutcome:
    ensemble = crossing_ensemble(3, seeds, "A", factor=FACTOR)
    table = run_ensemble(StressOutcome, ensemble, make_controller(law), seeds).table
    late = table["arrival_s"] > FACTOR * table["nominal_s"]  # the ensemble goes on until the longest run is late
    return StressOutcome(table.assign(arrival_s=table["arrival_s"].mask(late, np.inf)))


def _crossing_files(law: str, seeds: Sequence[int]) -> Iterator[tuple[str, Run]]:
    """Each crossing by itself: their runs have paths of their own."""
    for seed in seeds:
        setting = crossing_ensemble(3, [seed], "A", factor=FACTOR)
        longest = int(FACTOR * float(setting.references.ends.max()) / setting.period)
        setting = replace(setting, ticks=min(longest, setting.ticks))
        yield run_name(f"{RANDOM_CROSSINGS} {seed}", law), record_run(setting, make_controller(law), [seed], name=law)
