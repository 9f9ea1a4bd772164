"""Small tables and line drawings as HTML: what a notebook shows of an object, in the notebook's own colours."""

import math
from collections.abc import Sequence
from html import escape

from fuzzy.shown import typeset

Point = tuple[float, float]
_DASHES = ("", "5 2", "1.5 1.5", "7 2 1.5 2")  # lines are told apart without colours


def titled(title: str, about: str, *parts: str) -> str:
    """Parts, already HTML, below a title and what is said of it."""
    return f"<div><b>{escape(title)}</b> {escape(typeset(about))}{''.join(parts)}</div>"


def table(head: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    """A table of texts, without a head if that is empty; a cell that begins with ``<svg`` is one of :func:`lines`."""
    cells = [[c if c.startswith("<svg ") else escape(typeset(c)) for c in row] for row in rows]
    style = ' style="text-align: left; vertical-align: middle; padding: 2px 10px 2px 0"'
    body = "".join(f"<tr>{''.join(f'<td{style}>{cell}</td>' for cell in row)}</tr>" for row in cells)
    heads = f"<thead><tr>{''.join(f'<th{style}>{escape(h)}</th>' for h in head)}</tr></thead>" if head else ""
    return f'<table style="color: inherit; font-size: inherit">{heads}<tbody>{body}</tbody></table>'


def lines(
    curves: Sequence[Sequence[Point]], thin: Sequence[Sequence[Point]] = (), *, size: Point, equal: bool = False
) -> str:
    """A drawing of curves, each with dashes of its own, over thin pale ones; y points upwards.

    Args:
        curves: Points (x, y) of each curve; a point that is not finite is left out.
        thin: Likewise, of what is drawn below.
        size: The width and the height, in pixels.
        equal: Whether both axes have one scale, as a map has.
    """
    points = [p for curve in (*curves, *thin) for p in curve if all(map(math.isfinite, p))]
    if not points:
        return ""
    low, high = ([f(p[axis] for p in points) for axis in (0, 1)] for f in (min, max))
    scale = [(size[axis] - 6) / ((high[axis] - low[axis]) or 1.0) for axis in (0, 1)]
    if equal:
        scale = [min(scale)] * 2
    height = min(size[1], (high[1] - low[1]) * scale[1] + 6) if equal else size[1]

    def line(curve: Sequence[Point], style: str) -> str:
        places = (
            f"{3 + (x - low[0]) * scale[0]:.1f},{height - 3 - (y - low[1]) * scale[1]:.1f}"
            for x, y in curve
            if math.isfinite(x) and math.isfinite(y)
        )
        return f'<polyline points="{" ".join(places)}" {style}/>'

    drawn = [line(curve, 'stroke-width="1" opacity="0.4"') for curve in thin]
    drawn += [
        line(curve, f'stroke-width="1.5" stroke-dasharray="{_DASHES[k % len(_DASHES)]}"')
        for k, curve in enumerate(curves)
    ]
    return (
        f'<svg width="{size[0]:g}" height="{height:.0f}" viewBox="0 0 {size[0]:g} {height:.0f}" fill="none" '
        f'stroke="currentColor" role="img">{"".join(drawn)}</svg>'
    )
