"""What teachers and pupils drive: scenarios, and the random scenarios of stress tests, each for any seeds."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from robotics.laws.law import Law
from robotics.laws.setting import Setting
from robotics.measures.contacts import can_touch
from robotics.measures.registry import headlines, measure_all
from robotics.plugins.stress.crossings import crossing_ensemble
from robotics.plugins.stress.obstaclecourse import ObstacleOutcome, obstacle_ensemble
from robotics.plugins.stress.outcome import StressOutcome
from robotics.plugins.stress.tally import run_ensemble
from robotics.simulation.loop import simulate
from robotics.simulation.scenario.description import Scenario

Judge = Callable[[Law[Any], str, Sequence[int]], dict[str, float]]


@dataclass(frozen=True)
class ImitationTask:
    """What is driven."""

    name: str
    setting: Callable[[Sequence[int]], Setting]  # for these seeds
    # The outcome of a law, which has a name, on these seeds: numbers by what they are, with their unit
    judged: Judge


def scenario_course(scenario: Scenario) -> ImitationTask:
    """A scenario, judged by what a comparison's short table shows: means over seeds and robots."""

    def judged(law: Law[Any], name: str, seeds: Sequence[int]) -> dict[str, float]:
        run = simulate(scenario, law, seeds, name=name)
        values = measure_all(run)
        found: dict[str, float] = {"robots stopped": float(run.diverged.sum())}
        if can_touch(run):
            found["runs with a contact"] = float((values["contacts"] > 0).any(axis=1).sum())
        for metric, about in headlines(scenario.kind, can_touch(run)).items():
            found[f"{about.short or about.title} [{about.unit}]"] = float(np.mean(values[metric]))
        return found

    return ImitationTask(scenario.name, lambda seeds: scenario.setting, judged)


def crossing_course(robots: int = 3) -> ImitationTask:
    """Random crossings of class A, one for each seed, judged as by ``robotics stress crossing``."""

    name = f"{robots} robots on random crossings"
    return _stress_course(name, StressOutcome, lambda seeds: crossing_ensemble(robots, seeds))


def obstacle_course(robots: int = 1) -> ImitationTask:
    """Random obstacle courses of class A, one for each seed, judged as by ``robotics stress obstacles``."""

    name = f"{robots} robots among random obstacles"
    return _stress_course(name, ObstacleOutcome, lambda seeds: obstacle_ensemble(seeds, "A", robots))


def _stress_course(
    title: str, kind: type[StressOutcome], ensemble: Callable[[Sequence[int]], Setting]
) -> ImitationTask:
    def judged(law: Law[Any], name: str, seeds: Sequence[int]) -> dict[str, float]:
        found = run_ensemble(kind, ensemble(seeds), law, seeds).summary()
        return {what: np.nan if value is None else value for what, value in found.items() if what != "failed_seeds"}

    return ImitationTask(title, ensemble, judged)
