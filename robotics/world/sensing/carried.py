"""The range sensors of a team, of which each robot may carry its own, and how they are read in every period.

The noise of a period depends on the seed and on the period only, so that whoever asks again reads the same.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from math import gcd, pi
from typing import NamedTuple

import numpy as np

from fuzzy.compiled.columns import Columns, Floats1, Floats2, Floats3, Ints1, Ints2, codes, column
from fuzzy.compiled.jit import compiled_only, without_refcounts
from robotics.world.environment.world import Geometry, Moving, place
from robotics.world.random_streams import SONAR_STREAM
from robotics.world.sensing.raycasting import Bodies, Eyes, SensorColumns, bodies_in_view, cast, overhear
from robotics.world.sensing.sonar import RangeSensor, SonarError
from robotics.world.vehicle.plant import TruthColumns

_DRAWS = 4096  # random numbers of one kind that a run draws at a time: bounds memory, whatever the number of runs
_DRAWN = codes(("noise", "loss", "crosstalk"))  # each from a generator of its own


class KindColumns(Columns):
    """What robots of a kind carry, and where their random numbers are."""

    first = column("", "its first sensor")
    end = column("", "the first that is not its")
    stride = column("periods", "from look to look")
    length = column("looks", "for which random numbers are there at a time")
    place = column("", "of the first of them")


def sensor_names(sensors: Sequence[Mapping[str, RangeSensor]]) -> tuple[str, ...]:
    """The names of all sensors that any robot carries, in the order of the first robot that has them."""
    return tuple(dict.fromkeys(name for carried in sensors for name in carried))


class Looks(NamedTuple):
    """The range sensors of all robots as columns, for compiled functions; a lane is one robot of one run.

    Robots that carry the same sensors are of one kind, whose sensors stand in a row.
    """

    eyes: Eyes
    every: Ints1  # (sensors,): control periods from update to update
    column: Ints1  # (sensors,): its place in the readings
    kinds: Ints2  # (KindColumns, kinds)
    kind: Ints1  # (lanes,): what a robot carries; -1: nothing
    sizes: Floats2  # (3, lanes): of robotics.world.environment.collision.footprints
    here: Geometry  # the obstacles, of as many runs or of one world for all
    moving: Moving
    draws: Floats3  # (3, runs, numbers): normal numbers, and evenly distributed ones, as _DRAWN
    drawn: Ints1  # (kinds,): the block of random numbers that is there; -1: none
    readings: Floats2  # (lanes, names) m; infinite also where a robot does not carry that sensor
    wanted: Ints1  # (needs,): the readings that a law needs, in its order
    turned: Floats2  # (2, lanes): cosine and sine of the headings
    bodies: Bodies  # to work in
    echoes: Floats1  # (sensors,) m: likewise


@dataclass(frozen=True, eq=False)
class CarriedSensors:
    """The range sensors of all robots of a simulation, and their random numbers."""

    names: tuple[str, ...]
    kinds: tuple[Mapping[str, RangeSensor], ...]  # each once
    kind: np.ndarray  # (lanes,) int: which of them a robot carries; -1: nothing
    robots: int  # of a run
    seeds: tuple[int, ...]  # one for each run
    tick: float  # s

    @classmethod
    def opened(
        cls, sensors: Sequence[Mapping[str, RangeSensor]], robots: int, seeds: Sequence[int], tick: float
    ) -> "CarriedSensors":
        """Make the sensors of a simulation. Raises SonarError where a sensor's period does not suit ``tick``.

        Args:
            sensors: By name those of each robot of a run, or of each robot of all runs, run after run.
            robots: The number of robots of a run.
            seeds: One for each run.
            tick: The control period [s].
        """
        kinds: list[Mapping[str, RangeSensor]] = []
        of: dict[int, int] = {}  # a population's robots share what they carry: the same object is not compared again
        for carried in sensors:
            if id(carried) not in of:
                if carried and carried not in kinds:
                    kinds.append(carried)
                of[id(carried)] = kinds.index(carried) if carried else -1
        for sensor in (sensor for carried in kinds for sensor in carried.values()):
            _periods(sensor, tick)
        kind = np.resize([of[id(carried)] for carried in sensors], robots * len(seeds))
        return cls(sensor_names(kinds), tuple(kinds), kind.astype(np.int64), robots, tuple(seeds), tick)

    def looks(self, here: Geometry, moving: Moving, sizes: np.ndarray, needs: Sequence[str] = ()) -> Looks:
        """The columns before the first period: nothing was seen yet.

        Args:
            here: The obstacles, of as many runs or of one world for all; ``moving`` ones are placed in it.
            moving: The obstacles that move, by control period.
            sizes: Of the robots (3, lanes), as of :func:`robotics.world.environment.collision.footprints`.
            needs: The names of the sensors that a law reads.
        """
        sensors = [sensor for carried in self.kinds for sensor in carried.values()]
        angles = [sensor.axis + np.linspace(-1, 1, sensor.rays) * sensor.half_cone for sensor in sensors]
        angles = [a if len(a) > 1 else np.array([sensor.axis]) for a, sensor in zip(angles, sensors, strict=True)]
        joined = np.concatenate([np.empty(0), *angles])
        eyes = Eyes(
            np.array([_column(sensor, self.tick) for sensor in sensors]).reshape(-1, SensorColumns.size).T.copy(),
            np.stack([np.cos(joined), np.sin(joined)]),
            np.cumsum([0, *(len(a) for a in angles)]),
            np.zeros(len(sensors), dtype=bool),
        )
        every = np.array([_periods(sensor, self.tick) for sensor in sensors], dtype=np.int64)
        kinds, numbers = self._kinds(every)
        wanted = any(self._draws(carried, kind) for carried in self.kinds for kind in _DRAWN)
        return Looks(
            eyes,
            every,
            np.array([self.names.index(name) for carried in self.kinds for name in carried], dtype=np.int64),
            kinds,
            self.kind,
            np.ascontiguousarray(sizes, dtype=float),
            here,
            moving,
            np.empty((3, len(self.seeds), numbers if wanted else 0)),
            np.full(len(self.kinds), -1),
            np.full((len(self.kind), len(self.names)), np.inf),
            np.array([self.names.index(name) for name in needs], dtype=np.int64),
            np.empty((2, len(self.kind))),
            bodies_in_view(here.circles.shape[1], here.segments.shape[1], self.robots, len(joined)),
            np.empty(len(sensors)),
        )

    def _kinds(self, every: np.ndarray) -> tuple[np.ndarray, int]:
        """The rows of Looks.kinds, and how many random numbers of one kind a run has."""
        rows = np.zeros((KindColumns.size, len(self.kinds)), dtype=np.int64)
        first, places, numbers = 0, dict[tuple[int, int], int](), 0
        for n, carried in enumerate(self.kinds):
            end = first + len(carried)
            stride = gcd(*every[first:end].tolist())
            length = max(1, _DRAWS // (self.robots * len(carried)))
            # As many sensors that look as often draw the same numbers of a seed.
            if (len(carried), stride) not in places:
                places[len(carried), stride] = numbers
                numbers += length * self.robots * len(carried)
            rows[:, n] = first, end, stride, length, places[len(carried), stride]
            first = end
        return rows, numbers

    def _draws(self, carried: Mapping[str, RangeSensor], kind: int) -> bool:
        """Whether sensors need random numbers of a kind."""
        if kind == _DRAWN.noise:
            return any(s.noise or s.relative_noise for s in carried.values())
        if kind == _DRAWN.loss:
            return any(s.dropout for s in carried.values())
        return self.robots > 1 and any(s.crosstalk for s in carried.values())

    def supply(self, looks: Looks, k: int) -> None:
        """Draw the random numbers of control period ``k`` and of some after it, if they are not there."""
        if looks.draws.shape[2] == 0:
            return
        kinds = KindColumns(looks.kinds)
        fresh: set[int] = set()  # places of random numbers that were drawn now
        for n, carried in enumerate(self.kinds):
            stride, length, at = (int(row[n]) for row in (kinds.stride, kinds.length, kinds.place))
            block = k // stride // length
            if block == looks.drawn[n]:
                continue
            looks.drawn[n] = block
            if at in fresh:
                continue
            fresh.add(at)
            alike = [c for c, place_of in zip(self.kinds, kinds.place, strict=True) if place_of == at]
            numbers = length * self.robots * len(carried)
            for kind in _DRAWN:
                if any(self._draws(c, kind) for c in alike):
                    self._draw(looks.draws[kind, :, at : at + numbers], kind, block)

    def _draw(self, rows: np.ndarray, kind: int, block: int) -> None:
        for seed, row in zip(self.seeds, rows, strict=True):
            generator = np.random.default_rng([seed, SONAR_STREAM, kind + 1, block])
            if kind == _DRAWN.noise:
                generator.standard_normal(out=row)
            else:
                generator.random(out=row)

    def last_period(self, looks: Looks) -> float:
        """The control period up to which random numbers are there."""
        if looks.draws.shape[2] == 0:
            return np.inf
        kinds = KindColumns(looks.kinds)
        return int(((looks.drawn + 1) * kinds.length * kinds.stride).min())


def nothing_to_see(lanes: int) -> Looks:
    """The columns of robots that do not look."""
    sensors = CarriedSensors((), (), np.full(lanes, -1), 1, (), 1.0)
    return sensors.looks(Geometry.nothing(), Moving.nothing(), np.empty((3, 0)))._replace(readings=np.empty((0, 0)))


def _periods(sensor: RangeSensor, tick: float) -> int:
    """The control periods of ``tick`` [s] from update to update. Raises SonarError where they are no whole number."""
    periods = max(1, round(sensor.period / tick))
    if abs(sensor.period - periods * tick) > 1e-9:
        raise SonarError(f"period must be a multiple of {tick:g} s, got {sensor.period:g}").about("period")
    return periods


def _column(sensor: RangeSensor, tick: float) -> np.ndarray:
    start, end = (np.inf if at is None else at for at in (sensor.failure_start, sensor.failure_end))
    own = "x", "y", "range", "minimum", "noise", "relative_noise", "dropout", "crosstalk"
    rows = {name: getattr(sensor, name) for name in own} | {
        "cos_axis": np.cos(sensor.axis),
        "sin_axis": np.sin(sensor.axis),
        "cos_half": np.cos(sensor.half_cone),
        "sin_half": np.sin(sensor.half_cone),
        "cos_incidence": np.cos(sensor.incidence) if sensor.incidence < pi / 2 else 0.0,
        "fails_from": start / tick - 1e-9,
        "fails_until": end / tick - 1e-9,
    }
    return np.array(SensorColumns.stacked(rows))


@without_refcounts
def look(looks, k, truth, robots, ranges, goes_on):  # type: ignore[no-untyped-def]
    """Read all range sensors that are due in control period ``k``; the others keep their readings.

    Args:
        looks: The sensors.
        k: The control period.
        truth: True x [m], y [m] and heading [rad] in the first rows (rows, lanes).
        robots: Of a run.
        ranges: Where the readings that a law needs are written (needs, lanes) [m].
        goes_on: (runs,): whether it does; of a run that does not nothing is read.
    """
    if not some_due(looks, k):
        return
    turned, here = looks.turned, TruthColumns(truth)
    if looks.moving.frames.shape[0] > 0:
        place(looks.here, looks.moving, k)
    for lane in range(truth.shape[1]):
        turned[0, lane], turned[1, lane] = np.cos(here.heading[lane]), np.sin(here.heading[lane])
    for lane in range(truth.shape[1]):
        if goes_on[lane // robots]:
            look_of(looks, k, lane, robots, truth)
            tell(looks, lane, ranges)


@compiled_only
def some_due(looks, k):  # type: ignore[no-untyped-def]
    """Note which sensors are due in control period ``k``; return whether any is."""
    found = False
    for q in range(len(looks.every)):
        looks.eyes.due[q] = k % looks.every[q] == 0
        found |= looks.eyes.due[q]
    return found


@compiled_only
def tell(looks, lane, ranges):  # type: ignore[no-untyped-def]
    """Write the readings of one lane that a law needs."""
    for n in range(len(looks.wanted)):
        ranges[n, lane] = looks.readings[lane, looks.wanted[n]]


@compiled_only
def look_of(looks, k, lane, robots, truth):  # type: ignore[no-untyped-def]
    """Read the sensors of one lane that are due; its heading's cosine and sine are there."""
    kind = looks.kind[lane]
    if kind < 0:
        return
    eyes, here = looks.eyes, TruthColumns(truth)
    mine = KindColumns(looks.kinds, kind)
    begin, end = mine.first, mine.end
    cast(
        eyes, begin, end, lane, robots, here.x, here.y, looks.turned, looks.sizes, looks.here, looks.bodies,
        looks.echoes,
    )  # fmt: skip
    update = k // mine.stride % mine.length
    drawn = mine.place + (update * robots + lane % robots) * (end - begin)
    for q in range(begin, end):
        if eyes.due[q]:
            _read(looks, k, q, kind, lane, robots, drawn + q - begin, truth)


@without_refcounts
def _read(looks, k, q, kind, lane, robots, drawn, truth):  # type: ignore[no-untyped-def]
    """Read one sensor: its echo, or the ping of another, with noise and losses."""
    sensor, run, d, here = SensorColumns(looks.eyes.table, q), lane // robots, looks.echoes[q], TruthColumns(truth)
    if sensor.crosstalk > 0 and robots > 1 and looks.draws[_DRAWN.crosstalk, run, drawn] < sensor.crosstalk:
        carried = KindColumns(looks.kinds, kind)
        d = overhear(
            d, looks.eyes, carried.first, carried.end, q, lane, robots, looks.kind,
            here.x, here.y, looks.turned, looks.sizes, looks.here,
        )  # fmt: skip
    if sensor.dropout > 0 and looks.draws[_DRAWN.loss, run, drawn] < sensor.dropout:
        d = np.inf
    if d < np.inf:
        if sensor.noise > 0 or sensor.relative_noise > 0:
            d += np.sqrt(sensor.noise**2 + (sensor.relative_noise * d) ** 2) * looks.draws[_DRAWN.noise, run, drawn]
        d = min(max(d, sensor.minimum), sensor.range)
    if sensor.fails_from <= k < sensor.fails_until:
        d = np.inf
    looks.readings[lane, looks.column[q]] = d


@without_refcounts
def see_nothing(looks, k, truth, robots, ranges, goes_on):  # type: ignore[no-untyped-def]
    """Do nothing, in place of :func:`look`, where nobody looks."""
