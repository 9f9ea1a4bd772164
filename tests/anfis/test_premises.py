"""The premises as an optimiser sees them: scaled, legal, in order, and back again."""

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
import torch
from hypothesis import given, settings
from hypothesis import strategies as st

import fuzzy
from anfis.consequents import groups
from anfis.data import samples
from anfis.network import Network
from anfis.premises import premises
from fuzzy import membership as mf
from fuzzy.errors import InputError
from fuzzy.files.fisfile import format_fis
from fuzzy.system import Linear
from tests.randomcases import cases

torch.set_num_threads(1)
# Two terms over [0, 1] of every kind; no sample lies on a corner.
TERMS: dict[type[mf.MembershipFunction], tuple[tuple[float, ...], tuple[float, ...]]] = {
    mf.Triangle: ((-0.7, 0.1, 0.93), (0.07, 0.81, 1.6)),
    mf.Trapezoid: ((-0.7, -0.1, 0.23, 0.91), (0.13, 0.72, 1.1, 1.6)),
    mf.LinearS: ((0.05, 0.93), (-0.6, 1.4)),
    mf.LinearZ: ((-0.4, 1.7), (0.11, 0.97)),
    mf.Gaussian: ((0.4, 0.1), (-0.5, 0.9)),
    mf.TwoSidedGaussian: ((0.3, -0.1, 0.35, 0.2), (0.3, 0.7, 0.5, 0.95)),
    mf.Bell: ((0.45, 2.0, 0.05), (0.5, 1.6, 0.97)),
    mf.Sigmoid: ((-6.0, 0.4), (7.0, 0.55)),
    mf.SigmoidDifference: ((7.0, -0.3, 8.0, 0.5), (6.0, 0.4, 7.0, 1.5)),
    mf.SigmoidProduct: ((7.0, -0.3, -8.0, 0.5), (6.0, 0.4, -7.0, 1.5)),
    mf.SShape: ((-0.6, 1.3), (0.02, 0.9)),
    mf.ZShape: ((-0.4, 1.3), (0.12, 1.07)),
    mf.PiShape: ((-0.8, -0.2, 0.2, 1.1), (-0.1, 0.7, 1.1, 1.7)),
}
UNIVERSES = ((-2.0, 3.0), (10.0, 10.5))


def in_units(kind: type[mf.MembershipFunction], parameters, low: float, span: float) -> mf.MembershipFunction:
    scale = {
        "location": lambda p: low + span * p,
        "width": lambda p: span * p,
        "slope": lambda p: p / span,
        "shape": float,
    }
    return kind(*(scale[role](p) for role, p in zip(kind.roles, parameters, strict=True)))


def system_of(kind: type[mf.MembershipFunction]) -> fuzzy.Sugeno:
    """Two inputs in units of their own, four rules."""
    inputs = [
        fuzzy.Variable(
            f"x{i}",
            (low, high),
            {f"t{k}": in_units(kind, parameters, low, high - low) for k, parameters in enumerate(TERMS[kind])},
        )
        for i, (low, high) in enumerate(UNIVERSES)
    ]
    output = fuzzy.Variable("y", (-1, 2), {f"c{k}": Linear((0.1 * k, -0.2), 1.0) for k in range(4)})
    rules = [f"if x0 is t{a} and x1 is t{b} then y is c{2 * a + b}" for a in (0, 1) for b in (0, 1)]
    return fuzzy.Sugeno(inputs, [output], rules, name=kind.matlab)


def points(count: int = 60) -> tuple[np.ndarray, np.ndarray]:
    unit = np.random.default_rng(3).uniform(0.01, 0.99, (count, 2))
    low, high = np.array(UNIVERSES).T
    return low + unit * (high - low), np.sin(4 * unit[:, 0]) * (1 + unit[:, 1] ** 2)


def network_of(fis: fuzzy.Sugeno, **options) -> Network:
    held = premises(fis, dtype=torch.float64, device="cpu", **options)
    return Network(held, groups(fis, torch.float64, "cpu"), ridge=0.0, block=1000)


@pytest.mark.parametrize("kind", mf.FUNCTIONS)
def test_the_gradient_of_the_reduced_cost_is_that_of_finite_differences(kind):
    fis = system_of(kind)
    network = network_of(fis)
    x, y = points()
    data = samples(fis, x, y, "training").to(torch.float64, "cpu")
    free = network.start().free

    def cost(flat: torch.Tensor) -> float:
        return network.fit(network.unflatten(flat), data).rmse ** 2 * len(x)

    fit = network.fit(free, data, gradient=True)
    assert fit.gradient is not None
    assert fit.solutions[0].rank == 12
    analytic = torch.cat([g.flatten() for g in fit.gradient])
    flat = torch.cat([p.flatten() for p in free])
    h = 1e-6
    steps = h * torch.eye(len(flat), dtype=torch.float64)
    numeric = flat.new_tensor([(cost(flat + e) - cost(flat - e)) / (2 * h) for e in steps])
    torch.testing.assert_close(analytic, numeric, rtol=1e-4, atol=1e-5 * float(numeric.abs().max()))
    assert (analytic.abs() > 0).sum() >= len(flat) // 2


@pytest.mark.parametrize("kind", mf.FUNCTIONS)
def test_torch_differentiates_through_the_least_squares(kind):
    from anfis.consequents import equations, solve

    fis = system_of(kind)
    network = network_of(fis)
    x, y = points(30)
    u, target = network.premises.scale(torch.tensor(x)), torch.tensor(y)[:, None]

    def answers(*free: torch.Tensor) -> torch.Tensor:
        (a,), _ = network.designs(free, u)
        return a @ solve(equations(a, target)).values

    free = [p.clone().requires_grad_() for p in network.start().free]
    assert torch.autograd.gradcheck(answers, free, eps=1e-5, atol=1e-5, rtol=1e-3)


@pytest.mark.parametrize("kind", mf.FUNCTIONS)
def test_parameters_survive_the_scaling(kind):
    fis = system_of(kind)
    held = premises(fis, dtype=torch.float64, device="cpu")
    start = held.start()
    consequents = [list(v.terms.values()) for v in fis.outputs]
    assert format_fis(held.system(start, consequents)) == format_fis(fis)
    moved = held.system(tuple(p + 1e-12 for p in start), consequents)
    for before, after in zip(fis.inputs, moved.inputs, strict=True):
        for name in before.terms:
            np.testing.assert_allclose(
                after.terms[name].parameters, before.terms[name].parameters, rtol=1e-9, atol=1e-10
            )


@pytest.mark.parametrize("kind", mf.FUNCTIONS)
@settings(max_examples=20)
@given(seed=st.integers(0, 10_000), size=st.sampled_from([0.1, 1.0, 1e3, 1e8]))
def test_a_huge_step_makes_a_legal_system_with_bounded_widths(kind, seed, size):
    fis = system_of(kind)
    held = premises(fis, dtype=torch.float64, device="cpu")
    random = torch.Generator().manual_seed(seed)
    free = held.valid([p + size * torch.randn(p.shape, dtype=p.dtype, generator=random) for p in held.start()])
    system = held.system(free, [list(v.terms.values()) for v in fis.outputs])  # raises where a term is not legal
    for (low, high), before, after in zip(UNIVERSES, fis.inputs, system.inputs, strict=True):
        for name, term in after.terms.items():
            for role, old, new in zip(term.roles, before.terms[name].parameters, term.parameters, strict=True):
                if role in ("width", "shape"):
                    assert old * new > 0
                if role == "width":
                    assert 0.999e-3 * (high - low) <= abs(new) <= 1.001e2 * (high - low)


@pytest.mark.parametrize("kind", [mf.Gaussian, mf.Bell])
@settings(max_examples=cases(40))
@given(seed=st.integers(0, 10_000), size=st.floats(0, 5))
def test_keep_order_keeps_order_and_coverage(kind, seed, size):
    centers = np.linspace(-2, 3, 4)
    terms = {f"t{k}": kind(0.9, c) if kind is mf.Gaussian else kind(0.8, 2.0, c) for k, c in enumerate(centers)}
    # Listed out of order: what counts is where they stand.
    shuffled = {name: terms[name] for name in ("t2", "t0", "t3", "t1")}
    fis = fuzzy.Sugeno(
        [fuzzy.Variable("x", (-2, 3), shuffled)],
        [fuzzy.Variable("y", (0, 1), {f"c{k}": k / 3 for k in range(4)})],
        [f"if x is t{k} then y is c{k}" for k in range(4)],
    )
    held = premises(fis, dtype=torch.float64, device="cpu", keep_order=True)
    random = torch.Generator().manual_seed(seed)
    free = held.valid([p + size * torch.randn(p.shape, dtype=p.dtype, generator=random) for p in held.start()])
    after = held.system(free, [list(v.terms.values()) for v in fis.outputs]).inputs[0].terms
    ordered = [after[f"t{k}"] for k in range(4)]
    for left, right in pairwise(ordered):
        assert left.c <= right.c
        x = np.linspace(left.c, right.c, 2001)
        assert np.maximum(left(x), right(x)).min() > 0.0999


def test_keep_order_refuses_what_has_no_center():
    with pytest.raises(InputError, match=r"'x0' must all be Gaussians or all bells, got Triangle"):
        premises(system_of(mf.Triangle), dtype=torch.float64, device="cpu", keep_order=True)


def test_a_system_that_clips_its_inputs_is_learnt_clipped():
    fis = replace(system_of(mf.Gaussian), out_of_range="clip")
    network = network_of(fis)
    x = np.array([[-9.0, 10.2], [0.0, 99.0], [1.0, 10.1]])
    start = network.start()
    output = network.output(start.free, start.values, network.premises.scale(torch.tensor(x)))
    np.testing.assert_allclose(output, fis(x), rtol=1e-12)


def test_a_universe_of_one_value():
    fis = fuzzy.Sugeno(
        [fuzzy.Variable("x", (2, 2), {"here": fuzzy.Gaussian(1, 2)})],
        [fuzzy.Variable("y", (0, 1), {"c": 0.5})],
        ["if x is here then y is c"],
        out_of_range="clip",
    )
    held = premises(fis, dtype=torch.float64, device="cpu")
    assert held.scale(torch.tensor([[2.0], [5.0]])).tolist() == [[0.0], [0.0]]
