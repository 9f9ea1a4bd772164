"""Paths of random teams: which of them are too tight, too near to each other's ends, or in conflict."""

import math

import numpy as np

from fuzzy.compiled.jit import kernel
from robotics.laws.avoidance.reservation import square
from robotics.plugins.stress.quintic_table import bend, coefficients, place, slope
from robotics.world.paths.path import Quintic

CLEAR = 0.6  # m: starts and ends are at least this far from the other paths
CONFLICT = 0.4  # m: robots on time that come nearer than this are in conflict
TIGHTEST = 0.35  # m: the smallest radius of a path
SAMPLES = 101  # points of a path between which distances are taken
_FINE = 201  # values of its parameter from which its length is taken


def evenly(shape: Quintic) -> np.ndarray | None:
    """Points (samples, 2) [m] at equal shares of a path's length, to a few millimetres; None if it is too tight."""
    points = np.empty((SAMPLES, 2))
    return points if sampled_evenly(coefficients(shape), points) else None


@kernel
def sampled_evenly(shape, points):  # type: ignore[no-untyped-def]
    """Fill in the ``points`` of :func:`evenly`; ``shape`` are coefficients. Returns whether the path is wide enough."""
    x, y, h = shape[0], shape[1], 1 / (_FINE - 1)
    for k in range(_FINE):
        u = k * h
        dx, dy = slope(x, u), slope(y, u)
        if abs(dx * bend(y, u) - dy * bend(x, u)) * TIGHTEST > math.hypot(dx, dy) ** 3:
            return False
    measured, fine = np.zeros(_FINE), np.empty((_FINE, 2))
    for k in range(_FINE):
        fine[k, 0], fine[k, 1] = place(x, k * h), place(y, k * h)
        if k > 0:
            measured[k] = measured[k - 1] + math.hypot(fine[k, 0] - fine[k - 1, 0], fine[k, 1] - fine[k - 1, 1])
    k, cells = 0, SAMPLES - 1
    for n in range(SAMPLES):
        s = n * (measured[_FINE - 1] / cells) if n < cells else measured[_FINE - 1]
        while k < _FINE - 2 and measured[k + 1] <= s:
            k += 1
        share = (s - measured[k]) / (measured[k + 1] - measured[k])
        for axis in range(2):
            points[n, axis] = fine[k, axis] + share * (fine[k + 1, axis] - fine[k, axis])
    return True


@kernel
def ends_clear(a, b):  # type: ignore[no-untyped-def]
    """Whether both paths (samples, 2) [m] keep CLEAR of the ends of the other."""
    last = len(a) - 1
    for end in (0, last):
        for k in range(len(a)):
            if square(a[end], b[k]) < CLEAR * CLEAR or square(b[end], a[k]) < CLEAR * CLEAR:
                return False
    return True


@kernel
def ends_apart(a, b, apart):  # type: ignore[no-untyped-def]
    """Whether the starts of two paths (samples, 2) [m], and their ends, are ``apart`` [m] or more."""
    last = len(a) - 1
    return square(a[0], b[0]) >= apart * apart and square(a[last], b[last]) >= apart * apart


@kernel
def in_conflict(points):  # type: ignore[no-untyped-def]
    """Whether two robots come nearer than CONFLICT at equal progress; ``points`` (robots, samples, 2) [m]."""
    for i in range(points.shape[0]):
        for j in range(i):
            for k in range(points.shape[1]):
                if square(points[i, k], points[j, k]) < CONFLICT * CONFLICT:
                    return True
    return False
