import io
import json
import os
import signal
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import fuzzy.commands.show
from fuzzy.commands.application import main
from fuzzy.figures import figureset
from fuzzy.files.fisfile import format_fis, read_fis, write_fis
from fuzzy.files.table import table_text
from fuzzy.insight.surfacegrid import surface
from fuzzy.language import parse_rule
from fuzzy.membership import Gaussian, Trapezoid
from fuzzy.plugins.mamdani.likeness import mamdani_difference, read_mamdani_original
from fuzzy.system import Linear, Sugeno, Variable

CORPUS = Path(__file__).parents[2] / "data" / "fis-corpus"
FIS = Sugeno(
    [
        Variable("distance", (0, 4), {"near": Trapezoid(-1, -1, 1, 3), "far": Trapezoid(1, 3, 5, 5)}, "m"),
        Variable("bearing", (-1, 1), {"left": Trapezoid(-3, -2, -0.5, 0.5), "right": Trapezoid(-0.5, 0.5, 2, 3)}),
    ],
    [
        Variable("v", (0, 1), {"slow": 0.25, "fast": 1.0}, "m/s"),
        Variable("w", (-2, 2), {"cw": -1.0, "line": Linear([0.0, 2.0], 0.0)}),
    ],
    [
        "if distance is near then v is slow",
        "if distance is far then v is fast",
        "if bearing is right then w is cw",
        "if bearing is left then w is line",
        "if bearing is not right then w is line with 0.5",
    ],
    name="drive",
)


@pytest.fixture
def fis(tmp_path, monkeypatch) -> str:
    monkeypatch.chdir(tmp_path)
    write_fis(FIS, tmp_path / "drive.fis")
    return "drive.fis"


def folder() -> list[str]:
    return sorted(path.name for path in Path().iterdir())


def fails(capsys, *arguments: str) -> str:
    """Run the command line, which must end with 2 and print nothing but its message."""
    assert main(arguments) == 2
    said = capsys.readouterr()
    assert said.out == ""
    assert "Traceback" not in said.err
    assert said.err.count("fuzzy: ") + said.err.count("fuzzy " + arguments[0] + ": ") == 1
    return said.err


def succeeds(capsys, *arguments: str, code: int = 0, err: str = "") -> str:
    assert main(arguments) == code
    said = capsys.readouterr()
    assert said.err == err
    return said.out


def as_json(capsys, *arguments: str, code: int = 0) -> dict:
    data = json.loads(succeeds(capsys, *arguments, "--json", code=code), parse_constant=pytest.fail)
    assert isinstance(data, dict)
    return data


def test_show(fis, capsys) -> None:
    said = succeeds(capsys, "show", fis)
    assert "drive: 2 inputs, 2 outputs, 5 rules" in said
    assert "input distance [0 4] m" in said
    assert "  near  trapmf [-1 -1 1 3]" in said
    assert "  line  2 bearing" in said
    assert "  3. if bearing is right then w is cw" in said
    data = as_json(capsys, "show", fis)
    assert data["inputs"][1]["terms"][0] == {"name": "left", "type": "trapmf", "parameters": [-3, -2, -0.5, 0.5]}
    assert data["outputs"][1]["terms"][1]["type"] == "linear"
    assert data["rules"][4]["when"] == [{"input": "bearing", "term": "right", "not": True, "power": 1.0}]


def test_rules_read_back(fis, capsys) -> None:
    inputs = {v.name: tuple(v.terms) for v in FIS.inputs}
    outputs = {v.name: tuple(v.terms) for v in FIS.outputs}
    lines = succeeds(capsys, "rules", fis).splitlines()
    assert tuple(parse_rule(line, inputs, outputs) for line in lines) == FIS.rules
    assert as_json(capsys, "rules", fis) == {"rules": lines}


@pytest.mark.parametrize(
    "arguments",
    [
        ["plot"],
        ["plot", "--variable", "distance"],
        ["plot", "--kind", "rules", "--at", "distance=2", "--only-fired"],
        ["plot", "--kind", "structure"],
        ["surface"],
        ["surface", "--inputs", "bearing", "--output", "w", "--at", "distance=3"],
        ["surface", "--kind", "3d", "--points", "5"],
    ],
)
def test_pictures(fis, capsys, arguments: list[str]) -> None:
    command, *options = arguments
    assert succeeds(capsys, command, fis, "-o", "a.svg", *options) == "a.svg\n"
    assert "<svg" in Path("a.svg").read_text()
    assert folder() == ["a.svg", "drive.fis"]


def test_all_pictures_go_into_a_zip_or_a_folder(fis, capsys, monkeypatch) -> None:
    asked = []
    monkeypatch.setattr(figureset, "picture_bytes", lambda *args: asked.append(args[2:]) or b"<svg/>")
    monkeypatch.setattr(figureset, "entry_points", lambda group: [])  # what plug-ins add is theirs to test
    assert succeeds(capsys, "plot", fis, "--all") == "drive-figures.zip\n"
    assert asked == [((2.0, 0.0), "pdf")] * (2 + 2 + 1 + 1 + 2)  # terms, consequents, viewer, structure, surfaces
    said = as_json(capsys, "plot", fis, "--all", "--format", "svg", "--at", "distance=3", "-o", "set")
    assert asked[-1] == ((3.0, 0.0), "svg")
    assert said["file"] == "set"
    assert sorted(said["files"]) == sorted(path.name for path in Path("set").iterdir())
    assert folder() == ["drive-figures.zip", "drive.fis", "set"]


def test_a_picture_has_a_name_of_its_own(fis, capsys) -> None:
    assert succeeds(capsys, "plot", fis, "--kind", "structure") == "drive-structure.png\n"
    assert Path("drive-structure.png").read_bytes().startswith(b"\x89PNG")
    assert as_json(capsys, "plot", fis) == {"file": "drive-memberships.png"}


def test_surface_prints_its_numbers(fis, capsys) -> None:
    data = as_json(capsys, "surface", fis, "--inputs", "bearing,distance", "--output", "w", "--points", "3")
    assert data["x"] == [-1, 0, 1]
    assert data["y"] == [0, 2, 4]
    assert data["z"] == surface(FIS, ("bearing", "distance"), "w", points=3).z.tolist()
    assert folder() == ["drive.fis"]


def test_explain(fis, capsys) -> None:
    said = succeeds(capsys, "explain", fis, "bearing=0.25", "distance=1.5")
    assert "distance = 1.5 m is near (0.75), far (0.25)" in said
    assert "rule 1 fires 0.75: if distance is near then v is slow" in said
    assert f"v = {0.75 * 0.25 + 0.25 * 1.0:.4g} m/s" in said
    data = as_json(capsys, "explain", fis, "bearing=0.25", "distance=1.5")
    assert data["outputs"]["v"] == pytest.approx(0.4375)
    assert data["rules"][0]["share"] == {"v": pytest.approx(0.75), "w": None}


def test_check_passes_and_fails(fis, capsys) -> None:
    assert succeeds(capsys, "check", fis) == "nothing found\n"
    assert as_json(capsys, "check", fis) == {"ok": True, "findings": []}
    write_fis(Sugeno(FIS.inputs, FIS.outputs, FIS.rules[1:]), "gap.fis")
    said = succeeds(capsys, "check", "gap.fis", code=1)
    assert "warning: no rule for v fires in about 25 % of the input space" in said
    assert "where distance is 0 to 1 m" in said
    data = as_json(capsys, "check", "gap.fis", code=1)
    assert not data["ok"]
    assert data["findings"][0]["where"] == ["v"]


def test_notes_do_not_fail_a_check(fis, capsys) -> None:
    extra = Variable("v", (0, 1), {**FIS.outputs[0].terms, "unused": 0.5}, "m/s")
    write_fis(Sugeno(FIS.inputs, [extra, FIS.outputs[1]], FIS.rules), "notes.fis")
    assert "note: no rule uses unused of v" in succeeds(capsys, "check", "notes.fis")


X = np.array([[1.5, 0.25], [0.0, -1.0], [4.0, 1 / 3]])


def numbers(text: str) -> np.ndarray:
    return np.array([[float(field) for field in line.split(",")] for line in text.splitlines()])


def test_evaluate_by_position(fis, capsys) -> None:
    Path("x.csv").write_text("".join(f"{a!r},{b!r}\n" for a, b in X.tolist()))
    said = succeeds(capsys, "evaluate", fis, "x.csv")
    assert np.array_equal(numbers(said), FIS(X))
    assert succeeds(capsys, "evaluate", fis, "x.csv", "-o", "y.csv") == ""
    assert Path("y.csv").read_text() == said
    data = as_json(capsys, "evaluate", fis, "x.csv")
    assert data == {"rows": 3, "skipped": 0, "outputs": {"v": FIS(X)[:, 0].tolist(), "w": FIS(X)[:, 1].tolist()}}


def test_evaluate_by_header(fis, capsys) -> None:
    Path("x.csv").write_text("bearing,distance\n" + "".join(f"{b!r},{a!r}\n" for a, b in X.tolist()))
    header, _, rest = succeeds(capsys, "evaluate", fis, "x.csv").partition("\n")
    assert header == ",".join(v.label for v in FIS.outputs)
    assert np.array_equal(numbers(rest), FIS(X))


def test_evaluate_with_other_columns(fis, capsys) -> None:
    Path("x.csv").write_text("bearing,note,distance\n0.25,7,1.5\n")
    said = succeeds(capsys, "evaluate", fis, "x.csv", err="ignored: note\n")
    assert np.array_equal(numbers(said.partition("\n")[2]), FIS(X[:1]))
    Path("x.csv").write_text("one,two\n1.5,0.25\n")
    said = succeeds(
        capsys,
        "evaluate",
        fis,
        "x.csv",
        err="the header names no input: the columns are taken to be distance, bearing\n",
    )
    assert np.array_equal(numbers(said.partition("\n")[2]), FIS(X[:1]))


def test_evaluate_in_portions_warns_once(fis, capsys) -> None:
    x = np.column_stack([np.full(100_001, 4.5), np.linspace(-1, 1, 100_001)])
    np.savetxt("x.csv", x, delimiter=",", fmt="%.17g")
    assert main(["evaluate", fis, "x.csv", "-o", "y.csv"]) == 0
    said = capsys.readouterr().err
    assert said.startswith("warning: drive: input distance outside [0 4]; evaluated without clipping")
    assert said.count("warning: ") == said.count("\n") == 1
    y = np.loadtxt("y.csv", delimiter=",")
    assert y.shape == (100_001, 2)
    assert y[60_000, 1] == FIS(np.clip(x[60_000], -1, 4))[1]


def test_nan_is_null_in_json(fis, capsys) -> None:
    write_fis(Sugeno(FIS.inputs[:1], FIS.outputs[:1], [FIS.rules[0]], no_rule_fires="nan"), "gap.fis")
    Path("x.csv").write_text("1\n4\n")
    assert main(["evaluate", "gap.fis", "x.csv", "--json"]) == 0
    said = capsys.readouterr()
    assert json.loads(said.out, parse_constant=pytest.fail) == {"rows": 2, "skipped": 0, "outputs": {"v": [0.25, None]}}
    assert said.err.startswith("warning: fuzzy: no rule fires for output v")
    assert said.err.count("\n") == 1


def test_convert(fis, capsys) -> None:
    for suffix in ("fis", "txt", "json"):
        assert succeeds(capsys, "convert", fis, f"out.{suffix}") == ""
    assert read_fis("out.fis") == read_fis(fis)
    assert Path("out.txt").read_text().splitlines() == [str(rule) for rule in FIS.rules]
    assert json.loads(Path("out.json").read_text()) == as_json(capsys, "show", fis)
    said = fails(capsys, "convert", fis, "out.xml")
    assert "'out.xml'" in said
    for form in (".fis", ".txt", ".json"):
        assert form in said


def test_a_system_of_standard_input(fis, capsys, monkeypatch) -> None:
    of_file = succeeds(capsys, "show", fis)
    for command in ("show", "check"):
        monkeypatch.setattr("sys.stdin", io.TextIOWrapper(io.BytesIO(Path(fis).read_bytes())))
        assert main([command, "-"]) in (0, 1)
        said = capsys.readouterr()
        assert said.err == ""
        assert command != "show" or said.out == of_file
    monkeypatch.setattr("sys.stdin", io.TextIOWrapper(io.BytesIO(b"[System")))
    assert "standard input:1: " in fails(capsys, "show", "-")
    monkeypatch.setattr("sys.stdin", io.TextIOWrapper(io.BytesIO(Path(fis).read_bytes())))
    assert succeeds(capsys, "plot", "-") == "stdin-memberships.png\n"


def test_explain_takes_a_decimal_comma_and_warns_outside(fis, capsys) -> None:
    with_comma = succeeds(capsys, "explain", fis, "distance=3,5", "bearing=0")
    assert with_comma == succeeds(capsys, "explain", fis, "distance=3.5", "bearing=0")
    assert "trust" not in with_comma
    said = succeeds(capsys, "explain", fis, "distance=30", "bearing=0")
    assert "; it lies outside [0 4], where no rule is meant: do not trust the answer\n" in said


def test_convert_without_hedges(tmp_path, monkeypatch, capsys) -> None:
    monkeypatch.chdir(tmp_path)
    x = Variable("x", (0, 1), {"a": Gaussian(0.5, 0)})
    hedged = Sugeno([x], [Variable("y", (0, 1), {"z": 1.0})], ["if x is very a then y is z"])
    Path("hedged.fis").write_text(format_fis(hedged))
    assert main(["convert", "hedged.fis", "again.fis"]) == 0
    assert capsys.readouterr().err.startswith("warning: again.fis: MATLAB cannot read the hedges")
    assert succeeds(capsys, "convert", "hedged.fis", "plain.fis", "--without-hedges") == ""
    assert str(read_fis("plain.fis").rules[0]) == "if x is very_a then y is z"


def test_convert_a_mamdani_system(tmp_path, monkeypatch, capsys) -> None:
    monkeypatch.chdir(tmp_path)
    text = (CORPUS / "m02_auvsl_rgator.fis").read_text()
    Path("old.fis").write_text(text)
    assert "fuzzy convert" in fails(capsys, "show", "old.fis")
    said = succeeds(capsys, "convert", "old.fis", "new.fis")
    assert "- v is low: the set trimf [7.5 22.5 30] became the constant 20, its centroid" in said.splitlines()
    assert [term.value for term in read_fis("new.fis")["v"].terms.values()] == [20, 7.5]
    # Neither under its own name nor by a link is the Mamdani system replaced.
    Path("link.fis").symlink_to("old.fis")
    for target in ("old.fis", "link.fis", "./old.fis"):
        assert "would be lost" in fails(capsys, "convert", "old.fis", target)
    assert Path("old.fis").read_text() == text


def test_convert_tells_how_far_the_systems_are_apart(tmp_path, monkeypatch, capsys) -> None:
    monkeypatch.chdir(tmp_path)
    old = CORPUS / "m05_kzafeiroudi_smf.fis"
    told = as_json(capsys, "convert", str(old), "new.fis", "--fit", "planes")
    (before,), (after,) = told["difference"], told["fitted difference"]
    assert after["root_mean_square"] < 0.6 * before["root_mean_square"]
    assert mamdani_difference(read_mamdani_original(old), read_fis("new.fis"))[0]._asdict() == pytest.approx(after)
    said = succeeds(capsys, "convert", str(old), "new.fis")
    assert f"speed: greatest {before['greatest']:.2%}, mean {before['mean']:.2%}" in said
    # What least squares makes worse in another measure is said.
    said = succeeds(capsys, "convert", str(old), "new.fis", "--fit", "constants")
    assert "Fitting made the mean difference of speed worse." in said
    assert "--fit is for Mamdani systems" in fails(capsys, "convert", "new.fis", "newer.fis", "--fit", "planes")
    assert not Path("newer.fis").exists()
    Path("odd.fis").write_text(old.read_text().replace("AggMethod='max'", "AggMethod='mean'"))
    assert "not measured: fuzzy" not in succeeds(capsys, "convert", "odd.fis", "new.fis")
    assert "aggregation" in fails(capsys, "convert", "odd.fis", "new.fis", "--fit", "planes")


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["show", "none.fis"], ["none.fis", "No such file"]),
        (["show", "."], ["directory"]),
        (["show", "bad.fis"], ["bad.fis"]),
        (["explain", "drive.fis", "distance=1"], ["no value for bearing"]),
        (["explain", "drive.fis", "distance=1", "baring=0"], ["unknown input 'baring'; did you mean 'bearing'"]),
        (["explain", "drive.fis", "distance=1", "distance=2"], ["two values for the input 'distance'"]),
        (["explain", "drive.fis", "distance=one", "bearing=0"], ["'distance' must be a finite number: 'one'"]),
        (["explain", "drive.fis", "distance=1,234", "bearing=0"], ["'distance' holds '1,234', of which the comma may"]),
        (["show", "drve.fis"], ["drve.fis: cannot be read: No such file or directory; did you mean 'drive.fis'?"]),
        (
            ["explain", "drive.fis", "distance=inf", "bearing=0"],
            ["must be a finite number: 'inf' is not finite"],
        ),
        (["explain", "drive.fis", "distance"], ["expected INPUT=VALUE, got 'distance'"]),
        (["plot", "drive.fis", "-o", "a.gif"], ["'a.gif'", ".png, .pdf or .svg"]),
        (["plot", "drive.fis", "-o", "no/a.png"], ["no/a.png", "there is no folder"]),
        (["plot", "drive.fis", "--variable", "speed"], ["unknown variable 'speed'", "distance, bearing, v, w"]),
        (["plot", "drive.fis", "--all", "-o", "a.pdf"], ["a .zip file or a folder, not into 'a.pdf'"]),
        (["plot", "drive.fis", "--all", "--kind", "rules"], ["--all draws everything; it goes with --at, --format"]),
        (["plot", "drive.fis", "--format", "svg"], ["--format goes with --all"]),
        (["plot", "drive.fis", "--at", "distance=1"], ["--at and --only-fired go with --kind rules"]),
        (["plot", "drive.fis", "--kind", "pie"], ["'pie'", "memberships"]),
        (["surface", "drive.fis", "--inputs", "distance,distance"], ["one or two different inputs"]),
        (["surface", "drive.fis", "--at", "distance=1"], ["'distance' cannot both be held and be an axis"]),
        (["surface", "drive.fis", "--points", "1"], ["--points", "2"]),
        (["evaluate", "drive.fis", "none.csv"], ["none.csv", "No such file"]),
        (
            ["evaluate", "drive.fis", "text.csv"],
            ["text.csv: 1 of 2 rows has no number in column 2", "(line 2: 'two'); --skip-bad"],
        ),
        (["evaluate", "drive.fis", "three.csv"], ["three.csv: 3 columns, but drive has 2 inputs: distance, bearing"]),
        (["evaluate", "drive.fis", "part.csv"], ["part.csv: the header names distance, but not bearing"]),
        (["evaluate", "drive.fis", "good.csv", "-o", "no/y.csv"], ["no/y.csv", "there is no folder"]),
        (["convert", "drive.fis", "no/y.txt"], ["no/y.txt", "there is no folder"]),
        (["convert", "drive.fis"], ["Missing argument 'OUT'"]),
        (["check", "drive.fis", "--seed", "x"], ["--seed", "must be a whole number"]),
        (["paint", "drive.fis"], ["No such command 'paint'"]),
        (["show", "drive.fis", "--loud"], ["--loud"]),
    ],
)
def test_expected_errors_are_one_message_and_exit_2(fis, capsys, arguments: list[str], words: list[str]) -> None:
    Path("bad.fis").write_text("this is\nno system\n")
    Path("text.csv").write_text("1,2\n1,two\n")
    Path("three.csv").write_text("1,2,3\n")
    Path("part.csv").write_text("distance,baring\n1,2\n")
    Path("good.csv").write_text("1,0\n")
    before = folder()
    said = " ".join(fails(capsys, *arguments).split())
    for word in words:
        assert word in said
    assert folder() == before


def test_a_bug_is_no_expected_error(fis, monkeypatch) -> None:
    def broken(_: Path) -> Sugeno:
        raise ValueError("a bug")

    monkeypatch.setattr(fuzzy.commands.show, "read_system", broken)
    with pytest.raises(ValueError, match="a bug"):
        main(["show", fis])


def test_an_interrupt_exits_130(fis, monkeypatch) -> None:
    def interrupted(_: Path) -> Sugeno:
        raise KeyboardInterrupt

    monkeypatch.setattr(fuzzy.commands.show, "read_system", interrupted)
    assert main(["show", fis]) == 130


def process(*arguments: str, **options) -> subprocess.CompletedProcess:
    return subprocess.run(
        [sys.executable, "-m", "fuzzy", *arguments], capture_output=True, text=True, timeout=60, **options
    )


def test_as_a_process(fis) -> None:
    done = process("check", fis)
    assert (done.returncode, done.stdout, done.stderr) == (0, "nothing found\n", "")
    done = process("show", "none.fis")
    assert (done.returncode, done.stdout) == (2, "")
    assert done.stderr.startswith("fuzzy: none.fis")
    done = process("--version")
    assert done.stdout.startswith("fuzzyfleet ")


def test_a_terminal_without_the_characters(fis) -> None:
    write_fis(
        Sugeno([Variable("Hız", (0, 1), FIS.inputs[0].terms)], FIS.outputs[:1], ["if Hız is near then v is slow"]),
        "a.fis",
    )
    done = process("rules", "a.fis", env={**os.environ, "PYTHONIOENCODING": "ascii"})
    assert (done.returncode, done.stderr) == (0, "")
    assert done.stdout == "if H\\u0131z is near then v is slow\n"


@pytest.mark.skipif(os.name != "posix", reason="pipes end differently elsewhere")
def test_a_reader_that_goes_away(fis) -> None:
    Path("x.csv").write_text("1,0\n" * 50_000)
    command = [sys.executable, "-m", "fuzzy", "evaluate", fis, "x.csv"]
    # Unbuffered, Python itself drops what a closing pipe did not take, and says nothing.
    environment = {**os.environ, "PYTHONUNBUFFERED": ""}
    with subprocess.Popen(
        command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, env=environment
    ) as running:
        assert running.stdout is not None
        assert running.stderr is not None
        assert running.stdout.readline() == table_text(None, FIS([[1.0, 0.0]]))
        running.stdout.close()
        assert running.stderr.read() == ""
        assert running.wait(60) == 128 + signal.SIGPIPE


def test_help_needs_no_heavy_library() -> None:
    program = (
        "import sys; from fuzzy.commands.application import main; assert main(['--help']) == 0; "
        "print([m for m in ('matplotlib', 'pandas', 'torch', 'numba', 'scipy') if m in sys.modules])"
    )
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True)
    assert done.stdout.endswith("[]\n")
