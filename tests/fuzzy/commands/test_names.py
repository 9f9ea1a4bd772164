"""The commands of ``fuzzy`` and ``anfis`` on packaged rule bases, by name; none of them writes into the package."""

import json
from pathlib import Path

import numpy as np
import pytest

import anfis.commands.application
from fuzzy.commands.application import main
from fuzzy.files.fisfile import read_fis
from fuzzy.files.table import write_table

OURS = Path(__file__).parents[3] / "robotics" / "data" / "rulebases"
TRACKING, V_L = OURS / "tracking.fis", OURS / "formation" / "v_l.fis"


@pytest.fixture(autouse=True)
def here(site, tmp_path, monkeypatch):
    """An empty folder to work in; the packaged rule bases must stay as they are."""
    before = {file: file.read_bytes() for file in OURS.rglob("*") if file.is_file()}
    monkeypatch.chdir(tmp_path)
    yield tmp_path
    assert {file: file.read_bytes() for file in OURS.rglob("*") if file.is_file()} == before


def said(capsys, *arguments: str, run=main) -> str:
    assert run(arguments) == 0
    out = capsys.readouterr()
    assert out.err == ""
    return out.out


@pytest.mark.parametrize(
    ("command", "rest"),
    [
        ("show", []),
        ("rules", []),
        ("explain", ["distance=0.2", "alpha=0.1", "x_err=0.2", "heading_err=0", "--json"]),
        ("surface", ["--json", "--points", "3"]),
    ],
)
def test_a_name_is_as_good_as_the_path(command, rest, capsys):
    by_name = said(capsys, command, "tracking", *rest)
    assert by_name == said(capsys, command, str(TRACKING), *rest) != ""


def test_check_by_name(capsys):
    assert main(["check", "formation/v_l", "--json"]) == main(["check", str(V_L), "--json"])
    first, second = capsys.readouterr().out.splitlines()
    assert json.loads(first) == json.loads(second)


def test_pictures_are_called_by_the_name(capsys):
    assert said(capsys, "plot", "formation/v_l", "--kind", "structure") == "formation-v_l-structure.png\n"
    assert said(capsys, "surface", "lateral") == "lateral-surface.png\n"
    assert said(capsys, "plot", str(V_L), "--kind", "structure") == "v_l-structure.png\n"
    assert sorted(path.name for path in Path().iterdir()) == [
        "formation-v_l-structure.png",
        "lateral-surface.png",
        "v_l-structure.png",
    ]


def test_tables_by_name(capsys):
    x = np.random.default_rng(0).uniform([-3, -0.3], [3, 0.3], (40, 2))
    write_table("x.csv", ["dx", "alpha_l"], x)
    expected = read_fis(V_L)(x)[:, 0]
    evaluated = json.loads(said(capsys, "evaluate", "formation/v_l", "x.csv", "--json"))
    predicted = json.loads(
        said(capsys, "predict", "formation/v_l", "x.csv", "--json", run=anfis.commands.application.main)
    )
    assert evaluated["outputs"] == predicted["outputs"] == {"v_l": expected.tolist()}
    write_table("xy.csv", ["dx", "alpha_l", "v_l"], np.column_stack([x, expected + 0.5]))
    arguments = ["evaluate", "formation/v_l", "xy.csv", "--json"]
    errors = json.loads(said(capsys, *arguments, run=anfis.commands.application.main))
    assert errors["outputs"]["v_l"]["rmse"] == pytest.approx(0.5)
    arguments = ["train", "xy.csv", "--start", "formation/v_l", "--epochs", "0", "-o", "v_l.fis", "-q", "--json"]
    said(capsys, *arguments, run=anfis.commands.application.main)
    assert len(read_fis("v_l.fis").rules) == 8


@pytest.mark.parametrize(
    ("run", "arguments", "written"),
    [
        (main, ["convert", "lateral", "lateral.fis"], "lateral.fis"),
        (main, ["convert", "lateral", "lateral"], None),
        (main, ["identify", "xy.csv", "--method", "grid", "-o", "lateral"], "lateral"),
        (main, ["plot", "lateral", "-o", "lateral"], None),
        (anfis.commands.application.main, ["train", "xy.csv", "--grid", "2", "--epochs", "0", "-o", "lateral"], None),
        (anfis.commands.application.main, ["predict", "lateral", "xy.csv", "-o", "lateral"], "lateral"),
    ],
)
def test_what_is_written_is_a_file_here(run, arguments, written):
    """The fixture sees to it that nothing packaged has changed."""
    t = np.linspace(-1, 1, 20)
    write_table("xy.csv", ["y_err", "y"], np.column_stack([t, t**2]))
    assert run(arguments) == (2 if written is None else 0)
    assert sorted(path.name for path in Path().iterdir()) == sorted({"xy.csv", written} - {None})


@pytest.mark.parametrize(
    ("arguments", "fragments"),
    [
        (["show", "traking"], ["unknown rule base 'traking'; did you mean 'tracking'?", "the path of a .fis file"]),
        (["plot", "formation"], ["unknown rule base 'formation'; did you mean 'formation/"]),
        (["rules", "tracking.fis"], ["the packaged rule base is called 'tracking', without .fis"]),
        (["design", "traking", "--no-browser"], ["did you mean 'tracking'?"]),
    ],
)
def test_an_unknown_name_is_one_sentence(arguments, fragments, capsys):
    if arguments[0] == "design":
        pytest.importorskip("nicegui", reason="the designer needs the extra design")
    assert main(arguments) == 2
    out, err = capsys.readouterr()
    assert out == ""
    assert err.count("\n") == 1
    for fragment in fragments:
        assert fragment in err


def test_the_designer_begins_with_a_copy(here, capsys, monkeypatch):
    """The page's document is a file of one's own, which is there once it is saved."""
    pytest.importorskip("nicegui", reason="the designer needs the extra design")
    from fuzzy.plugins.designer import server
    from fuzzy.plugins.designer.document import Document
    from fuzzy.plugins.designer.open_documents import OpenDocuments

    started = []

    def serve(folder, name, port, browser, begin=None):
        started.append((folder, name, begin))

    monkeypatch.setattr(server, "serve", serve)
    assert main(["design", "formation/v_l"]) == 0
    (here / "tracking.fis").write_bytes(V_L.read_bytes())
    assert main(["design", "tracking"]) == 0
    (here / "other").mkdir()
    assert main(["design", "tracking", "--folder", "other"]) == 0
    assert main(["design", "tracking.fis"]) == 0
    assert [(folder.path.name, name) for folder, name, _ in started] == [
        (here.name, "formation-v_l.fis"),
        (here.name, "tracking-2.fis"),  # what is here stays, and is opened by its path
        ("other", "tracking.fis"),
        (here.name, "tracking.fis"),
    ]
    assert [begin for _, _, begin in started] == [read_fis(V_L), read_fis(TRACKING), read_fis(TRACKING), None]
    folder, name, begin = started[1]
    opened = OpenDocuments(folder)
    assert opened.document(name, begin).design.system == begin
    opened.close()
    document = Document(name, folder.path, begin)
    assert document.design.system == begin
    assert not document.saved
    assert document.can_undo is None
    assert not (here / name).exists()
    document.apply({"edit": "remove_rule", "key": document.design.lines[0].key})
    document.discard()
    assert document.design.system == begin
    document.save()
    assert read_fis(here / name) == read_fis(TRACKING)
