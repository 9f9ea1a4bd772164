"""How a policy is learnt, and on which scenarios; :mod:`robotics.plugins.reinforcement.training` does it."""

from dataclasses import dataclass
from pathlib import Path

from fuzzy.quantity import check_quantities, quantity, whole
from robotics.plugins.reinforcement.choosing import LEARNING, chosen_scenarios
from robotics.plugins.reinforcement.task import TaskError
from robotics.simulation.scenario.description import Scenario

VALIDATION = 6_000_000  # the first number of the scenarios, and of the seeds, by which policies are chosen among
_OWN = Path(__file__).parent / "learning.toml"  # what the packaged policy learns on


@dataclass(frozen=True, kw_only=True)
class Learning:
    """How a policy is learnt. Raises TaskError for numbers that cannot be."""

    steps: int = whole(3_000_000, least=1, most=10**10, doc="Control periods that are driven, of all lanes together.")
    lanes: int = whole(512, least=1, most=100_000, doc="Robots that drive at a time.")
    rollout: int = whole(32, least=2, most=10_000, doc="Periods between two updates.")
    batch: int = whole(2048, least=2, doc="Samples of a gradient.")
    epochs: int = whole(5, least=1, most=1000, doc="How often an update sees each sample.")
    rate: float = quantity(1e-3, "1", above=0, doc="The learning rate at the start; it falls linearly to a 20th.")
    discount: float = quantity(0.95, "1", above=0, most=0.9999, doc="What a reward counts one period later.")
    spread: float = quantity(0.37, "1", above=0, doc="The standard deviation of the actions at the start.")
    units: int = whole(32, least=1, most=4096, doc="Units of each of the two hidden layers.")
    divergence: float = quantity(0.3, "m", above=0, doc="An episode ends so far beyond the farthest start.")

    def __post_init__(self) -> None:
        check_quantities(self, TaskError)


def learning_scenarios(arena: str | Path | None = None, draws: int = 96) -> tuple[Scenario, ...]:
    """Scenarios to learn on: drawn from the sorts that an arena tunes on, by default those of the packaged policy."""
    return chosen_scenarios(None, arena or _OWN, draws, LEARNING)


def validation_scenarios(arena: str | Path | None = None, draws: int = 12) -> tuple[Scenario, ...]:
    """Others of the same sorts, to choose by."""
    return chosen_scenarios(None, arena or _OWN, draws, VALIDATION)
