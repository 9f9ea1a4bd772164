"""One page about one run: where the robots went, how far off they were, how fast, and what was commanded."""

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from fuzzy.figures.drawing import COLORS, DOUBLE, LINES, new_figure, style
from robotics.figures.drawing import (
    TARGET,
    cut_to_what_robots_can,
    draw_legend,
    draw_line,
    draw_title,
    draw_top_view,
    last_known,
    mark_contacts,
    mark_stop,
    strided,
    top_view_height,
    unjumped,
)
from robotics.figures.faults import FEW
from robotics.figures.team import plot_team
from robotics.figures.world import draw_bodies, draw_world
from robotics.measures.standing import last_move
from robotics.measures.tracking import cross_track_error, tracking_error
from robotics.simulation.run import Run
from robotics.simulation.spans import seed_place

_FAINT = 0.25  # opacity of the seeds after the first
_MOST = 40  # seeds drawn


def plot_run(run: Run, *, seed: int | None = None, width: float = DOUBLE) -> Figure:
    """Draw the page of ``robotics run --plot``: path, errors, speeds, commands.

    One seed, by default the first, is drawn boldly, up to 39 more faintly behind it; each robot has its colour. A cross
    marks where a robot was stopped; a cross in a ring where in that seed one touched another, or an obstacle. Among
    obstacles robots are drawn in true size too. A team has a page of its own: :func:`robotics.figures.team.plot_team`.

    Args:
        run: The run.
        seed: The seed that is drawn boldly, by default the first.
        width: The width of the figure in inches.

    Raises:
        ReplayError: A seed that was not run.
    """
    if run.team is not None:
        return plot_team(run, seed, width)
    place = seed_place(run, seed)
    order = [place, *(r for r in range(len(run.seeds)) if r != place)][:_MOST]
    error, cross = tracking_error(run), cross_track_error(run)
    torque = run.level == "torque"
    panels: list[list[tuple[str, np.ndarray, np.ndarray | None]]] = [
        [("x error [m]", error.x, None), ("v [m/s]", run["v"], run.target("v"))],
        [("y error [m]", error.y, None), ("ω [rad/s]", run["w"], run.target("w"))],
        [
            ("heading error [rad]", unjumped(error.heading), None),
            ("right wheel [N m]" if torque else "commanded v [m/s]", run["command_1"], None),
        ],
        [
            ("cross-track error [m]", cross, None),
            ("left wheel [N m]" if torque else "commanded ω [rad/s]", run["command_2"], None),
        ],
    ]
    with style():
        seen = [np.stack([run[axis][r].ravel() for axis in "xy"]) for r in order]
        top = top_view_height([*run.paths, *seen], 0.9 * width)
        figure = new_figure(width, top + 6.2)
        grid = figure.add_gridspec(5, 2, height_ratios=(top + 0.4, *(4 * [1.35])))
        _draw_top_view(figure.add_subplot(grid[0, :]), run, order)
        first: Axes | None = None
        for row, pair in enumerate(panels, start=1):
            for column, (name, values, target) in enumerate(pair):
                ax = figure.add_subplot(grid[row, column], sharex=first)
                first = first or ax
                _draw_channel(ax, run, values, target, order)
                if not torque and name.startswith("commanded"):
                    cut_to_what_robots_can(ax, run, place, f"command_{row - 2}")
                ax.set_ylabel(name)
                if row == len(panels):
                    ax.set_xlabel("time [s]")
                else:
                    ax.tick_params(labelbottom=False)
        figure.align_ylabels()
        draw_title(figure, run, order)
        return figure


def _color(robot: int) -> str:
    return COLORS[robot % len(COLORS)]


def _look(robot: int, robots: int, bold: bool) -> dict[str, Any]:
    """How the line of a robot looks: of several each has its dashes, and those drawn first are wider."""
    under = 0.5 * (robots - 1 - robot) if bold and 1 < robots <= FEW else 0.0
    return {
        "color": _color(robot),
        "linestyle": LINES[robot % 7] if robots <= FEW else "-",
        "alpha": 1.0 if bold else _FAINT,
        "linewidth": (1.0 if bold else 0.5) + under,
    }


def _draw_top_view(ax: Axes, run: Run, order: list[int]) -> None:
    first = order[0]
    several = len(run.paths) > 1
    if run.obstacles is not None:
        last = last_move(run, first)
        draw_world(ax, run, last)
        draw_bodies(ax, run, first, last)
    for i, nodes in enumerate(run.paths):
        for r in reversed(order):
            x, y = run["x"][r, i], run["y"][r, i]
            ax.plot(
                *strided(x, y),
                **_look(i, len(run.paths), r == first),
                label=None if r != first else f"robot {i + 1}" if several else "robot",
            )
            if run.diverged[r, i] and (k := last_known(x)) >= 0:
                mark_stop(ax, x[k], y[k], _color(i))
        ax.plot(*strided(*nodes), **TARGET, label=None if i else "reference")  # type: ignore[arg-type]
        ax.plot(
            run["x"][first, i, :1],
            run["y"][first, i, :1],
            marker="o",
            markerfacecolor="white",
            color="black",
            linestyle="none",
            zorder=5,
            label=None if i else "start",
        )
    mark_contacts(ax, run, first)
    draw_top_view(ax)
    draw_legend(ax, ("reference", "start"))


def _draw_channel(ax: Axes, run: Run, values: np.ndarray, target: np.ndarray | None, order: list[int]) -> None:
    """One channel (runs, robots, samples) over time, with the reference (robots, samples) if there is one."""
    for i in range(values.shape[1]):
        for r in reversed(order):
            line = values[r, i]
            draw_line(
                ax,
                run.time,
                line,
                **_look(i, values.shape[1], r == order[0]),
            )
            if run.diverged[r, i] and (k := last_known(line)) >= 0:
                mark_stop(ax, run.time[k], line[k], _color(i))
        if target is not None:
            draw_line(ax, run.time, target[i], **TARGET)
    if target is None:
        ax.axhline(0.0, **TARGET)  # type: ignore[arg-type]
    ax.margins(x=0)
