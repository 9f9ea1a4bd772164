"""The proof that comes with every export, the table in place of rules, and the board."""

import json
import re
from dataclasses import replace

import numpy as np
import pytest

from fuzzy.commands.application import main
from fuzzy.files.fisfile import read_fis, read_mamdani, write_fis
from fuzzy.files.packaged import find_fis
from fuzzy.membership import Bell, Trapezoid, Triangle
from fuzzy.plugins.ccode.compiler import CompilerError
from fuzzy.plugins.ccode.cortexm import missing_tools, run_on_board
from fuzzy.plugins.ccode.lookup import lookup_of
from fuzzy.plugins.ccode.numbertype import ExportError
from fuzzy.plugins.ccode.verification import LIMITS, verify_c
from fuzzy.plugins.ccode.writing import write_c
from fuzzy.system import Sugeno, Variable
from tests.fuzzy.plugins.ccode.inc import CORPUS, PACKAGED, needs_compiler


@needs_compiler
def test_a_proof_holds_and_fails_for_other_c(tmp_path):
    fis = read_fis(find_fis("tracking"))
    files = write_c(fis, tmp_path)
    proof = verify_c(fis, files, 2000)
    assert proof.holds
    assert all(0 <= d.greatest <= LIMITS["double"] * d.scale for d in proof.differences)
    text = files.source.read_text()
    files.source.write_text(text.replace("0.3", "0.30000001", 1))
    assert files.source.read_text() != text
    assert verify_c(fis, files, 2000).holds is False


@needs_compiler
def test_a_sanitizer_finds_what_no_difference_shows(tmp_path):
    fis = read_fis(find_fis("tracking"))
    files = write_c(fis, tmp_path)
    text = files.source.read_text()
    files.source.write_text(
        text.replace(
            "int told = 0;",
            "int told = 0;\n    volatile int k = 4;\n    volatile double kept = x[k];\n    (void)kept;",
        )
    )
    if not verify_c(fis, write_c(fis, tmp_path / "good"), 10).sanitized:
        pytest.skip("the compiler has no sanitizers")
    with pytest.raises(CompilerError, match="driver ended with"):
        verify_c(fis, files, 100)


@needs_compiler
def test_what_the_compiler_refuses_is_said(tmp_path):
    fis = read_fis(find_fis("tracking"))
    files = write_c(fis, tmp_path)
    files.source.write_text(files.source.read_text().replace("int told", "int unused, told"))
    with pytest.raises(CompilerError, match="unused"):
        verify_c(fis, files, 10)


@needs_compiler
@pytest.mark.parametrize("number", ["double", "float", "q16.16"])
def test_a_table_in_place_of_rules(number, tmp_path):
    fis = read_mamdani(next(f for f in CORPUS if f.stem.startswith("m02")))[0]
    files = write_c(fis, tmp_path, number, lookup=(33, 17))
    proof = verify_c(fis, files, 3000)
    for d, greatest in zip(proof.differences, files.lookup.greatest, strict=True):
        assert 0.1 * greatest < d.greatest <= 1.01 * greatest + 1e-3 * d.span
    assert "33 x 17 points" in files.header.read_text()


def test_a_finer_table_has_a_smaller_error_and_corners_are_exact():
    fis = read_mamdani(next(f for f in CORPUS if f.stem.startswith("m05")))[0]
    coarse, fine = lookup_of(fis, (9,)), lookup_of(fis, (65,))
    assert fine.mean[0] < coarse.mean[0] / 4
    corners = np.array([[v.universe[k] for v in fis.inputs] for k in (0, 1)])
    np.testing.assert_allclose(fine.answers(fis, corners), fis(corners), rtol=1e-12)


def test_what_no_table_can_be_is_refused():
    with pytest.raises(ExportError, match="one or two inputs"):
        lookup_of(read_fis(find_fis("tracking")), (9,))
    two = read_mamdani(next(f for f in CORPUS if f.stem.startswith("m02")))[0]
    with pytest.raises(ExportError, match=r"at least 2 .* got 1x5"):
        lookup_of(two, (1, 5))
    with pytest.raises(ExportError, match="65536 in all"):
        lookup_of(two, (3000, 3000))


@pytest.mark.skipif(bool(missing_tools()), reason="the tools for a Cortex-M are not here")
@pytest.mark.parametrize("number", ["float", "q16.16"])
def test_a_board_gives_the_same_answers(number, tmp_path):
    fis = read_fis(find_fis("tracking"))
    found = run_on_board(fis, write_c(fis, tmp_path, number))
    assert found.equal
    assert 500 < found.flash < 20_000
    assert 0 < found.ram < 2_000
    assert 100 < found.median <= found.instructions < 20_000


@needs_compiler
def test_the_command_writes_proves_and_says_so(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    assert main(["example", "tipper"]) == 0
    capsys.readouterr()
    assert main(["export", "c", "tipper.fis", "-o", "out", "--verify", "--points", "500", "--json"]) == 0
    report = json.loads(capsys.readouterr().out)
    assert report["proof"]["holds"] is True
    assert report["proof"]["points"] == 500
    assert {f.name for f in (tmp_path / "out").iterdir()} == {"tipper.h", "tipper.c"}
    assert main(["export", "c", "tipper.fis", "-o", "out", "--number", "q16.16", "--table", "17"]) == 0
    said = capsys.readouterr().out
    assert re.search(r"the table differs from the rules by [\d.]+ at most", said)


def faint(function):
    x = Variable("x", (0, 1), {"a": function})
    return Sugeno([x], [Variable("y", (-10, 10), {"z": -5.0})], ["if x is not a then y is z"])


@needs_compiler
def test_faint_strengths_in_fixed_point_are_a_verdict_and_name_the_point(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    write_fis(faint(Bell(0.5, 3, 0.5)), "faint.fis")
    arguments = ["export", "c", "faint.fis", "-o", "out", "--verify", "--points", "5000", "--number"]
    assert main([*arguments, "q16.16"]) == 1
    said = capsys.readouterr()
    assert ": NOT the same within 0.01" in said.out
    worst = r"y differs by 0.25 of its range of 20 at x = 0\.\d+; strengths below 1e-9 are 0 in fixed point"
    assert re.fullmatch(rf"warning: {worst}\n", said.err)
    assert main([*arguments, "double"]) == 0
    assert main([*arguments, "q16.16", "--table", "9"]) == 0  # a table has no limit


@needs_compiler
@pytest.mark.parametrize("at", [0.2, 0.25, 1 / 3])
def test_edges_and_feet_are_the_same_within_a_last_digit(at, tmp_path):
    for function in (Trapezoid(at, at, 0.6, 0.6), Triangle(at, 0.6, 1)):
        for fis in (faint(function), replace(faint(function), no_rule_fires="nan")):
            assert verify_c(fis, write_c(fis, tmp_path, "q16.16"), 5000).holds


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["--table", "0"], "at least 2 along each input"),
        (["--table", "a"], "takes a number of points N, or NxM"),
        (["--number", "int8"], "double"),
        (["-o", "tipper.fis"], "is a file, not a folder"),
    ],
)
def test_what_cannot_be_written_is_a_sentence(arguments, said, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    main(["example", "tipper"])
    given = ["export", "c", "tipper.fis", *([] if "-o" in arguments else ["-o", "out"]), *arguments]
    assert main(given) == 2
    assert said in capsys.readouterr().err
    assert not (tmp_path / "out").exists()


def test_without_a_compiler_it_is_written_and_not_verified(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    main(["example", "tipper"])
    monkeypatch.setenv("CC", "no-such-compiler")
    assert main(["export", "c", "tipper.fis", "-o", "out", "--verify"]) == 2
    assert "CC names 'no-such-compiler', which is not there" in capsys.readouterr().err
    assert (tmp_path / "out" / "tipper.c").is_file()


@needs_compiler
@pytest.mark.long
@pytest.mark.parametrize("file", [*CORPUS, *PACKAGED], ids=lambda f: f"{f.parent.name}-{f.stem}")
@pytest.mark.parametrize("number", ["double", "float", "q16.16"])
def test_a_million_points(number, file, tmp_path):
    fis = read_mamdani(file)[0]
    proof = verify_c(fis, write_c(fis, tmp_path, number))
    assert proof.points == 1_000_000
    assert proof.holds
    if number == "q16.16":
        assert max(d.greatest / d.scale for d in proof.differences) < 4e-4
