"""An arena of tasks that is held, stopped and gone on with; its runs, its emergency rule, and the command."""

import json
import shutil
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np
import pytest

from robotics.commands.application import main
from robotics.laws.catalogue import with_gains
from robotics.plugins.arena.kinds import parse_plan
from robotics.plugins.arena.plan import ArenaError
from robotics.plugins.stress.outcome import StressOutcome
from robotics.plugins.stress.tally import run_ensemble
from robotics.plugins.tasks.description import GUARD
from robotics.plugins.tasks.driving import drive, run_row
from robotics.plugins.tasks.families import TaskFamily
from robotics.plugins.tasks.report import ranking_table, results_table
from robotics.plugins.tasks.running import drive_tasks
from robotics.simulation.loop import record_run
from tests.robotics.laws.rules.arrayform.laws import InterpretedTeam
from tests.robotics.plugins.tasks.test_task_families import TEXT

PLAN: Any = parse_plan(TEXT, "small")


def contents(outcome):
    return [table(outcome).to_csv() for table in (results_table, ranking_table)]


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    folder = tmp_path_factory.mktemp("tasks")
    return drive_tasks(PLAN, folder), folder


class _StopError(Exception):
    pass


@pytest.mark.parametrize("stops", [("tuning", 1), ("choosing", 1), ("testing", 2)])
def test_what_was_stopped_goes_on_and_ends_with_the_same_numbers(whole, tmp_path, stops):
    step, after = stops

    def begin(text, total):
        done = [0]

        def advance():
            done[0] += 1
            if text.startswith(step) and done[0] == after:
                raise _StopError

        return advance

    with pytest.raises(_StopError):
        drive_tasks(PLAN, tmp_path, begin=begin)
    assert contents(drive_tasks(PLAN, tmp_path)) == contents(whole[0])


def test_a_damaged_piece_is_computed_again(whole, tmp_path):
    folder = tmp_path / "again"
    shutil.copytree(whole[1], folder)
    chunk = sorted((folder / "runs" / "testing").glob("chunk-*"))[0]
    chunk.write_bytes(chunk.read_bytes()[:-100])
    with pytest.warns(UserWarning, match="is damaged"):
        again = drive_tasks(PLAN, folder)
    assert contents(again) == contents(whole[0])


def test_another_arena_in_the_folder_is_refused(whole):
    with pytest.raises(ArenaError, match="another arena"):
        drive_tasks(replace(PLAN, contact=50.0), whole[1])


def test_every_law_has_the_same_budget_and_the_emergency_rule_is_not_tuned(whole):
    entries = {entry.law: entry for entry in whole[0].entries}
    assert all(len(entry.searches) == 1 for entry in entries.values())
    plan = PLAN.with_laws(["fuzzy-team", "orca"])
    names = [p.name for p in plan.space("fuzzy-team").parameters]
    assert GUARD not in names
    assert {"guard.braking", "look_ahead"} <= {*names}
    assert plan.budget("fuzzy-team") == plan.budget("orca") == 3


def test_all_laws_drive_the_same_scenarios(whole):
    first, second = (entry.runs for entry in whole[0].entries)
    assert first["scenario"].tolist() == second["scenario"].tolist() == list(range(7))
    rows = results_table(whole[0])
    drawn = ["robots", "model", "loss", "latency_s", "held_up_s", "nominal_s"]
    one, other = (rows[rows["law"] == law][drawn].to_numpy() for law in PLAN.laws)
    assert (one == other).all()


# Runs ----------------------------------------------------------------------------------------------------------------


def test_a_row_is_what_the_judge_and_a_recorded_run_say():
    scenario = TaskFamily(task="crossing", most=3, latency=0.3).scenario(7)
    law = PLAN.law("fuzzy-team")
    row = run_row(scenario, law)
    judged = run_ensemble(StressOutcome, scenario.setting, law, [7], scenario.faults, extra=scenario.extra)
    assert row["time"] == pytest.approx(judged.arrivals.max() / judged.nominal[0])
    assert row["caused"] == judged.caused.any()
    assert row["clearance_m"] == judged.clearance[0]
    run = record_run(scenario.setting, law, [7], name="fuzzy-team", faults=scenario.faults)
    last = round(judged.arrivals.max() / scenario.setting.period)
    shares = np.stack(
        [
            [
                np.argmin(np.hypot(table[0] - x, table[1] - y)) / (table.shape[1] - 1)
                for x, y in zip(run["x"][0, i, :last:20], run["y"][0, i, :last:20], strict=True)
            ]
            for i, table in enumerate(run.paths)
        ]
    )
    assert row["gap"] == pytest.approx(np.ptp(shares, axis=0).max(), abs=0.05)
    varied = abs(np.diff(run["w_demand"][0, :, : last // 2], axis=-1)).mean() / scenario.setting.period
    assert row["restlessness"] == pytest.approx(varied, rel=1.0)


def test_a_law_on_arrays_takes_part_as_one_with_an_equation():
    scenario = TaskFamily(task="crossing", most=3, latency=0.3, silent=1.0).scenario(8)
    law: Any = PLAN.law("fuzzy-team")
    compiled, arrays = run_row(scenario, law), run_row(scenario, InterpretedTeam.of(law))
    assert arrays == pytest.approx(compiled, rel=1e-6)


def test_whoever_cannot_drive_a_robot_is_said_to_have_refused():
    scenario = TaskFamily(task="course", most=3, models=("turtlebot3-burger",)).scenario(1)
    row = run_row(scenario, PLAN.law("hierarchy-literal"))
    assert row["refused"] == row["deadlock"] == 1
    assert np.isnan(row["caused"])


def test_it_is_the_emergency_rule_that_keeps_a_team_without_crash_rules_apart():
    law = PLAN.law("fuzzy-team:crash_rule_base=none,obstacles_rule_base=none")
    family = TaskFamily(task="crossing", most=3)
    scenarios = [(k, family.scenario(k)) for k in range(12)]
    guarded, bare = (drive(scenarios, made) for made in (law, with_gains(law, {GUARD: 0.0})))
    assert bare["caused"].sum() > guarded["caused"].sum() + 3


# The command ---------------------------------------------------------------------------------------------------------


def test_an_arena_of_tasks_from_a_file_to_a_page(tmp_path, capsys, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "mine.toml").write_text(TEXT.replace("count = 4", "count = 1").replace("count = 3", "count = 1"))
    assert main(["arena", "mine.toml", "--out", "out", "--workers", "1", "--json", "-q"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert {row["law"] for row in found["ranking"]} == {"stop-and-wait", "right-of-way"}
    assert 2 < len(found["answer"]) <= 10
    page = (tmp_path / found["page"]).read_text(encoding="utf-8")
    assert page.count("<figure") >= 1
    assert "everything beforehand" in page
    for name in ("results.csv", "ranking.csv", "laws.csv", "figures/tasks.svg"):
        assert (tmp_path / "out" / name).stat().st_size > 100
    before = (tmp_path / "out" / "results.csv").read_bytes()
    assert main(["arena", "mine.toml", "--out", "out", "--workers", "1", "-q"]) == 0
    assert (tmp_path / "out" / "results.csv").read_bytes() == before
    assert "own sensors\n  1 Stop and wait" in capsys.readouterr().out


def test_all_that_is_wrong_with_a_plan_of_tasks_is_told_at_once(tmp_path, capsys):
    file = tmp_path / "plan.toml"
    text = TEXT.replace("repeats = 1", 'repeats = "a"').replace('task = "course"', 'task = "curse"')
    file.write_text(text.replace("latency = 0.3", "latency = 30"), encoding="utf-8")
    assert main(["check", str(file), "--json"]) == 1
    found = {f["line"]: f["sentence"] for f in json.loads(capsys.readouterr().out)["findings"]}
    assert [*sorted(found)] == [7, 18, 20]
    assert all(word in found[line] for line, word in {7: "repeats must", 18: "latency must", 20: "task must"}.items())


def test_a_plan_is_drawn_and_takes_laws_and_rule_bases_of_ones_own(tmp_path, capsys, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert main(["copy", "crash.fis", "--to", "."]) == 0
    text = TEXT.replace('"stop-and-wait"', '"fuzzy-team:crash_rule_base=crash.fis"')
    (tmp_path / "plan.toml").write_text(text, encoding="utf-8")
    assert main(["check", "plan.toml"]) == 0
    plan = parse_plan(text, folder=tmp_path)
    one = partial(run_row, TaskFamily(task="crossing", most=3).scenario(3))
    assert one(plan.law(plan.laws[0])) == one(PLAN.law("fuzzy-team"))
    with pytest.raises(ArenaError, match=r"theirs\.fis"):
        parse_plan(text.replace("crash.fis", "theirs.fis"), folder=tmp_path)
