"""The gallery: every script runs without a warning and draws, and its page says what it is."""

import ast
import re
import runpy
import tomllib
from pathlib import Path

import pytest
from matplotlib.colors import rgb_to_hsv, to_hex, to_rgb
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from fuzzy.figures.palette import COLORS, ROLES, STRONG

ROOT = Path(__file__).parent.parent
SCRIPTS = sorted((ROOT / "examples").glob("*/plot_*.py"))
IN_WORDS = tomllib.loads((ROOT / "examples" / "alt.toml").read_text(encoding="utf-8"))
# The hues of the palette: a name may stand in a darker shade of its line's.
HUES = [rgb_to_hsv(to_rgb(c))[0] for c in (*COLORS, *STRONG.values(), *(shade.light for shade in ROLES.values()))]


@pytest.mark.long  # they run whenever the site is made, too
@pytest.mark.parametrize("script", [pytest.param(script, id=script.stem) for script in SCRIPTS])
def test_it_runs_and_its_pictures_have_labelled_axes(script):
    names = runpy.run_path(str(script))
    figures = {id(value): value for value in names.values() if isinstance(value, Figure)}
    assert figures
    for figure in figures.values():
        said = [ax.get_xlabel() or ax.get_ylabel() or ax.get_title() for ax in figure.axes if ax.axison]
        assert any(said) or figure.get_supxlabel() or not said, script.stem
        for color in {to_hex(line.get_color()) for line in figure.findobj(Line2D)}:
            hue, colored, _ = rgb_to_hsv(to_rgb(color))
            assert not colored or min(abs(hue - known) for known in HUES) < 0.003, f"{color} is not of the palette"
    assert len(figures) == len(IN_WORDS[script.stem])


def test_there_is_one_of_everything_and_each_has_a_title_of_its_own():
    titles = [
        str(ast.get_docstring(ast.parse(script.read_text(encoding="utf-8")))).split("\n")[0] for script in SCRIPTS
    ]
    assert len({*titles}) == len(titles)
    assert 25 <= len(SCRIPTS) <= 30
    assert {*IN_WORDS} == {script.stem for script in SCRIPTS}
    words = [text for texts in IN_WORDS.values() for text in texts]
    assert len({*words}) == len(words)
    assert all(text.endswith(".") and len(text) > 30 for text in words)
    for script in SCRIPTS:
        text = script.read_text(encoding="utf-8")
        assert re.match(r'"""\n(.+)\n=+\n\n[A-Z0-9].+', text), f"{script.name}: a title, its line, and a sentence"
        parts = re.findall(r"^(?:from|import) ((?:fuzzy|anfis|robotics)\.[\w.]+)", text, re.MULTILINE)
        assert not parts, f"{script.name} uses {parts}, which a user's program need not know"
        assert not re.search("#[0-9A-Fa-f]{6}", text), f"{script.name} has a colour of its own"
