"""The article: what it cites, shows and says of the arena is there."""

import importlib.util
import re
from pathlib import Path

from matplotlib.figure import Figure

PAPER = Path(__file__).parent.parent / "docs" / "paper"
TEXT = (PAPER / "paper.md").read_text(encoding="utf-8")


def test_it_cites_what_its_bibliography_has_and_all_of_it():
    cited = {*re.findall(r"@(\w+)", TEXT.partition("# Summary")[2])}
    listed = {*re.findall(r"^@\w+\{(\w+),", (PAPER / "paper.bib").read_text(encoding="utf-8"), re.MULTILINE)}
    assert cited == listed
    assert len(listed) > 8


def test_its_figures_are_made_by_its_code():
    spec = importlib.util.spec_from_file_location("paper_figures", PAPER / "figures.py")
    assert spec is not None
    assert spec.loader is not None
    figures = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(figures)
    shown = re.findall(r"\]\((\w+\.png)\)", TEXT)
    assert sorted(shown) == sorted(figures.FIGURES)
    named = re.findall(r"\\label\{(fig:\w+)\}", TEXT)
    assert sorted(named) == sorted({*re.findall(r"\\autoref\{(fig:\w+)\}", TEXT)})
    for draw in (lambda: figures.crossings(4), lambda: figures.noise(1)):
        figure = draw()
        assert isinstance(figure, Figure)
        assert all(ax.get_xlabel() for ax in figure.axes)


def test_its_numbers_of_the_arena_are_those_of_the_readme():
    readme = (PAPER.parents[1] / "README.md").read_text(encoding="utf-8")
    arena = TEXT.partition("# The arena")[2].partition("# Limits")[0]
    for row, number in (
        ("MPPI", "0.76"),
        ("exponential sliding mode", "1.53"),
        ("Lyapunov", "2.04"),
        ("fuzzy rule base", "3.96"),
    ):
        assert re.search(rf"\| {row} \| [\d.]+ \| {re.escape(number)}", readme), row
        assert number in arena
    assert "| fuzzy rule base | 4.62 |" in readme
    assert "4.62 as published" in arena


def test_it_has_the_parts_of_an_article_of_software():
    for part in ("Summary", "Statement of need", "State of the field", "Design", "Quality", "The arena", "Limits"):
        assert f"\n# {part}\n" in TEXT
    assert 800 < len(TEXT.split()) < 2000
