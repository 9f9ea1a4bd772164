"""The command ``robotics tune``: its files, resuming to the same bytes, and before against after on unseen runs."""

import json
import random
import time
from contextlib import suppress
from dataclasses import replace
from pathlib import Path

import numpy as np
import psutil
import pytest

import robotics
from robotics.commands.application import main
from robotics.laws.catalogue import located, make_controller
from robotics.measures.statistics.intervals import Interval
from robotics.plugins.tuning.unseen import Unseen, compared
from robotics.studies.tuning.cost import Cost, costs_of
from robotics.studies.tuning.tune import TESTING, TUNING, tune
from tests.robotics.commands.warmstart import Warm, wait_until
from tests.robotics.studies.tuning.test_tune import QUICK, SINE

SCENARIO = """
duration = 3.0

[sensing]
posture = "pose"
position_noise = 0.003
heading_noise = 0.003

[[robots]]
start = [0.0, 0.05, 0.0]
path = { shape = "sine", amplitude = 0.3, wavenumber = 1.0, x_end = 4.0 }
timing = { speed = 0.3 }
"""


def test_before_and_after_are_compared_on_runs_that_no_search_has_seen():
    found = tune("lyapunov", [SINE], runs=4, evaluations=40, cost=QUICK)
    circle = replace(robotics.load_scenario("lyapunov-circle"), duration=4.0, sensing=SINE.sensing)
    same, other = compared(found, [SINE], [circle], 20)
    costs = costs_of(QUICK, [SINE], [found.space.law, found.law], range(TESTING, TESTING + 20)).sum(axis=-1)
    assert same.costs.tolist() == costs.tolist()
    assert same.ratio.value == pytest.approx(costs[1].mean() / costs[0].mean())
    assert same.ratio.low < same.ratio.value < same.ratio.high
    assert same.better == (same.ratio.high < 1)
    assert "20 unseen seeds of the same scenarios" in same.sentence()
    assert "unseen scenarios" in other.sentence()
    assert ("less" in same.sentence()) == same.better or "not shown" in same.sentence()


@pytest.mark.parametrize(
    ("after", "ends", "said"),
    [
        (1.0, (1.0, 1.0), "every run costs the same"),
        (1.001, (0.998, 1.004), "not shown to be better: between 0 % more and 0 % less at 95 %"),
        (1.01, (0.97, 1.05), "not shown to be better: between 5 % more and 3 % less at 95 %"),
        (0.9, (0.88, 0.92), "10 % less, 95 % interval 8 to 12 %"),
    ],
)
def test_what_became_of_a_law_is_told_in_numbers_that_people_write(after, ends, said):
    costs = np.stack([np.ones((1, 4)), np.full((1, 4), after)]) * np.linspace(0.9, 1.1, 4)
    told = Unseen(("sine",), True, costs, Interval(after, *ends)).sentence()
    assert told.endswith(f"; {said}")
    assert "-" not in told


# The command ----------------------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def scenario(tmp_path_factory):
    file = tmp_path_factory.mktemp("tune") / "short.toml"
    file.write_text(SCENARIO, encoding="utf-8")
    return str(file)


def test_the_command_tunes_a_rule_base_and_its_result_can_be_driven(scenario, tmp_path, capsys):
    out = tmp_path / "tuned"
    told = [scenario, "--unseen", "lyapunov-circle", "--seeds", "4", "--evaluations", "150"]
    assert main(["tune", "fuzzy", *told, "--check-seeds", "10", "-o", str(out), "--json", "-q"]) == 0
    said = json.loads(capsys.readouterr().out)
    assert said["after"] < said["before"]
    assert said["evaluations"] == 150
    assert said["seconds"] > 0
    assert "w.Big negative+Big positive" in said["held"]
    assert [row["tuned_on"] for row in said["unseen"]] == [True, False]
    law = make_controller(said["result"])
    cost = costs_of(Cost(), [robotics.load_scenario(scenario)], [law], range(TUNING, TUNING + 4)).sum(axis=-1).mean()
    assert cost == pytest.approx(said["after"], rel=1e-12)
    head = (out / "tracking.fis").read_text().splitlines()[:6]
    assert "seeds 1000000 to 1000003" in head[1]
    assert "150 evaluations by cmaes, seed 1" in head[4]
    about = json.loads((out / "result.json").read_text())
    assert about["provenance"]["cost"]["failed"] == 100
    assert located(about["specification"], out) == said["result"]
    assert {p.name for p in out.iterdir()} >= {"history.csv", "search.json", "result.json", "evaluations.png"}
    assert main(["run", scenario, "-c", said["result"]]) == 0


def test_the_front_is_a_table_and_a_picture(scenario, tmp_path, capsys):
    told = [scenario, "--seeds", "2", "--evaluations", "120", "--check-seeds", "0", "--pareto"]
    assert main(["tune", "lyapunov", *told, "-o", str(tmp_path / "front"), "-q"]) == 0
    assert "laws on the front" in capsys.readouterr().out
    rows = (tmp_path / "front" / "front.csv").read_text().splitlines()
    assert rows[0] == "evaluation,cost,precision,effort,kx,ky,kpsi,catch_up"
    front = np.array([[float(v) for v in row.split(",")] for row in rows[1:]])
    assert len(front) >= 2
    assert (np.diff(front[:, 2]) > 0).all()
    assert (np.diff(front[:, 3]) < 0).all()
    assert (tmp_path / "front" / "front.png").stat().st_size > 5000


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["tune", "fuzy", "lyapunov-sine"], "did you mean 'fuzzy'"),
        (["tune", "fuzzy", "lyapunov-sin"], "did you mean 'lyapunov-sine'"),
        (["tune", "fuzzy"], "Missing argument"),
        (["tune", "fuzzy", "lyapunov-sine", "--engine", "cma"], "cmaes"),
        (["tune", "fuzzy", "lyapunov-sine", "--space", "gone.toml"], "gone.toml: cannot be read"),
        (["tune", "concentric", "concentric-circles"], "unknown controller"),
    ],
)
def test_a_command_that_cannot_be_is_one_sentence(arguments, message, capsys, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert main([*arguments, "-q"]) == 2
    said = capsys.readouterr().err
    assert message in said
    assert "Traceback" not in said


def test_another_search_in_the_same_folder_is_refused(scenario, tmp_path, capsys):
    told = ["tune", "lyapunov", scenario, "--seeds", "1", "--check-seeds", "0", "-o", str(tmp_path), "-q"]
    assert main([*told, "--evaluations", "10"]) == 0
    assert main([*told, "--evaluations", "10", "--seed", "2"]) == 2
    assert "holds another search: seed changed" in capsys.readouterr().err
    assert main([*told, "--evaluations", "10", "--seed", "2", "--fresh"]) == 0


def folder_bytes(folder: Path):
    return {p.name: p.read_bytes() for p in sorted(folder.iterdir()) if p.name != ".lock"}


@pytest.mark.long
def test_a_search_that_is_killed_at_random_moments_ends_with_the_same_bytes(scenario, tmp_path):
    told = ["tune", "fuzzy", scenario, "--seeds", "2", "--evaluations", "1200", "--check-seeds", "0", "-q"]
    assert main([*told, "-o", str(tmp_path / "whole")]) == 0
    wait, killed = random.Random(1), 0
    history = tmp_path / "killed" / "history.csv"
    warm = Warm(tmp_path, scenario)
    with warm.process:
        for _ in range(3):
            before = history.stat().st_mtime_ns if history.exists() else 0
            child = warm.start([*told, "-o", str(tmp_path / "killed")])
            wait_until(lambda before=before: history.exists() and history.stat().st_mtime_ns > before, child.is_running)
            time.sleep(wait.uniform(0, 0.1))
            with suppress(psutil.NoSuchProcess):
                child.kill()
            killed += warm.end()[0] != 0
        warm.process.stdin.close()
    assert killed > 1
    assert main([*told, "-o", str(tmp_path / "killed")]) == 0
    assert folder_bytes(tmp_path / "killed") == folder_bytes(tmp_path / "whole")


def test_a_search_that_was_killed_goes_on(scenario, tmp_path):
    """The same by the pieces that a killed process leaves: a history that ends anywhere."""
    told = [
        "tune",
        "lyapunov",
        scenario,
        "--seeds",
        "2",
        "--evaluations",
        "60",
        "--check-seeds",
        "0",
        "-q",
    ]
    assert main([*told, "-o", str(tmp_path / "whole")]) == 0
    assert main([*told, "-o", str(tmp_path / "again")]) == 0
    rows = (tmp_path / "again" / "history.csv").read_text().splitlines(keepends=True)
    for kept in (9, 25, 41):  # the header, the start, and whole generations of eight
        (tmp_path / "again" / "history.csv").write_text("".join(rows[:kept]) if kept > 9 else rows[0] + rows[1])
        (tmp_path / "again" / "result.json").unlink()
        assert main([*told, "-o", str(tmp_path / "again")]) == 0
        assert folder_bytes(tmp_path / "again") == folder_bytes(tmp_path / "whole")
