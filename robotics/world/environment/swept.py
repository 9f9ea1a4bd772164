"""Signed clearances of robots to each other and to obstacles, and contacts between samples: nothing tunnels.

The signed clearance of two shapes is the distance between their surfaces; where they overlap it is minus the least
distance by which one must be moved to come free. For convex shapes that is found by separating axes [Gottschalk 1996];
of a polygon that is not convex it is bounded from below: see :func:`body_clearance`. Shapes are closed sets, so
touching (0) is contact.

Between two samples a robot moves on the cubic Hermite curve of its recorded place, heading, speed and turn rate. Where
these do not fit the chord (a run made by hand, a jump) it goes straight and turns evenly, the shorter way. Corners and
centers of obstacles go straight. Along these motions the signed clearance f of two shapes cannot change faster than
their points move against each other, |f'| ≤ S; and while they are apart it is the least of the distances of all pairs
of their points, so f'' ≤ S²/f + A with A the largest relative acceleration. Both bound f over an interval from its
ends (:func:`lower_bound`): most intervals need no look inside, the others are halved until the minimum is known to
within TOLERANCE. Contacts begin and end where a grid of at most GRID seconds, and bisection within it, says so.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple, Self

import numpy as np

from fuzzy.compiled.columns import Bools1, Columns, Floats2, Floats3, Floats4, Ints1, Ints2, Ints3, codes, column
from fuzzy.compiled.jit import compiled_only, kernel, without_refcounts
from robotics.world.environment.collision import corner_gap, footprints, segment_gap, segment_meets
from robotics.world.environment.world import BodyColumns, Geometry, Moving, place
from robotics.world.vehicle.robot import Robot

_TOLERANCE = 1e-7  # m: of the least clearance between two samples, while shapes are apart
DEPTH_TOLERANCE = 1e-4  # m: likewise, while they overlap
GRID = 1e-3  # s: a contact, and a gap between two contacts, that is longer than this is found as such
FITS = 0.5  # a velocity fits the chord if the mean of both ends' is off by no more than this share of the larger

TO = codes(("robot", "obstacle"))  # the first axis of ContactNotes.least and .first


class ContactColumns(Columns):
    """What a number of a contact is."""

    run = column("", "from 0, as robots and obstacles are")
    robot = column("")
    other = column("", "the other robot; -1: none")
    obstacle = column("", "-1: none")
    start = column("s")
    end = column("s")
    depth = column("m", "of the deepest overlap")


class ContactNotes(NamedTuple):
    """What is known of all contacts up to a time, which :func:`sweep` carries on in place.

    A pair is two robots, or a robot and an obstacle: first the robots' (0, 1), (0, 2), ..., then each robot with each
    obstacle.
    """

    spans: Ints3  # (runs or 1, obstacles, 2): first body of each obstacle, and the first that is not its
    least: Floats3  # (2, runs, robots) m: the least signed clearance to a robot, and to an obstacle; inf: there is none
    first: Floats3  # (2, runs, robots) s: begin of the first contact with a robot, and with an obstacle; inf: none
    counts: Ints2  # (runs, robots): the number of contacts that have begun
    ends: Floats2  # (runs, pairs) m: signed clearances at the last sample; not-a-number where nobody asked
    floor: Floats2  # (runs, pairs) m: what they are at least
    since: Floats2  # (runs, pairs) s: the begin of a contact that goes on; not-a-number: none does
    depth: Floats2  # (runs, pairs) m: how deep it has been

    @classmethod
    def nothing(cls, runs: int, robots: int, spans: np.ndarray) -> Self:
        """Before the first sample of ``runs`` runs among obstacles of these ``spans``, as of :func:`body_spans`."""
        each, pairs = (runs, robots), (runs, robots * (robots - 1) // 2 + robots * spans.shape[1])
        return cls(
            spans,
            np.full((2, *each), np.inf),
            np.full((2, *each), np.inf),
            np.zeros(each, dtype=np.int64),
            np.full(pairs, np.nan),
            np.full(pairs, -np.inf),
            np.full(pairs, np.nan),
            np.zeros(pairs),
        )


@dataclass(frozen=True, eq=False)
class Watch:
    """What is known of all contacts up to a time; :meth:`to` carries it on from sample to sample."""

    robots: tuple[Robot, ...]
    time: float  # s: of the last sample
    poses: np.ndarray  # (5, runs, robots): x [m], y [m], heading [rad], v [m/s], ω [rad/s] at the last sample
    geometry: Geometry | None  # the obstacles at the last sample; the first axis is the runs, or 1 for all
    known: ContactNotes

    @classmethod
    def opened(cls, robots: Sequence[Robot], time: float, poses: np.ndarray, geometry: Geometry | None = None) -> Self:
        """Begin with the first sample.

        Args:
            robots: The robots.
            time: Of the sample [s].
            poses: x [m], y [m], heading [rad], v [m/s], ω [rad/s] (5, runs, robots); not-a-number: nowhere.
            geometry: The obstacles; the first axis is the runs, or 1 for a world that all runs share.
        """
        nowhere, known = (
            np.full(poses.shape, np.nan),
            ContactNotes.nothing(poses.shape[1], poses.shape[2], body_spans(geometry)),
        )
        watch = cls(tuple(robots), time, nowhere, geometry, known)
        # A robot that was nowhere has nothing to come from: the sample alone is looked at.
        return watch.to(time, poses, geometry)[0]

    def to(self, time: float, poses: np.ndarray, geometry: Geometry | None = None) -> tuple[Self, np.ndarray]:
        """Carry the watch on to the next sample; return it with the contacts that ended meanwhile.

        Args:
            time: Of the sample [s].
            poses: As of :meth:`opened`.
            geometry: The obstacles at that time; the same object as before says that none moves.

        The contacts that ended are (contacts, ContactColumns).
        """
        times, both = np.array([self.time, time]), np.stack([self.poses, poses], axis=-1)
        worlds = [geometry] if geometry is self.geometry else [self.geometry, geometry]
        return self._carried(times, both, stacked(worlds), geometry)

    def along(self, times: np.ndarray, poses: np.ndarray, geometry: Geometry | None) -> tuple[Self, np.ndarray]:
        """Carry the watch on through many samples, of which the first is the watch's own; as :meth:`to`.

        Args:
            times: Of the samples (samples,) [s].
            poses: (5, runs, robots, samples), as of :meth:`opened`.
            geometry: The obstacles; the first axis is the samples, or 1 if all rest.
        """
        if geometry is None:
            return self._carried(times, poses, stacked([None]), None)
        circles, bodies, segments, counts = geometry
        world = Geometry(circles[:, None], bodies[:1], segments[:, None], counts[:1])
        return self._carried(times, poses, world, Geometry(*(part[-1:] for part in geometry)))

    def _carried(
        self, times: np.ndarray, poses: np.ndarray, world: Geometry, last: Geometry | None
    ) -> tuple[Self, np.ndarray]:
        known = ContactNotes(self.known.spans, *(part.copy() for part in self.known[1:]))
        going, sizes = np.ones(poses.shape[1], dtype=np.bool_), footprints(self.robots)
        poses = np.ascontiguousarray(poses, dtype=float)
        ended = sweep(times, poses, *world, sizes, going, True, known)
        return replace(self, time=float(times[-1]), poses=poses[..., -1], geometry=last, known=known), ended

    def open_contacts(self) -> np.ndarray:
        """The contacts that still go on, as of :meth:`to`; their end is the last sample."""
        known, rows = self.known, []
        firsts, seconds = np.triu_indices(self.poses.shape[2], 1)
        for run, pair in np.argwhere(np.isfinite(known.since)):
            if pair < len(firsts):
                who = (firsts[pair], seconds[pair], -1)
            else:
                robot, obstacle = divmod(pair - len(firsts), known.spans.shape[1])
                who = (robot, -1, obstacle)
            rows.append((run, *who, known.since[run, pair], self.time, known.depth[run, pair]))
        return np.array(rows, dtype=float).reshape(-1, ContactColumns.size)


class WorldInTime(NamedTuple):
    """The obstacles one sample ago and now, or once, if they rest: the fields of Geometry, by time."""

    circles: Floats4
    bodies: Ints3
    segments: Floats4
    counts: Ints1


class ContactWatch(NamedTuple):
    """The contacts of all runs up to a sample, which :func:`watch_contacts` carries on in compiled code."""

    sizes: Floats2  # (3, robots) m: as of robotics.world.environment.collision.footprints
    poses: Floats4  # (5, runs, robots, 2): x [m], y [m], heading [rad], v [m/s], ω [rad/s] one sample ago, and now
    world: WorldInTime
    here: Geometry  # where obstacles that move are placed
    moving: Moving
    going: Bools1  # (runs,): those that are watched; of the others nothing changes
    contacts: ContactNotes

    @classmethod
    def opened(cls, robots: Sequence[Robot], runs: int, here: Geometry, moving: Moving) -> Self:
        """Before the first sample of ``runs`` runs among obstacles, of as many runs or of one world for all."""
        place(here, moving, 0)
        world = stacked([here, here] if len(moving.frames) else [here])
        return cls(
            footprints(robots),
            np.full((5, runs, len(robots), 2), np.nan),
            WorldInTime(*(np.require(part, requirements=["C", "W"]) for part in world)),
            here,
            moving,
            np.ones(runs, dtype=bool),
            ContactNotes.nothing(runs, len(robots), body_spans(here)),
        )

    def geometry(self, now: bool) -> Geometry:
        """The obstacles at the last sample, or at the one before."""
        t = len(self.world.circles) - 1 if now else 0
        return Geometry(self.world.circles[t], self.world.bodies, self.world.segments[t], self.world.counts)


def body_spans(geometry: Geometry | None) -> np.ndarray:
    """The bodies of each obstacle (runs or 1, obstacles, 2): the first, and the first that is not its any more."""
    if geometry is None or geometry.bodies.shape[1] == 0:
        return np.zeros((1, 0, 2), dtype=np.int64)
    owners = geometry.bodies[:, :, BodyColumns.owner.row]
    real = np.arange(owners.shape[1]) < geometry.counts[:, None]
    spans = np.zeros((len(owners), int(owners[real].max(initial=-1)) + 1, 2), dtype=np.int64)
    for r, b in np.argwhere(real):
        span = spans[r, owners[r, b]]
        span[:] = (b if span[1] == 0 else span[0]), b + 1
    return spans


def stacked(worlds: Sequence[Geometry | None]) -> Geometry:
    """Geometries of successive samples as one, circles and segments (samples, runs or 1, ...); nothing for None."""
    known = [world for world in worlds if world is not None]
    if len(known) < 2:
        here = known[0] if known else Geometry.nothing()
        return here._replace(circles=here.circles[None], segments=here.segments[None])
    circles, segments = (np.stack([getattr(world, name) for world in known]) for name in ("circles", "segments"))
    return Geometry(circles, known[0].bodies, segments, known[0].counts)


def pose_between(period: float, before: np.ndarray, after: np.ndarray, share: float) -> np.ndarray:
    """The poses (3, robots) at the ``share`` of a ``period`` [s] between two samples (5, robots)."""
    found, motion = np.empty((3, before.shape[1])), np.empty((3, 4))
    powers = np.array([1.0, share, share**2, share**3])
    for i in range(before.shape[1]):
        _motion(before[:, i], after[:, i], period, motion)
        found[:, i] = motion @ powers
    return found


# Signed clearances of one pair -------------------------------------------------------------------------------------
# Sizes are columns of footprints(); coordinates are in the rectangle's frame unless stated otherwise.


@without_refcounts
def rectangle_clearance(dx, dy, heading, other, size, other_size):  # type: ignore[no-untyped-def]
    """The signed clearance [m] of two rectangles; the arguments are as of collision.rectangles_meet."""
    c, s = np.cos(heading), np.sin(heading)
    cc, ss = np.cos(other), np.sin(other)
    turn_c, turn_s = abs(c * cc + s * ss), abs(c * ss - s * cc)
    apart = max(
        max(
            abs(c * dx + s * dy) - size[0] - other_size[0] * turn_c - other_size[1] * turn_s,
            abs(c * dy - s * dx) - size[1] - other_size[0] * turn_s - other_size[1] * turn_c,
        ),
        max(
            abs(cc * dx + ss * dy) - other_size[0] - size[0] * turn_c - size[1] * turn_s,
            abs(cc * dy - ss * dx) - other_size[1] - size[0] * turn_s - size[1] * turn_c,
        ),
    )
    if apart <= 0:
        return apart
    return corner_gap(dx, dy, c, s, cc, ss, size, other_size)


@without_refcounts
def point_clearance(x, y, size):  # type: ignore[no-untyped-def]
    """The signed distance [m] of the point (``x``, ``y``) [m] from a rectangle, < 0 inside."""
    over, beside = abs(x) - size[0], abs(y) - size[1]
    if over <= 0 and beside <= 0:
        return max(over, beside)
    over, beside = max(over, 0.0), max(beside, 0.0)
    return np.sqrt(over * over + beside * beside)


@without_refcounts
def segment_depth(ax, ay, bx, by, size):  # type: ignore[no-untyped-def]
    """How far [m] a rectangle must be moved to come free of a segment that it meets, by separating axes."""
    mx, my, ex, ey = (ax + bx) / 2, (ay + by) / 2, abs(bx - ax) / 2, abs(by - ay) / 2
    across = abs(mx * (by - ay) - my * (bx - ax)) / 2
    normal = (size[0] * ey + size[1] * ex - across) / np.sqrt(ex * ex + ey * ey)
    return min(normal, min(size[0] + ex - abs(mx), size[1] + ey - abs(my)))


@without_refcounts
def body_clearance(corners, closed, size):  # type: ignore[no-untyped-def]
    """The signed clearance [m] of a rectangle to a polygon or a wall, whose sides are ``corners`` (sides, 4) [m].

    Where a polygon that is not convex overlaps the rectangle, the depth is a lower bound: the deepest of the
    rectangle's corners, of the disc in its middle, and of the depths by which it is across single sides.
    """
    sides = corners.shape[0]
    inside, meets, least = False, False, np.inf
    for k in range(sides):
        ax, ay, bx, by = corners[k, 0], corners[k, 1], corners[k, 2], corners[k, 3]
        # A ray from the robot's center crosses the sides of a polygon around it an odd number of times.
        if (ay > 0) != (by > 0) and (ax * by - ay * bx > 0) == (by > ay):
            inside = not inside
        if segment_meets(ax, ay, bx, by, size):
            meets = True
        elif not meets:
            least = min(least, segment_gap(ax, ay, bx, by, size))
    if not (meets or (inside and closed)):
        return least
    if closed and _convex(corners):
        return -_convex_depth(corners, size)
    depth = 0.0
    for k in range(sides):
        ax, ay, bx, by = corners[k, 0], corners[k, 1], corners[k, 2], corners[k, 3]
        if segment_meets(ax, ay, bx, by, size):
            depth = max(depth, segment_depth(ax, ay, bx, by, size))
    if closed:
        depth = max(depth, _depth_inside(0.0, 0.0, corners) + min(size[0], size[1]))
        for along in (-1.0, 1.0):
            for across in (-1.0, 1.0):
                depth = max(depth, _depth_inside(along * size[0], across * size[1], corners))
    return -depth


@without_refcounts
def _convex(corners):  # type: ignore[no-untyped-def]
    """Whether a polygon, counter-clockwise, is convex."""
    sides = corners.shape[0]
    for k in range(sides):
        n = (k + 1) % sides
        ex, ey = corners[k, 2] - corners[k, 0], corners[k, 3] - corners[k, 1]
        fx, fy = corners[n, 2] - corners[n, 0], corners[n, 3] - corners[n, 1]
        if ex * fy - ey * fx < -1e-12 * (abs(ex * fy) + abs(ey * fx)):
            return False
    return True


@without_refcounts
def _convex_depth(corners, size):  # type: ignore[no-untyped-def]
    """How far [m] a rectangle must be moved to come free of a convex polygon, counter-clockwise, that it overlaps."""
    depth = np.inf
    low_x, high_x, low_y, high_y = np.inf, -np.inf, np.inf, -np.inf
    for k in range(corners.shape[0]):
        ax, ay = corners[k, 0], corners[k, 1]
        ex, ey = corners[k, 2] - ax, corners[k, 3] - ay
        # The side's outward normal is (ey, -ex)/|e|.
        reach = ax * ey - ay * ex + size[0] * abs(ey) + size[1] * abs(ex)
        depth = min(depth, reach / np.sqrt(ex * ex + ey * ey))
        low_x, high_x, low_y, high_y = min(low_x, ax), max(high_x, ax), min(low_y, ay), max(high_y, ay)
    depth = min(depth, min(high_x + size[0], size[0] - low_x))
    return max(min(depth, min(high_y + size[1], size[1] - low_y)), 0.0)


@without_refcounts
def _depth_inside(x, y, corners):  # type: ignore[no-untyped-def]
    """The distance [m] of a point from the sides of a polygon, < 0 outside of it."""
    least, inside = np.inf, False
    for k in range(corners.shape[0]):
        ax, ay, bx, by = corners[k, 0] - x, corners[k, 1] - y, corners[k, 2] - x, corners[k, 3] - y
        if (ay > 0) != (by > 0) and (ax * by - ay * bx > 0) == (by > ay):
            inside = not inside
        ex, ey = bx - ax, by - ay
        t = min(max(-(ax * ex + ay * ey) / (ex * ex + ey * ey), 0.0), 1.0)
        least = min(least, np.sqrt((ax + t * ex) ** 2 + (ay + t * ey) ** 2))
    return least if inside else -least


# Between two samples -----------------------------------------------------------------------------------------------


@without_refcounts
def _motion(before, after, period, motion):  # type: ignore[no-untyped-def]
    """Fill in the coefficients (3, 4) of x, y and heading as polynomials of the share of the period.

    Poses are (5,): x, y, heading, v, ω.
    """
    turned = after[2] - before[2]
    if abs(turned) > np.pi:  # a heading that is kept within one turn
        turned -= 2 * np.pi * np.round(turned / (2 * np.pi))
    cx, cy = after[0] - before[0], after[1] - before[1]
    ax, ay = before[3] * period * np.cos(before[2]), before[3] * period * np.sin(before[2])
    bx, by = after[3] * period * np.cos(after[2]), after[3] * period * np.sin(after[2])
    off = np.sqrt(((ax + bx) / 2 - cx) ** 2 + ((ay + by) / 2 - cy) ** 2)
    largest = max(max(abs(before[3]), abs(after[3])) * period, np.sqrt(cx * cx + cy * cy))
    if not off <= FITS * largest:  # also where a speed is not-a-number
        ax, ay, bx, by = cx, cy, cx, cy
    aw, bw = before[4] * period, after[4] * period
    if not abs((aw + bw) / 2 - turned) <= FITS * max(abs(turned), max(abs(aw), abs(bw))):
        aw, bw = turned, turned
    _hermite(before[0], cx, ax, bx, motion[0])
    _hermite(before[1], cy, ay, by, motion[1])
    _hermite(before[2], turned, aw, bw, motion[2])


@without_refcounts
def _hermite(start, chord, first, last, row):  # type: ignore[no-untyped-def]
    row[0], row[1], row[2], row[3] = start, first, 3 * chord - 2 * first - last, first + last - 2 * chord


@without_refcounts
def _on(row, share):  # type: ignore[no-untyped-def]
    return row[0] + share * (row[1] + share * (row[2] + share * row[3]))


@without_refcounts
def _fastest(p, q):  # type: ignore[no-untyped-def]
    """The most |(p', q')| of two cubics on [0, 1]: that of the control points of the derivative's Bézier form."""
    first = p[1] * p[1] + q[1] * q[1]
    middle = (p[1] + p[2]) ** 2 + (q[1] + q[2]) ** 2
    last = (p[1] + 2 * p[2] + 3 * p[3]) ** 2 + (q[1] + 2 * q[2] + 3 * q[3]) ** 2
    return np.sqrt(max(first, max(middle, last)))


@without_refcounts
def _sharpest(p, q):  # type: ignore[no-untyped-def]
    """The most |(p'', q'')| of two cubics on [0, 1]: that at one of the ends."""
    first = p[2] * p[2] + q[2] * q[2]
    return 2 * np.sqrt(max(first, (p[2] + 3 * p[3]) ** 2 + (q[2] + 3 * q[3]) ** 2))


@without_refcounts
def lower_bound(first, last, share, speed, bend):  # type: ignore[no-untyped-def]
    """A lower bound [m] of the signed clearance over an interval.

    Args:
        first: The clearance at its begin [m].
        last: That at its end [m].
        share: The interval's length, as a share of the period.
        speed: S of the module's description [m a period].
        bend: A of the module's description [m a period²].
    """
    low = (first + last - speed * share) / 2
    if low <= 0:
        return low
    # f − K u²/2 is concave with K = S²/f + A, so that f lies above its chord minus K u (share − u)/2.
    drop = (speed * speed / low + bend) * share * share / 2
    rise = last - first
    if abs(rise) >= drop:
        return max(low, min(first, last))
    return max(low, first - (drop - rise) ** 2 / (4 * drop))


@without_refcounts
def _clearance_at(share, i, j, obstacle, motion, sizes, world, at):  # type: ignore[no-untyped-def]
    """The signed clearance of a pair at the ``share`` of the period: robots i and j, or robot i and an obstacle.

    ``world`` is as :func:`sweep` makes it; ``at`` are the samples before and after, and the run, of what is in it.
    """
    x, y, heading = _on(motion[i, 0], share), _on(motion[i, 1], share), _on(motion[i, 2], share)
    if obstacle < 0:
        dx, dy = _on(motion[j, 0], share) - x, _on(motion[j, 1], share) - y
        return rectangle_clearance(dx, dy, heading, _on(motion[j, 2], share), sizes[:, i], sizes[:, j])
    all_circles, all_bodies, all_segments, all_spans, corners = world
    circles, circles_after, spans = all_circles[at[0], at[2]], all_circles[at[1], at[2]], all_spans[at[2]]
    segments, segments_after = all_segments[at[0], at[2]], all_segments[at[1], at[2]]
    c, s = np.cos(heading), np.sin(heading)
    rest = 1.0 - share
    least = np.inf
    for b in range(spans[obstacle, 0], spans[obstacle, 1]):
        dx = rest * circles[b, 0] + share * circles_after[b, 0] - x
        dy = rest * circles[b, 1] + share * circles_after[b, 1] - y
        if np.sqrt(dx * dx + dy * dy) - circles[b, 2] - sizes[2, i] > max(least, 0.0) and least < np.inf:
            continue
        body = BodyColumns(all_bodies[at[2], b])
        if body.number == 0:
            least = min(least, point_clearance(c * dx + s * dy, c * dy - s * dx, sizes[:, i]) - circles[b, 2])
            continue
        for n in range(body.number):
            k = body.first + n
            for end in (0, 2):
                dx = rest * segments[k, end] + share * segments_after[k, end] - x
                dy = rest * segments[k, end + 1] + share * segments_after[k, end + 1] - y
                corners[n, end], corners[n, end + 1] = c * dx + s * dy, c * dy - s * dx
        least = min(least, body_clearance(corners[: body.number], body.closed != 0, sizes[:, i]))
    return least


@without_refcounts
def _search(first, last, level, pair, bounds, motion, sizes, world, at, stack):  # type: ignore[no-untyped-def]
    """The least clearance of a pair between two samples, and at which share; no search for what is above ``level``."""
    i, j, obstacle = pair
    speed, bend = bounds
    best, place = (first, 0.0) if first <= last else (last, 1.0)
    stack[0, 0], stack[0, 1], stack[0, 2], stack[0, 3] = 0.0, first, 1.0, last
    count = 1
    while count > 0:
        count -= 1
        a, fa, b, fb = stack[count, 0], stack[count, 1], stack[count, 2], stack[count, 3]
        low = lower_bound(fa, fb, b - a, speed, bend)
        if low > level or low >= best - (_TOLERANCE if best > 0 else DEPTH_TOLERANCE) or count + 2 > len(stack):
            continue
        middle = (a + b) / 2
        fm = _clearance_at(middle, i, j, obstacle, motion, sizes, world, at)
        if fm < best:
            best, place = fm, middle
        # The half with the lower end is looked at first.
        near = fa <= fb
        for side in (1, 0):
            row = stack[count]
            if (side == 0) == near:
                row[0], row[1], row[2], row[3] = a, fa, middle, fm
            else:
                row[0], row[1], row[2], row[3] = middle, fm, b, fb
            count += 1
    return best, place


@without_refcounts
def _crossing(out, into, pair, motion, sizes, world, at):  # type: ignore[no-untyped-def]
    """The share at which a contact begins or ends between a share ``out`` of contact and one in it; it is in it."""
    i, j, obstacle = pair
    for _ in range(12):  # of at most GRID: 0.25 µs
        middle = (out + into) / 2
        if _clearance_at(middle, i, j, obstacle, motion, sizes, world, at) <= 0:
            into = middle
        else:
            out = middle
    return into


@kernel(nogil=True)
def sweep(  # type: ignore[no-untyped-def]
    times, poses, circles, bodies, segments, counts, sizes, going, each_robot, known
):
    """Carry what is ``known`` through all samples, as of :class:`ContactNotes`; return the contacts that ended.

    Poses and obstacles are as of :meth:`Watch.along`, ``sizes`` those of
    :func:`robotics.world.environment.collision.footprints`; of runs that are not ``going`` (runs,) nothing changes.
    Without ``each_robot`` clearances are those of whole runs: the least of all robots is as with it, and those of
    single robots are no less than they should be.
    """
    runs, robots, samples = poses.shape[1:]
    spans, least, ends, floor = known.spans, known.least, known.ends, known.floor
    moves, each = circles.shape[0] > 1, circles.shape[1] > 1
    log, length = np.empty((16, 7)), np.int64(0)
    nobody = np.int64(-1)  # and not the literal, of which every function below would be compiled anew
    motion = np.empty((robots, 3, 4))
    way, arc, turn, bend = np.empty(robots), np.empty(robots), np.empty(robots), np.empty(robots)
    stack, corners = np.empty((200, 4)), np.empty((segments.shape[2], 4))
    relative = np.empty((2, 4))
    placed = np.empty((3, robots), dtype=np.bool_)
    here, there, ready = placed[0], placed[1], placed[2]
    # Whole arrays: to count the users of views of them, in each period of each run, takes longer than the rest
    world = circles, bodies, segments, spans, corners
    for r in range(runs):
        if not going[r]:
            continue
        g = r if each else 0
        for k in range(samples - 1):
            period = times[k + 1] - times[k]
            for i in range(robots):
                ready[i] = False
                there[i] = np.isfinite(poses[0, r, i, k] + poses[1, r, i, k] + poses[2, r, i, k])
                dx, dy = poses[0, r, i, k + 1] - poses[0, r, i, k], poses[1, r, i, k + 1] - poses[1, r, i, k]
                here[i] = np.isfinite(poses[0, r, i, k + 1] + poses[1, r, i, k + 1] + poses[2, r, i, k + 1])
                # The way of a cubic is no longer than its control polygon; of a robot that appears there is none.
                way[i] = np.sqrt(dx * dx + dy * dy)
                rates = abs(poses[3, r, i, k]) + abs(poses[3, r, i, k + 1])
                way[i] += rates * period * 2 / 3 if np.isfinite(rates) else 0.0
                arc[i] = abs(poses[2, r, i, k + 1] - poses[2, r, i, k])
                rates = abs(poses[4, r, i, k]) + abs(poses[4, r, i, k + 1])
                arc[i] = way[i] + sizes[2, i] * (arc[i] + (rates * period * 2 / 3 if np.isfinite(rates) else 0.0))
                if np.isnan(arc[i]):
                    way[i], arc[i] = 0.0, np.inf
            a = k if moves else 0
            b = k + 1 if moves else 0
            at, after, run_least = (a, b, g), (b, b, g), np.inf
            for i in range(robots):
                run_least = min(run_least, min(least[TO.robot, r, i], least[TO.obstacle, r, i]))
            pair = -1
            for i in range(robots):
                for j in range(i + 1, robots):
                    pair += 1
                    who = i, j, nobody
                    if not (here[i] and here[j]):
                        log, length = _gone(log, length, r, who, known, pair, times[k])
                        continue
                    level = max(least[TO.robot, r, i], least[TO.robot, r, j]) if each_robot else run_least
                    level = _level(level, r, pair, known)
                    floor[r, pair] -= arc[i] + arc[j]
                    if floor[r, pair] > max(level, 0.0) or _circles_apart(poses, r, i, j, k, way[i] + way[j]) > (
                        sizes[2, i] + sizes[2, j] + max(level, 0.0)
                    ):
                        ends[r, pair] = np.nan
                        continue
                    # Of a robot that appears with this sample, the sample alone is looked at.
                    appears = not (there[i] and there[j])
                    for m in (i, j):
                        _make_ready(m, poses[:, r, m, k : k + 2], appears, period, sizes, motion, turn, bend, ready)
                    relative[0], relative[1] = motion[j, 0] - motion[i, 0], motion[j, 1] - motion[i, 1]
                    fast = _fastest(relative[0], relative[1]) + sizes[2, i] * turn[i] + sizes[2, j] * turn[j]
                    bounds = fast, _sharpest(relative[0], relative[1]) + bend[i] + bend[j]
                    start, lasts = (times[k + 1], 0.0) if appears else (times[k], period)
                    log, length = _interval(
                        r, pair, who, bounds, level, start, lasts, motion, sizes, world, at, stack, known, log, length
                    )
            for i in range(robots):
                for o in range(spans.shape[1]):
                    pair += 1
                    who = i, nobody, o
                    if spans[g, o, 0] == spans[g, o, 1]:
                        continue
                    if not here[i]:
                        log, length = _gone(log, length, r, who, known, pair, times[k])
                        continue
                    level = _level(least[TO.obstacle, r, i] if each_robot else run_least, r, pair, known)
                    shift = _displacement(o, world, at) if moves else 0.0
                    floor[r, pair] -= arc[i] + shift
                    if floor[r, pair] > max(level, 0.0):
                        ends[r, pair] = np.nan
                        continue
                    near = False
                    for c in range(spans[g, o, 0], spans[g, o, 1]):
                        dx, dy = circles[a, g, c, 0] - poses[0, r, i, k], circles[a, g, c, 1] - poses[1, r, i, k]
                        ex = circles[b, g, c, 0] - poses[0, r, i, k + 1]
                        ey = circles[b, g, c, 1] - poses[1, r, i, k + 1]
                        start, end = np.sqrt(dx * dx + dy * dy), np.sqrt(ex * ex + ey * ey)
                        reach = (start + end - way[i] - shift) / 2 if np.isfinite(start) else end - shift
                        near |= reach <= sizes[2, i] + circles[a, g, c, 2] + max(level, 0.0)
                    if not near:
                        ends[r, pair] = np.nan
                        continue
                    appears = not there[i]
                    _make_ready(i, poses[:, r, i, k : k + 2], appears, period, sizes, motion, turn, bend, ready)
                    fast = _fastest(motion[i, 0], motion[i, 1]) + shift
                    bounds = fast + sizes[2, i] * turn[i], _sharpest(motion[i, 0], motion[i, 1]) + bend[i]
                    start, lasts = (times[k + 1], 0.0) if appears else (times[k], period)
                    when = after if appears else at
                    log, length = _interval(
                        r, pair, who, bounds, level, start, lasts, motion, sizes, world, when, stack, known, log, length
                    )
    return log[:length].copy()


@kernel(nogil=True)
def watch_contacts(k, times, truth, watch):  # type: ignore[no-untyped-def]
    """Carry a ContactWatch on to sample ``k``; return the contacts that ended.

    ``times`` [s] are those of the sample before and of this one, ``truth`` (rows, lanes) the plant's state.
    """
    poses, world = watch.poses, watch.world
    for c in range(len(poses)):
        for r in range(poses.shape[1]):
            for i in range(poses.shape[2]):
                poses[c, r, i, 0], poses[c, r, i, 1] = poses[c, r, i, 1], truth[c, r * poses.shape[2] + i]
    if k > 0 and len(world.circles) > 1:
        world.circles[0], world.segments[0] = world.circles[1], world.segments[1]
        place(watch.here, watch.moving, k)
        world.circles[1], world.segments[1] = watch.here.circles, watch.here.segments
    return sweep(
        times, poses, world.circles, world.bodies, world.segments, world.counts, watch.sizes, watch.going, False,
        watch.contacts,
    )  # fmt: skip


@kernel
def _gone(log, length, r, who, known, pair, time):  # type: ignore[no-untyped-def]
    """Note that one of a pair is nowhere, which ends a contact."""
    known.ends[r, pair], known.floor[r, pair] = np.nan, -np.inf
    if not np.isnan(known.since[r, pair]):
        return _ended(log, length, r, who, known, pair, time)
    return log, length


@without_refcounts
def _level(least, r, pair, known):  # type: ignore[no-untyped-def]
    """The clearance [m] below which a pair is looked at: where it touches, what is deeper than before."""
    return max(least, 0.0) if np.isnan(known.since[r, pair]) else -known.depth[r, pair]


@compiled_only
def _circles_apart(poses, r, i, j, k, way):  # type: ignore[no-untyped-def]
    """The least distance [m] between the centers of two robots of a run from sample ``k`` to the next, at least."""
    dx, dy = poses[0, r, i, k] - poses[0, r, j, k], poses[1, r, i, k] - poses[1, r, j, k]
    ex, ey = poses[0, r, i, k + 1] - poses[0, r, j, k + 1], poses[1, r, i, k + 1] - poses[1, r, j, k + 1]
    start, end = np.sqrt(dx * dx + dy * dy), np.sqrt(ex * ex + ey * ey)
    return (start + end - way) / 2 if np.isfinite(start) else end


@without_refcounts
def _make_ready(i, poses, appears, period, sizes, motion, turn, bend, ready):  # type: ignore[no-untyped-def]
    """Fill in how robot ``i`` moves between two ``poses`` (5, 2), or that it stays where it ``appears``.

    ``motion`` has its coefficients, ``turn`` its fastest turn, ``bend`` the sharpest bend of its corners' ways by
    turning.
    """
    if appears:
        motion[i] = 0.0
        motion[i, 0, 0], motion[i, 1, 0], motion[i, 2, 0] = poses[0, 1], poses[1, 1], poses[2, 1]
        turn[i], bend[i] = 0.0, 0.0
        ready[i] = False
    elif not ready[i]:
        own = motion[i]
        _motion(poses[:, 0], poses[:, 1], period, own)
        turn[i] = _fastest(own[2], own[2]) / np.sqrt(2.0)
        bend[i] = sizes[2, i] * (_sharpest(own[2], own[2]) / np.sqrt(2.0) + turn[i] * turn[i])
        ready[i] = True


@without_refcounts
def _displacement(obstacle, world, at):  # type: ignore[no-untyped-def]
    """How far [m] the points of an obstacle move from sample to sample, at most."""
    all_circles, bodies, all_segments, all_spans, _ = world
    circles, circles_after, spans = all_circles[at[0], at[2]], all_circles[at[1], at[2]], all_spans[at[2]]
    segments, segments_after = all_segments[at[0], at[2]], all_segments[at[1], at[2]]
    most = 0.0
    for b in range(spans[obstacle, 0], spans[obstacle, 1]):
        dx, dy = circles_after[b, 0] - circles[b, 0], circles_after[b, 1] - circles[b, 1]
        most = max(most, dx * dx + dy * dy)
        body = BodyColumns(bodies[at[2], b])
        for k in range(body.first, body.first + body.number):
            for end in (0, 2):
                dx = segments_after[k, end] - segments[k, end]
                dy = segments_after[k, end + 1] - segments[k, end + 1]
                most = max(most, dx * dx + dy * dy)
    return np.sqrt(most)


@kernel
def _interval(  # type: ignore[no-untyped-def]
    r, pair, who, bounds, level, time, period, motion, sizes, world, at, stack, known, log, length
):
    """Look at one pair of run ``r`` between two samples."""
    i, j, obstacle = who
    least, first, begun, ends, since, depth = (
        known.least, known.first, known.counts, known.ends, known.since, known.depth,
    )  # fmt: skip
    fa = ends[r, pair]
    if np.isnan(fa):
        fa = _clearance_at(0.0, i, j, obstacle, motion, sizes, world, at)
    fb = _clearance_at(1.0, i, j, obstacle, motion, sizes, world, at)
    ends[r, pair], known.floor[r, pair] = fb, fb
    best, place = _search(fa, fb, level, who, bounds, motion, sizes, world, at, stack)
    side = TO.robot if obstacle < 0 else TO.obstacle
    least[side, r, i] = min(least[side, r, i], best)
    if j >= 0:
        least[side, r, j] = min(least[side, r, j], best)
    if best > 0:
        return log, length
    if not np.isnan(since[r, pair]) and fa + fb + bounds[0] <= 0:  # in contact all the time
        depth[r, pair] = max(depth[r, pair], -best)
        return log, length
    steps = max(int(np.ceil(period / GRID - 1e-9)), 1)
    before, done = 0.0, False  # is the deepest place done?
    g = 0
    while g <= steps:
        share = g / steps
        if not done and place <= share:
            share, done = place, True
            if place == g / steps:
                g += 1
        else:
            g += 1
        if share == 0.0:
            f = fa
        elif share == 1.0:
            f = fb
        elif share == place:
            f = best
        else:
            f = _clearance_at(share, i, j, obstacle, motion, sizes, world, at)
        if f <= 0:
            if np.isnan(since[r, pair]):
                begin = share if share == before else _crossing(before, share, who, motion, sizes, world, at)
                since[r, pair], depth[r, pair] = time + begin * period, 0.0
                begun[r, i] += 1
                first[side, r, i] = min(first[side, r, i], since[r, pair])
                if j >= 0:
                    begun[r, j] += 1
                    first[side, r, j] = min(first[side, r, j], since[r, pair])
            depth[r, pair] = max(depth[r, pair], -f)
        elif not np.isnan(since[r, pair]):
            end = _crossing(share, before, who, motion, sizes, world, at)
            log, length = _ended(log, length, r, who, known, pair, time + end * period)
        before = share
    return log, length


@kernel
def _ended(log, length, r, who, known, pair, time):  # type: ignore[no-untyped-def]
    """Note the end of a contact in ``log``, which grows where need be."""
    if length == len(log):
        longer = np.empty((2 * len(log), 7))
        longer[:length] = log
        log = longer
    row = log[length]
    row[0], row[1], row[2], row[3] = r, who[0], who[1], who[2]
    row[4], row[5], row[6] = known.since[r, pair], time, known.depth[r, pair]
    known.since[r, pair] = np.nan
    return log, length + 1
