"""Stress tests: thousands of random scenarios in one pass, and what went wrong in which of them.

A run goes on after a contact, as if robots could overlap: collisions and deadlocks are counted apart, and a run may
have both. A deadlock is a run that started and in which not all have arrived after 4 times the nominal duration.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from robotics import plant as p
from robotics.controller import Controller
from robotics.ensemble import Ensemble
from robotics.environment.collision import footprints, robot_contacts
from robotics.radio import FAULT_STREAM, Fault, Faults, Radio
from robotics.simulation import drive
from robotics.stress.crossings import crossing_ensemble

ARRIVED = 0.005  # of the path's length from its end, as in robotics.team; but
NEAREST = 0.03  # m at least
LIMIT = 4.0  # nominal durations after which a robot that has not arrived never will; as long as a plan may take, and
HELD = 2.0  # times as long as one robot is held up
TOGETHER = 1.0  # s: a spread of arrivals that counts as together
_SHOWN = 50  # seeds of failures that are named


@dataclass(frozen=True, eq=False)
class Outcome:
    """What became of every run; arrays are (runs,) unless they say otherwise."""

    seeds: tuple[int, ...]
    nominal: np.ndarray  # s
    arrivals: np.ndarray  # (runs, robots) s; infinite: never
    collided: np.ndarray  # bool: two robots touched
    refused: np.ndarray  # bool: the law said before the start that there is no safe plan
    min_distance: np.ndarray  # m between the centers of two robots

    @property
    def arrived(self) -> np.ndarray:
        """Did all robots arrive?"""
        return np.asarray(np.isfinite(self.arrivals).all(axis=1))

    @property
    def deadlocked(self) -> np.ndarray:
        """Started, and yet not all arrived: somebody waits for ever, or is stopped by a collision."""
        return np.asarray(~self.arrived & ~self.refused)

    @property
    def spread(self) -> np.ndarray:
        """Between the first and the last arrival [s]; infinite if not all arrive."""
        return np.asarray(
            np.where(
                self.arrived,
                self.arrivals.max(axis=1) - np.where(self.arrived[:, None], self.arrivals, 0).min(axis=1),
                np.inf,
            )
        )

    def summary(self) -> dict[str, Any]:
        """The figures that ``robotics stress --json`` prints."""
        good = self.arrived & ~self.collided
        together = good & (self.spread <= TOGETHER)
        ratio = self.arrivals.max(axis=1)[good] / self.nominal[good]
        moving = ~self.refused

        def named(which: np.ndarray) -> list[int]:
            return [self.seeds[k] for k in np.flatnonzero(which)[:_SHOWN]]

        return {
            "runs": len(self.seeds),
            "collisions": int(self.collided.sum()),
            "deadlocks": int(self.deadlocked.sum()),
            "refused": int(self.refused.sum()),
            "arrived": int(good.sum()),
            "arrived_together": int(together.sum()),
            "arrival_spread_p95_s": float(np.quantile(self.spread[good], 0.95)) if good.any() else None,
            "time_ratio_median": float(np.median(ratio)) if good.any() else None,
            "time_ratio_p95": float(np.quantile(ratio, 0.95)) if good.any() else None,
            "min_distance_m": float(self.min_distance[moving].min()) if moving.any() else None,
            "contacts": int(self.collided.sum()),
            "failed_seeds": {
                "collision": named(self.collided),
                "deadlock": named(self.deadlocked),
                "refused": named(self.refused),
                "apart": named(good & ~together),
            },
        }


def joined(outcomes: Sequence[Outcome]) -> Outcome:
    """The outcomes of all runs, in their order, as one."""
    arrays = [name for name in Outcome.__dataclass_fields__ if name != "seeds"]
    return Outcome(
        tuple(seed for part in outcomes for seed in part.seeds),
        *(np.concatenate([getattr(part, name) for part in outcomes]) for name in arrays),
    )


@dataclass(frozen=True, kw_only=True)
class Disturbance:
    """What is wrong in every run."""

    loss: float = 0.0  # share of messages
    latency: float = 0.0  # s, of messages
    freeze: float = 0.0  # s for which one robot, drawn at random, is held up at a random moment


def stress_crossing(
    controller: Controller,
    robots: int,
    seeds: Sequence[int],
    kind: Any = "A",
    disturbance: Disturbance = Disturbance(),
    begin: Callable[[str, int], Callable[[], None]] | None = None,
) -> Outcome:
    """``controller`` on a random crossing for every seed; ``begin`` starts the bars of a progress display."""
    start = begin or (lambda text, total: lambda: None)
    ensemble, faults = disturbed_crossing(robots, seeds, kind, disturbance, start("drawing crossings", len(seeds)))
    return run_ensemble(
        ensemble, controller, seeds, faults, start("simulating", ensemble.ticks + 1), HELD * disturbance.freeze
    )


def disturbed_crossing(
    robots: int,
    seeds: Sequence[int],
    kind: Any,
    disturbance: Disturbance,
    advance: Callable[[], None] | None = None,
) -> tuple[Ensemble, Faults | None]:
    """The crossing of every seed, long enough to judge it, and what goes wrong in it."""
    radio = Radio(loss=disturbance.loss, latency=disturbance.latency)
    held = HELD * disturbance.freeze
    ensemble = crossing_ensemble(robots, seeds, kind, radio=radio, factor=LIMIT, extra=held, advance=advance)
    return ensemble, _freeze(ensemble, seeds, disturbance.freeze) if disturbance.freeze > 0 else None


def _freeze(ensemble: Ensemble, seeds: Sequence[int], duration: float) -> Faults:
    """One robot of each run is held up once, from a moment in the first 80 % of the nominal time."""
    robots = len(ensemble.robots)
    faults = tuple(Fault(robot=i + 1, kind="stall", duration=duration) for i in range(robots))
    starts = np.full((len(seeds), robots), np.inf)
    for k, seed in enumerate(seeds):
        rng = np.random.default_rng([seed, FAULT_STREAM])
        starts[k, rng.integers(robots)] = rng.uniform(0.0, 0.8) * ensemble.trajectory.durations[k]
    return Faults(faults, robots, starts, starts + duration)


def run_ensemble(
    ensemble: Ensemble,
    controller: Controller,
    seeds: Sequence[int],
    faults: Faults | None = None,
    advance: Callable[[], None] | None = None,
    extra: float = 0.0,
) -> Outcome:
    """Drive until all have arrived in every run, or the time is up: 4 nominal durations and ``extra`` [s].

    After that nothing of a run counts, so that it does not matter which runs are beside it.
    """
    runs, robots = len(seeds), len(ensemble.robots)
    paths = ensemble.trajectory.joined
    ends = paths.at(paths.lengths)
    sizes = footprints([member.robot for member in ensemble.robots])
    arrivals = np.full((runs, robots), np.inf)
    collided = np.zeros(runs, dtype=bool)
    nearest = np.full(runs, np.inf)
    refused = np.zeros(runs, dtype=bool)
    pairs = np.triu_indices(robots, 1)
    limit = LIMIT * ensemble.trajectory.durations + extra
    goes_on = np.ones(runs, dtype=bool)
    for period in drive(ensemble, controller, seeds, faults):
        if period.k == 0 and period.command.refused is not None:
            refused = period.command.refused
        x, y, heading = period.state[[p.X, p.Y, p.HEADING]]
        gaps = np.hypot(x[:, pairs[0]] - x[:, pairs[1]], y[:, pairs[0]] - y[:, pairs[1]]).min(axis=1)
        nearest = np.where(goes_on, np.minimum(nearest, gaps), nearest)
        if (gaps < 2 * sizes[2].max()).any():
            collided |= goes_on & (robot_contacts(x, y, heading, sizes) >= 0).any(axis=1)
        there = np.hypot(x - ends.x, y - ends.y) < np.maximum(ARRIVED * paths.lengths, NEAREST)
        arrivals = np.where(there & np.isinf(arrivals) & goes_on[:, None], period.time, arrivals)
        goes_on = ~(np.isfinite(arrivals).all(axis=1) | refused) & (period.time < limit)
        if advance is not None:
            advance()
        if not goes_on.any():
            break
    return Outcome(tuple(seeds), ensemble.trajectory.durations, arrivals, collided, refused, nearest)
