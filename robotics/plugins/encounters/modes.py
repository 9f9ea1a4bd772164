"""What robots were about over time: tracking, avoiding, following a wall, yielding, left behind; and what they saw.

The panels of what range sensors read are those of the thesis's Figs 6.30 to 6.42.
"""

from functools import partial

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.figure import Figure

from fuzzy.figures.drawing import COLORS, DOUBLE, LINES, styled_figure
from robotics.laws.modes import LEFT_BEHIND, MODES, STOPPED
from robotics.measures.clearance import clearances
from robotics.show.figures.drawing import (
    ABOVE,
    MODE_COLORS,
    MODE_LINES,
    PlotError,
    draw_common_legend,
    draw_line,
    page_title,
    shown_until,
)
from robotics.show.figures.page import TimePlot, draw_page
from robotics.simulation.run import Run
from robotics.simulation.spans import seed_place
from robotics.world.sensing.carried import sensor_names

_MOST_PANELS = 6  # robots that get a panel each


def plot_modes(run: Run, *, seed: int | None = None) -> Figure:
    """Draw each robot's mode over time [s], a row for each robot; ticks are changes of mode.

    Args:
        run: A run whose law has modes.
        seed: The seed that is drawn, by default the first.

    Raises:
        PlotError: A run whose law has no modes.
        ReplayError: A seed that was not run.
    """
    place = seed_place(run, seed)
    if run.modes is None:
        raise PlotError(f"the run of {run.controller!r} on {run.scenario!r} has no modes: its law knows none")
    end = shown_until(run, place)
    with styled_figure(DOUBLE, 1.0 + 0.24 * max(run.modes.shape[2], 3)) as figure:
        panel = TimePlot("robot", partial(draw_modes, run=run, place=place, end=end))
        (ax,) = draw_page(figure, [(panel,)], span=(0.0, float(run.time[end - 1])))
        draw_common_legend(ax, [ax], ncol=6, **ABOVE)
        figure.suptitle(page_title(run, [place]), parse_math=False, fontsize=9)
        return figure


def draw_modes(ax: Axes, run: Run, place: int, end: int) -> None:
    """Draw the panel of modes over the first ``end`` samples of the seed at ``place``; without modes all track."""
    robots = run.samples.shape[3]
    codes = np.zeros((end, robots), dtype=int) if run.modes is None else run.modes[:end, place].astype(int)
    for i in range(robots):
        code = codes[:, i]
        for mode, (color, line) in enumerate(zip(MODE_COLORS, MODE_LINES, strict=True)):
            row = np.where((code & 3 == mode) & (code < STOPPED), float(i + 1), np.nan)
            width = 4.0 if mode else 1.0
            name = MODES[mode] if np.isfinite(row).any() else None
            ax.plot(run.time[:end], row, color=color, linestyle=line, linewidth=width, label=name)
        alone = np.where((code & LEFT_BEHIND > 0) & (code < STOPPED), i + 1.3, np.nan)
        name = "left behind" if np.isfinite(alone).any() else None
        ax.plot(run.time[:end], alone, color="black", linestyle="-", linewidth=1.2, label=name)
        ticks = [[(run.time[k + 1], i + 0.7), (run.time[k + 1], i + 1.3)] for k in np.flatnonzero(np.diff(code))]
        ax.add_collection(LineCollection(ticks, colors="0.3", linewidths=0.5, linestyles="-"))
    ax.set_yticks(range(1, robots + 1))
    ax.set_ylim(robots + 0.6, 0.4)


def plot_sonar(run: Run, *, seed: int | None = None, robot: int | None = None) -> Figure:
    """Draw what each range sensor read [m] over time [s], a panel for each robot; a gap is no echo.

    A dashed black line is the true distance of the robot's rectangle from the nearest obstacle.

    Args:
        run: A run whose law used range sensors.
        seed: The seed that is drawn, by default the first.
        robot: One robot, from 1; by default the first six that carry sensors.

    Raises:
        PlotError: A run that kept no readings, and a robot that it does not have or that carries no sensors.
        ReplayError: A seed that was not run.
    """
    place = seed_place(run, seed)
    if run.ranges is None:
        raise PlotError(
            f"the run of {run.controller!r} on {run.scenario!r} kept no readings of range sensors: its law uses none"
        )
    carriers = [i for i, sensors in enumerate(run.about.sensors) if sensors]
    if robot is not None and robot - 1 not in carriers:
        known = ", ".join(str(i + 1) for i in carriers)
        raise PlotError(f"robot {robot} carries no range sensors; those that do are {known or 'none'}")
    shown = carriers[:_MOST_PANELS] if robot is None else [robot - 1]
    end = shown_until(run, place)
    of = {i: f"robot {i + 1}\n" if len(run.paths) > 1 else "" for i in shown}
    draw = partial(_draw_ranges, run=run, place=place, end=end)
    rows = [(TimePlot(f"{of[i]}range [m]", partial(draw, robot=i)),) for i in shown]
    with styled_figure(DOUBLE, 0.9 + (1.9 if len(shown) == 1 else 1.15 * len(shown))) as figure:
        axes = draw_page(figure, rows, span=(0.0, float(run.time[end - 1])))
        draw_common_legend(figure, axes, loc="outside lower center", ncol=5)
        figure.suptitle(page_title(run, [place]), parse_math=False, fontsize=9)
        return figure


def _draw_ranges(ax: Axes, run: Run, place: int, robot: int, end: int) -> None:
    assert run.ranges is not None
    names, carried, time = sensor_names(run.about.sensors), run.about.sensors[robot], run.time[:end]
    for name, _ in carried.items():
        n = names.index(name)
        read = run.ranges[:end, place, robot, n].astype(float)
        look = {"color": COLORS[n % len(COLORS)], "linestyle": LINES[n // len(COLORS)], "linewidth": 0.9}
        draw_line(ax, time, np.where(np.isfinite(read), read, np.nan), label=name.replace("_", " "), **look)
    if not np.isfinite(run.ranges[:end, place, robot]).any():
        ax.text(0.5, 0.5, "no echo", transform=ax.transAxes, ha="center", color="0.4", fontsize=7)
    if run.obstacles is not None:
        free = clearances(run, place)[robot, :end]
        draw_line(ax, time, free, color="black", linestyle="--", linewidth=0.9, label="true clearance of obstacles")
    ax.set_ylim(0.0, 1.05 * max(sensor.range for sensor in carried.values()))
