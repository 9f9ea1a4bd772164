"""Paths: sine, circle, figure of eight, straight line, quintic and way-points, each compiled to an arc-length table.

A shape is a curve p(u), u in [0, 1], with its first two derivatives. :func:`compile_path` measures its length
(Gauss-Legendre quadrature, to 1e-9 m or better) and tabulates position, heading and curvature at equal steps of
the abscissa s; :meth:`Path.at` evaluates arrays of abscissae at once by cubic Hermite interpolation.
"""

from dataclasses import dataclass, field
from functools import cached_property
from itertools import pairwise
from math import hypot, pi
from typing import Literal, NamedTuple, Protocol

import numpy as np

from fuzzy.compiled.columns import Columns, column
from fuzzy.compiled.jit import kernel
from fuzzy.compiled.threads import share_out
from fuzzy.entrypoints import entry_points
from fuzzy.errors import InputError
from fuzzy.quantity import LARGEST_NUMBER, check_quantities, described, quantity, turn

_NEAREST = 1e-12  # of the length of all way-points' chords: the spline needs points that rounding keeps apart
_LONGEST = 1e4  # m: on a longer path its nodes would be more than 5 cm apart
# Nodes are 5 mm apart on up to 1 km. Farther apart, h, the interpolation errs by h⁴ κ³/384: at 5 cm and a radius of 1 m
# by 2e-8 m. A table of all has 8 MB.
_MOST_CELLS = 200_000
_AT_ONCE = 50_000  # nodes of which one thread makes the tangents at a time


class PathError(InputError):
    """A path that cannot be driven. The message names the parameter, its value and what is accepted."""


class Shape(Protocol):
    """A plane curve p(u), u in [0, 1], twice continuously differentiable, with p' ≠ 0."""

    def curve(self, u: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return p, dp/du and d²p/du², each (2, ...) in m, at ``u`` (...)."""
        ...


def _require(condition: bool, what: str) -> None:
    if not condition:
        raise PathError(what)


def _finite(shape: object, **values: object) -> None:
    for name, value in values.items():
        sizes = np.abs(np.asarray(value, dtype=float))
        if not np.isfinite(sizes).all():
            raise PathError(f"{type(shape).__name__.lower()} path: {name} must be finite, got {value!r}")
        if (sizes > LARGEST_NUMBER).any():
            raise PathError(
                f"{type(shape).__name__.lower()} path: the numbers of {name} may be {LARGEST_NUMBER:g} in size at most"
            )


@dataclass(frozen=True, kw_only=True)
class Sine:
    """y = offset + amplitude · sin(wavenumber · x + phase), from x_start to x_end; phase π/2 makes it a cosine.

    ``lead_in`` puts a straight line of that extent in x before x_start, along the tangent there. The curvature jumps
    where the two meet, unless it is 0 there.
    """

    amplitude: float = quantity(1.0, "m", doc="How far the sine swings to either side of its middle.")
    wavenumber: float = quantity(1.0, "rad/m", doc="The phase a metre of x; a period is 2π / wavenumber long.")
    phase: float = turn(0.0, doc="The phase at x = 0; π/2 makes it a cosine.")
    offset: float = quantity(0.0, "m", doc="The y of the sine's middle.")
    x_start: float = quantity(0.0, "m", doc="The x at which the sine begins.")
    x_end: float = quantity(2 * pi, "m", doc="The x at which the sine ends; below x_start it is driven towards −x.")
    lead_in: float = quantity(0.0, "m", least=0, doc="The extent in x of a straight line along the tangent before it.")

    def __post_init__(self) -> None:
        check_quantities(self, PathError)
        _require(self.x_end != self.x_start, f"sine path: x_end must differ from x_start, got {self.x_end!r} for both")

    def curve(self, u: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """The curve p, dp/du and d²p/du², each (2, ...) [m], at ``u`` (...) in [0, 1]."""
        forward = 1.0 if self.x_end > self.x_start else -1.0
        begin = self.x_start - forward * self.lead_in
        span = self.x_end - begin
        x = begin + span * u
        before = np.minimum((x - self.x_start) * forward, 0.0) * forward  # into the lead-in, 0 on the sine
        a, k, angle = self.amplitude, self.wavenumber, self.wavenumber * (x - before) + self.phase
        slope, one = a * k * np.cos(angle), np.ones_like(x)
        return (
            np.stack([x, self.offset + a * np.sin(angle) + slope * before]),
            np.stack([span * one, slope * span]),
            np.stack([0 * one, np.where(before == 0, -a * (k * span) ** 2 * np.sin(angle), 0.0)]),
        )


@dataclass(frozen=True, kw_only=True)
class Circle:
    """A circle that begins at ``start_angle``; with ``turns`` other than 1 a part of it, or several rounds."""

    center: tuple[float, float] = described("The center of the circle.", (0.0, 0.0))
    radius: float = quantity(1.0, "m", above=0, doc="The radius of the circle.")
    start_angle: float = turn(0.0, doc="The angle, seen from the center, of the point where it begins.")
    direction: Literal["counter-clockwise", "clockwise"] = described(
        "Which way round the circle is driven.", "counter-clockwise"
    )
    turns: float = quantity(1.0, "turns", above=0, doc="How many rounds are driven; below 1 it is a part of one.")

    def __post_init__(self) -> None:
        check_quantities(self, PathError)
        _finite(self, center=self.center)
        _require(
            self.direction in ("counter-clockwise", "clockwise"),
            f"circle path: direction must be 'counter-clockwise' or 'clockwise', got {self.direction!r}",
        )

    def curve(self, u: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """The curve p, dp/du and d²p/du², each (2, ...) [m], at ``u`` (...) in [0, 1]."""
        sweep = 2 * pi * self.turns * (1 if self.direction == "counter-clockwise" else -1)
        angle = self.start_angle + sweep * u
        radial = self.radius * np.stack([np.cos(angle), np.sin(angle)])
        normal = self.radius * np.stack([-np.sin(angle), np.cos(angle)])
        center = np.reshape(self.center, (2,) + (1,) * np.ndim(u))
        return center + radial, sweep * normal, -(sweep**2) * radial


@dataclass(frozen=True, kw_only=True)
class Eight:
    """A figure of eight, Bernoulli's lemniscate, from its crossing round its right half and then round its left.

    With a half its width, its length is 5.24412 a, and its curvature at a distance r from the crossing is 3 r/a².
    """

    center: tuple[float, float] = described("The crossing.", (0.0, 0.0))  # m
    width: float = quantity(4.0, "m", above=0, doc="From the outermost point of one half to that of the other.")
    angle: float = turn(0.0, doc="The direction of the right half from the crossing.")
    turns: float = quantity(1.0, "turns", above=0, doc="How often the whole figure is driven.")

    def __post_init__(self) -> None:
        check_quantities(self, PathError)
        _finite(self, center=self.center)

    def curve(self, u: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """See :class:`Shape`."""
        # In the complex plane: z(t) = a cos t/(1 − i sin t), and t = −π/2 is the crossing
        sweep = 2 * pi * self.turns
        t = sweep * np.asarray(u) - pi / 2
        sin, cos = np.sin(t), np.cos(t)
        d = 1 - 1j * sin
        arm = self.width / 2 * np.exp(1j * self.angle)
        center = complex(*self.center)
        z, slope, bend = arm * cos / d, arm * (1j - sin) / d**2, -arm * cos * (3 + 1j * sin) / d**3
        parts = (center + z, sweep * slope, sweep**2 * bend)
        return tuple(np.stack([part.real, part.imag]) for part in parts)  # type: ignore[return-value]


@dataclass(frozen=True, kw_only=True)
class Line:
    """The straight line from ``start`` to ``end``."""

    start: tuple[float, float] = described("The point where the line begins.", example=[0.0, 0.0])
    end: tuple[float, float] = described("The point where the line ends.", example=[5.0, 0.0])

    def __post_init__(self) -> None:
        _finite(self, start=self.start, end=self.end)
        _require(self.start != self.end, f"line path: start and end are the same point {self.start}: its length is 0")

    def curve(self, u: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """The curve p, dp/du and d²p/du², each (2, ...) [m], at ``u`` (...) in [0, 1]."""
        shape = (2,) + (1,) * np.ndim(u)
        start, end = np.reshape(self.start, shape), np.reshape(self.end, shape)
        one = np.ones_like(u)
        return start + (end - start) * u, (end - start) * one, 0.0 * (end - start) * one


@dataclass(frozen=True, kw_only=True)
class Quintic:
    """The fifth-order polynomial p(u) through given ends and end tangents, with p'' = 0 at both ends.

    A tangent is dp/du [m]. A slope dy/dx means the tangent (X, slope · X), with X the extent in x; y is then a quintic
    polynomial of x, the thesis's trajectory (2.3, 5.3).
    """

    start: tuple[float, float] = described("The point where the path begins.", example=[0.0, 0.0])
    end: tuple[float, float] = described("The point where the path ends.", example=[5.0, 1.0])
    start_slope: float = quantity(0.0, "1", doc="The slope dy/dx at the start; the ends need different x for it.")
    end_slope: float = quantity(0.0, "1", doc="The slope dy/dx at the end; the ends need different x for it.")
    start_tangent: tuple[float, float] | None = described(
        "The tangent dp/du [m] at the start, instead of start_slope: its direction, and how long the path keeps to it.",
        None,
        example=[5.0, 0.0],
    )
    end_tangent: tuple[float, float] | None = described(
        "The tangent dp/du [m] at the end, instead of end_slope.", None, example=[5.0, 0.0]
    )

    def __post_init__(self) -> None:
        check_quantities(self, PathError)
        _finite(self, start=self.start, end=self.end)
        _require(
            self.start != self.end, f"quintic path: start and end are the same point {self.start}: its length is 0"
        )
        for name in ("start_tangent", "end_tangent"):
            tangent = getattr(self, name)
            if tangent is not None:
                _finite(self, **{name: tangent})
                _require(hypot(*tangent) > 0, f"quintic path: {name} must not be zero")
            else:
                _require(
                    self.start[0] != self.end[0],
                    "quintic path: a slope dy/dx needs ends with different x; give start_tangent and end_tangent",
                )

    def curve(self, u: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """The curve p, dp/du and d²p/du², each (2, ...) [m], at ``u`` (...) in [0, 1]."""
        shape = (2,) + (1,) * np.ndim(u)
        run = self.end[0] - self.start[0]
        p0, p1 = np.reshape(self.start, shape), np.reshape(self.end, shape)
        t0 = np.reshape(self.start_tangent or (run, run * self.start_slope), shape)
        t1 = np.reshape(self.end_tangent or (run, run * self.end_slope), shape)
        gap = p1 - p0
        c3, c4, c5 = 10 * gap - 6 * t0 - 4 * t1, -15 * gap + 8 * t0 + 7 * t1, 6 * gap - 3 * t0 - 3 * t1
        return (
            p0 + u * (t0 + u**2 * (c3 + u * (c4 + u * c5))),
            t0 + u**2 * (3 * c3 + u * (4 * c4 + u * 5 * c5)),
            u * (6 * c3 + u * (12 * c4 + u * 20 * c5)),
        )


@dataclass(frozen=True, kw_only=True)
class Waypoints:
    """A natural cubic spline through points, its parameter the chord length; closed if the ends coincide."""

    points: tuple[tuple[float, float], ...] = described(
        "The points, at least two, that the path goes through in this order; it is closed if the last is the first.",
        example=[[0.0, 0.0], [2.0, 1.0], [5.0, 0.0]],
    )

    def __post_init__(self) -> None:
        _require(len(self.points) >= 2, f"waypoints path: at least two points are needed, got {len(self.points)}")
        _finite(self, points=self.points)
        for i, (a, b) in enumerate(pairwise(self.points), 1):
            _require(a != b, f"waypoints path: points {i} and {i + 1} are the same, {a}: its length is 0 there")
        apart = np.hypot(*np.diff(np.asarray(self.points, dtype=float), axis=0).T)
        near, length = int(apart.argmin()), float(apart.sum())
        _require(
            apart[near] > _NEAREST * length,
            f"waypoints path: points {near + 1} and {near + 2} are {apart[near]:.3g} m apart, on "
            f"a path of {length:.3g} m; rounding takes them for one",
        )

    def curve(self, u: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """The curve p, dp/du and d²p/du², each (2, ...) [m], at ``u`` (...) in [0, 1]."""
        from scipy.interpolate import CubicSpline

        points = np.asarray(self.points, dtype=float)
        chord = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(points, axis=0).T))])
        closed = len(points) > 3 and self.points[0] == self.points[-1]
        spline = CubicSpline(chord / chord[-1], points, bc_type="periodic" if closed else "natural")
        return (
            np.moveaxis(spline(u), -1, 0),
            np.moveaxis(spline(u, 1), -1, 0),
            np.moveaxis(spline(u, 2), -1, 0),
        )


SHAPES: dict[str, type] = {
    "sine": Sine,
    "circle": Circle,
    "eight": Eight,
    "line": Line,
    "quintic": Quintic,
    "waypoints": Waypoints,
}


def shapes() -> dict[str, type]:
    """All shapes by the names that files give them: those above, and those of the plug-ins that are installed."""
    return SHAPES | {point.name: point.load() for point in entry_points("fuzzyfleet.shapes")}


class PathPoint(NamedTuple):
    """The points of a path at given abscissae; every field has their shape."""

    x: np.ndarray  # m
    y: np.ndarray  # m
    heading: np.ndarray  # rad, continuous along the path (not wrapped)
    curvature: np.ndarray  # 1/m, > 0 to the left


class PathColumns(Columns):
    """The rows of a path's table, by equal steps of its abscissa."""

    x = column("m")
    y = column("m")
    heading = column("rad", "continuous along the path")
    curvature = column("1/m", "> 0 to the left")
    u = column("1", "the shape's parameter")


class NodeColumns(PathColumns):
    """The same with the directions of the tangents, which a point between two nodes is made of."""

    cos = column("1", "of the heading")
    sin = column("1")


def with_tangents(*tables: np.ndarray) -> np.ndarray:
    """The nodes of paths' ``tables`` (PathColumns, nodes), one after the other, as NodeColumns."""
    nodes = np.empty((NodeColumns.size, sum(table.shape[1] for table in tables)))
    np.concatenate(tables, axis=1, out=nodes[: PathColumns.size])
    begins = range(0, nodes.shape[1], _AT_ONCE)
    share_out(lambda first: _fill_in_tangents(nodes, first, min(first + _AT_ONCE, nodes.shape[1])), begins)
    return nodes


@kernel(nogil=True)
def _fill_in_tangents(nodes, first, last):  # type: ignore[no-untyped-def]
    for k in range(first, last):
        node = NodeColumns(nodes, k)
        node.cos, node.sin = np.cos(node.heading), np.sin(node.heading)


@dataclass(frozen=True)
class Path:
    """A path as a table over its abscissa s in [0, length].

    Attributes:
        length: Of the whole path [m].
        table: (PathColumns, nodes).
        shares: Of a robot of a formation (2, nodes): the share of the virtual path, and ds [m] by that share; None: it
            has no place in one.
    """

    length: float
    table: np.ndarray = field(repr=False)
    shares: np.ndarray | None = field(default=None, repr=False)

    @property
    def nodes(self) -> PathColumns:
        """The rows of the table by name."""
        return PathColumns(self.table)

    @cached_property
    def _whole(self) -> np.ndarray:
        return with_tangents(self.table)

    @property
    def spacing(self) -> float:
        """The step of the abscissa between nodes [m]."""
        return self.length / (self.table.shape[1] - 1)

    def at(self, s: np.ndarray | float) -> PathPoint:
        """The points at abscissae ``s`` [m], of any shape; beyond an end the point stays there."""
        s = np.asarray(s, dtype=float)
        rows = _points(self._whole, self.length, np.atleast_1d(s).ravel())
        return PathPoint(*(row.reshape(s.shape) for row in rows))

    def beside(self, x: np.ndarray) -> PathPoint:
        """The points with these ``x`` [m], of any shape, or else the nearer end; x must grow along the path."""
        x = np.asarray(x, dtype=float)
        rows = _points_beside(self._whole, self.length, np.atleast_1d(x).ravel())
        return PathPoint(*(row.reshape(x.shape) for row in rows))

    def abscissa(self, u: np.ndarray) -> np.ndarray:
        """The abscissae [m] of the shape's parameters ``u`` (...) in [0, 1], (...) as these, linear between nodes.

        Where the tangent's length changes fast, to 1e-4 m; elsewhere to 1e-5 m.
        """
        nodes = np.linspace(0.0, self.length, self.table.shape[1])
        return np.interp(u, self.nodes.u, nodes)


def compile_path(shape: Shape, spacing: float = 0.005) -> Path:
    """Make the arc-length table of a shape.

    Args:
        shape: The shape, such as a :class:`Sine`.
        spacing: The most that nodes are apart [m], or a 200,000th of the length, where that is more.

    Returns:
        The path.

    Raises:
        PathError: The curve has no length, stands still or turns on the spot.
    """
    return _tabulated(shape, spacing)


def _tabulated(shape: Shape, spacing: float) -> Path:
    cells = 4096
    edges = np.linspace(0.0, 1.0, cells + 1)
    nodes, weights = np.polynomial.legendre.leggauss(5)
    u = edges[:-1, None] + (nodes + 1) / (2 * cells)
    with np.errstate(over="ignore", invalid="ignore"):  # a curve that overflows is too long, and is refused below
        _, slope, _ = shape.curve(u)
        pieces = np.hypot(slope[0], slope[1]) @ weights / (2 * cells)
        measured = np.concatenate([[0.0], np.cumsum(pieces)])
    length = float(measured[-1])
    name = type(shape).__name__.lower()
    if not 1e-9 < length <= _LONGEST:
        raise PathError(f"{name} path: its length is {length:g} m; a path needs a length > 0 and <= {_LONGEST:g} m")
    count = max(256, min(int(np.ceil(length / spacing)), _MOST_CELLS)) + 1
    s = np.linspace(0.0, length, count)
    with np.errstate(all="ignore"):  # a cusp is refused below
        parameter = _parameter_at(shape, edges, measured, s)
    position, slope, bend = shape.curve(parameter)
    speed = np.hypot(slope[0], slope[1])
    heading = np.unwrap(np.arctan2(slope[1], slope[0]))
    good = speed > 1e-9 * length
    good[1:] &= np.abs(np.diff(heading)) < pi / 2  # otherwise it turns on the spot between two nodes
    if not good.all():
        where = shape.curve(np.interp(s[np.argmin(good)], measured, edges))[0]
        raise PathError(
            f"{name} path: it stands still or turns on the spot near ({where[0]:.3g}, {where[1]:.3g}) m (a cusp); "
            "a robot needs a heading everywhere"
        )
    curvature = (slope[0] * bend[1] - slope[1] * bend[0]) / speed**3  # thesis (5.6), regular at x' = 0
    return Path(length, np.stack([position[0], position[1], heading, curvature, parameter]))


def _parameter_at(shape: Shape, edges: np.ndarray, measured: np.ndarray, s: np.ndarray) -> np.ndarray:
    """Invert the arc length: u with s(u) = ``s``, by Newton's method inside the cell of the quadrature."""
    cell = np.clip(np.searchsorted(measured, s, side="right") - 1, 0, len(edges) - 2)
    start, base = edges[cell], measured[cell]
    u = start + (s - base) / (measured[cell + 1] - base) * (edges[cell + 1] - start)
    nodes, weights = np.polynomial.legendre.leggauss(5)
    for _ in range(4):
        inner = start[:, None] + (u - start)[:, None] * (nodes + 1) / 2
        _, slope, _ = shape.curve(inner)
        travelled = (np.hypot(slope[0], slope[1]) @ weights) * (u - start) / 2
        _, slope, _ = shape.curve(u)
        u = u + (s - base - travelled) / np.hypot(slope[0], slope[1])
    return np.clip(u, 0.0, 1.0)


@kernel
def point(table, first, cells, length, s):  # type: ignore[no-untyped-def]
    """Return x [m], y [m], heading [rad] and curvature [1/m] at one abscissa of one path of a table.

    The interpolation is cubic Hermite: positions with the tangent (cos, sin) of the heading, headings with κ.

    Args:
        table: The table of one path or of several (NodeColumns, nodes).
        first: The column at which the path begins.
        cells: The number of its nodes minus 1.
        length: Its length [m].
        s: The abscissa [m]; beyond an end the point stays there.
    """
    h = length / cells
    place = min(max(s, 0.0), length) / h
    k = min(int(place), cells - 1)
    t = place - k
    k += first
    # The basis functions for values (left, right) and for slopes (left, right)
    right = t * t * (3 - 2 * t)
    left = 1 - right
    slope_left = t * (1 - t) * (1 - t) * h
    slope_right = -t * t * (1 - t) * h
    one, other = NodeColumns(table, k), NodeColumns(table, k + 1)
    x = left * one.x + right * other.x + slope_left * one.cos + slope_right * other.cos
    y = left * one.y + right * other.y + slope_left * one.sin + slope_right * other.sin
    heading = left * one.heading + right * other.heading + slope_left * one.curvature + slope_right * other.curvature
    return x, y, heading, (1 - t) * one.curvature + t * other.curvature


@kernel
def _points(table, length, s):  # type: ignore[no-untyped-def]
    out = np.empty((4, s.shape[0]))
    for i in range(s.shape[0]):
        out[0, i], out[1, i], out[2, i], out[3, i] = point(table, 0, table.shape[1] - 1, length, s[i])
    return out


@kernel
def cell_by_x(table, first, cells, x):  # type: ignore[no-untyped-def]
    """The cell of one path, along which x grows, that has that ``x`` [m], or its first or last.

    Its nodes begin at column ``first`` of ``table``.
    """
    low, high = 0, cells
    while high - low > 1:
        middle = (low + high) // 2
        if table[0, first + middle] <= x:
            low = middle
        else:
            high = middle
    return low


@kernel
def point_beside(table, first, cells, length, x):  # type: ignore[no-untyped-def]
    """The point of one path with that ``x`` [m], or its nearer end: as of :meth:`Path.beside`."""
    low = cell_by_x(table, first, cells, x)
    share = low + (x - table[0, first + low]) / (table[0, first + low + 1] - table[0, first + low])
    s = min(max(share, 0.0), cells) * (length / cells)
    for _ in range(2):  # Newton: dx/ds = cos(heading)
        there = point(table, first, cells, length, s)
        s = min(max(s + (x - there[0]) / np.cos(there[2]), 0.0), length)
    return point(table, first, cells, length, s)


@kernel
def _points_beside(table, length, x):  # type: ignore[no-untyped-def]
    out = np.empty((4, x.shape[0]))
    cells = table.shape[1] - 1
    for i in range(x.shape[0]):
        out[0, i], out[1, i], out[2, i], out[3, i] = point_beside(table, 0, cells, length, x[i])
    return out
