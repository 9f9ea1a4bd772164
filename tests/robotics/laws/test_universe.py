"""Recorded inputs of rule bases: what leaves a universe, and what no rule answers, is said once a run is over."""

import warnings
from dataclasses import replace

import numpy as np
import pytest

from fuzzy.inference import InferenceWarning
from fuzzy.system import FuzzySystemError
from robotics.laws.tracking.fuzzy_tracking import load_rule_base
from robotics.laws.universe import say_of_inputs

ETA = load_rule_base("eta")  # 0 to 0.6 m, or so: its ends are no float32 numbers
LOW, HIGH = ETA.inputs[0].universe


def recorded(*values: float) -> np.ndarray:
    """Inputs of two systems of one input, of one robot; the second one is told its near end throughout."""
    both = np.array([[value, LOW] for value in values], dtype=np.float32)
    return both[:, :, None, None]


def test_within_the_universe_nothing_is_said() -> None:
    strict = replace(ETA, out_of_range="error")
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        say_of_inputs({"eta": strict, "theta": strict}, recorded(LOW, (LOW + HIGH) / 2, HIGH, np.nan))


def test_outside_it_is_said_as_the_system_wants_it() -> None:
    beyond = recorded(LOW, HIGH + 1e-6)
    with pytest.raises(FuzzySystemError, match="outside"):
        say_of_inputs({"eta": replace(ETA, out_of_range="error"), "theta": ETA}, beyond)
    with pytest.warns(InferenceWarning, match="outside"):
        say_of_inputs({"eta": replace(ETA, out_of_range="warn"), "theta": ETA}, beyond)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        say_of_inputs({"eta": ETA, "theta": replace(ETA, out_of_range="error")}, beyond)  # clipped; and in order


def test_where_no_rule_fires_it_is_said() -> None:
    gap = replace(ETA, rules=ETA.rules[:1], no_rule_fires="error")
    with pytest.raises(FuzzySystemError, match="no rule fires"):
        say_of_inputs({"eta": gap, "theta": ETA}, recorded(LOW, HIGH))
