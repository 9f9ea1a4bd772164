"""What robots were about over time: tracking, avoiding, following a wall, yielding, left behind."""

from functools import partial

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.figure import Figure

from fuzzy.figures.drawing import DOUBLE, styled_figure
from robotics.laws.modes import LEFT_BEHIND, MODES, STOPPED
from robotics.show.figures.drawing import (
    ABOVE,
    MODE_COLORS,
    MODE_LINES,
    PlotError,
    draw_common_legend,
    page_title,
    shown_until,
)
from robotics.show.figures.page import TimePlot, draw_page
from robotics.simulation.run import Run
from robotics.simulation.spans import seed_place


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
