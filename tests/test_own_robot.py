"""The page docs/howto/own-robot.md: its snippets run, and its robot does in a corridor what the page says."""

import shutil
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import fuzzy
import robotics
from tests.snippets import run_commands, snippets

LINE = """
[[robots]]
start = [0.0, 0.0, 0.0]
path = { shape = "line", start = [0.0, 0.0], end = [1.0, 0.0] }
timing = { speed = 0.1 }
"""
DOCS = Path(__file__).parent.parent / "docs"


@pytest.fixture
def folder(tmp_path, monkeypatch):
    shutil.copytree(DOCS / "examples" / "turtlebot-corridor", tmp_path, dirs_exist_ok=True)
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.mark.long
def test_every_snippet_of_the_page_runs_in_order(folder, capsys):
    found = snippets(DOCS / "howto" / "own-robot.md", changed=False)
    assert [kind for kind, _ in found] == ["toml", "sh", "sh", "toml", "toml", "sh"]
    robots = []
    for kind, text in found:
        if kind == "sh":
            run_commands(text)
        else:
            whole = text.replace("[[robots]]\n", LINE + LINE) if "[[robots]]" in text else text + LINE
            robots.append(robotics.parse_scenario(whole, "own").setting)
    burger, loaded, sensing = robots
    assert burger.robots[0] == robotics.load_robot("turtlebot3-burger").robot
    assert loaded.robots[0].body_mass == 1.6
    assert loaded.robots[0].kp > burger.robots[0].kp
    all_robots, this_robot = sensing.sensors
    assert [s.noise for s in all_robots.values()] == [0.03] * 4 + [0.0]
    assert all_robots["rear"].failure_start == 20.0
    assert {name: s.range for name, s in this_robot.items()} == {"nose": 3.0}
    for name in ("turtlebot.png", "mine.png", "check.png", "corridor.png"):
        assert (folder / name).stat().st_size > 10_000
    said = capsys.readouterr().out
    assert "front_left" in said
    assert "Derived" in said


@pytest.mark.long
def test_it_keeps_to_the_middle_by_its_lidar_and_its_rules(folder):
    scenario, law = robotics.load_scenario("corridor.toml"), robotics.make_controller("corridor.fis")
    run = robotics.simulate(scenario, law, seeds=range(20))
    found = robotics.measure_all(run)
    assert not found["contacts"].any()
    assert 0.18 < found["min_clearance_m"].min() < 0.21
    straight = run["x"][:, 0] > 5.5  # beyond the corner, where the middle is y = 3
    assert straight.any(axis=1).all()
    assert np.abs(run["y"][:, 0][straight] - 3.0).max() < 0.05

    def straight_on(numbers):
        """The contacts of every seed if the rules of these numbers say to go straight on."""
        fis = fuzzy.read_fis("corridor.fis")
        rules = [
            replace(rule, then=tuple((o, "straight" if o == "w" else term) for o, term in rule.then))
            if n in numbers
            else rule
            for n, rule in enumerate(fis.rules, start=1)
        ]
        other = law.with_fuzzy_system("own", replace(fis, rules=rules))
        return robotics.measure_all(robotics.simulate(scenario, other, seeds=range(20)))["contacts"][:, 0]

    assert (straight_on((1, 2)) > 0).sum() == 20
    assert (straight_on((5, 6)) > 0).sum() >= 2

    blind = replace(scenario, sensors={})
    assert (robotics.measure_all(robotics.simulate(blind, law, seeds=range(5)))["contacts"] > 0).all()
