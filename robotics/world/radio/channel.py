"""The radio of one simulation: messages on their way, and what each robot has heard.

The model, and the meaning of its numbers, is that of :mod:`robotics.world.radio.description`.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from fuzzy.compiled.columns import Bools2, Columns, Floats3, Floats5, Ints1, ShortInts2, ShortInts3, column, several
from fuzzy.compiled.jit import compiled_only, without_refcounts
from robotics.world.radio.description import Radio
from robotics.world.random_streams import RADIO_STREAM

_MOST_DRAWS = 2_000_000  # random numbers drawn at a time: bounds memory
_MESSAGES = 256  # drawn at a time, at most
BELIEVED = 0.5  # s for which a rate that was heard is believed; after that the value stays as predicted


class HeardColumns(Columns):
    """What one robot has heard of another; a law's own class adds the values of its message as ``said``."""

    age = column("s", "of the message; infinite: none was heard")
    hears = column("", "1: the graph lets it pass")


class AirColumns(HeardColumns):
    """The same with the values of any message."""

    values = several(0, "", "heard last; not-a-number before the first")


def predicted_arrays(value: np.ndarray, rate: np.ndarray, age: np.ndarray) -> np.ndarray:
    """What was heard, ``age`` [s] after it was sent, by its rate, which is believed for BELIEVED seconds."""
    return value + rate * np.minimum(age, BELIEVED)


predicted = compiled_only(predicted_arrays)  # the same, for one number in a compiled loop


@dataclass(frozen=True, eq=False)
class Heard:
    """The last message that each robot heard of each other robot.

    ``heard["x"]`` is a value as it was sent, ``heard.now("x", by="v_x")`` the same value predicted for now.

    Attributes:
        fields: The names of the values.
        values: (fields, runs, receivers, senders); not-a-number before the first message.
        age: (runs, receivers, senders) s since it was sent; infinite before the first.
        hears: (robots, robots) bool: the graph, receivers by senders.
    """

    fields: tuple[str, ...]
    values: np.ndarray
    age: np.ndarray
    hears: np.ndarray

    @classmethod
    def nothing(cls, runs: int, robots: int) -> "Heard":
        """What ``robots`` robots in each of ``runs`` runs hear whose law broadcasts nothing."""
        age = np.full((runs, robots, robots), np.inf)
        return cls((), np.empty((0, *age.shape)), age, np.zeros((robots, robots), dtype=bool))

    def __getitem__(self, name: str) -> np.ndarray:
        """The value ``name`` as it was sent (runs, receivers, senders)."""
        value: np.ndarray = self.values[self.fields.index(name)]
        return value

    def now(self, name: str, *, by: str) -> np.ndarray:
        """The present value (runs, receivers, senders) of ``name``, predicted by its rate, whose name is ``by``.

        A rate is believed for half a second. The value is not-a-number before the first message.
        """
        return predicted_arrays(self[name], self[by], self.age)


NOTHING = Heard.nothing(0, 0)


class Air(NamedTuple):
    """A radio as columns, for compiled functions; a lane is one robot of one run, here as the receiver."""

    values: int  # in a message; 0: nothing is said
    every: int  # control periods from message to message
    latency: float  # s
    jitter: float  # s
    loss: float  # 1
    burst_start: float  # 1
    burst_end: float  # 1
    burst_loss: float  # 1
    range: float  # m; infinite: none
    graph: Bools2  # (robots, robots)
    heard: Floats3  # (AirColumns, lanes, robots)
    born: ShortInts2  # (lanes, robots): the period in which that was sent; -1 before the first
    bad: Bools2  # (lanes, robots): links in a burst of losses
    said: Floats3  # (flights, values, lanes): messages on their way
    arrives: ShortInts3  # (flights, lanes, robots): the period in which each is heard; -1 never
    sent: Ints1  # (flights,): the period in which they were sent; -1: none
    draws: Floats5  # (messages, streams, runs, robots, robots): uniform numbers
    drawn: int  # the number of the first of these messages


@dataclass(frozen=True, eq=False)
class Channel:
    """The radio of one simulation: its state as columns, and the random numbers of each run."""

    radio: Radio
    fields: tuple[str, ...]  # the names of the values of a message
    tick: float  # s, the control period
    streams: int  # uniform numbers for each message of a link
    generators: tuple[np.random.Generator, ...]  # one for each run

    @classmethod
    def opened(cls, radio: Radio, fields: Sequence[str], robots: int, seeds: Sequence[int], tick: float) -> "Channel":
        """Open the channel of a simulation. Raises RadioError where the messages of a period do not fit.

        Args:
            radio: Its description.
            fields: The names of the values of a message; none: nothing is said.
            robots: The number of robots.
            seeds: One for each run.
            tick: The control period [s].
        """
        streams = sum((radio.loss > 0 or radio.burst_start > 0, radio.burst_start > 0, radio.jitter > 0))
        if fields:
            radio.check_bandwidth(robots, len(fields))
        generators = tuple(np.random.default_rng([seed, RADIO_STREAM]) for seed in seeds if streams and fields)
        return cls(radio, tuple(fields), tick, streams, generators)

    def silence(self, runs: int, robots: int) -> Air:
        """The state at the start of ``runs`` runs. Raises RadioError where the graph names an unknown robot."""
        radio, lanes, values = self.radio, runs * robots, len(self.fields)
        graph = radio.adjacency(robots).astype(bool) if values else np.zeros((robots, robots), dtype=bool)
        every = max(1, round(radio.period / self.tick))
        longest = max(1, math.ceil((radio.latency + radio.jitter) / self.tick - 1e-9))
        flights = -(-longest // every) if values else 0
        heard = np.full((AirColumns.size + values, lanes, robots), np.nan)
        planes = AirColumns(heard)
        planes.age, planes.hears = np.inf, np.tile(graph, (runs, 1))
        return Air(
            values,
            every,
            float(radio.latency),
            float(radio.jitter),
            float(radio.loss),
            float(radio.burst_start),
            float(radio.burst_end),
            float(radio.burst_loss),
            np.inf if radio.range is None else float(radio.range),
            graph,
            heard,
            np.full((lanes, robots), -1, np.int32),
            np.zeros((lanes, robots), dtype=bool),
            np.zeros((flights, values, lanes)),
            np.full((flights, lanes, robots), -1, np.int32),
            np.full(flights, -1),
            np.empty((0, 0, 0, 0, 0)),
            0,
        )

    def supplied(self, air: Air, k: int) -> Air:
        """The same with the random numbers that the message of period ``k`` needs, and of some after it."""
        message = k // air.every
        if not self.generators or air.drawn <= message < air.drawn + len(air.draws):
            return air
        robots = len(air.graph)
        size = self.streams * robots * robots
        count = max(1, min(_MESSAGES, _MOST_DRAWS // (size * len(self.generators))))
        draws = np.empty((len(self.generators), count, self.streams, robots, robots))
        for generator, rows in zip(self.generators, draws, strict=True):
            generator.random(out=rows)
        return air._replace(draws=np.ascontiguousarray(np.moveaxis(draws, 0, 2)), drawn=message)

    def heard(self, air: Air) -> Heard:
        """What every robot knows of the others."""
        robots = len(air.graph)
        planes = AirColumns(air.heard.reshape(len(air.heard), -1, robots, robots))
        return Heard(self.fields, planes.values, planes.age, air.graph)


@without_refcounts
def receive(air, k, tick, cut):  # type: ignore[no-untyped-def]
    """Take from the air what arrives in period ``k``, where nothing newer was heard and the link is not ``cut``."""
    heard, born, robots = AirColumns(air.heard), air.born, len(air.graph)
    for flight in range(len(air.sent)):
        sent = air.sent[flight]
        if sent < 0:
            continue
        for first in range(0, born.shape[0], robots):
            for i in range(first, first + robots):
                for j in range(robots):
                    if air.arrives[flight, i, j] == k and sent > born[i, j] and not cut[i, j]:
                        born[i, j] = sent
                        for f in range(air.values):
                            heard.values[f, i, j] = air.said[flight, f, first + j]
    for i in range(born.shape[0]):
        for j in range(robots):
            heard.age[i, j] = (k - born[i, j]) * tick if born[i, j] >= 0 else np.inf


@without_refcounts
def broadcast(air, k, tick, cut, values, x, y):  # type: ignore[no-untyped-def]
    """Send the messages of all robots in period ``k``, if it is time for one.

    A message is made of the first ``values`` (rows, lanes); ``x`` and ``y`` (lanes,) [m] are where the robots are.
    """
    if air.values == 0 or k % air.every != 0:
        return
    message, robots = k // air.every, len(air.graph)
    flight = message % len(air.sent)
    air.sent[flight] = k
    for f in range(air.values):
        for i in range(len(x)):
            air.said[flight, f, i] = values[f, i]
    for run in range(len(x) // robots):
        for receiver in range(robots):
            i = run * robots + receiver
            for j in range(robots):
                dx, dy = x[i] - x[run * robots + j], y[i] - y[run * robots + j]
                passes = air.graph[receiver, j] and dx * dx + dy * dy <= air.range * air.range and not cut[i, j]
                late = _lateness(air, message - air.drawn, run, receiver, j, i)
                periods = max(1.0, math.ceil(late / tick - 1e-9)) if passes and late < np.inf else 0.0
                air.arrives[flight, i, j] = np.int32(k + periods) if periods > 0 else np.int32(-1)


@compiled_only
def _lateness(air, place, run, receiver, sender, lane):  # type: ignore[no-untyped-def]
    """How late [s] a message arrives by chance; infinite: it is lost. Bursts go on whether it passes or not."""
    stream, late = 0, air.latency
    if air.loss > 0 or air.burst_start > 0:
        lost, chance = air.draws[place, 0, run, receiver, sender], air.loss
        stream = 1
        if air.burst_start > 0:
            turn, bad = air.draws[place, 1, run, receiver, sender], air.bad[lane, sender]
            stream = 2
            bad = turn >= air.burst_end if bad else turn < air.burst_start
            air.bad[lane, sender] = bad
            chance = max(air.burst_loss, air.loss) if bad else air.loss
        if lost < chance:
            return np.inf
    if air.jitter > 0:
        late += air.jitter * air.draws[place, stream, run, receiver, sender]
    return late
