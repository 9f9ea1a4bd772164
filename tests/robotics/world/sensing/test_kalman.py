"""The extended Kalman filter: closed forms, the matrix form of textbooks, consistency, and what it is good for."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.stats import chi2

import robotics
from fuzzy.compiled.jit import kernel
from robotics.laws.law import ControllerError
from robotics.simulation.loop import Simulation
from robotics.world.sensing.kalman import EstimateColumns, begin, joined
from robotics.world.sensing.posture import Sensing, SensingError
from robotics.world.vehicle.plant import ParameterColumns, TruthColumns

HALF_AXLE = 0.2  # m


@kernel
def filtered(estimate, pose, ways, slip, measured, variances, wheel, axle):
    """Filter all lanes: ``pose`` (3, lanes) is what the filter believes, and is brought up to date at each time."""
    for k in range(len(measured)):
        for i in range(pose.shape[1]):
            lane, m = EstimateColumns(estimate, i), measured[k]
            three = variances[0], variances[1], variances[2]
            if k == 0:
                begin(lane, three, wheel, axle)
                pose[0, i], pose[1, i], pose[2, i] = m[0, i], m[1, i], m[2, i]
            else:
                way = ways[k, 0, i], ways[k, 1, i]
                before, now = (pose[0, i], pose[1, i], pose[2, i]), (m[0, i], m[1, i], m[2, i])
                pose[0, i], pose[1, i], pose[2, i] = joined(lane, before, way, HALF_AXLE, slip, now, three)


def run(ways, measured, variances, slip=0.0, wheel=0.0, axle=0.0):
    """The pose (3, lanes), the scales (3, lanes) and the covariance (lanes, 6, 6) after all measurements."""
    lanes = measured.shape[2]
    estimate, pose = np.zeros((EstimateColumns.size, lanes)), np.zeros((3, lanes))
    filtered(estimate, pose, ways, slip, measured, np.array(variances, dtype=float), wheel, axle)
    end = EstimateColumns(estimate)
    scales = np.array([end.right, end.left, end.axle])
    return pose, scales, np.moveaxis(end.covariance.reshape(6, 6, lanes), 2, 0)


def driven(pose, scales, ways):
    """Poses (..., 3) after the wheels' ways (..., 2), by scales (..., 3) of wheels and axle."""
    right, left = scales[..., 0] * ways[..., 0], scales[..., 1] * ways[..., 1]
    forward, turn = (right + left) / 2, (right - left) / (2 * HALF_AXLE * scales[..., 2])
    middle = pose[..., 2] + turn / 2
    return pose + np.stack([forward * np.cos(middle), forward * np.sin(middle), turn], axis=-1)


def test_at_rest_it_is_the_mean():
    measured = np.random.default_rng(1).normal([[1.0], [2.0], [0.3]], 0.01, (20, 3, 5))
    pose, _, p = run(np.zeros((20, 2, 5)), measured, (1e-4, 1e-4, 1e-4))
    np.testing.assert_allclose(pose, measured.mean(axis=0), rtol=1e-12)
    np.testing.assert_allclose(p[:, :3, :3], np.tile(np.eye(3) * 1e-4 / 20, (5, 1, 1)), atol=1e-16)


def test_along_a_line_the_variance_settles_where_riccati_says():
    """Straight on with slip alone, x is a random walk: P = (√(q² + 4 q r) − q)/2 after a measurement."""
    way, slip, r = 0.05, 0.01, 9e-6
    ways, measured = np.full((4000, 2, 1), way), np.zeros((4000, 3, 1))
    measured[:, 0, 0] = way * np.arange(4000)
    _, _, p = run(ways, measured, (r, r, 1e-12), slip)  # the heading is known, so y and x are apart
    q = slip**2 * way / 2  # the mean of two wheels
    assert p[0, 0, 0] == pytest.approx((np.sqrt(q * q + 4 * q * r) - q) / 2, rel=1e-6)


def test_matrices_of_the_textbook_give_the_same():
    """F by differences, P and the gain by matrices, all three measurements at once."""
    random = np.random.default_rng(2)
    ways = random.normal(0.03, 0.02, (60, 2, 1))
    measured = np.cumsum(random.normal(0, 0.02, (60, 3, 1)), axis=0)
    variances, slip = np.array([4e-6, 9e-6, 1e-5]), 0.002
    z = np.array([*measured[0, :, 0], 1, 1, 1])
    p = np.diag([*variances, 4e-4, 4e-4, 1e-4])

    def moved(state, way):
        return np.array([*driven(state[:3], state[3:], way), *state[3:]])

    for k in range(1, 60):
        way, h = ways[k, :, 0], 1e-6
        f = np.stack([(moved(z + e, way) - moved(z - e, way)) / (2 * h) for e in np.eye(6) * h], axis=1)
        g = np.stack([(driven(z[:3], z[3:], way + e) - driven(z[:3], z[3:], way - e)) / (2 * h) for e in np.eye(2) * h])
        g /= z[3:5, None]  # of the true way
        q = np.zeros((6, 6))
        q[:3, :3] = g.T @ np.diag(slip**2 * np.abs(z[3:5] * way)) @ g
        z, p = moved(z, way), f @ p @ f.T + q
        gain = p[:, :3] @ np.linalg.inv(p[:3, :3] + np.diag(variances))
        z, p = z + gain @ (measured[k, :, 0] - z[:3]), p - gain @ p[:3]
    pose, scales, covariance = run(ways, measured, variances, slip, 0.02, 0.01)
    np.testing.assert_allclose([*pose[:, 0], *scales[:, 0]], z, rtol=1e-6, atol=1e-8)
    np.testing.assert_allclose(covariance[0], p, rtol=1e-5, atol=1e-12)


@settings(max_examples=40)
@given(seed=st.integers(0, 10_000), noise=st.floats(0, 0.3), way=st.floats(0, 1), wheel=st.floats(0, 0.2))
def test_the_covariance_stays_one(seed, noise, way, wheel):
    """Symmetric and positive, whatever is driven and measured, a sensor without noise too."""
    random = np.random.default_rng(seed)
    measured = random.normal(0, 1, (200, 3, 1))
    _, scales, p = run(random.normal(0, way, (200, 2, 1)), measured, (noise**2, 0, noise**2), 0.001, wheel, wheel)
    assert np.isfinite(scales).all()
    np.testing.assert_array_equal(p, p.transpose(0, 2, 1))
    assert np.linalg.eigvalsh(p).min() >= -1e-15 * (1 + np.abs(p).max())


def test_it_is_consistent():
    """NEES [Bar-Shalom 2001, 5.4.2]: errors over their own covariance, of 400 robots that slip and are 1 % wrong."""
    random, robots, times, slip, spread = np.random.default_rng(3), 400, 300, 0.002, 0.01
    true_scales = 1 + spread * random.standard_normal((robots, 3))
    noise = np.array([0.003, 0.003, 0.003])
    time = np.arange(times)[:, None]
    ways = np.stack([0.03 + 0.01 * np.sin(time / 9), 0.03 - 0.01 * np.cos(time / 13)], axis=1).repeat(robots, axis=2)
    pose, poses = np.zeros((robots, 3)), []
    for k in range(times):
        if k:
            true = ways[k].T * true_scales[:, :2]
            slipped = true + slip * np.sqrt(np.abs(true)) * random.standard_normal(true.shape)
            pose = driven(pose, np.c_[np.ones((robots, 2)), true_scales[:, 2]], slipped)
        poses.append(pose.T)
    measured = np.array(poses) + noise[:, None] * random.standard_normal((times, 3, robots))
    low, high = chi2.ppf([0.025, 0.975], 6 * robots) / robots
    inside = []
    for k in range(10, times, 10):
        found, scales, p = run(ways[: k + 1], measured[: k + 1], noise**2, slip, spread, spread)
        error = np.concatenate([found - poses[k], scales - true_scales.T]).T
        inside.append(low < np.einsum("ni,nij,nj->n", error, np.linalg.inv(p), error).mean() < high)
    assert np.mean(inside) >= 0.9
    wrong = run(ways, measured, noise**2, slip / 10, spread / 10, spread / 10)  # one that trusts its wheels too much
    error = np.concatenate([wrong[0] - poses[-1], wrong[1] - true_scales.T]).T
    assert np.einsum("ni,nij,nj->n", error, np.linalg.inv(wrong[2]), error).mean() > 2 * high


NOISY = Sensing(posture="pose", position_noise=0.003, heading_noise=0.003, wheel_error=0.01, axle_error=0.01)


def driving(sensing: Sensing, law: str = "lyapunov", runs: int = 20) -> Simulation:
    scenario = replace(robotics.load_scenario("lyapunov-sine"), sensing=sensing)
    return Simulation(scenario.setting, robotics.make_controller(law), tuple(range(runs)))


def test_in_the_simulator_it_finds_the_pose_and_what_the_wheels_have_wrong():
    rms = {}
    for law in ("lyapunov", "lyapunov:estimator=0.2", "lyapunov:estimator=kalman"):
        simulation, errors = driving(NOISY, law), []
        for k, _ in simulation.periods():
            seen, truth = simulation.lanes.known.seen, TruthColumns(simulation.lanes.body.truth)
            errors.append((k > 100) * (seen[:3] - np.array([truth.x, truth.y, truth.heading])))
        rms[law] = np.sqrt(np.mean(np.square(errors), axis=(0, 2)))
    raw, complementary, kalman = rms.values()
    assert (kalman < 0.5 * complementary).all()
    assert (kalman < 0.35 * raw).all()
    assert (complementary < raw)[:2].all()
    assert complementary[2] > raw[2]  # wheels that are wrong turn it aside for good
    lanes = simulation.lanes
    estimate, assumed = EstimateColumns(lanes.senses.estimate), ParameterColumns(lanes.body.parameters)
    true = assumed.radius / np.array([assumed.odometry.right, assumed.odometry.left])
    left = np.array([estimate.right, estimate.left]) - true
    assert np.std(left) < 0.2 * np.std(1 - true)


def test_a_law_takes_another_estimator_than_the_scenario_and_all_ways_to_run_agree():
    scenario = replace(robotics.load_scenario("lyapunov-sine"), sensing=replace(NOISY, estimator="kalman"))
    told = robotics.simulate(replace(scenario, sensing=NOISY), "lyapunov:estimator=kalman", range(3))
    np.testing.assert_array_equal(told.samples, robotics.simulate(scenario, "lyapunov", range(3)).samples)
    raw = robotics.simulate(scenario, "lyapunov:estimator=1", range(3))
    np.testing.assert_array_equal(
        raw.samples, robotics.simulate(replace(scenario, sensing=NOISY), "lyapunov", range(3)).samples
    )
    assert not np.array_equal(raw.samples, told.samples)
    simulation = driving(scenario.sensing, runs=3)
    for _ in simulation.periods():
        pass
    np.testing.assert_array_equal(TruthColumns(simulation.lanes.body.truth).x, told["x"][..., -1].ravel())


def test_laws_with_different_estimators_in_one_comparison():
    scenario = replace(robotics.load_scenario("lyapunov-sine"), sensing=NOISY)
    laws = ["lyapunov", "lyapunov:estimator=kalman", "lyapunov:estimator=0.2", "lyapunov"]
    found = robotics.compare([scenario], laws[:3], seeds=range(2))
    alone = robotics.compare([scenario], [laws[1]], seeds=range(2))
    both, one = (table[table["controller"] == laws[1]].reset_index(drop=True) for table in (found.table, alone.table))
    assert both.equals(one)
    assert found.table.groupby("controller")["rms_cross_track_m"].mean().nunique() == 3


def test_what_it_cannot_be():
    with pytest.raises(SensingError, match="filter_gain belongs to estimator"):
        Sensing(posture="pose", estimator="kalman", filter_gain=0.2)
    with pytest.raises(SensingError, match='estimator belongs to posture = "pose"'):
        Sensing(estimator="kalman")
    with pytest.raises(ControllerError, match="estimator of Lyapunov joins a pose sensor with odometry"):
        driving(Sensing(), "lyapunov:estimator=kalman")
    with pytest.raises(ControllerError, match=r'estimator must be .* or "kalman"'):
        robotics.make_controller("lyapunov:estimator=median")
