"""What a figure shows, as arrays: matplotlib's own annotations promise less than that."""

import numpy as np
from matplotlib.lines import Line2D
from matplotlib.path import Path


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
