"""A page of panels over time: what run, team and formation pages, and those of one quantity, are lists of."""

from collections.abc import Callable, Sequence
from typing import NamedTuple

from matplotlib.axes import Axes
from matplotlib.figure import Figure


class TimePlot(NamedTuple):
    """One picture over time."""

    label: str  # of the y axis, with its unit
    draw: Callable[[Axes], None]


def draw_page(
    figure: Figure,
    rows: Sequence[Sequence[TimePlot]],
    heights: Sequence[float] | None = None,
    top_view: Callable[[Axes], None] | None = None,
    span: tuple[float, float] | None = None,
) -> list[Axes]:
    """Draw a top view across the figure, and below it rows of panels that share one axis of time; return the panels'.

    The numbers of the axis stand under the last row, and under one whose panels do not go on in the next.

    Args:
        figure: The figure.
        rows: The panels that stand side by side; all rows have the same number of panels, or one across the figure.
        heights: The heights of all rows, in any unit, the top view's first; by default they are equal.
        top_view: Draws the top view; without, there is none.
        span: The times [s] at which the axis begins and ends; by default it shows what is drawn.
    """
    columns = max(map(len, rows))
    first = 0 if top_view is None else 1
    grid = figure.add_gridspec(first + len(rows), columns, height_ratios=heights)
    if top_view is not None:
        top_view(figure.add_subplot(grid[0, :]))
    axes: list[Axes] = []
    for n, row in enumerate(rows, start=first):
        below = rows[n - first + 1] if n - first + 1 < len(rows) else ()
        for column, (label, draw) in enumerate(row):
            place = grid[n, column] if len(row) == columns else grid[n, :]
            ax = figure.add_subplot(place, sharex=axes[0] if axes else None)
            axes.append(ax)
            draw(ax)
            ax.set_ylabel(label)
            ax.tick_params(labelbottom=len(below) < len(row))
            if len(below) < len(row):
                ax.set_xlabel("time [s]")
    if span is not None:
        axes[0].set_xlim(span)
    if top_view is not None:
        figure.align_ylabels()
    return axes
