"""Every snippet of the README and of the page with everything, and the examples in docstrings, run as written."""

import doctest
import importlib
import re
import tomllib
from pathlib import Path

import numpy as np
import pytest
import shapely

import fuzzy
from robotics.plugins.designer.driving import drives
from tests.snippets import run_commands, run_python, snippets

ROOT = Path(__file__).parent.parent
README = (ROOT / "README.md").read_text(encoding="utf-8")
EVERYTHING = ROOT / "docs" / "start" / "everything.md"
SNIPPETS = {"README.md": snippets(ROOT / "README.md"), EVERYTHING.name: snippets(EVERYTHING)}


@pytest.mark.parametrize(("page", "counts"), [("README.md", (1, 3, 0)), (EVERYTHING.name, (7, 12, 1))])
def test_the_pages_have_what_a_newcomer_needs(page, counts):
    kinds = [kind for kind, _ in SNIPPETS[page]]
    assert (kinds.count("python"), kinds.count("sh"), kinds.count("toml")) == counts


def test_the_readme_is_short_and_its_film_small():
    assert len(README.encode()) <= 9000
    pictures = re.findall(r"docs/start/[\w-]+\.webp", README)
    assert len(pictures) == 5
    assert sum((ROOT / each).stat().st_size for each in pictures) < 2e6


def _run(page, folder):
    """One after the other in one folder: later ones use the files of earlier ones."""
    for kind, text in SNIPPETS[page]:
        if kind == "python":
            run_python(text, page)
        elif kind == "sh" and "make " not in text:
            run_commands(text)
        elif file := re.match(r"# ([\w-]+\.toml)", text):
            (folder / file[1]).write_text(text, encoding="utf-8")


@pytest.mark.long
def test_the_snippets_of_the_readme_run_in_order(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    _run("README.md", tmp_path)
    for name in ("surface.png", "go.fis", "formation.png", "comparison/figures/lyapunov-sine-paths.png"):
        assert (tmp_path / name).stat().st_size > 200, name
    assert not drives(fuzzy.read_fis("go.fis"))  # the designer shows the README's first design as a function
    assert "Traceback" not in capsys.readouterr().err


@pytest.mark.long
def test_snippets_of_the_page_with_everything_run_in_order(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(folder := tmp_path)
    _run(EVERYTHING.name, folder)
    for name in (
        "surface.png",
        "go.fis",
        "memberships.png",
        "run.png",
        "wall-surface.png",
        "wall.png",
        "comparison/report.html",
        "formation.png",
        "sinc.fis",
        "team.png",
        "team.html",
        "crossing-3-A-seed-4.html",
        "mine.png",
        "robot.png",
        "mine/report.html",
    ):
        assert (folder / name).stat().st_size > 200, name
    _check_the_wall_is_followed(folder)
    said = capsys.readouterr()
    assert "Traceback" not in said.err
    output = said.out
    assert "within 5 cm of the path after" in output
    assert "virtual-structure  from" in output
    unseen = [line for line in output.splitlines() if "unseen seeds of unseen scenarios" in line]
    assert len(unseen) == 2
    assert all(re.search(r"after; \d+ % less, 95 % interval", line) for line in unseen)
    go = fuzzy.read_fis(folder / "go.fis")  # its hedge is our own: no warning
    # near and far are 0 and 1 at 1 m; ahead is exp(-0.02); by hand
    ahead, left = 0.9801986733067553, (2 * (0.1 / 1.5) ** 2) ** 2
    expected = (ahead * 0.6 + (1 - ahead) * 0.1) / (ahead + 1 - ahead + 0.5 * left)
    assert float(go([1.0, 0.1])[0]) == pytest.approx(expected, rel=1e-12)


def _check_the_wall_is_followed(folder):
    """The saved run goes round the room, at a distance from its wall that changes little, corners included."""
    from robotics.simulation.run import load_run

    run = load_run(folder / "wall.npz")
    room = tomllib.loads((folder / "wall.toml").read_text(encoding="utf-8"))
    wall = shapely.LineString(room["obstacles"][0]["points"])
    later = run.time > 5.0  # it starts too far away
    places = shapely.points(run["x"][0, 0, later], run["y"][0, 0, later])
    distance = shapely.distance(places, wall)
    assert 0.25 < distance.min() < distance.max() < 0.7  # at the outer corner, where it remembers the wall it left
    assert 0.36 < np.median(distance) < 0.46
    along = np.unwrap(shapely.line_locate_point(wall, places), period=wall.length)
    assert along[-1] - along[0] > wall.length


def test_make_targets_named_in_the_readme_exist():
    makefile = (ROOT / "Makefile").read_text(encoding="utf-8")
    for target in re.findall(r"make (\w+)", README):
        assert re.search(rf"^{target}:", makefile, re.MULTILINE), target


@pytest.mark.parametrize(
    "link", [*re.findall(r"\]\(([\w./-]+)(?:#[\w-]+)?\)", README), *re.findall(r'(?:src|srcset)="([^"]+)"', README)]
)
def test_links_lead_somewhere(link):
    assert (ROOT / link).exists()


@pytest.mark.parametrize("module", ["fuzzy", "fuzzy.naming", "fuzzy.rule", "robotics", "robotics.commands.compare"])
def test_docstring_examples(module):
    result = doctest.testmod(importlib.import_module(module))
    assert result.attempted > 0
    assert result.failed == 0
