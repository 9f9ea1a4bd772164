"""Trajectories: references that move along their paths in time.

A path says where, a :class:`Timing` says how fast; together they are the moving target that controllers track.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from math import inf

import numpy as np

from fuzzy.errors import concerning
from fuzzy.quantity import check_quantities, described, quantity
from robotics.world.paths.joined import join_paths
from robotics.world.paths.path import Path, PathError, Shape, compile_path
from robotics.world.paths.references import References
from robotics.world.paths.road import TIMED, road_of

_only = partial(quantity, None, above=0.0)


@dataclass(frozen=True, kw_only=True)
class Timing:
    """The motion of a reference along its path, by exactly one of three numbers, or none: it rests at the path's end.

    With ``speed`` it has that constant speed, with ``duration`` the constant speed that takes so long. With ``x_rate``
    its x grows evenly, dx/dt = x_rate (the thesis's "x = 0.3 t, y = sin x").

    Raises:
        PathError: None, or several, of these.
    """

    speed: float | None = _only("m/s", doc="The constant speed along the path, between the ramps.", example=0.3)
    duration: float | None = _only("s", doc="The time for the whole path, from which its speed follows.", example=30.0)
    x_rate: float | None = _only("m/s", doc='The constant rate of x, as in "x = 0.3 t, y = sin x".', example=0.3)
    rest: bool = described("Whether it rests at the path's end from the first: a goal without a timetable.", False)
    start: float = quantity(0.0, "m", least=0.0, doc="How far along the path it begins.")
    ramp: float = quantity(
        0.0, "s", least=0.0, doc="The time in which the speed rises at the start, and in which it falls at the end."
    )

    def __post_init__(self) -> None:
        check_quantities(self, PathError)
        given = {n: getattr(self, n) for n in ("speed", "duration", "x_rate") if getattr(self, n) is not None}
        if self.rest and (given or self.start or self.ramp):
            raise PathError(
                "timing: rest = true stands alone: what rests has no speed, duration, x_rate, start or ramp"
            )
        if len(given) != 1 and not self.rest:
            raise PathError(f"timing: give exactly one of speed, duration and x_rate, got {', '.join(given) or 'none'}")
        if self.ramp and self.x_rate is not None:
            raise PathError("timing: ramp goes with speed or duration, not with x_rate")
        if self.duration is not None and 2 * self.ramp > self.duration:
            raise PathError(f"timing: two ramps of {self.ramp:g} s do not fit into {self.duration:g} s")


@dataclass(frozen=True, eq=False, init=False)
class Trajectory(References):
    """Paths with their timing, for all robots of a scenario.

    Attributes:
        paths: Of each robot.
        tables: (robots, 2, nodes): abscissa [m] and its rate [m/s] at equal steps of time.
        joined: The paths in one table.
        ends: The times [s] at which the robots are due at the ends of their paths (robots,).
        road: The same as plain arrays, for compiled functions.
    """

    paths: tuple[Path, ...]
    tables: np.ndarray = field(repr=False)

    def __init__(self, paths: tuple[Path, ...], tables: np.ndarray, ends: np.ndarray) -> None:
        joined = join_paths(paths)
        super().__init__(joined, ends, road_of(joined, TIMED.tabulated, ends, timing=tables))
        object.__setattr__(self, "paths", paths)
        object.__setattr__(self, "tables", tables)


def together(trajectories: Sequence[Trajectory]) -> Trajectory:
    """The robots of all ``trajectories``, one after the other."""
    return Trajectory(
        tuple(path for t in trajectories for path in t.paths),
        np.concatenate([t.tables for t in trajectories]),
        np.concatenate([t.ends for t in trajectories]),
    )


def side_by_side(trajectories: Sequence[Trajectory]) -> References:
    """The trajectories of several scenarios, one for each run; to the last bit as each alone.

    They must have the same number of robots.
    """
    flat, shape = together(trajectories), (len(trajectories), -1)
    joined = replace(flat.joined, lengths=flat.joined.lengths.reshape(shape))
    return References(joined, flat.ends.reshape(shape), flat.road)


def compile_trajectory(paths: tuple[Path, ...], timings: tuple[Timing, ...]) -> Trajectory:
    """Tabulate the motion of each robot's reference. Raises PathError where a timing does not fit its path."""
    nodes = 4097
    tables, ends = np.empty((len(paths), 2, nodes)), np.empty(len(paths))
    for i, (path, timing) in enumerate(zip(paths, timings, strict=True)):
        if timing.start >= path.length:
            raise PathError(f"timing: start {timing.start:g} m lies at or beyond the path's end, {path.length:g} m")
        rest = path.length - timing.start
        if timing.rest:
            end, s, rate = 0.0, np.full(nodes, path.length), np.zeros(nodes)
        elif timing.x_rate is None:
            end, s, rate = _ramped(rest, timing, nodes)
            s = timing.start + s
        else:
            end, s, rate = _even_in_x(path, timing.start, timing.x_rate, nodes)
        tables[i], ends[i] = np.stack([s, rate]), end
    return Trajectory(paths, tables, ends)


def compile_motion(shape: Shape, timing: Timing) -> Trajectory:
    """One reference's trajectory. A PathError is about the key "path" or about "timing"."""
    with concerning("path"):
        path = compile_path(shape)
    with concerning("timing"):
        return compile_trajectory((path,), (timing,))


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
