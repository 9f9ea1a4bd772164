"""Row E's certificate: a common P, checked by numpy alone, by the law itself, and by the nonlinear error dynamics."""

import builtins
import json
from dataclasses import replace

import numpy as np
import pytest

from robotics.commands.application import main
from robotics.laws.tracking.lyapunov import Lyapunov
from robotics.plugins.certificates.certificate import (
    CertificateError,
    SectorModel,
    certify,
    decay_rate,
    error_rates,
    try_out,
)
from robotics.plugins.certificates.commands import broken
from robotics.plugins.certificates.figures import plot_certificate
from robotics.simulation.scenario.robots import load_robot
from tests.drawn import x_of, y_of
from tests.robotics.world.vehicle.etsro import ETSRO

AS_RUN = SectorModel()  # gains 1, 10, 5, catch_up 0.3 m/s
PRINTED = SectorModel(law=Lyapunov(catch_up=0.0))  # (2.32) as printed: the model of row E
THESIS = SectorModel(law=Lyapunov(ky=1.0, kpsi=1.0, form="2.31", catch_up=0.0))
MODELS = {"as run": AS_RUN, "printed": PRINTED, "thesis": THESIS}


@pytest.fixture(scope="module")
def certificates():
    return {name: certify(model) for name, model in MODELS.items()}


@pytest.fixture(params=MODELS)
def certificate(certificates, request):
    return certificates[request.param]


def test_row_e_decay_is_at_least_a_tenth(certificates):
    for name in ("as run", "printed"):
        model = certificates[name].model
        assert (model.law.kx, model.law.ky, model.law.kpsi) == (1, 10, 5)
        assert (model.speed_low, model.speed_high, model.turn, model.heading) == (0.2, 0.4, 5.74, 1.2)
        assert certificates[name].decay >= 0.1
    # Another solver's path to the greatest rate of this model
    assert certificates["printed"].fastest == pytest.approx(0.117, abs=5e-4)


def sampled_premises(model, n, rng):
    """(v_r, a_y, a_ψ, s, ω) anywhere in their ranges, a third of them at an end of each."""
    v, more, psi, w = np.clip(rng.uniform(-0.25, 1.25, (4, n)), 0, 1)
    v = model.speed_low + (model.speed_high - model.speed_low) * v
    psi = np.maximum(model.heading * psi, 1e-9)
    a = v + more * (np.maximum(v, model.law.catch_up) - v)
    w = model.turn * (2 * w - 1)
    return (v, v, 1.0 + 0 * v, np.sin(psi) / psi, w) if model.law.form == "2.31" else (v, a, a, np.sin(psi) / psi, w)


def test_lyapunov_inequality_holds_between_the_corners(certificate):
    """A'P + PA + 2 decay P <= 0 for A written out here, on 200,000 premises; the corners are the worst."""
    model, p = certificate.model, certificate.P
    law = model.law
    v, ay, apsi, s, w = sampled_premises(model, 200_000, np.random.default_rng(1))
    zero = np.zeros_like(v)
    a = np.moveaxis(
        np.array(
            [
                [zero - law.kx, w, zero],
                [-w, zero, v * s],
                [zero, -ay * law.ky, -apsi * law.kpsi * s],
            ]
        ),
        -1,
        0,
    )
    assert np.linalg.eigvalsh(p)[0] > 0
    np.testing.assert_array_equal(p, p.T)
    falls = np.swapaxes(a, 1, 2) @ p + p @ a
    assert np.linalg.eigvalsh(falls).max() <= certificate.worst_eigenvalue * (1 - 1e-9) < 0
    assert np.linalg.eigvalsh(falls + 2 * certificate.decay * p).max() <= 1e-9
    # and no greater rate would do: the certified one is met at a corner
    assert np.linalg.eigvalsh(falls + 2 * 1.01 * certificate.decay * p).max() > 0


def test_the_grid_is_the_premises(certificate):
    model = certificate.model
    grid = model.grid(7)
    assert len(grid) == (7**4 if model is AS_RUN else 7**3)
    law = model.law
    a_y, v_s = -grid[:, 2, 1] / law.ky, grid[:, 1, 2]
    assert (a_y.min(), a_y.max()) == pytest.approx((model.speed_low, model.speed_high))
    assert (v_s.min(), v_s.max()) == pytest.approx((0.2 * np.sin(1.2) / 1.2, 0.4))
    assert (grid[:, 0, 1].min(), grid[:, 0, 1].max()) == (-model.turn, model.turn)
    assert decay_rate(grid, certificate.P) == pytest.approx(certificate.decay, rel=1e-9)


@pytest.mark.parametrize("model", MODELS.values(), ids=list(MODELS))
def test_the_model_is_the_law_exactly(model):
    """A e, with ω and a of the law's own command, is the kinematics of the error; the premises are in their ranges."""
    law, rng, n = model.law, np.random.default_rng(2), 5000
    e = rng.uniform(-1, 1, (n, 3)) * [0.8, 0.8, model.heading]
    x, y, psi = e.T
    v_r, w_r = rng.uniform(model.speed_low, model.speed_high, n), rng.uniform(-1, 1, n)
    v = v_r * np.cos(psi) + law.kx * x  # (2.30)
    if law.form == "2.31":
        ay, apsi = v_r, np.ones(n)
    else:
        ay = apsi = np.maximum(v_r, np.minimum(np.abs(v), law.catch_up))
        assert np.all(ay <= np.maximum(v_r, law.catch_up))
        assert np.any(ay > v_r) == (model is AS_RUN)
    w = w_r + ay * law.ky * y + apsi * law.kpsi * np.sin(psi)
    rates = np.stack([v_r * np.cos(psi) - v + y * w, v_r * np.sin(psi) - x * w, w_r - w], axis=-1)
    np.testing.assert_allclose(error_rates(law, e, v_r, w_r), rates, atol=1e-12)
    a = model.matrix(v_r, ay, apsi, np.sin(psi) / psi, w)
    np.testing.assert_allclose(np.einsum("nij,nj->ni", a, e), rates, atol=1e-12)


def test_premises_hold_in_the_region_and_not_in_a_larger_one(certificate):
    """|ψ| and the law's own |ω| over the region's boundary, at every reference."""
    model = certificate.model
    rng, n = np.random.default_rng(3), 400_000
    e = certificate.boundary(rng.standard_normal((n, 3)))
    np.testing.assert_allclose(certificate.level(e), 1, atol=1e-12)
    v_r = rng.choice([model.speed_low, model.speed_high], n)
    w_r = rng.choice([-1.0, 1.0], n) * model.reference_turn
    w = w_r - error_rates(model.law, e, v_r, w_r)[:, 2]
    assert np.abs(e[:, 2]).max() <= model.heading * (1 + 1e-9)
    assert np.abs(w).max() <= certificate.largest_turn <= model.turn
    np.testing.assert_allclose(np.abs(e).max(axis=0), certificate.half_widths, rtol=1e-3)
    assert np.abs(e[:, 2]).max() == pytest.approx(model.heading, rel=1e-3)  # this premise is what bounds the region


def test_a_low_bound_of_turn_bounds_the_region():
    found = certify(replace(PRINTED, turn=2.0))
    assert found.decay > 0.2
    assert found.largest_turn == pytest.approx(2.0, rel=1e-9)
    assert found.half_widths[2] < 0.6


def test_v_never_rises_in_100_000_nonlinear_steps(certificate):
    """The law's own dynamics, integrated here: V falls as fast as is certified."""
    model, p = certificate.model, certificate.P
    rng, n, h = np.random.default_rng(4), 1000, 0.005
    # On the boundary: e = L u with L L' = P⁻¹, |u| = 1
    u = rng.standard_normal((n, 3))
    e = np.linalg.solve(np.linalg.cholesky(p).T, (u / np.linalg.norm(u, axis=1, keepdims=True)).T).T
    level = np.einsum("ni,ij,nj->n", e, p, e)
    for _ in range(100):
        v_r = np.clip(rng.uniform(0.15, 0.45, n), model.speed_low, model.speed_high)
        w_r = np.clip(rng.uniform(-1.5, 1.5, n), -model.reference_turn, model.reference_turn)
        k1 = error_rates(model.law, e, v_r, w_r)
        k2 = error_rates(model.law, e + h / 2 * k1, v_r, w_r)
        k3 = error_rates(model.law, e + h / 2 * k2, v_r, w_r)
        k4 = error_rates(model.law, e + h * k3, v_r, w_r)
        e = e + h / 6 * (k1 + 2 * k2 + 2 * k3 + k4)
        after = np.einsum("ni,ij,nj->n", e, p, e)
        assert np.all(after <= level * np.exp(-2 * certificate.decay * h) + 1e-12)
        level = after


def test_trial_counts_and_repeats(certificates):
    found = certificates["as run"]
    trial = try_out(found, seed=5)
    assert (trial.steps, trial.increases) == (100_000, 0)
    assert trial.slowest >= found.decay
    np.testing.assert_array_equal(trial.levels, try_out(found, seed=5).levels)
    assert not np.array_equal(trial.levels, try_out(found, seed=6).levels)
    # A P that certifies nothing is found out: y weighed 100 times too much
    wrong = replace(found, P=found.P * np.array([[1, 1, 1], [1, 100, 1], [1, 1, 1.0]]))
    assert try_out(wrong, seed=5).increases > 1000


def test_no_command_saturates_in_the_share_of_the_region(certificates):
    found, robot = certificates["as run"], ETSRO
    share = found.unsaturated(robot)
    assert 0.5 < share < 1
    rng, n = np.random.default_rng(6), 400_000
    e = found.boundary(rng.standard_normal((n, 3)))
    v_r, w_r = np.full(n, 0.4), rng.choice([-1.0, 1.0], n)

    def most(e):
        rates = error_rates(found.model.law, e, v_r, w_r)
        w = w_r - rates[:, 2]
        v = v_r * np.cos(e[:, 2]) + e[:, 1] * w - rates[:, 0]
        return (np.abs(v) + robot.half_axle * np.abs(w)).max()

    assert most(share * e) <= robot.wheel_speed_limit < most(e)


def test_a_lower_rate_gives_a_larger_region(certificates):
    wide = certify(AS_RUN, decay=0.05)
    assert 0.05 <= wide.decay < 0.0501
    assert np.linalg.det(wide.P) < 0.5 * np.linalg.det(certificates["as run"].P)


@pytest.mark.parametrize(
    ("change", "fragments"),
    [
        ({"speed_low": 0.0}, ["speed_low must be", "> 0", "got 0.0"]),
        ({"speed_low": 0.5}, ["speed_low must be at most speed_high, 0.4"]),
        ({"reference_turn": 6.0}, ["reference_turn must be below turn, 5.74"]),
        ({"heading": 3.2}, ["heading must be", "<= 3.1"]),
        ({"turn": float("nan")}, ["turn must be a finite number in rad/s"]),
        ({"law": Lyapunov(signs="literal")}, ["signs must be 'corrected'"]),
    ],
)
def test_models_that_make_no_sense(change, fragments):
    with pytest.raises(CertificateError) as error:
        replace(AS_RUN, **change)
    for fragment in fragments:
        assert fragment in str(error.value)


def test_rates_that_cannot_be_had():
    for decay in (0.2, 0.0, -1.0, float("nan")):
        with pytest.raises(CertificateError, match=r"accepted are rates > 0 and <= 0\.106 1/s"):
            certify(AS_RUN, decay=decay)


# The command line -------------------------------------------------------------------------------------------------


@pytest.mark.long
def test_command_prints_what_it_certifies(tmp_path, capsys):
    picture = tmp_path / "region.png"
    assert main(["certify", "--catch-up", "0", "--plot", str(picture), "--json"]) == 0
    printed = json.loads(capsys.readouterr().out)
    assert printed["decay"] >= 0.1
    assert printed["fastest"] == pytest.approx(0.117, abs=5e-4)
    assert printed["worst_eigenvalue_on_grid"] <= printed["worst_eigenvalue"] * (1 - 1e-9) < 0
    assert (printed["steps"], printed["increases"]) == (100_000, 0)
    assert np.linalg.eigvalsh(np.array(printed["P"]))[0] > 0
    assert printed["region"]["heading"] == pytest.approx(1.2)
    assert picture.read_bytes().startswith(b"\x89PNG")

    assert main(["certify", "--speed", "0.3", "0.5", "--turn", "3.5", "--decay", "0.1"]) == 0
    text = capsys.readouterr().out
    for fragment in (
        "decay:  0.1 1/s",
        "0.3 <= v_r <= 0.5 m/s",
        "V = e'Pe rose in 0 of 100,000",
        "In continuous time",
        "motors and wheel loops that lag",
        "noisy measurements",
        "References slower than 0.3 m/s, at rest",
        "singleton fuzzy rule base",
    ):
        assert fragment in text


@pytest.mark.parametrize(
    ("arguments", "fragments"),
    [
        (["--speed", "0.01", "0.4"], ["no common quadratic Lyapunov function", "v_r in [0.01, 0.4] m/s", "narrow"]),
        (["--decay", "0.5"], ["decay rate 0.5 1/s", "<= 0.106 1/s"]),
        (["--speed", "0", "0.4"], ["speed_low", "> 0"]),
        (["--ky", "-1"], ["ky must be a finite number in 1/m²", "got -1"]),
        (["--plot", "region.bmp"], ["region.bmp", ".png, .pdf or .svg"]),
    ],
)
def test_bad_requests_are_one_message(arguments, fragments, capsys):
    assert main(["certify", *arguments]) == 2
    printed = capsys.readouterr()
    assert printed.out == ""
    assert len(printed.err.strip().splitlines()) == 1
    for fragment in fragments:
        assert fragment in printed.err


def test_without_the_extra_one_sentence_says_what_to_install(monkeypatch, capsys):
    real = builtins.__import__

    def without(name, *rest, **named):
        if name.partition(".")[0] == "cvxpy":
            raise ImportError(name)
        return real(name, *rest, **named)

    monkeypatch.setattr(builtins, "__import__", without)
    assert main(["certify"]) == 2
    message = capsys.readouterr().err
    assert "pip install 'cvxpy>=" in message
    assert len(message.strip().splitlines()) == 1


def test_figure_shows_region_bounds_and_trajectories(certificates):
    found = certificates["as run"]
    figure = plot_certificate(found, ETSRO, starts=6, duration=3.0)
    plane, heading, decay = figure.axes
    assert (plane.get_xlabel(), plane.get_ylabel()) == ("x_err [m]", "y_err [m]")
    assert (heading.get_xlabel(), heading.get_ylabel()) == ("y_err [m]", "ψ_err [rad]")
    for ax, pair in ((plane, [0, 1]), (heading, [1, 2])):
        outline = next(line for line in ax.lines if line.get_color() == "black")
        reached = [np.abs(values).max() for values in outline.get_data()]
        np.testing.assert_allclose(reached, found.half_widths[pair], rtol=1e-3)
        assert len([line for line in ax.lines if len(x_of(line)) == 301]) == 6
    (bound,) = [line for line in decay.lines if line.get_color() == "black"]
    for line in decay.lines:
        assert np.all(y_of(line) <= y_of(bound) * (1 + 1e-9))


def test_what_a_robot_has_that_no_proof_assumes_is_said():
    assert broken(load_robot("etsro").robot) == ()
    (said,) = broken(load_robot("etsro").robot.changed(lateral_slip=0.02, dead_band=0.01))
    assert "it has dead_band 0.01 and lateral_slip 0.02" in said
    assert "Its assumptions are broken." in said
