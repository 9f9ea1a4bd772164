"""Shared parts of all pictures: the style, sizes, names as text, and files written whole."""

from collections.abc import Iterator
from contextlib import AbstractContextManager, contextmanager
from functools import lru_cache
from pathlib import Path
from typing import Any

import matplotlib.style
from cycler import cycler
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.font_manager import FontProperties
from matplotlib.textpath import text_to_path
from matplotlib.ticker import FuncFormatter, LogFormatterSciNotation

from fuzzy.figures.palette import COLORS, HIGHLIGHT
from fuzzy.files.atomic import check_target, replacing
from fuzzy.shown import shown, typeset
from fuzzy.system import FuzzySystemError, Variable

STYLE = Path(__file__).parent / "style" / "fuzzyfleet.mplstyle"
COLUMN, DOUBLE = 3.5, 7.16  # widths of one and of two columns of a paper, in inches
PAGE_WIDTH = 4.6  # inches: the width of figures of a page, whose letters can be read on a phone of 390 pixels too
# The line style tells the terms apart in grey.
LINES: tuple[Any, ...] = ("-", "--", "-.", (0, (1, 1)), (0, (5, 1, 1, 1, 1, 1)), (0, (8, 2)), (0, (3, 3)))
FORMATS = ("png", "pdf", "svg")


def style() -> AbstractContextManager[None]:
    """The look of this package's figures for those of one's own, made in a ``with`` block; outside it nothing changes.

    Colours are those of Okabe and Ito, which the colour-blind can tell apart, and every line has its own dashes.

    >>> import fuzzy
    >>> from matplotlib.figure import Figure
    >>> with fuzzy.style():
    ...     lines = Figure().subplots().plot([0, 1], [[0, 1], [1, 0]])
    >>> [line.get_linestyle() for line in lines]
    ['-', '--']
    """
    lines = cycler(color=COLORS, linestyle=LINES)
    return matplotlib.style.context([STYLE, {"axes.prop_cycle": lines}])


def new_figure(width: float, height: float, constrained: bool = True) -> Figure:
    """Make a figure that pyplot does not know, so that it goes with its last user.

    Args:
        width: The width in inches.
        height: The height in inches.
        constrained: Whether matplotlib's constrained layout arranges it.
    """
    return Figure(figsize=(width, height), layout="constrained" if constrained else None)


@contextmanager
def styled_figure(width: float, height: float, constrained: bool = True) -> Iterator[Figure]:
    """A new figure for a ``with`` block, in which it is drawn in the :func:`style`; see :func:`new_figure`."""
    with style():
        yield new_figure(width, height, constrained)


def line_look(n: int) -> dict[str, Any]:
    """The colour and the dashes of the ``n``-th of several lines, from 0."""
    return {"color": COLORS[n % len(COLORS)], "linestyle": LINES[n % len(LINES)]}


def draw_ring(ax: Axes, x: float, y: float, label: str, color: str = HIGHLIGHT, **look: Any) -> None:
    """Mark a point with a ring; ``look`` is as of matplotlib's ``plot``."""
    look = {"markersize": 8, **look}
    ax.plot([x], [y], "o", markerfacecolor="none", markeredgecolor=color, label=label, **look)


def log_y(ax: Axes, digits: str = "") -> None:
    """Make the y axis logarithmic.

    Args:
        ax: The axes.
        digits: The numbers in a decade that are written, such as "125"; "": powers of ten, and numbers between where
            there are less than two.
    """
    ax.set_yscale("log")
    if not digits:
        ax.yaxis.set_minor_formatter(LogFormatterSciNotation(labelOnlyBase=False, minor_thresholds=(1, 0.5)))
        return
    for of in (ax.yaxis.set_major_formatter, ax.yaxis.set_minor_formatter):
        of(FuncFormatter(lambda value, _: number(value) if f"{value:.0e}"[0] in digits else ""))


def figure_of(axes: Axes) -> Figure:
    """The figure at the root of ``axes``."""
    figure = axes.get_figure(root=True)
    assert figure is not None
    return figure


def save_figure(figure: Figure, path: str | Path) -> None:
    """Write a picture, whole or not at all, in the format of the suffix (png, pdf, svg).

    Args:
        figure: The picture.
        path: The file.

    Raises:
        FuzzySystemError: Another suffix.
        OSError: The file cannot be written.
    """
    path = Path(path)
    _check_format(path)
    metadata: dict[str, Any] = {"svg": {"Date": None}, "pdf": {"CreationDate": None}}.get(path.suffix[1:].lower(), {})
    with style(), replacing(path) as target:
        figure.savefig(target, format=path.suffix[1:].lower(), metadata=metadata)


def check_picture(path: str | Path) -> None:
    """See, before long work, that a picture can be written to ``path``.

    Raises FuzzySystemError for a name that does not end like a picture, TargetError for a place for no file.
    """
    _check_format(path)
    check_target(path)


def _check_format(path: str | Path) -> None:
    if Path(path).suffix[1:].lower() not in FORMATS:
        raise FuzzySystemError(f"cannot tell the kind of picture from {str(path)!r}; end it in .png, .pdf or .svg")


@lru_cache
def _font(size: float) -> FontProperties:
    return FontProperties(family="DejaVu Sans", size=size)


def text_width(text: str, size: float) -> float:
    """The width of a line of text in inches; ``size`` is in points."""
    return text_to_path.get_text_width_height_descent(text, _font(size), ismath=False)[0] / 72


def shortened(text: str, width: float, size: float) -> str:
    """A text, or its beginning with an ellipsis if the text is too wide.

    Args:
        text: The text.
        width: The width in inches that it may have.
        size: The size of its letters in points.
    """
    if text_width(text, size) <= width:
        return text
    while text and text_width(text + "…", size) > width:
        text = text[:-1]
    return text.rstrip() + "…"


def number(value: float) -> str:
    """A number as labels show it: four significant digits, with a true minus sign."""
    return typeset(shown(value))


def quantity(value: float, variable: Variable) -> str:
    """A value with the unit of its variable."""
    return f"{number(value)} {variable.unit}".rstrip()
