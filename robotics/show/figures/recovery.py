"""Pictures of many team runs: recovery against the length of an outage, and how coordination scales."""

import textwrap
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter

from fuzzy.figures.drawing import COLORS, DOUBLE, LINES, PAGE_WIDTH, number, styled_figure
from robotics.laws.catalogue import law_title
from robotics.measures.evidence import Estimate, rate_of
from robotics.show.figures.drawing import TARGET, draw_common_legend, panel_grid, scale_values
from robotics.studies.recovery import Recovery
from robotics.studies.scaling import Scaling

_MARKERS = "os^Dv"


def plot_recovery(recoveries: Sequence[Recovery], width: float = DOUBLE) -> Figure:
    """Draw the share of runs that recover, with Wilson's interval, and the largest distance from the path.

    Controllers stand side by side at each length of an outage, so that none covers another.

    Args:
        recoveries: What is drawn, by controller and outage.
        width: The width of the figure in inches.
    """
    names = list(dict.fromkeys(r.controller for r in recoveries))
    with styled_figure(width, 2.3 + 0.15 * len(names)) as figure:
        left, right = figure.subplots(1, 2)
        for i, name in enumerate(names):
            mine = [r for r in recoveries if r.controller == name]
            at = np.array([r.outage for r in mine]) + 0.5 * (i - (len(names) - 1) / 2)
            look = {"color": COLORS[i], "linestyle": LINES[i], "marker": _MARKERS[i], "markersize": 4, "linewidth": 0.9}
            shares = [rate_of(r.recovered) for r in mine]
            ends = np.array([[s.value - s.low, s.high - s.value] for s in shares]).T
            values = [100 * s.value for s in shares]
            left.errorbar(at, values, 100 * ends, label=law_title(name), capsize=2, elinewidth=0.8, **look)
            right.plot(at, [float(r.deviation.mean()) for r in mine], **look)
        left.axvline(15.0, color="0.45", linewidth=0.8, linestyle=(0, (4, 2)))
        left.text(14.7, 3, "limit in\nthe thesis", fontsize=7, color="0.3", ha="right")
        left.set(ylim=(-3, 103), ylabel="teams that recover [%]")
        right.set_ylim(bottom=0)
        right.set_ylabel("largest distance from\nthe path, mean [m]")
        for ax in (left, right):
            ax.set_xticks(sorted({r.outage for r in recoveries}))
            ax.set_xlabel("length of the outage [s]")
        counts = sorted({len(r.recovered) for r in recoveries})
        figure.legend(
            loc="outside upper left",
            ncol=3 if width > PAGE_WIDTH else 1,
            title_fontsize=7,
            title=f"{' or '.join(map(str, counts))} runs a point",
        )
        return figure


def plot_robot_errors(
    means: Mapping[str, Sequence[Sequence[Estimate]]], titles: Sequence[str], width: float = DOUBLE
) -> Figure:
    """Draw errors of several laws, a panel for each kind of error, in it a row for each law and a dot for each robot.

    Bars are the intervals of the means. An axis whose values span more than a decade is logarithmic, and says so.

    Args:
        means: By the law's title, for each kind of error the means of the robots.
        titles: The kinds of errors, with their units.
        width: The width of the figure in inches.
    """
    columns = 4 if width > PAGE_WIDTH else 2
    with styled_figure(width, 0.3 + -(-len(titles) // columns) * (0.55 + 0.34 * len(means))) as figure:
        axes = panel_grid(figure, len(titles), columns)
        for k, (ax, title) in enumerate(zip(axes, titles, strict=True)):
            _draw_robot_errors(ax, [kinds[k] for kinds in means.values()], title)
        axes[0].set_yticks(range(len(means)), [textwrap.fill(name, 22) for name in means], parse_math=False)
        axes[0].set_ylim(len(means) - 0.5, -0.5)
        draw_common_legend(figure, axes[:1], loc="outside upper right")
        return figure


def _draw_robot_errors(ax: Axes, rows: Sequence[Sequence[Estimate]], title: str) -> None:
    known = np.array([mean.value for row in rows for mean in row])
    logarithmic = scale_values(ax, known)
    for row, robots in enumerate(rows):
        for i, mean in enumerate(robots):
            at = row + 0.22 * (i - (len(robots) - 1) / 2)
            low = max(mean.low, known.min() / 2) if logarithmic else mean.low
            ax.plot([low, mean.high], [at, at], color=COLORS[i], linestyle="-", linewidth=0.9)
            look: dict[str, Any] = {"color": COLORS[i], "marker": _MARKERS[i], "markersize": 3.5, "linestyle": "none"}
            ax.plot([mean.value], [at], **look, label=f"robot {i + 1}")
    if not logarithmic:
        ax.set_xlim(0.0, 1.1 * max(mean.high for row in rows for mean in row if np.isfinite(mean.high)))
    ax.xaxis.set_major_formatter(FuncFormatter(lambda value, _: number(value)))
    ax.yaxis.grid(False)
    ax.set_xlabel(f"{title}\n← better{'; logarithmic' if logarithmic else ''}", parse_math=False)


def plot_scaling(scaling: Sequence[Scaling], width: float = DOUBLE) -> Figure:
    """Draw spread and delay of the arrivals over the number of robots, a line for each share of lost messages.

    A point is one team. Below the grey line arrivals differ by less than a sample.

    Args:
        scaling: The teams.
        width: The width of the figure in inches.
    """
    losses = sorted({s.loss for s in scaling})
    sizes = sorted({s.robots for s in scaling})
    with styled_figure(width, 2.5) as figure:
        left, right = figure.subplots(1, 2)
        for i, loss in enumerate(losses):
            mine = [s for s in scaling if s.loss == loss]
            at = np.array([s.robots for s in mine]) * 1.02 ** (i - (len(losses) - 1) / 2)
            look = {"color": COLORS[i], "linestyle": LINES[i], "marker": _MARKERS[i], "markersize": 4}
            look |= {"linewidth": 1.0 + 0.8 * (len(losses) - 1 - i)}  # lines below others are wider
            left.plot(at, [s.spread for s in mine], label=f"{100 * loss:g} % of messages lost", **look)
            right.plot(at, [s.late for s in mine], **look)
        step = max(s.step for s in scaling)
        left.axhline(step, **TARGET)
        left.text(0.02, step, f" a sample: {step:g} s", transform=left.get_yaxis_transform(), va="bottom", fontsize=6.5)
        for ax in (left, right):
            ax.set_xscale("log")
            ax.set_xticks(sizes, [str(n) for n in sizes])
            ax.minorticks_off()
            ax.set_xlabel("robots, logarithmic")
        left.set(ylim=(0.0, 1.15 * max(2 * step, *(s.spread for s in scaling))), ylabel="spread of the arrivals [s]")
        right.set_ylabel("arrival of the last\nafter the reference's end [s]")
        figure.legend(loc="outside upper center", ncol=len(losses), title="one team a point", title_fontsize=7)
        return figure
