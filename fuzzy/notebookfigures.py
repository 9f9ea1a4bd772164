"""Figures in notebooks: what a cell ends with is shown as a picture, though no pyplot ever ran.

Our figures are plain matplotlib ones, made without pyplot: nothing is kept open, and no window appears. A notebook,
though, learns to draw a Figure only from pyplot's inline backend; without that it shows a figure's type and size.
"""

import sys
from typing import Any

_MODULE, CLASS = "matplotlib.figure", "Figure"


def show_figures() -> None:
    """Teach the notebook, if this runs in one, to show figures as PNG; whoever has chosen a format keeps it."""
    shell = getattr(sys.modules.get("IPython"), "get_ipython", lambda: None)()
    formatters = getattr(getattr(shell, "display_formatter", None), "formatters", None)
    if not formatters or "image/png" not in formatters:
        return
    figure = getattr(sys.modules.get(_MODULE), CLASS, None)
    if not any(figure in one.type_printers for one in formatters.values()):
        formatters["image/png"].for_type_by_name(_MODULE, CLASS, _png)


def _png(figure: Any) -> Any:
    from IPython.core.pylabtools import print_figure

    return print_figure(figure, "png")
