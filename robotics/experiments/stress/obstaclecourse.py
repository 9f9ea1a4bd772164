"""Obstacle courses: one robot or a team on lanes through random fields of obstacles, or into U-shaped traps.

Lanes are 7 m of quintics, side by side. The obstacles of a field lie along them: in class A with gaps that a robot fits
through, in class B overlapping; kind "U" has a trap across the first lane. Discs may cross the lanes as well. Runs are
judged as crossings are, and against the obstacles.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any, Literal

import numpy as np

from robotics.environment.collision import footprints, obstacle_clearance
from robotics.environment.obstaclefields import GAP, random_field, random_trap
from robotics.environment.swept import TO_OBSTACLE, TO_ROBOT, Watch
from robotics.environment.world import Disc, World, WorldError, compile_worlds
from robotics.experiments.stress.outcome import Disturbance, StressOutcome
from robotics.laws.law import Law
from robotics.laws.modes import FOLLOW
from robotics.laws.setting import Setting
from robotics.measures.arrival import at_goal, together
from robotics.paths.joined import join_tables, table_length
from robotics.paths.path import Line, Path, Quintic, X, Y
from robotics.paths.quintic_table import quintic_table
from robotics.paths.references import EvenTiming
from robotics.paths.trajectory import Timing
from robotics.radio.description import Radio
from robotics.scenario.description import Member, Scenario
from robotics.sensing.posture import LABORATORY
from robotics.simulation.loop import drive
from robotics.vehicle import plant as p

COURSE_STREAM = 7  # of a seed's random streams: see robotics.radio.channel
Kind = Literal["A", "B", "U"]
LENGTH = 7.0  # m, along x
APART = 1.5  # m between the starts of lanes
BEND = {1: 1.5, 3: 0.4}  # m, by the number of robots: the most by which a lane ends beside its start
SPEED = 0.22  # m/s: mean speed on the longest lane
FASTEST_DISC = 0.2  # m/s
EARLY = 4.0  # s: a disc and a robot on time would meet, but for at most this
DISC = (0.15, 0.3)  # m: the least and the largest radius of a disc
AWAY = 1.6  # m: the least distance from the lane at which a disc starts, and that at which it ends
APPROACH = 0.02  # m/s: a robot that came no faster towards an obstacle did not drive into it
LONGEST = 8.0  # times the nominal duration: a run ends then


def obstacle_ensemble(
    seeds: Sequence[int], kind: Kind = "A", robots: int = 1, *, radio: Radio | None = None, moving: int = 0
) -> Setting:
    """A random course for every seed.

    A seed's course is the same whatever the other seeds are, and its fixed obstacles are the same whatever moves.

    Args:
        seeds: One course for each.
        kind: Class of the courses: "A", "B" or "U".
        robots: Number of robots, each on a lane of its own.
        radio: The radio over which the robots talk, by default a perfect one.
        moving: Number of discs that cross the lanes.
    """
    drawn = [random_course(np.random.default_rng([seed, COURSE_STREAM]), kind, robots, moving) for seed in seeds]
    tables = [course[0] for course in drawn]
    paths = join_tables(tables)
    durations = paths.lengths.max(axis=1) / SPEED
    starts = np.array([[(t[X, 0], t[Y, 0], t[2, 0]) for t in row] for row in tables])
    shared = Member(
        start=(0.0, 0.0, 0.0),
        path=Quintic(start=(0.0, 0.0), end=(5.0, 0.0)),
        timing=Timing(duration=float(np.ceil(durations.max()))),
    )
    scenario = Scenario(
        name=f"obstacles-{robots}-{kind}",
        robots=(shared,) * robots,
        duration=float(np.ceil(LONGEST * durations.max())),
        kind="team" if robots > 1 else "tracking",
        sensing=LABORATORY,
        radio=radio or Radio(),
    )
    worlds = compile_worlds([course[1] for course in drawn])
    return replace(scenario.setting, starts=starts, references=EvenTiming(paths, durations), world=worlds)


def random_course(rng: np.random.Generator, kind: Kind, robots: int, moving: int = 0) -> tuple[list[np.ndarray], World]:
    """The tables of the lanes of one course, and its obstacles.

    Args:
        rng: The generator from which the course is drawn.
        kind: Class of the course: "A", "B" or "U".
        robots: Number of lanes.
        moving: Number of discs that cross a lane.
    """
    while True:
        bend = BEND.get(robots, 0.4)
        tables = []
        for i in range(robots):
            y = APART * ((robots - 1) / 2 - i)
            end = y + rng.uniform(-bend, bend)
            tables.append(quintic_table(Quintic(start=(0.0, y), end=(LENGTH, end))))
        lanes = [Path(table_length(table), table) for table in tables]
        try:
            if kind == "U":
                world = random_trap(rng, lanes[0])
            else:
                world = random_field(rng, lanes, gap=GAP if kind == "A" else None)
        except WorldError:  # no place: another course
            continue
        nominal = max(lane.length for lane in lanes) / SPEED
        discs = [_crossing_disc(rng, lanes[int(rng.integers(robots))], nominal) for _ in range(moving)]
        return tables, World(obstacles=(*world.obstacles, *discs), known=world.known)


def _crossing_disc(rng: np.random.Generator, lane: Path, nominal: float) -> Disc:
    """A disc that crosses ``lane`` at an angle, straight and evenly, about when a robot on time would be there."""
    share, speed = rng.uniform(0.3, 0.7), rng.uniform(0.05, FASTEST_DISC)
    on = lane.at(share * lane.length)
    course = float(on.heading) + rng.choice((-1.0, 1.0)) * rng.uniform(np.pi / 4, 3 * np.pi / 4)
    step = np.array([np.cos(course), np.sin(course)])
    # Timing begins at once: a disc that is to come later starts farther away.
    before = max(AWAY, speed * (share * nominal + rng.uniform(-EARLY, EARLY)))
    crossing = np.array([float(on.x), float(on.y)])
    start, end = crossing - before * step, crossing + AWAY * step
    path = Line(start=(float(start[0]), float(start[1])), end=(float(end[0]), float(end[1])))
    return Disc(radius=float(rng.uniform(*DISC)), path=path, timing=Timing(speed=float(speed)))


@dataclass(frozen=True, eq=False)
class ObstacleOutcome(StressOutcome):
    """The outcome of every run among obstacles; ``collided`` says only whether two robots touched."""

    hit: np.ndarray  # (runs,) bool: a robot touched an obstacle
    trapped: np.ndarray  # (runs,) bool: a robot followed a wall
    caused: np.ndarray  # (runs,) bool: a robot drove into an obstacle; else the obstacle drove into it

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
        figures["contacts_caused"] = int((self.collided | self.caused).sum())
        figures["followed_wall"] = int(self.trapped.sum())
        if not np.isfinite(figures["min_distance_m"] or 0.0):
            figures["min_distance_m"] = None  # of one robot there is none
        figures["failed_seeds"]["obstacle"] = seeds[self.hit][:50].tolist()
        figures["failed_seeds"]["caused"] = seeds[self.caused][:50].tolist()
        return figures


def stress_obstacles(
    controller: Law[Any],
    seeds: Sequence[int],
    kind: Kind = "A",
    robots: int = 1,
    begin: Callable[[str, int], Callable[[], None]] | None = None,
    *,
    disturbance: Disturbance | None = None,
    moving: int = 0,
) -> ObstacleOutcome:
    """Drive a random course for every seed, and judge what became of it.

    Args:
        controller: The law that drives the robots.
        seeds: One course for each.
        kind: Class of the courses: "A", "B" or "U".
        robots: Number of robots of each course.
        begin: Starts a bar of a progress display, by its text and total.
        disturbance: The loss and latency of messages; its ``freeze`` plays no part.
        moving: Number of discs that cross the lanes.
    """
    start = begin or (lambda text, total: lambda: None)
    wrong = disturbance or Disturbance()
    radio = Radio(loss=wrong.loss, latency=wrong.latency)
    ensemble = obstacle_ensemble(seeds, kind, robots, radio=radio, moving=moving)
    return run_course(ensemble, controller, seeds, start("simulating", ensemble.ticks + 1))


def run_course(
    ensemble: Setting,
    controller: Law[Any],
    seeds: Sequence[int],
    advance: Callable[[], None] | None = None,
) -> ObstacleOutcome:
    """Drive until in every run all robots have arrived or something touched, or the time is up.

    The clearance of a run is that up to the period of its first contact.

    Args:
        ensemble: The courses.
        controller: The law that drives the robots.
        seeds: The seed of each run.
        advance: Called after every period.
    """
    runs, robots = len(seeds), len(ensemble.robots)
    assert ensemble.world is not None
    paths, durations = ensemble.references.joined, ensemble.references.ends[:, 0]
    ends = paths.at(paths.lengths)
    sizes = footprints(ensemble.robots)
    arrivals = np.full((runs, robots), np.inf)
    trapped, caused = np.zeros(runs, dtype=bool), np.zeros(runs, dtype=bool)
    nearest = np.full(runs, np.inf)
    pairs = np.triu_indices(robots, 1)
    watch: Watch | None = None
    for state in drive(ensemble, controller, seeds):
        poses, geometry = state.truth[: p.W + 1], ensemble.world.at(state.time)
        x, y = poses[: p.Y + 1]
        if robots > 1:
            gaps = np.hypot(x[:, pairs[0]] - x[:, pairs[1]], y[:, pairs[0]] - y[:, pairs[1]]).min(axis=1)
            nearest = np.minimum(nearest, gaps)
        if watch is None:
            watch = Watch.opened(ensemble.robots, state.time, poses, geometry)
        else:
            before = watch
            watch, _ = before.to(state.time, poses, geometry, going=np.isinf(before.first).all(axis=(0, 2)))
            newly = np.isfinite(watch.first[TO_OBSTACLE]) & np.isinf(before.first[TO_OBSTACLE])
            if newly.any():
                caused |= (newly & _drove(before, state.time, poses, sizes)).any(axis=1)
        collided, hit = np.isfinite(watch.first[[TO_ROBOT, TO_OBSTACLE]]).any(axis=2)
        if state.command.mode is not None:
            trapped |= (state.command.mode & 3 == FOLLOW).any(axis=1)
        there = at_goal(x, y, ends, paths.lengths)
        arrivals = np.where(there & np.isinf(arrivals), state.time, arrivals)
        if advance is not None:
            advance()
        if (np.isfinite(arrivals).all(axis=1) | hit | collided).all():
            break
    assert watch is not None  # there is a first state
    refused = np.zeros(runs, dtype=bool)
    crossed = (arrivals, collided, refused, nearest, watch.least.min(axis=(0, 2)))
    return ObstacleOutcome(tuple(seeds), durations, *crossed, hit, trapped=trapped, caused=caused)


def _drove(before: Watch, time: float, poses: np.ndarray, sizes: np.ndarray) -> np.ndarray:
    """Whether the robots' own motion since ``before`` led to contact, had the obstacles stayed (runs, robots) bool."""
    assert before.geometry is not None
    at_first = Watch.opened(before.robots, before.time, before.poses, before.geometry)
    alone, _ = at_first.to(time, poses, before.geometry)
    free = [obstacle_clearance(x, y, psi, sizes, before.geometry) for x, y, psi, *_ in (before.poses, poses)]
    nearer = free[0] - free[1] > APPROACH * (time - before.time)
    return np.asarray(np.isfinite(alone.first[TO_OBSTACLE]) | nearer)
