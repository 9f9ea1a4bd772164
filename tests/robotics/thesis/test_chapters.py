"""The thesis's chapters side by side, and the chapter on one robot."""

import warnings
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from robotics.report.chapter import Chapter, Picture
from robotics.simulation.run import Run
from robotics.thesis import tracking
from robotics.thesis.chapters import CHAPTERS, _made
from robotics.thesis.experiment import ChapterMaker, Experiment, results_of
from robotics.thesis.tracking import chapter_of, claims_of, experiments


@pytest.fixture(scope="module")
def results() -> Iterator[dict[Any, Any]]:
    """All experiments of the tracking chapter, with a sweep of one condition and few places."""
    patch = pytest.MonkeyPatch()
    patch.setattr(tracking, "_SWEEP", tracking._SWEEP[:1])
    patch.setattr(tracking, "_PLACES", 10)
    yield results_of(experiments())
    patch.undo()


def test_progress_is_the_number_of_experiments(tmp_path: Path) -> None:
    for maker in CHAPTERS:
        wanted = maker.experiments(str(tmp_path), 0)
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

    maker = ChapterMaker("one", lambda folder, seed: [Experiment(("x",), warned)], chapter, 1.0)
    monkeypatch.setattr("robotics.thesis.chapters.CHAPTERS", (maker,))
    ticks: list[None] = []
    made, caught = _made(0, "", 0, False, lambda: ticks.append(None))
    assert (made.title, list(made.pictures), len(ticks)) == ("7", [], 1)
    assert [str(message) for message in caught] == ["thin ice"]
    with pytest.raises(AssertionError, match="nobody wants"):
        _made(0, "", 0, True, lambda: None)


def test_the_tracking_chapter_judges_and_says_where_gains_come_from(results: dict[Any, Any]) -> None:
    chapter = chapter_of(results)
    verdicts = {claim.name: claim.verdict for claim in chapter.claims}
    assert len(verdicts) == 13
    assert all(claim.source.startswith("thesis ") for claim in chapter.claims)
    assert verdicts["The law as printed"] == "does not hold"
    assert verdicts["Fuzzy tracking on and off the path"] == "holds"
    (origins,) = chapter.tables
    assert {"csm", "esm", "fuzzy", "lyapunov-thesis"} <= {row[1] for row in origins.rows}
    assert all(len(row) == len(origins.head) and row[2] for row in origins.rows)
    assert len(chapter.pictures) == 4


def test_another_outcome_gives_another_verdict(results: dict[Any, Any]) -> None:
    """A verdict is not a sentence that stands there anyway."""
    swapped = dict(results)
    for name in ("lyapunov-sine", "lyapunov-circle"):
        swapped[name, "lyapunov-thesis:signs=literal"] = results["fuzzy-on-path", "lyapunov"]
    driven: Run = results["fuzzy-off-path", "fuzzy"]
    swapped["fuzzy-off-path", "fuzzy"] = driven.with_recorded(samples=driven.samples + 1.0)
    verdicts = {claim.name: claim.verdict for claim in claims_of(swapped)}
    assert verdicts["The law as printed"] == "holds"
    assert verdicts["Fuzzy tracking on and off the path"] == "does not hold"
