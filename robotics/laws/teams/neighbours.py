"""Sums over the messages that a robot has heard: differences, the smallest value, and the time of an outage."""

import numpy as np

from fuzzy.compiled.jit import kernel
from robotics.laws.equation import uncounted
from robotics.radio.channel import AGE, HEARS, Heard

OUTAGE = 0.5  # s without a message: the robot is alone, and its watchdog stops it
SEARCH_REACH = 0.5  # m: how far from its last place on the path a robot looks for the next
SEARCH_REACH_AFTER_OUTAGE = 3.0  # m: the same for a robot that was alone


def differences(mine: np.ndarray, theirs: np.ndarray, weights: np.ndarray) -> np.ndarray:
    """Σ_j a_ij (mine_i − theirs_ij) (runs, robots), over the neighbours that were heard.

    ``mine`` is (runs, robots), ``theirs`` (runs, receivers, senders), ``weights`` (robots, robots) are the a_ij.
    """
    mine, theirs = np.ascontiguousarray(mine, dtype=float), np.ascontiguousarray(theirs, dtype=float)
    return np.asarray(_differences(mine, theirs, np.ascontiguousarray(weights, dtype=float)))


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


@uncounted
def reach_of(heard, i, time):  # type: ignore[no-untyped-def]
    """The distance [m] from its last place within which the robot of lane i looks for the next: :func:`search_reach`.

    ``heard`` (planes, lanes, robots) is what the lanes hear.
    """
    alone = time
    for j in range(heard.shape[2]):
        if heard[HEARS, i, j] > 0 and heard[AGE, i, j] < alone:
            alone = heard[AGE, i, j]
    return SEARCH_REACH_AFTER_OUTAGE if alone > OUTAGE else SEARCH_REACH


@kernel
def _differences(mine, theirs, weights):  # type: ignore[no-untyped-def]
    out = np.zeros(mine.shape)
    for r in range(mine.shape[0]):
        for i in range(mine.shape[1]):
            for j in range(mine.shape[1]):
                gap = mine[r, i] - theirs[r, i, j]
                if weights[i, j] != 0 and not np.isnan(gap):
                    out[r, i] += gap * weights[i, j]
    return out


@kernel
def _least(mine, theirs, hears):  # type: ignore[no-untyped-def]
    out = mine.copy()
    for r in range(mine.shape[0]):
        for i in range(mine.shape[1]):
            for j in range(mine.shape[1]):
                if hears[i, j] and theirs[r, i, j] < out[r, i]:
                    out[r, i] = theirs[r, i, j]
    return out
