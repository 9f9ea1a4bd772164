"""Row D of the acceptance list, and the closed forms of thesis 2.2."""

from dataclasses import replace
from math import pi, sqrt

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import solve_ivp

from robotics.laws.catalogue import make_controller
from robotics.laws.law import Observation
from robotics.laws.tracking.lyapunov import Lyapunov
from robotics.measures.tracking import settling_time, tracking_error
from robotics.simulation.loop import simulate
from robotics.simulation.scenario.reading import load_scenario
from robotics.world.paths.posture import posture_error, wrapped
from robotics.world.paths.references import Reference
from robotics.world.sensing.posture import Sensing

SETTING = load_scenario("lyapunov-circle").setting  # of one robot
NOISY = Sensing(posture="pose", position_noise=0.005)

Pose = tuple[np.ndarray, np.ndarray, np.ndarray]  # x, y, heading


def pose_and_target(x, y, heading, v=0.0, w=0.0, s=0.0) -> tuple[Pose, Reference]:
    """A target at the origin, and a robot that sees it at (x, y, heading) from itself (5.9)."""
    here = np.array([[heading]])  # so that the robot's heading is -heading
    robot = -np.cos(here) * x - np.sin(here) * y, np.sin(here) * x - np.cos(here) * y, -here
    return robot, Reference(*(np.array([value]) for value in (0.0, 0.0, 0.0, v, w, s)))


def decide(law, robot: Pose, target):
    zero = np.zeros((1, 1))
    seen = Observation(0.0, *robot, zero, zero, target, SETTING.references)
    command, _ = law.control(seen, law.init(SETTING, 1), 0.05)
    return float(command.v[0, 0]), float(command.w[0, 0])


def advance(robot: Pose, target, v, w, h) -> tuple[Pose, Reference]:
    """Both a small exact arc on."""
    x, y, heading = robot
    arc = w * h / 2
    chord = v * h * np.sinc(arc / pi)
    moved = x + chord * np.cos(heading + arc), y + chord * np.sin(heading + arc), heading + w * h
    turn = target.w * h / 2
    chord = target.v * h * np.sinc(turn / pi)
    to = target._replace(
        x=target.x + chord * np.cos(target.heading + turn),
        y=target.y + chord * np.sin(target.heading + turn),
        heading=target.heading + target.w * h,
    )
    return moved, to


def certificate(robot: Pose, target, ky):
    """V = (x² + y²)/2 + (1 − cos ψ)/K_y   (2.33)."""
    e = posture_error(*robot, target)
    return float(((e.x**2 + e.y**2) / 2 + (1 - np.cos(e.heading)) / ky)[0, 0])


error = st.tuples(st.floats(-2, 2), st.floats(-2, 2), st.floats(-3.1, 3.1))
gain = st.floats(0.2, 10)


@given(error, st.tuples(gain, gain, gain), st.floats(-0.6, 0.6), st.floats(-2, 2), st.sampled_from(["2.31", "2.32"]))
@settings(max_examples=150)
def test_derivative_of_the_certificate_is_2_34_and_never_positive(e, gains, v_d, w_d, form):
    """V' by differences along the true motion; the closed form has no term in y and no w_d."""
    kx, ky, kpsi = gains
    law = Lyapunov(kx=kx, ky=ky, kpsi=kpsi, form=form, catch_up=0.0)
    robot, target = pose_and_target(e[0], e[1], e[2], v_d, w_d)
    assert [float(f[0, 0]) for f in posture_error(*robot, target)] == pytest.approx(e, abs=1e-12)
    v, w = decide(law, robot, target)
    h = 1e-5
    ahead, behind = (certificate(*advance(robot, target, v, w, d), ky) for d in (h, -h))
    x, y, psi = e
    if form == "2.32":
        # With v_d < 0 the term v_d y sin ψ of x y' is not cancelled by |v_d| K_y y: the law drives forwards.
        expected = -kx * x**2 - kpsi / ky * abs(v_d) * np.sin(psi) ** 2 + (v_d - abs(v_d)) * y * np.sin(psi)
    else:
        expected = -kx * x**2 - kpsi / ky * np.sin(psi) ** 2
    assert (ahead - behind) / (2 * h) == pytest.approx(expected, abs=1e-5 * (1 + abs(v) + abs(w)) ** 3)
    if v_d >= 0:
        assert expected <= 0


@pytest.mark.parametrize(("ky", "kpsi"), [(1.0, 1.0), (10.0, 5.0)])
@pytest.mark.parametrize("v_d", [0.1, 0.3])
def test_lateral_poles_are_sqrt_ky_a_metre_with_damping_kpsi_over_2_sqrt_ky(ky, kpsi, v_d):
    law = Lyapunov(ky=ky, kpsi=kpsi, catch_up=0.0)

    def rate(e):
        robot, target = pose_and_target(e[0], e[1], e[2], v_d)
        h = 1e-6
        v, w = decide(law, robot, target)
        a, b = (
            posture_error(*arrived[0], arrived[1]) for arrived in (advance(robot, target, v, w, d) for d in (h, -h))
        )
        return np.array([float(p[0, 0] - q[0, 0]) / (2 * h) for p, q in zip(a, b, strict=True)])

    step = 1e-4
    jacobian = np.array([(rate(step * d) - rate(-step * d)) / (2 * step) for d in np.eye(3)]).T
    poles = np.linalg.eigvals(jacobian)
    assert np.abs(poles + 1.0).min() < 1e-4  # x: −K_x
    lateral = poles[np.argsort(np.abs(poles + 1.0))[1:]]
    wn, zeta = v_d * sqrt(ky), kpsi / (2 * sqrt(ky))
    assert np.prod(lateral).real == pytest.approx(wn**2, rel=1e-4)
    assert -np.sum(lateral).real == pytest.approx(2 * zeta * wn, rel=1e-4)
    assert 5 / (2 * sqrt(10)) == pytest.approx(0.79, abs=5e-3)  # [D]: 1, 10, 5


def test_commands_are_the_printed_formulas():
    robot, target = pose_and_target(0.4, -0.2, 0.7, 0.3, 0.5)
    v = 0.3 * np.cos(0.7) + 1.5 * 0.4
    law = Lyapunov(kx=1.5, ky=2.0, kpsi=3.0, form="2.31")
    assert decide(law, robot, target) == pytest.approx((v, 0.5 + 0.3 * 2.0 * -0.2 + 3.0 * np.sin(0.7)))
    law = replace(law, form="2.32", catch_up=0.0)
    assert decide(law, robot, target) == pytest.approx((v, 0.5 + 0.3 * (2.0 * -0.2 + 3.0 * np.sin(0.7))))
    resting = target._replace(v=np.zeros(1), w=np.zeros(1))
    assert decide(law, robot, resting)[1] == 0  # (2.32) leaves the heading alone at v_d = 0
    assert decide(replace(law, catch_up=0.3), robot, resting)[1] == pytest.approx(0.3 * (-0.4 + 3 * np.sin(0.7)))
    assert decide(replace(law, form="2.31"), robot, resting)[1] == pytest.approx(3 * np.sin(0.7))


def test_kinematic_run_is_the_error_dynamics_integrated():
    """x' = v_d cos ψ − v + y ω, y' = v_d sin ψ − x ω, ψ' = ω_d − ω (errata A19), by scipy's integrator."""
    scenario = replace(
        load_scenario("lyapunov-circle"), plant="kinematic", period=0.01, sensing=Sensing(posture="pose")
    )
    run = simulate(scenario, make_controller("lyapunov:catch_up=0"))
    v_d, w_d = 0.3, -0.3

    def rates(t, e):
        x, y, psi = e
        v = v_d * np.cos(psi) + x
        w = w_d + v_d * (10 * y + 5 * np.sin(psi))
        return [v_d * np.cos(psi) - v + y * w, v_d * np.sin(psi) - x * w, w_d - w]

    times = run.time[run.time <= 10]
    exact = solve_ivp(rates, (0, 10), [0.0, -0.5, 0.0], t_eval=times, rtol=1e-9, atol=1e-10).y
    e = tracking_error(run)
    for ours, theirs in zip(e, exact, strict=True):
        np.testing.assert_allclose(ours[0, 0, : len(times)], theirs, rtol=0, atol=0.006)  # 10 ms sample and hold


# Row D ----------------------------------------------------------------------------------------------------------


def measured(scenario, law, sensing, latency, seeds):
    run = simulate(replace(load_scenario(scenario), sensing=sensing, latency=latency), make_controller(law), seeds)
    e = tracking_error(run)
    distance = np.hypot(e.x, e.y)
    tail = run.time >= 20
    return settling_time(run, distance).max(), np.sqrt(np.mean(distance[..., tail] ** 2, axis=-1)).max(), e.heading


@pytest.mark.parametrize("scenario", ["lyapunov-sine", "lyapunov-circle"])
@pytest.mark.parametrize(
    ("law", "sensing", "latency", "settle", "tail"),
    [
        ("lyapunov", Sensing(), 0.0, 5.0, 0.003),
        ("lyapunov", NOISY, 0.08, 5.0, 0.006),
        ("lyapunov-thesis", Sensing(), 0.0, 18.0, 0.010),
        ("lyapunov-thesis", NOISY, 0.08, 18.0, 0.020),
    ],
    ids=["1-10-5", "1-10-5-noise-and-80-ms", "1-1-1", "1-1-1-noise-and-80-ms"],
)
def test_row_d_settling_and_tail(scenario, law, sensing, latency, settle, tail):
    time, rms, heading_error = measured(scenario, law, sensing, latency, range(5))
    assert time <= settle
    assert rms <= tail
    # Not driving backwards with the heading reversed (erratum A7)
    assert np.abs(wrapped(heading_error[..., -100:])).max() < 0.2


def test_tuned_gains_settle_sooner_than_the_thesis_gains():
    for scenario in ("lyapunov-sine", "lyapunov-circle"):
        tuned, thesis = (measured(scenario, law, Sensing(), 0.0, (0,))[0] for law in ("lyapunov", "lyapunov-thesis"))
        assert tuned < thesis / 3


@pytest.mark.parametrize("scenario", ["lyapunov-sine", "lyapunov-circle"])
@pytest.mark.parametrize("law", ["lyapunov:signs=literal", "lyapunov-thesis:signs=literal"])
def test_literal_signs_diverge_beyond_a_metre(scenario, law):
    """(2.28) as printed makes (2.30) positive feedback (erratum A19)."""
    run = simulate(replace(load_scenario(scenario), sensing=Sensing()), make_controller(law))
    e = tracking_error(run)
    assert np.nanmax(np.hypot(e.x, e.y)) > 1.0
    assert run.diverged.all()


def test_every_random_start_converges():
    """[D]: 120 of 120 within ±1.5 m and all headings, both gains."""
    rng = np.random.default_rng(3)
    scenario = load_scenario("lyapunov-sine")
    members = tuple(
        replace(scenario.robots[0], start=(*rng.uniform(-1.5, 1.5, 2), rng.uniform(-pi, pi))) for _ in range(100)
    )
    for law in ("lyapunov", "lyapunov:form=2.31"):
        run = simulate(replace(scenario, robots=members, sensing=Sensing()), make_controller(law))
        e = tracking_error(run)
        assert np.isfinite(settling_time(run, np.hypot(e.x, e.y))).all()
