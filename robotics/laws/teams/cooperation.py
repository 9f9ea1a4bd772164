"""Hierarchical fuzzy cooperation: the tracking rule base under a clock that all share, thesis 5.3.

Every path is cut into the same number of samples, which lie farther apart on a longer path, so that it is driven
faster; ς_i = s_i / L_i is a robot's progress, z the clock that says which sample is due. The upper level runs it,

    z' = (1/T) (1 − e^{−t}) (1 − tanh((d − d0)₊² / d1²))        after (5.14)

with d the lag [m] along its path of the robot that is most behind; the lower level drives each robot towards the sample
due by the rule base of Table 5.6. The factor e^{k2 (t − t0)} of (5.14) must decay, and is here the (1 − e^{−t}).

Variants:

``literal``: the clock as printed, (1 − tanh(Σ d_RP²)). It counts robots that are ahead as well: they wait for a clock
that waits for them, and test 2 never starts.
``lag-clock``: the same with the clock above.
``repaired``: the clock above, and four choices. The target is held at most ``reach`` metres ahead of the robot's own
place on the path, so that a robot far off its path drives to the path and not across it, even before it is due. Rule
11 takes "ahead" along the path, since off the path the robot's own x says nothing. The target is taken ``look_ahead``
seconds ahead, which removes the lag. And a late clock runs faster, by the factor 1 + (catch_up − 1) min(late, 1 s), as
in :mod:`robotics.laws.teams.virtual_structure`: (1 − e^{−t}) alone leaves it 1 s behind the scenario's timetable for
good. With 1.5 the robots drive half as fast again at most, and where nobody lags the lateness decays in 2 s.

Each robot keeps a copy of the clock, and the copies agree on the slowest (a choice: the thesis has one clock). The
clock all but stops for a robot that lags by much more than d0. Stability: the lower level's local certificate is that
of :mod:`robotics.laws.tracking.fuzzy_tracking`; there is no proof for the whole.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import Any, Literal

import numpy as np

from fuzzy.compiled.columns import Columns, codes, column, within
from fuzzy.compiled.jit import compiled_only
from fuzzy.quantity import quantity
from fuzzy.system import Sugeno
from robotics.laws.equation import EquationLaw, HeardColumns, equation
from robotics.laws.law import check_connected, check_team
from robotics.laws.modes import StateBox, StateDiagram, Transition
from robotics.laws.setting import Setting
from robotics.laws.teams.neighbours import OUTAGE, SEARCH_REACH, SEARCH_REACH_AFTER_OUTAGE
from robotics.laws.tracking.fuzzy_tracking import FuzzyTracking, Lateral, TrackingWork, tell_inputs, toward
from robotics.world.paths.road import at as point_at
from robotics.world.paths.road import moving, nearest, share
from robotics.world.paths.road import place as place_at
from robotics.world.radio.channel import predicted

_AT_END = 0.04  # m: a robot that is nearer to the end of its path has arrived
ON_PATH = 0.03  # m: a robot that is no farther from its path is on it

# What a robot does, as the lower level chooses it in every period
_FOLLOWING = 0
WAITING = 1
JOINING = 2
ARRIVED = 3
# Thesis Fig 5.24 as printed: rule 11 decides
RULE_11_DIAGRAM = StateDiagram(
    {
        _FOLLOWING: StateBox("following", "rules 1-10 of Table 5.6: to the sample due"),
        WAITING: StateBox("waiting", "rule 11 of Table 5.6: v and ω fall to 0"),
    },
    (
        Transition(_FOLLOWING, WAITING, "the sample due is behind: x_err < 0"),
        Transition(WAITING, _FOLLOWING, "the sample due is ahead: x_err ≥ 0"),
    ),
)
_OFF, _ON, _END = "off its path", "on its path", "the target is the path's end, and near"
REPAIRED_DIAGRAM = StateDiagram(
    {
        WAITING: StateBox("waiting", "rule 11 of Table 5.6: v and ω fall to 0"),
        JOINING: StateBox("joining its path", "Table 5.6 to a point of the path ahead, though it may not be due"),
        ARRIVED: StateBox("arrived", "Table 5.6 to the path's end; rule 11 by the robot's own x"),
        _FOLLOWING: StateBox("following", "Table 5.6 to the sample due, at most reach ahead"),
    },
    (
        Transition(WAITING, JOINING, _OFF),
        Transition(JOINING, WAITING, f"{_ON}, the target is behind"),
        Transition(JOINING, ARRIVED, _END),
        Transition(ARRIVED, JOINING, "the end is not near, off its path"),
        Transition(WAITING, ARRIVED, _END),
        Transition(WAITING, _FOLLOWING, "the target is ahead"),
        Transition(_FOLLOWING, WAITING, "the target is behind"),
        Transition(JOINING, _FOLLOWING, f"{_ON}, the target is ahead"),
        Transition(_FOLLOWING, JOINING, _OFF),
        Transition(ARRIVED, _FOLLOWING, f"the end is not near, {_ON}"),
        Transition(_FOLLOWING, ARRIVED, _END),
    ),
)


Variant = Literal["repaired", "lag-clock", "literal"]
_VARIANT = codes(Variant)


class CooperationMessage(Columns):
    """What every robot broadcasts."""

    place = column("m", "the abscissa of its nearest point; in the variant literal d_RP")
    speed = column("m/s", "the rate of that")
    clock = column("s", "its copy of the clock")
    pace = column("1", "of that clock")


class CooperationHeard(HeardColumns):
    """What one robot has heard of another."""

    said = within(CooperationMessage)


class CooperationMemory(Columns):
    """What the cooperation remembers."""

    clock = column("s", "the scenario's time that the robot's copy of the clock shows")
    place = column("m", "the abscissa of its nearest point")
    phase = column("", "FOLLOWING, WAITING, JOINING or ARRIVED")


class CooperationDerived(Columns):
    """What the law makes of its setting."""

    end = column("s", "when the last reference arrives")


@compiled_only
def steered(  # type: ignore[no-untyped-def]
    robot, gain, memory, command, work, known, i, turn, excused, no_lateral
):
    """Run one robot's copy of the clock, drive it towards the sample due, and say so; what :data:`cooperate` does.

    It leaves the inputs of the rule bases in ``work``, for
    :func:`robotics.laws.tracking.fuzzy_tracking.tell_inputs`.

    Args:
        robot: What the robot knows of itself.
        gain: The numbers of FuzzyCooperation.
        memory: CooperationMemory.
        command: All of it is written but the message's other values, and the inputs of the rule bases.
        work: What the rule bases work in, TrackingWork.
        known: What the law knows; the message's first values are those of this law.
        i: The lane.
        turn: Added to α [rad].
        excused: Whether the clock does not wait for the robot; it then broadcasts a place that is not a number.
        no_lateral: Whether λ is not added.
    """
    road, path, aim, due, say = known.road, known.path[i], work.aim, command.target, command.say
    repaired, literal = gain.variant == _VARIANT.repaired, gain.variant == _VARIANT.literal
    clock, before = memory.clock, memory.place
    due.x, due.y, due.heading, due_v, due_w, due.s = moving(road, path, min(clock, gain.end))
    newest, apart, worst, slowest = _listened(i, known, due.s, literal)
    reach = SEARCH_REACH_AFTER_OUTAGE if newest > OUTAGE else SEARCH_REACH
    place = nearest(road, path, robot.x, robot.y, before, reach)
    if literal:
        said = math.hypot(due.x - robot.x, due.y - robot.y)  # d_RP
        rate = 0.0
        slowing = math.tanh(said * said + apart)  # (5.14) as printed
    else:
        said, rate = math.nan if excused else place, (place - before) / known.dt
        own = 0.0 if excused else due.s - place
        beyond = (worst if own < worst else own) - gain.lag
        late = beyond / gain.softness if not beyond < 0 else 0.0
        slowing = math.tanh(late * late)
    pace = (1 - math.exp(-known.time)) * (1 - slowing)  # after (5.14)
    look_ahead, x_err = gain.look_ahead, math.nan
    if repaired:
        pace = pace * (1 + (gain.catch_up - 1) * min(max(known.time - clock, 0.0), 1.0))
        look_ahead = look_ahead * pace
    # The sample to drive to
    aim.x, aim.y, aim.heading, aim.v, aim.w, aim.s = moving(road, path, min(clock + look_ahead, gain.end))
    if repaired:
        near_x, near_y, _, _ = point_at(road, path, place)
        off = math.hypot(near_x - robot.x, near_y - robot.y)
        x_err, memory.phase = hold(road, path, robot, place, off, aim, gain.reach)
    else:
        ahead = math.cos(robot.heading) * (aim.x - robot.x) + math.sin(robot.heading) * (aim.y - robot.y)
        memory.phase = _FOLLOWING if ahead >= 0 else WAITING
    v, w, _ = toward(robot, aim, x_err, turn, no_lateral, gain.tracker, known.rules[known.base[i]], work)
    command.first, command.second, command.wish_v, command.wish_w = v, w, v, w
    due.v, due.w = due_v * pace, due_w * pace
    command.progress = share(road, path, place)
    say.place, say.speed, say.clock, say.pace = said, rate, clock, pace
    clock = clock + known.dt * pace
    memory.clock = slowest if slowest < clock and not literal else clock
    memory.place = place


@compiled_only
def _listened(i, known, due, literal):  # type: ignore[no-untyped-def]
    """What one robot makes of the messages it has heard.

    Returns the age [s] of the newest message, at most the time; Σ d_RP² [m²] of the others if the clock is ``literal``;
    the greatest lag [m] of another behind what is level with the abscissa ``due`` [m], at least 0; and the time [s]
    that the slowest copy of the clock may show in the next period.
    """
    road, path = known.road, known.path
    robots = known.heard.shape[2]
    run = i - i % robots  # the lane of the run's first robot
    # All paths have the same timing: what is level with the own place due is due on every path.
    progress = share(road, path[i], due)
    newest, apart, worst, slowest = known.time, 0.0, 0.0, math.inf
    for j in range(robots):
        heard = CooperationHeard(known.heard, i, j)
        if not heard.hears > 0:
            continue
        said = heard.said
        newest = min(newest, heard.age)
        theirs = predicted(said.place, said.speed, heard.age)
        if not math.isnan(theirs):
            if literal:
                apart += theirs * theirs
            else:
                worst = max(worst, place_at(road, path[run + j], progress) - theirs)
        shown = predicted(said.clock, said.pace, heard.age) + known.dt * (1.0 if said.pace < 1.0 else said.pace)
        if shown < slowest:  # false where nothing was heard yet
            slowest = shown
    return newest, apart, worst, slowest


@compiled_only
def hold(road, path, robot, place, off, aim, reach):  # type: ignore[no-untyped-def]
    """Move the ``aim``, which is the sample due, near one robot, ``off`` [m] from its ``place`` [m]; see :func:`held`.

    Returns how far it is ahead [m], and the phase.
    """
    dx, dy = aim.x - robot.x, aim.y - robot.y
    behind, s = aim.s - place, min(aim.s, place + reach)
    if aim.s >= road.lengths[path] and math.hypot(dx, dy) < _AT_END:
        # At the path's end the nearest point is the end from both sides: there the robot's own x tells.
        ahead = math.cos(robot.heading) * dx + math.sin(robot.heading) * dy
        phase, behind = ARRIVED, ahead if ahead > 0 else -1.0
    elif off > ON_PATH:
        # A robot that is ahead of time but off its path drives to the path before it waits.
        phase, behind, s = JOINING, max(behind, off), max(s, place + min(off, reach) / 2)
    else:
        phase = _FOLLOWING if aim.s >= place else WAITING
    if s != aim.s:
        aim.x, aim.y, aim.heading, curvature = point_at(road, path, s)
        aim.w, aim.s = aim.v * curvature, s
    return behind, phase


@equation
def cooperate(robot, gain, memory, command, work, known, i):  # type: ignore[no-untyped-def]
    """Run the clock, and drive towards the sample due by Table 5.6."""
    steered(robot, gain, memory, command, work, known, i, 0.0, False, False)
    tell_inputs(command.inputs, gain.tracker, work)


@dataclass(frozen=True, kw_only=True)
class FuzzyCooperation(EquationLaw):
    """Fuzzy cooperation: the rule base, how its target is chosen, and the clock."""

    variant: Variant = "repaired"
    rule_base: str | Sugeno = "tracking"
    look_ahead: float = quantity(0.4, "s", least=0, most=10)
    steering_distance: float = quantity(0.35, "m", least=0)  # as of the tracking law
    lateral: Lateral = "none"  # as of the tracking law
    reach: float = quantity(0.4, "m", above=0)  # "repaired": the target is no farther ahead of the robot's place
    lag: float = quantity(0.25, "m", least=0)  # d0: a lag that does not slow the clock
    softness: float = quantity(0.4, "m", above=0)  # d1: the lag beyond d0 at which the clock runs at 24 %
    catch_up: float = quantity(1.5, "1", least=1, most=5)  # pace of a clock that is late; "repaired"
    tracker: FuzzyTracking = field(init=False, repr=False)

    tasks = MappingProxyType({"tracking": "rule_base"})

    def __post_init__(self) -> None:
        super().__post_init__()
        tracker = FuzzyTracking(
            rule_base=self.rule_base, steering_distance=self.steering_distance, lateral=self.lateral
        )
        object.__setattr__(self, "tracker", tracker)

    @property
    def idle(self) -> frozenset[str]:
        """The parameters that have no effect in this variant."""
        idle = {"literal": {"reach", "lag", "softness", "catch_up"}, "lag-clock": {"reach", "catch_up"}}
        return frozenset(idle.get(self.variant, ()))

    @property
    def diagrams(self) -> tuple[StateDiagram, ...]:
        """The choices of the lower level, thesis Fig 5.24."""
        return (REPAIRED_DIAGRAM if self.variant == "repaired" else RULE_11_DIAGRAM,)

    @property
    def fuzzy_systems(self) -> Mapping[str, Sugeno]:
        """The rule bases of the lower level."""
        return self.tracker.fuzzy_systems

    equation = cooperate
    says, remembers, works, derived = CooperationMessage, CooperationMemory, TrackingWork, CooperationDerived
    aims = progresses = True

    def derive(self, setting: Setting) -> Mapping[str, Any]:
        """When the last reference arrives."""
        ends = setting.references.ends
        return {
            "end": np.broadcast_to(ends.max(axis=-1, keepdims=True), ends.shape) if ends.ndim > 1 else float(ends.max())
        }

    def rule_rows(self) -> Sequence[np.ndarray]:
        """The rule bases of the lower level."""
        return self.tracker.rule_rows()

    def begin(self, setting: Setting, runs: int) -> np.ndarray:
        """Set the clocks to 0. Raises ControllerError where the robots are no team, or the graph is not connected."""
        robots = len(setting.robots)
        if robots > 1:
            check_team(setting)
        check_connected(setting)
        memory = CooperationMemory.zeros(runs, robots)
        memory.place = setting.starting_places(runs, setting.references.at(0.0).s, SEARCH_REACH_AFTER_OUTAGE)
        memory.phase = WAITING
        return memory.array
