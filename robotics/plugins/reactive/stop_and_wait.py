"""Stop and wait: along the path, and standing still while a sensor sees something ahead that is too near.

The simplest law that is safe against what stands: it stops within its braking distance and ``near``, and waits until
the way is free. What stands for good stops it for good.
"""

import math
from dataclasses import dataclass

from fuzzy.quantity import quantity
from robotics.laws.equation import equation
from robotics.laws.modes import TRACK, YIELD
from robotics.plugins.reactive.along import AlongPath, drive, look_around, tell, wanted


@equation
def stop_and_wait(robot, gain, memory, command, work, known, i, table):  # type: ignore[no-untyped-def]
    """Drive along the path unless something is ahead."""
    speed, course = wanted(robot, gain, memory, command, known, i)
    radius, v, points = table[i % known.heard.shape[2]], abs(robot.v), work.points
    far = radius + gain.near + gain.delay * v + v * v / (2 * gain.braking)
    stands = False
    for n in range(look_around(robot, gain, memory, known, i, table, far, points)):
        stands = stands or (0 < points[2 * n] < far and abs(points[2 * n + 1]) < radius + gain.beside)
    command.mode = YIELD if stands else TRACK
    if stands:
        tell(command, 0.0, 0.0)
    else:
        drive(command, robot, gain, speed * math.cos(course), speed * math.sin(course))


@dataclass(frozen=True, kw_only=True)
class StopAndWait(AlongPath):
    """Stop and wait: how near is too near."""

    near: float = quantity(0.15, "m", above=0, most=5)  # before the circle in which the robot turns
    beside: float = quantity(0.03, "m", above=0, most=2)  # to either side of it
    delay: float = quantity(0.3, "s", above=0, most=5)  # until a command acts, and until sensors see
    braking: float = quantity(1.0, "m/s²", above=0, most=20)

    equation = stop_and_wait
    has_modes = True
