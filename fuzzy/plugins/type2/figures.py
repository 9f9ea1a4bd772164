"""Pictures of the terms of an interval type-2 system, with the footprint of uncertainty."""

from matplotlib.figure import Figure

from fuzzy.detached import detached
from fuzzy.figures.drawing import COLUMN, DOUBLE, new_figure, style
from fuzzy.figures.memberships import plot_memberships
from fuzzy.figures.palette import COLORS
from fuzzy.insight.universe import place_of, universe_grid
from fuzzy.plugins.type2.system import Type2Sugeno


def plot_footprint(fis: Type2Sugeno, variable: str | int | None = None) -> Figure:
    """Draw the terms of one input, or of all: the upper membership functions, and the footprint down to the lower ones.

    Args:
        fis: The system.
        variable: An input by its name or by its place; None draws all.

    Raises:
        FuzzySystemError: An input that does not exist.
    """
    upper = detached(fis.upper)
    chosen = range(len(fis.inputs)) if variable is None else [place_of(variable, fis.inputs, "input")]
    columns = min(len(chosen), 2)
    rows = -(-len(chosen) // columns)
    with style():
        figure = new_figure(DOUBLE if columns == 2 else COLUMN, 1.9 * rows)
        panels = [figure.add_subplot(rows, columns, n) for n in range(1, len(chosen) + 1)]
        figure.draw_without_rendering()  # the labels are placed by the size that the panels get
        for ax, i in zip(panels, chosen, strict=True):
            plot_memberships(upper, i, ax)
            x = universe_grid(upper.inputs[i])
            for n, term in enumerate(upper.inputs[i].terms):
                low, high = fis.degrees(upper.inputs[i].name, term, x)
                ax.fill_between(x, low, high, color=COLORS[n % len(COLORS)], alpha=0.25, linewidth=0)
        return figure
