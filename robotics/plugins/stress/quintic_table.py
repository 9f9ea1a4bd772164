"""Tables of quintic paths, made quickly: for thousands of random paths."""

import math
from itertools import pairwise

import numpy as np

from fuzzy.compiled.jit import kernel
from robotics.world.paths.path import PathColumns, Quintic

_ROWS = PathColumns.size
_SPACING = 0.02  # m: between nodes, at most
_CELLS = 800  # of the parameter, between which the length is measured


def quintic_table(shape: Quintic) -> np.ndarray:
    """Make the table of :class:`robotics.world.paths.path.Path` for a quintic, to about 1e-6 m.

    :func:`robotics.world.paths.path.compile_path` is slower and more exact.
    """
    return tabulated(coefficients(shape)[None])[0]


def tabulated(shapes: np.ndarray) -> list[np.ndarray]:
    """The tables of :func:`quintic_table` of quintics by their :func:`coefficients` (quintics, 2, 5)."""
    speed, measured = _measured(shapes)
    ends = np.cumsum(np.maximum(32, np.ceil(measured[:, -1] / _SPACING)).astype(np.int64) + 1)
    found, (dx, dy, cross) = np.empty(_ROWS * ends[-1]), np.empty((3, ends[-1]))
    _place_nodes(shapes, speed, measured, ends, found, dx, dy, cross)
    # By numpy, not in the compiled function: their last bits are others, and crossings shall stay what they were.
    _finish(ends, np.arctan2(dy, dx), cross / np.hypot(dx, dy) ** 3, found)
    spans = pairwise([0, *(_ROWS * ends).tolist()])
    return [found[first:end].reshape(_ROWS, -1) for first, end in spans]


def coefficients(shape: Quintic) -> np.ndarray:
    """The coefficients (2, 5) of x and y: those of 1, u, u³, u⁴ and u⁵; there is none of u²."""
    run = shape.end[0] - shape.start[0]
    found = np.empty((2, 5))
    first = shape.start_tangent or (run, run * shape.start_slope)
    last = shape.end_tangent or (run, run * shape.end_slope)
    for axis in range(2):
        fill(found[axis], shape.start[axis], shape.end[axis], first[axis], last[axis])
    return found


@kernel
def fill(row, start, end, first, last):  # type: ignore[no-untyped-def]
    """Fill in the coefficients (5,) of one axis by its ends [m], and the tangents there [m]."""
    gap = end - start
    row[0], row[1] = start, first
    row[2], row[3] = 10 * gap - 6 * first - 4 * last, -15 * gap + 8 * first + 7 * last
    row[4] = 6 * gap - 3 * first - 3 * last


@kernel
def place(row, u):  # type: ignore[no-untyped-def]
    """One axis [m] at the parameter u."""
    return row[0] + u * (row[1] + u * u * (row[2] + u * (row[3] + u * row[4])))


@kernel
def slope(row, u):  # type: ignore[no-untyped-def]
    """Its first derivative by u [m]."""
    return row[1] + u * u * (3 * row[2] + u * (4 * row[3] + u * 5 * row[4]))


@kernel
def bend(row, u):  # type: ignore[no-untyped-def]
    """Its second derivative by u [m]."""
    return u * (6 * row[2] + u * (12 * row[3] + u * 20 * row[4]))


@kernel(nogil=True)
def _measured(shapes):  # type: ignore[no-untyped-def]
    """|p'| at equal steps of the parameter, and the length up to there, both (quintics, _CELLS + 1)."""
    h = 1 / _CELLS
    speeds, lengths = np.empty((len(shapes), _CELLS + 1)), np.empty((len(shapes), _CELLS + 1))
    for n in range(len(shapes)):
        x, y, speed, measured = shapes[n, 0], shapes[n, 1], speeds[n], lengths[n]
        for k in range(_CELLS + 1):
            speed[k] = math.hypot(slope(x, _node(k)), slope(y, _node(k)))
        # Simpson's rule over pairs of steps, and its half-step form between
        measured[0] = 0.0
        for k in range(0, _CELLS, 2):
            a, b, c = speed[k], speed[k + 1], speed[k + 2]
            measured[k + 1] = measured[k] + h / 12 * (5 * a + 8 * b - c)
            measured[k + 2] = measured[k + 1] + h / 12 * (-a + 8 * b + 5 * c)
    return speeds, lengths


@kernel(nogil=True)
def _place_nodes(shapes, speeds, lengths, ends, found, slopes_x, slopes_y, cross):  # type: ignore[no-untyped-def]
    """Fill in the places at equal shares of the length, and of them p' and p' × p'' (nodes of all,).

    ``ends`` are where the nodes of each end; the tables are one after the other in ``found``.
    """
    h, first = 1 / _CELLS, 0
    for n in range(len(shapes)):
        x, y, speed, measured = shapes[n, 0], shapes[n, 1], speeds[n], lengths[n]
        table, length, cells, k = _table(found, first, ends[n]), measured[_CELLS], ends[n] - first - 1, 0
        for m in range(cells + 1):
            s = m * (length / cells) if m < cells else length
            while k < _CELLS - 1 and measured[k + 1] <= s:
                k += 1
            u = (_node(k + 1) - _node(k)) / (measured[k + 1] - measured[k]) * (s - measured[k]) + _node(k)
            for _ in range(2):  # Newton, the speed taken linearly between the samples
                c = min(max(int(u / h), 0), _CELLS - 1)
                t = u - _node(c)
                here = measured[c] + t * (speed[c] + (speed[c + 1] - speed[c]) * t / (2 * h))
                u = min(max(u + (s - here) / _speed_at(speed, c, u), 0.0), 1.0)
            dx, dy = slope(x, u), slope(y, u)
            node = PathColumns(table, m)
            node.x, node.y, node.u = place(x, u), place(y, u), u
            slopes_x[first + m], slopes_y[first + m] = dx, dy
            cross[first + m] = dx * bend(y, u) - dy * bend(x, u)
        first = ends[n]


@kernel
def _table(found, first, end):  # type: ignore[no-untyped-def]
    return found[_ROWS * first : _ROWS * end].reshape((_ROWS, end - first))


@kernel
def _node(k):  # type: ignore[no-untyped-def]
    return k * (1 / _CELLS) if k < _CELLS else 1.0


@kernel
def _speed_at(speed, k, u):  # type: ignore[no-untyped-def]
    """The speed at a parameter, linear between the nodes; ``k`` is about the node before it."""
    while k > 0 and u < _node(k):
        k -= 1
    while k < _CELLS and u >= _node(k + 1):
        k += 1
    if k == _CELLS:
        return speed[k]
    return (speed[k + 1] - speed[k]) / (_node(k + 1) - _node(k)) * (u - _node(k)) + speed[k]


@kernel(nogil=True)
def _finish(ends, angles, curvatures, found):  # type: ignore[no-untyped-def]
    """Fill in the headings, ``angles`` [rad] as numpy.unwrap makes them continuous, and the ``curvatures`` [1/m]."""
    first = 0
    for end in ends:
        nodes, turns = PathColumns(_table(found, first, end)), 0.0
        nodes.heading[0] = angles[first]
        for k in range(1, end - first):
            step = angles[first + k] - angles[first + k - 1]
            if abs(step) >= math.pi:
                rest = (step + math.pi) % (2 * math.pi) - math.pi
                turns += (math.pi if rest == -math.pi and step > 0 else rest) - step
            nodes.heading[k] = angles[first + k] + turns
        nodes.curvature[:] = curvatures[first:end]
        first = end
