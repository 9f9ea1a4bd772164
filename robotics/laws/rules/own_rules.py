"""Any rule base drives: a law whose inputs are quantities that a robot can know, by their names in the ``.fis`` file.

The inputs are those of :mod:`robotics.laws.rules.quantities`; the outputs are one or more of ``RULE_OUTPUTS``.
What a rule base does not give, or one of pairs cannot give as nobody is heard, fuzzy tracking does: it drives to the
target ``look_ahead`` seconds from now. A rule base of v and w whose inputs are a tracking law's four, as Table 5.6, is
fuzzy tracking itself (:mod:`robotics.laws.tracking.fuzzy_tracking`).
"""

from collections.abc import Mapping
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import Any, NamedTuple

import numpy as np

from fuzzy.quantity import quantity
from fuzzy.system import Sugeno
from robotics.laws.law import Command, ControllerError, Observation
from robotics.laws.rules.evaluation import RuleBase
from robotics.laws.rules.situation import TEAM_MESSAGE, TURN_TIME, Fixed, Recall, Situation
from robotics.laws.setting import Setting
from robotics.laws.tracking.fuzzy_tracking import TRACKING_INPUTS, FuzzyTracking, load_rule_base

RULE_OUTPUTS = {  # each with its unit and meaning
    "v": "m/s: the speed itself",
    "w": "rad/s: the turn rate itself",
    "turn": f"rad, made in {TURN_TIME:g} s: added to the turn of fuzzy tracking underneath",
    "speed": "m/s, at most: fuzzy tracking underneath drives no faster",
    "speed_factor": "1: what the speed of fuzzy tracking underneath is multiplied by",
    "rate": "1, of the robot's copy of a clock that all share: 1 on time, 0 waits; the slowest copy holds",
    "keep": "1, the side of an obstacle to keep: 1 this one, -1 the other, 0 none; the robot remembers it",
}
_NEUTRAL = {"v": np.inf, "w": 0.0, "turn": 0.0, "speed": np.inf, "speed_factor": 1.0, "rate": 1.0, "keep": 0.0}
_MARGIN = 0.2  # m: between the turning circles of robots whose paths do not meet


def is_tracking(fis: Sugeno) -> bool:
    """Whether a rule base is one of fuzzy tracking: of a tracking law's inputs, with two outputs, v before w."""
    outputs = [v.name for v in fis.outputs]
    other = {*RULE_OUTPUTS} - {"v", "w"}
    ordered = len(outputs) == 2 and outputs[0] != "w" and outputs[1] != "v"
    return ordered and not other & {*outputs} and all(v.name in TRACKING_INPUTS for v in fis.inputs)


class _Memory(NamedTuple):
    fixed: Fixed
    recall: Recall


@dataclass(frozen=True, kw_only=True)
class OwnRules(FuzzyTracking):
    """A rule base of one's own, and fuzzy tracking for what it does not give."""

    leader: float = quantity(0.0, "1", least=0)  # the number of the robot that only tracks; 0: none
    own: RuleBase | None = field(init=False, repr=False, compare=False)  # none: fuzzy tracking itself

    tasks = MappingProxyType({**FuzzyTracking.tasks, "own": "rule_base"})

    def __post_init__(self) -> None:
        tracks = is_tracking(load_rule_base(self.rule_base))
        own = None if tracks else RuleBase.of(self.rule_base, RULE_OUTPUTS, "a rule base")
        object.__setattr__(self, "own", own)
        super().__post_init__()

    @property
    def tracking_rule_base(self) -> str | Sugeno:
        """The rule base by which it tracks."""
        return self.rule_base if self.own is None else "tracking"

    @property
    def idle(self) -> frozenset[str]:
        """The parameters that have no effect as the others are set."""
        return super().idle | ({"leader"} if self.own is None else frozenset())

    @property
    def has_equation(self) -> bool:  # type: ignore[override]
        """Whether it is fuzzy tracking alone."""
        return self.own is None

    @property
    def message(self) -> tuple[str, ...]:
        """Where the robots are, if the rule base asks for it."""
        asks = self.own is not None and (self.own.radio or "rate" in self.own.outputs)
        return TEAM_MESSAGE if asks else ()

    @property
    def needs(self) -> tuple[str, ...]:
        """The range sensors that the rule base names."""
        return () if self.own is None else self.own.sensors

    @property
    def looks(self) -> bool:
        """Whether the rule base asks for the room around the robot."""
        return self.own is not None and self.own.looks

    @property
    def fuzzy_systems(self) -> Mapping[str, Sugeno]:
        """The rule base, or those of tracking."""
        return super().fuzzy_systems if self.own is None else {"own": self.own.fis}

    def misgivings(self, setting: Setting) -> tuple[str, ...]:
        """Those of fuzzy tracking, where it alone drives."""
        return super().misgivings(setting) if self.own is None else ()

    def init(self, setting: Setting, runs: int) -> Any:
        """Look at the paths. Raises ControllerError where a rule base names a robot that does not exist."""
        if self.own is None:
            return super().init(setting, runs)
        self.own.check(setting, self.rule_base)
        if self.leader > len(setting.robots) or self.leader % 1:
            raise ControllerError(
                f"leader must be the number of a robot of {setting.name}, 1 to {len(setting.robots)}, or 0 for none; "
                f"got {self.leader:g}"
            )
        return _Memory(Fixed.of(setting, _MARGIN), Recall.start(setting, runs))

    @property
    def rule_bases(self) -> Mapping[str, RuleBase]:
        """The rule base, if it is not fuzzy tracking itself."""
        return {} if self.own is None else {"own": self.own}

    def situation(self, seen: Observation, memory: _Memory, dt: float) -> Situation:
        """All that the rule base can be told in a period; without an output ``rate`` the clock shows the time."""
        fixed, recall = memory
        assert self.own is not None
        if "rate" not in self.own.outputs:
            recall = recall._replace(clock=np.full_like(recall.clock, seen.time))
        target = seen.references.each_at(np.minimum(recall.clock + self.look_ahead, fixed.end))
        return Situation(seen, fixed, recall, dt, target)

    def control(self, seen: Observation, memory: Any, dt: float) -> tuple[Command, Any]:
        """Ask the rule base, and track for the rest."""
        if self.own is None:
            return super().control(seen, memory, dt)
        fixed, _ = memory
        now = self.situation(seen, memory, dt)
        target = now.target
        said, inputs = self.own.asked(now, _NEUTRAL)
        v, w, _ = self.toward(seen, target)
        # A rule base of pairs tells a robot that hears nobody nothing
        tracks = (np.arange(1, v.shape[1] + 1) == self.leader) | np.isnan(inputs).all(axis=0)
        wish_v = said.get("v", v * said.get("speed_factor", 1.0))
        wish_v = np.minimum(wish_v, said.get("speed", np.inf))
        # Who keeps a side turns away from the obstacle there, whichever it is.
        turn = said.get("turn", 0.0) * (now.way if "keep" in self.own.outputs else 1.0)
        wish_w = said.get("w", w) + turn / TURN_TIME
        v, w = np.where(tracks, v, wish_v), np.where(tracks, w, wish_w)
        pace = np.broadcast_to(said.get("rate", np.ones_like(v)), v.shape)
        zero = np.zeros_like(v)
        after = now.remembered(pace=pace, keep=said.get("keep", zero), yields=zero)
        message = now.message(after) if self.message else None
        progress = now.paths.share(now.place)
        return Command(v, w, v, w, message, target, progress, inputs=inputs), _Memory(fixed, after)
