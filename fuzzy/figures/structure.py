"""The structure of a system as the network of [Jang 1993]: inputs, terms, rules, shares, consequents, outputs."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Circle, FancyBboxPatch

from fuzzy.figures.drawing import number, shortened, styled_figure, text_width
from fuzzy.figures.palette import COLORS
from fuzzy.system import Sugeno

_SIZE = 7.0  # the size of the names, in points
_ROW = 0.24  # the height of a row, in inches
_BOX = 0.17  # the height of a box
_WIDEST = 1.3  # the width of the widest box, in inches; longer names are shortened
_FEW = 4  # up to this number of rules each has its own node of the third layer, as in the paper; of more they hide all


@dataclass(frozen=True)
class _Node:
    x: float  # the center, in inches
    y: float
    half: float  # half its width


def plot_structure(fis: Sugeno) -> Figure:
    """Draw the system as a network of six layers, from the inputs on the left to the outputs on the right.

    A term is joined to the rules that name it; a dashed line is a "not". A rule is marked by its operation (Π for
    the product, min, or) and its number, and by its weight if that is not 1. Up to four rules have a
    normalising node each; more share one box.

    Args:
        fis: The system.
    """
    s = fis.structure
    rules = len(fis.rules)
    terms = [(i, t) for i, v in enumerate(fis.inputs) for t in range(len(v.terms))]
    consequents = [(j, t) for j in range(len(fis.outputs)) for t in range(len(fis.outputs[j].terms))]
    # A consequent that several rules share is one node; they stand in the order of the rules that use them.
    first = {
        (j, t): next((r for r in range(rules) if s.consequent[j, r] == t), rules + n)
        for n, (j, t) in enumerate(consequents)
    }
    consequents.sort(key=lambda node: (node[0], first[node]))
    columns = [
        [v.name for v in fis.inputs],
        [list(fis.inputs[i].terms)[t] for i, t in terms],
        [_operation(fis, r) for r in range(rules)],
        ["N"] * rules,
        [list(fis.outputs[j].terms)[t] for j, t in consequents],
        [v.name for v in fis.outputs],
    ]
    rows = max(len(column) for column in columns)
    height = rows * _ROW
    bundles = rules > _FEW
    edges = [len(terms), rules, rules, rules, len(consequents)]
    gaps = [min(1.1, 0.45 + 0.03 * n) for n in edges]
    gaps[2] = 0.35 if bundles else min(0.9, 0.4 + 0.04 * rules)
    halves = [
        max((min(text_width(name, _SIZE) + 0.12, _WIDEST) / 2 for name in column), default=0.1) for column in columns
    ]
    halves[3] = 0.11
    left, head, foot = 0.15, 0.45, 0.08
    centers = [left + halves[0]]
    for c in range(1, 6):
        centers.append(centers[-1] + halves[c - 1] + gaps[c - 1] + halves[c])
    # The titles of two columns must not meet either.
    titles = ["inputs", "terms", "rules", "shares", "consequents", "outputs"]
    symbols = ["x", "μ", "w", "w / Σw", "f", "y"]
    for c in range(1, 6):
        apart = (text_width(titles[c - 1], 8) + text_width(titles[c], 8)) / 2 + 0.12
        centers[c:] = [x + max(0.0, apart - (centers[c] - centers[c - 1])) for x in centers[c:]]
    width = centers[-1] + max(halves[-1], text_width(titles[-1], 8) / 2) + 0.15
    with styled_figure(width, head + height + foot, constrained=False) as figure:
        ax = figure.add_axes((0, 0, 1, 1))
        # One unit is one inch, with y downward from the first row.
        ax.set(xlim=(0, width), ylim=(height + foot, -head))
        ax.axis("off")
        nodes = [
            [_Node(x, (n + 0.5) * (height / len(column)), half) for n in range(len(column))]
            for column, x, half in zip(columns, centers, halves, strict=True)
        ]
        _edges(ax, fis, nodes, terms, consequents, bundles)
        _boxes(ax, nodes[0], columns[0], ["0.9"] * len(nodes[0]))
        _boxes(ax, nodes[1], columns[1], [_tint(COLORS[t % len(COLORS)]) for _, t in terms])
        _boxes(ax, nodes[2], columns[2], ["white"] * rules)
        if bundles:
            top, bottom = nodes[3][0].y - _BOX / 2, nodes[3][-1].y + _BOX / 2
            _box(ax, centers[3], (top + bottom) / 2, 0.11, bottom - top, "white")
            ax.text(centers[3], (top + bottom) / 2, "normalised: w / Σw", rotation=90, ha="center", va="center")
        else:
            for node in nodes[3]:
                ax.add_patch(Circle((node.x, node.y), 0.1, facecolor="white", edgecolor="0.2", zorder=3))
                ax.text(node.x, node.y, "N", ha="center", va="center", fontsize=_SIZE, zorder=4)
        _boxes(ax, nodes[4], columns[4], ["white"] * len(nodes[4]))
        _boxes(ax, nodes[5], columns[5], ["0.9"] * len(nodes[5]))
        for x, title, symbol in zip(centers, titles, symbols, strict=True):
            ax.text(x, -0.26, title, ha="center", va="baseline", fontsize=8)
            ax.text(x, -0.1, symbol, ha="center", va="baseline", fontsize=_SIZE, color="0.4", style="italic")
        return figure


def _operation(fis: Sugeno, r: int) -> str:
    rule = fis.rules[r]
    sign = "or" if rule.connective == "or" and len(rule.when) > 1 else "Π" if fis.and_method == "prod" else "min"
    weight = f" ×{number(float(fis.structure.weight[r]))}" if rule.weight != 1 else ""
    return f"{sign} {r + 1}{weight}"


def _edges(
    ax: Axes,
    fis: Sugeno,
    nodes: Sequence[Sequence[_Node]],
    terms: Sequence[tuple[int, int]],
    consequents: Sequence[tuple[int, int]],
    bundles: bool,
) -> None:
    s = fis.structure
    inputs, labels, rules, shares, proposals, outputs = nodes
    for place, (i, t) in enumerate(terms):
        color = COLORS[t % len(COLORS)]
        used: list[int] = np.flatnonzero(s.term[i] == t).tolist()
        _line(ax, inputs[i], labels[place], "0.6" if used else "0.85")
        for r in used:
            _line(ax, labels[place], rules[r], color, "--" if s.negated[i, r] else "-")
    for r in range(len(rules)):
        if bundles:
            _line(ax, rules[r], shares[r], "0.6")
        else:
            for share in shares:
                _line(ax, rules[r], share, "0.6" if share is shares[r] else "0.8")
    for place, (j, t) in enumerate(consequents):
        used = np.flatnonzero(s.consequent[j] == t).tolist()
        for r in used:
            _line(ax, shares[r], proposals[place], COLORS[j % len(COLORS)])
        if used:
            _line(ax, proposals[place], outputs[j], COLORS[j % len(COLORS)])


def _line(ax: Axes, start: _Node, end: _Node, color: str, line: str = "-") -> None:
    ax.plot(
        [start.x + start.half, end.x - end.half], [start.y, end.y], color=color, linestyle=line, linewidth=0.6, zorder=1
    )


def _boxes(ax: Axes, nodes: Sequence[_Node], names: Sequence[str], colors: Sequence[str]) -> None:
    for node, name, color in zip(nodes, names, colors, strict=True):
        _box(ax, node.x, node.y, node.half, _BOX, color)
        text = shortened(name, 2 * node.half - 0.06, _SIZE)
        ax.text(node.x, node.y, text, ha="center", va="center", fontsize=_SIZE, parse_math=False, zorder=4)


def _box(ax: Axes, x: float, y: float, half: float, height: float, color: str) -> None:
    pad = 0.03
    ax.add_patch(
        FancyBboxPatch(
            (x - half + pad, y - height / 2 + pad),
            2 * (half - pad),
            height - 2 * pad,
            boxstyle=f"round,pad={pad}",
            facecolor=color,
            edgecolor="0.2",
            zorder=3,
        )
    )


def _tint(color: str) -> str:
    """The colour mixed with white, light enough for black text."""
    channels = [int(color[k : k + 2], 16) for k in (1, 3, 5)]
    return "#" + "".join(f"{round(255 - 0.3 * (255 - c)):02x}" for c in channels)
