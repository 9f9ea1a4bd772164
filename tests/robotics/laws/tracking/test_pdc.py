"""Parallel distributed compensation: its models against the kinematics, its certificate against numpy, its runs."""

import json

import numpy as np
import pytest

from robotics.commands.application import main
from robotics.laws.catalogue import make_controller
from robotics.laws.law import ControllerError
from robotics.laws.tracking.pdc import ParallelCompensation
from robotics.measures.tracking import cross_track_error, settling_time, tracking_error
from robotics.plugins.certificates.certificate import CertificateError
from robotics.plugins.certificates.compensation import certify_compensation
from robotics.simulation.loop import simulate
from robotics.simulation.scenario.reading import load_scenario, parse_scenario

LAW = ParallelCompensation()


def rates(state, command, v_r, w_r):
    """d', α', ψ' from the motion of two unicycles in the plane, by a step of time: no formula of (2.37) in it."""
    d, alpha, psi = state

    def seen(robot, target):
        dx, dy = target[0] - robot[0], target[1] - robot[1]
        return np.array([np.hypot(dx, dy), np.arctan2(dy, dx) - robot[2], target[2] - robot[2]])

    robot, target = np.zeros(3), np.array([d * np.cos(alpha), d * np.sin(alpha), psi])
    h = 1e-6

    def moved(pose, v, w, t):
        return pose + t * np.array([v * np.cos(pose[2]), v * np.sin(pose[2]), w])

    v, w = command
    ends = [seen(moved(robot, v, w, t), moved(target, v_r, w_r, t)) for t in (-h, h)]
    return (ends[1] - ends[0]) / (2 * h)


def test_the_operating_points_are_equilibria_and_a_b_their_derivatives():
    """Erratum A25's signs of B, and A by central differences of the motion itself."""
    np.testing.assert_allclose(LAW.distances, [0.05, 0.15, 0.4, 1.0])  # the peaks of Table 5.6's sets, but for d = 0
    np.testing.assert_allclose(LAW.alphas, [-1.2, -0.3, 0.0, 0.3, 1.2])
    a, b = LAW.model()
    for i, d in enumerate(LAW.distances):
        for j, alpha in enumerate(LAW.alphas):
            v = d / (0.4 * np.sinc(alpha / np.pi))
            at, command = np.array([d, alpha, 2 * alpha]), np.array([v, 2 * alpha / 0.4])
            np.testing.assert_allclose(rates(at, command, *command), 0.0, atol=1e-6)
            for k in range(3):
                step = np.zeros(3)
                step[k] = 1e-4
                slope = (rates(at + step, command, *command) - rates(at - step, command, *command)) / 2e-4
                np.testing.assert_allclose(a[i, j, :, k], slope, rtol=2e-4, atol=2e-4)
            for k in range(2):
                step = np.zeros(2)
                step[k] = 1e-4
                slope = (rates(at, command + step, *command) - rates(at, command - step, *command)) / 2e-4
                np.testing.assert_allclose(b[i, j, :, k], slope, rtol=2e-4, atol=2e-4)
            assert np.linalg.eigvals(a[i, j] - b[i, j] @ LAW.gains[i, j]).real.max() < -1


def test_the_gain_is_that_of_the_regulator():
    """Straight ahead the distance alone gives v; its gain is the ratio of the scales."""
    gain = LAW.gains[1, 2]
    np.testing.assert_allclose(gain[0], [-0.2 / 0.1, 0.0, 0.0], atol=1e-9)
    a, b = (part[1, 3] for part in LAW.model())
    k = LAW.gains[1, 3]
    weight, cost = np.diag(np.array([0.1, 0.3, 0.5]) ** -2), np.diag([0.2**-2, 1.0])
    # Kleinman: the cost of this gain, by its Lyapunov equation, gives the same gain back.
    closed = a - b @ k
    lyapunov = np.kron(np.eye(3), closed.T) + np.kron(closed.T, np.eye(3))
    p = np.linalg.solve(lyapunov, -(weight + k.T @ cost @ k).ravel()).reshape(3, 3)
    np.testing.assert_allclose(np.linalg.solve(cost, b.T @ p), k, atol=1e-8)


def test_firing_strengths_are_products_of_degrees_and_blend_the_gains():
    h = LAW.strengths(np.array(0.1), np.array(0.15))
    expected = np.zeros((4, 5))
    expected[np.ix_([0, 1], [2, 3])] = np.outer([0.5, 0.5], [0.5, 0.5])
    np.testing.assert_allclose(h, expected, atol=1e-12)
    far = LAW.strengths(np.array([0.0, 9.0]), np.array([-3.0, 3.0]))
    assert far[0, 0, 0] == far[1, -1, -1] == 1.0


@pytest.fixture(scope="module")
def found():
    return certify_compensation(LAW, turn=0.5)


def test_the_common_p_is_one_for_every_mixture_of_the_rules(found):
    """(2.42) by numpy alone: Σ h_j h_k (A^j − B^j K^k), the strengths being those of 2000 random states."""
    assert len(found.points) == 12
    assert found.decay > 0.5
    assert np.linalg.eigvalsh(found.P)[0] > 0
    assert found.worst_eigenvalue < 0
    rng = np.random.default_rng(3)
    h = LAW.strengths(rng.uniform(0.05, 1.0, 2000), rng.uniform(-0.3, 0.3, 2000))[:, :, 1:4].reshape(-1, 12)
    np.testing.assert_allclose(h.sum(axis=1), 1.0)
    loop = np.einsum("nj,jab->nab", h, found.A) - np.einsum("nj,jab,nk,kbc->nac", h, found.B, h, found.K)
    falls = np.linalg.eigvalsh(np.swapaxes(loop, 1, 2) @ found.P + found.P @ loop + 2 * 0.999 * found.decay * found.P)
    assert falls.max() < 0
    again = np.einsum("nj,jab,nj,jbc->nac", h, found.B, h, found.K)  # B^j K^j, as printed, is another loop
    assert np.abs(loop - (np.einsum("nj,jab->nab", h, found.A) - again)).max() > 0.1


def test_for_all_rules_there_is_none():
    """With the sets that peak at ±1.2 rad: each pair of rules is stable, no common P exists."""
    every = certify_compensation(LAW)
    assert len(every.points) == 20
    assert every.P is None
    assert every.decay == 0.0
    assert every.slowest_pole < -1
    with pytest.raises(CertificateError, match=r"the distances are 0.05, 0.15, 0.4, 1 m"):
        certify_compensation(LAW, least=2.0)


@pytest.mark.parametrize(("scenario", "within"), [("lyapunov-sine", 3.5), ("lyapunov-circle", 2.5)])
def test_it_tracks_with_noise(scenario, within):
    """Row D's bounds for the Lyapunov law, 5 s and 3 mm, for five seeds with 3 mm of posture noise."""
    run = simulate(load_scenario(scenario), make_controller("pdc"), range(5))
    error = tracking_error(run)
    distance = np.hypot(error.x, error.y)
    assert settling_time(run, distance).max() < within
    tail = run.time > 8
    assert np.sqrt((distance[..., tail] ** 2).mean(axis=-1)).max() < 0.003
    assert np.sqrt((cross_track_error(run)[..., tail] ** 2).mean(axis=-1)).max() < 0.0015
    assert distance[..., -1].max() < 0.005


LINE = """
duration = 12.0
[[robots]]
start = [0.0, 0.0, 0.0]
path = { shape = "line", start = [0.0, 0.0], end = [2.0, 0.0] }
timing = { speed = 0.25 }
"""


def test_on_the_path_it_commands_the_reference_and_at_the_end_it_rests():
    run = simulate(parse_scenario(LINE.replace("duration", 'plant = "kinematic"\nduration', 1), "line"), LAW)
    assert np.abs(run["y"]).max() < 1e-9
    assert np.abs(run["v"][0, 0, 20:150] - 0.25).max() < 1e-3
    assert abs(run["x"][0, 0, -1] - 2.0) < 2e-3
    assert abs(run["v"][0, 0, -1]) < 1e-4


def test_a_rule_base_without_its_inputs_is_refused():
    with pytest.raises(ControllerError, match="eta: parallel compensation needs the inputs distance and alpha"):
        ParallelCompensation(rule_base="eta")


def test_the_command_certifies_it(capsys):
    assert main(["certify", "--law", "pdc", "--alpha", "0", "--json"]) == 0
    printed = json.loads(capsys.readouterr().out)
    assert [rule["distance"] for rule in printed["rules"]] == [0.05, 0.15, 0.4, 1.0]
    assert printed["decay"] == pytest.approx(2.0, rel=1e-3)  # that of d: 0.2 / 0.1 1/s
    assert main(["certify", "--law", "pdc", "--distance", "0.1", "0.5"]) == 0
    text = capsys.readouterr().out
    assert "6 of 20 rules, those with |alpha| <= 0.5 rad and 0.1 <= d <= 0.5 m" in text
    assert main(["certify", "--law", "pdc", "--alpha", "2"]) == 2
    assert "no common P was found for these 20 rules and the 75 pairs" in capsys.readouterr().err
    assert main(["certify", "--law", "csm"]) == 2
    assert "--law must be lyapunov or pdc" in capsys.readouterr().err
