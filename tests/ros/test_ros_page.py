"""The pages docs/howto/on-ros-2.md and turtlebot3.md: their snippets run as written, and what they name is there."""

import re
from pathlib import Path

import pytest

from robotics import ScenarioError, load_run, load_scenario, measure, simulate
from robotics.laws.catalogue import make_controller
from robotics.plugins.identify.model import COORDINATE_NAMES, values_of
from robotics.simulation.scenario.robots import load_robot
from tests.snippets import run_commands, run_python, snippets

ROOT = Path(__file__).parent.parent.parent
PAGE = ROOT / "docs" / "howto" / "on-ros-2.md"


@pytest.mark.long
def test_every_snippet_of_the_page_runs_in_order(ros, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    found = snippets(PAGE)
    assert [kind for kind, _ in found] == ["sh", "python", "toml"]
    run_commands(found[0][1])
    assert (tmp_path / "drive.png").stat().st_size > 10_000
    capsys.readouterr()
    run_python(found[1][1], PAGE.name)
    apart, said = capsys.readouterr().out.split(maxsplit=1)
    assert float(apart) < 1e-9
    assert said == "m apart\n"


@pytest.mark.long
def test_the_stand_in_of_the_turtlebots_page_comes_out_of_its_drive(ros, tmp_path, monkeypatch):
    """By the commands of the page, as written: other numbers than the data sheet's, and the tuned law drives."""
    monkeypatch.chdir(tmp_path)
    found = snippets(PAGE.with_name("turtlebot3.md"))
    assert [kind for kind, _ in found] == ["toml", "toml", "sh"]
    for _, text in found[:2]:
        (tmp_path / re.match(r"# (\S+):", text)[1]).write_text(text, encoding="utf-8")
    run_commands(found[2][1])
    told = re.search(r"^#   latency = (\S+)", (tmp_path / "myrobot.toml").read_text(encoding="utf-8"), re.MULTILINE)
    assert float(told[1]) == pytest.approx(0.12, abs=0.005)
    robots = load_robot("myrobot.toml").robot, load_scenario("standin.toml").robots[0].robot
    identified, true = (dict(zip(COORDINATE_NAMES, values_of(robot), strict=True)) for robot in robots)
    for name, share in {
        "v_rate_max": 0.005,
        "w_max": 0.005,
        "wheel_max": 0.005,
        "gyration": 0.02,
        "friction": 0.2,
    }.items():
        assert identified[name] == pytest.approx(true[name], rel=share), name
    assert measure(load_run("drive.npz"))["rms_cross_track_under_way_m"].max() < 0.1


def test_a_burger_can_drive_on_the_floor_of_the_page_and_not_the_default(tmp_path):
    from fuzzyfleet_ros.names import scenario_of

    floor = tmp_path / "floor.toml"
    floor.write_text(dict(snippets(PAGE))["toml"], encoding="utf-8")
    run = simulate(scenario_of(str(floor), "turtlebot3-burger"), "fuzzy", [0])
    assert measure(run)["rms_cross_track_m"].max() < 0.01
    with pytest.raises(ScenarioError, match="infeasible"):
        simulate(scenario_of("reference", "turtlebot3-burger"), "fuzzy", [0])


def test_the_files_that_the_page_names_are_there():
    named = set(re.findall(r"\b((?:ros|config)/[\w/-]+\.\w+)", PAGE.read_text(encoding="utf-8")))
    assert len(named) >= 4
    for name in named:
        assert (ROOT / name).exists() or (ROOT / "ros" / name).exists(), name
    assert (ROOT / "ros" / "foxglove" / "three-robots.json").exists()


def test_the_law_that_the_page_names_commands_velocities():
    assert make_controller("csm:k=0.3,realisation=velocity").level == "velocity"


def test_the_files_of_parameters_suit_the_controller(ros):
    from fuzzyfleet_ros.controllersettings import PARAMETERS

    defaults = {parameter.name: parameter.default for parameter in PARAMETERS}
    files = sorted((ROOT / "ros" / "config").glob("*.yaml"))
    assert len(files) == 2
    for file in files:
        pairs = re.findall(r"^    (\w+): (\S+)", file.read_text(encoding="utf-8"), re.MULTILINE)
        assert len(pairs) > 5
        for name, value in pairs:
            kind = bool if value in ("true", "false") else str if value.startswith('"') else float
            assert type(defaults[name]) is kind, (file.name, name)


def test_the_versions_agree():
    """ROS packages have three numbers and nothing behind them (REP 149)."""
    version = re.search(r'^version = "(.+)"', (ROOT / "pyproject.toml").read_text(encoding="utf-8"), re.MULTILINE)[1]
    numbers = re.match(r"\d+\.\d+\.\d+", version)[0]
    assert f'version="{version}"' in (ROOT / "ros" / "setup.py").read_text(encoding="utf-8")
    assert f"<version>{numbers}</version>" in (ROOT / "ros" / "package.xml").read_text(encoding="utf-8")
