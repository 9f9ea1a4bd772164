"""The picture of a comparison: every seed of every controller, with the mean and how well the seeds fix it."""

import textwrap
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import FuncFormatter

from fuzzy.figures.drawing import DOUBLE, PAGE_WIDTH, styled_figure
from robotics.laws.catalogue import law_title
from robotics.measures.registry import ALL_METRICS, short_metrics
from robotics.measures.tracking import Metric
from robotics.show.figures.drawing import Look, PlotError, looks_of, on_white, panel_grid, scale_values
from robotics.studies.comparison import Comparison, contact_runs, summarise, values_of_runs

_PREFIXED = ("m", "rad", "m/s")  # units that may take the prefix milli


def plot_comparison(
    comparison: Comparison,
    scenario: str | None = None,
    metrics: Sequence[str] | None = None,
    looks: Mapping[str, Look] | None = None,
    width: float = DOUBLE,
) -> Figure:
    """Draw a panel for each metric, in it a row for each controller: seeds as dots, mean and 95 % interval as a bar.

    An axis begins at 0; where its values span more than a decade it is logarithmic, and says so. Metrics that are 0 in
    all runs, or known in none, have no panel. Where all seeds give the same numbers each controller has one dot, and no
    interval. The number of runs that never settled or arrived is written at the right edge, that of runs with a contact
    below the controller's name.

    Args:
        comparison: The comparison.
        scenario: The name of the scenario that is drawn, by default the first.
        metrics: The names of the metrics, by default those of :func:`robotics.measures.registry.short_metrics`.
        looks: How each controller is drawn, by its specification.
        width: The width of the figure in inches.

    Raises:
        PlotError: A scenario that was not compared, or no metric that has anything to show.
    """
    scenario = comparison.scenarios[0].name if scenario is None else scenario
    table = comparison.table[comparison.table["scenario"] == scenario]
    if table.empty:
        raise PlotError(f"scenario {scenario!r} was not compared")
    drawn = next(s for s in comparison.scenarios if s.name == scenario)
    names = list(comparison.controllers)
    if metrics is None:
        metrics = list(short_metrics(drawn, drawn.setting.has_others, own=comparison.metrics))
    known = {**ALL_METRICS, **comparison.metrics}
    summary = summarise(table, comparison.metrics).set_index(["metric", "controller"])
    chosen = looks_of(names, looks)
    runs = {n: table[table["controller"] == n] for n in names}
    values = {m: {n: values_of_runs(rows, m, known[m]) for n, rows in runs.items()} for m in metrics}
    values = {m: found for m, found in values.items() if any(map(_has_something, found.values()))}
    if not values:
        raise PlotError(f"the metrics of {scenario!r} are 0 or unknown in all runs: there is nothing to draw")
    alike = all(_same(numbers) for found in values.values() for numbers in found.values())
    columns = min(3 if width > PAGE_WIDTH else 2, len(values))
    with styled_figure(width, -(-len(values) // columns) * (0.74 + 0.17 * len(names)) + 0.25) as figure:
        axes = panel_grid(figure, len(values), columns)
        for ax, (metric, found) in zip(axes, values.items(), strict=True):
            _draw_metric(ax, found, pd.DataFrame(summary.loc[metric]), known[metric], chosen, alike)
        touched = [contact_runs(table, scenario, name) for name in names]
        titles = [
            textwrap.fill(law_title(name).replace(",", ", "), 24)
            + (f"\n✕ contact in {count} of {runs}" if count else "")
            for name, (count, runs) in zip(names, touched, strict=True)
        ]
        axes[0].set_yticks(range(len(names)), titles)
        axes[0].set_ylim(len(names) - 0.4, -0.6)
        for tick in (t for ax in axes[::columns] for t in ax.get_yticklabels()):
            tick.set_parse_math(False)
        mean = Line2D([], [], color="black", marker="|", markersize=8, linewidth=1.0, linestyle="-")
        dot = Line2D([], [], color="0.5", marker="o", markersize=2.5, linestyle="none")
        several = [(dot, "one seed"), (mean, "mean with its 95 % interval")]
        one = "every seed gives this" if table["seed"].nunique() > 1 else "the one seed"
        shown = [(dot, one)] if alike else several
        figure.legend(*zip(*shown, strict=True), loc="outside upper right", ncol=2, borderaxespad=0.2)
        return figure


def _has_something(values: np.ndarray) -> bool:
    """Whether some run has a number other than 0; never is one, too."""
    return bool((~np.isnan(values) & (values != 0)).any())


def _same(values: np.ndarray) -> bool:
    """Whether all runs of a controller have the same number, up to rounding."""
    known = values[np.isfinite(values)]
    return len(known) in (0, len(values)) and (len(known) < 2 or bool(np.ptp(known) <= 1e-9 * np.abs(known).max()))


def _draw_metric(
    ax: Axes,
    values: Mapping[str, np.ndarray],
    summary: pd.DataFrame,
    about: Metric,
    chosen: Mapping[str, Look],
    alike: bool,
) -> None:
    known = np.concatenate([v[np.isfinite(v)] for v in values.values()])
    logarithmic = scale_values(ax, known)
    small = known.size > 0 and known.max() < 0.1 and about.unit in _PREFIXED
    factor = 1000.0 if small else 1.0
    ax.xaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{factor * value:.6g}".replace("-", "−")))
    for row, (name, numbers) in enumerate(values.items()):
        look, finite = chosen[name], numbers[np.isfinite(numbers)]
        _write_never(ax, row, numbers)
        if alike:
            ax.plot(finite[:1], [row][: len(finite)], color=look.color, marker=look.marker, markersize=4.5)
            continue
        # Spread over the row's height, the same way every time, so that equal values stay countable.
        offset = 0.5 * ((np.arange(len(finite)) * 0.618034 + 0.5) % 1.0 - 0.5)
        ax.plot(finite, row + offset, color=look.color, marker=look.marker, markersize=2.2, linestyle="none", alpha=0.7)
        mean, low, high = summary.loc[name, ["mean", "low", "high"]].to_numpy(dtype=float)
        if np.isfinite(mean):
            ax.plot([mean], [row], color="black", marker="|", markersize=9, zorder=4)
            if np.isfinite(low) and np.isfinite(high):
                left = max(low, known.min() / 2) if logarithmic else low
                ax.plot([left, high], [row, row], color="black", linestyle="-", linewidth=1.0, zorder=4)
    if known.size and not logarithmic and known.min() >= 0:
        ax.set_xlim(0.0, 1.12 * known.max() or 1.0)  # lengths from 0 can be compared
    name = f"{about.title.partition(':')[0]} [{'m' if small else ''}{about.unit}]"
    better = "better →" if about.larger else "← better"
    ax.set_xlabel(
        textwrap.fill(name.replace(" [", "\N{NO-BREAK SPACE}["), 26, break_long_words=False)
        + f"\n{better}{'; logarithmic' if logarithmic else ''}",
        parse_math=False,
    )
    ax.yaxis.grid(False)


def _write_never(ax: Axes, row: int, values: np.ndarray) -> None:
    never = int(np.isposinf(values).sum())
    if never:
        look: dict[str, Any] = {"ha": "right", "va": "center"} | on_white(0.5) | {"zorder": 5}
        ax.text(0.99, row, f"never: {never} of {len(values)} ×", transform=ax.get_yaxis_transform(), **look)
