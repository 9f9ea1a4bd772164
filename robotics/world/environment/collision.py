"""Contact and clearance of robots with each other and with obstacles, exactly, of all runs in one compiled pass.

A robot is a rectangle with its center at the axle midpoint. Two convex shapes are apart if a side of one separates
them (separating axes [Gottschalk 1996]); shapes are closed sets, so touching is contact. Circles around robots and
bodies are compared first. A robot whose pose is not-a-number is nowhere: it touches nothing.
"""

from collections.abc import Sequence

import numpy as np

from fuzzy.compiled.jit import compiled_only, kernel
from robotics.world.environment.world import BodyColumns, Geometry
from robotics.world.vehicle.robot import Robot


def footprints(robots: Sequence[Robot]) -> np.ndarray:
    """The sizes of robots (3, robots) [m]: half the length, half the width, and the radius of the circle around."""
    half = np.array([[r.length / 2, r.width / 2] for r in robots]).T.reshape(2, -1)
    return np.stack([*half, np.hypot(*half) * (1 + 1e-12)])


def robot_contacts(x: np.ndarray, y: np.ndarray, heading: np.ndarray, sizes: np.ndarray) -> np.ndarray:
    """The first other robot that each robot touches (runs, robots) int, from 0; -1 for none.

    Args:
        x: (runs, robots) [m].
        y: (runs, robots) [m].
        heading: (runs, robots) [rad].
        sizes: Those of :func:`footprints` (3, robots).
    """
    return np.asarray(_robot_gaps(*as_poses(x, y, heading), sizes)[0])


def obstacle_contacts(
    x: np.ndarray, y: np.ndarray, heading: np.ndarray, sizes: np.ndarray, geometry: Geometry
) -> np.ndarray:
    """The first obstacle that each robot touches, or is inside of (runs, robots) int, from 0; -1 for none.

    Poses and sizes are as of :func:`robot_contacts`; ``geometry`` has as many runs, or one world for all of them.
    Raises ValueError for another number of runs.
    """
    return np.asarray(_obstacle_gaps(*as_poses(x, y, heading), sizes, *for_runs(geometry, len(x)))[0])


def robot_clearance(x: np.ndarray, y: np.ndarray, heading: np.ndarray, sizes: np.ndarray) -> np.ndarray:
    """The distance [m] from each robot's rectangle to the nearest other's (runs, robots); 0: contact, inf: none.

    The arguments are as of :func:`robot_contacts`.
    """
    return np.asarray(_robot_gaps(*as_poses(x, y, heading), sizes)[1])


def obstacle_clearance(
    x: np.ndarray, y: np.ndarray, heading: np.ndarray, sizes: np.ndarray, geometry: Geometry
) -> np.ndarray:
    """The distance [m] from each robot's rectangle to the nearest obstacle (runs, robots); 0: contact, inf: none.

    The arguments are as of :func:`obstacle_contacts`. Raises ValueError for another number of runs.
    """
    return np.asarray(_obstacle_gaps(*as_poses(x, y, heading), sizes, *for_runs(geometry, len(x)))[1])


def as_poses(*values: np.ndarray) -> list[np.ndarray]:
    """Copy ``values`` where need be into contiguous arrays of floats, for the compiled passes."""
    return [np.ascontiguousarray(v, dtype=float) for v in values]


def for_runs(geometry: Geometry, runs: int) -> Geometry:
    """Return ``geometry`` if it has ``runs`` runs, or one world for all; raise ValueError otherwise."""
    if len(geometry.counts) not in (1, runs):
        raise ValueError(f"a world for each of {runs} runs, or one for all, is needed; got {len(geometry.counts)}")
    return geometry


# All robots of all runs ------------------------------------------------------------------------------------------


@kernel
def _robot_gaps(x, y, heading, sizes):  # type: ignore[no-untyped-def]
    """What :func:`robot_contacts` and :func:`robot_clearance` return."""
    runs, robots = x.shape
    touched, least = np.full((runs, robots), -1), np.full((runs, robots), np.inf)
    for r in range(runs):
        for i in range(robots):
            for j in range(i + 1, robots):
                dx, dy = x[r, j] - x[r, i], y[r, j] - y[r, i]
                further = max(least[r, i], least[r, j])
                bound = np.sqrt(dx * dx + dy * dy) - sizes[2, i] - sizes[2, j]
                if not (bound < further and np.isfinite(heading[r, i] + heading[r, j])):
                    continue
                gap = rectangle_gap(dx, dy, heading[r, i], heading[r, j], sizes[:, i], sizes[:, j])
                for one, other in ((i, j), (j, i)):
                    least[r, one] = min(least[r, one], gap)
                    if gap <= 0 and touched[r, one] < 0:
                        touched[r, one] = other
    return touched, least


@kernel
def _obstacle_gaps(x, y, heading, sizes, circles, bodies, segments, counts):  # type: ignore[no-untyped-def]
    """What :func:`obstacle_contacts` and :func:`obstacle_clearance` return."""
    touched, least = np.full(x.shape, -1), np.full(x.shape, np.inf)
    _find_obstacle_gaps(x, y, heading, sizes, circles, bodies, segments, counts, touched, least)
    return touched, least


@compiled_only
def _find_obstacle_gaps(x, y, heading, sizes, circles, bodies, segments, counts, touched, least):  # type: ignore[no-untyped-def]
    """Write what :func:`_obstacle_gaps` returns."""
    runs, robots = x.shape
    for r in range(runs):
        g = r if counts.shape[0] > 1 else 0
        for i in range(robots):
            c, s = np.cos(heading[r, i]), np.sin(heading[r, i])
            if not np.isfinite(c):
                continue
            for b in range(counts[g]):
                dx, dy = circles[g, b, 0] - x[r, i], circles[g, b, 1] - y[r, i]
                if not np.sqrt(dx * dx + dy * dy) - sizes[2, i] - circles[g, b, 2] < least[r, i]:
                    continue
                body = BodyColumns(bodies[g, b])
                least[r, i] = min(
                    least[r, i], _body_gap(x[r, i], y[r, i], c, s, sizes[:, i], circles[g, b], body, segments[g])
                )
                if least[r, i] <= 0:
                    touched[r, i] = body.owner
                    break


@compiled_only
def _body_gap(x, y, c, s, size, circle, body, segments):  # type: ignore[no-untyped-def]
    """The distance [m] from a robot's rectangle to a body, 0 in contact."""
    if body.number == 0:
        dx, dy = circle[0] - x, circle[1] - y
        return max(point_gap(c * dx + s * dy, c * dy - s * dx, size) - circle[2], 0.0)
    least = np.inf
    inside = False  # the robot's center in the polygon: a ray from it crosses the sides an odd number of times
    for k in range(body.first, body.first + body.number):
        dx, dy = segments[k, 0] - x, segments[k, 1] - y
        ax, ay = c * dx + s * dy, c * dy - s * dx
        dx, dy = segments[k, 2] - x, segments[k, 3] - y
        bx, by = c * dx + s * dy, c * dy - s * dx
        if (ay > 0) != (by > 0) and (ax * by - ay * bx > 0) == (by > ay):
            inside = not inside
        least = min(least, segment_gap(ax, ay, bx, by, size))
    return 0.0 if inside and body.closed else least


# One pair --------------------------------------------------------------------------------------------------------
# Sizes are columns of footprints(); coordinates are in the rectangle's frame unless stated otherwise.


@kernel
def rectangles_meet(dx, dy, heading, other, size, other_size):  # type: ignore[no-untyped-def]
    """Whether two rectangles have a point in common.

    Args:
        dx: From the first rectangle's center to the second's, in the world's axes [m].
        dy: The same along y [m].
        heading: Of the first [rad].
        other: The heading of the second [rad].
        size: Of the first, a column of :func:`footprints`.
        other_size: Of the second.
    """
    c, s = np.cos(heading), np.sin(heading)
    cc, ss = np.cos(other), np.sin(other)
    # The sides' directions as the other sees them
    turn_c, turn_s = abs(c * cc + s * ss), abs(c * ss - s * cc)
    return (
        abs(c * dx + s * dy) <= size[0] + other_size[0] * turn_c + other_size[1] * turn_s
        and abs(c * dy - s * dx) <= size[1] + other_size[0] * turn_s + other_size[1] * turn_c
        and abs(cc * dx + ss * dy) <= other_size[0] + size[0] * turn_c + size[1] * turn_s
        and abs(cc * dy - ss * dx) <= other_size[1] + size[0] * turn_s + size[1] * turn_c
    )


@kernel
def rectangle_gap(dx, dy, heading, other, size, other_size):  # type: ignore[no-untyped-def]
    """The distance [m] between two rectangles, 0 in contact; the arguments are as of :func:`rectangles_meet`."""
    if rectangles_meet(dx, dy, heading, other, size, other_size):
        return 0.0
    return corner_gap(dx, dy, np.cos(heading), np.sin(heading), np.cos(other), np.sin(other), size, other_size)


@kernel
def corner_gap(dx, dy, c, s, cc, ss, size, other_size):  # type: ignore[no-untyped-def]
    """The distance [m] between two rectangles that are apart, from cosines and sines of both headings.

    The distance of two convex polygons that are apart is that of a corner of one from the other.
    """
    least = np.inf
    for along in (-1.0, 1.0):
        for across in (-1.0, 1.0):
            u, v = along * other_size[0], across * other_size[1]
            px, py = dx + cc * u - ss * v, dy + ss * u + cc * v
            least = min(least, point_gap(c * px + s * py, c * py - s * px, size))
            u, v = along * size[0], across * size[1]
            px, py = c * u - s * v - dx, s * u + c * v - dy
            least = min(least, point_gap(cc * px + ss * py, cc * py - ss * px, other_size))
    return least


@kernel
def point_gap(x, y, size):  # type: ignore[no-untyped-def]
    """The distance [m] from a rectangle to the point (``x``, ``y``) [m], 0 inside it."""
    over, beside = max(abs(x) - size[0], 0.0), max(abs(y) - size[1], 0.0)
    return np.sqrt(over * over + beside * beside)


@kernel
def segment_meets(ax, ay, bx, by, size):  # type: ignore[no-untyped-def]
    """Whether a rectangle and the segment from (``ax``, ``ay``) to (``bx``, ``by``) [m] have a point in common."""
    if min(ax, bx) > size[0] or max(ax, bx) < -size[0] or min(ay, by) > size[1] or max(ay, by) < -size[1]:
        return False
    return abs(ax * by - ay * bx) <= size[0] * abs(by - ay) + size[1] * abs(bx - ax)


@kernel
def segment_gap(ax, ay, bx, by, size):  # type: ignore[no-untyped-def]
    """The distance [m] from a rectangle to the segment from (``ax``, ``ay``) to (``bx``, ``by``) [m], 0 in contact."""
    if segment_meets(ax, ay, bx, by, size):
        return 0.0
    # When apart, an end of the segment is nearest to the rectangle, or a corner of the rectangle to the segment.
    least = min(point_gap(ax, ay, size), point_gap(bx, by, size)) ** 2
    ex, ey = bx - ax, by - ay
    per_square = 1 / (ex * ex + ey * ey)
    for along in (-1.0, 1.0):
        for across in (-1.0, 1.0):
            px, py = along * size[0] - ax, across * size[1] - ay
            t = min(max((px * ex + py * ey) * per_square, 0.0), 1.0)
            least = min(least, (px - t * ex) ** 2 + (py - t * ey) ** 2)
    return np.sqrt(least)
