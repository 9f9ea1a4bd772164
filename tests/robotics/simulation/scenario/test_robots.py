"""Robots as data: files of one's own, packaged ones by name, tables that change one; nobody has the EtsRo's numbers."""

import json
from dataclasses import fields, replace

import numpy as np
import pytest

from robotics.laws.avoidance.priority import STATED_FOR
from robotics.laws.catalogue import make_controller, safety_distance
from robotics.laws.law import ControllerError
from robotics.show.report.plan import load_sweep
from robotics.show.report.study import run_table
from robotics.simulation.loop import simulate
from robotics.simulation.scenario import robots
from robotics.simulation.scenario.description import Member, Scenario, ScenarioError
from robotics.simulation.scenario.reading import load_scenario, parse_scenario
from robotics.simulation.scenario.robots import load_robot, parse_robot, robot_names, with_numbers
from robotics.world.sensing.sonar import SONAR, sonar
from robotics.world.vehicle.robot import Robot, RobotError
from tests.robotics.world.vehicle.etsro import ETSRO

MINE = """\
title = "A cart"  # of my own
body_mass = 6.0
length = 0.4
width = 0.3
half_axle = 0.14
wheel_radius = 0.05
supply_voltage = 12.0
stall_torque = 2.0      # data sheet
no_load_speed = 20.0
counts_per_turn = 2000

# what it sees with
[[sensors]]
preset = "sonar"
range = 3.0

[[sensors]]
name = "rear"
x = -0.2
axis = 3.1
"""
HEAD = "duration = 3.0\n"
DRIVE = """
[[robots]]
start = [0.0, 0.05, 0.0]
path = { shape = "line", start = [0.0, 0.0], end = [0.5, 0.0] }
timing = { speed = 0.1 }
"""


def test_a_robot_of_ones_own_is_what_its_file_says():
    model = parse_robot(MINE, "cart")
    assert (model.name, model.title) == ("cart", "A cart")
    assert (model.robot.body_mass, model.robot.torque_constant) == (6.0, 2.0 / 12.0)
    assert list(model.sensors) == [*SONAR, "rear"]
    nose = model.sensors["front-left"]  # on the outline of this robot, not of the EtsRo
    assert (nose.x, nose.y, nose.range) == pytest.approx((0.2, 0.09, 3.0))
    assert model.sensors["right"].y == -0.15


@pytest.mark.parametrize(
    ("old", "new", "line", "message"),
    [
        ("body_mass", "body_mas", 2, "unknown key 'body_mas'; did you mean 'body_mass'?"),
        ("length = 0.4", "length = 400.0", 3, "length must be a finite number in m, > 0 and <= 10; got 400.0"),
        ("stall_torque", "torque_constant = 0.2\nstall_torque", 9, "give stall_torque or torque_constant, not both"),
        ("counts_per_turn = 2000\n", "", 1, "a robot lacks counts_per_turn [counts]"),
        ('"A cart"', "3", 1, "title must be text in quotes"),
        ("range = 3.0", "rnge = 3.0", 15, "did you mean 'range'?"),
        ('"rear"', '"left"', 17, "there are two sensors called 'left'"),
        ("x = -0.2", "prefix = 'a'", 19, "prefix belongs to a preset"),
        ("range = 3.0", "beams = 3", 15, "unknown key 'beams'"),
        ("stall_torque = 2.0 ", "stall_torque = two ", 8, "this is not TOML"),
    ],
)
def test_what_is_wrong_with_a_robots_file_is_named_with_its_line(old, new, line, message):
    assert old in MINE
    with pytest.raises(RobotError) as caught:
        parse_robot(MINE.replace(old, new, 1), "cart", "cart.toml")
    assert str(caught.value).startswith(f"cart.toml:{line}: ")
    assert message in str(caught.value)


def test_a_lidar_has_the_beams_of_its_table():
    model = parse_robot(
        MINE.replace('preset = "sonar"', 'preset = "lidar"\nprefix = "top-"\nbeams = 5\nspan = 2.0\naxis = 0.5'), "c"
    )
    beams = [sensor for name, sensor in model.sensors.items() if name.startswith("top-beam-")]
    assert [sensor.axis for sensor in beams] == pytest.approx([-0.5, 0.0, 0.5, 1.0, 1.5])
    assert {sensor.range for sensor in beams} == {3.0}
    with pytest.raises(RobotError, match=r"cart\.toml:15: beams must be a whole number >= 2"):
        parse_robot(MINE.replace('"sonar"', '"lidar"\nbeams = 1'), "c", "cart.toml")
    with pytest.raises(RobotError, match=r"cart\.toml:15: span must be a finite number in rad"):
        parse_robot(MINE.replace('"sonar"', '"lidar"\nspan = 360'), "c", "cart.toml")


def test_unknown_robots_and_files_are_named():
    with pytest.raises(RobotError, match=r"unknown robot 'turtlebot-burger'; did you mean 'turtlebot3-burger'\?"):
        load_robot("turtlebot-burger")
    with pytest.raises(RobotError, match=r"none\.toml: cannot be read"):
        load_robot("none.toml")


# In scenarios ----------------------------------------------------------------------------------------------------


def parsed(common="", own="", folder=None):
    return parse_scenario(HEAD + common + DRIVE + own, "one", "one.toml", folder)


def test_a_scenario_names_its_robots():
    found = parsed('robot = "turtlebot3-burger"\n').robots[0]
    assert found.model is load_robot("turtlebot3-burger")
    assert found.robot == found.model.robot
    other = parsed('robot = "turtlebot3-burger"\n', 'robot = "pioneer-3dx"\n')
    assert other.robots[0].robot == load_robot("pioneer-3dx").robot
    assert other.setting.sensors == (load_robot("pioneer-3dx").sensors,)


def test_no_robot_is_the_etsro_with_its_sonars():
    plain = parsed()
    assert (plain.robots[0].robot, plain.setting.sensors) == (ETSRO, (SONAR,))
    built = Member(start=(0.0, 0.0, 0.0), path=plain.robots[0].path, timing=plain.robots[0].timing)
    assert Scenario(name="built", robots=(built,)).setting.sensors == (SONAR,)
    mine = Robot(**load_robot("pioneer-3dx").robot.given)
    assert Scenario(name="mine", robots=(replace(built, model=None, robot=mine),)).setting.sensors == ({},)


def test_a_file_of_a_robot_lies_beside_the_scenario_or_here(tmp_path, monkeypatch):
    (tmp_path / "there").mkdir()
    (tmp_path / "there" / "mine.toml").write_text(MINE, encoding="utf-8")
    (tmp_path / "there" / "one.toml").write_text(HEAD + 'robot = "mine.toml"\n' + DRIVE, encoding="utf-8")
    monkeypatch.chdir(tmp_path)
    assert load_scenario("there/one.toml").robots[0].robot.body_mass == 6.0
    (tmp_path / "mine.toml").write_text(MINE.replace("6.0", "7.0"), encoding="utf-8")
    assert load_scenario("there/one.toml").robots[0].robot.body_mass == 6.0  # beside it first
    (tmp_path / "there" / "mine.toml").unlink()
    assert load_scenario("there/one.toml").robots[0].robot.body_mass == 7.0
    (tmp_path / "mine.toml").write_text(MINE.replace("width = 0.3", "width = -0.3"), encoding="utf-8")
    with pytest.raises(ScenarioError, match=r"one\.toml:2: mine\.toml:4: width must be"):
        load_scenario("there/one.toml")


def test_numbers_are_changed_before_others_are_derived():
    burger = load_robot("turtlebot3-burger").robot
    table = '[robot]\nmodel = "turtlebot3-burger"\nno_load_speed = 10.0\n'
    changed = parsed(table).robots[0]
    assert changed.robot == burger.changed(no_load_speed=10.0)
    assert changed.robot.wheel_speed_max == pytest.approx(10.0)
    assert changed.robot.kp != burger.kp
    assert changed.model is load_robot("turtlebot3-burger")
    assert list(parsed(table).setting.sensors[0]) == [f"beam-{n}" for n in range(1, 121)]
    # a robot's own table changes the common robot, or takes another model and starts afresh
    own = parsed(table, "[robots.robot]\nbody_mass = 3.0\n").robots[0].robot
    assert own == burger.changed(no_load_speed=10.0, body_mass=3.0)
    fresh = parsed(table, '[robots.robot]\nmodel = "etsro"\nbody_mass = 3.0\n').robots[0].robot
    assert fresh == replace(ETSRO, body_mass=3.0)


def test_a_whole_robot_needs_no_model():
    numbers = MINE[MINE.index("body_mass") : MINE.index("# what")]
    member = parsed("[robot]\n" + numbers).robots[0]
    assert (member.robot, member.model) == (parse_robot(MINE, "m").robot, None)
    assert parsed("[robot]\n" + numbers).setting.sensors == ({},)


@pytest.mark.parametrize(
    ("common", "own", "line", "message"),
    [
        ("[robot]\nkp = 1.0\n", "", 2, "it lacks body_mass [kg], length [m], width [m]"),
        ("[robot]\nkp = 1.0\n", "", 2, 'model = "etsro" changes the EtsRo'),
        ("", "[robots.robot]\nkp = 1.0\n", 7, "nor does it name the model that it changes"),
        ('robot = "etsroo"\n', "", 2, "unknown robot 'etsroo'; did you mean 'etsro'?"),
        ('[robot]\nmodel = "etsroo"\n', "", 3, "unknown robot 'etsroo'"),
        ("[robot]\nmodel = 3\n", "", 3, "model must be the name of a robot"),
        ('[robot]\nmodel = "etsro"\nkq = 3\n', "", 4, "unknown key 'kq'; did you mean 'kp'?"),
        ('[robot]\nmodel = "etsro"\nkp = -3\n', "", 4, "kp must be a finite number in V s/rad, >= 0; got -3"),
        ('[robot]\nmodel = "pioneer-3dx"\nback_emf = 1\nno_load_speed = 2\n', "", 5, "give no_load_speed or back_emf"),
        ("", 'robot = "none.toml"\n', 7, "none.toml: cannot be read"),
    ],
)
def test_what_is_wrong_with_a_robot_is_named_with_its_line(common, own, line, message):
    with pytest.raises(ScenarioError) as caught:
        parsed(common, own)
    assert str(caught.value).startswith(f"one.toml:{line}: ")
    assert message in str(caught.value)


def test_sensors_of_a_scenario_sit_on_the_robot_that_carries_them():
    sensors = '[[sensors]]\npreset = "sonar"\n'
    mixed = parse_scenario(HEAD + 'robot = "pioneer-3dx"\n' + sensors + DRIVE + DRIVE + 'robot = "etsro"\n', "two")
    assert mixed.setting.sensors == (sonar(0.455, 0.381), SONAR)


@pytest.mark.parametrize("name", [f.name for f in fields(Robot)])
def test_nothing_of_the_etsro_is_in_the_run_of_another_robot(monkeypatch, name):
    """Whatever number of the EtsRo is another one: a TurtleBot3 drives as it did."""
    scenario = parsed('robot = "turtlebot3-burger"\n')
    before = simulate(scenario, make_controller("fuzzy"))
    other = getattr(ETSRO, name)
    if other is not None:
        standard = replace(load_robot("etsro"), robot=replace(ETSRO, **{name: other * 1.1 + 0.01}), sensors={})
        packaged = robots._packaged
        monkeypatch.setattr(robots, "_packaged", lambda said: standard if said == "etsro" else packaged(said))
        assert parsed().robots[0].robot != ETSRO
    after = simulate(parsed('robot = "turtlebot3-burger"\n'), make_controller("fuzzy"))
    np.testing.assert_array_equal(after.samples, before.samples)


def test_laws_say_which_sensors_a_robot_lacks():
    with pytest.raises(ControllerError, match=r"robot 1 lacks the range sensors front-left, .*it carries sonar-1"):
        simulate(parsed('robot = "pioneer-3dx"\n'), make_controller("obstacles"))


def test_distances_between_robots_go_by_their_size():
    """The same room beyond the turning circles, whatever the robots; the EtsRo's are those that the law states."""
    law = "right-of-way"
    assert safety_distance(law, [ETSRO]) == 0.5
    large = load_robot("mir100").robot
    found = safety_distance(law, [ETSRO, large])
    assert found - np.hypot(large.length, large.width) == pytest.approx(0.5 - STATED_FOR)
    assert np.hypot(ETSRO.length, ETSRO.width) == STATED_FOR


# In sweeps, and in files -----------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("common", "mass"),
    [("", 2.3), ('robot = "mine.toml"\n', 6.0), ('[robot]\nmodel = "mine.toml"\nki = 5.0\n', 6.0)],
)
def test_a_sweep_changes_the_numbers_of_any_robot(tmp_path, common, mass):
    (tmp_path / "mine.toml").write_text(MINE, encoding="utf-8")
    (tmp_path / "one.toml").write_text(HEAD + common + DRIVE, encoding="utf-8")
    text = 'scenario = "one.toml"\ncontrollers = ["lyapunov"]\n[scenario_fields]\nrobot.kp = [0.5, 0.7]\n'
    (tmp_path / "sweep.toml").write_text(text, encoding="utf-8")
    plan = load_sweep(tmp_path / "sweep.toml")
    found = [plan.cases[0][0].design.scenario_at(point).robots[0].robot for point in plan.points]
    assert [(robot.body_mass, robot.kp) for robot in found] == [(mass, 0.5), (mass, 0.7)]
    run_table(plan, tmp_path / "out")
    about = json.loads((tmp_path / "out" / "pieces" / "plan.json").read_text(encoding="utf-8"))
    assert list(about["files_sha256"]) == (["mine.toml"] if common else []) + ["one.toml"]


def test_numbers_are_written_into_a_file_and_comments_stay():
    text = with_numbers(MINE, {"kp": 0.5, "stall_torque": 2.5})
    assert "stall_torque = 2.5      # data sheet\n" in text
    assert text.index("kp = 0.5") < text.index("# what it sees with") < text.index("[[sensors]]")
    found = parse_robot(text, "cart")
    assert (found.robot.kp, found.robot.torque_constant) == pytest.approx((0.5, 2.5 / 12))
    assert found.sensors == parse_robot(MINE, "cart").sensors
    assert with_numbers("kp = 1\n", {"kp": 2.0, "ki": 3.0}) == "kp = 2.0\nki = 3.0\n"


def test_robots_are_named():
    assert robot_names() == ["etsro", "mir100", "pioneer-3dx", "turtlebot3-burger"]
