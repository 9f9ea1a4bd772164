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
_GAP = 0.7  # between columns, in which wires run
_PAD = 0.08


def plot_tree(tree: Tree) -> Figure:
    """Draw a tree: its inputs on the left, each system as a box with its ports and rules, its outputs on the right.

    A system stands in a column to the right of all from which it takes something. The wires of one output or input have
    one colour.

    Args:
        tree: The tree.
    """
    columns: list[list[str]] = []
    depth = _depths(tree)
    for name in tree.order:
        while len(columns) <= depth[name]:
            columns.append([])
        columns[depth[name]].append(name)
    heights = [sum(_height(tree, name) for name in column) for column in columns]
    whole = max(*heights, _ROW * 2 * len(tree.inputs), _ROW * 2 * len(tree.outputs))
    labels = [v.label for v in tree.inputs], [v.label for v in tree.outputs]
    left, right = (max(_width(label) for label in each) + _PAD for each in labels)
    widths = [max(_box_width(tree, name) for name in column) for column in columns]
    width = left + right + sum(widths) + _GAP * (len(columns) + 1) + 2 * _PAD
    with styled_figure(width, whole + 2 * _PAD, constrained=False) as figure:
        ax = figure.add_axes((0, 0, 1, 1))
        # One unit is one inch, with y downward.
        ax.set(xlim=(0, width), ylim=(whole + _PAD, -_PAD))
        ax.axis("off")
        at: dict[str, tuple[float, float]] = {}  # where the value of a port comes from
        for k, label in enumerate(labels[0]):
            at[tree.columns[k]] = left + _PAD, whole * (k + 0.5) / len(labels[0])
            _say(ax, left, at[tree.columns[k]][1], label, "right")
        x, wires = left + _PAD + _GAP, []
        for column, wide, high in zip(columns, widths, heights, strict=True):
            y = (whole - high) / 2
            for name in column:
                at |= _draw_system(ax, tree, name, x, y, wide)
                wires += [(tree.columns[k], (x, y + _ROW * (r + 1.75))) for r, k in enumerate(_wires(tree, name))]
                y += _height(tree, name)
            x += wide + _GAP
        for k, (port, label) in enumerate(zip(tree.answers or (), labels[1], strict=True)):
            end = x, whole * (k + 0.5) / len(labels[1])
            wires.append((port, end))
            _say(ax, x + _PAD, end[1], label, "left")
        for port, end in wires:
            _draw_wire(ax, at[port], end, COLORS[tree.columns.index(port) % len(COLORS)])
        return figure


def _depths(tree: Tree) -> dict[str, int]:
    """The column of each system: 0, or one more than the greatest of those from which it takes something."""
    depth: dict[str, int] = {}
    for name in tree.order:
        ports = [tree.columns[k] for k in _wires(tree, name) if k >= len(tree.inputs)]
        depth[name] = max((depth[port.partition("/")[0]] + 1 for port in ports), default=0)
    return depth


def _wires(tree: Tree, name: str) -> tuple[int, ...]:
    return tree.wires[tree.order.index(name)]


def _height(tree: Tree, name: str) -> float:
    """That of a system's box and of the space about it."""
    fis = tree.systems[name]
    return _ROW * (max(len(fis.inputs), len(fis.outputs)) + 2.5)


def _width(text: str) -> float:
    return min(text_width(text, _SIZE), _WIDEST)


def _box_width(tree: Tree, name: str) -> float:
    fis = tree.systems[name]
    takes, gives = (max(_width(v.name) for v in variables) for variables in (fis.inputs, fis.outputs))
    return max(takes + gives + 4 * _PAD, _width(_title(tree, name)) + 2 * _PAD)


def _title(tree: Tree, name: str) -> str:
    return f"{name}: {counted(len(tree.systems[name].rules), 'rule')}"


def _draw_system(ax: Axes, tree: Tree, name: str, x: float, y: float, width: float) -> dict[str, tuple[float, float]]:
    """Draw a box below ``y``; return where its outputs leave it."""
    fis, found = tree.systems[name], dict[str, tuple[float, float]]()
    height = _height(tree, name) - _ROW
    box = FancyBboxPatch((x, y + _ROW / 2), width, height, boxstyle="round,pad=0", facecolor="0.95", edgecolor="0.2")
    ax.add_patch(box).set_zorder(3)
    _say(ax, x + width / 2, y + _ROW, _title(tree, name), "center", weight="bold")
    for r, variable in enumerate(fis.inputs):
        _say(ax, x + _PAD, y + _ROW * (r + 1.75), variable.name, "left")
    for r, variable in enumerate(fis.outputs):
        found[f"{name}/{variable.name}"] = x + width, y + _ROW * (r + 1.75)
        _say(ax, x + width - _PAD, y + _ROW * (r + 1.75), variable.name, "right")
    return found


def _say(ax: Axes, x: float, y: float, text: str, side: str, weight: str = "normal") -> None:
    text = shortened(text, _WIDEST, _SIZE)
    ax.text(x, y, text, ha=side, va="center", fontsize=_SIZE, weight=weight, parse_math=False, zorder=4)


def _draw_wire(ax: Axes, start: tuple[float, float], end: tuple[float, float], color: str) -> None:
    """A line that leaves and comes horizontally, behind the boxes."""
    (x, y), (u, v) = start, end
    bend = max(_GAP, (u - x) / 2)
    path = Path([(x, y), (x + bend, y), (u - bend, v), (u, v)], [Path.MOVETO, *[Path.CURVE4] * 3])
    ax.add_patch(PathPatch(path, facecolor="none", edgecolor=color, linewidth=0.9, zorder=2))
