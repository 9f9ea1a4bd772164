"""How the gallery finds the pictures of an example: every matplotlib figure that a block has named, or ends with.

What a picture shows is said in words in examples/alt.toml, for those who do not see it. The examples have there the
order in which they are shown.
"""

import tomllib
from pathlib import Path
from typing import Any

from matplotlib.figure import Figure
from sphinx_gallery.scrapers import figure_rst

ALTERNATIVES = Path(__file__).parent.parent / "examples" / "alt.toml"
PIXELS = 76  # of the page for an inch of a picture, at least: 4.6 inches fit a phone, wider ones scroll there
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


def scrape(block: Any, variables: dict[str, Any], gallery: dict[str, Any]) -> str:
    """Save the figures that are new since the last block, and return what shows them."""
    known = variables.setdefault("figures_shown", [])
    said = _read()[Path(variables["src_file"]).stem]
    shown = ""
    for thing in list(variables["example_globals"].values()):
        if isinstance(thing, Figure) and not any(thing is figure for figure in known):
            path = next(variables["image_path_iterator"])
            thing.savefig(path, dpi=160)
            picture = figure_rst([str(path)], gallery["src_dir"], said[len(known)])
            shown += _SCROLLING.format(pixels=PIXELS * thing.get_figwidth(), picture=picture)
            known.append(thing)
    return shown
