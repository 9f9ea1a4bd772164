"""What the page says of the arena of tasks is what its last run wrote: docs/reference/arena-tasks*.csv."""

from pathlib import Path
from typing import Any

import pandas as pd
import pytest

from robotics.laws.catalogue import as_law
from robotics.measures.statistics.intervals import clopper_pearson
from robotics.plugins.arena.entered import short_title
from robotics.plugins.arena.kinds import load_plan
from robotics.plugins.tasks.driving import run_row
from robotics.plugins.tasks.outcome import TaskEntry, TaskOutcome

ROOT = Path(__file__).parents[4]
REFERENCE = ROOT / "docs" / "reference"
RANKING = pd.read_csv(REFERENCE / "arena-tasks.csv")
RUNS = pd.read_csv(REFERENCE / "arena-tasks-runs.csv")
LAWS = pd.read_csv(REFERENCE / "arena-tasks-laws.csv", index_col="law")["chosen"]
PAGE = (ROOT / "docs" / "explanation" / "arena-of-tasks.md").read_text(encoding="utf-8")
PLAN: Any = load_plan("tasks")


def test_the_files_are_of_the_packaged_arena():
    assert {*RANKING["law"]} == {*LAWS.index} == {*PLAN.laws}
    assert (RANKING["runs"] == PLAN.count("test")).all()
    assert len(RUNS) == len(PLAN.laws) * PLAN.count("test") + 2 * PLAN.count("test")


def test_all_laws_are_tuned_alike_and_one_keeps_its_numbers():
    assert not PLAN.untuned
    assert not PLAN.exceptions
    assert [law for law, chosen in LAWS.items() if law == chosen] == ["ppo-team"]
    assert "Twelve laws drive it with the numbers of their search, `ppo-team` with its own." in " ".join(PAGE.split())


def test_the_ranking_is_that_of_the_runs():
    own = {law: rows.assign(candidate=0) for law, rows in RUNS[RUNS["emergency_rule"] == "as it is"].groupby("law")}
    entries = tuple(TaskEntry(law, (), (), (0,), 0, None, own[law], own[law], None) for law in PLAN.laws)
    outcome = TaskOutcome(PLAN, entries)
    for knowledge, rows in RANKING.groupby("class"):
        assert [PLAN.laws[k] for k in outcome.among(str(knowledge))] == rows["law"].tolist()


def test_bounds_are_exact():
    for rank in RANKING.itertuples():
        rows = RUNS[(RUNS["law"] == rank.law) & (RUNS["emergency_rule"] == "as it is")]["caused"].dropna()
        found = clopper_pearson(int(rows.sum()), len(rows))
        told = (rank.caused_per_1000, rank.caused_per_1000_low, rank.caused_per_1000_high)
        assert told == pytest.approx(
            [1000 * float(v) for v in (found.value, found.low, found.high)], rel=1e-6, abs=1e-9
        )


def test_the_page_says_who_is_first_of_each_class_with_its_numbers():
    for _, rows in RANKING.groupby("class"):
        first = rows.iloc[0]
        ends = [f"{first[f'caused_per_1000{end}']:.3g}" for end in ("", "_low", "_high")]
        assert (
            f"{short_title(first['law'])} is first: it causes contacts in {ends[0]} of 1,000 ({ends[1]} to {ends[2]})"
            in PAGE
        )


@pytest.mark.parametrize(
    ("law", "place"),
    [
        ("fuzzy-team", 40),
        ("orca", 100),
        ("right-of-way", 300),
        pytest.param("mppi-ranges", 230, marks=pytest.mark.long),
    ],
)
def test_a_run_is_driven_again_with_the_same_result(law, place):
    row = run_row(PLAN.scenario("test", place), as_law(LAWS[law]))
    (kept,) = RUNS[
        (RUNS["law"] == law) & (RUNS["scenario"] == place) & (RUNS["emergency_rule"] == "as it is")
    ].itertuples()
    assert (row["caused"], row["deadlock"]) == (kept.caused, kept.deadlock)
    assert row["time"] == pytest.approx(kept.time, rel=1e-3)
