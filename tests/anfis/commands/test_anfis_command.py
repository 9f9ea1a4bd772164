"""The command line ``anfis``, end to end."""

import json

import numpy as np
import pandas as pd
import pytest

import fuzzy
from anfis.commands.application import main

X = np.random.default_rng(0).uniform(-1, 1, (120, 2))
Y = np.sin(3 * X[:, 0]) * X[:, 1]


def read_exactly(file):
    """A table of numbers as Python reads them; pandas 2 reads some of them only nearly."""
    return pd.read_csv(file, dtype=str).astype(float)


@pytest.fixture
def data(tmp_path):
    for name, rows in (("data", slice(0, 80)), ("check", slice(80, None))):
        table = pd.DataFrame({"a": X[rows, 0], "b": X[rows, 1], "y": Y[rows]})
        table.to_csv(tmp_path / f"{name}.csv", index=False)
    return tmp_path


def test_train_evaluate_predict(data, capsys):
    files = [str(data / name) for name in ("data.csv", "check.csv", "net.fis", "h.csv", "e.png")]
    options = ["--grid", "3", "--mf", "gaussmf", "--epochs", "5", "--check", files[1], "--history", files[3]]
    assert main(["train", files[0], "-o", files[2], *options, "--plot", files[4], "--json", "-q"]) == 0
    printed = json.loads(capsys.readouterr().out)
    history = read_exactly(files[3])
    assert len(history) == 6
    assert printed["best"]["check"] == history["check"].min()
    assert printed["start"]["train"] == history["train"][0]
    assert (data / "e.png").read_bytes().startswith(b"\x89PNG")
    fis = fuzzy.read_fis(files[2])
    assert [v.name for v in (*fis.inputs, *fis.outputs)] == ["a", "b", "y"]
    error = fuzzy.Sugeno(fis.inputs, fis.outputs, fis.rules, out_of_range="ignore")(X[80:])[:, 0] - Y[80:]
    assert main(["evaluate", files[2], files[1], "--json"]) == 0
    found = json.loads(capsys.readouterr().out)["outputs"]["y"]
    assert found["rmse"] == pytest.approx(np.sqrt(np.mean(error**2)), rel=1e-12)
    assert found["rmse"] == pytest.approx(printed["best"]["check"], rel=1e-9)
    assert main(["predict", files[2], files[1], "-o", str(data / "p.csv")]) == 0
    np.testing.assert_allclose(read_exactly(data / "p.csv")["y"] - Y[80:], error, atol=1e-14)


def test_resume_is_as_if_it_had_not_stopped(data, capsys):
    common = [str(data / "data.csv"), "--grid", "2", "-q"]
    assert main(["train", *common, "--epochs", "6", "-o", str(data / "whole.fis")]) == 0
    assert main(["train", *common, "--epochs", "3", "-o", str(data / "a.fis"), "--checkpoint", str(data / "c.pt")]) == 0
    assert main(["train", *common, "--epochs", "6", "-o", str(data / "b.fis"), "--resume", str(data / "c.pt")]) == 0
    assert (data / "whole.fis").read_bytes() == (data / "b.fis").read_bytes()


def test_folds_come_before_the_training_of_all(data, capsys):
    common = ["train", str(data / "data.csv"), "--grid", "2", "--epochs", "2", "-q"]
    assert main([*common, "-o", str(data / "a.fis"), "--json"]) == 0
    plain = json.loads(capsys.readouterr().out)
    options = ["--folds", "4", "--fold-order", "blocks", "--test", str(data / "check.csv")]
    assert main([*common, "-o", str(data / "b.fis"), "--json", *options]) == 0
    found = json.loads(capsys.readouterr().out)
    assert (data / "a.fis").read_bytes() == (data / "b.fis").read_bytes()
    assert found["best"] == plain["best"]
    system = fuzzy.read_fis(data / "b.fis")
    error = fuzzy.Sugeno(system.inputs, system.outputs, system.rules, out_of_range="ignore")(X[80:])[:, 0] - Y[80:]
    assert found["rmse"]["test"] == pytest.approx(np.sqrt(np.mean(error**2)))
    each = [row["rmse"] for row in found["folds"]["each"]]
    assert [row["held"] for row in found["folds"]["each"]] == [20] * 4
    assert found["folds"]["mean"] == pytest.approx(np.mean(each))
    assert found["folds"]["std"] == pytest.approx(np.std(each, ddof=1))
    assert main([*common, "-o", str(data / "c.fis"), "--folds", "2"]) == 0
    assert "mean " in capsys.readouterr().out


def test_pruning_keeps_fewer_rules(data, capsys):
    common = ["train", str(data / "data.csv"), "--grid", "4", "--epochs", "2", "-q", "--prune"]
    tables = ["--check", str(data / "check.csv"), "--plot", str(data / "rules.png")]
    assert main([*common, *tables, "--choice", "least", "-o", str(data / "a.fis"), "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert found["rules"] == found["pruning"]["chosen"] == len(fuzzy.read_fis(data / "a.fis").rules) < 16
    path = found["pruning"]["path"]
    assert path[0] == found["pruning"]["unpruned"]
    assert min(path, key=lambda row: row["check"])["rules"] == found["rules"]
    assert found["rmse"]["check"] == found["pruning"]["pruned"]["check"] <= min(row["check"] for row in path)
    assert (data / "rules.png").read_bytes().startswith(b"\x89PNG")
    assert main([*common, "--keep-rules", "5", "-o", str(data / "b.fis")]) == 0
    assert "    5  " in capsys.readouterr().out
    assert len(fuzzy.read_fis(data / "b.fis").rules) == 5


@pytest.mark.parametrize(
    ("arguments", "fragment"),
    [
        (["--grid", "2", "--keep-rules", "3"], "give --prune too"),
        (["--grid", "2", "--prune", "--choice", "leats"], "did you mean 'least'"),
        (["--grid", "2", "--prune", "--folds", "3"], "give one of them"),
        (["--grid", "2", "--prune", "--checkpoint", "c.pt"], "leave --checkpoint out"),
        (["--grid", "2", "--prune", "--keep-rules", "9"], "from 1 to the number of rules (4), got 9"),
        (["--grid", "2", "--folds", "3", "--fold-order", "block"], "did you mean 'blocks'"),
        (["--grid", "2", "--folds", "81"], "from 2 to the number of samples (80), got 81"),
        (["--outputs", "z", "--grid", "2"], "unknown column 'z'. Known: a, b, y"),
        ([], "exactly one of --start, --rules, --radius and --grid"),
        (["--grid", "2", "--method", "hybird"], "did you mean 'hybrid'"),
        (["--grid", "2", "--step", "-1"], "--step: must be >= 0"),
        (["--grid", "2", "--mf", "gausmf"], "gaussmf"),
        (["--start", "none.fis"], "none.fis"),
        (["--grid", "2", "--resume", "none.pt"], "none.pt"),
        (["--grid", "2", "--inputs", "a,y"], "the last column is among the inputs: say which are the outputs"),
        (["--grid", "2", "--inputs", "a,y", "--outputs", "y"], "column 'y' is both an input and an output"),
        (["--grid", "2", "--inputs", "a,a"], "column 'a' is named twice"),
        (["--rules", "3", "--mf", "trimf"], "--mf says what --grid is made of"),
        (["--grid", "2", "--history", "nowhere/h.csv"], "nowhere/h.csv: there is no folder"),
        (["--grid", "2", "--plot", "e.gif"], "end it in .png, .pdf or .svg"),
    ],
)
def test_bad_options_are_one_message(data, arguments, fragment, capsys):
    assert main(["train", str(data / "data.csv"), "-o", str(data / "x.fis"), *arguments, "-q"]) == 2
    printed = capsys.readouterr()
    assert fragment in printed.err
    assert "Traceback" not in printed.err
    assert not (data / "x.fis").exists()


def test_predictions_as_json(data, tmp_path, capsys):
    fuzzy.write_fis(fuzzy.identify(X, Y, "grid", input_names=["a", "b"], output_names=["y"]), data / "p.fis")
    table, out = data / "data.csv", tmp_path / "out.csv"
    assert main(["predict", str(data / "p.fis"), str(table), "--json", "-o", str(out)]) == 0
    printed = json.loads(capsys.readouterr().out)
    expected = fuzzy.read_fis(data / "p.fis")(read_exactly(table)[["a", "b"]].to_numpy())[:, 0]
    assert printed == {"samples": len(expected), "skipped": 0, "outputs": {"y": expected.tolist()}, "file": str(out)}
    np.testing.assert_array_equal(read_exactly(out)["y"], expected)


@pytest.fixture
def colours(tmp_path, monkeypatch):
    """Tables whose last input is a text; one has a text that the others lack."""
    monkeypatch.chdir(tmp_path)
    for name, rows, words in (("data", 80, "red green"), ("check", 40, "green red"), ("other", 40, "red pink")):
        colour = np.array(words.split())[(X[:rows, 0] > 0).astype(int)]
        frame = pd.DataFrame(
            {"a": X[:rows, 0], "b": X[:rows, 1], "colour": colour, "y": X[:rows, 1] + (colour == "red")}
        )
        frame.to_csv(f"{name}.csv", index=False)


def test_a_column_of_texts_is_coded_alike_wherever_the_system_goes(colours, capsys):
    common = ["train", "data.csv", "--grid", "2", "--epochs", "1", "-q", "-o", "net.fis", "--ridge", "1e-6"]
    assert main([*common, "--one-hot", "colour", "--inputs", "b,colour", "--check", "check.csv", "--json"]) == 0
    said = capsys.readouterr()
    assert said.err.startswith("data.csv: 'colour' is coded as colour=green, colour=red\n")
    assert json.loads(said.out)["rmse"]["check"] < 1e-3
    assert [v.name for v in fuzzy.read_fis("net.fis").inputs] == ["b", "colour=green", "colour=red"]
    assert main(["evaluate", "net.fis", "check.csv", "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["outputs"]["y"]["rmse"] < 1e-3
    assert main(["predict", "net.fis", "check.csv", "-o", "p.csv"]) == 0
    np.testing.assert_allclose(pd.read_csv("p.csv")["y"], pd.read_csv("check.csv")["y"], atol=1e-2)
    assert (
        main(["train", "data.csv", "--start", "net.fis", "--epochs", "1", "-q", "-o", "more.fis", "--ridge", "1"]) == 0
    )
    capsys.readouterr()
    for arguments in ([*common, "--one-hot", "colour", "--check", "other.csv"], ["predict", "net.fis", "other.csv"]):
        assert main(arguments) == 2
        assert "anfis: other.csv: 'colour' holds 'pink', which is none of green, red" in capsys.readouterr().err


@pytest.mark.parametrize("more", [[], ["--skip-bad"]])
def test_a_column_of_texts_names_both_ways_out(colours, capsys, more):
    assert main(["train", "data.csv", "--rules", "2", "-o", "net.fis", *more]) == 2
    said = "leave it out with --inputs a,b, or let anfis train --one-hot colour code it as 0/1 columns\n"
    assert capsys.readouterr().err.endswith(said)


def test_an_interrupt_writes_the_best_so_far(data, capsys, monkeypatch):
    from anfis.methods.hybrid import Hybrid

    advance = Hybrid.advance

    def interrupted(self, problem, state):
        if state.epoch == 3:
            raise KeyboardInterrupt
        return advance(self, problem, state)

    monkeypatch.setattr(Hybrid, "advance", interrupted)
    files = [str(data / name) for name in ("data.csv", "net.fis", "h.csv")]
    assert main(["train", files[0], "-o", files[1], "--grid", "2", "--epochs", "9", "--history", files[2], "-q"]) == 130
    printed = capsys.readouterr()
    assert printed.err == f"anfis: interrupted; the best so far is in {files[1]}\n"
    assert "stopped: interrupted" in printed.out
    history = read_exactly(files[2])
    assert len(history) == 4
    fis = fuzzy.read_fis(files[1])
    assert np.sqrt(np.mean((fis(X[:80])[:, 0] - Y[:80]) ** 2)) == pytest.approx(history["train"].min(), rel=1e-6)


@pytest.mark.parametrize("start", [["--rules", "5"], ["--radius", "0.6"]])
def test_clusters_to_start_from_and_a_bar(data, capsys, start):
    assert main(["train", str(data / "data.csv"), "-o", str(data / "n.fis"), *start, "--epochs", "2"]) == 0
    printed = capsys.readouterr()
    assert "epoch 2: training" in printed.err
    assert printed.out.count("\n") == 1
    # And on from there, by another method.
    again = ["--start", str(data / "n.fis"), "--method", "second-order", "--epochs", "1", "-q"]
    assert main(["train", str(data / "data.csv"), "-o", str(data / "m.fis"), *again]) == 0


def test_an_option_that_the_method_does_not_read_is_said(data, capsys):
    common = ["train", str(data / "data.csv"), "-o", str(data / "n.fis"), "--grid", "2", "--epochs", "1", "-q"]
    assert main([*common, "--method", "second-order", "--step", "0.1", "--ridge", "0.1"]) == 0
    said = capsys.readouterr().err
    assert said == "warning: --step changes nothing: the method second-order does not read it\n"
    assert main([*common, "--step", "0.1"]) == 0
    assert capsys.readouterr().err == ""


def test_versions(capsys):
    assert main(["--version"]) == 0
    assert "torch" in capsys.readouterr().out
