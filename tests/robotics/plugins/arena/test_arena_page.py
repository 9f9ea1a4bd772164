"""The page of an arena, and what opens a report."""

import re

import numpy as np
import pytest

from robotics.plugins.arena.answer import answer
from robotics.plugins.arena.report import arena_chapters, ranking, write_arena, write_tables
from robotics.show.report.page import write_report
from tests.robotics.plugins.arena.synthetic import noisy, outcome


@pytest.fixture(scope="module")
def held():
    failing = noisy(1.4, 2)
    failing[1, :15] = np.inf
    return outcome({"fuzzy": noisy(1.2, 0), "lyapunov": noisy(1.0, 1), "lqr": failing}, reference="lyapunov")


@pytest.mark.long
def test_the_page_needs_nothing_else_and_has_the_answer_first(held, tmp_path, monkeypatch):
    monkeypatch.setattr("robotics.plugins.arena.report.write_laws", lambda outcome, folder: outcome.laws)
    page = write_arena(held, tmp_path, command="robotics arena mine.toml").read_text(encoding="utf-8")
    assert not re.search(r"(?:src|href)=\"(?!data:|#)", page)
    first = page.index(answer(held)[0].split(":")[0])
    assert page.index('id="figure-ranking"') < first < page.index("The terms of each law")
    assert page.count("<figure") == 1 + sum(len(c.pictures) for c in arena_chapters(held))
    for suffix in ("png", "svg", "pdf"):
        assert (tmp_path / "figures" / f"ranking.{suffix}").stat().st_size > 1000


def test_the_tables_say_what_the_statistics_say(held):
    grids = {
        grid.caption.split(":")[0].split(",")[0]: grid for c in arena_chapters(held) for grid in [*c.tables, *c.details]
    }
    costs = grids["Costs over that of Lyapunov"]
    assert [row[0] for row in costs.rows] == ["Lyapunov", "Fuzzy", "LQR"]
    assert costs.rows[0][2].startswith("1 (1 to 1)")
    assert costs.rows[2][2] == "fails"
    assert costs.rows[2][6].startswith("3.12 % (")  # 15 of 480
    orders = {row[0]: row[1:] for row in grids["The order of the laws under other weights of the cost"].rows}
    assert (
        orders["rms_distance_late_m alone"] == orders["as they are"] == ("Lyapunov, Fuzzy, LQR", "0")
    )  # its only term
    assert orders["w_variation_late_radps2 alone"] == ("Fuzzy, Lyapunov, LQR", "1")  # 0 of each that does not fail
    terms = {row[0]: row for row in grids["The terms of each law."].rows}
    assert terms["Lyapunov"][1:3] == ("velocities", "reference, reference velocity")


def test_files_have_a_row_a_run_a_law_and_a_pair(held, tmp_path):
    write_tables(held, tmp_path)
    rows = {
        name: len((tmp_path / f"{name}.csv").read_text().splitlines()) - 1 for name in ("results", "summary", "pairs")
    }
    assert rows == {"results": 3 * 2 * 12 * 40, "summary": 3, "pairs": 6}


def test_it_can_open_a_report(held, tmp_path):
    import robotics
    from robotics.show.report.chapter import Front

    comparison = robotics.compare([robotics.load_scenario("lyapunov-sine")], ["lyapunov"], [0])
    opening = Front("At their best", ranking(held), answer(held), "A note.")
    page = write_report([comparison], [], tmp_path, sections=[], front=opening).read_text(encoding="utf-8")
    assert page.index('id="figure-ranking"') < page.index('id="what"')
    front, _, behind = page.partition("</article>")
    assert "<h2>At their best</h2>" in front
    assert 'id="head"' in behind  # who leads where is a page of its own then
    assert (tmp_path / "figures" / "ranking.png").exists()
