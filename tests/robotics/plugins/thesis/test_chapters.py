"""The thesis's chapters side by side, and the chapter on one robot."""

import csv
import warnings
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from robotics.laws.catalogue import make_controller
from robotics.plugins.thesis import tracking
from robotics.plugins.thesis.chapters import CHAPTERS, _made
from robotics.plugins.thesis.claims import Needed, needed
from robotics.plugins.thesis.experiment import USUAL, ChapterMaker, Experiment, results_of
from robotics.plugins.thesis.tracking import chapter_of, claims_of
from robotics.show.report.chapter import Chapter, Picture
from robotics.simulation.run import Run
from robotics.simulation.scenario.reading import scenario_names
from tests.robotics.plugins.thesis.conftest import FEW
from tests.robotics.plugins.thesis.recomputed import check_recomputed


def test_progress_is_the_number_of_experiments(tmp_path: Path) -> None:
    for maker in CHAPTERS:
        wanted = maker.experiments(str(tmp_path), 0, USUAL)
        assert len({experiment.key for experiment in wanted}) == len(wanted) > 0, maker.title
    assert list(tmp_path.iterdir()) == []  # nothing is run by counting
    ticks: list[int] = []
    found = results_of([Experiment((n,), lambda n=n: n * n) for n in range(4)], lambda: ticks.append(len(ticks)))  # type: ignore[misc]
    assert found == {(0,): 0, (1,): 1, (2,): 4, (3,): 9}
    assert ticks == [0, 1, 2, 3]


def test_a_chapter_comes_back_with_its_warnings_and_undrawn_if_nobody_looks(monkeypatch: pytest.MonkeyPatch) -> None:
    def warned() -> int:
        warnings.warn("thin ice", UserWarning, stacklevel=1)
        return 7

    def draw() -> Any:
        raise AssertionError("drawn although nobody wants pictures")

    def chapter(found: Any) -> Chapter:
        return Chapter("one", str(found["x",]), (), [], [], [Picture("p", "c", "a", draw)], [])

    maker = ChapterMaker("one", lambda folder, seed, effort: [Experiment(("x",), warned)], chapter, 1.0)
    monkeypatch.setattr("robotics.plugins.thesis.chapters.CHAPTERS", (maker,))
    ticks: list[int] = []
    made, caught = _made("", 0, USUAL, False, ticks.append, False, 0)
    assert (made.title, list(made.pictures), len(ticks)) == ("7", [], 1)
    assert [str(message) for message in caught] == ["thin ice"]
    with pytest.raises(AssertionError, match="nobody wants"):
        _made("", 0, USUAL, True, ticks.append, False, 0)


def test_the_tracking_chapter_judges_and_says_where_gains_come_from(tracking_results: dict[Any, Any]) -> None:
    chapter = chapter_of(tracking_results)
    verdicts = {claim.name: claim.forms for claim in chapter.claims}
    assert len(verdicts) == 13
    assert all(claim.source.startswith("thesis ") and claim.untested for claim in chapter.claims)
    assert verdicts["The law as printed"] == {"as printed": "does not hold"}
    assert verdicts["Fuzzy tracking on and off the path"]["corrected"] == "holds"
    table, origins, proven = chapter.tables
    assert {"csm", "esm", "fuzzy", "lyapunov-thesis"} <= {row[1] for row in origins.rows}
    for grid in chapter.tables:
        assert {len(row) for row in grid.rows} == {len(grid.head)}
    assert len(table.rows) == 8  # each mode as printed, and here
    assert len(chapter.pictures) == 5
    certified = {row[0]: row[4].startswith("X ±") for row in proven.rows}
    assert [law for law, found in certified.items() if found] == ["Fuzzy, correcting (smooth=0)", "Lyapunov"]
    assert len(certified) == 6


def test_fuzzy_against_nonlinear_is_judged_with_the_scenario_s_noise(tracking_results: dict[Any, Any]) -> None:
    """It was judged without, where the fuzzy law looks more precise."""
    (claim,) = (c for c in claims_of(tracking_results) if c.name == "Fuzzy against nonlinear")
    for form in ("as printed", "corrected"):
        assert all(part.estimate.runs == FEW.seeds for part in claim.of(form))
    noisy: Run = tracking_results[Needed("fuzzy-on-path", "fuzzy", False)]
    assert np.std(noisy["x_measured"] - noisy["x"]) == pytest.approx(0.003, rel=0.2)
    quiet: Run = tracking_results[Needed("fuzzy-on-path", "fuzzy", True)]
    assert np.abs(quiet["x_measured"] - quiet["x"]).max() < 0.01
    assert quiet.seeds == (3,)


def test_another_outcome_gives_another_verdict(tracking_results: dict[Any, Any]) -> None:
    """A verdict is not a sentence that stands there anyway, and neither are the words beside it."""
    swapped = dict(tracking_results)
    for name in ("lyapunov-sine", "lyapunov-circle"):
        good = tracking_results[Needed("fuzzy-on-path", "lyapunov", False)]
        swapped[Needed(name, "lyapunov-thesis:signs=literal", False)] = good
    driven: Run = tracking_results[Needed("fuzzy-off-path", "fuzzy", False)]
    lost = driven.with_recorded(samples=driven.samples + 1.0)
    swapped[Needed("fuzzy-off-path", "fuzzy", False)] = lost
    before, after = ({c.name: c for c in claims_of(found)} for found in (tracking_results, swapped))
    assert after["The law as printed"].verdict == "holds"
    assert after["Fuzzy tracking on and off the path"].forms["corrected"] == "holds in part"
    for name in ("The law as printed", "Fuzzy tracking on and off the path"):
        assert before[name].measured != after[name].measured


def test_the_printed_table_is_the_data_s() -> None:
    folder = Path(__file__).parents[4] / "datasets" / "thesis"
    with (folder / "table-2-1.csv").open(encoding="utf-8") as file:
        rows = list(csv.reader(file))[1:]
    assert list(tracking.PRINTED_TRACKING.values()) == [tuple(map(float, row[1:])) for row in rows]


@pytest.mark.parametrize("chapter", ["tracking", "teams", "avoidance", "formation"])
def test_every_claim_asks_for_what_exists(chapter: str) -> None:
    asked = needed(chapter)
    assert asked
    for need in asked:
        if need.on in scenario_names() and "networks" not in need.of and "systems" not in need.of:
            make_controller(need.of)
    names = [need.on for need in asked]
    assert chapter in {"formation"} or len(set(names) & set(scenario_names())) >= 3


def test_numbers_are_recomputed_by_code_that_shares_nothing(tracking_results: dict[Any, Any], tmp_path: Path) -> None:
    check_recomputed(
        tracking_results, tracking.experiments("", 3, FEW), claims_of(tracking_results), tmp_path, least=59
    )


def test_the_check_finds_a_number_that_is_wrong(tracking_results: dict[Any, Any], tmp_path: Path) -> None:
    claims = claims_of(tracking_results)
    part = claims[0].parts[0]
    wrong = replace(part, estimate=replace(part.estimate, value=part.estimate.value + 1e-5))
    claims[0] = replace(claims[0], parts=(wrong, *claims[0].parts[1:]))
    with pytest.raises(AssertionError, match="recomputed"):
        check_recomputed(tracking_results, [], claims, tmp_path, least=1)
