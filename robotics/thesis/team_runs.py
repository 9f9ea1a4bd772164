"""The runs of the chapter on teams, thesis 3, 4, 5.3 and 5.4, and how coordination scales."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

import numpy as np

from robotics.experiments.recovery import Recovery, recovery_curve
from robotics.experiments.scaling import Scaling
from robotics.laws.catalogue import make_controller
from robotics.measures.arrival import arrival_time, spread
from robotics.measures.progress import progress_gap, true_progress
from robotics.measures.tracking import cross_track_error, settling_time, tracking_error
from robotics.radio.faults import Fault
from robotics.scenario.random_team import random_team
from robotics.scenario.reading import load_scenario
from robotics.simulation.loop import simulate
from robotics.simulation.run import Run
from robotics.thesis.experiment import Experiment

# Scenario and controllers of every experiment; the first is the one that is drawn
EXPERIMENTS: dict[str, tuple[str, ...]] = {
    "ahead-and-behind": ("graph-esm", "graph-esm:realisation=torque", "graph-esm-thesis", "graph-esm-literal"),
    "concentric-circles": ("virtual-structure-measured", "virtual-structure-virtual", "virtual-structure-thesis"),
    "crossing-in-turn": ("virtual-structure-measured", "virtual-structure-virtual", "virtual-structure-thesis"),
    "noisy-position": ("virtual-structure-virtual", "virtual-structure-thesis"),
    "outage-10s": (
        "virtual-structure-virtual",
        "virtual-structure-thesis",
        "virtual-structure-measured",
        "virtual-structure",
        "virtual-structure:catch_up=1.5",
        "cooperation",
    ),
    "outage-20s": ("virtual-structure-thesis", "virtual-structure-virtual", "virtual-structure"),
    "unequal-lengths": ("cooperation", "cooperation-literal"),
    "start-off-paths": ("cooperation", "cooperation-literal"),
}
# Tables 5.7 and 5.8: the controllers, and whether each knows the reference's speed
DUELS: dict[str, str] = {
    "virtual-structure-thesis:feed_forward=none": "nonlinear, K 1, 1, 1, without feed-forward",
    "virtual-structure-thesis": "nonlinear, K 1, 1, 1, with feed-forward",
    "virtual-structure-virtual:feed_forward=none": "nonlinear, K 1, 10, 5, without feed-forward",
    "virtual-structure-virtual": "nonlinear, K 1, 10, 5, with feed-forward",
    "cooperation:look_ahead=0.05": "fuzzy, target the next sample",
    "cooperation": "fuzzy, target 0.4 s ahead",
}
TESTS = ("unequal-lengths", "start-off-paths")
OUTAGES = (5.0, 10.0, 15.0, 20.0, 25.0)  # s: the lengths of the outages
RECOVERERS = ("virtual-structure-thesis", "virtual-structure-virtual", "virtual-structure")
RECOVERY_SEEDS = 20
SIZES, LOSSES = (10, 50, 200), (0.0, 0.3)
HELD = (Fault(robot=1, kind="stall", start=15.0, duration=5.0),)  # chapter 3: robot 1 is held up
COUPLINGS = ("graph-esm:coupling=0", "graph-esm-thesis", "graph-esm")


@dataclass(frozen=True, eq=False)
class TeamResults:
    """The runs of the chapter on teams."""

    runs: dict[tuple[str, str], Run]  # by scenario and controller
    recoveries: list[Recovery]
    scaling: list[Scaling]
    apart: dict[str, float]  # s: ∫ Σ |z_i − z_j| dt after robot 1 is held up, by controller


def experiments(folder: str = "", seed: int = 0) -> list[Experiment]:
    """The experiments of the chapter on teams, with ``seed``; ``folder`` does not matter."""
    driven = [(scenario, law) for scenario, laws in EXPERIMENTS.items() for law in laws]
    driven += [(scenario, law) for scenario in TESTS for law in DUELS if (scenario, law) not in driven]
    seeds = range(seed, seed + RECOVERY_SEEDS)
    return [
        *(Experiment(("driven", *pair), partial(_driven, *pair, seed)) for pair in driven),
        *(Experiment(("held up", law), partial(_held_up, law, seed)) for law in COUPLINGS),
        *(Experiment(("recovery", law), partial(recovery_curve, [law], OUTAGES, seeds)) for law in RECOVERERS),
        *(Experiment(("scaling", n, loss), partial(_scaled, n, loss, seed)) for n in SIZES for loss in LOSSES),
    ]


def team_results(found: Mapping[tuple[Any, ...], Any]) -> TeamResults:
    """The results of :func:`experiments`, sorted by what they are."""

    def of(what: str) -> dict[tuple[Any, ...], Any]:
        return {key[1:]: value for key, value in found.items() if key[0] == what}

    return TeamResults(
        {(scenario, law): run for (scenario, law), run in of("driven").items()},
        [curve for curves in of("recovery").values() for curve in curves],
        list(of("scaling").values()),
        {law: apart for (law,), apart in of("held up").items()},
    )


def _driven(scenario: str, law: str, seed: int) -> Run:
    return simulate(load_scenario(scenario), make_controller(law), [seed], name=law, links=True)


def _held_up(law: str, seed: int) -> float:
    """The :func:`separation` [s] of the robots after robot 1 is held up."""
    held = replace(load_scenario("ahead-and-behind"), faults=HELD)
    return separation(simulate(held, make_controller(law), [seed], name=law), since=10.0)


def _scaled(robots: int, loss: float, seed: int) -> Scaling:
    team = random_team(robots, seed)
    setting = replace(team, radio=replace(team.radio, loss=loss))
    run = simulate(setting, make_controller(team.controller), [seed])
    arrivals, gap = arrival_time(run), float(np.nanmax(progress_gap(run)))
    late = float(arrivals.max() - setting.trajectory.ends.max())
    return Scaling(robots, loss, float(spread(arrivals)[0]), late, gap)


def separation(run: Run, since: float) -> float:
    """The integral ∫ Σ |z_i − z_j| dt [s] from ``since`` [s] on; z_i is where robot i truly is on its path."""
    z = true_progress(run)[0][:, run.time >= since]
    pairs = np.abs(z[:, None] - z[None])
    return float(np.nansum(pairs) / 2 * (run.time[1] - run.time[0]))


def mean_errors(run: Run) -> np.ndarray:
    """The errors of thesis (5.17) (robots, 4): means of |x_err|, |y_err| [m], |ψ_err| [rad], and of their norm.

    The thesis calls the last "MSE"; it is a mean error norm, with 1 rad counted as 1 m.
    """
    e = tracking_error(run)
    norm = np.sqrt(e.x**2 + e.y**2 + e.heading**2)
    means = [np.nanmean(v[0], axis=-1) for v in (np.abs(e.x), np.abs(e.y), np.abs(e.heading), norm)]
    return np.stack(means, axis=1)


def path_reached(run: Run) -> np.ndarray:
    """The time [s] (robots,) from which each robot stays within 5 cm of its path; infinite if it never does."""
    return np.asarray(settling_time(run, cross_track_error(run))[0])
