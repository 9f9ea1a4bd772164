"""Obstacle avoidance: the rule base is its formula, the side is kept, the group goes on without who is stuck."""

from dataclasses import replace
from functools import cache
from typing import Any, NamedTuple

import numpy as np
import pytest

from fuzzy.compiled.jit import kernel
from robotics.laws.avoidance.obstacle_avoidance import ObstacleAvoidance, ObstacleWork, theta_at
from robotics.laws.avoidance.obstacle_modes import (
    LOOSE,
    RELIEF,
    STALL,
    TIGHT,
    UNSEEN,
    ModeMemory,
    MountColumns,
    SonarColumns,
    WallColumns,
    WatchMemory,
    mounting,
    next_mode,
    nothing_watched,
    stand_still,
)
from robotics.laws.catalogue import gains_of, make_controller
from robotics.laws.equation import RobotColumns, gain_columns
from robotics.laws.modes import AVOID, FOLLOW, LEFT_BEHIND, MODES, STOPPED, TRACK, YIELD
from robotics.simulation.loop import simulate
from robotics.simulation.mode_changes import REJOINED, TIMED_OUT, ModeChange, mode_change_table, mode_changes_in, reason
from robotics.simulation.run import load_run
from robotics.simulation.scenario.description import ScenarioError
from robotics.simulation.scenario.reading import load_scenario, parse_scenario
from robotics.studies.together import run_together
from robotics.world.environment.collision import obstacle_clearance
from robotics.world.environment.world import Disc
from robotics.world.paths.path import Line
from robotics.world.paths.trajectory import Timing
from robotics.world.sensing.sonar import SONAR

DT = 0.05
Gain = gain_columns(ObstacleAvoidance)
MOUNTED = MountColumns(np.array(MountColumns.stacked(mounting([SONAR])))[:, 0])
FREE = np.inf
SIZES = np.array([[0.115], [0.1], [0.153]])  # m: half a robot's length and width, and its half diagonal
POINT = np.full((3, 1), 1e-6)


class Steering(NamedTuple):
    alpha: float
    v: float
    w: float
    front: float


@kernel
def stepped(state, readings, pose, alpha, place, off, remaining, walls):
    seen = SonarColumns(readings)
    return next_mode(
        ModeMemory(state), seen, seen, RobotColumns(pose), alpha, place, off, remaining, 0.5, DT, WallColumns(walls)
    )


@kernel
def stands(watch, readings, speed, turning):
    return stand_still(WatchMemory(watch), SonarColumns(readings), speed, turning, DT)


def step(state, readings, alpha=0.0, place=1.0, off=0.0, remaining=5.0, pose=(0.0, 0.0, 0.0)):
    """The state after a period, and the bearing, v, ω and front distance that the mode asks for."""
    after, walls = ModeMemory(state.array.copy()), MOUNTED.walls.array
    given = np.array(readings, dtype=float), np.array([*pose, 0.0, 0.0])
    return after, Steering(*stepped(after.array, *given, alpha, place, off, remaining, walls))


def fresh():
    return ModeMemory.zeros()


# The rule base ----------------------------------------------------------------------------------------------------


@kernel
def thetas_at(distances, gains, theta, work):
    found, gain = np.empty(len(distances)), Gain(gains, 0)
    for n in range(len(distances)):
        found[n] = theta_at(distances[n], gain, theta, ObstacleWork(work))
    return found


@pytest.mark.parametrize(("name", "ro_min"), [("obstacles", 0.5), ("obstacles-literal", 0.8), ("obstacles", 1.3)])
def test_theta_equals_its_formula(name, ro_min):
    law: Any = make_controller(f"{name}:ro_min={ro_min}")
    ro = np.array([0.0, 0.1, 0.15, 0.2, 0.31, 0.475, 0.5, 0.79, 0.8, 1.0, 2.0, np.inf])
    with np.errstate(invalid="ignore"):
        expected = 1.6 * np.clip((ro_min - ro) / (ro_min - 0.15), 0.0, 1.0)
    gains = law.setup(load_scenario("turn-into-neighbour").setting, 1).gains
    found = thetas_at(ro, gains, law.turn.system, np.empty(law.working))
    np.testing.assert_allclose(found, expected, atol=1e-12)


def test_gains_are_those_that_have_an_effect():
    assert "push" not in gains_of(make_controller("obstacles"))
    assert "reach" not in gains_of(make_controller("obstacles-literal"))
    assert gains_of(make_controller("obstacles"))["patience"] == 15.0


# Commitment -------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(("left", "right", "way"), [(0.4, 0.49, -1.0), (0.49, 0.4, 1.0)])
def test_the_first_detection_chooses_the_side_and_it_is_kept(left, right, way):
    state, steer = step(fresh(), (left, right, FREE, FREE))
    assert state.mode == AVOID
    assert state.way == way
    for _ in range(10):  # the other reading is smaller now, but not by much
        state, steer = step(state, (right, left, FREE, FREE))
    assert state.way == way
    assert 0 < steer.v < 0.28


def test_alike_readings_go_the_way_of_the_path():
    assert step(fresh(), (0.4, 0.4, FREE, FREE), alpha=0.3)[0].way == 1
    assert step(fresh(), (0.4, 0.4, FREE, FREE), alpha=-0.3)[0].way == -1


def test_the_side_is_given_up_once_all_has_been_free_for_1_2_s():
    state, _ = step(fresh(), (0.4, 0.6, FREE, FREE))
    for _ in range(23):
        state, _ = step(state, (FREE, FREE, FREE, FREE))
    assert state.mode == AVOID
    state, _ = step(state, (FREE, FREE, 0.4, FREE))  # the obstacle is to the left, beside the robot
    for _ in range(23):
        state, _ = step(state, (FREE, FREE, FREE, FREE))
    assert state.mode == AVOID
    for _ in range(2):
        state, _ = step(state, (FREE, FREE, FREE, FREE))
    assert state.mode == TRACK


def test_the_target_pulls_the_less_towards_an_obstacle_the_nearer_it_is_beside():
    state, _ = step(fresh(), (0.4, 0.6, FREE, FREE))  # on the left: round it to the right
    pulls = [step(state, (FREE, FREE, beside, FREE), alpha=0.4)[1].alpha for beside in (0.1, TIGHT, 0.25, LOOSE)]
    assert pulls[0] < 0  # away
    assert pulls[1] == pytest.approx(0.0)
    assert pulls[2] == pytest.approx(0.4 * (0.25 - TIGHT) / (LOOSE - TIGHT))
    assert pulls[3] == pytest.approx(0.4)
    assert step(state, (FREE, FREE, 0.3, FREE), alpha=-0.7)[1].alpha == -0.7
    assert step(state, (FREE, FREE, FREE, FREE), alpha=0.7)[1].alpha == UNSEEN  # it may just have lost it


def test_an_obstacle_that_one_front_sonar_sees_counts_as_farther():
    state, steer = step(fresh(), (0.4, 0.45, FREE, FREE))
    assert steer.front == 0.4
    assert step(state, (0.4, FREE, FREE, FREE))[1].front == pytest.approx(0.4 + RELIEF)


def test_the_side_is_chosen_by_what_the_sonars_read_for_a_while():
    state = fresh()
    for _ in range(40):
        state, _ = step(state, (0.7, 0.75, FREE, FREE))
    state, _ = step(state, (0.49, 0.45, FREE, FREE))  # noise
    assert state.way == -1


def test_it_stops_where_the_front_is_blocked():
    state, steer = step(fresh(), (0.12, 0.3, FREE, FREE))
    assert steer.v == 0.0
    assert step(state, (0.32, 0.4, FREE, FREE))[1].v == pytest.approx(0.28 / 2)


def test_what_is_behind_the_end_of_the_path_is_not_avoided():
    assert step(fresh(), (0.45, 0.48, FREE, FREE), remaining=0.3)[0].mode == TRACK
    assert step(fresh(), (0.45, 0.48, FREE, FREE), remaining=0.5)[0].mode == AVOID


def test_without_progress_it_follows_the_wall_and_leaves_it_beyond():
    state, _ = step(fresh(), (0.4, 0.3, FREE, FREE))
    for _ in range(round(STALL / DT) - 2):
        state, _ = step(state, (0.4, 0.3, FREE, FREE))
    assert state.mode == AVOID
    for _ in range(4):
        state, _ = step(state, (0.4, 0.3, FREE, FREE))
    assert state.mode == FOLLOW
    state, _ = step(state, (FREE, FREE, FREE, 0.3), alpha=0.5, place=1.05)
    assert state.mode == FOLLOW  # not beyond
    assert state.wall == 1
    assert step(state, (FREE, FREE, FREE, 0.3), alpha=-0.5, place=1.2)[0].mode == FOLLOW  # through the wall
    assert step(state, (FREE, FREE, FREE, 0.3), alpha=0.5, place=1.2)[0].mode == AVOID


def test_along_a_wall_the_speed_and_the_sign_of_the_turn():
    state = fresh()
    state.mode, state.way, state.wall, state.best, state.net = FOLLOW, 1, 1, 1, 1  # the wall is on the right
    even = 0.29 / np.sin(np.radians(57))  # what the front sonar reads of a wall at 0.25 m
    turn = {}
    for side in (0.15, 0.25, 0.35):
        seen = (FREE, even + (side - 0.25) / np.sin(np.radians(57)), FREE, side)
        turn[side] = step(state, seen, pose=(1.0, 2.0, 0.3))[1].w
    assert turn[0.25] == pytest.approx(0.0, abs=1e-9)
    assert turn[0.15] > 0.3  # away, to the left
    assert turn[0.35] < -0.3


def test_round_the_end_of_a_wall_it_circles_where_it_saw_it_last():
    state = fresh()
    state.mode, state.way, state.wall, state.best, state.net = FOLLOW, 1, 1, 1, 1  # the wall is on the right
    state, _ = step(state, (FREE, FREE, FREE, 0.25))  # 0.35 m to the right of the origin
    _, steer = step(state, (FREE, FREE, FREE, FREE))
    assert steer.w == pytest.approx(-steer.v / 0.35)


# What moves -------------------------------------------------------------------------------------------------------


def halts(readings, turning=0.0, speed=0.0, watch=None):
    """For which of the periods, with the nearest reading [m] of each, does a robot stand still, or leave?"""
    if watch is None:
        watch = WatchMemory.zeros()
        nothing_watched(watch)
    out = []
    for reading in readings:
        out.append(bool(stands(watch.array, np.array([FREE, FREE, reading, FREE]), speed, turning)))
    return np.array(out)


def test_a_robot_stands_as_long_as_something_near_comes_nearer():
    still = halts(np.linspace(0.5, 0.02, 100))  # 0.1 m/s
    assert not still[:80].any()
    assert still[82:].all()


def test_what_stands_is_no_reason_to_stand_for_ever_nor_again():
    noise = np.random.default_rng(0).normal(scale=0.01, size=200)
    still = halts(np.full(200, 0.09) + noise)
    assert still[0]
    assert 0.9 <= DT * still.sum() <= 6.1
    assert not still[still.sum() :].any()
    again = halts([0.08] * 60 + [0.02] * 3)  # but before what is nearer
    assert not again[59]
    assert again[60:].all()


def test_a_robot_that_turns_quickly_stands_earlier_for_its_corners():
    assert not halts([0.15])[0]
    assert halts([0.15], turning=-5.0)[0]


def test_what_is_not_seen_any_more_is_given_time_to_pass():
    still = halts([0.1] * 5 + [FREE] * 100)
    assert 3.0 <= DT * still.sum() <= 4.5  # from when the smoothed reading has grown


def test_who_has_left_far_enough_goes_on():
    away = halts([0.1] * 5 + [FREE] * 100, speed=0.5)
    assert DT * away.sum() == pytest.approx(0.6 / 0.5, abs=2 * DT)
    beside = 0.07 + 0.03 * np.sin(np.arange(100) * DT * np.pi)
    assert halts(beside, speed=0.5)[: round(5.0 / DT)].all()  # but not from what is still as near


# Runs -------------------------------------------------------------------------------------------------------------


# All scenarios of a law in one pass: each run is, to the last bit, that of its scenario alone (test_avoidance_chapter).
SIMULATIONS = ["obstacles-on-two-paths", "turn-into-neighbour", "trap-u", "obstacles-on-outer-paths"]
COURSES = {
    "obstacles": [*SIMULATIONS, "wait-for-one", "neighbour-stops", "turn-towards-each-other", "trap-u-middle"],
    "obstacles-literal": [*SIMULATIONS, "neighbour-stops", "trap-u-middle"],
}
LONGEST = {"obstacles": 100.0, "obstacles-literal": 52.0}  # s


def crossed():
    """Case study 1 with a disc that crosses all three lanes, 0.2 m/s, in place of its obstacle."""
    disc = Disc(radius=0.2, path=Line(start=(3.3, -1.2), end=(3.3, 4.0)), timing=Timing(speed=0.2))
    return replace(load_scenario("wait-for-one"), name="crossed", obstacles=(disc,), duration=45.0)


@cache
def passed(law):
    """The runs of ``law`` by scenario."""
    scenarios = [load_scenario(name) for name in COURSES[law]] + [crossed()] * (law == "obstacles")
    return {run.scenario: run for run in run_together(scenarios, law, [0], LONGEST[law])}


def ran(name, law):
    return passed(law)[name]


def arrivals(run):
    """(robots,) s: when each first was at the end of its path; infinite: never."""
    ends = np.array([nodes[:, -1] for nodes in run.paths])
    there = np.hypot(run["x"][0] - ends[:, :1], run["y"][0] - ends[:, 1:]) < 0.036
    return np.where(there.any(axis=1), run.time[there.argmax(axis=1)], np.inf)


def clearance(run, sizes=SIZES):
    """(samples, robots) m from the obstacles."""
    x, y, heading = (run[name][0].T for name in ("x", "y", "heading"))
    return obstacle_clearance(x, y, heading, np.tile(sizes, (1, x.shape[1])), run.obstacles)


def off_path(run):
    """(robots, samples) m"""
    x, y = run["x"][0], run["y"][0]
    return np.array([np.hypot(x[i, :, None] - p[0], y[i, :, None] - p[1]).min(axis=1) for i, p in enumerate(run.paths)])


def least_distance(run):
    x, y = run["x"][0], run["y"][0]
    return min(np.hypot(x[i] - x[j], y[i] - y[j]).min() for i in range(len(x)) for j in range(i))


def stopped_for(run, robot):
    """s, while it should be driving"""
    still = np.abs(run["v"][0, robot]) < 0.02
    return DT * np.count_nonzero(still & (run.time > 3) & (run.time < 30))


def duration(name):
    return load_scenario(name).trajectory.ends.max()


@pytest.mark.parametrize("name", ["obstacles-on-two-paths", "obstacles-on-outer-paths", "wait-for-one"])
def test_obstacles_on_the_way_are_passed_narrowly(name):
    """Rows S1 and E1: centre clearance ≥ 0.25 m, ≤ 0.6 m off the path, back in ≤ 9 s, arriving together."""
    run = ran(name, "obstacles")
    assert np.ptp(arrivals(run)) <= 0.2
    assert clearance(run).min() > 0.1
    assert clearance(run, POINT).min() >= 0.25
    off = off_path(run)
    assert off.max() <= 0.6
    assert (off > 0.1).sum(axis=1).max() * DT <= 9.0
    assert (run.modes[-1] == TRACK).all()


@pytest.mark.parametrize("name", ["obstacles-on-two-paths", "obstacles-on-outer-paths"])
def test_the_literal_scheme_passes_them_as_well(name):
    run = ran(name, "obstacles-literal")
    assert np.ptp(arrivals(run)) <= 0.2
    assert clearance(run).min() > 0
    assert (off_path(run) > 0.1).sum(axis=1).max() * DT <= 9.0


@pytest.mark.parametrize("name", ["turn-into-neighbour", "neighbour-stops"])
@pytest.mark.parametrize("law", ["obstacles", "obstacles-literal"])
def test_the_lower_priority_stops_for_who_avoids(name, law):
    """Row S2: robot 2 stops ≥ 1 s, no two robots are nearer than 0.45 m, t ≤ 1.1 T."""
    run = ran(name, law)
    arrived = arrivals(run)
    assert np.ptp(arrived) <= 0.2
    assert arrived.max() <= 1.1 * duration(name)
    assert least_distance(run) >= 0.45
    assert stopped_for(run, 1) >= 1.0
    assert (run.modes[:, 0, 1] == YIELD).any()
    assert not (run.modes[:, 0, 0] == YIELD).any()
    if law == "obstacles":
        assert clearance(run).min() > 0.1


def test_who_avoids_towards_each_other_passes():
    run = ran("turn-towards-each-other", "obstacles")
    assert np.ptp(arrivals(run)) <= 0.2
    assert clearance(run).min() > 0.05
    assert least_distance(run) > 0.31
    assert set(mode_change_table(run)["robot"]) >= {1, 2}


@pytest.mark.parametrize(("name", "stuck"), [("trap-u", 0), ("trap-u-middle", 1)])
def test_the_group_goes_on_without_a_stuck_robot(name, stuck):
    """Row S3, literal: out of the group after the time-out, and the others arrive together."""
    run = ran(name, "obstacles-literal")
    arrived, others = arrivals(run), np.arange(3) != stuck
    assert np.isinf(arrived[stuck])
    assert np.ptp(arrived[others]) <= 0.2
    assert clearance(run).min() > 0
    events = mode_change_table(run)
    events = events[events["robot"] == stuck + 1]
    out = events[events["why"].str.contains(TIMED_OUT)].iloc[0]
    before = events[(events["time"] < out["time"]) & (events["from"] == "tracking")].iloc[0]
    assert out["time"] - before["time"] >= 15.0
    assert (run.modes[:, 0, others] & LEFT_BEHIND == 0).all()


@pytest.mark.parametrize("name", ["trap-u", "trap-u-middle"])
def test_the_committed_scheme_escapes(name):
    """Row S3, smarter."""
    run = ran(name, "obstacles")
    assert np.ptp(arrivals(run)) <= 0.2
    assert clearance(run).min() > 0.05


def test_a_robot_that_comes_free_is_taken_back():
    """Left behind after 2 s, and yet all arrive together: the group waits as soon as the robot tracks again."""
    scenario = replace(load_scenario("trap-u"), duration=75.0)
    (run,) = run_together([scenario], "obstacles:patience=2", [3], 75.0)
    assert np.ptp(arrivals(run)) <= 0.5
    why = "; ".join(mode_change_table(run)["why"])
    assert why.index(TIMED_OUT) < why.index(REJOINED)


def test_it_stops_or_turns_before_a_disc_that_crosses_its_lane():
    run = ran("crossed", "obstacles")
    assert len(run.obstacles.counts) == len(run.time)
    assert clearance(run).min() > 0
    assert np.isfinite(arrivals(run)).all()
    assert (run.modes[:, 0] == AVOID).any()


# Events -----------------------------------------------------------------------------------------------------------


def test_events_are_the_changes_of_mode():
    modes = np.array([[[0, 0]], [[1, 0]], [[5, 3]], [[1, 0]]])
    assert mode_changes_in(np.arange(4) * 0.5, modes) == [
        ModeChange(0.5, 0, 0, "tracking", "avoiding", "an obstacle is near"),
        ModeChange(1.0, 0, 0, "avoiding", "avoiding, left behind", TIMED_OUT),
        ModeChange(1.0, 0, 1, "tracking", "yielding", "another robot, or what may move, is near"),
        ModeChange(1.5, 0, 0, "avoiding, left behind", "avoiding", REJOINED),
        ModeChange(1.5, 0, 1, "yielding", "tracking", "its way is free"),
    ]
    assert reason(AVOID, STOPPED).startswith("its command")


def test_every_change_between_two_modes_has_a_reason():
    codes = range(2 * LEFT_BEHIND)
    assert all(reason(a, b) for a in codes for b in codes if a != b)
    assert len(MODES) == STOPPED + 1


def test_a_run_keeps_its_modes_ranges_and_obstacles(tmp_path):
    run = ran("turn-into-neighbour", "obstacles")
    run.save(tmp_path / "run.npz")
    again = load_run(tmp_path / "run.npz")
    assert again.modes.dtype == np.int8
    assert np.array_equal(again.modes, run.modes)
    assert np.array_equal(again.ranges, run.ranges)
    assert all(np.array_equal(a, b) for a, b in zip(again.obstacles, run.obstacles, strict=True))
    assert mode_change_table(again).equals(mode_change_table(run))
    assert list(mode_change_table(run).columns) == ["seed", "time", "robot", "from", "to", "why"]
    assert (run.frame()["mode"] == "yielding").sum() == (run.modes == YIELD).sum()


def test_a_law_without_modes_has_no_events():
    scenario = replace(load_scenario("obstacles-on-two-paths"), obstacles=(), duration=1.0)
    run = simulate(scenario, make_controller("cooperation"), (0,))
    assert run.modes is None
    assert run.obstacles is None
    assert mode_change_table(run).empty


# Wiring -----------------------------------------------------------------------------------------------------------


def test_without_obstacles_nothing_is_sensed_and_it_cooperates():
    scenario = replace(load_scenario("obstacles-on-two-paths"), obstacles=(), duration=3.0)
    assert scenario.setting.world is None
    a = simulate(scenario, make_controller("obstacles"), (0,))
    b = simulate(scenario, make_controller("cooperation:steering_distance=0,catch_up=1"), (0,))
    assert np.array_equal(a["x"], b["x"])


def test_a_seed_gives_the_same_bits_alone_and_among_others():
    scenario = replace(load_scenario("obstacles-on-two-paths"), duration=12.0)
    law = make_controller("obstacles")
    together = simulate(scenario, law, (3, 0, 9))
    alone = simulate(scenario, law, (9,))
    assert (alone.modes > 0).any()
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
        ('shape = "box"\nlength = 1.0', r"^bad\.toml:16: box lacks width"),
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
    geometry = scenario.setting.world.at(5.0)
    np.testing.assert_allclose(geometry.circles[0, 0], [1.0, 2.0, 0.3])
    before = scenario.setting.world.at(0.0).segments[0]
    np.testing.assert_allclose(geometry.segments[0] - before, np.tile([0.5, 0.0, 0.5, 0.0], (8, 1)), atol=1e-9)
