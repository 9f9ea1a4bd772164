"""Rays of all sensors of all robots of all runs against obstacles and the other robots, in one compiled pass.

The bodies whose circle meets the cone of any of a robot's sensors are taken into the robot's frame once.
A ray that meets a surface at more than the sensor's incidence angle is reflected away, and no echo comes back; the
shortest echo of a cone's rays counts. A sensor inside a disc or a polygon reads 0.
"""

import numpy as np

from fuzzy.compiled.jit import kernel
from robotics.environment.collision import segment_meets
from robotics.environment.world import CLOSED, FIRST, NUMBER

# Rows of the sensors' table
(
    MOUNT_X, MOUNT_Y, COS_AXIS, SIN_AXIS, COS_HALF, SIN_HALF, RANGE, COS_INCIDENCE, MINIMUM, NOISE, RELATIVE, DROPOUT,
    CROSSTALK,
) = range(13)  # fmt: skip
SENSOR_ROWS = 13


@kernel
def cast(x, y, heading, sizes, circles, bodies, segments, counts, table, rays, first_ray, due):  # type: ignore[no-untyped-def]
    """The shortest echo of every sensor [m] (runs, robots, sensors): infinite where there is none, or none is due.

    Args:
        x: (runs, robots) [m].
        y: (runs, robots) [m].
        heading: (runs, robots) [rad].
        sizes: Those of :func:`robotics.environment.collision.footprints`.
        circles: Of :class:`robotics.environment.world.Geometry`, as the next three.
        bodies: Of the geometry.
        segments: Of the geometry.
        counts: Of the geometry.
        table: The sensors (SENSOR_ROWS, sensors).
        rays: Unit directions in the robot's frame (2, rays).
        first_ray: The rays of sensor q are those from ``first_ray[q]`` to ``first_ray[q + 1]`` (sensors + 1,).
        due: Whether a sensor looks now (sensors,) bool.
    """
    runs, robots = x.shape
    sensors = table.shape[1]
    out = np.full((runs, robots, sensors), np.inf)
    reach = 0.0
    for q in range(sensors):
        reach = max(reach, table[RANGE, q] + np.sqrt(table[MOUNT_X, q] ** 2 + table[MOUNT_Y, q] ** 2))
    # For one robot: the circles (x, y, radius) in view; their first edge, one past the last, and 1 if they enclose a
    # solid; the edges. For one sensor: its rays' nearest hits, and the distance of the surface's line from the sensor
    seen = np.empty((circles.shape[1] + robots, 3))
    spans = np.empty((circles.shape[1] + robots, 3), np.int64)
    edges = np.empty((segments.shape[1] + 4 * robots, 4))
    hits = np.empty((2, rays.shape[1]))
    cos, sin = np.empty(robots), np.empty(robots)
    for r in range(runs):
        g = r if counts.shape[0] > 1 else 0
        for i in range(robots):
            cos[i], sin[i] = np.cos(heading[r, i]), np.sin(heading[r, i])
        for i in range(robots):
            c, s = cos[i], sin[i]
            if not np.isfinite(x[r, i] + y[r, i] + c):
                continue
            count, edge = 0, 0
            for b in range(counts[g]):
                dx, dy, radius = circles[g, b, 0] - x[r, i], circles[g, b, 1] - y[r, i], circles[g, b, 2]
                if dx * dx + dy * dy > (reach + radius) ** 2:
                    continue
                px, py = c * dx + s * dy, c * dy - s * dx
                if not _in_view(table, due, px, py, radius):
                    continue
                seen[count, 0], seen[count, 1], seen[count, 2] = px, py, radius
                spans[count, 0] = edge
                for k in range(bodies[g, b, FIRST], bodies[g, b, FIRST] + bodies[g, b, NUMBER]):
                    for end in (0, 2):
                        dx, dy = segments[g, k, end] - x[r, i], segments[g, k, end + 1] - y[r, i]
                        edges[edge, end], edges[edge, end + 1] = c * dx + s * dy, c * dy - s * dx
                    edge += 1
                spans[count, 1], spans[count, 2] = edge, bodies[g, b, CLOSED]
                count += 1
            for j in range(robots):
                dx, dy = x[r, j] - x[r, i], y[r, j] - y[r, i]
                if j == i or not dx * dx + dy * dy <= (reach + sizes[2, j]) ** 2:  # also where it is not-a-number
                    continue
                px, py = c * dx + s * dy, c * dy - s * dx
                if not (np.isfinite(cos[j]) and _in_view(table, due, px, py, sizes[2, j])):
                    continue
                seen[count, 0], seen[count, 1], seen[count, 2] = px, py, sizes[2, j]
                _outline(px, py, c * cos[j] + s * sin[j], c * sin[j] - s * cos[j], sizes[0, j], sizes[1, j],
                         edges[edge : edge + 4])  # fmt: skip
                spans[count, 0], spans[count, 1], spans[count, 2] = edge, edge + 4, 1
                edge += 4
                count += 1
            if count > 0:
                _look(table, rays, first_ray, due, seen[:count], spans, edges, hits, out[r, i])
    return out


@kernel
def _in_view(table, due, x, y, radius):  # type: ignore[no-untyped-def]
    """Whether any sensor may see a body in a circle about (x, y), in the robot's frame."""
    view = False
    for q in range(table.shape[1]):
        view |= due[q] & _in_cone(table, q, x - table[MOUNT_X, q], y - table[MOUNT_Y, q], radius)
    return view


@kernel
def _in_cone(table, q, dx, dy, radius):  # type: ignore[no-untyped-def]
    """Whether sensor ``q`` may see a body in a circle about (dx, dy) from it; without branches, for speed."""
    far = table[RANGE, q] + radius
    along = table[COS_AXIS, q] * dx + table[SIN_AXIS, q] * dy
    across = abs(table[COS_AXIS, q] * dy - table[SIN_AXIS, q] * dx)
    # A cone no wider than a half plane is the intersection of two half planes.
    beside = (along < -radius) | (across * table[COS_HALF, q] - along * table[SIN_HALF, q] > radius)
    return (dx * dx + dy * dy <= far * far) & ((table[COS_HALF, q] <= 0) | (not beside))


@kernel
def _outline(x, y, c, s, half_length, half_width, edges):  # type: ignore[no-untyped-def]
    """Write the sides of a rectangle about (x, y), turned by (cos, sin), into ``edges``, counter-clockwise."""
    ax, ay, bx, by = half_length * c, half_length * s, -half_width * s, half_width * c
    corner_x, corner_y = x + ax - bx, y + ay - by
    for k, (u, v) in enumerate(((1, 1), (-1, 1), (-1, -1), (1, -1))):
        edges[k, 0], edges[k, 1] = corner_x, corner_y
        corner_x, corner_y = x + u * ax + v * bx, y + u * ay + v * by
        edges[k, 2], edges[k, 3] = corner_x, corner_y


@kernel
def _look(table, rays, first_ray, due, circles, spans, edges, hits, out):  # type: ignore[no-untyped-def]
    """Write into ``out`` (sensors,) the shortest echo of each sensor from the bodies in view of its robot [m]."""
    for q in range(table.shape[1]):
        if not due[q]:
            continue
        first, last, mount_x, mount_y = first_ray[q], first_ray[q + 1], table[MOUNT_X, q], table[MOUNT_Y, q]
        right_x, right_y, left_x, left_y = rays[0, first], rays[1, first], rays[0, last - 1], rays[1, last - 1]
        narrow = table[COS_HALF, q] > 0
        hit, within = False, False
        for b in range(circles.shape[0]):
            dx, dy, radius = circles[b, 0] - mount_x, circles[b, 1] - mount_y, circles[b, 2]
            if not _in_cone(table, q, dx, dy, radius):
                continue
            if dx * dx + dy * dy <= radius * radius and _inside(mount_x, mount_y, edges, spans[b]):
                within = True
                break
            if not hit:
                for n in range(first, last):
                    hits[0, n] = np.inf
                hit = True
            if spans[b, 0] == spans[b, 1]:
                _meet_disc(dx, dy, radius, rays, first, last, hits)
            for k in range(spans[b, 0], spans[b, 1]):
                ax, ay = edges[k, 0] - mount_x, edges[k, 1] - mount_y
                bx, by = edges[k, 2] - mount_x, edges[k, 3] - mount_y
                area = ax * by - ay * bx
                far_side = (spans[b, 2] == 1) & (area > 0)
                # Beside the cone, both ends are to the left of its last ray, or to the right of its first.
                on_left = (left_x * ay - left_y * ax > 0) & (left_x * by - left_y * bx > 0)
                on_right = (right_x * ay - right_y * ax < 0) & (right_x * by - right_y * bx < 0)
                if not (far_side | (narrow & (on_left | on_right))):
                    _meet_edge(ax, ay, bx, by, area, rays, first, last, hits)
        if within:
            out[q] = 0.0
        elif hit:
            shortest = np.inf
            for n in range(first, last):
                heard = (hits[0, n] <= table[RANGE, q]) & (hits[1, n] >= hits[0, n] * table[COS_INCIDENCE, q])
                shortest = min(shortest, hits[0, n] if heard else np.inf)
            out[q] = shortest


@kernel
def _meet_edge(ax, ay, bx, by, area, rays, first, last, hits):  # type: ignore[no-untyped-def]
    """Update the nearest ``hits`` of rays from the origin with the segment from a to b, and its line's distance."""
    height = abs(area) / np.sqrt((bx - ax) ** 2 + (by - ay) ** 2)
    for n in range(first, last):
        # The ends are on either side of the ray's line, and the edge is not behind.
        left, right = rays[0, n] * ay - rays[1, n] * ax, rays[0, n] * by - rays[1, n] * bx
        t = area / (right - left)  # not-a-number if the ray runs along the edge
        nearer = (left * right <= 0) & (t >= 0) & (t < hits[0, n])
        hits[0, n] = t if nearer else hits[0, n]
        hits[1, n] = height if nearer else hits[1, n]


@kernel
def _inside(x, y, edges, span):  # type: ignore[no-untyped-def]
    """Whether a point in a body's circle is in the body: a ray from there crosses an odd number of sides."""
    inside = span[0] == span[1]
    if span[2] == 1:
        for k in range(span[0], span[1]):
            ax, ay, bx, by = edges[k, 0] - x, edges[k, 1] - y, edges[k, 2] - x, edges[k, 3] - y
            if (ay > 0) != (by > 0) and (ax * by - ay * bx > 0) == (by > ay):
                inside = not inside
    return inside


@kernel
def _meet_disc(dx, dy, radius, rays, first, last, hits):  # type: ignore[no-untyped-def]
    """Update the nearest ``hits`` of rays from the origin with a circle, and the distance of the tangent there."""
    for n in range(first, last):
        along, beside = rays[0, n] * dx + rays[1, n] * dy, rays[0, n] * dy - rays[1, n] * dx
        if abs(beside) <= radius:
            root = np.sqrt(radius * radius - beside * beside)
            t = along - root
            if 0 <= t < hits[0, n]:
                hits[0, n], hits[1, n] = t, t * root / radius


@kernel
def overhear(echoes, x, y, heading, sizes, circles, bodies, segments, counts, table, due, talks):  # type: ignore[no-untyped-def]
    """Shorten ``echoes`` to half the distance of a foreign sensor whose ping is heard straight on (crosstalk).

    A ping is heard where both sensors are due, each is in the other's cone and range, nothing stands between them, and
    the hearing sensor happens to listen meanwhile: ``talks`` (runs, robots, sensors) bool. The other arguments are as
    of :func:`cast`.
    """
    runs, robots = x.shape
    sensors = table.shape[1]
    for r in range(runs):
        g = r if counts.shape[0] > 1 else 0
        for i in range(robots):
            for q in range(sensors):
                if not (due[q] and talks[r, i, q]):
                    continue
                ax, ay, ac, as_ = _mounted(x[r, i], y[r, i], heading[r, i], table[:, q])
                for j in range(robots):
                    for p in range(sensors):
                        if j == i or not due[p]:
                            continue
                        bx, by, bc, bs = _mounted(x[r, j], y[r, j], heading[r, j], table[:, p])
                        d = np.sqrt((bx - ax) ** 2 + (by - ay) ** 2)
                        if not d <= min(table[RANGE, q], table[RANGE, p]) or d / 2 >= echoes[r, i, q]:
                            continue
                        if ac * (bx - ax) + as_ * (by - ay) < d * table[COS_HALF, q]:
                            continue
                        if bc * (ax - bx) + bs * (ay - by) < d * table[COS_HALF, p]:
                            continue
                        if not _hidden(ax, ay, bx, by, circles[g], bodies[g], segments[g], counts[g]) and not _covered(
                            ax, ay, bx, by, i, j, x[r], y[r], heading[r], sizes
                        ):
                            echoes[r, i, q] = d / 2
    return echoes


@kernel
def _mounted(x, y, heading, sensor):  # type: ignore[no-untyped-def]
    """The place of a sensor [m], and the direction of its axis."""
    c, s = np.cos(heading), np.sin(heading)
    return (
        x + c * sensor[MOUNT_X] - s * sensor[MOUNT_Y],
        y + s * sensor[MOUNT_X] + c * sensor[MOUNT_Y],
        c * sensor[COS_AXIS] - s * sensor[SIN_AXIS],
        s * sensor[COS_AXIS] + c * sensor[SIN_AXIS],
    )


@kernel
def _hidden(ax, ay, bx, by, circles, bodies, segments, count):  # type: ignore[no-untyped-def]
    """Whether an obstacle is between the points a and b."""
    ex, ey = bx - ax, by - ay
    for n in range(count):
        dx, dy = circles[n, 0] - ax, circles[n, 1] - ay
        t = min(max((dx * ex + dy * ey) / (ex * ex + ey * ey), 0.0), 1.0)
        if (dx - t * ex) ** 2 + (dy - t * ey) ** 2 > circles[n, 2] ** 2:
            continue
        if bodies[n, NUMBER] == 0:
            return True
        for k in range(bodies[n, FIRST], bodies[n, FIRST] + bodies[n, NUMBER]):
            px, py = segments[k, 0] - ax, segments[k, 1] - ay
            qx, qy = segments[k, 2] - ax, segments[k, 3] - ay
            apart = (ex * py - ey * px) * (ex * qy - ey * qx)
            other = ((qx - px) * -py - (qy - py) * -px) * ((qx - px) * (ey - py) - (qy - py) * (ex - px))
            if apart <= 0 and other <= 0:
                return True
    return False


@kernel
def _covered(ax, ay, bx, by, i, j, x, y, heading, sizes):  # type: ignore[no-untyped-def]
    """Whether a robot other than ``i`` and ``j`` is between the points a and b."""
    for k in range(x.shape[0]):
        if k in (i, j):
            continue
        c, s = np.cos(heading[k]), np.sin(heading[k])
        dx, dy, ex, ey = ax - x[k], ay - y[k], bx - x[k], by - y[k]
        if segment_meets(c * dx + s * dy, c * dy - s * dx, c * ex + s * ey, c * ey - s * ex, sizes[:, k]):
            return True
    return False
