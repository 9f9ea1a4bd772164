"""Right of way: random crossings without contact or deadlock, and the planner behind it."""

import json

import numpy as np
import pytest

from robotics.commands.application import main
from robotics.laws.avoidance.reservation import CELLS, plan_right_of_way
from robotics.laws.avoidance.right_of_way import RightOfWay
from robotics.laws.law import ControllerError
from robotics.plugins.stress.crossings import crossing_ensemble, stress_crossing
from robotics.plugins.stress.disturbance import Disturbance
from robotics.plugins.stress.quintic_table import quintic_table
from robotics.simulation.scenario.reading import load_scenario
from robotics.world.paths.path import Quintic, compile_path


@pytest.fixture(scope="module")
def undisturbed():
    return stress_crossing(RightOfWay(), 3, range(1000, 1060))


def test_nobody_touches_and_all_arrive_together_and_in_time(undisturbed):
    """Chapters 5-6, I: 0 collisions, 0 deadlocks; together, and within 1.1 of the time if nothing is wrong."""
    found = undisturbed.summary()
    assert found["collisions"] == found["deadlocks"] == 0
    assert found["arrived"] == 60
    assert found["arrival_spread_p95_s"] <= 0.3
    assert found["time_ratio_median"] <= 1.10


@pytest.mark.parametrize(
    ("robots", "runs", "disturbance"),
    [
        (3, 40, Disturbance(freeze=8.0, loss=0.2, latency=0.3)),
        (10, 3, Disturbance()),
        pytest.param(3, 1000, Disturbance(freeze=8.0, loss=0.2, latency=0.3), marks=pytest.mark.long),
        pytest.param(10, 60, Disturbance(), marks=pytest.mark.long),
    ],
)
def test_nobody_touches_and_nobody_waits_for_ever(robots, runs, disturbance):
    found = stress_crossing(RightOfWay(), robots, range(1000, 1000 + runs), "A", disturbance).summary()
    assert found["collisions"] == found["deadlocks"] == 0
    assert found["arrived"] == runs


def test_where_there_is_no_plan_the_robots_stay_and_the_seeds_are_named():
    found = stress_crossing(RightOfWay(), 3, [0, 203], "B").summary()
    assert found["collisions"] == found["deadlocks"] == 0
    assert found["refused"] == len(found["failed_seeds"]["refused"]) == 1
    assert found["failed_seeds"]["refused"] == [203]
    assert found["arrived"] == 1


def test_a_run_does_not_depend_on_the_others(undisturbed):
    alone = stress_crossing(RightOfWay(), 3, [1003])
    np.testing.assert_array_equal(undisturbed.arrivals[3], alone.arrivals[0])
    assert undisturbed.min_distance[3] == alone.min_distance[0]


def line(start, end):
    return np.linspace(start, end, CELLS + 1)


def test_a_plan_keeps_the_clearance_also_when_clocks_differ():
    """Two paths that cross at their middles, and one that follows; brute force over all ticks within the margin."""
    nodes = np.array([[line((0, 0), (6, 0)), line((3, -3), (3, 3)), line((0, 1), (6, 1))]])
    plan = plan_right_of_way(nodes, clearance=0.5, margin=0.05)
    assert plan.found.all()
    places = np.round(plan.progress[0] * CELLS).astype(int)
    where = np.stack([nodes[0, i][places[i]] for i in range(3)])
    shift = int(np.ceil(0.05 * CELLS))
    for i in range(3):
        for j in range(i):
            for off in range(-shift, shift + 1):
                a = where[i, max(off, 0) : len(where[i]) + min(off, 0)]
                b = where[j, max(-off, 0) : len(where[j]) + min(-off, 0)]
                assert np.hypot(*(a - b).T).min() >= 0.5
    assert (np.diff(plan.progress) >= 0).all()
    np.testing.assert_array_equal(plan.progress[0, :, -1], 1.0)


def test_head_on_in_one_lane_there_is_no_plan():
    nodes = np.array([[line((0, 0), (6, 0)), line((6, 0), (0, 0))]])
    assert not plan_right_of_way(nodes).found.any()


def test_a_scenario_without_connection_is_refused():
    with pytest.raises(ControllerError, match='kind = "team"'):
        RightOfWay().init(load_scenario("reference").setting, 1)


def test_the_quick_table_of_a_quintic_is_the_exact_one():
    shape = Quintic(start=(0.0, 0.0), end=(6.0, 2.0), start_tangent=(5.0, -4.0), end_tangent=(5.0, 6.0))
    table, exact = quintic_table(shape), compile_path(shape)
    s = np.linspace(0.0, exact.length, table.shape[1])
    point = exact.at(s)
    np.testing.assert_allclose(table[:4], np.stack(point), atol=2e-4)


def test_crossings_have_conflicts_and_clear_ends():
    ensemble = crossing_ensemble(4, range(6))
    paths = ensemble.references.joined
    places = np.linspace(0, 1, 101)
    points = np.stack([np.stack(paths.at(u * paths.lengths)[:2], axis=-1) for u in places], axis=2)
    for run in points:
        gaps = np.hypot(*np.moveaxis(run[:, None] - run[None], -1, 0)).min(axis=-1) + 9 * np.eye(4)
        assert gaps.min() < 0.4
        for i in range(4):
            for j in set(range(4)) - {i}:
                for end in (0, -1):
                    assert np.hypot(*(run[j] - run[i, end]).T).min() >= 0.6 - 0.02


def test_the_command_finds_what_the_printed_rules_do_wrong(capsys, monkeypatch):
    monkeypatch.setattr("robotics.plugins.stress.outcome.StressOutcome.limit", 1.5)  # many never end
    options = ["--robots", "3", "--runs", "4", "--seed", "50", "-q", "--controller", "literal", "--json"]
    assert main(["stress", "crossing", *options]) == 0
    literal = json.loads(capsys.readouterr().out)
    assert literal["collisions"] + literal["deadlocks"] > 0
    assert literal["failed_seeds"]["collision"] or literal["failed_seeds"]["deadlock"]
