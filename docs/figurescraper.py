"""How the gallery finds the pictures of an example: every matplotlib figure that a block has named, or ends with."""

from pathlib import Path
from typing import Any

from matplotlib.figure import Figure
from sphinx_gallery.scrapers import figure_rst


def scrape(block: Any, variables: dict[str, Any], gallery: dict[str, Any]) -> str:
    """Save the figures that are new since the last block, and return what shows them."""
    known = variables.setdefault("figures_shown", [])
    saved = []
    for thing in list(variables["example_globals"].values()):
        if isinstance(thing, Figure) and not any(thing is shown for shown in known):
            known.append(thing)
            path = next(variables["image_path_iterator"])
            thing.savefig(path, dpi=160)
            saved.append(Path(path))
    return figure_rst([str(path) for path in saved], gallery["src_dir"])
