"""The report's chapter on avoidance: robots that would meet, and obstacles that are not known before; thesis 6."""

from functools import partial

import numpy as np

from robotics.figures.avoidance import plot_avoidance
from robotics.figures.laws import plot_crash_turn, plot_obstacle_turn
from robotics.figures.meetings import plot_meetings
from robotics.figures.states import plot_states
from robotics.laws.catalogue import label
from robotics.measures.arrival import ARRIVAL_SPREAD, together
from robotics.measures.avoidance import AvoidanceMetrics, avoidance_metrics
from robotics.playback.player import player_fragment
from robotics.report.chapter import Chapter, Claim, Film, Grid, Picture, Verdict
from robotics.thesis.avoidance_runs import (
    CASES,
    COURSES,
    CRASH_LAWS,
    CROSSERS,
    FACTOR,
    OBSTACLE_LAWS,
    TESTS,
    AvoidanceResults,
)

ARRIVE_WITHIN = 0.2 + 1e-9  # s: arrivals that count as together here, which is stricter than ARRIVAL_SPREAD
# By scenario: the laws that are drawn, and the thesis's figure of each row
FIGURES: dict[str, tuple[tuple[str, ...], dict[str, str]]] = {
    "two-meetings": (
        ("crash-literal", "right-of-way"),
        {
            "trajectories": "Figs 6.9, 6.10",
            "distances": "Fig 6.11",
            "cross-track": "Fig 6.12",
            "heading": "Fig 6.12",
            "v": "Fig 6.13",
            "w": "Fig 6.13",
        },
    ),
    "three-cross": (
        ("crash-literal", "crash-yielding", "right-of-way"),
        {
            "trajectories": "Figs 6.14, 6.15",
            "distances": "Fig 6.16",
            "cross-track": "Fig 6.17",
            "heading": "Fig 6.17",
            "v": "Fig 6.18",
            "w": "Fig 6.18",
        },
    ),
    "obstacles-on-two-paths": (
        OBSTACLE_LAWS,
        {"trajectories": "Fig 6.28", "cross-track": "Fig 6.29", "v": "Fig 6.30", "sonar": "Fig 6.31"},
    ),
    "turn-into-neighbour": (
        OBSTACLE_LAWS,
        {"trajectories": "Fig 6.32", "cross-track": "Fig 6.33", "v": "Fig 6.34", "sonar": "Fig 6.35"},
    ),
    "trap-u": (
        OBSTACLE_LAWS,
        {"trajectories": "Fig 6.36", "cross-track": "Fig 6.37", "v": "Fig 6.38", "sonar": "Fig 6.39"},
    ),
    "obstacles-on-outer-paths": (
        OBSTACLE_LAWS,
        {"trajectories": "Fig 6.40", "cross-track": "Fig 6.41", "v": "Fig 6.42", "w": "Fig 6.43"},
    ),
}


def chapter_of(results: AvoidanceResults) -> Chapter:
    """Write the chapter from the results of its experiments."""
    nominal = {name: float(scenario.trajectory.ends[0]) for name, scenario in results.scenarios.items()}
    found = {key: avoidance_metrics(run, nominal[key[0]]) for key, run in results.runs.items()}
    return Chapter(
        "avoidance",
        "Avoidance: other robots, and obstacles that nobody knows (thesis 6)",
        (
            "Three robots that shall arrive together would meet on their paths (6.1), or find obstacles on them (6.2, "
            "6.3). “Literal” laws follow the thesis's rules: who has the higher number stops, the other turns; a robot "
            "turns away from what its sonars see. Beside them stand right of way, a plan in which no two robots come "
            "near, and a robot that keeps to the side it chose and follows the wall where that leads nowhere.",
            "The thesis's figures and its membership functions are missing: lanes, obstacles and rule bases are "
            "choices, made once for all laws. Contact is judged by the robots' true rectangles, not by distances of "
            "centers. Under the literal rules robots chatter near each other and near obstacles: how close they come "
            "changes with the noise.",
        ),
        [_tests(results, found), _crossings(results), _courses(results, found)],
        [],
        _pictures(results),
        _claims(results, found),
        [_film(results, *key) for key in _played(results)],
    )


def _played(results: AvoidanceResults) -> list[tuple[str, str]]:
    """The runs to play: test 2 under the thesis's rules, and the case studies, each under its own law."""
    cases = [key for key in results.runs if key[0] in CASES]
    return [(TESTS[1], CRASH_LAWS[0]), *sorted(cases, key=lambda key: CASES.index(key[0]))]


def _film(results: AvoidanceResults, scenario: str, law: str) -> Film:
    run = results.runs[scenario, law]
    return Film(f"To play: {results.scenarios[scenario].title}; {label(law)}.", partial(player_fragment, run))


# Tables -----------------------------------------------------------------------------------------------------------


def _tests(results: AvoidanceResults, found: dict[tuple[str, str], AvoidanceMetrics]) -> Grid:
    rows = []
    for test in TESTS:
        for law in CRASH_LAWS:
            m = found[test, law]
            stood = ", ".join(f"{s:.1f}" for s in m.stood)
            touch = "yes" if m.collided else "no"
            rows.append((test, label(law), f"{m.nearest:.2f}", touch, *_arrival(m), stood, f"{m.off:.2f}"))
    return Grid(
        "Tests 1 and 2 of thesis 6.1.3. Time: the last arrival over the nominal duration. Stood: the longest stop of "
        "robots 1, 2, 3 on the way.",
        (
            "test",
            "controller",
            "least distance of centers [m]",
            "robots touch",
            "arrived",
            "spread of arrivals [s]",
            "time",
            "stood [s]",
            "largest distance from the path [m]",
        ),
        rows,
    )


def _crossings(results: AvoidanceResults) -> Grid:
    rows = []
    for law, outcome in results.crossings.items():
        figures = outcome.summary()
        ratio = figures["time_ratio_median"]
        counts = [figures[name] for name in ("collisions", "deadlocks", "refused", "arrived_together")]
        nearest = f"{figures['min_distance_m']:.2f}"
        shares = [_share(n, figures["runs"]) for n in counts]
        rows.append((label(law), *shares, nearest, "–" if ratio is None else f"{ratio:.2f}"))
    return Grid(
        f"The same {figures['runs']} random crossings of three robots each (robotics stress crossing). Deadlock: "
        f"not all arrived within {FACTOR:g} times the nominal duration; a run may do both. Together: without "
        f"contact, within {ARRIVAL_SPREAD:g} s.",
        (
            "controller",
            "robots touch",
            "deadlock",
            "refused before the start",
            "arrive together",
            "least distance of centers [m]",
            "median time",
        ),
        rows,
    )


def _courses(results: AvoidanceResults, found: dict[tuple[str, str], AvoidanceMetrics]) -> Grid:
    rows = []
    order = (*COURSES, *CASES)
    driven = [key for key in results.runs if key[0] in order]
    for scenario, law in sorted(driven, key=lambda key: (order.index(key[0]), key[1])):
        m = found[scenario, law]
        touch = " and ".join(name for name, is_so in (("obstacle", m.hit), ("robot", m.collided)) if is_so) or "no"
        left = ", ".join(map(str, m.left)) or "–"
        cells = (f"{m.clearance:.2f}", touch, *_arrival(m), f"{m.off:.2f}", f"{m.away:.1f}", left)
        rows.append((scenario, label(law), *cells))
    return Grid(
        "Robots among obstacles, thesis 6.2 and 6.3. Clearance: from a robot's rectangle. Off the path: more than "
        "0.1 m. Left behind: robots that the group went on without, for a while or for good.",
        (
            "scenario",
            "controller",
            "least clearance [m]",
            "touch",
            "arrived",
            "spread of arrivals [s]",
            "time",
            "largest distance from the path [m]",
            "longest off the path [s]",
            "left behind",
        ),
        rows,
    )


def _arrival(m: AvoidanceMetrics) -> tuple[str, str, str]:
    """The number of robots that arrived, their spread [s], and the last arrival in nominal durations."""
    ratio = f"{m.ratio:.2f}" if np.isfinite(m.ratio) else "never"
    return f"{sum(m.arrived)} of {len(m.arrived)}", _seconds(m.spread), ratio


# Pictures ---------------------------------------------------------------------------------------------------------


def _pictures(results: AvoidanceResults) -> list[Picture]:
    pictures = [
        Picture(
            "avoidance-eta",
            "The rule base eta (thesis Figs 6.4, 6.5): the sets of d_ij, and the turn η of (6.4). The thesis's figures "
            "are missing; the numbers are choices.",
            "Three triangles over the distance; η falls from 2.4 rad at 0 m to 0 at 0.6 m in a straight line.",
            plot_crash_turn,
        ),
        Picture(
            "avoidance-theta",
            "The rule base theta (thesis Figs 6.20, 6.21): the sets of ro, and the turn Θ of (6.7); choices, too.",
            "Three triangles over the distance; Θ falls from 1.6 rad at 0.15 m to 0 at 0.8 m in a straight line.",
            plot_obstacle_turn,
        ),
        Picture(
            "avoidance-states-crash",
            "What a robot does, and what leads from one to the other (thesis Fig 6.7), from the laws' own tables.",
            "State diagrams of the thesis's crash avoidance and of right of way: tracking and standing.",
            partial(plot_states, (CRASH_LAWS[0], CRASH_LAWS[-1])),
        ),
        Picture(
            "avoidance-states-obstacles",
            "The same among obstacles (thesis Fig 6.26): as printed, and keeping to one side; for both, when the group "
            "goes on without a robot.",
            "State diagrams of obstacle avoidance: tracking, avoiding, following the wall, yielding; left behind.",
            partial(plot_states, OBSTACLE_LAWS),
        ),
        *(
            Picture(
                f"avoidance-meetings-{test}",
                f"{results.scenarios[test].title}, {label(CRASH_LAWS[0])}: where the robots came nearest (thesis "
                f"{figure}), 3 s before and after. Rectangles: the robots in true size every second, filled when they "
                "were nearest; the circle's diameter is their distance.",
                f"The ways of the robots near each other in {test}, magnified.",
                partial(plot_meetings, results.runs[test, CRASH_LAWS[0]]),
            )
            for test, figure in zip(TESTS, ("Fig 6.10", "Fig 6.15"), strict=True)
        ),
    ]
    for scenario, (laws, figures) in FIGURES.items():
        crash = scenario in TESTS
        about = (
            "Filled: the two robots that came nearest, when they did. Line in the distances: what the law keeps; grey: "
            "certainly in contact."
            if crash
            else "Obstacle: what the sonars of robot 1 read, and how far its rectangle truly was from the nearest one."
        )
        pictures.append(
            Picture(
                f"avoidance-{scenario}",
                f"{results.scenarios[scenario].title}. Robots in true size at equal times. {about}",
                f"Trajectories, errors, speeds and distances over time in {scenario}, a column for each of "
                + ", ".join(map(label, laws)),
                partial(plot_avoidance, [results.runs[scenario, law] for law in laws], figures=figures),
            )
        )
    return pictures


# Claims -----------------------------------------------------------------------------------------------------------


def _claims(results: AvoidanceResults, found: dict[tuple[str, str], AvoidanceMetrics]) -> list[Claim]:
    return [
        _crash_test(found, TESTS[0], "thesis 6.1.3.1, Figs 6.9-6.13", "Crash avoidance, test 1: two meetings"),
        _crash_test(
            found, TESTS[1], "thesis 6.1.3.1, Figs 6.14-6.18", "Crash avoidance, test 2: three robots in one point"
        ),
        _any_crossing(results),
        _obstacles(found),
        _stops(found),
        _stuck(found),
    ]


def _crash_test(found: dict[tuple[str, str], AvoidanceMetrics], test: str, source: str, name: str) -> Claim:
    literal, others = found[test, CRASH_LAWS[0]], CRASH_LAWS[1:]
    stops = literal.stood[1] >= 1 and literal.stood[2] >= 1
    good = literal.safe and _together(literal)
    best = any(found[test, law].safe and _together(found[test, law]) for law in others)
    return Claim(
        name,
        source,
        "The robots of lower priority, 2 and 3, stop, robot 1 turns; nobody crashes, and all arrive together.",
        f"As printed: {_crash(literal)}; robots 2 and 3 stand for {literal.stood[1]:.1f} and {literal.stood[2]:.1f} s. "
        + " ".join(f"{label(law)}: {_crash(found[test, law])}." for law in others),
        _graded(good and stops, good or best),
    )


def _crash(m: AvoidanceMetrics) -> str:
    touch = "robots touch" if m.collided else "no contact"
    together = f"arrive within {m.spread:.2f} s" if all(m.arrived) else f"only {sum(m.arrived)} of them arrive"
    return f"{touch}, least distance {m.nearest:.2f} m, {together}, {m.ratio:.2f} of the nominal time"


def _any_crossing(results: AvoidanceResults) -> Claim:
    rates = {law: results.crossings[law].summary() for law in CROSSERS}
    literal, planned = (rates[law] for law in CROSSERS)
    count = literal["runs"]
    bad = literal["collisions"] + literal["deadlocks"]
    touch, wait = (_share(literal[name], count) for name in ("collisions", "deadlocks"))
    ours = ", ".join(_share(planned[name], count) for name in ("collisions", "deadlocks", "refused"))
    return Claim(
        "The crash avoidance is accurate",
        "thesis 6.1.2, 6.4",
        "Stopping by priority and turning away lets robots on crossing paths avoid each other and arrive.",
        f"{count} random crossings of three robots. As printed: robots touch in {touch}, deadlock in {wait}: a "
        f"robot that waits on another's path is run into. Right of way: {ours} touch, deadlock, are refused "
        "before the start.",
        _graded(bad == 0, bad <= 0.1 * count),
    )


def _obstacles(found: dict[tuple[str, str], AvoidanceMetrics]) -> Claim:
    courses = (COURSES[0], COURSES[3])
    literal, ours = ([found[course, law] for course in courses] for law in OBSTACLE_LAWS)
    return Claim(
        "Obstacles are avoided, coordination is kept",
        "thesis 6.3.1 test 1, 6.3.2, Figs 6.28-6.31, 6.40-6.43",
        "The robots detect obstacles, drive around them and resume their paths; the group arrives together.",
        "Simulation 1 and the experiment. As printed: "
        + "; ".join(map(_course, literal))
        + ". Keeping to one side: "
        + "; ".join(map(_course, ours))
        + ".",
        _graded(
            all(m.safe and _together(m) and m.away <= 9 for m in literal), all(m.safe and _together(m) for m in ours)
        ),
    )


def _stops(found: dict[tuple[str, str], AvoidanceMetrics]) -> Claim:
    literal, ours = (found[COURSES[1], law] for law in OBSTACLE_LAWS)
    good = literal.safe and _together(literal) and literal.stood[1] >= 1
    return Claim(
        "Robot 2 stops while robot 1 passes an obstacle",
        "thesis 6.3.1 test 2, Figs 6.32-6.35",
        "Robot 1 turns away from its obstacle into robot 2's way; robot 2 stops until robot 1 is past.",
        f"As printed: {_course(literal)}; robot 2 stands for {literal.stood[1]:.1f} s, least distance of centers "
        f"{literal.nearest:.2f} m. Keeping to one side: {_course(ours)}; robot 2 stands for {ours.stood[1]:.1f} s, "
        f"least distance {ours.nearest:.2f} m.",
        _graded(good, ours.safe and _together(ours)),
    )


def _stuck(found: dict[tuple[str, str], AvoidanceMetrics]) -> Claim:
    literal, ours = (found[COURSES[2], law] for law in OBSTACLE_LAWS)
    left = literal.left == (1,) and not literal.arrived[0] and _together(literal, first=1)
    return Claim(
        "A stuck robot is left behind",
        "thesis 6.2.3 case study 4, 6.3.1 test 3, Figs 6.36-6.39",
        "Robot 1 is stuck in a local minimum; after a delay the others go on without it and stay coordinated.",
        f"As printed: {_course(literal)}; left behind: {', '.join(map(str, literal.left)) or 'nobody'}. Following the "
        f"wall: {_course(ours)}; left behind: {', '.join(map(str, ours.left)) or 'nobody'}.",
        _graded(left and literal.safe, left),
    )


def _course(m: AvoidanceMetrics) -> str:
    touch = "an obstacle is touched" if m.hit else "robots touch" if m.collided else "no contact"
    count = "all arrive" if all(m.arrived) else f"{sum(m.arrived)} of {len(m.arrived)} arrive"
    return (
        f"{touch}, clearance {m.clearance:.2f} m, {count} within {_seconds(m.spread)} s, at most {m.off:.2f} m from "
        f"the path, {m.away:.1f} s off it"
    )


def _together(m: AvoidanceMetrics, first: int = 0) -> bool:
    """Whether all robots, from the one at the place ``first`` on, arrive together as the thesis's tests ask for."""
    return bool(together(m.arrivals[None, first:], ARRIVE_WITHIN)[0])


def _graded(whole: bool, part: bool) -> Verdict:
    return "holds" if whole else "holds in part" if part else "does not hold"


def _share(count: int, runs: int) -> str:
    return f"{100 * count / runs:.0f} %"


def _seconds(value: float) -> str:
    return f"{value:.2f}" if np.isfinite(value) else "–"
