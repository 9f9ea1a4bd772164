"""Shared parts of the pictures of runs: a look for each controller, thinned lines, seeds as text."""

import warnings
from collections.abc import Iterable, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection, PolyCollection
from matplotlib.lines import Line2D

from fuzzy.errors import InputError
from fuzzy.figures.drawing import COLORS, LINES
from robotics.laws.catalogue import law_title
from robotics.measures.contacts import MOST_DRAWN, contacts, first_contact
from robotics.measures.standing import last_move
from robotics.simulation.run import Run

TARGET = {"color": "0.45", "linestyle": (0, (4, 2)), "linewidth": 1.0}  # how every reference is drawn
POINTS = 2000  # points of a line, at most about: a double column printed at 300 dpi is that wide
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
AFTER = 4.0  # s shown after the last robot came to rest
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


def looks(specifications: Iterable[str]) -> dict[str, Look]:
    """A look for every controller: each of the six presets has its own, others take the remaining ones in turn."""
    wanted = list(dict.fromkeys(specifications))
    places = {name: _PLACES[name] for name in wanted if name in _PLACES}
    free = iter([n for n in range(len(COLORS)) if n not in places.values()] + list(range(len(COLORS), 1000)))
    for name in wanted:
        if name not in places:
            places[name] = next(free)
    return {name: _look(n) for name, n in places.items()}


def _look(n: int) -> Look:
    """The n-th look: the style's own pairs of colour and line; then the colours again with other lines, 21 in all."""
    count = len(COLORS)
    line = LINES[n] if n < count else LINES[:6][(n + n // count) % 6]  # the seventh line is the first again
    return Look(COLORS[n % count], line, _MARKERS[n % len(_MARKERS)])


def looks_of(specifications: Iterable[str], given: Mapping[str, Look] | None) -> Mapping[str, Look]:
    """The looks that are ``given``, or those of :func:`looks` for the controllers."""
    return looks(specifications) if given is None else given


def only(run: Run, seed: int | None) -> Run:
    """The run of that one seed, by default the first. Raises PlotError for a seed that was not run."""
    seed = run.seeds[0] if seed is None else seed
    if seed not in run.seeds:
        raise PlotError(f"seed {seed} is not among those of the run: {seeds_as_text(run.seeds)}")
    return run.only(seed)


def shown_until(run: Run, place: int, after: float = AFTER) -> int:
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
    step = -(-2 * n // POINTS)
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
    step = max(1, len(x) // POINTS)
    if step == 1:
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
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", RuntimeWarning)  # once all are stopped: not-a-number
        low, middle, high = np.nanpercentile(rows, (5, 50, 95), axis=0)
    ax.fill_between(time, low, high, color="0.35", alpha=0.3, linewidth=0, zorder=2, label=f"{of}5–95 % of the robots")
    for edge in (low, high):
        draw_line(ax, time, edge, color="black", linestyle="-", linewidth=0.4, alpha=0.6, zorder=2.5)
    draw_line(ax, time, middle, color="black", linestyle="-", linewidth=1.0, zorder=3, label=f"{of}median")


def mark_stop(ax: Axes, x: float, y: float, color: Any) -> None:
    """Draw a cross where a robot was stopped.

    Args:
        ax: The axes.
        x: The place, in the axes' unit.
        y: Likewise.
        color: The robot's colour.
    """
    ax.plot([x], [y], marker="X", color=color, markersize=7, markeredgecolor="white", linestyle="none", zorder=4)


def mark_contacts(
    ax: Axes,
    run: Run,
    place: int,
    *,
    until: float = np.inf,
    scale: float = 1.0,
    center: tuple[float, float] = (0.0, 0.0),
) -> None:
    """Draw a cross in a ring where each contact began, in a top view, with an entry for the legend.

    Args:
        ax: The axes.
        run: The run.
        place: The place of the seed in the run.
        until: The time [s] after which contacts are not drawn.
        scale: The axes' units in a metre.
        center: The place [m] that is the origin of the axes.
    """
    shown = [contact for contact in contacts(run, place, MOST_DRAWN) if contact.start <= until]
    if shown:
        x, y = np.array([(contact.x, contact.y) for contact in shown]).T
        ax.plot(scale * (x - center[0]), scale * (y - center[1]), **CONTACT, label="contact")


def last_known(values: np.ndarray) -> int:
    """The place of the last finite sample of ``values`` (n,), or -1."""
    known = np.flatnonzero(np.isfinite(values))
    return int(known[-1]) if known.size else -1


def draw_obstacles(ax: Axes, lines: Iterable[np.ndarray], **style: Any) -> None:
    """Draw obstacles in a top view; walls are lines.

    Args:
        ax: The axes.
        lines: The outlines, as :func:`robotics.environment.world.outlines` gives them.
        style: Options of the collections that are drawn.
    """
    look: dict[str, Any] = OBSTACLE | {"zorder": 1.5} | style
    closed, walls = split_outlines(lines)
    ax.add_collection(PolyCollection(closed, **look))
    ax.add_collection(LineCollection(walls, colors=look["edgecolor"], linewidths=2.0, zorder=look["zorder"]))


def split_outlines(lines: Iterable[np.ndarray]) -> tuple[list[np.ndarray], list[np.ndarray]]:
    """The outlines that return to their first point, which enclose a solid; and the others, which are walls."""
    listed = list(lines)
    closed = [len(points) > 2 and bool(np.allclose(points[0], points[-1])) for points in listed]
    return (
        [points for points, solid in zip(listed, closed, strict=True) if solid],
        [points for points, solid in zip(listed, closed, strict=True) if not solid],
    )


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


def page_title(run: Run, order: Sequence[int]) -> str:
    """The title of a page: law, scenario and the seeds at the places ``order``, of which the first is drawn boldly."""
    seeds = f"seed {run.seeds[order[0]]}"
    if len(order) > 1:
        seeds += f"; faint: seeds {seeds_as_text([run.seeds[r] for r in order[1:]])}"
    stopped = int(run.diverged.sum())
    end = f"; stopped (×): {stopped} of {run.diverged.size}" if stopped else ""
    touched = int(np.isfinite(first_contact(run)).sum())
    if touched:
        end += f"; contact (⊗) in {touched} of {len(run.seeds)} runs" if len(run.seeds) > 1 else "; contact (⊗)"
    return f"{law_title(run.controller)} on {run.scenario}, {seeds}{end}"
