"""What a robot makes of what it has heard: values brought up to date, and how long it has been alone."""

import numpy as np

from fuzzy.compiled.jit import kernel
from robotics.radio.channel import Heard

ALONE = 0.5  # s without a message: an outage
PATIENCE = 0.5  # s: how long a rate that was heard is believed; after that the value is kept as it was


def current(heard: Heard, value: int, rate: int) -> np.ndarray:
    """Field ``value`` of every neighbour now (runs, receivers, senders), by field ``rate``; not-a-number: unheard."""
    return np.asarray(_current(heard.values[value], heard.values[rate], heard.age, PATIENCE))


def differences(mine: np.ndarray, theirs: np.ndarray, weights: np.ndarray) -> np.ndarray:
    """Σ_j a_ij (own − theirs_j) (runs, robots), over those that were heard; ``weights`` (robots, robots) are a_ij."""
    mine, theirs = np.ascontiguousarray(mine, dtype=float), np.ascontiguousarray(theirs, dtype=float)
    return np.asarray(_differences(mine, theirs, np.ascontiguousarray(weights, dtype=float)))


def least(mine: np.ndarray, theirs: np.ndarray, hears: np.ndarray) -> np.ndarray:
    """The smallest of the own value (runs, robots) and the neighbours' (runs, receivers, senders) that were heard."""
    mine, theirs = np.ascontiguousarray(mine, dtype=float), np.ascontiguousarray(theirs, dtype=float)
    return np.asarray(_least(mine, theirs, np.ascontiguousarray(hears, dtype=bool)))


def alone_for(heard: Heard, time: float) -> np.ndarray:
    """How long each robot has heard nobody [s] (runs, robots): the age of its newest message, at most ``time``."""
    return np.asarray(_least(np.full(heard.age.shape[:2], float(time)), heard.age, heard.hears))


@kernel
def _current(values, rates, age, longest):  # type: ignore[no-untyped-def]
    out = np.empty(values.shape)
    for r in range(values.shape[0]):
        for i in range(values.shape[1]):
            for j in range(values.shape[2]):
                out[r, i, j] = values[r, i, j] + rates[r, i, j] * min(age[r, i, j], longest)
    return out


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
