"""The linear-quadratic regulator: its model and its gain against scipy, standstill, and its runs."""

from dataclasses import replace
from math import pi

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st
from scipy.linalg import expm, solve_discrete_are

from fuzzy.compiled.jit import kernel
from robotics.laws.catalogue import make_controller
from robotics.laws.equation import gain_columns
from robotics.laws.law import ControllerError, Observation
from robotics.laws.tracking.linear_quadratic import LinearQuadratic, discretised, feedback
from robotics.measures.tracking import METRICS, tracking_error
from robotics.simulation.loop import simulate
from robotics.simulation.scenario.reading import load_scenario, parse_scenario
from robotics.world.paths.references import Reference
from robotics.world.sensing.posture import Sensing
from tests.robotics.laws.tracking.courses import from_random_starts

SETTING = load_scenario("lyapunov-circle").setting  # of one robot
LAW = LinearQuadratic()
Gain = gain_columns(LinearQuadratic)


@kernel
def _feedback(v, w, dt, gains):
    return np.array(feedback(v, w, dt, Gain(gains, 0)))


def gain_of(law, v, w, period):
    """K (2, 3) of the regulator about these speeds."""
    return _feedback(float(v), float(w), float(period), law.gain_array()).reshape(2, 3)


def model(v, w, period):
    """F and G by scipy's matrix exponential."""
    a = np.array([[0, w, 0], [-w, 0, v], [0, 0, 0]])
    b = np.array([[-1.0, 0], [0, 0], [0, -1]])
    both = expm(np.block([[a, b], [np.zeros((2, 5))]]) * period)
    return both[:3, :3], both[:3, 3:]


speed = st.floats(0.02, 1.5).flatmap(lambda v: st.sampled_from([v, -v]))
turn = st.floats(-4.0, 4.0)
period = st.sampled_from([0.01, 0.05, 0.1, 0.3])
share = st.floats(0.2, 5.0)


@given(speed, turn, period)
@example(0.3, 4.99, 0.05)  # just below and above where the series end
@example(0.3, 5.01, 0.05)
@settings(max_examples=100)
def test_the_model_is_the_matrix_exponential(v, w, dt):
    f, g = (np.array(part) for part in discretised.py_func(v, w, dt))
    exact_f, exact_g = model(v, w, dt)
    np.testing.assert_allclose(f.reshape(3, 3), exact_f, rtol=0, atol=1e-14)
    np.testing.assert_allclose(g.reshape(3, 2), exact_g, rtol=0, atol=1e-15)


@given(speed, turn, period, st.tuples(*[share] * 5))
@settings(max_examples=150)
def test_the_gain_is_that_of_scipys_riccati_equation(v, w, dt, shares):
    names = ("x_scale", "y_scale", "heading_scale", "v_scale", "w_scale")
    scales = {name: share * getattr(LAW, name) for name, share in zip(names, shares, strict=True)}
    law = LinearQuadratic(**scales)
    found = gain_of(law, v, w, dt)
    f, g = model(v, w, dt)
    weights = np.array(list(scales.values())) ** -2.0
    q, r = np.diag(weights[:3]), np.diag(weights[3:])
    p = solve_discrete_are(f, g, q, r)
    exact = np.linalg.solve(r + g.T @ p @ g, g.T @ p @ f)
    np.testing.assert_allclose(found, exact, rtol=0, atol=1e-9 * np.abs(exact).max())
    assert np.abs(np.linalg.eigvals(f - g @ found)).max() < 1


def decide(law, e, v_d, w_d, v=0.0):
    """The command to a robot at the origin, along x, that sees its target at these errors."""
    one = np.ones((1, 1))
    target = Reference(*(np.array([value]) for value in (*e, v_d, w_d, 0.0)))
    seen = Observation(0.0, 0 * one, 0 * one, 0 * one, v * one, 0 * one, target, SETTING.references)
    command, _ = law.control(seen, law.init(SETTING, 1), 0.05)
    return np.array([command.first[0, 0], command.second[0, 0]])


def test_it_commands_the_references_velocities_and_the_gain_times_the_errors():
    e = np.array([0.02, -0.03, 0.05])
    k = gain_of(LAW, 0.3, 0.4, 0.05)
    np.testing.assert_allclose(decide(LAW, e, 0.3, 0.4), [0.3 * np.cos(0.05), 0.4] - k @ e, atol=1e-14)
    without = decide(replace(LAW, feed_forward="none"), e, 0.3, 0.4)
    np.testing.assert_allclose(without, -k @ e, atol=1e-14)
    # Backwards as forwards, mirrored: x_e and the headings change their signs
    back = decide(LAW, (-0.02, -0.03, -0.05), -0.3, -0.4)
    np.testing.assert_allclose(back, -decide(LAW, e, 0.3, 0.4), atol=1e-12)


def test_at_standstill_it_turns_to_the_heading_and_does_not_chase_what_lies_beside_it():
    k = gain_of(LAW, LAW.slowest, 0.0, 0.05)
    v, w = decide(LAW, (0.1, 0.2, 0.3), 0.0, 0.0)
    assert v == pytest.approx(-k[0, 0] * 0.1)
    assert w == pytest.approx(-k[1, 2] * 0.3)
    # Below the slowest speed of the model the lateral gain grows in proportion, and there is no step at 0
    half = decide(LAW, (0.0, 0.01, 0.0), LAW.slowest / 2, 0.0)[1]
    assert half == pytest.approx(-k[1, 1] * 0.01 / 2)
    assert decide(LAW, (0.0, 0.01, 0.0), 1e-9, 0.0)[1] == pytest.approx(0.0, abs=1e-8)
    # Catching up with a reference at rest it steers by its own speed
    moving = gain_of(LAW, 0.3, 0.0, 0.05)
    assert decide(LAW, (0.5, 0.01, 0.0), 0.0, 0.0, v=0.6)[1] == pytest.approx(-moving[1, 1] * 0.01)


@pytest.mark.parametrize(
    ("scenario", "within"), [("lyapunov-sine", 3.5), ("lyapunov-circle", 2.5), ("fuzzy-off-path", 4.0)]
)
def test_it_tracks_with_noise_from_off_the_path_and_stops(scenario, within):
    """5 cm for good, then below 2 mm from the path, with 3 mm of posture noise, on the full plant 30 ms late."""
    run = simulate(replace(load_scenario(scenario), latency=0.03), LAW, range(20))
    assert METRICS["settling_time_s"].measure(run).max() < within
    assert METRICS["rms_cross_track_under_way_m"].measure(run).max() < 0.002
    assert METRICS["w_variation_radps2"].measure(run).max() < 1.5
    e = tracking_error(run)
    assert np.hypot(e.x, e.y)[..., -1].max() < 0.01


def test_every_random_start_converges():
    """Steering by the direction of its own speed, not of the reference's, one in ten drives beside it backwards."""
    run = simulate(from_random_starts("lyapunov-circle", (-1.5, -0.5, -pi), (1.5, 2.5, pi)), LAW)
    assert METRICS["settling_time_s"].measure(run).max() < 8.0


LINE = """
duration = 12.0
plant = "kinematic"
[[robots]]
start = [0.0, 0.0, 0.0]
path = { shape = "line", start = [0.0, 0.0], end = [2.0, 0.0] }
timing = { speed = 0.25 }
"""


def test_on_the_path_it_commands_the_reference_and_at_the_end_it_rests():
    run = simulate(replace(parse_scenario(LINE, "line"), sensing=Sensing()), LAW)
    assert np.abs(run["y"]).max() < 1e-9
    assert np.abs(run["v"][0, 0, 20:150] - 0.25).max() < 1e-3
    assert abs(run["x"][0, 0, -1] - 2.0) < 1e-3
    assert np.abs(run["v"][0, 0, -20:]).max() < 1e-3


def test_wrong_scales_are_refused():
    with pytest.raises(ControllerError, match=r"y_scale must be a finite number in m, > 0; got 0"):
        make_controller("lqr:y_scale=0")
