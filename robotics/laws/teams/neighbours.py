"""Sums over the messages that a robot has heard: differences, the smallest value, and the time of an outage.

In equations of one robot ``heard`` is :attr:`robotics.laws.equation.Known.heard` and ``i`` the robot's lane; a value
and the rate at which it changes are places in the law's message.
"""

import math

import numpy as np

from fuzzy.compiled.jit import kernel, uncounted
from robotics.radio.channel import AGE, BELIEVED, HEARD, HEARS, Heard

OUTAGE = 0.5  # s without a message: the robot is alone, and its watchdog stops it
SEARCH_REACH = 0.5  # m: how far from its last place on the path a robot looks for the next
SEARCH_REACH_AFTER_OUTAGE = 3.0  # m: the same for a robot that was alone


# Of one robot -----------------------------------------------------------------------------------------------------


@uncounted
def heard_now(heard, i, j, value, rate):  # type: ignore[no-untyped-def]
    """What robot ``j`` of the run said of a value, predicted for now; not-a-number before its first message.

    A rate is believed for BELIEVED seconds.
    """
    return heard[HEARD + value, i, j] + heard[HEARD + rate, i, j] * min(heard[AGE, i, j], BELIEVED)


@uncounted
def difference(heard, i, mine, value, rate, weight):  # type: ignore[no-untyped-def]
    """Σ_j a_ij (mine − theirs_j) over the neighbours that were heard; a_ij is ``weight`` for every link."""
    total = 0.0
    for j in range(heard.shape[2]):
        if heard[HEARS, i, j] > 0:
            gap = mine - heard_now(heard, i, j, value, rate)
            if not math.isnan(gap):
                total += gap * weight
    return total


@uncounted
def smallest(heard, i, mine, value, rate):  # type: ignore[no-untyped-def]
    """The smallest of a robot's own value and its neighbours' that were heard."""
    for j in range(heard.shape[2]):
        if heard[HEARS, i, j] > 0:
            theirs = heard_now(heard, i, j, value, rate)
            mine = theirs if theirs < mine else mine
    return mine


@uncounted
def alone(heard, i, time):  # type: ignore[no-untyped-def]
    """The time [s] since the newest message that the robot heard was sent, at most ``time`` [s]."""
    for j in range(heard.shape[2]):
        if heard[HEARS, i, j] > 0 and heard[AGE, i, j] < time:
            time = heard[AGE, i, j]
    return time


@uncounted
def reach(heard, i, time):  # type: ignore[no-untyped-def]
    """The distance [m] from its last place within which the robot looks for the next on its path, at ``time`` [s]."""
    return SEARCH_REACH_AFTER_OUTAGE if alone(heard, i, time) > OUTAGE else SEARCH_REACH


# Of all robots at once --------------------------------------------------------------------------------------------


def smallest_heard(mine: np.ndarray, theirs: np.ndarray, hears: np.ndarray) -> np.ndarray:
    """The smallest of a robot's own value and its neighbours' that were heard (runs, robots).

    ``mine`` is (runs, robots), ``theirs`` (runs, receivers, senders), ``hears`` (receivers, senders) bool.
    """
    mine, theirs = np.ascontiguousarray(mine, dtype=float), np.ascontiguousarray(theirs, dtype=float)
    return np.asarray(_least(mine, theirs, np.ascontiguousarray(hears, dtype=bool)))


def alone_for(heard: Heard, time: float) -> np.ndarray:
    """The time [s] (runs, robots) since the newest message that each robot heard was sent, at most ``time`` [s]."""
    return np.asarray(_least(np.full(heard.age.shape[:2], float(time)), heard.age, heard.hears))


def search_reach(heard: Heard, time: float) -> np.ndarray:
    """The distance [m] (runs, robots) from its last place within which each robot looks for the next on its path."""
    return np.where(alone_for(heard, time) > OUTAGE, SEARCH_REACH_AFTER_OUTAGE, SEARCH_REACH)


@kernel
def _least(mine, theirs, hears):  # type: ignore[no-untyped-def]
    out = mine.copy()
    for r in range(mine.shape[0]):
        for i in range(mine.shape[1]):
            for j in range(mine.shape[1]):
                if hears[i, j] and theirs[r, i, j] < out[r, i]:
                    out[r, i] = theirs[r, i, j]
    return out
