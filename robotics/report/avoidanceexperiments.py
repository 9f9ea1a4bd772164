"""The thesis's experiments on avoidance, run: chapter 6, each scenario under the thesis's rules and under better ones.

All scenarios of a law are driven in one array pass, a run each, which is several times quicker than one by one.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from robotics import plant as p
from robotics.controllers import make_controller
from robotics.ensemble import Ensemble
from robotics.environment.collision import footprints, obstacle_contacts, robot_contacts
from robotics.environment.world import Geometry, World, compile_worlds
from robotics.events import ALONE, STOPPED
from robotics.figures.avoidance import clearances, robot_gaps
from robotics.metrics import cross_track_error
from robotics.paths import Paths
from robotics.run import CHANNELS, TEAM_CHANNELS, Run
from robotics.scenario import Scenario, load_scenario, scenario_names
from robotics.simulation import Period, drive
from robotics.stress.crossings import crossing_ensemble
from robotics.stress.outcome import Outcome, run_ensemble
from robotics.team import arrival_time
from robotics.trajectory import Reference, Trajectory

TESTS = ("chapter-6-test-1", "chapter-6-test-2")
CRASH_LAWS = ("crash-literal", "crash-yielding", "right-of-way")
COURSES = ("chapter-6-simulation-1", "chapter-6-simulation-2", "chapter-6-simulation-3", "chapter-6-experiment")
OBSTACLE_LAWS = ("obstacles-literal", "obstacles")
CROSSERS = ("crash-literal", "right-of-way")
CROSSINGS = 40  # random ones
FACTOR = 2.0  # times the nominal duration: who has not arrived by then counts as waiting for ever
_LONGEST = 70.0  # s of a run that are driven
_REST = 5.0  # s that are driven after all have reached their goals
_OFF = 0.1  # m from the path: off it; from the goal: there
_STANDS = 0.01  # m/s

# How many times run_avoidance_experiments calls ``advance``
STEPS = len(CRASH_LAWS) + len(OBSTACLE_LAWS) + len(CROSSERS)


@dataclass(frozen=True, eq=False)
class AvoidanceResults:
    """Everything that was run."""

    scenarios: dict[str, Scenario]  # by name
    runs: dict[tuple[str, str], Run]  # by scenario and controller
    crossings: dict[str, Outcome]  # by controller, the same random crossings for all


@dataclass(frozen=True)
class Merits:
    """What a run came to, against the exact rectangles."""

    collided: bool  # two robots touched
    hit: bool  # a robot touched an obstacle
    nearest: float  # m between the centers of two robots
    clearance: float  # m between a robot's rectangle and an obstacle; infinite without obstacles
    arrived: tuple[bool, ...]  # by robot
    spread: float  # s between the first and the last arrival, of those that arrive
    ratio: float  # the last arrival over the nominal duration; infinite if nobody arrives
    off: float  # m: the largest distance from a path
    away: float  # s: the longest that a robot was farther than 0.1 m from its path
    stood: tuple[float, ...]  # s, by robot: the longest that it stood still on its way
    left: tuple[int, ...]  # robots, from 1, that the group went on without

    @property
    def safe(self) -> bool:
        """Nothing touched anything."""
        return not (self.collided or self.hit)

    @property
    def together(self) -> bool:
        """All arrived within 0.2 s of each other."""
        return all(self.arrived) and self.spread <= 0.2 + 1e-9


def case_studies() -> list[str]:
    """The scenarios of thesis 6.2.3 that come with the package."""
    return [name for name in scenario_names("team") if name.startswith("chapter-6-case-")]


def run_avoidance_experiments(seed: int = 0, advance: Callable[[], None] | None = None) -> AvoidanceResults:
    """Run them all with ``seed``; ``advance`` is called after every pass, STEPS times."""
    step = advance or (lambda: None)
    cases = case_studies()
    scenarios = {name: load_scenario(name) for name in (*TESTS, *COURSES, *cases)}
    runs: dict[tuple[str, str], Run] = {}
    for law in CRASH_LAWS:
        runs |= {(run.scenario, law): run for run in run_together([scenarios[n] for n in TESTS], law, seed)}
        step()
    for law in OBSTACLE_LAWS:
        settings = [scenarios[name] for name in (*COURSES, *(c for c in cases if scenarios[c].controller == law))]
        runs |= {(run.scenario, law): run for run in run_together(settings, law, seed)}
        step()
    seeds = range(seed, seed + CROSSINGS)
    ensemble = crossing_ensemble(3, seeds, "A", factor=FACTOR)
    crossings = {}
    for law in CROSSERS:
        crossings[law] = run_ensemble(ensemble, make_controller(law), seeds)
        step()
    return AvoidanceResults(scenarios, runs, crossings)


def run_together(settings: Sequence[Scenario], controller: str, seed: int, longest: float = _LONGEST) -> list[Run]:
    """``controller`` on each of ``settings`` with ``seed``, in one pass: the runs of simulate(), up to ``longest`` [s],
    or until all have reached their goals in all of them.

    The scenarios differ in paths, starts, durations and obstacles only; each run is, to the last bit, that of its
    scenario alone. Raises ControllerError, and ValueError for
    scenarios that differ in more.
    """
    first = settings[0]
    for other in settings:
        same = all(getattr(other, n) == getattr(first, n) for n in ("period", "latency", "plant", "sensing", "radio"))
        even = all(m.timing.start == m.timing.ramp == 0 and m.robot == first.robots[0].robot for m in other.robots)
        if not same or not even or other.faults or len(other.robots) != len(first.robots):
            raise ValueError(f"{other.name} cannot be driven together with {first.name}")
    duration = min(longest, max(s.duration for s in settings))
    shared = replace(first, duration=duration, obstacles=())
    worlds = [World(obstacles=s.obstacles, known=False) for s in settings]
    ensemble = Ensemble(
        shared,
        np.stack([s.starts for s in settings]),
        _joined(settings),  # type: ignore[arg-type]
        compile_worlds(worlds) if any(s.obstacles for s in settings) else None,
    )
    law = make_controller(controller)
    recorded = _Record(ensemble.ticks + 1, len(settings), p.velocity_limits([m.robot for m in first.robots]))
    goals = ensemble.trajectory.joined.at(ensemble.trajectory.joined.lengths)
    reached = np.inf
    for period in drive(ensemble, law, [seed] * len(settings)):
        recorded.keep(period)
        if np.isinf(reached) and (np.hypot(period.state[p.X] - goals.x, period.state[p.Y] - goals.y) < _OFF).all():
            reached = period.time
        if period.time > reached + _REST:
            break
    return [recorded.run(r, s, controller, law.level, seed) for r, s in enumerate(settings)]


@dataclass(frozen=True, eq=False)
class _Timing:
    """The references of several scenarios, a run each, to the last bit those of each alone."""

    flat: Trajectory  # all robots of the first run, then those of the second ...
    joined: Paths  # lengths (runs, robots)

    @property
    def ends(self) -> np.ndarray:
        return self.flat.ends.reshape(self.joined.lengths.shape)

    def at(self, time: float) -> Reference:
        return Reference(*(row.reshape(self.joined.lengths.shape) for row in self.flat.at(time)))

    def each_at(self, times: np.ndarray) -> Reference:
        found = self.flat.each_at(np.reshape(times, (1, -1)))
        return Reference(*(row.reshape(self.joined.lengths.shape) for row in found))


def _joined(settings: Sequence[Scenario]) -> _Timing:
    trajectories = [s.trajectory for s in settings]
    flat = Trajectory(
        tuple(path for t in trajectories for path in t.paths),
        np.concatenate([t.tables for t in trajectories]),
        np.concatenate([t.ends for t in trajectories]),
    )
    return _Timing(flat, replace(flat.joined, lengths=flat.joined.lengths.reshape(len(settings), -1)))


class _Record:
    """The samples of a pass as it goes on, and the runs made of them."""

    def __init__(self, samples: int, runs: int, limits: np.ndarray) -> None:
        robots = limits.shape[1]
        self.limits = limits
        self.kept = 0
        self.samples = np.empty((samples, len(CHANNELS), runs, robots))
        self.team = np.empty((samples, len(TEAM_CHANNELS), runs, robots))
        self.modes: np.ndarray | None = None
        self.ranges: np.ndarray | None = None
        self.stopped = np.full((runs, robots), -1)

    def keep(self, period: Period) -> None:
        k, command = period.k, period.command
        self.kept = k + 1
        gone = period.stopped >= 0
        progress = np.nan if command.progress is None else command.progress
        row = self.samples[k]
        row[:5], row[5:8], row[8:10] = period.state[: p.W + 1], period.posture, period.order
        row[10:12] = p.saturate(self.limits, command.v, command.w)
        row[12], row[13] = period.state[p.EFFORT], period.state[p.VARIATION]
        target = period.target
        for n, values in enumerate((progress, target.x, target.y, target.heading, 0.0)):
            self.team[k, n] = values
        row[:, gone] = np.nan
        self.team[k][:, gone] = np.nan
        if command.mode is not None:
            if self.modes is None:
                self.modes = np.zeros((len(self.samples), *gone.shape), dtype=np.int8)
            self.modes[k] = np.where(gone, STOPPED, command.mode)
        if period.ranges is not None:
            if self.ranges is None:
                self.ranges = np.empty((len(self.samples), *period.ranges.shape), dtype=np.float32)
            self.ranges[k] = period.ranges
        self.stopped = np.where(period.lost, k, period.stopped)

    def run(self, r: int, scenario: Scenario, controller: str, level: str, seed: int) -> Run:
        end = min(scenario.ticks + 1, self.kept)
        times, mine = scenario.times[:end], slice(r, r + 1)
        stopped = np.where(self.stopped[mine] < end, self.stopped[mine], -1)
        return Run(
            scenario.name,
            controller,
            level,
            (seed,),
            times,
            self.samples[:end, :, mine],
            np.stack(scenario.trajectory.sampled(times)),
            tuple(path.table[:2] for path in scenario.trajectory.paths),
            stopped,
            self.team[:end, :, mine],
            None,
            None if self.modes is None else self.modes[:end, mine],
            None if self.ranges is None or scenario.world is None else self.ranges[:end, mine],
            _obstacles(scenario, times),
        )


def _obstacles(scenario: Scenario, times: np.ndarray) -> Geometry | None:
    """Where the obstacles are at ``times`` [s]; once, if none moves."""
    world = scenario.world
    if world is None or world.motion is None:
        return None if world is None else world.rest
    return Geometry(*(np.concatenate(parts) for parts in zip(*(world.at(t) for t in times), strict=True)))


def merits(run: Run, scenario: Scenario) -> Merits:
    """What the first seed of a team's ``run`` of ``scenario`` came to."""
    x, y, heading = (run[name][0].T for name in ("x", "y", "heading"))
    sizes = footprints([member.robot for member in scenario.robots])
    arrivals = arrival_time(run)[0]
    there = np.isfinite(arrivals)
    cross = np.abs(cross_track_error(run)[0])
    step = float(run.time[1] - run.time[0])
    still = np.abs(run["v"][0]) < _STANDS
    # Not the start, and not the goal
    on_way = (run.time > 2.0) & (run.time < np.where(there, arrivals, run.time[-1])[:, None] - 0.5)
    modes = np.zeros((1, x.shape[1]), dtype=int) if run.modes is None else run.modes[:, 0].astype(int)
    left = ((modes & ALONE > 0) & (modes < STOPPED)).any(axis=0)
    nominal = float(scenario.trajectory.ends[0])
    return Merits(
        bool((robot_contacts(x, y, heading, sizes) >= 0).any()),
        run.obstacles is not None and bool((obstacle_contacts(x, y, heading, sizes, run.obstacles) >= 0).any()),
        float(min(np.nanmin(gap) for gap in robot_gaps(run, 0).values())),
        float(clearances(run, 0).min()),
        tuple(there.tolist()),
        float(np.ptp(arrivals[there])) if there.any() else np.inf,
        float(arrivals[there].max() / nominal) if there.any() else np.inf,
        float(np.nanmax(cross)),
        max(_longest(row, step) for row in cross > _OFF),
        tuple(_longest(row, step) for row in still & on_way),
        tuple(int(i) + 1 for i in np.flatnonzero(left)),
    )


def _longest(flags: np.ndarray, step: float) -> float:
    """How long [s] ``flags`` (samples,) hold without a break, at most."""
    edges = np.flatnonzero(np.diff(np.concatenate([[0], flags.astype(int), [0]])))
    return float((edges[1::2] - edges[::2]).max(initial=0) * step)
