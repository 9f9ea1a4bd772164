"""The world: discs, polygons and walls, at rest or moving on given paths, compiled to one table for any number of runs.

A body is a disc, a polygon with its sides, or one piece of a wall. Every body has a circle around it, so that a body
out of reach costs one comparison. The table of several worlds (a random field for every run)
is padded to the largest of them; one world may be shared by all runs.
"""

from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import MISSING, dataclass, field
from functools import partial
from math import cos, hypot, pi, sin
from typing import Literal, NamedTuple

import numpy as np

from fuzzy.compiled.columns import Columns, Floats3, Ints1, Ints2, Ints3, column
from fuzzy.compiled.jit import kernel
from fuzzy.errors import InputError, concerning
from fuzzy.quantity import check_quantities, described, got, is_number, quantity, turn, whole
from robotics.world.paths.path import Shape
from robotics.world.paths.trajectory import Timing, Trajectory, compile_motion, together

Point = tuple[float, float]


class BodyColumns(Columns):
    """What a number of a row of Geometry.bodies is."""

    first = column("", "its first segment")
    number = column("", "its segments; 0: a disc")
    closed = column("", "whether they enclose a solid")
    owner = column("", "the obstacle that it is a part of")


class WorldError(InputError):
    """An obstacle that cannot be. The message names the field, its value and what is accepted."""


def _refuse(name: str, what: str) -> WorldError:
    return WorldError(f"{name} {what}").about(name)


def _check_points(name: str, points: tuple[Point, ...], least: int) -> None:
    if len(points) < least:
        raise _refuse(name, f"must be at least {least} points [x, y] in m, got {len(points)}")
    for p in points:
        if len(p) != 2 or not all(is_number(v) for v in p):
            raise _refuse(name, f"must be points [x, y] of finite numbers in m; {got(p)}")


# Descriptions ----------------------------------------------------------------------------------------------------


class Piece(NamedTuple):
    """A body of an obstacle, in the obstacle's own frame: a disc, a polygon, or a piece of a wall."""

    points: list[Point]  # m; of a disc its center, of a polygon its corners counter-clockwise, of a wall two ends
    closed: bool = False  # do the points enclose a solid?
    radius: float = 0.0  # m, of a disc


@dataclass(frozen=True, kw_only=True)
class Obstacle(ABC):
    """The place of an obstacle; the classes of OBSTACLES add its form, each by its :meth:`pieces`.

    The obstacle's own frame is at ``position``, turned by ``heading``. With a ``path`` and a ``timing`` it moves, and
    rests at the path's end: position and heading then count from the point on the path, with the orientation "along"
    in the frame of the path's tangent, with "fixed" in the world's. Raises WorldError for values that cannot be.
    """

    position: Point = described(
        "Where it stands; of an obstacle that moves, its place beside the point on the path.",
        (0.0, 0.0),
        example=[2.0, 4.0],
    )
    heading: float = turn(0.0, doc="How far it is turned to the left.")
    path: Shape | None = described("The path of an obstacle that moves, which needs a timing too.", None)
    timing: Timing | None = described("The timing of an obstacle that moves, which needs a path too.", None)
    orientation: Literal["along", "fixed"] = described(
        "Whether one that moves turns with its path, or keeps its heading in the world.", "along"
    )

    def __post_init__(self) -> None:
        check_quantities(self, WorldError)
        _check_points("position", (self.position,), 1)
        if (self.path is None) != (self.timing is None):
            lacks = "path" if self.path is None else "timing"
            raise _refuse(lacks, "is missing: a moving obstacle needs both a path and a timing")
        if self.orientation not in ("along", "fixed"):
            raise _refuse("orientation", f"must be 'along' or 'fixed', got {self.orientation!r}")

    @abstractmethod
    def pieces(self) -> list[Piece]:
        """The bodies that it is made of: contacts, sensors and pictures know no more of it."""


@dataclass(frozen=True, kw_only=True)
class Disc(Obstacle):
    """A solid disc with its center at the position."""

    radius: float = quantity(0.25, "m", above=0, most=1000, doc="The radius of the disc.")

    def pieces(self) -> list[Piece]:
        """See :meth:`Obstacle.pieces`."""
        return [Piece([(0.0, 0.0)], radius=self.radius)]


@dataclass(frozen=True, kw_only=True)
class Polygon(Obstacle):
    """A solid polygon, convex or not, whose sides do not cross; see :func:`box`, :func:`regular`, :func:`u_shape`."""

    corners: tuple[Point, ...] = described(
        "Its corners, at least three, in its own frame, either way round, the first not repeated; sides do not cross.",
        example=[[-0.2, -0.2], [0.2, -0.2], [0.0, 0.2]],
    )

    def __post_init__(self) -> None:
        super().__post_init__()
        _check_points("corners", self.corners, 3)
        n = len(self.corners)
        sides = [(self.corners[k], self.corners[(k + 1) % n]) for k in range(n)]
        for k, (a, b) in enumerate(sides):
            if a == b:
                raise _refuse("corners", f"{k + 1} and {(k + 1) % n + 1} are the same, {a}")
        for k, (a, b) in enumerate(sides):
            before = sides[k - 1][0]
            if _turn(before, a, b) == 0 and (before[0] - a[0]) * (b[0] - a[0]) + (before[1] - a[1]) * (b[1] - a[1]) > 0:
                raise _refuse("corners", f"go back over a side at corner {k + 1}, {a}")
            # For sides that share a corner the test above is enough.
            for other in range(k + 2, n - (k == 0)):
                if _cross(a, b, *sides[other]):
                    raise _refuse("corners", f"make sides that cross or touch: sides {k + 1} and {other + 1}")

    def pieces(self) -> list[Piece]:
        """See :meth:`Obstacle.pieces`."""
        corners = list(self.corners)
        area = sum(a[0] * b[1] - a[1] * b[0] for a, b in zip(corners, corners[1:] + corners[:1], strict=True))
        return [Piece(corners if area > 0 else corners[::-1], closed=True)]


@dataclass(frozen=True, kw_only=True)
class Wall(Obstacle):
    """A thin wall along straight pieces; a closed one is an arena, whose inside is free."""

    points: tuple[Point, ...] = described(
        "Its points, at least two, in its own frame, joined by straight pieces; the last may be the first.",
        example=[[-1.0, 3.0], [1.0, 3.0]],
    )

    def __post_init__(self) -> None:
        super().__post_init__()
        _check_points("points", self.points, 2)
        for k, (a, b) in enumerate(zip(self.points, self.points[1:], strict=False)):
            if a == b:
                raise _refuse("points", f"{k + 1} and {k + 2} are the same, {a}")

    def pieces(self) -> list[Piece]:
        """See :meth:`Obstacle.pieces`."""
        return [Piece([a, b]) for a, b in zip(self.points, self.points[1:], strict=False)]


_extent = partial(quantity, MISSING, "m", above=0, most=1000)


@dataclass(frozen=True, kw_only=True)
class MeasuredPolygon(Polygon):
    """A polygon whose corners follow from its measures."""

    corners: tuple[Point, ...] = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        check_quantities(self, WorldError)
        object.__setattr__(self, "corners", self.outline())
        super().__post_init__()

    @abstractmethod
    def outline(self) -> tuple[Point, ...]:
        """The corners [m]."""


@dataclass(frozen=True, kw_only=True)
class Box(MeasuredPolygon):
    """A rectangle: ``length`` along its heading."""

    length: float = _extent(doc="Its extent along its heading.", example=0.5)
    width: float = _extent(doc="Its extent across its heading.", example=0.3)

    def outline(self) -> tuple[Point, ...]:
        """See :meth:`MeasuredPolygon.outline`."""
        return box(self.length, self.width)


@dataclass(frozen=True, kw_only=True)
class Regular(MeasuredPolygon):
    """A regular polygon in a circle, with a corner along its heading."""

    sides: int = whole(MISSING, least=3, most=1000, doc="How many sides it has.", example=6)
    radius: float = _extent(doc="The distance of its corners from its middle.", example=0.25)

    def outline(self) -> tuple[Point, ...]:
        """See :meth:`MeasuredPolygon.outline`."""
        return regular(self.sides, self.radius)


@dataclass(frozen=True, kw_only=True)
class UShape(MeasuredPolygon):
    """A U by the measures of the free space in it; its mouth is behind."""

    width: float = _extent(doc="The free width between its arms, across its heading.", example=0.9)
    depth: float = _extent(doc="The free depth from its mouth to its bottom.", example=0.8)
    thickness: float = quantity(0.06, "m", above=0, most=10, doc="The thickness of its walls.")

    def outline(self) -> tuple[Point, ...]:
        """See :meth:`MeasuredPolygon.outline`."""
        return u_shape(self.width, self.depth, self.thickness)


OBSTACLES: dict[str, type[Obstacle]] = {
    "disc": Disc,
    "polygon": Polygon,
    "wall": Wall,
    "box": Box,
    "regular": Regular,
    "u": UShape,
}


@dataclass(frozen=True, kw_only=True)
class World:
    """All obstacles of a scenario. Robots that do not know them can only sense them."""

    obstacles: tuple[Obstacle, ...] = ()
    known: bool = True


def _turn(a: Point, b: Point, c: Point) -> float:
    return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])


def _cross(a: Point, b: Point, c: Point, d: Point) -> bool:
    """Whether the segments ab and cd have a point in common."""
    if any(max(a[i], b[i]) < min(c[i], d[i]) or max(c[i], d[i]) < min(a[i], b[i]) for i in (0, 1)):
        return False
    return _turn(a, b, c) * _turn(a, b, d) <= 0 and _turn(c, d, a) * _turn(c, d, b) <= 0


def box(length: float, width: float) -> tuple[Point, ...]:
    """The corners of a rectangle ``length`` along x and ``width`` along y [m], about its center."""
    return ((-length / 2, -width / 2), (length / 2, -width / 2), (length / 2, width / 2), (-length / 2, width / 2))


def regular(corners: int, radius: float) -> tuple[Point, ...]:
    """The corners of a regular polygon on a circle of ``radius`` [m] about its center, the first at angle 0."""
    angles = [2 * pi * k / corners for k in range(corners)]
    return tuple((radius * cos(a), radius * sin(a)) for a in angles)


def u_shape(width: float, depth: float, thickness: float = 0.06) -> tuple[Point, ...]:
    """The corners [m] of a U whose mouth opens towards −x, about the middle of the free space in it.

    Args:
        width: The free width between its arms, along y [m].
        depth: The free depth from its mouth to its bottom [m].
        thickness: The thickness of its walls [m].
    """
    x, y, t = depth / 2, width / 2, thickness
    return ((-x, -y), (x, -y), (x, y), (-x, y), (-x, y + t), (x + t, y + t), (x + t, -y - t), (-x, -y - t))


# Compiled --------------------------------------------------------------------------------------------------------


class Geometry(NamedTuple):
    """The places of all obstacles at one time. The first axis is the runs, or 1 for a world that all runs share.

    A body with segments is a polygon (closed, counter-clockwise) or a piece of a wall; one without is a disc.
    """

    circles: Floats3  # (runs, bodies, 3) m: x, y, radius of the disc, or of the circle around the body
    bodies: Ints3  # (runs, bodies, 4): first segment, number of segments, 1 if closed, its obstacle
    segments: Floats3  # (runs, segments, 4) m: x, y of one end, x, y of the other
    counts: Ints1  # (runs,): the number of bodies of the run; those after it are padding

    @classmethod
    def nothing(cls) -> "Geometry":
        """One world without obstacles."""
        return cls(np.zeros((1, 0, 3)), np.zeros((1, 0, 4), np.int64), np.zeros((1, 0, 4)), np.zeros(1, np.int64))


class Moving(NamedTuple):
    """How obstacles move, as columns, for :func:`place`; no worlds: none does."""

    circles: Floats3  # (worlds, bodies, 3): as of Geometry, in the obstacles' own frames where they move
    segments: Floats3  # (worlds, segments, 4): likewise
    frames: Ints2  # (worlds, bodies): the frame with which a body moves; -1: it rests
    poses: Floats3  # (times, 4, frames) m, m, 1, 1: x, y, cosine and sine of the heading of each frame

    @classmethod
    def nothing(cls) -> "Moving":
        """The columns where nothing moves."""
        return cls(np.empty((0, 0, 3)), np.empty((0, 0, 4)), np.empty((0, 0), np.int64), np.empty((0, 4, 0)))


@dataclass(frozen=True)
class Obstacles:
    """The obstacles of one world or of several, ready to be placed at any time."""

    rest: Geometry = field(repr=False)  # bodies that move are in their own frames
    frames: np.ndarray = field(repr=False)  # (runs, bodies) int: the frame with which a body moves; -1: it rests
    motion: Trajectory | None = field(default=None, repr=False)  # of all frames of all runs
    offsets: np.ndarray = field(default_factory=lambda: np.zeros((3, 0)), repr=False)  # (3, frames) x, y, heading
    along: np.ndarray = field(default_factory=lambda: np.zeros(0, bool), repr=False)  # (frames,) whether it turns

    @property
    def runs(self) -> int:
        """The number of worlds."""
        return len(self.rest.counts)

    def at(self, time: float) -> Geometry:
        """The places of all obstacles at ``time`` [s]. Nothing is copied where nothing moves."""
        if self.motion is None:
            return self.rest
        here, moving = self.during(np.array([time]), np.arange(self.runs))
        place(here, moving, 0)
        return here

    def during(self, times: np.ndarray, worlds: np.ndarray) -> tuple[Geometry, "Moving"]:
        """The obstacles of some worlds, for :func:`place` to place at any of some times.

        Args:
            times: (n,) [s].
            worlds: Their numbers, from 0 (m,).

        Returns their geometry, a copy, in which those that move are in their own frames; and how they move.
        """
        rest = Geometry(*(np.ascontiguousarray(rows[worlds]) for rows in self.rest))
        if self.motion is None:
            return rest, Moving.nothing()
        frames, motion, offsets, along = self.frames[worlds], self.motion, self.offsets, self.along
        if len(worlds) < self.runs:
            used, place_of = np.unique(np.append(frames, -1), return_inverse=True)
            frames, used = place_of[:-1].reshape(frames.shape) - 1, used[1:]
            if len(used) == 0:
                return rest, Moving.nothing()
            paths = tuple(motion.paths[f] for f in used)
            motion = Trajectory(paths, motion.tables[used], motion.ends[used])
            offsets, along = offsets[:, used], along[used]
        on = motion.sampled(times)
        poses = np.empty((len(times), 4, offsets.shape[1]))
        _pose_frames(on.x, on.y, on.heading, offsets, along, poses)
        return rest, Moving(rest.circles.copy(), rest.segments.copy(), frames, poses)


def compile_world(world: World) -> Obstacles:
    """Compile ``world`` for all runs. Raises WorldError, or PathError for a path on which no obstacle can move."""
    return compile_worlds([world])


def compile_worlds(worlds: Sequence[World]) -> Obstacles:
    """Compile a world for every run. Raises as :func:`compile_world`; a PathError's ``at`` says what it is about."""
    moving: list[tuple[int, Obstacle]] = []
    listed = [_listed(world, moving) for world in worlds]
    runs, bodies, segments = len(listed), *(max((len(row[i]) for row in listed), default=0) for i in (0, 2))
    rest = Geometry(
        np.zeros((runs, bodies, 3)),
        np.zeros((runs, bodies, 4), dtype=np.int64),
        np.zeros((runs, segments, 4)),
        np.array([len(row.circles) for row in listed], dtype=np.int64),
    )
    frames = np.full((runs, bodies), -1, dtype=np.int64)
    for r, row in enumerate(listed):
        if row.circles:
            n = len(row.circles)
            rest.circles[r, :n], rest.bodies[r, :n], frames[r, :n] = row.circles, row.bodies, row.frames
            rest.segments[r, : len(row.segments)] = np.reshape(row.segments, (-1, 4))
    if not moving:
        return Obstacles(rest, frames)
    motion = together([_motion(i, obstacle) for i, obstacle in moving])
    offsets = np.array([(*o.position, o.heading) for _, o in moving]).T
    return Obstacles(rest, frames, motion, offsets, np.array([o.orientation == "along" for _, o in moving]))


class _Listed(NamedTuple):
    """One world's part of a :class:`Geometry`, and the frame with which each body moves."""

    circles: list[list[float]]
    bodies: list[list[int]]
    segments: list[tuple[Point, Point]]
    frames: list[int]


def _listed(world: World, moving: list[tuple[int, Obstacle]]) -> _Listed:
    """List the bodies of ``world``, and add its obstacles that move to ``moving``, whose order numbers the frames."""
    row = _Listed([], [], [], [])
    for i, obstacle in enumerate(world.obstacles):
        frame = -1
        if obstacle.path is not None:
            frame = len(moving)
            moving.append((i, obstacle))
        for points, closed, radius in obstacle.pieces():
            placed = [_moved(p, obstacle) if frame < 0 else p for p in points]
            ends = zip(placed, placed[1:] + placed[:1] * closed, strict=False)
            first = len(row.segments)
            row.segments.extend(ends)
            row.circles.append(_circle(placed, radius))
            row.bodies.append([first, len(row.segments) - first, closed, i])
            row.frames.append(frame)
    return row


def _motion(i: int, obstacle: Obstacle) -> Trajectory:
    assert obstacle.path is not None
    assert obstacle.timing is not None
    with concerning("obstacles", i):
        return compile_motion(obstacle.path, obstacle.timing)


def _moved(p: Point, obstacle: Obstacle) -> Point:
    c, s, (x, y) = cos(obstacle.heading), sin(obstacle.heading), obstacle.position
    return x + c * p[0] - s * p[1], y + s * p[0] + c * p[1]


def _circle(points: list[Point], radius: float) -> list[float]:
    """A circle around ``points`` (not the smallest): x, y, radius; a single point gets the circle of ``radius``."""
    if len(points) == 1:
        return [*points[0], radius]
    xs, ys = [p[0] for p in points], [p[1] for p in points]
    x, y = (min(xs) + max(xs)) / 2, (min(ys) + max(ys)) / 2
    return [x, y, max(hypot(p[0] - x, p[1] - y) for p in points) * (1 + 1e-12) + 1e-12]


@kernel(nogil=True, _nrt=False)
def _pose_frames(x, y, heading, offsets, along, poses):  # type: ignore[no-untyped-def]
    """Write the poses of frames beside points on their paths (times, frames): x, y, cosine and sine of the heading."""
    for k in range(x.shape[0]):
        for f in range(x.shape[1]):
            turn = heading[k, f] if along[f] else 0.0
            c, s = np.cos(turn), np.sin(turn)
            poses[k, 0, f] = x[k, f] + c * offsets[0, f] - s * offsets[1, f]
            poses[k, 1, f] = y[k, f] + s * offsets[0, f] + c * offsets[1, f]
            poses[k, 2, f], poses[k, 3, f] = np.cos(turn + offsets[2, f]), np.sin(turn + offsets[2, f])


@kernel(nogil=True, _nrt=False)
def place(here, moving, k):  # type: ignore[no-untyped-def]
    """Write the circles and segments of obstacles that move as they are at the time of number ``k``."""
    for g in range(moving.frames.shape[0]):
        for b in range(here.counts[g]):
            f = moving.frames[g, b]
            if f < 0:
                continue
            x, y, c, s = moving.poses[k, 0, f], moving.poses[k, 1, f], moving.poses[k, 2, f], moving.poses[k, 3, f]
            px, py = moving.circles[g, b, 0], moving.circles[g, b, 1]
            here.circles[g, b, 0], here.circles[g, b, 1] = x + c * px - s * py, y + s * px + c * py
            body = BodyColumns(here.bodies[g, b])
            for n in range(body.first, body.first + body.number):
                for end in (0, 2):
                    px, py = moving.segments[g, n, end], moving.segments[g, n, end + 1]
                    here.segments[g, n, end] = x + c * px - s * py
                    here.segments[g, n, end + 1] = y + s * px + c * py


def outlines(geometry: Geometry, run: int = 0) -> list[np.ndarray]:
    """The outlines of one run's bodies to draw, (points, 2) [m] each; that of a disc or a polygon is closed."""
    run = run if len(geometry.counts) > 1 else 0
    lines = []
    for (x, y, radius), (first, number, closed, _) in zip(
        geometry.circles[run, : geometry.counts[run]], geometry.bodies[run], strict=False
    ):
        ends = geometry.segments[run, first : first + number].reshape(-1, 2)
        if number == 0:
            angle = np.linspace(0, 2 * pi, 65)
            ends = np.stack([x + radius * np.cos(angle), y + radius * np.sin(angle)], axis=1)
        elif closed:
            ends = np.concatenate([ends[::2], ends[:1]])
        lines.append(ends)
    return lines
