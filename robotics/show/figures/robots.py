"""Robots in pictures of runs: the look of their lines, over time and in a top view, and where they were stopped."""

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes

from fuzzy.figures.drawing import line_look
from robotics.show.figures.drawing import TARGET, draw_line, fill_band, is_band, last_known, strided
from robotics.show.figures.faults import FEW_ROBOTS
from robotics.simulation.run import Run
from robotics.simulation.spans import seed_place

FAINT = 0.25  # opacity of the seeds beside the one that is drawn boldly
START: dict[str, Any] = {"marker": "o", "markerfacecolor": "white", "color": "black", "linestyle": "none"}
_MOST = 40  # seeds drawn on one page
_QUIET: dict[str, Any] = {"linewidth": 0.5, "alpha": 0.6}  # the paths of many robots

RobotLook = Callable[[int, bool], dict[str, Any]]  # of a robot, from 0, of the seed that is drawn boldly or another


def seed_order(run: Run, seed: int | None) -> list[int]:
    """The places of the seeds that a page draws: first the one that it draws boldly, then at most 39 others.

    Raises ReplayError for a seed that was not run.
    """
    place = seed_place(run, seed)
    return [place, *(r for r in range(len(run.seeds)) if r != place)][:_MOST]


def robot_look(robot: int, robots: int, bold: bool = True, *, step: float = 0.5, thin: float = 0.5) -> dict[str, Any]:
    """The look of a robot's line: of few robots each has its dashes, and those drawn first, below others, are wider.

    Args:
        robot: The robot, from 0.
        robots: The number of robots.
        bold: Whether the line is of the seed that is drawn boldly.
        step: How much wider [points] a line is than the next one.
        thin: The width [points] of lines that are not bold, or of many robots.
    """
    few = robots <= FEW_ROBOTS
    look = line_look(robot) if few else line_look(robot) | {"linestyle": "-"}
    width = 1.0 + step * (robots - 1 - robot) if bold and few else thin
    return look | {"alpha": 1.0 if bold else FAINT, "linewidth": width}


def draw_robots(
    ax: Axes,
    run: Run,
    values: np.ndarray,
    order: Sequence[int],
    look: RobotLook,
    targets: np.ndarray | None = None,
    band: bool = False,
) -> None:
    """Draw a channel over time, a line for each robot and seed, and a cross where a robot was stopped.

    Args:
        ax: The axes.
        run: The run.
        values: The channel (runs, robots, samples), from the run's first sample on.
        order: The places of the seeds that are drawn, the first one boldly and on top.
        look: How each line looks.
        targets: The reference (robots, samples), if there is one.
        band: Whether many seeds are a band with the first one's line, as :func:`is_band` says.
    """
    time = run.time[: values.shape[-1]]
    banded = band and is_band(order)
    for robot in range(values.shape[1]):
        if banded:
            fill_band(ax, time, values[list(order), robot], look(robot, True)["color"])
        for place in order[:1] if banded else reversed(order):
            style, line = look(robot, place == order[0]), values[place, robot]
            draw_line(ax, time, line, **style)
            mark_stop(ax, run, place, robot, time, line, style["color"])
        if targets is not None:
            draw_line(ax, time, targets[robot], **TARGET)


def draw_way(ax: Axes, run: Run, place: int, robot: int, end: int | None = None, **style: Any) -> None:
    """Draw where a robot drove, and a cross where it was stopped, in a top view.

    Args:
        ax: The axes.
        run: The run.
        place: The place of the seed in the run.
        robot: The robot, from 0.
        end: The number of samples that are drawn; by default all.
        style: Options of ``ax.plot``, the colour among them.
    """
    x, y = (run[axis][place, robot, :end] for axis in "xy")
    ax.plot(*strided(x, y), **style)
    mark_stop(ax, run, place, robot, x, y, style["color"])


def draw_path(ax: Axes, run: Run, robot: int, *, name: str = "path", quiet: bool = False, **style: Any) -> None:
    """Draw a robot's path in a top view; the legend names the first robot's.

    Args:
        ax: The axes.
        run: The run.
        robot: The robot, from 0.
        name: What the legend says.
        quiet: Whether the line is thin, as among many.
        style: More options of ``ax.plot``.
    """
    look: dict[str, Any] = TARGET | (_QUIET if quiet else {}) | style
    ax.plot(*strided(*run.paths[robot]), **look, label=None if robot else name)


def mark_stop(ax: Axes, run: Run, place: int, robot: int, along: np.ndarray, values: np.ndarray, color: Any) -> None:
    """Draw a cross at the last point of a robot's line, if the robot was stopped.

    Args:
        ax: The axes.
        run: The run.
        place: The place of the seed in the run.
        robot: The robot, from 0.
        along: The line's points along x (n,), in the axes' unit.
        values: Likewise along y; not-a-number after the stop.
        color: The robot's colour.
    """
    k = last_known(values) if run.diverged[place, robot] else -1
    if k >= 0:
        cross: dict[str, Any] = {"marker": "X", "markersize": 7, "markeredgecolor": "white", "linestyle": "none"}
        ax.plot([along[k]], [values[k]], color=color, zorder=4, **cross)
