"""The paths of several robots in one table: points and nearest points of all robots in one compiled pass."""

import math
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any

import numpy as np

from fuzzy.compiled.jit import kernel
from robotics.world.paths.path import NodeColumns, Path, PathColumns, PathPoint, point, with_tangents


@dataclass(frozen=True)
class PathTable:
    """The paths of several robots in one table, for looking up all of them in one pass.

    Each robot has one path in all runs, or, with ``lengths`` (runs, robots), another in every run.
    """

    lengths: np.ndarray  # (robots,) or (runs, robots) m
    table: np.ndarray = field(repr=False)  # (NodeColumns, nodes of all paths): one path after the other
    first: np.ndarray = field(repr=False)  # as lengths, but flat: the column at which each begins
    cells: np.ndarray = field(repr=False)  # as lengths, but flat: the number of its nodes minus 1
    # As of Path, one for each path; None: the shares of all paths are those of their lengths
    shares: tuple[np.ndarray, ...] | None = field(default=None, repr=False)

    @property
    def paths(self) -> tuple[Path, ...]:
        """The single paths, robot after robot; with another path in every run, run after run."""
        rows = zip(self.lengths.ravel(), self.first, self.cells, strict=True)
        shares: Sequence[np.ndarray | None] = self.shares or [None] * self.lengths.size
        return tuple(
            Path(float(length), np.ascontiguousarray(self.table[: PathColumns.size, k : k + n + 1]), share)
            for (length, k, n), share in zip(rows, shares, strict=True)
        )

    def at(self, s: np.ndarray) -> PathPoint:
        """The points of each robot's path at abscissae ``s`` (..., robots) [m]; beyond an end the point stays there.

        With another path in every run ``s`` is (runs, robots).
        """
        flat = np.ascontiguousarray(s, dtype=float).reshape(-1, self.lengths.size)
        rows = _points_of_all(self.table, self.first, self.cells, self.lengths.ravel(), flat)
        return PathPoint(*(row.reshape(np.shape(s)) for row in rows))

    def share(self, s: np.ndarray) -> np.ndarray:
        """The progress, 0 to 1, at abscissae ``s`` (..., robots) [m]: alike for robots that are level with each other.

        It is the share of a path's own length, in a formation that of the virtual path.
        """
        if self.shares is None:
            return s / self.lengths
        return self._interpolated(s, [(nodes, rows[0]) for nodes, rows in self._nodes])

    def place(self, share: np.ndarray) -> np.ndarray:
        """The abscissae [m] at the progress ``share`` (..., robots); what :meth:`share` inverts."""
        if self.shares is None:
            return share * self.lengths
        return self._interpolated(share, [(rows[0], nodes) for nodes, rows in self._nodes])

    @cached_property
    def _nodes(self) -> list[tuple[np.ndarray, np.ndarray]]:
        """The abscissae of each path's nodes, and its shares."""
        assert self.shares is not None
        counted = zip(self.lengths.ravel(), self.cells, self.shares, strict=True)
        return [(np.linspace(0.0, length, cells + 1), rows) for length, cells, rows in counted]

    def _interpolated(self, x: np.ndarray, curves: Sequence[Any]) -> np.ndarray:
        """The values at ``x`` (..., robots) of one curve for each path: its abscissae, and its values."""
        flat = np.reshape(x, (-1, self.lengths.size))
        columns = [np.interp(flat[:, i], *curve) for i, curve in enumerate(curves)]
        return np.stack(columns, axis=-1).reshape(np.shape(x))

    def nearest(self, x: np.ndarray, y: np.ndarray, around: np.ndarray, reach: np.ndarray) -> np.ndarray:
        """The abscissae [m] of each path's nearest points, (..., robots) as all arguments.

        A path that crosses or closes itself is followed along the branch on which the robot is.

        Args:
            x: The robot's x [m].
            y: The robot's y [m].
            around: The abscissa about which to look [m].
            reach: How far along the path to look, both ways [m].
        """
        shape = np.shape(x)
        alike = (a if np.shape(a) == shape else np.broadcast_to(a, shape) for a in (x, y, around, reach))
        flat = [np.ascontiguousarray(a, dtype=float).reshape(-1, self.lengths.size) for a in alike]
        return _nearest_of_all(self.table, self.first, self.cells, self.lengths.ravel(), *flat).reshape(shape)


def join_paths(paths: Sequence[Path]) -> PathTable:
    """Put ``paths``, one for each robot, into one table."""
    table = _joined(np.array([path.length for path in paths]), [path.table for path in paths])
    if all(path.shares is None for path in paths):
        return table
    return replace(table, shares=tuple(path.shares if path.shares is not None else _even(path) for path in paths))


def _even(path: Path) -> np.ndarray:
    """The shares of a path that is driven at a constant speed."""
    nodes = path.table.shape[1]
    return np.stack([np.linspace(0.0, 1.0, nodes), np.full(nodes, path.length)])


def _joined(lengths: np.ndarray, tables: Sequence[np.ndarray]) -> PathTable:
    nodes = np.array([table.shape[1] for table in tables])
    return PathTable(lengths, with_tangents(*tables), np.concatenate([[0], np.cumsum(nodes)[:-1]]), nodes - 1)


@kernel(nogil=True)
def _points_of_all(table, first, cells, lengths, s):  # type: ignore[no-untyped-def]
    out = np.empty((4, s.shape[0], s.shape[1]))
    for r in range(s.shape[0]):
        for i in range(s.shape[1]):
            out[0, r, i], out[1, r, i], out[2, r, i], out[3, r, i] = point(
                table, first[i], cells[i], lengths[i], s[r, i]
            )
    return out


@kernel
def _nearest_of_all(table, first, cells, lengths, x, y, around, reach):  # type: ignore[no-untyped-def]
    out = np.empty(x.shape)
    for r in range(x.shape[0]):
        for i in range(x.shape[1]):
            out[r, i] = nearest_abscissa(
                table, first[i], cells[i], lengths[i], x[r, i], y[r, i], around[r, i], reach[r, i]
            )
    return out


@kernel
def nearest_abscissa(table, first, cells, length, x, y, around, reach):  # type: ignore[no-untyped-def]
    """The abscissa [m] of one path's nearest point to (x, y), looked for ``reach`` [m] to both sides of ``around``."""
    h = length / cells
    low = min(max(around - reach, 0.0), length)
    high = max(min(around + reach, length), low)
    best = _nearest_node(table, first, cells, h, x, y, around, low, high)
    s = _nearest_beside(table, first, cells, h, x, y, best, low, high)
    return min(max(s, low), high)


@kernel
def _nearest_node(table, first, cells, h, x, y, around, low, high):  # type: ignore[no-untyped-def]
    """The number of the node between ``low`` and ``high`` nearest to (x, y); one beside them where there is none."""
    start = min(int(np.ceil(low / h - 1e-9)), cells)
    stop = max(min(int(high / h + 1e-9), cells), start)
    beside = int(np.sqrt((stop - start) / 12))
    best = min(max(int(around / h + 0.5), start), stop)
    least = _square(table, first + best, x, y)
    # A metre along the path leads nearer by a metre at most: few of the nodes left out can be nearer.
    for k in range(start + beside, stop + beside + 1, 2 * beside + 1):
        if _square(table, first + min(k, stop), x, y) < (np.sqrt(least) + (beside + 1e-6) * h) ** 2:
            for inner in range(k - beside, min(k + beside, stop) + 1):
                square = _square(table, first + inner, x, y)
                if square < least:
                    least, best = square, inner
    return best


@kernel
def _square(table, k, x, y):  # type: ignore[no-untyped-def]
    return (table[0, k] - x) ** 2 + (table[1, k] - y) ** 2


@kernel
def _nearest_beside(table, first, cells, h, x, y, best, low, high):  # type: ignore[no-untyped-def]
    """The abscissa nearest to (x, y) in the cell before or behind node ``best``.

    There g is the derivative of half the squared distance by the cell's own parameter t; g = 0 is found by Newton's
    method, held in a bracket.
    """
    k = first + best
    node = NodeColumns(table, k)
    ca, sa = node.cos, node.sin
    ahead = ca * (x - node.x) + sa * (y - node.y) > 0
    if (best == cells) if ahead else (best == 0):
        return best * h
    other = k + 1 if ahead else k - 1
    cb, sb = NodeColumns(table, other).cos, NodeColumns(table, other).sin
    if not ahead:
        ca, sa, cb, sb = cb, sb, ca, sa
    k, cell = min(k, other), best if ahead else best - 1
    # The cell as point() interpolates it: x = a0 + a1 t + a2 t² + a3 t³, seen from (x, y)
    a0, b0 = table[0, k] - x, table[1, k] - y
    a1, b1 = h * ca, h * sa
    over, up = table[0, k + 1] - table[0, k], table[1, k + 1] - table[1, k]
    a2, b2 = 3 * over - h * (2 * ca + cb), 3 * up - h * (2 * sa + sb)
    a3, b3 = h * (ca + cb) - 2 * over, h * (sa + sb) - 2 * up
    left, right = max(low / h - cell, 0.0), min(high / h - cell, 1.0)
    t = left
    for step in range(60):
        px, py = a0 + t * (a1 + t * (a2 + t * a3)), b0 + t * (b1 + t * (b2 + t * b3))
        dx, dy = a1 + t * (2 * a2 + t * 3 * a3), b1 + t * (2 * b2 + t * 3 * b3)
        g = px * dx + py * dy
        if step == 0:  # at the left end
            if g >= 0:
                break
            t = right
            continue
        if step == 1:  # at the right end
            if g <= 0:
                break
        elif g > 0:
            right = t
        else:
            left = t
        bend = dx * dx + dy * dy + px * (2 * a2 + 6 * t * a3) + py * (2 * b2 + 6 * t * b3)
        before = t
        t = t - g / bend
        newton = left < t < right
        if not newton:
            t = (left + right) / 2
        # The step after one of Newton's is about its square.
        if abs(t - before) < (1e-7 if newton else 1e-12):
            break
    return (cell + t) * h


def table_length(table: np.ndarray) -> float:
    """The length [m] of the path with that ``table`` (5, nodes), whose nodes are equally spaced."""
    return float(_arcs(np.ascontiguousarray(table)).sum())


@kernel(nogil=True)
def _arcs(table):  # type: ignore[no-untyped-def]
    """The lengths [m] of the arcs between nodes."""
    arcs = np.empty(table.shape[1] - 1)
    for k in range(len(arcs)):
        one, other = PathColumns(table, k), PathColumns(table, k + 1)
        chord = math.hypot(other.x - one.x, other.y - one.y)
        turn = other.heading - one.heading
        arcs[k] = chord * (1 + turn * turn / 24)  # arc over chord, to the second order
    return arcs


def join_tables(tables: Sequence[Sequence[np.ndarray]]) -> PathTable:
    """Put paths, given by their ``tables`` [run][robot] (5, nodes), into one table with another path in every run."""
    joined = _joined(np.empty(0), [table for row in tables for table in row])
    arcs, spans = _arcs(joined.table), zip(joined.first.tolist(), joined.cells.tolist(), strict=True)
    lengths = np.array([arcs[first : first + cells].sum() for first, cells in spans])
    return replace(joined, lengths=lengths.reshape(len(tables), len(tables[0])))
