"""What is wrong in every run of a stress test: messages lost or late, and a robot that is held up."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from fuzzy.quantity import check_quantities, quantity
from robotics.laws.setting import Setting
from robotics.world.radio.description import Radio, RadioError
from robotics.world.radio.faults import Fault, Faults
from robotics.world.random_streams import FAULT_STREAM

_HELD = 2.0  # times the duration for which one robot is held up: so much longer a run may take


@dataclass(frozen=True, kw_only=True)
class Disturbance:
    """The disturbances that are the same in every run. Raises RadioError for numbers out of their ranges."""

    loss: float = quantity(0.0, "1", least=0, most=1, doc="Share of the messages that are lost.")
    latency: float = quantity(0.0, "s", least=0, most=10, doc="Latency of the messages.")
    freeze: float = quantity(
        0.0, "s", least=0, most=600, doc="How long one robot, drawn at random, is stopped at a random moment."
    )

    def __post_init__(self) -> None:
        check_quantities(self, RadioError)

    @property
    def radio(self) -> Radio:
        """The radio over which the robots talk."""
        return Radio(loss=self.loss, latency=self.latency)

    @property
    def extra(self) -> float:
        """The time [s] by which a run may take longer than an undisturbed one."""
        return _HELD * self.freeze

    def faults(self, ensemble: Setting, seeds: Sequence[int]) -> Faults | None:
        """The faults that hold up one robot of each run once, from a moment in the first 80 % of the nominal time.

        Args:
            ensemble: What is driven: one run for each seed.
            seeds: The seeds.

        None where no robot is held up.
        """
        if not self.freeze > 0:
            return None
        robots, durations = len(ensemble.robots), ensemble.references.ends[:, 0]
        stalls = tuple(Fault(robot=i + 1, kind="stall", duration=self.freeze) for i in range(robots))
        starts = np.full((len(seeds), robots), np.inf)
        for k, seed in enumerate(seeds):
            rng = np.random.default_rng([seed, FAULT_STREAM])
            starts[k, rng.integers(robots)] = rng.uniform(0.0, 0.8) * durations[k]
        return Faults(stalls, robots, starts, starts + self.freeze)


UNDISTURBED = Disturbance()
