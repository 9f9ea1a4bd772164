"""One page about a team's run: where the robots went, their errors and speeds, and whether they arrived together.

The panels are those of the thesis's figures: trajectories (3.5, 4.4, 4.8, 4.12, 5.26, 5.29), errors and speeds
(3.6, 4.5, 4.6, 5.27, 5.30), and the differences s_i − s_j (4.7, 4.11, 4.15, 4.17).
"""

import warnings
from collections.abc import Sequence
from functools import partial
from itertools import combinations
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.layout_engine import ConstrainedLayoutEngine

from fuzzy.figures.drawing import DOUBLE, line_look, styled_figure
from fuzzy.shown import shown
from robotics.measures.standing import last_move
from robotics.measures.tracking import tracking_error
from robotics.show.figures.drawing import (
    ABOVE,
    TARGET,
    PlotError,
    draw_legend,
    draw_line,
    draw_many,
    draw_title,
    fill_band,
    is_band,
    last_known,
    on_white,
    page_title,
    top_view_height,
    unjumped,
)
from robotics.show.figures.faults import FEW_ROBOTS, WORDS, shade_panels
from robotics.show.figures.page import TimePlot, draw_page
from robotics.show.figures.robots import FAINT, START, draw_path, draw_robots, draw_way, robot_look, seed_order
from robotics.show.figures.world import draw_surroundings
from robotics.simulation.run import Run
from robotics.simulation.spans import FaultSpan, fault_spans, seed_place

_PAIRS = 4  # robots: in a larger team each is compared with the median instead of with every other
_NAMED = 6  # faults that are named in the picture

LEAST = 1e-3  # the axis of the differences of progress reaches at least as far to either side


def plot_team(run: Run, seed: int | None = None, width: float = DOUBLE) -> Figure:
    """Draw the page of a team: trajectories, errors against the law's own target, speeds, progress, its differences.

    One seed is drawn boldly, up to 39 others faintly behind it; over time 5 seeds and more are bands from the 5th to
    the 95th percentile of each robot. More than 8 robots are thin lines over a band from the 5th to the 95th percentile
    with their median, of that seed alone. Faults are shaded, hatched by kind, and named.
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
    robots = run.samples.shape[3]
    order = seed_order(run, seed)[: None if robots <= FEW_ROBOTS else 1]
    faults, error = fault_spans(run, order[0]), tracking_error(run)
    progress = run["progress"] if run.team is not None else np.full_like(error.x, np.nan)
    known = bool(np.isfinite(progress).any())
    apart = _most_apart(progress[order]) if known else 0.0

    def panel(label: str, values: np.ndarray) -> TimePlot:
        return TimePlot(label, partial(draw_team_channel, run=run, values=values, order=order))

    last = panel("progress s", progress) if known else panel("to the target [m]", np.hypot(error.x, error.y))
    rows: list[tuple[TimePlot, ...]] = [
        (panel("x error [m]", error.x), panel("v [m/s]", run["v"])),
        (panel("y error [m]", error.y), panel("ω [rad/s]", run["w"])),
        (panel("heading error [rad]", unjumped(error.heading)), last),
    ]
    if apart >= LEAST:
        rows.append((differences_panel(run, progress, order),))
    heights = [top_view_height(run.paths, 0.9 * width), 1.15, 1.15, 1.15, 1.45][: 1 + len(rows)]
    with styled_figure(width, sum(heights) + (2.0 if apart >= LEAST else 1.6)) as figure:
        engine = figure.get_layout_engine()
        assert isinstance(engine, ConstrainedLayoutEngine)
        engine.set(w_pad=0.08)  # inches: labels that are aligned below may move a little outwards
        span = float(run.time[0]), float(run.time[-1])
        axes = draw_page(figure, rows, heights, partial(_draw_top_view, run=run, order=order, faults=faults), span)
        if known and apart < LEAST:
            said = f"all within {shown(apart, digits=1)} of each other"
            axes[-1].text(0.98, 0.06, said, transform=axes[-1].transAxes, ha="right", fontsize=6.5)
        draw_title(figure, run, order, banded=True)
        shade_panels(figure, axes, faults, span, axes[-1] if len(faults) <= _NAMED else None)
        return figure


def _most_apart(progress: np.ndarray) -> float:
    """The largest difference of progress (runs, robots, samples) between two robots of a run, at any time."""
    with warnings.catch_warnings(action="ignore", category=RuntimeWarning):  # once all are stopped: not-a-number
        apart = np.nanmax(progress, axis=1) - np.nanmin(progress, axis=1)
    return float(np.nanmax(apart, initial=0.0))


def _look(robot: int, robots: int, bold: bool, thin: float) -> dict[str, Any]:
    return robot_look(robot, robots, bold, step=min(0.5, 1.2 / robots), thin=thin)


def _draw_top_view(ax: Axes, run: Run, order: list[int], faults: Sequence[FaultSpan]) -> None:
    robots, first = run.samples.shape[3], order[0]
    few = robots <= FEW_ROBOTS
    for i in range(robots):
        draw_path(ax, run, i, quiet=not few, zorder=1)
        for r in reversed(order):
            bold = r == first
            name = f"robot {i + 1}" if bold and few else None
            draw_way(ax, run, r, i, **_look(i, robots, bold, 0.6), label=name)
    size: dict[str, Any] = {"markersize": 4 if few else 2, "markeredgewidth": 1 if few else 0.5, "zorder": 5}
    x, y = run["x"][first], run["y"][first]
    ax.plot(x[:, 0], y[:, 0], **START | size, label="start")
    ends = [last_known(row) for row in x]
    pairs = [(x[i, k], y[i, k]) for i, k in enumerate(ends) if k >= 0 and not run.diverged[first, i]]
    ax.plot(*np.reshape(pairs, (-1, 2)).T, marker="s", linestyle="none", color="black", label="end", **size)
    drawn = [f for f in faults if np.isfinite(run["x"][first, f.robot, np.searchsorted(run.time, f.start)])]
    for f in drawn[:_NAMED]:
        k = int(np.searchsorted(run.time, f.start))
        ax.plot(x[f.robot, k], y[f.robot, k], marker="v", markersize=5, color="black", zorder=6)
        at, words = (x[f.robot, k], y[f.robot, k]), f"{f.robot + 1}: {WORDS[f.kind]}"
        ax.annotate(words, at, (4, 5), textcoords="offset points", **on_white(0.6))
    bodies, names = few and run.obstacles is not None, ("path", "start", "end", "contact")
    draw_surroundings(ax, run, first, last_move(run, first), names, bodies)


def draw_team_channel(ax: Axes, run: Run, values: np.ndarray, order: list[int], named: bool = False) -> None:
    """Draw one channel over time: a line for each robot, a band and a median for many.

    Args:
        ax: The axes.
        run: The run.
        values: The channel (runs, robots, samples).
        order: The places of the seeds that are drawn, the first one boldly.
        named: Whether a legend is to know few robots' lines.
    """
    robots = values.shape[1]
    if robots > FEW_ROBOTS:
        draw_many(ax, run.time, values[order[0]])
        return

    def look(robot: int, bold: bool) -> dict[str, Any]:
        return _look(robot, robots, bold, 0.5) | {"label": f"robot {robot + 1}" if named and bold else None}

    draw_robots(ax, run, values, order, look, band=True)


def differences_panel(run: Run, progress: np.ndarray, order: list[int], unit: str = "") -> TimePlot:
    """The panel of s_i − s_j of every pair of few robots, or of s_i minus the median of the team.

    Args:
        run: The run.
        progress: s (runs, robots, samples) [1].
        order: The places of the seeds that are drawn, the first one boldly.
        unit: What stands behind the label.
    """
    label = "$s_i − s_j$" if progress.shape[1] <= _PAIRS else "$s_i$ − median"
    return TimePlot(label + unit, partial(_draw_differences, run=run, progress=progress, order=order))


def _draw_differences(ax: Axes, run: Run, progress: np.ndarray, order: list[int]) -> None:
    robots, first = progress.shape[1], order[0]
    ax.axhline(0.0, **TARGET)
    if robots <= _PAIRS:
        for n, (i, j) in enumerate(combinations(range(robots), 2), start=3):  # other looks than those of robots 1 to 3
            apart, color = progress[:, i] - progress[:, j], str(line_look(n)["color"])
            banded = is_band(order)
            if banded:
                fill_band(ax, run.time, apart[order], color)
            for r in order[:1] if banded else reversed(order):
                bold = r == first
                over = robots * (robots - 1) // 2 + 2 - n  # lines that are drawn over this one
                look = {"alpha": 1.0 if bold else FAINT, "linewidth": 1.0 + 0.3 * over if bold else 0.5}
                name = f"$s_{{{i + 1}}} − s_{{{j + 1}}}$" if bold else None
                draw_line(ax, run.time, apart[r], **line_look(n), label=name, **look)
    else:
        with warnings.catch_warnings(action="ignore", category=RuntimeWarning):
            rows = progress - np.nanmedian(progress, axis=1, keepdims=True)
        draw_team_channel(ax, run, rows, order)
    low, high = ax.get_ylim()
    ax.set_ylim(min(low, -LEAST), max(high, LEAST))  # differences of rounding are none
    if ax.get_legend_handles_labels()[0]:
        ax.legend(ncol=6, **ABOVE)


def plot_progress(run: Run, *, seed: int | None = None) -> Figure:
    """Draw the progress s [1] that the robots of a team tell each other over time [s], and how far they are apart.

    Up to four robots have a line for every difference s_i − s_j; of more, each is compared with the team's median.
    The times in which a robot is at fault are hatched, with its number and its fault.

    Args:
        run: A run of a team whose law coordinates progress.
        seed: The seed that is drawn, by default the first.

    Raises:
        PlotError: A run without progress.
        ReplayError: A seed that was not run.
    """
    place = seed_place(run, seed)
    if run.team is None or not np.isfinite(run["progress"]).any():
        raise PlotError(f"the run of {run.controller!r} on {run.scenario!r} has no progress: its law coordinates none")
    span = float(run.time[0]), float(run.time[-1])
    draw = partial(draw_team_channel, run=run, values=run["progress"], order=[place], named=True)
    rows = [(TimePlot("progress s [1]", draw),), (differences_panel(run, run["progress"], [place], " [1]"),)]
    with styled_figure(DOUBLE, 4.2) as figure:
        axes = draw_page(figure, rows, span=span)
        figure.suptitle(page_title(run, [place]), parse_math=False, fontsize=9)
        draw_legend(axes[0], **ABOVE)
        faults = fault_spans(run, place)
        shade_panels(figure, axes, faults, span, axes[0] if len(faults) <= FEW_ROBOTS else None)
        return figure
