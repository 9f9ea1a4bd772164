"""One page about how robots avoided each other or obstacles: a column a law, a row for each of the thesis's figures.

Tests of crash avoidance have the thesis's Figs 6.9-6.18: trajectories and where two came nearest, distances d_ij,
errors and speeds. Runs among obstacles have Figs 6.28-6.43: trajectories, errors, speeds, and what the sonars of
robot 1 saw, with its true clearance and each robot's mode.
"""

import textwrap
from collections.abc import Callable, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np
from matplotlib.artist import setp
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from fuzzy.figures.drawing import COLORS, DOUBLE, figure_of, line_look, styled_figure, text_width
from robotics.laws.catalogue import law_title
from robotics.measures.clearance import clearances
from robotics.measures.tracking import cross_track_error, tracking_error
from robotics.plugins.encounters.distances import draw_distances
from robotics.plugins.encounters.meetings import nearest_pairs
from robotics.plugins.encounters.modes import draw_modes
from robotics.show.figures.drawing import (
    TARGET,
    PlotError,
    draw_common_legend,
    draw_line,
    draw_many,
    legend_entries,
    mark_contacts,
    shown_until,
    unjumped,
)
from robotics.show.figures.faults import FEW_ROBOTS
from robotics.show.figures.robots import draw_path, draw_way
from robotics.show.figures.world import draw_bodies, draw_body, draw_world
from robotics.simulation.run import Run
from robotics.simulation.spans import seed_place

CRASH_ROWS = ("trajectories", "distances", "cross-track", "heading", "v", "w", "progress")
OBSTACLE_ROWS = ("trajectories", "cross-track", "sonar", "v", "w", "distances", "modes")
_FAR = 2.05  # m: what the panel of sonars shows
_LEFT, _RIGHT, _GAP, _ROW, _TOP, _BETWEEN = 0.62, 0.1, 0.24, 0.82, 0.62, 0.2  # inches
_LEGEND: dict[str, Any] = {"borderaxespad": 0.1, "fontsize": 6.5, "handlelength": 2.0, "columnspacing": 1.0}
# Rows of the report's two figures of a scenario: where robots were and who met whom; errors and speeds
WHERE = ("trajectories", "distances", "sonar", "modes", "progress")
HOW = ("cross-track", "heading", "v", "w")


class _View(NamedTuple):
    """A run, and which part of it is drawn."""

    run: Run
    place: int  # of the seed
    end: int  # samples shown


def plot_avoidance(
    runs: Run | Sequence[Run],
    seed: int | None = None,
    figures: Mapping[str, str] | None = None,
    rows: Sequence[str] | None = None,
    width: float = DOUBLE,
) -> Figure:
    """Draw one to three laws on one scenario, side by side.

    The distances have a line at what the law keeps: d_min, or the clearance of its plan. Robots are drawn in true size
    at equal times, and filled where two of them came nearest.

    Args:
        runs: A run, or up to three on one scenario.
        seed: The seed that is drawn, by default the first.
        figures: A source's figure of a row, such as {"distances": "thesis Fig 6.11"}.
        rows: The rows that are drawn, by default CRASH_ROWS, among obstacles OBSTACLE_ROWS; rows that no run has are
            left out.
        width: The width of the figure in inches.

    Raises:
        ReplayError: A seed that was not run.
        PlotError: No run, or runs of several scenarios.
    """
    runs = [runs] if isinstance(runs, Run) else runs
    if not 1 <= len(runs) <= 3 or len({run.scenario for run in runs}) > 1:
        raise PlotError("a page about avoidance needs one to three runs on one scenario")
    shown = max(float(run.time[shown_until(run, seed_place(run, seed)) - 1]) for run in runs)
    views = [_View(run, seed_place(run, seed), int(np.searchsorted(run.time, shown + 1e-9))) for run in runs]
    usual = CRASH_ROWS if runs[0].obstacles is None else OBSTACLE_ROWS
    chosen = [row for row in rows or usual if any(_has(run, row) for run in runs)]
    panel = (width - _LEFT - _RIGHT - _BETWEEN * (len(runs) - 1)) / len(runs)
    heights = [_height(views, panel) if row == "trajectories" else _ROW for row in chosen]
    breaks = [_GAP + (0.38 if row == "trajectories" else 0.0) for row in chosen]
    titles = [textwrap.fill(law_title(view.run.controller), max(8, int(panel / text_width("n", 8)))) for view in views]
    above = _TOP + 0.14 * max(title.count("\n") for title in titles)
    total = above + sum(heights) + sum(breaks) + 0.17
    with styled_figure(width, total, constrained=False) as figure:
        top = total - above
        for row, height, gap in zip(chosen, heights, breaks, strict=True):
            axes: list[Axes] = []
            for column, view in enumerate(views):
                box = (_LEFT + column * (panel + _BETWEEN), top - height, panel, height)
                place = (box[0] / width, box[1] / total, box[2] / width, box[3] / total)
                ax = figure.add_axes(place, sharey=axes[0] if axes else None)
                axes.append(ax)
                _ROWS[row].draw(ax, view)
                if row == "trajectories":
                    ax.set_xlabel("x [m]")
                else:
                    ax.set_xlim(0.0, shown)
                    ax.tick_params(labelbottom=row == chosen[-1])
                if row == chosen[-1]:
                    ax.set_xlabel("time [s]")
                if column:
                    ax.tick_params(labelleft=False)
                    continue
                ax.set_ylabel(_ROWS[row].label)
                if figures and row in figures:
                    ax.set_title(figures[row], loc="left", fontsize=7, pad=2.5, color="0.3")
            if row != "trajectories":
                _legend(axes, top / total)
            top -= height + gap
        for column, title in enumerate(titles):
            x = (_LEFT + column * (panel + _BETWEEN) + panel / 2) / width
            figure.text(x, 1 - (above - 0.18) / total, title, ha="center", fontsize=8, parse_math=False)
        figure.text(0.1 / width, 1 - 0.2 / total, _named(views[0]), fontsize=9, parse_math=False)
        _robots_legend(figure, views, chosen)
        return figure


def plot_trajectories(rows: Sequence[Sequence[Run]], seed: int | None = None) -> Figure:
    """Draw where robots drove: a row a scenario, a column a law; robots in true size as in :func:`plot_avoidance`.

    Args:
        rows: The runs on one scenario each, as many laws in each row, in the same order.
        seed: The seed that is drawn, by default the first.

    Raises:
        ReplayError: A seed that was not run.
        PlotError: A row has several scenarios, or rows differ in their laws.
    """
    laws = {tuple(run.controller for run in row) for row in rows}
    if len(laws) != 1 or not all(len({run.scenario for run in row}) == 1 for row in rows):
        raise PlotError("a page of trajectories needs one scenario a row, and the same laws in each row")
    views = [
        [_View(run, place, shown_until(run, place)) for run in row for place in [seed_place(run, seed)]] for row in rows
    ]
    width = (DOUBLE - _LEFT) / len(views[0])
    with styled_figure(DOUBLE, sum(_height(row, width) + 0.35 for row in views) + 0.45) as figure:
        grid = figure.subplots(
            len(rows), len(views[0]), squeeze=False, height_ratios=[_height(row, width) for row in views]
        )
        for panels, row in zip(grid, views, strict=True):
            for ax, view in zip(panels, row, strict=True):
                _trajectories(ax, view)
            panels[0].set_ylabel(f"{_named(row[0])}\ny [m]", parse_math=False)
        for ax, view in zip(grid[0], views[0], strict=True):
            ax.set_title(law_title(view.run.controller), fontsize=9, parse_math=False)
        setp(grid[-1], xlabel="x [m]")
        draw_common_legend(figure, grid[0, :1], loc="outside lower center", ncol=6)
        return figure


def _named(view: _View) -> str:
    return f"{view.run.scenario}, seed {view.run.seeds[view.place]}"


def _has(run: Run, row: str) -> bool:
    if row == "sonar":
        return run.obstacles is not None
    if row == "modes":
        return run.modes is not None
    return row != "progress" or (run.team is not None and bool(np.isfinite(run["progress"]).any()))


def _height(views: Sequence[_View], width: float) -> float:
    points = np.concatenate([nodes for view in views for nodes in view.run.paths], axis=1)
    across, up = points.max(axis=1) - points.min(axis=1) + 0.5
    return float(np.clip(width * up / across, 1.2, 2.3))


def _robots_legend(figure: Figure, views: Sequence[_View], rows: Sequence[str]) -> None:
    """At the top, what holds of all panels: the robots' lines, and of the trajectories what else is in them."""
    robots = len(views[0].run.paths)
    entries: dict[str, Any] = {}
    if robots <= FEW_ROBOTS:
        entries |= {f"robot {i + 1}": Line2D([], [], **line_look(i), linewidth=1.1) for i in range(robots)}
    if "trajectories" in rows:
        found = legend_entries(*figure.axes[: len(views)])
        entries |= {name: found[name] for name in ("path", "contact") if name in found}
    if entries:
        options = _LEGEND | {"loc": "upper right", "ncol": 3}
        figure.legend(list(entries.values()), list(entries), **options)


def _legend(axes: Sequence[Axes], top: float) -> None:
    """One legend for a row, over its panels; ``top`` is their upper edge, as a share of the figure."""
    ax = axes[-1]
    if legend_entries(*axes):
        place = {"bbox_to_anchor": (ax.get_position().x1, top), "bbox_transform": figure_of(ax).transFigure}
        draw_common_legend(ax, axes, **_LEGEND | place | {"loc": "lower right", "ncol": 6})


# One panel each ---------------------------------------------------------------------------------------------------


def _trajectories(ax: Axes, view: _View) -> None:
    run, place, end = view
    draw_world(ax, run, end - 1)
    draw_bodies(ax, run, place, end - 1)
    met = nearest_pairs(run, place, end)[:1]
    robots = len(run.paths)
    for i in range(robots):
        draw_path(ax, run, i, zorder=1)
        name = f"robot {i + 1}" if robots <= FEW_ROBOTS else None
        draw_way(ax, run, place, i, end, **line_look(i), linewidth=1.1, label=name)
        for sample in (sample for pair, sample, _ in met if i in pair):
            draw_body(ax, run, place, i, np.array([sample]), facecolors=line_look(i)["color"], zorder=4)
    mark_contacts(ax, run, place, until=float(run.time[end - 1]))
    ax.set_aspect("equal", adjustable="datalim")


def _per_robot(values: Callable[[_View], np.ndarray]) -> Callable[[Axes, _View], None]:
    def draw(ax: Axes, view: _View) -> None:
        ax.axhline(0.0, **TARGET)
        rows = values(view)
        if len(rows) > FEW_ROBOTS:
            draw_many(ax, view.run.time[: view.end], rows[:, : view.end])
            return
        for i, row in enumerate(rows):
            look = line_look(i) | {"linewidth": 0.8 + 0.4 * (len(rows) - 1 - i) / max(len(rows) - 1, 1)}
            draw_line(ax, view.run.time[: view.end], row[: view.end], **look)

    return draw


def _sonar(ax: Axes, view: _View) -> None:
    run, place, end = view
    time = run.time[:end]
    if run.ranges is not None:
        read = run.ranges[:end, place, 0].astype(float)
        pairs = {"robot 1: front sonars": slice(0, 2), "side sonars": slice(2, 4)}  # of SONAR
        for n, (name, sensors) in enumerate(pairs.items()):
            nearest = read[:, sensors].min(axis=1)
            look = {"color": COLORS[n + 4], "linestyle": "-", "linewidth": 0.8}
            draw_line(ax, time, np.where(np.isfinite(nearest), nearest, np.nan), label=name, **look)
    free = np.minimum(clearances(run, place)[0, :end], 10.0)
    draw_line(ax, time, free, color="black", linestyle="--", linewidth=0.9, label="true clearance")
    ax.set_ylim(0.0, _FAR)


class _Row(NamedTuple):
    """A row of panels, one for each law."""

    label: str  # of the y axis, with its unit
    draw: Callable[[Axes, _View], None]


_ROWS = {
    "trajectories": _Row("y [m]", _trajectories),
    "distances": _Row("distance [m]", lambda ax, view: draw_distances(ax, *view)),
    "cross-track": _Row("$y_{err}$ [m]", _per_robot(lambda view: cross_track_error(view.run)[view.place])),
    "heading": _Row("$ψ_{err}$ [rad]", _per_robot(lambda view: unjumped(tracking_error(view.run).heading[view.place]))),
    "sonar": _Row("obstacle [m]", _sonar),
    "v": _Row("v [m/s]", _per_robot(lambda view: view.run["v"][view.place])),
    "w": _Row("ω [rad/s]", _per_robot(lambda view: view.run["w"][view.place])),
    "progress": _Row("progress s", _per_robot(lambda view: view.run["progress"][view.place])),
    "modes": _Row("robot", lambda ax, view: draw_modes(ax, *view)),
}
