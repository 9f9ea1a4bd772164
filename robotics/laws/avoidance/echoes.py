"""Echoes of robots that are known by their messages: they are no obstacles, and are left out of the readings."""

import math

from fuzzy.compiled.jit import without_refcounts
from robotics.world.paths.posture import wrapped_compiled

ROBOT_ECHO = 0.25  # m: a reading so much less than a robot's distance may be that robot
FARTHER = 0.05  # m: one so much more may be as well


@without_refcounts
def is_echo(reading, x, y, axis, half_cone, ahead, left, radius, nearer, unsure):  # type: ignore[no-untyped-def]
    """Whether a sensor's reading [m] fits a robot at a place in its own robot's frame; see :func:`without_echoes`."""
    distance = math.hypot(ahead - x, left - y)
    if not distance - nearer - unsure < reading < distance + FARTHER + unsure:
        return False
    off = abs(wrapped_compiled(math.atan2(left - y, ahead - x) - axis))
    return off < half_cone + (radius + unsure) / max(distance, 1e-6)
