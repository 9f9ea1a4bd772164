"""Rule bases of the robot's own motion and its reference in compiled code: against the same in Python, and by hand."""

from dataclasses import replace
from itertools import product
from typing import Any

import numpy as np
import pytest

import fuzzy
from fuzzy import Linear, Sugeno, Trapezoid, Triangle, Variable
from fuzzy.system import FuzzySystemError
from robotics.laws.law import ControllerError
from robotics.laws.rules.of_reference import CORRECTIONS, OUTPUTS, SEEN, is_of_reference, later
from robotics.laws.rules.own_rules import RULE_OUTPUTS, OwnRules, PerceivingRules
from robotics.laws.rules.quantities import RULE_QUANTITIES
from robotics.laws.tracking.lyapunov import Lyapunov
from robotics.simulation.loop import simulate
from robotics.simulation.scenario.reading import load_scenario
from tests.robotics.laws.rules.arrayform.laws import InterpretedRules

SCENARIO = load_scenario("table-2-1")  # its posture is measured with noise


def system(inputs: list[str], outputs: dict[str, float], kinds: tuple[bool, ...] = (True,)) -> Sugeno:
    """Two sets an input, and for each combination of the first two a rule; consequents grow with the inputs."""
    sets = {"low": Triangle(-4.0, -1.0, 1.5), "high": Triangle(-1.5, 1.0, 4.0)}
    gives = {
        name: {
            f"r{k}": Linear(np.full(len(inputs), size / 20), size * (k - 1.5) / 10) if kinds[0] else size * k / 10
            for k in range(4)
        }
        for name, size in outputs.items()
    }
    rules = []
    for k, (one, two) in enumerate(product(sets, sets)):
        when = f"{inputs[0]} is {one}" + (f" and {inputs[1]} is {two}" if len(inputs) > 1 else "")
        rules.append(f"if {when} then " + " and ".join(f"{name} is r{k}" for name in outputs))
    return Sugeno(
        [Variable(name, (-2.0, 2.0), sets) for name in inputs],
        [Variable(name, (-5.0, 5.0), terms) for name, terms in gives.items()],
        rules if len(inputs) > 1 else rules[:1] + rules[3:],
        name="any",
        out_of_range="clip",
    )


CASES = [
    (["x_err", "y_err", "heading_err"], {"dv": 1.0, "bend": 3.0}),
    (["x_err_smooth", "y_err_smooth", "heading_err_smooth"], {"dv": 1.0, "dw": 3.0}),
    (["v_command", "w_command", "y_err"], {"v": 0.5, "bend": 3.0}),
    (["target_v:0.5", "target_curvature:0.25", "y_err"], {"dv": 1.0, "dw": 1.0, "bend": 1.0}),
    (["distance", "alpha", "target_w:1"], {"speed_factor": 1.0, "turn": 0.3}),
    (["time", "v", "w", "target_v", "target_w"], {"speed": 1.0, "w": 1.0}),
    (["alpha"], {"turn": 0.3}),
    (["cross_track", "path_bearing", "curvature"], {"v": 1.0, "turn": 0.5}),
    (["progress", "remaining", "lag"], {"speed_factor": 1.0}),
    (["lag", "cross_track", "y_err"], {"dv": 1.0, "bend": 3.0}),
]


@pytest.mark.parametrize(("inputs", "outputs"), CASES)
def test_compiled_they_drive_as_in_python(inputs: list[str], outputs: dict[str, float]) -> None:
    law = OwnRules(rule_base=system(inputs, outputs))
    assert law.has_equation
    compiled, python = (simulate(SCENARIO, each, [1, 2]) for each in (law, InterpretedRules.of(law)))
    assert np.isfinite(compiled["x"]).all()
    for channel in ("x", "y", "v_demand", "w_demand"):
        np.testing.assert_allclose(compiled[channel][..., :40], python[channel][..., :40], rtol=0, atol=1e-11)
        np.testing.assert_allclose(compiled[channel], python[channel], rtol=0, atol=5e-3)  # the last bit may grow


def test_every_compiled_name_is_a_quantity_and_an_output_that_robots_have() -> None:
    assert set(SEEN) <= set(RULE_QUANTITIES)
    assert set(OUTPUTS) <= set(RULE_OUTPUTS)
    assert later("target_v:0.5") == ("target_v", 0.5)
    assert later("target_v") is later("x_err:1") is later("target_v:soon") is None
    with pytest.raises(ControllerError, match="target_v:SECONDS"):
        OwnRules(rule_base=system(["target_x:1"], {"dv": 1.0}))


def test_what_asks_for_more_perceives() -> None:
    for inputs, outputs in ((["front", "alpha"], {"turn": 1.0}), (["x_err"], {"rate": 1.0})):
        fis = system(inputs, outputs)
        assert not is_of_reference(fis)
        law = OwnRules(rule_base=fis)
        assert isinstance(law, PerceivingRules)
        assert law.has_equation
    assert isinstance(OwnRules(rule_base=system(["x_err"], {"v": 1.0}), leader=1), PerceivingRules)
    assert not isinstance(OwnRules(rule_base=system(["x_err"], {"v": 1.0})), PerceivingRules)


@pytest.mark.parametrize("inputs", [["x_err", "y_err"], ["x_err", "stuck"]])
def test_what_refuses_numbers_says_so_behind_the_run(inputs: list[str]) -> None:
    """As any rule base in compiled code; here of the robot alone, and one that perceives."""
    fis = system(inputs, {"v": 0.5})
    strict = replace(
        fis, out_of_range="error", inputs=[replace(v, universe=(-0.02, 0.02), terms=v.terms) for v in fis.inputs]
    )
    with pytest.raises(FuzzySystemError, match="x_err"):
        simulate(SCENARIO, OwnRules(rule_base=strict))


def linear(kx: float, ky: float, kpsi: float) -> Sugeno:
    """One rule for each output that is the linear part of the Lyapunov law (2.30), (2.32)."""
    everywhere = {"any": Trapezoid(-100.0, -99.0, 99.0, 100.0)}
    inputs = [Variable(name, (-50.0, 50.0), everywhere) for name in ("x_err", "y_err", "heading_err")]
    dv = Variable("dv", (-100.0, 100.0), {"trim": Linear((kx, 0.0, 0.0), 0.0)})
    bend = Variable("bend", (-1000.0, 1000.0), {"trim": Linear((0.0, ky, kpsi), 0.0)})
    return Sugeno(inputs, [dv, bend], ["if x_err is any then dv is trim and bend is trim"], name="linear")


@pytest.mark.parametrize("given", [{}, {"lead": "auto"}, {"lead": 0.1, "smooth": 0.3}])
def test_one_linear_rule_is_the_lyapunov_law_near_the_path(given: dict[str, Any]) -> None:
    """They differ by sin ψ for ψ, which is ψ³/6."""
    told = load_scenario("reference")
    rules = simulate(told, OwnRules(rule_base=linear(1.0, 10.0, 5.0), **given), [0])
    law = simulate(told, Lyapunov(kx=1.0, ky=10.0, kpsi=5.0, **given), [0])
    psi = np.abs(rules["heading"] - rules.target("heading")).max()
    assert psi < 0.05
    on = told.times < 10  # s: later a wheel's encoder may count one more
    assert np.abs(rules["v_demand"] - law["v_demand"])[..., on].max() < 1e-4
    off = np.abs(rules["w_demand"] - law["w_demand"])[..., on]
    assert np.median(off) < 5.0 * psi**3 < 1e-4
    assert off.max() < 5e-3  # where a wheel's encoder counts one more


def test_a_rule_base_that_corrects_has_a_lead_and_another_has_none() -> None:
    assert OwnRules(rule_base=linear(1, 1, 1), lead="auto").corrects
    assert CORRECTIONS & {*OUTPUTS}
    with pytest.raises(ControllerError, match="its target is look_ahead ahead"):
        OwnRules(rule_base=system(["alpha"], {"turn": 0.3}), lead=0.1)
    assert {"look_ahead", "steering_distance", "leader"} <= OwnRules(rule_base=linear(1, 1, 1)).idle
    assert "catch_up" in OwnRules(rule_base=system(["alpha"], {"turn": 0.3})).idle


def test_at_rest_it_turns_as_fast_as_catch_up_says() -> None:
    """A robot beside a reference that stands: ω = catch_up · bend."""
    told = load_scenario("reference")
    fis = linear(2.0, 10.0, 0.0)
    slow, fast = (simulate(told, OwnRules(rule_base=fis, catch_up=c), [0])["w_demand"] for c in (0.1, 1.0))
    assert not np.array_equal(slow, fast)
    assert fuzzy.check(fis) is not None
