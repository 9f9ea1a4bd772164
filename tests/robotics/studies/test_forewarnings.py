"""What can be told before a run to go wrong: and it does; and nothing is told of the package's own pairs."""

import json
from pathlib import Path

import numpy as np
import pytest

from robotics.commands.application import main
from robotics.laws.catalogue import make_controller
from robotics.laws.law import ControllerError
from robotics.measures.arrival import arrival_time
from robotics.measures.contacts import judge
from robotics.simulation.loop import simulate
from robotics.simulation.scenario.reading import load_scenario, parse_scenario, scenario_file, scenario_names
from robotics.studies.forewarnings import forewarnings, meetings

LANES = """
kind = "team"
duration = 60.0
[[robots]]
start = [0.0, 1.5, 0.0]
path = { shape = "line", start = [0.0, 1.5], end = [5.0, 1.0] }
timing = { duration = 25.0 }
[[robots]]
start = [0.0, -1.5, 0.0]
path = { shape = "line", start = [0.0, -1.5], end = [5.0, -1.5] }
timing = { duration = 25.0 }
[[robots]]
start = [0.0, 0.0, 0.0]
path = { shape = "line", start = [0.0, 0.0], end = [5.0, GOAL] }
timing = { duration = 25.0 }
"""


def lanes(goal):
    return LANES.replace("GOAL", str(goal))


def test_a_blind_law_is_told_of_as_such(capsys, tmp_path):
    for words in ("run {} -c cooperation", "compare {} --controllers=cooperation --seeds=1 --no-report --out={}"):
        main([*words.format("obstacles-on-two-paths", tmp_path / "out").split(), "--json", "-q"])
        told = capsys.readouterr().err.splitlines()
        sentence = "cooperation drives blind: it senses no obstacles, and obstacles-on-two-paths has 2"
        assert told[0] == f"robotics: warning: {sentence}"
    run = simulate(load_scenario("obstacles-on-two-paths"), make_controller("cooperation"))
    assert np.isfinite(judge(run).first).all()  # and that is what happens


def test_robots_that_meet_are_named_with_the_time_at_which_they_do():
    setting = load_scenario("two-meetings").setting
    (sentence,) = forewarnings(setting, make_controller("graph-esm"), "graph-esm")
    assert "robots 1 and 2 at t = 11.8 s" in sentence
    assert "robots 2 and 3" in sentence
    # The references themselves, every 5 ms: centers nearer than widths have touched, farther than diagonals have not
    for (i, j), time in meetings(setting).items():
        at = setting.references.at(time)
        robot = setting.robots[0]
        gap = np.hypot(at.x[i] - at.x[j], at.y[i] - at.y[j])
        assert robot.width <= gap <= np.hypot(robot.length, robot.width)
    assert forewarnings(setting, make_controller("right-of-way"), "right-of-way") == []


def test_places_that_nobody_measures_are_told_of_by_runs_and_by_check(tmp_path, capsys):
    wedge = Path(__file__).parents[3] / "docs/examples/wedge-on-eight/wedge-on-eight.toml"
    text = wedge.read_text(encoding="utf-8")
    mine = tmp_path / "mine.toml"
    for kind, said in (('kind = "formation"\n', False), ("", True)):
        mine.write_text(text.replace('kind = "formation"\n', kind), encoding="utf-8")
        setting = load_scenario(mine).setting
        told = forewarnings(setting, make_controller("leader-follower"), "leader-follower")
        assert [line for line in told if 'with kind = "formation" in the file of mine their place errors' in line] == (
            told if said else []
        )
        assert not forewarnings(setting, make_controller("csm"), "csm")
        assert main(["check", str(mine)]) == int(said)
        assert ("place errors are measured" in capsys.readouterr().out) == said


def test_a_meeting_of_one_that_is_late_is_told_only_where_none_is_on_time():
    """Robot 3 crosses the path of robot 1 when that is there; or is ahead of it by 0.7 m, of which 1 s is 0.2 m."""
    crossing = LANES.replace("end = [5.0, 1.0]", "end = [5.0, 0.2]").replace("[5.0, GOAL]", "[5.0, 1.6]")
    same = parse_scenario(crossing, "same")
    assert set(meetings(same.setting)) == {(0, 2)}
    ahead = crossing.replace("start = [0.0, 0.0", "start = [0.7, 0.0")
    other = parse_scenario(ahead, "other")
    assert not meetings(other.setting)
    assert set(meetings(other.setting, 1.0)) == {(0, 2)}
    for scenario, when in ((same, "if all are on time"), (other, "if one of them is 1 s late")):
        (sentence,) = forewarnings(scenario.setting, make_controller("cooperation"), "cooperation")
        assert when in sentence
        assert "robots 1 and 3" in sentence


@pytest.mark.parametrize("name", scenario_names())
def test_nobody_cries_wolf_over_a_scenario_with_its_own_law(name):
    scenario = load_scenario(name)
    usual = {"tracking": "fuzzy", "formation": "formation-teacher", "team": "cooperation", "goal": ""}[scenario.kind]
    law = scenario.controller or usual
    assert forewarnings(scenario.setting, make_controller(law), law) == []


def test_goals_within_d_min_are_told_of_and_hold_a_robot_up_for_ever(tmp_path, capsys):
    """Goals of robots 1 and 3 are 0.9 m apart, crash-yielding keeps 1 m: robot 3 never arrives; at 1.4 m it does."""
    near, far = parse_scenario(lanes(0.1), "near"), parse_scenario(lanes(-0.4), "far")
    law = make_controller("crash-yielding")
    (sentence,) = forewarnings(near.setting, law, "crash-yielding")
    for words in ("the goals of robots 1 and 3 are 0.90 m apart", "d_min = 1 m", "wait for ever", "set d_min below"):
        assert words in sentence
    assert "robots 2" not in sentence
    assert forewarnings(far.setting, law, "crash-yielding") == []
    assert np.isinf(arrival_time(simulate(near, law))[0, 2])
    assert np.isfinite(arrival_time(simulate(far, law))[0, 2])
    file = tmp_path / "near.toml"
    file.write_text(lanes(0.1))
    assert main(["run", str(file), "-c", "crash-yielding", "--json", "-q"]) == 0
    shown = capsys.readouterr()
    assert "goals of robots 1 and 3" in shown.err
    assert json.loads(shown.out)["scenario"] == "near"


@pytest.mark.parametrize("law", ["right-of-way", "fuzzy-team-planned"])
def test_a_law_that_plans_names_the_goals_that_leave_no_plan(law):
    near = parse_scenario(lanes(0.7), "near")
    with pytest.raises(ControllerError, match=r"the goals of robots 1 and 3 are 0.30 m apart; no order"):
        simulate(near, make_controller(law))


def test_a_sweep_tells_it_once(tmp_path, capsys):
    file = tmp_path / "blind.toml"
    file.write_text('scenario = "trap-u"\ncontrollers = ["cooperation"]\n[scenario_fields]\nduration = [0.5, 1.0]\n')
    assert main(["sweep", str(file), "--out", str(tmp_path / "out"), "--json", "-q"]) == 0
    assert capsys.readouterr().err.count("drives blind") == 1


def test_fuzzy_team_says_for_which_robots_its_rules_were_made():
    law = make_controller("fuzzy-team")
    text = scenario_file("obstacles-on-two-paths").text.replace('controller = "obstacles"', "")
    assert law.misgivings(parse_scenario(text, "small").setting) == ()
    assert law.misgivings(parse_scenario(f'robot = "mir100"\n{text}', "large").setting) == ()
    larger = parse_scenario(f'robot = {{ model = "mir100", length = 1.4 }}\n{text}', "larger")
    (sentence,) = law.misgivings(larger.setting)
    assert "made for the EtsRo and is tested with the packaged robots" in sentence
    assert "robot 1 needs 0.76 m" in sentence
