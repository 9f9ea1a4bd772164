"""The judge of runs: an observer that notes arrivals, distances, contacts, and which runs go on.

What is known of a run is kept in columns, which :func:`judge` carries on in place from period to period. Of a run that
is over nothing changes any more, so that it does not matter which runs are beside it.
"""

import math
from typing import NamedTuple

import numpy as np

from fuzzy.compiled.columns import Bools1, Floats1, Floats2, Floats3, Ints1, Ints2
from fuzzy.compiled.jit import compiled_only
from robotics.laws.equation import CommandColumns
from robotics.laws.modes import FOLLOW
from robotics.measures.arrival import at_end_compiled
from robotics.simulation.observer import observer
from robotics.world.environment.swept import ContactWatch, watch_contacts


class JudgeNotes(NamedTuple):
    """What is known of all runs up to a period."""

    goals: Floats3  # (4, runs, robots): x [m], y [m] and heading [rad] of the paths' ends, and their lengths [m]
    limits: Floats1  # (runs,) s: the longest that each run takes
    arrivals: Floats2  # (runs, robots) s; infinite: not yet
    refused: Bools1  # (runs,): the law said before the start that there is no safe plan
    nearest: Floats1  # (runs,) m: the least distance between the centers of two robots
    followed: Bools1  # (runs,): a robot followed a wall
    driven: Ints1  # (runs,): periods of robots that had not yet arrived, while their run went on
    guarded: Ints1  # (runs,): those of them in which the emergency rule acted
    counts_before: Ints2  # (runs, robots): counts one period ago
    since_before: Floats2  # (runs, pairs) s: since one period ago
    watch: ContactWatch  # of the runs that go on
    ended: Floats2  # (contacts, 7): those that ended in the last period, as of robotics.world.environment.swept.sweep
    many: Ints1  # (1,): how many they are
    stops: int  # 1: a run that is over does not go on


@observer
def judge(moment, notes):  # type: ignore[no-untyped-def]
    """Carry the notes on; ask where a contact began since the last period, or where no run goes on any more."""
    k, period, known, watch = moment.k, moment.period, notes, notes.watch
    runs, robots = known.arrivals.shape
    time, contacts, goes_on = k * period, watch.contacts, watch.going
    known.counts_before[:] = contacts.counts
    known.since_before[:] = contacts.since
    ended = watch_contacts(k, np.array([max(k - 1, 0) * period, time]), moment.truth, watch)
    known.many[0] = len(ended)
    known.ended[: len(ended)] = ended
    begun, some_go_on = False, False
    for r in range(runs):
        for i in range(robots):
            begun |= k > 0 and contacts.counts[r, i] > known.counts_before[r, i]
        if goes_on[r]:
            if k == 0:
                known.refused[r] = CommandColumns(moment.command, r * robots).refused > 0
            goes_on[r] = _judge_run(r, time, known, moment.command)
            some_go_on |= goes_on[r]
            if known.stops == 1:
                moment.goes_on[r] = goes_on[r]
    return begun or not some_go_on


@compiled_only
def _judge_run(r, time, known, command):  # type: ignore[no-untyped-def]
    """Note what became of one run beside contacts; return whether it goes on."""
    robots, poses, nearest = known.arrivals.shape[1], known.watch.poses, np.inf
    left = 0
    for i in range(robots):
        x, y = poses[0, r, i, 1], poses[1, r, i, 1]
        for j in range(i + 1, robots):
            dx, dy = x - poses[0, r, j, 1], y - poses[1, r, j, 1]
            nearest = min(nearest, dx * dx + dy * dy)
        known.followed[r] |= int(CommandColumns(command, r * robots + i).mode) & 3 == FOLLOW
        if known.arrivals[r, i] == np.inf:
            goals = known.goals
            if at_end_compiled(x, y, goals[0, r, i], goals[1, r, i], goals[2, r, i], goals[3, r, i]):
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
