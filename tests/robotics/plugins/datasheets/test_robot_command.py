"""``robotics robot``: what it prints, draws, tunes and writes."""

import json

import numpy as np
import pytest
from matplotlib.collections import LineCollection

from robotics.commands.application import main
from robotics.plugins.datasheets.figures import drivable, plot_robot
from robotics.simulation.scenario.robots import load_robot, robot_names
from robotics.world.vehicle.plant import saturate, velocity_limits
from robotics.world.vehicle.wheel_loop import step_response, tuned
from tests.drawn import y_of

MINE = """\
body_mass = 6.0          # weighed
length = 0.4
width = 0.3
half_axle = 0.14
wheel_radius = 0.05
supply_voltage = 12.0
stall_torque = 2.0
no_load_speed = 20.0
counts_per_turn = 2000
"""


@pytest.fixture
def mine(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "mine.toml").write_text(MINE, encoding="utf-8")
    return tmp_path


def test_every_derived_number_is_shown_with_its_rule(mine, capsys):
    assert main(["robot", "mine.toml"]) == 0
    out = capsys.readouterr().out
    robot = load_robot("mine.toml").robot
    given, derived = out.split("\nDerived\n")
    assert "v 1 m/s, ω 7.143 rad/s; |v| + 0.14 m |ω| <= 1 m/s" in given
    assert "sensors   none" in given
    for name in robot.derived:
        assert f"\n  {name} " in f"\n{derived}"
        assert f"\n  {name} " not in given
    assert all(f"\n  {name} " in given for name in robot.given if name not in robot.derived)
    assert main(["robot", "mine.toml", "--json"]) == 0
    told = json.loads(capsys.readouterr().out)
    rules = {row["name"]: row["rule"] for row in told["numbers"]}
    assert {name: rule for name, rule in rules.items() if rule is not None} == robot.derived
    step = step_response(robot, "spot")
    assert told["wheel_loop"]["spot"] == {"overshoot": step.overshoot, "settling_time_s": step.settling_time}
    assert told["limits"]["v_rate_mps2"] is None


def test_it_tunes_and_writes_a_copy_that_keeps_the_comments(mine, capsys):
    gains = tuned(load_robot("mine.toml").robot)
    assert main(["robot", "mine.toml", "--tune", "--write", "tuned.toml"]) == 0
    out = capsys.readouterr().out
    assert f"\nkp = {gains.kp!r}\nki = {gains.ki!r}\n" in out
    written = (mine / "tuned.toml").read_text(encoding="utf-8")
    assert written.startswith(MINE)
    robot = load_robot("tuned.toml").robot
    assert (robot.kp, robot.ki) == (gains.kp, gains.ki)
    assert main(["robot", "mine.toml", "--tune", "--write", "tuned.toml"]) == 2
    assert "tuned.toml exists already, nothing was written; --force overwrites" in capsys.readouterr().err
    assert main(["robot", "mine.toml", "--tune", "--write", "tuned.toml", "--force", "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["tuned"]["kp"] == gains.kp


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["turtle"], "unknown robot 'turtle'"),
        (["none.toml"], "none.toml: cannot be read"),
        (["mine.toml", "--write", "x.toml"], "--write writes what --tune finds"),
        (["mine.toml", "--tune", "--write", "x.txt"], "x.txt: the file's name must end in .toml"),
        (["mine.toml", "-o", "x.bmp"], "end it in .png, .pdf or .svg"),
    ],
)
def test_what_is_wrong_is_one_sentence(mine, capsys, arguments, said):
    assert main(["robot", *arguments]) == 2
    err = capsys.readouterr().err
    assert said in err
    assert err.count("\n") == 1
    assert sorted(path.name for path in mine.iterdir()) == ["mine.toml"]


def test_the_picture_is_to_scale_with_wheels_sensors_and_steps(mine, capsys):
    assert main(["robot", "turtlebot3-burger", "-o", "burger.png"]) == 0
    assert (mine / "burger.png").stat().st_size > 10_000
    model = load_robot("turtlebot3-burger")
    above, speed, voltage, limits = plot_robot(model).axes
    assert above.get_aspect() == 1.0
    body, *wheels, _ = [patch.get_extents().transformed(above.transData.inverted()) for patch in above.patches]
    assert (body.width, body.height) == pytest.approx((0.138, 0.178))
    assert [wheel.width for wheel in wheels] == pytest.approx([0.066, 0.066])
    assert sorted(wheel.y0 + wheel.height / 2 for wheel in wheels) == pytest.approx([-0.08, 0.08])
    (beams,) = above.collections
    assert isinstance(beams, LineCollection)
    assert len(beams.get_segments()) == len(model.sensors)
    step = step_response(model.robot, "straight")
    np.testing.assert_allclose(y_of(speed.lines[0]), step.speed / step.command)
    np.testing.assert_allclose(y_of(voltage.lines[0]), step.voltage)
    assert all(ax.get_ylabel() for ax in (above, speed, voltage, limits))


@pytest.mark.parametrize("name", robot_names())
def test_the_drivable_velocities_are_those_that_the_plant_leaves_as_they_are(name):
    robot = load_robot(name).robot
    corners, bounds = drivable(robot), velocity_limits([robot])
    for v, w in corners:
        inside = saturate(bounds, np.array([0.999 * v]), np.array([0.999 * w]))
        assert np.ravel(inside) == pytest.approx([0.999 * v, 0.999 * w], rel=1e-9)
        beyond = saturate(bounds, np.array([1.01 * v]), np.array([1.01 * w]))
        assert np.abs(np.ravel(beyond) - [1.01 * v, 1.01 * w]).max() > 1e-4


def test_robots_are_listed_and_copied(mine, capsys):
    assert main(["list", "robots", "--json"]) == 0
    assert [row["name"] for row in json.loads(capsys.readouterr().out)["robots"]] == robot_names()
    assert main(["copy", "mir100", "etsro.toml"]) == 0
    assert capsys.readouterr().out.splitlines() == [
        "mir100.toml",
        "  robotics robot mir100.toml",
        "etsro.toml",
        "  robotics robot etsro.toml",
    ]
    assert load_robot("mir100.toml").robot == load_robot("mir100").robot


def test_a_place_for_no_picture_is_refused_before_the_work(tmp_path, capsys):
    nowhere = tmp_path / "nowhere"
    assert main(["robot", "etsro", "-o", f"{nowhere}/x.png"]) == 2
    error = capsys.readouterr().err
    assert f"{nowhere}/x" in error
    assert f"there is no folder {str(nowhere)!r} to write into" in error
