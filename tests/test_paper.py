"""The article: what it cites, shows and says of the arena is there."""

import importlib.util
import re
from pathlib import Path

from matplotlib.figure import Figure

import robotics

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
    for said in ("keeps 4.7 mm from its reference", "1.6 mm"):
        assert said in readme
        assert said in " ".join(arena.split())


def test_its_conditions_of_the_arena_are_those_of_the_packaged_one():
    arena = robotics.load_arena("default")
    words = {2: "two", 8: "eight", 12: "twelve"}
    said = " ".join(TEXT.partition("# The arena")[2].partition("# Limits")[0].split()).lower()
    assert f"{words[len(arena.laws)]} laws" in said
    assert f"{words[len(arena.engines)]} engines" in said
    assert f"{words[len(arena.test)]} random scenarios" in said
    given = arena.conditions
    noise = (
        f"({1000 * given.position_noise:g} mm, {1000 * given.heading_noise:g} mrad, {1000 * given.latency:g} ms latency"
    )
    assert f"with {arena.testing_runs} noisy runs each {noise}" in said
    assert [(t.metric, round(t.scale, 4)) for t in arena.cost] == [
        ("rms_distance_late_m", 0.01),
        ("rms_heading_late_rad", 0.0873),
        ("w_variation_late_radps2", 1.0),
    ]
    assert (
        "rms distance over 1 cm, the rms heading error over 5° and the variation of the turn rate over 1 rad/s²" in said
    )


def test_it_has_the_parts_of_an_article_of_software():
    for part in ("Summary", "Statement of need", "State of the field", "Design", "Quality", "The arena", "Limits"):
        assert f"\n# {part}\n" in TEXT
    assert 800 < len(TEXT.split()) < 2000
