"""The progress of a team over time, and its differences: the thesis's Figs 4.7, 4.11, 4.15, 4.17."""

import numpy as np
from matplotlib.figure import Figure

from fuzzy.figures.drawing import DOUBLE, new_figure, style
from robotics.figures.drawing import PlotError, draw_legend, page_title
from robotics.figures.faults import FEW, shade_faults
from robotics.figures.team import draw_differences, draw_team_channel
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
    with style():
        figure = new_figure(DOUBLE, 4.2)
        above, below = figure.subplots(2, 1, sharex=True)
        draw_team_channel(above, run, run["progress"], [place], named=True)
        draw_differences(below, run, run["progress"], [place])
        above.set_ylabel("progress s [1]")
        below.set_ylabel(f"{below.get_ylabel()} [1]")
        below.set_xlabel("time [s]")
        below.set_xlim(run.time[0], run.time[-1])
        figure.suptitle(page_title(run, [place]), parse_math=False, fontsize=9)
        draw_legend(above, loc="lower right", bbox_to_anchor=(1.0, 1.0), borderaxespad=0.1)
        faults, end = fault_spans(run, place), float(run.time[-1])
        figure.draw_without_rendering()  # the names of faults need the widths of the panels
        figure.set_layout_engine("none")
        for ax in (above, below):
            shade_faults(ax, faults, float(run.time[0]), end, named=ax is above and len(faults) <= FEW)
        return figure
