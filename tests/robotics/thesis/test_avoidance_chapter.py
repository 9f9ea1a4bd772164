"""The report's chapter on avoidance: its runs, metrics, pictures, verdicts, and its place in the report."""

import json
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from matplotlib.collections import PolyCollection

from fuzzy.figures.drawing import COLORS
from fuzzy.shell.progress import Begin
from robotics.commands.application import main
from robotics.environment.world import Disc, World, compile_world
from robotics.experiments.together import run_together
from robotics.figures.avoidance import plot_avoidance
from robotics.laws.catalogue import kept_distance, make_controller
from robotics.laws.modes import AVOID, LEFT_BEHIND
from robotics.measures.avoidance import avoidance_metrics
from robotics.measures.clearance import clearances, robot_gaps
from robotics.measures.teams import nearest_distance
from robotics.measures.tracking import cross_track_error
from robotics.report.chapter import Chapter
from robotics.scenario.description import Scenario
from robotics.scenario.reading import load_scenario
from robotics.simulation.loop import simulate
from robotics.simulation.run import Run
from robotics.simulation.spans import ReplayError
from robotics.thesis import avoidance
from robotics.thesis import avoidance_runs as avoidanceexperiments
from robotics.thesis.avoidance import FIGURES, chapter_of
from robotics.thesis.avoidance_runs import (
    CASES,
    COURSES,
    CRASH_LAWS,
    OBSTACLE_LAWS,
    TESTS,
    AvoidanceResults,
    avoidance_results,
    experiments,
)
from robotics.thesis.experiment import results_of
from tests.drawn import vertices, y_of


@pytest.fixture(scope="module")
def results() -> AvoidanceResults:
    """All experiments, with fewer random crossings, that are given less time."""
    patch = pytest.MonkeyPatch()
    patch.setattr(avoidanceexperiments, "CROSSINGS", 5)
    patch.setattr(avoidanceexperiments, "FACTOR", 1.15)
    patch.setattr(avoidanceexperiments, "CASES", CASES[2:3])
    steps: list[int] = []
    wanted = experiments()
    found = results_of(wanted, lambda: steps.append(1))
    patch.undo()
    assert len(steps) == len(wanted) == len(found)
    return avoidance_results(found)


@pytest.fixture(scope="module")
def first(results: AvoidanceResults) -> Scenario:
    return results.scenarios[TESTS[0]]


@pytest.fixture(scope="module")
def planned(results: AvoidanceResults) -> Run:
    return results.runs[TESTS[0], "right-of-way"]


# Runs -----------------------------------------------------------------------------------------------------------


def test_runs_of_a_pass_are_those_of_their_scenarios_alone() -> None:
    one, other = (replace(load_scenario(COURSES[n]), duration=11.0) for n in (3, 1))
    together = run_together([one, other], "obstacles-literal", 3)
    alone = simulate(other, make_controller("obstacles-literal"), [3], name="x")
    mine = together[1]
    for name in ("samples", "team", "modes", "ranges", "reference", "stopped", "time"):
        np.testing.assert_array_equal(getattr(mine, name), getattr(alone, name), err_msg=name)
    for a, b in zip(mine.obstacles, alone.obstacles, strict=True):
        np.testing.assert_array_equal(a, b)
    assert (mine.modes > 0).any()
    assert (mine.scenario, mine.seeds) == (COURSES[1], (3,))


def test_scenarios_that_differ_in_more_are_not_driven_together() -> None:
    with pytest.raises(ValueError, match="outage-10s cannot be driven together with two-meetings"):
        run_together([load_scenario(TESTS[0]), load_scenario("outage-10s")], "cooperation", 0)


# Metrics -----------------------------------------------------------------------------------------------


def test_distances_and_clearances_are_those_of_geometry(planned: Run, first: Scenario) -> None:
    gaps = robot_gaps(planned, 0)
    assert (
        min(gap.min() for gap in gaps.values())
        == nearest_distance(planned).min()
        == avoidance_metrics(planned, first.trajectory.ends[0]).nearest
    )
    assert list(gaps) == [(0, 1), (0, 2), (1, 2)]
    samples = planned.samples.copy()
    samples[:, :3] = 0.0
    samples[:, 0, 0, 0] = np.linspace(-1, 1, len(planned.time))  # robot 1 drives along x past a disc
    disc = compile_world(World(obstacles=(Disc(position=(0.0, 0.6), radius=0.2),)))
    free = clearances(replace(planned, obstacles=disc.rest).with_recorded(samples=samples), 0)[0]
    x = np.linspace(-1, 1, len(planned.time))
    corner = np.hypot(np.maximum(np.abs(x) - 0.115, 0.0), 0.5)  # of 0.23 x 0.20 m
    np.testing.assert_allclose(free, corner - 0.2, atol=1e-9)
    assert np.isinf(clearances(planned, 0)).all()


def test_contact_is_that_of_rectangles(planned: Run, first: Scenario) -> None:
    for gap, touches in ((0.2301, False), (0.2299, True)):
        samples = planned.samples.copy()
        samples[300, :3, 0, 0] = samples[300, :3, 0, 1]
        samples[300, 2, 0, :2] = 0.0
        samples[300, 0, 0, 0] += gap
        samples[[299, 301], :3, 0, 0] = np.nan  # it does not drive there
        m = avoidance_metrics(planned.with_recorded(samples=samples), first.trajectory.ends[0])
        assert (m.collided, m.safe) == (touches, not touches)
        assert m.nearest == pytest.approx(gap)


def test_stops_detours_and_who_was_left(planned: Run, first: Scenario) -> None:
    still, away = slice(200, 260), slice(400, 440)
    samples, modes = planned.samples.copy(), np.zeros((len(planned.time), 1, 3), dtype=np.int8)
    samples[:, 3] = 0.2
    samples[still, 3, 0, 1] = 0.0
    heading = samples[away, 2, 0, 2]
    samples[away, 0, 0, 2] -= 0.3 * np.sin(heading)
    samples[away, 1, 0, 2] += 0.3 * np.cos(heading)
    modes[500:, 0, 2] = AVOID + LEFT_BEHIND
    m = avoidance_metrics(planned.with_recorded(samples=samples, modes=modes), first.trajectory.ends[0])
    assert m.stood == pytest.approx((0.0, 3.0, 0.0))
    assert m.away == pytest.approx(2.0)
    assert m.off == pytest.approx(0.3, abs=0.02)
    assert m.left == (3,)
    assert m.spread <= 0.2
    assert m.ratio == pytest.approx(1.02, abs=0.02)


# The chapter ----------------------------------------------------------------------------------------------------


def test_the_chapter_judges_the_claims_from_its_runs(results: AvoidanceResults) -> None:
    chapter = chapter_of(results)
    verdicts = {claim.name: claim.verdict for claim in chapter.claims}
    assert verdicts["Crash avoidance, test 1: two meetings"] == "holds"
    assert verdicts["Crash avoidance, test 2: three robots in one point"] == "holds in part"
    assert verdicts["The crash avoidance is accurate"] == "does not hold"
    assert len(verdicts) == 6
    tests, crossings, courses = chapter.tables
    assert len(tests.rows) == len(TESTS) * len(CRASH_LAWS)
    assert [row[0] for row in crossings.rows] == ["Crash avoidance, literal", "Right of way"]
    assert crossings.rows[1][1:5] == ("0 %", "0 %", "0 %", "100 %")
    assert len(courses.rows) >= len(COURSES) * len(OBSTACLE_LAWS)
    for grid in chapter.tables:
        assert {len(row) for row in grid.rows} == {len(grid.head)}
    assert any(results.scenarios[CASES[2]].title in film.caption for film in chapter.films)


def test_another_outcome_gives_another_verdict(results: AvoidanceResults) -> None:
    """A verdict is not a sentence that stands there anyway."""
    runs = dict(results.runs)
    for law in CRASH_LAWS:
        runs[TESTS[0], law] = results.runs[TESTS[1], "crash-literal"]
    runs[COURSES[2], "obstacles-literal"] = results.runs[COURSES[0], "obstacles-literal"]
    crossings = dict.fromkeys(results.crossings, results.crossings["right-of-way"])
    verdicts = {c.name: c.verdict for c in chapter_of(replace(results, runs=runs, crossings=crossings)).claims}
    assert verdicts["Crash avoidance, test 1: two meetings"] == "does not hold"
    assert verdicts["A stuck robot is left behind"] == "does not hold"
    assert verdicts["The crash avoidance is accurate"] == "holds"


# Pictures -------------------------------------------------------------------------------------------------------


def test_a_page_has_a_column_a_law_and_names_the_thesis_figures(results: AvoidanceResults) -> None:
    laws, figures = FIGURES[TESTS[1]]
    runs = [results.runs[TESTS[1], law] for law in laws]
    page = plot_avoidance(runs, figures=figures)
    assert len(page.axes) == 7 * 3
    named = [ax.get_title(loc="left") for ax in page.axes if ax.get_title(loc="left")]
    assert named == [f"thesis {name}" for name in figures.values()]
    distances = page.axes[3:6]
    for ax, run, kept in zip(distances, runs, (0.6, 1.0, 0.5), strict=True):
        drawn = [y_of(line) for line in ax.lines]
        assert any(np.all(np.asarray(y) == kept) for y in drawn)
        gap = robot_gaps(run, 0)[0, 1]
        assert any(len(y) > 2 and np.array_equal(y, gap[: len(y)]) for y in drawn)
    assert {ax.get_xlim() for ax in page.axes[3:]} == {distances[0].get_xlim()}
    # Filled in the top view: the two robots that came nearest, where they did.
    (k, i, j) = (lambda g: (int(min(g.values(), key=np.min).argmin()), *min(g, key=lambda pair: g[pair].min())))(
        robot_gaps(runs[0], 0)
    )
    filled = [
        c for c in page.axes[0].collections if isinstance(c, PolyCollection) and np.asarray(c.get_facecolor())[0, 1] < 1
    ]
    middles = [vertices(c.get_paths()[0])[:4].mean(axis=0) for c in filled]
    wanted = [[runs[0]["x"][0, n, k], runs[0]["y"][0, n, k]] for n in (i, j)]
    np.testing.assert_allclose(sorted(map(list, middles)), sorted(wanted), atol=1e-9)


def test_a_page_among_obstacles_shows_sonars_clearance_and_modes(results: AvoidanceResults) -> None:
    run = results.runs[COURSES[2], "obstacles-literal"]
    page = plot_avoidance([run], rows=("trajectories", "sonar", "modes", "cross-track"))
    top, sonar, modes, cross = page.axes
    solid = [c for c in top.collections if isinstance(c, PolyCollection) and c.get_zorder() == 1.5]
    assert len(solid[0].get_paths()) == 1  # the trap
    names = [line.get_label() for line in sonar.lines]
    assert names == ["robot 1, front sonars", "robot 1, side sonars", "true clearance"]
    front = np.asarray(sonar.lines[0].get_ydata())
    read = run.ranges[: len(front), 0, 0, :2].min(axis=1)
    np.testing.assert_array_equal(front, np.where(np.isfinite(read), read, np.nan))
    words = {text.get_text() for text in modes.get_legend().get_texts()}
    assert {"tracking", "avoiding", "left behind"} <= words
    driven = [line for line in cross.lines if line.get_color() == COLORS[0]][-1]
    np.testing.assert_array_equal(driven.get_ydata(), cross_track_error(run)[0, 0, : len(front)])


def test_pages_that_cannot_be(results: AvoidanceResults, planned: Run) -> None:
    with pytest.raises(ValueError, match="one to three runs on one scenario"):
        plot_avoidance([])
    with pytest.raises(ValueError, match="one to three runs on one scenario"):
        plot_avoidance([planned, results.runs[TESTS[1], "right-of-way"]])
    with pytest.raises(ReplayError, match="seed 5 is not among those of the run: 0"):
        plot_avoidance([planned], seed=5)
    assert kept_distance("crash-literal:d_min=0.8") == 0.8
    assert kept_distance("obstacles") is None
    assert kept_distance("something else") is None


# The command line -----------------------------------------------------------------------------------------------


def test_compare_writes_the_chapter_into_the_report(
    results: AvoidanceResults, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    @contextmanager
    def judging(begin: Begin, folder: Path, seed: int, draw: bool) -> Iterator[Callable[[], list[Chapter]]]:
        yield lambda: [chapter_of(results)]

    monkeypatch.setattr("robotics.thesis.chapters.judging", judging)
    monkeypatch.setattr("robotics.report.page._pictures", lambda comparison, scenario: [])
    monkeypatch.setattr(avoidance, "FIGURES", {TESTS[0]: FIGURES[TESTS[0]]})
    out = tmp_path / "out"
    command = ["compare", "lyapunov-sine", "--controllers", "lyapunov", "--seeds", "1", "--claims", "--out", str(out)]
    assert main([*command, "--json", "-q"]) == 0
    printed = json.loads(capsys.readouterr().out)
    assert [claim["name"] for claim in printed["claims"]] == [c.name for c in chapter_of(results).claims]
    assert f"figures/avoidance-{TESTS[0]}.png" in printed["files"]
    page = (out / "report.html").read_text(encoding="utf-8")
    assert 'id="chapter-avoidance"' in page
    assert "Fig 6.13" not in page  # it is in the picture
    assert page.count("data-fleet-player=") >= 2
    assert page.count('"obstacles":{"bodies":') >= 1
    assert "A stuck robot is left behind" in (out / "claims.csv").read_text(encoding="utf-8")
