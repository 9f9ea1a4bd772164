"""A fuzzy team: tracking, cooperation, crash and obstacle avoidance at once, in one hierarchy of rule bases.

Thesis 1.8, 5.3 and (6.4)-(6.7), Figs 5.20 and 6.26; there two modes are switched by hand. Here five rule bases do it:

* ``cooperation``: from how far the robot and each other is behind, the age of what it heard, and who gives way or is
  stuck, to the rate z' of the robot's copy of the group's clock. The copies agree on the slowest.
* ``tracking``: v and ω towards the sample due by that clock, Table 5.6 as repaired.
* ``crash``: from the way to the place where two paths meet, the gap, bearing and closing speed of the other, and who
  has right of way, to a turn and to the speed above which it would be dangerous. Over all others the turns add up and
  the least speed holds.
* ``obstacles``: from the room ahead and aside, and the progress made, to a turn, a speed, and the side to keep. The
  side is remembered: σ' = (keep − σ)/T, so that it is kept while the obstacle is there and forgotten when it is gone.
* ``supervisor``: how urgent each of the four is, by which they are blended:

      ω = (μ_t ω_tracking + μ_o turn_obstacles / T) / (μ_t + μ_o) + μ_c turn_crash / T
      v = min((μ_t v_tracking + μ_o v_obstacles) / (μ_t + μ_o), speed_crash)
      z' = 1 + μ_k (z'_cooperation − 1)

Below them stands the emergency rule of :mod:`robotics.laws.rules.emergency`, which knows no rules and no paths.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, NamedTuple

import numpy as np

from fuzzy.system import Sugeno
from robotics.laws.avoidance.priority import WHEREABOUTS, whereabouts
from robotics.laws.law import Command, ControllerError, Law, Observation, check_connected, check_team
from robotics.laws.modes import AVOID, FOLLOW, TRACK, YIELD
from robotics.laws.rules.emergency import Guard
from robotics.laws.rules.evaluation import RuleBase
from robotics.laws.rules.situation import Fixed, Recall, Situation
from robotics.laws.setting import Setting
from robotics.laws.teams.cooperation import held
from robotics.laws.teams.neighbours import OUTAGE, smallest_heard
from robotics.laws.tracking.fuzzy_tracking import FuzzyTracking
from robotics.quantity import check_quantities, quantity

OUTPUTS = {
    "cooperation": {"rate": "rate of the clock"},
    "crash": {"turn": "rad", "speed": "m/s, at most"},
    "obstacles": {"turn": "rad, away from the obstacle", "speed": "m/s", "keep": "the side: 1 keep, -1 change, 0 none"},
    "supervisor": dict.fromkeys(("tracking", "cooperation", "crash", "obstacles"), "urgency"),
}
TURN_TIME = 0.4  # s: a turn [rad] is made in this time, as by the tracking rule base's look-ahead
SIDE_TIME = 0.5  # s: the time constant with which a side is taken and forgotten
FREE_SPEED = 1.2  # m/s: what the crash rule base allows where nobody is


class _Memory(NamedTuple):
    fixed: Fixed
    recall: Recall


@dataclass(frozen=True, kw_only=True)
class FuzzyTeam(Law[_Memory]):
    """The fuzzy team: its five rule bases, and the few numbers beside them. A rule base "none" leaves its task out."""

    tracking_rule_base: str = "tracking"
    cooperation_rule_base: str = "cooperation"
    crash_rule_base: str = "crash"
    obstacles_rule_base: str = "obstacles"
    supervisor_rule_base: str = "supervisor"
    margin: float = quantity(0.2, "m", least=0.02, most=5)  # between the turning circles of robots that do not meet
    look_ahead: float = quantity(0.4, "s", least=0, most=10)
    reach: float = quantity(0.4, "m", above=0)  # the target is no farther ahead of the robot's place
    tracker: FuzzyTracking = field(init=False, repr=False)
    bases: dict[str, RuleBase | None] = field(init=False, repr=False, compare=False)
    guard: Guard = field(default_factory=Guard)

    yields = True
    looks = True

    def __post_init__(self) -> None:
        check_quantities(self, ControllerError)
        tracking = FuzzyTracking(rule_base="tracking" if self.tracking_rule_base == "none" else self.tracking_rule_base)
        object.__setattr__(self, "tracker", tracking)
        bases: dict[str, RuleBase | None] = {}
        for task, outputs in OUTPUTS.items():
            name = getattr(self, f"{task}_rule_base")
            bases[task] = None if name == "none" else RuleBase.of(name, outputs, task)
        object.__setattr__(self, "bases", bases)

    @property
    def message(self) -> tuple[str, ...]:
        """The names of the values that each robot broadcasts."""
        return ("place", "speed", "clock", "pace", *WHEREABOUTS, "yields", "stuck")

    @property
    def watchdog(self) -> float:
        """After how long [s] without a new command a robot stops."""
        return OUTAGE

    @property
    def fuzzy_systems(self) -> dict[str, Sugeno]:
        """The rule bases by their tasks."""
        found = {"tracking": self.tracker.tracking.fis} if self.tracking_rule_base != "none" else {}
        return found | {task: base.fis for task, base in self.bases.items() if base is not None}

    def init(self, setting: Setting, runs: int) -> _Memory:
        """Look at the paths. Raises ControllerError where the robots are no team, or the graph is not connected."""
        if len(setting.robots) > 1:
            check_team(setting)
        check_connected(setting)
        return _Memory(Fixed.of(setting, self.margin), Recall.start(setting, runs))

    @property
    def rule_bases(self) -> Mapping[str, RuleBase]:
        """The rule bases of named inputs, by their tasks; tracking's inputs are not named so."""
        return {task: base for task, base in self.bases.items() if base is not None}

    def situation(self, seen: Observation, memory: _Memory, dt: float) -> Situation:
        """All that the rule bases can be told in a period."""
        return Situation(seen, *memory, dt)

    def control(self, seen: Observation, memory: _Memory, dt: float) -> tuple[Command, _Memory]:
        """Know the situation, ask the rule bases, blend what they say, and guard it."""
        fixed, recall = memory
        now = self.situation(seen, memory, dt)
        asked: dict[str, np.ndarray] = {}
        urgency = self._ask(now, "supervisor", asked)
        rate = self._rate(now, urgency, asked)
        pace = (1 - np.exp(-seen.time)) * rate
        v, w = self._tracked(now, pace)
        crash = self._ask(now, "crash", asked)
        obstacles = self._ask(now, "obstacles", asked)
        way = np.where(recall.side >= 0, 1.0, -1.0)
        mu_t, mu_o = urgency["tracking"], urgency["obstacles"]
        total = np.maximum(mu_t + mu_o, 1e-6)
        v = (mu_t * v + mu_o * obstacles["speed"]) / total
        w = (mu_t * w + mu_o * way * obstacles["turn"] / TURN_TIME) / total
        w = w + urgency["crash"] * crash["turn"] / TURN_TIME
        wanted = v
        v = np.minimum(v, FREE_SPEED + urgency["crash"] * (crash["speed"] - FREE_SPEED))
        yields = np.clip((wanted - v) / np.maximum(wanted, 0.1), 0.0, 1.0)
        safe_v, safe_w = self.guard.kept(seen, now.others, now.clear, fixed.radii, v, w)
        guarded = (np.abs(safe_v - v) > 0.01) | (np.abs(safe_w - w) > 0.05)
        v, w = safe_v, safe_w
        side = recall.side + dt / SIDE_TIME * (way * obstacles["keep"] - recall.side)
        message = {
            "place": now.place - now.off,
            "speed": (now.place - recall.place) / dt,
            "clock": recall.clock,
            "pace": pace,
            "yields": yields,
            "stuck": now.stuck,
            **whereabouts(seen),
        }
        clock = recall.clock + dt * pace
        if seen.heard.fields:
            theirs = seen.heard.now("clock", by="pace") + dt * np.maximum(seen.heard["pace"], 1.0)
            clock = np.minimum(clock, smallest_heard(clock, theirs, seen.heard.hears))
        after = Recall(now.place, message["speed"], clock, pace, now.best, now.stuck, side, now.clear, yields)
        mode = np.where(yields > 0.5, YIELD, np.where(mu_o > mu_t, np.where(now.stuck > 6, FOLLOW, AVOID), TRACK))
        due = now.due
        moving = due._replace(v=due.v * pace, w=due.w * pace)
        command = Command(v, w, v, w, message, moving, now.paths.share(now.place), mode=mode, guarded=guarded)
        return command, _Memory(fixed, after)

    def _ask(self, now: Situation, task: str, asked: dict[str, np.ndarray]) -> dict[str, np.ndarray]:
        """What the rule base of ``task`` says, (runs, robots) each; of pairs the most cautious of all others.

        An output that it does not have is neutral.
        """
        base = self.bases[task]
        shape = now.place.shape
        neutral = {name: np.full(shape, value) for name, value in NEUTRAL[task].items()}
        if base is None or (base.of_pairs and shape[1] == 1):
            return neutral
        said, asked[task] = base.asked(now, NEUTRAL[task])
        return neutral | said

    def _rate(self, now: Situation, urgency: dict[str, np.ndarray], asked: dict[str, np.ndarray]) -> np.ndarray:
        said = self._ask(now, "cooperation", asked)["rate"]
        return 1 + urgency["cooperation"] * (said - 1)

    def _tracked(self, now: Situation, pace: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """v [m/s] and ω [rad/s] towards the sample due."""
        ahead = np.minimum(now.recall.clock + self.look_ahead * pace, now.fixed.end)
        target, behind, _ = held(now.seen, now.seen.references.each_at(ahead), now.place, now.fixed.lengths, self.reach)
        v, w = self.tracker.toward(now.seen, target, behind)
        if self.tracking_rule_base == "none":
            v, w = np.zeros_like(v), np.zeros_like(w)
        return v, w


NEUTRAL: dict[str, dict[str, Any]] = {
    "cooperation": {"rate": 1.0},
    "crash": {"turn": 0.0, "speed": FREE_SPEED},
    "obstacles": {"turn": 0.0, "speed": 0.0, "keep": 0.0},
    "supervisor": {"tracking": 1.0, "cooperation": 1.0, "crash": 1.0, "obstacles": 0.0},
}
