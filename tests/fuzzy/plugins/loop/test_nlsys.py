"""Rule bases in python-control, against its own loop, its describing functions and closed forms."""

import builtins
import sys
from typing import Any

import numpy as np
import pytest

import fuzzy
from fuzzy.plugins.designer.starts.control import rule_table
from fuzzy.plugins.loop.controller import LoopError, Scale
from fuzzy.plugins.loop.frequency import plot_bode, plot_describing_function
from fuzzy.plugins.loop.nlsys import describing_function, linear_controller, linearised, to_nlsys
from tests.drawn import faults_of

control = pytest.importorskip("control", reason="python-control is not installed")


def ramp(gain, limit):
    """min(max(gain u, -limit gain), limit gain): a rule base of two straight edges."""
    terms = {"low": fuzzy.linzmf(-limit, limit), "high": fuzzy.linsmf(-limit, limit)}
    sides = {"down": -gain * limit, "up": gain * limit}
    return fuzzy.Sugeno(
        [fuzzy.Variable("e", (-10, 10), terms, "m")],
        [fuzzy.Variable("u", (-20, 20), sides, "N")],
        ["if e is low then u is down", "if e is high then u is up"],
        name="ramp",
    )


def saturation(gain, limit, amplitude):
    """The textbook formula of a saturation's describing function, for amplitudes beyond the limit."""
    s = limit / amplitude
    return 2 * gain / np.pi * (np.arcsin(s) + s * np.sqrt(1 - s**2))


def test_a_describing_function_is_that_of_the_books_and_of_python_control():
    fis = ramp(2.0, 1.0)
    a = np.array([0.2, 0.7, 1.0, 2.0, 5.0])
    ours = describing_function(fis, a)
    np.testing.assert_allclose(ours[:3], 2.0, atol=1e-6)
    np.testing.assert_allclose(ours[3:], saturation(2.0, 1.0, a[3:]), rtol=1e-5)
    np.testing.assert_allclose(ours.imag, 0, atol=1e-12)
    theirs = control.describing_function(to_nlsys(fis), a, num_points=400)
    np.testing.assert_allclose(ours, theirs, rtol=2e-3)
    assert describing_function(fis, 2.0).shape == ()


def summing():
    """A position-form PI by rules over the error and its sum."""
    sides = {"negative": fuzzy.linzmf(-1, 1), "positive": fuzzy.linsmf(-1, 1)}
    inputs = [fuzzy.Variable(name, (-1, 1), sides) for name in ("error", "error_sum")]
    rules = ["if error is positive or error_sum is positive then u is push", "if error is negative then u is pull"]
    return fuzzy.Sugeno(inputs, [fuzzy.Variable("u", (-1, 1), {"push": 1, "pull": -1})], rules)


@pytest.mark.parametrize(
    ("kind", "scale"),
    [("pd", {"Kde": 0.7, "Ku": 4}), ("pi", {"Kdu": 2}), ("pid", {"Kdu": 1.5}), ("sum", {"Kie": 0.5, "Ku": 2})],
)
def test_a_loop_in_python_control_answers_as_ours(kind, scale):
    """A sampled first-order plant with an integrator, held input, and the controller with its states."""
    fis = summing() if kind == "sum" else rule_table(kind, 5)
    plant, period = fuzzy.TransferFunction([1], [1, 1, 0]), 0.02
    ours = fuzzy.step_response(fis, plant, scale=Scale(**scale), duration=4, sample_time=period)
    sampled = control.ssdata(control.sample_system(control.ss(control.tf([1], [1, 1, 0])), period))
    loop = control.interconnect(
        [
            to_nlsys(fis, period, scale=Scale(**scale)),
            control.ss(*sampled, period, inputs=["u"], outputs=["y"], name="plant"),
            control.ss([], [], [], [[1, -1]], period, inputs=["r", "y"], outputs=["error"], name="difference"),
        ],
        inputs=["r"],
        outputs=["y"],
        dt=period,
    )
    time = np.arange(201) * period
    theirs = control.input_output_response(loop, time, np.ones_like(time))
    np.testing.assert_allclose(theirs.outputs, ours.output, atol=1e-9)


def test_a_linearised_controller_is_its_gains_and_what_the_rules_do_near_zero():
    fis = rule_table("pd", 5)
    gains = linearised(fis, [0.05, 0.05])
    step = 1e-4
    np.testing.assert_allclose(gains[0, 0], (fis([0.05 + step, 0.05]) - fis([0.05, 0.05]))[0] / step, rtol=1e-6)
    made = linear_controller(fis, 0.02, at=[0.05, 0.05], scale=Scale(Kde=0.7, Ku=4))
    w = 3.0
    z = np.exp(1j * w * 0.02)
    expected = 4 * (gains[0, 0] + gains[0, 1] * 0.7 * (1 - 1 / z) / 0.02)
    np.testing.assert_allclose(made(z), expected, rtol=1e-9)
    integral = linear_controller(rule_table("pi", 5), 0.02, at=[0.05, 0.05])
    assert abs(integral(np.exp(1j * 1e-4))) > 20 * abs(integral(np.exp(1j * 0.5)))


def test_a_limit_cycle_is_where_the_describing_function_says():
    """A steep rule base, nearly a relay, around 1 / (s (s + 1)²): w = 1 rad/s, and -1/N(A) = G(i) = -1/2."""
    fis = ramp(50.0, 0.02)
    amplitudes = np.linspace(0.3, 1.2, 500)
    predicted = amplitudes[np.argmin(np.abs(describing_function(fis, amplitudes).real - 2.0))]
    assert predicted == pytest.approx(2 / np.pi, rel=0.01)
    done = fuzzy.step_response(
        fis, fuzzy.TransferFunction([1], [1, 2, 1, 0]), reference=0.3, duration=120, sample_time=0.01
    )
    late = done.time > 80
    wave = (done.output - 0.3)[late]
    measured = (wave.max() - wave.min()) / 2
    ups = done.time[late][1:][(wave[:-1] < 0) & (wave[1:] >= 0)]
    assert measured == pytest.approx(predicted, rel=0.06)
    assert 2 * np.pi / np.diff(ups).mean() == pytest.approx(1.0, rel=0.03)


def test_pictures_have_axes_with_units():
    fis = rule_table("pd", 5)
    made = {f"Kde = {k}": linear_controller(fis, 0.02, at=[0.05, 0.05], scale=Scale(Kde=k)) for k in (0.2, 1.0)}
    for figure in (plot_bode(made), plot_describing_function(ramp(2.0, 1.0))):
        assert not faults_of(figure)


def test_what_makes_no_controller_is_said(monkeypatch):
    with pytest.raises(LoopError, match="one input and one output"):
        describing_function(rule_table("pd", 3), 1.0)
    with pytest.raises(LoopError, match="> 0"):
        describing_function(ramp(1, 1), [0.0, 1.0])
    pd = rule_table("pd", 3)
    periods: list[Any] = [0, -0.1, "a", True, float("nan"), float("inf")]
    for period in periods:
        with pytest.raises(LoopError, match="sample time must be a number > 0"):
            to_nlsys(pd, period)
        with pytest.raises(LoopError, match="sample time must be a number > 0"):
            linear_controller(pd, period)
    with pytest.raises(LoopError, match="give its sample_time too"):
        to_nlsys(ramp(1, 1), scale=Scale())
    with pytest.raises(LoopError, match="sample time must be"):
        to_nlsys(ramp(1, 1), -1.0)
    monkeypatch.delitem(sys.modules, "control")
    original = builtins.__import__

    def without(name, *rest):
        if name == "control":
            raise ModuleNotFoundError(name)
        return original(name, *rest)

    monkeypatch.setattr(builtins, "__import__", without)
    with pytest.raises(LoopError, match="needs python-control; install it: pip install"):
        to_nlsys(ramp(1, 1))
