"""The judgement of many runs as they go on: arrivals, distances, contacts and whose fault they are.

A run goes on after a contact, as if robots could overlap, until all its robots have arrived, its law has refused, or
its time is up. After that nothing of it counts, so that it does not matter which runs are beside it.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any, Self

import numpy as np

from robotics.environment.swept import TO_OBSTACLE, TO_ROBOT, Watch
from robotics.laws.law import Law
from robotics.laws.modes import FOLLOW
from robotics.laws.setting import Setting
from robotics.measures.arrival import at_goal
from robotics.measures.blame import at_fault
from robotics.radio.faults import Faults
from robotics.simulation.loop import drive
from robotics.simulation.state import State
from robotics.vehicle import plant as p


@dataclass(frozen=True, eq=False)
class Tally:
    """What is known of all runs up to a time; :meth:`to` carries it on from period to period."""

    ensemble: Setting
    limits: np.ndarray  # (runs,) s: the longest that each run takes
    watch: Watch
    goes_on: np.ndarray  # (runs,) bool
    arrivals: np.ndarray  # (runs, robots) s; infinite: not yet
    refused: np.ndarray  # (runs,) bool: the law said before the start that there is no safe plan
    nearest: np.ndarray  # (runs,) m: the least distance between the centers of two robots
    caused: np.ndarray  # (runs, robots) bool: the robot drove into something
    followed: np.ndarray  # (runs,) bool: a robot followed a wall
    driven: np.ndarray  # (runs,) int: periods of robots that had not yet arrived, while their run went on
    guarded: np.ndarray | None  # (runs,) int: those of them in which the emergency rule acted; None: there is none

    @classmethod
    def opened(cls, ensemble: Setting, limits: np.ndarray, state: State) -> Self:
        """Begin with the state before the first period.

        Args:
            ensemble: What is driven, one run for each of ``limits``.
            limits: The longest that each run takes (runs,) [s].
            state: The state.
        """
        runs, robots = len(limits), len(ensemble.robots)
        world = None if ensemble.world is None else ensemble.world.at(state.time)
        tally = cls(
            ensemble,
            limits,
            Watch.opened(ensemble.robots, state.time, state.truth[: p.W + 1], world),
            np.ones(runs, dtype=bool),
            np.full((runs, robots), np.inf),
            np.zeros(runs, dtype=bool) if state.command.refused is None else state.command.refused,
            np.full(runs, np.inf),
            np.zeros((runs, robots), dtype=bool),
            np.zeros(runs, dtype=bool),
            np.zeros(runs, dtype=int),
            None,
        )
        return tally._with(state)

    def to(self, state: State) -> Self:
        """Carry the tally on to the state of the next period."""
        world = None if self.ensemble.world is None else self.ensemble.world.at(state.time)
        watch, ended = self.watch.to(state.time, state.truth[: p.W + 1], world, going=self.goes_on)
        caused = self.caused | at_fault(self.watch, watch, ended)
        return replace(self, watch=watch, caused=caused)._with(state)

    def _with(self, state: State) -> Self:
        """The tally with what ``state`` says beside contacts."""
        going, (x, y) = self.goes_on, state.truth[: p.Y + 1]
        nearest, followed = self.nearest, self.followed
        if x.shape[1] > 1:
            a, b = np.triu_indices(x.shape[1], 1)
            gaps = np.hypot(x[:, a] - x[:, b], y[:, a] - y[:, b]).min(axis=1)
            nearest = np.where(going, np.minimum(nearest, gaps), nearest)
        if state.command.mode is not None:
            followed = followed | (going & (state.command.mode & 3 == FOLLOW).any(axis=1))
        paths = self.ensemble.references.joined
        there = at_goal(x, y, paths.at(paths.lengths), paths.lengths)
        arrivals = np.where(there & np.isinf(self.arrivals) & going[:, None], state.time, self.arrivals)
        going = ~(np.isfinite(arrivals).all(axis=1) | self.refused) & (state.time < self.limits)
        on_way, acted, guarded = going[:, None] & np.isinf(arrivals), state.command.guarded, self.guarded
        if acted is not None:
            guarded = (0 if guarded is None else guarded) + (acted & on_way).sum(axis=1)
        return replace(
            self,
            goes_on=going,
            arrivals=arrivals,
            nearest=nearest,
            followed=followed,
            driven=self.driven + on_way.sum(axis=1),
            guarded=guarded,
        )

    @property
    def collided(self) -> np.ndarray:
        """Whether two robots touched (runs,) bool."""
        return np.asarray(np.isfinite(self.watch.first[TO_ROBOT]).any(axis=1))

    @property
    def hit(self) -> np.ndarray:
        """Whether a robot touched an obstacle (runs,) bool."""
        return np.asarray(np.isfinite(self.watch.first[TO_OBSTACLE]).any(axis=1))

    def judged(self, seeds: Sequence[int]) -> dict[str, Any]:
        """The fields of :class:`robotics.experiments.stress.outcome.StressOutcome` of the runs of ``seeds``."""
        period = self.ensemble.period
        return {
            "seeds": tuple(seeds),
            "nominal": self.ensemble.references.ends[:, 0],
            "arrivals": self.arrivals,
            "collided": self.collided,
            "refused": self.refused,
            "min_distance": self.nearest,
            "clearance": self.watch.least.min(axis=(0, 2)),
            "caused": self.caused,
            "driven": self.driven * period,
            "overridden": None if self.guarded is None else self.guarded * period,
        }


def tallied(
    ensemble: Setting,
    controller: Law[Any],
    seeds: Sequence[int],
    limits: np.ndarray,
    faults: Faults | None = None,
    advance: Callable[[], None] | None = None,
) -> Tally:
    """Drive until no run goes on any more.

    Args:
        ensemble: What is driven, one run for each seed.
        controller: The law that drives the robots.
        seeds: The seed of each run.
        limits: The longest that each run takes (runs,) [s].
        faults: The faults of the runs.
        advance: Called after every period.
    """
    tally: Tally | None = None
    for state in drive(ensemble, controller, seeds, faults):
        tally = Tally.opened(ensemble, limits, state) if tally is None else tally.to(state)
        if advance is not None:
            advance()
        if not tally.goes_on.any():
            break
    assert tally is not None  # there is a first state
    return tally
