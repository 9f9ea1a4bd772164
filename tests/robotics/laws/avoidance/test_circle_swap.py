"""Circle swaps and random goals of the benchmark: the cases, what ORCA asks of the wheels, and who gets through."""

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from scipy.spatial.distance import pdist

from benchmarks.avoidance import Clocked, Entrant, Orca, circle_swap, ensemble, entered, figures, random_goals
from robotics.laws.catalogue import make_controller
from robotics.laws.law import Observation
from robotics.plugins.stress.outcome import StressOutcome, table_of
from tests.robotics.world.vehicle.etsro import ETSRO


def test_everyone_goes_to_the_opposite_point():
    starts, goals = circle_swap(10, range(2))
    assert starts.shape == (2, 10, 2)
    np.testing.assert_allclose(goals, np.roll(starts, 5, axis=1), atol=1e-12)
    np.testing.assert_allclose(pdist(starts[0]).max(), 4.0)


def test_random_goals_are_apart_and_a_seeds_case_is_its_own():
    both = random_goals(10, (3, 4))
    for points in both:
        assert min(pdist(run).min() for run in points) >= 0.9
    assert np.hypot(*np.moveaxis(both[1] - both[0], -1, 0)).min() >= 2.0
    for alone, together in zip(random_goals(10, (4,)), both, strict=True):
        np.testing.assert_array_equal(alone[0], together[1])


def test_a_roundabout_has_the_same_room_for_everybody_around_the_middle():
    starts, goals = circle_swap(10, range(1))
    paths = ensemble(starts, goals, True).references.joined
    middle = paths.at(paths.lengths / 2)
    np.testing.assert_allclose(np.hypot(middle.x, middle.y), 10 * 0.75 / (2 * np.pi), atol=1e-4)
    # To the right of the straight line: the middle lies clockwise of the start, seen from the start
    across = starts[..., 0] * middle.y - starts[..., 1] * middle.x
    assert (across > 0).all()
    straight = ensemble(starts, goals).references.joined
    np.testing.assert_allclose(straight.lengths, 4.0, atol=1e-6)


def test_success_is_arriving_in_time_without_a_touch():
    arrivals = np.array([[9.0, 10.0], [41.0, 5.0], [9.0, 10.0], [np.inf, np.inf]])
    touched, refused = np.array([False, False, True, False]), np.array([False, False, False, True])
    nearest, clearance = np.array([0.5, 0.6, 0.2, 0.9]), np.array([0.1, 0.2, -0.1, 0.5])
    columns = {"seed": np.arange(4), "arrival_s": arrivals, "collided": touched, "refused": refused}
    outcome = StressOutcome(table_of(columns | {"min_distance_m": nearest, "clearance_m": clearance}))
    found = figures(outcome, np.full(4, 10.0))
    assert found["success"] == 0.25
    assert (found["collisions"], found["refused"], found["late"]) == (1, 1, 1)
    assert (found["makespan"], found["min_distance_m"], found["worst_distance_m"]) == (1.0, 0.5, 0.2)


def test_right_of_way_swaps_ten_robots_on_a_roundabout():
    entrant = Entrant("right of way", make_controller("right-of-way"), True)
    found = entered(entrant, "circle swap", 10, range(1))
    assert found["success"] == 1.0
    assert found["worst_distance_m"] > 0.5
    assert 1.0 < found["makespan"] < 2.0


def test_a_lone_point_ahead_of_the_axle_moves_straight_to_the_goal():
    pytest.importorskip("pyrvo")
    law = Orca(lead=0.05)
    scenario: Any = SimpleNamespace(robots=(ETSRO,), period=0.05)
    goal = SimpleNamespace(x=np.array([3.0]), y=np.array([4.0]))
    way: Any = SimpleNamespace(each_at=lambda times: goal)
    heading, zero = np.array([[0.7]]), np.zeros((1, 1))
    seen = Observation(0.0, zero, zero, heading, zero, zero, None, way)
    command, _ = law.control(seen, law.init(scenario, 1), 0.05)
    # v along the heading and lead times ω across it: 0.22 m/s towards (3, 4)
    v, w = command.v.item(), command.w.item()
    point = v * np.array([np.cos(0.7), np.sin(0.7)]) + 0.05 * w * np.array([-np.sin(0.7), np.cos(0.7)])
    np.testing.assert_allclose(point, [0.22 * 0.6, 0.22 * 0.8], atol=1e-6)


def test_orca_swaps_three_robots_and_its_time_is_kept():
    pytest.importorskip("pyrvo")
    found = entered(Entrant("ORCA", Orca()), "circle swap", 3, range(2))
    assert found["success"] == 1.0
    assert found["worst_distance_m"] > 0.3
    assert found["deciding_ms"] > 0
    assert Clocked(make_controller("right-of-way")).message[0] == "place"  # the law's attributes show through
