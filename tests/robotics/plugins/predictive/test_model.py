"""The model of predictive laws against the plant, and against small steps of its own equations."""

from dataclasses import replace

import numpy as np
import pytest

from fuzzy.compiled.jit import kernel
from robotics.plugins.predictive.model import moved, response, velocity_shares, wheel_rate
from robotics.simulation.scenario.robots import load_robot
from robotics.world.vehicle.plant import STEP, Plant, initial_state, parameters
from robotics.world.vehicle.plant import TruthColumns as Truth
from robotics.world.vehicle.wheel_loop import wheel_lag

ETSRO = load_robot("etsro").robot


@kernel
def _moved(state, command, after):
    x, y, heading, v, w = state[0], state[1], state[2], state[3], state[4]
    return moved(x, y, heading, v, w, command[0], command[1], after)[:5]


def speeds(robot, before, command, seconds):
    """v and ω (2, samples) every 10 ms, of a robot that has driven ``before`` for 3 s, after a step to ``command``."""
    machine, lanes = Plant(parameters(robot)[:, None], steps=1), np.zeros((1, 3))
    state, found = initial_state(lanes), []
    for k in range(round((3 + seconds) / STEP)):
        order = np.array(before if k < round(3 / STEP) else command)[:, None]
        if k >= round(3 / STEP):
            found.append(state[[Truth.v.row, Truth.w.row], 0])
        state = machine.advance(state, order, order, 0, "velocity")
    return np.array(found).T


@pytest.mark.parametrize("name", ["etsro", "turtlebot3-burger", "mir100"])
def test_the_lag_is_the_area_above_the_step_response_of_the_plant(name):
    """Steps of a moving robot with fine encoders, within voltage and torque: its friction is the same before and after.

    When it turns, a center of mass off the axle couples v and ω, which the formula leaves out.
    """
    robot = replace(load_robot(name).robot, v_rate_max=None, w_rate_max=None, counts_per_turn=2.0**40)
    lag, top = wheel_lag(robot), robot.wheel_speed_limit
    for axis, step, tolerance, shape in ((0, 0.05 * top, 0.025, 0.12), (1, 0.05 * top / robot.half_axle, 0.1, 0.21)):
        before = 0.4 * top, 0.0
        command = np.array(before)
        command[axis] += step
        followed = speeds(robot, before, command, 20 * lag + 1.0)[axis]
        share = (followed - followed[0]) / step
        area = ((1 - share[1:]) + (1 - share[:-1])).sum() * STEP / 2
        assert area == pytest.approx(lag, rel=tolerance)
        assert np.abs(share - (1 - np.exp(-STEP * np.arange(len(share)) / lag))).max() < shape


def test_both_wheels_can_change_their_speed_as_fast_as_the_rate_says():
    rate = wheel_rate(ETSRO)
    for command in ((0.7, 0.0), (0.0, 0.7 / ETSRO.half_axle)):
        followed = speeds(ETSRO, (0.0, 0.0), command, 0.2)
        wheel = followed[0] + ETSRO.half_axle * followed[1]
        assert np.diff(wheel).max() / STEP > 0.9 * rate  # the loop reaches it
    assert rate == pytest.approx(2 * (0.35 - 0.02) / (0.045 * ETSRO.effective_mass))
    assert wheel_rate(replace(ETSRO, friction_torque=0.4, friction_speed=5.0)) > 0


@pytest.mark.parametrize("lag", [0.0, 0.004, 0.05, 0.3])
def test_a_period_is_that_of_small_steps(lag):
    """The velocities and the heading exactly; the place to the second order of the period."""
    state, command, period = np.array([0.2, -0.1, 0.7, 0.3, -1.5]), np.array([0.5, 2.0]), 0.05
    x, y, heading, v, w = state
    n = 20_000
    h = period / n
    for _ in range(n):
        left = np.exp(-h / lag) if lag > 0 else 0.0
        next_v, next_w = command + (np.array([v, w]) - command) * left
        mean_v, mean_w = (next_v, next_w) if lag == 0 else ((v + next_v) / 2, (w + next_w) / 2)
        middle = heading + h * mean_w / 2
        x, y, heading = x + h * mean_v * np.cos(middle), y + h * mean_v * np.sin(middle), heading + h * mean_w
        v, w = next_v, next_w
    found = _moved(state, command, response(period, lag))
    np.testing.assert_allclose(found[2:], [heading, v, w], rtol=1e-6)
    np.testing.assert_allclose(found[:2], [x, y], atol=1e-4)


@pytest.mark.parametrize("change", [0.0, 0.03, 0.05])
@pytest.mark.parametrize("lag", [0.0, 0.035, 0.5])
def test_the_velocity_now_follows_from_its_mean(lag, change):
    period, older, newer = 0.05, 0.2, 0.5
    start, n = -0.1, 50_000
    t = (np.arange(n) + 0.5) * period / n
    left = (lambda s: np.exp(-s / lag)) if lag > 0 else (lambda s: np.where(s > 0, 0.0, 1.0))
    middle = older + (start - older) * left(np.float64(change))
    v = np.where(t < change, older + (start - older) * left(t), newer + (middle - newer) * left(t - change))
    now = newer + (middle - newer) * left(np.float64(period - change))
    shares = velocity_shares(period, change, lag)
    assert sum(shares) == pytest.approx(1)
    assert 0 <= shares.mean <= 1
    if lag > 0 or change < period:
        assert shares.mean * v.mean() + shares.older * older + shares.newer * newer == pytest.approx(now, abs=1e-6)


def test_a_loop_faster_than_its_period_has_no_lag_and_one_without_an_integral_part_its_own():
    assert wheel_lag(replace(ETSRO, ki=90.0)) == 0.0
    slow = replace(ETSRO, ki=0.0)
    assert wheel_lag(slow) == pytest.approx(slow.wheel_load / (slow.torque_constant * (slow.back_emf + slow.kp)))
    assert wheel_lag(replace(ETSRO, filter_frequency=20.0)) == pytest.approx(wheel_lag(ETSRO) - 0.7 / (20 * np.pi))
