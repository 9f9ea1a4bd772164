"""Postures in the plane: from quaternions and back, from one frame to another, and headings that do not jump."""

from math import atan2, cos, hypot, pi, remainder, sin
from typing import NamedTuple


class Posture(NamedTuple):
    """A place and a heading, as REP-103 counts them."""

    x: float  # m
    y: float  # m
    heading: float  # rad, counter-clockwise

    def inside(self, frame: "Posture") -> "Posture":
        """This posture, given in ``frame``, as seen from where ``frame`` is given."""
        c, s = cos(frame.heading), sin(frame.heading)
        x, y = frame.x + c * self.x - s * self.y, frame.y + s * self.x + c * self.y
        return Posture(x, y, frame.heading + self.heading)

    def frame_of(self, same: "Posture") -> "Posture":
        """The frame in which this posture is ``same``: ``same.inside(posture.frame_of(same))`` is the posture."""
        turn = self.heading - same.heading
        c, s = cos(turn), sin(turn)
        return Posture(self.x - c * same.x + s * same.y, self.y - s * same.x - c * same.y, turn)


HERE = Posture(0.0, 0.0, 0.0)


def heading_of(x: float, y: float, z: float, w: float) -> float:
    """The heading [rad] in [-π, π] of a quaternion, whose roll and pitch play no part.

    Raises ValueError for one without a length, as messages hold that nobody has filled in.
    """
    if not hypot(x, y, z, w) > 1e-6:
        raise ValueError("the quaternion of the orientation has no length")
    return atan2(2 * (w * z + x * y), w * w + x * x - y * y - z * z)


def quaternion(heading: float) -> tuple[float, float]:
    """The z and w of the quaternion of a ``heading`` [rad]; its x and y are 0."""
    return sin(heading / 2), cos(heading / 2)


def continued(heading: float, last: float) -> float:
    """``heading`` [rad] by as many turns more or less that it lies within half a turn of ``last``."""
    return last + remainder(heading - last, 2 * pi)
