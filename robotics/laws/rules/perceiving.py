"""The base of laws that perceive: what their robots broadcast, remember, look with and know before the start."""

from collections.abc import Mapping
from typing import ClassVar

import numpy as np

from fuzzy.compiled.columns import Columns
from robotics.laws.equation import EquationLaw
from robotics.laws.rules.evaluation import RuleBase
from robotics.laws.rules.perception import OtherColumns, TeamMessage, asking
from robotics.laws.rules.situation import RecallColumns, recall_at_start, team_rows
from robotics.laws.setting import Setting
from robotics.world.sensing.carried import sensor_names

MEETING_MARGIN = 0.2  # m: between the turning circles of robots whose paths do not meet


class Perceiving(EquationLaw):
    """A law by rule bases of named quantities, whose equation finds these out: robotics.laws.rules.perception."""

    says: ClassVar[type[Columns]] = TeamMessage
    remembers: ClassVar[type[Columns]] = RecallColumns
    aims = progresses = True
    margin: float = MEETING_MARGIN

    @property
    def rule_bases(self) -> Mapping[str, RuleBase]:
        """The rule bases of named inputs, by their tasks."""
        return {}

    @property
    def needs(self) -> tuple[str, ...]:
        """The range sensors that the rule bases name."""
        return tuple(dict.fromkeys(name for base in self.rule_bases.values() for name in base.sensors))

    @property
    def looks(self) -> bool:
        """Whether a rule base asks for the room around the robot."""
        return any(base.looks for base in self.rule_bases.values())

    def reads(self, setting: Setting) -> tuple[str, ...]:
        """All sensors that robots carry, where it looks."""
        return sensor_names(setting.sensors) if self.looks else ()

    def wanted(self, setting: Setting, ahead: float = 0.0) -> dict[str, float]:
        """What its rule bases ask for, as WantedColumns; its target is the reference ``ahead`` [s] of what is due."""
        names = {v.name for base in self.rule_bases.values() for v in base.fis.inputs}
        return asking(names, setting.period, self.working - self.works.size, ahead)

    def working_for(self, robots: int, sensors: int) -> int:
        """Room for the sensors and for the other robots, too."""
        return self.working + sensors + robots * (1 + OtherColumns.size)

    def tables(self, setting: Setting) -> np.ndarray:
        """What the robots know before the start."""
        return team_rows(setting, self.margin, self.reads(setting))

    def begin(self, setting: Setting, runs: int) -> np.ndarray:
        """Nothing is remembered but where the robots are."""
        start = recall_at_start(setting, runs)
        return np.concatenate([start, np.zeros((self.remembers.size - len(start), *start.shape[1:]))])
