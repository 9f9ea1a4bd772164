"""The closed loop against closed forms and scipy, and what it refuses."""

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from scipy.signal import cont2discrete, dlsim, lsim

from fuzzy import (
    PID,
    FunctionPlant,
    Linear,
    LoopError,
    PlantError,
    Scale,
    Sugeno,
    TransferFunction,
    Variable,
    step_response,
)
from fuzzy.membership import Gaussian, Triangle
from fuzzy.plugins.designer.starts.control import rule_table
from fuzzy.plugins.loop.controller import role_of, roles_of
from fuzzy.plugins.loop.rival import tuned_pid


def linear(slopes, inputs=("error", "error_rate"), outputs=("u",)):
    """A system of one rule whose outputs are linear: exactly a PD law."""
    wide = {"any": Gaussian(1e6, 0.0)}
    return Sugeno(
        [Variable(n, (-1e3, 1e3), wide) for n in inputs],
        [Variable(n, (-1e3, 1e3), {"law": Linear(slopes, 0.0)}) for n in outputs],
        [f"if {inputs[0]} is any then " + " and ".join(f"{n} is law" for n in outputs)],
        out_of_range="ignore",
    )


def test_a_linear_rule_base_is_the_pd_law():
    """y'' + (1 + Kd) y' + Kp y = Kp r: overshoot and settling of a second order in closed form."""
    plant = TransferFunction([1], [1, 1, 0])
    Kp, Kd, period = 4.0, 0.6, 1e-3
    done = step_response(linear((Kp, Kd)), plant, duration=12, sample_time=period)
    wn = math.sqrt(Kp)
    zeta = (1 + Kd) / (2 * wn)
    # The reference steps once: its derivative is left out, as is the PD law's zero
    y = 1 - np.exp(-zeta * wn * done.time) * (
        np.cos(wn * math.sqrt(1 - zeta**2) * done.time)
        + zeta / math.sqrt(1 - zeta**2) * np.sin(wn * math.sqrt(1 - zeta**2) * done.time)
    )
    np.testing.assert_allclose(done.output, y, atol=4e-3)  # of the order of the sample time
    assert done.figures.overshoot == pytest.approx(100 * math.exp(-math.pi * zeta / math.sqrt(1 - zeta**2)), abs=0.3)
    outside = np.flatnonzero(np.abs(y - 1) > 0.02)[-1]
    assert done.figures.settling_time == pytest.approx(done.time[outside], abs=0.02)
    rise = np.interp(0.9, y[:1600], done.time[:1600]) - np.interp(0.1, y[:1600], done.time[:1600])
    assert done.figures.rise_time == pytest.approx(rise, abs=0.01)
    assert done.figures.steady_state_error == pytest.approx(0, abs=1e-4)
    # The integral of e of a type-1 loop: (1 + Kd) / Kp
    assert np.trapezoid(1 - done.output, done.time) == pytest.approx((1 + Kd) / Kp, abs=5e-3)


def test_the_sampled_loop_is_that_of_another_discretisation():
    """PI by du on 2 / (10 s + 1), against a recursion of the z-domain."""
    plant, T, Kp, Ki = TransferFunction([2], [10, 1]), 0.1, 1.5, 0.4
    done = step_response(PID(Kp, Ki), plant, duration=30, sample_time=T)
    a = math.exp(-T / 10)
    y, total, expected = 0.0, 0.0, []
    for _ in done.time:
        expected.append(y)
        total += (1 - y) * T
        y = a * y + 2 * (1 - a) * (Kp * (1 - y) + Ki * total)
    np.testing.assert_allclose(done.output, expected, atol=1e-12)
    # The same as a rate: du = Kp de/dt + Ki e; at first the error is no rate, which the proportional part adds
    rate = step_response(linear((Ki, Kp), outputs=("du",)), plant, duration=60, sample_time=T)
    assert abs(rate.figures.steady_state_error) < 1e-3
    pid = step_response(linear((0.2, 0.0), outputs=("u", "du")), plant, duration=30, sample_time=T)
    same = step_response(PID(0.2, 0.2), plant, duration=30, sample_time=T)
    np.testing.assert_allclose(pid.output, same.output, atol=1e-9)
    summed = step_response(linear((0.2, 0.2), ("error", "error_sum")), plant, duration=30, sample_time=T)
    np.testing.assert_allclose(summed.output, same.output, atol=1e-9)


@pytest.mark.parametrize("dead_time", [0.0, 0.3, 0.25, 0.04])
def test_dead_time_shifts_the_response(dead_time):
    """Open loop (a controller that saturates): the response of lsim, later by the dead time, also between samples."""
    T, plant = 0.1, TransferFunction([1, 3], [1, 0.8, 2], dead_time)
    done = step_response(PID(1e6), plant, reference=100, duration=6, sample_time=T, limits=(0, 1))
    fine = np.linspace(0, 6, 6001)
    _, y, _ = lsim(((1, 3), (1, 0.8, 2)), np.ones_like(fine), fine)
    np.testing.assert_allclose(done.output, np.interp(done.time - dead_time, fine, y, left=0.0), atol=1e-5)


def test_a_transfer_function_with_a_direct_path_and_a_disturbance():
    plant = TransferFunction([0.5, 2], [1, 1])
    done = step_response(PID(0.0), plant, reference=1, duration=4, sample_time=0.01, disturbance=(1.0, 2.0))
    w = np.where(done.time >= 1.0 - 1e-9, 2.0, 0.0)
    discrete = cont2discrete(((0.5, 2), (1, 1)), 0.01)
    _, y = dlsim((*discrete[:2], 0.01), w)[:2]
    np.testing.assert_allclose(done.output[101:] - 0.5 * w[101:], (y[:, 0] - 0.5 * w)[101:], atol=1e-9)
    gain = step_response(PID(0.5), TransferFunction([3], [1]), duration=1, sample_time=0.1)
    assert gain.output[0] == 0  # measured before the actuator moves
    assert gain.output[1] == pytest.approx(1.5)


def test_a_function_is_the_same_plant():
    def motor(x, u, t):
        return [x[1], -x[1] + u]

    about: dict[str, Any] = {"scale": Scale(1, 0.7, 1, 4), "duration": 8, "disturbance": (4, 1.0), "limits": (-1, 1.5)}
    fis = rule_table("pd", 5)
    one = step_response(fis, TransferFunction([1], [1, 1, 0], 0.05), **about)
    other = step_response(fis, FunctionPlant(motor, 2, dead_time=0.05), **about)
    np.testing.assert_allclose(one.output, other.output, atol=1e-6)
    for name, value in vars(one.figures).items():
        assert getattr(other.figures, name) == pytest.approx(value, abs=1e-4)
    shown = step_response(fis, FunctionPlant(motor, 2, output=lambda x: 2 * x[0]), scale=Scale(Ku=4), duration=1)
    assert shown.output[-1] > 0
    assert (one.control.min(), one.control.max()) >= (-1, 1.5)


def test_the_sum_is_clamped_at_the_limits():
    plant = TransferFunction([1], [5, 1])
    wound = step_response(PID(2.0, 2.0), plant, duration=20)
    held = step_response(PID(2.0, 2.0), plant, duration=20, limits=(-1.2, 1.2))
    assert held.control.max() == 1.2
    assert held.error_sum[:50].max() <= 0.04 + 1e-12  # at its limit from the first sample on
    assert held.figures.overshoot < 5 < wound.figures.overshoot
    # A reversed plant with reversed rules winds up no more
    turned = step_response(PID(-2.0, -2.0), TransferFunction([-1], [5, 1]), duration=20, limits=(-1.2, 1.2))
    np.testing.assert_allclose(turned.output, held.output, atol=1e-12)
    rate = step_response(linear((2.0, 2.0), outputs=("du",)), plant, duration=20, limits=(-1.2, 1.2))
    assert rate.control.max() == 1.2
    assert rate.figures.overshoot < 20


def test_noise_comes_from_its_seed_and_a_filter_smooths_it():
    plant, fis = TransferFunction([1], [1, 1, 0]), rule_table("pd", 3)
    noisy: dict[str, Any] = {"noise": 0.01, "duration": 5, "scale": Scale(Kde=0.5, Ku=3)}
    one, same, other = (step_response(fis, plant, seed=seed, **noisy) for seed in (1, 1, 2))
    np.testing.assert_array_equal(one.control, same.control)
    assert not np.array_equal(one.control, other.control)
    smooth = step_response(fis, plant, seed=1, rate_filter=0.1, **noisy)
    assert smooth.figures.variation < one.figures.variation / 2
    np.testing.assert_allclose(one.known, np.stack([one.error, 0.5 * one.error_rate], -1))


@pytest.mark.parametrize(
    ("plant", "settles"),
    [
        (TransferFunction([1], [1, 1], 0.5), True),
        (TransferFunction([3], [20, 12, 1], 1.0), True),
        (TransferFunction([1], [1, 1, 0]), True),
        (TransferFunction([-2], [1, 0], 0.3), True),
        (TransferFunction([1], [1, 0.8, 1], 0.3), True),
        (TransferFunction([-1, 1], [1, 3, 3, 1]), True),
    ],
)
def test_the_rival_is_tuned_by_published_rules(plant, settles):
    pid = tuned_pid(plant, 0.05)
    done = step_response(pid, plant, duration=60, sample_time=0.05)
    assert not done.stopped
    assert (done.figures.settling_time is not None) == settles


def test_simc_of_the_textbook():
    """exp(-s) / (10 s + 1): Kc = 0.5 τ / θ, τI = min(τ, 8 θ), Skogestad 2003, table 1, where the hold vanishes."""
    pid = tuned_pid(TransferFunction([1], [10, 1], 1.0), 1e-9)
    assert (pid.Kp, pid.Kp / pid.Ki, pid.Kd) == pytest.approx((5.0, 8.0, 0.0), rel=1e-6)
    cubic = tuned_pid(TransferFunction([1], [1, 3, 3, 1, 0], 0.0), 1e-9)  # an integrator and three equal lags
    assert cubic.rule.startswith("SIMC")


def test_the_ultimate_gain_of_three_equal_lags():
    """1 / (s + 1)³ with a zero far left: Ku = 8, Tu = 2π / √3."""
    pid = tuned_pid(TransferFunction([1e-6, 1], [1, 3, 3, 1]), 1e-6)
    assert pid.rule.startswith("ultimate")
    assert (pid.Kp, pid.Kp / pid.Ki) == pytest.approx((4.8, math.pi / math.sqrt(3)), rel=1e-2)


def test_roles_are_read_from_names_or_given():
    assert [role_of(n) for n in ("E", "Change of Error", "int_e", "dE/dt")] == [
        "error",
        "error_rate",
        None,
        "error_rate",
    ]
    fis = linear((1.0, 0.0), ("level", "error_rate"))
    with pytest.raises(LoopError, match=r"error \(e\), error_rate .*'level' is none of them"):
        step_response(fis, TransferFunction([1], [1, 1]))
    assert roles_of(fis, {"level": "error"}).inputs == ("error", "error_rate")
    with pytest.raises(LoopError, match="two variables are error_rate"):
        roles_of(fis, {"level": "error_rate"})
    step_response(fis, TransferFunction([1], [1, 1]), roles={"level": "error"}, duration=1)


def test_a_loop_that_runs_away_is_stopped_with_a_sentence():
    done = step_response(rule_table("pd", 3), TransferFunction([1], [1, -3]), duration=20)
    assert "runs away" in done.stopped
    assert done.figures.iae is None
    assert np.isnan(done.output[-1])


def test_other_functions_of_membership_are_evaluated_too():
    fis = rule_table("pd", 3)
    names = iter(fis.inputs[0].terms)

    class Own(Triangle):
        """A function without a compiled branch."""

    terms = {n: Own(*fis.inputs[0].terms[n].parameters) for n in names}
    own = replace(fis, inputs=[replace(fis.inputs[0], terms=terms), fis.inputs[1]])
    about: dict[str, Any] = {"duration": 1, "sample_time": 0.05}
    a, b = (step_response(f, TransferFunction([1], [1, 1]), **about) for f in (own, fis))
    np.testing.assert_allclose(a.output, b.output, atol=1e-12)


@pytest.mark.parametrize(
    ("make", "sentence"),
    [
        (lambda: TransferFunction([1, 0, 0], [1, 1]), "must be proper"),
        (lambda: TransferFunction([1], [0, 0]), "other than 0"),
        (lambda: TransferFunction([1], [math.nan]), "denominator must be finite numbers"),
        (lambda: TransferFunction([1], [1, 1], -1), "dead time must be"),
        (lambda: FunctionPlant(lambda x, u, t: x, 0), "states must be a whole number"),
        (lambda: step_response(PID(1), FunctionPlant(lambda x, u, t: [1, 2]), duration=1), "1 derivatives"),
        (lambda: step_response(PID(1), TransferFunction([1], [1, 1]), duration=-1), "duration must be"),
        (lambda: step_response(PID(1), TransferFunction([1], [1, 1]), limits=(1, 0)), "above the lower limit"),
        (lambda: step_response(PID(1), TransferFunction([1], [1, 1]), sample_time=1e-6), "at most 20000"),
        (lambda: tuned_pid(TransferFunction([1], [1, -1]), 0.1), "unstable plant"),
    ],
)
def test_what_makes_no_loop_is_refused_in_a_sentence(make, sentence):
    with pytest.raises((LoopError, PlantError), match=sentence):
        make()
