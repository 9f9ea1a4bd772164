"""The paths of several robots in one table: points and nearest points of all of them in one compiled pass."""

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from numba import njit

from robotics.path import Path, PathPoint, point


@dataclass(frozen=True)
class Paths:
    """The paths of several robots in one table, for looking at all of them in one pass."""

    lengths: np.ndarray  # (robots,) m
    table: np.ndarray = field(repr=False)  # (5, nodes of all): as of Path, one path after the other
    first: np.ndarray = field(repr=False)  # (robots,) the column at which each begins
    cells: np.ndarray = field(repr=False)  # (robots,) one less than its nodes

    def at(self, s: np.ndarray) -> PathPoint:
        """Each robot's path at its abscissae ``s`` (..., robots) [m]; beyond an end it stays there."""
        flat = np.ascontiguousarray(s, dtype=float).reshape(-1, len(self.lengths))
        rows = _points_of_all(self.table, self.first, self.cells, self.lengths, flat)
        return PathPoint(*(row.reshape(np.shape(s)) for row in rows))

    def nearest(self, x: np.ndarray, y: np.ndarray, around: np.ndarray, reach: np.ndarray) -> np.ndarray:
        """The abscissae [m] of the points nearest to ``x``, ``y`` [m] within ``reach`` [m] of ``around`` [m].

        All are (..., robots). A path that crosses or closes itself is thus followed along the branch one is on.
        """
        shape = np.shape(x)
        flat = [
            np.ascontiguousarray(np.broadcast_to(a, shape), dtype=float).reshape(-1, len(self.lengths))
            for a in (x, y, around, reach)
        ]
        return _nearest_of_all(self.table, self.first, self.cells, self.lengths, *flat).reshape(shape)


def join_paths(paths: Sequence[Path]) -> Paths:
    """``paths``, one a robot, in one table."""
    nodes = np.array([path.table.shape[1] for path in paths])
    return Paths(
        np.array([path.length for path in paths]),
        np.ascontiguousarray(np.concatenate([path.table for path in paths], axis=1)),
        np.concatenate([[0], np.cumsum(nodes)[:-1]]),
        nodes - 1,
    )


@njit(cache=True, error_model="numpy")
def _points_of_all(table, first, cells, lengths, s):  # type: ignore[no-untyped-def]
    out = np.empty((4, s.shape[0], s.shape[1]))
    for r in range(s.shape[0]):
        for i in range(s.shape[1]):
            out[0, r, i], out[1, r, i], out[2, r, i], out[3, r, i] = point(
                table, first[i], cells[i], lengths[i], s[r, i]
            )
    return out


@njit(cache=True, error_model="numpy")
def _nearest_of_all(table, first, cells, lengths, x, y, around, reach):  # type: ignore[no-untyped-def]
    out = np.empty(x.shape)
    for r in range(x.shape[0]):
        for i in range(x.shape[1]):
            h = lengths[i] / cells[i]
            low = max(around[r, i] - reach[r, i], 0.0)
            high = min(around[r, i] + reach[r, i], lengths[i])
            # Coarsely by the nodes, a few at a time where the window is wide, then Newton between the nodes.
            count = max(int((high - low) / h), 1)
            stride = max(count // 64, 1)
            best = low
            least = np.inf
            for n in range(0, count + stride, stride):
                s = min(low + n * h, high)
                k = min(int(s / h + 0.5), cells[i]) + first[i]
                d = (table[0, k] - x[r, i]) ** 2 + (table[1, k] - y[r, i]) ** 2
                if d < least:
                    least = d
                    best = s
            limit = stride * h
            for _ in range(6):
                px, py, heading, curvature = point(table, first[i], cells[i], lengths[i], best)
                dx = x[r, i] - px
                dy = y[r, i] - py
                along = np.cos(heading) * dx + np.sin(heading) * dy
                across = np.cos(heading) * dy - np.sin(heading) * dx
                step = along / max(1 - curvature * across, 0.2)  # d²/ds² of half the squared distance
                step = min(max(step, -limit), limit)
                before = best
                best = min(max(best + step, low), high)
                if abs(best - before) < 1e-10:
                    break
            out[r, i] = best
    return out
