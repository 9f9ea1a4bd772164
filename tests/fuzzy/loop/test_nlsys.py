"""Rule bases as static nonlinearities of python-control."""

import sys

import numpy as np
import pytest

import fuzzy
from fuzzy.loop.nlsys import to_nlsys


def rule_base(low, high):
    terms = {"negative": fuzzy.LinearZ(-1, 1), "positive": fuzzy.LinearS(-1, 1)}
    return fuzzy.Sugeno(
        inputs=[fuzzy.Variable("error", (-1, 1), terms, "m")],
        outputs=[fuzzy.Variable("force", (-3, 3), {"back": low, "ahead": high}, "N")],
        rules=["if error is negative then force is back", "if error is positive then force is ahead"],
        out_of_range="ignore",
    )


def test_a_linear_rule_base_has_its_gain_as_slope_and_as_describing_function():
    control = pytest.importorskip("control", reason="python-control is not installed")
    system = to_nlsys(rule_base(-2.0, 2.0))
    assert (system.input_labels, system.output_labels, system.nstates) == (["error"], ["force"], 0)
    assert system.linearize([], [0.25]).D[0, 0] == pytest.approx(2.0, abs=1e-6)
    found = control.describing_function(system, [0.2, 0.7, 1.0])
    np.testing.assert_allclose(found, 2.0, atol=1e-9)


def test_a_saturating_rule_base_has_the_describing_function_of_saturation():
    control = pytest.importorskip("control", reason="python-control is not installed")
    amplitude = np.array([2.0, 5.0])
    r = 1 / amplitude
    book = 2.0 * 2 / np.pi * (np.arcsin(r) + r * np.sqrt(1 - r**2))  # gain 2, saturated beyond 1
    found = control.describing_function(to_nlsys(rule_base(-2.0, 2.0)), amplitude, num_points=2000)
    np.testing.assert_allclose(found, book, rtol=1e-4, atol=1e-6)


def test_without_python_control_a_sentence_says_what_to_install(monkeypatch):
    monkeypatch.setitem(sys.modules, "control", None)
    with pytest.raises(fuzzy.LoopError, match=r"needs python-control; install it: pip install .*control"):
        to_nlsys(rule_base(-2.0, 2.0))
