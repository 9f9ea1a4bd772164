"""Rays of a robot's sensors against obstacles and the other robots of its run, compiled.

The bodies whose circle meets the cone of any of a robot's sensors are taken into the robot's frame once.
A ray that meets a surface at more than the sensor's incidence angle is reflected away, and no echo comes back; the
shortest echo of a cone's rays counts. A sensor inside a disc or a polygon reads 0.
"""

from typing import NamedTuple

import numpy as np

from fuzzy.compiled.columns import Bools1, Columns, Floats2, Ints1, Ints2, column
from fuzzy.compiled.jit import compiled_only
from robotics.world.environment.collision import segment_meets
from robotics.world.environment.world import BodyColumns


class SensorColumns(Columns):
    """A range sensor, in its robot's frame."""

    x = column("m", "the place of its mount")
    y = column("m")
    cos_axis = column("1", "where it looks")
    sin_axis = column("1")
    cos_half = column("1", "half its cone")
    sin_half = column("1")
    range = column("m")
    cos_incidence = column("1", "the largest angle of incidence at which an echo comes back")
    minimum = column("m", "the shortest reading")
    noise = column("m", "standard deviation")
    relative_noise = column("1", "standard deviation over the distance")
    dropout = column("1", "the probability that an echo is lost")
    crosstalk = column("1", "the probability that another's ping is heard")
    fails_from = column("periods")
    fails_until = column("periods")


class Eyes(NamedTuple):
    """Range sensors as columns; robots of one kind carry those of some places in a row."""

    table: Floats2  # (SensorColumns, sensors)
    rays: Floats2  # (2, rays): unit directions in the robot's frame
    first_ray: Ints1  # (sensors + 1,): the rays of sensor q are those from first_ray[q] to first_ray[q + 1]
    due: Bools1  # (sensors,): whether it looks now


class Bodies(NamedTuple):
    """Room for what one robot may see, in its own frame, and for the rays that hit it."""

    circles: Floats2  # (bodies, 3) m: x, y, radius of the circle around each
    spans: Ints2  # (bodies, 3): its first edge, one past its last, and 1 if they enclose a solid
    edges: Floats2  # (edges, 4) m: x, y of one end, x, y of the other
    hits: Floats2  # (2, rays) m: each ray's nearest hit, and the distance of that surface's line from the sensor


def bodies_in_view(bodies: int, segments: int, robots: int, rays: int) -> Bodies:
    """Room for the ``bodies`` of a world with so many ``segments``, and for ``robots``."""
    spans = np.empty((bodies + robots, 3), dtype=np.int64)
    return Bodies(np.empty((bodies + robots, 3)), spans, np.empty((segments + 4 * robots, 4)), np.empty((2, rays)))


@compiled_only
def cast(eyes, begin, end, lane, robots, x, y, turned, sizes, here, view, echoes):  # type: ignore[no-untyped-def]
    """Write the shortest echo [m] of each sensor of one robot that is due: infinite where there is none.

    Args:
        eyes: The sensors.
        begin: The robot's are those from here.
        end: To before this one.
        lane: The robot's.
        robots: The number of robots of a run.
        x: Of all lanes (lanes,) [m].
        y: Likewise [m].
        turned: Cosine and sine of all headings (2, lanes).
        sizes: Those of :func:`robotics.world.environment.collision.footprints` (3, lanes).
        here: The obstacles, of as many runs or of one world for all.
        view: To work in.
        echoes: Where they are written (sensors,).
    """
    table, due = eyes.table, eyes.due
    reach = 0.0
    for q in range(begin, end):
        echoes[q] = np.inf
        sensor = SensorColumns(table, q)
        reach = max(reach, sensor.range + np.sqrt(sensor.x**2 + sensor.y**2))
    run = lane // robots
    g = run if here.counts.shape[0] > 1 else 0
    c, s = turned[0, lane], turned[1, lane]
    if not np.isfinite(x[lane] + y[lane] + c):
        return
    count, edge = 0, 0
    for b in range(here.counts[g]):
        dx, dy, radius = here.circles[g, b, 0] - x[lane], here.circles[g, b, 1] - y[lane], here.circles[g, b, 2]
        if dx * dx + dy * dy > (reach + radius) ** 2:
            continue
        px, py = c * dx + s * dy, c * dy - s * dx
        if not _in_view(table, due, begin, end, px, py, radius):
            continue
        view.circles[count, 0], view.circles[count, 1], view.circles[count, 2] = px, py, radius
        view.spans[count, 0] = edge
        body = BodyColumns(here.bodies[g, b])
        for k in range(body.first, body.first + body.number):
            for side in (0, 2):
                dx, dy = here.segments[g, k, side] - x[lane], here.segments[g, k, side + 1] - y[lane]
                view.edges[edge, side], view.edges[edge, side + 1] = c * dx + s * dy, c * dy - s * dx
            edge += 1
        view.spans[count, 1], view.spans[count, 2] = edge, body.closed
        count += 1
    for j in range(run * robots, (run + 1) * robots):
        dx, dy = x[j] - x[lane], y[j] - y[lane]
        if j == lane or not dx * dx + dy * dy <= (reach + sizes[2, j]) ** 2:  # also where it is not-a-number
            continue
        px, py = c * dx + s * dy, c * dy - s * dx
        if not (np.isfinite(turned[0, j]) and _in_view(table, due, begin, end, px, py, sizes[2, j])):
            continue
        view.circles[count, 0], view.circles[count, 1], view.circles[count, 2] = px, py, sizes[2, j]
        cos, sin = c * turned[0, j] + s * turned[1, j], c * turned[1, j] - s * turned[0, j]
        _outline(px, py, cos, sin, sizes[0, j], sizes[1, j], view.edges, edge)
        view.spans[count, 0], view.spans[count, 1], view.spans[count, 2] = edge, edge + 4, 1
        edge += 4
        count += 1
    if count > 0:
        _look(eyes, begin, end, view, count, echoes)


@compiled_only
def _in_view(table, due, begin, end, x, y, radius):  # type: ignore[no-untyped-def]
    """Whether any sensor may see a body in a circle about (x, y), in the robot's frame."""
    view = False
    for q in range(begin, end):
        sensor = SensorColumns(table, q)
        view |= due[q] & _in_cone(sensor, x - sensor.x, y - sensor.y, radius)
    return view


@compiled_only
def _in_cone(sensor, dx, dy, radius):  # type: ignore[no-untyped-def]
    """Whether a sensor may see a body in a circle about (dx, dy) from it; without branches, for speed."""
    far = sensor.range + radius
    along = sensor.cos_axis * dx + sensor.sin_axis * dy
    across = abs(sensor.cos_axis * dy - sensor.sin_axis * dx)
    # A cone no wider than a half plane is the intersection of two half planes.
    beside = (along < -radius) | (across * sensor.cos_half - along * sensor.sin_half > radius)
    return (dx * dx + dy * dy <= far * far) & ((sensor.cos_half <= 0) | (not beside))


@compiled_only
def _outline(x, y, c, s, half_length, half_width, edges, first):  # type: ignore[no-untyped-def]
    """Write the sides of a rectangle about (x, y), turned by (cos, sin), from ``first`` on, counter-clockwise."""
    ax, ay, bx, by = half_length * c, half_length * s, -half_width * s, half_width * c
    corner_x, corner_y = x + ax - bx, y + ay - by
    for k, (u, v) in enumerate(((1, 1), (-1, 1), (-1, -1), (1, -1)), first):
        edges[k, 0], edges[k, 1] = corner_x, corner_y
        corner_x, corner_y = x + u * ax + v * bx, y + u * ay + v * by
        edges[k, 2], edges[k, 3] = corner_x, corner_y


@compiled_only
def _look(eyes, begin, end, view, count, echoes):  # type: ignore[no-untyped-def]
    """Write the shortest echo [m] of each sensor from the ``count`` bodies in view of its robot."""
    table, rays, first_ray = eyes.table, eyes.rays, eyes.first_ray
    circles, spans, edges, hits = view.circles, view.spans, view.edges, view.hits
    for q in range(begin, end):
        if not eyes.due[q]:
            continue
        sensor = SensorColumns(table, q)
        first, last, mount_x, mount_y = first_ray[q], first_ray[q + 1], sensor.x, sensor.y
        right_x, right_y, left_x, left_y = rays[0, first], rays[1, first], rays[0, last - 1], rays[1, last - 1]
        narrow = sensor.cos_half > 0
        hit, within = False, False
        for b in range(count):
            dx, dy, radius = circles[b, 0] - mount_x, circles[b, 1] - mount_y, circles[b, 2]
            if not _in_cone(sensor, dx, dy, radius):
                continue
            if dx * dx + dy * dy <= radius * radius and _inside(mount_x, mount_y, edges, spans, b):
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
            echoes[q] = 0.0
        elif hit:
            shortest = np.inf
            for n in range(first, last):
                heard = (hits[0, n] <= sensor.range) & (hits[1, n] >= hits[0, n] * sensor.cos_incidence)
                shortest = min(shortest, hits[0, n] if heard else np.inf)
            echoes[q] = shortest


@compiled_only
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


@compiled_only
def _inside(x, y, edges, spans, b):  # type: ignore[no-untyped-def]
    """Whether a point in a body's circle is in the body: a ray from there crosses an odd number of sides."""
    inside = spans[b, 0] == spans[b, 1]
    if spans[b, 2] == 1:
        for k in range(spans[b, 0], spans[b, 1]):
            ax, ay, bx, by = edges[k, 0] - x, edges[k, 1] - y, edges[k, 2] - x, edges[k, 3] - y
            if (ay > 0) != (by > 0) and (ax * by - ay * bx > 0) == (by > ay):
                inside = not inside
    return inside


@compiled_only
def _meet_disc(dx, dy, radius, rays, first, last, hits):  # type: ignore[no-untyped-def]
    """Update the nearest ``hits`` of rays from the origin with a circle, and the distance of the tangent there."""
    for n in range(first, last):
        along, beside = rays[0, n] * dx + rays[1, n] * dy, rays[0, n] * dy - rays[1, n] * dx
        if abs(beside) <= radius:
            root = np.sqrt(radius * radius - beside * beside)
            t = along - root
            if 0 <= t < hits[0, n]:
                hits[0, n], hits[1, n] = t, t * root / radius


@compiled_only
def overhear(echo, eyes, begin, end, q, lane, robots, kinds, x, y, turned, sizes, here):  # type: ignore[no-untyped-def]
    """Shorten the ``echo`` [m] of sensor ``q`` to half the distance of one that it hears straight on (crosstalk).

    A ping is heard from robots of the same kind (their number in ``kinds``, (lanes,)), where both sensors are due,
    each is in the other's cone and range, and nothing stands between them. The other arguments are as of
    :func:`cast`.
    """
    table = eyes.table
    run = lane // robots
    g = run if here.counts.shape[0] > 1 else 0
    mine = SensorColumns(table, q)
    ax, ay, ac, as_ = _mounted(x, y, turned, lane, mine)
    for j in range(run * robots, (run + 1) * robots):
        for p in range(begin, end):
            if j == lane or kinds[j] != kinds[lane] or not eyes.due[p]:
                continue
            theirs = SensorColumns(table, p)
            bx, by, bc, bs = _mounted(x, y, turned, j, theirs)
            d = np.sqrt((bx - ax) ** 2 + (by - ay) ** 2)
            if not d <= min(mine.range, theirs.range) or d / 2 >= echo:
                continue
            if ac * (bx - ax) + as_ * (by - ay) < d * mine.cos_half:
                continue
            if bc * (ax - bx) + bs * (ay - by) < d * theirs.cos_half:
                continue
            if not _hidden(ax, ay, bx, by, here, g) and not _covered(
                ax, ay, bx, by, lane, j, run * robots, robots, x, y, turned, sizes
            ):
                echo = d / 2
    return echo


@compiled_only
def _mounted(x, y, turned, lane, sensor):  # type: ignore[no-untyped-def]
    """The place of a sensor on the robot of a lane [m], and the direction of its axis."""
    c, s = turned[0, lane], turned[1, lane]
    return (
        x[lane] + c * sensor.x - s * sensor.y,
        y[lane] + s * sensor.x + c * sensor.y,
        c * sensor.cos_axis - s * sensor.sin_axis,
        s * sensor.cos_axis + c * sensor.sin_axis,
    )


@compiled_only
def _hidden(ax, ay, bx, by, here, g):  # type: ignore[no-untyped-def]
    """Whether an obstacle of world ``g`` is between the points a and b."""
    circles, bodies, segments = here.circles, here.bodies, here.segments
    ex, ey = bx - ax, by - ay
    for n in range(here.counts[g]):
        dx, dy = circles[g, n, 0] - ax, circles[g, n, 1] - ay
        t = min(max((dx * ex + dy * ey) / (ex * ex + ey * ey), 0.0), 1.0)
        if (dx - t * ex) ** 2 + (dy - t * ey) ** 2 > circles[g, n, 2] ** 2:
            continue
        body = BodyColumns(bodies[g, n])
        if body.number == 0:
            return True
        for k in range(body.first, body.first + body.number):
            px, py = segments[g, k, 0] - ax, segments[g, k, 1] - ay
            qx, qy = segments[g, k, 2] - ax, segments[g, k, 3] - ay
            apart = (ex * py - ey * px) * (ex * qy - ey * qx)
            other = ((qx - px) * -py - (qy - py) * -px) * ((qx - px) * (ey - py) - (qy - py) * (ex - px))
            if apart <= 0 and other <= 0:
                return True
    return False


@compiled_only
def _covered(ax, ay, bx, by, i, j, first, robots, x, y, turned, sizes):  # type: ignore[no-untyped-def]
    """Whether a robot of the run other than ``i`` and ``j`` is between the points a and b."""
    for k in range(first, first + robots):
        if k in (i, j):
            continue
        c, s = turned[0, k], turned[1, k]
        dx, dy, ex, ey = ax - x[k], ay - y[k], bx - x[k], by - y[k]
        if segment_meets(c * dx + s * dy, c * dy - s * dx, c * ex + s * ey, c * ey - s * ex, sizes[:, k]):
            return True
    return False
