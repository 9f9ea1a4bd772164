"""The commands that take a tree's folder, and what those say that do not."""

import json

import pytest

import fuzzy
from fuzzy.commands.application import main
from fuzzy.plugins.ccode import verification
from tests.fuzzy.plugins.trees.test_tree import TREE


@pytest.fixture
def folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    TREE.write(tmp_path / "tree")
    return tmp_path


def test_commands_take_the_folder_and_the_file(folder, capsys):
    (folder / "rows.csv").write_text("wet,wear,distance\n0.2,0.4,0.9\n1,1,1\n")
    assert main(["evaluate", "tree", "rows.csv", "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["outputs"]["v"] == pytest.approx([0.6, 1.0])
    assert main(["show", "tree/tree.toml", "--json"]) == 0
    assert json.loads(capsys.readouterr().out) == json.loads(json.dumps(TREE.as_dict()))
    assert main(["show", "tree"]) == 0
    assert capsys.readouterr().out == TREE.describe() + "\n"
    assert main(["explain", "tree", "wet=0.2", "wear=0.4", "distance=0.9"]) == 0
    assert capsys.readouterr().out == f"{fuzzy.explain_tree(TREE, [0.9, 0.2, 0.4])}\n"
    assert main(["plot", "tree"]) == 0
    assert capsys.readouterr().out == "tree-tree.png\n"
    assert (folder / "tree-tree.png").exists()
    assert main(["export", "c", "tree", "-o", "out", "--number", "float", "--json"]) == 0
    written = json.loads(capsys.readouterr().out)
    assert written["number"] == "float"
    assert [written["header"], *(each["source"] for each in written["systems"])] == [
        f"out/{name}" for name in ("tree.h", "tree_grip.c", "tree_speed.c")
    ]
    assert "float" in (folder / "out" / "tree_grip.c").read_text()


def test_the_c_of_its_systems_is_proven_one_by_one(folder, capsys, monkeypatch):
    assert main(["export", "c", "tree", "-o", "out", "--verify", "--points", "500"]) == 0
    said = capsys.readouterr().out
    assert said.count("500 points") == said.count("the same within 4e-15") == 2
    monkeypatch.setitem(verification.LIMITS, "double", -1.0)
    assert main(["export", "c", "tree", "-o", "out", "--verify", "--points", "500"]) == 1
    assert capsys.readouterr().out.count("NOT the same") == 2


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["check", "tree"], "tree is a tree of systems: evaluate, explain"),
        (["plot", "tree", "--kind", "rules"], "of a tree its systems and their wires are drawn"),
        (["export", "c", "tree", "-o", "out", "--board"], "--table and --board are for single systems"),
        (["explain", "tree", "wet=0.2"], "no value for distance, wear"),
        (["explain", "tree", "v=1"], "unknown input 'v'"),
    ],
)
def test_what_a_tree_is_not_taken_for_is_said(words, said, folder, capsys):
    assert main(words) == 2
    assert said in capsys.readouterr().err
