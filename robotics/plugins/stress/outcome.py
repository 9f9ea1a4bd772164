"""The outcome of a stress test: what went wrong in which of thousands of random scenarios.

A run goes on after a contact, as if robots could overlap: collisions and deadlocks are counted apart, and a run may
have both. A deadlock is a run that started and in which not all robots have arrived after 4 nominal durations.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, ClassVar, TypeVar

import numpy as np
import pandas as pd

from robotics.laws.setting import Setting
from robotics.measures.arrival import spread, together

_SHOWN = 50  # seeds of failures that are named, at most
Outcome = TypeVar("Outcome", bound="StressOutcome")


def table_of(columns: Mapping[str, np.ndarray]) -> pd.DataFrame:
    """The table of an outcome from arrays (runs,), each for all robots of a run, and (runs, robots), but the robots."""
    runs, robots = next(values.shape for values in columns.values() if values.ndim > 1)
    table = pd.DataFrame({name: np.repeat(v, robots) if v.ndim == 1 else v.ravel() for name, v in columns.items()})
    table.insert(1, "robot", np.tile(np.arange(1, robots + 1), runs))
    return table


def of_runs(column: str) -> Any:
    """A column that says the same in all rows of a run: an array (runs,)."""
    return property(lambda outcome: outcome.column(column)[:, 0].copy())


def of_robots(column: str) -> Any:
    """A column of robots: an array (runs, robots)."""
    return property(lambda outcome: outcome.column(column))


@dataclass(frozen=True, eq=False)
class StressOutcome:
    """The outcome of every run.

    Attributes:
        table: A row a run and robot, the robots of a run one after the other: seed, robot, nominal_s, arrival_s,
            collided, refused, min_distance_m, clearance_m, caused, driven_s, overridden_s, hit, trapped.
    """

    # Nominal durations: a robot that has not arrived by then never will; a plan may take as long
    limit: ClassVar[float] = 4.0

    table: pd.DataFrame = field(repr=False)

    seeds = property(lambda outcome: tuple(outcome.column("seed")[:, 0].tolist()))
    nominal = of_runs("nominal_s")
    arrivals = of_robots("arrival_s")  # infinite: never
    collided = of_runs("collided")  # two robots touched
    refused = of_runs("refused")  # the law said before the start that there is no safe plan
    min_distance = of_runs("min_distance_m")  # between the centers of two robots
    clearance = of_runs("clearance_m")  # the least signed one of a robot to anything; < 0: how deep they overlapped
    caused = of_robots("caused")  # the robot drove into something; else what it touched drove into it
    driven = of_runs("driven_s")  # of all robots together, each until it arrived or the run was over
    overridden = of_runs("overridden_s")  # of those in which the emergency rule acted; NaN: the law has no such rule

    def column(self, name: str) -> np.ndarray:
        """A column of the table (runs, robots)."""
        return self.table[name].to_numpy().reshape(-1, int(self.table["robot"].max()))

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
        if np.isnan(self.overridden).all():
            return None
        with np.errstate(invalid="ignore"):
            return np.asarray(self.overridden / self.driven)

    @property
    def emergency_share(self) -> float | None:
        """The same share over the time of the robots of all runs; None too where no run began."""
        share = float(self.overridden.sum() / self.driven.sum()) if self.driven.any() else np.nan
        return None if np.isnan(share) else share

    def summary(self) -> dict[str, Any]:
        """The numbers that ``robotics stress --json`` prints."""
        good = self.arrived & ~self.collided
        at_once = good & together(self.arrivals)
        ratio = self.arrivals.max(axis=1)[good] / self.nominal[good]
        moving, seeds = ~self.refused, self.seeds

        def named(which: np.ndarray) -> list[int]:
            return [seeds[k] for k in np.flatnonzero(which)[:_SHOWN]]

        return {
            "runs": len(seeds),
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
