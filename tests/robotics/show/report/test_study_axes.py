"""Studies with conditions and axes: their table against runs by hand, what is refused, how plans are drawn."""

import json
import re
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

import robotics
from robotics.commands.application import main
from robotics.show.report.plan import load_study
from robotics.show.report.study import run_study
from tests.robotics.commands.test_sweep_command import SCENARIO, SPEC

STUDY = """
scenarios = ["short.toml", "other.toml"]
controllers = ["lyapunov", "csm"]
names = ["lyap", "slide"]
seeds = 3
first_seed = 5
questions = ["axes"]

[conditions]
calm = {}
noisy = { sensing.position_noise = 0.01 }

[[axes]]
key = "latency"
values = [0.0, 0.1]

[[axes]]
gain = "kx"
values = { low = 1.0, high = 4.0, count = 2, scale = "log" }

[[claims]]
name = "One"
metric = "rms_cross_track_m"
on = "other"
of = "lyap"
against = "slide"
less = true
"""


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    (tmp_path / "short.toml").write_text(SCENARIO, encoding="utf-8")
    (tmp_path / "other.toml").write_text(SCENARIO.replace("speed = 0.3", "speed = 0.2"), encoding="utf-8")
    (tmp_path / "study.toml").write_text(STUDY, encoding="utf-8")
    return tmp_path


def test_rows_are_those_of_runs_by_hand(folder: Path) -> None:
    study = run_study(load_study(folder / "study.toml"), folder / "out", report=False)
    table = pd.read_csv(folder / "out" / "results.csv")
    assert len(table) == 2 * 2 * 4 * 2 * 3
    assert list(table)[:7] == ["scenario", "condition", "point", "latency", "kx", "controller", "seed"]
    mine = table[
        (table["scenario"] == "other")
        & (table["condition"] == "noisy")
        & (table["point"] == 4)
        & (table["controller"] == "lyap")
        & (table["seed"] == 6)
    ].iloc[0]
    assert (mine["latency"], mine["kx"]) == (0.1, 4.0)
    text = "latency = 0.1\n" + SCENARIO.replace("speed = 0.3", "speed = 0.2").replace("0.002", "0.01")
    run = robotics.simulate(robotics.parse_scenario(text, "other"), "lyapunov:kx=4.0", (6,))
    for name, values in robotics.measure_all(run).items():
        np.testing.assert_allclose(mine[name], values[0, 0], rtol=1e-12)
    # A claim counts the runs at all points alike, under each condition
    assert [part.on for part in study.claims[0].parts] == ["other, calm", "other, noisy"]
    here = table[(table["scenario"] == "other") & (table["condition"] == "noisy")]
    wide = here.pivot_table(index=["point", "seed"], columns="controller", values="rms_cross_track_m")
    estimate = study.claims[0].parts[1].estimate
    assert estimate.value == pytest.approx((wide["lyap"] - wide["slide"]).mean(), rel=1e-9)
    assert estimate.runs == 12


def test_a_study_of_one_scenario_and_axes_has_the_numbers_of_the_sweep(folder: Path) -> None:
    (folder / "sweep.toml").write_text(SPEC, encoding="utf-8")
    axes = """
scenarios = ["short.toml"]
controllers = ["lyapunov", "fuzzy"]
seeds = 4
method = "random"
samples = 15
seed = 7
[[axes]]
key = "sensing.position_noise"
values = { low = 1e-4, high = 1e-2, scale = "log" }
[[axes]]
key = "latency"
values = { low = 0.0, high = 0.1, step = 0.05 }
"""
    (folder / "axes.toml").write_text(axes, encoding="utf-8")
    assert main(["sweep", str(folder / "sweep.toml"), "--out", str(folder / "s"), "-q"]) == 0
    assert main(["study", str(folder / "axes.toml"), "--out", str(folder / "a"), "-q", "--no-report"]) == 0
    swept, studied = pd.read_parquet(folder / "s" / "results.parquet"), pd.read_csv(folder / "a" / "results.csv")
    pd.testing.assert_frame_equal(swept, studied[list(swept)], check_dtype=False, rtol=1e-15)


BAD = {
    "no such key": ('key = "latency"', 'key = "latncy"', "latncy"),
    "two names": ('gain = "kx"', 'gain = "kx"\nkey = "duration"', 'needs key = "...", of the scenarios, or gain'),
    "no levels": ("values = [0.0, 0.1]", "values = []", "at least one value is needed"),
    "no count": ("count = 2, ", "", "a grid needs count = N"),
    "random": ("seeds = 3", 'seeds = 3\nmethod = "random"', "needs samples = N"),
    "a condition's key": ("sensing.position_noise = 0.01", "sensing.positon_noise = 0.01", "positon_noise"),
    "a condition's value": ("position_noise = 0.01", "position_noise = -1", "conditions: noisy: short: "),
    "twice": ('gain = "kx"', 'key = "latency"', "two columns 'latency'"),
}


@pytest.mark.parametrize("case", BAD)
def test_what_is_wrong_is_one_sentence_with_file_and_line(
    case: str, folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    before, after, says = BAD[case]
    text = (folder / "study.toml").read_text(encoding="utf-8")
    assert before in text
    (folder / "study.toml").write_text(text.replace(before, after), encoding="utf-8")
    assert main(["study", str(folder / "study.toml"), "--out", str(folder / "o"), "-q"]) == 2
    said = capsys.readouterr().err.splitlines()[-1]
    assert re.match(rf"robotics: {re.escape(str(folder / 'study.toml'))}:\d+: ", said)
    assert says in said


def test_check_draws_plans_of_every_kind_and_notes_the_new_form(
    folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file = str(folder / "study.toml")
    assert main(["check", file]) == 0
    drawn = capsys.readouterr()
    for words in (
        "2 scenarios",
        "× 2 conditions   calm, noisy",
        "× 4 points       grid: latency 0.0, 0.1 × kx 1.0, 4.0",
        "× 2 controllers  lyap, slide",
        "= 96 runs in 4 pieces, 96 rows",
        "1 claim: One",
        "1 question: axes",
    ):
        assert words in drawn.out
    assert drawn.err == ""
    (folder / "sweep.toml").write_text(SPEC, encoding="utf-8")
    assert main(["check", str(folder / "sweep.toml"), "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["kind"] == "sweep"
    assert main(["study", str(folder / "sweep.toml"), "--out", str(folder / "s"), "-q"]) == 0
    told = capsys.readouterr()
    assert "is a sweep's file, and is read as one; its new form: " in told.err
    assert (folder / "s" / "results.parquet").exists()
    for kind in ("arenas/demo", "tunings/team"):
        packaged = Path(robotics.__file__).parent / "data" / f"{kind}.toml"
        assert main(["check", str(packaged)]) == 0
        assert f"{kind.split('s/')[0]}'s file, and is read as one" in capsys.readouterr().err
