"""Training error against the number of rules   [thesis, Fig 5.6]. Importing this module imports matplotlib."""

from collections.abc import Mapping
from typing import Any

from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from fuzzy.figures.drawing import COLUMN, LINES, draw_ring, figure_of, log_y, new_figure, style
from fuzzy.figures.palette import COLORS, HIGHLIGHT
from fuzzy.fitting.consequents import IdentificationError
from fuzzy.fitting.search import SearchResult


def plot_rules_error(results: SearchResult | Mapping[str, SearchResult], ax: Axes | None = None) -> Figure:
    """Draw a search: every setting as a dot, the best for each number of rules as a line, the wanted one as a ring.

    The error is the root mean square error of the training data in the output's unit; with several outputs in one
    search it is a share of their ranges.

    Args:
        results: A search, or several by name, which share the axes; their outputs must have the same unit.
        ax: The axes to draw on; by default a new figure's.

    Raises:
        IdentificationError: Units that differ, or no setting that was fitted.
    """
    if isinstance(results, SearchResult):
        results = {"": results}
    labels = {_error_label(result) for result in results.values()}
    if len(labels) != 1:
        raise IdentificationError(f"one axes shows errors of one kind, got {', '.join(sorted(labels)) or 'no search'}")
    if not all(result.by_rules for result in results.values()):
        raise IdentificationError("no setting was fitted: there is no error to draw")
    with style():
        if ax is None:
            ax = new_figure(COLUMN, 2.5 + 0.3 * len(results)).add_subplot()
        for i, (name, result) in enumerate(results.items()):
            _draw(ax, name, result, COLORS[i % len(COLORS)], LINES[i % len(LINES)])
        errors = [trial.error for result in results.values() for trial in result.by_rules.values()]
        if min(errors) > 0:  # otherwise there is no logarithm: a system that fits to the last bit
            log_y(ax, "125")
        ax.xaxis.set_major_locator(MaxNLocator(6, integer=True, min_n_ticks=1))
        ax.set_xlabel("number of rules")
        ax.set_ylabel(labels.pop(), parse_math=False)
        # Below the axes: the curves are not monotone and leave no corner free.
        ax.legend(loc="upper center", bbox_to_anchor=(0.5, -0.2), borderaxespad=0, ncols=1)
        return figure_of(ax)


def _error_label(result: SearchResult) -> str:
    if len(result.outputs) > 1:
        return "training RMSE / range [1]"
    unit = result.outputs[0][1]
    return f"training RMSE [{unit}]" if unit else "training RMSE"


def _draw(ax: Axes, name: str, result: SearchResult, color: str, line: Any) -> None:
    best = result.by_rules
    fitted = [trial for trial in result.trials if trial.rules <= result.limit]
    ax.plot(
        [trial.rules for trial in fitted],
        [trial.error for trial in fitted],
        linestyle="none",
        marker="o",
        markersize=2,
        color=color,
        alpha=0.35,
        markeredgewidth=0,
        label="_nolegend_" if name else "one setting",
    )
    ax.plot(
        list(best),
        [trial.error for trial in best.values()],
        linestyle=line,
        marker=".",
        color=color,
        label=name or "best for that number of rules",
    )
    if result.wanted in best:
        chosen = best[result.wanted]
        unit = "" if len(result.outputs) > 1 else result.outputs[0][1]
        label = f"{name} {chosen.rules} rules: {chosen.error:.3g} {unit}".strip()
        mine = color if name else HIGHLIGHT  # of several each ring is its line's
        draw_ring(ax, chosen.rules, chosen.error, label, mine, markeredgewidth=1.2)
