"""The rule by which every robot brakes for another that is ahead of it: which of two stops, and which goes on."""

import math
from collections.abc import Sequence

import numpy as np

from fuzzy.compiled.columns import Columns, column
from fuzzy.compiled.jit import without_refcounts
from robotics.world.paths.posture import wrapped_compiled
from robotics.world.radio.channel import predicted
from robotics.world.vehicle.robot import Robot

STATED_FOR = float(np.hypot(0.23, 0.20))  # m: turning circle's diameter of the robots for which laws state distances
CONE = 0.9  # rad to either side of the heading: a robot within is ahead
BRAKING = 1.0  # m/s²: the deceleration by which the braking distance is reckoned
MOVES = 0.01  # m/s: a robot that is slower drives towards nobody


class WhereaboutsColumns(Columns):
    """The values of a message that say where a robot is."""

    x = column("m", "its place")
    y = column("m")
    v_x = column("m/s", "its velocity, in the world's axes")
    v_y = column("m/s")


@without_refcounts
def tell_whereabouts(where, robot):  # type: ignore[no-untyped-def]
    """Write a robot's place and velocity into its message, whose part ``where`` is as WhereaboutsColumns."""
    where.x, where.y = robot.x, robot.y
    where.v_x, where.v_y = robot.v * math.cos(robot.heading), robot.v * math.sin(robot.heading)


@without_refcounts
def other(where, age, x, y):  # type: ignore[no-untyped-def]
    """Another robot's present place from a place (x, y) [m], dx and dy [m], and its velocity [m/s], as it was heard.

    It is not-a-number before the first message.
    """
    dx, dy = predicted(where.x, where.v_x, age) - x, predicted(where.y, where.v_y, age) - y
    return dx, dy, where.v_x, where.v_y


@without_refcounts
def in_the_way(dx, dy, v_x, v_y, heading, limit, goes_first):  # type: ignore[no-untyped-def]
    """Whether a robot must stop for another, of which it knows what :func:`other` tells.

    It must where that one is ahead and nearer than ``limit`` [m], unless it ``goes_first`` and the two drive towards
    each other.
    """
    if not (abs(dx) < limit and abs(dy) < limit):  # most are far; nor is one that was never heard
        return False
    distance = math.hypot(dx, dy)
    if not (distance < limit and abs(wrapped_compiled(math.atan2(dy, dx) - heading)) < CONE):
        return False
    speed = math.hypot(v_x, v_y)
    # The other is taken to head where its velocity points.
    towards = -(dx * v_x + dy * v_y) > math.cos(CONE) * distance * speed
    return not (goes_first and towards and speed > MOVES)


@without_refcounts
def limit_of(near, v):  # type: ignore[no-untyped-def]
    """The distance [m] within which a robot with speed v [m/s] stops for others: ``near`` and its braking distance."""
    speed = abs(v)
    return near + speed**2 / (2 * BRAKING) + 0.1 * speed


@without_refcounts
def stops_for(where, age, robot, near, goes_first):  # type: ignore[no-untyped-def]
    """Whether a robot must stop for another ahead of it, nearer than ``near`` [m] and its braking distance.

    ``where`` and ``age`` are what it has heard of the other. Where two robots drive towards each other, the one that
    ``goes_first`` goes on: that with the lower number.
    """
    dx, dy, v_x, v_y = other(where, age, robot.x, robot.y)
    return in_the_way(dx, dy, v_x, v_y, robot.heading, limit_of(near, robot.v), goes_first)


def wider(robots: Sequence[Robot]) -> float:
    """By how much [m] more than a law states the centers of ``robots`` are kept apart; less than 0 for small robots.

    Laws state the distances between centers for robots as large as the EtsRo. The room beyond the turning circles of
    the largest robots is thus the same for robots of any size.
    """
    return 2 * max(robot.turning_circle for robot in robots) - STATED_FOR
