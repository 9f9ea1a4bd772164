"""One page about a team's run: where the robots went, their errors and speeds, and whether they arrived together.

The panels are those of the thesis's figures: trajectories (3.5, 4.4, 4.8, 4.12, 5.26, 5.29), errors and speeds
(3.6, 4.5, 4.6, 5.27, 5.30), and the differences s_i − s_j (4.7, 4.11, 4.15, 4.17).
"""

import warnings
from collections.abc import Iterable
from itertools import combinations
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.layout_engine import ConstrainedLayoutEngine

from fuzzy.figures.drawing import COLORS, DOUBLE, LINES, new_figure, style
from fuzzy.shown import shown
from robotics.figures.drawing import (
    TARGET,
    draw_legend,
    draw_line,
    draw_many,
    draw_title,
    draw_top_view,
    last_known,
    mark_contacts,
    mark_stop,
    strided,
    top_view_height,
    unjumped,
)
from robotics.figures.faults import FEW, WORDS, shade_faults
from robotics.figures.world import draw_bodies, draw_world
from robotics.measures.standing import last_move
from robotics.measures.tracking import tracking_error
from robotics.simulation.run import Run
from robotics.simulation.spans import FaultSpan, fault_spans, seed_place

_PAIRS = 4  # robots: in a larger team each is compared with the median instead of with every other
_FAINT = 0.25  # opacity of the other seeds
_MOST = 40  # seeds drawn
_NAMED = 6  # faults that are named in the picture

LEAST = 1e-3  # the axis of the differences of progress reaches at least as far to either side


def plot_team(run: Run, seed: int | None = None, width: float = DOUBLE) -> Figure:
    """Draw the page of a team: trajectories, errors against the law's own target, speeds, progress, its differences.

    One seed is drawn boldly, up to 39 others faintly behind it. More than 8 robots are thin lines over a band from the
    5th to the 95th percentile with their median, of that seed alone. Faults are shaded, hatched by kind, and named.
    Among obstacles few robots are drawn in true size too, all at the same times, as are obstacles that move. Where all
    robots are within 0.001 of each other at any time, the panel of the differences of progress is left out, and that of
    progress says so.

    Args:
        run: The run of a team.
        seed: The seed that is drawn boldly, by default the first.
        width: The width of the figure in inches.

    Raises:
        ReplayError: A seed that was not run.
    """
    place = seed_place(run, seed)
    order = [place, *(r for r in range(len(run.seeds)) if r != place)]
    robots = run.samples.shape[3]
    order = order[: _MOST if robots <= FEW else 1]
    faults, error = fault_spans(run, place), tracking_error(run)
    progress = run["progress"] if run.team is not None else np.full_like(error.x, np.nan)
    known = bool(np.isfinite(progress).any())
    last = ("progress s", progress) if known else ("to the target [m]", np.hypot(error.x, error.y))
    panels = [
        [("x error [m]", error.x), ("v [m/s]", run["v"])],
        [("y error [m]", error.y), ("ω [rad/s]", run["w"])],
        [("heading error [rad]", unjumped(error.heading)), last],
    ]
    apart = _most_apart(progress[order]) if known else 0.0
    with style():
        heights = [top_view_height(run.paths, 0.9 * width), 1.15, 1.15, 1.15, *([1.45] if apart >= LEAST else [])]
        figure = new_figure(width, sum(heights) + (2.0 if apart >= LEAST else 1.6))
        engine = figure.get_layout_engine()
        assert isinstance(engine, ConstrainedLayoutEngine)
        engine.set(w_pad=0.08)  # inches: labels that are aligned below may move a little outwards
        grid = figure.add_gridspec(len(heights), 2, height_ratios=heights)
        _draw_top_view(figure.add_subplot(grid[0, :]), run, order, faults)
        axes: list[Axes] = []
        for row, pair in enumerate(panels, start=1):
            for column, (name, values) in enumerate(pair):
                ax = figure.add_subplot(grid[row, column], sharex=axes[0] if axes else None)
                axes.append(ax)
                draw_team_channel(ax, run, values, order)
                ax.set_ylabel(name)
                ax.tick_params(labelbottom=row == len(panels))
        for ax in axes[-2:]:
            ax.set_xlabel("time [s]")
        if known and apart < LEAST:
            said = f"all within {shown(apart, digits=1)} of each other"
            axes[-1].text(0.98, 0.06, said, transform=axes[-1].transAxes, ha="right", fontsize=6.5)
        if apart >= LEAST:
            bottom = figure.add_subplot(grid[4, :], sharex=axes[0])
            axes.append(bottom)
            draw_differences(bottom, run, progress, order)
            bottom.set_xlabel("time [s]")
        start, end = float(run.time[0]), float(run.time[-1])
        axes[0].set_xlim(start, end)
        figure.align_ylabels()
        draw_title(figure, run, order)
        figure.draw_without_rendering()  # the names of faults need the widths of the panels
        figure.set_layout_engine("none")  # which then stay
        for ax in axes:
            shade_faults(ax, faults, start, end, named=ax is axes[-1] and len(faults) <= _NAMED)
        return figure


def _most_apart(progress: np.ndarray) -> float:
    """The largest difference of progress (runs, robots, samples) between two robots of a run, at any time."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", RuntimeWarning)  # once all are stopped: not-a-number
        apart = np.nanmax(progress, axis=1) - np.nanmin(progress, axis=1)
    return float(np.nanmax(apart, initial=0.0))


def _color(robot: int) -> str:
    return COLORS[robot % len(COLORS)]


def _width(robot: int, robots: int) -> float:
    """The width of a robot's line in points: those that are drawn first, below the others, are wider."""
    return 1.0 + min(0.5, 1.2 / robots) * (robots - 1 - robot)


def _draw_top_view(ax: Axes, run: Run, order: list[int], faults: Iterable[FaultSpan]) -> None:
    few, first = run.samples.shape[3] <= FEW, order[0]
    for i, nodes in enumerate(run.paths):
        quiet = TARGET if few else TARGET | {"linewidth": 0.5, "alpha": 0.6}
        ax.plot(*strided(*nodes), **quiet, zorder=1, label=None if i else "path")  # type: ignore[arg-type]
        for r in reversed(order):
            x, y = run["x"][r, i], run["y"][r, i]
            bold = r == first
            ax.plot(
                *strided(x, y),
                color=_color(i),
                linestyle=LINES[i % 7] if few else "-",
                alpha=1.0 if bold else _FAINT,
                linewidth=_width(i, len(run.paths)) if bold and few else 0.6,
                label=f"robot {i + 1}" if bold and few else None,
            )
            if run.diverged[r, i] and (k := last_known(x)) >= 0:
                mark_stop(ax, x[k], y[k], _color(i))
    size: dict[str, Any] = {"markersize": 4 if few else 2, "markeredgewidth": 1 if few else 0.5}
    size |= {"linestyle": "none", "color": "black", "zorder": 5}
    x, y = run["x"][first], run["y"][first]
    ax.plot(x[:, 0], y[:, 0], marker="o", markerfacecolor="white", label="start", **size)
    ends = [last_known(row) for row in x]
    pairs = [(x[i, k], y[i, k]) for i, k in enumerate(ends) if k >= 0 and not run.diverged[first, i]]
    ax.plot(*np.reshape(pairs, (-1, 2)).T, marker="s", label="end", **size)
    drawn = [f for f in faults if np.isfinite(run["x"][first, f.robot, np.searchsorted(run.time, f.start)])]
    for f in drawn[:_NAMED]:
        k = int(np.searchsorted(run.time, f.start))
        ax.plot(x[f.robot, k], y[f.robot, k], marker="v", markersize=5, color="black", zorder=6)
        box = {"facecolor": "white", "edgecolor": "none", "pad": 0.6, "alpha": 0.8}
        ax.annotate(
            f"{f.robot + 1}: {WORDS[f.kind]}",
            (x[f.robot, k], y[f.robot, k]),
            (4, 5),
            textcoords="offset points",
            fontsize=6.5,
            bbox=box,
            zorder=6,
        )
    if run.obstacles is not None:
        last = last_move(run, first)
        draw_world(ax, run, last)
        if few:
            draw_bodies(ax, run, first, last)
    mark_contacts(ax, run, first)
    draw_top_view(ax)
    draw_legend(ax, ("path", "start", "end", "contact"))


def draw_team_channel(ax: Axes, run: Run, values: np.ndarray, order: list[int], named: bool = False) -> None:
    """Draw one channel over time: a line for each robot, a band and a median for many.

    Args:
        ax: The axes.
        run: The run.
        values: The channel (runs, robots, samples).
        order: The places of the seeds that are drawn, the first one boldly.
        named: Whether a legend is to know few robots' lines.
    """
    rows, first = values[order[0]], order[0]
    if rows.shape[0] > FEW:
        draw_many(ax, run.time, rows)
        return
    for i in range(rows.shape[0]):
        for r in reversed(order):
            alpha, width = (1.0, _width(i, rows.shape[0])) if r == first else (_FAINT, 0.5)
            look = {"color": _color(i), "linestyle": LINES[i % 7], "alpha": alpha, "linewidth": width}
            draw_line(ax, run.time, values[r, i], **look, label=f"robot {i + 1}" if named and r == first else None)
            if run.diverged[r, i] and (k := last_known(values[r, i])) >= 0:
                mark_stop(ax, run.time[k], values[r, i, k], _color(i))


def draw_differences(ax: Axes, run: Run, progress: np.ndarray, order: list[int]) -> None:
    """Draw s_i − s_j of every pair of few robots, or s_i minus the median of the team.

    Args:
        ax: The axes.
        run: The run.
        progress: s (runs, robots, samples) [1].
        order: The places of the seeds that are drawn, the first one boldly.
    """
    robots, first = progress.shape[1], order[0]
    ax.axhline(0.0, **TARGET)  # type: ignore[arg-type]
    if robots <= _PAIRS:
        for n, (i, j) in enumerate(combinations(range(robots), 2), start=3):  # other looks than those of robots 1 to 3
            for r in reversed(order):
                bold = r == first
                over = robots * (robots - 1) // 2 + 2 - n  # lines that are drawn over this one
                look = {"alpha": 1.0 if bold else _FAINT, "linewidth": 1.0 + 0.3 * over if bold else 0.5}
                name = f"$s_{{{i + 1}}} − s_{{{j + 1}}}$" if bold else None
                row = progress[r, i] - progress[r, j]
                draw_line(ax, run.time, row, color=_color(n), linestyle=LINES[n % 7], label=name, **look)
        ax.set_ylabel("$s_i − s_j$")
    else:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", RuntimeWarning)
            rows = progress - np.nanmedian(progress, axis=1, keepdims=True)
        draw_team_channel(ax, run, rows, order)
        ax.set_ylabel("$s_i$ − median")
    low, high = ax.get_ylim()
    ax.set_ylim(min(low, -LEAST), max(high, LEAST))  # differences of rounding are none
    if ax.get_legend_handles_labels()[0]:
        ax.legend(loc="lower right", bbox_to_anchor=(1.0, 1.0), ncol=6, borderaxespad=0.1)
