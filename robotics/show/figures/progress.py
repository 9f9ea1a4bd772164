"""The progress of a team over time, and its differences: the thesis's Figs 4.7, 4.11, 4.15, 4.17."""

from functools import partial

import numpy as np
from matplotlib.figure import Figure

from fuzzy.figures.drawing import DOUBLE, styled_figure
from robotics.show.figures.drawing import ABOVE, PlotError, draw_legend, page_title
from robotics.show.figures.faults import FEW_ROBOTS, shade_panels
from robotics.show.figures.page import TimePlot, draw_page
from robotics.show.figures.team import differences_panel, draw_team_channel
from robotics.simulation.run import Run
from robotics.simulation.spans import fault_spans, seed_place


def plot_progress(run: Run, *, seed: int | None = None) -> Figure:
    """Draw the progress s [1] that the robots of a team tell each other over time [s], and how far they are apart.

    Up to four robots have a line for every difference s_i − s_j; of more, each is compared with the team's median.
    The times in which a robot is at fault are hatched, with its number and its fault.

    Args:
        run: A run of a team whose law coordinates progress.
        seed: The seed that is drawn, by default the first.

    Raises:
        PlotError: A run without progress.
        ReplayError: A seed that was not run.
    """
    place = seed_place(run, seed)
    if run.team is None or not np.isfinite(run["progress"]).any():
        raise PlotError(f"the run of {run.controller!r} on {run.scenario!r} has no progress: its law coordinates none")
    span = float(run.time[0]), float(run.time[-1])
    draw = partial(draw_team_channel, run=run, values=run["progress"], order=[place], named=True)
    rows = [(TimePlot("progress s [1]", draw),), (differences_panel(run, run["progress"], [place], " [1]"),)]
    with styled_figure(DOUBLE, 4.2) as figure:
        axes = draw_page(figure, rows, span=span)
        figure.suptitle(page_title(run, [place]), parse_math=False, fontsize=9)
        draw_legend(axes[0], **ABOVE)
        faults = fault_spans(run, place)
        shade_panels(figure, axes, faults, span, axes[0] if len(faults) <= FEW_ROBOTS else None)
        return figure
