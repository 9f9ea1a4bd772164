"""``robotics dataset`` end to end, the files of datasets/, and the thesis's own systems."""

import csv
import json
import shutil
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from fuzzy.files.fisfile import read_fis
from robotics.commands.application import main
from robotics.plugins.thesis.printed_systems import ThesisTableError, thesis_system

DATASETS = Path(__file__).parents[4] / "datasets"
COMPUTED = [
    "formation-literal.csv",
    "formation-literal.card.md",
    "formation-literal-check.csv",
    "formation-literal-check.card.md",
    "formation-well-posed.csv",
    "formation-well-posed.card.md",
    "formation-well-posed-check.csv",
    "formation-well-posed-check.card.md",
    "thesis/network-1-v_l-as-printed.fis",
    "thesis/network-2-w_l-as-printed.fis",
    "thesis/network-3-v_f.fis",
    "thesis/network-4-w_f.fis",
]


def test_datasets_are_regenerated_byte_for_byte(tmp_path, capsys):
    shutil.copytree(DATASETS / "thesis", tmp_path / "thesis", ignore=shutil.ignore_patterns("*.fis"))
    assert main(["dataset", "regenerate", "--out", str(tmp_path)]) == 0
    assert capsys.readouterr().out.split() == [str(tmp_path / name) for name in COMPUTED]
    for name in COMPUTED:
        assert (tmp_path / name).read_bytes() == (DATASETS / name).read_bytes(), name


def test_every_file_of_datasets_is_described():
    for folder in (DATASETS, DATASETS / "thesis"):
        card = (folder / "README.md").read_text(encoding="utf-8")
        for file in folder.iterdir():
            assert file.is_dir() or file.name == "README.md" or f"`{file.name}`" in card, file
    assert not list(DATASETS.rglob("*.py"))


def test_formation_writes_the_same_file_twice_and_says_what_it_holds(tmp_path, capsys):
    files = [tmp_path / "a.csv", tmp_path / "b.csv"]
    options = ["--kind", "well-posed", "--samples", "20", "--formations", "-1,0.5", "--coverage", "0.5"]
    options += ["--jitter", "0.3", "--seed", "7"]
    for file in files:
        assert main(["dataset", "formation", *options, "-o", str(file)]) == 0
    assert files[0].read_bytes() == files[1].read_bytes()
    assert "40 rows, inputs dx, alpha_l, kappa_f, outputs v_l, w_l, v_f, w_f" in capsys.readouterr().out
    assert main(["dataset", "formation", *options[:-2], "--seed", "8", "-o", str(files[1])]) == 0
    assert files[0].read_bytes() != files[1].read_bytes()


def test_formation_json_is_one_object(tmp_path, capsys):
    file = tmp_path / "check.csv"
    assert main(["dataset", "formation", "--check", "--samples", "50", "-o", str(file), "--json"]) == 0
    about = json.loads(capsys.readouterr().out)
    assert (about["rows"], about["inputs"], about["check"]) == (50, ["x_l", "y_l", "theta_l"], True)
    assert about["scatter"] is None  # one formation alone never contradicts itself
    with file.open(encoding="utf-8") as lines:
        rows = list(csv.reader(lines))
    assert rows[0] == about["inputs"] + about["outputs"]
    assert [float(v) for v in rows[1][:2]] == [-1.0, 0.5]
    assert len(rows) == 51


def test_the_literal_sets_scatter_is_said_as_what_it_is(tmp_path, capsys):
    """An estimate with its range; no sentence that a network trained on the file contradicts."""
    file = tmp_path / "literal.csv"
    options = ["dataset", "formation", "--formations", "-2,2", "-o", str(file)]
    assert main([*options, "--json"]) == 0
    said = json.loads(capsys.readouterr().out)["scatter"]
    assert said["v_f"] == {"rms": 0.0, "least": 0.0, "most": 0.0}
    assert main(options) == 0
    text = capsys.readouterr().out
    for name in ("v_l", "w_l", "w_f"):
        assert 0 <= said[name]["least"] < said[name]["rms"] < said[name]["most"]
        assert f"{name} {said[name]['rms']:.4f} ({said[name]['least']:.4f} to {said[name]['most']:.4f})" in text
    assert "No function" not in text
    assert "errs by about that on fresh samples" in text
    assert main([*options, "--samples", "4"]) == 0
    assert "Gamma" not in capsys.readouterr().out  # too few to say


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (["-o", "a.txt"], "a.txt: the file's name must end in .csv"),
        (["-o", "a.csv", "--kind", "exact"], "--kind: 'exact' is not one of 'literal', 'well-posed'"),
        (["-o", "a.csv", "--kind", "wellposed"], "did you mean 'well-posed'?"),
        (["-o", "a.csv", "--jitter", "0.5"], "--jitter belongs to --kind well-posed"),
        (["-o", "a.csv", "--formations", "1,two"], "--formations must be numbers in m with commas"),
        (["-o", "a.csv", "--kind", "well-posed", "--formations", "1"], "--formations needs --coverage below 1"),
        (["-o", "a.csv", "--formations", "1", "--check"], "give it or --formations, not both"),
        (["-o", "a.csv", "--samples", "0"], "--samples must be a whole number >= 2 and <= 1000000; got 0"),
        (["-o", "a.csv", "--samples", str(10**20)], "--samples must be a whole number >= 2 and <= 1000000; got 1000"),
        (
            ["-o", "a.csv", "--followers", "2", "--samples", str(10**9)],
            "--samples must be a whole number >= 2 and <= 1000000",
        ),
        (["-o", "a.csv", "--speed", "3"], "speed must be a finite number in m/s"),
        (["-o", "no/such/folder/a.csv", "--samples", "2", "--formations", "5"], "no/such/folder"),
    ],
)
def test_wrong_options_are_said_in_one_message(options, message, capsys, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert main(["dataset", "formation", *options]) == 2
    error = capsys.readouterr().err
    assert message in error
    assert "Traceback" not in error
    assert not list(tmp_path.iterdir())


# The thesis's tables and systems ---------------------------------------------------------------------------------


def cells(name):
    with (DATASETS / "thesis" / name).open(encoding="utf-8") as lines:
        return list(csv.reader(lines))


def test_tables_are_as_printed():
    """Spot checks against the thesis, slips included; and the two tables of antecedents are the same numbers."""
    assert cells("table-2-1.csv")[1] == ["Conventional Sliding Mode", "0.0195", "0.0367", "0.0532", ".0780", "0.0898"]
    assert cells("table-5-1.csv")[2] == ["Trading Data Error", "7.997e-003", "2.011e-003", "8.287e-004", "2.757e-003"]
    assert cells("table-5-2.csv")[1:] == cells("table-5-3.csv")[1:]
    assert cells("table-5-2.csv")[2][-2:] == cells("table-5-2.csv")[3][-2:] == ["0.234", "0.1455"]
    assert cells("table-5-4.csv")[8][1:5] == ["0.00814", "-0.03152", "0.05042", "0.00193"]
    assert cells("table-5-5.csv")[1][1:5] == ["1.504", "32.85", "34.58", "-20.4"]
    assert cells("table-5-7.csv")[3][-2:] == [".27e-005", ".0056"]
    assert cells("table-5-8.csv")[1][1:5] == ["0993", ".2920", "2728", ".4981"]
    for number, shape in {2: (9, 13), 3: (9, 13), 4: (9, 9), 5: (9, 9), 7: (4, 9), 8: (4, 9)}.items():
        rows = cells(f"table-5-{number}.csv")
        assert {len(row) for row in rows} == {shape[1]}
        assert len(rows) == shape[0]


def along_the_curve(name, a=0.473, k=0.993, phase=0.035, x_end=2 * np.pi):
    """A system's output (n,) on y = a cos(k x + phase), and the curve's x and curvature."""
    x = np.linspace(0.0, x_end, 2001)
    slope = -a * k * np.sin(k * x + phase)
    points = np.stack([x, a * np.cos(k * x + phase), np.arctan(slope)], axis=-1)
    fis = replace(read_fis(DATASETS / "thesis" / f"{name}.fis"), out_of_range="ignore")
    return fis(points)[:, 0], x, -a * k * k * np.cos(k * x + phase) / (1 + slope**2) ** 1.5


def test_followers_networks_belong_to_the_printed_antecedents():
    v_f, _, _ = along_the_curve("network-3-v_f")
    assert v_f.mean() == pytest.approx(0.07, abs=0.005)
    assert v_f.std() < 0.03
    w_f, x, curvature = along_the_curve("network-4-w_f")
    there = x < 3.9
    assert np.sqrt(np.mean((w_f - 0.12 * curvature)[there] ** 2)) < 0.02


def test_leaders_networks_do_not():
    v_l, _, _ = along_the_curve("network-1-v_l-as-printed")
    assert v_l.std() > 0.5
    w_l, x, curvature = along_the_curve("network-2-w_l-as-printed")
    assert np.sqrt(np.mean((w_l - 0.12 * curvature)[x < 3.9] ** 2)) > 0.1


def test_systems_say_which_column_is_missing(tmp_path):
    shutil.copytree(DATASETS / "thesis", tmp_path / "thesis")
    table = tmp_path / "thesis" / "table-5-5.csv"
    table.write_text(table.read_text(encoding="utf-8").replace("network_4", "net_4"), encoding="utf-8")
    assert len(thesis_system(3, tmp_path / "thesis").rules) == 8
    with pytest.raises(ThesisTableError, match=r"table-5-5\.csv: columns 6 to 9 must be those of network_4"):
        thesis_system(4, tmp_path / "thesis")
