"""Where the paths of two robots meet: the geometry that tells who has to pass before whom, and where to wait.

Two places on two paths are in conflict where robots that stood there would be nearer to each other than ``apart``. For
every cell of robot i's path the table keeps the last abscissa of robot j's path that is in conflict with it: i may
enter the cell without meeting j as soon as j has passed that abscissa. On paths that cross, i thus waits at the line
before the crossing; behind a robot on the same path it follows at a distance.

A robot that waits must not stand in the way of a third: where the ways through several meetings lie one behind the
other without room to stand between them, its line is the one before all of them, as for cars at a crossing.
"""

from typing import NamedTuple

import numpy as np

from fuzzy.compiled.jit import compiled_only, kernel
from fuzzy.compiled.threads import share_out
from robotics.world.paths.joined import PathTable
from robotics.world.paths.path import point

CELL = 0.05  # m of a path for which one number is kept
LOOK = 4.0  # m: a meeting farther ahead is none yet
NO_MEETING = 9.0  # m, and s: what is told where two paths do not meet any more
INSIDE = -0.1  # m: what is told of a robot that is in the meeting
NOWHERE = -1.0  # the abscissa of a cell that is in conflict with nothing
_BITS = 3  # 2 to this are the cells that are looked at together
_TOGETHER = 64  # runs whose meetings one thread looks for at a time


class Meetings(NamedTuple):
    """The conflicts of all pairs of robots; the first axis is that of the runs, or 1 if they share their paths."""

    first: np.ndarray  # (runs, robots, robots) bool: the row's robot goes first, as far as the paths' ends demand it
    last: np.ndarray  # (runs, robots, robots, cells) m: the last abscissa of the other's path in conflict, or NOWHERE
    # (runs, robots, robots, blocks, 2) m: the greatest of each 2^_BITS cells of ``last``, and of all from these on
    peaks: np.ndarray
    points: np.ndarray  # (runs, robots, cells, 2) m: the cells of the paths

    @classmethod
    def of(cls, paths: PathTable, robots: int, radii: np.ndarray, margin: float) -> "Meetings":
        """Find the conflicts of ``paths`` for robots with circles of ``radii`` (robots,) [m] around them.

        Two robots are in conflict where less than ``margin`` [m] lies between their circles.
        """
        lengths = np.ascontiguousarray(paths.lengths.reshape(-1, robots))
        cells = int(np.ceil(lengths.max() / CELL)) + 1
        runs, blocks = len(lengths), -(-cells >> _BITS)
        apart, first = radii[:, None] + radii + margin, np.zeros((runs, robots, robots), dtype=bool)
        last = np.full((runs, robots, robots, cells), NOWHERE, dtype=np.float32)
        peaks = np.empty((runs, robots, robots, blocks, 2), np.float32)
        found = cls(first, last, peaks, np.empty((runs, robots, cells, 2)))

        def find(begin: int) -> None:
            end = min(begin + _TOGETHER, runs)
            some = cls(*(part[begin:end] for part in found))
            _fill(paths.table, paths.first, paths.cells, lengths[begin:end], begin * robots, some.points)
            _conflicts(some.points, lengths[begin:end], apart, some.last)
            some.peaks[..., 0] = np.maximum.reduceat(some.last, range(0, cells, 1 << _BITS), axis=-1)
            some.peaks[..., 1] = np.maximum.accumulate(some.peaks[..., ::-1, 0], axis=-1)[..., ::-1]
            _first(some.last, some.points, lengths[begin:end], apart, some.first)

        share_out(find, range(0, runs, _TOGETHER))
        return found


@kernel(nogil=True)
def _fill(table, first, cells, lengths, path, points):  # type: ignore[no-untyped-def]
    """Fill in the cells of the paths from that of the number ``path`` on."""
    for r in range(points.shape[0]):
        for i in range(points.shape[1]):
            length = lengths[r, i]
            for c in range(points.shape[2]):
                points[r, i, c, 0], points[r, i, c, 1], _, _ = point(
                    table, first[path], cells[path], length, min(c * CELL, length)
                )
            path += 1


@kernel(nogil=True)
def _conflicts(points, lengths, apart, last):  # type: ignore[no-untyped-def]
    """Fill in the last abscissae in conflict, where there are some."""
    runs, robots, cells, _ = points.shape
    for r in range(runs):
        for i in range(robots):
            for j in range(robots):
                if i == j:
                    continue
                square = apart[i, j] ** 2
                mine = int(np.ceil(lengths[r, i] / CELL)) + 1
                theirs = int(np.ceil(lengths[r, j] / CELL)) + 1
                for c in range(min(mine, cells)):
                    k = min(theirs, cells) - 1
                    while k >= 0:
                        dx = points[r, i, c, 0] - points[r, j, k, 0]
                        dy = points[r, i, c, 1] - points[r, j, k, 1]
                        gap = dx * dx + dy * dy
                        if gap < square:
                            last[r, i, j, c] = min(k * CELL, lengths[r, j])
                            break
                        # A step along the path leads nearer by a cell at most
                        k -= max(int((np.sqrt(gap) - apart[i, j]) / CELL), 1)


@kernel(nogil=True)
def _first(last, points, lengths, apart, first):  # type: ignore[no-untyped-def]
    """Note where robot i goes before j because it starts in j's way, or because j ends in i's way."""
    runs, robots, _, cells = last.shape
    for r in range(runs):
        for i in range(robots):
            for j in range(robots):
                if i == j:
                    continue
                for c in range(cells):
                    if last[r, i, j, c] >= lengths[r, j] - CELL:
                        first[r, i, j] = True  # j ends in i's way
                    dx = points[r, j, c, 0] - points[r, i, 0, 0]
                    dy = points[r, j, c, 1] - points[r, i, 0, 1]
                    if dx * dx + dy * dy < apart[i, j] ** 2:
                        first[r, i, j] = True  # i starts in j's way


@compiled_only(forceinline=True)
def next_meeting(last, peaks, place, others, room, i, j):  # type: ignore[no-untyped-def]
    """The next meeting of robot i, at ``place`` [m], with j.

    Returns the way [m] to the line at which it would wait, INSIDE beyond it, NO_MEETING where they meet no more; from
    that line until it is out of the meeting; and that of the other to its own line.

    Args:
        last: Of its run, as :attr:`Meetings.last` (robots · robots · cells,), one after the other.
        peaks: Likewise.
        place: Its abscissa [m].
        others: Those of all robots, as far as it knows them (robots,) [m].
        room: What it needs between two meetings in order to wait there [m].
        i: Its number from 0.
        j: That of the other.
    """
    robots, s = len(others), others[j]
    cells = len(last) // (robots * robots)
    if i == j or np.isnan(s):
        return NO_MEETING, 0.0, NO_MEETING
    mine, here, reach = (i * robots + j) * cells, int(max(place, 0.0) / CELL), int(LOOK / CELL)
    found = _first_taken(last, peaks, robots, i, j, s, here, min(here + reach, cells))
    if found < 0:
        return NO_MEETING, 0.0, NO_MEETING
    out = found
    while out < cells - 1 and last[mine + out] >= s:
        out += 1
    line = _line(last, others, room, i, here, found, cells)
    way = INSIDE if found == here else max(line * CELL - place, 0.0)
    # the other's way to its own line, as far as I can tell: without third robots
    start, theirs = int(max(s, 0.0) / CELL), NO_MEETING
    c = _first_taken(last, peaks, robots, j, i, place, start, min(start + reach, cells))
    if c >= 0:
        theirs = INSIDE if c == start else c * CELL - s
    return way, (out - min(line, found)) * CELL, theirs


@compiled_only
def _first_taken(last, peaks, robots, i, j, until, begin, end):  # type: ignore[no-untyped-def]
    """The first cell of robot i, from ``begin`` to before ``end``, in conflict with j at ``until`` [m] or later; or -1.

    A block of cells none of which is, is passed over, and the search ends where none farther on is.
    """
    pair = i * robots + j
    cells, blocks, c = len(last) // (robots * robots), len(peaks) // (2 * robots * robots), begin
    while c < end:
        peak = 2 * (pair * blocks + (c >> _BITS))
        if peaks[peak + 1] < until:
            return -1
        if peaks[peak] < until:
            c = ((c >> _BITS) + 1) << _BITS
        elif last[pair * cells + c] >= until:
            return c
        else:
            c += 1
    return -1


@compiled_only
def _line(last, others, room, i, here, found, cells):  # type: ignore[no-untyped-def]
    """The cell before all meetings that leave no room to stand between them and the one at cell ``found``."""
    line, free, robots = found, 0, len(others)
    needed = int(room / CELL)
    c = found - 1
    while c >= here and free < needed:
        taken = False
        for k in range(robots):
            if k != i and not np.isnan(others[k]) and last[(i * robots + k) * cells + c] >= others[k]:
                taken = True
                break
        if taken and c == here:
            return found  # it stands in one of them already: there is no better place than right before this one
        if taken:
            line, free = c, 0
        else:
            free += 1
        c -= 1
    return line


@compiled_only(forceinline=True)
def off_the_way(way, place, x, y, reach):  # type: ignore[no-untyped-def]
    """The distance [m] of (x, y) from the next ``reach`` cells of a path behind ``place`` [m].

    ``way`` are the cells of the path, x and y [m] one after the other (2 cells,).
    """
    here, square = int(max(place, 0.0) / CELL), np.inf
    for c in range(here, min(here + reach, len(way) // 2)):
        dx, dy = way[2 * c] - x, way[2 * c + 1] - y
        square = min(square, dx * dx + dy * dy)
    return np.sqrt(square)


@compiled_only
def goes_first(last, peaks, reached, robots, place, other, i, j):  # type: ignore[no-untyped-def]
    """Who goes first by a plan where robots meet next: 1: robot i, at ``place`` [m], -1: j, at ``other``; 0: neither.

    Either robot has a next meeting of its own, and what the plan passes first of the two counts: the two agree.

    ``last`` and ``peaks`` are as of :func:`next_meeting`, ``reached`` is when the plan has each robot at each cell of
    its path (robots · cells,) [s]; an ``other`` that is not a number is not known.
    """
    if i == j or np.isnan(other):
        return 0.0
    mine, theirs = _passing(last, peaks, reached, robots, i, j, place, other)
    their_own, my_own = _passing(last, peaks, reached, robots, j, i, other, place)
    if min(my_own, their_own) < min(mine, theirs):
        mine, theirs = my_own, their_own
    return 1.0 if mine < theirs else -1.0 if theirs < mine else 0.0


@compiled_only
def _passing(last, peaks, reached, robots, i, j, place, other):  # type: ignore[no-untyped-def]
    """When robot i, at ``place``, enters its next meeting with j, at ``other``, and when j leaves it; infinite: none"""
    cells = len(reached) // robots
    c = _first_taken(last, peaks, robots, i, j, other, int(max(place, 0.0) / CELL), cells)
    if c < 0:
        return np.inf, np.inf
    until = last[(i * robots + j) * cells + c]
    return reached[i * cells + c], reached[j * cells + min(int(np.ceil(until / CELL)), cells - 1)]
