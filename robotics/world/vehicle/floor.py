"""A floor whose friction differs by place: patches, and what the plant makes of them.

A patch's friction f counts from that of the floor elsewhere, for which a robot's numbers are told. A choice: where
f < 1 the whole curve of a tyre shrinks with it. So ``torque_limit``, which is then taken for that of the tyres, and
``castor_drag`` are f times what they are, and the slips 1 / f. A robot whose wheels roll, with slips of 0, only
speeds up and brakes less. What counts is the place of the axle's middle at the begin of a control period.
"""

from collections.abc import Sequence
from dataclasses import MISSING, dataclass
from typing import NamedTuple

import numpy as np

from fuzzy.compiled.columns import Floats1, Floats2, Ints1
from fuzzy.compiled.jit import compiled_only
from fuzzy.errors import InputError
from fuzzy.quantity import check_quantities, described, got, is_number, quantity
from robotics.world.vehicle.plant import ParameterColumns, TruthColumns

Point = tuple[float, float]


class FloorError(InputError):
    """A patch that cannot be. The message names the field, its value and what is accepted."""


@dataclass(frozen=True, kw_only=True)
class Patch:
    """A part of the floor whose friction is another: a disc by center and radius, or a polygon by its corners.

    Where patches overlap, the last one counts. Raises FloorError for values that cannot be.
    """

    friction: float = quantity(
        MISSING, "1", least=0.01, most=10, doc="The floor's friction there over that elsewhere.", example=0.2
    )
    center: Point | None = described("The center of a disc, which needs a radius.", None, example=[2.0, 0.0])
    radius: float | None = quantity(None, "m", above=0, most=1000, doc="The radius of that disc.", example=0.5)
    corners: tuple[Point, ...] | None = described(
        "The corners of a polygon, at least three, in place of center and radius.",
        None,
        example=[[1.0, -1.0], [2.0, -1.0], [2.0, 1.0]],
    )

    def __post_init__(self) -> None:
        check_quantities(self, FloorError)
        name = "center" if self.corners is None else "corners"
        if (self.center is None) != (self.radius is None) or (self.center is None) == (self.corners is None):
            what = "a patch is a disc, which needs center and radius, or a polygon, which needs corners alone"
            raise FloorError(what).about(name)
        if self.corners is not None and len(self.corners) < 3:
            raise FloorError(f"corners must be at least 3 points [x, y] in m, got {len(self.corners)}").about(name)
        for point in self.points:
            if len(point) != 2 or not all(is_number(value) for value in point):
                raise FloorError(f"{name} must be [x, y], finite numbers in m; {got(point)}").about(name)

    @property
    def points(self) -> tuple[Point, ...]:
        """The corners [m], or the center of a disc alone."""
        return (self.center,) if self.center is not None else self.corners or ()

    def outline(self, count: int = 60) -> np.ndarray:
        """Points (n, 2) [m] around it."""
        if self.center is None:
            return np.array(self.points)
        angles = np.linspace(0.0, 2 * np.pi, count, endpoint=False)
        return np.array(self.center) + (self.radius or 0.0) * np.stack([np.cos(angles), np.sin(angles)], axis=1)


class Floor(NamedTuple):
    """Patches, as compiled code reads them."""

    points: Floats2  # (points, 2) m: corners, and centers of discs
    first: Ints1  # (patches,): the first point of each,
    number: Ints1  # and how many it has; 1: a disc
    radius: Floats1  # (patches,) m
    friction: Floats1  # (patches,)
    usual: Floats2  # (4, lanes): torque_limit, castor_drag and the slips of each robot elsewhere


def compiled_floor(patches: Sequence[Patch], parameters: np.ndarray) -> Floor:
    """The patches, for robots of ``parameters`` (ParameterColumns, lanes)."""
    outlines = [patch.points for patch in patches]
    number = np.array([len(points) for points in outlines], dtype=np.int64)
    return Floor(
        np.array([point for points in outlines for point in points], dtype=float).reshape(-1, 2),
        np.cumsum(number) - number,
        number,
        np.array([patch.radius or 0.0 for patch in patches]),
        np.array([patch.friction for patch in patches], dtype=float),
        usual(parameters),
    )


def usual(parameters: np.ndarray) -> np.ndarray:
    """What a floor changes of parameters (ParameterColumns, lanes), where it changes nothing (4, lanes)."""
    robots = ParameterColumns(parameters)
    return np.stack([robots.torque_limit, robots.castor_drag, robots.longitudinal_slip, robots.lateral_slip])


@compiled_only
def friction_at(floor, x, y):  # type: ignore[no-untyped-def]
    """The floor's friction at a place, over that outside all patches."""
    found = 1.0
    for j in range(len(floor.friction)):
        first, number = floor.first[j], floor.number[j]
        if number == 1:
            dx, dy = x - floor.points[first, 0], y - floor.points[first, 1]
            inside = dx * dx + dy * dy <= floor.radius[j] * floor.radius[j]
        else:  # how often a ray to the right crosses its sides
            inside = False
            for k in range(number):
                a, b = first + k, first + (k + 1) % number
                ax, ay, bx, by = floor.points[a, 0], floor.points[a, 1], floor.points[b, 0], floor.points[b, 1]
                if (ay > y) != (by > y) and x < ax + (bx - ax) * (y - ay) / (by - ay):
                    inside = not inside
        if inside:
            found = floor.friction[j]
    return found


@compiled_only
def tread(first, last, floor, truth, parameters):  # type: ignore[no-untyped-def]
    """Give the robots of the lanes from ``first`` to before ``last`` the numbers of the floor where they are."""
    for i in range(first, last):
        here, robot = TruthColumns(truth, i), ParameterColumns(parameters, i)
        friction = friction_at(floor, here.x, here.y)
        robot.torque_limit = floor.usual[0, i] * friction
        robot.castor_drag = floor.usual[1, i] * friction
        robot.longitudinal_slip = floor.usual[2, i] / friction
        robot.lateral_slip = floor.usual[3, i] / friction
