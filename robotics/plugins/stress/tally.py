"""The judgement of many runs as they go on: arrivals, distances, contacts and whose fault they are.

A run goes on after a contact, as if robots could overlap, until all its robots have arrived, its law has refused, or
its time is up. After that nothing of it counts, so that it does not matter which runs are beside it. Runs of a law with
an equation are driven a few at a time, by compiled code, until all of these are over.

A robot is to blame for its contact with an obstacle or with another robot if its motion alone leads to it, the other
held where it was, or brings it nearer by more than APPROACH. The first touch of a pair decides: until they have been
apart at a sample, nothing of that pair is judged anew. One that stands, as it was told to or because it is held
up, is not to blame; neither is one that another drives into from behind. Where neither of two robots alone can be
blamed, both are.
"""

import math
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from fuzzy.compiled.threads import share_out
from robotics.laws.equation import EquationLaw
from robotics.laws.law import Law
from robotics.laws.setting import Setting
from robotics.plugins.stress.judge import JudgeNotes, judge
from robotics.plugins.stress.outcome import Outcome, table_of
from robotics.simulation.loop import CHUNK, Periods, Simulation, checked_seeds, drive_chunk, threads_for
from robotics.simulation.observer import Observer
from robotics.simulation.opening import Driver, PreparedRuns, has_equation
from robotics.world.environment.collision import footprints, obstacle_clearance, robot_clearance
from robotics.world.environment.swept import GRID, TO, ContactColumns, ContactWatch, Watch
from robotics.world.environment.world import Geometry, Moving
from robotics.world.radio.faults import Faults

APPROACH = 0.02  # m/s: a robot that came no faster towards another, or an obstacle, did not drive into it
_V = 3  # of a pose (5,): the speeds begin here


class Tally:
    """What is known of some runs, and the observer that carries it on from period to period, in place."""

    def __init__(
        self, ensemble: Setting, limits: np.ndarray, first: int, last: int, after: float | None = None
    ) -> None:
        """Begin with the runs from ``first`` to before ``last`` of ``ensemble``; ``limits`` (runs,) [s] is of all.

        Once none of them goes on the simulation ends. With ``after`` it ends so many seconds [s] after the last
        arrival, or with its setting, and until then the law of a run that is over drives on.
        """
        self.ensemble, self.robots, self.after = ensemble, ensemble.robots, after
        here, shape = slice(first, last), (last - first, len(ensemble.robots))
        paths = ensemble.references.joined
        goals = paths.at(paths.lengths)
        placed, moving = Geometry.nothing(), Moving.nothing()
        if (obstacles := ensemble.world) is not None:
            worlds = np.zeros(1, dtype=np.int64) if obstacles.runs == 1 else np.arange(obstacles.runs)[here]
            placed, moving = obstacles.during(ensemble.times, worlds)
        watch = ContactWatch.opened(ensemble.robots, shape[0], placed, moving)
        contacts = watch.contacts
        # Contacts, and the gaps between two, are longer than GRID: of a pair no more than these end in a period
        most = contacts.since.size * (math.ceil(ensemble.period / (2 * GRID)) + 1)
        self.caused = np.zeros(shape, dtype=bool)  # the robot drove into something
        self.guards = False  # whether there is an emergency rule
        self.runs = here
        self.known = JudgeNotes(
            np.stack([goals.x[here], goals.y[here], goals.heading[here], paths.lengths[here]]),
            np.array(limits[here], dtype=float),
            np.full(shape, np.inf),
            np.zeros(shape[0], dtype=bool),
            np.full(shape[0], np.inf),
            np.zeros(shape[0], dtype=bool),
            np.zeros(shape[0], dtype=np.int64),
            np.zeros(shape[0], dtype=np.int64),
            np.zeros(shape, dtype=np.int64),
            np.full_like(contacts.since, np.nan),
            watch,
            np.empty((most, 7)),
            np.zeros(1, dtype=np.int64),
            int(after is None),
        )
        self.observer = Observer(judge, self.known, self.asked)

    def asked(self, k: int) -> int | None:
        """Find out whose fault the contacts are that began since the last period; end where no run goes on."""
        known, robots, period, watch = self.known, self.robots, self.ensemble.period, self.known.watch
        past = watch.contacts._replace(counts=known.counts_before, since=known.since_before)
        before = Watch(robots, max(k - 1, 0) * period, watch.poses[..., 0], watch.geometry(now=False), past)
        after = Watch(robots, k * period, watch.poses[..., 1], watch.geometry(now=True), watch.contacts)
        self.caused |= at_fault(before, after, known.ended[: known.many[0]])
        if watch.going.any():
            return None
        if self.after is None:
            return k
        last = float(known.arrivals.max())
        return round(np.ceil(last + self.after) / period) if np.isfinite(last) else None

    def columns(self, seeds: Sequence[int]) -> dict[str, np.ndarray]:
        """Those of :attr:`robotics.plugins.stress.outcome.StressOutcome.table` of its runs; ``seeds`` are of all runs.

        They are (runs,), or (runs, robots).
        """
        known, period = self.known, self.ensemble.period
        touched = np.isfinite(known.watch.contacts.first).any(axis=2)
        return {
            "seed": np.array(seeds[self.runs]),
            "nominal_s": self.ensemble.references.ends[self.runs, 0],
            "arrival_s": known.arrivals,
            "collided": touched[TO.robot],
            "refused": known.refused,
            "min_distance_m": known.nearest,
            "clearance_m": known.watch.contacts.least.min(axis=(0, 2)),
            "caused": self.caused,
            "driven_s": known.driven * period,
            "overridden_s": known.guarded * (period if self.guards else np.nan),
            "hit": touched[TO.obstacle],
            "trapped": known.followed,
        }


def judged(kind: type[Outcome], tallies: Sequence[Tally], seeds: Sequence[int]) -> Outcome:
    """The outcome of all runs, those of ``seeds``, as one of its ``kind``."""
    parts = [tally.columns(seeds) for tally in tallies]
    return kind(table_of({name: np.concatenate([part[name] for part in parts]) for name in parts[0]}))


def run_ensemble(
    kind: type[Outcome],
    ensemble: Setting,
    controller: Law[Any],
    seeds: Sequence[int],
    faults: Faults | None = None,
    advance: Callable[[], None] | None = None,
    extra: float = 0.0,
    beside: Callable[[int, int], Observer] | None = None,
) -> Outcome:
    """Drive until all robots of every run have arrived, or the time is up.

    Args:
        kind: Of the outcome.
        ensemble: What is driven, one run for each seed.
        controller: The law that drives the robots.
        seeds: The seed of each run.
        faults: The faults of the runs.
        advance: Called after every period.
        extra: The time [s] by which runs may take longer than the limit of their ``kind``.
        beside: Makes an observer that looks on, too, at the runs from one number to before another.
    """

    def watching(tally: Tally) -> Observer:
        return tally.observer if beside is None else tally.observer.beside(beside(tally.runs.start, tally.runs.stop))

    runs, checked, limits = len(seeds), checked_seeds(seeds), kind.longest(ensemble, extra)
    if has_equation(controller):
        opening = PreparedRuns.of([Driver(ensemble, controller)], checked, faults)
        size = max(1, CHUNK // len(ensemble.robots))
        told = Periods(ensemble.ticks + 1, runs, advance)
        tallies = [Tally(ensemble, limits, first, min(first + size, runs)) for first in range(0, runs, size)]
        guards = isinstance(controller, EquationLaw) and controller.guards

        def drive(tally: Tally) -> None:
            tally.guards = guards
            drive_chunk(opening, tally.runs.start, tally.runs.stop, watching(tally), ensemble.ticks, told)

        share_out(drive, tallies, threads_for(None))
        return judged(kind, tallies, seeds)
    tally = Tally(ensemble, limits, 0, runs)
    for _, command in Simulation(ensemble, controller, checked, faults, observers=[watching(tally)]).periods():
        tally.guards |= command.guarded is not None
        if advance is not None:
            advance()
    return judged(kind, [tally], seeds)


def at_fault(before: Watch, after: Watch, ended: np.ndarray) -> np.ndarray:
    """The robots that are to blame for a contact that began since ``before`` (runs, robots) bool.

    Args:
        before: What was known at a sample.
        after: What :meth:`robotics.world.environment.swept.Watch.to` made of it at the next one.
        ended: The contacts that ended meanwhile, likewise.
    """
    blamed = np.zeros(after.known.counts.shape, dtype=bool)
    if not (after.known.counts > before.known.counts).any():
        return blamed
    for run, i, j, obstacle in _begun(before, after, ended):
        if obstacle >= 0:
            blamed[run, i] |= _drove_at_obstacle(before, after, run, i, obstacle)
            continue
        first, second = _drove_at_robot(before, after, run, i, j), _drove_at_robot(before, after, run, j, i)
        blamed[run, i] |= first or not second
        blamed[run, j] |= second or not first
    return blamed


def _begun(before: Watch, after: Watch, ended: np.ndarray) -> list[tuple[int, int, int, int]]:
    """The contacts that began: run, robot, other robot or -1, obstacle or -1."""
    until = ContactColumns.start.row  # who comes free and touches again within a period was not apart at a sample
    known = {tuple(row) for row in before.open_contacts()[:, :until].tolist()}
    rows = np.concatenate([ended, after.open_contacts()])[:, :until].tolist()
    return [(int(row[0]), int(row[1]), int(row[2]), int(row[3])) for row in rows if tuple(row) not in known]


def _drove_at_robot(before: Watch, after: Watch, run: int, i: int, j: int) -> bool:
    """Whether robot ``i`` drove into robot ``j``, had that one stayed."""
    robots = before.robots[i], before.robots[j]
    first, last = before.poses[:, [run], [i, j]].copy(), after.poses[:, [run], [i, j]].copy()
    first[_V:, 1] = 0.0
    last[:, 1] = first[:, 1]
    poses = [pose[:, None] for pose in (first, last)]  # of one run
    alone, _ = Watch.opened(robots, before.time, poses[0]).to(after.time, poses[1])
    gaps = [robot_clearance(x, y, psi, footprints(robots))[0, 0] for x, y, psi, *_ in poses]
    return bool(np.isfinite(alone.known.first[0, 0, 0]) or gaps[0] - gaps[1] > APPROACH * (after.time - before.time))


def _drove_at_obstacle(before: Watch, after: Watch, run: int, i: int, obstacle: int) -> bool:
    """Whether robot ``i`` drove into an obstacle, had that one stayed."""
    assert before.geometry is not None
    robots, world = (before.robots[i],), _alone(before.geometry, before.known.spans, run, obstacle)
    poses = [watch.poses[:, run : run + 1, i : i + 1] for watch in (before, after)]
    alone, _ = Watch.opened(robots, before.time, poses[0], world).to(after.time, poses[1], world)
    sizes, period = footprints(robots), after.time - before.time
    gaps = [obstacle_clearance(x, y, psi, sizes, world)[0, 0] for x, y, psi, *_ in poses]
    if gaps[0] - gaps[1] > APPROACH * period:
        return True
    # Who is slower, to the last hair, did not drive into what came to it.
    assert after.geometry is not None
    moved, now = (poses[1] - poses[0])[:3, 0, 0], _alone(after.geometry, before.known.spans, run, obstacle)
    came = (now.circles != world.circles).any() or (now.bodies != world.bodies).any()
    stands = np.hypot(moved[0], moved[1]) + sizes[2, 0] * abs(moved[2]) <= APPROACH * period
    return bool(np.isfinite(alone.known.first[1, 0, 0]) and not (came and stands))


def _alone(geometry: Geometry, spans: np.ndarray, run: int, obstacle: int) -> Geometry:
    """A world with only one of the obstacles of a run."""
    g = run if len(geometry.counts) > 1 else 0
    first, last = spans[g, obstacle]
    circles, bodies = geometry.circles[g : g + 1, first:last], geometry.bodies[g : g + 1, first:last]
    return Geometry(circles, bodies, geometry.segments[g : g + 1], np.array([last - first]))
