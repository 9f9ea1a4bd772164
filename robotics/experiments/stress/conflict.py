"""Paths of random teams: which of them are too tight, too near to each other's ends, or in conflict."""

import numpy as np

from robotics.paths.path import Quintic

CLEAR = 0.6  # m: starts and ends are at least this far from the other paths
CONFLICT = 0.4  # m: robots on time that come nearer than this are in conflict
TIGHTEST = 0.35  # m: the smallest radius of a path
_SAMPLES = 101  # points of a path between which distances are taken
_FINE = np.linspace(0.0, 1.0, 201)  # values of its parameter from which its length is taken


def evenly(shape: Quintic) -> np.ndarray | None:
    """Points (samples, 2) [m] at equal shares of a path's length, to a few millimetres; None if it is too tight."""
    position, slope, bend = shape.curve(_FINE)
    if np.any(np.abs(slope[0] * bend[1] - slope[1] * bend[0]) * TIGHTEST > np.hypot(*slope) ** 3):
        return None
    measured = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(position, axis=1)))])
    wanted = np.linspace(0.0, measured[-1], _SAMPLES)
    return np.stack([np.interp(wanted, measured, row) for row in position], axis=1)


def ends_clear(a: np.ndarray, b: np.ndarray) -> bool:
    """Whether both paths (samples, 2) [m] keep CLEAR of the ends of the other."""
    ends = [(a[0], b), (a[-1], b), (b[0], a), (b[-1], a)]
    return all(np.hypot(*(path - end).T).min() >= CLEAR for end, path in ends)


def in_conflict(points: np.ndarray) -> bool:
    """Whether two robots come nearer than CONFLICT at equal progress; ``points`` (robots, samples, 2) [m]."""
    gap = np.hypot(*np.moveaxis(points[:, None] - points[None], -1, 0)).min(axis=-1)
    gap[np.diag_indices(len(points))] = np.inf
    return bool(gap.min() < CONFLICT)
