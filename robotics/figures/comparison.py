"""The picture of a comparison: every seed of every controller, with the mean and how well the seeds fix it."""

import textwrap
from collections.abc import Mapping, Sequence

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter

from fuzzy.figures.drawing import DOUBLE, new_figure, style
from robotics.experiments.comparison import Comparison, contact_runs, summarise, values_of_runs
from robotics.figures.drawing import Look, PlotError, looks_of
from robotics.laws.catalogue import law_title
from robotics.measures.registry import ALL_METRICS, headlines
from robotics.measures.tracking import Metric


def plot_comparison(
    comparison: Comparison,
    scenario: str | None = None,
    metrics: Sequence[str] | None = None,
    looks: Mapping[str, Look] | None = None,
) -> Figure:
    """Draw a panel for each metric, in it a row for each controller: seeds as dots, mean and 95 % interval as a bar.

    An axis is logarithmic where its values span more than a decade. The number of runs that never settled or arrived is
    written at the right edge, that of runs with a contact below the controller's name.

    Args:
        comparison: The comparison.
        scenario: The name of the scenario that is drawn, by default the first.
        metrics: The names of the metrics, by default those of :func:`robotics.measures.registry.headlines`.
        looks: How each controller is drawn, by its specification.
    """
    scenario = comparison.scenarios[0].name if scenario is None else scenario
    table = comparison.table[comparison.table["scenario"] == scenario]
    if table.empty:
        raise PlotError(f"scenario {scenario!r} was not compared")
    setting = next(s.setting for s in comparison.scenarios if s.name == scenario)
    metrics = list(headlines(setting.kind, setting.has_others, own=comparison.metrics)) if metrics is None else metrics
    known = {**ALL_METRICS, **comparison.metrics}
    summary = summarise(table, comparison.metrics)
    names = list(comparison.controllers)
    chosen = looks_of(names, looks)
    columns = min(3, len(metrics))
    rows = -(-len(metrics) // columns)
    with style():
        figure = new_figure(DOUBLE, rows * (0.62 + 0.17 * len(names)) + 0.25)
        grid = figure.subplots(rows, columns, squeeze=False, sharey=True)
        for ax, metric in zip(grid.flat, metrics, strict=False):
            _draw_metric(ax, table, summary[summary["metric"] == metric], metric, known[metric], names, chosen)
        for ax in grid.flat[len(metrics) :]:
            ax.remove()
        touched = [contact_runs(table, scenario, name) for name in names]
        titles = [
            textwrap.fill(law_title(name).replace(",", ", "), 24)
            + (f"\n✕ contact in {count} of {runs}" if count else "")
            for name, (count, runs) in zip(names, touched, strict=True)
        ]
        grid[0, 0].set_yticks(range(len(names)), titles)
        grid[0, 0].set_ylim(len(names) - 0.4, -0.6)
        for tick in (t for row in grid for t in row[0].get_yticklabels()):
            tick.set_parse_math(False)
        mean = Line2D([], [], color="black", marker="|", markersize=8, linewidth=1.0, linestyle="-")
        dot = Line2D([], [], color="0.5", marker="o", markersize=2.5, linestyle="none")
        figure.legend(
            [dot, mean],
            ["one seed", "mean with its 95 % interval"],
            loc="outside upper right",
            ncol=2,
            borderaxespad=0.2,
        )
        return figure


def _draw_metric(
    ax: Axes,
    table: pd.DataFrame,
    summary: pd.DataFrame,
    metric: str,
    about: Metric,
    names: Sequence[str],
    chosen: Mapping[str, Look],
) -> None:
    values = {name: values_of_runs(table[table["controller"] == name], metric, about) for name in names}
    known = np.concatenate([v[np.isfinite(v)] for v in values.values()])
    logarithmic = known.size > 0 and known.min() > 0 and known.max() > 10 * known.min()
    if logarithmic:
        ax.set_xscale("log")
        ax.xaxis.set_major_locator(LogLocator(subs=(1, 2, 5)))
        ax.xaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
        ax.xaxis.set_minor_formatter(NullFormatter())
    else:
        ax.locator_params(axis="x", nbins=5)
    for row, name in enumerate(names):
        look, finite = chosen[name], values[name][np.isfinite(values[name])]
        # Spread over the row's height, the same way every time, so that equal values stay countable.
        offset = 0.5 * ((np.arange(len(finite)) * 0.618034 + 0.5) % 1.0 - 0.5)
        ax.plot(finite, row + offset, color=look.color, marker=look.marker, markersize=2.2, linestyle="none", alpha=0.7)
        mean, low, high = (
            float(summary.loc[summary["controller"] == name, c].iloc[0]) for c in ("mean", "low", "high")
        )
        if np.isfinite(mean):
            ax.plot([mean], [row], color="black", marker="|", markersize=9, zorder=4)
            if np.isfinite(low) and np.isfinite(high):
                left = max(low, known.min() / 2) if logarithmic else low
                ax.plot([left, high], [row, row], color="black", linestyle="-", linewidth=1.0, zorder=4)
        never = int(np.isposinf(values[name]).sum())
        if never:
            ax.text(
                0.99,
                row,
                f"never: {never} of {len(values[name])} ×",
                transform=ax.get_yaxis_transform(),
                ha="right",
                va="center",
                fontsize=6.5,
                zorder=5,
                bbox={"facecolor": "white", "edgecolor": "none", "alpha": 0.8, "pad": 0.5},
            )
    if known.size and known.max() == known.min():
        ax.set_xlim(0.5 * known.min() - 0.02, 1.5 * known.max() or 1.0)
    name = f"{about.title.partition(':')[0]} [{about.unit}]" + (", logarithmic" if logarithmic else "")
    ax.set_xlabel(
        textwrap.fill(name, 32, break_long_words=False).replace(" [", "\N{NO-BREAK SPACE}["), parse_math=False
    )
    ax.yaxis.grid(False)
