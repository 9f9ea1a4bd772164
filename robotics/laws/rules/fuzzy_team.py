"""A fuzzy team: tracking, cooperation, crash and obstacle avoidance at once, in one hierarchy of rule bases.

Thesis 1.8, 5.3 and (6.4)-(6.7), Figs 5.20 and 6.26; there two modes are switched by hand. Here five rule bases do it:

* ``cooperation``: from how far the robot is behind, and whether it gives way or is stuck, to the rate z' of its copy
  of the group's clock. The copies agree on the slowest: who is behind makes all wait.
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

By its gain ``plan`` the team plans before the start, :mod:`robotics.laws.avoidance.planned_way`: the rule bases then
work on the plan's paths and timing in the place of the scenario's, and the right of way of ``crash`` is the plan's.

Below them stands the emergency rule of :mod:`robotics.laws.rules.emergency`, which knows no rules and no paths.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, field, replace
from types import MappingProxyType
from typing import Any, Literal

import numpy as np

from fuzzy.compiled.columns import Columns, codes, column, several, within
from fuzzy.compiled.jit import compiled_only
from fuzzy.quantity import quantity
from fuzzy.system import Sugeno
from robotics.laws.avoidance.obstacle_avoidance import GROUP_DIAGRAM
from robotics.laws.avoidance.planned_way import planned_timing
from robotics.laws.equation import equation, gain_columns
from robotics.laws.law import check_connected, check_team
from robotics.laws.modes import AVOID, FOLLOW, LEFT_BEHIND, TRACK, YIELD, StateBox, StateDiagram, Transition
from robotics.laws.rules.asking import MOST_OUTPUTS, AnswerColumns, AskColumns, ask_numbers, ask_rules
from robotics.laws.rules.emergency import EmergencyColumns, EmergencySettings, kept_safe
from robotics.laws.rules.evaluation import RuleBase
from robotics.laws.rules.perceiving import MEETING_MARGIN, Perceiving
from robotics.laws.rules.perception import KNOWN, PerceivedColumns, WantedColumns, perceive, remember, tell
from robotics.laws.rules.situation import TURN_TIME, RecallColumns, TeamColumns, turning_circles
from robotics.laws.setting import Setting
from robotics.laws.teams.cooperation import JOINING, hold
from robotics.laws.teams.neighbours import OUTAGE
from robotics.laws.tracking.fuzzy_tracking import FuzzyTracking, TrackingWork, toward
from robotics.world.paths.road import moving, share

TEAM_OUTPUTS = {  # of each task, each with its unit and meaning
    "cooperation": {"rate": "1, of the clock: 1 on time, 0 waits", "speed": "m/s, at most, beside the path"},
    "crash": {"turn": "rad, added to that of tracking", "speed": "m/s, at most"},
    "obstacles": {
        "turn": "rad, away from the obstacle",
        "speed": "m/s",
        "keep": "1, the side: 1 keep, -1 change, 0 none",
    },
    "supervisor": {
        task: f"1, how urgent {task} is: 0 to 1" for task in ("tracking", "cooperation", "crash", "obstacles")
    },
}
_SHOWN_WITH = 0.54  # m: the largest circle of a robot with which its rule bases are tested among obstacles (MiR100)
LEAST_WISH = 0.1  # m/s: a robot that wants to drive slower gives way by less than its speed
GUARDED, GUARDED_TURN = 0.01, 0.2  # m/s, rad/s: what the emergency rule takes off less than this is noise
WALL_AFTER = 6.0  # s without progress after which an avoiding robot is said to follow the wall
LEFT_AFTER = 15.0  # s after which it is said to be left behind
FREE_SPEED = 1.2  # m/s: what the crash rule base allows where nobody is


_DIAGRAM = StateDiagram(  # thesis Fig 6.26; the rule bases blend what here are states
    {
        TRACK: StateBox("tracking", "tracking outweighs: to the sample due, turned and slowed by crash"),
        AVOID: StateBox("avoiding", "obstacles outweighs: round one side, which is kept"),
        FOLLOW: StateBox("following the wall", "the same, along what leads nowhere"),
        YIELD: StateBox("yielding", "crash or the emergency rule takes half of the speed, or all"),
    },
    (
        Transition(TRACK, AVOID, "supervisor: little room ahead, or a thing comes"),
        *(Transition(mode, TRACK, "supervisor: room ahead, and no side is kept") for mode in (AVOID, FOLLOW)),
        Transition(AVOID, FOLLOW, f"no progress on the path for {WALL_AFTER:g} s"),
        Transition(FOLLOW, AVOID, "progress"),
        *(Transition(mode, YIELD, "another robot goes first, or is near") for mode in (TRACK, AVOID, FOLLOW)),
        Transition(YIELD, TRACK, "its way is free, and no side is kept"),
        Transition(YIELD, AVOID, "its way is free, beside an obstacle"),
        Transition(YIELD, FOLLOW, "its way is free, without progress"),
    ),
)


NEUTRAL: dict[str, dict[str, float]] = {
    "cooperation": {"rate": 1.0, "speed": FREE_SPEED},
    "crash": {"turn": 0.0, "speed": FREE_SPEED},
    "obstacles": {"turn": 0.0, "speed": 0.0, "keep": 0.0},
    "supervisor": {"tracking": 1.0, "cooperation": 1.0, "crash": 1.0, "obstacles": 0.0},
}
_TASKS, _ASK = len(TEAM_OUTPUTS), AskColumns.size
_TOGETHER, _CRASH, _OBSTACLES, _URGENCY = (codes(tuple(NEUTRAL[task])) for task in TEAM_OUTPUTS)


class TeamMemory(RecallColumns):
    """What a robot of the team remembers."""

    halted = column("s", "as of EmergencySettings.kept")


class TeamDerived(Columns):
    """What the law makes of its rule bases and of the emergency rule's numbers."""

    tracks = column("", "1: it has a rule base of tracking; 2: one without rules")
    tracking_inputs = column("", "how many that has")
    asks = within(WantedColumns)
    first_ask = column("", "the row of the next among the gains")
    cooperation = within(AskColumns)
    crash = within(AskColumns)
    obstacles = within(AskColumns)
    supervisor = within(AskColumns)
    emergency = within(EmergencyColumns)


class TeamWork(Columns):
    """What the law works in."""

    now = within(PerceivedColumns)
    answer = within(AnswerColumns)
    answers = several(len(TEAM_OUTPUTS) * MOST_OUTPUTS, "", "what the rule bases say, as NEUTRAL")
    tracking = within(TrackingWork)


@equation
def drive_team(robot, gain, memory, command, work, known, i, rules, table):  # type: ignore[no-untyped-def]
    """Perceive, ask the rule bases, blend what they say, and guard it."""
    now, rest, asks, dt = work.now, work.tracking.rest, gain.asks, known.dt
    readings, inputs = rest[int(asks.readings) :], command.inputs
    perceive(robot, memory, asks, known, i, table, now, rest)
    for task in range(_TASKS):
        ask = AskColumns(known.gains[int(gain.first_ask) + task * _ASK :], known.column[i])
        answer = work.answers[task * MOST_OUTPUTS : (task + 1) * MOST_OUTPUTS]
        ask_rules(ask, rules, memory, known, i, table, now, work.answer, rest, readings, inputs, answer)
    together, crash = work.answers[0:MOST_OUTPUTS], work.answers[MOST_OUTPUTS : 2 * MOST_OUTPUTS]
    obstacles, urgency = work.answers[2 * MOST_OUTPUTS : 3 * MOST_OUTPUTS], work.answers[3 * MOST_OUTPUTS :]
    joint = urgency[_URGENCY.cooperation]
    pace = (1 - math.exp(-known.time)) * (1 + joint * (together[_TOGETHER.rate] - 1))
    in_time = FREE_SPEED + joint * (together[_TOGETHER.speed] - FREE_SPEED)
    v, w = _track(robot, gain, memory, command, work, known, i, rules, table, pace, in_time)
    # blended
    tracking, avoiding = urgency[_URGENCY.tracking], urgency[_URGENCY.obstacles]
    total = max(tracking + avoiding, 1e-6)
    w += urgency[_URGENCY.crash] * crash[_CRASH.turn] / TURN_TIME
    v = (tracking * v + avoiding * min(obstacles[_OBSTACLES.speed], in_time)) / total
    turn = obstacles[_OBSTACLES.turn] if memory.side >= 0 else -obstacles[_OBSTACLES.turn]
    w = (tracking * w + avoiding * turn / TURN_TIME) / total
    asked = min(v, FREE_SPEED + urgency[_URGENCY.crash] * (crash[_CRASH.speed] - FREE_SPEED))
    # guarded
    stays = TeamColumns(table).stays
    if stays == 1:
        asked, w = 0.0, 0.0
    if asked < 0:  # back it goes straight
        w = 0.0
    safe, safe_w, memory.halted = kept_safe(asked, w, memory.halted, gain.emergency, robot, known, table, now, readings)
    yields = min(max((v - safe) / max(v, LEAST_WISH), 0.0), 1.0)
    mode, stuck = TRACK, now.known[KNOWN.stuck]
    if avoiding > tracking:
        mode = FOLLOW if stuck > WALL_AFTER else AVOID
    if yields > 0.5:
        mode = YIELD
    command.mode = mode + (LEFT_BEHIND if stuck > LEFT_AFTER else 0)
    command.first, command.second, command.wish_v, command.wish_w = safe, safe_w, safe, safe_w
    due, target = now.due, command.target
    target.x, target.y, target.heading, target.s = due.x, due.y, due.heading, due.s
    target.v, target.w = due.v * pace, due.w * pace
    command.progress = share(known.road, known.path[i], now.place)
    command.refused = stays
    command.guarded = 1.0 if abs(safe - asked) > GUARDED or abs(safe_w - w) > GUARDED_TURN else 0.0
    tell(command.say, robot, memory, now, dt, pace, yields)
    remember(memory, known, i, now, pace, obstacles[_OBSTACLES.keep], yields, safe, safe_w)


@compiled_only(forceinline=True)
def _track(robot, gain, memory, command, work, known, i, rules, table, pace, in_time):  # type: ignore[no-untyped-def]
    """v [m/s] and ω [rad/s] towards the sample due, beside the path no faster than ``in_time`` [m/s]."""
    inputs, count = command.inputs, int(gain.tracking_inputs)
    if gain.tracks != 1:
        for n in range(count):
            inputs[n] = np.nan
        return 0.0, 0.0
    road, path, aim, own = known.road, known.path[i], work.tracking.aim, work.tracking
    ahead = min(memory.clock + gain.look_ahead * pace, TeamColumns(table).end)
    aim.x, aim.y, aim.heading, aim.v, aim.w, aim.s = moving(road, path, ahead)
    behind, phase = hold(road, path, robot, work.now.place, work.now.off, aim, gain.reach)
    v, w, _ = toward(robot, aim, behind, 0.0, False, gain.tracker, rules, own)
    if phase == JOINING:
        # Back to its path a robot steers straight to it, and turns first: at speed it would circle about a target
        # that is beside it.
        _, w, _ = toward(robot, aim, behind, 0.0, False, gain.joiner, rules, own)
        dx, dy, cos, sin = aim.x - robot.x, aim.y - robot.y, work.now.cos, work.now.sin
        facing = math.cos(math.atan2(cos * dy - sin * dx, cos * dx + sin * dy))
        v = min(v, in_time) * min(max(facing, 0.0), 1.0)
    for n in range(count):
        inputs[n] = own.asked[n]
    return v, w


@dataclass(frozen=True, kw_only=True)
class FuzzyTeam(Perceiving):
    """The fuzzy team: its five rule bases, and the few numbers beside them. A rule base "none" leaves its task out.

    So does one without rules.
    """

    tracking_rule_base: str | Sugeno = "tracking"
    cooperation_rule_base: str | Sugeno = "cooperation"
    crash_rule_base: str | Sugeno = "crash"
    obstacles_rule_base: str | Sugeno = "obstacles"
    supervisor_rule_base: str | Sugeno = "supervisor"
    margin: float = quantity(
        MEETING_MARGIN, "m", least=0.02, most=5
    )  # between the turning circles of robots that do not meet
    plan: Literal["none", "reservation"] = "none"  # whose timing it follows: the scenario's, or a plan's
    look_ahead: float = quantity(0.4, "s", least=0, most=10)
    reach: float = quantity(0.4, "m", above=0)  # the target is no farther ahead of the robot's place
    tracker: FuzzyTracking = field(init=False, repr=False)
    joiner: FuzzyTracking = field(init=False, repr=False)  # the same for a robot off its path, which steers to it
    bases: dict[str, RuleBase | None] = field(init=False, repr=False, compare=False)
    guard: EmergencySettings = field(default_factory=EmergencySettings)

    yields = True
    looks = True
    diagrams = (_DIAGRAM, GROUP_DIAGRAM)
    remembers, derived, works = TeamMemory, TeamDerived, TeamWork
    equation = drive_team
    has_modes = guards = True
    watchdog = OUTAGE  # s
    tasks = MappingProxyType({task: f"{task}_rule_base" for task in ("tracking", *TEAM_OUTPUTS)})

    def __post_init__(self) -> None:
        super().__post_init__()
        tracking = FuzzyTracking(rule_base="tracking" if self.tracking_rule_base == "none" else self.tracking_rule_base)
        object.__setattr__(self, "tracker", tracking)
        object.__setattr__(self, "joiner", replace(tracking, steering_distance=0.0))
        bases: dict[str, RuleBase | None] = {}
        for task, outputs in TEAM_OUTPUTS.items():
            name = getattr(self, f"{task}_rule_base")
            bases[task] = None if name == "none" else RuleBase.of(name, outputs, task)
        object.__setattr__(self, "bases", bases)

    @property
    def may_refuse(self) -> bool:  # type: ignore[override]
        """Whether it plans, which may find no plan."""
        return self.plan != "none"

    def derive(self, setting: Setting) -> Mapping[str, Any]:
        """How the rule bases are asked, and the numbers of the emergency rule."""
        count, begin = len(self.tracker.inputs), sum(map(len, self.tracker.rule_rows()))
        told = count * (self.tracking_rule_base != "none")
        rules = 0 if not told else 1 if self.tracker.tracking.fis.rules else 2
        first = gain_columns(FuzzyTeam).columns["cooperation"].row
        found: dict[str, Any] = {
            "first_ask": first,
            "tracks": rules,
            "tracking_inputs": told,
            "emergency": asdict(self.guard),
        }
        sensors = self.reads(setting)
        for task, base in self.bases.items():
            found[task] = ask_numbers(base, NEUTRAL[task], begin, told, sensors)
            if base is not None:
                begin, told = begin + len(base.compiled.system), told + len(base.inputs)
        return found | {"asks": self.wanted(setting)}

    def rule_rows(self) -> Sequence[np.ndarray]:
        """The rule bases of tracking, and those of named inputs."""
        return (*self.tracker.rule_rows(), *(base.compiled.system for base in self.rule_bases.values()))

    @property
    def fuzzy_systems(self) -> dict[str, Sugeno]:
        """The rule bases by their tasks."""
        found = {"tracking": self.tracker.tracking.fis} if self.tracking_rule_base != "none" else {}
        return found | {task: base.fis for task, base in self.rule_bases.items()}

    def init(self, setting: Setting, runs: int) -> Any:
        """Look at the paths, and plan where a plan is wanted and robots may meet.

        In an ensemble the runs without a plan are refused. Raises ControllerError where the robots are no team, the
        graph is not connected, a scenario has no safe plan, or a rule base names a robot that does not exist.
        """
        for task, base in self.rule_bases.items():
            base.check(setting, getattr(self, f"{task}_rule_base"))
        if len(setting.robots) > 1:
            check_team(setting)
        check_connected(setting)
        if self.plan == "reservation" and len(setting.robots) > 1:
            plan = planned_timing(setting, 2 * float(turning_circles(setting).max()) + self.margin)
            setting = replace(setting, references=plan)
        return super().init(setting, runs)

    def misgivings(self, setting: Setting) -> tuple[str, ...]:
        """Say where a robot is larger than those with which the packaged rule bases are tested."""
        circle = turning_circles(setting)
        i = int(np.argmax(circle))
        if setting.world is None or circle[i] <= _SHOWN_WITH or self.obstacles_rule_base != "obstacles":
            return ()
        return (
            f"{setting.name}: the rule base obstacles was made for the EtsRo and is tested with the packaged robots, "
            f"which turn on the spot in a circle of {_SHOWN_WITH:g} m at most; robot {i + 1} needs {circle[i]:.2g} m",
        )

    @property
    def rule_bases(self) -> Mapping[str, RuleBase]:
        """The rule bases of named inputs, by their tasks; tracking's inputs are not named so."""
        return {task: base for task, base in self.bases.items() if base is not None}
