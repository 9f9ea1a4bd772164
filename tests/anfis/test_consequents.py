"""Least squares against numpy's, against itself in blocks, and sample by sample."""

import warnings
from dataclasses import replace

import numpy as np
import pytest
import torch

import anfis
import fuzzy
from anfis.consequents import (
    NormalEquations,
    design,
    equations,
    groups,
    recursive_start,
    recursive_step,
    solve,
    weights_gradient,
)
from anfis.data import DataError, samples
from anfis.network import Network
from anfis.parameters import consequent_terms, present_values
from anfis.point import Point, numbers
from anfis.premises import premises
from fuzzy.inference import infer
from fuzzy.system import Constant, Linear

torch.set_num_threads(1)
RNG = np.random.default_rng(5)
FIS = fuzzy.Sugeno(
    [
        fuzzy.Variable("p", (-1, 3), {"low": fuzzy.Gaussian(1.2, -0.5), "high": fuzzy.Gaussian(1.0, 2.5)}),
        fuzzy.Variable("q", (10, 30), {"low": fuzzy.Bell(6, 2, 12), "high": fuzzy.Bell(7, 3, 27)}),
    ],
    [
        fuzzy.Variable(
            "v", (0, 4), {"a": Linear((1.0, -0.1), 0.5), "b": Linear((0.3, 0.2), -1), "idle": Linear((7, 8), 9)}
        ),
        fuzzy.Variable("w", (-2, 6), {"c": Constant(1.5), "d": Linear((-0.5, 0.05), 0.25)}),
    ],
    [
        "if p is low and q is low then v is a, w is c",
        "if p is low and q is high then v is b",
        "if p is high and q is low then v is a, w is d with 0.5",
        "if p is high and q is high then v is b, w is d",
    ],
    name="shared",
)
X = RNG.uniform([-1, 10], [3, 30], (60, 2))


def network_of(fis: fuzzy.Sugeno, ridge: float = 0.0, block: int = 1000) -> Network:
    return Network(
        premises(fis, dtype=torch.float64, device="cpu"), groups(fis, torch.float64, "cpu"), ridge=ridge, block=block
    )


def sums(a: np.ndarray, y: np.ndarray) -> NormalEquations:
    return equations(torch.tensor(a), torch.tensor(y))


def test_full_rank_is_numpys_answer():
    a, y = RNG.normal(size=(50, 7)), RNG.normal(size=(50, 2))
    values, rank = solve(sums(a, y))
    assert rank == 7
    np.testing.assert_allclose(values, np.linalg.lstsq(a, y, rcond=None)[0], atol=1e-12)


@pytest.mark.parametrize("samples_", [50, 5])
def test_a_low_rank_gives_the_minimum_norm_and_says_so(samples_):
    a = RNG.normal(size=(samples_, 4)) @ RNG.normal(size=(4, 9))
    y = RNG.normal(size=(samples_, 1))
    values, rank = solve(sums(a, y))
    expected, _, expected_rank, _ = np.linalg.lstsq(a, y, rcond=1e-10)
    assert rank == expected_rank == 4
    np.testing.assert_allclose(values, expected, atol=1e-9)


def test_more_parameters_than_samples_pass_through_them():
    a, y = RNG.normal(size=(4, 9)), RNG.normal(size=(4, 1))
    values, rank = solve(sums(a, y))
    assert rank == 4
    np.testing.assert_allclose(a @ values.numpy(), y, atol=1e-9)
    np.testing.assert_allclose(values, np.linalg.lstsq(a, y, rcond=None)[0], atol=1e-9)


def wide(fis: fuzzy.Sugeno) -> fuzzy.Sugeno:
    """The same in universes wider than the samples' ranges, where units of one are not those of the other."""
    low, high = np.array([v.universe for v in fis.inputs]).T
    ends = zip(low - 3, high + 7, strict=True)
    return replace(fis, inputs=[replace(v, universe=e) for v, e in zip(fis.inputs, ends, strict=True)])


GRID = fuzzy.identify(X, X[:, 0], "grid", fit=False)
TRIANGLES = fuzzy.identify(X[:30] / 2, X[:30, 0], "grid", kind="trimf", mfs=3, fit=False)  # not all samples fire


@pytest.mark.parametrize("batch", [0, 7])
@pytest.mark.parametrize("ridge", [1e-4, 0.3])
@pytest.mark.parametrize(
    "fis",
    [
        GRID,
        wide(GRID),
        replace(wide(GRID), defuzzification="wtsum"),
        replace(GRID, out_of_range="clip"),
        TRIANGLES,
        replace(TRIANGLES, defuzzification="wtsum"),
        wide(FIS),
    ],
    ids=["grid", "wide", "wide-wtsum", "clip", "silent", "silent-wtsum", "shared"],
)
def test_ridge_means_what_it_means_in_identification(fis, ridge, batch):
    """Against :func:`fuzzy.fit_consequents`, whose test has the normal equations by hand."""
    x = X * [1.5, 1.1]
    y = np.stack([np.sin(X[:, 0]) + 5, X[:, 1] ** 2 / 50], axis=1)[:, : len(fis.outputs)]
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        expected = fuzzy.fit_consequents(fis, x, y, ridge)
        options = anfis.Options(method="least-squares", ridge=ridge, batch=batch)
        found = anfis.train(fis, x, y, options).system
        free = fuzzy.fit_consequents(fis, x, y)
    for output, same, other in zip(found.outputs, expected.outputs, free.outputs, strict=True):
        for name, term in output.terms.items():
            np.testing.assert_allclose(term.parameters, same.terms[name].parameters, rtol=1e-6, atol=1e-7)
        assert any(t.parameters != pytest.approx(other.terms[n].parameters, rel=1e-4) for n, t in output.terms.items())


def test_a_ridge_does_not_depend_on_units():
    y = np.sin(X[:, 0]) + 0.002 * X[:, 1] ** 2
    made, other = GRID, fuzzy.identify(X * 1000 - 7, y * 5 + 100, "grid", fit=False)
    options = anfis.Options(epochs=3, ridge=1e-3)
    found = anfis.train(made, X, y, options).system
    moved = anfis.train(other, X * 1000 - 7, y * 5 + 100, options).system
    np.testing.assert_allclose(moved(X * 1000 - 7), found(X) * 5 + 100, rtol=1e-9)


def test_nothing_to_solve_and_too_much():
    assert solve(sums(np.zeros((3, 0)), np.ones((3, 2)))).values.shape == (0, 2)
    values, rank = solve(sums(np.zeros((3, 2)), np.ones((3, 1))))
    assert rank == 0
    assert not values.any()
    with pytest.raises(DataError, match="overflow"):
        solve(sums(np.full((3, 2), 1e200), np.ones((3, 1))))


@pytest.mark.parametrize("defuzzification", ["wtaver", "wtsum"])
def test_the_network_is_the_system(defuzzification):
    fis = replace(FIS, defuzzification=defuzzification)
    network = network_of(fis)
    start = network.start()
    output = network.output(start.free, start.values, network.premises.scale(torch.tensor(X)))
    np.testing.assert_allclose(output, fis(X), rtol=1e-12, atol=1e-12)


def test_consequents_survive_the_scaling():
    network = network_of(FIS)
    p = network.premises
    low, span = numbers(p.low), numbers(p.span)
    back = consequent_terms(FIS, present_values(FIS, low, span), low, span)
    for output, terms in zip(FIS.outputs, back, strict=True):
        for before, after in zip(output.terms.values(), terms, strict=True):
            assert type(before) is type(after)
            np.testing.assert_allclose(before.parameters, after.parameters, rtol=1e-12)


@pytest.mark.parametrize("defuzzification", ["wtaver", "wtsum"])
def test_shared_terms_and_rules_that_leave_an_output_out(defuzzification):
    """Against a design matrix built from the inference, in the inputs' own units."""
    fis = replace(FIS, defuzzification=defuzzification)
    y = np.stack([np.sin(X[:, 0]) + 0.1 * X[:, 1], X[:, 0] * X[:, 1] / 20], axis=1)
    network = network_of(fis)
    data = samples(fis, X, y, "training").to(torch.float64, "cpu")
    start = network.start()
    fit = network.fit(start.free, data)
    answer = network.system(Point(start.free, [s.values for s in fit.solutions]))(X)
    layers = infer(fis, X)
    x1 = np.column_stack([X, np.ones(len(X))])
    for j, output in enumerate(fis.outputs):
        consequent = fis.structure.consequent[j]
        share = layers.firing if defuzzification == "wtsum" else layers.weights
        share = share * (consequent >= 0)
        if defuzzification == "wtaver":
            share = share / share.sum(axis=1, keepdims=True)
        columns = []
        for t, term in enumerate(output.terms.values()):
            w = share[:, consequent == t].sum(axis=1)[:, None]
            columns.append(w * (x1 if isinstance(term, Linear) else x1[:, -1:]))
        design = np.concatenate(columns, axis=1)
        np.testing.assert_allclose(
            answer[:, j], design @ np.linalg.lstsq(design, y[:, j], rcond=None)[0], rtol=1e-8, atol=1e-8
        )


def test_a_term_that_no_rule_proposes_stays_as_it_is():
    network = network_of(FIS)
    data = samples(FIS, X, X, "training").to(torch.float64, "cpu")
    start = network.start()
    fit = network.fit(start.free, data)
    assert [s.rank for s in fit.solutions] == [6, 4]
    assert network.count == 10 + 6 + 4
    system = network.system(Point(start.free, [s.values for s in fit.solutions]))
    assert system["v"].terms["idle"] == FIS["v"].terms["idle"]


@pytest.mark.parametrize("ridge", [0.0, 0.1])
@pytest.mark.parametrize("defuzzification", ["wtaver", "wtsum"])
def test_an_output_without_any_rule_stays_as_it_is(defuzzification, ridge):
    rules = [replace(rule, then=(("v", dict(rule.then)["v"]),)) for rule in FIS.rules]
    fis = replace(FIS, rules=rules, defuzzification=defuzzification)
    network = network_of(fis, ridge)
    data = samples(fis, X, X, "training").to(torch.float64, "cpu")
    start = network.start()
    fit = network.fit(start.free, data, gradient=True)
    system = network.system(Point(start.free, [s.values for s in fit.solutions]))
    assert system["w"] == fis["w"]
    assert np.isfinite(fit.rmse)
    reduced = network.reduced(Point(start.free, [s.values for s in fit.solutions]), data)
    assert all(torch.isfinite(part).all() for part in reduced)


@pytest.mark.parametrize("normalise", [True, False])
def test_the_gradient_to_the_weights_is_torchs(normalise):
    """Shared terms, constants, rules that leave an output out; also where no rule of an output fires."""
    random = torch.Generator().manual_seed(2)
    weights = torch.rand(9, 4, dtype=torch.float64, generator=random)
    weights[3] = 0.0
    weights[5, [0, 2, 3]] = 0.0  # only the second rule, which says nothing of w
    weights.requires_grad_()
    x1 = torch.cat([torch.rand(9, 2, dtype=torch.float64, generator=random), torch.ones(9, 1)], dim=1)
    own = replace(FIS, rules=[replace(r, then=(("v", "a"),)) for r in FIS.rules[:1]] + list(FIS.rules[1:2]))
    for fis, used in ((FIS, weights), (own, weights[:, :2])):
        for group in groups(fis, torch.float64, "cpu"):
            error = torch.rand(9, len(group.outputs), dtype=torch.float64, generator=random)
            values = torch.rand(len(group.columns), len(group.outputs), dtype=torch.float64, generator=random)
            output = design(group, used, x1, normalise) @ values
            (expected,) = torch.autograd.grad((error * output).sum(), used)
            found = weights_gradient(group, used.detach(), x1, values, error, normalise)
            torch.testing.assert_close(found, expected, rtol=1e-12, atol=1e-12)


@pytest.mark.parametrize("block", [1000, 7])
@pytest.mark.parametrize("ridge", [0.0, 1e-3])
def test_the_reduced_jacobian_leaves_out_what_the_consequents_make_up_for(ridge, block):
    """Against numpy with the ridge as rows of its own, and the Jacobian by differences."""

    def theta(group, values):
        """The consequents for inputs scaled to [−1, 1]: a line's value in the middle, and what it gains to the ends."""
        full = np.zeros(group.share.shape[1] * 3)
        full[group.columns] = values
        lines = full.reshape(-1, 3)
        middle, half = (u.max(dim=0).values + u.min(dim=0).values) / 2, (u.max(dim=0).values - u.min(dim=0).values) / 2
        points = np.array([np.append(p, 1.0) for p in (middle, *(middle + torch.diag(half)))])
        at = lines @ points.T
        return np.column_stack([at[:, 1:] - at[:, :1], at[:, 0]]).ravel()[group.columns]

    y = np.stack([np.sin(X[:, 0]), X[:, 1] / 10], axis=1)
    data = samples(FIS, X, y, "training").to(torch.float64, "cpu")
    network = network_of(FIS, ridge, block)
    free = network.start().free
    values = [s.values for s in network.fit(free, data).solutions]
    u = network.premises.scale(torch.tensor(X))
    flat, h = torch.cat([p.flatten() for p in free]), 1e-6
    columns = [
        (
            network.output(network.unflatten(flat + e), values, u)
            - network.output(network.unflatten(flat - e), values, u)
        )
        / (2 * h)
        for e in h * torch.eye(len(flat), dtype=torch.float64)
    ]
    jacobian = torch.stack(columns, dim=2).numpy()  # (samples, outputs, premises)
    residual = y - network.output(free, values, u).numpy()
    matrices, _ = network.designs(free, u)
    jtj, jtr = np.zeros((len(flat), len(flat))), np.zeros(len(flat))
    for group, matrix, c in zip(network.groups, matrices, values, strict=True):
        a = matrix.numpy()
        root = np.sqrt(ridge * len(X))
        change = np.column_stack([theta(group, e) for e in np.eye(a.shape[1])])
        constants = (group.columns % 3 == 2).numpy()
        below = np.concatenate([a, root * change])
        for k, o in enumerate(group.outputs):
            j = np.concatenate([jacobian[:, o], np.zeros((a.shape[1], len(flat)))])
            own = j - below @ np.linalg.lstsq(below, j, rcond=None)[0]
            jtj += own.T @ own
            left = constants * y[:, o].mean() - theta(group, c[:, k].numpy())
            jtr += own.T @ np.concatenate([residual[:, o], root * left])
    found = network.reduced(Point(free, values), data)
    np.testing.assert_allclose(found[0], jtj, atol=1e-6 * np.abs(jtj).max())
    np.testing.assert_allclose(found[1], jtr, atol=1e-6 * np.abs(jtr).max())


def test_blocks_are_one_block():
    y = np.stack([np.sin(X[:, 0]), X[:, 1] / 10], axis=1)
    data = samples(FIS, X, y, "training").to(torch.float64, "cpu")
    whole, parts = network_of(FIS), network_of(FIS, block=7)
    a = whole.fit(whole.start().free, data, gradient=True)
    b = parts.fit(parts.start().free, data, gradient=True)
    assert a.rmse == pytest.approx(b.rmse, rel=1e-10)
    ours, theirs = ([*f.gradient, *(s.values for s in f.solutions)] for f in (a, b))
    for p, q in zip(ours, theirs, strict=True):
        torch.testing.assert_close(p, q, rtol=1e-8, atol=1e-8)
    point = Point(whole.start().free, [s.values for s in a.solutions])
    for p, q in zip(whole.reduced(point, data), parts.reduced(point, data), strict=True):
        torch.testing.assert_close(p, q, rtol=1e-8, atol=1e-8)


def test_recursive_least_squares_is_the_batch():
    a, y = RNG.normal(size=(80, 6)), RNG.normal(size=(80, 2))
    state = recursive_start(torch.zeros(6, 2, dtype=torch.float64), confidence=1e-8)
    for row, target in zip(torch.tensor(a), torch.tensor(y), strict=True):
        state = recursive_step(state, row, target)
    np.testing.assert_allclose(state.values, np.linalg.lstsq(a, y, rcond=None)[0], atol=1e-7)


def test_recursive_least_squares_forgets():
    """With forgetting λ the answer is the batch with weights λ^age."""
    a, y, forgetting = RNG.normal(size=(60, 3)), RNG.normal(size=(60, 1)), 0.9
    state = recursive_start(torch.zeros(3, 1, dtype=torch.float64), confidence=1e-8)
    for row, target in zip(torch.tensor(a), torch.tensor(y), strict=True):
        state = recursive_step(state, row, target, forgetting)
    root = forgetting ** (np.arange(59, -1, -1)[:, None] / 2)
    np.testing.assert_allclose(state.values, np.linalg.lstsq(root * a, root * y, rcond=None)[0], atol=1e-8)
