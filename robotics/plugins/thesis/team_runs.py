"""The runs of the chapter on teams, thesis 3, 4, 5.3 and 5.4, and how coordination scales."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from functools import partial
from itertools import product
from typing import Any

import numpy as np

from robotics.laws.catalogue import make_controller
from robotics.measures.arrival import arrival_time, spread
from robotics.measures.progress import progress_gap, true_progress
from robotics.measures.quantities import measured
from robotics.measures.tracking import timetable_error
from robotics.plugins.thesis.claims import Needed, needed
from robotics.plugins.thesis.driving import driven, experiments_of
from robotics.plugins.thesis.experiment import Effort, Experiment
from robotics.plugins.thesis.lemma import LemmaCondition, judge_lemma
from robotics.plugins.thesis.recovery import Recovery, Scaling, outage_run, recovery_curve
from robotics.plugins.thesis.rows import TABLES
from robotics.plugins.thesis.theorems import theorem_number
from robotics.show.report.claims import run_name
from robotics.simulation.loop import simulate
from robotics.simulation.run import Run
from robotics.simulation.scenario.random_team import random_team
from robotics.simulation.scenario.reading import load_scenario
from robotics.world.radio.faults import Fault

# Scenario and controllers of every experiment; the first is the one that is drawn
EXPERIMENTS: dict[str, list[str]] = TABLES.table("experiments")
# Tables 5.7 and 5.8: the controllers, and whether each knows the reference's speed
DUELS: dict[str, str] = TABLES.table("duels")
TEAM_TESTS = ("unequal-lengths", "start-off-paths")
OUTAGES = (5.0, 10.0, 15.0, 20.0, 25.0)  # s: the lengths of the outages
RECOVERERS = ("virtual-structure-thesis", "virtual-structure-virtual", "virtual-structure")
DECIDED = {"outage of 15 s": 15.0, "outage of 20 s": 20.0}  # as claims call them
LEMMA = "lemma 4.1"
THEOREMS = ("theorem 3.1", "theorem 4.1", "5.3.2")  # what begins so is decided by robotics.plugins.thesis.theorems
HELD_UP = "ahead-and-behind, robot 1 held up"
_HELD = (Fault(robot=1, kind="stall", start=15.0, duration=5.0),)
SIZES, LOSSES = (10, 20, 40), (0.0, 0.3)
_FEW = 5  # seeds of what is shown beside, and decides nothing

Results = Mapping[Any, Any]


def experiments(folder: str, seed: int, effort: Effort) -> list[Experiment]:
    """The experiments of the chapter, with ``effort.seeds`` seeds from ``seed`` on; ``folder`` does not matter."""
    duels = [Needed(test, law, False) for test in TEAM_TESTS for law in DUELS]
    wanted, seeds = [*needed("teams"), *duels], effort.row(seed)
    shown = [Needed(scenario, law, False) for scenario, laws in EXPERIMENTS.items() for law in laws]
    decided = {(need.of, DECIDED[need.on]) for need in wanted if need.on in DECIDED}

    def many(law: str, outage: float) -> Sequence[int]:
        return effort.many(seed) if (law, outage) in decided else seeds[: 2 * _FEW]

    return [
        *experiments_of(wanted, seeds),
        *experiments_of([need for need in shown if need not in wanted], seeds[:_FEW]),
        *(
            Experiment(need, partial(_held_up, need, seeds), partial(_held_up_files, need, seeds))
            for need in wanted
            if need.on == HELD_UP
        ),
        Experiment((LEMMA,), judge_lemma),
        *(
            Experiment(
                ("recovery", *key),
                partial(_recovery, *key, many(*key)),
                partial(_recovery_files, *key, many(*key)) if key in decided else None,
            )
            for key in product(RECOVERERS, OUTAGES)
        ),
        *(Experiment(("scaling", n, loss), partial(_scaled, n, loss, seed)) for n in SIZES for loss in LOSSES),
    ]


def values(results: Results, need: Needed, quantity: str, robots: str) -> np.ndarray:
    """The numbers of a law's seeds that claims ask for, from the results of :func:`experiments`."""
    if need.on in DECIDED:
        return np.asarray(results["recovery", need.of, DECIDED[need.on]].recovered)
    if need.on.startswith(THEOREMS):
        return np.array([theorem_number(need.on, need.of)])
    if need.on == LEMMA:
        return np.array([_share_of_bound(results[LEMMA,], need.of.removeprefix("condition "))])
    found = results[need]
    return found if isinstance(found, np.ndarray) else measured(found, quantity, robots)


def _share_of_bound(conditions: Sequence[LemmaCondition], name: str) -> float:
    """The worst value of a condition over its printed constant; of a lower bound inversely. It must not exceed 1."""
    found = next(c for c in conditions if c.name == name)
    if name in ("1 lower", "3"):
        return found.printed / found.worst if found.worst > 0 else np.inf
    return found.worst / found.printed


def _held_up(need: Needed, seeds: Sequence[int]) -> np.ndarray:
    """The :func:`separation` [s] (seeds,) of the robots after robot 1 was held up."""
    return separation(_held_up_run(need, seeds), since=10.0)


def _held_up_run(need: Needed, seeds: Sequence[int]) -> Run:
    return driven(need, replace(load_scenario("ahead-and-behind"), faults=_HELD), need.of, seeds)


def _held_up_files(need: Needed, seeds: Sequence[int]) -> Iterator[tuple[str, Run]]:
    yield run_name(need.on, need.of), _held_up_run(need, seeds)


def _recovery(law: str, outage: float, seeds: Sequence[int]) -> Recovery:
    (found,) = recovery_curve([law], [outage], seeds, duration=_longest(law))
    return found


def _recovery_files(law: str, outage: float, seeds: Sequence[int]) -> Iterator[tuple[str, Run]]:
    (on,) = (on for on, length in DECIDED.items() if length == outage)
    yield run_name(on, law), outage_run(law, [outage], seeds, duration=_longest(law))[0]


def _longest(law: str) -> float | None:
    """How long its runs last [s], if not as the scenario says: to the timetable, unless its clock waits."""
    return None if law == "virtual-structure" else 70.0


def _scaled(robots: int, loss: float, seed: int) -> Scaling:
    team = random_team(robots, seed)
    setting = replace(team, radio=replace(team.radio, loss=loss))
    run = simulate(setting, make_controller(team.controller), [seed])
    arrivals, gap = arrival_time(run), float(np.nanmax(progress_gap(run)))
    late = float(arrivals.max() - setting.trajectory.ends.max())
    return Scaling(robots, loss, float(spread(arrivals)[0]), late, gap, float(run.time[1] - run.time[0]))


def separation(run: Run, since: float) -> np.ndarray:
    """The integral ∫ Σ |z_i − z_j| dt [s] (runs,) from ``since`` [s] on; z_i is where robot i truly is on its path."""
    z = true_progress(run)[..., run.time >= since]
    pairs = np.abs(z[:, :, None] - z[:, None])
    return np.asarray(np.nansum(pairs, axis=(1, 2, 3)) / 2 * (run.time[1] - run.time[0]))


def mean_errors(run: Run) -> np.ndarray:
    """The errors of thesis (5.17) against the scenario's timetable (runs, robots, 4).

    They are the means of |x_err|, |y_err| [m], |ψ_err| [rad], and of their norm, which the thesis calls "MSE", with 1
    rad counted as 1 m.
    """
    e = timetable_error(run)
    norm = np.sqrt(e.x**2 + e.y**2 + e.heading**2)
    return np.stack([np.nanmean(v, axis=-1) for v in (np.abs(e.x), np.abs(e.y), np.abs(e.heading), norm)], axis=-1)
