"""Trajectories: when the reference is where on its path.

A path says where, a :class:`Timing` says how fast; together they are the moving target that controllers track.
"""

from dataclasses import dataclass, field
from math import inf
from typing import NamedTuple

import numpy as np
from numba import njit

from robotics.path import Path, PathError, X, lookup
from robotics.quantity import check_quantities, quantity


@dataclass(frozen=True, kw_only=True)
class Timing:
    """How the reference moves along its path: exactly one of these.

    ``speed``: at constant speed. ``duration``: at the constant speed that takes this long.
    ``x_rate``: so that x grows evenly, dx/dt = x_rate (the thesis's "x = 0.3 t, y = sin x").
    """

    speed: float | None = quantity(None, "m/s", above=0.0)
    duration: float | None = quantity(None, "s", above=0.0)
    x_rate: float | None = quantity(None, "m/s", above=0.0)
    start: float = quantity(0.0, "m", least=0.0)  # the abscissa at time 0

    def __post_init__(self) -> None:
        check_quantities(self, PathError)
        given = {n: getattr(self, n) for n in ("speed", "duration", "x_rate") if getattr(self, n) is not None}
        if len(given) != 1:
            raise PathError(f"timing: give exactly one of speed, duration and x_rate, got {', '.join(given) or 'none'}")


class Reference(NamedTuple):
    """The moving target of every robot at one time; each field is (robots,)."""

    x: np.ndarray  # m
    y: np.ndarray  # m
    heading: np.ndarray  # rad, continuous
    v: np.ndarray  # m/s
    w: np.ndarray  # rad/s
    s: np.ndarray  # m, the abscissa on the robot's path


@dataclass(frozen=True)
class Trajectory:
    """Paths with their timing, for all robots of a scenario."""

    paths: tuple[Path, ...]
    tables: np.ndarray = field(repr=False)  # (robots, 2, nodes): abscissa [m] and its rate [m/s] at equal time steps
    ends: np.ndarray = field(repr=False)  # (robots,) s, when each reference reaches the end of its path

    def at(self, time: float) -> Reference:
        """Every robot's reference at ``time`` [s]; after its end a reference rests there."""
        rows = np.empty((6, len(self.paths)))
        for i, path in enumerate(self.paths):
            _refer(path.table, path.length, self.tables[i], self.ends[i], time, rows[:, i])
        return Reference(*rows)

    def sampled(self, times: np.ndarray) -> Reference:
        """The references at ``times`` (n,) [s]; each field is (n, robots)."""
        rows = np.empty((6, len(times), len(self.paths)))
        for i, path in enumerate(self.paths):
            _refer_each(path.table, path.length, self.tables[i], self.ends[i], times, rows[:, :, i])
        return Reference(*rows)


def compile_trajectory(paths: tuple[Path, ...], timings: tuple[Timing, ...]) -> Trajectory:
    """Tabulate when each robot's reference is where; times are those of the path's own length."""
    nodes = 4097
    tables, ends = np.empty((len(paths), 2, nodes)), np.empty(len(paths))
    for i, (path, timing) in enumerate(zip(paths, timings, strict=True)):
        if timing.start >= path.length:
            raise PathError(f"timing: start {timing.start:g} m lies at or beyond the path's end, {path.length:g} m")
        rest = path.length - timing.start
        if timing.x_rate is None:
            end = timing.duration if timing.duration is not None else rest / (timing.speed or inf)
            s = timing.start + rest * np.linspace(0, 1, nodes)
            rate = np.full(nodes, rest / end)
        else:
            end, s, rate = _even_in_x(path, timing.start, timing.x_rate, nodes)
        tables[i], ends[i] = np.stack([s, rate]), end
    return Trajectory(paths, tables, ends)


def _even_in_x(path: Path, start: float, x_rate: float, nodes: int) -> tuple[float, np.ndarray, np.ndarray]:
    x = path.table[X]
    if not np.all(np.diff(x) * np.sign(x[-1] - x[0]) > 0):
        raise PathError("timing: x_rate needs a path on which x always grows or always falls; give speed or duration")
    first = float(path.at(start).x)
    end = abs(float(x[-1]) - first) / x_rate
    direction = np.sign(x[-1] - x[0])
    wanted = first + direction * x_rate * np.linspace(0.0, end, nodes)
    s = np.interp(direction * wanted, direction * x, np.linspace(0.0, path.length, len(x)))
    for _ in range(3):  # Newton: dx/ds = cos(heading)
        point = path.at(s)
        s = np.clip(s + (wanted - point.x) / np.cos(point.heading), 0.0, path.length)
    return end, s, x_rate / np.abs(np.cos(path.at(s).heading))


@njit(cache=True, error_model="numpy")
def _refer(table, length, law, end, time, out):  # type: ignore[no-untyped-def]
    cells = law.shape[1] - 1
    h = end / cells
    place = min(max(time, 0.0), end) / h
    k = min(int(place), cells - 1)
    t = place - k
    right = t * t * (3 - 2 * t)
    s = (
        (1 - right) * law[0, k]
        + right * law[0, k + 1]
        + (t * (1 - t) * (1 - t) * law[1, k] - t * t * (1 - t) * law[1, k + 1]) * h
    )
    rate = (1 - t) * law[1, k] + t * law[1, k + 1]
    if time >= end:
        s = length
        rate = 0.0
    point = lookup(table, length, np.array([s]))
    out[0] = point[0, 0]
    out[1] = point[1, 0]
    out[2] = point[2, 0]
    out[3] = rate
    out[4] = rate * point[3, 0]
    out[5] = s


@njit(cache=True, error_model="numpy")
def _refer_each(table, length, law, end, times, out):  # type: ignore[no-untyped-def]
    for k in range(times.shape[0]):
        _refer(table, length, law, end, times[k], out[:, k])
