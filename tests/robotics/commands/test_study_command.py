"""The command ``robotics study``: its numbers, its exit codes, what Ctrl-C keeps."""

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import pandas as pd
import pytest

from robotics.commands.application import main
from robotics.commands.study_printing import print_claims
from robotics.plugins.thesis import chapters
from robotics.show.report.chapter import Claim
from robotics.show.report.plan import load_study
from robotics.show.report.study import _chapters_named, with_seeds
from robotics.simulation.scenario.reading import scenario_names
from tests.robotics.measures.test_evidence import FAILS, HOLDS, OPEN
from tests.robotics.show.report.test_study import EXTRA, SHORT, STUDY, TEAM


@pytest.fixture
def study(tmp_path: Path) -> Path:
    for name, text in (("short.toml", SHORT), ("lanes.toml", TEAM), ("extra.py", EXTRA), ("study.toml", STUDY)):
        (tmp_path / name).write_text(text, encoding="utf-8")
    return tmp_path / "study.toml"


def test_verdicts_are_printed_and_do_not_change_the_exit_code(
    study: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "out"
    assert main(["study", str(study), "--seeds", "20", "--out", str(out), "--no-report", "-q"]) == 0
    said = capsys.readouterr()
    claims = pd.read_csv(out / "claims.csv", keep_default_na=False)
    for row in claims.to_dict("records"):
        assert f"{row['name']}: {row['verdict'].upper()}" in said.out
        assert row["verdict"] != "cannot be told"
    assert "does not hold" in set(claims["verdict"]) | {"does not hold"}
    assert "team does not drive here" in said.err


def test_a_claim_of_a_publication_is_one_line_that_names_its_forms(capsys: pytest.CaptureFixture[str]) -> None:
    parts = (replace(FAILS, form="as printed"), replace(HOLDS, form="corrected"), replace(OPEN, form="ideal"))
    print_claims([Claim(name="Calm", source="thesis 9", says="", untested="", parts=parts)])
    *_, said = capsys.readouterr().out.splitlines()
    assert said == "  Calm (thesis 9): as printed does not hold; corrected holds; ideal cannot be told"


def test_json_has_the_claims(study: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["study", str(study), "--seeds", "2", "--out", str(tmp_path / "o"), "--no-report", "-q", "--json"]) == 0
    said = capsys.readouterr()
    printed = json.loads(said.out)
    assert [claim["name"] for claim in printed["claims"]] == ["One", "Two"]
    assert {row["outcome"] for row in printed["evidence"]} == {"open"}
    assert "a verdict needs 20 seeds; with 2 the claims cannot be told" in said.err


def test_a_file_that_cannot_be_used_is_one_sentence(study: Path, capsys: pytest.CaptureFixture[str]) -> None:
    study.write_text(STUDY.replace("seeds = 3", "seeds = 0.5"), encoding="utf-8")
    assert main(["study", str(study)]) == 2
    said = capsys.readouterr().err
    assert said == f"robotics: {study}:6: seeds must be a whole number >= 1 and <= 100000; got 0.5\n"


def test_an_interrupt_keeps_the_rows_that_are_done(
    study: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    from robotics.studies import keptcomparison

    done: list[str] = []

    def simulate(*arguments: Any, **options: Any) -> Any:
        if len(done) == 3:
            raise KeyboardInterrupt
        done.append(options["name"])
        return real(*arguments, **options)

    real = keptcomparison.simulate
    monkeypatch.setattr(keptcomparison, "simulate", simulate)
    assert main(["study", str(study), "--out", str(tmp_path / "out"), "-q"]) == 130
    assert "interrupted; 12 of 24 rows are in" in capsys.readouterr().err
    rows = pd.read_csv(tmp_path / "out" / "results.csv")
    assert rows[["scenario", "controller"]].drop_duplicates().to_numpy().tolist() == [
        ["short", "rival"],
        ["short", "gentle"],
        ["lanes", "rival"],
    ]
    monkeypatch.undo()
    assert main(["study", str(study), "--out", str(tmp_path / "out"), "--no-report", "-q", "--seeds", "2"]) == 2
    told = capsys.readouterr().err
    assert "out/pieces holds another study: seeds changed; give another --out, or --fresh to throw it away" in told
    for out in ("out", "whole"):
        assert main(["study", str(study), "--out", str(tmp_path / out), "--no-report"]) == 0
    assert f"{tmp_path / 'out'}: 3 of 5 pieces are there already" in capsys.readouterr().err
    for name in ("results.csv", "summary.csv", "claims.csv", "evidence.csv", "configuration.json"):
        assert (tmp_path / "out" / name).read_bytes() == (tmp_path / "whole" / name).read_bytes()
    assert not (tmp_path / "out" / "pieces").exists()


def test_studies_are_listed_and_begun_anew(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["list", "studies", "--json"]) == 0
    assert [row["name"] for row in json.loads(capsys.readouterr().out)["studies"]] == ["thesis"]
    mine = tmp_path / "mine.toml"
    assert main(["new", "study", "-o", str(mine), "--minimal"]) == 0
    assert main(["study", str(mine), "--seeds", "1", "--out", str(tmp_path / "o"), "--no-report", "-q"]) == 0
    assert "CANNOT BE TOLD" in capsys.readouterr().out


def test_compare_without_names_runs_the_study_of_the_thesis(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    asked: list[Any] = []

    def run_study(plan: Any, *_: Any, **__: Any) -> None:
        asked.append(plan)
        raise KeyboardInterrupt

    monkeypatch.setattr("robotics.show.report.study.run_study", run_study)
    for command in (["study", "thesis"], ["compare"]):
        assert main([*command, "--seeds", "7", "--out", str(tmp_path), "-q"]) == 130
    first, second = asked
    assert first == second == with_seeds(load_study("thesis"), 7)
    assert first.chapters == "robotics.plugins.thesis.chapters:judging"
    assert _chapters_named(first) is chapters.judging


def test_compare_without_a_study_says_so_and_takes_the_tracking_scenarios(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    asked: list[Any] = []

    def write_study(folder: Path, settings: Any, *_: Any, **told: Any) -> None:
        asked.append(([each.name for each in settings], told["chapters"], told["front"]))
        raise KeyboardInterrupt

    monkeypatch.setattr("robotics.show.report.study.write_study", write_study)
    monkeypatch.setattr("robotics.commands.compare.entry_points", lambda group: [])
    assert main(["compare", "--out", str(tmp_path), "-q"]) == 130
    assert asked == [(scenario_names("tracking"), None, None)]
    sentence = "robotics: no installed plug-in brings a study: the tracking scenarios are compared\n"
    assert capsys.readouterr().err.startswith(sentence)
    assert main(["compare", "--claims", "--out", str(tmp_path), "-q"]) == 2
    assert "no installed plug-in brings a study with claims" in capsys.readouterr().err
