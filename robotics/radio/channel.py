"""The radio of one simulation: messages on their way, and what each robot has heard.

The model, and the meaning of its numbers, is that of :mod:`robotics.radio.description`.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from fuzzy.compiled.jit import kernel
from robotics.radio.description import Radio
from robotics.radio.faults import Condition
from robotics.random_streams import RADIO_STREAM

_BLOCK = 2_000_000  # random numbers drawn at a time: bounds memory
_NO_CUT = np.zeros((0, 0, 0), dtype=bool)
BELIEVED = 0.5  # s for which a rate that was heard is believed; after that the value stays as predicted


@dataclass(frozen=True, eq=False)
class Heard:
    """The last message that each robot heard of each other robot.

    ``heard["x"]`` is a value as it was sent, ``heard.now("x", by="v_x")`` the same value predicted for now.
    """

    fields: tuple[str, ...]  # the names of the values
    values: np.ndarray  # (fields, runs, receivers, senders); not-a-number before the first message
    age: np.ndarray  # (runs, receivers, senders) s since it was sent; infinite before the first
    hears: np.ndarray  # (robots, robots) bool: the graph

    @classmethod
    def nothing(cls, runs: int, robots: int) -> "Heard":
        """Make what robots hear whose law broadcasts nothing."""
        age = np.full((runs, robots, robots), np.inf)
        return cls((), np.empty((0, *age.shape)), age, np.zeros((robots, robots), dtype=bool))

    def __getitem__(self, name: str) -> np.ndarray:
        """The value ``name`` as it was sent (runs, receivers, senders)."""
        value: np.ndarray = self.values[self.fields.index(name)]
        return value

    def now(self, name: str, *, by: str) -> np.ndarray:
        """Predict the present value ``name`` (runs, receivers, senders), which changes at the rate ``by``.

        A rate is believed for BELIEVED seconds. The value is not-a-number before the first message.
        """
        return np.asarray(_predicted(self[name], self[by], self.age, BELIEVED))


NOTHING = Heard.nothing(0, 0)


class _Flight(NamedTuple):
    """One broadcast of all robots, on its way."""

    sent: int  # period
    first: int  # period before which none of it is heard
    last: int  # period after which none of it is
    values: np.ndarray  # (fields, runs, robots)
    arrives: np.ndarray  # (runs, receivers, senders) int32: the period in which it is heard; -1 never


class Air(NamedTuple):
    """The state of a channel: the messages heard last, and those on their way."""

    values: np.ndarray  # (fields, runs, receivers, senders): heard last
    born: np.ndarray  # (runs, receivers, senders) int32: the period in which that was sent, -1 before the first
    flying: tuple[_Flight, ...]  # oldest first
    bad: np.ndarray  # (runs, receivers, senders) bool: links in a burst of losses


@dataclass(frozen=True)
class Channel:
    """The radio of one simulation; its state is an :class:`Air`."""

    radio: Radio
    fields: tuple[str, ...]  # the names of the values of a message
    graph: np.ndarray  # (robots, robots) bool
    tick: float  # s, the control period
    every: int  # periods from message to message
    draws: Iterator[np.ndarray] | None  # uniform numbers (streams, runs, receivers, senders), message by message

    @classmethod
    def opened(cls, radio: Radio, fields: Sequence[str], robots: int, seeds: Sequence[int], tick: float) -> "Channel":
        """Open the channel of a simulation. Raises RadioError where the graph names a robot that does not exist.

        Args:
            radio: Its description.
            fields: The names of the values of a message.
            robots: The number of robots.
            seeds: One for each run.
            tick: The control period [s].
        """
        streams = sum((radio.loss > 0 or radio.burst_start > 0, radio.burst_start > 0, radio.jitter > 0))
        draws = _uniform(seeds, streams, robots) if streams else None
        every = max(1, round(radio.period / tick))
        return cls(radio, tuple(fields), radio.adjacency(robots).astype(bool), tick, every, draws)

    def init(self, runs: int) -> Air:
        """Begin ``runs`` runs in silence. Raises RadioError where the messages of a period do not fit."""
        robots = len(self.graph)
        self.radio.check_bandwidth(robots, len(self.fields))
        shape = (runs, robots, robots)
        return Air(
            np.full((len(self.fields), *shape), np.nan), np.full(shape, -1, np.int32), (), np.zeros(shape, dtype=bool)
        )

    def hear(self, air: Air, k: int, condition: Condition | None) -> tuple[Heard, Air]:
        """Return what every robot knows of the others in period ``k``, and the state after it."""
        values, born = air.values, air.born
        landing = [flight for flight in air.flying if flight.first <= k <= flight.last]
        cut = _NO_CUT if condition is None else condition.cut
        for flight in landing:
            values, born = _land(values, born, flight.values, flight.arrives, cut, flight.sent, k)
        flying = tuple(flight for flight in air.flying if flight.last > k)
        return Heard(self.fields, values, _ages(born, k, self.tick), self.graph), Air(values, born, flying, air.bad)

    def send(
        self,
        air: Air,
        k: int,
        message: Mapping[str, np.ndarray],
        x: np.ndarray,
        y: np.ndarray,
        condition: Condition | None,
    ) -> Air:
        """Broadcast a message of each robot, and return the state after it.

        Args:
            air: The state.
            k: The control period.
            message: The values by name, (runs, robots) each.
            x: The robots' true x (runs, robots) [m].
            y: The robots' true y (runs, robots) [m].
            condition: The faults of this period; None where no robot is at fault.
        """
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
        said = np.empty((len(self.fields), *bad.shape[:2]))
        for row, name in zip(said, self.fields, strict=True):
            row[...] = message[name]
        first, last = (k + int(self._periods(late)) for late in (radio.latency, radio.latency + radio.jitter))
        return air._replace(flying=(*air.flying, _Flight(k, first, last, said, arrives)), bad=bad)

    def _periods(self, late: Any) -> Any:
        """The number of control periods after which a message that takes ``late`` [s] is heard."""
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


@kernel
def _predicted(values, rates, age, longest):  # type: ignore[no-untyped-def]
    out = np.empty(values.shape)
    for r in range(values.shape[0]):
        for i in range(values.shape[1]):
            for j in range(values.shape[2]):
                out[r, i, j] = values[r, i, j] + rates[r, i, j] * min(age[r, i, j], longest)
    return out


@kernel
def _land(values, born, said, arrives, cut, sent, k):  # type: ignore[no-untyped-def]
    """``values`` and ``born`` after the arrivals of one flight in period ``k``, where nothing newer was heard."""
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


@kernel
def _ages(born, k, tick):  # type: ignore[no-untyped-def]
    age = np.empty(born.shape)
    for r in range(born.shape[0]):
        for i in range(born.shape[1]):
            for j in range(born.shape[2]):
                age[r, i, j] = (k - born[r, i, j]) * tick if born[r, i, j] >= 0 else np.inf
    return age


@kernel
def _within(x, y, reach):  # type: ignore[no-untyped-def]
    """Whether two robots are within ``reach`` [m] of each other (runs, robots, robots) bool."""
    runs, robots = x.shape
    near = np.empty((runs, robots, robots), np.bool_)
    for r in range(runs):
        for i in range(robots):
            for j in range(robots):
                near[r, i, j] = (x[r, i] - x[r, j]) ** 2 + (y[r, i] - y[r, j]) ** 2 <= reach * reach
    return near
