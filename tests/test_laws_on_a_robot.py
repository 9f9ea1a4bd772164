"""The page docs/laws-on-a-robot.md: its commands and its Python run as written."""

from pathlib import Path

import pytest

from fuzzy.ccode.compiler import CompilerError, find_compiler
from tests.snippets import run_commands, run_python, snippets

DOCS = Path(__file__).parent.parent / "docs"


def test_every_snippet_of_the_page_runs(tmp_path, monkeypatch, capsys):
    try:
        find_compiler()
    except CompilerError as error:
        pytest.skip(str(error))
    monkeypatch.chdir(tmp_path)
    kinds = []
    for kind, text in snippets(DOCS / "laws-on-a-robot.md"):
        kinds.append(kind)
        if kind == "sh":
            run_commands(text)
        elif kind == "python":
            run_python(text, "laws-on-a-robot.md")
    assert kinds == ["sh", "python", "c"]
    said = capsys.readouterr().out
    assert said.splitlines()[-1] == "0e+00 m apart: the same"
    assert (tmp_path / "out" / "fuzzy_rules.c").stat().st_size > 1000
