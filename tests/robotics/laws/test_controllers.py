"""The catalogue of controllers and the specifications that name them."""

import pickle
from dataclasses import FrozenInstanceError, replace
from typing import Any

import numpy as np
import pytest

from robotics.laws.catalogue import CATALOGUE, gains_of, make_controller
from robotics.laws.law import ControllerError
from robotics.laws.rules.own_rules import OwnRules
from robotics.laws.tracking.lyapunov import Lyapunov
from robotics.laws.tracking.sliding_mode import SlidingMode
from robotics.simulation.loop import simulate
from robotics.simulation.scenario.reading import load_scenario
from robotics.world.paths.posture import posture_error, wrapped, wrapped_compiled
from robotics.world.paths.references import Reference


def made(specification: str) -> Any:
    """The law itself, with the gains that only its class has."""
    return make_controller(specification)


@pytest.mark.parametrize("name", [name for name, preset in CATALOGUE.items() if preset.kind == "tracking"])
def test_every_preset_can_be_made_and_driven(name):
    law = make_controller(name)
    assert isinstance(law, CATALOGUE[name].law)
    assert CATALOGUE[name].title
    assert CATALOGUE[name].note
    run = simulate(replace(load_scenario("table-2-1"), duration=1.0), law)
    assert not run.diverged.any()
    assert run.level == law.level
    with pytest.raises(FrozenInstanceError):
        law.level = "torque"  # type: ignore[misc]


def test_presets_have_the_gains_of_the_thesis():
    """2.1.3.2: K = 1, 0.8, 0.8, 0.2; λ = 10; μ0 = 0.1, α = 3.  2.2.1: 1, 1, 1."""
    modes: dict[str, Any] = {name: make_controller(name) for name in ("csm", "assm", "qssm", "esm")}
    assert {name: law.mode for name, law in modes.items()} == {n: n for n in modes}
    assert [law.k for law in modes.values()] == [1.0, 0.8, 0.8, 0.2]
    assert {law.lam for law in modes.values()} == {10.0}
    assert (modes["esm"].mu0, modes["esm"].alpha) == (0.1, 3.0)
    assert {law.level for law in modes.values()} == {"torque"}
    thesis, tuned = made("lyapunov-thesis"), made("lyapunov")
    assert (thesis.kx, thesis.ky, thesis.kpsi, thesis.form) == (1, 1, 1, "2.32")
    assert (tuned.kx, tuned.ky, tuned.kpsi) == (1, 10, 5)
    assert made("fuzzy").rule_base == "tracking"
    assert made("fuzzy-literal").rule_base == "tracking-literal"


def test_specifications_change_gains():
    law = make_controller("csm:k=0.3,realisation=velocity")
    assert law == SlidingMode(mode="csm", k=0.3, realisation="velocity")
    assert law.level == "velocity"
    assert make_controller(" esm : k = 0.5 , mu0=1e-1 ") == SlidingMode(mode="esm", k=0.5)
    assert make_controller("lyapunov:form=2.31,ky=4") == Lyapunov(form="2.31", ky=4.0)
    assert make_controller("fuzzy:steering=heading,lateral=path,look_ahead=0.6") == OwnRules(
        steering="heading", lateral="path", look_ahead=0.6
    )
    assert make_controller("lyapunov:") == make_controller("lyapunov")
    assert made("qssm:discretisation=memory").discretisation == "memory"
    assert made("csm:ky=3,kpsi=2").outer == Lyapunov(ky=3.0, kpsi=2.0)


REFUSED = {
    "fuzy": "unknown controller 'fuzy'; did you mean 'fuzzy'? Known: fuzzy, fuzzy-lateral, fuzzy-literal",
    "lyapunow:ky=1": "unknown controller 'lyapunow'; did you mean 'lyapunov'?",
    "": "unknown controller ''",
    "stanley": "unknown controller 'stanley'",
    "csm:kk=1": "controller 'csm': unknown gain 'kk'; did you mean 'k'?",
    "lyapunov:kpsy=1": "controller 'lyapunov': unknown gain 'kpsy'; did you mean 'kpsi'?",
    "csm:mode=esm": "unknown gain 'mode'",
    "lyapunov:level=torque": "unknown gain 'level'",
    "csm:law=1": "unknown gain 'law'",
    "csm:k": "controller 'csm': gain 'k' needs a value: k=...",
    "csm:k=": "gain 'k' needs a value",
    "csm:k=big": "controller 'csm': k must be a finite number in m/s² (rad/s²), > 0; got 'big'",
    "csm:k=0": "controller 'csm': k must be a finite number in m/s² (rad/s²), > 0; got 0.0",
    "esm:k=-1": "> 0; got -1.0",
    "esm:k=nan": "k must be a finite number",
    "esm:k=inf": "k must be a finite number",
    "esm:mu0=2": "mu0 must be a finite number, > 0 and <= 1; got 2.0",
    "lyapunov:form=2.33": "controller 'lyapunov': form must be one of '2.31', '2.32'; got '2.33'",
    "csm:realisation=volts": "realisation must be one of 'torque', 'velocity'; got 'volts'",
    "assm:discretisation=exact": "discretisation must be one of 'integrated', 'algebraic', 'memory'",
    "fuzzy:look_ahead=-1": "look_ahead must be a finite number in s, >= 0 and <= 10; got -1.0",
    "fuzzy:rule_base=trackin": "controller 'fuzzy': unknown rule base 'trackin'; did you mean 'tracking'?",
    "fuzzy:steering=global": "steering must be one of 'bearing', 'heading'",
}


@pytest.mark.parametrize(("specification", "message"), REFUSED.items(), ids=REFUSED)
def test_wrong_specifications_say_what_is_accepted(specification, message):
    with pytest.raises(ControllerError) as caught:
        make_controller(specification)
    assert message in str(caught.value)


def test_gains_of_names_every_gain():
    gains = gains_of(make_controller("esm:k=0.25"))
    assert gains["k"] == 0.25
    assert {"lam", "mu0", "alpha", "realisation", "outer.kx", "outer.ky", "outer.kpsi"} <= set(gains)
    assert "law" not in gains
    assert gains_of(make_controller("lyapunov-thesis"))["ky"] == 1.0


def test_wrapped_brings_angles_into_half_a_turn():
    angles = np.array([0.0, np.pi, -np.pi, 3 * np.pi, 2 * np.pi + 0.1, -0.1, 100.0])
    result = wrapped(angles)
    assert ((result >= -np.pi) & (result < np.pi)).all()
    np.testing.assert_allclose(np.exp(1j * result), np.exp(1j * angles), atol=1e-12)
    assert result[1] == -np.pi


def test_one_angle_is_wrapped_to_the_same_bits():
    """Also at half turns and beside them, where the remainder is left out or not."""
    turns = np.pi * np.arange(-5, 6)
    angles = np.concatenate([turns, np.nextafter(turns, -9), np.nextafter(turns, 9), np.linspace(-20, 20, 999), [-0.0]])
    np.testing.assert_array_equal([wrapped_compiled(angle) for angle in angles], wrapped(angles))
    assert np.isnan([wrapped_compiled(np.nan), wrapped_compiled(np.inf)]).all()


def test_posture_error_is_5_9():
    """Ahead is +x, left is +y, desired minus actual."""
    target = Reference(*(np.array([v]) for v in (1.0, 1.0, 0.5, 0.0, 0.0, 0.0)))
    e = posture_error(np.array([[1.0]]), np.array([[0.0]]), np.array([[np.pi / 2]]), target)
    assert [f.item() for f in e] == pytest.approx([1.0, 0.0, 0.5 - np.pi / 2])
    e = posture_error(np.array([[0.0]]), np.array([[0.0]]), np.array([[0.0]]), target)
    assert [f.item() for f in e] == pytest.approx([1.0, 1.0, 0.5])


@pytest.mark.parametrize("name", sorted(CATALOGUE))
def test_a_law_goes_to_other_processes(name):
    law = make_controller(name)
    assert gains_of(pickle.loads(pickle.dumps(law))) == gains_of(law)
