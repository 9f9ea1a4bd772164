"""The command line ``robotics``, end to end."""

import json
import os
import signal
import subprocess
import sys
import time

import numpy as np
import pandas as pd
import pytest
import typer

from robotics.commands.application import app, main
from robotics.commands.compare import split_controllers
from robotics.measures.tracking import METRICS
from robotics.show.report.wording import digits
from robotics.simulation.run import load_run
from robotics.simulation.scenario.reading import scenario_names
from robotics.studies.comparison import DEFAULT_CONTROLLERS

TINY = """
title = "short"
duration = 2.0

[sensing]
posture = "pose"
position_noise = 0.002

[[robots]]
start = [0.0, 0.0, 0.0]
path = { shape = "line", start = [0.0, 0.0], end = [2.0, 0.0] }
timing = { speed = 0.3 }
"""


@pytest.fixture
def tiny(tmp_path):
    path = tmp_path / "tiny.toml"
    path.write_text(TINY, encoding="utf-8")
    return str(path)


def test_list_names_everything(capsys):
    assert main(["list"]) == 0
    out = capsys.readouterr().out
    for name in (*scenario_names(), *(name for names in DEFAULT_CONTROLLERS.values() for name in names)):
        assert name in out
    assert main(["list", "--json"]) == 0
    listed = json.loads(capsys.readouterr().out)
    assert [s["name"] for s in listed["scenarios"]] == scenario_names()
    assert {c["name"]: c["gains"] for c in listed["controllers"]}["csm"]["k"] == 1.0


def test_run_saves_what_it_prints(tiny, tmp_path, capsys):
    files = [tmp_path / "run.npz", tmp_path / "run.csv", tmp_path / "run.png"]
    options = [
        "--save",
        str(files[0]),
        "--table",
        str(files[1]),
        "--plot",
        str(files[2]),
        "--seed",
        "3",
        "--seeds",
        "2",
    ]
    assert main(["run", tiny, "-c", "lyapunov:ky=4", *options, "--json"]) == 0
    printed = json.loads(capsys.readouterr().out)
    assert printed["seeds"] == [3, 4]
    run = load_run(files[0])
    assert run.seeds == (3, 4)
    assert set(printed["metrics"]) == set(METRICS)
    for name, metric in METRICS.items():  # a saved run lies differently in memory: sums end in other last digits
        np.testing.assert_allclose(printed["metrics"][name], metric.measure(run)[:, 0], rtol=1e-13)
    frame = pd.read_csv(files[1])
    assert len(frame) == 2 * 41
    np.testing.assert_array_equal(frame["x"][frame["seed"] == 4], run["x"][1, 0])
    assert files[2].read_bytes().startswith(b"\x89PNG")


@pytest.mark.long
def test_compare_twice_is_the_same_to_the_byte(tiny, tmp_path, capsys):
    for out in ("a", "b"):
        command = ["compare", tiny, "--controllers", "fuzzy,csm:k=0.3,realisation=velocity", "--seeds", "3", "-q"]
        assert main([*command, "--out", str(tmp_path / out)]) == 0
        assert capsys.readouterr().err == ""
    for name in ("results.csv", "summary.csv", "configuration.json", "report.html"):
        assert (tmp_path / "a" / name).read_bytes() == (tmp_path / "b" / name).read_bytes(), name
    table = pd.read_csv(tmp_path / "a" / "results.csv")
    assert list(table["controller"].unique()) == ["fuzzy", "csm:k=0.3,realisation=velocity"]
    assert len(table) == 6
    summary = pd.read_csv(tmp_path / "a" / "summary.csv")
    one = summary[(summary["controller"] == "fuzzy") & (summary["metric"] == "rms_cross_track_m")].iloc[0]
    values = table[table["controller"] == "fuzzy"]["rms_cross_track_m"].to_numpy()
    assert one["mean"] == pytest.approx(values.mean(), rel=1e-14)
    # Student's t for 3 values: 4.3027 s/√n
    assert one["high"] - one["mean"] == pytest.approx(4.302652729749464 * values.std(ddof=1) / 3**0.5, rel=1e-9)


def test_compare_json_is_one_object_and_nothing_else(tiny, tmp_path, capsys):
    command = ["compare", tiny, "--controllers", "esm", "--seeds", "1", "--no-report", "--json"]
    assert main([*command, "--out", str(tmp_path / "o")]) == 0
    printed = json.loads(capsys.readouterr().out)
    assert {row["metric"] for row in printed["summary"]} == set(METRICS)
    assert printed["files"] == ["columns.csv", "configuration.json", "results.csv", "summary.csv"]
    assert printed["claims"] == []


@pytest.mark.parametrize("columns", [200, 70, 30])
def test_a_comparison_cuts_no_number_and_no_word_however_narrow_the_terminal(
    columns, tiny, tmp_path, capsys, monkeypatch
):
    monkeypatch.setattr(sys.stdout, "isatty", lambda: True, raising=False)
    monkeypatch.setenv("COLUMNS", str(columns))
    command = ["compare", tiny, "--controllers", "fuzzy,esm:k=0.5", "--seeds", "3", "--no-report", "-q"]
    assert main([*command, "--out", str(tmp_path / "o")]) == 0
    printed = capsys.readouterr().out
    table = printed.partition("mean over 3 seeds ±")[0]
    assert "±0" not in table
    assert "± 0.0000" not in table
    assert "…" not in table
    assert ("━" in table) == (columns == 200)
    values = pd.read_csv(tmp_path / "o" / "results.csv")["rms_cross_track_under_way_m"].to_numpy(dtype=float)
    for of_law in values.reshape(2, 3):
        half = 4.302652729749464 * of_law.std(ddof=1) / 3**0.5  # Student's t for 3 values
        number, interval = digits(1e3 * of_law.mean(), 1e3 * half)
        assert 1e-6 < half < 1e-3  # which four decimals of a metre would hide
        assert f"{number} ± {interval}" in table
    for word in ("cross-track", "variation", "[N² m²]", "Exponential SM (k=0.5)", "[mm]"):
        assert word in table


@pytest.mark.parametrize(
    ("arguments", "fragments"),
    [
        (["run", "referense"], ["unknown scenario 'referense'", "did you mean 'reference'"]),
        (["run", "reference", "-c", "lyapnov"], ["unknown controller 'lyapnov'", "did you mean 'lyapunov'"]),
        (["run", "reference", "-c", "esm:kk=1"], ["controller 'esm'", "unknown gain 'kk'", "did you mean 'k'"]),
        (["run", "reference", "-c", "esm:k=-1"], ["k must be a finite number", "> 0", "got -1"]),
        (["run", "reference", "-c", "esm:k=nan"], ["k must be a finite number", "got nan"]),
        (["run", "reference", "-c", "esm:k=inf"], ["k must be a finite number", "got inf"]),
        (["run", "reference", "-c", "esm:k"], ["gain 'k' needs a value"]),
        (["run", "reference", "-c", "esm:realisation=volts"], ["one of 'torque', 'velocity'", "got 'volts'"]),
        (["run", "reference", "-c", "fuzzy:rule_base=traking"], ["unknown rule base 'traking'", "'tracking'"]),
        (["run", "reference", "--plot", "a.bmp"], ["a.bmp", ".png, .pdf or .svg"]),
        (["run", "reference", "--save", "a.csv"], ["a.csv", ".npz"]),
        (["run", "nowhere/none.toml"], ["none.toml", "cannot be read"]),
        (["run", "reference", "--seed", "-1"], ["--seed"]),
        (["compare", "reference", "reference"], ["'reference' is given twice"]),
        (["compare", "--controllers", ","], ["at least one name"]),
        (["compare", "lyapunov-sine,nosuch", "-c", "fuzzy"], ["unknown scenario 'nosuch'"]),
        (["compare", "lyapunov-sine,lyapunov-sine"], ["'lyapunov-sine' is given twice"]),
        (["compare", "--seeds", "0"], ["--seeds"]),
        (["compare", "reference", "--out", "/proc/none/x"], ["/proc/none"]),
        (["fly"], ["fly"]),
    ],
)
def test_bad_input_is_one_message_and_exit_code_2(arguments, fragments, capsys):
    assert main([*arguments, "-q"] if arguments != ["fly"] else arguments) == 2
    printed = capsys.readouterr()
    assert printed.out == ""
    assert "Traceback" not in printed.err
    assert len(printed.err.strip().splitlines()) <= 2
    for fragment in fragments:
        assert fragment in printed.err


def test_a_bad_scenario_file_is_named_with_its_line(tiny, tmp_path, capsys):
    bad = tmp_path / "bad.toml"
    bad.write_text(TINY.replace("position_noise", "position_nois"), encoding="utf-8")
    assert main(["compare", str(bad), "-q"]) == 2
    assert f"{bad}:7: unknown key 'position_nois'; did you mean 'position_noise'" in capsys.readouterr().err


def test_an_unwritable_folder_is_said(tiny, tmp_path, capsys):
    (tmp_path / "file").write_text("", encoding="utf-8")
    assert main(["compare", tiny, "--out", str(tmp_path / "file"), "-q"]) == 2
    assert str(tmp_path / "file") in capsys.readouterr().err


@pytest.mark.parametrize(
    "command",
    [
        "run lyapunov-sine --plot {}/x.png",
        "run lyapunov-sine --save {}/x.npz",
        "run lyapunov-sine --table {}/x.csv",
        "check lyapunov-sine -o {}/x.svg",
        "plot none.npz -o {}/x.pdf",
        "team -o {}/x.toml",
    ],
)
def test_a_place_for_no_file_is_refused_before_the_work(command, tmp_path, capsys, no_runs):
    nowhere = tmp_path / "nowhere"
    assert main(command.format(nowhere).split()) == 2
    error = capsys.readouterr().err
    assert f"{nowhere}/x" in error
    assert f"there is no folder {str(nowhere)!r} to write into" in error


def test_a_diverging_controller_is_named_and_its_history_kept(tmp_path, capsys):
    command = ["compare", "lyapunov-sine", "--controllers", "lyapunov:signs=literal,lyapunov", "--seeds", "2", "-q"]
    assert main([*command, "--no-report", "--out", str(tmp_path)]) == 2
    message = capsys.readouterr().err
    assert "'lyapunov:signs=literal' diverged on 'lyapunov-sine'" in message
    table = pd.read_csv(tmp_path / "results.csv")
    assert table["diverged"].tolist() == [True, True, False, False]
    assert table["mean_error_norm"].notna().all()


@pytest.mark.long
def test_interrupted_comparison_keeps_its_rows(tmp_path):
    command = [
        sys.executable,
        "-m",
        "robotics",
        "compare",
        "--seeds",
        "20",
        "--no-report",
        "--out",
        str(tmp_path),
        "-q",
    ]
    process = subprocess.Popen(command, stderr=subprocess.PIPE, text=True, env={**os.environ, "PYTHONUNBUFFERED": "1"})
    results = tmp_path / "results.csv"
    deadline = time.monotonic() + 120
    while not results.exists() and process.poll() is None and time.monotonic() < deadline:
        time.sleep(0.02)
    process.send_signal(signal.SIGINT)
    _, error = process.communicate(timeout=120)
    assert process.returncode == 130, error
    assert "Traceback" not in error
    rows = len(pd.read_csv(results))
    assert f"{rows} of {20 * 6 * len(scenario_names('tracking'))} rows are in {results}" in error
    assert rows % 20 == 0


def leaves(command, words=()):
    """The words of every command below ``command``, and the command."""
    below = getattr(command, "commands", {})
    if not below:
        return [pytest.param(words, command, id=" ".join(words))]
    return [leaf for name, one in below.items() for leaf in leaves(one, (*words, name))]


@pytest.mark.parametrize(("words", "command"), leaves(typer.main.get_command(app)))
def test_help_has_a_sentence_for_every_option(words, command):
    assert main([*words, "--help"]) == 0
    said = {parameter.name: getattr(parameter, "help", None) or "" for parameter in command.params}
    for name, text in said.items():
        assert len(text.split()) >= 3, name
        assert text[0].isupper() or ":" in text or text.startswith("well-posed:"), text
        assert not text.startswith(("Of ", "How many")), text


@pytest.mark.parametrize(("short", "long"), [("-c", "--controllers"), ("-o", "--out"), ("-q", "--quiet")])
def test_a_long_option_has_its_short_name_in_every_command(short, long):
    found = 0
    for words, command in (leaf.values for leaf in leaves(typer.main.get_command(app))):
        for parameter in command.params:
            if long in parameter.opts:
                assert short in parameter.opts, words
                found += 1
    assert found


def test_splitting_controllers():
    assert split_controllers("fuzzy, csm:k=0.3,lam=5,esm") == ["fuzzy", "csm:k=0.3,lam=5", "esm"]


def test_a_law_that_commands_not_a_number_leaves_no_numbers_that_look_like_success(tmp_path, capsys):
    law = tmp_path / "mine.py"
    law.write_text(
        "from dataclasses import dataclass\nimport numpy as np\nfrom robotics import Command, Law\n\n"
        "@dataclass(frozen=True, kw_only=True)\nclass Bad(Law):\n"
        "    def control(self, seen, memory, dt):\n"
        "        nan = np.full_like(seen.x, np.nan)\n        return Command(nan, nan, nan, nan), memory\n"
    )
    assert main(["run", "lyapunov-sine", "--law", f"{law}:Bad", "-q"]) == 2
    told = capsys.readouterr()
    assert "stopped at t = 0.00 s" in told.err
    assert {line.split()[1] for line in told.out.splitlines()[1:]} == {"-", "∞"}
    compared = ["compare", "lyapunov-sine", "--controllers", "lyapunov", "--law", f"{law}:Bad", "--seeds", "2", "-q"]
    assert main([*compared, "--no-report", "--out", str(tmp_path / "o")]) == 2
    (row,) = (line for line in capsys.readouterr().out.splitlines() if line.startswith("│ Bad"))
    assert {cell.strip() for cell in row.split("│")[2:-1]} == {"no sample", "never"}
