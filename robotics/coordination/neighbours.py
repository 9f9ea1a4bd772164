"""What a robot makes of what it has heard: values brought up to date, and how long it has been alone."""

import numpy as np

from robotics.radio import Heard

ALONE = 0.5  # s without a message: an outage
PATIENCE = 0.5  # s: how long a rate that was heard is believed; after that the value is kept as it was


def current(heard: Heard, value: int, rate: int) -> np.ndarray:
    """Field ``value`` of every neighbour now (runs, receivers, senders), by field ``rate``; not-a-number: unheard."""
    return np.asarray(heard.values[value] + heard.values[rate] * np.minimum(heard.age, PATIENCE))


def differences(mine: np.ndarray, theirs: np.ndarray, weights: np.ndarray) -> np.ndarray:
    """Σ_j a_ij (own − theirs_j) (runs, robots), over those that were heard; ``weights`` (robots, robots) are a_ij."""
    gap = mine[:, :, None] - theirs
    return np.asarray(np.where(np.isnan(gap), 0.0, gap * weights).sum(axis=-1))


def least(mine: np.ndarray, theirs: np.ndarray, hears: np.ndarray) -> np.ndarray:
    """The smallest of the own value (runs, robots) and the neighbours' (runs, receivers, senders) that were heard."""
    heard = np.where(hears & ~np.isnan(theirs), theirs, np.inf)
    return np.asarray(np.minimum(mine, heard.min(axis=-1)))


def alone_for(heard: Heard, time: float) -> np.ndarray:
    """How long each robot has heard nobody [s] (runs, robots): the age of its newest message, at most ``time``."""
    newest = np.where(heard.hears, heard.age, np.inf).min(axis=-1)
    return np.asarray(np.minimum(newest, time))
