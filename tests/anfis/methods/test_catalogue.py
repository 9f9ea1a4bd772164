"""A method is one file and one line in METHODS: a toy one learns wherever methods are named."""

import subprocess
import sys
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

import anfis
import fuzzy
from anfis import METHODS, Options, TrainingError
from anfis.commands.application import main
from anfis.methods.catalogue import Listed
from anfis.methods.method import LearningProblem, make_method
from anfis.plugins.designer.panel import methods
from anfis.plugins.designer.task import TrainingTaskError, learn, task_of
from fuzzy.files.fisfile import format_fis
from fuzzy.plugins.designer.columns import LoadedTable
from tests.anfis.training_problem import FIS, TRAINED, X, Y

HALVED = pytest.approx([0.04, 0.02, 0.01, 0.005], rel=1e-12)


@pytest.fixture
def toy(monkeypatch):
    monkeypatch.setitem(METHODS, "halving", Listed("half as far", "tests.anfis.methods.toy_method:Halving"))


def test_a_toy_method_trains_stops_and_goes_on(toy, tmp_path):
    options = Options(method="halving", epochs=3, step=0.04)
    whole = anfis.train(FIS, X, Y, options)
    assert [row.step for row in whole.history] == HALVED
    assert whole.history[-1].train < whole.history[0].train
    assert whole.state["memory"]["steps"] == 3
    anfis.train(FIS, X, Y, Options(method="halving", epochs=1, step=0.04), checkpoint=tmp_path / "half.pt")
    resumed = anfis.train(FIS, X, Y, options, resume=tmp_path / "half.pt")
    assert format_fis(resumed.system) == format_fis(whole.system)


def test_a_toy_method_on_the_command_line(toy, tmp_path, capsys):
    table, start, history = tmp_path / "data.csv", tmp_path / "start.fis", tmp_path / "h.csv"
    pd.DataFrame({"x1": X[:, 0], "x2": X[:, 1], "y": Y}).to_csv(table, index=False)
    fuzzy.write_fis(FIS, start)
    command = ["train", str(table), "--start", str(start), "-o", str(tmp_path / "net.fis"), "--history", str(history)]
    more = ["--method", "halving", "--step", "0.04", "--epochs", "3", "-q"]
    assert main([*command, *more]) == 0
    assert capsys.readouterr().err == ""
    assert pd.read_csv(history)["step"].tolist() == HALVED


def test_a_toy_method_in_the_designer(toy):
    assert methods()[-1] == ["halving", "half as far"]
    table = LoadedTable("made up", ("a", "b", "y"), np.column_stack([X, Y]))
    task = task_of(table, {"a": "input", "b": "input", "y": "output"}, None, start="grid", method="halving", epochs=2)
    heard = []
    result = learn(task, lambda what, about: heard.append(what) or True)
    assert result.options.method == "halving"
    assert heard.count("epoch") == len(result.history) == 3


def test_a_toy_method_in_the_estimator(toy):
    from anfis.plugins.regressor.estimator import ANFISRegressor

    found = ANFISRegressor("grid", method="halving", step=0.04, epochs=3).fit(X, Y)
    assert [row.step for row in found.training_.history] == HALVED


def test_an_unknown_method_is_a_sentence_everywhere():
    with pytest.raises(TrainingError, match="unknown method 'halving'"):
        Options(method="halving")
    table = LoadedTable("made up", ("a", "y"), np.ones((9, 2)))
    with pytest.raises(TrainingTaskError, match="unknown method 'halving'"):
        task_of(table, {"a": "input", "y": "output"}, None, start="grid", method="halving")


class Watched(Options):
    """Options that note which of them are looked at."""

    def __getattribute__(self, name):
        if not name.startswith("_"):
            object.__getattribute__(self, "__dict__").setdefault("_seen", set()).add(name)
        return object.__getattribute__(self, name)


@pytest.mark.parametrize("name", TRAINED)
def test_a_method_says_which_options_it_reads(name):
    """What training itself reads for a method that solves, ``ridge`` and ``batch``, counts as the method's."""
    method = make_method(name)
    run = anfis.train(FIS, X, Y, Options(method=name, epochs=0))
    network = _network()
    data = anfis.data.samples(FIS, X, Y, "training").to(network.premises.low.dtype, "cpu")
    options = Watched(method=name)
    state = anfis.checkpoint.restore(run.state, run.options, run.state["fingerprint"], array=network.array)
    options.__dict__["_seen"] = set()
    method.first_step(options)
    assert method.advance(LearningProblem(network, data, options), state) is not None
    assert options.__dict__["_seen"] | ({"ridge", "batch"} if method.solves else set()) == set(method.reads)


def _network():
    import torch

    from anfis.consequents import groups
    from anfis.network import Network
    from anfis.premises import premises

    held = premises(FIS, dtype=torch.float64, device="cpu")
    return Network(held, groups(FIS, torch.float64, "cpu"), ridge=0.0, block=1000)


@pytest.mark.parametrize("name", METHODS)
def test_every_method_has_its_own_module_and_title(name):
    module = METHODS[name].home.partition(":")[0]
    assert module == f"anfis.methods.{name.replace('-', '_')}"
    assert [m.home.partition(":")[0] for m in METHODS.values()].count(module) == 1
    assert METHODS[name].title in dict(methods()).values()


def test_the_table_and_the_command_line_are_light():
    code = "import anfis.methods.catalogue, anfis.commands.application, anfis.plugins.designer.panel, sys; "
    code += "print(*sorted({'torch', 'pandas', 'matplotlib', 'sklearn'} & set(sys.modules)))"
    done = subprocess.run(
        [sys.executable, "-c", code], cwd=Path(__file__).parents[3], capture_output=True, text=True, check=True
    )
    assert done.stdout.strip() == ""
