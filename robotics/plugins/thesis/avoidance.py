"""The report's chapter on avoidance: robots that would meet, and obstacles that are not known before; thesis 6."""

from collections.abc import Iterator, Sequence
from functools import partial
from itertools import product
from typing import Any

import numpy as np

from fuzzy.figures.drawing import PAGE_WIDTH
from robotics.laws.catalogue import label, make_controller
from robotics.measures.arrival import ARRIVAL_SPREAD, together
from robotics.measures.evidence import mean_of, rate_of
from robotics.measures.leading import Lead, lead
from robotics.measures.quantities import measured, runs_touched
from robotics.plugins.encounters.avoidance import (
    CRASH_ROWS,
    HOW,
    OBSTACLE_ROWS,
    WHERE,
    plot_avoidance,
    plot_trajectories,
)
from robotics.plugins.encounters.meetings import plot_meetings
from robotics.plugins.stress.outcome import StressOutcome
from robotics.plugins.thesis import avoidance_runs
from robotics.plugins.thesis.avoidance_runs import (
    AVOIDANCE_TESTS,
    CASES,
    COURSES,
    CRASH_LAWS,
    JOINED,
    LATEST,
    OBSTACLE_LAWS,
    SIDE_BY_SIDE,
    Results,
    nominal_time,
)
from robotics.plugins.thesis.claims import judged
from robotics.plugins.thesis.figures import plot_turn
from robotics.plugins.thesis.rows import TEXTS, film_of, run_columns
from robotics.plugins.thesis.states import plot_states
from robotics.show.report.chapter import Chapter, Grid, Picture
from robotics.show.report.wording import shown
from robotics.simulation.run import Run
from robotics.simulation.scenario.reading import load_scenario

Runs = dict[tuple[str, str], Run]  # by scenario and law

_MEETING, _AMONG_OBSTACLES = (*CRASH_LAWS, JOINED), (*OBSTACLE_LAWS, JOINED)
_SEEN = ("trajectories", "cross-track", "v", "sonar")


def _figures(first: int, *rows: str) -> dict[str, str]:
    """The thesis's figures of rows, one after the other."""
    return {row: f"Fig 6.{number}" for number, row in enumerate(rows, first)}


def _test_figures(first: int) -> dict[str, str]:
    """The same of a test, which has two figures of its trajectories, and one of both errors and of both speeds."""
    errors, speeds = f"Fig 6.{first + 3}", f"Fig 6.{first + 4}"
    found = {"trajectories": f"Figs 6.{first}, 6.{first + 1}", "distances": f"Fig 6.{first + 2}"}
    return found | {"cross-track": errors, "heading": errors, "v": speeds, "w": speeds}


# By scenario: the laws that are drawn, and the thesis's figure of each row
CHAPTER_FIGURES: dict[str, tuple[tuple[str, ...], dict[str, str]]] = {
    "two-meetings": (("crash-literal", JOINED, "right-of-way"), _test_figures(9)),
    "three-cross": (("crash-literal", JOINED, "right-of-way"), _test_figures(14)),
    "obstacles-on-two-paths": (_AMONG_OBSTACLES, _figures(28, *_SEEN)),
    "turn-into-neighbour": (_AMONG_OBSTACLES, _figures(32, *_SEEN)),
    "trap-u": (_AMONG_OBSTACLES, _figures(36, *_SEEN)),
    "obstacles-on-outer-paths": (_AMONG_OBSTACLES, _figures(40, "trajectories", "cross-track", "v", "w")),
}


def chapter_of(results: Results) -> Chapter:
    """Write the chapter from the results of its experiments."""
    runs = avoidance_runs.runs_of(results)
    return TEXTS.chapter(
        "avoidance",
        tables=[_tests(runs), _crossings(results), _courses(runs), side_by_side_table(runs)],
        pictures=_pictures(runs),
        claims=judged("avoidance", partial(avoidance_runs.values, results)),
        films=[film_of(runs[key], *key, "avoidance") for key in _played(runs)],
        leads=[
            *(_lead(runs, test, _MEETING) for test in AVOIDANCE_TESTS),
            *(_lead(runs, c, _AMONG_OBSTACLES) for c in COURSES),
        ],
    )


def _lead(runs: Runs, scenario: str, laws: Sequence[str]) -> Lead:
    """Who arrives first, by the seeds with which all ``laws`` were driven."""
    seeds = min(len(runs[scenario, law].seeds) for law in laws)
    arrivals = {law: measured(runs[scenario, law], "arrival_time_s")[:seeds] for law in laws}
    touched = {law: int((measured(runs[scenario, law], "contacts")[:seeds] > 0).sum()) for law in laws}
    return lead(scenario, "last arrival", "s", arrivals, touched)


def _played(runs: Runs) -> list[tuple[str, str]]:
    """The runs to play: test 2 under the thesis's rules, and the case studies, each under its own law."""
    cases = [key for key in runs if key[0] in CASES]
    return [(AVOIDANCE_TESTS[1], CRASH_LAWS[0]), *sorted(cases, key=lambda key: CASES.index(key[0]))]


# Tables -----------------------------------------------------------------------------------------------------------


def _tests(runs: Runs) -> Grid:
    return Grid.of(
        TEXTS.text("avoidance.tests.caption"),
        [runs[key] for key in product(AVOIDANCE_TESTS, _MEETING)],
        run_columns("test", _TOUCHED, min_distance_m="least distance of centers", **_ARRIVING)
        | {"stood": lambda run: ", ".join(shown(mean_of(measured(run, "stood_s", str(i))), "s") for i in (1, 2, 3))},
    )


# Quantities that the tables show, and what they call them
_ARRIVING = {"arrival_time_s": "last arrival", "arrival_spread_s": "spread of arrivals"}
_ARRIVING["max_cross_track_m"] = "largest distance from the path"
_TOUCHED = {"runs with contact": lambda run: f"{runs_touched(run)} of {len(run.seeds)}"}


def _crossings(results: Results) -> Grid:
    rows = []
    for law in _MEETING:
        outcome: StressOutcome = results[avoidance_runs.RANDOM_CROSSINGS, law]
        figures = outcome.summary()
        ratio = figures["time_ratio_median"]
        good = outcome.arrived & ~outcome.collided & together(outcome.arrivals)
        rates = [rate_of(which) for which in (outcome.collided, outcome.deadlocked, outcome.refused, good)]
        nearest = f"{figures['min_distance_m']:.2f}"
        rows.append((label(law), *(shown(r, "1") for r in rates), nearest, "–" if ratio is None else f"{ratio:.2f}"))
    within = {"factor": avoidance_runs.FACTOR, "spread": ARRIVAL_SPREAD}
    return TEXTS.grid("avoidance.crossings", rows, runs=figures["runs"], **within)


def _courses(runs: Runs) -> Grid:
    order = (*COURSES, *CASES)
    shown_here = [key for key in runs if key[0] in order and key[1] in _AMONG_OBSTACLES]
    return Grid.of(
        TEXTS.text("avoidance.courses.caption"),
        [runs[key] for key in sorted(shown_here, key=lambda key: (order.index(key[0]), key[1]))],
        run_columns(
            "scenario", _TOUCHED, min_clearance_m="least clearance", **_ARRIVING, off_path_s="longest off the path"
        )
        | {"left behind": _left_behind},
    )


def _left_behind(run: Run) -> str:
    robots = [str(i) for i in range(1, len(run.paths) + 1)]
    return ", ".join(robot for robot in robots if measured(run, "left_behind_s", robot).any()) or "–"


def side_by_side_table(runs: Runs) -> Grid:
    """The table of SIDE_BY_SIDE on AVOIDANCE_TESTS and COURSES, from the runs by scenario and law."""
    seeds = len(runs[AVOIDANCE_TESTS[0], SIDE_BY_SIDE[0]].seeds)  # of a course there may be more
    rows = [_row(runs[scenario, law], seeds) for scenario in (*AVOIDANCE_TESTS, *COURSES) for law in SIDE_BY_SIDE]
    return TEXTS.grid("avoidance.side-by-side", rows, spread=ARRIVAL_SPREAD, latest=LATEST)


def _row(run: Run, seeds: int) -> tuple[str, ...]:
    def of(quantity: str, robots: str = "worst") -> np.ndarray:
        return measured(run, quantity, robots)[:seeds]

    touched = of("contacts") > 0
    count = f"{touched.sum()} of {len(touched)}"
    clearance = shown(mean_of(of("min_clearance_m")), "m")
    guarded = _mean(of("emergency_share", "mean"), "1")
    if run.obstacles is not None and not make_controller(run.controller).looks:
        return (run.scenario, f"{label(run.controller)}: drives blind", count, *"––––", clearance, guarded)
    late, apart = of("arrival_time_s") / nominal_time(run.scenario), of("arrival_spread_s")
    arrived = ~touched & (late <= LATEST)
    good = shown(rate_of(arrived & (apart <= ARRIVAL_SPREAD)), "1")
    means = _mean(apart[arrived], "s"), _mean(late[arrived], "1")
    away = ", ".join(shown(mean_of(of("max_cross_track_m", str(i + 1))), "m") for i in range(len(run.paths)))
    return (run.scenario, label(run.controller), count, good, *means, away, clearance, guarded)


def _mean(values: np.ndarray, unit: str) -> str:
    """The mean with its interval; a dash where there is nothing to take it of."""
    known = values[~np.isnan(values)]
    return shown(mean_of(known), unit) if len(known) else "–"


# Pictures ---------------------------------------------------------------------------------------------------------


def _pictures(runs: Runs) -> list[Picture]:
    plots = {
        "avoidance-eta": partial(plot_turn, "eta", PAGE_WIDTH),
        "avoidance-theta": partial(plot_turn, "theta", PAGE_WIDTH),
        "avoidance-states-crash": partial(plot_states, (CRASH_LAWS[0], CRASH_LAWS[-1])),
        "avoidance-states-obstacles": partial(plot_states, OBSTACLE_LAWS),
        "avoidance-states-joined": partial(plot_states, ("hierarchy-literal", JOINED)),
    }
    return [
        *(TEXTS.picture(name, plot) for name, plot in plots.items()),
        side_by_side_picture(runs),
        *(
            TEXTS.picture(
                f"avoidance-meetings-{test}",
                partial(plot_meetings, runs[test, CRASH_LAWS[0]]),
                key="avoidance-meetings",
                title=load_scenario(test).title,
                law=label(CRASH_LAWS[0]),
                figure=figure,
                test=test,
            )
            for test, figure in zip(AVOIDANCE_TESTS, ("Fig 6.10", "Fig 6.15"), strict=True)
        ),
        *_pages(runs),
    ]


def side_by_side_picture(runs: Runs) -> Picture:
    """The trajectories of SIDE_BY_SIDE on the two tests, a row each."""
    return TEXTS.picture(
        "avoidance-side-by-side",
        partial(plot_trajectories, [[runs[test, law] for law in SIDE_BY_SIDE] for test in AVOIDANCE_TESTS]),
        titles="; ".join(load_scenario(test).title for test in AVOIDANCE_TESTS),
        tests=" and ".join(AVOIDANCE_TESTS),
        laws=", ".join(map(label, SIDE_BY_SIDE)),
    )


def _pages(runs: Runs) -> Iterator[Picture]:
    """Two pages a scenario: where robots were, and how they drove."""
    for scenario, (laws, figures) in CHAPTER_FIGURES.items():
        crash, columns = scenario in AVOIDANCE_TESTS, [runs[scenario, law] for law in laws]
        about: dict[str, Any] = {
            "title": load_scenario(scenario).title,
            "scenario": scenario,
            "laws": ", ".join(map(label, laws)),
        }
        about["about"] = TEXTS.text(f"avoidance-where.{'crash' if crash else 'obstacles'}")
        shown = {row: f"thesis {figure}" for row, figure in figures.items()}
        for suffix, rows, key in (("", WHERE, "avoidance-where"), ("-speeds", HOW, "avoidance-speeds")):
            chosen = [row for row in (CRASH_ROWS if crash else OBSTACLE_ROWS) if row in rows]
            plot = partial(plot_avoidance, columns, figures=shown, rows=chosen, width=PAGE_WIDTH)
            yield TEXTS.picture(f"avoidance-{scenario}{suffix}", plot, key=key, **about)
