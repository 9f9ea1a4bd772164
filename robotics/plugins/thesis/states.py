"""State diagrams of laws: the thesis's flow charts 5.24, 6.7 and 6.26, drawn from the laws' own tables.

States stand in a row. One that is linked with all others, where there are three or more, is a wide box below them.
"""

from collections.abc import Sequence
from itertools import pairwise
from typing import Any

from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import FancyArrowPatch, FancyBboxPatch

from fuzzy.figures.drawing import COLORS, DOUBLE, styled_figure, text_width
from robotics.laws.catalogue import law_title, make_controller
from robotics.laws.modes import StateBox, StateDiagram, Transition
from robotics.show.figures.drawing import PlotError

# All lengths are in inches: the axes of a diagram have this unit.
_BOX, _GAP, _TALL = 1.55, 1.18, 0.62  # a box's width, the space between two of a row, a box's height
_DROP = 0.95  # from the row to the wide box below it
_ARCH = 0.62  # over the row, for an arrow that passes a box
_APART = 0.13  # between an arrow and the one that leads back
_LARGE, _SMALL = 8.0, 6.5  # points: a state's name, and all other text
_LINE = 0.105  # height of a line of small text
_TEXT: dict[str, Any] = {"fontsize": _SMALL, "linespacing": 1.05, "parse_math": False}
_BESIDE: dict[int, Any] = {1: "bottom", -1: "top"}  # where words stand that are above an arrow, or below it


def plot_states(specifications: Sequence[str]) -> Figure:
    """Draw the state diagrams of one or more laws, one below the other.

    Args:
        specifications: The laws, as :func:`robotics.laws.catalogue.make_controller` takes them.

    Raises:
        ControllerError: A law that does not exist.
        PlotError: A law without states.
    """
    users: dict[int, tuple[StateDiagram, list[str]]] = {}  # of each diagram, by its identity
    for name in specifications:
        diagrams = make_controller(name).diagrams
        if not diagrams:
            raise PlotError(f"{name} has no states to draw")
        for diagram in diagrams:
            users.setdefault(id(diagram), (diagram, []))[1].append(law_title(name))
    drawn = sorted(users.values(), key=lambda pair: len(pair[1]))  # what several laws share comes last
    heights = [_height(diagram) for diagram, _ in drawn]
    total = sum(heights)
    with styled_figure(DOUBLE, total, constrained=False) as figure:
        top = total
        for (diagram, names), height in zip(drawn, heights, strict=True):
            ax = figure.add_axes((0.0, (top - height) / total, 1.0, height / total))
            ax.set(xlim=(0.0, DOUBLE), ylim=(0.0, height))
            ax.set_axis_off()
            ax.text(0.1, height - 0.14, "; ".join(names), fontsize=9, va="center", parse_math=False)
            _draw(ax, diagram, height)
            top -= height
        return figure


def hub_of(diagram: StateDiagram) -> int | None:
    """The code of the last state that is linked with all others, where there are three states or more."""
    codes = list(diagram.states)
    links = {(t.before, t.after) for t in diagram.transitions}
    linked = [c for c in codes if all((c, o) in links or (o, c) in links for o in codes if o != c) and len(codes) > 2]
    return linked[-1] if linked else None


def _row(diagram: StateDiagram) -> list[int]:
    hub = hub_of(diagram)
    return [code for code in diagram.states if code != hub]


def _passing(diagram: StateDiagram) -> list[Transition]:
    """The transitions between two states of the row that do not stand side by side."""
    row = _row(diagram)
    both = [t for t in diagram.transitions if t.before in row and t.after in row]
    return [t for t in both if abs(row.index(t.before) - row.index(t.after)) > 1]


def _height(diagram: StateDiagram) -> float:
    below = 0.0 if hub_of(diagram) is None else _DROP + _TALL
    return 0.5 + (_ARCH if _passing(diagram) else 0.0) + _TALL + below + 0.18


def _draw(ax: Axes, diagram: StateDiagram, height: float) -> None:
    row, hub = _row(diagram), hub_of(diagram)
    gap = _GAP if len(row) > 2 else 2.2 if hub is None else _GAP
    wide = len(row) * _BOX + (len(row) - 1) * gap
    left = (DOUBLE - wide) / 2
    middle = height - 0.42 - (_ARCH if _passing(diagram) else 0.0) - _TALL / 2
    places = {code: left + k * (_BOX + gap) + _BOX / 2 for k, code in enumerate(row)}
    for k, code in enumerate(row):
        _box(ax, diagram.states[code], places[code], middle, _BOX, COLORS[k % len(COLORS)])
    said = {(t.before, t.after): t.condition for t in diagram.transitions}
    for a, b in pairwise(row):
        near, far = places[a] + _BOX / 2, places[b] - _BOX / 2
        for pair, begin, end, way in (((a, b), near, far, 1), ((b, a), far, near, -1)):
            if pair in said:
                y = middle + way * _APART / 2
                _arrow(ax, (begin, y), (end, y))
                words = _wrapped(said[pair], gap - 0.12)
                ax.text((near + far) / 2, y + way * 0.04, words, **_TEXT, ha="center", va=_BESIDE[way])
    for t in _passing(diagram):
        begin, end = places[t.before], places[t.after]
        y, over = middle + _TALL / 2, middle + _TALL / 2 + _ARCH - 0.25
        ax.plot([begin, begin, end], [y, over, over], color="0.25", linewidth=0.9, linestyle="-", zorder=1)
        _arrow(ax, (end, over), (end, y))
        ax.text((begin + end) / 2, over + 0.04, t.condition, **_TEXT, ha="center", va="bottom")
    if hub is None:
        return
    low = middle - _TALL - _DROP
    _box(ax, diagram.states[hub], DOUBLE / 2, low, wide, COLORS[len(row) % len(COLORS)])
    for code, x in places.items():
        for pair, side in (((code, hub), -1), ((hub, code), 1)):
            if pair in said:
                at = x + side * _APART / 2
                ends = (at, middle - _TALL / 2), (at, low + _TALL / 2)
                _arrow(ax, *(ends if side < 0 else ends[::-1]))
                rim = x if side < 0 else DOUBLE - x
                words = _wrapped(said[pair], min((_BOX + gap) / 2, rim) - _APART / 2 - 0.12)
                y = (middle + low) / 2
                ax.text(at + side * 0.05, y, words, **_TEXT, ha="right" if side < 0 else "left", va="center")


def _box(ax: Axes, state: StateBox, x: float, y: float, width: float, color: Any) -> None:
    look: dict[str, Any] = {"boxstyle": "round,pad=0.04", "facecolor": "white", "linewidth": 1.2, "zorder": 2}
    corner = (x - width / 2 + 0.04, y - _TALL / 2 + 0.04)
    ax.add_patch(FancyBboxPatch(corner, width - 0.08, _TALL - 0.08, edgecolor=color, **look))
    words = _wrapped(state.does, width - 0.14)
    lines = words.count("\n") + 1
    ax.text(x, y + lines * _LINE / 2 + 0.005, state.name, fontsize=_LARGE, ha="center", va="center", zorder=3)
    ax.text(x, y - 0.075, words, **_TEXT, ha="center", va="center", zorder=3)


def _arrow(ax: Axes, begin: tuple[float, float], end: tuple[float, float]) -> None:
    look: dict[str, Any] = {"arrowstyle": "-|>", "mutation_scale": 7.0, "shrinkA": 0.0, "shrinkB": 0.0}
    ax.add_patch(FancyArrowPatch(begin, end, color="0.25", linewidth=0.9, linestyle="-", zorder=1, **look))


def _wrapped(text: str, width: float) -> str:
    """The text in lines of at most ``width`` inches."""
    lines: list[str] = []
    for word in text.split():
        longer = f"{lines[-1]} {word}" if lines else word
        if lines and text_width(longer, _SMALL) <= width:
            lines[-1] = longer
        else:
            lines.append(word)
    return "\n".join(lines)
