"""The page docs/howto/trees.md: its cells and commands run as written, in an empty folder."""

from pathlib import Path

import pytest

from tests.snippets import cells, run_commands, run_python, snippets

PAGE = Path(__file__).parents[4] / "docs" / "howto" / "trees.md"


@pytest.mark.long
def test_every_snippet_of_the_page_runs_in_order(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    run_python("\n".join(cells(PAGE)), "trees.md")
    said = capsys.readouterr().out
    for words in ("Tree('approach': wet, wear, distance -> v; 2 systems)", "speed takes friction from grip/friction"):
        assert words in said
    run_commands(next(text for kind, text in snippets(PAGE) if kind == "sh"))
    assert {path.name for path in (tmp_path / "firmware").iterdir()} == {
        f"approach{of}.{end}" for of in ("", "_grip", "_speed") for end in "ch"
    }
