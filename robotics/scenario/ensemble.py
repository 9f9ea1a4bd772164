"""Ensembles: scenarios that differ in paths, starts and durations only, in one array pass, a run each."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from robotics.environment.world import Obstacles
from robotics.paths.joined import Paths
from robotics.paths.trajectory import Reference
from robotics.scenario.description import Scenario


@dataclass(frozen=True, eq=False)
class EvenTiming:
    """Paths driven at constant speed, each run's in its own time."""

    joined: Paths  # lengths (runs, robots)
    durations: np.ndarray  # (runs,) s

    @property
    def ends(self) -> np.ndarray:
        """(runs, robots) s: when each reference reaches the end of its path."""
        return np.broadcast_to(self.durations[:, None], self.joined.lengths.shape)

    def at(self, time: float) -> Reference:
        """Every robot's reference at ``time`` [s]; each field is (runs, robots)."""
        return self.each_at(np.full(self.joined.lengths.shape, float(time)))

    def each_at(self, times: np.ndarray) -> Reference:
        """Each robot's reference at a time of its own, ``times`` (runs, robots) [s]."""
        share = np.clip(times / self.durations[:, None], 0.0, 1.0)
        s = share * self.joined.lengths
        point = self.joined.at(s)
        v = np.where(share < 1, self.joined.lengths / self.durations[:, None], 0.0)
        return Reference(point.x, point.y, point.heading, v, v * point.curvature, s)


@dataclass(frozen=True, eq=False)
class Ensemble:
    """What its runs share is that of ``scenario``, whose own paths, starts and timing are not used."""

    scenario: Scenario
    starts: np.ndarray  # (runs, robots, 3): x [m], y [m], heading [rad]
    trajectory: EvenTiming
    world: Obstacles | None = None  # of every run, or one for all

    def __getattr__(self, name: str) -> Any:
        return getattr(self.scenario, name)
