"""An arena that is held, stopped and gone on with; and its numbers, computed again by other means."""

import numpy as np
import pytest

import robotics
from robotics.commands.filekinds import template_text
from robotics.plugins.arena.answer import answer
from robotics.plugins.arena.changes import CHANGES
from robotics.plugins.arena.description import parse_arena
from robotics.plugins.arena.plan import ArenaError
from robotics.plugins.arena.report import pairs_table, results_table, summary_table, write_laws
from robotics.plugins.arena.running import drive_arena

TEXT = """
laws = ["lyapunov", "pid"]
reference = "lyapunov"
evaluations = 12
runs = 1
repeats = 1
choosing_runs = 2
testing_runs = 6
robustness_runs = 3
[[tune]]
path = "sine"
duration = 12.5
[[choose]]
path = "sine"
duration = 12.5
[[test]]
path = "circle"
duration = 12.5
[[test]]
path = "eight"
duration = 12.5
"""
ARENA = parse_arena(TEXT, "small")
TABLES = (results_table, summary_table, pairs_table)


def contents(outcome):
    return [table(outcome).to_csv() for table in TABLES]


@pytest.fixture(scope="module", autouse=True)
def timed_once():
    """What a law takes is compared with nothing here: one try says it."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("robotics.plugins.arena.computing.REPEATS", 1)
        yield


@pytest.fixture(scope="module")
def whole(timed_once, tmp_path_factory):
    folder = tmp_path_factory.mktemp("arena")
    return drive_arena(ARENA, folder), folder


class _StopError(Exception):
    pass


@pytest.mark.parametrize(
    "after", [1, pytest.param(3, marks=pytest.mark.long), pytest.param(5, marks=pytest.mark.long), 8]
)
def test_a_stopped_arena_goes_on_to_the_same_numbers(whole, tmp_path, after):
    done = 0

    def begin(description, total):
        def advance(description=None):
            nonlocal done
            done += 1
            if done == after:
                raise _StopError

        return advance

    with pytest.raises(_StopError):
        drive_arena(ARENA, tmp_path, begin=begin)
    assert contents(drive_arena(ARENA, tmp_path)) == contents(whole[0])


def test_what_is_damaged_is_driven_again(whole):
    outcome, folder = whole
    file = folder / "runs" / "testing" / "chunk-000001.parquet"
    content = file.read_bytes()
    file.write_bytes(content[: len(content) // 2])
    with pytest.warns(UserWarning, match=r"chunk-000001\.parquet is damaged, or is not of this arena; it is computed"):
        assert contents(drive_arena(ARENA, folder)) == contents(outcome)
    assert file.read_bytes() == content


def test_another_arena_in_the_same_folder_is_refused(whole):
    with pytest.raises(ArenaError, match="holds another arena: laws"):
        drive_arena(ARENA.with_laws(["lyapunov"]), whole[1])


def test_its_runs_are_those_of_simulate(whole):
    outcome, _ = whole
    rows = results_table(outcome).query("law == 'pid' and gains == 'published'")
    scenario = ARENA.scenarios("test")[1]
    row = rows[rows["scenario"] == scenario.name].iloc[2]
    found = robotics.measure_all(robotics.simulate(scenario, "pid", [int(row["seed"])]))
    for name in ARENA.made_cost.metrics:
        assert found[name][0, 0] == row[name]
    assert int(row["seed"]) == 3_000_002


def test_the_chosen_law_is_the_best_on_the_choosing_runs_and_is_written_down(whole):
    outcome, folder = whole
    specifications = write_laws(outcome, folder)
    scenario, seeds = ARENA.scenarios("choose")[0], ARENA.seeds("choose")
    metrics = list(ARENA.made_cost.metrics)
    for entry, specification in zip(outcome.entries, specifications, strict=True):
        laws = [entry.law, specification]
        runs = robotics.simulate_many(scenario, laws, seeds, keep="metrics", metrics=metrics)
        before, after = ARENA.made_cost.of(runs.metrics, runs.stopped).mean(axis=1)
        assert after <= before
        assert after == pytest.approx(min(entry.choosing.mean(axis=(1, 2))[[0, *entry.looked_at[:, -1]]]))
        if entry.by:
            assert (folder / "tuned" / entry.law / "result.json").exists()


def test_changes_are_driven_on_the_seeds_of_the_test(whole):
    outcome, _ = whole
    for change in CHANGES:
        assert set(outcome.entries[0].changed[change]["seed"]) == {3_000_000, 3_000_001, 3_000_002}
    assert len(outcome.entries[0].changed["noise ×2"]) == 2 * 3
    assert np.isfinite(outcome.robustness.value).all()


def test_a_law_of_which_nothing_moves_takes_part_as_published(tmp_path):
    (tmp_path / "mylaw.py").write_text(template_text("law"), encoding="utf-8")
    text = TEXT.replace('"pid"', '"mylaw.py:MyLaw"').replace("evaluations = 12", "evaluations = 3")
    arena, told = parse_arena(text, "small", folder=tmp_path), list[str]()
    outcome = drive_arena(arena, tmp_path / "out", clocked=False, announce=told.append)
    assert told == [
        "mylaw.py:MyLaw: nothing of it moves, of gains, memberships, consequents; it takes part as published"
    ]
    entry = outcome.entries[1]
    assert (entry.parameters, entry.chosen, entry.by, entry.searches, arena.budget(entry.law)) == ((), 0, "", (), 0)
    assert (outcome.published[1] == outcome.tuned[1]).all()
    assert (outcome.curves.value[1] == entry.choosing.mean()).all()
    assert outcome.by_engine[0, 1] == outcome.by_engine[1, 1] == pytest.approx(entry.choosing.mean())
    row = summary_table(outcome).set_index("law").loc[entry.law]
    assert (row["numbers_tuned"], row["evaluations"], row["chosen"]) == (0, 0, "published")
    assert "of which nothing moves, took part as published" in answer(outcome)[-1]
    assert write_laws(outcome, tmp_path / "out")[1] == entry.law
    with pytest.raises(ArenaError, match="laws: none has anything that moves"):
        arena.with_laws([entry.law])


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ('"pid"', '"pdi"', r":2: laws: unknown controller 'pdi'; did you mean 'pid'"),
        ('reference = "lyapunov"', 'reference = "nmpc"', r":3: unknown law of the arena 'nmpc'"),
        ("evaluations = 12", "evaluations = 0", r":4: evaluations must be a whole number >= 1"),
        ('path = "circle"', 'path = "circl"', r":17: path must be one of 'sine', 'winding', 'circle'"),
        ("repeats = 1", 'engines = ["cma"]', r":6: unknown engine 'cma'; did you mean 'cmaes'"),
        ("repeats = 1", "exceptions = { pid = 0 }", r":6: the evaluations of pid must be a whole number"),
        ("repeats = 1", 'like = "defaul"', r"like: unknown arena 'defaul'; did you mean 'default'"),
    ],
)
def test_what_is_wrong_with_a_file_is_said_with_its_line(old, new, message):
    with pytest.raises(ArenaError, match=message):
        parse_arena(TEXT.replace(old, new), file="mine.toml")
