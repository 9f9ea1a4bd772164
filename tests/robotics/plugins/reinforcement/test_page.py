"""The page docs/howto/environments.md: its tables are those of the code, and its snippets run as written.

`python -m tests.robotics.plugins.reinforcement.test_page` prints the tables.
"""

import re
from pathlib import Path

import pytest

pytest.importorskip("gymnasium", reason="needs gymnasium")
pytest.importorskip("pettingzoo", reason="needs pettingzoo")
from fuzzy.shown import shown
from robotics.plugins.reinforcement.observed import entries, team_entries
from robotics.plugins.reinforcement.policyfile import load_policy
from robotics.simulation.scenario.reading import load_scenario
from tests.snippets import run_commands, run_python, snippets

PAGE = Path(__file__).parents[4] / "docs" / "howto" / "environments.md"


def observations():
    """What a robot observes: the EtsRo on a packaged scenario, and what is added where it reads range sensors."""
    setting = load_scenario("lyapunov-circle").setting
    return _table(entries(setting, "velocity"))


def heard():
    """What an agent of a team observes beside that of one other robot."""
    found = team_entries(load_scenario("three-cross").setting, "velocity", 0, False)
    return _table([entry for entry in found if entry.name.startswith("robot2_")])


def _table(found):
    rows = ["| entry | unit | within | meaning |", "| --- | --- | --- | --- |"]
    for entry in found:
        within = f"0 to {shown(entry.high)}" if entry.positive else f"±{shown(entry.high)}"
        rows.append(f"| `{entry.name}` | {entry.unit} | {within} | {entry.meaning} |")
    return "\n".join(rows) + "\n"


def test_the_tables_are_those_of_the_code():
    text = PAGE.read_text(encoding="utf-8")
    assert observations() in text
    assert heard() in text


@pytest.mark.long
def test_its_programs_run(capsys):
    for kind, text in snippets(PAGE, changed=False):
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
    for kind, text in snippets(PAGE, changed=False):
        if kind == "sh":
            run_commands(text)
    assert load_policy("mine.json").about["steps"] >= 20000


def test_what_it_says_of_the_packaged_policy_stands_in_the_policy():
    about = load_policy("ppo").about
    assert f"{about['steps']:,} steps" in PAGE.read_text(encoding="utf-8")


if __name__ == "__main__":
    print(observations(), heard(), sep="\n")
