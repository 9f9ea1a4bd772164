"""The fuzzy team and rule bases of one's own on arrays: what their equations are held against."""

import math
from collections.abc import Mapping
from dataclasses import dataclass, fields
from typing import Any, NamedTuple

import numpy as np

from fuzzy.compiled.columns import Columns, column, within
from fuzzy.compiled.jit import kernel
from robotics.laws.avoidance.planned_way import planned_timing
from robotics.laws.equation import KNOWLEDGE_FIELDS, AimColumns, RobotColumns, SeenColumns, gain_columns
from robotics.laws.law import Command, Observation
from robotics.laws.modes import AVOID, FOLLOW, LEFT_BEHIND, TRACK, YIELD
from robotics.laws.rules.fuzzy_team import (
    FREE_SPEED,
    GUARDED,
    GUARDED_TURN,
    LEAST_WISH,
    LEFT_AFTER,
    WALL_AFTER,
    FuzzyTeam,
)
from robotics.laws.rules.fuzzy_team import (
    NEUTRAL as TEAM_NEUTRAL,
)
from robotics.laws.rules.own_rules import RULE_NEUTRAL, OwnRules
from robotics.laws.rules.perceiving import MEETING_MARGIN
from robotics.laws.rules.perception import TeamMessage
from robotics.laws.rules.situation import TURN_TIME, turning_circles
from robotics.laws.setting import Setting
from robotics.laws.teams.cooperation import JOINING, hold
from robotics.laws.tracking.fuzzy_tracking import FuzzyTracking, TrackingWork, tell_inputs
from robotics.laws.tracking.fuzzy_tracking import toward as steer
from robotics.world.paths.posture import posture_error, wrapped
from robotics.world.paths.references import Reference
from robotics.world.paths.road import at
from tests.robotics.laws.rules.arrayform.evaluation import ask, kept
from tests.robotics.laws.rules.arrayform.situation import Fixed, Recall, Situation

_GAIN = gain_columns(FuzzyTracking)


class Toward(NamedTuple):
    """What the rule bases of a tracking law answered, and to what."""

    v: np.ndarray  # (runs, robots) m/s
    w: np.ndarray  # (runs, robots) rad/s
    inputs: np.ndarray  # (inputs, runs, robots): those of FuzzyTracking.fuzzy_systems


class TowardColumns(SeenColumns):
    """The arguments of :func:`toward`: a robot, an aim, and what follows."""

    x_err = column("m")


def toward(law: FuzzyTracking, seen: Observation, target: Reference, x_err: np.ndarray | None = None) -> Toward:
    """Evaluate the rule bases for robots that drive towards a target, as the equation does.

    Args:
        law: The law.
        seen: What the robots know.
        target: Each field (robots,) or (runs, robots).
        x_err: How far each robot is behind (runs, robots) [m]; by default the target's x in its frame (5.9).
    """
    shape = seen.x.shape
    given = TowardColumns.zeros(*shape)
    robot, aim = given.robot, given.aim
    robot.x, robot.y, robot.heading = seen.x, seen.y, seen.heading
    aim.x, aim.y, aim.heading, aim.v, aim.w = target[:5]
    given.x_err = np.nan if x_err is None else x_err
    rows, (gains, rules) = given.array.reshape(given.size, -1), (law.gain_array(), np.concatenate(law.rule_rows()))
    out = np.empty((2 + len(law.inputs) + (law.lateral != "none"), rows.shape[1]))
    if _toward_all(rows, gains, rules, np.empty(law.working), out):
        law.tracking(out[2 : 2 + len(law.inputs)].T)  # which says what was wrong
    out = out.reshape(-1, *shape)
    return Toward(out[0], out[1], out[2:])


@kernel(nogil=True)
def _toward_all(rows, gains, rules, work, out):
    """Steer for every column of ``rows``, TowardColumns; return what was wrong anywhere."""
    wrong, gain, places = 0, _GAIN(gains, 0), TrackingWork(work)
    for i in range(rows.shape[1]):
        one = TowardColumns(rows, i)
        out[0, i], out[1, i], told = steer(one.robot, one.aim, one.x_err, 0.0, False, gain, rules, places)
        wrong |= told
        tell_inputs(out[2:, i], gain, places)
    return wrong


class HeldColumns(Columns):
    """The arguments of :func:`hold`, which moves the aim, and what it returns."""

    robot = within(RobotColumns)
    aim = within(AimColumns)
    place = column("m")
    ahead = column("m")
    phase = column("")


def held(
    seen: Observation, target: Reference, place: np.ndarray, reach: float
) -> tuple[Reference, np.ndarray, np.ndarray]:
    """Hold the sample due near the robot, along its path; so that it drives to the path before it drives across it.

    Args:
        seen: What the robots know.
        target: The samples due, each field (runs, robots).
        place: The abscissae of the paths' nearest points (runs, robots) [m].
        reach: How far ahead of the robot's place the target is at most [m].

    Returns the target, how far it is ahead [m], as rule 11 takes it, and what the robot does: _FOLLOWING, WAITING,
    JOINING or ARRIVED; each (runs, robots).
    """
    rows = HeldColumns.zeros(*place.shape)
    rows.place, robot, aim = place, rows.robot, rows.aim
    robot.x, robot.y, robot.heading = seen.x, seen.y, seen.heading
    aim.x, aim.y, aim.heading, aim.v, aim.w, aim.s = target
    _hold_all(seen.references.road, rows.array.reshape(rows.size, -1), float(reach))
    return Reference(aim.x, aim.y, aim.heading, target.v, aim.w, aim.s), rows.ahead, rows.phase.astype(int)


@kernel
def _hold_all(road, rows, reach):
    for i in range(rows.shape[1]):
        one = HeldColumns(rows, i)
        path, robot = i % len(road.lengths), one.robot
        x, y, _, _ = at(road, path, one.place)
        off = math.hypot(x - robot.x, y - robot.y)
        one.ahead, one.phase = hold(road, path, robot, one.place, off, one.aim, reach)


class TeamMemory(NamedTuple):
    fixed: Fixed
    recall: Recall
    halted: np.ndarray  # (runs, robots) s: as of EmergencySettings.kept
    stays: np.ndarray | None  # (runs, 1) bool: there is no plan; None: none is wanted


@dataclass(frozen=True, kw_only=True)
class InterpretedTeam(FuzzyTeam):
    """The fuzzy team on arrays."""

    @classmethod
    def of(cls, law: FuzzyTeam) -> "InterpretedTeam":
        """The same as ``law``."""
        return cls(**{f.name: getattr(law, f.name) for f in fields(law) if f.init and f.name not in KNOWLEDGE_FIELDS})

    def init(self, setting: Setting, runs: int) -> Any:
        """Look at the paths, and plan where a plan is wanted and robots may meet."""
        super().init(setting, runs)  # raises what it raises
        plan = None
        if self.plan == "reservation" and len(setting.robots) > 1:
            plan = planned_timing(setting, 2 * float(turning_circles(setting).max()) + self.margin)
        stays = None if plan is None else np.broadcast_to(~plan.found, (runs, 1))
        halted = np.zeros((runs, len(setting.robots)))
        return TeamMemory(Fixed.of(setting, self.margin, plan), Recall.start(setting, runs, plan), halted, stays)

    def situation(self, seen: Observation, memory: TeamMemory, dt: float) -> Situation:
        """All that the rule bases can be told in a period."""
        if memory.fixed.plan is not None:
            seen = seen._replace(references=memory.fixed.plan)
        return Situation(seen, memory.fixed, memory.recall, dt)

    def control(self, seen: Observation, memory: Any, dt: float) -> tuple[Command, Any]:
        """Know the situation, ask the rule bases, blend what they say, and guard it."""
        stays = memory.stays
        now = self.situation(seen, memory, dt)
        inputs: dict[str, np.ndarray] = {}
        urgency = self._ask(now, "supervisor", inputs)
        crash = self._ask(now, "crash", inputs)
        obstacles = self._ask(now, "obstacles", inputs)
        together = self._ask(now, "cooperation", inputs)
        pace = (1 - np.exp(-seen.time)) * (1 + urgency["cooperation"] * (together["rate"] - 1))
        in_time = FREE_SPEED + urgency["cooperation"] * (together["speed"] - FREE_SPEED)
        v, w = self._tracked(now, pace, in_time, inputs)
        # blended
        tracking, avoiding = urgency["tracking"], urgency["obstacles"]
        total = np.maximum(tracking + avoiding, 1e-6)
        w = w + urgency["crash"] * crash["turn"] / TURN_TIME
        aside = np.minimum(obstacles["speed"], in_time)
        v = (tracking * v + avoiding * aside) / total
        w = (tracking * w + avoiding * now.way * obstacles["turn"] / TURN_TIME) / total
        limit = FREE_SPEED + urgency["crash"] * (crash["speed"] - FREE_SPEED)
        # guarded
        asked = np.minimum(v, limit)
        if stays is not None:
            asked, w = np.where(stays, 0.0, asked), np.where(stays, 0.0, w)
        w = np.where(asked < 0, 0.0, w)  # back it goes straight
        safe, safe_w, halted = kept(self.guard, now, asked, w, memory.halted)
        yields = np.clip((v - safe) / np.maximum(v, LEAST_WISH), 0.0, 1.0)
        after = now.remembered(pace=pace, keep=obstacles["keep"], yields=yields, v=safe, w=safe_w)
        mode = np.where(avoiding > tracking, np.where(now.stuck > WALL_AFTER, FOLLOW, AVOID), TRACK)
        mode = np.where(yields > 0.5, YIELD, mode) + np.where(now.stuck > LEFT_AFTER, LEFT_BEHIND, 0)
        due = now.due
        command = Command(
            safe,
            safe_w,
            safe,
            safe_w,
            now.message(after),
            due._replace(v=due.v * pace, w=due.w * pace),
            now.paths.share(now.place),
            refused=None if stays is None else stays[:, 0],
            mode=mode,
            inputs=np.concatenate([inputs[task] for task in self.fuzzy_systems]) if inputs else None,
            guarded=(np.abs(safe - asked) > GUARDED) | (np.abs(safe_w - w) > GUARDED_TURN),
        )
        return command, memory._replace(recall=after, halted=halted)

    def _ask(self, now: Situation, task: str, inputs: dict[str, np.ndarray]) -> Mapping[str, np.ndarray]:
        """What the rule base of ``task`` says, (runs, robots) each; its inputs are put into ``inputs``."""
        base, shape = self.bases[task], now.place.shape
        found = {name: np.full(shape, value) for name, value in TEAM_NEUTRAL[task].items()}
        if base is None:
            return found
        if base.of_pairs and shape[1] == 1:
            inputs[task] = np.full((len(base.inputs), *shape), np.nan)
            return found
        said, inputs[task] = ask(base, now, TEAM_NEUTRAL[task])
        return {**found, **said}

    def _tracked(
        self, now: Situation, pace: np.ndarray, in_time: np.ndarray, inputs: dict[str, np.ndarray]
    ) -> tuple[np.ndarray, np.ndarray]:
        """v [m/s] and ω [rad/s] towards the sample due, beside the path no faster than ``in_time`` [m/s]."""
        if self.tracking_rule_base == "none":
            return np.zeros_like(pace), np.zeros_like(pace)
        if not self.tracker.tracking.fis.rules:
            inputs["tracking"] = np.full((len(self.tracker.inputs), *pace.shape), np.nan)
            return np.zeros_like(pace), np.zeros_like(pace)
        ahead = np.minimum(now.recall.clock + self.look_ahead * pace, now.fixed.end)
        due = now.seen.references.each_at(ahead)
        target, behind, phase = held(now.seen, due, now.place, self.reach)
        v, w, asked = toward(self.tracker, now.seen, target, behind)
        joins = phase == JOINING
        if joins.any():
            # Back to its path a robot steers straight to it, and turns first: at speed it would circle about a target
            # that is beside it.
            _, steep, asked_then = toward(self.joiner, now.seen, target, behind)
            e = posture_error(now.seen.x, now.seen.y, now.seen.heading, target)
            w = np.where(joins, steep, w)
            v = np.where(joins, np.minimum(v, in_time) * np.clip(np.cos(np.arctan2(e.y, e.x)), 0.0, 1.0), v)
            asked = np.where(joins, asked_then, asked)
        inputs["tracking"] = asked
        return v, w


class RulesMemory(NamedTuple):
    fixed: Fixed
    recall: Recall


class InterpretedRules(OwnRules):
    """A rule base of one's own on arrays."""

    @classmethod
    def of(cls, law: OwnRules) -> "InterpretedRules":
        """The same as ``law``, which asks a rule base of its own."""
        return cls(**{f.name: getattr(law, f.name) for f in fields(law) if f.init and f.name not in KNOWLEDGE_FIELDS})

    @property
    def message(self) -> tuple[str, ...]:
        """Where the robots are, if the rule base asks for it."""
        asks = self.own is not None and (any(q.radio for q in self.own.inputs) or "rate" in self.own.outputs)
        return TeamMessage.leaves() if asks else ()

    @property
    def looks(self) -> bool:
        """Whether the rule base asks for the room around the robot."""
        return self.own is not None and self.own.looks

    @property
    def needs(self) -> tuple[str, ...]:
        """The range sensors that the rule base names."""
        return () if self.own is None else self.own.sensors

    def init(self, setting: Setting, runs: int) -> Any:
        """Look at the paths."""
        return RulesMemory(Fixed.of(setting, MEETING_MARGIN), Recall.start(setting, runs))

    def situation(self, seen: Observation, memory: RulesMemory, dt: float) -> Situation:
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
        assert self.own is not None
        fixed, _ = memory
        now = self.situation(seen, memory, dt)
        target = now.target
        said, inputs = ask(self.own, now, RULE_NEUTRAL)
        v, w, _ = toward(self.tracker, seen, target)
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
        return Command(v, w, v, w, message, target, progress, inputs=inputs), RulesMemory(fixed, after)
