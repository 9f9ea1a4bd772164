"""Any rule base drives: a law whose inputs are quantities that a robot can know, by their names in the ``.fis`` file.

The inputs are those of :mod:`robotics.laws.rules.quantities`; the outputs are one or more of ``RULE_OUTPUTS``.
What a rule base does not give, or one of pairs cannot give as nobody is heard, fuzzy tracking does: it drives to the
target ``look_ahead`` seconds from now. A rule base of v and w whose inputs are a tracking law's four, as Table 5.6, is
fuzzy tracking itself (:mod:`robotics.laws.tracking.fuzzy_tracking`). All run in compiled code: one that asks for
nothing but the robot's own motion, path and reference by :mod:`robotics.laws.rules.of_reference`, others by
:mod:`robotics.laws.rules.perception`.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, fields
from functools import cached_property
from types import MappingProxyType
from typing import Any, ClassVar

import numpy as np

from fuzzy.compiled.columns import Columns, codes, column, several, within
from fuzzy.compiled.composite import evaluate_composite
from fuzzy.compiled.packed import evaluate_packed
from fuzzy.quantity import quantity
from fuzzy.system import Sugeno
from robotics.laws.equation import KNOWLEDGE_FIELDS, equation
from robotics.laws.law import ControllerError
from robotics.laws.rules.asking import MOST_OUTPUTS, AnswerColumns, AskColumns, ask_numbers, ask_rules
from robotics.laws.rules.evaluation import RuleBase, composite_of
from robotics.laws.rules.of_reference import (
    CORRECTIONS,
    HEADING_ERR,
    INPUTS,
    LATER,
    OUTPUTS,
    SEEN,
    AskedColumns,
    AskingColumns,
    RecalledColumns,
    answered,
    asked_columns,
    asks_for_reference,
    is_of_reference,
    pick,
    see,
    see_path,
    tell_asked,
)
from robotics.laws.rules.perceiving import Perceiving
from robotics.laws.rules.perception import PerceivedColumns, WantedColumns, perceive, remember, tell
from robotics.laws.rules.situation import TURN_TIME, RecallColumns
from robotics.laws.setting import Setting
from robotics.laws.tracking.fuzzy_tracking import (
    TRACKING_INPUTS,
    FuzzyTracking,
    TrackingDerived,
    TrackingWork,
    called,
    load_rule_base,
    tell_inputs,
    toward,
)
from robotics.world.paths.posture import wrapped_compiled
from robotics.world.paths.road import moving, share

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
RULE_NEUTRAL = dict.fromkeys(RULE_OUTPUTS, 0.0) | {"v": np.inf, "speed": np.inf, "speed_factor": 1.0, "rate": 1.0}
_GIVEN = codes(tuple(RULE_OUTPUTS))
_UNASKED = {name: [0] * c.rows if c.width else 0 for name, c in AskedColumns.columns.items()}


def is_tracking(fis: Sugeno) -> bool:
    """Whether a rule base is one of fuzzy tracking: of a tracking law's inputs, with two outputs, v before w."""
    outputs = [v.name for v in fis.outputs]
    other = {*RULE_OUTPUTS} - {"v", "w"}
    ordered = len(outputs) == 2 and outputs[0] != "w" and outputs[1] != "v"
    return ordered and not other & {*outputs} and all(v.name in TRACKING_INPUTS for v in fis.inputs)


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
        if ask.composite == 1:
            evaluate_composite(rules[int(ask.begin) :], own.asked, own.said, work.tracking.rest)
        else:
            evaluate_packed(rules[int(ask.begin) :], own.asked, own.said, work.tracking.rest)
        v, w = answered(own.said, ask, target, own.seen[HEADING_ERR], v, w, gain.catch_up)
        memory.v, memory.w = v, w
    command.first, command.second, command.wish_v, command.wish_w = v, w, v, w


@dataclass(frozen=True, kw_only=True)
class OwnRules(FuzzyTracking):
    """A rule base of one's own, and fuzzy tracking for what it does not give.

    One that asks for more than the robot's own motion, path and reference is made a :class:`PerceivingRules`.
    """

    def __new__(cls, rule_base: str | Sugeno = "tracking", leader: float = 0.0, **_: Any) -> "OwnRules":
        """Choose the class by what the rule base is and asks for; raises as the making of it."""
        if composite_of(rule_base) is not None:
            return super().__new__(CompositeRules if cls is OwnRules else cls)
        fis = load_rule_base(rule_base)
        perceives = not is_tracking(fis) and (leader != 0 or not is_of_reference(fis))
        return super().__new__(PerceivingRules if perceives and cls is OwnRules else cls)

    leader: float = quantity(0.0, "1", least=0)  # the number of the robot that only tracks; 0: none
    catch_up: float = quantity(0.3, "m/s", least=0)  # of a rule base that corrects: `bend` acts at this speed at rest
    own: RuleBase | None = field(init=False, repr=False, compare=False)  # none: fuzzy tracking itself

    tasks = MappingProxyType({**FuzzyTracking.tasks, "own": "rule_base"})
    equation = drive_by_rules
    derived: ClassVar[type[Columns]] = RulesDerived
    remembers: ClassVar[type[Columns]] = RecalledColumns
    works: ClassVar[type[Columns]] = RulesWork

    def __post_init__(self) -> None:
        if (whole := composite_of(self.rule_base)) is not None:
            own: RuleBase | None = RuleBase.of_composite(whole, self.rule_base, RULE_OUTPUTS, "a rule base")
        else:
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
        idle = super().idle | {"leader"}
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
        return {} if self.corrects else super().barred

    def derive(self, setting: Setting) -> Mapping[str, Any]:
        """What fuzzy tracking derives, and how the rule base is asked."""
        begin = sum(map(len, super().rule_rows()))
        ask = _UNASKED if self.own is None else asked_columns(self.own.fis, begin, setting.period)
        return {**super().derive(setting), "ask": ask}

    def rule_rows(self) -> Sequence[np.ndarray]:
        """The rule bases of tracking, and the own one."""
        if self.own is None:
            return super().rule_rows()
        return *super().rule_rows(), self.own.compiled.system if self.own.composite is None else self.own.composite

    @cached_property
    def tracker(self) -> FuzzyTracking:
        """The fuzzy tracking underneath."""
        names = [f.name for f in fields(FuzzyTracking) if f.init and f.name not in KNOWLEDGE_FIELDS]
        own = {name: getattr(self, name) for name in names}
        return FuzzyTracking(**own | {"rule_base": self.tracking_rule_base})

    @property
    def fuzzy_systems(self) -> Mapping[str, Sugeno]:
        """The rule base, or those of tracking."""
        return super().fuzzy_systems if self.own is None else {"own": self.own.fis}

    def misgivings(self, setting: Setting) -> tuple[str, ...]:
        """Those of fuzzy tracking, where it alone drives."""
        return super().misgivings(setting) if self.own is None else ()

    def init(self, setting: Setting, runs: int) -> Any:
        """Look at the paths. Raises ControllerError where a rule base names a robot that does not exist."""
        if self.own is not None:
            self.own.check(setting, self.rule_base)
        if self.leader > len(setting.robots) or self.leader % 1:
            raise ControllerError(
                f"leader must be the number of a robot of {setting.name}, 1 to {len(setting.robots)}, or 0 for none; "
                f"got {self.leader:g}"
            )
        return super().init(setting, runs)

    @property
    def rule_bases(self) -> Mapping[str, RuleBase]:
        """The rule base, if it is not fuzzy tracking itself."""
        return {} if self.own is None else {"own": self.own}


@dataclass(frozen=True, kw_only=True)
class CompositeRules(OwnRules):
    """A tree of systems or an interval type-2 system as the rule base, of the robot's own motion, path and reference.

    It is evaluated in compiled code as a plain one is, and tuned; what explains or writes rules takes plain ones only.
    """

    def __post_init__(self) -> None:
        super().__post_init__()
        assert self.own is not None
        if not asks_for_reference(self.own.fis):
            raise ControllerError(
                f"{called(self.rule_base)}: a tree or a type-2 system that drives takes at most {INPUTS} of "
                f"{', '.join(SEEN)}, and {', '.join(LATER)} with :SECONDS behind it, and gives {', '.join(OUTPUTS)}"
            )

    def derive(self, setting: Setting) -> Mapping[str, Any]:
        """The same, evaluated as what it is."""
        found = super().derive(setting)
        return {**found, "ask": {**found["ask"], "composite": 1.0}}

    @cached_property
    def composites(self) -> Mapping[str, Any]:
        """The tree or the type-2 system."""
        return {"own": composite_of(self.rule_base)}

    def with_fuzzy_system(self, task: str, fis: Any) -> "CompositeRules":
        """The same law with another tree or type-2 system. Raises ControllerError for a plain rule base."""
        if isinstance(fis, Sugeno):
            raise ControllerError(
                f"{called(self.rule_base)} is a tree or a type-2 system; its rules are not taken apart"
            )
        return super().with_fuzzy_system(task, fis)


class PerceivingDerived(RulesDerived):
    """What the law makes of its rule bases."""

    asks = within(WantedColumns)
    perceived = within(AskColumns)
    keeps_time = column("", "1: its copy of the clock shows the time")
    keeps_side = column("", "1: it remembers the side of an obstacle to keep")


class PerceivingWork(Columns):
    """What the law works in."""

    now = within(PerceivedColumns)
    answer = within(AnswerColumns)
    given = several(MOST_OUTPUTS, "", "what the rule base gives, as RULE_OUTPUTS")
    tracking = within(TrackingWork)


@equation
def perceive_and_drive(robot, aim, gain, memory, command, work, known, i, rules, table):  # type: ignore[no-untyped-def]
    """Perceive, ask the rule base, and track for the rest."""
    now, rest, ask, said, dt = work.now, work.tracking.rest, gain.ask, work.given, known.dt
    readings, road, path, target = rest[int(gain.asks.readings) :], known.road, known.path[i], work.now.target
    if gain.keeps_time == 1:
        memory.clock = known.time
    perceive(robot, memory, gain.asks, known, i, table, now, rest)
    ask_rules(gain.perceived, rules, memory, known, i, table, now, work.answer, rest, readings, command.inputs, said)
    into = command.target
    into.x, into.y, into.heading, into.v, into.w, into.s = (
        target.x,
        target.y,
        target.heading,
        target.v,
        target.w,
        target.s,
    )
    v, w, _ = toward(robot, target, math.nan, 0.0, False, gain, rules, work.tracking)
    alone = (
        gain.leader == i % known.heard.shape[2] + 1
    )  # it only tracks, as one that a rule base of pairs tells nothing
    if not alone and gain.perceived.count > 0:
        alone = True
        for n in range(int(gain.perceived.count)):
            alone = alone and math.isnan(command.inputs[n])
    if not alone:
        if gain.keeps_side == 1 and memory.side < 0:  # it turns away from the obstacle there, whichever it is
            said[_GIVEN.turn] = -said[_GIVEN.turn]
        if ask.corrects == 0 or gain.keeps_time == 1:  # the velocity of the reference, which may be read ahead
            target.v, target.w = aim.v, aim.w
        v, w = answered(said, ask, target, wrapped_compiled(target.heading - robot.heading), v, w, gain.catch_up)
    pace = said[_GIVEN.rate]
    command.first, command.second, command.wish_v, command.wish_w = v, w, v, w
    command.progress = share(road, path, now.place)
    tell(command.say, robot, memory, now, dt, pace, 0.0)
    remember(memory, known, i, now, pace, said[_GIVEN.keep], 0.0, v, w)


@dataclass(frozen=True, kw_only=True)
class PerceivingRules(OwnRules, Perceiving):
    """A rule base that asks for other robots, the room around it or what the robot remembers of its way."""

    equation = perceive_and_drive
    derived, remembers, works = PerceivingDerived, RecallColumns, PerceivingWork

    @property
    def idle(self) -> frozenset[str]:
        """The parameters that have no effect as the others are set."""
        return super().idle - {"leader"}

    @property
    def barred(self) -> Mapping[str, str]:
        """No low-pass; a lead where it corrects the reference of the present time."""
        leads = self.corrects and self.own is not None and "rate" not in self.own.outputs
        return {name: why for name, why in super(OwnRules, self).barred.items() if not (leads and name == "lead")}

    def derive(self, setting: Setting) -> Mapping[str, Any]:
        """What fuzzy tracking derives, and how the rule base is asked."""
        outputs = {} if self.own is None or not self.own.fis.rules else self.own.outputs
        begin = sum(map(len, super(OwnRules, self).rule_rows()))
        ahead = 0.0 if self.corrects else self.look_ahead
        given = [[*RULE_OUTPUTS].index(name) if name in outputs else -1 for name in OUTPUTS]
        return {
            **super(OwnRules, self).derive(setting),
            "ask": _UNASKED | {"given": given, "corrects": float(self.corrects)},
            "asks": self.wanted(setting, ahead),
            "perceived": ask_numbers(self.own, RULE_NEUTRAL, begin, 0, self.reads(setting)),
            "keeps_time": float("rate" not in outputs),
            "keeps_side": float("keep" in outputs),
        }
