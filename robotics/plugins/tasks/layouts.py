"""Random layouts of the tasks: paths of a team, and the obstacles on the way. Lengths are for the EtsRo, and grow.

Each is drawn from a generator that the caller gives: by the same numbers it is the same layout everywhere.
"""

from collections.abc import Callable, Mapping
from math import cos, pi, sin
from typing import Any, Literal, NamedTuple, get_args

import numpy as np

from robotics.plugins.stress.crossings import random_crossings
from robotics.plugins.stress.obstaclecourse import random_course
from robotics.plugins.stress.quintic_table import quintic_table
from robotics.world.environment.world import Obstacle, Polygon, box
from robotics.world.paths.path import Quintic, Waypoints, compile_path

Task = Literal["lanes", "crossing", "dense", "circle", "corridor", "gate", "course", "joined", "trap"]
TASKS: tuple[str, ...] = get_args(Task)
_LANE = 1.2  # m between lanes
_SHORTEST, _LONGEST = 3.0, 8.0  # m: lanes
_APART = 0.9  # m between the starts of robots that drive through a corridor or a gate
_LENGTH = 7.0  # m, along x
_ROOM = (0.75, 1.2)  # m of a circle's circumference a robot
_CORRIDOR = (1.3, 2.4)  # m: its width
_GATE = (0.7, 1.3)  # m: likewise
_WALL = 0.1  # m: how thick walls are
_BESIDE = 0.3  # m from a wall to the nearest path


class Layout(NamedTuple):
    """The paths of a team, and the obstacles."""

    tables: list[np.ndarray]  # of the paths
    obstacles: tuple[Obstacle, ...] = ()


def draw_layout(task: str, rng: np.random.Generator, robots: int, discs: int) -> Layout:
    """Draw the layout of a task.

    Args:
        task: One of TASKS.
        rng: The generator.
        robots: How many robots there are.
        discs: How many discs cross the lanes of an obstacle course.
    """
    return _DRAWN[task](rng, robots, discs)


def _lanes(rng: np.random.Generator, robots: int, discs: int) -> Layout:
    """Lanes beside each other, of unequal lengths: who has the longest way drives fastest."""
    lengths = rng.uniform(_SHORTEST, _LONGEST, robots)
    bends = rng.uniform(-0.3, 0.3, robots)
    rows = zip(_LANE * np.arange(robots), lengths, bends, strict=True)
    return Layout([_straight((0.0, float(y)), (float(x), float(y + bend))) for y, x, bend in rows])


def _crossing(rng: np.random.Generator, robots: int, discs: int) -> Layout:
    return Layout(random_crossings(robots, [rng], "A")[0])


def _dense(rng: np.random.Generator, robots: int, discs: int) -> Layout:
    """A crossing whose ends may lie on the others' ways."""
    return Layout(random_crossings(robots, [rng], "B")[0])


def _circle(rng: np.random.Generator, robots: int, discs: int) -> Layout:
    """Each robot to the opposite point of a circle, from somewhere near its place on it."""
    radius = max(1.5, robots * float(rng.uniform(*_ROOM)) / (2 * pi))
    turned = float(rng.uniform(0, 2 * pi))
    angles = turned + 2 * pi * np.arange(robots) / robots + rng.uniform(-0.1, 0.1, robots)
    places = [(radius * cos(a), radius * sin(a)) for a in angles.tolist()]
    return Layout([_straight(place, (-place[0], -place[1])) for place in places])


def _corridor(rng: np.random.Generator, robots: int, discs: int) -> Layout:
    """Half of the robots from the left, the others from the right, through one corridor."""
    width = float(rng.uniform(*_CORRIDOR))
    order = rng.permutation(robots)
    tables: list[np.ndarray] = [np.empty(0)] * robots
    for place, robot in enumerate(order.tolist()):
        behind, side = place // 2, 1.0 if place % 2 else -1.0
        many = (robots + 1 - place % 2) // 2
        first, last = side * (_LENGTH / 2 + _APART * behind), -side * (_LENGTH / 2 + _APART * (many - 1 - behind))
        at, to = (float(rng.uniform(-1, 1)) * (width / 2 - _BESIDE) for _ in range(2))
        tables[robot] = _straight((first, at), (last, to))
    length = _LENGTH - 2.5
    walls = [_box((0.0, s * (width + _WALL) / 2), length, _WALL) for s in (-1.0, 1.0)]
    return Layout(tables, tuple(walls))


def _gate(rng: np.random.Generator, robots: int, discs: int) -> Layout:
    """All through one gap in a wall, to places in another order."""
    gap, middle = float(rng.uniform(*_GATE)), float(rng.uniform(-0.5, 0.5))
    places = _APART * ((robots - 1) / 2 - np.arange(robots))
    ends, half = places[rng.permutation(robots)], _LENGTH / 2
    near = 0.5
    tables = []
    for start, end in zip(places.tolist(), ends.tolist(), strict=True):
        points = ((-half, start), (-near, middle), (near, middle), (half, end))
        tables.append(compile_path(Waypoints(points=points)).table)
    reach = float(abs(places).max()) + 2.0
    walls = [_box((0.0, middle + s * (gap + reach) / 2), _WALL, reach) for s in (-1.0, 1.0)]
    return Layout(tables, tuple(walls))


def _course(rng: np.random.Generator, robots: int, discs: int) -> Layout:
    """Obstacles along lanes beside each other, near each other or overlapping."""
    return _of_course(random_course(rng, "A" if rng.random() < 0.5 else "B", robots, discs, "beside"))


def _joined(rng: np.random.Generator, robots: int, discs: int) -> Layout:
    """Obstacles along lanes that cross."""
    return _of_course(random_course(rng, "A", robots, discs, "crossing"))


def _trap(rng: np.random.Generator, robots: int, discs: int) -> Layout:
    """A U across the first robot's lane."""
    return _of_course(random_course(rng, "U", robots, discs, "beside"))


def _of_course(drawn: tuple[list[np.ndarray], Any]) -> Layout:
    tables, world = drawn
    return Layout(tables, world.obstacles)


def _straight(start: tuple[float, float], end: tuple[float, float]) -> np.ndarray:
    return quintic_table(Quintic(start=start, end=end))


def _box(position: tuple[float, float], length: float, width: float) -> Polygon:
    return Polygon(corners=box(length, width), position=position)


_DRAWN: Mapping[str, Callable[[np.random.Generator, int, int], Layout]] = {
    "lanes": _lanes,
    "crossing": _crossing,
    "dense": _dense,
    "circle": _circle,
    "corridor": _corridor,
    "gate": _gate,
    "course": _course,
    "joined": _joined,
    "trap": _trap,
}
