"""The plant against the full constrained model, closed forms, energy, and its own limits."""

import os
import subprocess
import sys
from dataclasses import replace
from math import cos, inf, pi, sin
from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from robotics.world.vehicle import plant as p
from robotics.world.vehicle.plant import TruthColumns as Truth
from robotics.world.vehicle.robot import RobotError
from tests.robotics.world.vehicle.etsro import ETSRO

ROBOT = ETSRO
# No motor in the way: no limit is reached, and the torque does not sag as the wheel speeds up within a step.
FREE = replace(ROBOT, supply_voltage=1e4, torque_limit=1e3, back_emf=1e-13, friction_torque=0.0)
TIME_STEP = 0.01


def machine(*robots, **settings):
    return p.Plant(np.stack([p.parameters(r) for r in robots], axis=1), **settings)


def at_rest(lanes=1):
    return p.initial_state(np.zeros((lanes, 3)))


def driven(robot, commands, level="velocity", state=None, **settings):
    """The states (ticks + 1, CHANNELS) of one robot under one command (2,) a tick."""
    plant = machine(robot, **settings)
    states = [at_rest() if state is None else state]
    for command in commands:
        order = np.array(command, dtype=float).reshape(2, 1)
        states.append(plant.advance(states[-1], order, order, 0, level))
    return np.array(states)[:, :, 0]


def of_wheels(name, states):
    """A column of the right and of the left wheel (..., 2) in ``states`` (..., CHANNELS)."""
    state = Truth(states.T)
    return np.stack([getattr(wheel, name) for wheel in (state.right, state.left)], axis=-1)


def torques(t):
    """An open-loop drive: forward, turning both ways, never resting; right and left [N m]."""
    return np.array([0.025 * sin(1.1 * t) + 0.006, 0.025 * sin(1.1 * t) + 0.006 * cos(1.7 * t)])


def full_model(robot, ahead, tick, seconds):
    """Thesis (2.1)-(2.4) as corrected by errata A4 and A5: posture of the body's center of mass, a constraint force.

    d > 0 lies behind the axle. The wheels' spin inertia, which the thesis omits, enters by the virtual power of
    J_w φ'' on each wheel's rolling rate φ' = b(ψ)·q'. Returns axle x, y and heading after every tick.
    """
    d = -ahead
    mw, L, r, jw = robot.wheel_mass, robot.half_axle, robot.wheel_radius, robot.wheel_spin_inertia
    m = robot.body_mass + 2 * mw
    inertia = robot.body_inertia + 2 * mw * (d**2 + L**2) + 2 * robot.wheel_inertia  # (2.3), about C_c

    def right_hand_side(t, z, torque):
        psi, turn = z[2], z[5]
        c, s = cos(psi), sin(psi)
        mass = np.array([[m, 0, -2 * mw * d * s], [0, m, 2 * mw * d * c], [-2 * mw * d * s, 2 * mw * d * c, inertia]])
        bias = np.array([-2 * mw * d * turn**2 * c, -2 * mw * d * turn**2 * s, 0.0])
        for side in (1, -1):
            b = np.array([c, s, side * L]) / r
            b_dot = turn * np.array([-s, c, 0.0]) / r
            mass = mass + jw * np.outer(b, b)
            bias = bias + jw * b * (b_dot @ z[3:])
        force = np.array([[c, c], [s, s], [L, -L]]) @ torque / r
        a = np.array([s, -c, -d])  # (2.4)
        a_dot = turn * np.array([c, s, 0.0])
        kkt = np.block([[mass, -a[:, None]], [a[None, :], np.zeros((1, 1))]])
        solution = np.linalg.solve(kkt, np.concatenate([force - bias, [-(a_dot @ z[3:])]]))
        return np.concatenate([z[3:], solution[:3]])

    z = np.array([-d, 0.0, 0.0, 0.0, 0.0, 0.0])
    poses = [[0.0, 0.0, 0.0]]
    for k in range(round(seconds / tick)):
        t = k * tick
        z = solve_ivp(right_hand_side, (t, t + tick), z, method="DOP853", rtol=1e-11, atol=1e-13, args=(torques(t),)).y[
            :, -1
        ]
        poses.append([z[0] + d * cos(z[2]), z[1] + d * sin(z[2]), z[2]])
    return np.array(poses)


@pytest.fixture(scope="module")
def full():
    """By d [m]: the full model's poses over 5 s (row B)."""
    return {d: full_model(replace(FREE, mass_offset=d), d, 0.05, 5.0) for d in (-0.02, 0.02)}


def reduced(d):
    states = driven(replace(FREE, mass_offset=d), [torques(0.05 * k) for k in range(100)], "torque")
    return states[:, [Truth.x.row, Truth.y.row, Truth.heading.row]]


@pytest.mark.parametrize("d", [-0.02, 0.02])
def test_reduced_model_is_the_full_one_within_a_micrometre_after_5_s(full, d):
    poses = reduced(d)
    assert np.hypot(*poses[-1, :2]) > 0.3  # it went somewhere
    assert np.ptp(poses[:, 2]) > 1.0
    np.testing.assert_allclose(poses, full[d], rtol=0, atol=1e-6)


def test_mass_behind_is_not_mass_ahead_and_not_mass_on_the_axle(full):
    """Erratum A5: the sign of d, under the same torques. Behind the axle it makes the yaw unstable."""
    assert np.abs(full[-0.02][-1] - full[0.02][-1]).max() > 0.1
    assert np.abs(reduced(-0.02)[-1] - reduced(0.02)[-1]).max() > 0.1
    assert np.abs(reduced(-0.02)[-1] - reduced(0.0)[-1]).max() > 0.1


@pytest.mark.parametrize(("d", "grows"), [(-0.02, True), (0.02, False)])
def test_yaw_of_a_coasting_robot_grows_at_the_rate_of_the_linearised_model(d, grows):
    """ω' = −m_c d v ω / I: with the mass behind, the rate is +m_c |d| v / I [B]."""
    robot = replace(FREE, mass_offset=d)
    state = at_rest()
    state[Truth.v.row], state[Truth.w.row] = 0.5, 1e-6
    end = driven(robot, [(0, 0)] * 20, "torque", state)[-1]
    rate = -robot.body_mass * d * 0.5 / robot.effective_inertia
    assert end[Truth.w.row] == pytest.approx(1e-6 * np.exp(rate), rel=1e-8)
    assert (end[Truth.w.row] > 1e-6) == grows
    bare = replace(robot, wheel_spin_inertia=0.0)  # the figures of [B], without the wheels' spin
    assert bare.body_mass * 0.02 * np.array([0.2, 0.5, 1.0]) / bare.effective_inertia == pytest.approx(
        [0.44, 1.1, 2.2], rel=0.02
    )


def test_constants_are_the_published_ones():
    assert ROBOT.mass == pytest.approx(2.86)
    assert ROBOT.yaw_inertia == pytest.approx(0.02072)
    assert ROBOT.wheel_speed_limit == pytest.approx(0.825, abs=5e-4)
    assert replace(ROBOT, wheel_radius=0.04).wheel_speed_limit == pytest.approx(0.733, abs=5e-4)


def kinetic_energy(robot, state):
    """Body at its center of mass, wheels at theirs, spin: not the reduced mass matrix."""
    v, w, d, L = state[..., Truth.v.row], state[..., Truth.w.row], robot.mass_offset, robot.half_axle
    total = robot.body_mass * (v**2 + (d * w) ** 2) / 2 + robot.body_inertia * w**2 / 2
    for side in (1, -1):
        rolling = v + side * L * w
        total = total + robot.wheel_mass * rolling**2 / 2 + robot.wheel_inertia * w**2 / 2
        total = total + robot.wheel_spin_inertia * (rolling / robot.wheel_radius) ** 2 / 2
    return total


@pytest.mark.parametrize("friction", [0.0, 0.02, 0.1])
@pytest.mark.parametrize("level", ["torque", "velocity"])
def test_work_is_kinetic_energy_and_losses(friction, level):
    robot = replace(ROBOT, friction_torque=friction)
    time = 0.05 * np.arange(100)
    if level == "torque":
        commands = [4 * torques(t) for t in time]
    else:
        commands = [(0.5 * sin(2 * t), 3 * cos(1.3 * t)) for t in time]
    states = driven(robot, commands, level)
    energy = kinetic_energy(robot, states)
    assert np.ptp(energy) > 0.01
    assert (np.abs(energy + states[:, Truth.loss.row] - states[:, Truth.work.row]) <= 1e-5).all()
    assert (np.diff(states[:, Truth.loss.row]) >= 0).all()
    assert (states[-1, Truth.loss.row] > 0.01) == (friction > 0)


@pytest.mark.parametrize("spin", [0.0, 2.8e-4])
def test_without_offset_constant_torques_drive_the_closed_form_of_2_10(spin):
    robot = replace(FREE, mass_offset=0.0, wheel_spin_inertia=spin)
    right, left, t = 0.012, 0.010, 0.05 * np.arange(101)
    states = driven(robot, [(right, left)] * 100, "torque")
    r, L = robot.wheel_radius, robot.half_axle
    mass = 2.3 + 2 * 0.28 + 2 * spin / r**2
    inertia = 0.01 + 2 * 0.28 * L**2 + 2 * 0.0021 + 2 * spin * (L / r) ** 2
    a, b = (right + left) / (r * mass), L * (right - left) / (r * inertia)  # (2.12)
    np.testing.assert_allclose(states[:, Truth.v.row], a * t, rtol=0, atol=1e-12)
    np.testing.assert_allclose(states[:, Truth.w.row], b * t, rtol=0, atol=1e-12)
    angle = b * t**2 / 2
    np.testing.assert_allclose(states[:, Truth.heading.row], angle, rtol=0, atol=1e-12)
    np.testing.assert_allclose(states[:, Truth.x.row], a / b * np.sin(angle), rtol=0, atol=1e-7)
    np.testing.assert_allclose(states[:, Truth.y.row], a / b * (1 - np.cos(angle)), rtol=0, atol=1e-7)


@pytest.mark.parametrize("substeps", [2, 4])
def test_pose_converges_with_the_substeps(substeps):
    """[B]: RK4 at 2 ms is within 1.4e-7 m of 0.5 ms after 5 s."""
    commands = [(0.4 + 0.2 * sin(0.1 * k), 2 * sin(0.07 * k)) for k in range(100)]
    exact = driven(replace(ROBOT, counts_per_turn=1e12), commands, substeps=20)
    coarse = driven(replace(ROBOT, counts_per_turn=1e12), commands, substeps=substeps)
    gap = np.abs(exact - coarse)[:, [Truth.x.row, Truth.y.row, Truth.heading.row]].max()
    assert 0 < gap < {2: 1e-5, 4: 5e-7}[substeps]


# Wheel loops ----------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("frequency", [0.0, 20.0])
@pytest.mark.parametrize("speed", [4.0, 12.0])
@pytest.mark.parametrize("motion", ["forward", "turn"])
@pytest.mark.parametrize("radius", [0.045, 0.04])
def test_wheel_loop_overshoots_6_percent_rises_in_150_ms_settles_in_350_ms(radius, motion, speed, frequency):
    """Row B; with the 20 Hz filter, too."""
    robot = replace(ROBOT, wheel_radius=radius, filter_frequency=frequency)
    command = (radius * speed, 0.0) if motion == "forward" else (0.0, radius * speed / robot.half_axle)
    states = driven(robot, [command] * 150, steps=1)
    wheel = (states[:, Truth.v.row] + robot.half_axle * states[:, Truth.w.row]) / radius / speed
    time = TIME_STEP * np.arange(len(wheel))
    assert wheel.max() <= 1.06
    assert time[np.argmax(wheel >= 0.9)] <= 0.15
    assert wheel.max() >= 0.9
    outside = np.abs(wheel - 1) > 0.02
    assert time[outside][-1] + TIME_STEP <= 0.35
    assert wheel[-1] == pytest.approx(1, abs=0.005)  # the integral part removes the friction's droop


def test_encoder_quantum_is_0_105_rad_per_second():
    quantum = 2 * pi / 6000 / TIME_STEP
    assert quantum == pytest.approx(0.105, abs=5e-4)
    speeds = of_wheels("speed", driven(ROBOT, [(0.2, 0.3)] * 100, steps=1)) / quantum
    np.testing.assert_allclose(speeds, np.round(speeds), rtol=0, atol=1e-9)
    assert np.diff(np.unique(np.round(speeds))).min() == 1
    filtered = of_wheels("speed", driven(replace(ROBOT, filter_frequency=20.0), [(0.2, 0.3)] * 100, steps=1)) / quantum
    assert np.abs(filtered - np.round(filtered)).max() > 0.1


def test_low_pass_has_gain_1_at_rest_and_3_db_around_its_frequency():
    b0, b1, b2, a1, a2 = p._low_pass(20.0, TIME_STEP)

    def gain(frequency):
        z = np.exp(2j * pi * frequency * TIME_STEP)
        return abs((b0 + b1 / z + b2 / z**2) / (1 + a1 / z + a2 / z**2))

    assert gain(0.0) == pytest.approx(1)
    assert gain(20.0) == pytest.approx(1 / 1.4)  # 1/(2 ζ)
    assert gain(49.9) < 1e-4


# Limits ---------------------------------------------------------------------------------------------------------

TOO_FAST = [(1.12, 5.74), (3.0, 0.0), (0.0, 50.0), (-1.0, 3.0), (0.8, -5.0)]


@pytest.mark.parametrize("command", TOO_FAST)
def test_saturation_keeps_the_curvature_and_the_diamond(command):
    limits = p.velocity_limits([ROBOT])
    v, w = (limited.item() for limited in p.saturate(limits, *np.array(command)))
    clamped = np.clip(command, (-1.12, -5.74), (1.12, 5.74))
    assert v * clamped[1] == pytest.approx(w * clamped[0], abs=1e-12)
    assert abs(v) + 0.1 * abs(w) <= ROBOT.wheel_speed_limit * (1 + 1e-12)
    at_limit = abs(v) + 0.1 * abs(w) == pytest.approx(ROBOT.wheel_speed_limit, rel=1e-12)
    assert at_limit or abs(w) == pytest.approx(5.74)
    assert v * command[0] >= 0
    assert w * command[1] >= 0
    assert [*p.saturate(limits, np.array(0.3), np.array(1.0))] == [0.3, 1.0]
    # The kinematic plant does the same at once, the dynamic one settles inside the diamond.
    glide = driven(ROBOT, [command], kinematic=True)[-1]
    assert glide[[Truth.v.row, Truth.w.row]] == pytest.approx([v, w], abs=1e-14)
    end = driven(replace(ROBOT, friction_torque=0.0), [command] * 60)[-20:]
    assert (np.abs(end[:, Truth.v.row]) + 0.1 * np.abs(end[:, Truth.w.row]) <= ROBOT.wheel_speed_limit * 1.005).all()
    np.testing.assert_allclose(end[:, Truth.v.row], v, rtol=0, atol=0.01)
    np.testing.assert_allclose(end[:, Truth.w.row], w, rtol=0, atol=0.1)  # at the supply's edge the loops hunt a little


@pytest.mark.parametrize(("command", "seconds"), [((0.3, 0.0), 0.6), ((0.0, -2.0), 1.0), ((0.1, 2.0), 1.0)])
def test_a_step_to_a_velocity_takes_v_over_a_seconds(command, seconds):
    """Thesis (5.1) with v' <= 0.5 m/s², ω' <= 2 rad/s²: exactly in the kinematic plant."""
    slow = replace(ROBOT, v_rate_max=0.5, w_rate_max=2.0)
    states = driven(slow, [command] * 120, steps=1, kinematic=True)
    time = TIME_STEP * np.arange(121)
    rates = np.array([0.5, 2.0]) * np.sign(command)
    wanted = np.sign(command) * np.minimum(np.abs(rates * time[:, None]), np.abs(command))
    np.testing.assert_allclose(states[:, [Truth.v.row, Truth.w.row]], wanted, rtol=0, atol=1e-13)
    reached = np.abs(states[:, [Truth.v.row, Truth.w.row]] - command).max(axis=1) < 1e-12
    assert time[np.argmax(reached)] == pytest.approx(seconds)
    # Braking is bounded as well, and the way is that of the ramps: v²/(2 a) each, and half a step's.
    if command[1] == 0.0:
        stopped = driven(slow, [command] * 60 + [(0.0, 0.0)] * 100, steps=1, kinematic=True)
        assert stopped[-1, Truth.v.row] == 0.0
        assert stopped[-1, Truth.x.row] == pytest.approx(0.3**2 / 0.5, abs=1e-12)


def test_bounds_of_acceleration_hold_for_the_wheel_loops_too_and_never_beyond_the_wheels():
    slow = replace(ROBOT, v_rate_max=0.5, w_rate_max=2.0)
    states = driven(slow, [(0.3, 0.0)] * 100, steps=1)
    time = TIME_STEP * np.arange(101)
    rising = (time > 0.3) & (time < 0.58)
    assert np.diff(states[rising, Truth.v.row]).mean() / TIME_STEP == pytest.approx(0.5, rel=0.05)
    assert np.abs(states[:, Truth.v.row] - np.minimum(0.5 * time, 0.3)).max() < 0.04  # the wheel loops' lag
    np.testing.assert_allclose(states[:, Truth.held_v.row], np.minimum(0.5 * time, 0.3), rtol=0, atol=1e-13)
    # v falls no faster than it may, so ω must wait: both together would be more than the wheels turn.
    turned = driven(slow, [(0.8, 0.0)] * 200 + [(0.0, 5.7)] * 100, steps=1, kinematic=True)
    assert (
        np.abs(turned[:, Truth.v.row]) + 0.1 * np.abs(turned[:, Truth.w.row]) <= ROBOT.wheel_speed_limit * (1 + 1e-12)
    ).all()
    # No bounds, or bounds that are never met: the same to the last bit.
    commands = [(0.4 * sin(0.1 * k), cos(0.2 * k)) for k in range(60)]
    for settings in ({}, {"kinematic": True}):
        free = driven(ROBOT, commands, **settings)
        wide = driven(replace(ROBOT, v_rate_max=1e9, w_rate_max=1e9), commands, **settings)
        np.testing.assert_array_equal(free, wide)
    # Torques are bounded by the motors only.
    torque = [(0.2, 0.1)] * 20
    np.testing.assert_array_equal(driven(ROBOT, torque, "torque"), driven(slow, torque, "torque"))


def test_torque_stays_within_its_limit_and_what_the_supply_reaches():
    for level, command in (("velocity", (0.8, 0.0)), ("torque", (5.0, 5.0))):
        states = driven(ROBOT, [command] * 200 + [(-command[0], 0.0)] * 100, level, steps=1)
        assert np.abs(of_wheels("torque", states)).max() == pytest.approx(ROBOT.torque_limit, abs=1e-12)
        wheel = (states[:-1, Truth.v.row] + ROBOT.half_axle * states[:-1, Truth.w.row]) / ROBOT.wheel_radius
        reach = ROBOT.torque_constant * (ROBOT.supply_voltage - ROBOT.back_emf * wheel)
        assert (of_wheels("torque", states)[1:, 0] <= reach + 1e-12).all()
    first = driven(ROBOT, [(0.8, 0.0)], steps=1)[1]
    assert first[Truth.v.row] == pytest.approx(
        0.01 * 2 * 0.35 / 0.045 / ROBOT.effective_mass, rel=0.1
    )  # a_max ≈ 5 m/s²


@pytest.mark.parametrize("friction", [0.0, 0.02])
def test_back_emf_ends_at_the_no_load_speed(friction):
    robot = replace(ROBOT, friction_torque=friction)
    end = driven(robot, [(1.0, 1.0)] * 60, "torque")[-1]
    drag = friction * 18 / np.hypot(18, 0.2)
    expected = (7.5 - drag / 0.0933) / 0.409
    assert end[Truth.v.row] / 0.045 == pytest.approx(expected, rel=1e-4)
    assert pytest.approx(175 * 2 * pi / 60, rel=1e-3) == 7.5 / 0.409


def test_effort_and_variation_are_the_sums_they_claim_to_be():
    commands = [(0.3 * (k % 3), 1.0) for k in range(60)]
    states = driven(ROBOT, commands, steps=1)
    torque = of_wheels("torque", states)
    assert states[-1, Truth.effort.row] == pytest.approx(0.01 * (torque[1:] ** 2).sum(), rel=1e-12)
    assert states[-1, Truth.variation.row] == pytest.approx(np.abs(np.diff(torque, axis=0)).sum(), rel=1e-12)


# Pose -----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("v", [0.5, -0.2])
@pytest.mark.parametrize("turn", [1, -1])
def test_kinematic_mode_drives_the_exact_circle_and_returns(v, turn):
    w = turn * 2 * pi / 5  # one turn in 5 s
    states = driven(ROBOT, [(v, w)] * 100, kinematic=True)
    t = 0.05 * np.arange(101)
    np.testing.assert_allclose(states[:, Truth.heading.row], w * t, rtol=0, atol=1e-12)
    np.testing.assert_allclose(states[:, Truth.x.row], v / w * np.sin(w * t), rtol=0, atol=1e-12)
    np.testing.assert_allclose(states[:, Truth.y.row], v / w * (1 - np.cos(w * t)), rtol=0, atol=1e-12)
    assert np.hypot(states[-1, Truth.x.row], states[-1, Truth.y.row]) < 1e-12
    straight = driven(ROBOT, [(v, 0.0)] * 100, kinematic=True)
    assert straight[-1, :3] == pytest.approx([v * 5, 0, 0], abs=1e-12)


def test_odometry_follows_the_truth_within_the_encoders_counts():
    time = 0.05 * np.arange(400)
    states = driven(ROBOT, [(0.4 * sin(0.9 * t) + 0.1, 2 * cos(0.7 * t)) for t in time])
    count = 2 * pi / 6000
    heading = np.abs(states[:, Truth.odo_heading.row] - states[:, Truth.heading.row])
    bound = ROBOT.wheel_radius * count / (2 * ROBOT.half_axle)  # less than a count on either wheel, for ever
    assert bound / 2 < heading.max() <= bound * (1 + 1e-9)
    gap = np.hypot(
        states[:, Truth.odo_x.row] - states[:, Truth.x.row], states[:, Truth.odo_y.row] - states[:, Truth.y.row]
    )
    driven_distance = np.cumsum(np.abs(states[:, Truth.v.row])) * 0.05
    assert gap.max() > 1e-5
    assert (gap <= bound * driven_distance + 3e-4).all()
    # A finer encoder is nearer
    fine = driven(replace(ROBOT, counts_per_turn=6e6), [(0.4 * sin(0.9 * t) + 0.1, 2 * cos(0.7 * t)) for t in time])
    assert np.abs(fine[:, Truth.odo_heading.row] - fine[:, Truth.heading.row]).max() <= bound / 1000 * (1 + 1e-6)


def test_odometry_starts_where_the_robot_believes_to_stand():
    state = p.initial_state(np.array([[1.0, 2.0, 0.5]]), np.array([[0.0, 0.0, 0.0]]))
    states = driven(replace(ROBOT, counts_per_turn=1e9), [(0.3, 0.0)] * 20, state=state, kinematic=True)
    assert states[-1, [Truth.x.row, Truth.y.row, Truth.heading.row]] == pytest.approx(
        [1 + 0.3 * cos(0.5), 2 + 0.3 * sin(0.5), 0.5], abs=1e-9
    )
    assert states[-1, [Truth.odo_x.row, Truth.odo_y.row, Truth.odo_heading.row]] == pytest.approx([0.3, 0, 0], abs=1e-6)


@pytest.mark.parametrize("late", range(6))
def test_late_command_takes_effect_exactly_that_many_steps_later(late):
    order, nothing = np.array([[0.5], [0.0]]), np.zeros((2, 1))
    state = machine(ROBOT, kinematic=True).advance(at_rest(), nothing, order, late, "velocity")
    assert state[Truth.x.row, 0] == pytest.approx(0.5 * (5 - late) * TIME_STEP, abs=1e-15)
    # The dynamic plant: late steps with the old command, then the new one, bit by bit as single steps.
    whole = machine(ROBOT).advance(at_rest(), nothing, order, late, "velocity")
    single = machine(ROBOT, steps=1)
    step_by_step = at_rest()
    for k in range(5):
        held = nothing if k < late else order
        step_by_step = single.advance(step_by_step, held, held, 0, "velocity")
    np.testing.assert_allclose(whole, step_by_step, rtol=0, atol=1e-13)
    assert (whole[Truth.x.row, 0] != 0) == (late < 5)


# Lanes ----------------------------------------------------------------------------------------------------------


def crowd(lanes):
    """Different robots in different states under different commands."""
    rng = np.random.default_rng(7)
    kinds = [
        ROBOT,
        replace(ROBOT, wheel_radius=0.04, filter_frequency=20.0, kd=0.001),
        replace(ROBOT, mass_offset=0.02, friction_torque=0.0, body_mass=3.0),
    ]
    rows = np.stack([p.parameters(kinds[i % 3]) for i in range(lanes)], axis=1)
    state = p.initial_state(rng.uniform(-3, 3, (lanes, 3)))
    commands = rng.uniform(-1, 1, (20, 2, lanes))
    return rows, state, commands


def rolled(rows, state, commands, level, kinematic):
    plant = p.Plant(rows, kinematic=kinematic)
    before = np.zeros_like(commands[0])
    for command in commands:
        state = plant.advance(state, before, command, 2, level)
        before = command
    return state


@pytest.mark.parametrize(("level", "kinematic"), [("velocity", False), ("torque", False), ("velocity", True)])
def test_lanes_do_not_see_each_other_to_the_last_bit(level, kinematic):
    rows, state, commands = crowd(1000)
    together = rolled(rows, state, commands, level, kinematic)
    assert np.isfinite(together).all()
    for lanes in (1, 3, 8, 9, 31, 32, 33, 40, 65):
        part = rolled(rows[:, :lanes], state[:, :lanes], commands[:, :, :lanes], level, kinematic)
        assert part.tobytes() == np.ascontiguousarray(together[:, :lanes]).tobytes()
    for lane in (0, 5, 31, 32, 500, 999):
        one = slice(lane, lane + 1)
        alone = rolled(rows[:, one], state[:, one], commands[:, :, one], level, kinematic)
        assert alone.tobytes() == np.ascontiguousarray(together[:, one]).tobytes()


def test_a_lane_gone_mad_spoils_no_other():
    rows, state, commands = crowd(20)
    good = rolled(rows, state, commands, "velocity", False)
    state[:, 7] = np.nan
    commands[:, :, 3] = inf
    bad = rolled(rows, state, commands, "velocity", False)
    others = [i for i in range(20) if i not in (3, 7)]
    assert bad[:, others].tobytes() == good[:, others].tobytes()
    assert np.isnan(bad[:, 7]).any()


@pytest.mark.parametrize(
    ("code", "level", "kinematic"), [(0, "velocity", False), (1, "torque", False), (2, "velocity", True)]
)
def test_a_tick_in_place_is_the_same_to_the_last_bit(code, level, kinematic):
    rows, state, commands = crowd(45)
    before, here = np.zeros_like(commands[0]), state.copy()
    after = p.Plant(rows, kinematic=kinematic).advance(state, before, commands[0], 2, level)
    p.tick_into(here, here, rows, before, commands[0], 2, 5, p.STEP, 4, code, np.full(p.SCRATCH, np.nan))
    assert here.tobytes() == after.tobytes()


def test_advance_leaves_its_arguments_alone():
    rows, state, commands = crowd(5)
    copies = state.copy(), commands.copy(), rows.copy()
    rolled(rows, state, commands, "velocity", False)
    assert all((a == b).all() for a, b in zip(copies, (state, commands, rows), strict=True))


WITHOUT_COMPILER = """
import sys
import numpy as np
from robotics.world.vehicle import plant as p
data = np.load(sys.argv[1])
for name, level, kinematic in (("v", "velocity", False), ("t", "torque", False), ("k", "velocity", True)):
    plant, state = p.Plant(data["rows"], kinematic=kinematic), data["state"]
    for command in data["commands"]:
        state = plant.advance(state, command[::-1], command, 2, level)
    data = dict(data) | {name: state}
np.savez(sys.argv[2], **data)
"""


def test_interpreted_the_plant_gives_the_same_numbers(tmp_path):
    rows, state, commands = crowd(3)
    state[Truth.v.row], state[Truth.w.row] = 0.2, 0.5
    np.savez(tmp_path / "in.npz", rows=rows, state=state, commands=commands[:2])
    subprocess.run(
        [sys.executable, "-c", WITHOUT_COMPILER, str(tmp_path / "in.npz"), str(tmp_path / "out.npz")],
        env=os.environ | {"NUMBA_DISABLE_JIT": "1"},
        check=True,
    )
    interpreted = np.load(tmp_path / "out.npz")
    cases: Any = (("v", "velocity", False), ("t", "torque", False), ("k", "velocity", True))
    for name, level, kinematic in cases:
        plant, compiled = p.Plant(rows, kinematic=kinematic), state
        for command in commands[:2]:
            compiled = plant.advance(compiled, command[::-1], command, 2, level)
        np.testing.assert_allclose(interpreted[name], compiled, rtol=1e-12, atol=1e-12)


# What a data sheet leaves out -----------------------------------------------------------------------------------


def test_wheels_stand_within_their_dead_band_one_by_one():
    """Rims are asked for v + L ω and v - L ω: 0.11 and 0.09 m/s, then 0.11 and -0.01."""
    banded = replace(ROBOT, dead_band=0.1)
    for v, w, right, left in ((0.1, 0.1, 0.11, 0.0), (0.05, 0.6, 0.11, 0.0), (0.09, 0.0, 0.0, 0.0)):
        states = driven(banded, [(v, w)] * 40)
        rims = of_wheels("angle", states)[-1] - of_wheels("angle", states)[-2]
        assert rims * ROBOT.wheel_radius / 0.05 == pytest.approx([right, left], abs=2e-3)


def test_a_rounded_command_is_the_rounded_command():
    """To the last bit that of a perfect robot, whose driver rounds."""
    rounded = replace(ROBOT, v_resolution=0.03, w_resolution=0.25)
    by_plant = driven(rounded, [(0.22, 0.3), (0.23, -0.4)] * 10)
    by_hand = driven(ROBOT, [(0.03 * 7.0, 0.25), (0.03 * 8.0, -0.5)] * 10)
    assert np.array_equal(by_plant, by_hand)


def test_a_robot_stays_behind_wheels_that_speed_up():
    """κ = k a: from rest to v the way is short by ∫ k a v dt = k v²/2 of each wheel, whatever the time took."""
    k = 0.05
    end = Truth(driven(replace(ROBOT, longitudinal_slip=k, mass_offset=0.0), [(0.4, 0.0)] * 60)[-1])
    way = end.right.angle * ROBOT.wheel_radius
    assert way - end.x == pytest.approx(k * end.v**2 / 2, rel=1e-6)
    assert way > 1.0


def test_a_robot_drifts_outwards_in_a_curve():
    """α = k v ω: a steady circle has the radius √(1 + α²) v/ω, as its velocity has another component across."""
    k, states = 0.2, driven(replace(ROBOT, lateral_slip=0.2), [(0.4, 1.0)] * 400)
    drive = Truth(states[150:].T)
    v, w = drive.v.mean(), drive.w.mean()
    design = np.stack([drive.x, drive.y, np.ones_like(drive.x)], axis=1)  # a circle, by least squares
    two_x, two_y, rest = np.linalg.lstsq(design, drive.x**2 + drive.y**2, rcond=None)[0]
    radius = np.sqrt(rest + (two_x / 2) ** 2 + (two_y / 2) ** 2)
    assert radius == pytest.approx(v / w * np.sqrt(1 + (k * v * w) ** 2), rel=1e-3)
    assert radius > 1.002 * v / w


@pytest.mark.parametrize("spot", [False, True])
def test_a_castor_brakes_what_coasts_by_its_dry_friction(spot):
    """v' = -D/m straight on, ω' = -D |x_c| / I on the spot: the castor then moves across."""
    dragging = replace(FREE, castor_drag=0.5, castor_offset=-0.08, mass_offset=0.0, friction_speed=0.01)
    state = at_rest()
    row, start = (Truth.w.row, 2.0) if spot else (Truth.v.row, 0.5)
    state[row] = start
    states = driven(dragging, [(0.0, 0.0)] * 6, "torque", state)
    inertia = dragging.effective_inertia if spot else dragging.effective_mass
    slowing = 0.5 * (0.08 if spot else 1.0) / inertia
    assert start - states[-1, row] == pytest.approx(0.3 * slowing, rel=2e-3)
    assert Truth(states[-1]).loss == pytest.approx(inertia / 2 * (start**2 - states[-1, row] ** 2), rel=0.02)


def test_a_perfect_robot_is_the_same_to_the_last_bit_beside_an_imperfect_one():
    """What is off costs no bit: the others' lanes do not see it, whichever level is commanded."""
    rough = replace(
        ROBOT, dead_band=0.05, v_resolution=0.01, longitudinal_slip=0.1, lateral_slip=0.1, castor_drag=0.3,
    )  # fmt: skip
    cases: Any = (("velocity", False), ("torque", False), ("velocity", True))
    for level, kinematic in cases:
        command = np.array([[0.314], [0.7]]) * (0.1 if level == "torque" else 1.0)
        alone, beside = at_rest(), at_rest(3)
        for _ in range(20):
            alone = machine(ROBOT, kinematic=kinematic).advance(alone, 0 * command, command, 2, level)
            three = machine(rough, ROBOT, rough, kinematic=kinematic)
            both = np.repeat(command, 3, axis=1)
            beside = three.advance(beside, 0 * both, both, 2, level)
        assert np.array_equal(beside[:, 1], alone[:, 0])
        assert not np.array_equal(beside[:, 0], alone[:, 0])


# Robot ----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("field", "value", "message"),
    [
        ("body_mass", 0.0, "body_mass must be a finite number in kg, > 0; got 0.0"),
        ("wheel_radius", 45.0, "wheel_radius must be a finite number in m, > 0 and <= 1; got 45.0"),
        ("half_axle", -0.1, "half_axle must be a finite number in m"),
        ("friction_torque", -0.1, ">= 0"),
        ("mass_offset", float("nan"), "mass_offset must be a finite number"),
        ("torque_limit", inf, "torque_limit must be a finite number"),
        ("kp", "0.8", "kp must be a finite number in V s/rad"),
        ("ki", True, "ki must be a finite number in V/rad"),
        ("filter_frequency", 60.0, "<= 49"),
    ],
)
def test_impossible_robots_are_refused(field, value, message):
    with pytest.raises(RobotError) as caught:
        replace(ETSRO, **{field: value})
    assert message in str(caught.value)
    assert caught.value.at[-1] == field
