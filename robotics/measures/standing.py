"""Robots that stand still: the one definition, by the speed below which a robot counts as standing."""

import numpy as np

from robotics.simulation.run import Run

STANDSTILL = 0.01  # m/s: a robot that is slower stands still
MOVING = 0.05  # m/s: a robot that is faster moves enough to be seen in a picture


def stands_still(v: np.ndarray, below: float = STANDSTILL) -> np.ndarray:
    """Whether robots with the speeds ``v`` [m/s] stand still, slower than ``below`` [m/s]; bool, of the same shape."""
    return np.asarray(np.abs(v) < below)


def last_move(run: Run, place: int) -> int:
    """The last sample at which a robot of the run at ``place`` visibly moves; the run's last, if none ever does."""
    moving = (np.abs(np.nan_to_num(run["v"][place])) > MOVING).any(axis=0)
    return int(np.flatnonzero(moving)[-1]) if moving.any() else len(run.time) - 1
