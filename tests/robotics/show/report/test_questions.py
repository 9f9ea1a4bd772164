"""Questions to a study's table: those of the package against numbers by hand, one's own, and what is refused."""

import json
import re
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from matplotlib.figure import Figure

import robotics
from robotics.commands.application import main
from robotics.show.report.plan import StudyError, load_study
from robotics.show.report.questions import QUESTIONS, Answer, QuestionError, asked, described_table
from tests.robotics.show.report.test_study import SHORT

OWN = """
from matplotlib.figure import Figure
import robotics

def nearest(table):
    means = table.groupby("controller", sort=False)["rms_cross_track_m"].mean()
    figure = Figure(figsize=(3, 1))
    figure.subplots().barh(means.index, means)
    unit = table.attrs["units"]["rms_cross_track_m"]
    sentence = f"{means.idxmin()} keeps nearest, {means.min():.3g} {unit}."
    return robotics.Answer(sentence, "Nearest", means.reset_index(), figure)

def silent(table):
    return "nothing"

def fails(table):
    return table["no such column"]

def no_picture(table):
    return robotics.Answer("So.", picture=lambda: 3)
"""
STUDY = """
scenarios = ["short.toml", "other.toml"]
controllers = ["lyapunov", "csm"]
seeds = 3
questions = ["summary", "leads", "ranking", "rates", "front", "axes", "mine.py:nearest"]
"""


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    for name, text in (("short.toml", SHORT), ("other.toml", SHORT), ("mine.py", OWN), ("study.toml", STUDY)):
        (tmp_path / name).write_text(text, encoding="utf-8")
    return tmp_path


@pytest.mark.long
def test_an_own_question_stands_in_the_report_in_the_terminal_and_in_json(folder, capsys):
    out = folder / "out"
    assert main(["study", str(folder / "study.toml"), "--out", str(out), "-q"]) == 0
    printed = capsys.readouterr().out
    means = pd.read_csv(out / "results.csv").groupby("controller")["rms_cross_track_m"].mean()
    sentence = f"{means.idxmin()} keeps nearest, {means.min():.3g} m."
    assert f"Nearest\n  {sentence}" in printed
    answers = json.loads((out / "answers.json").read_text(encoding="utf-8"))
    assert list(answers) == [*QUESTIONS, "mine.py:nearest"]
    assert answers["mine.py:nearest"]["sentence"] == sentence
    assert {r["controller"]: r["rms_cross_track_m"] for r in answers["mine.py:nearest"]["table"]} == pytest.approx(
        means.to_dict(), rel=1e-12
    )
    page = (out / "report.html").read_text(encoding="utf-8")
    assert sentence in re.sub(r"<[^>]+>", "", page)
    assert (out / "figures" / "question-7.png").read_bytes().startswith(b"\x89PNG")
    assert main(["study", str(folder / "study.toml"), "--out", str(out), "-q", "--json", "--no-report"]) == 0
    assert json.loads(capsys.readouterr().out)["answers"] == answers


def table_of(values: dict[str, list[float]]) -> pd.DataFrame:
    rows = [
        {
            "scenario": "a",
            "controller": law,
            "seed": seed,
            "robot": 1,
            "rms_cross_track_m": value,
            "diverged": value > 5,
        }
        for law, own in values.items()
        for seed, value in enumerate(own)
    ]
    return described_table(pd.DataFrame(rows), {}, "rms_cross_track_m")


def test_the_packages_questions_answer_what_a_hand_works_out():
    table = table_of({"lyapunov": [1.0, 2.0, 3.0, 4.0], "csm": [2.0, 1.0, 4.0, 9.0]})
    answers = asked(["ranking", "rates", "leads"], table)
    ranks = answers["ranking"].table
    assert ranks is not None
    assert dict(zip(ranks["controller"], ranks["mean rank"], strict=True)) == {"lyapunov": 1.25, "csm": 1.75}
    assert ranks["first in"].tolist() == ["75 %", "25 %"]
    rates = answers["rates"].table
    assert rates is not None
    assert rates["share"].tolist() == [0.0, 0.25]
    # Wilson's interval of 1 of 4: (p + z²/2n ± z √(p q/n + z²/4n²))/(1 + z²/n)
    z, n, p = 1.959963984540054, 4, 0.25
    half = z * np.sqrt(p * (1 - p) / n + z**2 / (4 * n**2)) / (1 + z**2 / n)
    middle = (p + z**2 / (2 * n)) / (1 + z**2 / n)
    assert rates[["low", "high"]].iloc[1].tolist() == pytest.approx([middle - half, middle + half], rel=1e-12)
    assert "leads in 1 of 1 scenario" in answers["leads"].sentence


def test_laws_are_ranked_where_all_of_them_drive():
    table = table_of({"lyapunov": [1.0, 2.0, 3.0, 4.0], "csm": [2.0, 1.0, 4.0, 9.0]})
    alone = table[table["controller"] == "csm"].assign(scenario="another")
    found = asked(["ranking"], with_rows(table, alone))["ranking"]
    assert found.sentence == asked(["ranking"], table)["ranking"].sentence
    apart = with_rows(table[table["controller"] == "lyapunov"], alone)
    with pytest.raises(QuestionError, match="no scenario that all controllers drive"):
        asked(["ranking"], apart)


def with_rows(table: pd.DataFrame, more: pd.DataFrame) -> pd.DataFrame:
    both = pd.concat([table, more], ignore_index=True)
    both.attrs = dict(table.attrs)
    return both


def test_numbers_along_an_axis_are_the_means_of_its_values():
    table = table_of({"lyapunov": [1.0, 2.0, 3.0, 4.0]})
    table["latency"] = [0.0, 0.0, 0.1, 0.1]
    table["point"] = [1, 1, 2, 2]
    table.attrs["axes"] = ["latency"]
    found = asked(["axes"], table)["axes"]
    assert found.table is not None
    assert found.table[["value", "rms_cross_track_m"]].to_numpy().tolist() == [[0.0, 1.5], [0.1, 3.5]]
    assert "Lyapunov along latency from 1.5 to 3.5" in found.sentence
    assert callable(found.picture)
    assert isinstance(found.picture(), Figure)


@pytest.mark.parametrize(
    ("question", "says"),
    [
        ("leeds", "did you mean 'leads'"),
        ("mine.py:nearst", "did you mean 'nearest'"),
        ("there.py:none", "there.py: cannot be read"),
    ],
)
def test_a_question_that_there_is_not_is_told_with_its_line(folder, question, says):
    text = STUDY.replace("mine.py:nearest", question)
    (folder / "study.toml").write_text(text, encoding="utf-8")
    with pytest.raises(StudyError, match=re.escape(says)) as caught:
        load_study(folder / "study.toml")
    assert str(caught.value).startswith(f"{folder / 'study.toml'}:5: questions: ")


@pytest.mark.parametrize(
    ("question", "says"),
    [
        ("silent", "the question silent must return a robotics.Answer; got 'nothing'"),
        ("fails", "mine.py:17: KeyError: 'no such column' (in the question fails)"),
        ("no_picture", "the picture of an answer must be a matplotlib.figure.Figure; got int"),
    ],
)
def test_a_question_that_gives_no_answer_is_told_in_a_sentence(folder, capsys, question, says):
    (folder / "study.toml").write_text(STUDY.replace("mine.py:nearest", f"mine.py:{question}"), encoding="utf-8")
    assert main(["study", str(folder / "study.toml"), "--seeds", "1", "--out", str(folder / "o"), "-q"]) == 2
    assert says in capsys.readouterr().err


def test_an_answer_says_what_it_cannot_show():
    with pytest.raises(QuestionError, match="an answer needs a sentence"):
        Answer("")
    with pytest.raises(QuestionError, match=r"must be a pandas\.DataFrame; got list"):
        robotics.Answer("So.", table=[1])  # type: ignore[arg-type]


def test_a_question_that_failed_is_asked_again_without_a_run(folder, capsys, monkeypatch):
    """What was simulated is kept while a question is mended; a metric that is mended begins anew."""
    file, out = folder / "study.toml", folder / "out"
    file.write_text(STUDY.replace("mine.py:nearest", "mine.py:fails"), encoding="utf-8")
    command = ["study", str(file), "--out", str(out), "--no-report"]
    assert main(command) == 2
    (folder / "mine.py").write_text(
        OWN.replace('table["no such column"]', 'robotics.Answer("Well.")'), encoding="utf-8"
    )
    monkeypatch.setattr("robotics.studies.keptcomparison.simulate", None)
    assert main(command) == 0
    told = capsys.readouterr()
    assert f"{out}: 4 of 4 pieces are there already" in told.err
    assert "Well." in told.out
    monkeypatch.undo()
    file.write_text(STUDY + 'metrics = ["mine.py:no_metric"]\n', encoding="utf-8")
    (folder / "mine.py").write_text(OWN + "\ndef no_metric(run):\n    return 1 / 0\n", encoding="utf-8")
    assert main(command) == 2
    assert "ZeroDivisionError" in capsys.readouterr().err
    assert not (out / "pieces").exists()
    (folder / "mine.py").write_text(OWN + '\ndef no_metric(run):\n    return run["x"][..., 0]\n', encoding="utf-8")
    assert main(command) == 0
