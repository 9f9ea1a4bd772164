"""The pictures of an arena: who leads and how surely, at which budget, at what effort, and what a change does to it."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import LinearSegmentedColormap
from matplotlib.figure import Figure
from matplotlib.image import AxesImage
from matplotlib.lines import Line2D
from matplotlib.patches import Rectangle
from matplotlib.text import Text

from fuzzy.figures.drawing import COLORS, LINES, figure_of, number, styled_figure, text_width
from fuzzy.figures.palette import DIVERGING, ROLES, STRONG
from robotics.measures.statistics.intervals import Interval
from robotics.measures.statistics.ranking import pareto_front
from robotics.plugins.arena.entrants import Sort
from robotics.show.figures.drawing import PlotError, write_log_ticks

WIDTH = 6.3  # inches: 16 cm, the text of a printed page
_MOST = 20.0  # times the reference's cost: what is more is written at the edge
_GAP = 0.1  # inches between columns of text
_FORMS = (("as published", "white"), ("tuned", "0.35"))  # of a law, and how its marks are filled
_MARKS = {"better": "▲", "worse": "▼", "equivalent": "=", "undecided": "?"}
_RATIOS = (0.25, 0.33, 0.5, 0.67, 0.8, 0.9, 1.0, 1.1, 1.25, 1.5, 2.0, 3.0, 4.0)
_BUDGETS = (1, 2, 5, 10, 20, 50, 100, 200, 500, 1000, 2000, 5000)  # evaluations at which there may be a tick
# From good over nothing to bad, blue and orange as in the series
_SCALE = LinearSegmentedColormap.from_list("cost", DIVERGING)


class _Look(NamedTuple):
    words: str
    color: str
    marker: str


_FAMILIES: dict[Sort, _Look] = {
    "fuzzy": _Look("fuzzy", COLORS[0], "o"),
    "lyapunov": _Look("Lyapunov, sliding mode", COLORS[1], "s"),
    "geometric": _Look("geometric", COLORS[2], "^"),
    "linear": _Look("linear", STRONG[3], "D"),
    "predictive": _Look("predictive", COLORS[6], "P"),
    "other": _Look("other", ROLES["quiet"].light, "X"),
}


@dataclass(frozen=True)
class Entrant:
    """A law as pictures name and colour it."""

    title: str  # short: at most some 22 characters
    family: Sort


@dataclass(frozen=True, eq=False)
class Standings:
    """What the one look shows; every array has a place for each law, not-a-number where nothing is known."""

    laws: Sequence[Entrant]
    reference: str  # the title of the law whose tuned cost is 1
    published: Interval  # (laws,), cost over the reference's, with the gains as published
    tuned: Interval  # (laws,), likewise tuned; infinite: fails
    failures: Interval  # (laws,), share of the tuned law's runs that failed, 0 to 1
    effort: np.ndarray  # (laws,) [rad/s²], of the tuned law
    computing: np.ndarray  # (laws,) [µs], of one period
    numbers: np.ndarray  # (laws,), how many numbers were tuned


def plot_ranking(standings: Standings, width: float = WIDTH) -> Figure:
    """Draw the one look: laws from the least tuned cost down, as published and tuned, beside what they ask for.

    Hollow marks are costs as published, filled ones tuned, each with its 95 % interval, over the reference's tuned
    cost. A law whose statistic is infinite stands at the right edge as "fails".

    Args:
        standings: The laws and their numbers.
        width: The width of the figure in inches; less than some 5.5 leaves the costs little room.

    Raises PlotError where no law has a finite cost.
    """
    laws, tuned, published = standings.laws, standings.tuned, standings.published
    order = np.argsort(np.where(np.isnan(tuned.value), np.inf, tuned.value), kind="stable")
    known = np.concatenate([tuned.value, published.value])
    _some_finite(known)
    known = known[np.isfinite(known)]
    right = min(max(float(known.max()) * 1.15, 1.6), _MOST)
    with styled_figure(width, 1.05 + 0.2 * len(laws)) as figure:
        columns = _columns(standings, order)
        needed = columns[-1][0] + _GAP
        room = width - _names_width(laws) - needed - 0.3
        ax, beside = figure.subplots(1, 2, sharey=True, width_ratios=[max(room, 0.8), needed])
        for row, law in enumerate(order):
            look = _FAMILIES[laws[law].family]
            if row % 2:
                for part in (ax, beside):
                    part.axhspan(row - 0.5, row + 0.5, color=ROLES["band"].light, linewidth=0, zorder=0)
            _draw_cost(ax, row - 0.16, published[law], look, right, hollow=True)
            _draw_cost(ax, row + 0.16, tuned[law], look, right, hollow=False)
            if beyond := _beyond(float(published.value[law]), float(tuned.value[law]), right):
                ax.text(right / 1.01, row, beyond, color=look.color, fontsize=6.3, ha="right", va="center", zorder=5)
        ax.axvline(1.0, color="0.45", linewidth=0.8, linestyle=(0, (4, 2)), zorder=1)
        left = min(0.9, float(known.min()) / 1.1)
        ax.set(xscale="log", xlim=(left, right))
        write_log_ticks(ax.xaxis, _round_ticks(left, right))
        ax.set_xlabel(f"cost [tuned {standings.reference} = 1], logarithmic\n← better")
        ranks = [str(row + 1) if np.isfinite(tuned.value[law]) else "–" for row, law in enumerate(order)]
        ax.set_yticks(range(len(laws)), [f"{laws[law].title}  {rank}" for law, rank in zip(order, ranks, strict=True)])
        _color_names(ax.get_yticklabels(), [laws[law] for law in order])
        ax.set_ylim(len(laws) - 0.5, -0.5)
        ax.grid(visible=False, axis="y")
        _write_columns(beside, columns)
        _legend(figure, laws, _FORMS)
        return figure


def _draw_cost(ax: Axes, row: float, cost: Interval, look: _Look, right: float, hollow: bool) -> None:
    """Draw one law's cost in its row, if it is at most ``right``."""
    value, low, high = float(cost.value), float(cost.low), float(cost.high)
    if value <= right:
        ax.plot([low, min(high, right)], [row, row], color=look.color, linestyle="-", linewidth=1.0, zorder=3)
        _mark(ax, (value, row), look, 3.8, hollow, zorder=4)


def _mark(
    ax: Axes, at: Sequence[float] | np.ndarray, look: _Look, size: float, hollow: bool = False, zorder: float = 3
) -> None:
    """Draw a law's mark at a point, filled or ``hollow``."""
    fill = "white" if hollow else look.color
    ax.plot(*at, marker=look.marker, color=look.color, markerfacecolor=fill, markersize=size, zorder=zorder)


def _beyond(published: float, tuned: float, right: float) -> str:
    """What is written at the right edge of a law's row: costs that do not fit, and infinite ones."""
    words = {
        name: "fails" if np.isinf(value) else f"{_few(value)}×"
        for name, value in (("published", published), ("tuned", tuned))
        if value > right
    }
    if len(words) == 2 and len(set(words.values())) == 1:
        return f"{words['tuned']} ▸"
    return "  ".join(f"{name}: {word} ▸" for name, word in words.items())


def _names_width(laws: Sequence[Entrant]) -> float:
    """The width of the laws' names and ranks beside an axis, in inches."""
    return max(text_width(f"{law.title}  00", 7) for law in laws) + 0.1


def _columns(standings: Standings, order: np.ndarray) -> list[tuple[float, str, list[str]]]:
    """What each law asks for: failures, effort, computing time, tuned numbers; with where a column ends, in inches."""
    columns = [
        ("failed\n[%]", [_percent(standings.failures[law]) for law in order]),
        ("effort\n[rad/s²]", [*map(_few, standings.effort[order])]),
        ("computing\n[µs]", [*map(_few, standings.computing[order])]),
        ("numbers\ntuned", [*map(_few, standings.numbers[order])]),
    ]
    columns = [(title, cells) for title, cells in columns if {*cells} != {_few(np.nan)}]  # of nothing none is made
    widths = [max(text_width(line, 6.5) for line in (*title.split("\n"), *cells)) for title, cells in columns]
    ends = np.cumsum(np.array(widths) + _GAP)
    return [(float(end), *column) for end, column in zip(ends, columns, strict=True)]


def _write_columns(ax: Axes, columns: Sequence[tuple[float, str, Sequence[str]]]) -> None:
    """Write columns of text (end in inches, title, cells), right-aligned, a cell a row."""
    ax.set_axis_off()
    ax.set_xlim(0, columns[-1][0] + _GAP)
    for end, title, cells in columns:
        ax.text(end, -0.62, title, ha="right", va="bottom", fontsize=6.5, color=ROLES["quiet"].light)
        for row, cell in enumerate(cells):
            ax.text(end, row, cell, ha="right", va="center", fontsize=6.5)


def _few(value: float) -> str:
    return "–" if np.isnan(value) else number(float(f"{value:.2g}"))


def _percent(share: Interval) -> str:
    """A failure rate with the upper end of its interval: what the runs cannot rule out."""
    if np.isnan(share.value):
        return "–"
    return f"{_few(100 * float(share.value))} (≤ {_few(100 * float(share.high))})"


def plot_budget(laws: Sequence[Entrant], budgets: np.ndarray, curves: Interval) -> Figure:
    """Draw the cost of the best so far over the number of evaluations, a line a law with a band over the repeats.

    Args:
        laws: The laws.
        budgets: The numbers of evaluations (budgets,), growing.
        curves: Median and range over repeats (laws, budgets), of :meth:`robotics.plugins.arena.outcome.Outcome.curves`.

    Raises PlotError where no law has a finite cost at the end.
    """
    _some_finite(curves.value[:, -1])
    with styled_figure(WIDTH, 3.4) as figure:
        ax = figure.subplots()
        for law, line, own in zip(laws, _lines(laws), range(len(laws)), strict=True):
            color = _FAMILIES[law.family].color
            middle, least, most = (_finite(part[own]) for part in (curves.value, curves.low, curves.high))
            ax.fill_between(budgets, least, most, color=color, alpha=0.13, linewidth=0)
            ax.plot(budgets, middle, color=color, linestyle=line, linewidth=1.2)
        low, high = _room(curves)
        begin = budgets[0] if len(budgets) > 1 else budgets[0] / 2
        ax.set(xscale="log", xlim=(begin, budgets[-1]), xlabel="evaluations")
        ax.set(yscale="log", ylim=(low, high), ylabel="cost of the best so far [1], logarithmic")
        write_log_ticks(ax.xaxis, [b for b in _BUDGETS if budgets[0] <= b <= budgets[-1]])
        write_log_ticks(ax.yaxis, _round_ticks(low, high))
        ends = np.column_stack([np.full(len(laws), budgets[-1]), curves.value[:, -1]])
        _write_beside(ax, laws, ends, figure.get_size_inches()[1] * 0.78)
        _legend(figure, laws, lines=True)
        return figure


def _finite(values: np.ndarray) -> np.ndarray:
    """The values, with a gap where they are infinite."""
    return np.where(np.isfinite(values), values, np.nan)


def _some_finite(values: np.ndarray) -> None:
    if not np.isfinite(values).any():
        raise PlotError("no law has a finite cost: there is nothing to draw")


def _room(curves: Interval) -> tuple[float, float]:
    """The ends of the axis of costs: all medians, and of the bands what lies within twice their greatest."""
    middle = curves.value[np.isfinite(curves.value)]
    low = min(float(middle.min()), float(np.nanmin(_finite(curves.low))))
    high = min(2 * float(middle.max()), float(np.nanmax(_finite(curves.high))))
    return low / 1.04, max(high, float(middle.max())) * 1.04


def _round_ticks(low: float, high: float) -> list[float]:
    """Round numbers on a logarithmic axis: close ones where it is short."""
    close = (1, 1.1, 1.2, 1.3, 1.4, 1.6, 1.8, 2, 2.5, 3, 4, 5, 6, 7, 8, 9)
    middle, wide = (1, 1.5, 2, 3, 5, 7), (1, 2, 5)
    steps: Sequence[float] = close if high < 4 * low else middle if high < 20 * low else wide
    decades = range(int(np.floor(np.log10(low))), int(np.ceil(np.log10(high))) + 1)
    return [t for t in (s * 10.0**d for d in decades for s in steps) if low <= t <= high]


def _write_beside(ax: Axes, laws: Sequence[Entrant], points: np.ndarray, height: float) -> None:
    """Write the laws' names in a column to the right, pushed apart where they would overlap, each joined to its point.

    Args:
        ax: The axes, with logarithmic axes.
        laws: The laws.
        points: Where the names belong (laws, 2); a law whose height is infinite fails, and stands on top.
        height: The height of the axes in inches.
    """
    ends = np.log([ax.get_xlim(), ax.get_ylim()])
    fails = ~np.isfinite(points[:, 1])
    at = (np.log(np.where(fails[:, None], np.exp(ends[:, 1]), points)) - ends[:, 0]) / (ends[:, 1] - ends[:, 0])
    placed = _apart(np.clip(at[:, 1], 0.0, 1.0), 0.115 / height)
    for law, own, where, failed in zip(laws, np.minimum(at, 1.0), placed, fails, strict=True):
        color = _FAMILIES[law.family].color
        line = {"arrowstyle": "-", "color": color, "linewidth": 0.5, "relpos": (0, 0.5), "shrinkA": 0, "shrinkB": 0}
        look: dict[str, Any] = {"fontsize": 6.5, "color": color, "va": "center", "annotation_clip": False}
        words = f"{law.title}: fails" if failed else law.title
        ax.annotate(words, own, (1.045, where), "axes fraction", "axes fraction", arrowprops=line, **look)


def _apart(places: np.ndarray, gap: float) -> np.ndarray:
    """The places (n,) moved as little as need be so that none is nearer than ``gap`` to another, in their order.

    It is the least-squares fit of growing numbers, by pooling those that violate the order [Ayer 1955].
    """
    from scipy.optimize import isotonic_regression

    order, gaps = np.argsort(places, kind="stable"), gap * np.arange(len(places))
    moved = np.empty_like(places)
    moved[order] = isotonic_regression(places[order] - gaps).x + gaps
    return moved - max(0.0, float(moved.max()) - max(1.0, float(places.max())))


def plot_improvement(laws: Sequence[Entrant], chances: Interval, verdicts: np.ndarray) -> Figure:
    """Draw the probability that the row's law costs less than the column's, with the verdict on each pair.

    Args:
        laws: The laws, in the order of rows and columns.
        chances: The probabilities (laws, laws), of robotics.measures.statistics.shares.probability_of_improvement.
        verdicts: What robotics.measures.statistics.pairs.verdicts says (laws, laws).
    """
    count = len(laws)
    room = (WIDTH - _names_width(laws) - 0.85) / count  # inches across a cell
    between, size = (" ", 6.3) if room > 0.28 else ("\n", 5.5)
    with styled_figure(WIDTH, max(1.45 + 0.24 * count, 2.6)) as figure:
        ax = figure.subplots()
        shown = np.where(np.eye(count, dtype=bool), np.nan, 100 * chances.value)
        image = ax.imshow(shown, cmap=_SCALE.reversed(), vmin=0, vmax=100, aspect="auto")
        for row, column in np.ndindex(count, count):
            if row != column:
                chance, mark = shown[row, column], _MARKS[str(verdicts[row, column])]
                color = "white" if abs(chance - 50) > 42 else ROLES["ink"].light
                words = f"{chance:.0f}{between}{mark}"
                ax.text(column, row, words, ha="center", va="center", fontsize=size, linespacing=0.9, color=color)
        ax.set_xticks(range(count), [law.title for law in laws], rotation=40, ha="left", rotation_mode="anchor")
        _end_matrix(ax, image, laws, "runs on which the row costs less [%]", {t: f"{t}" for t in (0, 25, 50, 75, 100)})
        _color_names(ax.get_xticklabels(), laws)
        words = "   ".join(f"{mark} {verdict}" for verdict, mark in _MARKS.items())
        figure.supxlabel(f"the row's cost against the column's:  {words}", fontsize=6.5)
        return figure


def plot_robustness(laws: Sequence[Entrant], changes: Sequence[str], ratios: Interval) -> Figure:
    """Draw what a change that no law was tuned for does to its cost: a heat map with numbers, rows laws.

    A number in brackets cannot be told from 1: its interval contains it.

    Args:
        laws: The laws, in the order of rows.
        changes: What is changed, in the order of columns: "mass +20 %".
        ratios: The cost with the change over the cost without (laws, changes); infinite: fails.
    """
    finite = np.where(np.isfinite(ratios.value) & (ratios.value > 0), ratios.value, np.nan)
    reach = float(np.clip(np.nanmax(np.abs(np.log(finite)), initial=0.0), np.log(1.2), np.log(4.0)))
    with styled_figure(WIDTH, max(1.0 + 0.22 * len(laws), 1.8)) as figure:
        ax = figure.subplots()
        image = ax.imshow(np.log(finite), cmap=_SCALE, vmin=-reach, vmax=reach, aspect="auto")
        for row, column in np.ndindex(*ratios.value.shape):
            _write_ratio(ax, row, column, ratios[row, column], reach)
        heads = [change.replace(" ", "\n", 1) for change in changes]
        room = (WIDTH - _names_width(laws) - 0.85) / len(changes)  # inches across a cell
        crowded = max(text_width(line, 7) for head in heads for line in head.split("\n")) > room - 0.06
        turned: dict[str, Any] = {"rotation": 40, "ha": "left", "rotation_mode": "anchor"} if crowded else {}
        ax.set_xticks(range(len(changes)), changes if crowded else heads, **turned)
        ticks = {float(np.log(t)): f"{t:g}" for t in _RATIOS if abs(np.log(t)) <= reach * 1.001}
        _end_matrix(ax, image, laws, "cost [unchanged = 1]", ticks)
        figure.supxlabel("(in brackets: cannot be told from 1)", fontsize=6.5)
        return figure


def _write_ratio(ax: Axes, row: int, column: int, ratio: Interval, reach: float) -> None:
    value, color = float(ratio.value), ROLES["ink"].light
    if np.isnan(value):
        words = "–"
    elif np.isinf(value):
        words, color = "fails", "white"
        ax.add_patch(Rectangle((column - 0.5, row - 0.5), 1, 1, facecolor=ROLES["ink"].light, linewidth=0))
    else:
        words = f"{value:.2f}" if value < 9.95 else f"{value:.0f}"
        words = f"({words})" if ratio.low <= 1 <= ratio.high else words
        color = "white" if abs(np.log(max(value, 1e-9))) > 0.8 * reach else color
    ax.text(column, row, words, ha="center", va="center", fontsize=6.5, color=color)


class KnowledgeLine(NamedTuple):
    """What a law costs by what it knows."""

    law: Entrant
    known: Sequence[str]
    cost: Interval  # an array each (known,); infinite: it fails


class ConditionPanel(NamedTuple):
    """The laws under one condition."""

    title: str
    columns: Sequence[str]  # what can be known
    lines: Sequence[KnowledgeLine]
    floor: float  # 0: none


def plot_conditions(panels: Sequence[ConditionPanel]) -> Figure:
    """Draw what laws cost by what they know, a panel for each condition, a line for each law.

    Args:
        panels: The conditions; laws of the same title look alike in all.
    """
    laws = list({line.law.title: line.law for panel in panels for line in panel.lines}.values())
    looks = dict(zip((law.title for law in laws), _lines(laws), strict=True))
    values = np.concatenate([np.ravel(line.cost.value) for panel in panels for line in panel.lines])
    _some_finite(values)
    floors = [panel.floor for panel in panels if panel.floor > 0]
    low, high = min([*values[np.isfinite(values)], *floors]) / 1.15, 1.15 * max(values[np.isfinite(values)])
    rows, across = -(-len(panels) // 2), min(len(panels), 2)
    with styled_figure(WIDTH, 0.9 + 2.3 * rows) as figure:
        grid = figure.subplots(rows, across, squeeze=False, sharey=True)
        for ax, panel in zip(grid.flat, panels, strict=False):
            for n, line in enumerate(panel.lines):
                x = np.array([panel.columns.index(name) for name in line.known]) + 0.05 * (n - len(panel.lines) / 2)
                color, shown = (
                    _FAMILIES[line.law.family].color,
                    [_finite(part) for part in (line.cost.value, line.cost.low, line.cost.high)],
                )
                ax.plot(x, shown[0], color=color, linestyle=looks[line.law.title], linewidth=1.0)
                ax.vlines(x, shown[1], shown[2], color=color, linewidth=0.8)
                ax.plot(x, shown[0], _FAMILIES[line.law.family].marker, color=color, markersize=3.5)
            if panel.floor > 0:
                ax.axhline(panel.floor, color="0.4", linestyle="--", linewidth=0.8)
            ax.set(title=panel.title, yscale="log", ylim=(low, high), xlim=(-0.5, len(panel.columns) - 0.5))
            ax.set_xticks(
                range(len(panel.columns)), [name.replace(", ", ",\n") for name in panel.columns], fontsize=6.5
            )
            write_log_ticks(ax.yaxis, _round_ticks(low, high))
        for ax in grid.flat[len(panels) :]:
            ax.set_visible(False)
        for ax in grid[:, 0]:
            ax.set_ylabel("cost, tuned [1]")
        handles = [
            Line2D(
                [],
                [],
                color=_FAMILIES[law.family].color,
                marker=_FAMILIES[law.family].marker,
                markersize=3.5,
                linestyle=looks[law.title],
                label=law.title,
            )
            for law in laws
        ] + ([Line2D([], [], color="0.4", linestyle="--", label="the reference's own variation")] if floors else [])
        figure.legend(handles=handles, loc="outside upper center", ncol=4, fontsize=6.5)
        return figure


def plot_pareto(
    laws: Sequence[Entrant],
    effort: np.ndarray,
    precision: np.ndarray,
    titles: tuple[str, str],
    published: np.ndarray,
) -> Figure:
    """Draw precision against effort, a named point a law, and the front of those that none beats in both.

    Args:
        laws: The laws.
        effort: The tuned laws' effort (laws,), > 0; less is better.
        precision: The tuned laws' error (laws,), > 0; less is better.
        titles: What the axes of effort and of precision say, each with its unit in brackets.
        published: Effort and error as published (laws, 2), drawn hollow and joined to the tuned ones.

    Raises PlotError where no law has a finite point.
    """
    tuned = np.column_stack([effort, precision]).astype(float)
    known = np.isfinite(tuned).all(axis=1)
    _some_finite(np.where(known, 1.0, np.inf))
    with styled_figure(WIDTH, 3.7) as figure:
        ax = figure.subplots()
        ax.set(xscale="log", yscale="log")
        front = tuned[pareto_front(np.where(np.isnan(tuned), np.inf, tuned))]
        front = front[np.argsort(front[:, 0])]
        ax.plot(*front.T, color="0.6", drawstyle="steps-post", linewidth=1.0, linestyle="-", zorder=1)
        for k, law in enumerate(laws):
            look = _FAMILIES[law.family]
            if known[k] and np.isfinite(published[k]).all():
                ax.plot(*np.stack([published[k], tuned[k]]).T, color=look.color, linestyle=":", linewidth=0.7)
                _mark(ax, published[k], look, 3.8, hollow=True)
            if known[k]:
                _mark(ax, tuned[k], look, 5)
        points = np.concatenate([tuned[known], published[known]])
        points = points[np.isfinite(points).all(axis=1)]
        _round_axes(ax, points)
        ax.set(xlabel=f"{titles[0]}, logarithmic\n← better", ylabel=f"{titles[1]}, logarithmic\n← better")
        _legend(figure, laws, _FORMS)
        named = [law for law, is_known in zip(laws, known, strict=True) if is_known]
        _write_beside(ax, named, tuned[known], figure.get_size_inches()[1] * 0.78)
        return figure


def _round_axes(ax: Axes, points: np.ndarray) -> None:
    """Give both logarithmic axes room around the points (n, 2), and round ticks."""
    for axis, values, limit in ((ax.xaxis, points[:, 0], ax.set_xlim), (ax.yaxis, points[:, 1], ax.set_ylim)):
        margin = max((values.max() / values.min()) ** 0.1, 1.25)
        low, high = values.min() / margin, values.max() * margin
        limit(low, high)
        write_log_ticks(axis, _round_ticks(low, high))


def _lines(laws: Sequence[Entrant]) -> list[Any]:
    """A line style for each law: its own where there are enough, otherwise its own within its family."""
    if len(laws) <= len(LINES):
        return list(LINES[: len(laws)])
    turns = [sum(other.family == law.family for other in laws[:k]) for k, law in enumerate(laws)]
    return [LINES[turn % len(LINES)] for turn in turns]


def _color_names(labels: Iterable[Text], laws: Sequence[Entrant]) -> None:
    for label, law in zip(labels, laws, strict=True):
        label.set_color(_FAMILIES[law.family].color)
        label.set_parse_math(False)


def _end_matrix(ax: Axes, image: AxesImage, laws: Sequence[Entrant], label: str, ticks: Mapping[float, str]) -> None:
    """Name the rows of a heat map and part its cells by white lines; leave nothing else of its axes but a colour bar.

    Args:
        ax: The axes.
        image: What is drawn in them.
        laws: The laws, in the order of rows.
        label: What the colours say, with its unit in brackets.
        ticks: What the colour bar says at which values.
    """
    ax.set_yticks(range(len(laws)), [law.title for law in laws])
    _color_names(ax.get_yticklabels(), laws)
    ax.xaxis.tick_top()
    bar = figure_of(ax).colorbar(image, ax=ax, fraction=0.03, pad=0.015, ticks=list(ticks))
    bar.ax.set_yticklabels(list(ticks.values()))
    bar.outline.set_visible(False)
    bar.set_label(label, fontsize=7)
    ax.grid(visible=False)
    ax.tick_params(length=0)
    ax.spines[:].set_visible(False)
    for lines, count in ((ax.axvline, ax.get_xlim()[1]), (ax.axhline, ax.get_ylim()[0])):
        for k in range(int(count + 0.5) + 1):
            lines(k - 0.5, color="white", linewidth=0.8)


def _legend(
    figure: Figure, laws: Sequence[Entrant], marks: Sequence[tuple[str, str]] = (), lines: bool = False
) -> None:
    """Draw the legend on top: of the ``marks`` (words, fill), and of families as marks or ``lines``."""
    found: dict[str, dict[str, Any]]
    found = {word: {"color": "0.35", "marker": "o", "markerfacecolor": fill} for word, fill in marks}
    present = {law.family for law in laws}
    for name, color, marker in (look for family, look in _FAMILIES.items() if family in present):
        found[name] = {"color": color} if lines else {"color": color, "marker": marker}
    line: Any = "-" if lines else "none"
    handles, words = [Line2D([], [], markersize=4, linestyle=line, **how) for how in found.values()], [*found]
    wide = sum(text_width(word, 6.5) + (0.5 if lines else 0.3) for word in words)
    rows = -(-wide // (figure.get_size_inches()[0] - 0.2))
    look: dict[str, Any] = {"fontsize": 6.5, "handletextpad": 0.6 if lines else 0.1, "columnspacing": 1.2}
    figure.legend(handles, words, loc="outside upper center", ncol=-(-len(words) // int(rows)), **look)
