"""The posture error (5.9): a target as a robot sees it; and angles brought into one turn."""

from typing import Any, NamedTuple

import numpy as np

from fuzzy.compiled.jit import kernel
from robotics.world.paths.references import Reference


class PostureError(NamedTuple):
    """The place and heading of a target as a robot sees it; each field is (runs, robots)."""

    x: np.ndarray  # m, ahead
    y: np.ndarray  # m, to the left
    heading: np.ndarray  # rad in [-π, π)


def wrapped(angle: np.ndarray) -> np.ndarray:
    """``angle`` [rad] brought into [-π, π)."""
    return (angle + np.pi) % (2 * np.pi) - np.pi


@kernel
def wrapped_compiled(angle):  # type: ignore[no-untyped-def]
    """The same, for one angle in a compiled loop; of most the remainder is what they are, and not looked for."""
    turned = angle + np.pi
    return (turned if 0 <= turned < 2 * np.pi else turned % (2 * np.pi)) - np.pi


def posture_error(x: Any, y: Any, heading: Any, target: Reference) -> PostureError:
    """The target minus the pose, in the robot's frame: thesis (5.9), desired − actual.

    (2.28) prints actual − desired, with which (2.30) would be positive feedback. Every law here uses (5.9).

    Args:
        x: The robot's x [m], of any shape.
        y: The robot's y [m].
        heading: The robot's heading [rad].
        target: The target, whose fields fit that shape.
    """
    dx, dy = target.x - x, target.y - y
    cos, sin = np.cos(heading), np.sin(heading)
    return PostureError(cos * dx + sin * dy, cos * dy - sin * dx, wrapped(target.heading - heading))
