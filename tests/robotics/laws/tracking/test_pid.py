"""PID control: its placed poles against the differential equation, its integrals, its filter, and its runs."""

from dataclasses import replace
from math import pi
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import solve_ivp
from scipy.optimize import fsolve

from robotics.laws.law import Observation
from robotics.laws.tracking.pid import TrackingPID, placed
from robotics.measures.tracking import METRICS, tracking_error
from robotics.simulation.loop import simulate
from robotics.simulation.scenario.reading import load_scenario, parse_scenario
from robotics.world.paths.references import Reference
from robotics.world.sensing.posture import Sensing
from tests.robotics.laws.tracking.courses import from_random_starts

SETTING = load_scenario("lyapunov-circle").setting  # of one robot
LAW = TrackingPID()


def test_the_default_gains_are_those_of_the_placement():
    assert {name: getattr(LAW, name) for name in placed(1.0, 0.3)} == pytest.approx(placed(1.0, 0.3))


@given(st.floats(0.3, 3), st.floats(0.1, 1), st.floats(0, 1))
def test_the_characteristic_polynomials_have_the_placed_roots(p, v, dpsi):
    k = placed(p, v, dpsi)
    lateral = [1 + dpsi, k["kpsi"], v * k["ky"], v * k["iy"]]
    np.testing.assert_allclose(lateral, (1 + dpsi) * np.poly([-p] * 3), rtol=1e-12)
    np.testing.assert_allclose([1, k["kx"], k["ix"]], np.poly([-p] * 2), rtol=1e-12)


LINE = """
duration = 12.0
plant = "kinematic"
[[robots]]
start = [0.0, 0.0, 0.0]
path = { shape = "line", start = [0.0, 0.0], end = [6.0, 0.0] }
timing = { speed = 0.3 }
"""
ON_A_LINE = replace(parse_scenario(LINE, "line"), sensing=Sensing(posture="pose"))


@pytest.mark.parametrize(("aside", "along"), [(0.02, 0.0), (0.0, 0.03)])
def test_a_kinematic_run_is_the_placed_differential_equation(aside, along):
    """y''' + 3 y'' + 3 y' + y = 0 aside, and x'' + 2 x' + x = 0 along the path, by scipy's integrator."""
    gains: Any = placed(1.0, 0.3, 0.0)
    beside = replace(ON_A_LINE.robots[0], start=(-along, aside, 0.0))
    run = simulate(replace(ON_A_LINE, period=0.01, robots=(beside,)), TrackingPID(**gains, dpsi=0.0))
    times = run.time[run.time <= 10]

    def rates(t, z):
        y, dy, ddy, x, dx = z
        return [dy, ddy, -3 * ddy - 3 * dy - y, dx, -2 * dx - x]

    exact = solve_ivp(rates, (0, 10), [aside, 0, -3 * aside, along, -2 * along], t_eval=times, rtol=1e-9, atol=1e-12).y
    if aside:
        np.testing.assert_allclose(run["y"][0, 0, : len(times)], exact[0], rtol=0, atol=0.02 * aside)
    else:
        np.testing.assert_allclose(tracking_error(run).x[0, 0, : len(times)], exact[3], rtol=0, atol=0.02 * along)


def commands(law, errors, v_d=0.3, w_d=0.2):
    """The commands (periods, 2) to a robot at the origin, along x, that sees targets at ``errors`` (periods, 3)."""
    memory, said = law.init(SETTING, 1), []
    zero = np.zeros((1, 1))
    for e in errors:
        target = Reference(*(np.array([value]) for value in (*e, v_d, w_d, 0.0)))
        seen = Observation(0.0, zero, zero, zero, zero, zero, target, SETTING.references)
        command, memory = law.control(seen, memory, 0.05)
        said.append((command.first[0, 0], command.second[0, 0]))
    return np.array(said)


def test_commands_are_the_printed_formulas():
    law = TrackingPID(kx=1.5, ix=0.0, ky=2.0, iy=0.0, kpsi=3.0, dpsi=0.0)
    expected = [0.3 * np.cos(0.4) + 1.5 * 0.1, 0.2 + 2.0 * -0.05 + 3.0 * 0.4]
    np.testing.assert_allclose(commands(law, [(0.1, -0.05, 0.4)])[0], expected, rtol=1e-14)
    without = replace(law, feed_forward="none")
    np.testing.assert_allclose(commands(without, [(0.1, -0.05, 0.4)])[0], [1.5 * 0.1, expected[1] - 0.2], rtol=1e-14)
    standing = commands(law, [(0.0, 0.05, 0.4)], v_d=0.0, w_d=0.0)
    np.testing.assert_allclose(standing[0], [0.0, 3.0 * 0.4], atol=1e-15)  # what lies aside is not chased
    backwards = commands(law, [(-0.1, -0.05, -0.4)], v_d=-0.3, w_d=-0.2)
    np.testing.assert_allclose(backwards[0], np.negative(expected), rtol=1e-14)


def test_integrals_are_bounded_and_stand_far_from_the_path_and_at_the_limits():
    still = replace(LAW, kx=0.0, ky=0.0, kpsi=0.0, dpsi=0.0)
    near = commands(still, [(0.02, -0.01, 0.0)] * 400)
    np.testing.assert_allclose(near[:5, 0] - 0.3, [0, 0.001, 0.002, 0.003, 0.004], atol=1e-12)
    np.testing.assert_allclose(near[:5, 1] - 0.2, [0, -0.0025, -0.005, -0.0075, -0.01], atol=1e-12)
    np.testing.assert_allclose(near[-1], [0.3 + 0.05, 0.2 - 0.1])
    np.testing.assert_allclose(commands(still, [(0.2, -0.2, 0.0)] * 400)[-1], [0.3, 0.2])  # beyond the band
    fast = replace(
        LAW, kx=0.0, ky=0.0, dpsi=0.0, kpsi=100.0
    )  # whose command is beyond the wheels, with a heading error
    errors = [(0.02, -0.01, 0.5)] * 400 + [(0.0, 0.0, 0.0)]
    np.testing.assert_allclose(commands(fast, errors)[-1], [0.3, 0.2])


def test_the_derivative_is_filtered():
    """A ramp of 1 rad/s: the response of a first-order low-pass in steps, from 0 to D."""
    law = replace(LAW, kx=0.0, ky=0.0, kpsi=0.0, ix=0.0, iy=0.0)
    said = commands(law, [(0.0, 0.0, 0.05 * k) for k in range(40)])[:, 1] - 0.2
    k = np.arange(40)
    np.testing.assert_allclose(said, 0.5 * (1 - (0.1 / 0.15) ** k), atol=1e-12)


def test_the_integrals_take_away_what_is_left_without_feed_forward():
    """On a circle without noise: the equilibrium of the error dynamics, 15 cm, or nothing with the integrals."""
    scenario = replace(load_scenario("lyapunov-circle"), sensing=Sensing(posture="pose"))
    bare = replace(LAW, feed_forward="none", band=1.0, most_v=1.0, most_w=1.0)
    means = []
    for law in (bare, replace(bare, ix=0.0, iy=0.0)):
        e = tracking_error(run := simulate(scenario, law))
        tail = run.time > 18
        means.append((e.x[0, 0, tail].mean(), e.y[0, 0, tail].mean()))
    np.testing.assert_allclose(means[0], 0, atol=5e-4)

    def rates(e):  # of (5.9), where v_d = 0.3 and ω = ω_d = −0.3
        x, y, psi = e
        return [
            -0.3 * y - LAW.kx * x + 0.3 * np.cos(psi),
            0.3 * x + 0.3 * np.sin(psi),
            LAW.ky * y + LAW.kpsi * psi + 0.3,
        ]

    np.testing.assert_allclose(means[1], fsolve(rates, [0.1, 0, 0])[:2], rtol=0.01)


@pytest.mark.parametrize(
    ("scenario", "within"), [("lyapunov-sine", 3.5), ("lyapunov-circle", 2.5), ("fuzzy-off-path", 4.0)]
)
def test_it_tracks_with_noise_from_off_the_path_and_stops(scenario, within):
    run = simulate(replace(load_scenario(scenario), latency=0.03), LAW, range(20))
    assert METRICS["settling_time_s"].measure(run).max() < within
    assert METRICS["rms_cross_track_under_way_m"].measure(run).max() < 0.003
    assert METRICS["w_variation_radps2"].measure(run).max() < 2.0
    e = tracking_error(run)
    assert np.hypot(e.x, e.y)[..., -1].max() < 0.01


def test_at_the_end_it_rests():
    line = replace(ON_A_LINE, plant="dynamic", sensing=Sensing(posture="pose", position_noise=0.003), latency=0.03)
    run = simulate(replace(line, duration=28.0), LAW, range(20))
    assert np.abs(run["v"][..., -20:]).max() < 0.03  # 3 mm of noise times K_x, and the wheels' share of it
    assert np.abs(run["x"][..., -1] - 6.0).max() < 0.01
    assert np.abs(run["heading"][..., -1]).max() < 0.02


def test_every_random_start_converges():
    """With the errors in the path's frame instead of the robot's one in six never comes to it."""
    run = simulate(from_random_starts("lyapunov-sine", (-1.5, -1.5, -pi), (1.5, 1.5, pi)), LAW)
    assert METRICS["settling_time_s"].measure(run).max() < 9.0
