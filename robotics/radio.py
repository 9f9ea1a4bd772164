"""The radio: who hears whom, how late, and what is lost; and the faults of a run.

Every ``period`` each robot broadcasts what its law wants to say. A message reaches a robot that the graph (and the
range) lets hear it after ``latency`` and up to ``jitter`` more, unless it is lost: each with the probability
``loss``, or in bursts by the model of Gilbert and Elliott [Gilbert 1960, Elliott 1963]: a link goes bad with the
probability ``burst_start`` a message, good again with ``burst_end``, and loses ``burst_loss`` of them meanwhile.
What is heard is at least one control period old: all robots decide at the same time.

Baud rates count ten bits a byte, on one shared channel: all messages of a period must fit.
"""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from math import ceil
from typing import Any, Literal, NamedTuple

import numpy as np
from numba import njit

from fuzzy.errors import InputError
from robotics.graph import GRAPHS, adjacency
from robotics.quantity import check_quantities, quantity

_BLOCK = 2_000_000  # random numbers drawn at a time: bounds memory
# Random streams of a seed beside that of the start and the posture noise, so that one does not shift another
RADIO_STREAM, RELATIVE_STREAM, WHEEL_STREAM, FAULT_STREAM = 1, 2, 3, 4
# The kinds of faults, each with what a run records for it, the gravest first
FAULTS = {"failure": 1, "stall": 4, "delay": 2, "silence": 3}

_NO_CUT = np.zeros((0, 0, 0), dtype=bool)

PRESETS: dict[str, dict[str, Any]] = {
    # Thesis 4.5: ZigBee modules at 9600 baud. Frame overhead: transmit request with a 16-bit address (assumed).
    "zigbee-9600": {"baud": 9600.0, "header_bytes": 9, "value_bytes": 2, "period": 0.1, "latency": 0.03},
}


class RadioError(InputError):
    """A radio or a fault that cannot be. The message names the field and what is accepted."""


@dataclass(frozen=True, kw_only=True)
class Radio:
    """How a team talks."""

    graph: Literal["star", "ring", "line", "complete", "edges"] = "complete"
    hub: int = 1  # the center of a star, from 1
    edges: tuple[tuple[int, int], ...] = ()  # for "edges": [sender, receiver], from 1
    range: float | None = quantity(None, "m", above=0)  # between centers; none: unlimited
    period: float = quantity(0.05, "s", above=0, most=60)  # from message to message
    latency: float = quantity(0.0, "s", least=0, most=10)
    jitter: float = quantity(0.0, "s", least=0, most=10)  # uniform on top of the latency
    loss: float = quantity(0.0, "1", least=0, most=1)  # of messages, independently
    burst_start: float = quantity(0.0, "1", least=0, most=1)  # good link -> bad, a message
    burst_end: float = quantity(0.2, "1", above=0, most=1)  # bad -> good
    burst_loss: float = quantity(1.0, "1", least=0, most=1)  # of messages on a bad link, if more than loss
    baud: float | None = quantity(None, "baud", above=0)  # none: unlimited
    header_bytes: int = 0  # of a message besides its values
    value_bytes: int = 2  # of a value

    def __post_init__(self) -> None:
        check_quantities(self, RadioError)
        _expect_one_of(GRAPHS, "graph", self.graph)
        for name, least in (("hub", 1), ("header_bytes", 0), ("value_bytes", 1)):
            number = getattr(self, name)
            if not isinstance(number, int) or number < least:
                raise _about(RadioError(f"{name} must be a whole number >= {least}, got {number!r}"), name)
        if (self.graph == "edges") != bool(self.edges):
            raise _about(
                RadioError('edges = [[sender, receiver], ...] belong to graph = "edges", and only to it'), "edges"
            )
        for sender, receiver in self.edges:
            if sender == receiver:
                raise _about(RadioError(f"edges: robot {sender} needs no radio to hear itself"), "edges")

    def adjacency(self, robots: int) -> np.ndarray:
        """Who can hear whom (robots, robots), before range. Raises RadioError where a robot does not exist."""
        for name, values in (("hub", [self.hub]), ("edges", [i for edge in self.edges for i in edge])):
            for i in values:
                if not 1 <= i <= robots:
                    raise _about(RadioError(f"{name}: robots are 1 to {robots}, got {i}"), name)
        return adjacency(self.graph, robots, self.hub, self.edges)

    def check_bandwidth(self, robots: int, values: int) -> None:
        """Do ``robots`` messages of so many values fit into a period? Raises RadioError."""
        if self.baud is None or values == 0:
            return
        need = robots * (self.header_bytes + self.value_bytes * values)
        room = self.baud / 10 * self.period
        if need > room + 1e-9:
            raise _about(
                RadioError(
                    f"{robots} robots × ({self.header_bytes} + {values} × {self.value_bytes}) bytes = {need} bytes "
                    f"every {self.period:g} s do not fit into the {room:g} that {self.baud:g} baud carry; "
                    f"period must be >= {ceil(need / self.baud * 1000) / 100:g} s"
                ),
                "period",
            )


@dataclass(frozen=True, kw_only=True)
class Fault:
    """What goes wrong with one robot for a while.

    "failure": its wheel references are 0, and nobody hears it, nor it anybody. "delay": it holds its last command, and
    nobody hears it, nor it anybody. "silence": it drives on, but nobody hears it, nor it anybody; with ``other`` only
    that link is silent, both ways. "stall": its wheel references are 0, as if it were held up, and the radio works.
    With ``start_until`` each seed draws its start evenly between ``start`` and that.
    """

    robot: int  # from 1
    kind: Literal["failure", "delay", "silence", "stall"]
    start: float = quantity(0.0, "s", least=0)
    duration: float = quantity(1.0, "s", above=0)
    start_until: float | None = quantity(None, "s", least=0)
    other: int | None = None  # from 1

    def __post_init__(self) -> None:
        check_quantities(self, RadioError)
        _expect_one_of(FAULTS, "kind", self.kind)
        if self.other is not None and (self.kind != "silence" or self.other == self.robot):
            raise _about(RadioError('other names the far end of a link, for kind = "silence"'), "other")
        if self.start_until is not None and self.start_until < self.start:
            raise _about(
                RadioError(f"start_until must be >= start, {self.start:g} s; got {self.start_until:g}"), "start_until"
            )


def _about(error: ValueError, name: str) -> ValueError:
    error.field = name  # type: ignore[attr-defined]
    return error


def _expect_one_of(names: Iterable[str], name: str, value: Any) -> None:
    if value not in names:
        raise _about(RadioError(f"{name} must be one of {', '.join(map(repr, names))}; got {value!r}"), name)


class Heard(NamedTuple):
    """What each robot last heard of each other."""

    values: np.ndarray  # (fields, runs, receivers, senders); not-a-number before the first message
    age: np.ndarray  # (runs, receivers, senders) s since it was sent; infinite before the first
    hears: np.ndarray  # (robots, robots) bool: the graph


class Condition(NamedTuple):
    """Which robots are at fault at one time."""

    failed: np.ndarray  # (runs, robots) bool: wheel references are 0
    held: np.ndarray  # (runs, robots) bool: the last command is held
    cut: np.ndarray  # (runs, receivers, senders) bool: no message passes
    code: np.ndarray  # (runs, robots) int: of FAULTS, the gravest of several; 0: none, or only a link of it


@dataclass(frozen=True)
class Faults:
    """The faults of every run."""

    faults: tuple[Fault, ...]
    robots: int
    starts: np.ndarray  # (runs, faults) s
    ends: np.ndarray  # (runs, faults) s

    @classmethod
    def drawn(cls, faults: Sequence[Fault], robots: int, seeds: Sequence[int]) -> "Faults":
        """When each fault begins in the run of each seed."""
        draws = np.array([np.random.default_rng([seed, FAULT_STREAM]).random(len(faults)) for seed in seeds])
        start = np.array([f.start for f in faults])
        until = np.array([f.start if f.start_until is None else f.start_until for f in faults])
        starts = start + draws.reshape(len(seeds), len(faults)) * (until - start)
        return cls(tuple(faults), robots, starts, starts + [f.duration for f in faults])

    def at(self, time: float) -> Condition | None:
        """The condition at ``time`` [s]; None where no robot of any run is at fault."""
        active = (self.starts <= time + 1e-9) & (time + 1e-9 < self.ends)
        if not active.any():
            return None
        runs, n = len(self.starts), self.robots
        at_fault = {kind: np.zeros((runs, n), dtype=bool) for kind in FAULTS}
        cut = np.zeros((runs, n, n), dtype=bool)
        for f, now in zip(self.faults, active.T, strict=True):
            i = f.robot - 1
            if f.other is not None:
                cut[:, i, f.other - 1] |= now
                cut[:, f.other - 1, i] |= now
                continue
            at_fault[f.kind][:, i] |= now
            if f.kind != "stall":
                cut[:, i, :] |= now[:, None]
                cut[:, :, i] |= now[:, None]
        code = np.zeros((runs, n), dtype=int)
        for kind in reversed(FAULTS):
            code[at_fault[kind]] = FAULTS[kind]
        return Condition(at_fault["failure"] | at_fault["stall"], at_fault["delay"], cut, code)


class _Flight(NamedTuple):
    sent: int  # period
    first: int  # period before which none of it is heard
    last: int  # period after which none of it is
    values: np.ndarray  # (fields, runs, robots)
    arrives: np.ndarray  # (runs, receivers, senders) int32: the period in which it is heard; -1 never


class Air(NamedTuple):
    """What was heard so far, and what is on its way."""

    values: np.ndarray  # (fields, runs, receivers, senders): heard last
    born: np.ndarray  # (runs, receivers, senders) int32: the period in which that was sent, -1 before the first
    flying: tuple[_Flight, ...]  # oldest first
    bad: np.ndarray  # (runs, receivers, senders) bool: links in a burst of losses


@dataclass(frozen=True)
class Channel:
    """The radio of one simulation; its state is an :class:`Air`."""

    radio: Radio
    graph: np.ndarray  # (robots, robots) bool
    tick: float  # s, the control period
    every: int  # periods from message to message
    draws: Iterator[np.ndarray] | None  # uniform numbers (streams, runs, receivers, senders), message by message

    @classmethod
    def opened(cls, radio: Radio, robots: int, seeds: Sequence[int], tick: float) -> "Channel":
        """The channel of ``robots`` robots in the runs of ``seeds``. Raises RadioError."""
        streams = sum((radio.loss > 0 or radio.burst_start > 0, radio.burst_start > 0, radio.jitter > 0))
        draws = _uniform(seeds, streams, robots) if streams else None
        every = max(1, round(radio.period / tick))
        return cls(radio, radio.adjacency(robots).astype(bool), tick, every, draws)

    def init(self, fields: int, runs: int) -> Air:
        """Silence, for messages of so many values. Raises RadioError where they do not fit."""
        robots = len(self.graph)
        self.radio.check_bandwidth(robots, fields)
        shape = (runs, robots, robots)
        return Air(np.full((fields, *shape), np.nan), np.full(shape, -1, np.int32), (), np.zeros(shape, dtype=bool))

    def hear(self, air: Air, k: int, condition: Condition | None) -> tuple[Heard, Air]:
        """What every robot knows of the others in period ``k``."""
        values, born = air.values, air.born
        landing = [flight for flight in air.flying if flight.first <= k <= flight.last]
        cut = _NO_CUT if condition is None else condition.cut
        for flight in landing:
            values, born = _land(values, born, flight.values, flight.arrives, cut, flight.sent, k)
        flying = tuple(flight for flight in air.flying if flight.last > k)
        return Heard(values, _ages(born, k, self.tick), self.graph), Air(values, born, flying, air.bad)

    def send(
        self, air: Air, k: int, values: np.ndarray, x: np.ndarray, y: np.ndarray, condition: Condition | None
    ) -> Air:
        """Broadcast ``values`` (fields, runs, robots) in period ``k``, from ``x``, ``y`` (runs, robots) [m]."""
        if k % self.every:
            return air
        radio, bad = self.radio, air.bad
        passes = np.broadcast_to(self.graph, bad.shape)
        if radio.range is not None:
            passes = passes & _within(np.ascontiguousarray(x), np.ascontiguousarray(y), radio.range)
        if condition is not None:
            passes = passes & ~condition.cut
        draws = iter(()) if self.draws is None else iter(next(self.draws))
        if radio.loss > 0 or radio.burst_start > 0:
            lost, chance = next(draws), np.asarray(radio.loss)
            if radio.burst_start > 0:
                turn = next(draws)
                bad = np.where(bad, turn >= radio.burst_end, turn < radio.burst_start)
                chance = np.where(bad, max(radio.burst_loss, radio.loss), radio.loss)
            passes = passes & (lost >= chance)
        arrives: Any = np.int32(k + self._periods(radio.latency))
        if radio.jitter > 0:
            arrives = (k + self._periods(radio.latency + radio.jitter * next(draws))).astype(np.int32)
        arrives = np.where(passes, arrives, np.int32(-1))
        said = np.array(values, dtype=float, order="C")
        first, last = (k + int(self._periods(late)) for late in (radio.latency, radio.latency + radio.jitter))
        return air._replace(flying=(*air.flying, _Flight(k, first, last, said, arrives)), bad=bad)

    def _periods(self, late: Any) -> Any:
        """After how many control periods a message is heard that takes ``late`` [s]."""
        return np.maximum(1.0, np.ceil(late / self.tick - 1e-9))


def _uniform(seeds: Sequence[int], streams: int, robots: int) -> Iterator[np.ndarray]:
    """Uniform numbers (streams, runs, robots, robots), message by message; each run draws from its own generator."""
    generators = [np.random.default_rng([seed, RADIO_STREAM]) for seed in seeds]
    size = streams * robots * robots
    count = max(1, min(256, _BLOCK // (size * len(generators))))
    draws = np.empty((len(generators), count, streams, robots, robots))
    while True:
        for generator, rows in zip(generators, draws, strict=True):
            generator.random(out=rows)
        yield from np.moveaxis(draws, 0, 2)


@njit(cache=True, error_model="numpy")
def _land(values, born, said, arrives, cut, sent, k):  # type: ignore[no-untyped-def]
    """``values`` and ``born`` after what arrives of one flight in period ``k``, where nothing newer was heard."""
    fields, runs, robots, _ = values.shape
    heard, when = np.empty_like(values), np.empty_like(born)
    new = np.empty(robots, np.bool_)
    for r in range(runs):
        for i in range(robots):
            for j in range(robots):
                new[j] = arrives[r, i, j] == k and sent > born[r, i, j]
                if cut.size and cut[r, i, j]:
                    new[j] = False
                when[r, i, j] = sent if new[j] else born[r, i, j]
            for f in range(fields):
                for j in range(robots):
                    heard[f, r, i, j] = said[f, r, j] if new[j] else values[f, r, i, j]
    return heard, when


@njit(cache=True, error_model="numpy")
def _ages(born, k, tick):  # type: ignore[no-untyped-def]
    age = np.empty(born.shape)
    for r in range(born.shape[0]):
        for i in range(born.shape[1]):
            for j in range(born.shape[2]):
                age[r, i, j] = (k - born[r, i, j]) * tick if born[r, i, j] >= 0 else np.inf
    return age


@njit(cache=True, error_model="numpy")
def _within(x, y, reach):  # type: ignore[no-untyped-def]
    """Who is within ``reach`` [m] of whom (runs, robots, robots)."""
    runs, robots = x.shape
    near = np.empty((runs, robots, robots), np.bool_)
    for r in range(runs):
        for i in range(robots):
            for j in range(robots):
                near[r, i, j] = (x[r, i] - x[r, j]) ** 2 + (y[r, i] - y[r, j]) ** 2 <= reach * reach
    return near
