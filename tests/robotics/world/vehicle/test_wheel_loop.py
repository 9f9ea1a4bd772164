"""The step response against a wheel simulated by hand, and gains that are tuned."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from robotics.simulation.scenario.robots import load_robot
from robotics.world.vehicle.wheel_loop import (
    MOST_OVERSHOOT,
    MOTIONS,
    TRIED,
    WheelResponse,
    step_response,
    top_speed,
    tuned,
)
from tests.robotics.world.vehicle.etsro import ETSRO


def by_hand(robot, command, seconds):
    """The wheel of a robot that drives straight on: the loop in steps of 10 ms, the motor between by scipy."""
    limit, quantum = robot.torque_limit, 2 * np.pi / robot.counts_per_turn

    def motion(_, w, voltage):
        torque = np.clip(robot.torque_constant * (voltage - robot.back_emf * w[0]), -limit, limit)
        drag = robot.friction_torque * w[0] / np.hypot(w[0], robot.friction_speed)
        return [(torque - drag) / robot.wheel_load]

    w, integral, angle, measured, counted, speeds = 0.0, 0.0, 0.0, 0.0, 0.0, [0.0]
    for _ in range(round(seconds / 0.01)):
        wish = robot.kp * (command - measured) + integral
        voltage = np.clip(wish, -robot.supply_voltage, robot.supply_voltage)
        integral += 0.01 * (robot.ki * (command - measured) + robot.ki / robot.kp * (voltage - wish))
        path = solve_ivp(motion, (0, 0.01), [w], args=(voltage,), rtol=1e-8, atol=1e-10, dense_output=True)
        angle += np.trapezoid(path.sol(np.linspace(0, 0.01, 21))[0], dx=0.0005)
        w, count = path.y[0, -1], np.floor(angle / quantum) * quantum
        measured, counted = (count - counted) / 0.01, count
        speeds.append(w)
    return np.array(speeds)


@pytest.mark.parametrize("name", ["etsro", "pioneer-3dx"])
def test_a_step_is_that_of_the_equations(name):
    robot = load_robot(name).robot
    step = step_response(robot, "straight")
    mine = by_hand(robot, step.command, 0.4)
    assert np.abs(step.speed[:41] - mine).max() < 0.02 * step.command  # a count of the encoder more or less


def test_overshoot_and_settling_time_are_those_of_a_known_response():
    time = 0.01 * np.arange(200)
    damped = 1 - np.exp(-5 * time) * np.cos(10 * time)
    step = WheelResponse("spot", 3.0, time, 3.0 * damped, time)
    assert step.overshoot == pytest.approx(damped.max() - 1)
    outside = time[np.abs(damped - 1) > 0.02]
    assert step.settling_time == pytest.approx(outside[-1] + 0.01)
    assert WheelResponse("spot", 1.0, time, 0.5 + 0 * time, time).settling_time == np.inf


def test_top_speeds_are_what_both_commands_and_wheels_allow():
    assert top_speed(ETSRO, "straight") == ETSRO.wheel_speed_max  # 0.825 m/s, below the 1.12 that may be commanded
    assert top_speed(ETSRO, "spot") == pytest.approx(5.74 * 0.1 / 0.045)


@pytest.mark.parametrize("name", ["etsro", "mir100", "pioneer-3dx"])
def test_tuned_gains_settle_sooner_within_the_overshoot(name):
    robot = load_robot(name).robot
    gains = tuned(robot)
    assert tuned(robot) == gains
    after = replace(robot, **gains._asdict())
    cases = [(motion, level) for motion in MOTIONS for level in TRIED]
    steps = [step_response(after, *case) for case in cases]
    assert max(step.overshoot for step in steps) <= MOST_OVERSHOOT
    before = [step_response(robot, *case) for case in cases]
    fair = max(step.overshoot for step in before) <= MOST_OVERSHOOT
    slowest = [max(step.settling_time for step in some) for some in (steps, before)]
    assert slowest[0] < slowest[1] or not fair
