"""Echoes of robots that are known by their messages: they are no obstacles, and are left out of the readings."""

import math

import numpy as np

from fuzzy.compiled.jit import kernel, without_refcounts
from robotics.laws.law import Observation
from robotics.world.paths.posture import wrapped_compiled

ROBOT_ECHO = 0.25  # m: a reading so much less than a robot's distance may be that robot
FARTHER = 0.05  # m: one so much more may be as well


def in_own_frame(seen: Observation, dx: np.ndarray, dy: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Places ``dx``, ``dy`` [m] (runs, robots, others) from each robot in its own frame: ahead, and to the left."""
    cos, sin = np.cos(seen.heading)[:, :, None], np.sin(seen.heading)[:, :, None]
    return cos * dx + sin * dy, cos * dy - sin * dx


@without_refcounts
def is_echo(reading, x, y, axis, half_cone, ahead, left, radius, nearer, unsure):  # type: ignore[no-untyped-def]
    """Whether a sensor's reading [m] fits a robot at a place in its own robot's frame; see :func:`without_echoes`."""
    distance = math.hypot(ahead - x, left - y)
    if not distance - nearer - unsure < reading < distance + FARTHER + unsure:
        return False
    off = abs(wrapped_compiled(math.atan2(left - y, ahead - x) - axis))
    return off < half_cone + (radius + unsure) / max(distance, 1e-6)


@kernel
def without_echoes(  # type: ignore[no-untyped-def]
    readings, x, y, axis, half_cone, ahead, left, known, radius, nearer, unsure
):
    """``readings`` [m] (runs, robots, sensors) without the echoes of ``known`` robots; one left out reads infinite.

    Args:
        readings: What the sensors read.
        x: Where the sensors are [m] (robots, sensors).
        y: Likewise [m].
        axis: Where they look [rad].
        half_cone: Half their cones [rad].
        ahead: The others' places in each robot's frame [m] (runs, robots, others).
        left: The same to the left.
        known: Whose echoes are left out (runs, robots, others) bool.
        radius: Of the other robots [m] (others,).
        nearer: By how much less than their distance they may read [m] (others,).
        unsure: How far they may be from those places [m] (runs, robots, others).
    """
    out = readings.copy()
    for r in range(readings.shape[0]):
        for i in range(readings.shape[1]):
            for q in range(readings.shape[2]):
                for j in range(ahead.shape[2]):
                    if known[r, i, j] and is_echo(
                        readings[r, i, q], x[i, q], y[i, q], axis[i, q], half_cone[i, q],
                        ahead[r, i, j], left[r, i, j], radius[j], nearer[j], unsure[r, i, j],
                    ):  # fmt: skip
                        out[r, i, q] = np.inf
                        break
    return out
