"""Any rule base drives: a law whose inputs are quantities that a robot can know, by their names in the ``.fis`` file.

The inputs are those of :mod:`robotics.laws.rules.quantities`; the outputs are one or more of ``RULE_OUTPUTS``.
What a rule base does not give, or one of pairs cannot give as nobody is heard, fuzzy tracking does: it drives to the
target ``look_ahead`` seconds from now. A rule base of v and w whose inputs are a tracking law's four, as Table 5.6, is
fuzzy tracking itself (:mod:`robotics.laws.tracking.fuzzy_tracking`). One that asks for nothing but the robot's own
motion, path and reference runs in compiled code (:mod:`robotics.laws.rules.of_reference`), as fuzzy tracking does.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, fields
from functools import cached_property
from types import MappingProxyType
from typing import Any, NamedTuple

import numpy as np

from fuzzy.compiled.columns import Columns, within
from fuzzy.compiled.packed import evaluate_packed
from fuzzy.quantity import quantity
from fuzzy.system import Sugeno
from robotics.laws.equation import KNOWLEDGE_FIELDS, equation
from robotics.laws.law import Command, ControllerError, Observation
from robotics.laws.rules.evaluation import RuleBase
from robotics.laws.rules.of_reference import (
    CORRECTIONS,
    HEADING_ERR,
    AskedColumns,
    AskingColumns,
    RecalledColumns,
    answered,
    asked_columns,
    is_of_reference,
    pick,
    see,
    see_path,
    tell_asked,
)
from robotics.laws.rules.situation import TEAM_MESSAGE, TURN_TIME, Fixed, Recall, Situation
from robotics.laws.setting import Setting
from robotics.laws.tracking.fuzzy_tracking import (
    TRACKING_INPUTS,
    FuzzyTracking,
    TrackingDerived,
    TrackingWork,
    load_rule_base,
    tell_inputs,
    toward,
)
from robotics.world.paths.posture import wrapped
from robotics.world.paths.road import moving

RULE_OUTPUTS = {  # each with its unit and meaning
    "v": "m/s: the speed itself",
    "w": "rad/s: the turn rate itself",
    "dv": "m/s: added to the reference's speed",
    "dw": "rad/s: added to the reference's turn rate",
    "bend": "1/m: a curvature, added to the reference's turn rate times the speed",
    "turn": f"rad, made in {TURN_TIME:g} s: added to the turn of fuzzy tracking underneath",
    "speed": "m/s, at most: fuzzy tracking underneath drives no faster",
    "speed_factor": "1: what the speed of fuzzy tracking underneath is multiplied by",
    "rate": "1, of the robot's copy of a clock that all share: 1 on time, 0 waits; the slowest copy holds",
    "keep": "1, the side of an obstacle to keep: 1 this one, -1 the other, 0 none; the robot remembers it",
}
_NEUTRAL = dict.fromkeys(RULE_OUTPUTS, 0.0) | {"v": np.inf, "speed": np.inf, "speed_factor": 1.0, "rate": 1.0}
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


class RulesDerived(TrackingDerived):
    """What the law makes of its rule bases."""

    ask = within(AskedColumns)


class RulesWork(Columns):
    """What the law works in."""

    own = within(AskingColumns)
    tracking = within(TrackingWork)


@equation
def drive_by_rules(robot, aim, gain, memory, command, work, time, road, path, rules):  # type: ignore[no-untyped-def]
    """Ask the rule base, and track for the rest."""
    ask, own, target = gain.ask, work.own, work.tracking.aim
    if ask.corrects == 1:
        target.x, target.y, target.heading, target.v, target.w = aim.x, aim.y, aim.heading, aim.v, aim.w
        v, w = 0.0, 0.0  # not asked for
    else:
        target.x, target.y, target.heading, target.v, target.w, target.s = moving(road, path, time + gain.look_ahead)
        v, w, _ = toward(robot, target, math.nan, 0.0, False, gain, rules, work.tracking)
    if ask.count == 0:
        tell_inputs(command.inputs, gain, work.tracking)
    else:
        if ask.on_path == 1:
            see_path(robot, time, memory, own, road, path)
        see(robot, target, time, ask, memory, own)
        for n in range(int(ask.count)):
            own.asked[n] = pick(n, ask, own, time, road, path)
        tell_asked(command.inputs, ask, own)
        evaluate_packed(rules[int(ask.begin) :], own.asked, own.said, work.tracking.rest)
        v, w = answered(own.said, ask, target, own.seen[HEADING_ERR], v, w, gain.catch_up)
        memory.v, memory.w = v, w
    command.first, command.second, command.wish_v, command.wish_w = v, w, v, w


@dataclass(frozen=True, kw_only=True)
class OwnRules(FuzzyTracking):
    """A rule base of one's own, and fuzzy tracking for what it does not give."""

    leader: float = quantity(0.0, "1", least=0)  # the number of the robot that only tracks; 0: none
    catch_up: float = quantity(0.3, "m/s", least=0)  # of a rule base that corrects: `bend` acts at this speed at rest
    own: RuleBase | None = field(init=False, repr=False, compare=False)  # none: fuzzy tracking itself

    tasks = MappingProxyType({**FuzzyTracking.tasks, "own": "rule_base"})
    equation = drive_by_rules
    derived, remembers, works = RulesDerived, RecalledColumns, RulesWork

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
        idle = super().idle | ({"leader"} if self.own is None or self.has_equation else frozenset())
        if not self.corrects:
            return idle | {"catch_up"}
        return idle | {"look_ahead", "steering_distance", "deadband", "steering", "lateral", "lateral_rule_base"}

    @property
    def corrects(self) -> bool:
        """Whether the rule base corrects the velocity of the reference."""
        return self.own is not None and bool(CORRECTIONS & {*self.own.outputs})

    @property
    def barred(self) -> Mapping[str, str]:
        """A rule base that corrects takes what laws of velocities take."""
        if self.corrects and self.has_equation:
            return {}
        return super().barred

    @property
    def has_equation(self) -> bool:  # type: ignore[override]
        """Whether it is fuzzy tracking alone, or asks for nothing that is not compiled."""
        return self.own is None or (is_of_reference(self.own.fis) and self.leader == 0)

    def derive(self, setting: Setting) -> Mapping[str, Any]:
        """What fuzzy tracking derives, and how the rule base is asked."""
        begin = sum(map(len, super().rule_rows()))
        nothing = {name: [0] * c.rows if c.width else 0 for name, c in AskedColumns.columns.items()}
        ask = nothing if self.own is None else asked_columns(self.own.fis, begin, setting.period)
        return {**super().derive(setting), "ask": ask}

    def rule_rows(self) -> Sequence[np.ndarray]:
        """The rule bases of tracking, and the own one."""
        return super().rule_rows() if self.own is None else (*super().rule_rows(), self.own.compiled.system)

    @cached_property
    def tracker(self) -> FuzzyTracking:
        """The fuzzy tracking underneath."""
        names = [f.name for f in fields(FuzzyTracking) if f.init and f.name not in KNOWLEDGE_FIELDS]
        own = {name: getattr(self, name) for name in names}
        return FuzzyTracking(**own | {"rule_base": self.tracking_rule_base})

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
        if self.has_equation:
            return super().init(setting, runs)
        assert self.own is not None
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
        ahead = 0.0 if self.corrects else self.look_ahead
        target = seen.references.each_at(np.minimum(recall.clock + ahead, fixed.end))
        return Situation(seen, fixed, recall, dt, target)

    def control(self, seen: Observation, memory: Any, dt: float) -> tuple[Command, Any]:
        """Ask the rule base, and track for the rest."""
        if self.has_equation:
            return super().control(seen, memory, dt)
        assert self.own is not None
        fixed, _ = memory
        now = self.situation(seen, memory, dt)
        target = now.target
        said, inputs = self.own.asked(now, _NEUTRAL)
        v, w, _ = self.tracker.toward(seen, target)
        # A rule base of pairs tells a robot that hears nobody nothing
        tracks = (np.arange(1, v.shape[1] + 1) == self.leader) | np.isnan(inputs).all(axis=0)
        aim = target if self.corrects else seen.reference
        straight = aim.v * np.cos(wrapped(aim.heading - seen.heading)) if self.corrects else v
        wish_v = said.get("v", straight * said.get("speed_factor", 1.0)) + said.get("dv", 0.0)
        wish_v = np.minimum(wish_v, said.get("speed", np.inf))
        # Who keeps a side turns away from the obstacle there, whichever it is.
        turn = said.get("turn", 0.0) * (now.way if "keep" in self.own.outputs else 1.0)
        speed = np.maximum(np.abs(aim.v), np.minimum(np.abs(wish_v), self.catch_up))
        wish_w = said.get("w", np.broadcast_to(aim.w, v.shape) if self.corrects else w) + turn / TURN_TIME
        wish_w = wish_w + said.get("dw", 0.0) + speed * said.get("bend", 0.0)
        v, w = np.where(tracks, v, wish_v), np.where(tracks, w, wish_w)
        pace = np.broadcast_to(said.get("rate", np.ones_like(v)), v.shape)
        zero = np.zeros_like(v)
        after = now.remembered(pace=pace, keep=said.get("keep", zero), yields=zero, v=v, w=w)
        message = now.message(after) if self.message else None
        progress = now.paths.share(now.place)
        return Command(v, w, v, w, message, target, progress, inputs=inputs), _Memory(fixed, after)


class InterpretedRules(OwnRules):
    """The same law in Python: who learns from it looks at its situation in every period."""

    has_equation = False

    @classmethod
    def of(cls, law: OwnRules) -> "InterpretedRules":
        """The same as ``law``, which asks a rule base of its own."""
        return cls(**{f.name: getattr(law, f.name) for f in fields(law) if f.init})
