"""The description of a radio: who hears whom, how late, and what is lost.

Every ``period`` each robot broadcasts its law's message. A message reaches a robot that the graph (and the
range) lets hear it after ``latency`` and up to ``jitter`` more, unless it is lost: each with the probability
``loss``, or in bursts by the model of Gilbert and Elliott [Gilbert 1960, Elliott 1963]: a link goes bad with the
probability ``burst_start`` a message, good again with ``burst_end``, and loses ``burst_loss`` of them meanwhile.
A message that is heard is at least one control period old, since all robots decide at the same time.

Baud rates count ten bits a byte, on one shared channel: all messages of a period must fit.
"""

from collections.abc import Iterable
from dataclasses import dataclass
from math import ceil
from typing import Any, Literal

import numpy as np

from fuzzy.errors import InputError
from fuzzy.quantity import check_quantities, described, part, quantity, whole
from robotics.world.radio.graph import GRAPHS, adjacency

RADIO_PRESETS: dict[str, dict[str, Any]] = {
    # Thesis 4.5: ZigBee modules at 9600 baud. Frame overhead: transmit request with a 16-bit address (assumed).
    "zigbee-9600": {"baud": 9600.0, "header_bytes": 9, "value_bytes": 2, "period": 0.1, "latency": 0.03},
}


class RadioError(InputError):
    """A radio or a fault that cannot be. The message names the field and what is accepted."""


@dataclass(frozen=True, kw_only=True)
class Radio:
    """The radio of a team.

    Raises:
        RadioError: Fields that do not suit each other.
    """

    graph: Literal["star", "ring", "line", "complete", "edges"] = described(
        "Who hears whom: everybody (complete), the neighbours in a ring or a line, the hub of a star, or given edges.",
        "complete",
    )
    hub: int = whole(1, least=1, doc="The robot at the center of a star, counted from 1.")
    edges: tuple[tuple[int, int], ...] = described(
        'The pairs [sender, receiver] of graph = "edges", robots counted from 1.', (), example=[[1, 2], [2, 1]]
    )
    range: float | None = quantity(
        None,
        "m",
        above=0,
        doc="The distance between centers beyond which nothing is heard; left out: none.",
        example=5.0,
    )
    period: float = quantity(
        0.05, "s", above=0, most=60, doc="The time from message to message, a multiple of the scenario's period."
    )
    latency: float = quantity(0.0, "s", least=0, most=10, doc="How late a message arrives.")
    jitter: float = quantity(
        0.0, "s", least=0, most=10, doc="How much later than that it may arrive, drawn evenly for each message."
    )
    loss: float = part(0.0, doc="The probability with which a message is lost, independently of others.")
    burst_start: float = part(0.0, doc="The probability, a message, with which a good link becomes a bad one.")
    burst_end: float = quantity(
        0.2, "1", above=0, most=1, doc="The probability, a message, with which a bad link becomes a good one."
    )
    burst_loss: float = part(1.0, doc="The probability with which a bad link loses a message, if it is more than loss.")
    baud: float | None = quantity(
        None,
        "baud",
        above=0,
        doc="The speed of the one shared channel, at ten bits a byte; left out: unlimited.",
        example=57600.0,
    )
    header_bytes: int = whole(0, least=0, doc="The bytes of a message without its values.")
    value_bytes: int = whole(2, least=1, doc="The bytes of a value in a message.")

    def __post_init__(self) -> None:
        check_quantities(self, RadioError)
        expect_one_of(GRAPHS, "graph", self.graph)
        if (self.graph == "edges") != bool(self.edges):
            what = 'edges = [[sender, receiver], ...] belong to graph = "edges", and only to it'
            raise RadioError(what).about("edges")
        for sender, receiver in self.edges:
            if sender == receiver:
                raise RadioError(f"edges: robot {sender} needs no radio to hear itself").about("edges")

    def adjacency(self, robots: int) -> np.ndarray:
        """The graph's adjacency matrix (robots, robots), for a number of ``robots``.

        Raises:
            RadioError: It names an unknown robot.
        """
        for name, values in (("hub", [self.hub]), ("edges", [i for edge in self.edges for i in edge])):
            for i in values:
                if not 1 <= i <= robots:
                    raise RadioError(f"{name}: robots are 1 to {robots}, got {i}").about(name)
        return adjacency(self.graph, robots, self.hub, self.edges)

    def check_bandwidth(self, robots: int, values: int) -> None:
        """Raise RadioError unless ``robots`` messages of ``values`` values each fit into a period."""
        if self.baud is None or values == 0:
            return
        need = robots * (self.header_bytes + self.value_bytes * values)
        room = self.baud / 10 * self.period
        if need > room + 1e-9:
            raise RadioError(
                f"{robots} robots × ({self.header_bytes} + {values} × {self.value_bytes}) bytes = {need} bytes "
                f"every {self.period:g} s do not fit into the {room:g} that {self.baud:g} baud carry; "
                f"period must be >= {ceil(need / self.baud * 1000) / 100:g} s"
            ).about("period")


def expect_one_of(names: Iterable[str], name: str, value: Any) -> None:
    """Raise RadioError, about the field ``name``, unless ``value`` is one of ``names``."""
    if value not in names:
        raise RadioError(f"{name} must be one of {', '.join(map(repr, names))}; got {value!r}").about(name)
