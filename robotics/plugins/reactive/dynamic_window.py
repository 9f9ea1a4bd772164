"""Dynamic window approach: of the velocities that the wheels can reach within a moment, the best that can still stop.

Each v and ω that the accelerations allow within ``window`` is an arc. Of an arc is known how far it is free of all that
the sensors see, in closed form; it is admissible if the robot can stop on that way, v² ≤ 2 a (way − least). Of the
admissible arcs it drives the one with the largest [Fox, Burgard and Thrun 1997]

    heading (1 − |bearing of the target from its end|/π) + clearance min(way, far)/far + velocity (1 − |v − v*|/fastest)

with v* the speed wanted. The target is a direction near that of the path in which the way is free, which on a robot the
planner above gives. To stand and turn is always admissible.
"""

import math
from dataclasses import dataclass

import numpy as np

from fuzzy.compiled.jit import compiled_only
from fuzzy.quantity import quantity
from robotics.laws.equation import equation
from robotics.laws.setting import Setting
from robotics.plugins.reactive.along import DRIVEN_OFF, AlongPath, around, look_around, tell, wanted
from robotics.world.paths.posture import wrapped_compiled

_SPEEDS = 5  # of the arcs that are looked at
_TURNS = 13  # turn rates, likewise
_FAR = 1.5  # m: what is farther free counts no more
_STRAIGHT = 0.02  # rad/s: slower turns are taken for none
_AHEAD = 1.0  # s: the end of an arc, at which the bearing of the target is taken


@compiled_only
def free_way(v, w, radius, x, y):  # type: ignore[no-untyped-def]
    """How far [m] an arc is driven until a disc of that ``radius`` [m] touches the point (x, y) [m]; inf: it does not.

    The robot is at (0, 0) and drives along x with v > 0 [m/s] and ω [rad/s].
    """
    radius = min(radius, DRIVEN_OFF * math.hypot(x, y))
    if abs(w) < _STRAIGHT:
        if abs(y) >= radius or x <= 0:
            return math.inf
        return max(x - math.sqrt(radius * radius - y * y), 0.0)
    rho = v / w  # the center of the circle is at (0, ρ)
    d, size = math.hypot(x, y - rho), abs(rho)
    if abs(d - size) >= radius or d < 1e-9 or size < 1e-9:
        return math.inf if math.hypot(x, y) >= radius else 0.0
    around = math.atan2(x, size - (y if rho > 0 else -y)) % (2 * math.pi)
    before = math.acos(min(max((size * size + d * d - radius * radius) / (2 * size * d), -1.0), 1.0))
    return 0.0 if around < before or around > 2 * math.pi - before else size * (around - before)


@equation
def choose_arc(robot, gain, memory, command, work, known, i, table):  # type: ignore[no-untyped-def]
    """Look at all arcs of the window, and drive the best."""
    speed, course = wanted(robot, gain, memory, command, known, i)
    points, radius = work.points, table[i % known.heard.shape[2]] + gain.margin
    count = look_around(robot, gain, memory, known, i, table, _FAR + radius, points)
    course = around(memory, points, count, radius, course, robot.heading, gain.clears)
    bearing = wrapped_compiled(course - robot.heading)
    slowest, quickest = max(robot.v - gain.acceleration * gain.window, 0.0), robot.v + gain.acceleration * gain.window
    quickest = max(min(quickest, speed), slowest)
    best, best_v, best_w = -math.inf, 0.0, 0.0
    for a in range(_SPEEDS + 1):
        v = 0.0 if a == _SPEEDS else slowest + (quickest - slowest) * a / (_SPEEDS - 1)
        for b in range(_TURNS):
            w = robot.w + gain.turning * gain.window * (2 * b / (_TURNS - 1) - 1)
            w = min(max(w, -gain.quickest), gain.quickest)
            way = _FAR
            if v > 1e-3:
                for n in range(count):
                    way = min(way, free_way(v, w, radius, points[2 * n], points[2 * n + 1]))
                if v * v > 2 * gain.braking * max(way - gain.delay * v, 0.0):
                    continue
            facing = abs(wrapped_compiled(bearing - w * _AHEAD))
            value = gain.heading * (1 - facing / math.pi) + gain.clearance * way / _FAR
            value += gain.velocity * (1 - abs(v - speed) / gain.fastest)
            if value > best:
                best, best_v, best_w = value, v, w
    tell(command, best_v, best_w if speed > 1e-3 else 0.0)


@dataclass(frozen=True, kw_only=True)
class DynamicWindow(AlongPath):
    """Dynamic window: what can be reached, how it stops, and the weights; ratios of weights as in the paper."""

    heading: float = quantity(2.0, "1", above=0, most=100)
    clearance: float = quantity(0.2, "1", above=0, most=100)
    velocity: float = quantity(0.4, "1", above=0, most=100)
    window: float = quantity(0.25, "s", above=0, most=5)
    acceleration: float = quantity(1.0, "m/s²", above=0, most=20)
    turning: float = quantity(6.0, "rad/s²", above=0, most=100)
    quickest: float = quantity(1.5, "rad/s", above=0, most=20)
    braking: float = quantity(0.5, "m/s²", above=0, most=20)
    delay: float = quantity(0.3, "s", above=0, most=5)  # until a command acts, and until sensors see
    clears: float = quantity(0.6, "m", above=0, most=10)  # the way that is free in the direction it turns to
    margin: float = quantity(0.04, "m", above=0, most=2)

    equation = choose_arc

    def misgivings(self, setting: Setting) -> tuple[str, ...]:
        """Say where robots see nothing to all sides: an arc is taken for free where no sensor looks."""
        seen = [sum(2 * max(s.half_cone, 0.05) for s in own.values()) for own in setting.sensors]
        if not seen or min(seen) >= np.pi:
            return ()
        return (f"{setting.name}: the range sensors see less than half of what is around; what none sees counts free",)
