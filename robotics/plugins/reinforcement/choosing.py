"""Which scenarios an environment drives, and which of them and which seed each episode has."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from robotics.plugins.arena.description import load_arena
from robotics.plugins.reinforcement.task import TaskError
from robotics.simulation.scenario.description import Scenario
from robotics.simulation.scenario.reading import load_scenario

LEARNING = 5_000_000  # the first number of scenarios drawn for learning: no arena tunes, chooses or tests on these
_EPISODE_STREAM = 7  # of a lane's seed: which scenarios and seeds its later episodes have
_FIRST_SEED, _LAST_SEED = 10_000_000, 2**31  # of later episodes: arenas use those below

Scenarios = str | Path | Scenario | Sequence[str | Path | Scenario]


def chosen_scenarios(
    scenario: Scenarios | None = None, arena: str | Path | None = None, draws: int = 16, first: int = LEARNING
) -> tuple[Scenario, ...]:
    """The scenarios of an environment.

    Args:
        scenario: A scenario, its name or its file; or several, of which each episode has one.
        arena: Instead of these an arena, its name or its file: scenarios are drawn from the sorts that it tunes on.
        draws: How many are drawn, sort after sort.
        first: The number of the first of them; the default is in no block of an arena.

    Raises TaskError, and ScenarioError or ArenaError for what cannot be read.
    """
    if scenario is not None and arena is not None:
        raise TaskError("an environment has scenarios of its own, or those of an arena; got both")
    if scenario is not None:
        several = [scenario] if isinstance(scenario, (str, Path, Scenario)) else list(scenario)
        return tuple(s if isinstance(s, Scenario) else load_scenario(s) for s in several)
    if type(draws) is not int or draws < 1:
        raise TaskError(f"draws must be a whole number >= 1; got {draws!r}")
    about = load_arena("default" if arena is None else arena)
    return tuple(about.tune[n % len(about.tune)].scenario(first + n, about.conditions) for n in range(draws))


class Chooser:
    """Which scenario and which seed the next episode of a lane has; everything follows from the lane's own seed."""

    def __init__(self, scenarios: int) -> None:
        """Choose among so many ``scenarios``."""
        self.scenarios = scenarios
        self.generator = np.random.default_rng()
        self.fresh: int | None = None

    def seed(self, seed: int) -> None:
        """Begin anew: the next episode has this seed itself."""
        self.generator = np.random.default_rng([seed, _EPISODE_STREAM])
        self.fresh = seed

    def next(self) -> tuple[int, int]:
        """The place of the next scenario, and the next seed."""
        scenario = int(self.generator.integers(self.scenarios))
        drawn = int(self.generator.integers(_FIRST_SEED, _LAST_SEED))
        seed, self.fresh = drawn if self.fresh is None else self.fresh, None
        return scenario, seed
