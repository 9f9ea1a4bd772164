"""Echoes of robots that are known by their messages: they are no obstacles, and are left out of the readings."""

from typing import Any

import numpy as np

from robotics.laws.law import Observation
from robotics.paths.posture import wrapped

NEARER = 0.25  # m: a reading so much less than a robot's distance may be that robot
FARTHER = 0.05  # m: one so much more may be as well


def in_own_frame(seen: Observation, dx: np.ndarray, dy: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Places ``dx``, ``dy`` [m] (runs, robots, others) from each robot in its own frame: ahead, and to the left."""
    cos, sin = np.cos(seen.heading)[:, :, None], np.sin(seen.heading)[:, :, None]
    return cos * dx + sin * dy, cos * dy - sin * dx


def without_echoes(
    readings: np.ndarray,
    mounts: tuple[np.ndarray, ...],
    ahead: np.ndarray,
    left: np.ndarray,
    known: np.ndarray,
    *,
    radius: Any,
    nearer: Any = NEARER,
    unsure: Any = 0.0,
) -> np.ndarray:
    """``readings`` [m] (runs, robots, sensors) without the echoes of ``known`` robots; one left out reads infinite.

    Args:
        readings: What the sensors read.
        mounts: The sensors' x [m], y [m], axis [rad] and half_cone [rad], (robots, sensors) each.
        ahead: The others' places in each robot's frame [m] (runs, robots, others).
        left: The same to the left.
        known: Whose echoes are left out (runs, robots, others) bool.
        radius: Of the other robots [m], a number or (others,).
        nearer: By how much less than their distance they may read [m].
        unsure: How far they may be from those places [m], a number or (runs, robots, others).
    """
    out = readings.copy()
    for q in range(readings.shape[-1]):
        x, y, axis, half_cone = (row[:, q, None] for row in mounts)
        distance = np.hypot(ahead - x, left - y)
        off = np.abs(wrapped(np.arctan2(left - y, ahead - x) - axis))
        reading = readings[:, :, None, q]
        fits = (reading > distance - nearer - unsure) & (reading < distance + FARTHER + unsure)
        theirs = known & fits & (off < half_cone + (radius + unsure) / np.maximum(distance, 1e-6))
        out[..., q] = np.where(theirs.any(axis=-1), np.inf, out[..., q])
    return out
