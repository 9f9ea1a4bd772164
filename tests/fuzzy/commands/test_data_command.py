"""``fuzzy identify`` and ``fuzzy search``: columns, files, messages and exit codes."""

import json
from pathlib import Path

import numpy as np
import pytest

from fuzzy.commands.application import main
from fuzzy.files.fisfile import read_fis
from fuzzy.files.table import write_table
from fuzzy.fitting.clustering import ClusteringOptions
from fuzzy.fitting.identification import identify
from fuzzy.fitting.search import search_clusters

RNG = np.random.default_rng(4)
X = RNG.uniform([-2, 0], [2, 5], (150, 2))
Y = np.column_stack([np.sin(X[:, 0]) + X[:, 1], X[:, 0] * X[:, 1]])


@pytest.fixture(autouse=True)
def data(tmp_path, monkeypatch) -> None:
    monkeypatch.chdir(tmp_path)
    write_table("data.csv", ["x [m]", "t", "v [m/s]", "w"], np.column_stack([X, Y]))
    write_table("bare.csv", None, np.column_stack([X, Y[:, 0]]))
    write_table("few.csv", None, np.column_stack([X, Y[:, 0]])[:20])


def succeeds(capsys, line: str, code: int = 0, err: str = "") -> str:
    assert main(line.split()) == code
    said = capsys.readouterr()
    assert said.err == err
    return said.out


def fails(capsys, line: str) -> str:
    assert main(line.split()) == 2
    said = capsys.readouterr()
    assert said.out == ""
    assert "Traceback" not in said.err
    assert sorted(path.name for path in Path().iterdir()) == ["bare.csv", "data.csv", "few.csv"]
    return said.err


def test_identify_writes_the_system(capsys) -> None:
    said = succeeds(
        capsys,
        "identify data.csv --inputs x,t --outputs v,w --radius 0.6 --squash 1 -o net.fis",
    )
    fis = read_fis("net.fis")
    assert fis.name == "net"
    assert [(v.name, v.unit) for v in fis.inputs] == [("x", "m"), ("t", "")]
    assert [(v.name, v.unit) for v in fis.outputs] == [("v", "m/s"), ("w", "")]
    expected = identify(X, Y, "subtractive", radius=0.6, options=ClusteringOptions(squash=1.0))
    assert np.asarray(fis(X)) == pytest.approx(np.asarray(expected(X)), rel=1e-9)
    rmse = np.sqrt(np.mean((np.asarray(fis(X)) - Y) ** 2, axis=0))
    count = len(fis.rules)
    assert said == f"net.fis: {count} rules, RMSE of the samples: v {rmse[0]:.4g} m/s, w {rmse[1]:.4g}\n"


@pytest.mark.parametrize(
    ("arguments", "settings"),
    [
        ("--method grid", {"method": "grid"}),
        ("--method grid --mfs 3,2 --kind gaussmf", {"method": "grid", "mfs": [3, 2], "kind": "gaussmf"}),
        ("--order 0", {"method": "subtractive", "order": 0}),
        ("--method grid --mfs 3 --no-fit", {"method": "grid", "mfs": 3, "fit": False}),
        ("--method fcm --clusters 4 --seed 3 --ridge 0.01", {"method": "fcm", "clusters": 4, "seed": 3, "ridge": 0.01}),
        ("", {"method": "subtractive"}),
    ],
)
def test_identify_by_every_method(capsys, arguments, settings) -> None:
    out = json.loads(succeeds(capsys, f"identify bare.csv {arguments} --json"))
    # Columns by default: the last is the output. The file is named after the data.
    expected = identify(X, Y[:, 0], **settings)
    fis = read_fis("bare.fis")
    assert out["file"] == "bare.fis"
    assert out["rules"] == len(fis.rules) == len(expected.rules)
    assert np.asarray(fis(X)) == pytest.approx(np.asarray(expected(X)), rel=1e-9)
    rmse = np.sqrt(np.mean((np.asarray(expected(X))[:, 0] - Y[:, 0]) ** 2))
    assert out["rmse"]["column3"] == pytest.approx(rmse, rel=1e-9)


def test_identify_with_a_number_of_rules_searches(capsys) -> None:
    best = search_clusters(X, Y[:, 0], 4).best
    arguments = "identify data.csv --inputs 1,2 --outputs 3 --rules 4 -o net.fis --plot error.png --json"
    out = json.loads(succeeds(capsys, arguments))
    assert out["rules"] == len(read_fis("net.fis").rules) == 4
    assert out["rmse"]["v"] == pytest.approx(best.error, rel=1e-9)
    assert out["setting"] == {
        "radius": best.radius,
        "squash": best.options.squash,
        "accept": best.options.accept,
        "reject": best.options.reject,
    }
    assert Path("error.png").read_bytes()[:4] == b"\x89PNG"


def test_search_lists_the_best_of_each_number(capsys) -> None:
    result = search_clusters(X, Y[:, 0], 4)
    arguments = "search data.csv --inputs x,t --outputs v --rules 4"
    lines = succeeds(capsys, f"{arguments} --plot error.svg").splitlines()
    assert lines[0] == f"108 settings, {result.fitted} different systems; error: RMSE of v [m/s]"
    rows = [line.split() for line in lines[2:]]
    assert [int(row[0]) for row in rows] == list(result.by_rules)
    assert [row[0] for row in rows if "wanted" in row] == ["4"]
    for row, trial in zip(rows, result.by_rules.values(), strict=True):
        ratios = [trial.options.squash, trial.options.accept, trial.options.reject]
        assert [float(cell) for cell in row[1:6]] == [float(f"{trial.error:.3e}"), trial.radius, *ratios]
    assert Path("error.svg").exists()
    out = json.loads(succeeds(capsys, f"{arguments} --json"))
    assert out["found"] is True
    assert [row["error"] for row in out["best"]] == pytest.approx([t.error for t in result.by_rules.values()])


def test_search_without_success_exits_with_1(capsys) -> None:
    result = search_clusters(X, Y[:, 0], 7, radii=[5.0, 6.0])
    assert 7 not in result.by_rules
    told = "no setting gives 7 rules; try other --radii\n"
    said = succeeds(capsys, "search bare.csv --rules 7 --radii 5,6", code=1, err=told)
    assert said.splitlines()[0].startswith("54 settings, ")
    assert [line.split()[0] for line in said.splitlines()[2:]] == [str(k) for k in result.by_rules]


def test_a_constant_column_is_one_line_on_stderr(capsys) -> None:
    write_table("flat.csv", ["a", "b", "y"], np.column_stack([X[:, 0], np.ones(150), Y[:, 0]]))
    assert main(["identify", "flat.csv", "--method", "fcm", "--clusters", "2"]) == 0
    lines = capsys.readouterr().err.splitlines()
    assert lines[0] == "warning: constant, so nothing can be learnt from it: b (1)"
    assert len(lines) == 2  # and the rank


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ("data.csv --inputs x,q", "unknown column 'q'"),
        ("data.csv --inputs x,q", "Known: x, t, v, w"),
        ("bare.csv --inputs 7", "unknown column '7'. Known: column1, column2, column3"),
        ("data.csv --inputs x,x", "column 'x' is named twice"),
        ("data.csv --inputs x,v --outputs v", "column 'v' is both an input and an output"),
        ("data.csv --inputs x,w", "say which are the outputs"),
        ("bare.csv --outputs 1,2,3", "no inputs are left"),
        ("data.csv --method grid --radius 0.5", "--radius goes with --method subtractive, not grid"),
        ("data.csv --mfs 3", "--mfs goes with --method grid, not subtractive"),
        ("data.csv --clusters 3", "--clusters goes with --method fcm"),
        ("data.csv --rules 3 --radius 0.5", "--rules searches radius"),
        ("data.csv --rules 3 --no-fit", "leave --no-fit out"),
        ("data.csv --plot a.png", "it goes with --rules"),
        ("data.csv --rules 3 --plot a.gif", "end it in .png"),
        ("data.csv --method grid --mfs a", "expected a whole number, got 'a'"),
        ("data.csv --method grid --kind sigmf", "unknown kind of membership function"),
        ("data.csv --reject 0.9", "reject (0.9) must not exceed accept (0.5)"),
        ("data.csv --radius 0", "radius must be >= 1e-06 and <= 1e+06"),
        ("data.csv --ridge 1e308", "ridge must be a number >= 0 and <= 1e+12, got 1e+308"),
        ("data.csv --radius 1e-308", "radius must be >= 1e-06 and <= 1e+06"),
        ("few.csv --rules 21", "none of the 108 settings gives 21 rules; found: "),
        ("none.csv", "none.csv"),
    ],
)
def test_refusals_name_the_option_and_leave_no_file(capsys, arguments, message) -> None:
    assert message in fails(capsys, f"identify {arguments}")


def test_search_refuses(capsys) -> None:
    assert "expected a number, got 'x'" in fails(capsys, "search data.csv --radii x")
    assert "end it in .png" in fails(capsys, "search data.csv --plot a.bmp")
