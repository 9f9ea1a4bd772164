"""Distances between robots over time, and from obstacles: the panels d_ij of the thesis's Figs 6.11, 6.16."""

from functools import partial

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from fuzzy.figures.drawing import DOUBLE, line_look, styled_figure
from robotics.laws.catalogue import safety_distance
from robotics.measures.clearance import clearances, robot_gaps
from robotics.show.figures.drawing import ABOVE, TARGET, PlotError, draw_line, draw_many, page_title, shown_until
from robotics.show.figures.page import TimePlot, draw_page
from robotics.simulation.run import Run
from robotics.simulation.spans import seed_place

PAIRS = 4  # robots of which every pair has a line; of more robots each has one, to the nearest other
_FAR = 2.05  # m: what the panels show at least


def plot_distances(run: Run, *, seed: int | None = None) -> Figure:
    """Draw the distances d_ij [m] between the robots' centers over time [s], and those from obstacles if there are any.

    Up to four robots have a line for every pair; of more, each has one: to whichever other is nearest, over a band from
    the 5th to the 95th percentile with the median. A dashed line is what the law keeps; in the grey centers cannot be
    without contact. The distance from obstacles is that of a robot's rectangle.

    Args:
        run: A run of two or more robots, or one among obstacles.
        seed: The seed that is drawn, by default the first.

    Raises:
        PlotError: A run of one robot without obstacles.
        ReplayError: A seed that was not run.
    """
    place = seed_place(run, seed)
    several, obstacles = run.samples.shape[3] > 1, run.obstacles is not None
    if not several and not obstacles:
        raise PlotError(f"{run.scenario}: one robot without obstacles has no distances to draw")
    end = shown_until(run, place)
    draw = {"between centers [m]": draw_distances} if several else {}
    draw |= {"to an obstacle [m]": _draw_clearances} if obstacles else {}
    rows = [(TimePlot(label, partial(each, run=run, place=place, end=end)),) for label, each in draw.items()]
    with styled_figure(DOUBLE, 0.8 + 1.9 * len(rows)) as figure:
        for ax in draw_page(figure, rows, span=(0.0, float(run.time[end - 1]))):
            ax.legend(ncol=7, **ABOVE)
        figure.suptitle(page_title(run, [place]), parse_math=False, fontsize=9)
        return figure


def draw_distances(ax: Axes, run: Run, place: int, end: int) -> None:
    """Draw the panel of distances between centers over the first ``end`` samples of the seed at ``place``."""
    gaps, robots = robot_gaps(run, place), run.samples.shape[3]
    if robots <= PAIRS:
        for n, ((i, j), gap) in enumerate(gaps.items(), start=3):  # other looks than those of robots 1 to 3
            draw_line(ax, run.time[:end], gap[:end], **line_look(n), label=f"$d_{{{i + 1}{j + 1}}}$")
    else:
        nearest = np.full((robots, end), np.inf)
        for (i, j), gap in gaps.items():
            for robot in (i, j):
                nearest[robot] = np.fmin(nearest[robot], gap[:end])
        draw_many(ax, run.time[:end], np.where(np.isfinite(nearest), nearest, np.nan), "to the nearest other, ")
    # Centers nearer than this cannot be without contact, whichever two robots it is and however they stand.
    inner = sorted(min(robot.length, robot.width) / 2 for robot in run.about.robots)
    ax.axhspan(0.0, sum(inner[:2]), color="0.85", linewidth=0)
    kept = safety_distance(run.controller, run.about.robots)
    if kept is not None:
        ax.axhline(kept, **TARGET | {"color": "0.2"}, label="$d_{min}$")
        ax.text(0.99, kept, f" {kept:g} m", transform=ax.get_yaxis_transform(), ha="right", va="bottom", fontsize=6.5)
    ax.set_ylim(0.0, max(_FAR, ax.get_ylim()[1] if ax.get_ylim()[1] < 4 else 4.0))


def _draw_clearances(ax: Axes, run: Run, place: int, end: int) -> None:
    free = clearances(run, place)[:, :end]
    if len(free) > 7:
        draw_many(ax, run.time[:end], free, "to the nearest obstacle, ")
    else:
        for i, row in enumerate(free):
            draw_line(ax, run.time[:end], row, **line_look(i), label=f"robot {i + 1}" if len(free) > 1 else "robot")
    ax.axhline(0.0, **TARGET)
    ax.set_ylim(min(0.0, float(np.nanmin(free))) - 0.05, _FAR)
