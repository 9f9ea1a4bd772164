"""What ``robotics run`` and ``robotics list`` print for people."""

import re
from pathlib import Path

import pytest

from robotics.commands.application import main
from robotics.simulation.scenario.conditions import CONDITION_GROUPS, group_of
from robotics.simulation.scenario.description import Scenario
from robotics.simulation.scenario.reading import load_scenario, scenario_names


@pytest.fixture
def team(tmp_path):
    text = "".join(
        f"\n[[robots]]\nstart = [0.0, {i}.0, 0.0]\n"
        f'path = {{ shape = "line", start = [0.0, {i}.0], end = [2.0, {i}.0] }}\n'
        "timing = { duration = 8.0 }\n"
        for i in range(7)
    )
    head = 'kind = "team"\nduration = 1.0\n\n[sensing]\nposture = "pose"\nposition_noise = 0.002\n'

    def write(robots):
        place = [m.start() for m in re.finditer(r"\n\[\[robots", text)] + [len(text)]
        (tmp_path / "row.toml").write_text(head + text[: place[robots]], encoding="utf-8")
        return str(tmp_path / "row.toml")

    return write


def test_the_first_line_says_what_ran_and_the_second_whose_a_column_is(team, capsys):
    assert main(["run", team(2), "-c", "virtual-structure", "-q", "--seed", "3", "--seeds", "3"]) == 0
    first, heads, *rows = capsys.readouterr().out.splitlines()
    assert first == "row under virtual-structure, means of seeds 3 to 5; noise: position ± 2 mm"
    assert heads.split("  ")[-1] == " robot 2"
    ends = [heads.index(f"robot {i}") + len(f"robot {i}") for i in (1, 2)]
    for row in rows:
        assert all(row[end - 1] != " " and row[end] == " " for end in ends), row  # the numbers end below their heads
    assert "mean over" not in "".join(rows)


def test_many_robots_have_three_columns(team, capsys):
    assert main(["run", team(7), "-c", "virtual-structure", "-q"]) == 0
    first, heads, *_ = capsys.readouterr().out.splitlines()
    assert first == "row under virtual-structure, seed 0; noise: position ± 2 mm"
    assert heads.split() == ["of", "7", "robots", "least", "median", "largest"]


def test_one_robot_needs_no_heads_and_no_dust_is_shown(team, tmp_path, capsys):
    file = tmp_path / "one.toml"
    file.write_text(
        'duration = 1.0\nplant = "kinematic"\n\n[[robots]]\nstart = [0.0, 0.0, 0.0]\n'
        'path = { shape = "line", start = [0.0, 0.0], end = [2.0, 0.0] }\ntiming = { speed = 0.3 }\n',
        encoding="utf-8",
    )
    assert main(["run", str(file), "-c", "lyapunov", "-q"]) == 0
    first, *rows = capsys.readouterr().out.splitlines()
    assert first == "one under lyapunov, seed 0; noise: none"
    values = {row.split()[0]: row.split()[1] for row in rows}
    assert values["mean_abs_y_error_m"] == "0"
    assert not [v for v in values.values() if re.search(r"e-1\d", v)]


def test_packaged_scenarios_and_studies_are_listed_without_being_made(capsys, monkeypatch):
    def fails(*arguments):
        raise AssertionError("a scenario was made")

    monkeypatch.setattr(Scenario, "__post_init__", fails)
    assert main(["list", "scenarios"]) == main(["list", "studies", "--json"]) == 0
    assert '"thesis"' in capsys.readouterr().out


def test_a_scenario_of_another_package_is_listed_by_its_trajectories(capsys, monkeypatch):
    assert main(["list", "scenarios"]) == 0
    listed = capsys.readouterr().out
    monkeypatch.setattr("robotics.commands.list._OURS", Path("elsewhere"))
    assert main(["list", "scenarios"]) == 0
    assert capsys.readouterr().out == listed


def test_scenarios_are_listed_in_their_groups(capsys):
    assert main(["list", "scenarios"]) == 0
    lines = capsys.readouterr().out.splitlines()[1:]
    listed, group = {}, ""
    for line in lines:
        if re.match(r"  \S", line):
            group = line.strip()
        elif found := re.match(r"    (\S+)  +\S", line):
            listed[found[1]] = group
    assert listed == {name: group_of(load_scenario(name)) for name in scenario_names()}
    assert list(dict.fromkeys(listed.values())) == list(CONDITION_GROUPS)
    assert listed["three-cross"] == "Meetings: robots on time would touch"
    assert listed["crossing-in-turn"] == "Teams: all arrive together"  # their paths cross, they do not meet
    assert listed["trap-u"] == "Obstacles: unknown to the robots"
    assert {line.index(re.sub(r"^ +\S+ +", "", line)) for line in lines if re.match(r"    \S", line)} == {
        6 + max(map(len, scenario_names()))
    }
