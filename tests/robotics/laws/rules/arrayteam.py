"""The fuzzy team, or a rule base of one's own, on arrays and its equation, both asked in the same situations."""

from dataclasses import dataclass, field
from typing import Any, NamedTuple

import numpy as np

from robotics.laws.law import Command, Law, Observation
from robotics.laws.rules.formation_networks import RobotNetworks
from robotics.laws.rules.fuzzy_team import FuzzyTeam
from robotics.laws.rules.own_rules import OwnRules
from robotics.laws.setting import Setting
from tests.robotics.laws.rules.arrayform.formation import InterpretedNetworks
from tests.robotics.laws.rules.arrayform.laws import InterpretedRules, InterpretedTeam

NUMBERS = ("first", "second", "progress")


class BothMemory(NamedTuple):
    """Those of both."""

    arrays: Any
    equation: Any


@dataclass(frozen=True, kw_only=True, eq=False)
class BothTeams(Law[BothMemory]):
    """Drives by the form on arrays, and notes by how much the equation says something else."""

    team: FuzzyTeam | OwnRules | RobotNetworks = field(default_factory=FuzzyTeam)
    farthest: dict[str, float] = field(default_factory=dict)

    looks = yields = True

    @property
    def message(self) -> tuple[str, ...]:
        """That of the team."""
        return self.team.message

    @property
    def needs(self) -> tuple[str, ...]:
        """Those of the team."""
        return self.team.needs

    def init(self, setting: Setting, runs: int) -> BothMemory:
        """Begin both."""
        return BothMemory(self.arrays.init(setting, runs), self.team.init(setting, runs))

    @property
    def arrays(self) -> InterpretedTeam | InterpretedRules | InterpretedNetworks:
        """The form on arrays."""
        if isinstance(self.team, RobotNetworks):
            return InterpretedNetworks(networks=self.team.networks)
        return InterpretedTeam.of(self.team) if isinstance(self.team, FuzzyTeam) else InterpretedRules.of(self.team)

    def control(self, seen: Observation, memory: BothMemory, dt: float) -> tuple[Command, BothMemory]:
        """Ask both."""
        said, arrays = self.arrays.control(seen, memory.arrays, dt)
        own, equation = self.team.control(seen, memory.equation, dt)
        pairs = {name: (getattr(said, name), getattr(own, name)) for name in NUMBERS}
        pairs |= {f"target {n}": (a, getattr(own.target, n)) for n, a in said.target._asdict().items()}
        pairs |= {f"message {n}": (a, own.message[n]) for n, a in (said.message or {}).items()}
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
