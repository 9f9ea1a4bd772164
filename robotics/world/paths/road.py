"""References of any kind as plain arrays, for compiled functions that look up one robot's own at a time.

A road holds the paths of all lanes and when each is driven: a lane is one robot of one run. Robots that have the same
paths in all runs have as many columns as there are robots; otherwise every lane has its own.
"""

from typing import NamedTuple

import numpy as np

from fuzzy.compiled.columns import Floats1, Floats2, Floats3, Ints1, codes
from fuzzy.compiled.jit import compiled_only, kernel
from robotics.world.paths.joined import PathTable, nearest_abscissa
from robotics.world.paths.path import cell_by_x, point, point_beside

TIMED = codes(("tabulated", "evenly", "planned"))  # by a table of abscissae, or by a plan of shares
CELLS = 160  # ticks of a plan in its nominal duration


class Road(NamedTuple):
    """The paths and the timing of all robots; where nothing else is said, arrays are (paths,)."""

    table: Floats2  # (NodeColumns, nodes of all paths): as of robotics.world.paths.joined.PathTable
    first: Ints1  # the column at which each begins
    cells: Ints1  # the number of its nodes minus 1
    lengths: Floats1  # m
    kind: int  # of TIMED
    ends: Floats1  # s: when each reference reaches the end of its path
    durations: Floats1  # s: of even timing, or of CELLS ticks of a plan
    timing: Floats3  # (paths, 2, times): abscissa [m] and its rate [m/s] at equal steps of time, if tabulated
    plan: Floats2  # (paths, ticks + 1): share of the path at every tick, if planned
    shares: Floats2  # (2, nodes of all paths) progress and the way for each unit of it; (2, 0): shares of the length
    since: float  # s: the time of the road when a run begins


def road_of(
    joined: PathTable,
    kind: int,
    ends: np.ndarray,
    *,
    durations: np.ndarray | None = None,
    timing: np.ndarray | None = None,
    plan: np.ndarray | None = None,
) -> Road:
    """The road of ``joined`` paths; the other arguments are the fields of :class:`Road` that its ``kind`` needs."""
    lengths = np.ascontiguousarray(joined.lengths, dtype=float).ravel()
    shares = np.empty((2, 0)) if joined.shares is None else np.concatenate(joined.shares, axis=1)

    def each(values: np.ndarray | None) -> np.ndarray:
        given = lengths if values is None else np.broadcast_to(values, np.shape(joined.lengths))
        return np.array(given, dtype=float).ravel()  # a copy: what was spread out cannot be written to

    return Road(
        np.ascontiguousarray(joined.table),
        np.ascontiguousarray(joined.first, dtype=np.int64),
        np.ascontiguousarray(joined.cells, dtype=np.int64),
        lengths,
        kind,
        each(ends),
        each(durations),
        np.empty((0, 2, 0)) if timing is None else np.ascontiguousarray(timing),
        np.empty((0, 0)) if plan is None else np.ascontiguousarray(plan),
        np.ascontiguousarray(shares),
        0.0,
    )


def rows_at(road: Road, times: np.ndarray) -> np.ndarray:
    """What :func:`moving` tells of every path at a time of its own, (6, ..., paths) for ``times`` (..., paths) [s]."""
    flat = np.ascontiguousarray(times, dtype=float).reshape(-1, len(road.lengths))
    rows: np.ndarray = _moving_all(road, flat)
    return rows.reshape(len(rows), *np.shape(times))


@kernel(nogil=True)
def _moving_all(road, times):  # type: ignore[no-untyped-def]
    out = np.empty((6, *times.shape))
    for n in range(times.shape[0]):
        for path in range(times.shape[1]):
            x, y, heading, v, w, s = moving(road, path, times[n, path])
            out[0, n, path], out[1, n, path], out[2, n, path] = x, y, heading
            out[3, n, path], out[4, n, path], out[5, n, path] = v, w, s
    return out


@compiled_only
def timed(road, path, time):  # type: ignore[no-untyped-def]
    """How far the reference of one path is at a time [s] of the run: abscissa [m] and speed [m/s]."""
    time = time + road.since
    length = road.lengths[path]
    if road.kind == TIMED.tabulated:
        return _tabulated(road.timing, path, road.ends[path], length, time)
    if road.kind == TIMED.evenly:
        share = min(max(time / road.durations[path], 0.0), 1.0)
        return share * length, length / road.durations[path] if share < 1 else 0.0
    share, slope = planned(road, path, time)
    return share * length, slope * CELLS / road.durations[path] * length if time < road.ends[path] else 0.0


@compiled_only
def moving(road, path, time):  # type: ignore[no-untyped-def]
    """The reference of one path at a time [s] of the run: x, y [m], heading [rad], v [m/s], ω [rad/s], abscissa [m]."""
    s, v = timed(road, path, time)
    x, y, heading, curvature = at(road, path, s)
    return x, y, heading, v, v * curvature, s


@compiled_only
def planned(road, path, time):  # type: ignore[no-untyped-def]
    """A plan's share of the path at a time [s], and its slope a tick."""
    return planned_at(road.plan[path], time / road.durations[path] * CELLS)


@compiled_only
def planned_at(shares, tick):  # type: ignore[no-untyped-def]
    """The share of the path between the ticks of one robot's plan, and its slope a tick."""
    t = min(max(tick, 0.0), len(shares) - 1 - 1e-9)
    k = int(t)
    a, b = shares[k], shares[k + 1]
    return a + (t - k) * (b - a), b - a


@compiled_only
def _tabulated(timing, path, end, length, time):  # type: ignore[no-untyped-def]
    """Abscissa [m] and speed [m/s]: between the times of the table by a cubic Hermite spline."""
    if time >= end:
        return length, 0.0
    last = timing.shape[2] - 1
    h = end / last
    place = max(time, 0.0) / h
    k = min(int(place), last - 1)
    t = place - k
    right = t * t * (3 - 2 * t)
    a, b = timing[path, 1, k], timing[path, 1, k + 1]
    s = (1 - right) * timing[path, 0, k] + right * timing[path, 0, k + 1]
    s += (t * (1 - t) * (1 - t) * a - t * t * (1 - t) * b) * h
    return s, (1 - t) * a + t * b


@compiled_only
def at(road, path, s):  # type: ignore[no-untyped-def]
    """The point of one path at an abscissa [m]: x, y [m], heading [rad], curvature [1/m]."""
    return point(road.table, road.first[path], road.cells[path], road.lengths[path], s)


@compiled_only
def beside(road, path, x):  # type: ignore[no-untyped-def]
    """The point of one path, along which x grows, with that x [m]: x, y [m], heading [rad], curvature [1/m]."""
    return point_beside(road.table, road.first[path], road.cells[path], road.lengths[path], x)


@compiled_only
def by_x(road, path, x):  # type: ignore[no-untyped-def]
    """The abscissa [m] where one path, along which x grows, has that x [m]; linear between nodes."""
    k = cell_by_x(road.table, road.first[path], road.cells[path], x)
    a, b = road.table[0, road.first[path] + k], road.table[0, road.first[path] + k + 1]
    return _between(x, a, b, _node(road, path, k), _node(road, path, k + 1))


@compiled_only
def last_x(road, path):  # type: ignore[no-untyped-def]
    """The x [m] of the end of one path."""
    return road.table[0, road.first[path] + road.cells[path]]


@compiled_only
def share(road, path, s):  # type: ignore[no-untyped-def]
    """The progress, 0 to 1, at an abscissa [m]; in a formation it is that of the virtual path."""
    if road.shares.shape[1] == 0:
        return s / road.lengths[path]
    cells = road.cells[path]
    k = min(max(int(s / road.lengths[path] * cells), 0), cells - 1)
    if s < _node(road, path, k):  # by rounding
        k = max(k - 1, 0)
    elif s >= _node(road, path, k + 1):
        k = min(k + 1, cells - 1)
    n = road.first[path] + k
    return _between(s, _node(road, path, k), _node(road, path, k + 1), road.shares[0, n], road.shares[0, n + 1])


@compiled_only
def place(road, path, progress):  # type: ignore[no-untyped-def]
    """The abscissa [m] at a progress; what :func:`share` inverts."""
    if road.shares.shape[1] == 0:
        return progress * road.lengths[path]
    k = _share_cell(road, path, progress)
    n = road.first[path] + k
    a, b = road.shares[0, n], road.shares[0, n + 1]
    return _between(progress, a, b, _node(road, path, k), _node(road, path, k + 1))


@compiled_only
def stretch(road, path, progress):  # type: ignore[no-untyped-def]
    """The way [m] for each unit of progress, at a progress: the path's length, or nearly so."""
    if road.shares.shape[1] == 0:
        return road.lengths[path]
    n = road.first[path] + _share_cell(road, path, progress)
    return _between(progress, road.shares[0, n], road.shares[0, n + 1], road.shares[1, n], road.shares[1, n + 1])


@compiled_only
def _share_cell(road, path, progress):  # type: ignore[no-untyped-def]
    """The cell in which a path has a progress."""
    low, high = 0, road.cells[path]
    while high - low > 1:
        middle = (low + high) // 2
        if road.shares[0, road.first[path] + middle] <= progress:
            low = middle
        else:
            high = middle
    return low


@compiled_only
def _node(road, path, k):  # type: ignore[no-untyped-def]
    """The abscissa [m] of a path's node, to the last bit as numpy.linspace has it."""
    cells = road.cells[path]
    return k * (road.lengths[path] / cells) if k < cells else road.lengths[path]


@compiled_only
def _between(x, a, b, at_a, at_b):  # type: ignore[no-untyped-def]
    """The value at ``x`` between two points, or at the nearer one outside; to the last bit as numpy.interp has it."""
    if x <= a:
        return at_a
    return (at_b - at_a) / (b - a) * (x - a) + at_a if x < b else at_b


@compiled_only
def nearest(road, path, x, y, around, reach):  # type: ignore[no-untyped-def]
    """The abscissa [m] of a path's nearest point to (x, y) [m], within ``reach`` [m] of the abscissa ``around``."""
    return nearest_abscissa(road.table, road.first[path], road.cells[path], road.lengths[path], x, y, around, reach)
