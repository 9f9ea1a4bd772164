"""The page docs/howto/short-answers.md: its snippets run as written, in an empty folder."""

import re
from pathlib import Path

from tests.snippets import run_commands, run_python, snippets

DOCS = Path(__file__).parent.parent / "docs"
PAGE = DOCS / "howto" / "short-answers.md"


def test_what_people_look_for_has_a_heading_and_the_changelog_is_not_searched():
    headings = re.findall(r"^## (.*)", PAGE.read_text(encoding="utf-8"), re.MULTILINE)
    wanted = ("Change a gain", "1,000 seeds", "A plot for a paper", "A categorical column", "k-fold")
    assert all(any(heading.startswith(words) for heading in headings) for words in wanted)
    index = (DOCS / "howto" / "index.md").read_text(encoding="utf-8")
    links = [f"short-answers.md#{re.sub('[^a-z0-9 -]', '', h.lower()).replace(' ', '-')}" for h in headings]
    assert all(link in index for link in links)
    assert (DOCS / "changelog.md").read_text(encoding="utf-8").startswith("---\nnosearch: true\n---\n")


def test_every_snippet_of_the_page_runs_in_order(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("MPLBACKEND", "Agg")
    for kind, text in snippets(PAGE):
        if kind == "sh":
            run_commands(text)
        else:
            run_python(text, PAGE.name)
    capsys.readouterr()
    for name in ("figures.zip", "memberships.pdf", "run.pdf", "paths.pdf", "column.pdf", "power.fis", "net.fis"):
        assert (tmp_path / name).stat().st_size > 200, name
