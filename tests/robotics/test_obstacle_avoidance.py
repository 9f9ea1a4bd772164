"""Obstacle avoidance: the rule base is its formula, the side is kept, the group goes on without who is stuck."""

from dataclasses import replace

import numpy as np
import pytest

from robotics import plant as p
from robotics.controllers import gains_of, make_controller
from robotics.coordination.commitment import BEST, MODE, NET, ROWS, STALL, WALL, WAY, commit
from robotics.environment.collision import footprints, obstacle_clearance, robot_contacts
from robotics.events import ALONE, AVOID, FOLLOW, MODES, TRACK, Event, mode_events
from robotics.scenario import ScenarioError, load_scenario, parse_scenario, scenario_names
from robotics.simulation import drive, simulate

DT = 0.05
FREE = np.inf


def looks(*readings):
    return np.array([[readings]], dtype=float)


def step(state, readings, alpha=0.0, place=1.0, off=0.0, remaining=5.0, pose=(0.0, 0.0, 0.0)):
    one = [np.array([[v]]) for v in (alpha, place, off, remaining)]
    seen = looks(*readings)
    return commit(state, seen, seen, np.array(pose)[:, None, None], *one, 0.5, DT)


def fresh():
    return np.zeros((ROWS, 1, 1))


# The rule base ----------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(("name", "ro_min"), [("obstacles", 0.5), ("obstacles-literal", 0.8), ("obstacles", 1.3)])
def test_theta_equals_its_formula(name, ro_min):
    law = make_controller(f"{name}:ro_min={ro_min}")
    ro = np.array([0.0, 0.1, 0.15, 0.2, 0.31, 0.475, 0.5, 0.79, 0.8, 1.0, 2.0, np.inf])
    with np.errstate(invalid="ignore"):
        expected = 1.6 * np.clip((ro_min - ro) / (ro_min - 0.15), 0.0, 1.0)
    np.testing.assert_allclose(law.theta_at(ro), expected, atol=1e-12)


def test_gains_are_those_that_have_an_effect():
    assert "push" not in gains_of(make_controller("obstacles"))
    assert "reach" not in gains_of(make_controller("obstacles-literal"))
    assert gains_of(make_controller("obstacles"))["patience"] == 15.0


# Commitment -------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(("left", "right", "way"), [(0.4, 0.49, -1.0), (0.49, 0.4, 1.0)])
def test_the_first_detection_chooses_the_side_and_it_is_kept(left, right, way):
    state, steer = step(fresh(), (left, right, FREE, FREE))
    assert state[MODE, 0, 0] == AVOID
    assert state[WAY, 0, 0] == way
    for _ in range(10):  # the other reading is smaller now, but not by much
        state, steer = step(state, (right, left, FREE, FREE))
    assert state[WAY, 0, 0] == way
    assert 0 < steer.v[0, 0] < 0.28


def test_alike_readings_go_the_way_of_the_path():
    assert step(fresh(), (0.4, 0.4, FREE, FREE), alpha=0.3)[0][WAY, 0, 0] == 1
    assert step(fresh(), (0.4, 0.4, FREE, FREE), alpha=-0.3)[0][WAY, 0, 0] == -1


def test_the_side_is_given_up_once_all_has_been_free_for_1_2_s():
    state, _ = step(fresh(), (0.4, 0.6, FREE, FREE))
    for _ in range(23):
        state, _ = step(state, (FREE, FREE, FREE, FREE))
    assert state[MODE, 0, 0] == AVOID
    state, _ = step(state, (FREE, FREE, 0.4, FREE))  # the obstacle is to the left, beside the robot
    for _ in range(23):
        state, _ = step(state, (FREE, FREE, FREE, FREE))
    assert state[MODE, 0, 0] == AVOID
    for _ in range(2):
        state, _ = step(state, (FREE, FREE, FREE, FREE))
    assert state[MODE, 0, 0] == TRACK


def test_the_target_does_not_pull_towards_an_obstacle_beside():
    state, _ = step(fresh(), (0.4, 0.6, FREE, FREE))  # on the left: round it to the right
    beside = (FREE, FREE, 0.3, FREE)
    assert step(state, beside, alpha=0.7)[1].alpha[0, 0] == 0.0
    assert step(state, beside, alpha=-0.7)[1].alpha[0, 0] == -0.7
    assert step(state, (FREE, FREE, FREE, FREE), alpha=0.7)[1].alpha[0, 0] == 0.7


def test_it_stops_where_the_front_is_blocked():
    state, steer = step(fresh(), (0.12, 0.3, FREE, FREE))
    assert steer.v[0, 0] == 0.0
    assert step(state, (0.32, 0.4, FREE, FREE))[1].v[0, 0] == pytest.approx(0.28 / 2)


def test_what_is_behind_the_end_of_the_path_is_not_avoided():
    assert step(fresh(), (0.45, 0.48, FREE, FREE), remaining=0.3)[0][MODE, 0, 0] == TRACK
    assert step(fresh(), (0.45, 0.48, FREE, FREE), remaining=0.5)[0][MODE, 0, 0] == AVOID


def test_without_progress_it_follows_the_wall_and_leaves_it_beyond():
    state, _ = step(fresh(), (0.4, 0.3, FREE, FREE))
    for _ in range(round(STALL / DT) - 2):
        state, _ = step(state, (0.4, 0.3, FREE, FREE))
    assert state[MODE, 0, 0] == AVOID
    for _ in range(4):
        state, _ = step(state, (0.4, 0.3, FREE, FREE))
    assert state[MODE, 0, 0] == FOLLOW
    state, _ = step(state, (FREE, FREE, FREE, 0.3), alpha=0.5, place=1.05)
    assert state[MODE, 0, 0] == FOLLOW  # not beyond
    assert state[WALL, 0, 0] == 1
    assert step(state, (FREE, FREE, FREE, 0.3), alpha=-0.5, place=1.2)[0][MODE, 0, 0] == FOLLOW  # through the wall
    assert step(state, (FREE, FREE, FREE, 0.3), alpha=0.5, place=1.2)[0][MODE, 0, 0] == AVOID


def test_along_a_wall_the_speed_and_the_sign_of_the_turn():
    state = fresh()
    state[MODE], state[WAY], state[WALL], state[BEST], state[NET] = FOLLOW, 1, 1, 1, 1  # the wall is on the right
    even = 0.29 / np.sin(np.radians(57))  # what the front sonar reads of a wall at 0.25 m
    turn = {}
    for side in (0.15, 0.25, 0.35):
        seen = (FREE, even + (side - 0.25) / np.sin(np.radians(57)), FREE, side)
        turn[side] = step(state, seen, pose=(1.0, 2.0, 0.3))[1].w[0, 0]
    assert turn[0.25] == pytest.approx(0.0, abs=1e-9)
    assert turn[0.15] > 0.3  # away, to the left
    assert turn[0.35] < -0.3


def test_round_the_end_of_a_wall_it_circles_where_it_saw_it_last():
    state = fresh()
    state[MODE], state[WAY], state[WALL], state[BEST], state[NET] = FOLLOW, 1, 1, 1, 1  # the wall is on the right
    state, _ = step(state, (FREE, FREE, FREE, 0.25))  # 0.35 m to the right of the origin
    _, steer = step(state, (FREE, FREE, FREE, FREE))
    assert steer.w[0, 0] == pytest.approx(-steer.v[0, 0] / 0.35)


# Runs -------------------------------------------------------------------------------------------------------------


def run(name, law, seeds=(0,)):
    scenario = load_scenario(name)
    sizes = footprints([member.robot for member in scenario.robots])
    paths = scenario.trajectory.joined
    ends = paths.at(paths.lengths)
    shape = (len(seeds), len(scenario.robots))
    arrivals, clear, modes, times, touched = np.full(shape, np.inf), np.inf, [], [], False
    for period in drive(scenario, law, seeds):
        x, y, heading = period.state[[p.X, p.Y, p.HEADING]]
        clear = min(clear, obstacle_clearance(x, y, heading, sizes, scenario.world.at(period.time)).min())
        touched |= bool((robot_contacts(x, y, heading, sizes) >= 0).any())
        there = np.hypot(x - ends.x, y - ends.y) < 0.036
        arrivals = np.where(there & np.isinf(arrivals), period.time, arrivals)
        modes.append(period.command.mode)
        times.append(period.time)
        if np.isfinite(arrivals).all():
            break
    return arrivals, clear, touched, np.array(modes), np.array(times)


@pytest.mark.parametrize("name", [n for n in scenario_names() if n.startswith(("chapter-6-s", "chapter-6-e"))])
def test_teams_pass_and_arrive_together(name):
    arrivals, clear, touched, modes, _ = run(name, make_controller("obstacles"), (0, 1))
    assert np.isfinite(arrivals).all()
    assert (np.ptp(arrivals, axis=1) <= 0.2).all()
    assert clear > 0.1
    assert not touched
    assert (modes[-1] == TRACK).all()


def test_case_study_3():
    arrivals, clear, touched, modes, times = run("chapter-6-case-3", make_controller("obstacles"))
    assert np.isfinite(arrivals).all()
    assert clear > 0.05
    assert not touched
    events = mode_events(times, modes)
    assert [e.time for e in events] == sorted(e.time for e in events)
    assert {e.robot for e in events} >= {0, 1}


def test_the_group_goes_on_without_a_stuck_robot():
    arrivals, clear, _, modes, times = run("chapter-6-simulation-3", make_controller("obstacles-literal"))
    assert np.isinf(arrivals[0, 0])
    assert np.isfinite(arrivals[0, 1:]).all()
    assert np.ptp(arrivals[0, 1:]) <= 0.2
    assert clear > 0
    avoids, alone = (times[np.argmax(modes[:, 0, 0] == code)] for code in (AVOID, AVOID + ALONE))
    assert alone - avoids >= 15.0
    assert (modes[:, 0, 1:] & ALONE == 0).all()


def test_a_robot_that_comes_free_is_taken_back():
    """Left behind after 2 s, and yet all arrive together: the group waits as soon as the robot tracks again."""
    arrivals, _, _, modes, _ = run("chapter-6-simulation-3", make_controller("obstacles:patience=2"))
    assert (modes[:, 0, 0] == AVOID + ALONE).any()
    assert np.isfinite(arrivals).all()
    assert np.ptp(arrivals) <= 0.5


def test_events_are_the_changes_of_mode():
    modes = np.array([[[0, 0]], [[1, 0]], [[1, 3]], [[1, 0]]])
    assert mode_events(np.arange(4) * 0.5, modes) == [
        Event(0.5, 0, 0, "tracking", "avoiding"),
        Event(1.0, 0, 1, "tracking", "yielding"),
        Event(1.5, 0, 1, "yielding", "tracking"),
    ]
    assert len(MODES) == 8


# Wiring -----------------------------------------------------------------------------------------------------------


def test_without_obstacles_nothing_is_sensed_and_it_cooperates():
    scenario = replace(load_scenario("chapter-6-simulation-1"), obstacles=(), duration=3.0)
    assert scenario.world is None
    a = simulate(scenario, make_controller("obstacles"), (0,))
    b = simulate(scenario, make_controller("cooperation"), (0,))
    assert np.array_equal(a["x"], b["x"])


def test_a_seed_gives_the_same_bits_alone_and_among_others():
    scenario = replace(load_scenario("chapter-6-simulation-1"), duration=15.0)
    law = make_controller("obstacles")
    together = simulate(scenario, law, (3, 0, 9))
    alone = simulate(scenario, law, (9,))
    assert together.samples[:, :, 2:].tobytes() == alone.samples.tobytes()


TABLE = """
kind = "team"
duration = 3.0
[[robots]]
start = [0.0, 0.0, 0.0]
path = { shape = "line", start = [0.0, 0.0], end = [2.0, 0.0] }
timing = { duration = 10.0 }
[[robots]]
start = [0.0, 1.0, 0.0]
path = { shape = "line", start = [0.0, 1.0], end = [2.0, 1.0] }
timing = { duration = 10.0 }
[[obstacles]]
shape = "disc"
position = [1.0, 2.0]
radius = 0.3
[[obstacles]]
"""


@pytest.mark.parametrize(
    ("lines", "message"),
    [
        ("radius = 1.0", r"^bad\.toml:16: an obstacle lacks shape, one of disc, polygon, wall, box"),
        ('shape = "blob"', r"^bad\.toml:17: unknown obstacle shape"),
        ('shape = "disc"\nradius = -1.0', r"^bad\.toml:18: radius must be .* m"),
        ('shape = "disc"\nwidth = 1.0', r"^bad\.toml:18: "),
        ('shape = "box"\nlength = 1.0', r"^bad\.toml:16: obstacle of shape 'box' lacks width"),
        ('shape = "box"\nlength = 1.0\nwidth = -2', r"^bad\.toml:19: width must be"),
        ('shape = "regular"\nsides = 2\nradius = 1.0', r"^bad\.toml:18: sides must be"),
        ('shape = "u"\nwidth = 1.0\ndepth = 1.0\nheading = 90', r"^bad\.toml:20: heading must be .* rad"),
        ('shape = "box"\nlength = 1.0\nwidth = 1.0\nradius = 3', r"^bad\.toml:20: "),
        ('shape = "polygon"\ncorners = [[0.0, 0.0], [1.0, 0.0]]', r"^bad\.toml:18: corners must be at least 3"),
        ('shape = "wall"\npoints = 3', r"^bad\.toml:18: points must be"),
        (
            'shape = "disc"\npath = { shape = "line", start = [0.0, 0.0], end = [1.0, 0.0] }',
            r"^bad\.toml:\d+: timing is",
        ),
        ('shape = "disc"\npath = 3', r"^bad\.toml:18: path must be a table"),
    ],
)
def test_what_is_wrong_with_an_obstacle_is_said_with_its_line(lines, message):
    with pytest.raises(ScenarioError, match=message):
        parse_scenario(TABLE + lines + "\n", "bad", "bad.toml")


def test_obstacles_of_a_file():
    moving = (
        'shape = "u"\nwidth = 1.0\ndepth = 0.5\ntiming = { speed = 0.1 }\n'
        'path = { shape = "line", start = [0.0, 0.0], end = [1.0, 0.0] }\n'
    )
    scenario = parse_scenario(TABLE + moving, "good", "good.toml")
    assert len(scenario.obstacles) == 2
    geometry = scenario.world.at(5.0)
    np.testing.assert_allclose(geometry.circles[0, 0], [1.0, 2.0, 0.3])
    before = scenario.world.at(0.0).segments[0]
    np.testing.assert_allclose(geometry.segments[0] - before, np.tile([0.5, 0.0, 0.5, 0.0], (8, 1)), atol=1e-9)
