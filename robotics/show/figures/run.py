"""One page about one run: where the robots went, how far off they were, how fast, and what was commanded."""

from functools import partial
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from fuzzy.figures.drawing import DOUBLE, styled_figure
from robotics.measures.standing import last_move
from robotics.measures.tracking import cross_track_error, tracking_error
from robotics.show.figures.drawing import TARGET, cut_to_what_robots_can, draw_title, top_view_height, unjumped
from robotics.show.figures.page import TimePlot, draw_page
from robotics.show.figures.robots import START, draw_path, draw_robots, draw_way, robot_look, seed_order
from robotics.show.figures.team import plot_team
from robotics.show.figures.world import draw_surroundings
from robotics.simulation.run import Run


def plot_run(run: Run, *, seed: int | None = None, width: float = DOUBLE) -> Figure:
    """Draw the page of ``robotics run --plot``: path, errors, speeds, commands.

    One seed, by default the first, is drawn boldly, up to 39 more faintly behind it; each robot has its colour. A cross
    marks where a robot was stopped; a cross in a ring where in that seed one touched another, or an obstacle. Among
    obstacles robots are drawn in true size too. A team has a page of its own:
    :func:`robotics.show.figures.team.plot_team`.

    Args:
        run: The run.
        seed: The seed that is drawn boldly, by default the first.
        width: The width of the figure in inches.

    Raises:
        ReplayError: A seed that was not run.
    """
    if run.team is not None:
        return plot_team(run, seed, width)
    order = seed_order(run, seed)
    error, torque = tracking_error(run), run.level == "torque"

    def panel(label: str, values: np.ndarray, target: np.ndarray | None = None, command: str = "") -> TimePlot:
        """A channel (runs, robots, samples), the reference if there is one, and the ``command`` at which it is cut."""

        def draw(ax: Axes) -> None:
            draw_robots(ax, run, values, order, partial(_look, values.shape[1]), target)
            if target is None:
                ax.axhline(0.0, **TARGET)
            ax.margins(x=0)
            if command:
                cut_to_what_robots_can(ax, run, order[0], command)

        return TimePlot(label, draw)

    right, left = ("right wheel [N m]", "left wheel [N m]") if torque else ("commanded v [m/s]", "commanded ω [rad/s]")
    rows = [
        (panel("x error [m]", error.x), panel("v [m/s]", run["v"], run.target("v"))),
        (panel("y error [m]", error.y), panel("ω [rad/s]", run["w"], run.target("w"))),
        (panel("heading error [rad]", unjumped(error.heading)), panel(right, run["command_1"], command="command_1")),
        (panel("cross-track error [m]", cross_track_error(run)), panel(left, run["command_2"], command="command_2")),
    ]
    seen = [np.stack([run[axis][r].ravel() for axis in "xy"]) for r in order]
    top = top_view_height([*run.paths, *seen], 0.9 * width)
    with styled_figure(width, top + 6.2) as figure:
        draw_page(figure, rows, (top + 0.4, *(4 * [1.35])), partial(_draw_top_view, run=run, order=order))
        draw_title(figure, run, order)
        return figure


def _draw_top_view(ax: Axes, run: Run, order: list[int]) -> None:
    first, robots = order[0], len(run.paths)
    for i in range(robots):
        for r in reversed(order):
            name = None if r != first else f"robot {i + 1}" if robots > 1 else "robot"
            draw_way(ax, run, r, i, **_look(robots, i, r == first), label=name)
        draw_path(ax, run, i, name="reference")
        start = (run[axis][first, i, :1] for axis in "xy")
        ax.plot(*start, **START, zorder=5, label=None if i else "start")
    draw_surroundings(ax, run, first, last_move(run, first), ("reference", "start"), run.obstacles is not None)


def _look(robots: int, robot: int, bold: bool) -> dict[str, Any]:
    return robot_look(robot, robots, bold, thin=1.0 if bold else 0.5)
