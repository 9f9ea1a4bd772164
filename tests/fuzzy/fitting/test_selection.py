"""Inputs chosen one after the other, against data whose inputs are known and an error that is computed otherwise."""

import json
from functools import partial

import numpy as np
import pytest
from sklearn.linear_model import LinearRegression
from sklearn.model_selection import KFold, cross_val_predict

import fuzzy
from fuzzy.commands.application import main
from fuzzy.fitting.consequents import IdentificationError
from fuzzy.fitting.selection import select_inputs
from fuzzy.membership import Gaussian
from fuzzy.system import Linear, Sugeno, Variable


def data(seed, samples=300):
    rng = np.random.default_rng(seed)
    x = rng.uniform(-1, 1, (samples, 6))
    return x, np.sin(3 * x[:, 1]) + x[:, 1] * x[:, 4] + 0.1 * rng.normal(size=samples)


@pytest.mark.parametrize("seed", range(8))
@pytest.mark.parametrize("make", [partial(fuzzy.identify, method="subtractive"), partial(fuzzy.identify, mfs=3)])
def test_the_inputs_that_matter_are_found_and_no_other(seed, make):
    x, y = data(seed)
    found = select_inputs(x, y, make)
    assert found.chosen == (1, 4)
    assert [step.inputs[: k + 1] for k, step in enumerate(found.steps[:2])] == [(1,), (1, 4)]
    assert len(found.steps) <= 4  # two more, which made it no less


def test_of_noise_one_input_is_taken():
    rng = np.random.default_rng(5)
    assert len(select_inputs(rng.normal(size=(200, 4)), rng.normal(size=200), fuzzy.identify).chosen) == 1


def linear(x, y):
    """One rule that always fires: a linear regression."""
    inputs = [Variable(f"x{k}", (-9, 9), {"all": Gaussian(1e9, 0.0)}) for k in range(x.shape[1])]
    fit = LinearRegression().fit(x, y[:, 0])
    rule = "if " + " and ".join(f"x{k} is all" for k in range(x.shape[1])) + " then y is line"
    return Sugeno(inputs, [Variable("y", (-99, 99), {"line": Linear(tuple(fit.coef_), float(fit.intercept_))})], [rule])


def test_the_error_is_that_of_scikit_learn():
    x, y = data(3)
    steps = select_inputs(x, y, linear, folds=4, order="blocks", most=6).steps
    assert len(steps) == 6
    for step in steps:
        told = cross_val_predict(LinearRegression(), x[:, step.inputs], y, cv=KFold(4))
        assert step.error == pytest.approx(np.sqrt(np.mean((told - y) ** 2)) / y.std(), rel=1e-9)


def test_what_cannot_be_selected_is_refused():
    x, y = data(0)
    with pytest.raises(IdentificationError, match="candidate"):
        select_inputs(x[:, :0], y, fuzzy.identify)
    with pytest.raises(IdentificationError, match="from 1 to the number of candidates, 6; got 7"):
        select_inputs(x, y, fuzzy.identify, most=7)
    with pytest.raises(IdentificationError, match="no single input"):
        select_inputs(x, y, partial(fuzzy.identify, method="grid", mfs=1_000_000))


def test_the_command_writes_the_system_of_the_inputs_chosen(tmp_path, capsys, monkeypatch):
    monkeypatch.chdir(tmp_path)
    x, y = data(1)
    header = "a,b [m],c,d,e [s],f,y [m/s]"
    np.savetxt("table.csv", np.c_[x, y], delimiter=",", header=header, comments="")
    assert main(["identify", "table.csv", "--select", "--folds", "4", "-o", "small.fis", "--json"]) == 0
    told = json.loads(capsys.readouterr().out)
    assert told["inputs"] == ["b", "e"]
    assert [step["inputs"] for step in told["steps"][:2]] == [["b"], ["b", "e"]]
    fis = fuzzy.read_fis("small.fis")
    assert [(v.name, v.unit) for v in fis.inputs] == [("b", "m"), ("e", "s")]
    assert main(["identify", "table.csv", "--select", "--rules", "4"]) == 2
    assert main(["identify", "table.csv", "--folds", "4"]) == 2
    assert "go with it" in capsys.readouterr().err
