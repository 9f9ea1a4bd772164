"""The fuzzy team on arrays and its equation, both asked in the same situations."""

from dataclasses import dataclass, field
from typing import Any, NamedTuple

import numpy as np

from robotics.laws.law import Command, Law, Observation
from robotics.laws.rules.fuzzy_team import FuzzyTeam, InterpretedTeam
from robotics.laws.rules.situation import TEAM_MESSAGE
from robotics.laws.setting import Setting

NUMBERS = ("first", "second", "progress")


class BothMemory(NamedTuple):
    """Those of both."""

    arrays: Any
    equation: Any


@dataclass(frozen=True, kw_only=True, eq=False)
class BothTeams(Law[BothMemory]):
    """Drives by the form on arrays, and notes by how much the equation says something else."""

    team: FuzzyTeam = field(default_factory=FuzzyTeam)
    farthest: dict[str, float] = field(default_factory=dict)

    message = TEAM_MESSAGE
    looks = yields = True

    @property
    def needs(self) -> tuple[str, ...]:
        """Those of the team."""
        return self.team.needs

    def init(self, setting: Setting, runs: int) -> BothMemory:
        """Begin both."""
        assert self.team.has_equation
        return BothMemory(self.arrays.init(setting, runs), self.team.init(setting, runs))

    @property
    def arrays(self) -> InterpretedTeam:
        """The form on arrays."""
        return InterpretedTeam.of(self.team)

    def control(self, seen: Observation, memory: BothMemory, dt: float) -> tuple[Command, BothMemory]:
        """Ask both."""
        said, arrays = self.arrays.control(seen, memory.arrays, dt)
        own, equation = self.team.control(seen, memory.equation, dt)
        pairs = {name: (getattr(said, name), getattr(own, name)) for name in NUMBERS}
        pairs |= {f"target {n}": (a, getattr(own.target, n)) for n, a in said.target._asdict().items()}
        pairs |= {f"message {n}": (a, own.message[n]) for n, a in said.message.items()}
        if said.inputs is not None:
            pairs["inputs"] = said.inputs, own.inputs
        for name in ("mode", "guarded", "refused"):
            one, other = getattr(said, name), getattr(own, name)
            assert (one is None) == (other is None), name
            if one is not None:
                pairs[name] = one.astype(float), other.astype(float)
        for name, (one, other) in pairs.items():
            unlike = np.nanmax(np.abs(np.where(one == other, 0.0, one - other)), initial=0.0)
            unlike = np.inf if (np.isnan(one) != np.isnan(other)).any() else unlike
            self.farthest[name] = max(self.farthest.get(name, 0.0), float(unlike))
        return said._replace(inputs=None), BothMemory(arrays, equation)
