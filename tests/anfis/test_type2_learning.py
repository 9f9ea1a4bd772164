"""Learning of interval type-2 systems: gradients against the compiled inference, what comes back, and the command."""

import json

import numpy as np
import pandas as pd
import pytest
import torch

import anfis
import fuzzy
from anfis import Options, TrainingError
from anfis.commands.application import main
from anfis.data import samples
from anfis.type2network import make_network

RNG = np.random.default_rng(3)
X = RNG.uniform([0, -2], [10, 3], (90, 2))
SERVICE = {"poor": fuzzy.Triangle(-4, 0, 6), "good": fuzzy.Gaussian(2, 5), "great": fuzzy.Trapezoid(4, 9, 12, 14)}
FOOD = {"bad": fuzzy.Bell(2, 2, -2), "fine": fuzzy.SShape(-1.5, 2.5)}
TIP = {"low": 5, "mid": fuzzy.Linear((1.0, 2.0), 8.0), "high": 25}
UPPER = fuzzy.Sugeno(
    [fuzzy.Variable("service", (0, 10), SERVICE), fuzzy.Variable("food", (-2, 3), FOOD)],
    [fuzzy.Variable("tip", (0, 30), TIP, "%")],
    [
        "if service is poor and food is bad then tip is low",
        "if service is good then tip is mid with 0.8",
        "if service is great or food is fine then tip is high",
        "if service is not poor and food is not bad then tip is mid",
    ],
    out_of_range="ignore",
)


def system(reduction="karnikmendel") -> fuzzy.Type2Sugeno:
    lag = {"service": {"poor": (0.2, 0.15), "good": 0.05, "great": (0.1, 0.2)}, "food": {"bad": 0.1, "fine": 0.05}}
    return fuzzy.to_type2(UPPER, lag, {"service": 0.9, "food": {"bad": 0.7, "fine": 0.6}}, reduction)


TRUE = fuzzy.to_type2(
    UPPER, {"service": {"poor": (0.05, 0.3)}}, {"service": {"poor": 0.4, "good": 0.5}, "food": {"bad": 0.4}}
)
Y = TRUE(X)


def rmse(fis: fuzzy.Type2Sugeno, x=X, y=Y) -> float:
    return float(np.sqrt(np.mean((fuzzy.compile_type2(fis)(x) - y) ** 2)))


@pytest.mark.parametrize("reduction", ["eiasc", "nietan"])
def test_gradients_are_those_of_differences_of_the_compiled_inference(reduction):
    fis = system(reduction)
    network = make_network(fis, "float64", "cpu", False, 0.0, 1000)
    data, start = network.samples(samples(UPPER, X, Y, "training")), network.start()
    assert network.system(start).lower == fis.lower
    assert network.system(start)(X) == pytest.approx(fis(X), abs=1e-9)
    leaves = [array.clone().requires_grad_() for array in (*start.free, *start.values)]
    kinds = len(start.free)
    x, y = data.rows(slice(None))
    error = network.output(leaves[:kinds], leaves[kinds:], network.premises.scale(x)) - y
    error.square().mean().sqrt().backward()
    least = []
    for k, leaf in enumerate(leaves):
        for place in np.ndindex(*leaf.shape):
            ends = []
            for step in (1e-6, -1e-6):
                moved = [array.detach().clone() for array in leaves]
                moved[k][place] += step
                ends.append(rmse(network.system(start._replace(free=tuple(moved[:kinds]), values=moved[kinds:]))))
            found = float(leaf.grad[place])
            assert found == pytest.approx((ends[0] - ends[1]) / 2e-6, rel=1e-4, abs=1e-6)
            least.append(abs(found))
    assert np.count_nonzero(np.array(least) > 1e-4) > 20
    assert network.count == sum(leaf.numel() for leaf in leaves) - 3  # good, bad and fine have one lag for both sides


def test_it_learns_the_footprint_with_the_rest_and_answers_as_it_learnt():
    start = system()
    found = anfis.train(start, X, Y, Options(method="backprop", epochs=25, rate=0.04), check=(X[:40], Y[:40]))
    assert found.history[0].train == pytest.approx(rmse(start), rel=1e-9)
    assert found.rmse == pytest.approx(rmse(found.system), rel=1e-6)
    assert found.check_rmse == pytest.approx(rmse(found.system, X[:40], Y[:40]), rel=1e-6)
    assert found.rmse < found.history[0].train / 3
    lower = found.system.lower
    assert lower["service"]["good"].scale < 0.85  # 0.5 in truth, from 0.9
    assert lower["service"]["good"].lag[0] == lower["service"]["good"].lag[1]
    assert lower["service"]["poor"].lag[0] != lower["service"]["poor"].lag[1]
    assert found.system.inputs[0].terms["poor"] != UPPER.inputs[0].terms["poor"]


def test_the_footprint_alone_has_something_to_say():
    """Of a system without freedom elsewhere: the scale of one term, which the data tell."""
    two = {"a": fuzzy.LinearZ(0, 1), "b": fuzzy.LinearS(0, 1)}
    upper = fuzzy.Sugeno(
        [fuzzy.Variable("x", (0, 1), two)],
        [fuzzy.Variable("y", (0, 1), {"zero": 0, "one": 1})],
        ["if x is a then y is zero", "if x is b then y is one"],
    )
    network = make_network(fuzzy.to_type2(upper, 0, {"x": {"a": 0.9}}), "float64", "cpu", False, 0.0, 100)
    point, x = network.start(), np.array([[0.25]])
    scale = 0.9
    # Bounds of a: 0.75 scale and 0.75, of b: 0.25. The ends are 0.25/(0.25 + 0.75) and 0.25/(0.25 + 0.75 scale).
    out = network.output(point.free, point.values, torch.tensor(x))
    assert float(out) == pytest.approx((0.25 + 0.25 / (0.25 + 0.75 * scale)) / 2)


def test_resumed_is_uninterrupted(tmp_path):
    options = Options(method="backprop", epochs=6, batch=30)
    whole = anfis.train(system(), X, Y, options)
    part = anfis.train(system(), X, Y, Options(method="backprop", epochs=3, batch=30), checkpoint=tmp_path / "c.pt")
    assert len(part.history) == 4
    again = anfis.train(system(), X, Y, options, resume=tmp_path / "c.pt")
    assert repr(again.history) == repr(whole.history)
    assert again.system == whole.system
    with pytest.raises(TrainingError, match="another system"):
        anfis.train(system("nietan"), X, Y, options, resume=tmp_path / "c.pt")


@pytest.mark.parametrize("method", ["hybrid", "second-order", "least-squares"])
def test_methods_that_solve_for_consequents_say_what_learns(method):
    with pytest.raises(TrainingError, match=f"'backprop', not by '{method}'"):
        anfis.train(system(), X, Y, Options(method=method))


def test_the_command_starts_from_a_type_2_file_and_writes_one(tmp_path, capsys):
    fuzzy.write_fis(system(), tmp_path / "start.fis")
    table = pd.DataFrame({"service": X[:, 0], "food": X[:, 1], "tip": Y[:, 0]})
    table.to_csv(tmp_path / "data.csv", index=False)
    common = [
        "train",
        str(tmp_path / "data.csv"),
        "--start",
        str(tmp_path / "start.fis"),
        "-o",
        str(tmp_path / "o.fis"),
    ]
    learn = ["--method", "backprop", "--epochs", "4", "-q"]
    assert main([*common, *learn, "--folds", "3", "--json"]) == 0
    printed = json.loads(capsys.readouterr().out)
    learnt = fuzzy.read_type2(tmp_path / "o.fis")
    assert printed["rmse"]["train"] == pytest.approx(rmse(learnt), rel=1e-6)
    assert printed["rmse"]["train"] < printed["start"]["train"] == pytest.approx(rmse(system()), rel=1e-6)
    assert main(["evaluate", str(tmp_path / "o.fis"), str(tmp_path / "data.csv"), "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["outputs"]["tip"]["rmse"] == pytest.approx(rmse(learnt), rel=1e-6)
    for wrong, match in (([], "by the method 'backprop'"), ([*learn, "--prune"], "--prune takes away rules of type-1")):
        assert main([*common, *wrong]) != 0
        assert match in " ".join(capsys.readouterr().err.split())
