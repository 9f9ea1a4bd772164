"""Ensembles: scenarios that differ in paths, starts and durations only, in one array pass, a run each."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from robotics.environment.world import Obstacles
from robotics.path import CURVATURE, HEADING, Quintic, U, X, Y
from robotics.paths import Paths
from robotics.scenario import Scenario
from robotics.trajectory import Reference


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


def quintic_table(shape: Quintic, spacing: float = 0.02) -> np.ndarray:
    """The table of :class:`robotics.path.Path` for a quintic, nodes at most ``spacing`` [m] apart, to about 1e-6 m.

    A thousand times are enough for its length: what :func:`robotics.path.compile_path` does more exactly.
    """
    u = np.linspace(0.0, 1.0, 801)
    _, slope, _ = shape.curve(u)
    speed = np.hypot(slope[0], slope[1])
    # Simpson's rule over pairs of steps, and its half-step form between
    h = u[1]
    pieces = np.empty(800)
    pieces[0::2] = h / 12 * (5 * speed[:-2:2] + 8 * speed[1::2] - speed[2::2])
    pieces[1::2] = h / 12 * (-speed[:-2:2] + 8 * speed[1::2] + 5 * speed[2::2])
    measured = np.concatenate([[0.0], np.cumsum(pieces)])
    s = np.linspace(0.0, measured[-1], max(33, int(np.ceil(measured[-1] / spacing)) + 1))
    parameter = np.interp(s, measured, u)
    for _ in range(2):  # Newton, the speed taken linearly between the samples
        k = np.clip((parameter / h).astype(int), 0, 799)
        t = parameter - u[k]
        here = measured[k] + t * (speed[k] + (speed[k + 1] - speed[k]) * t / (2 * h))
        parameter = np.clip(parameter + (s - here) / np.interp(parameter, u, speed), 0.0, 1.0)
    position, slope, bend = shape.curve(parameter)
    speed = np.hypot(slope[0], slope[1])
    table = np.empty((5, len(s)))
    table[X], table[Y] = position
    table[HEADING] = np.unwrap(np.arctan2(slope[1], slope[0]))
    table[CURVATURE] = (slope[0] * bend[1] - slope[1] * bend[0]) / speed**3
    table[U] = parameter
    return table


def table_length(table: np.ndarray) -> float:
    """The length [m] of the path with that table, whose nodes are equally spaced."""
    chord = np.hypot(np.diff(table[X]), np.diff(table[Y]))
    turn = np.abs(np.diff(table[HEADING]))
    return float((chord * (1 + turn**2 / 24)).sum())  # arc over chord, to the second order


def join_tables(tables: Sequence[Sequence[np.ndarray]]) -> Paths:
    """The paths of ``tables`` [run][robot] as one table."""
    flat = [table for row in tables for table in row]
    nodes = np.array([table.shape[1] for table in flat])
    lengths = np.array([table_length(table) for table in flat]).reshape(len(tables), len(tables[0]))
    return Paths(
        lengths,
        np.ascontiguousarray(np.concatenate(flat, axis=1)),
        np.concatenate([[0], np.cumsum(nodes)[:-1]]),
        nodes - 1,
    )
