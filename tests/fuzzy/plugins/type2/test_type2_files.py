"""Files of type-2 systems, MATLAB's script of one, and the commands that take them."""

import re

import numpy as np
import pytest

import fuzzy
from fuzzy.commands.application import main
from fuzzy.plugins.type2.files import type2_of
from tests.fuzzy.plugins.type2.drawn import drawn


def test_systems_survive_writing_and_reading(tmp_path):
    rng = np.random.default_rng(3)
    for number in range(20):
        fis = drawn(rng)
        fuzzy.write_fis(fis, tmp_path / "a.fis", "A title")
        assert fuzzy.read_type2(tmp_path / "a.fis") == fis, number


def test_the_text_without_comments_is_that_of_the_upper_system():
    fis = fuzzy.to_type2(fuzzy.read_fis(fuzzy.find_fis("tracking")), (0.1, 0.2), 0.9, "iasc")
    lines = fuzzy.format_fis(fis).splitlines()
    upper = fuzzy.format_fis(fis.upper).splitlines()
    assert [line for line in lines if not line.startswith(("%! TypeR", "%! Low"))] == upper
    assert sum(line.startswith("%! Lower=[0.9 0.1 0.2") for line in lines) == len(fis.inputs)
    assert "%! TypeReduction='iasc'" in lines


def test_a_type_1_reader_says_who_reads_it(tmp_path):
    fis = drawn(np.random.default_rng(0))
    fuzzy.write_fis(fis, tmp_path / "a.fis")
    with pytest.raises(fuzzy.Type2Error, match=r"a\.fis:2: .*fuzzy\.read_type2"):
        fuzzy.read_fis(tmp_path / "a.fis")
    fuzzy.write_fis(fis.upper, tmp_path / "b.fis")
    with pytest.raises(fuzzy.FisFileError, match=r"b\.fis: this is a type-1 system; `fuzzy type2`"):
        fuzzy.read_type2(tmp_path / "b.fis")


TEXT = fuzzy.format_fis(drawn(np.random.default_rng(0)))
ROWS = re.search(r"%! Lower=(.*)", TEXT)[1]


@pytest.mark.parametrize(
    ("old", "new", "says"),
    [
        (ROWS, "[1 0 0]", "x: Lower must be [scale left-lag right-lag; ...], three numbers for each term"),
        (ROWS, ROWS.replace("; ", "; 1 ", 1), "three numbers for each term"),
        (ROWS, "[2" + ROWS[ROWS.index(" ") :], "(0, 1], got 2.0"),
        (ROWS, "[one" + ROWS[ROWS.index(" ") :], "could not convert string to float: 'one'"),
        ("'karnikmendel'", "'km'", "unknown type reduction 'km'"),
        ("Type='sugeno'", "Type='sugenotype2'", "convertToType1(fis)"),
    ],
)
def test_what_is_wrong_in_a_file_is_said(old, new, says):
    assert old in TEXT
    with pytest.raises(fuzzy.FisFileError, match=re.escape(says)) as raised:
        type2_of(TEXT.replace(old, new, 1).encode(), "a.fis")
    assert str(raised.value).startswith("a.fis:")


def test_the_script_sets_each_scale_and_lag_by_matlabs_documented_properties():
    fis = drawn(np.random.default_rng(1))
    lines = fuzzy.matlab_type2(fis, "a.fis").splitlines()
    assert lines[:2] == ["fis = convertToType2(readfis('a.fis'));", "fis.TypeReductionMethod = 'karnikmendel';"]
    told = re.findall(r"Inputs\((\d)\)\.MembershipFunctions\((\d)\)\.(\w+) = \[?(.*?)\]?;", "\n".join(lines[2:]))
    expected = []
    for i, variable in enumerate(fis.inputs, 1):
        for t, lower in enumerate(fis.lower[variable.name].values(), 1):
            expected += [(i, t, "LowerScale", [lower.scale]), (i, t, "LowerLag", [*lower.lag])]
    assert [(int(i), int(t), what, [*map(float, values.split())]) for i, t, what, values in told] == expected
    with pytest.raises(fuzzy.FuzzySystemError, match="MATLAB has no type reduction 'nietan'"):
        fuzzy.matlab_type2(fuzzy.to_type2(fis.upper, reduction="nietan"), "a.fis")


def test_commands_make_evaluate_and_draw_one(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)

    def run(*words: str) -> str:
        code = main(words)
        out, error = capsys.readouterr()
        assert code == 0, error
        return str(out)

    run("example", "tipper", "meals")
    assert (
        run("type2", "tipper.fis", "--lag", "0.3,0.1", "--scale", "0.8", "-o", "t2.fis", "--matlab") == "t2.fis\nt2.m\n"
    )
    fis = fuzzy.to_type2(fuzzy.read_fis("tipper.fis"), (0.3, 0.1), 0.8)
    assert fuzzy.read_type2("t2.fis") == fis
    table = run("evaluate", "t2.fis", "meals.csv").splitlines()
    meals = np.loadtxt("meals.csv", delimiter=",", skiprows=1)
    assert [float(line) for line in table[1:]] == pytest.approx(fis(meals[:, :2])[:, 0].tolist())
    assert run("plot", "t2.fis", "-o", "t2.png") == "t2.png\n"
    assert (tmp_path / "t2.png").stat().st_size > 5000
