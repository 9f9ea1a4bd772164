"""One page about how robots avoided each other or obstacles: a column a law, a row for each of the thesis's figures.

Tests of crash avoidance have the thesis's Figs 6.9-6.18: trajectories and where two came nearest, distances d_ij,
errors and speeds. Runs among obstacles have Figs 6.28-6.43: trajectories, errors, speeds, and what the sonars of
robot 1 saw, with its true clearance and each robot's mode.
"""

from collections.abc import Callable, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from fuzzy.figures.drawing import COLORS, DOUBLE, LINES, new_figure, style
from robotics.figures.distances import draw_distances
from robotics.figures.drawing import (
    TARGET,
    PlotError,
    draw_line,
    draw_many,
    last_known,
    mark_contacts,
    mark_stop,
    shown_until,
    strided,
)
from robotics.figures.faults import FEW
from robotics.figures.modes import draw_modes
from robotics.figures.world import draw_bodies, draw_body, draw_world
from robotics.laws.catalogue import law_title
from robotics.measures.clearance import clearances, robot_gaps
from robotics.measures.tracking import cross_track_error, tracking_error
from robotics.sensing.sonar import FRONT_LEFT, FRONT_RIGHT, LEFT, RIGHT
from robotics.simulation.run import Run
from robotics.simulation.spans import seed_place

CRASH_ROWS = ("trajectories", "distances", "cross-track", "heading", "v", "w", "progress")
OBSTACLE_ROWS = ("trajectories", "cross-track", "sonar", "v", "w", "distances", "modes")
_FAR = 2.05  # m: what the panel of sonars shows
_LEFT, _RIGHT, _GAP, _ROW, _TOP, _BETWEEN = 0.7, 0.1, 0.24, 0.82, 0.6, 0.2  # inches


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
) -> Figure:
    """Draw one to three laws on one scenario, side by side.

    The distances have a line at what the law keeps: d_min, or the clearance of its plan. Robots are drawn in true size
    at equal times, and filled where two of them came nearest.

    Args:
        runs: A run, or up to three on one scenario.
        seed: The seed that is drawn, by default the first.
        figures: The thesis's figure of a row, such as {"distances": "Fig 6.11"}.
        rows: The rows that are drawn, by default CRASH_ROWS, among obstacles OBSTACLE_ROWS; rows that no run has are
            left out.

    Raises ReplayError for a seed that was not run, PlotError for no run, or runs of several scenarios.
    """
    runs = [runs] if isinstance(runs, Run) else runs
    if not 1 <= len(runs) <= 3 or len({run.scenario for run in runs}) > 1:
        raise PlotError("a page about avoidance needs one to three runs on one scenario")
    shown = max(float(run.time[shown_until(run, seed_place(run, seed)) - 1]) for run in runs)
    views = [_View(run, seed_place(run, seed), int(np.searchsorted(run.time, shown + 1e-9))) for run in runs]
    usual = CRASH_ROWS if runs[0].obstacles is None else OBSTACLE_ROWS
    chosen = [row for row in rows or usual if any(_has(run, row) for run in runs)]
    with style():
        width = (DOUBLE - _LEFT - _RIGHT - _BETWEEN * (len(runs) - 1)) / len(runs)
        heights = [_height(views, width) if row == "trajectories" else _ROW for row in chosen]
        breaks = [_GAP + (0.26 if row == "trajectories" else 0.0) for row in chosen]
        total = _TOP + sum(heights) + sum(breaks) + 0.17
        figure = new_figure(DOUBLE, total, constrained=False)
        top = total - _TOP
        for row, height, gap in zip(chosen, heights, breaks, strict=True):
            axes: list[Axes] = []
            for column, view in enumerate(views):
                box = (_LEFT + column * (width + _BETWEEN), top - height, width, height)
                place = (box[0] / DOUBLE, box[1] / total, box[2] / DOUBLE, box[3] / total)
                ax = figure.add_axes(place, sharey=axes[0] if axes else None)
                axes.append(ax)
                _DRAW[row](ax, view)
                if row != "trajectories":
                    ax.set_xlim(0.0, shown)
                    ax.tick_params(labelbottom=row == chosen[-1])
                if row == chosen[-1]:
                    ax.set_xlabel("time [s]")
                if column:
                    ax.tick_params(labelleft=False)
                    ax.set_ylabel("")
                if column == 0 and figures and row in figures:
                    ax.set_title(f"thesis {figures[row]}", loc="left", fontsize=7, pad=2.5, color="0.3")
            _legend(axes)
            top -= height + gap
        for column, view in enumerate(views):
            x = (_LEFT + column * (width + _BETWEEN) + width / 2) / DOUBLE
            figure.text(x, 1 - 0.42 / total, law_title(view.run.controller), ha="center", fontsize=9, parse_math=False)
        title = f"{runs[0].scenario}, seed {runs[0].seeds[views[0].place]}"
        figure.text(_LEFT / DOUBLE, 1 - 0.2 / total, title, fontsize=9, parse_math=False)
        return figure


def plot_trajectories(rows: Sequence[Sequence[Run]], seed: int | None = None) -> Figure:
    """Draw where robots drove: a row a scenario, a column a law; robots in true size as in :func:`plot_avoidance`.

    Args:
        rows: The runs on one scenario each, as many laws in each row, in the same order.
        seed: The seed that is drawn, by default the first.

    Raises ReplayError for a seed that was not run, PlotError where a row has several scenarios, or rows differ in
    their laws.
    """
    laws = {tuple(run.controller for run in row) for row in rows}
    if len(laws) != 1 or not all(len({run.scenario for run in row}) == 1 for row in rows):
        raise PlotError("a page of trajectories needs one scenario a row, and the same laws in each row")
    views = [[_view(run, seed_place(run, seed)) for run in row] for row in rows]
    with style():
        width = (DOUBLE - _LEFT) / len(views[0])
        figure = new_figure(DOUBLE, sum(_height(row, width) + 0.35 for row in views) + 0.45)
        grid = figure.subplots(
            len(rows), len(views[0]), squeeze=False, height_ratios=[_height(row, width) for row in views]
        )
        for panels, row in zip(grid, views, strict=True):
            for ax, view in zip(panels, row, strict=True):
                _trajectories(ax, view)
                ax.set(xlabel="", ylabel="")
            run, place = row[0].run, row[0].place
            panels[0].set_ylabel(f"{run.scenario}, seed {run.seeds[place]}\ny [m]", parse_math=False)
        for ax, view in zip(grid[0], views[0], strict=True):
            ax.set_title(law_title(view.run.controller), fontsize=9, parse_math=False)
        for ax in grid[-1]:
            ax.set_xlabel("x [m]")
        handles, names = grid[0, 0].get_legend_handles_labels()
        figure.legend(handles, names, loc="outside lower center", ncol=6)
        return figure


def _view(run: Run, place: int) -> _View:
    return _View(run, place, shown_until(run, place))


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


def _look(robot: int) -> dict[str, Any]:
    return {"color": COLORS[robot % len(COLORS)], "linestyle": LINES[robot % 7]}


def _legend(axes: Sequence[Axes]) -> None:
    """One legend for a row, over its last panel."""
    ax = axes[-1]
    unique: dict[str, Any] = {}
    for each in axes:
        handles, names = each.get_legend_handles_labels()
        unique |= dict(zip(names, handles, strict=True))
    if unique:
        place: dict[str, Any] = {"loc": "lower right", "bbox_to_anchor": (1.0, 0.98), "borderaxespad": 0.1}
        ax.legend(unique.values(), unique.keys(), ncol=6, fontsize=6.5, handlelength=2.0, columnspacing=1.0, **place)


# One panel each ---------------------------------------------------------------------------------------------------


def _trajectories(ax: Axes, view: _View) -> None:
    run, place, end = view
    x, y = (run[name][place, :, :end] for name in ("x", "y"))
    draw_world(ax, run, end - 1)
    draw_bodies(ax, run, place, end - 1)
    nearest = _nearest(view)
    for i, nodes in enumerate(run.paths):
        ax.plot(*strided(*nodes), **TARGET, zorder=1, label=None if i else "path")  # type: ignore[arg-type]
        ax.plot(*strided(x[i], y[i]), **_look(i), linewidth=1.1, label=f"robot {i + 1}" if len(x) <= FEW else None)
        color = COLORS[i % len(COLORS)]
        if nearest is not None and i in nearest[:2]:
            draw_body(ax, run, place, i, np.array([nearest[2]]), facecolors=color, zorder=4)
        if run.diverged[place, i] and (k := last_known(x[i])) >= 0:
            mark_stop(ax, x[i, k], y[i, k], color)
    mark_contacts(ax, run, place, until=float(run.time[end - 1]))
    ax.set_aspect("equal", adjustable="datalim")
    ax.set(xlabel="x [m]", ylabel="y [m]")


def _nearest(view: _View) -> tuple[int, int, int] | None:
    """The two robots that came nearest, and the sample at which they did."""
    gaps = robot_gaps(view.run, view.place)
    least = {pair: np.where(np.isfinite(gap), gap, np.inf)[: view.end] for pair, gap in gaps.items()}
    if not least:
        return None
    i, j = min(least, key=lambda pair: float(least[pair].min()))
    return i, j, int(least[i, j].argmin())


def _per_robot(values: Callable[[_View], np.ndarray], name: str) -> Callable[[Axes, _View], None]:
    def draw(ax: Axes, view: _View) -> None:
        ax.axhline(0.0, **TARGET)  # type: ignore[arg-type]
        rows = values(view)
        if len(rows) > FEW:
            draw_many(ax, view.run.time[: view.end], rows[:, : view.end])
            ax.set_ylabel(name)
            return
        for i, row in enumerate(rows):
            draw_line(ax, view.run.time[: view.end], row[: view.end], **_look(i), linewidth=0.9)
        ax.set_ylabel(name)

    return draw


def _sonar(ax: Axes, view: _View) -> None:
    run, place, end = view
    time = run.time[:end]
    if run.ranges is not None:
        read = run.ranges[:end, place, 0].astype(float)
        pairs = {"front sonars": (FRONT_LEFT, FRONT_RIGHT), "side sonars": (LEFT, RIGHT)}
        for n, (name, sensors) in enumerate(pairs.items()):
            nearest = read[:, sensors].min(axis=1)
            look = {"color": COLORS[n + 4], "linestyle": "-", "linewidth": 0.8}
            draw_line(ax, time, np.where(np.isfinite(nearest), nearest, np.nan), label=f"robot 1, {name}", **look)
    free = np.minimum(clearances(run, place)[0, :end], 10.0)
    draw_line(ax, time, free, color="black", linestyle="--", linewidth=0.9, label="true clearance")
    ax.set_ylim(0.0, _FAR)
    ax.set_ylabel("obstacle [m]")


_DRAW: dict[str, Callable[[Axes, _View], None]] = {
    "trajectories": _trajectories,
    "distances": lambda ax, view: draw_distances(ax, *view),
    "cross-track": _per_robot(lambda view: cross_track_error(view.run)[view.place], "$y_{err}$ [m]"),
    "heading": _per_robot(lambda view: tracking_error(view.run).heading[view.place], "$ψ_{err}$ [rad]"),
    "sonar": _sonar,
    "v": _per_robot(lambda view: view.run["v"][view.place], "v [m/s]"),
    "w": _per_robot(lambda view: view.run["w"][view.place], "ω [rad/s]"),
    "progress": _per_robot(lambda view: view.run["progress"][view.place], "progress s"),
    "modes": lambda ax, view: draw_modes(ax, *view),
}
