"""Right of way by reservation: a plan over (clock, path parameter) in which no two robots ever come close.

All paths are cut into the same number of cells, and time into ticks of a common clock; a plan says in which cell each
robot is at each tick. Robots plan one after the other, by priority: each finds, by dynamic programming over the grid,
the plan that stays nearest to its nominal timing and keeps clear of all that planned before it. At a tick it stays,
moves one cell (the nominal speed), or two. A robot that finds no plan is the first in the next order, and after all
orders a longer horizon is tried; where none of these has a plan, there is none. Robots may be made to arrive together:
then none is at its end before the last moment, and a robot that would be in the way there comes last.

The plan is safe on robots because it is a plan of the clock, not of time: a robot that is late slows the clock of all
(:mod:`robotics.laws.avoidance.right_of_way`), so that the robots stay together in it. Two robots are clear of each
other when they are farther apart than ``clearance``, also if one is up to ``margin`` ticks of the clock ahead.

After prioritised planning in configuration space-time [Erdmann & Lozano-Pérez 1987].
"""

from dataclasses import dataclass
from math import ceil

import numpy as np

from fuzzy.compiled.jit import kernel
from robotics.world.paths.road import CELLS  # of each path, and ticks of the nominal duration

_FACTORS = (1.0, 1.1, 1.2, 1.35, 1.6, 2.0, 2.6, 3.4)  # times the nominal duration: the horizons tried
# Orders that are tried for each horizon: at first robot 1 has precedence; then random ones, beside those that a failure
# suggests
_ORDERS = 12
PARKED = 0.035  # m: a robot nearer to its end may count as arrived
_STOP = 2e-4  # cost of a tick at rest, in squared shares of the path


@dataclass(frozen=True, eq=False)
class Plan:
    """Plans of all robots of many runs."""

    progress: np.ndarray  # (runs, robots, ticks + 1): share of the path at every tick, from 0 to 1
    found: np.ndarray  # (runs,) bool: whether there is a plan; where not, the row is the nominal timing
    factor: np.ndarray  # (runs,) the plan's duration over the nominal one
    orders: np.ndarray  # (runs,) int: how many orders were tried


def plan_right_of_way(
    nodes: np.ndarray,
    clearance: float = 0.5,
    margin: float | np.ndarray = 0.05,
    together: np.ndarray | None = None,
) -> Plan:
    """Plan the robots of every run so that they keep clear of each other.

    Args:
        nodes: The paths at equal shares of their lengths (runs, robots, CELLS + 1, 2) [m].
        clearance: The least distance between the robots' centers [m].
        margin: How far two robots' clocks may differ, as a share of the nominal duration, () or (runs,).
        together: The share of the nominal duration, at the end of the plan, within which all arrive (runs,); without
            it they may arrive earlier.
    """
    runs, robots = nodes.shape[:2]
    rng = np.random.default_rng(0)
    tried = np.stack([np.arange(robots), *(rng.permutation(robots) for _ in range(_ORDERS - 1))])
    longest = ceil(CELLS * _FACTORS[-1])
    cells = np.zeros((runs, robots, longest + 1), dtype=np.int32)
    ticks = np.zeros(runs, dtype=np.int64)
    count = np.zeros(runs, dtype=np.int64)
    horizons = np.array([ceil(CELLS * f) for f in _FACTORS])
    if together is None:
        late = np.full(runs, longest + 1)
    else:
        late = np.maximum((together * CELLS).astype(np.int64), 1)
    ahead = np.broadcast_to(np.ceil(np.asarray(margin) * CELLS).astype(np.int64), runs)
    _plan_runs(np.ascontiguousarray(nodes), clearance**2, ahead, tried, horizons, late, cells, ticks, count)
    found = ticks > 0
    nominal = np.minimum(np.arange(longest + 1), CELLS)
    progress = np.where(found[:, None, None], cells, nominal) / CELLS
    return Plan(progress, found, np.where(found, ticks, CELLS) / CELLS, count)


@kernel(nogil=True)
def _plan_runs(nodes, clear, margin, tried, horizons, late, cells, ticks, count):  # type: ignore[no-untyped-def]
    robots = nodes.shape[1]
    longest = horizons[-1]
    cost = np.empty((longest + 1, CELLS + 1))
    blocked = np.empty((longest + 1, CELLS + 1), dtype=np.bool_)
    for run in range(nodes.shape[0]):
        if _hopeless(nodes[run], clear):
            continue
        near = _within(nodes[run], clear)
        for horizon in horizons:
            order = tried[0].copy()
            for o in range(tried.shape[0]):
                count[run] += 1
                failed = -1
                for place in range(robots):
                    limits = (clear, margin[run], horizon, late[run])
                    if not _plan_one(nodes[run], near, cells[run], order, place, limits, cost, blocked):
                        failed = place
                        break
                if failed < 0:
                    ticks[run] = horizon
                    for i in range(robots):
                        for k in range(horizon + 1, longest + 1):
                            cells[run, i, k] = CELLS
                    break
                if o % 3 == 2 and o + 1 < tried.shape[0]:
                    order[:] = tried[o + 1]  # or the same few robots might take turns endlessly
                else:
                    first = order[failed]
                    for place in range(failed, 0, -1):
                        order[place] = order[place - 1]
                    order[0] = first
            if ticks[run] > 0:
                break


@kernel
def _hopeless(nodes, clear):  # type: ignore[no-untyped-def]
    """Whether some two robots cannot pass each other at any timing."""
    for i in range(nodes.shape[0]):
        for j in range(i):
            for end in (0, CELLS):
                dx = nodes[i, end, 0] - nodes[j, end, 0]
                dy = nodes[i, end, 1] - nodes[j, end, 1]
                if dx * dx + dy * dy < clear:
                    return True
            if not _passable(nodes[i], nodes[j], clear):
                return True
    return False


@kernel
def _passable(a, b, clear):  # type: ignore[no-untyped-def]
    """Whether there is a way through the plane of two robots' cells, from both starts to both ends, never back."""
    row = np.zeros(CELLS + 1, dtype=np.bool_)
    for i in range(CELLS + 1):
        before = False  # the cell (i - 1, j - 1)
        for j in range(CELLS + 1):
            above = row[j]
            dx = a[i, 0] - b[j, 0]
            dy = a[i, 1] - b[j, 1]
            free = dx * dx + dy * dy >= clear
            row[j] = free and ((i == 0 and j == 0) or above or before or (j > 0 and row[j - 1]))
            before = above
    return row[CELLS]


@kernel
def _within(nodes, clear):  # type: ignore[no-untyped-def]
    """The first and one past the last cell of robot i too near cell k of robot j, (i, j, CELLS + 1, 2)."""
    robots = nodes.shape[0]
    near = np.zeros((robots, robots, CELLS + 1, 2), dtype=np.int16)
    for i in range(robots):
        for j in range(robots):
            if i == j:
                continue
            for k in range(CELLS + 1):
                for c in range(CELLS + 1):
                    if square(nodes[i, c], nodes[j, k]) < clear:
                        if near[i, j, k, 1] == 0:
                            near[i, j, k, 0] = c
                        near[i, j, k, 1] = c + 1
    return near


@kernel
def square(a, b):  # type: ignore[no-untyped-def]
    """The squared distance [m²] of two points."""
    return (a[0] - b[0]) ** 2 + (a[1] - b[1]) ** 2


@kernel
def _plan_one(nodes, near, cells, order, place, limits, cost, blocked):  # type: ignore[no-untyped-def]
    """Plan robot ``order[place]`` around those before it in the order. Returns False if there is no plan."""
    clear, margin, horizon, late = limits
    robot = order[place]
    parked = CELLS  # the first cell that counts as the end
    while parked > CELLS // 2 and square(nodes[robot, parked - 1], nodes[robot, CELLS]) < PARKED * PARKED:
        parked -= 1
    latest = horizon - max(late, (CELLS - parked + 2) // 2)  # two cells a tick are left
    for k in range(horizon + 1):
        for c in range(CELLS + 1):
            blocked[k, c] = k < latest and c >= parked
    for before in range(place):
        other = order[before]
        # Where the other stays within the clearance of each of this robot's cells, tick by tick
        last = -1
        for k in range(horizon + 1):
            at = cells[other, k]
            until = min(k + margin, horizon)
            since = until if at == last else max(k - margin, 0)  # while it stays, only the margin's end is new
            last = at
            for c in range(near[robot, other, at, 0], near[robot, other, at, 1]):
                if square(nodes[robot, c], nodes[other, at]) < clear:
                    for tick in range(since, until + 1):
                        blocked[tick, c] = True
    if blocked[0, 0] or blocked[horizon, CELLS]:
        return False
    far = np.inf
    for c in range(CELLS + 1):
        cost[0, c] = far
    cost[0, 0] = 0.0
    for k in range(1, horizon + 1):
        nominal = k * CELLS / horizon  # all take the longer time, so that they still arrive together
        for c in range(CELLS + 1):
            best = cost[k - 1, c] + (_STOP if 0 < c < CELLS else 0.0)
            if c >= 1 and cost[k - 1, c - 1] < best:
                best = cost[k - 1, c - 1]
            if c >= 2 and cost[k - 1, c - 2] < best:
                best = cost[k - 1, c - 2]
            if blocked[k, c]:
                best = far
            off = (c - nominal) / CELLS
            cost[k, c] = best + off * off
    if not cost[horizon, CELLS] < far:
        return False
    c = CELLS
    cells[robot, horizon] = c
    for k in range(horizon, 0, -1):
        best = cost[k - 1, c] + (_STOP if 0 < c < CELLS else 0.0)
        step = 0
        if c >= 1 and cost[k - 1, c - 1] < best:
            best = cost[k - 1, c - 1]
            step = 1
        if c >= 2 and cost[k - 1, c - 2] < best:
            step = 2
        c -= step
        cells[robot, k - 1] = c
    return True
