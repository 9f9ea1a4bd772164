"""The certificate of a rule base's loop: against closed forms, eigenvalues, and the loop simulated from any state."""

import json
import math
from dataclasses import replace

import numpy as np
import pytest
from scipy.linalg import expm

from fuzzy import write_fis
from fuzzy.commands.application import main
from fuzzy.membership import Trapezoid
from fuzzy.membershipfunction import as_number
from fuzzy.plugins.designer.starts.control import rule_table
from fuzzy.plugins.loop.certificate import NotCertified, StepCertificate, certify_step, positive
from fuzzy.plugins.loop.controller import LoopError, RuleController, Scale, roles_of
from fuzzy.plugins.loop.plant import FunctionPlant, TransferFunction
from fuzzy.plugins.loop.plantfile import PLANT_EXAMPLES
from fuzzy.plugins.loop.response import Loop, SampledController, respond
from fuzzy.plugins.loop.sampledloop import Ball, ball, exponential, sampled_loop
from fuzzy.system import Constant, Linear, Sugeno, Variable

pytest.importorskip("cvxpy")


def proportional(gain):
    """u = gain · e, by one rule."""
    error = Variable("error", (-10, 10), {"any": Trapezoid(-10, -10, 10, 10)})
    u = Variable("u", (-99, 99), {"p": Linear((gain,), 0.0)})
    return Sugeno([error], [u], ["if error is any then u is p"], name="P")


def example(name, kind="pd", **changed):
    """A packaged plant with a rule table, and the settings that the designer begins with."""
    given = PLANT_EXAMPLES[name]
    loop = Loop(duration=given.duration, low=given.limits[0], high=given.limits[1], scale=Scale(*given.scale))
    return rule_table(kind, 5), given.plant, replace(loop, **changed)


def size_at_end(system, plant, z, level, steps=150):
    """V along the loop as it is simulated sample by sample, from states z."""
    loop, moving = system.loop, plant.sampled(system.loop.period)
    named = dict(zip(system.states, z.tolist(), strict=True))
    x = np.array([v for name, v in named.items() if name.startswith("x")])
    on_way = [v for name, v in named.items() if name.startswith("u(")]
    held = [0.0] * (moving.dead_samples + 1 - len(on_way)) + on_way
    asked = SampledController(RuleController(system.fis, system.roles, loop.scale), loop)
    asked._begun, asked.error = "error before" in named, named.get("error before", 0.0)
    asked.rate, asked.total = named.get("rate before", 0.0), named.get("sum", 0.0)
    asked._integrated = named.get("integral", 0.0)
    seen = [level(z)]
    for _ in range(steps):
        output = moving.output(x, held[0])
        held.append(asked(loop.reference - output))
        x = moving.advance(x, held[0], held[1], 0.0)
        del held[0]
        now = {
            "error before": asked.error,
            "rate before": asked.rate,
            "sum": asked.total,
            "integral": asked._integrated,
        }
        rest = [now[name] for name in system.states if name in now]
        seen.append(level(np.array([*x, *held[len(held) - len(on_way) :], *rest])))
    return np.array(seen)


def on_boundary(found, count, rng):
    """States with V = 1."""
    way = np.linalg.solve(np.linalg.cholesky(found.P).T, rng.normal(size=(len(found.P), count))).T
    return found.rest + way / np.sqrt(np.einsum("ki,ij,kj->k", way, found.P, way))[:, None]


def holds(found, plant, count, rng):
    """Whether starts on the boundary do what is proven of them."""
    for z in on_boundary(found, count, rng):
        seen = size_at_end(found.system, plant, z, found.level)
        assert (seen[1:] <= found.fall * seen[:-1] + (1 - found.fall) * found.end + 1e-9).all()


def test_the_exponential_encloses_and_is_near():
    rng = np.random.default_rng(1)
    for n in (1, 2, 5):
        a = rng.normal(size=(n, n)) * 3
        found = exponential(ball(a))
        assert (abs(found.mid - expm(a)) <= 1e-11 * abs(expm(a)).max()).all()
        assert found.rad.max() < 1e-11 * abs(expm(a)).max()
    grows = exponential(ball([[0.0, 1.0], [0.0, 0.0]]))  # [[1, 1], [0, 1]], exactly
    assert (abs(grows.mid - [[1, 1], [0, 1]]) <= grows.rad).all()
    one = exponential(ball([[math.log(2.0)]]))
    assert abs(one.mid.item() - 2) <= one.rad.item() + 1e-15


def test_products_enclose_exact_ones():
    rng = np.random.default_rng(2)
    a, b = rng.integers(-9, 9, (3, 4)) / 7, rng.integers(-9, 9, (4, 2)) / 3
    exact = np.array([[sum(round(x * 7) * round(y * 3) for x, y in zip(r, c, strict=True)) for c in b.T] for r in a])
    found = ball(a, 1) @ ball(b, 1)
    assert (abs(found.mid - exact / 21) <= found.rad + 1e-16).all()
    assert (found.rad < 3e-14).all()


def test_positive_definite_for_sure_only():
    assert positive(ball([[2.0, 1.0], [1.0, 2.0]]))
    assert not positive(ball([[1.0, 2.0], [2.0, 1.0]]))
    assert not positive(ball([[1.0, 1.0], [1.0, 1.0]]))
    assert not positive(Ball(np.eye(2), np.full((2, 2), 0.6)))


@pytest.mark.parametrize(
    ("plant", "kind", "changed"),
    [
        (TransferFunction([1], [1, 1], 0.2), "pi", {}),
        (TransferFunction([1], [1, 1], 0.05), "pi", {"sample_time": 0.05}),
        (TransferFunction([1], [1, 1], 0.13), "pd", {"sample_time": 0.05, "rate_filter": 0.1}),
        (TransferFunction([0.3, 1], [1, 1, 0]), "pd", {}),
        (TransferFunction([0.3, 1], [1, 1], 0.02), "pi", {"sample_time": 0.05}),  # the input is seen at once
        (TransferFunction([0.3, 1], [1, 1]), "pi", {"sample_time": 0.05}),
    ],
)
def test_the_sampled_system_is_the_simulated_loop(plant, kind, changed):
    loop, fis = replace(Loop(duration=4.0, scale=Scale(Kde=0.3)), **changed), rule_table(kind, 5)
    done = respond(fis, plant, loop)
    system = sampled_loop(fis, plant, loop, roles_of(fis))
    n, z, found = len(system.states), system.start, []
    for _ in range(loop.steps + 1):
        v = system.rules(system.rows.mid[n:-1][:, [*range(n), -1]] @ [*z, 1.0])
        found.append(system.rows.mid[-1] @ [*z, *v, 1.0])
        z = system.advance(z)
    np.testing.assert_allclose(found, done.control, atol=1e-9)


@pytest.mark.parametrize("samples", [0, 1, 4])
def test_a_gain_beyond_the_delay_margin_is_never_certified(samples):
    # z^(n+1) - z^n + K T has its roots inside the circle for K T < 2 sin(pi / (2 (2n + 1))) alone
    period, plant = 0.1, TransferFunction([1], [1, 0], 0.1 * samples)
    margin = 2 * math.sin(math.pi / (2 * (2 * samples + 1))) / period
    loop = Loop(sample_time=period, duration=20.0)
    for factor, limit in ((1.001, math.inf), (1.5, 0.5)):
        limited = replace(loop, low=-limit, high=limit)
        assert isinstance(certify_step(proportional(factor * margin), plant, limited), NotCertified)
    assert isinstance(certify_step(proportional(0.5 * margin), plant, loop), StepCertificate)


@pytest.mark.parametrize("samples", [0, 3])
def test_a_linear_rule_base_has_the_rate_of_its_eigenvalues(samples):
    period, gain = 0.1, 1.2
    found = certify_step(
        proportional(gain), TransferFunction([1], [1, 0], samples * period), Loop(sample_time=period, duration=20.0)
    )
    roots = np.roots([1.0, -1.0, *[0.0] * (samples - 1), gain * period] if samples else [1.0, gain * period - 1])
    exact = -math.log(abs(roots).max()) / period
    assert isinstance(found, StepCertificate)
    assert 0.97 * exact <= found.rate <= exact
    assert found.start <= 1


@pytest.mark.parametrize(("name", "kind"), [("integrating", "pd"), ("lag", "pi")])
def test_the_region_of_a_packaged_example_holds_its_step(name, kind):
    fis, plant, loop = example(name, kind)
    found = certify_step(fis, plant, loop)
    assert isinstance(found, StepCertificate), found
    assert found.start <= 1
    assert found.widths["error"] >= 1.0
    assert found.end <= 1.1e-6
    holds(found, plant, 10, np.random.default_rng(3))


def broken(rng):
    """A rule table whose outputs, factors or rules are broken at random."""
    fis = rule_table(str(rng.choice(["pd", "pi"])), 3)
    out = fis.outputs[0]
    spread = rng.uniform(0, 2)
    terms = {
        n: Constant(as_number(t.parameters[-1]) * rng.choice([1, 1, -1]) + spread * rng.normal())
        for n, t in out.terms.items()
    }
    rules = [rule for rule in fis.rules if rng.uniform() > 0.1]
    scale = Scale(Kde=10 ** rng.uniform(-2, 0), Ku=10 ** rng.uniform(-1, 2), Kdu=10 ** rng.uniform(-1, 2))
    return replace(fis, outputs=[replace(out, terms=terms)], rules=rules or fis.rules[:1]), scale


@pytest.mark.parametrize("count", [6, pytest.param(100, marks=pytest.mark.long)])
def test_no_broken_rule_base_is_certified_that_simulation_refutes(count):
    rng, certified = np.random.default_rng(4), 0
    plants = [TransferFunction([1], [1, 1], 0.2), TransferFunction([1], [1, 0.4, 1]), TransferFunction([1], [1, -1])]
    for k in range(count):
        fis, scale = broken(rng)
        plant = plants[k % 3]
        found = certify_step(fis, plant, Loop(sample_time=0.1, duration=20.0, scale=scale, low=-20, high=20))
        if isinstance(found, StepCertificate):
            certified += 1
            holds(found, plant, 2, rng)
    assert count < 100 or certified > 10


def test_a_python_plant_that_says_it_is_linear_is_certified_as_its_transfer_function():
    fis, plant, loop = example("integrating")
    own = FunctionPlant(lambda x, u, t: [-x[0] + u, x[0]], states=2, output=lambda x: x[1], linear=True, name="own.py")
    found, other = certify_step(fis, own, loop), certify_step(fis, plant, loop)
    assert isinstance(found, StepCertificate)
    assert isinstance(other, StepCertificate)
    assert found.rate == pytest.approx(other.rate, rel=1e-6)
    with pytest.raises(LoopError, match="is not A x"):
        certify_step(fis, replace(own, derivative=lambda x, u, t: [-math.sin(x[0]) + u, x[0]]), loop)
    with pytest.raises(LoopError, match="linear = True"):
        certify_step(fis, replace(own, linear=False), loop)


def test_a_hole_in_the_rules_is_named_with_its_box():
    fis, plant, loop = example("integrating")
    found = certify_step(replace(fis, rules=fis.rules[:12]), plant, loop)
    assert isinstance(found, NotCertified)
    assert found.why


def test_the_command_says_what_is_proven_and_fails_where_nothing_is(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    write_fis(rule_table("pd", 5), "pd.fis")
    arguments = ["step", "pd.fis", "--plant", "integrating", "--scale", "Ku=4", "--scale", "Kde=0.8", "--certify"]
    assert main([*arguments, "--json"]) == 0
    found = json.loads(capsys.readouterr().out)["certificates"]["Certified"]
    assert found["start"] <= 1
    assert len(found["P"]) == len(found["states"])
    assert main([*arguments, "--scale", "Ke=-1"]) == 1
    assert "Not certified" in capsys.readouterr().out
