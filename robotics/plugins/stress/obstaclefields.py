"""Random obstacle fields: convex polygons along paths, and U-shaped traps across one.

Class A keeps gaps through which a robot fits, class B lets obstacles overlap. All functions draw from a given
generator: with one that is seeded by a run's seed, the run's field does not depend on the number of runs.
"""

from collections.abc import Sequence

import numpy as np

from robotics.world.environment.world import Point, Polygon, World, WorldError, u_shape
from robotics.world.paths.path import Path

GAP = 0.7  # m between the obstacles of class A: more than twice a robot's diagonal
_MOST = 6  # polygons; 1 or more are drawn
_RADIUS = (0.15, 0.45)  # m, from and to: of the circles that they fill
_SPREAD = 0.8  # m: how far beside a path their centers may lie
_CLEAR = 0.6  # m: the least distance from where a path begins or ends
_WIDTH, _DEPTH = (0.7, 1.4), (0.4, 1.2)  # m, from and to: the free width between a trap's arms, and its free depth
_TURN = 0.4  # rad: the largest angle by which a trap is turned, either way
_THICKNESS = 0.06  # m, of its walls
_TRIES = 64  # the number of places tried for an obstacle before it is left out


def random_field(generator: np.random.Generator, paths: Sequence[Path], *, gap: float | None = GAP) -> World:
    """Draw convex polygons along the middle 80 % of paths.

    Polygons that find no place are left out. Raises WorldError where none finds one.

    Args:
        generator: The source of all randomness.
        paths: The paths, at least one.
        gap: The least distance between two polygons [m] (class A); None lets them overlap (class B).
    """
    if not paths:
        raise WorldError("paths: at least one is needed to put obstacles on")
    ends = np.array([path.table[:2, k] for path in paths for k in (0, -1)])
    placed = np.empty((0, 3))
    polygons = []
    for _ in range(int(generator.integers(1, _MOST, endpoint=True))):
        candidates = _candidates(generator, paths)
        free = _distances(candidates, ends) - candidates[:, 2:] >= _CLEAR
        good = free.all(axis=1)
        if gap is not None:
            between = _distances(candidates, placed[:, :2]) - candidates[:, 2:] - placed[:, 2]
            good &= (between >= gap).all(axis=1)
        corners = _corners(generator)
        if good.any():
            x, y, size = candidates[int(np.argmax(good))].tolist()
            placed = np.concatenate([placed, [[x, y, size]]])
            polygons.append(Polygon(corners=tuple((size * a, size * b) for a, b in corners), position=(x, y)))
    if not polygons:
        raise WorldError(f"no obstacle finds a place {_CLEAR:g} m clear of where the paths begin and end")
    return World(obstacles=tuple(polygons), known=False)


def random_trap(generator: np.random.Generator, path: Path) -> World:
    """Draw a U about the middle of a path, its mouth towards the robot that comes.

    Raises WorldError where the path is too short to begin and end 0.6 m away from the U. ``generator`` is the source of
    all randomness.
    """
    wide, deep, angle = generator.uniform(*_WIDTH), generator.uniform(*_DEPTH), generator.uniform(-_TURN, _TURN)
    on = path.at(generator.uniform(0.45, 0.55) * path.length)
    size = float(np.hypot(wide / 2 + _THICKNESS, deep / 2 + _THICKNESS))
    for k in (0, -1):
        away = float(np.hypot(path.table[0, k] - on.x, path.table[1, k] - on.y)) - size
        if away < _CLEAR:
            raise WorldError(f"a path must begin and end {_CLEAR:g} m or more from a trap on it, got {away:.3g} m")
    heading = float(np.arctan2(np.sin(on.heading + angle), np.cos(on.heading + angle)))
    corners = u_shape(wide, deep, _THICKNESS)
    return World(
        obstacles=(Polygon(corners=corners, position=(float(on.x), float(on.y)), heading=heading),), known=False
    )


def _candidates(generator: np.random.Generator, paths: Sequence[Path]) -> np.ndarray:
    """Places where an obstacle might be (tries, 3): x, y and the radius around it [m]."""
    path = paths[int(generator.integers(len(paths)))]
    place, beside = generator.uniform(0.1, 0.9, _TRIES), generator.uniform(-_SPREAD, _SPREAD, _TRIES)
    on = path.at(place * path.length)
    size = generator.uniform(*_RADIUS, _TRIES)
    return np.stack([on.x - beside * np.sin(on.heading), on.y + beside * np.cos(on.heading), size], axis=1)


def _distances(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    return np.hypot(a[:, None, 0] - b[:, 0], a[:, None, 1] - b[:, 1])


def _corners(generator: np.random.Generator) -> list[Point]:
    """Four to eight corners on the unit circle, unevenly: no angle is sharper than 67°."""
    count = int(generator.integers(4, 8, endpoint=True))
    even = np.arange(count) + generator.uniform(-0.25, 0.25, count)
    angles = 2 * np.pi * even / count + generator.uniform(0, 2 * np.pi)
    return [(float(np.cos(a)), float(np.sin(a))) for a in angles]
