"""The picture of a front: error against size. Importing this module imports matplotlib."""

from matplotlib.figure import Figure

from fuzzy.figures.drawing import COLUMN, draw_ring, styled_figure
from fuzzy.figures.palette import COLORS
from fuzzy.plugins.front.search import RuleFront


def plot_rule_front(front: RuleFront) -> Figure:
    """Draw the points of a front with their standard errors; a ring is around the smallest within one of the least.

    The error is in units of the outputs' spread: at 1 a system tells no more than the mean does.

    Args:
        front: What :func:`fuzzy.search_rules` found.
    """
    size = [point.operations for point in front.points]
    error = [point.error for point in front.points]
    with styled_figure(COLUMN, 2.6) as figure:
        ax = figure.add_subplot()
        ax.errorbar(
            size,
            error,
            yerr=[point.deviation for point in front.points],
            marker="o",
            markersize=3,
            capsize=2,
            linewidth=1,
            color=COLORS[0],
            label="± one standard error",
        )
        point = front.points[front.chosen]
        label = f"{point.rules} rules, {point.conditions} conditions"
        draw_ring(ax, point.operations, point.error, label, markeredgewidth=1.2)
        ax.set_xlabel("operations of the formula")
        ax.set_ylabel("cross-validated RMSE / spread [1]")
        ax.legend(loc="upper right")
    return figure
