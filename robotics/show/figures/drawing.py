"""Shared parts of the pictures of runs: a look for each controller, thinned lines, seeds as text."""

import textwrap
import warnings
from collections.abc import Callable, Iterable, Mapping, Sequence
from itertools import count
from typing import Any, NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.axis import Axis
from matplotlib.collections import LineCollection, PolyCollection
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Polygon
from matplotlib.ticker import FuncFormatter, NullLocator

from fuzzy.errors import InputError
from fuzzy.figures.drawing import COLORS, LINES, figure_of, number, text_width
from fuzzy.shown import shown, typeset
from robotics.laws.catalogue import law_title
from robotics.measures.contacts import MOST_DRAWN, contacts, first_contact
from robotics.measures.standing import last_move
from robotics.simulation.run import Run
from robotics.world.vehicle.floor import Patch

TARGET: dict[str, Any] = {"color": "0.45", "linestyle": (0, (4, 2)), "linewidth": 1.0}  # how every reference is drawn
# A legend over a panel, at its right edge
ABOVE: dict[str, Any] = {"loc": "lower right", "bbox_to_anchor": (1.0, 1.0), "borderaxespad": 0.1}
POINTS = 1000  # points of a line, at most: as a drawing of vectors it stays small, and keeps every extreme
OBSTACLE: dict[str, Any] = {"facecolor": "0.82", "edgecolor": "0.3", "linewidth": 0.8}
CONTACT: dict[str, Any] = {  # told by its form, whatever the colours
    "marker": r"$\otimes$",
    "color": "black",
    "markersize": 9,
    "markeredgewidth": 0.0,
    "linestyle": "none",
    "zorder": 7,
}
# How the modes of robotics.laws.modes look, by code & 3: colours that no robot of a team of three has, and lines
MODE_COLORS = ("0.7", COLORS[5], COLORS[3], COLORS[4])
MODE_LINES: tuple[Any, ...] = ("-", "-", (0, (4, 1.5)), (0, (1, 1)))
_BANDED = 5  # seeds: so many and more are a band over time
_AFTER = 4.0  # s shown after the last robot came to rest
_MARKERS = "os^DvPX*"
# The place of each preset among the colours; the palest, orange, is left for the controllers that users add.
_PLACES = {"fuzzy": 0, "lyapunov": 1, "csm": 2, "assm": 3, "qssm": 4, "esm": 6}


class PlotError(InputError):
    """A run or a request of which there is nothing to draw. The message says what is missing."""


class Look(NamedTuple):
    """The look of a controller, the same in every figure."""

    color: str
    line: Any  # a matplotlib line style
    marker: str

    @property
    def of_line(self) -> dict[str, Any]:
        """The options of its lines."""
        return {"color": self.color, "linestyle": self.line}


def looks(specifications: Iterable[str]) -> dict[str, Look]:
    """A look for every controller: each of the six presets has its own, others take the remaining ones in turn."""
    wanted = dict.fromkeys(specifications)
    taken = {_PLACES[name] for name in wanted if name in _PLACES}
    free = (n for n in count() if n not in taken)
    return {name: _look(_PLACES[name] if name in _PLACES else next(free)) for name in wanted}


def _look(n: int) -> Look:
    """The n-th look: the style's own pairs of colour and line; then the colours again with other lines, 21 in all."""
    colors = len(COLORS)
    line = LINES[n] if n < colors else LINES[:6][(n + n // colors) % 6]
    return Look(COLORS[n % colors], line, _MARKERS[n % len(_MARKERS)])


def looks_of(specifications: Iterable[str], given: Mapping[str, Look] | None) -> Mapping[str, Look]:
    """The looks that are ``given``, or those of :func:`looks` for the controllers."""
    return looks(specifications) if given is None else given


def only(run: Run, seed: int | None) -> Run:
    """The run of that one seed, by default the first. Raises PlotError for a seed that was not run."""
    seed = run.seeds[0] if seed is None else seed
    if seed not in run.seeds:
        raise PlotError(f"seed {seed} is not among those of the run: {seeds_as_text(run.seeds)}")
    return run.only(seed)


def shown_until(run: Run, place: int, after: float = _AFTER) -> int:
    """The number of samples that pictures of the seed at ``place`` show: until ``after`` [s] its last robot rests."""
    shown = min(run.time[last_move(run, place)] + after, run.time[-1])
    return int(np.searchsorted(run.time, shown + 1e-9))


def seeds_as_text(seeds: Sequence[int]) -> str:
    """The seeds as a short text, such as "0–19, 42"."""
    parts: list[list[int]] = []
    for seed in seeds:
        if parts and seed == parts[-1][-1] + 1:
            parts[-1].append(seed)
        else:
            parts.append([seed])
    return ", ".join(f"{p[0]}–{p[-1]}" if len(p) > 2 else ", ".join(map(str, p)) for p in parts)


def thinned(time: np.ndarray, values: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """A line (n,) over time that looks the same with fewer points: each stretch keeps its least and greatest value."""
    n = len(time)
    if n <= POINTS:
        return time, values
    step = -(-3 * n // (POINTS - 4))  # of each stretch its first, its least and its greatest value
    starts = np.arange(0, n, step)
    padded = np.full(len(starts) * step, np.nan)
    padded[:n] = values
    stretches = padded.reshape(-1, step)
    known = np.isfinite(stretches)
    least = np.where(known, stretches, np.inf).argmin(axis=1)
    greatest = np.where(known, stretches, -np.inf).argmax(axis=1)
    chosen = np.unique(np.concatenate([starts, starts + least, starts + greatest, [n - 1]]))
    return time[chosen], values[chosen]


def strided(x: np.ndarray, y: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """A curve in the plane, ``x`` and ``y`` (n,) each, with fewer points; both ends are kept."""
    step = -(-len(x) // (POINTS - 1))
    if step <= 1:
        return x, y
    chosen = np.append(np.arange(0, len(x) - 1, step), len(x) - 1)
    return x[chosen], y[chosen]


def draw_line(ax: Axes, time: np.ndarray, values: np.ndarray, **style: Any) -> Line2D:
    """Draw one channel over time, thinned.

    Args:
        ax: The axes.
        time: The times (n,) [s].
        values: The channel (n,).
        style: Options of ``ax.plot``.
    """
    return ax.plot(*thinned(time, values), **style)[0]


def unjumped(angle: np.ndarray) -> np.ndarray:
    """Angles (..., samples) [rad] with a gap where they jump between π and −π, which no robot turned through."""
    jump = np.abs(np.diff(angle, axis=-1)) > np.pi
    if not jump.any():
        return angle
    broken = np.array(angle, dtype=float)
    broken[..., 1:][jump] = np.nan
    return broken


def draw_band(ax: Axes, time: np.ndarray, rows: np.ndarray, look: Look) -> None:
    """Draw the median of lines, and the band from the 5th to the 95th percentile where they differ.

    Args:
        ax: The axes.
        time: The times (samples,) [s].
        rows: The lines (n, samples).
        look: The colour of both, and the line style of the median.
    """
    draw_line(ax, time, fill_band(ax, time, rows, look.color), **look.of_line, linewidth=1.0, zorder=2.2)


def fill_band(ax: Axes, time: np.ndarray, rows: np.ndarray, color: str) -> np.ndarray:
    """Fill the band from the 5th to the 95th percentile of lines (n, samples) where they differ; return the median."""
    low, middle, high = _percentiles(rows)
    if not np.allclose(low, high, equal_nan=True, rtol=0.0, atol=1e-12):
        at, edges = _thinned_together(time, np.stack([low, high]))
        ax.fill_between(at, *edges, facecolor=color, alpha=0.3, linewidth=0, zorder=1.8)
    return np.asarray(middle)


def _percentiles(rows: np.ndarray) -> np.ndarray:
    """The 5th, 50th and 95th percentile (3, samples) of the rows that are known."""
    with warnings.catch_warnings(action="ignore", category=RuntimeWarning):  # once all are stopped: not-a-number
        return np.asarray(np.nanpercentile(rows, (5, 50, 95), axis=0))


def _thinned_together(time: np.ndarray, rows: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The rows (n, samples) at the samples that keep the extremes of each."""
    if len(time) <= POINTS:
        return time, rows
    chosen = np.unique(np.concatenate([np.searchsorted(time, thinned(time, row)[0]) for row in rows]))
    return time[chosen], rows[:, chosen]


def cut_axis(ax: Axes, time: np.ndarray, rows: np.ndarray, low: float, high: float) -> None:
    """Show the y axis from ``low`` to ``high``; where a line goes beyond, a mark at the edge says how far.

    Args:
        ax: The axes, with time along x.
        time: The times (samples,) [s].
        rows: The lines (n, samples), in the unit of the axis.
        low: The least value that is shown.
        high: The greatest.
    """
    ax.set_ylim(low, high)
    known = np.isfinite(rows)
    if not known.any():
        return
    for sign, edge, y, va in ((1.0, high, 0.98, "top"), (-1.0, -low, 0.02, "bottom")):
        reached = np.where(known, sign * rows, -np.inf)
        row, k = np.unravel_index(reached.argmax(), reached.shape)
        if reached[row, k] <= edge:
            continue
        left = time[k] <= (time[0] + time[-1]) / 2
        arrow, most = "▲" if sign > 0 else "▼", typeset(shown(float(sign * reached[row, k]), digits=2))
        words, side = (f" {arrow} to {most}", "left") if left else (f"to {most} {arrow} ", "right")
        ax.text(time[k], y, words, transform=ax.get_xaxis_transform(), ha=side, va=va, **on_white(0.3))


def on_white(pad: float) -> dict[str, Any]:
    """The options of small words over lines, with a ground of white as wide as ``pad`` [points] around them."""
    return {"fontsize": 6.5, "zorder": 6, "bbox": {"facecolor": "white", "edgecolor": "none", "alpha": 0.8, "pad": pad}}


def panel_grid(figure: Figure, count: int, columns: int, heights: Sequence[float] | None = None) -> list[Axes]:
    """Panels in rows with one y axis for all, unless rows have ``heights`` of their own; the last row may be short."""
    grid = figure.subplots(
        -(-count // columns), columns, squeeze=False, sharey=heights is None, gridspec_kw={"height_ratios": heights}
    )
    for ax in grid.flat[count:]:
        ax.remove()
    return list(grid.flat[:count])


def scale_values(ax: Axes, known: np.ndarray) -> bool:
    """Make the x axis logarithmic where values > 0 span more than a decade; returns whether it is."""
    logarithmic = bool(known.size > 0 and known.min() > 0 and known.max() > 10 * known.min())
    if logarithmic:
        ax.set_xscale("log")
        ax.set_xticks(few_ticks(known.min(), known.max()))
        ax.minorticks_off()
    else:
        ax.locator_params(axis="x", nbins=4)
    return logarithmic


def write_log_ticks(axis: Axis, ticks: Sequence[float], words: Callable[[float], str] = number) -> None:
    """Give a logarithmic axis these ticks, as plain numbers or other ``words``, and no others."""
    axis.set_ticks(ticks)
    axis.set_major_formatter(FuncFormatter(lambda value, _: words(value)))
    axis.set_minor_locator(NullLocator())


def few_ticks(low: float, high: float) -> list[float]:
    """At most five round numbers from ``low`` to ``high`` > 0, as far apart as they can be on a logarithmic axis."""
    decades = range(int(np.floor(np.log10(low))), int(np.ceil(np.log10(high))) + 1)
    for steps in ((1, 2, 5), (1, 3), (1,)):
        ticks = [t for t in (s * 10.0**d for d in decades for s in steps) if 0.8 * low <= t <= 1.25 * high]
        if len(ticks) <= 4:
            return ticks
    return ticks[:: -(-len(ticks) // 5)]


def room_for(rows: np.ndarray) -> tuple[float, float]:
    """The least and greatest known value of the rows and of 0, with a margin."""
    known = rows[np.isfinite(rows)]
    low, high = known.min(initial=0.0), known.max(initial=0.0)
    room = 0.08 * (high - low) or 1e-6
    return float(low - room), float(high + room)


def draw_many(ax: Axes, time: np.ndarray, rows: np.ndarray, of: str = "") -> None:
    """Draw thin lines, the band in which most of them are, and their median.

    Args:
        ax: The axes.
        time: The times (samples,) [s].
        rows: The lines (robots, samples).
        of: What they are, before the words of the legend.
    """
    for i, row in enumerate(rows):
        faint = max(0.15, min(0.5, 20 / len(rows)))
        draw_line(ax, time, row, color=COLORS[i % len(COLORS)], linestyle="-", linewidth=0.3, alpha=faint, zorder=1.5)
    low, middle, high = _percentiles(rows)
    at, edges = _thinned_together(time, np.stack([low, high]))
    ax.fill_between(at, *edges, color="0.35", alpha=0.3, linewidth=0, zorder=2, label=f"{of}5–95 % of the robots")
    for edge in (low, high):
        draw_line(ax, time, edge, color="black", linestyle="-", linewidth=0.4, alpha=0.6, zorder=2.5)
    draw_line(ax, time, middle, color="black", linestyle="-", linewidth=1.0, zorder=3, label=f"{of}median")


def draw_top_view(ax: Axes) -> None:
    """End a top view: both axes in metres, to one scale, without empty space beside what is drawn."""
    ax.autoscale_view()
    (left, right), (low, high) = ax.get_xlim(), ax.get_ylim()
    flat = (high - low) < 0.25 * (right - left)  # as a box it would be a slit
    ax.set_aspect("equal", adjustable="datalim" if flat else "box")
    ax.set(xlabel="x [m]", ylabel="y [m]")


def top_view_height(paths: Iterable[np.ndarray], width: float) -> float:
    """The height of a top view in inches: the proportions of the paths (2, nodes) each, within what a page has.

    Args:
        paths: What is seen from above, each (2, nodes) [m].
        width: The width in inches that it has.
    """
    points = np.concatenate(list(paths), axis=1)
    across, up = np.nanmax(points, axis=1) - np.nanmin(points, axis=1)
    return float(np.clip(width * (up + 0.1 * across) / max(across, 1e-9), 0.25 * width, min(4.0, 0.8 * width)))


def cut_to_what_robots_can(ax: Axes, run: Run, place: int, channel: str) -> None:
    """Cut the axis of commands of the seed at ``place`` where one asks for more than twice what its robot can do.

    ``channel`` is command_1, v [m/s], or command_2, ω [rad/s]; that of torques is left as it is.
    """
    if run.level == "torque":
        return
    most = 2.0 * max(robot.v_max if channel == "command_1" else robot.w_max for robot in run.about.robots)
    rows = run[channel][place]
    if np.nanmax(np.abs(rows), initial=0.0) > most:
        cut_axis(ax, run.time, rows, *room_for(np.clip(rows, -most, most)))


def mark_contacts(ax: Axes, run: Run, place: int, *, until: float = np.inf) -> None:
    """Draw a cross in a ring where each contact began, in a top view, with an entry for the legend.

    Args:
        ax: The axes.
        run: The run.
        place: The place of the seed in the run.
        until: The time [s] after which contacts are not drawn.
    """
    shown = [contact for contact in contacts(run, place, MOST_DRAWN) if contact.start <= until]
    if shown:
        ax.plot([contact.x for contact in shown], [contact.y for contact in shown], **CONTACT, label="contact")


def last_known(values: np.ndarray) -> int:
    """The place of the last finite sample of ``values`` (n,), or -1."""
    known = np.flatnonzero(np.isfinite(values))
    return int(known[-1]) if known.size else -1


def draw_obstacles(ax: Axes, lines: Iterable[np.ndarray], **style: Any) -> None:
    """Draw obstacles in a top view; walls are lines.

    Args:
        ax: The axes.
        lines: The outlines, as :func:`robotics.world.environment.world.outlines` gives them.
        style: Options of the collections that are drawn.
    """
    look: dict[str, Any] = OBSTACLE | {"zorder": 1.5} | style
    closed, walls = split_outlines(lines)
    ax.add_collection(PolyCollection(closed, **look))
    ax.add_collection(LineCollection(walls, colors=look["edgecolor"], linewidths=2.0, zorder=look["zorder"]))


def draw_patches(ax: Axes, patches: Sequence[Patch]) -> None:
    """Draw the patches of a floor in a top view, each with its friction, within limits of the axes that are set.

    Slippery ones are hatched by lines, rough ones by a grid, told apart without their colours.
    """
    for patch in patches:
        outline, rough = patch.outline(), patch.friction > 1
        color, hatch = (COLORS[5], "++") if rough else (COLORS[4], "--")
        look: dict[str, Any] = {"facecolor": (color, 0.12), "edgecolor": (color, 0.6), "linewidth": 0.6}
        ax.add_patch(Polygon(outline, zorder=0.5, hatch=hatch, **look))
        x, y = outline[:, 0].mean(), outline[:, 1].min()
        if not ax.get_autoscale_on():
            x, y = np.clip([x, y], *np.transpose([ax.get_xlim(), ax.get_ylim()]))
        words = on_white(0.6) | {"zorder": 0.6, "fontsize": 6}
        ax.text(x, y, f"friction × {shown(patch.friction)}", ha="center", va="bottom", clip_on=True, **words)


def split_outlines(lines: Iterable[np.ndarray]) -> tuple[list[np.ndarray], list[np.ndarray]]:
    """The outlines that return to their first point, which enclose a solid; and the others, which are walls."""
    found: tuple[list[np.ndarray], list[np.ndarray]] = [], []
    for points in lines:
        solid = len(points) > 2 and np.allclose(points[0], points[-1])
        found[0 if solid else 1].append(points)
    return found


def rectangles(x: np.ndarray, y: np.ndarray, heading: np.ndarray, length: float, width: float) -> np.ndarray:
    """The corners (n, 4, 2) [m] of robots in a top view.

    Args:
        x: The robots' centers (n,) [m].
        y: Likewise.
        heading: The robots' headings (n,) [rad].
        length: The length of each robot [m].
        width: The width of each robot [m].
    """
    body = np.array([[-0.5, -0.5], [0.5, -0.5], [0.5, 0.5], [-0.5, 0.5]]) * (length, width)
    return placed(body, x, y, heading)


def placed(shape: np.ndarray, x: np.ndarray, y: np.ndarray, heading: np.ndarray) -> np.ndarray:
    """A shape turned and moved to every pose (n, points, 2).

    Args:
        shape: The shape (points, 2), or one for every pose (n, points, 2).
        x: The places (n,), in the unit of the shape.
        y: Likewise.
        heading: The headings (n,) [rad].
    """
    cos, sin = np.cos(heading), np.sin(heading)
    turn = np.stack([np.stack([cos, -sin], axis=-1), np.stack([sin, cos], axis=-1)], axis=-2)
    return np.asarray(
        np.einsum("rij,rpj->rpi", turn, np.broadcast_to(shape, (len(x), *np.shape(shape)[-2:])))
        + np.stack([x, y], axis=-1)[:, None]
    )


def legend_entries(*axes: Axes) -> dict[str, Any]:
    """The handles of what is drawn in one or several axes, by name; each name once."""
    return {name: handle for ax in axes for handle, name in zip(*ax.get_legend_handles_labels(), strict=True)}


def draw_common_legend(owner: Axes | Figure, axes: Iterable[Axes], **options: Any) -> None:
    """A legend of all that is drawn in several axes, each name once.

    Args:
        owner: The axes or the figure that it belongs to.
        axes: The axes.
        options: Options of ``owner.legend``; without ``ncol`` it has one row.
    """
    found = legend_entries(*axes)
    owner.legend(list(found.values()), list(found), **{"ncol": len(found)} | options)


def draw_legend(ax: Axes, last: Sequence[str] = (), **options: Any) -> None:
    """A legend above the axes, without repeated names: first the robots, in their order, the names ``last`` at the end.

    Args:
        ax: The axes.
        last: The names that come last, in this order; those that are not drawn are left out.
        options: Options of ``ax.legend``.
    """
    found = legend_entries(ax)
    names = [*(name for name in found if name not in last), *(name for name in last if name in found)]
    if names:
        inches = ax.get_window_extent().width / figure_of(ax).dpi
        widest = max(text_width(name, 7.0) for name in names) + 0.5  # with its line and the space to the next
        look: dict[str, Any] = {"loc": "lower center", "bbox_to_anchor": (0.5, 1.0), "columnspacing": 1.2} | options
        ax.legend([found[n] for n in names], names, ncol=max(1, min(len(names), int(inches / widest))), **look)


def draw_title(figure: Figure, run: Run, order: Sequence[int], banded: bool = False) -> None:
    """The title of a page, :func:`page_title`, in as many lines as the figure's width needs."""
    letters = max(20, int(figure.get_figwidth() / text_width("n", 9.0)))
    figure.suptitle(textwrap.fill(page_title(run, order, banded), letters), parse_math=False, fontsize=9)


def is_band(order: Sequence[int]) -> bool:
    """Whether seeds are so many that over time they are a band, with the first one's line."""
    return len(order) >= _BANDED


def page_title(run: Run, order: Sequence[int], banded: bool = False) -> str:
    """The title of a page: law, scenario and the seeds at the places ``order``, of which the first is drawn boldly.

    ``banded``: many others are a band, of :func:`fill_band`, and not lines.
    """
    seeds = f"seed {run.seeds[order[0]]}"
    if banded and is_band(order):
        seeds += f"; bands: 5 to 95 % of seeds {seeds_as_text([run.seeds[r] for r in sorted(order)])}"
    elif len(order) > 1:
        seeds += f"; faint: seeds {seeds_as_text([run.seeds[r] for r in order[1:]])}"
    stopped = int(run.diverged.sum())
    end = f"; stopped (×): {stopped} of {run.diverged.size}" if stopped else ""
    touched = int(np.isfinite(first_contact(run)).sum())
    if touched:
        end += f"; contact (⊗) in {touched} of {len(run.seeds)} runs" if len(run.seeds) > 1 else "; contact (⊗)"
    return f"{law_title(run.controller)} on {run.scenario}, {seeds}{end}"
