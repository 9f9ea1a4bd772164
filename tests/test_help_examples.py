"""Every example at the end of a --help runs as it is printed, in an empty folder, one after the other."""

import importlib

import pytest

from fuzzy.files.examples import EXAMPLES
from tests.helpexamples import helps, parse
from tests.snippets import run_commands

HELPS = {" ".join(each.words): each for each in helps()}
# Seconds each: `make check-all` runs them. What is not named here runs in a fraction of one.
LONG = {
    "fuzzy plot", "fuzzy surface", "fuzzy search", "fuzzy design",
    "anfis", "anfis train", "anfis predict", "anfis evaluate",
    "robotics", "robotics copy", "robotics run", "robotics repeat", "robotics compare", "robotics plot",
    "robotics explain", "robotics animate", "robotics certify", "robotics robot", "robotics sweep", "robotics study",
    "robotics identify", "robotics excite", "robotics team", "robotics tune", "robotics arena", "robotics reinforce",
    "robotics check", "robotics new", "robotics scenario", "robotics list",
    "fuzzy tune", "robotics dataset from-bag",
    "robotics dataset", "robotics dataset formation", "robotics dataset regenerate",
    "robotics stress", "robotics stress crossing", "robotics stress obstacles",
    "robotics learn", "robotics learn formation", "robotics learn rules",
}  # fmt: skip


@pytest.mark.parametrize("name", [pytest.param(n, marks=pytest.mark.long if n in LONG else ()) for n in HELPS])
def test_the_examples_of_a_help_run(name, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    if name == "fuzzy design":  # a server that never ends: what it is asked to serve is all that counts
        monkeypatch.setattr("fuzzy.plugins.designer.server.serve", lambda folder, name, *rest, **named: None)
    run_commands("\n".join(HELPS[name].examples))


def test_every_help_ends_with_examples_that_can_be_called():
    for name, each in HELPS.items():
        assert each.examples, name
        assert any(f"{line} ".startswith(f"{name} ") for line in each.examples), name
        for line in each.examples:
            parse(line.partition(" > ")[0])
        printed = each.command.make_context(name, ["-"], resilient_parsing=True).get_help()
        assert all(line in printed for line in each.examples), f"{name}: an example is wrapped"


def test_no_example_needs_a_file_that_none_writes():
    """Every file of ours is used by an example, beside those that write it."""
    lines = [line for each in HELPS.values() for line in each.examples if not line.startswith("fuzzy example")]
    for file in EXAMPLES:
        assert any(f" {file}" in line for line in lines), file


@pytest.mark.parametrize("words", [n.split() for n, each in HELPS.items() if getattr(each.command, "commands", None)])
def test_a_group_alone_shows_its_help(words, capsys):
    main = importlib.import_module(f"{words[0]}.commands.application").main
    assert main([*words[1:], "--help"]) == 0
    asked = capsys.readouterr().out
    assert main(words[1:]) == 2
    assert capsys.readouterr() == ("", asked)
