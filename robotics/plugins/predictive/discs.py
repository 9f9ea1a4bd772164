"""Discs that a plan keeps out of: what sensors see, at rest, and the robots that are heard, which go straight on.

Both are soft constraints, whose weight is :attr:`AroundColumns.weight`. Within a disc of radius r, d from its middle, a
plan of :mod:`robotics.plugins.predictive.ilqr` pays ½ weight (r − d)² at the end of each period, and a sample of
:mod:`robotics.plugins.predictive.mppi` weight (1 − d²/r²) at the end of each step.

Both plan from where the robot is along a straight line, at the speed that its path's timing asks for, and less where it
still has to turn: in the direction near that of the path in which the way is free, as the reactive laws have it
(:mod:`robotics.plugins.reactive.along`). So a plan bends around what comes, and its line around what stands.
"""

import math

from fuzzy.compiled.columns import Columns, column, several
from fuzzy.compiled.jit import compiled_only
from robotics.world.paths.posture import wrapped_compiled

DISCS = 12  # that are kept: the nearest
_STANDS = 1e-3  # m/s: who shall be slower stands


class DiscColumns(Columns):
    """A disc, and how it moves."""

    x = column("m", "now")
    y = column("m")
    v_x = column("m/s")
    v_y = column("m/s")
    radius = column("m")


_DISC = DiscColumns.size


class AroundColumns(Columns):
    """The discs, and what they weigh."""

    count = column("1")
    weight = column("", "1/m² of what is squared, 1 of a share")
    discs = several(DISCS * _DISC)


@compiled_only(forceinline=True)
def disc_of(around, k):  # type: ignore[no-untyped-def]
    """The ``k``-th disc."""
    return DiscColumns(around.discs, _DISC * k)


@compiled_only
def keep(around, robot, x, y, v_x, v_y, radius):  # type: ignore[no-untyped-def]
    """Keep a disc [m, m/s] if it is among the nearest to the robot."""
    count, place = int(around.count), int(around.count)
    if count < DISCS:
        around.count += 1
    else:
        farthest = math.hypot(x - robot.x, y - robot.y) - radius
        for k in range(count):
            disc = disc_of(around, k)
            gap = math.hypot(disc.x - robot.x, disc.y - robot.y) - disc.radius
            if gap > farthest:
                farthest, place = gap, k
    if place < DISCS:
        disc = disc_of(around, place)
        disc.x, disc.y, disc.v_x, disc.v_y, disc.radius = x, y, v_x, v_y, radius


@compiled_only
def keep_points(around, robot, points, count, radius):  # type: ignore[no-untyped-def]
    """Keep discs at rest around ``count`` points in the robot's frame [m]."""
    cos, sin = math.cos(robot.heading), math.sin(robot.heading)
    for n in range(count):
        ahead, left = points[2 * n], points[2 * n + 1]
        keep(around, robot, robot.x + cos * ahead - sin * left, robot.y + sin * ahead + cos * left, 0.0, 0.0, radius)


@compiled_only
def line(robot, speed, course):  # type: ignore[no-untyped-def]
    """The speed [m/s] and the direction [rad] in which a plan is led: who stands does not turn."""
    if speed < _STANDS:
        return 0.0, robot.heading
    off = wrapped_compiled(course - robot.heading)
    return speed * max(math.cos(off), 0.0), robot.heading + off
