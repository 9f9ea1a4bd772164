"""The page docs/howto/own-question.md, executed: a function, a study's file, the command line, the picture."""

import json
from pathlib import Path

import pandas as pd

from robotics.commands.application import main
from tests.snippets import snippets

PYTHON, STUDY, COMMANDS = (
    text for _, text in snippets(Path(__file__).parents[1] / "docs" / "howto" / "own-question.md")
)


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
    nearest = table.groupby("point")["min_clearance_m"].min()
    assert answer["sentence"] == f"Kept on 95 % of courses: obstacles {100 * nearest.quantile(0.05):.0f} cm."


def test_the_function_has_fifteen_lines():
    assert len([line for line in PYTHON.splitlines() if line.strip()]) <= 15
