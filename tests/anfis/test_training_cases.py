"""What training must take: data and systems of every form; and Mackey-Glass, where the answer is known."""

import warnings
from dataclasses import replace
from itertools import product
from pathlib import Path

import numpy as np
import pytest
import torch

import anfis
import fuzzy
from anfis import DataError, DataWarning, Options, TrainingError
from fuzzy.files.fisfile import format_fis
from fuzzy.system import Linear
from tests.anfis.training_problem import CHECK, FIS, RNG, TRAINED, X, Y, grid, rmse
from tests.conftest import module_in

torch.set_num_threads(1)


# Data ---------------------------------------------------------------------------------------------------------------


def test_a_value_that_is_no_number_is_named():
    x = X.copy()
    x[6, 1] = np.nan
    with pytest.raises(DataError, match=r"training data: row 7, column 'input2' is nan"):
        anfis.train(FIS, x, Y)
    y = CHECK[1].copy()
    y[2] = np.inf
    with pytest.raises(DataError, match=r"checking data: row 3, column 'output1' is inf"):
        anfis.train(FIS, X, Y, check=(CHECK[0], y))


@pytest.mark.parametrize(
    ("x", "y", "message"),
    [
        (X[:, :1], Y, r"must be \(samples, 2\): input1, input2; got shape \(80, 1\)"),
        (X[0], Y, r"got shape \(2,\)"),
        (X, np.stack([Y, Y], 1), r"outputs must be \(samples, 1\): output1; got shape \(80, 2\)"),
        (X, Y[:-1], "80 rows of inputs but 79 of outputs"),
        (X[:0], Y[:0], "are empty"),
        ([["a", "b"]], [1], "must be a table of real numbers"),
        (X + 1j, Y, "must be a table of real numbers"),
        (X, Y * 1e200, "magnitudes"),
    ],
)
def test_data_that_do_not_fit(x, y, message):
    with pytest.raises(DataError, match=message):
        anfis.train(FIS, x, y)


def test_an_input_that_the_system_refuses():
    with pytest.raises(DataError, match=r"row 1, column 'input1' is 99, outside \[.*\], and .* refuses that"):
        anfis.train(replace(FIS, out_of_range="error"), np.r_[[[99.0, 20.0]], X], np.r_[0.0, Y])


def test_a_constant_column_is_said():
    x = X.copy()
    x[:, 1] = 20.0
    with pytest.warns(DataWarning, match="input 'input2' is constant, 20"):
        result = anfis.train(FIS, x, Y, Options(epochs=3))
    assert np.isfinite([row.train for row in result.history]).all()


def test_more_parameters_than_samples_are_said():
    with pytest.warns(DataWarning, match="6 samples for 12 parameters"):
        result = anfis.train(FIS, X[:6], Y[:6], Options(epochs=3))
    assert result.history[0].rank == 6
    assert rmse(result.system, X[:6], Y[:6]) < 1e-6


def test_as_many_parameters_as_samples_are_said():
    with pytest.warns(DataWarning, match="12 samples for 12 parameters of the consequents: they are learnt by heart"):
        anfis.train(FIS, X[:12], Y[:12], Options(epochs=1))
    anfis.train(FIS, X[:13], Y[:13], Options(epochs=1))


def test_every_layout_of_an_array_is_taken():
    expected = format_fis(anfis.train(FIS, X, Y, Options(epochs=2)).system)
    frozen = X.copy()
    frozen.flags.writeable = False
    for x in (frozen, np.asfortranarray(X), X[::-1][::-1], X.tolist(), torch.tensor(X)):
        assert format_fis(anfis.train(FIS, x, Y, Options(epochs=2)).system) == expected


def test_data_on_disk(tmp_path):
    np.save(tmp_path / "x.npy", X)
    np.save(tmp_path / "y.npy", Y)
    x, y = (np.load(tmp_path / f"{name}.npy", mmap_mode="r") for name in "xy")
    for options in ({"batch": 32}, {"method": "backprop", "batch": 32}):
        disk, memory = (anfis.train(FIS, a, b, Options(epochs=3, **options)) for a, b in ((x, y), (X, Y)))
        assert format_fis(disk.system) == format_fis(memory.system)


def test_parameters_in_training_elsewhere():
    term = FIS["input1"].terms["in1mf1"]
    free = fuzzy.Gaussian(*(torch.tensor(p, dtype=torch.float64, requires_grad=True) for p in term.parameters))
    inputs = [replace(FIS.inputs[0], terms={**FIS.inputs[0].terms, "in1mf1": free}), FIS.inputs[1]]
    result = anfis.train(replace(FIS, inputs=inputs), X, Y, Options(epochs=2))
    assert result.system == anfis.train(FIS, X, Y, Options(epochs=2)).system


# Systems ------------------------------------------------------------------------------------------------------------


def three_triangles() -> fuzzy.Sugeno:
    """No rule fires above 2."""
    terms = {f"t{k}": fuzzy.Triangle(k - 1, k, k + 1) for k in range(2)}
    output = fuzzy.Variable("y", (-4, 10), {f"c{k}": Linear((0.0,), 0.0) for k in range(2)})
    return fuzzy.Sugeno(
        [fuzzy.Variable("x", (0, 4), terms)], [output], [f"if x is t{k} then y is c{k}" for k in range(2)]
    )


@pytest.mark.parametrize("method", [*TRAINED, "least-squares"])
@pytest.mark.parametrize("defuzzification", ["wtaver", "wtsum"])
def test_where_no_rule_fires_the_middle_stands_and_counts(method, defuzzification):
    fis = replace(three_triangles(), defuzzification=defuzzification)
    x = np.linspace(0.1, 3.9, 39)[:, None]
    y = np.cos(x[:, 0])
    with pytest.warns(DataWarning, match="no rule fires at 20 of 39 training samples"):
        result = anfis.train(fis, x, y, Options(method=method, epochs=4, step=0.002))
    assert np.isfinite([row.train for row in result.history]).all()
    assert rmse(result.system, x, y) == pytest.approx(min(row.train for row in result.history), rel=1e-6)


def test_no_rule_fires_anywhere():
    x = np.linspace(3, 4, 9)[:, None]
    with pytest.warns(DataWarning, match="no rule fires at 9 of 9"):
        result = anfis.train(three_triangles(), x, x[:, 0], Options(epochs=3))
    assert result.stopped == "converged"
    assert result.history[0].rank == 0


@pytest.mark.parametrize("method", TRAINED)
def test_a_gradient_step_does_not_depend_on_the_units(method):
    """Inputs in units of their own and the same inputs on [0, 1] are learnt alike."""
    low, span = np.array([100.0, -2e4]), np.array([250.0, 9e4])
    unit = np.random.default_rng(2).uniform(size=(60, 2))
    unit[:2] = [[0, 0], [1, 1]]
    y = np.sin(4 * unit[:, 0]) + unit[:, 1] ** 2
    options = Options(method=method, epochs=20, rate=0.02)
    plain, own = (anfis.train(grid(x), x, y, options) for x in (unit, low + span * unit))
    assert [r.train for r in own.history] == pytest.approx([r.train for r in plain.history], rel=1e-6)
    assert own.history[-1].train < 0.9 * own.history[0].train


@pytest.mark.parametrize("method", TRAINED)
def test_many_inputs_do_not_underflow(method):
    x = np.random.default_rng(1).normal(size=(200, 30))
    y = np.tanh(x[:, 0]) + 0.1 * x[:, 1]
    fis = fuzzy.Sugeno(
        [
            fuzzy.Variable(f"x{i}", (-4, 4), {f"t{k}": fuzzy.Gaussian(0.05, c) for k, c in enumerate((-1, 0, 1))})
            for i in range(30)
        ],
        [fuzzy.Variable("y", (-1, 1), {f"c{k}": Linear((0.0,) * 30, 0.0) for k in range(3)})],
        [fuzzy.Rule(tuple(fuzzy.Clause(f"x{i}", f"t{k}") for i in range(30)), (("y", f"c{k}"),)) for k in range(3)],
        out_of_range="ignore",
    )
    assert (fuzzy.infer(fis, x).firing == 0).any()  # the products themselves do underflow
    result = anfis.train(fis, x, y, Options(method=method, epochs=2))
    assert np.isfinite([row.train for row in result.history]).all()
    assert rmse(result.system, x, y) == pytest.approx(min(r.train for r in result.history), rel=1e-5)


@pytest.mark.parametrize("step", [5.0, 1e6])
@pytest.mark.parametrize("kind", ["gaussmf", "gbellmf", "trimf", "psigmf"])
def test_a_huge_step_does_no_harm(kind, step):
    fis = grid(X, kind)
    result = anfis.train(fis, X, Y, Options(epochs=6, step=step))
    # A term a million universes wide says with ten digits where a sample in one lies.
    assert rmse(result.system, X, Y) <= result.history[0].train * (1 + (1e-9 if step < 1e3 else 1e-6))


def test_keep_order_in_training():
    x = np.sort(RNG.uniform(0, 10, 120))[:, None]
    y = np.sign(np.sin(3 * x[:, 0]))
    fis = grid(x, "gbellmf", mfs=5)
    result = anfis.train(fis, x, y, Options(epochs=30, step=0.2, keep_order=True))
    terms = list(result.system.inputs[0].terms.values())
    centers = [term.c for term in terms]
    assert centers == sorted(centers)
    assert result.history[result.best].train < result.history[0].train
    places = np.linspace(centers[0], centers[-1], 1000)
    assert np.max([term(places) for term in terms], axis=0).min() > 0.0999


@pytest.mark.parametrize("defuzzification", ["wtaver", "wtsum"])
@pytest.mark.parametrize("method", TRAINED)
def test_outputs_shared_terms_left_out_rules_and_constants(method, defuzzification):
    fis = fuzzy.Sugeno(
        FIS.inputs,
        [
            fuzzy.Variable("v", (-1, 3), {"a": Linear((0.0, 0.0), 0.5), "b": Linear((0.0, 0.0), 0.0)}),
            fuzzy.Variable("w", (-1, 3), {"c": 1.0, "d": Linear((0.0, 0.0), 0.0)}),
        ],
        [
            "if input1 is in1mf1 and input2 is in2mf1 then v is a, w is c",
            "if input1 is in1mf1 and input2 is in2mf2 then v is b",
            "if input1 is in1mf2 and input2 is in2mf1 then v is a, w is d with 0.5",
            "if input1 is in1mf2 or input2 is not in2mf1 then w is c",
            "if input2 is somewhat in2mf2 then v is b",
        ],
        defuzzification=defuzzification,
        out_of_range="ignore",
    )
    y = np.stack([Y, np.cos(X[:, 0])], axis=1)
    result = anfis.train(fis, X, y, Options(method=method, epochs=6), check=(X[:10], y[:10]))
    assert result.system.rules == fis.rules
    assert rmse(result.least_train, X, y) == pytest.approx(min(r.train for r in result.history), rel=1e-6)
    assert min(r.train for r in result.history) < result.history[0].train


def test_constants_only():
    fis = grid(X, order=0)
    result = anfis.train(fis, X, Y, Options(epochs=10, step=0.05))
    assert result.history[0].rank == 4
    assert rmse(result.system, X, Y) < result.history[0].train


@pytest.mark.parametrize("kind", ["pimf", "gaussmf"])
def test_single_precision(kind):
    fis = grid(X, kind)
    double = anfis.train(fis, X, Y, Options(epochs=10))
    single = anfis.train(fis, X, Y, Options(epochs=10, dtype="float32"))
    assert rmse(single.system, X, Y) == pytest.approx(rmse(double.system, X, Y), rel=0.02)


def test_blocks_are_one_block():
    whole, parts = (anfis.train(FIS, X, Y, Options(epochs=10, batch=b), check=CHECK) for b in (0, 64))
    for a, b in zip(whole.history, parts.history, strict=True):
        assert a == pytest.approx(b, rel=1e-10)
    whole, parts = (anfis.train(FIS, X, Y, Options(method="second-order", epochs=4, batch=b)) for b in (0, 7))
    assert [r.train for r in whole.history] == pytest.approx([r.train for r in parts.history], rel=1e-7)


def test_ridge_keeps_the_consequents_small():
    free, held = (anfis.train(FIS, X, Y, Options(epochs=3, ridge=r)) for r in (0.0, 1e-2))
    sizes = [max(abs(p) for t in r.system.outputs[0].terms.values() for p in t.parameters) for r in (free, held)]
    assert sizes[1] < sizes[0]
    assert held.history[-1].train > free.history[-1].train


@pytest.mark.parametrize("constant", [7.0, 1e9])
def test_a_ridge_lets_a_constant_output_pass(constant):
    found = anfis.train(FIS, X, np.full(len(X), constant), Options(method="least-squares", ridge=1e-3))
    assert found.rmse <= 1e-13 * constant


def begun(x, y):
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", DataWarning)
        return fuzzy.identify(x, y, "subtractive", radius=0.15)


def test_an_error_that_the_written_system_does_not_keep_is_said():
    """Beside 1e12 a number in double precision has only some 1e-4 left."""
    x = 1e12 + np.random.default_rng(0).uniform(0, 1, (60, 1))
    y = np.sin(6 * (x[:, 0] - 1e12))
    options = Options(method="second-order", epochs=3)
    told = "for the input 'input1', which lies at 1e\\+12 and spreads over only 0.9[0-9]*; subtract a constant from it"
    with pytest.warns(DataWarning, match=told):
        far = anfis.train(begun(x, y), x, y, options, check=(x[:20], y[:20]))
    written = fuzzy.parse_fis(fuzzy.format_fis(far.system))
    assert far.rmse == pytest.approx(rmse(written, x, y))
    assert far.check_rmse == pytest.approx(rmse(written, x[:20], y[:20]))
    assert far.rmse > 2 * far.history[far.best].train
    near = anfis.train(begun(x - 1e12, y), x - 1e12, y, options)
    assert near.rmse == pytest.approx(near.history[near.best].train, rel=1e-6)
    assert np.isnan(near.check_rmse)


def test_a_system_without_rules():
    with pytest.raises(TrainingError, match="no rules"):
        anfis.train(replace(FIS, rules=()), X, Y)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"method": "hybird"}, "did you mean 'hybrid'"),
        ({"epochs": -1}, "epochs must be a whole number >= 0; got -1"),
        ({"epochs": True}, "epochs"),
        ({"step": float("nan")}, "step must be a finite number, >= 0; got nan"),
        ({"increase": 0.9}, "increase must be a finite number, >= 1; got 0.9"),
        ({"ridge": 1e308}, "ridge must be a finite number, >= 0 and <= 1e\\+12"),
        ({"decrease": 1.2}, "decrease must be a finite number, >= 0 and <= 1; got 1.2"),
        ({"dtype": "float16"}, "dtype"),
        ({"optimiser": "adam"}, "a class of torch.optim"),
        ({"optimiser": "LBFGS"}, "a class of torch.optim"),
        ({"optimiser": "Optimizer"}, "a class of torch.optim"),
        ({"device": "nowhere"}, "device 'nowhere' cannot be used"),
    ],
)
def test_options_that_make_no_sense(options, message):
    with pytest.raises(TrainingError, match=message):
        Options(**options)


# Mackey-Glass ---------------------------------------------------------------------------------------------------------


def mackey_glass() -> tuple[np.ndarray, np.ndarray]:
    path = Path(__file__).parents[2] / "benchmarks" / "mackeyglass.py"
    if not path.exists():
        pytest.skip("the benchmarks are not here")
    return module_in(path).pairs()


def bells(x: np.ndarray) -> fuzzy.Sugeno:
    """Two bells an input that cross at 0.5, sixteen rules, all consequents 0   [Jang 1993, section VI-D]."""
    ends = list(zip(x.min(axis=0), x.max(axis=0), strict=True))
    inputs = [
        fuzzy.Variable(f"x{i}", (low, high), {"low": fuzzy.Bell(h, 2, low), "high": fuzzy.Bell(h, 2, high)})
        for i, (low, high) in enumerate(ends)
        for h in [(high - low) / 2]
    ]
    combinations = list(product(("low", "high"), repeat=4))
    output = fuzzy.Variable("y", (0, 2), {f"c{r}": Linear((0.0,) * 4, 0.0) for r in range(16)})
    rules = [
        fuzzy.Rule(tuple(fuzzy.Clause(f"x{i}", name) for i, name in enumerate(names)), (("y", f"c{r}"),))
        for r, names in enumerate(combinations)
    ]
    return fuzzy.Sugeno(inputs, [output], rules)


def test_mackey_glass_reaches_jangs_error():
    x, y = mackey_glass()
    # The first and a later line of MATLAB's mgdata.dat are 1.2 and 1.1431 (t = 118), here as x(t) of the first pair.
    assert x[0, 3] == pytest.approx(1.1431278, abs=5e-8)
    result = anfis.train(bells(x[:500]), x[:500], y[:500], Options(epochs=500), check=(x[500:], y[500:]))
    assert result.parameters == 104
    assert result.history[result.best].check <= 0.0015  # Jang 1993: 0.0015
    assert result.history[result.best].train <= 0.0016  # Jang 1993: 0.0016
    assert rmse(result.system, x[500:], y[500:]) <= 0.0015


def test_second_order_reaches_jangs_error_in_forty_epochs():
    x, y = mackey_glass()
    options = Options(method="second-order", epochs=40)
    result = anfis.train(bells(x[:500]), x[:500], y[:500], options, check=(x[500:], y[500:]))
    assert result.history[result.best].check <= 0.0015
