"""One robot driven by a law, without ROS: what each robot decides alone is what the simulator decides for all."""

from dataclasses import replace
from math import cos, inf, nan, pi, sin

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from fuzzyfleet_ros.controllersettings import setting_along, thinned
from fuzzyfleet_ros.frames import HERE, Posture, continued, heading_of, quaternion
from fuzzyfleet_ros.loopback import Loopback
from fuzzyfleet_ros.onboard import Onboard, OnboardError, OwnState, Perceived, Received, Remembered
from fuzzyfleet_ros.standing import CommandWatchdog
from robotics import load_robot, load_scenario, make_controller, simulate
from robotics.laws.catalogue import presets
from robotics.laws.law import ControllerError
from robotics.simulation.scenario.description import ScenarioError
from robotics.world.paths.path import PathError
from robotics.world.sensing.posture import Sensing
from tests.ros.together import drive, farthest

numbers = st.floats(-20, 20)
postures = st.builds(Posture, numbers, numbers, st.floats(-7, 7))


def close(one, other):
    assert one.x == pytest.approx(other.x, abs=1e-9)
    assert one.y == pytest.approx(other.y, abs=1e-9)
    assert cos(one.heading - other.heading) == pytest.approx(1, abs=1e-9)


def shortened(name, seconds):
    return replace(load_scenario(name), duration=seconds)


@given(postures, postures)
def test_a_frame_is_where_a_posture_is_another(one, same):
    close(same.inside(one.frame_of(same)), one)
    close(one.inside(HERE), one)


@given(st.floats(-3.1, 3.1), st.integers(-3, 3))
def test_headings_survive_quaternions_and_turns(heading, turns):
    z, w = quaternion(heading + 2 * pi * turns)
    assert continued(heading_of(0.0, 0.0, z, w), heading + 2 * pi * turns) == pytest.approx(heading + 2 * pi * turns)


def test_a_quaternion_that_nobody_filled_in_is_refused():
    with pytest.raises(ValueError, match="no length"):
        heading_of(0.0, 0.0, 0.0, 0.0)


@pytest.mark.parametrize(
    ("scenario", "law", "seconds"),
    [
        ("reference", "lyapunov", 5),
        ("noisy-position", "cooperation", 3),  # by radio
        ("formation-behind", "formation", 5),  # reads the others' places
        ("turn-into-neighbour", "obstacles", 4),  # looks
    ],
)
def test_robots_that_decide_alone_drive_as_the_simulator_lets_them(scenario, law, seconds):
    told = shortened(scenario, seconds)
    driven, run = drive(told, make_controller(law), 3), simulate(told, law, [3])
    assert farthest(driven, run) == 0.0
    assert np.array_equal(driven.samples[:, 8:10], run.samples[:, 8:10])  # the commands


def test_robots_that_hear_nothing_drive_otherwise():
    told = shortened("outage-10s", 30)
    run = simulate(told, "cooperation", [3])
    assert farthest(drive(told, make_controller("cooperation"), 3, deaf=(0, 1, 2)), run) > 0.01


@pytest.mark.long
@pytest.mark.parametrize(
    ("name", "seconds"),
    [("noisy-position", 4), ("outage-10s", 12), ("formation-ahead", 4), ("three-cross", 6), ("trap-u", 6)],
)
def test_every_law_of_velocities_drives_alone_as_in_the_simulator(name, seconds):
    told, driven = shortened(name, seconds), 0
    for law in (name for name in presets() if not name.endswith("-tuned")):  # other numbers in the same laws
        made = make_controller(law)
        if made.level == "torque" or made.estimator is not None:  # a robot's pose comes filtered by its topic
            continue
        try:
            run = simulate(told, law, [1])
        except ControllerError:
            continue
        driven += 1
        assert farthest(drive(told, made, 1), run) == 0.0, law
    assert driven > 8


def test_who_reads_where_the_others_are_is_found_out():
    setting = load_scenario("formation-behind").setting
    assert Onboard.of(setting, make_controller("leader-follower"), 1).sees_others
    assert not Onboard.of(setting, make_controller("fuzzy"), 1).sees_others


def test_a_law_of_torques_is_refused_or_drives_by_its_wish():
    setting, law = load_scenario("reference").setting, make_controller("csm")
    with pytest.raises(OnboardError, match=r"commands the torques of the wheels.*torque_as_velocity"):
        Onboard.of(setting, law)
    board = Onboard.of(setting, law, torque_as_velocity=True)
    order, _ = board.step(Perceived(0.0, OwnState(board.start, 0.0, 0.0), {}, board.silence()), board.begin())
    wish = simulate(shortened("reference", 0.05), "csm", [0])
    assert (order.v, order.w) == pytest.approx((wish["v_demand"][0, 0, 0], wish["w_demand"][0, 0, 0]))


def test_bounds_hold_and_robots_that_are_lost_stop():
    setting = load_scenario("reference").setting
    board = Onboard.of(setting, make_controller("fuzzy"), v_max=0.1, w_max=0.2)
    away = board.start._replace(y=board.start.y - 2)
    order, _ = board.step(Perceived(1.0, OwnState(away, 0.0, 0.0), {}, board.silence()), board.begin())
    assert abs(order.v) <= 0.1
    assert abs(order.w) == pytest.approx(0.2)
    far = board.start._replace(y=1e3)
    order, _ = board.step(Perceived(1.0, OwnState(far, 0.0, 0.0), {}, board.silence()), board.begin())
    assert (order.v, order.w) == (0.0, 0.0)
    assert "m from its target, and 10 m are allowed" in order.lost
    order, _ = board.step(Perceived(1.0, OwnState(far._replace(x=nan), 0.0, 0.0), {}, board.silence()), board.begin())
    assert "not a finite number" in order.lost


def test_a_robot_that_is_not_there_and_sensors_that_are_missing_are_sentences():
    setting = load_scenario("reference").setting
    with pytest.raises(OnboardError, match="robots are 1 to 1, got 4"):
        Onboard.of(setting, make_controller("fuzzy"), 3)
    bare = replace(setting, sensors=({},))
    with pytest.raises(ControllerError, match="lacks the range sensors"):
        Onboard.of(bare, make_controller("obstacles"))


def test_an_older_message_does_not_replace_a_newer_one():
    heard = Received.nothing(1, 2).with_message(1, 5.0, 0.1, [7.0])
    assert heard.with_message(1, 5.2, 0.5, [8.0]) is heard
    assert heard.with_message(1, 5.2, 0.1, [8.0]).values[0, 1] == 8.0
    assert heard.ages(6.0).tolist() == [inf, pytest.approx(1.1)]


def test_a_path_of_points_becomes_a_task():
    model = load_robot("turtlebot3-burger")
    setting = setting_along([(0, 0), (0.5, 0), (0.5, 0), (1, 0.2), (1.5, 0.2)], model, 0.15)
    assert setting.starts[0].tolist() == [0.0, 0.0, 0.0]
    end = setting.references.at(setting.ticks * setting.period)
    assert (end.x[0], end.y[0], end.v[0]) == (pytest.approx(1.5), pytest.approx(0.2), 0.0)
    run = drive_path(setting, "fuzzy")
    assert np.hypot(run["x"][0, 0, -1] - 1.5, run["y"][0, 0, -1] - 0.2) < 0.05
    with pytest.raises(PathError, match="at least two points"):
        setting_along([(0, 0), (0, 1e-5)], model, 0.15)
    with pytest.raises(ScenarioError, match="infeasible"):
        setting_along([(0, 0), (1, 0)], model, 3.0)


def drive_path(setting, law):
    board, loop = Onboard.of(setting, make_controller(law)), Loopback(setting, keeps=True)
    memory = board.begin()
    while not loop.over:
        seen = loop.sense()
        known = OwnState(Posture(*seen.posture[:, 0]), *seen.velocity[:, 0])
        order, memory = board.step(Perceived(loop.time, known, {}, board.silence()), memory)
        loop.command(0, order.v, order.w)
        loop.advance()
    loop.sense()
    loop.advance()
    return loop.run(law)


@given(st.lists(st.tuples(numbers, numbers), min_size=1, max_size=30), st.floats(0, 1))
def test_thinned_points_begin_and_end_as_all(points, spacing):
    kept = thinned(points, spacing)
    assert kept[0] == points[0]
    assert set(kept) <= set(points)
    assert np.hypot(kept[-1][0] - points[-1][0], kept[-1][1] - points[-1][1]) < 1e-3


@pytest.mark.parametrize(("patience", "moves"), [(0.5, False), (inf, True)])
def test_a_base_without_commands_stops_by_its_own_watchdog(patience, moves):
    loop = Loopback(load_scenario("reference").setting, patience=patience)
    for k in range(60):
        loop.sense()
        if k < 20:
            loop.command(0, 0.3, 0.0)
        loop.advance()
    assert (abs(loop.sense().speed[0, 0]) > 0.1) == moves


def test_a_robot_that_says_nothing_is_not_heard():
    scenario = load_scenario("noisy-position")
    loop = Loopback(scenario.setting, make_controller("cooperation"))
    for _ in range(20):
        loop.sense()
        loop.speak(0, [sin(1.0)] * len(loop.outside.message))
        loop.advance()
    age = loop.sense().heard.age[0]
    assert np.isfinite(age[1:, 0]).all()
    assert np.isinf(age[:, 1:]).all()


def test_the_watchdog_tells_what_is_missing_and_for_how_long():
    now = [0.0]
    standing = CommandWatchdog(0.5, 1.0, lambda: now[0])
    assert standing.reason() == "no odometry has come yet"
    standing.odometry_came()
    assert standing.reason(["left"]) == "no reading of left has come yet"
    standing.reading_came("left")
    assert standing.reason(["left"]) == ""
    now[0] = 0.6
    assert standing.reason() == "its odometry is older than 0.5 s"
    assert standing.stands(standing.reason())
    assert not standing.stands(standing.reason())
    now[0] = 1.8
    standing.odometry_came()
    assert standing.reason(["left"]) == "the reading of left is older than 1 s"
    assert standing.moves() == "the robot drives on after 1.2 s"
    assert standing.moves() == ""


def test_what_counts_as_a_new_message():
    dog = CommandWatchdog(0.5, 1.0, lambda: 0.0)
    assert dog.refusal("range", 10.0, 10.9, 1.0) == ""
    assert dog.refusal("range", 10.0, 10.9, 1.0) == "its stamp, 10 s, does not move on"
    assert dog.refusal("range", 9.9, 10.0, 1.0) == "its stamp, 9.9 s, does not move on"
    assert dog.refusal("range", 11.0, 12.5, 1.0) == "its stamp is 1.5 s behind the clock here"
    assert dog.refusal("radio", 1.0, 12.5) == ""  # a law knows what an old message is worth,
    assert dog.refusal("radio", 13.5, 12.5) == "its stamp is 1 s ahead of the clock here"  # but none of tomorrow
    assert dog.refusal("radio", 2.0, 0.0) == ""  # no clock yet
    assert dog.refusal("range", 12.0, 12.5, 1.0) == ""  # what was refused is not the last one
    assert dog.refusal("odometry", 0.0, 0.0) == dog.refusal("odometry", 0.0, 12.5, 0.5) == "its stamp is not set"


def test_what_is_ignored_is_said_again_only_after_a_while_without():
    now = [0.0]
    dog = CommandWatchdog(0.5, 1.0, lambda: now[0])
    told = []
    for k in range(100):  # a driver that sends each message twice, ten times a second
        now[0] = k / 10
        told.append(dog.refused("odometry"))
    assert told == [True] + 99 * [False]
    assert dog.refused("range")
    now[0] += 5.1
    assert dog.refused("odometry")


def test_reasons_to_stand_that_alternate_are_each_said_once_until_it_drives():
    dog = CommandWatchdog(0.5, 1.0, lambda: 0.0)
    said = [why for _ in range(10) for why in ("it is stopped for good", "its odometry is old") if dog.stands(why)]
    assert said == ["it is stopped for good", "its odometry is old"]
    assert dog.moves()
    assert dog.stands("its odometry is old")


def test_the_odometry_of_another_robot_that_a_law_reads_grows_old_too():
    now = [0.0]
    dog = CommandWatchdog(0.5, 1.0, lambda: now[0])
    dog.odometry_came("robot2")
    assert dog.reason() == "no odometry has come yet"
    now[0] = 0.4
    dog.odometry_came()
    assert dog.reason() == ""
    now[0] = 0.6
    assert dog.reason() == "the odometry of robot2 is older than 0.5 s"


@pytest.mark.parametrize(
    ("scenario", "law", "seconds"),
    [("turn-into-neighbour", "fuzzy-team", 18), ("three-cross", "fuzzy", 27)],  # its sensors, and by radio
)
def test_the_monitor_of_passive_safety_acts_on_board_as_in_the_simulator(scenario, law, seconds):
    told, guarded = replace(shortened(scenario, seconds), sensing=Sensing(posture="odometry")), f"{law}:safe=yes"
    driven, run = drive(told, make_controller(guarded), 3), simulate(told, guarded, [3])
    assert farthest(run, simulate(told, law, [3])) > 0.05  # it acts
    assert farthest(driven, run) == 0.0
    assert np.array_equal(driven.samples[:, :8], run.samples[:, :8])


def test_a_robot_that_was_let_stand_has_no_orders_on_their_way():
    told = replace(load_scenario("reference"), latency=0.2)
    board = Onboard.of(told.setting, make_controller("fuzzy:safe=yes"))
    memory, lane = board.begin(), board.robot
    for time in (0.0, 0.05, 0.1, 0.15, 0.2):
        seen = Perceived(time, OwnState(board.start, 0.0, 0.0), {}, board.silence(), {})
        order, memory = board.step(seen, memory)
    assert order.v > 0.05
    assert memory.guard.sent[:, 0, lane].max() > 0.05
    old = memory.guard.held[0, lane]
    assert old > 0.0
    for time in (10.2, 0.2):  # the time of the task goes on, or waits
        now = Perceived(time, *seen[1:5], clock=10.2)
        held = board.step(now, Remembered(memory.law, memory.guard, 4))[1]
        assert held.k == 204
        assert np.count_nonzero(memory.guard.sent[:, 0, lane]) <= 1  # that of now
        assert memory.guard.held[0, lane] == 0.0


def test_what_the_monitor_knows_outlasts_a_task():
    board = Onboard.of(load_scenario("reference").setting, make_controller("fuzzy:safe=yes"))
    known, ranges = OwnState(board.start, 0.0, 0.0), dict.fromkeys(board.needs, 0.4)
    memory = board.step(Perceived(0.0, known, {}, board.silence(), ranges), board.begin())[1]
    before = memory.guard.ground.copy()
    _, again = board.step(Perceived(0.0, known, {}, board.silence(), {}, (), clock=0.05), board.begin(memory))
    assert again.k == 1
    assert (before > 0).any()
    assert np.array_equal(again.guard.ground, before)


def test_a_reading_that_has_not_come_anew_is_not_looked_at_again():
    board = Onboard.of(load_scenario("turn-into-neighbour").setting, make_controller("fuzzy:safe=yes"))
    known, far = OwnState(board.start, 0.0, 0.0), dict.fromkeys(board.needs, 0.5)
    grounds = []
    for looked in ((), board.needs[:1], None):
        memory = board.step(Perceived(0.0, known, {}, board.silence(), {}), board.begin())[1]
        before = memory.guard.ground.copy()
        board.step(Perceived(0.05, known, {}, board.silence(), far, looked), memory)
        grounds.append(int((memory.guard.ground[board.robot] != before[board.robot]).sum()))
    assert grounds[0] == 0
    assert 0 < grounds[1] < grounds[2]


def test_the_monitor_of_a_law_of_torques_is_refused():
    with pytest.raises(ControllerError, match="commands torques"):
        Onboard.of(load_scenario("reference").setting, make_controller("csm:safe=yes"), torque_as_velocity=True)
