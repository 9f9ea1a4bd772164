"""Three kinds of avoidance side by side: printed rules for robots and obstacles, one law for both, and a plan."""

from collections.abc import Mapping
from functools import partial

import numpy as np

from robotics.laws.catalogue import label, make_controller
from robotics.measures.arrival import ARRIVAL_SPREAD
from robotics.measures.evidence import mean_of, rate_of
from robotics.measures.quantities import measured
from robotics.plugins.thesis.avoidance_runs import AVOIDANCE_TESTS, COURSES, LATEST, SIDE_BY_SIDE, nominal_time
from robotics.plugins.thesis.rows import TEXTS
from robotics.show.figures.avoidance import plot_trajectories
from robotics.show.report.chapter import Grid, Picture
from robotics.show.report.wording import shown
from robotics.simulation.run import Run
from robotics.simulation.scenario.reading import load_scenario


def side_by_side_table(runs: Mapping[tuple[str, str], Run]) -> Grid:
    """The table of SIDE_BY_SIDE on AVOIDANCE_TESTS and COURSES, from the runs by scenario and law."""
    seeds = len(runs[AVOIDANCE_TESTS[0], SIDE_BY_SIDE[0]].seeds)  # of a course there may be more
    rows = [_row(runs[scenario, law], seeds) for scenario in (*AVOIDANCE_TESTS, *COURSES) for law in SIDE_BY_SIDE]
    return TEXTS.grid("avoidance.side-by-side", rows, spread=ARRIVAL_SPREAD, latest=LATEST)


def side_by_side_picture(runs: Mapping[tuple[str, str], Run]) -> Picture:
    """The trajectories of SIDE_BY_SIDE on the two tests, a row each."""
    return TEXTS.picture(
        "avoidance-side-by-side",
        partial(plot_trajectories, [[runs[test, law] for law in SIDE_BY_SIDE] for test in AVOIDANCE_TESTS]),
        titles="; ".join(load_scenario(test).title for test in AVOIDANCE_TESTS),
        tests=" and ".join(AVOIDANCE_TESTS),
        laws=", ".join(map(label, SIDE_BY_SIDE)),
    )


def _row(run: Run, seeds: int) -> tuple[str, ...]:
    def of(quantity: str, robots: str = "worst") -> np.ndarray:
        return measured(run, quantity, robots)[:seeds]

    touched = of("contacts") > 0
    count = f"{touched.sum()} of {len(touched)}"
    clearance = shown(mean_of(of("min_clearance_m")), "m")
    guarded = _mean(of("emergency_share", "mean"), "1")
    if run.obstacles is not None and not make_controller(run.controller).looks:
        return (run.scenario, f"{label(run.controller)}: drives blind", count, "–", "–", "–", clearance, guarded)
    late, apart = of("arrival_time_s") / nominal_time(run.scenario), of("arrival_spread_s")
    arrived = ~touched & (late <= LATEST)
    good = shown(rate_of(arrived & (apart <= ARRIVAL_SPREAD)), "1")
    means = _mean(apart[arrived], "s"), _mean(late[arrived], "1")
    return (run.scenario, label(run.controller), count, good, *means, clearance, guarded)


def _mean(values: np.ndarray, unit: str) -> str:
    """The mean with its interval; a dash where there is nothing to take it of."""
    known = values[~np.isnan(values)]
    return shown(mean_of(known), unit) if len(known) else "–"
