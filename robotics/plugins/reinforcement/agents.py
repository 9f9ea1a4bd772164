"""The law of robots that somebody else drives: what the simulator is told of them."""

from dataclasses import dataclass

from robotics.laws.equation import RobotColumns
from robotics.laws.law import Command, Law, Observation
from robotics.laws.setting import Setting
from robotics.world.vehicle.plant import Level

BROADCAST = RobotColumns.leaves()  # what every robot broadcasts


@dataclass(frozen=True)
class Agents(Law[None]):
    """The law of robots that somebody else drives; each broadcasts where it is, and how fast, as it knows it."""

    at: Level = "velocity"
    sees: bool = False
    message = BROADCAST

    @property
    def level(self) -> Level:
        """What the agents command."""
        return self.at

    @property
    def looks(self) -> bool:
        """Whether the robots carry range sensors among obstacles."""
        return self.sees

    def init(self, setting: Setting, runs: int) -> None:
        """It remembers nothing."""

    def control(self, seen: Observation, memory: None, dt: float) -> tuple[Command, None]:
        """Nobody asks it."""
        raise NotImplementedError
