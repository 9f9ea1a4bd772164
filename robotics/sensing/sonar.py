"""Range sensors: sonars and lidars, with noise, lost echoes and crosstalk.

A sensor sends a cone of rays (one for a beam of a lidar) and reads the shortest echo. It reads infinite where it sees
nothing, as in REP 117; a thing nearer than the minimum range reads the minimum. The noise is normal, with the standard
deviation √(noise² + (relative_noise · distance)²), and never takes a reading out of the range. Between its updates a
sensor keeps its reading.

An echo is lost beyond the incidence angle, where a smooth surface reflects the sound away; a sharp corner that points
at the sensor has no other surface, so that corners below 2 (90° − incidence) are not seen head-on. At random an echo
is lost with the probability ``dropout``, and another robot's ping is heard with the probability ``crosstalk`` if it
arrives straight on: half its way is then read as a distance.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from math import gcd, pi, remainder
from typing import NamedTuple

import numpy as np

from fuzzy.compiled.jit import kernel
from fuzzy.errors import InputError
from robotics.environment.collision import as_poses, for_runs
from robotics.environment.world import Geometry
from robotics.quantity import check_quantities, is_number, quantity, whole
from robotics.random_streams import SONAR_STREAM
from robotics.sensing.raycasting import (
    COS_AXIS,
    COS_HALF,
    COS_INCIDENCE,
    CROSSTALK,
    DROPOUT,
    MINIMUM,
    MOUNT_X,
    MOUNT_Y,
    NOISE,
    RANGE,
    RELATIVE,
    SENSOR_ROWS,
    SIN_AXIS,
    SIN_HALF,
    cast,
    overhear,
)

_DRAWS = 4096  # random numbers of one kind that a run draws at a time: bounds memory, whatever the number of runs
# Kinds of random numbers, each from a generator of its own
_NORMAL = 1  # noise
_LOST = 2  # lost echoes
_TALK = 3  # crosstalk


class SonarError(InputError):
    """A range sensor that cannot be. The message names the field, its value and what is accepted."""


@dataclass(frozen=True, kw_only=True)
class RangeSensor:
    """One range sensor in the robot's frame: x forward, y left, from the axle midpoint. Raises SonarError."""

    x: float = quantity(0.0, "m", least=-10, most=10, doc="Where it is mounted, ahead of the middle of the axle.")
    y: float = quantity(0.0, "m", least=-10, most=10, doc="Where it is mounted, to the left of the middle of the axle.")
    axis: float = quantity(
        0.0, "rad", least=-2 * pi, most=2 * pi, doc="Its direction, counted from straight ahead to the left."
    )
    half_cone: float = quantity(0.0, "rad", least=0, most=pi, doc="Half the opening angle of its cone.")
    rays: int = whole(
        1, least=1, most=10_000, doc="How many rays are spread evenly over the cone; a cone needs at least 2."
    )
    range: float = quantity(2.0, "m", above=0, most=1000, doc="The distance beyond which it sees nothing.")
    minimum: float = quantity(0.0, "m", least=0, most=1000, doc="The least distance that it can read.")
    period: float = quantity(0.05, "s", above=0, most=60, doc="The time from update to update.")
    noise: float = quantity(0.0, "m", least=0, most=10, doc="The standard deviation of a reading.")
    relative_noise: float = quantity(
        0.0, "1", least=0, most=1, doc="The standard deviation of a reading as a share of it, added to the noise."
    )
    incidence: float = quantity(
        pi / 2, "rad", above=0, most=pi / 2, doc="The angle from a surface's normal beyond which there is no echo."
    )
    dropout: float = quantity(0.0, "1", least=0, most=1, doc="The probability with which an echo is lost.")
    crosstalk: float = quantity(
        0.0, "1", least=0, most=1, doc="The probability with which it hears the ping of a robot straight on instead."
    )
    failure_start: float | None = quantity(
        None, "s", least=0, doc="From when on it sees nothing; left out: it never fails.", example=10.0
    )
    failure_end: float | None = quantity(
        None, "s", above=0, doc="Until when it sees nothing; left out: to the end.", example=20.0
    )

    def __post_init__(self) -> None:
        check_quantities(self, SonarError)
        if self.rays == 1 and self.half_cone > 0:
            raise SonarError(f"rays must be >= 2 to fill a half_cone of {self.half_cone:g} rad, got 1").about("rays")
        if self.minimum >= self.range:
            raise SonarError(f"minimum must be < range, {self.range:g} m; got {self.minimum:g}").about("minimum")
        if self.failure_end is not None and (self.failure_start is None or self.failure_end <= self.failure_start):
            raise SonarError(f"failure_end must be > failure_start; got {self.failure_end:g}").about("failure_end")


def _sonar(x: float, y: float, axis: float, half_cone: float, reach: float) -> RangeSensor:
    # Noise, minimum and incidence are typical of 40 kHz transducers and of surfaces that are not quite smooth.
    return RangeSensor(
        x=x, y=y, axis=axis, half_cone=half_cone, rays=7, range=reach, minimum=0.03,
        noise=0.01, relative_noise=0.01, incidence=pi / 3,
    )  # fmt: skip


def sonar(length: float, width: float) -> dict[str, RangeSensor]:
    """Two sonars on the nose and one on each side (thesis 6.2) of a robot of that size [m].

    The thesis gives neither their places nor their ranges.
    """
    nose, side = length / 2, width / 2
    return {
        "front-left": _sonar(nose, 0.3 * width, pi / 9, 37 * pi / 180, 2.0),
        "front-right": _sonar(nose, -0.3 * width, -pi / 9, 37 * pi / 180, 2.0),
        "left": _sonar(0.0, side, pi / 2, pi / 12, 1.2),
        "right": _sonar(0.0, -side, -pi / 2, pi / 12, 1.2),
    }


SONAR: Mapping[str, RangeSensor] = sonar(0.23, 0.20)  # on the EtsRo
FRONT_LEFT, FRONT_RIGHT, LEFT, RIGHT = range(4)  # the order of SONAR


def lidar(beams: int = 121, span: float = 4 * pi / 3, reach: float = 4.0, axis: float = 0.0) -> dict[str, RangeSensor]:
    """The beams of a scanner above the axle, by name: beam-1, beam-2 and so on, from right to left.

    It makes ten scans a second with 1 cm + 1 % of noise, as a small scanner such as the Hokuyo URG-04LX.

    Args:
        beams: Their number.
        span: The angle from the first to the last [rad].
        reach: Their range [m].
        axis: The direction of the middle of the span, counted from straight ahead to the left [rad].

    Raises SonarError for another number than 2 to 10 000, and as :class:`RangeSensor`.
    """
    for name, angle in (("span", span), ("axis", axis)):
        if not (is_number(angle) and abs(angle) <= 2 * pi):
            raise SonarError(f"{name} must be a finite number in rad, >= -2π and <= 2π; got {angle!r}").about(name)
    if isinstance(beams, bool) or not isinstance(beams, int) or not 2 <= beams <= 10_000:
        raise SonarError(f"beams must be a whole number >= 2 and <= 10000, got {beams!r}").about("beams")
    axes = [axis + a for a in np.linspace(-span / 2, span / 2, beams).tolist()]
    return {
        f"beam-{n}": RangeSensor(
            axis=_wrapped(a), range=reach, minimum=0.02, period=0.1, noise=0.01, relative_noise=0.01
        )
        for n, a in enumerate(axes, start=1)
    }


def _wrapped(angle: float) -> float:
    return angle if abs(angle) <= 2 * pi else remainder(angle, 2 * pi)


LIDAR: Mapping[str, RangeSensor] = lidar()
PRESETS: dict[str, Mapping[str, RangeSensor]] = {"sonar": SONAR, "lidar": LIDAR}


@dataclass(frozen=True, eq=False)
class Ranges:
    """The present readings of all range sensors. ``ranges["left"]`` is (runs, robots) [m]; infinite: nothing seen."""

    names: tuple[str, ...]
    values: np.ndarray  # (runs, robots, sensors) m; infinite also where a robot does not carry that sensor

    def __getitem__(self, name: str) -> np.ndarray:
        """The readings of the sensor ``name`` (runs, robots) [m]."""
        return np.asarray(self.values[..., self.names.index(name)])

    def of(self, names: Sequence[str]) -> np.ndarray:
        """The readings of the sensors ``names``, in this order (runs, robots, sensors) [m]."""
        if tuple(names) == self.names:
            return self.values
        return np.ascontiguousarray(self.values[..., [self.names.index(name) for name in names]])


class Echoes(NamedTuple):
    """The memory of range sensors."""

    readings: np.ndarray  # (runs, robots, sensors) m
    block: int  # the number of the block of random numbers in ``draws``; -1: none yet
    draws: tuple[np.ndarray | None, ...]  # normal, lost, talk: (updates, runs, robots, sensors)


@dataclass(frozen=True)
class SensorArray:
    """The same sensors on every robot of a simulation; their state is an :class:`Echoes`."""

    table: np.ndarray = field(repr=False)  # (SENSOR_ROWS, sensors)
    rays: np.ndarray = field(repr=False)  # (2, rays of all): directions in the robot's frame
    first_ray: np.ndarray = field(repr=False)  # (sensors + 1,)
    every: np.ndarray  # (sensors,) control periods from update to update
    seeds: tuple[int, ...] = field(repr=False)
    stride: int  # control periods from any update to the next
    failures: np.ndarray | None = field(
        repr=False
    )  # (2, sensors) control periods: failed from, until; None: none fails

    @classmethod
    def opened(cls, sensors: Sequence[RangeSensor], seeds: Sequence[int], tick: float) -> "SensorArray":
        """Make ``sensors`` for the runs of ``seeds``, for control periods of ``tick`` [s]. Raises SonarError."""
        if not sensors:
            raise SonarError("at least one range sensor is needed")
        every = np.array([max(1, round(sensor.period / tick)) for sensor in sensors])
        for sensor, periods in zip(sensors, every, strict=True):
            if abs(sensor.period - periods * tick) > 1e-9:
                raise SonarError(f"period must be a multiple of {tick:g} s, got {sensor.period:g}").about("period")
        angles = [sensor.axis + np.linspace(-1, 1, sensor.rays) * sensor.half_cone for sensor in sensors]
        angles = [a if len(a) > 1 else np.array([sensor.axis]) for a, sensor in zip(angles, sensors, strict=True)]
        joined = np.concatenate(angles)
        return cls(
            np.stack([_column(sensor) for sensor in sensors], axis=1),
            np.stack([np.cos(joined), np.sin(joined)]),
            np.concatenate([[0], np.cumsum([len(a) for a in angles])]),
            every,
            tuple(seeds),
            gcd(*every.tolist()),
            _failures(sensors, tick),
        )

    def init(self, robots: int) -> Echoes:
        """Return the memory at the start for ``robots`` robots: nothing was seen yet."""
        return Echoes(np.full((len(self.seeds), robots, len(self.every)), np.inf), -1, (None, None, None))

    def echoes(
        self, x: np.ndarray, y: np.ndarray, heading: np.ndarray, sizes: np.ndarray, geometry: Geometry
    ) -> np.ndarray:
        """The exact distances that all sensors would read now [m] (runs, robots, sensors): no noise, no minimum.

        The arguments are as of :func:`robotics.environment.collision.obstacle_contacts`.
        """
        return self._cast(np.ones(len(self.every), dtype=bool), x, y, heading, sizes, geometry)

    def sense(
        self,
        state: Echoes,
        k: int,
        x: np.ndarray,
        y: np.ndarray,
        heading: np.ndarray,
        sizes: np.ndarray,
        geometry: Geometry,
    ) -> tuple[np.ndarray, Echoes]:
        """Return the readings [m] (runs, robots, sensors) in control period ``k``, infinite where nothing is seen.

        The memory after them is returned too. The poses, sizes and geometry are as of :meth:`echoes`. The noise of a
        period depends on the seed and ``k`` only.
        """
        due = k % self.every == 0
        if not due.any():
            return state.readings, state
        exact = self._cast(due, x, y, heading, sizes, geometry)
        update = k // self.stride
        length = max(1, _DRAWS // state.readings[0].size)
        if update // length != state.block:
            state = state._replace(block=update // length, draws=self._drawn(update // length, length, x.shape[1]))
        normal, lost, talk = (None if d is None else d[update % length] for d in state.draws)
        if talk is not None:
            x, y, heading = as_poses(x, y, heading)
            overhear(exact, x, y, heading, sizes, *geometry, self.table, due, talk < self.table[CROSSTALK])
        none = np.empty((0, 0, 0))
        readings = _read(
            exact, state.readings, due, self.table, none if normal is None else normal, none if lost is None else lost
        )
        if self.failures is not None:
            failed = (self.failures[0] <= k) & (k < self.failures[1])
            readings = np.where(failed & due, np.inf, readings)
        return readings, state._replace(readings=readings)

    def _cast(
        self,
        due: np.ndarray,
        x: np.ndarray,
        y: np.ndarray,
        heading: np.ndarray,
        sizes: np.ndarray,
        geometry: Geometry,
    ) -> np.ndarray:
        x, y, heading = as_poses(x, y, heading)
        sensors = (self.table, self.rays, self.first_ray, due)
        return np.asarray(cast(x, y, heading, sizes, *for_runs(geometry, len(x)), *sensors))

    def _drawn(self, block: int, length: int, robots: int) -> tuple[np.ndarray | None, ...]:
        """A block of random numbers of each kind that is needed; each run draws from its own generators."""
        shape = (length, robots, len(self.every))
        wanted = {
            _NORMAL: self.table[[NOISE, RELATIVE]].any(),
            _LOST: self.table[DROPOUT].any(),
            _TALK: self.table[CROSSTALK].any() and robots > 1,
        }
        blocks: list[np.ndarray | None] = []
        for kind, needed in wanted.items():
            if not needed:
                blocks.append(None)
                continue
            draws, rows = np.empty((length, len(self.seeds), *shape[1:])), np.empty(shape)
            for r, seed in enumerate(self.seeds):
                generator = np.random.default_rng([seed, SONAR_STREAM, kind, block])
                if kind == _NORMAL:
                    generator.standard_normal(out=rows)
                else:
                    generator.random(out=rows)
                draws[:, r] = rows
            blocks.append(draws)
        return tuple(blocks)


def _failures(sensors: Sequence[RangeSensor], tick: float) -> np.ndarray | None:
    """The control periods in which each sensor fails: the first, and the one after the last."""
    starts = np.array([np.inf if s.failure_start is None else s.failure_start for s in sensors])
    ends = np.array([np.inf if s.failure_end is None else s.failure_end for s in sensors])
    return np.stack([starts, ends]) / tick - 1e-9 if np.isfinite(starts).any() else None


def _column(sensor: RangeSensor) -> np.ndarray:
    rows = {
        MOUNT_X: sensor.x,
        MOUNT_Y: sensor.y,
        COS_AXIS: np.cos(sensor.axis),
        SIN_AXIS: np.sin(sensor.axis),
        COS_HALF: np.cos(sensor.half_cone),
        SIN_HALF: np.sin(sensor.half_cone),
        RANGE: sensor.range,
        COS_INCIDENCE: np.cos(sensor.incidence) if sensor.incidence < pi / 2 else 0.0,
        MINIMUM: sensor.minimum,
        NOISE: sensor.noise,
        RELATIVE: sensor.relative_noise,
        DROPOUT: sensor.dropout,
        CROSSTALK: sensor.crosstalk,
    }
    return np.array([rows[i] for i in range(SENSOR_ROWS)])


@kernel
def _read(exact, held, due, table, normal, lost):  # type: ignore[no-untyped-def]
    """The readings of all sensors: those that are due with noise and losses, the others as they are ``held``."""
    out = np.empty_like(exact)
    for r in range(exact.shape[0]):
        for i in range(exact.shape[1]):
            for q in range(exact.shape[2]):
                if not due[q]:
                    out[r, i, q] = held[r, i, q]
                    continue
                d = exact[r, i, q]
                if d < np.inf and lost.size and lost[r, i, q] < table[DROPOUT, q]:
                    d = np.inf
                if d < np.inf:
                    if normal.size:
                        d += np.sqrt(table[NOISE, q] ** 2 + (table[RELATIVE, q] * d) ** 2) * normal[r, i, q]
                    d = min(max(d, table[MINIMUM, q]), table[RANGE, q])
                out[r, i, q] = d
    return out
