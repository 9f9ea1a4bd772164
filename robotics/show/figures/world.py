"""The world in a top view: obstacles where they are, robots in their true size, at equal times until all stand."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import PolyCollection

from fuzzy.figures.drawing import COLORS
from robotics.show.figures.drawing import (
    draw_legend,
    draw_obstacles,
    draw_patches,
    draw_top_view,
    mark_contacts,
    rectangles,
)
from robotics.simulation.run import Run
from robotics.world.environment.world import outlines

_MOMENTS = 8  # number of samples at which robots, and obstacles that move, are drawn


def draw_world(ax: Axes, run: Run, last: int) -> None:
    """Draw the patches and obstacles of ``run``; those that move are drawn at _MOMENTS samples up to ``last``."""
    draw_patches(ax, run.about.patches)
    if run.obstacles is None:
        return
    if len(run.obstacles.counts) == 1:
        draw_obstacles(ax, outlines(run.obstacles, 0))
        return
    for k in moments(last):
        draw_obstacles(ax, outlines(run.obstacles, int(k)), alpha=0.4)


def draw_bodies(ax: Axes, run: Run, place: int, last: int) -> None:
    """Draw the robots in their true size and their colours, at _MOMENTS samples.

    Args:
        ax: The axes of a top view.
        run: The run.
        place: The place of the seed in the run.
        last: The last sample that is drawn.
    """
    seen = moments(last)
    for i in range(run.samples.shape[3]):
        draw_body(ax, run, place, i, seen[np.isfinite(run["x"][place, i, seen])], facecolors="white", zorder=3)


def draw_surroundings(ax: Axes, run: Run, place: int, last: int, names: Sequence[str], bodies: bool = True) -> None:
    """End a top view of robots' ways with what is around them: obstacles, robots in true size, contacts, a legend.

    Args:
        ax: The axes.
        run: The run.
        place: The place of the seed in the run.
        last: The last sample that is drawn.
        names: The names that come last in the legend, as of :func:`robotics.show.figures.drawing.draw_legend`.
        bodies: Whether robots are drawn in true size.
    """
    draw_world(ax, run, last)
    if bodies:
        draw_bodies(ax, run, place, last)
    mark_contacts(ax, run, place)
    draw_top_view(ax)
    draw_legend(ax, names)


def draw_body(ax: Axes, run: Run, place: int, robot: int, samples: np.ndarray, **style: Any) -> None:
    """Draw one robot in its true size at some samples.

    Args:
        ax: The axes of a top view.
        run: The run.
        place: The place of the seed in the run.
        robot: The robot, from 0.
        samples: The samples (n,) at which it is drawn.
        style: Options of the collection that is drawn.
    """
    x, y, heading = (run[name][place, robot, samples] for name in ("x", "y", "heading"))
    body = run.about.robots[robot]
    look: dict[str, Any] = {"edgecolors": COLORS[robot % len(COLORS)], "linewidths": 0.6} | style
    ax.add_collection(PolyCollection(list(rectangles(x, y, heading, body.length, body.width)), **look))


def moments(last: int) -> np.ndarray:
    """The samples at which moving bodies are drawn: _MOMENTS of them, evenly up to ``last``."""
    return np.linspace(0, last, _MOMENTS).round().astype(int)
