"""The judgement of runs as they go on: time on the way, the emergency rule's share, blame, and robots held up."""

from dataclasses import replace

import numpy as np
import pandas as pd
import pytest

from robotics.laws.catalogue import make_controller
from robotics.plugins.stress.disturbance import Disturbance
from robotics.plugins.stress.obstaclecourse import ObstacleOutcome, obstacle_ensemble, stress_obstacles
from robotics.plugins.stress.outcome import StressOutcome
from robotics.plugins.stress.quintic_table import quintic_table
from robotics.plugins.stress.single import single_run
from robotics.plugins.stress.tally import run_ensemble
from robotics.simulation.scenario.description import Member, Scenario
from robotics.world.paths.joined import join_tables
from robotics.world.paths.path import Quintic
from robotics.world.paths.references import even_timing
from robotics.world.paths.trajectory import Timing
from robotics.world.radio.faults import Fault, Faults
from robotics.world.sensing.posture import Sensing
from tests.robotics.guardedlaw import Guarded


def straight(shapes, durations):
    """A setting of straight paths along x, from their starts to the given x (runs, robots), without noise."""
    runs = [[Quintic(start=start, end=(end, start[1])) for start, end in row] for row in shapes]
    paths = join_tables([[quintic_table(shape) for shape in row] for row in runs])
    member = Member(start=(0.0, 0.0, 0.0), path=runs[0][0], timing=Timing(duration=20.0))
    scenario = Scenario(
        name="straight",
        robots=(member,) * len(runs[0]),
        kind="team",
        plant="kinematic",
        duration=float(np.ceil(4 * max(durations))),
        divergence=1e3,
        sensing=Sensing(posture="pose"),
    )
    starts = np.array([[(*start, 0.0) for start, _ in row] for row in shapes])
    return replace(scenario.setting, starts=starts, references=even_timing(paths, np.array(durations)))


BESIDE = [((0.0, 0.0), 2.005), ((0.0, 1.0), 3.005)]


@pytest.fixture(scope="module")
def guarded():
    """Two runs at 0.2 m/s: one in which both arrive, one whose time is up after 4 times 1 s."""
    return run_ensemble(StressOutcome, straight([BESIDE, BESIDE], [15.0, 1.0]), Guarded(), (0, 1))


def test_time_on_the_way_is_that_until_arrival_or_until_the_run_is_over(guarded):
    """99.5 % of 2.005 and 3.005 m are behind after 9.975 and 14.950 s, seen every 50 ms: at 10 and 14.95 s."""
    np.testing.assert_allclose(guarded.arrivals[0], [10.0, 14.95], rtol=1e-12)
    assert np.isinf(guarded.arrivals[1]).all()
    np.testing.assert_allclose(guarded.driven, [10.0 + 14.95, 2 * 4.0], rtol=1e-12)


def test_the_emergency_rules_share_is_of_the_time_on_the_way(guarded):
    """It acts in odd seconds: 5 s of 10 and 7 s of 14.95; and two of four."""
    np.testing.assert_allclose(guarded.guarded, [(5.0 + 7.0) / 24.95, 0.5], rtol=1e-12)
    assert guarded.summary()["emergency_share"] == pytest.approx((5.0 + 7.0 + 4.0) / (24.95 + 8.0), rel=1e-12)
    twice = StressOutcome(pd.concat([guarded.table, guarded.table]))
    assert twice.seeds == (0, 1, 0, 1)
    assert twice.guarded.tolist() == guarded.guarded.tolist() * 2


def test_where_no_run_began_and_where_there_is_no_rule_there_is_no_share(guarded):
    never = StressOutcome(guarded.table.assign(driven_s=0.0, overridden_s=0.0))
    assert np.isnan(never.guarded).all()
    assert never.summary()["emergency_share"] is None
    without = run_ensemble(StressOutcome, straight([BESIDE], [1.0]), make_controller("cooperation"), (0,))
    assert without.guarded is None
    assert without.summary()["emergency_share"] is None


def test_a_robot_that_is_held_up_does_not_cause_what_drives_into_it():
    """In the second run the one ahead is held up at 2 s; the one behind drives into it, and in the first never."""
    row = [((0.0, 0.0), 4.0), ((0.6, 0.0), 4.6)]
    stalls = tuple(Fault(robot=i + 1, kind="stall", duration=10.0) for i in range(2))
    starts = np.array([[np.inf, np.inf], [np.inf, 2.0]])
    held = Faults(stalls, 2, starts, starts + 10.0)
    found = run_ensemble(StressOutcome, straight([row, row], [20.0, 20.0]), Guarded(), (0, 1), held)
    assert found.collided.tolist() == [False, True]
    assert found.caused.tolist() == [[False, False], [True, False]]
    assert (found.summary()["contacts"], found.summary()["contacts_caused"]) == (1, 1)


# Among obstacles ----------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(("robots", "lanes"), [(1, "beside"), (3, "crossing")])
def test_one_robot_of_a_course_is_held_up_in_the_first_80_percent(robots, lanes):
    seeds, wrong = range(8), Disturbance(freeze=3.0)
    course = obstacle_ensemble(seeds, "A", robots, disturbance=wrong, lanes=lanes)
    faults = wrong.faults(course, seeds)
    assert faults is not None
    once = np.isfinite(faults.starts)
    assert (once.sum(axis=1) == 1).all()
    assert len(set(np.argmax(once, axis=1))) == robots  # not always the same
    nominal = course.references.ends[:, 0]
    starts = faults.starts.min(axis=1)
    assert ((starts >= 0) & (starts < 0.8 * nominal)).all()
    assert starts.max() > 0.5 * nominal.min()
    np.testing.assert_allclose(faults.ends[once] - faults.starts[once], 3.0, rtol=1e-12)
    assert course.ticks * course.period == np.ceil(ObstacleOutcome.limit * nominal.max() + 2 * 3.0)
    again = wrong.faults(obstacle_ensemble([5], "A", robots, disturbance=wrong, lanes=lanes), [5])
    assert again is not None
    np.testing.assert_array_equal(again.starts[0], faults.starts[5])


def test_a_repeated_course_shows_the_robot_that_is_held_up():
    law, seed, wrong = make_controller("cooperation"), 3, Disturbance(freeze=3.0)
    run, outcome = single_run("obstacles", law, seed, 3, "A", wrong, lanes="crossing")
    faults = wrong.faults(obstacle_ensemble([seed], "A", 3, disturbance=wrong, lanes="crossing"), [seed])
    assert faults is not None
    who = int(np.argmin(faults.starts[0]))
    still = (run["fault"][0] == 4).sum(axis=-1)
    assert still.tolist() == [60 if i == who else 0 for i in range(3)]
    now = (run.time > faults.starts[0, who] + 0.5) & (run.time < faults.ends[0, who])
    assert np.abs(run["v"][0, who, now]).max() < 0.01
    same = stress_obstacles(law, [seed, seed + 1], "A", 3, disturbance=wrong, lanes="crossing")
    assert same.arrivals[0].tolist() == outcome.arrivals[0].tolist()
    assert same.min_distance[0] == outcome.min_distance[0]
    assert same.clearance[0] == outcome.clearance[0]


def test_a_course_that_never_ends_is_given_up_alone_as_beside_others(monkeypatch):
    """After a multiple of its own duration: until then both its robots are on their way, of which none arrives."""
    monkeypatch.setattr("robotics.plugins.stress.obstaclecourse.ObstacleOutcome.limit", 0.3)
    law = make_controller("cooperation")
    both, alone = stress_obstacles(law, range(2), "A", 3), stress_obstacles(law, (0,), "A", 3)
    assert not both.arrived.any()
    np.testing.assert_allclose(both.driven, 3 * 0.05 * np.ceil(0.3 * both.nominal / 0.05), rtol=1e-9)
    for name in ("nominal", "driven", "min_distance", "clearance"):
        assert getattr(both, name)[0] == getattr(alone, name)[0], name
    assert both.driven[0] != both.driven[1]
