"""Artificial potential field: drawn along the path, pushed away by all that the sensors see [Khatib 1986].

The velocity wanted is added to one from each thing seen, as the gradient of Khatib's potential, with ρ the distance
from the circle in which the robot turns, and ρ0 the distance from which on nothing pushes:

    v = speed e + Σ strength (1/ρ − 1/ρ0) ρ0/ρ · (−direction to it)

Its minima are where the robot stays: between an obstacle and the way behind it, and in every trap.
"""

import math
from dataclasses import dataclass

from fuzzy.quantity import quantity
from robotics.laws.equation import equation
from robotics.plugins.reactive.along import AlongPath, drive, look_around, wanted

_NEAREST = 0.01  # m: the least distance that counts
_MOST = 2.0  # times the fastest speed: no thing pushes more
_SECTORS = 12  # around the robot: of what is seen in each, the nearest point pushes, be it seen by one beam or by many


@equation
def follow_gradient(robot, gain, memory, command, work, known, i, table):  # type: ignore[no-untyped-def]
    """Add the pushes of all that is seen to the velocity wanted."""
    speed, course = wanted(robot, gain, memory, command, known, i)
    radius, rho0, points = table[i % known.heard.shape[2]], gain.influence, work.points
    v_x, v_y = speed * math.cos(course), speed * math.sin(course)
    count = look_around(robot, gain, memory, known, i, table, radius + rho0, points)
    for sector in range(_SECTORS):
        rho, away = rho0, 0.0
        for n in range(count):
            angle = math.atan2(points[2 * n + 1], points[2 * n])
            if int((angle / math.pi + 1) / 2 * _SECTORS) % _SECTORS == sector:
                apart = max(math.hypot(points[2 * n], points[2 * n + 1]) - radius, _NEAREST)
                if apart < rho:
                    rho, away = apart, angle + robot.heading
        push = min(gain.strength * (1 / rho - 1 / rho0) * rho0 / rho, _MOST * gain.fastest)
        v_x, v_y = v_x - push * math.cos(away), v_y - push * math.sin(away)
    most = min(1.0, gain.fastest / max(math.hypot(v_x, v_y), 1e-9))
    drive(command, robot, gain, most * v_x, most * v_y)


@dataclass(frozen=True, kw_only=True)
class PotentialField(AlongPath):
    """A potential field: how far and how strongly things push."""

    influence: float = quantity(0.5, "m", above=0, most=10)  # ρ0
    strength: float = quantity(0.05, "m²/s", above=0, most=10)

    equation = follow_gradient
