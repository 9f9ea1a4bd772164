"""One page about a formation's run: where the robots went, who leads by how much, speeds and wheels.

These are the thesis's Figs 5.16 to 5.19, with the lead and the distances from the paths beside them.
"""

from functools import partial
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from fuzzy.figures.drawing import COLORS, DOUBLE, styled_figure
from robotics.laws.catalogue import CATALOGUE
from robotics.measures.formations import ALIGNED, last_samples, leads, place_error, x_grows
from robotics.measures.tracking import cross_track_error
from robotics.show.figures.drawing import (
    TARGET,
    PlotError,
    cut_to_what_robots_can,
    draw_line,
    draw_title,
    fill_band,
    is_band,
    shown_until,
    top_view_height,
)
from robotics.show.figures.faults import FEW_ROBOTS
from robotics.show.figures.page import TimePlot, draw_page
from robotics.show.figures.robots import draw_path, draw_robots, draw_way, robot_look, seed_order
from robotics.show.figures.world import draw_surroundings, moments
from robotics.simulation.run import Run

_THIN: dict[str, Any] = {"linestyle": "-", "linewidth": 0.4, "alpha": 0.6, "zorder": 1.5}  # of commands
_AFTER = 1.0  # s shown after the last robot came to rest


def plot_formation(run: Run, *, seed: int | None = None, width: float = DOUBLE) -> Figure:
    """Draw a formation: paths, robot 1's lead over the others, distances from path and place, speeds, wheels.

    The lead is that in x where x grows along all paths, else that along robot 1's path; a robot's place is the point of
    its path level with robot 1. Grey lines join the robots of one time, at eight equal times. A thin line beside a
    robot's speed is the command; a law that commands torques has these in place of the wheels' speeds. Speeds are in
    m/s and rad/s, those of the wheels over the ground; leads and distances are in m.

    Args:
        run: A run of a scenario of the kind "formation", or of several robots under a law for formations.
        seed: The seed that is drawn, by default the first; over time 5 seeds and more are bands from the 5th to the
            95th percentile as well.
        width: The width of the figure in inches.

    Raises:
        PlotError: A run of another kind.
        ReplayError: A seed that was not run.
    """
    order = seed_order(run, seed)
    order = order if is_band(order) else order[:1]
    place = order[0]
    if not is_formation(run):
        raise PlotError(
            f'{run.scenario} is no formation but of the kind "{run.about.kind}", and its law none for formations'
        )
    last = shown_until(run, place, _AFTER) - 1
    torque = run.level == "torque"
    right, left = run["command_1"], run["command_2"]
    if not torque:
        turning = np.array([robot.half_axle for robot in run.about.robots])[:, None] * run["w"]
        right, left = run["v"] + turning, run["v"] - turning
    unit = "torque [N m]" if torque else "[m/s]"

    def panel(label: str, values: np.ndarray, command: str = "") -> TimePlot:
        """A channel (runs, robots, samples), thinly with what was commanded in the channel ``command``."""
        robots, time = values.shape[1], run.time[: last + 1]

        def draw(ax: Axes) -> None:
            ax.axhline(0.0, **TARGET)
            if command and not torque:
                for i in range(robots if robots <= FEW_ROBOTS else 0):
                    draw_line(ax, time, run[command][place, i, : last + 1], color=COLORS[i % len(COLORS)], **_THIN)
                cut_to_what_robots_can(ax, run, place, command)
            draw_robots(ax, run, values[..., : last + 1], order, lambda robot, _: _look(robot, robots), band=True)

        return TimePlot(label, draw)

    lead = TimePlot("lead in x [m]" if x_grows(run) else "lead along\nits path [m]",
                 partial(_draw_lead, run=run, order=order, last=last))  # fmt: skip
    rows = [
        (lead,),
        (panel("off its path [m]", cross_track_error(run)), panel("off its place [m]", place_error(run))),
        (panel("v [m/s]", run["v"], "command_1"), panel("ω [rad/s]", run["w"], "command_2")),
        (panel(f"right wheel {unit}", right), panel(f"left wheel {unit}", left)),
    ]
    seen = [np.stack([run[axis][place, :, : last + 1].ravel() for axis in "xy"])]
    top = top_view_height([*run.paths, *seen], 0.9 * width)
    with styled_figure(width, top + 6.2) as figure:
        top_view = partial(_draw_top_view, run=run, place=place, last=last)
        draw_page(figure, rows, (top + 0.4, *(4 * [1.35])), top_view, (0.0, float(run.time[last])))
        draw_title(figure, run, order, banded=True)
        return figure


def is_formation(run: Run) -> bool:
    """Whether a run is that of a formation: by its scenario's kind, or of several robots by its law's."""
    preset = CATALOGUE.get(run.controller.partition(":")[0])
    return run.about.kind == "formation" or (
        run.samples.shape[3] > 1 and preset is not None and preset.kind == "formation"
    )


def _look(robot: int, robots: int) -> dict[str, Any]:
    few = robots <= FEW_ROBOTS
    front: dict[str, Any] = {"alpha": 1.0 if few or robot == 0 else 0.6, "zorder": 2 if few or robot else 3}
    return robot_look(robot, robots, thin=0.6) | front


def _draw_top_view(ax: Axes, run: Run, place: int, last: int) -> None:
    robots, x, y = run.samples.shape[3], run["x"][place], run["y"][place]
    order = np.argsort(y[:, 0], kind="stable")
    at = moments(last)
    ax.plot(x[order][:, at], y[order][:, at], color="0.75", linestyle="-", linewidth=0.8, zorder=1)
    for i in range(robots):
        draw_path(ax, run, i, quiet=robots > FEW_ROBOTS, zorder=1)
        name = f"robot {i + 1}" if robots <= FEW_ROBOTS else "robot 1" if i == 0 else "others" if i == 1 else None
        draw_way(ax, run, place, i, last + 1, **_look(i, robots), label=name)
    draw_surroundings(ax, run, place, last, ("path", "contact"))


def _draw_lead(ax: Axes, run: Run, order: list[int], last: int) -> None:
    """The lead, the band within which robots count as level, and when robot 1 has arrived."""
    ax.axhspan(-ALIGNED, ALIGNED, color="0.9", linewidth=0)
    ax.axhline(0.0, **TARGET)
    rows, time = leads(run)[order, : last + 1], run.time[: last + 1]
    if len(order) > 1:
        fill_band(ax, time, rows, COLORS[0])
    draw_line(ax, time, rows[0], color=COLORS[0], linestyle="-", linewidth=1.2)
    end = int(last_samples(run)[order[0]])
    if end >= 0:
        ax.axvline(run.time[end], color="0.45", linewidth=0.8, linestyle=(0, (1, 1.5)))
        text = "robot 1 at its end "
        ax.text(run.time[end], 0.9, text, transform=ax.get_xaxis_transform(), ha="right", va="top", fontsize=6.5)
        low, high = ax.get_ylim()
        ax.set_ylim(low, high + 0.25 * (high - low))  # above the curve there is room for the words
