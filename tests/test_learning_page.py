"""The page docs/howto/learn-from-a-table.md: its snippets run as written, in an empty folder."""

import re
from pathlib import Path

import pytest

from tests.snippets import run_commands, run_python, snippets

SNIPPETS = snippets(Path(__file__).parent.parent / "docs" / "howto" / "learn-from-a-table.md")


@pytest.mark.long  # seconds; tests/anfis/commands has a small version of each command
def test_every_snippet_of_the_page_runs_in_order(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("MPLBACKEND", "Agg")
    assert [kind for kind, _ in SNIPPETS] == ["sh", "python", "python", "python", "python"]
    run_commands(SNIPPETS[0][1])
    run_python("\n".join(text for _, text in SNIPPETS[1:]), "learn-from-a-table.md")
    said = capsys.readouterr().out
    for words in (
        "of 5 folds (shuffled)",
        "<- chosen",
        "samples were held back for the choice",
        "rules: ",
        "[False  True]",
    ):
        assert words in said
    assert (tmp_path / "rules.png").exists()
    error = {(n, rules): float(e) for n, rules, e in re.findall(r"(\d+) samples, +(\d+) rules: (\S+)", said)}
    assert len(error) == 6
    assert min(("4", "9", "16"), key=lambda rules: error["60", rules]) == "4"
    assert min(("4", "9", "16"), key=lambda rules: error["200", rules]) == "9"
