"""Obstacles of a scenario file: the tables [[obstacles]], each with a ``shape`` and a place.

A shape is one of :mod:`robotics.environment.world` (disc, polygon, wall), or a polygon by its measures: box, regular,
u.
"""

from collections.abc import Callable
from dataclasses import dataclass, fields
from typing import Any

from fuzzy.naming import expected
from robotics.environment.world import OBSTACLES, Obstacle, Point, Polygon, WorldError, box, regular, u_shape
from robotics.paths.path import SHAPES
from robotics.quantity import check_quantities, quantity


@dataclass(frozen=True, kw_only=True)
class _Box:
    """A rectangle: ``length`` along its heading."""

    length: float = quantity(None, "m", above=0, most=1000)
    width: float = quantity(None, "m", above=0, most=1000)

    def corners(self) -> tuple[Point, ...]:
        return box(self.length, self.width)


@dataclass(frozen=True, kw_only=True)
class _Regular:
    """A regular polygon in a circle, with a corner along its heading."""

    sides: int
    radius: float = quantity(None, "m", above=0, most=1000)

    def __post_init__(self) -> None:
        if not 3 <= self.sides <= 1000:
            raise WorldError(f"sides must be a whole number >= 3 and <= 1000, got {self.sides}").about("sides")

    def corners(self) -> tuple[Point, ...]:
        return regular(self.sides, self.radius)


@dataclass(frozen=True, kw_only=True)
class _UShape:
    """A U by the measures of the free space in it; its mouth is behind."""

    width: float = quantity(None, "m", above=0, most=1000)
    depth: float = quantity(None, "m", above=0, most=1000)
    thickness: float = quantity(0.06, "m", above=0, most=10)

    def corners(self) -> tuple[Point, ...]:
        return u_shape(self.width, self.depth, self.thickness)


_MEASURED: dict[str, type] = {"box": _Box, "regular": _Regular, "u": _UShape}


def obstacle_from_table(table: dict[str, Any], keys: tuple[str | int, ...], build: Callable[..., Any]) -> Obstacle:
    """Make the obstacle of one table.

    Args:
        table: The table, which is left as it is.
        keys: Its place in the file, which errors name.
        build: Makes a dataclass, its first argument, of a table.

    Raises WorldError, and what ``build`` raises, with the place in ``at``.
    """
    rest = dict(table)
    kinds = (*OBSTACLES, *_MEASURED)
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
        given["path"] = build(SHAPES[shape], measures, (*keys, "path"))
    if kind in OBSTACLES:
        return _checked(build(OBSTACLES[kind], rest, keys, **given))
    own = {f.name for f in fields(_MEASURED[kind])}
    placed = {f.name for f in fields(Obstacle)}
    for key in rest:
        if key not in own | placed:
            raise WorldError(expected(key, sorted(own | (placed - {"path"})), "key")).about(*keys, key)
    for f in fields(_MEASURED[kind]):
        if f.name not in rest and f.default is None:
            raise WorldError(f"obstacle of shape {kind!r} lacks {f.name}").about(*keys)
    measured = build(_MEASURED[kind], {k: v for k, v in rest.items() if k in own}, keys)
    try:
        check_quantities(measured, WorldError)
    except WorldError as error:
        raise error.about(*keys) from None
    others = {k: v for k, v in rest.items() if k not in own}
    return _checked(build(Polygon, others, keys, corners=measured.corners(), **given))


def _checked(obstacle: Any) -> Obstacle:
    assert isinstance(obstacle, Obstacle)
    return obstacle
