"""Compiled learning against torch: forward, least squares, gradients, Jacobian; and that threads change no bit."""

import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
import torch
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from threadpoolctl import ThreadpoolController

import anfis
import fuzzy
from anfis import Options
from anfis import network as in_torch
from anfis.compiled import network as compiled
from anfis.compiled import threads
from anfis.compiled.derivatives import log_positive
from anfis.compiled.least_squares import Equations, eliminated, solve
from anfis.data import samples
from anfis.point import Point, numbers
from fuzzy import membership as mf
from fuzzy.compiled.jit import kernel
from fuzzy.system import Sugeno
from tests.anfis.training_problem import CHECK, FIS, X, Y, grid
from tests.fuzzy.random_systems import functions, systems
from tests.randomcases import cases

torch.set_num_threads(1)
ROOT = Path(__file__).parents[3]


def both(fis: Sugeno, ridge: float = 0.0, block: int = 1000):
    """The network of ``fis`` in compiled code, and in torch."""
    return (
        compiled.make_network(fis, False, ridge, block),
        in_torch.make_network(fis, "float64", "cpu", False, ridge, block),
    )


def tensors(point: Point) -> Point:
    return Point(tuple(map(torch.tensor, point.free)), [torch.tensor(v) for v in point.values])


def problem(fis: Sugeno, seed: int, count: int = 30):
    random = np.random.default_rng(seed)
    x = random.uniform(-3, 4, (count, len(fis.inputs)))  # of no round numbers: on no joint
    y = random.normal(size=(count, len(fis.outputs)))
    return samples(fis, x, y, "training")


def errors_and_slopes(fis: Sugeno, seed: int):
    """Squared errors and their gradient to the free premises with given consequents: compiled, and torch's autograd."""
    own, other = both(fis)
    data = problem(fis, seed)
    start = own.start()
    random = np.random.default_rng(seed)
    values = [random.normal(size=v.shape) for v in start.values]
    natural, parameters = own._at(start.free)
    squares, slopes, _ = own._errors(parameters, values, data, True)
    free = [torch.tensor(p).requires_grad_() for p in start.free]
    x, y = data.to(torch.float64, "cpu").rows(slice(None))
    error = other.output(free, [torch.tensor(v) for v in values], other.premises.scale(x)) - y
    found = torch.autograd.grad(error.square().sum(), free, allow_unused=True)
    expected = [torch.zeros_like(p) if g is None else g for p, g in zip(free, found, strict=True)]
    return squares, own._by_kind(natural, slopes), float(error.detach().square().sum()), expected


@pytest.mark.parametrize("kind", mf.FUNCTIONS)
@settings(max_examples=8)
@given(data=st.data(), seed=st.integers(0, 10_000))
def test_the_gradient_is_torchs_for_every_function(kind, data, seed):
    terms = [data.draw(functions((kind,))) for _ in range(2)]
    method = data.draw(st.sampled_from(["prod", "min"]))
    fis = fuzzy.Sugeno(
        [fuzzy.Variable("x", (-3, 4), dict(zip("ab", terms, strict=True))), FIS.inputs[0]],
        [fuzzy.Variable("y", (-5, 6), {"c": 1.0, "d": -2.0})],
        ["if x is a and input1 is in1mf1 then y is c", "if x is b and input1 is in1mf2 then y is d"],
        and_method=method,
    )
    squares, slopes, expected, by_torch = errors_and_slopes(fis, seed)
    assert squares == pytest.approx(expected, rel=1e-10)
    largest = max(float(g.abs().max()) for g in by_torch)
    for own, other in zip(slopes, by_torch, strict=True):
        np.testing.assert_allclose(own, other, rtol=1e-9, atol=1e-9 * max(largest, 1.0))


@settings(max_examples=cases(60))
@given(fis=systems(), seed=st.integers(0, 10_000))
def test_the_gradient_is_torchs_for_every_rule(fis, seed):
    """Hedges, "not", "or", weights, minimum, rules that leave an output out, weighted sums."""
    squares, slopes, expected, by_torch = errors_and_slopes(fis, seed)
    assume(np.isfinite(expected) and all(bool(torch.isfinite(g).all()) for g in by_torch))
    largest = max(float(g.abs().max()) for g in by_torch)
    # A sum of degrees that are small differences (1 − μ) has few true digits, and its quotients fewer.
    assume(largest < 1e6)
    assert squares == pytest.approx(expected, rel=1e-6, abs=1e-9)
    for own, other in zip(slopes, by_torch, strict=True):
        np.testing.assert_allclose(own, other, rtol=1e-5, atol=1e-6 * max(largest, 1.0))


@settings(max_examples=25)
@given(fis=systems(), seed=st.integers(0, 10_000), ridge=st.sampled_from([0.0, 0.1]), block=st.sampled_from([7, 1000]))
def test_the_jacobian_is_torchs(fis, seed, ridge, block):
    own, other = both(fis, ridge, block)
    data = problem(fis, seed)
    point = Point(own.start().free, [np.random.default_rng(seed).normal(size=v.shape) for v in own.start().values])
    free, values = tensors(point)
    found = own.reduced(point, data)
    expected = other.reduced(Point(free, values), data.to(torch.float64, "cpu"))
    scale = [float(part.abs().max()) for part in expected]
    assume(all(np.isfinite(scale)) and max(scale) < 1e6)
    # What the consequents make up for is a difference of large numbers where they are hardly determined.
    for part, same, size in zip(found, expected, scale, strict=True):
        np.testing.assert_allclose(part, same, rtol=1e-4, atol=1e-4 * max(size, 1.0))


@pytest.mark.parametrize("kind", ["gbellmf", "gaussmf", "trimf", "pimf", "dsigmf"])
def test_a_training_is_torchs_along_its_whole_way(kind):
    """At every point that torch comes to, the same error, rank and gradient are found. (Left alone the two part.

    A step has a given length, whatever the gradient: in a narrow valley it crosses from side to side, and a last digit
    grows as torch's own last digits do, in blocks of another size.)
    """
    # With straight edges linear consequents are not determined, and what is left over has no true digits.
    fis = grid(X, kind, order=1 if kind.startswith("g") else 0)
    own, other = both(fis)
    data = samples(fis, X, Y, "training")
    free = own.start().free
    for _ in range(30):
        found = own.fit(free, data, gradient=True)
        expected = other.fit(tuple(map(torch.tensor, free)), data.to(torch.float64, "cpu"), gradient=True)
        assert found.rmse == pytest.approx(expected.rmse, rel=1e-9)
        assert [s.rank for s in found.solutions] == [s.rank for s in expected.solutions]
        norm = float(sum((g * g).sum() for g in found.gradient)) ** 0.5
        for ours, theirs in zip(found.gradient, expected.gradient, strict=True):
            np.testing.assert_allclose(ours, theirs, atol=1e-7 * norm)
        free = own.premises.valid([p - 0.02 * numbers(g) / norm for p, g in zip(free, expected.gradient, strict=True)])


@pytest.mark.parametrize("method", ["hybrid", "second-order"])
def test_the_number_of_threads_changes_no_bit(method, monkeypatch):
    random = np.random.default_rng(3)
    x = random.uniform(size=(7000, 2))  # four blocks
    y = np.sin(5 * x[:, 0]) * x[:, 1]
    fis = grid(x, "gbellmf")
    found = []
    for count in (1, 2, 5):
        monkeypatch.setattr(threads, "count", lambda count=count: count)
        found.append(anfis.train(fis, x, y, Options(epochs=3, method=method), check=(x[:3000], y[:3000])))
    assert found[0].history == found[1].history == found[2].history
    assert found[0].system == found[1].system == found[2].system


def test_a_sample_counts_alike_in_every_place():
    """Chunks that are not full, blocks, portions: the sums are those of all samples."""
    own, _ = both(FIS)
    point = own.start()
    whole = own.rmse(point, samples(FIS, X, Y, "training")) ** 2 * len(X)
    alone = [own.rmse(point, samples(FIS, X[k : k + 1], Y[k : k + 1], "checking")) ** 2 for k in range(len(X))]
    assert whole == pytest.approx(sum(alone), rel=1e-12)
    small = compiled.make_network(FIS, False, 0.0, 13)
    a, b = (n.fit(point.free, samples(FIS, X, Y, "training"), gradient=True) for n in (own, small))
    assert a.rmse == pytest.approx(b.rmse, rel=1e-12)


def test_linear_algebra_gets_its_threads_back():
    """When the last of several trainings leaves, in whatever order they do."""
    learning = ThreadpoolController()

    def counts():
        return {library["num_threads"] for library in learning.info() if library["user_api"] == "blas"}

    with learning.limit(limits=2, user_api="blas"):
        before = counts()
        assert 2 in before  # a solver's own library, which another test may have loaded, never has more than one
        first, second = threads.one_for_linear_algebra(), threads.one_for_linear_algebra()
        first.__enter__()
        second.__enter__()
        assert counts() == {1}
        first.__exit__(None, None, None)
        assert counts() == {1}
        second.__exit__(None, None, None)
        assert counts() == before


# Least squares --------------------------------------------------------------------------------------------------------


def designed(condition: float, rows: int = 200, columns: int = 12, rank: int = 12):
    """A design matrix (rows, columns) of that condition, and targets."""
    random = np.random.default_rng(8)
    u, _ = np.linalg.qr(random.normal(size=(rows, columns)))
    v, _ = np.linalg.qr(random.normal(size=(columns, columns)))
    s = np.geomspace(1, 1 / condition, columns) * (np.arange(columns) < rank)
    return (u * s) @ v.T, random.normal(size=(rows, 2))


@pytest.mark.parametrize(("condition", "rank"), [(10, 12), (1e4, 12), (1e6, 12), (1e10, 12), (1e3, 9)])
def test_least_squares_are_numpys_however_well_they_are_determined(condition, rank):
    """Cholesky, its solution refined, singular values."""
    a, y = designed(condition, rank=rank)
    found = solve(Equations(a.T @ a, a.T @ y), lambda: (np.ascontiguousarray(a.T), y))
    expected, _, expected_rank, _ = np.linalg.lstsq(a, y, rcond=None)
    assert found.rank == expected_rank == rank
    np.testing.assert_allclose(found.values, expected, atol=1e-14 * condition**1.1 * np.abs(expected).max())
    np.testing.assert_allclose(a @ found.values, a @ expected, atol=1e-14 * condition)


@pytest.mark.parametrize("condition", [10, 1e5, 1e10])
def test_what_consequents_make_up_for_is_taken_out(condition):
    a, _ = designed(condition)
    b = np.random.default_rng(1).normal(size=(200, 3))
    q, _ = np.linalg.qr(a)
    own = b - q @ (q.T @ b)
    np.testing.assert_allclose(
        eliminated(np.concatenate([a, b], axis=1).T, 12), own.T @ own, atol=1e-14 * (condition + 1e3)
    )


def test_the_logarithm():
    logs = kernel(lambda v: log_positive(v))
    values = np.concatenate([np.geomspace(1e-300, 1e300, 4001), np.linspace(0.5, 2, 4001)])
    expected = np.log(values)
    found = np.array([logs(v) for v in values])
    assert (np.abs(found - expected) <= 2 * np.spacing(np.abs(expected))).all()


# What is loaded -------------------------------------------------------------------------------------------------------


def test_hybrid_learning_does_without_torch(tmp_path):
    """From the table to the file, on the command line too."""
    table = tmp_path / "data.csv"
    np.savetxt(table, np.column_stack([X, Y]), delimiter=",", header="a,b,y", comments="")
    code = (
        "import sys; from anfis.commands.application import main; "
        f"code = main(['train', {str(table)!r}, '--grid', '2', '-q', '-o', {str(tmp_path / 'n.fis')!r}]); "
        "print(code, 'torch' in sys.modules)"
    )
    done = subprocess.run(
        [sys.executable, "-c", code], cwd=ROOT, env={**os.environ}, capture_output=True, text=True, check=True
    )
    assert done.stdout.splitlines()[-1] == "0 False"


def test_single_precision_and_own_functions_learn_in_torch():
    for options in (Options(epochs=1, dtype="float32"), Options(epochs=1, method="backprop")):
        state = anfis.train(FIS, X, Y, options, check=CHECK).state
        assert isinstance(state["point"]["free"][0], torch.Tensor)
    assert isinstance(anfis.train(FIS, X, Y, Options(epochs=1)).state["point"]["free"][0], np.ndarray)
