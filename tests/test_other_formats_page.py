"""The page docs/howto/other-formats.md: its snippets run as written, and print what stands below them."""

import contextlib
import io
import shutil
from pathlib import Path

import pytest

from tests.snippets import run_commands, snippets

ROOT = Path(__file__).parent.parent


@pytest.mark.filterwarnings("ignore:Passing more than 2 positional:DeprecationWarning")  # scikit-fuzzy's
def test_every_snippet_of_the_page_runs_in_order(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    shutil.copy(ROOT / "tests" / "data" / "fis-corpus" / "m05_kzafeiroudi_smf.fis", "old.fis")
    names: dict[str, object] = {}
    said, kinds = "", []
    for kind, text in snippets(ROOT / "docs" / "howto" / "other-formats.md"):
        kinds.append(kind)
        if kind == "console":
            run_commands(text.removeprefix("$ "))
            assert Path("new.fis").exists()
        elif kind == "sh":
            run_commands(text)
        elif kind == "python":
            printed = io.StringIO()
            with contextlib.redirect_stdout(printed):
                exec(compile(text, "other-formats.md", "exec"), names)
            said += printed.getvalue()
        else:
            assert said == text
            said = ""
    assert kinds == ["console", "python", "text", "python", "python", "text", "sh", "python", "text"]
    assert Path("bode.png").stat().st_size > 10_000
