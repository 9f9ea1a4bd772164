"""Trajectories: references that move along their paths in time.

A path says where, a :class:`Timing` says how fast; together they are the moving target that controllers track.
"""

from dataclasses import dataclass, field
from functools import cached_property
from math import inf
from typing import NamedTuple

import numpy as np

from robotics.paths.joined import PathTable, join_paths
from robotics.paths.path import Path, PathError
from robotics.paths.road import TIMED, Road, road_of, rows_at
from robotics.quantity import check_quantities, quantity


@dataclass(frozen=True, kw_only=True)
class Timing:
    """The motion of a reference along its path, by exactly one of three numbers.

    With ``speed`` it has that constant speed, with ``duration`` the constant speed that takes so long. With ``x_rate``
    its x grows evenly, dx/dt = x_rate (the thesis's "x = 0.3 t, y = sin x").

    Raises:
        PathError: None, or several, of the three numbers.
    """

    speed: float | None = quantity(
        None, "m/s", above=0.0, doc="The constant speed along the path, between the ramps.", example=0.3
    )
    duration: float | None = quantity(
        None, "s", above=0.0, doc="The time for the whole path, from which its speed follows.", example=30.0
    )
    x_rate: float | None = quantity(
        None, "m/s", above=0.0, doc='The constant rate of x, as in "x = 0.3 t, y = sin x".', example=0.3
    )
    start: float = quantity(0.0, "m", least=0.0, doc="How far along the path it begins.")
    ramp: float = quantity(
        0.0, "s", least=0.0, doc="The time in which the speed rises at the start, and in which it falls at the end."
    )

    def __post_init__(self) -> None:
        check_quantities(self, PathError)
        given = {n: getattr(self, n) for n in ("speed", "duration", "x_rate") if getattr(self, n) is not None}
        if len(given) != 1:
            raise PathError(f"timing: give exactly one of speed, duration and x_rate, got {', '.join(given) or 'none'}")
        if self.ramp and self.x_rate is not None:
            raise PathError("timing: ramp goes with speed or duration, not with x_rate")
        if self.duration is not None and 2 * self.ramp > self.duration:
            raise PathError(f"timing: two ramps of {self.ramp:g} s do not fit into {self.duration:g} s")


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
    """Paths with their timing, for all robots of a scenario.

    Attributes:
        paths: Of each robot.
        tables: (robots, 2, nodes): abscissa [m] and its rate [m/s] at equal time steps.
        ends: (robots,) [s]: when each reference reaches the end of its path.
        joined: The same paths, for looking up all at once.
    """

    paths: tuple[Path, ...]
    tables: np.ndarray = field(repr=False)
    ends: np.ndarray = field(repr=False)
    joined: PathTable = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        object.__setattr__(self, "joined", join_paths(self.paths))

    @cached_property
    def road(self) -> Road:
        """The same as plain arrays."""
        return road_of(self.joined, TIMED.tabulated, self.ends, timing=self.tables)

    def at(self, time: float) -> Reference:
        """Every robot's reference at ``time`` [s]; after its end a reference rests there."""
        return Reference(*rows_at(self.road, np.full(len(self.paths), float(time))))

    def sampled(self, times: np.ndarray) -> Reference:
        """The references at ``times`` (n,) [s]; each field is (n, robots)."""
        times = np.asarray(times, dtype=float)
        return Reference(*rows_at(self.road, np.repeat(times[:, None], len(self.paths), axis=1)))

    def each_at(self, times: np.ndarray) -> Reference:
        """Each robot's reference at a time of its own, ``times`` (n, robots) [s]; each field is (n, robots)."""
        return Reference(*rows_at(self.road, times))


def compile_trajectory(paths: tuple[Path, ...], timings: tuple[Timing, ...]) -> Trajectory:
    """Tabulate the motion of each robot's reference. Raises PathError where a timing does not fit its path."""
    nodes = 4097
    tables, ends = np.empty((len(paths), 2, nodes)), np.empty(len(paths))
    for i, (path, timing) in enumerate(zip(paths, timings, strict=True)):
        if timing.start >= path.length:
            raise PathError(f"timing: start {timing.start:g} m lies at or beyond the path's end, {path.length:g} m")
        rest = path.length - timing.start
        if timing.x_rate is None:
            end, s, rate = _ramped(rest, timing, nodes)
            s = timing.start + s
        else:
            end, s, rate = _even_in_x(path, timing.start, timing.x_rate, nodes)
        tables[i], ends[i] = np.stack([s, rate]), end
    return Trajectory(paths, tables, ends)


def _ramped(rest: float, timing: Timing, nodes: int) -> tuple[float, np.ndarray, np.ndarray]:
    """The end time [s], and abscissae [m] and speeds [m/s] (nodes,), over ``rest`` [m] between two linear ramps."""
    ramp = timing.ramp
    if timing.duration is not None:
        end = timing.duration
        speed = rest / (end - ramp)
    else:
        speed = timing.speed or inf
        ramp = min(ramp, rest / speed)  # a path too short for the speed is driven in a triangle
        end = rest / speed + ramp
    if ramp < 1e-9:  # s: rounding takes it for none
        return end, rest * np.linspace(0, 1, nodes), np.full(nodes, rest / end)
    t = np.linspace(0.0, end, nodes)
    left = end - t
    s = np.where(t < ramp, speed * t**2 / (2 * ramp), speed * (t - ramp / 2))
    s = np.where(left < ramp, rest - speed * left**2 / (2 * ramp), s)
    return end, s, speed * np.minimum(1.0, np.minimum(t, left) / ramp)


def _even_in_x(path: Path, start: float, x_rate: float, nodes: int) -> tuple[float, np.ndarray, np.ndarray]:
    x = path.nodes.x
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
