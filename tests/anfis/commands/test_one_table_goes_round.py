"""One file of measurements, as a spreadsheet writes it, goes through every command without an edit."""

import json
from pathlib import Path

import numpy as np
import pytest

import anfis.commands.application
import fuzzy.commands.application
from fuzzy.files.fisfile import read_fis
from fuzzy.files.table import read_table

RNG = np.random.default_rng(8)
X = np.round(RNG.uniform([20, 1], [90, 5], (60, 2)), 2)
Y = np.round(0.1 * X[:, 0] + np.sin(X[:, 1]), 3)
KNOWN = np.delete(np.arange(60), 40)  # the row without a pressure
COLUMNS = ["--inputs", "Coolant temp [°C],Oil pressure", "--outputs", "Wear"]


@pytest.fixture(autouse=True)
def plant(tmp_path, monkeypatch) -> None:
    """Semicolons, decimal commas, a time and a note, a column without a title, a row without a number."""
    monkeypatch.chdir(tmp_path)
    rows = [
        f"2024-03-01 09:{k:02};{a};{b if k != 40 else ''};;{y};{'' if k % 2 else 'ok'}".replace(".", ",")
        for k, ((a, b), y) in enumerate(zip(X.tolist(), Y.tolist(), strict=True))
    ]
    text = "\n".join(["Time;Coolant temp [°C];Oil pressure (bar);;Wear [µm];Note", *rows, ""])
    Path("plant.csv").write_bytes(text.encode("utf-16"))


def run(capsys, package, *arguments: str, code: int = 0) -> tuple[str, str]:
    assert package.commands.application.main(arguments) == code
    said = capsys.readouterr()
    assert "Traceback" not in said.err
    return said.out, said.err


LEFT_OUT = "plant.csv: 1 of 60 rows was left out, line 42\n"


@pytest.mark.parametrize(
    ("package", "arguments"),
    [(fuzzy, ["identify", "--radius", "0.5"]), (anfis, ["train", "--grid", "2", "--epochs", "2", "-q"])],
)
def test_a_system_is_made_and_asked_with_the_same_file(capsys, package, arguments) -> None:
    command = [arguments[0], "plant.csv", *arguments[1:], *COLUMNS, "-o", "wear.fis"]
    assert (
        "1 of 60 rows has no number in 'Oil pressure' (line 42: the field is empty); --skip-bad leaves"
        in (run(capsys, package, *command, code=2)[1])
    )
    said, err = run(capsys, package, *command, "--skip-bad", "--json")
    assert err == LEFT_OUT
    assert json.loads(said)["skipped"] == 1
    fis = read_fis("wear.fis")
    assert [(v.name, v.unit) for v in fis.inputs] == [("Coolant temp", "°C"), ("Oil pressure", "bar")]
    assert [(v.name, v.unit) for v in fis.outputs] == [("Wear", "µm")]
    expected = np.asarray(fis(X[KNOWN]))[:, 0]
    rmse = float(np.sqrt(np.mean((expected - Y[KNOWN]) ** 2)))
    said, err = run(capsys, anfis, "evaluate", "wear.fis", "plant.csv", "--skip-bad", "--json")
    assert json.loads(said)["outputs"]["Wear"]["rmse"] == pytest.approx(rmse)
    assert (json.loads(said)["samples"], json.loads(said)["skipped"], err) == (59, 1, LEFT_OUT)
    run(capsys, anfis, "predict", "wear.fis", "plant.csv", "--skip-bad", "-o", "predicted.csv")
    ignored = "ignored: Time, Wear [µm], Note\n"
    told = run(capsys, fuzzy, "evaluate", "wear.fis", "plant.csv", "--skip-bad", "-o", "evaluated.csv")
    assert told == ("", ignored + LEFT_OUT)
    for file in ("predicted.csv", "evaluated.csv"):
        table = read_table(file)
        assert (table.names, table.units) == (("Wear",), ("µm",))
        assert table.values[:, 0] == pytest.approx(expected)
    again = ["--start", "wear.fis", "--epochs", "1", "-q", "-o", "more.fis", "--skip-bad", "--check", "plant.csv"]
    said, err = run(capsys, anfis, "train", "plant.csv", *again)
    assert " µm training, " in said
    assert err.startswith(LEFT_OUT)
    assert read_fis("more.fis").inputs[1].unit == "bar"


def test_a_search_takes_it_too(capsys) -> None:
    said = run(capsys, fuzzy, "search", "plant.csv", *COLUMNS, "--rules", "3", "--radii", "0.7", "--skip-bad", "--json")
    assert (json.loads(said[0])["samples"], json.loads(said[0])["skipped"]) == (59, 1)


def test_another_unit_than_the_system_s_is_said(capsys) -> None:
    run(capsys, fuzzy, "identify", "plant.csv", *COLUMNS, "-o", "wear.fis", "--skip-bad")
    Path("kelvin.csv").write_text("Oil pressure [bar],Coolant temp [K]\n2,300\n", encoding="utf-8")
    err = run(capsys, anfis, "predict", "wear.fis", "kelvin.csv")[1]
    assert err.startswith("kelvin.csv: 'Coolant temp' is in K, but the system's in °C\n")


def test_two_columns_of_one_name_are_told_apart_by_their_titles(capsys) -> None:
    Path("two.csv").write_text("T [K],T [°C],y\n300,27,1\n301,28,2\n310,37,3\n", encoding="utf-8")
    err = run(capsys, anfis, "train", "two.csv", "--inputs", "T", "-o", "t.fis", "--grid", "2", code=2)[1]
    assert "2 columns are called 'T': 'T [K]', 'T [°C]'; say which by its whole title" in err
    assert "columns 1 and 2 are both called 'T'" in run(capsys, fuzzy, "identify", "two.csv", code=2)[1]
    run(capsys, fuzzy, "identify", "two.csv", "--inputs", "T [°C]", "--method", "grid", "-o", "t.fis")
    assert [(v.name, v.unit) for v in read_fis("t.fis").inputs] == [("T", "°C")]
    said = run(capsys, anfis, "evaluate", "t.fis", "two.csv", "--json")[0]
    assert json.loads(said)["samples"] == 3
