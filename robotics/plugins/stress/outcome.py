"""The outcome of a stress test: what went wrong in which of thousands of random scenarios.

A run goes on after a contact, as if robots could overlap: collisions and deadlocks are counted apart, and a run may
have both. A deadlock is a run that started and in which not all robots have arrived after 4 nominal durations.
"""

from collections.abc import Sequence
from dataclasses import dataclass, fields, replace
from typing import Any, ClassVar, TypeVar

import numpy as np

from robotics.laws.setting import Setting
from robotics.measures.arrival import spread, together

_SHOWN = 50  # seeds of failures that are named, at most
Outcome = TypeVar("Outcome", bound="StressOutcome")


@dataclass(frozen=True, eq=False)
class StressOutcome:
    """The outcome of every run; arrays are (runs,) unless they say otherwise."""

    # Nominal durations: a robot that has not arrived by then never will; a plan may take as long
    limit: ClassVar[float] = 4.0

    seeds: tuple[int, ...]
    nominal: np.ndarray  # s
    arrivals: np.ndarray  # (runs, robots) s; infinite: never
    collided: np.ndarray  # bool: two robots touched
    refused: np.ndarray  # bool: the law said before the start that there is no safe plan
    min_distance: np.ndarray  # m between the centers of two robots
    clearance: np.ndarray  # m: the least signed clearance of a robot to anything; < 0: how deep they overlapped
    caused: np.ndarray  # (runs, robots) bool: the robot drove into something; else what it touched drove into it
    driven: np.ndarray  # s: of all robots together, each until it arrived or the run was over
    overridden: np.ndarray | None  # s of those in which the emergency rule acted; None: the law has no such rule

    @classmethod
    def longest(cls, ensemble: Setting, extra: float = 0.0) -> np.ndarray:
        """The longest that each run of ``ensemble`` may take (runs,) [s], ``extra`` [s] of it beside its limit."""
        return cls.limit * ensemble.references.ends[:, 0] + extra

    @property
    def arrived(self) -> np.ndarray:
        """Whether all robots arrived."""
        return np.asarray(np.isfinite(self.arrivals).all(axis=1))

    @property
    def deadlocked(self) -> np.ndarray:
        """Whether the run started, and yet not all robots arrived: of a deadlock, or stopped by a collision."""
        return np.asarray(~self.arrived & ~self.refused)

    @property
    def spread(self) -> np.ndarray:
        """The time [s] between the first and the last arrival; infinite if not all arrive."""
        return spread(self.arrivals)

    @property
    def guarded(self) -> np.ndarray | None:
        """The share of the robots' time, until they arrived, in which the emergency rule acted (runs,).

        Not-a-number for a run that never began; None where the law has no such rule.
        """
        if self.overridden is None:
            return None
        with np.errstate(invalid="ignore"):
            return np.asarray(self.overridden / self.driven)

    @property
    def emergency_share(self) -> float | None:
        """The same share over the time of the robots of all runs; None too where no run began."""
        if self.overridden is None or not self.driven.any():
            return None
        return float(self.overridden.sum() / self.driven.sum())

    def summary(self) -> dict[str, Any]:
        """The numbers that ``robotics stress --json`` prints."""
        good = self.arrived & ~self.collided
        at_once = good & together(self.arrivals)
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
            "arrived_together": int(at_once.sum()),
            "arrival_spread_p95_s": float(np.quantile(self.spread[good], 0.95)) if good.any() else None,
            "time_ratio_median": float(np.median(ratio)) if good.any() else None,
            "time_ratio_p95": float(np.quantile(ratio, 0.95)) if good.any() else None,
            "min_distance_m": float(self.min_distance[moving].min()) if moving.any() else None,
            "min_clearance_m": float(self.clearance[moving].min()) if moving.any() else None,
            "contacts": int(self.collided.sum()),
            "contacts_caused": int(self.caused.any(axis=1).sum()),
            "emergency_share": self.emergency_share,
            "failed_seeds": {
                "collision": named(self.collided),
                "deadlock": named(self.deadlocked),
                "refused": named(self.refused),
                "apart": named(good & ~at_once),
            },
        }


def joined(outcomes: Sequence[Outcome]) -> Outcome:
    """The outcomes of several parts of the runs as one, in their order; all of one class and one law."""
    first = outcomes[0]
    arrays = {f.name: [getattr(part, f.name) for part in outcomes] for f in fields(first) if f.name != "seeds"}
    whole: dict[str, Any] = {
        name: None if parts[0] is None else np.concatenate(parts) for name, parts in arrays.items()
    }
    return replace(first, seeds=tuple(seed for part in outcomes for seed in part.seeds), **whole)
