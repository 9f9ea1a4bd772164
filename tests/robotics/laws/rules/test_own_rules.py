"""A rule base of one's own: what each output does, how pairs are joined, what is refused, and three made by hand."""

from dataclasses import replace

import numpy as np
import pytest

from robotics.commands.application import main
from robotics.laws.catalogue import make_controller
from robotics.laws.law import ControllerError
from robotics.simulation.loop import simulate
from robotics.simulation.scenario.reading import load_scenario, parse_scenario
from tests.robotics.laws.rules.handmade import linear_base, lines

TIME = {"time": (0, 900)}
RADIUS = float(np.hypot(0.23, 0.20)) / 2  # m, of the turning circle
PERIOD = 0.05  # s


def driven(path, text=None, duration=0.25, **gains):
    """A run of the rule base at ``path``; by default of one robot, straight ahead at 0.3 m/s."""
    setting = replace(parse_scenario(text or lines((0.0, 0.0)), "lines"), duration=duration)
    more = "".join(f",{name}={value}" for name, value in gains.items())
    return simulate(setting, make_controller(f"fuzzy:rule_base={path}{more}"))


@pytest.fixture
def plain():
    """What fuzzy tracking itself asks for at the start: v [m/s] and w [rad/s]."""
    run = simulate(replace(parse_scenario(lines((0.0, 0.0)), "lines"), duration=0.25), make_controller("fuzzy"))
    return run["v_demand"][0, 0, 0], run["w_demand"][0, 0, 0]


@pytest.mark.parametrize(
    ("outputs", "v", "w"),
    [
        ({"v": 0.25, "w": -0.5}, lambda v: 0.25, lambda w: -0.5),
        ({"w": 0.7}, lambda v: v, lambda w: 0.7),
        ({"turn": 0.2}, lambda v: v, lambda w: w + 0.2 / 0.4),
        ({"speed": 0.1}, lambda v: 0.1, lambda w: w),
        ({"speed": 4.0}, lambda v: v, lambda w: w),
        ({"speed_factor": 0.5}, lambda v: 0.5 * v, lambda w: w),
        ({"speed_factor": 0.5, "turn": -0.1}, lambda v: 0.5 * v, lambda w: w - 0.1 / 0.4),
        ({"rate": 1.0, "keep": 1.0}, lambda v: v, lambda w: w),
    ],
)
def test_each_output_does_what_it_says(tmp_path, plain, outputs, v, w):
    run = driven(linear_base(tmp_path / "own.fis", TIME, {n: [0.0, value] for n, value in outputs.items()}))
    assert plain[0] > 0.11
    assert run["v_demand"][0, 0, 0] == pytest.approx(v(plain[0]), abs=1e-9)
    assert run["w_demand"][0, 0, 0] == pytest.approx(w(plain[1]), abs=1e-9)


def test_a_clock_that_waits_stops_the_robot_and_one_at_half_the_rate_halves_its_way(tmp_path):
    ways = {}
    for rate in (0.0, 0.5, 1.0):
        run = driven(linear_base(tmp_path / "own.fis", TIME, {"rate": [0.0, rate]}), duration=8.0)
        ways[rate] = run["x"][0, 0, -1]
    # The target is 0.4 s ahead of the clock, and the robot comes 0.4 s after it at its own speed
    for rate, way in ways.items():
        assert way == pytest.approx(0.3 * (8.0 * rate + 0.4) - 0.3 * rate * 0.4, abs=0.03)


@pytest.mark.parametrize(("keep", "held"), [(1.0, 1.0), (0.0, 0.0)])
def test_a_side_is_remembered_with_a_time_constant_of_half_a_second(tmp_path, keep, held):
    """The remembered side is the input "kept", half of which the rule base gives as its speed."""
    path = linear_base(tmp_path / "own.fis", {"kept": (0, 1)}, {"keep": [0.0, keep], "v": [0.5, 0.0]})
    kept = 2 * driven(path, duration=2.0)["v_demand"][0, 0, :40]
    np.testing.assert_allclose(kept, held * (1 - (1 - PERIOD / 0.5) ** np.arange(40)), atol=1e-6)


THREE = lines((0.0, 0.0), (0.9, 0.4), (1.5, -1.0))


def gaps(run, k):
    x, y = run["x"][0, :, k], run["y"][0, :, k]
    return np.hypot(x - x[:, None], y - y[:, None]) - 2 * RADIUS


def test_over_all_others_turns_add_up_and_of_the_rest_the_least_holds(tmp_path):
    path = linear_base(tmp_path / "own.fis", {"gap": (0, 9)}, {"w": [0.1, 0.0], "v": [0.2, 0.0], "keep": [0.0, 0.0]})
    run = driven(path, THREE)
    assert not run.diverged.any()
    others = gaps(run, 3)
    np.fill_diagonal(others, np.nan)
    np.testing.assert_allclose(run["w_demand"][0, :, 3], 0.1 * np.nansum(others, axis=1), atol=0.01)
    np.testing.assert_allclose(run["v_demand"][0, :, 3], 0.2 * np.nanmin(others, axis=1), atol=0.01)
    # The inputs that are kept are those of the robot for which the least was said
    np.testing.assert_allclose(run.inputs[3, 0, 0], np.nanmin(others, axis=1), atol=0.05)


@pytest.mark.parametrize("outputs", [{"v": [0.2, 0.0], "w": [0.0, 0.5]}, {"turn": [0.3, 0.0]}])
def test_who_hears_nobody_is_told_nothing_by_a_rule_base_of_pairs(tmp_path, plain, outputs):
    """Before the first message, and alone: it tracks."""
    path = linear_base(tmp_path / "own.fis", {"gap": (0, 9)}, outputs)
    for text in (THREE, None):
        run = driven(path, text)
        assert not run.diverged.any()
        np.testing.assert_allclose(run["v_demand"][0, :, 0], plain[0], atol=1e-9)
        np.testing.assert_allclose(run["w_demand"][0, :, 0], plain[1], atol=1e-9)
    assert np.isnan(run.inputs).all()


def test_a_rule_base_without_rules_leaves_all_to_tracking(tmp_path):
    for inputs in (TIME, {"gap": (0, 9)}):
        own = driven(linear_base(tmp_path / "own.fis", inputs, {"v": [0.0, 0.0]}, rules=0), THREE, duration=1.0)
        one = driven(linear_base(tmp_path / "own.fis", TIME, {"speed_factor": [0.0, 1.0]}), THREE, duration=1.0)
        np.testing.assert_array_equal(own.samples, one.samples)


def test_a_robot_is_known_by_its_number_and_is_nowhere_for_itself(tmp_path):
    inputs = {"robot2_ahead": (-9, 9), "robot2_left": (-9, 9)}
    path = linear_base(tmp_path / "own.fis", inputs, {"v": [0.1, 0.0, 0.0], "w": [0.0, 0.1, 0.0]})
    run = driven(path, THREE)
    k = 3
    x, y, heading = (run[name][0, :, k] for name in ("x", "y", "heading"))
    dx, dy = x[1] - x, y[1] - y
    np.testing.assert_allclose(
        run["v_demand"][0, :, k], 0.1 * (np.cos(heading) * dx + np.sin(heading) * dy), atol=0.005
    )
    np.testing.assert_allclose(
        run["w_demand"][0, :, k], 0.1 * (np.cos(heading) * dy - np.sin(heading) * dx), atol=0.005
    )
    assert run["v_demand"][0, 1, k] == 0


def test_the_leader_only_tracks(tmp_path, plain):
    path = linear_base(tmp_path / "own.fis", TIME, {"v": [0.0, 0.0], "w": [0.0, 1.0]})
    run = driven(path, THREE, leader=2)
    np.testing.assert_allclose(run["v_demand"][0, :, 0], [0.0, plain[0], 0.0], atol=1e-9)
    np.testing.assert_allclose(run["w_demand"][0, :, 0], [1.0, plain[1], 1.0], atol=1e-9)


@pytest.mark.parametrize("leader", [4, 1.5])
def test_a_leader_that_does_not_exist_is_refused(tmp_path, leader):
    path = linear_base(tmp_path / "own.fis", TIME, {"v": [0.0, 0.0]})
    with pytest.raises(ControllerError, match=f"number of a robot of lines, 1 to 3, or 0 for none; got {leader}"):
        driven(path, THREE, leader=leader)


SONARS = '\n[[sensors]]\npreset = "sonar"\n'


def wall(y, length=14.0, thick=0.2):
    """A wall along x whose face towards y = 0 is at ``y`` [m]."""
    middle = y + np.sign(y) * thick / 2
    return f'\n[[obstacles]]\nshape = "box"\nlength = {length}\nwidth = {thick}\nposition = [3.0, {middle}]\n'


def test_what_one_sensor_reads_is_known_by_its_name(tmp_path):
    path = linear_base(tmp_path / "own.fis", {"range:left": (0, 1.2)}, {"v": [1.0, 0.0]})
    run = driven(path, lines((0.0, 0.0), more=SONARS + wall(0.6)))
    assert run["v_demand"][0, 0, 0] == pytest.approx(0.5, abs=0.06)  # the sensor is 0.1 m to the left


@pytest.mark.parametrize(
    ("inputs", "outputs", "sentence"),
    [
        ({"gapp": (0, 1)}, {"v": [0, 0]}, "unknown quantity that a robot knows 'gapp'; did you mean 'gap'"),
        ({"robot1_aheaf": (0, 1)}, {"v": [0, 0]}, "unknown quantity that a robot knows 'robot1_aheaf'"),
        ({"time": (0, 1)}, {"sped": [0, 0]}, "unknown output of a rule base 'sped'; did you mean 'speed'"),
        ({"robot7_gap": (0, 1)}, {"v": [0, 0]}, "robot7_gap is of robot 7, and three-cross has 3"),
        ({"range:nose": (0, 1)}, {"v": [0, 0]}, "robot 1 lacks the range sensor nose"),
    ],
)
def test_the_command_line_says_in_a_sentence_what_is_unknown(tmp_path, capsys, inputs, outputs, sentence):
    path = linear_base(tmp_path / "own.fis", inputs, outputs)
    assert main(["run", "three-cross", "-q", "--controller", f"fuzzy:rule_base={path}"]) == 2
    said = capsys.readouterr()
    assert sentence in said.err
    assert "Traceback" not in said.err
    assert said.out == ""


@pytest.mark.parametrize(
    ("inputs", "sentence"),
    [
        ({"robot7_gap": (0, 1)}, "robot7_gap is of robot 7, and obstacles-on-two-paths has 3"),
        ({"range:nose": (0, 1)}, "robot 1 lacks the range sensor nose"),
    ],
)
def test_the_fuzzy_team_refuses_what_its_rule_bases_cannot_know(tmp_path, inputs, sentence):
    path = linear_base(tmp_path / "own.fis", inputs, {"speed": [0, 0]})
    with pytest.raises(ControllerError, match=sentence):
        simulate(load_scenario("obstacles-on-two-paths"), make_controller(f"fuzzy-team:crash_rule_base={path}"))


def test_a_wall_follower_keeps_its_distance(tmp_path):
    """0.3 m of room on the left; only the path's direction helps, not its place."""
    inputs = {"left": (0, 2), "heading_err": (-3.2, 3.2)}
    path = linear_base(tmp_path / "own.fis", inputs, {"v": [0, 0, 0.25], "w": [1.5, 2.0, -0.45]})
    run = driven(path, lines((0.0, 0.0), more=SONARS + wall(0.8)), duration=16.0)
    assert run["y"][0, 0, 0] == 0
    np.testing.assert_allclose(run["y"][0, 0, -40:], 0.8 - RADIUS - 0.3, atol=0.03)
    assert run["x"][0, 0, -1] > 3.5


def test_a_corridor_keeper_stays_in_the_middle(tmp_path):
    inputs = {"left": (0, 2), "right": (0, 2), "heading_err": (-3.2, 3.2)}
    path = linear_base(tmp_path / "own.fis", inputs, {"v": [0, 0, 0, 0.25], "w": [1.0, -1.0, 2.0, 0]})
    run = driven(path, lines((0.0, 0.2), more=SONARS + wall(0.6) + wall(-0.6)), duration=16.0)
    np.testing.assert_allclose(run["y"][0, 0, -80:], 0.0, atol=0.03)
    assert run["x"][0, 0, -1] > 3.5


def test_a_formation_keeper_keeps_its_place_behind_the_leader(tmp_path):
    """0.6 m behind and 0.5 m to the right of robot 1, from 0.3 m and 0.2 m beside that place."""
    inputs = {"robot1_ahead": (-9, 9), "robot1_left": (-9, 9), "robot1_v": (0, 2), "heading_err": (-3.2, 3.2)}
    outputs = {"v": [1.0, 0, 1.0, 0, -0.6], "w": [0, 1.5, 0, 2.0, -0.75]}
    path = linear_base(tmp_path / "own.fis", inputs, outputs)
    run = driven(path, lines((1.0, 0.0), (0.1, -0.3)), duration=15.0, leader=1)
    x, y = run["x"][0], run["y"][0]
    np.testing.assert_allclose(x[0, -40:] - x[1, -40:], 0.6, atol=0.03)
    np.testing.assert_allclose(y[0, -40:] - y[1, -40:], 0.5, atol=0.03)
    assert x[0, -1] - x[0, 0] == pytest.approx(0.3 * 15, abs=0.1)
