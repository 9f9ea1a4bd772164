"""How the gallery finds the pictures of an example: every matplotlib figure that a block has named, or ends with.

What a picture shows is said in words in examples/alt.toml, for those who do not see it. The examples have there the
order in which they are shown. A picture without labels, or with a colour that is not of the palette, is refused:
the site is then not made.
"""

import tomllib
from pathlib import Path
from typing import Any

from matplotlib.colors import rgb_to_hsv, to_hex, to_rgb
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from sphinx_gallery.scrapers import figure_rst

from fuzzy.figures.palette import COLORS, ROLES, STRONG

ALTERNATIVES = Path(__file__).parent.parent / "examples" / "alt.toml"
PIXELS = 76  # of the page for an inch of a picture, at least: 4.6 inches fit a phone, wider ones scroll there
# The hues of the palette: a name may stand in a darker shade of its line's.
_HUES = [rgb_to_hsv(to_rgb(c))[0] for c in (*COLORS, *STRONG.values(), *(shade.light for shade in ROLES.values()))]
_SCROLLING = """
.. raw:: html

   <div style="overflow-x: auto"><div style="min-width: {pixels:.0f}px">
{picture}
.. raw:: html

   </div></div>
"""


class InReadingOrder:
    """The order of a section's examples: that in which examples/alt.toml has them."""

    def __init__(self, folder: str) -> None:
        """Read the order; it is the same for every section, so that ``folder`` does not matter."""
        self.places = {f"{name}.py": place for place, name in enumerate(_read())}

    def __call__(self, file: str) -> int:
        """The place of a file, by its name."""
        return self.places[file]


def _read() -> dict[str, list[str]]:
    """What the pictures show, by the names of the examples."""
    return tomllib.loads(ALTERNATIVES.read_text(encoding="utf-8"))


def check_picture(figure: Figure) -> None:
    """Raise ValueError unless the axes are labelled and the lines have colours of the palette."""
    said = [ax.get_xlabel() or ax.get_ylabel() or ax.get_title() for ax in figure.axes if ax.axison]
    if said and not any(said) and not figure.get_supxlabel():
        raise ValueError("no axis of the picture has a label")
    for color in {to_hex(line.get_color()) for line in figure.findobj(Line2D)}:
        hue, colored, _ = rgb_to_hsv(to_rgb(color))
        if colored and min(abs(hue - known) for known in _HUES) >= 0.003:
            raise ValueError(f"{color} is not of the palette")


def scrape(block: Any, variables: dict[str, Any], gallery: dict[str, Any]) -> str:
    """Save the figures that are new since the last block, and return what shows them."""
    known = variables.setdefault("figures_shown", [])
    said = _read()[Path(variables["src_file"]).stem]
    shown = ""
    for thing in list(variables["example_globals"].values()):
        if isinstance(thing, Figure) and not any(thing is figure for figure in known):
            check_picture(thing)
            path = next(variables["image_path_iterator"])
            thing.savefig(path, dpi=160)
            picture = figure_rst([str(path)], gallery["src_dir"], said[len(known)])
            shown += _SCROLLING.format(pixels=PIXELS * thing.get_figwidth(), picture=picture)
            known.append(thing)
    return shown
