"""Pictures of the terms of variables: membership functions of inputs, consequents of outputs."""

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import to_rgb
from matplotlib.figure import Figure

from fuzzy.detached import detached
from fuzzy.figures.drawing import COLUMN, DOUBLE, figure_of, line_look, new_figure, shortened, style, text_width
from fuzzy.figures.palette import COLORS
from fuzzy.insight.universe import consequent_range, place_of, universe_grid
from fuzzy.system import FuzzySystemError, Linear, Sugeno, Variable

_SIZE = 7.0  # the size of the labels, in points
_LINE = 0.135  # the height of a line of labels, in inches
_PANEL = 2.6  # the width of a panel's axes, about, in inches
_ROWS = 3  # rows of labels above the curves, at most; beyond that a legend is easier to read


class _Label(NamedTuple):
    place: float  # in the unit of the variable
    text: str
    color: str


def plot_memberships(fis: Sugeno, variable: str | int | None = None, ax: Axes | None = None) -> Figure:
    """Draw the terms of one variable, or of all inputs and outputs, one panel each.

    Each input term's degree of membership is a curve with its name on it. Constants of an output are stems; a linear
    consequent is a bar from its lowest to its highest value over the inputs' universes.

    Args:
        fis: The system.
        variable: A variable by its name, or by its place among the inputs followed by the outputs; None draws all.
        ax: The axes to draw on, for a single variable.

    Raises:
        FuzzySystemError: A variable that does not exist, or ``ax`` without a variable.
    """
    fis = detached(fis)
    everything = [*fis.inputs, *fis.outputs]
    if ax is not None and variable is None and len(everything) > 1:
        raise FuzzySystemError("one axes shows one variable; name it")
    chosen = range(len(everything)) if variable is None else [place_of(variable, everything, "variable")]
    with style():
        if ax is not None:
            _draw(ax, fis, chosen[0])
            return figure_of(ax)
        bars = [k for k in chosen if k >= len(fis.inputs) and _as_bars(fis, everything[k])]
        legends = [k for k in chosen if k < len(fis.inputs) and not _labels_fit(everything[k])]
        plain = [k for k in chosen if k not in bars and k not in legends]
        # Rows of bars may be tall and share no row with the others; a legend takes half a row itself.
        rows = [plain[n : n + 2] for n in range(0, len(plain), 2)]
        rows += [[k] for k in legends] + [bars[n : n + 2] for n in range(0, len(bars), 2)]
        columns = 2 if legends else max(len(row) for row in rows)
        heights = [max(_height(fis, k) for k in row) for row in rows]
        figure = new_figure(DOUBLE if columns == 2 else COLUMN, sum(heights))
        grid = figure.add_gridspec(len(rows), columns, height_ratios=heights)
        panels = [
            (figure.add_subplot(grid[r, :] if len(row) == 1 and k not in plain else grid[r, c]), k)
            for r, row in enumerate(rows)
            for c, k in enumerate(row)
        ]
        for axes, k in panels:
            _label_axes(axes, everything[k], k not in bars)
        # The labels are placed by the size that the panels get.
        figure.draw_without_rendering()
        for axes, k in panels:
            _draw(axes, fis, k)
        return figure


def _draw(ax: Axes, fis: Sugeno, k: int) -> None:
    if k < len(fis.inputs):
        _curves(ax, fis.inputs[k])
        return
    output = fis.outputs[k - len(fis.inputs)]
    if _as_bars(fis, output):
        _bars(ax, fis, output)
    else:
        _stems(ax, fis, output)


def _height(fis: Sugeno, k: int) -> float:
    if k < len(fis.inputs) or not _as_bars(fis, output := fis.outputs[k - len(fis.inputs)]):
        return 1.75
    return max(1.75, 0.6 + 0.125 * len(output.terms))


def _as_bars(fis: Sugeno, output: Variable) -> bool:
    """Is the output drawn as rows of bars? With linear consequents, or too many names to stand over stems."""
    if any(_slopes(term) for term in output.terms.values()):
        return True
    return _rows(_stem_labels(output), *_span(fis, output), _PANEL) is None


def _labels_fit(variable: Variable) -> bool:
    return _rows(_curve_labels(variable, universe_grid(variable)), *variable.universe, _PANEL) is not None


def _slopes(term: Any) -> bool:
    return isinstance(term, Linear) and any(slope != 0 for slope in term.slopes)


def _label_axes(ax: Axes, variable: Variable, upright: bool) -> None:
    ax.set_xlabel(variable.label, parse_math=False)
    if upright:
        ax.set_ylim(0, 1.2)
        ax.set_yticks([0, 0.5, 1])
        ax.set_ylabel("degree")


def _curves(ax: Axes, variable: Variable) -> None:
    x = universe_grid(variable)
    for n, (name, function) in enumerate(variable.terms.items()):
        degree = np.asarray(function(x))
        # The zeros of all terms lie on one line, where they would only hide each other.
        zero = np.pad(degree == 0, 1, constant_values=True)
        shown = np.where(zero[:-2] & zero[1:-1] & zero[2:], np.nan, degree)
        ax.plot(x, shown, **line_look(n), label=name, clip_on=False, zorder=2.5)
    _finish(ax, variable, _curve_labels(variable, x), *variable.universe)


def _curve_labels(variable: Variable, x: np.ndarray) -> list[_Label]:
    labels = []
    for n, (name, function) in enumerate(variable.terms.items()):
        degree = np.asarray(function(x))
        top = degree.max()
        # The middle of the first plateau, if it is not a single peak.
        highest = np.flatnonzero(degree >= top - 1e-6)
        plateau = highest[: 1 + int(np.argmax(np.append(np.diff(highest) > 1, True)))]
        text = name if top > 0 else f"{name}: 0 everywhere"
        labels.append(_Label(float(x[plateau].mean()), text, COLORS[n % len(COLORS)]))
    return labels


def _stem_labels(output: Variable) -> list[_Label]:
    names: dict[float, list[str]] = {}
    for name, term in output.terms.items():
        names.setdefault(term.parameters[-1], []).append(name)
    return [_Label(value, ", ".join(same), COLORS[0]) for value, same in names.items()]


def _span(fis: Sugeno, output: Variable) -> tuple[float, float]:
    ends = [end for term in output.terms.values() for end in consequent_range(fis, term)]
    low, high = min([output.universe[0], *ends]), max([output.universe[1], *ends])
    margin = 0.04 * (high - low) or 0.5
    return low - margin, high + margin


def _stems(ax: Axes, fis: Sugeno, output: Variable) -> None:
    labels = _stem_labels(output)
    for label in labels:
        ax.plot([label.place] * 2, [0, 1], color=label.color, linestyle="-", clip_on=False)
        ax.plot([label.place], [1], marker="o", color=label.color, clip_on=False)
    _finish(ax, output, labels, *_span(fis, output))
    _mark_universe(ax, output)
    ax.set_yticks([])
    ax.set_ylabel("")
    ax.spines["left"].set_visible(False)


def _bars(ax: Axes, fis: Sugeno, output: Variable) -> None:
    names = list(output.terms)
    for row, term in enumerate(output.terms.values()):
        low, high = consequent_range(fis, term)
        ax.plot([low, high], [row, row], color=COLORS[0], linestyle="-", linewidth=2.5, solid_capstyle="butt")
        middle = (low + high) / 2
        ax.plot([middle], [row], marker="o", color=COLORS[0], clip_on=False)
    ax.set_xlim(*_span(fis, output))
    ax.set_ylim(len(names) - 0.4, -0.6)
    ax.set_yticks(range(len(names)), [shortened(name, 1.1, _SIZE) for name in names])
    for tick in ax.get_yticklabels():
        tick.set_parse_math(False)
    ax.tick_params(axis="y", length=0)
    ax.set_xlabel(output.label, parse_math=False)
    _mark_universe(ax, output)


def _mark_universe(ax: Axes, output: Variable) -> None:
    low, high = output.universe
    ax.axvspan(low, high, color="0.93", linewidth=0, zorder=0)


def _finish(ax: Axes, variable: Variable, labels: Sequence[_Label], low: float, high: float) -> None:
    """Put the names above the curves, in as few lines as keep them apart; in a legend if those are too many."""
    _label_axes(ax, variable, upright=True)
    ax.set_xlim((low, high) if high > low else (low - 0.5, high + 0.5))
    low, high = ax.get_xlim()
    box, dpi = ax.get_window_extent(), figure_of(ax).dpi
    width, height = box.width / dpi, box.height / dpi
    rows = _rows(labels, low, high, width)
    if rows is None:
        ax.set_ylim(0, 1.04)
        ax.legend(loc="upper left", bbox_to_anchor=(1.0, 1.0), borderaxespad=0.2, handlelength=2.6)
        for text in ax.get_legend().get_texts():  # type: ignore[union-attr]
            text.set_parse_math(False)
        return
    count = 1 + max((row for row, _, _ in rows), default=0)
    # A line of labels is _LINE inches high: the part of the axes that is left shows degrees 0 to 1.05.
    top = 1.05 / max(1 - (count * _LINE) / height, 0.3)
    ax.set_ylim(0, top)
    ax.spines["left"].set_bounds(0, 1)
    ax.yaxis.grid(False)
    line = _LINE / height * top
    taken: list[tuple[int, float, float]] = []
    for label, (row, center, half) in sorted(zip(labels, rows, strict=True), key=lambda pair: pair[1][0]):
        y = 1.05 + row * line
        red, green, blue = to_rgb(label.color)
        ink = (0.75 * red, 0.75 * green, 0.75 * blue)  # the paler colours are hard to read as text
        ax.text(center, y, label.text, color=ink, fontsize=_SIZE, ha="center", va="bottom", parse_math=False)
        crosses = any(left <= label.place <= right for r, left, right in taken if r < row)
        if row and not crosses:
            ax.plot([label.place] * 2, [1.02, y + 0.1 * line], color=ink, linewidth=0.5, linestyle="-", clip_on=False)
        taken.append((row, center - half, center + half))


def _rows(labels: Sequence[_Label], low: float, high: float, width: float) -> list[tuple[int, float, float]] | None:
    """Each label's (row, center, half width), the latter in the unit of the variable; None for too many rows."""
    scale = (high - low) / width if high > low else 1.0  # of the variable's unit to an inch
    placed: dict[int, tuple[int, float, float]] = {}
    for n in sorted(range(len(labels)), key=lambda n: labels[n].place):
        half = (text_width(labels[n].text, _SIZE) / 2 + 0.03) * scale
        if 2 * half > high - low:
            return None
        center = min(max(labels[n].place, low + half), high - half)
        row = next(
            row
            for row in range(len(labels) + 1)
            if all(r != row or abs(center - c) >= half + h for r, c, h in placed.values())
        )
        if row >= _ROWS:
            return None
        placed[n] = row, center, half
    return [placed[n] for n in range(len(labels))]
