"""The terminal cost: against scipy's Riccati equation, and as what the rest of a longer plan costs."""

from dataclasses import replace
from itertools import product

import numpy as np
import pytest
from scipy.linalg import solve_discrete_are

from benchmarks.predictiveproblems import LAW, PERIOD
from benchmarks.predictivesolving import Problem, plans_of
from robotics.plugins.predictive.model import response, wheel_rate
from robotics.plugins.predictive.terminal import SPEEDS, riccati, straight_across, straight_along, tail_table
from robotics.simulation.scenario.robots import load_robot
from robotics.world.vehicle.wheel_loop import wheel_lag

ETSRO = load_robot("etsro").robot
WEIGHTS, LAG = LAW.weights(ETSRO), wheel_lag(ETSRO)
AFTER, TOP = response(PERIOD, LAG), ETSRO.wheel_speed_limit
TABLE = tail_table(WEIGHTS, AFTER, TOP)


def test_the_table_has_the_solutions_of_scipy():
    assert TABLE.shape == (SPEEDS, 17)
    np.testing.assert_allclose(TABLE[:, 0], TOP / np.array([32, 16, 8, 4, 2, 1]))
    for row in TABLE:
        for problem, numbers in (
            (straight_along(WEIGHTS, AFTER), row[1:7]),
            (straight_across(WEIGHTS, AFTER, row[0]), row[7:]),
        ):
            *given, s = problem
            solution = solve_discrete_are(*given, s=s)
            np.testing.assert_allclose(numbers, solution[np.triu_indices(len(solution))], rtol=1e-9)


@pytest.mark.parametrize("scales", [*product((1e-3, 1e3), repeat=6)][::7], ids=str)
def test_scales_that_are_far_apart_have_a_terminal_cost(scales):
    """What it says of itself by the equation, in parts of its greatest term."""
    names = ("along_scale", "cross_scale", "heading_scale", "v_scale", "w_scale", "change_scale")
    weights = replace(LAW, **dict(zip(names, scales, strict=True))).weights(ETSRO)
    for a, b, q, r, s in (straight_along(weights, AFTER), straight_across(weights, AFTER, TOP / 8)):
        p = riccati(a, b, q, r, s)
        assert np.linalg.eigvalsh(p).min() >= -1e-9 * np.abs(p).max()
        f = b.T @ p @ a + s.T
        again = q + a.T @ p @ a - f.T @ np.linalg.solve(r + b.T @ p @ b, f)
        np.testing.assert_allclose(again, p, atol=1e-8 * np.abs(p).max())


def along_a_line(horizon, v, state):
    """A problem on the x axis driven at ``v``; nothing is bounded."""
    k = np.arange(1, horizon + 1)
    return Problem(
        period=PERIOD, lag=LAG, weights=WEIGHTS, half_axle=ETSRO.half_axle, tops=np.full(4, 99.0),
        rates=np.full(4, np.inf), before=np.array([v, 0.0]), state=np.array(state),
        to=np.stack([k * PERIOD * v, 0 * k, 0 * k], axis=-1), follow=np.tile([v, 0.0], (horizon + 1, 1)),
        end=np.array([v, 0.0]), tail=np.array([np.interp(v, TABLE[:, 0], column) for column in TABLE[:, 1:].T]),
        guess=np.full((horizon, 2), np.nan),
    )  # fmt: skip


@pytest.mark.parametrize("horizon", [2, 20])
def test_a_short_plan_costs_what_a_long_one_does_near_a_straight_reference(horizon):
    """At a speed of the table: from small errors the model is linear, and the tail is all that follows."""
    v = float(TABLE[4, 0])
    for state in ([0.002, 0.003, 0.01, v + 0.01, -0.05], [-0.001, -0.003, 0.0, v, 0.0]):
        short, long = (plans_of([along_a_line(n, v, state)]) for n in (horizon, 150))
        assert short.cost[0] == pytest.approx(long.cost[0], rel=2e-3)
        np.testing.assert_allclose(short.commands[0, 0], long.commands[0, 0], atol=2e-4)


def test_without_it_a_short_plan_is_a_worse_one():
    v, state = float(TABLE[4, 0]), [0.0, 0.1, 0.0, float(TABLE[4, 0]), 0.0]
    problem = along_a_line(2, v, state)
    with_tail, without = plans_of([problem]), plans_of([replace(problem, tail=np.zeros(16))])
    long = plans_of([along_a_line(150, v, state)])
    off = [abs(plan.commands[0, 0, 1] - long.commands[0, 0, 1]) for plan in (with_tail, without)]
    assert off[0] < 0.1 * off[1]
    assert wheel_rate(ETSRO) > 0
