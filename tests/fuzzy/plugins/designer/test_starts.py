"""What new rule bases begin with: the registry, the starts themselves, and the command that makes them."""

import json
from importlib.metadata import EntryPoint

import numpy as np
import pytest

import fuzzy
from fuzzy.commands.application import main
from fuzzy.insight.diagnosis import check
from fuzzy.plugins.designer.folder import open_folder
from fuzzy.plugins.designer.starting import make
from fuzzy.plugins.designer.starts import catalogue
from fuzzy.plugins.designer.starts.catalogue import find_starts
from fuzzy.plugins.designer.starts.grid import evenly, grid
from fuzzy.plugins.designer.starts.own import starts
from fuzzy.plugins.designer.starts.samples import example_table
from fuzzy.plugins.designer.starts.start import Start, StartError
from fuzzy.shown import shown

OWN = {start.name: start for start in starts()}


def only(monkeypatch, *values):
    points = [EntryPoint(value.split(":")[0].rpartition(".")[2], value, catalogue.START_GROUP) for value in values]
    monkeypatch.setattr(catalogue, "entry_points", lambda group: points)


def test_every_start_makes_a_system_without_errors_by_its_usual_options(monkeypatch):
    only(monkeypatch, "fuzzy.plugins.designer.starts.own:starts", "robotics.plugins.designer.starts:starts")
    found = find_starts()
    assert found.unusable == ()
    names = [start.name for start in found.starts]
    assert len(set(names)) == len(names)
    assert {
        "grid",
        "fuzzy-pd",
        "fuzzy-pi",
        "fuzzy-pid",
        "clusters",
        "data-grid",
        "tracking",
        "wall-follower",
        "crash",
        "formation/v_l",
    } <= {*names}
    groups = [start.group for start in found.starts]
    assert groups == sorted(groups, key=groups.index)  # those of a group stand together
    for start in found.starts:
        given = {option.name: example_table() for option in start.options if type(option).__name__ == "File"}
        fis = start.made(given, "mine")
        assert fis.rules
        # What ships from the thesis is as it was printed, gaps included.
        if start.group != "Shipped rule bases":
            assert [f.sentence for f in check(fis) if f.severity == "error"] == []
        assert fis.name == (fis.name if start.own_name else "mine")
        json.dumps(start.described())
        if start.example is not None:
            assert start.example().rules


def test_a_broken_entry_point_is_said_and_the_others_are_there(monkeypatch):
    only(
        monkeypatch,
        "fuzzy.plugins.designer.starts.own:starts",
        "no_such_package.starts:starts",
        "fuzzy.plugins.designer.starts.grid:names_of",
    )
    found = find_starts()
    assert {"grid", "clusters"} <= {start.name for start in found.starts}
    assert len(found.unusable) == 2
    assert all("cannot be used: " in sentence for sentence in found.unusable)
    only(monkeypatch, "fuzzy.plugins.designer.starts.own:starts", "fuzzy.plugins.designer.starts.own:starts")
    assert "there is another start 'grid'" in find_starts().unusable[0]


@pytest.mark.parametrize("shape", ["trimf", "gaussmf", "trapmf", "gbellmf"])
def test_evenly_spread_terms_have_the_closed_form(shape):
    low, high, n = -2.0, 4.0, 5
    terms = list(evenly(shape, low, high, n).values())
    x = np.linspace(low, high, 2001)
    centers, step = low + np.arange(n) * (high - low) / (n - 1), (high - low) / (n - 1)
    far = np.abs(x - centers[:, None]) / step  # in steps
    expected = {
        "trimf": np.clip(1 - far, 0, None),
        "gaussmf": 0.5 ** ((2 * far) ** 2),
        "trapmf": np.clip((0.7 - far) / 0.4, 0, 1),
        "gbellmf": 1 / (1 + (2 * far) ** 4),
    }[shape]
    assert np.allclose([term(x) for term in terms], expected, atol=1e-9)
    if shape == "trimf":
        assert np.allclose(sum(term(x) for term in terms), 1)


def test_an_empty_grid_has_a_rule_for_each_combination():
    fis = grid(3, 2, 4, "trimf", 0.0, 9.0)
    assert len(fis.rules) == 64
    assert len({rule.when for rule in fis.rules}) == 64
    assert [float(term.value) for term in fis.outputs[0].terms.values()] == [0, 3, 6, 9]
    assert fis([[1.0, 5.0, 8.5]]).tolist() == [[3.0, 3.0]]  # all say the lower of the two middle terms


@pytest.mark.parametrize(
    ("name", "given", "said"),
    [
        ("grid", {"terms": "9", "inputs": 6}, "make 531441 rules, more than 2000"),
        ("grid", {"low": 1, "high": "1"}, "low must lie below high"),
        ("grid", {"terms": "two"}, "terms must be a whole number >= 2 and <= 9, got 'two'"),
        ("grid", {"terms": 2.5}, "terms must be a whole number"),
        ("grid", {"low": "nan"}, "low must be a number"),
        ("grid", {"shape": "trimff"}, "did you mean 'trimf'?"),
        ("grid", {"term": 3}, "did you mean 'terms'?"),
        ("clusters", {}, "clusters needs file=FILE.csv"),
        ("clusters", {"file": "none.csv"}, "there is no file 'none.csv'"),
        ("clusters", {"file": str(example_table()), "inputs": "q"}, "did you mean"),
        ("clusters", {"file": str(example_table()), "radius": 0}, "radius must be a number >= 0.05"),
        ("clusters", {"file": str(example_table()), "inputs": ["x"]}, "inputs must be names of columns"),
    ],
)
def test_what_cannot_be_used_is_said(name, given, said):
    with pytest.raises(fuzzy.errors.InputError) as error:
        OWN[name].made(given, "mine")
    assert said in str(error.value) or (said == "did you mean" and "'q'" in str(error.value))


def test_a_table_with_gaps_is_refused_or_its_bad_rows_left_out(tmp_path):
    text = "x [m],y,v [m/s]\n" + "".join(f"{k / 99},{k % 4},{(k / 99) ** 2}\n" for k in range(100)) + "3,,1\n"
    (tmp_path / "a.csv").write_text(text)
    given = {"file": tmp_path / "a.csv", "inputs": "x,y", "outputs": "v"}
    with pytest.raises(fuzzy.errors.InputError, match="line 102"):
        OWN["clusters"].made(given, "mine")
    fis = OWN["clusters"].made({**given, "bad": "skip"}, "mine")
    assert [(v.name, v.unit) for v in (*fis.inputs, *fis.outputs)] == [("x", "m"), ("y", ""), ("v", "m/s")]
    assert fis.inputs[0].universe == (0.0, 1.0)


def test_the_command_lists_makes_and_never_overwrites(tmp_path, capsys, monkeypatch):
    only(monkeypatch, "fuzzy.plugins.designer.starts.own:starts", "no_such_package.starts:starts")
    monkeypatch.chdir(tmp_path)
    assert main(["new"]) == 0
    said = capsys.readouterr()
    assert "Empty\n  grid " in said.out
    assert "terms=2 to 9 [3]" in said.out
    assert "no_such_package" in said.err
    assert main(["new", "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["starts"][0]["name"] == "grid"
    assert main(["new", "grid", "terms=5", "shape=gaussmf", "-o", "mine.fis"]) == 0
    assert "mine.fis: 25 rules, input1, input2 -> output1" in capsys.readouterr().out
    fis = fuzzy.read_fis("mine.fis")
    assert (fis.name, len(fis.inputs[0].terms)) == ("mine", 5)
    before = (tmp_path / "mine.fis").read_bytes()
    for arguments, said in (
        (["grid", "-o", "mine.fis"], "mine.fis exists already"),
        (["grit"], "did you mean 'grid'?"),
        (["grid", "terms"], "expected OPTION=VALUE"),
        (["grid", "terms=2", "terms=3"], "two values"),
        (["grid", "-o", "mine.txt"], ".fis"),
    ):
        assert main(["new", *arguments]) == 2
        assert said in " ".join(capsys.readouterr().err.replace("│", " ").split())
    assert (tmp_path / "mine.fis").read_bytes() == before


def test_control_tables_are_found_in_three_sizes():
    for kind, outputs in (("pd", ["u"]), ("pi", ["du"]), ("pid", ["u", "du"])):
        for terms in "357":
            fis = OWN[f"fuzzy-{kind}"].made({"terms": terms}, "mine")
            assert ([v.name for v in fis.outputs], len(fis.rules)) == (outputs, int(terms) ** 2)
            assert not [f for f in check(fis) if f.severity == "error"]
    with pytest.raises(StartError):
        OWN["fuzzy-pd"].made({"terms": 4}, "mine")


def test_a_start_that_reports_tells_how_far_it_is():
    told = []

    def make(report):
        report(0.5, "half")
        return grid(1, 1, 2, "trimf", 0, 1)

    start = Start("slow", "Mine", "Slow", "Takes long.", make, reports=True)
    assert start.made({}, "mine", lambda *news: told.append(news)).name == "mine"
    assert told == [(0.5, "half")]
    with pytest.raises(StartError):
        start.made({"a": 1}, "mine")


def test_what_is_made_from_a_table_says_how_far_it_is_off(tmp_path):
    rows = np.random.default_rng(3).uniform(-1.0, 1.0, (60, 2))
    y = np.abs(rows[:, 0]) + rows[:, 1]
    table = tmp_path / "plant.csv"
    lines = [f"{a!r},{b!r},{c!r}" for (a, b), c in zip(rows.tolist(), y.tolist(), strict=True)]
    table.write_text("u,v,flow [l/min]\n" + "\n".join(lines) + "\n")
    made = make("data-grid", {"file": table, "terms": 2, "order": "0"}, "mine")
    off = np.sqrt(np.mean((made.fis(rows)[:, 0] - y) ** 2))
    assert off > 0.05
    assert made.warnings[-1] == f"RMSE {shown(off)} l/min in flow, on the 60 rows of plant.csv that it was made from"
    assert not any("RMSE" in said for said in make("grid", {}, "mine").warnings)


def test_a_file_of_the_folder_is_called_by_its_name_alone(tmp_path):
    there = open_folder(tmp_path)
    assert there.without_place(f"{there.path}/a/b.csv, line 3: no number") == "a/b.csv, line 3: no number"
    assert there.without_place("/elsewhere/b.csv: no number") == "/elsewhere/b.csv: no number"
