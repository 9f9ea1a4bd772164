"""The page docs/howto/own-question.md, executed: a function, a study's file, the command line, the picture."""

import json
import sys
from pathlib import Path
from typing import Any

import pandas as pd
import pytest

from robotics.commands.application import main
from tests.snippets import run_python, snippets

PYTHON, STUDY, COMMANDS, CHANGED = (
    text for _, text in snippets(Path(__file__).parents[1] / "docs" / "howto" / "own-question.md")
)


@pytest.mark.long
def test_the_page_answers_its_question(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    Path("clearance.py").write_text(PYTHON, encoding="utf-8")
    assert "samples = 30" in STUDY  # three will do here, of a law that is compiled, and without robots that are late
    Path("courses.toml").write_text(
        STUDY.replace("samples = 30", "samples = 3").replace(', "fuzzy-team"', ""), encoding="utf-8"
    )
    check, study = (line.partition("#")[0].split()[1:] for line in COMMANDS.splitlines())
    assert main(check) == 0
    assert "× 3 points" in capsys.readouterr().out
    assert main([*study, "-q"]) == 0
    answer = json.loads(Path("out/courses/answers.json").read_text(encoding="utf-8"))["clearance.py:keeps"]
    assert answer["sentence"] in capsys.readouterr().out
    assert answer["sentence"] in Path("out/courses/report.html").read_text(encoding="utf-8")
    assert Path("out/courses/figures/question-1.png").exists()
    table = pd.read_csv("out/courses/results.csv")
    share = (table.groupby("point")["min_clearance_m"].min() >= 0.1).mean()
    who = "obstacles" if share == 1 else "no law"
    said = f"10 cm are kept on 95 % of courses by {who}; obstacles on {100 * share:.0f} %."
    assert answer["sentence"] == said

    monkeypatch.syspath_prepend(tmp_path)
    run_python(CHANGED, "own-question.md")
    sys.modules.pop("clearance")
    share = (table.groupby("point")["min_clearance_m"].min() >= 0.15).mean()
    assert f"15 cm are kept on 95 % of courses by no law; obstacles on {100 * share:.0f} %." in capsys.readouterr().out


def test_it_goes_with_a_study_without_axes_and_of_several_scenarios():
    rows = [("one", "a", 0, 0.2), ("two", "a", 0, 0.05), ("one", "b", 0, 0.2), ("two", "b", 0, 0.3)]
    table = pd.DataFrame(rows, columns=["scenario", "controller", "seed", "min_clearance_m"])
    names: dict[str, Any] = {}
    exec(PYTHON, names)
    assert names["keeps"](table).sentence == "10 cm are kept on 95 % of courses by b; a on 50 %, b on 100 %."


def test_the_function_is_short():
    assert len([line for line in PYTHON.splitlines() if line.strip()]) <= 18
