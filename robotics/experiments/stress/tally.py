"""The judgement of many runs as they go on: arrivals, distances, contacts and whose fault they are.

A run goes on after a contact, as if robots could overlap, until all its robots have arrived, its law has refused, or
its time is up. After that nothing of it counts, so that it does not matter which runs are beside it. Runs of a law with
an equation are driven a few at a time, by compiled code, until all of these are over.
"""

from collections.abc import Callable, Sequence
from dataclasses import fields
from typing import Any

import numpy as np

from robotics.environment.collision import footprints
from robotics.environment.swept import TO_OBSTACLE, TO_ROBOT, Watch, body_spans, stacked
from robotics.environment.world import Geometry
from robotics.experiments.stress.judge import KNOWN_TYPE, WORLD_TYPE, Known, driving, judge
from robotics.experiments.stress.outcome import Outcome, joined
from robotics.laws.equation import compiled
from robotics.laws.law import Law
from robotics.laws.setting import Setting
from robotics.measures.arrival import reached_within
from robotics.measures.blame import at_fault
from robotics.radio.faults import Faults
from robotics.simulation.lanes import Lanes, check
from robotics.simulation.loop import BLOCK, CHUNK, Periods, Simulation, checked_seeds
from robotics.simulation.opening import Driver, Opening, has_equation
from robotics.simulation.recorder import Recorder


class Tally:
    """What is known of some runs; it is carried on from period to period, in place."""

    def __init__(self, ensemble: Setting, limits: np.ndarray, first: int, last: int) -> None:
        """Begin with the runs from ``first`` to before ``last`` of ``ensemble``; ``limits`` (runs,) [s] is of all."""
        self.ensemble, self.robots = ensemble, ensemble.robots
        here, shape = slice(first, last), (last - first, len(ensemble.robots))
        paths = ensemble.references.joined
        goals, near = paths.at(paths.lengths), reached_within(paths.lengths)
        self.geometry = self.geometry_before = self._world(0.0, here)
        spans = body_spans(self.geometry)
        pairs = shape[0], shape[1] * (shape[1] - 1) // 2 + shape[1] * spans.shape[1]
        self.caused = np.zeros(shape, dtype=bool)  # the robot drove into something
        self.guards = False  # whether there is an emergency rule
        self.runs = here
        self.known = Known(
            footprints(ensemble.robots),
            np.stack([goals.x[here], goals.y[here]]),
            np.ascontiguousarray(near[here]),
            np.array(limits[here], dtype=float),
            np.ones(shape[0], dtype=bool),
            np.full(shape, np.inf),
            np.zeros(shape[0], dtype=bool),
            np.full(shape[0], np.inf),
            np.zeros(shape[0], dtype=bool),
            np.zeros(shape[0], dtype=np.int64),
            np.zeros(shape[0], dtype=np.int64),
            np.full((5, *shape, 2), np.nan),
            np.zeros(shape, dtype=np.int64),
            np.full(pairs, np.nan),
            spans,
            np.full((2, *shape), np.inf),
            np.full((2, *shape), np.inf),
            np.zeros(shape, dtype=np.int64),
            np.full(pairs, np.nan),
            np.full(pairs, -np.inf),
            np.full(pairs, np.nan),
            np.zeros(pairs),
        )
        self.world = self._stacked()
        check(self.known, KNOWN_TYPE)

    def _world(self, time: float, runs: slice) -> Geometry | None:
        """The obstacles of ``runs`` at a time [s]."""
        if self.ensemble.world is None:
            return None
        here = self.ensemble.world.at(time)
        return here if len(here.counts) == 1 else Geometry(*(part[runs] for part in here))

    def _stacked(self) -> Geometry:
        """The obstacles one period ago and now, or once, if they rest."""
        moved = self.geometry is not self.geometry_before
        world = stacked([self.geometry_before, self.geometry] if moved else [self.geometry])
        world = Geometry(*(np.require(part, requirements=["C", "W"]) for part in world))
        check(world, WORLD_TYPE)
        return world

    def to(self, k: int, lanes: Lanes) -> bool:
        """Carry it on to period ``k``, in which the law has decided; return whether a run goes on."""
        world = self.ensemble.world
        if k > 0 and world is not None and world.motion is not None:
            self.geometry_before, self.geometry = self.geometry, self._world(k * lanes.period, self.runs)
            self.world = self._stacked()
        begun, goes_on, ended = judge(k, self.known, self.world, lanes.period, lanes.body.truth, lanes.command)
        if begun:
            self.blame(k, ended)
        return bool(goes_on)

    def drive(self, opening: Opening, ticks: int, advance: Callable[[int], None]) -> None:
        """Drive its runs until they are over, by compiled code; ``advance`` is told how many periods of how many."""
        runs, kept = self.runs, Recorder(self.ensemble, opening.drivers[0].law, opening.runs, nothing=True).kept
        lanes, supply = opening.lanes(runs.start, runs.stop, kept(runs.start, runs.stop))
        law: Any = opening.drivers[0].law
        one, loop, number = compiled(type(law).equation), driving(), runs.stop - runs.start
        block, k, halfway = max(16, BLOCK // len(lanes.lost)), 0, False
        while k <= ticks:
            lanes = lanes if halfway else supply.to(lanes, k)
            end = min(k + block, supply.lasts(lanes, k), ticks + 1)
            came, ended = loop(one, supply.look, supply.looks, k, end, halfway, self.known, self.world, lanes)
            advance((came - k) * number)
            k, halfway = came, came < end
            if halfway:
                self.blame(k, ended)
                if not self.known.goes_on.any():
                    break
        advance((ticks + 1 - k) * number)

    def blame(self, k: int, ended: np.ndarray) -> None:
        """Find out whose fault the contacts are that began since the last period; ``ended`` are those that ended."""
        known, robots, period = self.known, self.robots, self.ensemble.period
        rest = known.ends, known.floor
        before = Watch(
            robots, max(k - 1, 0) * period, known.poses[..., 0], self.geometry_before, known.spans, known.least,
            known.first, known.counts_before, *rest, known.since_before, known.depth,
        )  # fmt: skip
        after = Watch(
            robots, k * period, known.poses[..., 1], self.geometry, known.spans, known.least,
            known.first, known.counts, *rest, known.since, known.depth,
        )  # fmt: skip
        self.caused |= at_fault(before, after, ended)

    def judged(self, seeds: Sequence[int], wanted: Sequence[str]) -> dict[str, Any]:
        """The ``wanted`` fields of an outcome of its runs; ``seeds`` are those of all runs.

        They are those of :class:`robotics.experiments.stress.outcome.StressOutcome`, and of
        :class:`robotics.experiments.stress.obstaclecourse.ObstacleOutcome`.
        """
        known, period = self.known, self.ensemble.period
        touched = np.isfinite(known.first).any(axis=2)
        all_of_them = {
            "seeds": tuple(seeds[self.runs]),
            "nominal": self.ensemble.references.ends[self.runs, 0],
            "arrivals": known.arrivals,
            "collided": touched[TO_ROBOT],
            "refused": known.refused,
            "min_distance": known.nearest,
            "clearance": known.least.min(axis=(0, 2)),
            "caused": self.caused,
            "driven": known.driven * period,
            "overridden": known.guarded * period if self.guards else None,
            "hit": touched[TO_OBSTACLE],
            "trapped": known.followed,
        }
        return {name: all_of_them[name] for name in wanted}


def judged(kind: type[Outcome], tallies: Sequence[Tally], seeds: Sequence[int]) -> Outcome:
    """The outcome of all runs, those of ``seeds``, as one of its ``kind``."""
    return joined([kind(**tally.judged(seeds, [f.name for f in fields(kind)])) for tally in tallies])


def tallied(
    ensemble: Setting,
    controller: Law[Any],
    seeds: Sequence[int],
    limits: np.ndarray,
    faults: Faults | None = None,
    advance: Callable[[], None] | None = None,
) -> list[Tally]:
    """Drive until no run goes on any more; return the tallies of all runs, some runs in each.

    Args:
        ensemble: What is driven, one run for each seed.
        controller: The law that drives the robots.
        seeds: The seed of each run.
        limits: The longest that each run takes (runs,) [s].
        faults: The faults of the runs.
        advance: Called after every period.
    """
    runs, checked = len(seeds), checked_seeds(seeds)
    if drives_compiled(ensemble, controller):
        opening = Opening.of([Driver(ensemble, controller)], checked, faults)
        size = max(1, CHUNK // len(ensemble.robots))
        told = Periods(ensemble.ticks + 1, runs, advance)
        tallies = [Tally(ensemble, limits, first, min(first + size, runs)) for first in range(0, runs, size)]
        for tally in tallies:
            tally.drive(opening, ensemble.ticks, told)
        return tallies
    tally = Tally(ensemble, limits, 0, runs)
    simulation = Simulation(ensemble, controller, checked, faults)
    for k, command in simulation.periods():
        tally.guards |= command.guarded is not None
        goes_on = tally.to(k, simulation.lanes)
        if advance is not None:
            advance()
        if not goes_on:
            break
    return [tally]


def drives_compiled(ensemble: Setting, law: Law[Any]) -> bool:
    """Whether compiled code drives and judges many periods of ``ensemble`` at a time."""
    rests = ensemble.world is None or ensemble.world.motion is None
    return has_equation(law) and rests
