"""The judgement of runs in one period, compiled: arrivals, distances, contacts, and which runs go on.

What is known of a run is kept in columns, which :func:`judge` carries on in place from period to period. Of a run that
is over nothing changes any more, so that it does not matter which runs are beside it.
"""

import math
from typing import Any, NamedTuple

import numpy as np

from fuzzy.compiled.jit import kernel, types
from robotics.environment.swept import sweep
from robotics.environment.world import Geometry
from robotics.laws.equation import EQUATION_TYPE, GUARDED, MODE, REFUSED
from robotics.laws.modes import FOLLOW
from robotics.simulation.lanes import LOOK_TYPE, LOOKS_TYPE, machine_code
from robotics.simulation.steps import decide, hear, move, obey, say, sense


class Known(NamedTuple):
    """What is known of all runs up to a period; the last eight are as of :class:`robotics.environment.swept.Watch`."""

    sizes: np.ndarray  # (3, robots) m: as of robotics.environment.collision.footprints
    goals: np.ndarray  # (2, runs, robots) m: x and y of the paths' ends
    near: np.ndarray  # (runs, robots) m: a robot this near its goal is there
    limits: np.ndarray  # (runs,) s: the longest that each run takes
    goes_on: np.ndarray  # (runs,) bool
    arrivals: np.ndarray  # (runs, robots) s; infinite: not yet
    refused: np.ndarray  # (runs,) bool: the law said before the start that there is no safe plan
    nearest: np.ndarray  # (runs,) m: the least distance between the centers of two robots
    followed: np.ndarray  # (runs,) bool: a robot followed a wall
    driven: np.ndarray  # (runs,) int: periods of robots that had not yet arrived, while their run went on
    guarded: np.ndarray  # (runs,) int: those of them in which the emergency rule acted
    poses: np.ndarray  # (5, runs, robots, 2): x [m], y [m], heading [rad], v [m/s], ω [rad/s] one period ago, and now
    counts_before: np.ndarray  # (runs, robots) int: counts one period ago
    since_before: np.ndarray  # (runs, pairs) s: since one period ago
    spans: np.ndarray
    least: np.ndarray
    first: np.ndarray
    counts: np.ndarray
    ends: np.ndarray
    floor: np.ndarray
    since: np.ndarray
    depth: np.ndarray


_F, _I, _B = types.float64, types.int64, types.boolean
_AXES = (2, 3, 2, 1, 1, 2, 1, 1, 1, 1, 1, 4, 2, 2, 3, 3, 3, 2, 2, 2, 2, 2)  # of the fields of Known
_KINDS: dict[str, Any] = {"goes_on": _B, "refused": _B, "followed": _B}
_KINDS |= dict.fromkeys(("driven", "guarded", "counts_before", "counts", "spans"), _I)
KNOWN_TYPE = types.NamedTuple(
    tuple(types.Array(_KINDS.get(name, _F), axes, "C") for name, axes in zip(Known._fields, _AXES, strict=True)), Known
)
WORLD_TYPE = types.NamedTuple(  # the obstacles one period ago and now, or once, if they rest
    tuple(types.Array(kind, axes, "C") for kind, axes in ((_F, 4), (_I, 3), (_F, 4), (_I, 1))), Geometry
)


@kernel(nogil=True)
def judge(k, known, world, period, truth, command):  # type: ignore[no-untyped-def]
    """Carry ``known`` on to period ``k``, of ``period`` [s], in which the law has decided on its ``command``.

    ``truth`` is the plant's state. Returns whether a contact began since the last period, whether a run goes on, and
    the contacts that ended.
    """
    runs, robots = known.arrivals.shape
    time, poses = k * period, known.poses
    for c in range(len(poses)):
        for r in range(runs):
            for i in range(robots):
                poses[c, r, i, 0], poses[c, r, i, 1] = poses[c, r, i, 1], truth[c, r * robots + i]
    known.counts_before[:] = known.counts
    known.since_before[:] = known.since
    ended = sweep(
        np.array([max(k - 1, 0) * period, time]), poses, world.circles, world.bodies, world.segments,
        world.counts, known.spans, known.sizes, known.goes_on, False,
        known.least, known.first, known.counts, known.ends,
        known.floor, known.since, known.depth,
    )  # fmt: skip
    begun, goes_on = False, False
    for r in range(runs):
        for i in range(robots):
            begun |= k > 0 and known.counts[r, i] > known.counts_before[r, i]
        if known.goes_on[r]:
            if k == 0:
                known.refused[r] = command[REFUSED, r * robots] > 0
            known.goes_on[r] = _judge_run(r, time, known, command)
            goes_on |= known.goes_on[r]
    return begun, goes_on, ended


@kernel
def _judge_run(r, time, known, command):  # type: ignore[no-untyped-def]
    """Note what became of one run beside contacts; return whether it goes on."""
    robots, poses, nearest = known.arrivals.shape[1], known.poses, np.inf
    left = 0
    for i in range(robots):
        x, y = poses[0, r, i, 1], poses[1, r, i, 1]
        for j in range(i + 1, robots):
            dx, dy = x - poses[0, r, j, 1], y - poses[1, r, j, 1]
            nearest = min(nearest, dx * dx + dy * dy)
        known.followed[r] |= int(command[MODE, r * robots + i]) & 3 == FOLLOW
        if known.arrivals[r, i] == np.inf:
            if math.hypot(x - known.goals[0, r, i], y - known.goals[1, r, i]) < known.near[r, i]:
                known.arrivals[r, i] = time
            else:
                left += 1
    known.nearest[r] = min(known.nearest[r], math.sqrt(nearest))
    if left == 0 or known.refused[r] or not time < known.limits[r]:
        return False
    for i in range(robots):
        if known.arrivals[r, i] == np.inf:
            known.driven[r] += 1
            known.guarded[r] += command[GUARDED, r * robots + i] > 0
    return True


@kernel
def _decide(law, k, goes_on, robots, known, memory, command, work):  # type: ignore[no-untyped-def]
    """Ask the law for the commands of the runs that go on."""
    first = 0
    for run in range(len(goes_on) + 1):
        if run == len(goes_on) or not goes_on[run]:
            if run > first:
                decide(law, k, first * robots, run * robots, known, memory, command, work)
            first = run + 1


@kernel(nogil=True)
def _periods(law, look, looks, k, end, halfway, known, world, lanes):  # type: ignore[no-untyped-def]
    """Drive and judge from period ``k`` to before ``end``; if ``halfway``, that has been judged already.

    Returns the period before which it stopped; or the one in which a contact began, or after which no run goes on, and
    the contacts that ended in it.
    """
    ended = np.empty((0, 7))
    body, told, air, trouble, period = lanes.body, lanes.known, lanes.air, lanes.trouble, lanes.period
    truth, seen, command, order, stops = body.truth, told.seen, lanes.command, lanes.order, lanes.stopped
    robots = lanes.robots
    while k < end:
        if not halfway:
            sense(k, period, body.parameters, truth, lanes.senses, seen, lanes.road, lanes.path, lanes.references)
            look(looks, k, truth, robots, told.ranges)
            hear(k, period, trouble, air)
            _decide(law, k, known.goes_on, robots, told, lanes.memory, command, lanes.work)
            obey(
                period, lanes.divergence, lanes.watchdog, truth, trouble, command, order, lanes.held_for, stops,
                lanes.lost,
            )  # fmt: skip
            begun, goes_on, ended = judge(k, known, world, period, truth, command)
            if begun or not goes_on:
                return k, ended
        halfway = False
        say(k, period, trouble.cut, air, command, truth)
        move(k, body, order, stops, lanes.lost)
        k += 1
    return k, ended


def driving() -> Any:
    """The machine code that drives and judges many periods."""
    functions = types.FunctionType(EQUATION_TYPE), types.FunctionType(LOOK_TYPE)
    return machine_code(
        _periods, *functions, LOOKS_TYPE, types.int64, types.int64, types.boolean, KNOWN_TYPE, WORLD_TYPE
    )
