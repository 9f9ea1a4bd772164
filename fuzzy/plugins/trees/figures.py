"""The picture of a tree: its systems from left to right, and the wires between their ports."""

from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import FancyBboxPatch, PathPatch
from matplotlib.path import Path

from fuzzy.figures.drawing import shortened, styled_figure, text_width
from fuzzy.figures.palette import COLORS
from fuzzy.plugins.trees.tree import Tree
from fuzzy.words import counted

_SIZE = 7.0  # the size of the names, in points
_ROW = 0.2  # the height of a row, in inches
_WIDEST = 1.3  # the width of the widest name, in inches; longer ones are shortened
_GAP = 0.7  # between columns, in which wires bend
_PAD = 0.08

_Point = tuple[float, float]


def plot_tree(tree: Tree) -> Figure:
    """Draw a tree: its inputs on the left, each system as a box with its ports and rules, its outputs on the right.

    A system stands in a column to the right of all from which it takes something. A wire has the colour of the port
    from which it comes, and passes beside the boxes of systems that do not take it.

    Args:
        tree: The tree.
    """
    takes = dict(zip(tree.order, tree.wires, strict=True))
    begin = dict.fromkeys(range(len(tree.inputs)), -1)  # by the value's number: the column that it comes from
    columns: dict[str, int] = {}  # of each system
    for name in tree.order:
        columns[name] = max(begin[k] for k in takes[name]) + 1
        begin |= {len(begin) + k: columns[name] for k in range(len(tree.systems[name].outputs))}
    count = max(columns.values()) + 1
    end = {k: max([columns[n] for n in takes if k in takes[n]], default=0) for k in begin}
    end |= dict.fromkeys(tree.answer_columns, count)
    items: list[list[str | int]] = [
        [n for n in tree.order if columns[n] == c] + [k for k in begin if begin[k] < c < end[k]] for c in range(count)
    ]
    tall = max(sum(_height(tree, item) for item in column) for column in items)
    tall = max(tall, 1.5 * _ROW * len(tree.inputs), 1.5 * _ROW * len(tree.outputs))
    left, right = (max(_width(v.label) for v in ends) + 2 * _PAD for ends in (tree.inputs, tree.outputs))
    widths = [max(_box_width(tree, n) for n in tree.order if columns[n] == c) for c in range(count)]
    width = left + right + sum(widths) + _GAP * (count + 1)
    with styled_figure(width, tall + 2 * _PAD, constrained=False) as figure:
        ax = figure.add_axes((0, 0, 1, 1))
        # One unit is one inch, with y downward.
        ax.set(xlim=(0, width), ylim=(tall + _PAD, -_PAD))
        ax.axis("off")
        at: dict[int, _Point] = {}  # where the wire of a value has come
        for k, v in enumerate(tree.inputs):
            at[k] = left, tall * (k + 0.5) / len(tree.inputs)
            _say(ax, left - _PAD, at[k][1], v.label, "right")
        x = left + _GAP
        for c, column in enumerate(items):
            # What takes from above stands above.
            sources = {i: [at[k][1] for k in (takes[i] if isinstance(i, str) else [i])] for i in column}
            y = (tall - sum(_height(tree, item) for item in column)) / 2
            new: dict[int, _Point] = {}
            for item in sorted(column, key=lambda i: sum(sources[i]) / len(sources[i])):
                if isinstance(item, int):
                    new[item] = x + widths[c], y + _ROW / 2
                    _draw_wire(ax, item, at[item], (x, y + _ROW / 2), new[item])
                else:
                    given = [k for k in begin if tree.columns[k].startswith(f"{item}/") and begin[k] == c]
                    leave = _draw_system(ax, tree, item, (x, y), widths[c])
                    new |= dict(zip(given, leave, strict=True))
                    for r, k in enumerate(takes[item]):
                        _draw_wire(ax, k, at[k], (x, y + _ROW * (r + 1.75)))
                y += _height(tree, item)
            at |= new
            x += widths[c] + _GAP
        for o, (k, v) in enumerate(zip(tree.answer_columns, tree.outputs, strict=True)):
            place = x, tall * (o + 0.5) / len(tree.outputs)
            _draw_wire(ax, k, at[k], place)
            _say(ax, x + _PAD, place[1], v.label, "left")
        return figure


def _height(tree: Tree, item: str | int) -> float:
    """That of a system's box and the space about it, or of a wire that passes."""
    if isinstance(item, int):
        return _ROW
    return _ROW * (max(len(tree.systems[item].inputs), len(tree.systems[item].outputs)) + 2.25)


def _width(text: str) -> float:
    return min(text_width(text, _SIZE), _WIDEST)


def _box_width(tree: Tree, name: str) -> float:
    fis = tree.systems[name]
    takes, gives = (max(_width(v.name) for v in variables) for variables in (fis.inputs, fis.outputs))
    return max(takes + gives + 4 * _PAD, _width(_title(tree, name)) + 4 * _PAD)


def _title(tree: Tree, name: str) -> str:
    return f"{name}: {counted(len(tree.systems[name].rules), 'rule')}"


def _draw_system(ax: Axes, tree: Tree, name: str, corner: _Point, width: float) -> list[_Point]:
    """Draw a box below and to the right of ``corner``; return where its outputs leave it."""
    (x, y), fis, height = corner, tree.systems[name], _height(tree, name) - _ROW / 2
    box = FancyBboxPatch((x, y + _ROW / 4), width, height, "round,pad=0", facecolor="0.95", edgecolor="0.2", zorder=3)
    ax.add_patch(box)
    _say(ax, x + width / 2, y + _ROW * 0.85, _title(tree, name), "center", weight="bold")
    for variables, place, side in ((fis.inputs, x + _PAD, "left"), (fis.outputs, x + width - _PAD, "right")):
        for r, variable in enumerate(variables):
            _say(ax, place, y + _ROW * (r + 1.75), variable.name, side)
    return [(x + width, y + _ROW * (r + 1.75)) for r in range(len(fis.outputs))]


def _say(ax: Axes, x: float, y: float, text: str, side: str, weight: str = "normal") -> None:
    text = shortened(text, _WIDEST, _SIZE)
    ax.text(x, y, text, ha=side, va="center", fontsize=_SIZE, weight=weight, parse_math=False, zorder=4)


def _draw_wire(ax: Axes, value: int, start: _Point, end: _Point, straight: _Point | None = None) -> None:
    """A line that leaves and comes horizontally, and goes on straight if it has to pass."""
    middle = (start[0] + end[0]) / 2
    points, codes = [start, (middle, start[1]), (middle, end[1]), end], [Path.MOVETO, *[Path.CURVE4] * 3]
    if straight is not None:
        points, codes = [*points, straight], [*codes, Path.LINETO]
    color = COLORS[value % len(COLORS)]
    ax.add_patch(PathPatch(Path(points, codes), facecolor="none", edgecolor=color, linewidth=0.9, zorder=2))
