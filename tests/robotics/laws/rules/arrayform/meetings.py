"""Where the paths of robots meet, of all pairs at once; see :mod:`robotics.laws.rules.meetings`."""

from typing import NamedTuple

import numpy as np

from fuzzy.compiled.jit import kernel
from robotics.laws.rules.meetings import CELL, Meetings, goes_first, next_meeting, off_the_way


class Meeting(NamedTuple):
    """The next meeting of each robot with each other; each field is (runs, robots, others)."""

    way: np.ndarray  # m to the line at which it would wait; INSIDE: it is beyond it; NO_MEETING: they meet no more
    through: np.ndarray  # m from that line until the robot is out of the meeting
    theirs: np.ndarray  # m of the other to its own line


def next_meetings(meetings: Meetings, room: np.ndarray, place: np.ndarray, others: np.ndarray) -> Meeting:
    """The next meetings of robots at ``place`` (runs, robots) with ``others`` (runs, robots, others) [m].

    The others' abscissae are what each robot knows of them; not-a-number: nothing, and they meet nowhere. ``room``
    (robots,) [m] is what a robot needs between two meetings in order to wait there.
    """
    return Meeting(*_next(_flat(meetings.last, 1), _flat(meetings.peaks, 1), room, place, others))


def planned_order(meetings: Meetings, reached: np.ndarray, place: np.ndarray, others: np.ndarray) -> np.ndarray:
    """Who goes first by a plan where robots meet next: 1 the robot, -1 the other (runs, robots, others); 0: neither.

    Either robot has a next meeting of its own, and what the plan passes first of the two counts: the two agree.

    Args:
        meetings: The conflicts of the paths.
        reached: When the plan has each robot at each cell of its path (runs, robots, cells) [s].
        place: Where robots are (runs, robots) [m].
        others: What each knows of where the others are (runs, robots, others) [m]; not-a-number: nothing.
    """
    tables = (_flat(table, 1) for table in (meetings.last, meetings.peaks, reached))
    return np.asarray(_order(*tables, place, others))


def in_the_way(meetings: Meetings, place: np.ndarray, x: np.ndarray, y: np.ndarray, reach: float) -> np.ndarray:
    """The distance [m] of each other robot from the next ``reach`` [m] of each robot's path (runs, robots, others).

    ``place`` is (runs, robots); ``x`` and ``y`` [m] are where each robot knows the others to be.
    """
    return np.asarray(_off(_flat(meetings.points, 2), place, x, y, int(np.ceil(reach / CELL))))


def _flat(values: np.ndarray, axes: int) -> np.ndarray:
    """The same with all but the first ``axes`` axes one after the other."""
    return np.ascontiguousarray(values).reshape(*values.shape[:axes], -1)


@kernel
def _next(last, peaks, room, place, others):
    runs, robots = place.shape
    way, through, theirs = np.empty((runs, robots, robots)), np.empty((runs, robots, robots)), np.empty(others.shape)
    for r in range(runs):
        for i in range(robots):
            for j in range(robots):
                t = r if len(last) > 1 else 0
                found = next_meeting(last[t], peaks[t], place[r, i], others[r, i], room[i], i, j)
                way[r, i, j], through[r, i, j], theirs[r, i, j] = found
    return way, through, theirs


@kernel
def _off(points, place, x, y, reach):
    runs, robots = place.shape
    off = np.full((runs, robots, robots), np.inf)
    for r in range(runs):
        for i in range(robots):
            for j in range(robots):
                if i != j and not np.isnan(x[r, i, j]):
                    way = points[r if len(points) > 1 else 0, i]
                    off[r, i, j] = off_the_way(way, place[r, i], x[r, i, j], y[r, i, j], reach)
    return off


@kernel
def _order(last, peaks, reached, place, others):
    runs, robots = place.shape
    order = np.zeros((runs, robots, robots))
    for r in range(runs):
        t = r if len(last) > 1 else 0
        for i in range(robots):
            for j in range(robots):
                other = others[r, i, j]
                order[r, i, j] = goes_first(last[t], peaks[t], reached[t], robots, place[r, i], other, i, j)
    return order
