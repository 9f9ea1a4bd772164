"""What is kept of a simulation as it goes on: samples, and the runs made of them."""

from collections.abc import Sequence
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from robotics.environment.world import Geometry
from robotics.laws.law import Command
from robotics.laws.modes import STOPPED
from robotics.paths.trajectory import Reference
from robotics.radio.channel import Heard
from robotics.radio.faults import Condition
from robotics.scenario.description import Scenario
from robotics.simulation.run import CHANNELS, TEAM_CHANNELS, Run
from robotics.vehicle import plant as p
from robotics.vehicle.robot import Robot

if TYPE_CHECKING:
    pass


class Period(NamedTuple):
    """One period of all runs, at its end; arrays are (runs, robots) unless they say otherwise."""

    k: int
    time: float  # s
    state: np.ndarray  # (plant channels, runs, robots): the truth
    posture: np.ndarray  # (3, runs, robots): x [m], y [m], heading [rad] as measured
    target: Reference  # where the law wants the robots to be
    command: Command
    order: np.ndarray  # (2, runs, robots): the command after faults and stops
    condition: Condition | None  # who is at fault
    heard: Heard | None
    stopped: np.ndarray  # int: the period before in which the robot was stopped, or -1
    lost: np.ndarray  # bool: it is stopped in this one
    ranges: np.ndarray | None = None  # (runs, robots, sensors) m: what their sensors read


class Recorder:
    """The samples of a simulation as it goes on, and the runs made of them."""

    def __init__(self, samples: int, runs: int, robots: Sequence[Robot], *, team: bool, links: bool = False) -> None:
        """Room for so many ``samples`` of all ``runs``."""
        shape = (runs, len(robots))
        self.limits = p.velocity_limits(robots)
        self.kept = self.limited = 0  # samples; those whose command has been brought within the plant's limits
        self.samples = np.empty((samples, len(CHANNELS), *shape))
        self.team = np.empty((samples, len(TEAM_CHANNELS), *shape)) if team else None
        self.links = np.full((samples, *shape, len(robots)), np.inf, dtype=np.float32) if links else None
        self.modes: np.ndarray | None = None
        self.ranges: np.ndarray | None = None
        self.stopped = np.full(shape, -1)

    def keep(self, period: Period) -> None:
        """Keep one period; they come in their order."""
        k, now, command, target = period.k, period.state, period.command, period.target
        gone = self.stopped >= 0
        stops = bool(gone.any())
        if command.mode is not None:
            if self.modes is None:
                self.modes = np.zeros((len(self.samples), *gone.shape), dtype=np.int8)
            self.modes[k] = np.where(gone, STOPPED, command.mode)
        if period.ranges is not None:
            if self.ranges is None:
                self.ranges = np.empty((len(self.samples), *period.ranges.shape), dtype=np.float32)
            self.ranges[k] = period.ranges
        row = self.samples[k]
        row[:5], row[5:8], row[8:10] = now[: p.W + 1], period.posture, period.order
        row[10], row[11] = command.v, command.w  # without the plant's limits until all is kept
        row[12], row[13] = now[p.EFFORT], now[p.VARIATION]
        if stops:
            row[:, gone] = np.nan
        if self.team is not None:
            row = self.team[k]
            row[0] = np.nan if command.progress is None else command.progress
            row[1], row[2], row[3] = target.x, target.y, target.heading
            row[4] = 0 if period.condition is None else period.condition.code
            if stops:
                row[:, gone] = np.nan
        if self.links is not None and period.heard is not None:
            self.links[k] = np.where(period.heard.hears, period.heard.age, np.inf)
        self.stopped = np.where(period.lost, k, period.stopped)
        self.kept = k + 1

    def run(self, scenario: Scenario, level: str, seeds: tuple[int, ...], name: str, which: slice = slice(None)) -> Run:
        """The run of ``scenario`` with the law called ``name``; ``which`` of the runs of the pass are its seeds.

        It ends with the scenario, or before, if no more was kept.
        """
        end = min(scenario.ticks + 1, self.kept)
        times = scenario.times[:end]
        new = self.samples[self.limited : self.kept]
        new[:, 10], new[:, 11] = p.saturate(self.limits, new[:, 10], new[:, 11])
        self.limited = self.kept

        def mine(kept: np.ndarray | None, axis: int = 1) -> np.ndarray | None:
            return None if kept is None else kept[:end, :, which] if axis == 2 else kept[:end, which]

        return Run(
            scenario.name,
            name,
            level,
            seeds,
            times,
            self.samples[:end, :, which],
            np.stack(scenario.trajectory.sampled(times)),
            tuple(path.table[:2] for path in scenario.trajectory.paths),
            np.where(self.stopped[which] < end, self.stopped[which], -1),
            mine(self.team, axis=2),
            mine(self.links),
            mine(self.modes),
            None if scenario.world is None else mine(self.ranges),
            _obstacles(scenario, times),
        )


def _obstacles(scenario: Scenario, times: np.ndarray) -> Geometry | None:
    """Where the obstacles are at ``times`` [s]; once, if none moves."""
    world = scenario.world
    if world is None or world.motion is None:
        return None if world is None else world.rest
    seen = [world.at(time) for time in times]
    circles, segments = (np.concatenate([getattr(g, name) for g in seen]) for name in ("circles", "segments"))
    bodies, counts = (np.repeat(getattr(world.rest, name), len(seen), axis=0) for name in ("bodies", "counts"))
    return Geometry(circles, bodies, segments, counts)
