"""The page docs/howto/tuning.md: its snippets run as written, in an empty folder."""

import re
from pathlib import Path

import pytest

from tests.snippets import run_commands, run_python, snippets

SNIPPETS = snippets(Path(__file__).parent.parent / "docs" / "howto" / "tuning.md", changed=False)


@pytest.mark.long
def test_every_snippet_of_the_page_runs_in_order(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("MPLBACKEND", "Agg")
    assert [kind for kind, _ in SNIPPETS] == ["sh", "toml", "sh", "python", "sh"]
    for kind, text in SNIPPETS:
        if kind == "sh":
            run_commands(text)
        elif kind == "toml":
            name = re.match(r"# (\S+\.toml)", text)
            (tmp_path / name[1]).write_text(text, encoding="utf-8")
        else:
            run_python(text, "tuning.md")
    said = capsys.readouterr().out
    for words in ("fuzzy:rule_base=tuned/tracking.fis", "unseen scenarios", "laws on the front", "rule 7+9.weight"):
        assert words in said
    named = {"history.csv", "tracking.fis", "result.json", "evaluations.png", "search.json"}
    assert named <= {file.name for file in (tmp_path / "tuned").iterdir()}
