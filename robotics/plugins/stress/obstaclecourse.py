"""Obstacle courses: one robot or a team on lanes through random fields of obstacles, or into U-shaped traps.

Lanes are 7 m long, side by side, or crossing each other: see :mod:`robotics.plugins.stress.lanes`. The obstacles of
a field, convex polygons, lie along them: in class A with gaps that a robot fits through, in class B overlapping; kind
"U" has a trap across the first lane. Discs may cross the lanes as well. Runs are judged as crossings are, and against
the obstacles. A seed's course is drawn from a generator of its own: it does not depend on the number of runs.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any, Literal

import numpy as np

from fuzzy.shell.progress import Begin, unwatched
from robotics.laws.catalogue import as_law
from robotics.laws.law import Law
from robotics.laws.setting import Setting
from robotics.measures.arrival import together
from robotics.plugins.stress.crossings import SPEED, drawn_ensemble, growth
from robotics.plugins.stress.disturbance import UNDISTURBED, Disturbance
from robotics.plugins.stress.lanes import LENGTH, Lanes, lanes_beside, lanes_crossing
from robotics.plugins.stress.outcome import StressOutcome, of_runs
from robotics.plugins.stress.quintic_table import quintic_table
from robotics.plugins.stress.tally import run_ensemble
from robotics.simulation.scenario.description import ScenarioError
from robotics.simulation.scenario.robots import RobotModel, load_robot
from robotics.world.environment.world import Disc, Obstacle, Point, Polygon, World, WorldError, compile_worlds, u_shape
from robotics.world.paths.joined import table_length
from robotics.world.paths.path import Line, Path
from robotics.world.paths.trajectory import Timing

COURSE_STREAM = 7  # of a seed's random streams: see robotics.world.radio.channel
Kind = Literal["A", "B", "U"]
FASTEST_DISC = 0.2  # m/s
EARLY = 4.0  # s: a disc and a robot on time would meet, but for at most this
DISC = (0.15, 0.3)  # m: the least and the largest radius of a disc
_AWAY = 1.6  # m: the least distance from the lane at which a disc starts, and that at which it ends
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


def obstacle_ensemble(
    seeds: Sequence[int],
    kind: Kind = "A",
    robots: int = 1,
    *,
    disturbance: Disturbance = UNDISTURBED,
    moving: int = 0,
    lanes: Lanes = "beside",
    robot: RobotModel | None = None,
) -> Setting:
    """A random course for every seed.

    A seed's course is the same whatever the other seeds are, and its fixed obstacles are the same whatever moves.

    Args:
        seeds: One course for each.
        kind: Class of the courses: "A", "B" or "U".
        robots: Number of robots, each on a lane of its own.
        disturbance: What is wrong in every run, of which the radio belongs to the setting.
        moving: Number of discs that cross the lanes.
        lanes: Whether the lanes stay beside each other or cross.
        robot: What the robots are, by default the EtsRo; with others all lengths grow as of
            :func:`robotics.plugins.stress.crossings.growth`.

    Raises ScenarioError where there are too few lanes to cross.
    """
    if lanes == "crossing" and robots < 2:
        raise ScenarioError(f"obstacles: lanes cross where there are 2 robots or more, got {robots}")
    drawn = [random_course(np.random.default_rng([seed, COURSE_STREAM]), kind, robots, moving, lanes) for seed in seeds]
    name = f"obstacles-{robots}-{kind}" + ("-crossing" if lanes == "crossing" else "")
    setting = drawn_ensemble(name, [tables for tables, _ in drawn], ObstacleOutcome.limit, LENGTH, disturbance, robot)
    return replace(setting, world=compile_worlds([grown_world(world, growth(robot)) for _, world in drawn]))


def grown_world(world: World, factor: float) -> World:
    """A ``world`` of polygons and of discs on lines that is ``factor`` times as large; discs are as fast."""

    def larger(point: Point) -> Point:
        return factor * point[0], factor * point[1]

    obstacles: list[Obstacle] = []
    for one in world.obstacles:
        if isinstance(one, Polygon):
            corners = tuple(map(larger, one.corners))
            obstacles.append(replace(one, corners=corners, position=larger(one.position)))
        elif isinstance(one, Disc) and isinstance(one.path, Line):
            path = replace(one.path, start=larger(one.path.start), end=larger(one.path.end))
            obstacles.append(replace(one, radius=factor * one.radius, path=path))
    return replace(world, obstacles=tuple(obstacles))


def random_course(
    rng: np.random.Generator, kind: Kind, robots: int, moving: int = 0, lanes: Lanes = "beside"
) -> tuple[list[np.ndarray], World]:
    """The tables of the lanes of one course, and its obstacles.

    Args:
        rng: The generator from which the course is drawn.
        kind: Class of the course: "A", "B" or "U".
        robots: Number of lanes.
        moving: Number of discs that cross a lane.
        lanes: Whether the lanes stay beside each other or cross.
    """
    draw = lanes_crossing if lanes == "crossing" else lanes_beside
    while True:
        tables = [quintic_table(shape) for shape in draw(rng, robots)]
        paths = [Path(table_length(table), table) for table in tables]
        try:
            if kind == "U":
                world = random_trap(rng, paths[0])
            else:
                world = random_field(rng, paths, gap=GAP if kind == "A" else None)
        except WorldError:  # no place: another course
            continue
        nominal = max(path.length for path in paths) / SPEED
        discs = [_crossing_disc(rng, paths[int(rng.integers(robots))], nominal) for _ in range(moving)]
        return tables, World(obstacles=(*world.obstacles, *discs), known=world.known)


def _crossing_disc(rng: np.random.Generator, lane: Path, nominal: float) -> Disc:
    """A disc that crosses ``lane`` at an angle, straight and evenly, about when a robot on time would be there."""
    share, speed = rng.uniform(0.3, 0.7), rng.uniform(0.05, FASTEST_DISC)
    on = lane.at(share * lane.length)
    course = float(on.heading) + rng.choice((-1.0, 1.0)) * rng.uniform(np.pi / 4, 3 * np.pi / 4)
    step = np.array([np.cos(course), np.sin(course)])
    # Timing begins at once: a disc that is to come later starts farther away.
    before = max(_AWAY, speed * (share * nominal + rng.uniform(-EARLY, EARLY)))
    crossing = np.array([float(on.x), float(on.y)])
    start, end = crossing - before * step, crossing + _AWAY * step
    path = Line(start=(float(start[0]), float(start[1])), end=(float(end[0]), float(end[1])))
    return Disc(radius=float(rng.uniform(*DISC)), path=path, timing=Timing(speed=float(speed)))


@dataclass(frozen=True, eq=False)
class ObstacleOutcome(StressOutcome):
    """The outcome of every run among obstacles; ``collided`` says only whether two robots touched."""

    limit = 8.0

    hit = of_runs("hit")  # a robot touched an obstacle
    trapped = of_runs("trapped")  # a robot followed a wall

    @property
    def succeeded(self) -> np.ndarray:
        """Whether all robots arrived and nothing touched (runs,) bool."""
        return np.asarray(self.arrived & ~self.collided & ~self.hit)

    def summary(self) -> dict[str, Any]:
        """The numbers that ``robotics stress obstacles --json`` prints."""
        figures = super().summary()
        seeds = np.array(self.seeds)
        figures["arrived"] = int(self.succeeded.sum())
        figures["arrived_together"] = int((self.succeeded & together(self.arrivals)).sum())
        figures["contacts"] = int((self.collided | self.hit).sum())
        figures["obstacle_contacts"] = int(self.hit.sum())
        figures["followed_wall"] = int(self.trapped.sum())
        if not np.isfinite(figures["min_distance_m"] or 0.0):
            figures["min_distance_m"] = None  # of one robot there is none
        figures["failed_seeds"]["obstacle"] = seeds[self.hit][:50].tolist()
        figures["failed_seeds"]["caused"] = seeds[self.caused.any(axis=1)][:50].tolist()
        return figures


def stress_obstacles(
    controller: Law[Any] | str,
    seeds: Sequence[int],
    kind: Kind = "A",
    robots: int = 1,
    begin: Begin | None = None,
    *,
    disturbance: Disturbance = UNDISTURBED,
    moving: int = 0,
    lanes: Lanes = "beside",
    robot: str | None = None,
) -> ObstacleOutcome:
    """Drive a random course for every seed, and judge what became of it.

    Args:
        controller: The law that drives the robots, or its specification, as worker processes are given it: the class
            of a law in a user's file is known only where that file has run.
        seeds: One course for each.
        kind: Class of the courses: "A", "B" or "U".
        robots: Number of robots of each course.
        begin: Starts a bar of a progress display, by its text and total.
        disturbance: What is wrong in every run.
        moving: Number of discs that cross the lanes.
        lanes: Whether the lanes stay beside each other or cross.
        robot: What the robots are, as :func:`robotics.load_robot` takes it; by default the EtsRo.

    Returns:
        What became of every run.
    """
    model = None if robot is None else load_robot(robot)
    ensemble = obstacle_ensemble(seeds, kind, robots, disturbance=disturbance, moving=moving, lanes=lanes, robot=model)
    advance, faults = (begin or unwatched)("simulating", ensemble.ticks + 1), disturbance.faults(ensemble, seeds)
    return run_ensemble(ObstacleOutcome, ensemble, as_law(controller), seeds, faults, advance, disturbance.extra)
