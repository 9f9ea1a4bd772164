"""One page about a formation's run: where the robots went, who leads by how much, speeds and wheels.

These are the thesis's Figs 5.16 to 5.19, with the lead and the distances from the paths beside them.
"""

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from fuzzy.figures.drawing import COLORS, DOUBLE, LINES, new_figure, style
from robotics.figures.drawing import (
    TARGET,
    PlotError,
    cut_to_what_robots_can,
    draw_legend,
    draw_line,
    draw_title,
    draw_top_view,
    last_known,
    mark_contacts,
    mark_stop,
    shown_until,
    strided,
    top_view_height,
)
from robotics.figures.faults import FEW
from robotics.figures.world import draw_bodies, draw_world, moments
from robotics.laws.catalogue import CATALOGUE
from robotics.measures.formations import ALIGNED, last_samples, leads, place_error, x_grows
from robotics.measures.tracking import cross_track_error
from robotics.simulation.run import Run
from robotics.simulation.spans import seed_place

_AFTER = 1.0  # s shown after the last robot came to rest


def plot_formation(run: Run, *, seed: int | None = None, width: float = DOUBLE) -> Figure:
    """Draw a formation: paths, robot 1's lead over the others, distances from path and place, speeds, wheels.

    The lead is that in x where x grows along all paths, else that along robot 1's path; a robot's place is the point of
    its path level with robot 1. Grey lines join the robots of one time, at eight equal times. A thin line beside a
    robot's speed is the command; a law that commands torques has these in place of the wheels' speeds. Speeds are in
    m/s and rad/s, those of the wheels over the ground; leads and distances are in m.

    Args:
        run: A run of a scenario of the kind "formation", or of several robots under a law for formations.
        seed: The seed that is drawn, by default the first.
        width: The width of the figure in inches.

    Raises:
        PlotError: A run of another kind.
        ReplayError: A seed that was not run.
    """
    place = seed_place(run, seed)
    if not is_formation(run):
        raise PlotError(
            f'{run.scenario} is no formation but of the kind "{run.about.kind}", and its law none for formations'
        )
    last = shown_until(run, place, _AFTER) - 1
    torque = run.level == "torque"
    command = None if torque else (run["command_1"][place], run["command_2"][place])
    wheels = run["command_1"][place], run["command_2"][place]
    if not torque:
        half = np.array([robot.half_axle for robot in run.about.robots])[:, None]
        v, w = run["v"][place], run["w"][place]
        wheels = v + half * w, v - half * w
    unit = "torque [N m]" if torque else "[m/s]"
    panels: list[tuple[str, np.ndarray, np.ndarray | None]] = [
        ("off its path [m]", cross_track_error(run)[place], None),
        ("off its place [m]", place_error(run)[place], None),
        ("v [m/s]", run["v"][place], None if command is None else command[0]),
        ("ω [rad/s]", run["w"][place], None if command is None else command[1]),
        (f"right wheel {unit}", wheels[0], None),
        (f"left wheel {unit}", wheels[1], None),
    ]
    with style():
        seen = [np.stack([run[axis][place, :, : last + 1].ravel() for axis in "xy"])]
        top = top_view_height([*run.paths, *seen], 0.9 * width)
        figure = new_figure(width, top + 6.2)
        grid = figure.add_gridspec(5, 2, height_ratios=(top + 0.4, *(4 * [1.35])))
        _draw_top_view(figure.add_subplot(grid[0, :]), run, place, last)
        lead = figure.add_subplot(grid[1, :])
        _draw_lead(lead, run, place, last)
        for k, (label, values, commanded) in enumerate(panels):
            ax = figure.add_subplot(grid[2 + k // 2, k % 2], sharex=lead)
            _draw_channel(ax, run, place, values[:, : last + 1], commanded)
            if commanded is not None:
                cut_to_what_robots_can(ax, run, place, "command_1" if label.startswith("v ") else "command_2")
            ax.set_ylabel(label)
            if k < len(panels) - 2:
                ax.tick_params(labelbottom=False)
            else:
                ax.set_xlabel("time [s]")
        lead.tick_params(labelbottom=False)
        lead.set_xlim(0.0, run.time[last])
        figure.align_ylabels()
        draw_title(figure, run, [place])
        return figure


def is_formation(run: Run) -> bool:
    """Whether a run is that of a formation: by its scenario's kind, or of several robots by its law's."""
    preset = CATALOGUE.get(run.controller.partition(":")[0])
    return run.about.kind == "formation" or (
        run.samples.shape[3] > 1 and preset is not None and preset.kind == "formation"
    )


def _look(robot: int, robots: int) -> dict[str, Any]:
    few = robots <= FEW
    return {
        "color": COLORS[robot % len(COLORS)],
        "linestyle": LINES[robot % 7] if few else "-",
        "linewidth": 1.0 + 0.5 * (robots - 1 - robot) if few else 0.6,  # lines below others are wider
        "alpha": 1.0 if few or robot == 0 else 0.6,
        "zorder": 2 if few or robot else 3,
    }


def _draw_top_view(ax: Axes, run: Run, place: int, last: int) -> None:
    robots, x, y = run.samples.shape[3], run["x"][place], run["y"][place]
    draw_world(ax, run, last)
    order = np.argsort(y[:, 0], kind="stable")
    at = moments(last)
    ax.plot(x[order][:, at], y[order][:, at], color="0.75", linestyle="-", linewidth=0.8, zorder=1)
    for i, nodes in enumerate(run.paths):
        quiet = TARGET if robots <= FEW else TARGET | {"linewidth": 0.5, "alpha": 0.6}
        ax.plot(*strided(*nodes), **quiet, zorder=1, label=None if i else "path")  # type: ignore[arg-type]
        name = f"robot {i + 1}" if robots <= FEW else "robot 1" if i == 0 else "others" if i == 1 else None
        ax.plot(*strided(x[i, : last + 1], y[i, : last + 1]), **_look(i, robots), label=name)
        if run.diverged[place, i] and (k := last_known(x[i])) >= 0:
            mark_stop(ax, x[i, k], y[i, k], COLORS[i % len(COLORS)])
    draw_bodies(ax, run, place, last)
    mark_contacts(ax, run, place)
    draw_top_view(ax)
    draw_legend(ax, ("path", "contact"))


def _draw_lead(ax: Axes, run: Run, place: int, last: int) -> None:
    """The lead, the band within which robots count as level, and when robot 1 has arrived."""
    ax.axhspan(-ALIGNED, ALIGNED, color="0.9", linewidth=0)
    ax.axhline(0.0, **TARGET)  # type: ignore[arg-type]
    draw_line(ax, run.time[: last + 1], leads(run)[place, : last + 1], color=COLORS[0], linestyle="-", linewidth=1.2)
    end = int(last_samples(run)[place])
    if end >= 0:
        ax.axvline(run.time[end], color="0.45", linewidth=0.8, linestyle=(0, (1, 1.5)))
        text = "robot 1 at its end "
        ax.text(run.time[end], 0.9, text, transform=ax.get_xaxis_transform(), ha="right", va="top", fontsize=6.5)
        low, high = ax.get_ylim()
        ax.set_ylim(low, high + 0.25 * (high - low))  # above the curve there is room for the words
    ax.set_ylabel("lead in x [m]" if x_grows(run) else "lead along\nits path [m]")


def _draw_channel(ax: Axes, run: Run, place: int, values: np.ndarray, commanded: np.ndarray | None) -> None:
    robots, time = len(values), run.time[: values.shape[1]]
    ax.axhline(0.0, **TARGET)  # type: ignore[arg-type]
    for i in range(robots):
        if commanded is not None and robots <= FEW:
            thin = {"color": COLORS[i % len(COLORS)], "linestyle": "-", "linewidth": 0.4, "alpha": 0.6, "zorder": 1.5}
            draw_line(ax, time, commanded[i, : len(time)], **thin)
        draw_line(ax, time, values[i], **_look(i, robots))
        if run.diverged[place, i] and (k := last_known(values[i])) >= 0:
            mark_stop(ax, time[k], values[i, k], COLORS[i % len(COLORS)])
