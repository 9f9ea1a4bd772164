"""Where robots came nearest to each other, magnified: the details of the thesis's Figs 6.10 and 6.15."""

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Circle

from fuzzy.figures.drawing import DOUBLE, line_look, styled_figure
from robotics.measures.clearance import robot_gaps
from robotics.show.figures.drawing import TARGET, PlotError, draw_obstacles, legend_entries, page_title
from robotics.show.figures.world import draw_body
from robotics.simulation.run import Run
from robotics.simulation.spans import seed_place
from robotics.world.environment.world import outlines

NEAR = 1.0  # m between centers: robots that come no nearer do not meet
MEETINGS_DRAWN = 3  # meetings drawn
SPAN = 3.0  # s drawn before and after the moment at which two robots came nearest
_EVERY = 1.0  # s between the moments at which robots are drawn
_ROOM = 0.45  # m shown at least around the two, when they came nearest
_FAINT = 0.6  # opacity of the robots before and after that moment


def plot_meetings(run: Run, seed: int | None = None) -> Figure:
    """Draw up to three meetings of two robots, a panel each: those pairs that came nearest, in the order of time.

    A panel shows the way of all robots near that place from 3 s before the moment at which the two came nearest until
    3 s after it, and their true rectangles every second, filled at that moment itself. A dashed circle has the
    distance of the centers as its diameter. Pairs that stay more than 1 m apart have no panel, unless all do: then the
    pair that came nearest has one.

    Args:
        run: A run of two or more robots.
        seed: The seed that is drawn, by default the first.

    Raises:
        ReplayError: A seed that was not run.
        PlotError: A run of one robot.
    """
    place = seed_place(run, seed)
    met = _meetings(run, place)
    with styled_figure(DOUBLE * max(len(met), 2) / MEETINGS_DRAWN, 3.1) as figure:
        panels = figure.subplots(1, len(met), squeeze=False)[0]
        for ax, (pair, sample, distance) in zip(panels, met, strict=True):
            _draw(ax, run, place, pair, sample, distance)
        panels[0].set_ylabel("y [m]")
        names = dict(sorted(legend_entries(*panels).items()))
        figure.legend(names.values(), names.keys(), loc="outside lower center", ncol=6)
        figure.suptitle(page_title(run, [place]), parse_math=False, fontsize=9)
        return figure


def nearest_pairs(run: Run, place: int, end: int | None = None) -> list[tuple[tuple[int, int], int, float]]:
    """The pairs of robots, from 0, with the sample at which they came nearest, and their distance [m] then.

    The pair that came nearest is the first; only the first ``end`` samples of the seed at ``place`` count.
    """
    gaps = {pair: np.where(np.isfinite(gap), gap, np.inf)[:end] for pair, gap in robot_gaps(run, place).items()}
    found = [(pair, int(gap.argmin()), float(gap.min())) for pair, gap in gaps.items()]
    return sorted(found, key=lambda met: met[2])


def _meetings(run: Run, place: int) -> list[tuple[tuple[int, int], int, float]]:
    """The meetings that are drawn, in the order of time."""
    found = nearest_pairs(run, place)
    if not found:
        raise PlotError("a run of one robot has no meetings")
    return sorted([met for met in found[:MEETINGS_DRAWN] if met[2] < NEAR] or found[:1], key=lambda met: met[1])


def _draw(ax: Axes, run: Run, place: int, pair: tuple[int, int], sample: int, distance: float) -> None:
    x, y = run["x"][place], run["y"][place]
    period = float(run.time[1] - run.time[0])
    half, step = round(SPAN / period), max(1, round(_EVERY / period))
    first, last = max(sample - half, 0), min(sample + half, len(run.time) - 1)
    seen = np.arange(sample - half // step * step, last + 1, step)
    seen = seen[seen >= first]
    middle = np.array([x[list(pair), sample].mean(), y[list(pair), sample].mean()])
    room = max(_ROOM, 0.75 * distance + 0.2)
    if run.obstacles is not None:
        moved = 0 if len(run.obstacles.counts) == 1 else sample
        draw_obstacles(ax, outlines(run.obstacles, moved))
    for i in range(len(x)):
        look = line_look(i)
        inside = (np.abs(x[i, seen] - middle[0]) < 1.3 * room) & (np.abs(y[i, seen] - middle[1]) < 1.3 * room)
        if i not in pair and not inside.any():
            continue
        ax.plot(*run.paths[i], **TARGET, zorder=1)
        ax.plot(x[i, first : last + 1], y[i, first : last + 1], **look, linewidth=1.1, label=f"robot {i + 1}")
        draw_body(ax, run, place, i, seen[inside & (seen != sample)], facecolors="none", zorder=2, alpha=_FAINT)
        draw_body(ax, run, place, i, np.array([sample]), facecolors=look["color"], alpha=0.55, zorder=3)
    ax.add_patch(Circle((middle[0], middle[1]), distance / 2, fill=False, linestyle="--", linewidth=0.7, zorder=4))
    (left, right), (low, high) = ((at - room, at + room) for at in middle)
    ax.set(xlim=(left, right), ylim=(low, high), aspect="equal", xlabel="x [m]")
    i, j = pair
    ax.set_title(f"robots {i + 1} and {j + 1}: {distance:.2f} m at {run.time[sample]:.1f} s", fontsize=7)
