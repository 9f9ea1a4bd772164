"""The thesis's experiments on avoidance, run: chapter 6, each scenario under the thesis's rules and under better ones.

All scenarios of a law are driven in one array pass, a run each, which is several times quicker than one by one.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from robotics import plant as p
from robotics.catalogue import make_controller
from robotics.ensemble import Ensemble
from robotics.environment.collision import footprints, obstacle_contacts, robot_contacts
from robotics.environment.world import World, compile_worlds
from robotics.metrics import cross_track_error
from robotics.modes import ALONE, STOPPED
from robotics.paths import Paths
from robotics.run import Run
from robotics.scenario import Scenario, load_scenario, scenario_names
from robotics.simulation import Recorder, drive
from robotics.stress.crossings import crossing_ensemble
from robotics.stress.outcome import Outcome, run_ensemble
from robotics.team import arrival_time
from robotics.trajectory import Reference, Trajectory

TESTS = ("chapter-6-test-1", "chapter-6-test-2")
CRASH_LAWS = ("crash-literal", "crash-yielding", "right-of-way")
COURSES = ("chapter-6-simulation-1", "chapter-6-simulation-2", "chapter-6-simulation-3", "chapter-6-experiment")
OBSTACLE_LAWS = ("obstacles-literal", "obstacles")
CROSSERS = ("crash-literal", "right-of-way")
CROSSINGS = 24  # random ones
FACTOR = 1.6  # times the nominal duration: who has not arrived by then counts as waiting for ever
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
    recorded = Recorder(ensemble.ticks + 1, len(settings), [m.robot for m in first.robots], team=True)
    goals = ensemble.trajectory.joined.at(ensemble.trajectory.joined.lengths)
    reached = np.inf
    for period in drive(ensemble, law, [seed] * len(settings)):
        recorded.keep(period)
        if np.isinf(reached) and (np.hypot(period.state[p.X] - goals.x, period.state[p.Y] - goals.y) < _OFF).all():
            reached = period.time
        if period.time > reached + _REST:
            break
    return [recorded.run(s, law.level, (seed,), controller, slice(r, r + 1)) for r, s in enumerate(settings)]


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


def merits(run: Run, scenario: Scenario) -> Merits:
    """What the first seed of a team's ``run`` of ``scenario`` came to."""
    from robotics.figures.avoidance import clearances, robot_gaps

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
