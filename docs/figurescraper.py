"""How the gallery finds the pictures of an example: every matplotlib figure that a block has named, or ends with.

What a picture shows is said in words in examples/alt.toml, for those who do not see it.
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


def scrape(block: Any, variables: dict[str, Any], gallery: dict[str, Any]) -> str:
    """Save the figures that are new since the last block, and return what shows them."""
    known = variables.setdefault("figures_shown", [])
    said = tomllib.loads(ALTERNATIVES.read_text(encoding="utf-8"))[Path(variables["src_file"]).stem]
    shown = ""
    for thing in list(variables["example_globals"].values()):
        if isinstance(thing, Figure) and not any(thing is figure for figure in known):
            path = next(variables["image_path_iterator"])
            thing.savefig(path, dpi=160)
            picture = figure_rst([str(path)], gallery["src_dir"], said[len(known)])
            shown += _SCROLLING.format(pixels=PIXELS * thing.get_figwidth(), picture=picture)
            known.append(thing)
    return shown
