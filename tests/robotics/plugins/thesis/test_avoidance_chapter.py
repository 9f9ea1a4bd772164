"""The report's chapter on avoidance: its runs, metrics, pictures, verdicts, and its place in the report."""

import base64
import json
import re
import zlib
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from matplotlib.collections import PolyCollection

from fuzzy.figures.drawing import COLORS, PAGE_WIDTH
from fuzzy.shell.progress import Begin
from robotics.commands.application import main
from robotics.laws.catalogue import label, make_controller, safety_distance
from robotics.laws.modes import AVOID, LEFT_BEHIND
from robotics.measures.arrival import arrival_time
from robotics.measures.avoidance import left_behind_times, off_path_times, standing_times
from robotics.measures.clearance import robot_gaps
from robotics.measures.contacts import contacts
from robotics.measures.quantities import MEASURED_QUANTITIES
from robotics.measures.teams import nearest_distance
from robotics.measures.tracking import Metric, cross_track_error
from robotics.plugins.encounters.avoidance import CRASH_ROWS, HOW, WHERE, plot_avoidance, plot_trajectories
from robotics.plugins.thesis import avoidance, avoidance_runs
from robotics.plugins.thesis.avoidance import CHAPTER_FIGURES, chapter_of, side_by_side_picture, side_by_side_table
from robotics.plugins.thesis.avoidance_runs import (
    AVOIDANCE_TESTS,
    CASES,
    COURSES,
    CRASH_LAWS,
    OBSTACLE_LAWS,
    RANDOM_CROSSINGS,
    SIDE_BY_SIDE,
    runs_of,
)
from robotics.show.figures.drawing import CONTACT
from robotics.show.report.chapter import Chapter
from robotics.simulation.loop import simulate
from robotics.simulation.run import Run
from robotics.simulation.scenario.reading import load_scenario
from robotics.simulation.spans import ReplayError
from robotics.studies.together import run_together
from tests.drawn import faults_of, vertices, y_of
from tests.robotics.plugins.thesis.conftest import FEW
from tests.robotics.plugins.thesis.recomputed import check_recomputed
from tests.robotics.world.vehicle.etsro import ETSRO

pytestmark = pytest.mark.long


@pytest.fixture(scope="module")
def runs(avoidance_results: dict[Any, Any]) -> dict[tuple[str, str], Run]:
    """One seed of every run."""
    return {key: run.only(3) for key, run in runs_of(avoidance_results).items()}


@pytest.fixture(scope="module")
def planned(runs: dict[tuple[str, str], Run]) -> Run:
    return runs[AVOIDANCE_TESTS[0], "right-of-way"]


# Runs -----------------------------------------------------------------------------------------------------------


def test_runs_of_a_pass_are_those_of_their_scenarios_alone() -> None:
    one, other = (replace(load_scenario(COURSES[n]), duration=11.0) for n in (3, 1))
    together = run_together([one, other], "obstacles-literal", [3, 4])
    alone = simulate(other, make_controller("obstacles-literal"), [3, 4], name="x")
    mine = together[1]
    for name in ("samples", "team", "modes", "ranges", "reference", "stopped", "time"):
        np.testing.assert_array_equal(getattr(mine, name), getattr(alone, name), err_msg=name)
    for a, b in zip(mine.obstacles, alone.obstacles, strict=True):
        np.testing.assert_array_equal(a, b)
    assert (mine.modes > 0).any()
    assert (mine.scenario, mine.seeds) == (COURSES[1], (3, 4))


def test_scenarios_that_differ_in_more_are_not_driven_together() -> None:
    with pytest.raises(ValueError, match="outage-10s cannot be driven together with two-meetings"):
        run_together([load_scenario(AVOIDANCE_TESTS[0]), load_scenario("outage-10s")], "cooperation", [0])


# Metrics -----------------------------------------------------------------------------------------------


def test_distances_are_those_of_geometry(planned: Run) -> None:
    gaps = robot_gaps(planned, 0)
    assert min(gap.min() for gap in gaps.values()) == nearest_distance(planned).min()
    assert list(gaps) == [(0, 1), (0, 2), (1, 2)]


def test_stops_detours_and_who_was_left(planned: Run) -> None:
    still, away = slice(200, 260), slice(400, 440)
    samples, modes = planned.samples.copy(), np.zeros((len(planned.time), 1, 3), dtype=np.int8)
    samples[:, 3] = 0.2
    samples[still, 3, 0, 1] = 0.0
    heading = samples[away, 2, 0, 2]
    samples[away, 0, 0, 2] -= 0.3 * np.sin(heading)
    samples[away, 1, 0, 2] += 0.3 * np.cos(heading)
    modes[500:, 0, 2] = AVOID + LEFT_BEHIND
    run = planned.with_recorded(samples=samples, modes=modes)
    np.testing.assert_allclose(standing_times(run), [[0.0, 3.0, 0.0]], atol=1e-9)
    np.testing.assert_allclose(off_path_times(run), [[0.0, 0.0, 2.0]], atol=1e-9)
    left = left_behind_times(run)[0]
    assert (left[:2] == 0).all()
    assert left[2] == pytest.approx((len(run.time) - 500) * 0.05)


# The chapter ----------------------------------------------------------------------------------------------------


def test_the_chapter_judges_the_claims_from_its_runs(avoidance_results: dict[Any, Any]) -> None:
    chapter = chapter_of(avoidance_results)
    verdicts = {claim.name: claim.forms for claim in chapter.claims}
    assert verdicts["The crash avoidance is accurate"]["as printed"] == "does not hold"
    assert len(verdicts) == 6
    tests, crossings, courses, _ = chapter.tables
    assert len(tests.rows) == len(AVOIDANCE_TESTS) * (len(CRASH_LAWS) + 1)  # and the joined law
    assert [row[0] for row in crossings.rows][::2] == ["Crash avoidance, literal", "Right of way"]
    assert crossings.rows[2][1].startswith("0 % (0 to")
    assert len(courses.rows) == (len(COURSES) + 1) * len(OBSTACLE_LAWS) - 1 + len(COURSES)  # a case study is of one law
    for grid in chapter.tables:
        assert {len(row) for row in grid.rows} == {len(grid.head)}
    assert any(load_scenario(CASES[2]).title in film.caption for film in chapter.films)
    assert [lead.scenario for lead in chapter.leads] == [*AVOIDANCE_TESTS, *COURSES]


def test_test_1_asks_whether_robot_1_turns(avoidance_results: dict[Any, Any]) -> None:
    """It was said to hold although robot 1 leaves its path by 5 mm only."""
    (claim,) = (c for c in chapter_of(avoidance_results).claims if "test 1" in c.name)
    (turns,) = (part for part in claim.of("as printed") if "turns" in part.says)
    assert (turns.quantity, turns.robots, turns.outcome) == ("max_cross_track_m", "1", "fails")
    assert claim.forms["as printed"] != "holds"


@pytest.mark.long
def test_another_outcome_gives_another_verdict(avoidance_results: dict[Any, Any]) -> None:
    """A verdict is not a sentence that stands there anyway."""
    other = dict(avoidance_results)
    for law in CRASH_LAWS:
        other[RANDOM_CROSSINGS, law] = avoidance_results[RANDOM_CROSSINGS, "right-of-way"]
    literal = [run for run in avoidance_results["courses", "obstacles-literal"] if run.scenario != COURSES[2]]
    stuck = next(run for run in literal if run.scenario == COURSES[0])
    about = replace(stuck.about, scenario=COURSES[2])
    other["courses", "obstacles-literal"] = [*literal, replace(stuck, about=about)]
    before, after = ({c.name: c for c in chapter_of(r).claims} for r in (avoidance_results, other))
    assert before["A stuck robot is left behind"].forms["as printed"] != "does not hold"
    stuck_before, stuck_after = (
        found["A stuck robot is left behind"].of("as printed")[:2] for found in (before, after)
    )
    assert all(part.kept == part.estimate.runs for part in stuck_before)
    assert [(part.kept, part.outcome != "holds") for part in stuck_after] == [(0, True)] * 2
    assert [p.estimate.value for p in after["The crash avoidance is accurate"].parts] == [1.0] * 4


def test_three_laws_side_by_side(avoidance_results: dict[Any, Any], monkeypatch: pytest.MonkeyPatch) -> None:
    runs = runs_of(avoidance_results)
    rows = {row[:2]: row[2:] for row in side_by_side_table(runs).rows}
    assert len(rows) == (len(AVOIDANCE_TESTS) + len(COURSES)) * len(SIDE_BY_SIDE)
    printed, planned = (rows[AVOIDANCE_TESTS[1], label(law)] for law in (SIDE_BY_SIDE[0], SIDE_BY_SIDE[-1]))
    assert printed[:4] == ("4 of 4", "0 % (0 to 49)", "–", "–")
    assert planned[:2] == ("0 of 4", "100 % (51 to 100)")
    run = runs[AVOIDANCE_TESTS[1], "right-of-way"]
    last = [max(arrival_time(run.only(seed))[0]) for seed in run.seeds]
    assert planned[3].startswith(f"{np.mean(last) / 44.4:.2f}")
    touched = sum(bool(contacts(runs[COURSES[1], "right-of-way"], place)) for place in range(4))
    assert rows[COURSES[1], "Right of way: drives blind"][:4] == (f"{touched} of 4", "–", "–", "–")
    assert touched == 4
    # Of a law without an emergency rule the share is unknown.
    share = Metric(lambda r: np.full(r.stopped.shape, np.nan if r.controller == SIDE_BY_SIDE[0] else 0.25), "1", "")
    monkeypatch.setattr(
        "robotics.measures.quantities.MEASURED_QUANTITIES", {**MEASURED_QUANTITIES, "emergency_share": share}
    )
    table = side_by_side_table(runs)
    assert table.head[-1] == "emergency rule"
    assert [row[-1] for row in table.rows[:3]] == ["–", "0.250", "0.250"]


@pytest.mark.long
def test_numbers_are_recomputed_by_code_that_shares_nothing(
    avoidance_results: dict[Any, Any], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(avoidance_runs, "FACTOR", 1.15)  # as the results
    experiments = avoidance_runs.experiments("", 3, FEW)
    check_recomputed(avoidance_results, experiments, chapter_of(avoidance_results).claims, tmp_path, least=32)


# Pictures -------------------------------------------------------------------------------------------------------


def test_a_page_has_a_column_a_law_and_names_the_thesis_figures(runs: dict[tuple[str, str], Run]) -> None:
    laws, figures = CHAPTER_FIGURES[AVOIDANCE_TESTS[1]]
    shown = [runs[AVOIDANCE_TESTS[1], law] for law in laws]
    page = plot_avoidance(shown, figures=figures)
    assert len(page.axes) == 7 * 3
    named = [ax.get_title(loc="left") for ax in page.axes if ax.get_title(loc="left")]
    assert named == [*figures.values()]
    distances = page.axes[3:6]
    for ax, run, kept in zip(distances, shown, (0.6, None, 0.5), strict=True):
        drawn = [y_of(line) for line in ax.lines]
        assert kept is None or any(np.all(np.asarray(y) == kept) for y in drawn)  # the joined law keeps none
        gap = robot_gaps(run, 0)[0, 1]
        assert any(len(y) > 2 and np.isin(y, gap).all() for y in drawn)
    assert {ax.get_xlim() for ax in page.axes[3:]} == {distances[0].get_xlim()}
    assert [text.get_text() for text in page.legends[0].get_texts()][:3] == ["robot 1", "robot 2", "robot 3"]
    for rows in (WHERE, HOW):
        part = plot_avoidance(shown, figures=figures, rows=[row for row in CRASH_ROWS if row in rows], width=PAGE_WIDTH)
        assert not faults_of(part)
        assert part.get_figheight() < 6.0
    # Filled in the top view: the two robots that came nearest, where they did.
    (k, i, j) = (lambda g: (int(min(g.values(), key=np.min).argmin()), *min(g, key=lambda pair: g[pair].min())))(
        robot_gaps(shown[0], 0)
    )
    filled = [
        c for c in page.axes[0].collections if isinstance(c, PolyCollection) and np.asarray(c.get_facecolor())[0, 1] < 1
    ]
    middles = [vertices(c.get_paths()[0])[:4].mean(axis=0) for c in filled]
    wanted = [[shown[0]["x"][0, n, k], shown[0]["y"][0, n, k]] for n in (i, j)]
    np.testing.assert_allclose(sorted(map(list, middles)), sorted(wanted), atol=1e-9)


def test_a_page_among_obstacles_shows_sonars_clearance_and_modes(runs: dict[tuple[str, str], Run]) -> None:
    run = runs[COURSES[2], "obstacles-literal"]
    page = plot_avoidance([run], rows=("trajectories", "sonar", "modes", "cross-track"))
    top, sonar, modes, cross = page.axes
    solid = [c for c in top.collections if isinstance(c, PolyCollection) and c.get_zorder() == 1.5]
    assert len(solid[0].get_paths()) == 1  # the trap
    names = [line.get_label() for line in sonar.lines]
    assert names == ["robot 1: front sonars", "side sonars", "true clearance"]
    front = np.asarray(sonar.lines[0].get_ydata())
    read = run.ranges[: len(front), 0, 0, :2].min(axis=1)
    np.testing.assert_array_equal(front, np.where(np.isfinite(read), read, np.nan))
    words = {text.get_text() for text in modes.get_legend().get_texts()}
    assert {"tracking", "avoiding", "left behind"} <= words
    driven = [line for line in cross.lines if line.get_color() == COLORS[0]][-1]
    np.testing.assert_array_equal(driven.get_ydata(), cross_track_error(run)[0, 0, : len(front)])


def test_trajectories_have_a_row_a_scenario_and_a_column_a_law(avoidance_results: dict[Any, Any]) -> None:
    picture = side_by_side_picture(runs_of(avoidance_results))
    page = picture.draw()
    assert [ax.get_title() for ax in page.axes] == [*map(label, SIDE_BY_SIDE), "", "", ""]
    assert [ax.get_ylabel() for ax in page.axes[::3]] == [f"{test}, seed 3\ny [m]" for test in AVOIDANCE_TESTS]
    crosses = [any(line.get_marker() == CONTACT["marker"] for line in ax.lines) for ax in page.axes]
    assert [crosses[0], crosses[3], crosses[5]] == [False, True, False]
    runs = runs_of(avoidance_results)
    with pytest.raises(ValueError, match="one scenario a row, and the same laws in each row"):
        plot_trajectories([[runs[AVOIDANCE_TESTS[0], "right-of-way"]], [runs[AVOIDANCE_TESTS[1], "crash-literal"]]])


def test_pages_that_cannot_be(runs: dict[tuple[str, str], Run], planned: Run) -> None:
    with pytest.raises(ValueError, match="one to three runs on one scenario"):
        plot_avoidance([])
    with pytest.raises(ValueError, match="one to three runs on one scenario"):
        plot_avoidance([planned, runs[AVOIDANCE_TESTS[1], "right-of-way"]])
    with pytest.raises(ReplayError, match="seed 5 is not among those of the run: 3"):
        plot_avoidance([planned], seed=5)
    assert safety_distance("crash-literal:d_min=0.8", [ETSRO]) == 0.8
    assert safety_distance("obstacles", [ETSRO]) is None
    assert safety_distance("something else", [ETSRO]) is None


# The command line -----------------------------------------------------------------------------------------------


@pytest.mark.long
def test_compare_writes_the_chapter_into_the_report(
    avoidance_results: dict[Any, Any],
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    @contextmanager
    def judging(begin: Begin, folder: Path, seed: int, draw: bool, **how: Any) -> Iterator[Callable[[], list[Chapter]]]:
        yield lambda: [chapter_of(avoidance_results)]

    monkeypatch.setattr("robotics.plugins.thesis.chapters.judging", judging)
    monkeypatch.setattr("robotics.show.report.page._pictures", lambda *_: [])
    monkeypatch.setattr(avoidance, "CHAPTER_FIGURES", {AVOIDANCE_TESTS[0]: CHAPTER_FIGURES[AVOIDANCE_TESTS[0]]})
    out = tmp_path / "out"
    command = ["compare", "lyapunov-sine", "--controllers", "lyapunov", "--seeds", "1", "--claims", "--out", str(out)]
    assert main([*command, "--json", "-q"]) == 0
    printed = json.loads(capsys.readouterr().out)
    assert [claim["name"] for claim in printed["claims"]] == [c.name for c in chapter_of(avoidance_results).claims]
    assert f"figures/avoidance-{AVOIDANCE_TESTS[0]}.png" in printed["files"]
    page = (out / "report.html").read_text(encoding="utf-8")
    assert 'id="chapter-avoidance"' in page
    assert "Fig 6.13" not in page  # it is in the picture
    assert page.count("data-fleet-player=") >= 2
    packed = re.findall(r'<script type="application/octet-stream">(.*?)</script>', page)
    assert any(b'"obstacles":{"bodies":' in zlib.decompress(base64.b64decode(text)) for text in packed)
    assert "A stuck robot is left behind" in (out / "claims.csv").read_text(encoding="utf-8")
