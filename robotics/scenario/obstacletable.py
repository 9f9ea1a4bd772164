"""Obstacles of a scenario file: the tables [[obstacles]], each with a ``shape`` and a place.

A shape is one of :mod:`robotics.environment.world` (disc, polygon, wall), or a polygon by its measures: box, regular,
u.
"""

from collections.abc import Callable
from dataclasses import MISSING, dataclass, fields
from typing import Any

from fuzzy.naming import expected
from robotics.environment.world import OBSTACLES, Obstacle, Point, Polygon, WorldError, box, regular, u_shape
from robotics.paths.path import SHAPES
from robotics.quantity import check_quantities, quantity, whole


@dataclass(frozen=True, kw_only=True)
class Box:
    """A rectangle: ``length`` along its heading."""

    length: float = quantity(MISSING, "m", above=0, most=1000, doc="Its extent along its heading.", example=0.5)
    width: float = quantity(MISSING, "m", above=0, most=1000, doc="Its extent across its heading.", example=0.3)

    def __post_init__(self) -> None:
        check_quantities(self, WorldError)

    def corners(self) -> tuple[Point, ...]:
        """The corners [m]."""
        return box(self.length, self.width)


@dataclass(frozen=True, kw_only=True)
class Regular:
    """A regular polygon in a circle, with a corner along its heading."""

    sides: int = whole(MISSING, least=3, most=1000, doc="How many sides it has.", example=6)
    radius: float = quantity(
        MISSING, "m", above=0, most=1000, doc="The distance of its corners from its middle.", example=0.25
    )

    def __post_init__(self) -> None:
        check_quantities(self, WorldError)

    def corners(self) -> tuple[Point, ...]:
        """The corners [m]."""
        return regular(self.sides, self.radius)


@dataclass(frozen=True, kw_only=True)
class UShape:
    """A U by the measures of the free space in it; its mouth is behind."""

    width: float = quantity(
        MISSING, "m", above=0, most=1000, doc="The free width between its arms, across its heading.", example=0.9
    )
    depth: float = quantity(
        MISSING, "m", above=0, most=1000, doc="The free depth from its mouth to its bottom.", example=0.8
    )
    thickness: float = quantity(0.06, "m", above=0, most=10, doc="The thickness of its walls.")

    def __post_init__(self) -> None:
        check_quantities(self, WorldError)

    def corners(self) -> tuple[Point, ...]:
        """The corners [m]."""
        return u_shape(self.width, self.depth, self.thickness)


MEASURED: dict[str, type] = {"box": Box, "regular": Regular, "u": UShape}


def obstacle_from_table(table: dict[str, Any], keys: tuple[str | int, ...], build: Callable[..., Any]) -> Obstacle:
    """Make the obstacle of one table.

    Args:
        table: The table, which is left as it is.
        keys: Its place in the file, which errors name.
        build: Makes a dataclass, its first argument, of a table.

    Raises WorldError, and what ``build`` raises, with the place in ``at``.
    """
    rest = dict(table)
    kinds = (*OBSTACLES, *MEASURED)
    if "shape" not in rest:
        raise WorldError(f"an obstacle lacks shape, one of {', '.join(kinds)}").about(*keys)
    kind = rest.pop("shape")
    if not isinstance(kind, str) or kind not in kinds:
        raise WorldError(expected(str(kind), kinds, "obstacle shape")).about(*keys, "shape")
    given: dict[str, Any] = {}
    if "path" in rest:
        path = rest.pop("path")
        shape = path.get("shape") if isinstance(path, dict) else None
        if not isinstance(shape, str) or shape not in SHAPES:
            raise WorldError(f"path must be a table with a shape, one of {', '.join(SHAPES)}").about(*keys, "path")
        measures = {k: v for k, v in path.items() if k != "shape"}
        given["path"] = build(SHAPES[shape], measures, (*keys, "path"), ("shape",))
    if kind in OBSTACLES:
        return _checked(build(OBSTACLES[kind], rest, keys, ("shape", "path") if given else ("shape",), **given))
    own = {f.name for f in fields(MEASURED[kind])}
    placed = {f.name for f in fields(Obstacle)}
    for key in rest:
        if key not in own | placed:
            raise WorldError(expected(key, sorted({"shape"} | own | placed), "key")).about(*keys, key)
    measured = build(MEASURED[kind], {k: v for k, v in rest.items() if k in own}, keys)
    others = {k: v for k, v in rest.items() if k not in own}
    return _checked(build(Polygon, others, keys, corners=measured.corners(), **given))


def _checked(obstacle: Any) -> Obstacle:
    assert isinstance(obstacle, Obstacle)
    return obstacle
