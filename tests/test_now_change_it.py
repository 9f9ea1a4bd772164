"""What the how-to pages print below "Now change it", where a text stands below the program: they print that.

Pages that are notebooks assert theirs while the site is made; the other pages have tests of their own.
"""

import doctest
import re
import shutil
import sys
from pathlib import Path

import pytest

from tests.snippets import run_commands, run_python, snippets

DOCS = Path(__file__).parent.parent / "docs"
PAGES = [page for page in sorted((DOCS / "howto").glob("*.md")) if "text" in dict(snippets(page, changed=True))]
NEEDS = {"environments": "gymnasium", "logs": "rosbags"}
EXAMPLES = {"own-robot": "turtlebot-corridor"}
LOOSE = doctest.ELLIPSIS | doctest.NORMALIZE_WHITESPACE


def test_most_pages_have_something_to_change():
    changed = [page for page in (DOCS / "howto").glob("*.md") if "\n## Now change it\n" in page.read_text("utf-8")]
    assert len(changed) >= 20
    assert len(PAGES) >= 10


@pytest.mark.long
@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.stem)
def test_it_prints_what_the_page_says(page, tmp_path, monkeypatch, capsys):
    if needed := NEEDS.get(page.stem):
        pytest.importorskip(needed, reason=f"needs {needed}")
    monkeypatch.chdir(tmp_path)
    monkeypatch.syspath_prepend(tmp_path)
    if page.stem in EXAMPLES:
        shutil.copytree(DOCS / "examples" / EXAMPLES[page.stem], tmp_path, dirs_exist_ok=True)
    (tmp_path / "docs").symlink_to(DOCS)
    for _, text in snippets(page, changed=False):
        if file := re.match(r"# (\w+\.(?:py|toml))\n", text):
            (tmp_path / file[1]).write_text(text, encoding="utf-8")
    known = set(sys.modules)
    for kind, text in snippets(page, changed=True):
        if kind == "sh":
            run_commands(text)
        elif kind == "python":
            run_python(text, page.name)
        else:
            said = capsys.readouterr().out
            assert doctest.OutputChecker().check_output(text, said, LOOSE), said
    for name in set(sys.modules) - known:
        if Path(getattr(sys.modules[name], "__file__", None) or "/").is_relative_to(tmp_path):
            del sys.modules[name]
