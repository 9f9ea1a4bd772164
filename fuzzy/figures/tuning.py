"""Pictures of a search: cost against evaluations, and the front of two objectives."""

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from fuzzy.figures.drawing import COLUMN, draw_ring, figure_of, log_y, new_figure, number, style
from fuzzy.figures.palette import COLORS, HIGHLIGHT, ROLES
from fuzzy.tuning.search import Evaluations

_DECADE = 10.0  # of the greatest over the least cost that is shown, beyond which the axis is logarithmic
_WORST = 3.0  # times the cost of the start: what costs more is drawn at the upper edge


def plot_search(found: Evaluations, unit: str = "1", ax: Axes | None = None) -> Figure:
    """Draw every evaluation's cost as a dot and the best so far as a line; the start is a dashed level.

    What costs more than three times as much as the start stands as a small cross at the upper edge.

    Args:
        found: The evaluations.
        unit: The unit of the cost.
        ax: Where it is drawn; by default a figure of its own.
    """
    costs = found.costs
    numbers = np.arange(1, len(costs) + 1)
    with style():
        ax = new_figure(COLUMN, 2.6).add_subplot() if ax is None else ax
        top = _WORST * costs[0] if np.isfinite(costs[0]) and costs[0] > 0 else np.max(costs[np.isfinite(costs)])
        shown = costs <= top
        ax.axhline(costs[0], color=ROLES["quiet"].light, linestyle="--", linewidth=0.8, label="as it was")
        ax.plot(numbers[shown], costs[shown], ".", markersize=2, color=COLORS[0], alpha=0.4, label="tried")
        if not shown.all():
            beyond = np.flatnonzero(~shown)
            ax.plot(
                numbers[beyond], np.full(len(beyond), top), "x", markersize=3, color=ROLES["faint"].light,
                label=f"worse than {number(top)}", clip_on=False,
            )  # fmt: skip
        ax.plot(numbers, np.minimum.accumulate(costs), color=COLORS[1], drawstyle="steps-post", label="best so far")
        best = found.best
        ax.plot(numbers[best], costs[best], "o", markersize=4, color=HIGHLIGHT, zorder=3)
        late = best > 0.85 * len(costs)  # a number in the middle below would reach beyond the axes
        ax.annotate(
            number(costs[best]), (numbers[best], costs[best]), xytext=(4 if late else 0, -4),
            textcoords="offset points", ha="right" if late else "center", va="top", color=HIGHLIGHT,
        )  # fmt: skip
        lowest = float(np.min(costs))
        if lowest > 0 and top / lowest > _DECADE:
            log_y(ax, "125")
            ax.set_ylim(lowest * 0.7, top * 1.1)
        else:
            ax.set_ylim(max(0.0, lowest - 0.15 * (top - lowest)) if lowest >= 0 else None, top * 1.03)
        ax.xaxis.set_major_locator(MaxNLocator(6, integer=True, min_n_ticks=1))
        ax.set_xlabel("evaluations")
        ax.set_ylabel(f"cost [{unit}]", parse_math=False)
        ax.legend(loc="upper center", bbox_to_anchor=(0.5, -0.2), borderaxespad=0, ncols=2)
        return figure_of(ax)


def plot_front(found: Evaluations, unit: str = "1", ax: Axes | None = None) -> Figure:
    """Draw two objectives against each other: all evaluations as dots, the front as a line, and the start as a ring.

    Args:
        found: The evaluations.
        unit: The unit of the objectives.
        ax: Where it is drawn; by default a figure of its own.

    Raises ValueError for other than two objectives.
    """
    if len(found.names) != 2:
        raise ValueError(f"a front is drawn of two objectives; there are {len(found.names)}")
    front = found.objectives[found.front]
    start = found.objectives[0]
    with style():
        ax = new_figure(COLUMN, 3.0).add_subplot() if ax is None else ax
        ends = np.maximum(front.max(axis=0), start) * 1.4
        near = (found.objectives <= ends).all(axis=1)
        ax.plot(*found.objectives[near].T, ".", markersize=2, color=COLORS[0], alpha=0.4, label="tried")
        ax.plot(*front.T, drawstyle="steps-post", marker="o", markersize=3, color=COLORS[1], label="front")
        draw_ring(ax, start[0], start[1], "as it was", markersize=7, markeredgewidth=1.2)
        ax.set(xlim=(0, ends[0]), ylim=(0, ends[1]))
        ax.set_xlabel(f"{found.names[0]} [{unit}]: smaller is better", parse_math=False)
        ax.set_ylabel(f"{found.names[1]} [{unit}]", parse_math=False)
        ax.legend(loc="upper center", bbox_to_anchor=(0.5, -0.18), borderaxespad=0, ncols=3)
        return figure_of(ax)
