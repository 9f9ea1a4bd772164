"""What a figure shows, as arrays: matplotlib's own annotations promise less than that."""

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import to_hex, to_rgb
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.path import Path

from fuzzy.figures.drawing import LINES


def x_of(line: Line2D) -> np.ndarray:
    """The line's x, in its own order."""
    return np.asarray(line.get_xdata())


def y_of(line: Line2D) -> np.ndarray:
    """The line's y, in its own order."""
    return np.asarray(line.get_ydata())


def xy_of(line: Line2D) -> np.ndarray:
    """The line's points, (points, 2)."""
    return np.asarray(line.get_xydata())


def vertices(path: Path) -> np.ndarray:
    """The path's vertices, (points, 2)."""
    return np.asarray(path.vertices)


# What has no unit: numbers of things, shares, and rows that are names
UNITLESS = (
    "",
    "degree",
    "epoch",
    "evaluations",
    "number of rules",
    "robot",
    "progress s",
    "sample",
    "samples",
    "$s_i − s_j$",
    "$s_i$ − median",
    "robots, logarithmic",
    "times the leader's mean, with the 95 % interval over the seeds",
)
_TOLERANCE = 0.02  # inches: the side bearings of letters
_BOLD = 0.7  # pt: thinner lines are of other seeds, or beside the ones that are told apart


def faults_of(figure: Figure) -> list[str]:
    """What is wrong with a figure of a report, in words; the empty list for a good one.

    Axes whose labels have no unit, what stands outside the canvas, lines of one axes that are told apart by colour
    alone, legends over lines and over panels.
    """
    figure.draw_without_rendering()
    width, height = figure.get_size_inches()
    box = figure.get_tightbbox()
    edges = {"left": box.x0, "bottom": box.y0, "right": width - box.x1, "top": height - box.y1}
    found = [f"something is {-room:.2f} in beyond the {edge}" for edge, room in edges.items() if room < -_TOLERANCE]
    for n, ax in enumerate(figure.axes):
        if not ax.get_visible() or not ax.axison:
            continue
        for label in (ax.get_xlabel(), ax.get_ylabel()):
            if "[" not in label and label.partition("\n")[0] not in UNITLESS:
                found.append(f"axes {n}: {label!r} has no unit")
        looks = {_look(line) for line in ax.lines if _is_told_apart(line)}
        if len(looks) <= len(LINES):
            for pattern in {pattern for pattern, _ in looks}:
                colors = sorted(color for other, color in looks if other == pattern)
                if len(colors) > 1:
                    found.append(f"axes {n}: {' and '.join(colors)} look alike but for the colour")
        legend = ax.get_legend()
        if legend is not None:
            area = legend.get_window_extent()
            if any(area.contains(*point) for line in ax.lines for point in _on_canvas(line, ax)):
                found.append(f"axes {n}: the legend lies over a line")
    for legend in figure.legends:
        area = legend.get_window_extent()
        if any(area.shrunk(0.98, 0.98).overlaps(ax.get_window_extent()) for ax in figure.axes if ax.axison):
            found.append("the legend of the figure lies over a panel")
    return found


def _is_told_apart(line: Line2D) -> bool:
    """Whether the line is one of several: neither thin or faint, nor grey as references and data are."""
    red, green, blue = to_rgb(line.get_color())
    grey = red == green == blue and red > 0
    bold = line.get_linewidth() >= _BOLD and line.get_alpha() in (None, 1) and line.get_linestyle() != "None"
    return bool(line.get_visible() and bold and not grey and len(x_of(line)) > 2)


def _look(line: Line2D) -> tuple[str, str]:
    """Dashes and marker of a line, and its colour."""
    return f"{line._unscaled_dash_pattern} {line.get_marker()}", to_hex(line.get_color())  # type: ignore[attr-defined]


def _on_canvas(line: Line2D, ax: Axes) -> np.ndarray:
    """The points of the line [pixels] that lie within its axes."""
    points = np.asarray(line.get_transform().transform(xy_of(line).astype(float)))
    inside = ax.get_window_extent()
    return points[[bool(np.isfinite(p).all()) and inside.contains(*p) for p in points]]
