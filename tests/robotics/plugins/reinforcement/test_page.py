"""The page docs/howto/environments.md: its tables are those of the code, and its snippets run as written."""

import re
from pathlib import Path

import pytest

pytest.importorskip("gymnasium", reason="needs gymnasium")
pytest.importorskip("pettingzoo", reason="needs pettingzoo")
from robotics.plugins.reinforcement.policyfile import load_policy
from robotics.plugins.reinforcement.table import heard, observations
from tests.snippets import run_commands, run_python, snippets

PAGE = Path(__file__).parents[4] / "docs" / "howto" / "environments.md"


def test_the_tables_are_those_of_the_code():
    text = PAGE.read_text(encoding="utf-8")
    assert observations() in text
    assert heard() in text


def test_its_programs_run(capsys):
    for kind, text in snippets(PAGE):
        if kind == "python":
            run_python(text, PAGE.name)
    said = capsys.readouterr().out
    assert re.search(r"random: diverged, cost 100\.0", said)
    assert float(re.search(r"mean cost ([\d.]+)", said)[1]) < 1.5
    assert set(re.findall(r"'robot_\d': '(\w+)'", said)) <= {"diverged", "collided", "time"}


@pytest.mark.long
def test_its_commands_run(tmp_path, monkeypatch):
    pytest.importorskip("stable_baselines3", reason="needs stable-baselines3")
    monkeypatch.chdir(tmp_path)
    for kind, text in snippets(PAGE):
        if kind == "sh":
            run_commands(text)
    assert load_policy("mine.json").about["steps"] >= 20000


def test_what_it_says_of_the_packaged_policy_stands_in_the_policy():
    about = load_policy("ppo").about
    assert f"{about['steps']:,} steps" in PAGE.read_text(encoding="utf-8")
