"""The judge of runs: an observer that notes arrivals, distances, contacts, and which runs go on.

What is known of a run is kept in columns, which :func:`judge` carries on in place from period to period. Of a run that
is over nothing changes any more, so that it does not matter which runs are beside it.
"""

import math
from typing import NamedTuple

import numpy as np

from fuzzy.compiled.columns import Bools1, Floats1, Floats2, Floats3, Floats4, Ints1, Ints2, Ints3
from fuzzy.compiled.jit import kernel
from robotics.environment.swept import ContactNotes, sweep
from robotics.environment.world import Geometry, Moving, place
from robotics.laws.equation import CommandColumns
from robotics.laws.modes import FOLLOW
from robotics.simulation.observer import observer


class WorldInTime(NamedTuple):
    """The obstacles one period ago and now, or once, if they rest: the fields of Geometry, by time."""

    circles: Floats4
    bodies: Ints3
    segments: Floats4
    counts: Ints1


class JudgeNotes(NamedTuple):
    """What is known of all runs up to a period."""

    sizes: Floats2  # (3, robots) m: as of robotics.environment.collision.footprints
    goals: Floats3  # (2, runs, robots) m: x and y of the paths' ends
    near: Floats2  # (runs, robots) m: a robot this near its goal is there
    limits: Floats1  # (runs,) s: the longest that each run takes
    goes_on: Bools1  # (runs,)
    arrivals: Floats2  # (runs, robots) s; infinite: not yet
    refused: Bools1  # (runs,): the law said before the start that there is no safe plan
    nearest: Floats1  # (runs,) m: the least distance between the centers of two robots
    followed: Bools1  # (runs,): a robot followed a wall
    driven: Ints1  # (runs,): periods of robots that had not yet arrived, while their run went on
    guarded: Ints1  # (runs,): those of them in which the emergency rule acted
    poses: Floats4  # (5, runs, robots, 2): x [m], y [m], heading [rad], v [m/s], ω [rad/s] one period ago, and now
    counts_before: Ints2  # (runs, robots): counts one period ago
    since_before: Floats2  # (runs, pairs) s: since one period ago
    contacts: ContactNotes
    world: WorldInTime
    here: Geometry  # where obstacles that move are placed
    moving: Moving
    ended: Floats2  # (contacts, 7): those that ended in the last period, as of robotics.environment.swept.sweep
    many: Ints1  # (1,): how many they are
    stops: int  # 1: the law of a run that is over is not asked any more


@observer
def judge(moment, notes):  # type: ignore[no-untyped-def]
    """Carry the notes on; ask where a contact began since the last period, or where no run goes on any more."""
    k, period, known = moment.k, moment.period, notes
    runs, robots = known.arrivals.shape
    time, poses = k * period, known.poses
    for c in range(len(poses)):
        for r in range(runs):
            for i in range(robots):
                poses[c, r, i, 0], poses[c, r, i, 1] = poses[c, r, i, 1], moment.truth[c, r * robots + i]
    known.counts_before[:] = known.contacts.counts
    known.since_before[:] = known.contacts.since
    world = known.world
    if k > 0 and len(world.circles) > 1:
        world.circles[0], world.segments[0] = world.circles[1], world.segments[1]
        place(known.here, known.moving, k)
        world.circles[1], world.segments[1] = known.here.circles, known.here.segments
    times = np.array([max(k - 1, 0) * period, time])
    ended = sweep(
        times, poses, world.circles, world.bodies, world.segments, world.counts, known.sizes, known.goes_on, False,
        known.contacts,
    )  # fmt: skip
    known.many[0] = len(ended)
    known.ended[: len(ended)] = ended
    begun, goes_on = False, False
    for r in range(runs):
        for i in range(robots):
            begun |= k > 0 and known.contacts.counts[r, i] > known.counts_before[r, i]
        if known.goes_on[r]:
            if k == 0:
                known.refused[r] = CommandColumns(moment.command, r * robots).refused > 0
            known.goes_on[r] = _judge_run(r, time, known, moment.command)
            goes_on |= known.goes_on[r]
            if known.stops == 1:
                moment.goes_on[r] = known.goes_on[r]
    return begun or not goes_on


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
        known.followed[r] |= int(CommandColumns(command, r * robots + i).mode) & 3 == FOLLOW
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
            known.guarded[r] += CommandColumns(command, r * robots + i).guarded > 0
    return True
