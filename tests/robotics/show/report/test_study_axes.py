"""Studies with conditions and axes: their table against runs by hand, what is refused, how plans are drawn."""

import json
import re
import tomllib
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pyarrow.parquet as pq
import pytest

import robotics
from robotics.commands.application import main
from robotics.show.report.chapter import Chapter
from robotics.show.report.keys import study_table
from robotics.show.report.plan import StudyError, load_study
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
    titles = pd.read_csv(folder / "a" / "columns.csv").set_index("column")
    described = {name: (title, unit) for name, title, unit in titles.fillna("").itertuples()}
    schema = pq.read_schema(folder / "s" / "results.parquet")
    assert described == {n: tuple(m.decode() for m in schema.field(n).metadata.values()) for n in schema.names}
    assert described["rms_cross_track_m"] == ("RMS cross-track error", "m")
    swept, studied = pd.read_parquet(folder / "s" / "results.parquet"), pd.read_csv(folder / "a" / "results.csv")
    pd.testing.assert_frame_equal(swept, studied, check_dtype=False, rtol=1e-15)


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


@pytest.mark.long
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
    for kind in ("plugins/arena/data/arenas/demo", "data/tunings/team"):
        packaged = Path(robotics.__file__).parent / f"{kind}.toml"
        assert main(["check", str(packaged)]) == 0
        assert f"{packaged.parent.name[:-1]}'s file, and is read as one" in capsys.readouterr().err


TUNED = """
scenarios = ["short.toml", "other.toml"]
controllers = ["lyapunov", "fuzzy"]
names = ["lyap", "rules"]
seeds = 2

[tune]
controllers = ["lyap"]
on = ["other.toml"]
evaluations = 14
runs = 2

[[claims]]
name = "Better"
metric = "rms_cross_track_m"
of = "lyap (tuned)"
against = "lyap"
less = true
"""


def test_a_tuned_controller_takes_part_beside_the_published_one(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The law is what `robotics tune` finds, and a study stopped while it tunes goes on."""
    from robotics.studies.tuning import tune as tuning

    (folder / "study.toml").write_text(TUNED, encoding="utf-8")
    plan = load_study(folder / "study.toml")
    assert list(plan.laws) == ["lyap", "rules", "lyap (tuned)"]
    costs, calls = tuning.mean_costs, [3]

    def stopping(*arguments: object, **options: object) -> object:
        calls[0] -= 1
        if calls[0] == 0:
            raise KeyboardInterrupt
        return costs(*arguments, **options)  # type: ignore[arg-type]

    monkeypatch.setattr(tuning, "mean_costs", stopping)
    with pytest.raises(KeyboardInterrupt):
        run_study(plan, folder / "out", report=False)
    for out in ("out", "whole"):
        run_study(plan, folder / out, report=False)
    for name in ("results.csv", "summary.csv", "claims.csv", "evidence.csv"):
        assert (folder / "out" / name).read_bytes() == (folder / "whole" / name).read_bytes()
    found = robotics.tune("lyapunov", [folder / "other.toml"], runs=2, evaluations=14)
    run = robotics.simulate(robotics.load_scenario(folder / "short.toml"), found.law, (0, 1))
    table = pd.read_csv(folder / "out" / "results.csv")
    mine = table[(table["scenario"] == "short") & (table["controller"] == "lyap (tuned)")]
    np.testing.assert_allclose(
        mine["rms_cross_track_m"], robotics.measure_all(run)["rms_cross_track_m"][:, 0], rtol=1e-12
    )


@pytest.mark.parametrize(
    ("before", "after", "says"),
    [
        ('["lyap"]\non', '["lyp"]\non', "did you mean 'lyap'"),
        ('["other.toml"]', '["others"]', "did you mean 'other'"),
        ("runs = 2", 'engine = "cmae"', "did you mean 'cmaes'"),
        ("runs = 2", 'space = "trackin"', "did you mean 'tracking'"),
        ('of = "lyap (tuned)"', 'of = "rules (tuned)"', "rules (tuned)"),
    ],
)
def test_what_is_wrong_with_a_tuning_is_told_with_its_line(folder: Path, before: str, after: str, says: str) -> None:
    assert before in TUNED
    (folder / "study.toml").write_text(TUNED.replace(before, after), encoding="utf-8")
    with pytest.raises(StudyError, match=re.escape(says)) as caught:
        load_study(folder / "study.toml")
    assert re.match(rf"{re.escape(str(folder / 'study.toml'))}:\d+: ", str(caught.value))


EVERY = """
title = "Everything"
author = "A. Author"
text = "What I ask."
scenarios = ["short.toml"]
controllers = ["lyapunov", "csm"]
names = ["mine", "rival"]
seeds = 2
first_seed = 3
metrics = ["max_cross_track_m"]
method = "random"
samples = 2
chunk = 50
seed = 4
questions = ["leads", "axes"]
chapters = "tests.robotics.show.report.test_study_axes:chapters"
save_runs = true
out = "results"

[conditions]
calm = {}
late = { latency = 0.05 }

[tune]
controllers = ["mine"]
on = ["short"]
space = "tracking"
evaluations = 3
runs = 1
seed = 2
engine = "random"

[[axes]]
key = "sensing.position_noise"
values = { low = 1e-4, high = 1e-2, scale = "log" }

[[axes]]
gain = "kx"
values = [1.0, 2.0]

[[claims]]
name = "Mine"
says = "It is better."
source = "A paper"
untested = "Much."

[[claims.parts]]
metric = "rms_cross_track_m"
on = ["short"]
of = "mine (tuned)"
against = ["rival"]
less = true
margin_percent = 1.0
mean = true
says = "It is much better."
"""


@contextmanager
def chapters(begin: Any, folder: Path, seed: int, draw: bool) -> Iterator[Any]:
    yield lambda: [Chapter("mine", f"From seed {seed}")]


@pytest.mark.long
def test_a_file_with_every_key_runs_and_says_all(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("robotics.show.report.plates.DPI", 30)
    assert {key.name for key in study_table().keys} == {*tomllib.loads(EVERY)}
    (folder / "every.toml").write_text(EVERY, encoding="utf-8")
    assert main(["study", str(folder / "every.toml"), "-q", "--workers", "2"]) == 0
    out = folder / "results"
    table = pd.read_csv(out / "results.csv")
    assert len(table) == 2 * 2 * 3 * 2
    assert set(table["controller"]) == {"mine", "rival", "mine (tuned)"}
    words = re.sub(r"<[^>]+>", "", (out / "report.html").read_text(encoding="utf-8"))
    for said in (
        "Everything",
        "A. Author",
        "What I ask.",
        "From seed 3",
        "It is much better.",
        "Every scenario was driven at 2 points of sensing.position_noise and kx",
        "Who leads where",
    ):
        assert said in words
    assert {f.name for f in (out / "runs").iterdir()} == {
        f"short_{condition}--{law}.npz" for condition in ("calm", "late") for law in ("mine", "rival", "mine_tuned_")
    }
