"""How the cost of a simulation and of a team grows with the number of robots."""

from dataclasses import dataclass


@dataclass(frozen=True)
class Scaling:
    """The coordination of one team, of one size, on a radio that loses a share of its messages."""

    robots: int
    loss: float
    spread: float  # s
    late: float  # s: the arrival of the last after the time of the reference
    gap: float  # largest s_i − s_j
    step: float  # s between two samples: arrivals are known no better
