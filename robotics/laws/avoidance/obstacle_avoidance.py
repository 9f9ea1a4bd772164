"""Obstacle avoidance, thesis 6.2: fuzzy cooperation whose robots look around with sonars.

    ro ≤ ro_min  ⇒  α** = α + Θ(ro)                                      (6.7)

with ro the nearest front reading and Θ the rule base ``theta``, 0 at ro_min. The thesis prints ≤ also where it means
that the way is free, and gives no sign; here the robot turns away from the smaller of the two front readings.

"literal": the thesis's two modes. While ro ≤ ro_min the robot turns by Θ; a side reading below ``push_range`` turns it
``push`` away; v is reduced to ro / ro_min of itself (at least a quarter; 0 below 0.12 m). Otherwise the robot tracks.
It forgets an obstacle as soon as no cone sees it, and its target pulls it back: it grazes corners, and
never leaves a trap.

"committed": the modes of :mod:`robotics.laws.avoidance.obstacle_modes`. Chosen here:

* Rule 11 does not act while a robot avoids (one that was turned away from its target would stand still), and the
  target is held ``reach`` ahead of the robot's place on the path.
* Robots tell each other where they are, and stop before another robot ahead, as in
  :mod:`robotics.laws.avoidance.right_of_way`.
* A thing that is very near may be coming nearer: the robot stands still, or leaves straight ahead if that is free,
  until it has seen that nothing moves (:func:`robotics.laws.avoidance.obstacle_modes.stand_still`). It may be run into,
  but does not drive into a thing that moves.

Chosen for both variants:

* A robot stops for another that is nearer than ``d_pass``, ahead of it and going round an obstacle (case studies 2 and
  3). The robot with the lower number goes first; in "committed" a robot that avoids also goes before one that tracks,
  and nobody waits longer than 6 s. In "literal" there is no limit.
* A reading grows no faster than 2 m/s ("committed": 1 m/s in front, 0.6 m/s at the sides), so that an echo lost for a
  moment is not taken for an obstacle gone. Without that the literal scheme hits in 26 % of class A instead of 2 %.
* A robot that avoids and has made no progress along its path for longer than ``patience`` no longer slows the clock of
  the others (case study 4). As soon as it comes free they wait for it as before.

Stability: the tracking below is that of :mod:`robotics.laws.teams.cooperation`; avoidance is shown by sampling only.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import Any, Literal

import numpy as np

from fuzzy.compiled.columns import Columns, codes, column, several, within
from fuzzy.compiled.jit import compiled_only
from fuzzy.compiled.packed import evaluate_packed
from fuzzy.compiled.sugeno import CompiledSugeno
from fuzzy.quantity import quantity
from fuzzy.system import Sugeno
from robotics.laws.avoidance.echoes import ROBOT_ECHO, is_echo
from robotics.laws.avoidance.obstacle_modes import (
    GROWTH,
    STOP_DISTANCE,
    ModeMemory,
    MountColumns,
    SonarColumns,
    WatchMemory,
    mounting,
    next_mode,
    nothing_watched,
    stand_still,
)
from robotics.laws.avoidance.priority import (
    CONE,
    STATED_FOR,
    WhereaboutsColumns,
    other,
    stops_for,
    tell_whereabouts,
    wider,
)
from robotics.laws.equation import EquationLaw, HeardColumns, equation
from robotics.laws.modes import AVOID, FOLLOW, LEFT_BEHIND, TRACK, YIELD, StateBox, StateDiagram, Transition
from robotics.laws.setting import Setting
from robotics.laws.teams.cooperation import (
    ON_PATH,
    CooperationMemory,
    CooperationMessage,
    FuzzyCooperation,
    steered,
)
from robotics.laws.tracking.fuzzy_tracking import TrackingWork, compiled_curve, tell_inputs, toward
from robotics.world.paths.posture import wrapped_compiled
from robotics.world.paths.road import at as point_at
from robotics.world.sensing.sonar import SONAR

TOO_LARGE = 1.5  # 1: times the robot for which the distances are stated
_ABEAM = 1.45  # rad from the heading: a robot beyond that comes no nearer by driving on
SIDE_MARGIN = 0.06  # m: a robot turns away from another at its side that is nearer than ``near`` and this
TURN_AWAY = 0.8  # rad/s, from that one
PASSING_CONE = 1.3  # rad from the heading: a robot that avoids is let pass where it is within
LONGEST_WAIT = 6.0  # s: a robot lets others pass for no longer
LITERAL_RISE = 2.0  # m/s: a reading grows no faster
COMMITTED_RISE = (1.0, 1.0, 0.6, 0.6)  # m/s, in the order of SONAR; the side ones lose echoes at corners
ROBOT_RADIUS = 0.16  # m: of robots as large as the EtsRo, whose echoes are left out
IN_THE_WAY = 0.6  # m: likewise; robots that are known to be farther away are not avoided as obstacles
LEAVING_ROOM = 0.4  # m: with more ahead, a robot drives away from a thing that is too near
LEAVING_SPEED = 0.5  # m/s: no faster than this
CATCH_UP_SPEED = 0.6  # m/s: a robot that catches up drives no faster among obstacles it does not know
EARLY_TIME = 1.0  # s in which a robot loses its lead
JOINING_SPEED = 0.1  # m/s: a robot ahead of time drives back to its path no slower
CREEP_SPEED = 0.06  # m/s: a robot ahead of time that avoids drives no slower

# Thesis Fig 6.26, and what became of it here; below each, whether the group waits for the robot
LITERAL_DIAGRAM = StateDiagram(
    {
        TRACK: StateBox("tracking", "Table 5.6 at α"),
        AVOID: StateBox("avoiding", "Table 5.6 at α + Θ(ro) (6.7), slower"),
        YIELD: StateBox("standing", "v = ω = 0"),
    },
    (
        Transition(TRACK, AVOID, "ro ≤ ro_min, or a side sonar reads too little"),
        Transition(AVOID, TRACK, "all sonars read enough"),
        *(Transition(mode, YIELD, "a robot of lower number avoids ahead, within d_pass") for mode in (TRACK, AVOID)),
        Transition(YIELD, TRACK, "it is past; all sonars read enough"),
        Transition(YIELD, AVOID, "it is past; an obstacle is near"),
    ),
)
COMMITTED_DIAGRAM = StateDiagram(
    {
        TRACK: StateBox("tracking", "Table 5.6 at α, no faster than the front reading allows"),
        AVOID: StateBox("avoiding", "Table 5.6 at α + Θ(ro), round one side, which is kept"),
        FOLLOW: StateBox("following the wall", "along the wall, on the same side"),
        YIELD: StateBox("yielding", "stands; on the spot it may turn away from who is beside it"),
    },
    (
        Transition(TRACK, AVOID, "a front sonar reads less than ro_min"),
        Transition(AVOID, TRACK, "front and side have been free for 1.2 s"),
        Transition(AVOID, FOLLOW, "no progress on the path for 6 s"),
        Transition(FOLLOW, AVOID, "past where it got stuck, and free ahead"),
        *(Transition(m, YIELD, "another robot, or what may move, is too near") for m in (TRACK, AVOID, FOLLOW)),
        Transition(YIELD, TRACK, "its way is free, and no obstacle is near"),
        Transition(YIELD, AVOID, "its way is free, beside an obstacle"),
        Transition(YIELD, FOLLOW, "its way is free, along a wall"),
    ),
)
GROUP_DIAGRAM = StateDiagram(
    {
        0: StateBox("in the group", "the clock waits for the robot"),
        LEFT_BEHIND: StateBox("left behind", "the clock does not wait for it"),
    },
    (
        Transition(0, LEFT_BEHIND, "no progress on the path for longer than patience"),
        Transition(LEFT_BEHIND, 0, "progress, or it tracks again"),
    ),
    mask=LEFT_BEHIND,
)


SONARS = len(SONAR)
Variant = Literal["committed", "literal"]
_VARIANT = codes(Variant)


class ObstacleDerived(Columns):
    """What the law makes of its setting and of its rule bases."""

    theta_begin = column("1", "where Θ begins in the packed rule bases")
    close = column("m", "the ends of its range")
    far = column("m")
    widening = column("m", "more than the law states, by the size of the robots")
    mount = within(MountColumns)


class ObstacleMessage(CooperationMessage):
    """What every robot broadcasts: what the cooperation says, whether it avoids, and where it is."""

    avoids = column("", "1: it goes round an obstacle")
    where = within(WhereaboutsColumns)


class ObstacleHeard(HeardColumns):
    """What one robot has heard of another."""

    said = within(ObstacleMessage)


class ObstacleMemory(CooperationMemory):
    """What the law remembers."""

    state = within(ModeMemory)
    ranges = several(SONARS, "m", "the readings, with lost echoes filled in")
    waits = column("s", "for which the robot has let another pass")
    watch = within(WatchMemory)


class ObstacleWork(Columns):
    """What the law works in; ``tracking.rest`` is what Θ is evaluated in, too."""

    fresh = several(SONARS, "m", "what the sonars read")
    asked = several(1, "m", "the input of Θ")
    said = several(1, "rad", "Θ")
    tracking = within(TrackingWork)


@compiled_only
def theta_input(distance, gain):  # type: ignore[no-untyped-def]
    """The input of Θ [m] for a distance [m]: its range stretched to end at ro_min."""
    close, far, ro_min = gain.close, gain.far, gain.ro_min
    return min(max(far - (ro_min - distance) * (far - close) / (ro_min - close), close), far)


@compiled_only
def theta_at(distance, gain, theta, work):  # type: ignore[no-untyped-def]
    """|Θ| [rad] at a distance [m]; ``theta`` is its packed rule base."""
    work.asked[0] = theta_input(distance, gain)
    evaluate_packed(theta, work.asked, work.said, work.tracking.rest)
    return gain.theta * work.said[0]


@compiled_only
def sight_of(seen, gain, theta, work):  # type: ignore[no-untyped-def]
    """Judge by (6.7) what four sonars read, SonarColumns; ``theta`` is the packed rule base of Θ.

    Returns whether an obstacle is within ro_min in front, or within push_range at a side; Θ of (6.7) and the push from
    the sides [rad], with their signs, 0 unless there is one; the factor on v while it is there; and ro, the nearest
    front reading [m].
    """
    front, near = min(seen.front_left, seen.front_right), gain.push_range
    avoids = front <= gain.ro_min or min(front, seen.left, seen.right) < near
    turn = 0.0
    if avoids:
        size = theta_at(front, gain, theta, work)
        turn = -size if seen.front_left < seen.front_right else size
        turn += -gain.push if seen.left < near else 0.0
        turn += gain.push if seen.right < near else 0.0
    slowing = 0.0 if front < 0.12 else min(max(front / gain.ro_min, 0.25), 1.0)
    return avoids, turn, slowing, front


@compiled_only
def stalled(best, before, place, lost):  # type: ignore[no-untyped-def]
    """The largest place [m] on a robot's path so far, and the time [s] lost since it last grew.

    Args:
        best: The largest place [m] before.
        before: The time lost [s] before.
        place: The place [m] now.
        lost: The time [s] lost in this period, unless the place has grown by GROWTH.
    """
    if place > best + GROWTH:
        return place, 0.0
    return best, before + lost


@compiled_only
def _look(robot, gain, memory, work, known, i):  # type: ignore[no-untyped-def]
    """Take in what the sonars read: into ``work`` as read, and into the memory with lost echoes filled in."""
    committed = gain.variant == _VARIANT.committed
    for q in range(SONARS):
        reading = known.ranges[q, i]
        if committed and reading < np.inf and _of_a_robot(reading, q, robot, gain, known, i):
            reading = np.inf
        work.fresh[q] = reading
        rise = LITERAL_RISE if not committed else COMMITTED_RISE[q]
        memory.ranges[q] = min(reading, memory.ranges[q] + rise * known.dt)


@compiled_only
def _of_a_robot(reading, q, robot, gain, known, i):  # type: ignore[no-untyped-def]
    """Whether a reading [m] is the echo of another robot that is known and not so near as to be in the way."""
    mount = gain.mount
    cos, sin = math.cos(robot.heading), math.sin(robot.heading)
    for j in range(known.heard.shape[2]):
        heard = ObstacleHeard(known.heard, i, j)
        dx, dy, _, _ = other(heard.said.where, heard.age, robot.x, robot.y)
        ahead, left = cos * dx + sin * dy, cos * dy - sin * dx
        if math.hypot(ahead, left) > IN_THE_WAY + gain.widening and is_echo(
            reading, mount.x[q], mount.y[q], mount.axis[q], mount.half_cone[q],
            ahead, left, ROBOT_RADIUS + gain.widening / 2, ROBOT_ECHO, 0.0,
        ):  # fmt: skip
            return True
    return False


@compiled_only
def _lets_pass(robot, gain, known, i, avoids):  # type: ignore[no-untyped-def]
    """Whether a robot stops for another that goes round an obstacle.

    Where both go round one, the robot with the lower number goes first.
    """
    robots = known.heard.shape[2]
    for j in range(robots):
        heard = ObstacleHeard(known.heard, i, j)
        first = j < i % robots or (gain.variant == _VARIANT.committed and not avoids)
        if not (first and heard.hears > 0 and heard.said.avoids > 0.5):
            continue
        dx, dy, _, _ = other(heard.said.where, heard.age, robot.x, robot.y)
        bearing = abs(wrapped_compiled(math.atan2(dy, dx) - robot.heading))
        if math.hypot(dx, dy) < gain.d_pass and bearing < PASSING_CONE:
            return True
    return False


@compiled_only
def _must_stop(robot, near, known, i):  # type: ignore[no-untyped-def]
    """Whether a robot brakes for another, by :func:`robotics.laws.avoidance.priority.stops_for`."""
    robots = known.heard.shape[2]
    for j in range(robots):
        heard = ObstacleHeard(known.heard, i, j)
        if heard.hears > 0 and stops_for(heard.said.where, heard.age, robot, near, i % robots < j):
            return True
    return False


@compiled_only
def _aside(robot, near, known, i):  # type: ignore[no-untyped-def]
    """Which way a robot turns from others at its side: 1 to the left, -1 to the right, 0 where none is too near."""
    sides, reach = 0.0, near + SIDE_MARGIN + 0.2 * abs(robot.v)
    for j in range(known.heard.shape[2]):
        heard = ObstacleHeard(known.heard, i, j)
        if heard.hears > 0:
            dx, dy, _, _ = other(heard.said.where, heard.age, robot.x, robot.y)
            bearing = wrapped_compiled(math.atan2(dy, dx) - robot.heading)
            if CONE <= abs(bearing) < _ABEAM and math.hypot(dx, dy) < reach:
                sides += 1.0 if bearing > 0 else -1.0
    return -1.0 if sides > 0 else (1.0 if sides < 0 else 0.0)


@compiled_only
def _literal(  # type: ignore[no-untyped-def]
    robot, gain, memory, command, work, known, i, alone, avoids, slowing, front
):
    """Slow down while an obstacle is near. Returns v [m/s], ω [rad/s], the mode, and whether it avoids.

    The cooperation has steered already, turned by (6.7); ``alone`` robots are excused from its clock.
    """
    told = tell_inputs(command.inputs, gain.cooperation.tracker, work.tracking)
    command.inputs[told] = theta_input(front, gain)
    state, lost = memory.state, known.dt if avoids else 0.0
    state.best, state.stalled = stalled(state.best, state.stalled, memory.place, lost)
    v, w, mode = command.first, command.second, float(TRACK)
    if avoids:
        v *= slowing
        mode = float(AVOID + LEFT_BEHIND if alone else AVOID)
    if _lets_pass(robot, gain, known, i, avoids):
        v, w = 0.0, 0.0
        mode = float(YIELD + LEFT_BEHIND if avoids and alone else YIELD)
    return v, w, mode, avoids and not alone


@compiled_only
def _committed(robot, gain, memory, command, work, known, i, alone):  # type: ignore[no-untyped-def]
    """Choose a mode, and steer by it. Returns as :func:`_literal`."""
    road, path, dt, due, state = known.road, known.path[i], known.dt, command.target, memory.state
    ranges, fresh, rules = SonarColumns(memory.ranges), SonarColumns(work.fresh), known.rules[known.base[i]]
    place, length, aim = memory.place, road.lengths[path], work.tracking.aim
    near_x, near_y, _, _ = point_at(road, path, place)
    end_x, end_y, _, _ = point_at(road, path, length)
    aim.x, aim.y, aim.heading, _ = point_at(road, path, min(place + gain.reach, length))
    bearing = wrapped_compiled(math.atan2(aim.y - robot.y, aim.x - robot.x) - robot.heading)
    off = math.hypot(near_x - robot.x, near_y - robot.y)
    remaining = math.hypot(end_x - robot.x, end_y - robot.y)
    alpha, most, turning, distance = next_mode(
        state, ranges, fresh, robot, bearing, place, off, remaining, gain.ro_min, dt, gain.mount.walls
    )
    mode = state.mode
    avoids = mode != TRACK
    v, w = most, turning
    if mode == TRACK:
        v, w = _at_most(command.first, min(most, CATCH_UP_SPEED)), command.second
    elif mode == AVOID:
        turn = alpha - bearing + state.way * theta_at(distance, gain, rules[int(gain.theta_begin) :], work)
        aim.v, aim.w = due.v, due.w
        # Rule 11 does not act: the target counts as ahead.
        _, w, _ = toward(robot, aim, 1.0, turn, False, gain.cooperation.tracker, rules, work.tracking)
    v = _at_most(v, _in_time(due.v, due.s, place, off, mode))
    if avoids:
        command.say.place -= off  # the others wait for the way back to the path as well
    # Case studies 2 and 3. The wait is bounded: the other may be waiting as well, which would be a deadlock.
    passing = _lets_pass(robot, gain, known, i, avoids)
    memory.waits = memory.waits + dt if passing else 0.0
    stands = passing and memory.waits <= LONGEST_WAIT
    if stands and avoids:
        state.stalled -= dt  # a robot that lets another pass is not stuck
    near = gain.near + gain.widening
    stops = _must_stop(robot, near, known, i)
    aside = 0.0 if stops else _aside(robot, near, known, i)
    stops |= stands
    if stands or (stops and mode == TRACK):
        w = 0.0
    elif aside != 0:
        w = TURN_AWAY * aside
    stops |= aside != 0
    if stops:
        v = 0.0
    halted = stand_still(memory.watch, fresh, robot.v, robot.w, dt)
    front = min(ranges.front_left, ranges.front_right)
    leaves = halted and front > LEAVING_ROOM and not stops
    if halted:
        v, w = min(front - STOP_DISTANCE, LEAVING_SPEED) if leaves else 0.0, 0.0
    code = float(YIELD) if stops or (halted and not leaves) else mode
    return v, w, code + LEFT_BEHIND if alone and avoids else code, avoids and not alone


@compiled_only
def _at_most(value, bound):  # type: ignore[no-untyped-def]
    """The lesser of two numbers, the first of which may be not-a-number, and then is passed on."""
    return bound if value > bound else value


@compiled_only
def _in_time(due_v, due_s, place, off, mode):  # type: ignore[no-untyped-def]
    """The speed [m/s] above which a robot would get farther along its path than the others are.

    The bound holds off the path only, where the target is not the sample due. The way back to the path counts as
    way still to be driven. The bound is never 0, for a robot that stops counts as stuck.
    """
    if mode == TRACK:
        early, slowest, free = place - due_s, JOINING_SPEED, off <= ON_PATH
    else:
        early, slowest, free = place - off - due_s, CREEP_SPEED, mode == FOLLOW
    return np.inf if free else max(due_v - early / EARLY_TIME, slowest)


@equation
def avoid_obstacles(robot, gain, memory, command, work, known, i, rules):  # type: ignore[no-untyped-def]
    """Look, choose a mode, steer, and say so."""
    _look(robot, gain, memory, work, known, i)
    committed, alone = gain.variant == _VARIANT.committed, memory.state.stalled > gain.patience
    avoids, turn, slowing, front = False, 0.0, 1.0, np.inf
    if committed:
        alone = alone and memory.state.mode != TRACK
    else:
        theta = rules[int(gain.theta_begin) :]
        avoids, turn, slowing, front = sight_of(SonarColumns(memory.ranges), gain, theta, work)
    steered(robot, gain.cooperation, memory, command, work.tracking, known, i, turn, alone, False)
    if committed:
        v, w, mode, avoids = _committed(robot, gain, memory, command, work, known, i, alone)
    else:
        v, w, mode, avoids = _literal(robot, gain, memory, command, work, known, i, alone, avoids, slowing, front)
    command.first, command.second, command.wish_v, command.wish_w = v, w, v, w
    command.mode, command.say.avoids = mode, 1.0 if avoids else 0.0
    tell_whereabouts(command.say.where, robot)


@dataclass(frozen=True, kw_only=True)
class ObstacleAvoidance(EquationLaw):
    """Obstacle avoidance: from where on and how far to turn away, and the cooperation underneath."""

    variant: Variant = "committed"
    ro_min: float = quantity(0.5, "m", above=0.15, most=2)  # the thesis's scheme wants 0.8
    theta: float = quantity(1.0, "1", least=0, most=2)  # what Θ(ro) is multiplied by
    reach: float = quantity(0.5, "m", above=0)  # "committed": how far ahead the target is held while avoiding
    patience: float = quantity(15.0, "s", above=0)  # the group waits no longer for a robot without progress
    near: float = quantity(0.34, "m", above=0)  # "committed": at rest, another ahead and nearer (by centers) stops it
    d_pass: float = quantity(0.75, "m", least=0, most=5)  # a robot that avoids is let pass where it is nearer
    push: float = quantity(0.6, "rad", least=0, most=3)  # "literal": the turn away from a side reading
    push_range: float = quantity(0.35, "m", least=0)  # "literal": a side reading below this turns the robot
    rule_base: str | Sugeno = "tracking"
    theta_rule_base: str | Sugeno = "theta"
    cooperation: FuzzyCooperation = field(init=False, repr=False)
    turn: CompiledSugeno = field(init=False, repr=False, compare=False)

    yields = True
    tasks = MappingProxyType({"tracking": "rule_base", "theta": "theta_rule_base"})
    needs = tuple(SONAR)  # two on the nose and one on each side

    def __post_init__(self) -> None:
        super().__post_init__()
        kind: Any = "repaired" if self.variant == "committed" else "lag-clock"
        # No steering distance: a robot that comes round an obstacle must be back on its path within decimetres. And no
        # catching up: no robot hurries among obstacles that it does not know.
        below = FuzzyCooperation(variant=kind, rule_base=self.rule_base, steering_distance=0.0, catch_up=1.0)
        object.__setattr__(self, "cooperation", below)
        object.__setattr__(self, "turn", compiled_curve(self.theta_rule_base, "Θ", "the distance"))

    @property
    def idle(self) -> frozenset[str]:
        """The parameters that have no effect in this variant."""
        return frozenset({"push", "push_range"} if self.variant == "committed" else {"reach", "near"})

    @property
    def fuzzy_systems(self) -> Mapping[str, Sugeno]:
        """For "literal" those of the cooperation, and "theta" with ro as its input; "committed" is not only rules."""
        if self.variant == "committed":
            return {}
        return {**self.cooperation.fuzzy_systems, "theta": self.turn.fis}

    @property
    def diagrams(self) -> tuple[StateDiagram, ...]:
        """The modes of its variant, thesis Fig 6.26; and whether the group waits for the robot."""
        return (COMMITTED_DIAGRAM if self.variant == "committed" else LITERAL_DIAGRAM, GROUP_DIAGRAM)

    def misgivings(self, setting: Setting) -> tuple[str, ...]:
        """Say which robots are so large that its distances to obstacles do not suit them."""
        across = [2 * robot.turning_circle for robot in setting.robots]
        large = [i for i, diameter in enumerate(across, start=1) if diameter > TOO_LARGE * STATED_FOR]
        if not large:
            return ()
        who = f"robot{'s' * (len(large) > 1)} {', '.join(map(str, large))} {'are' if len(large) > 1 else 'is'}"
        return (
            f"{setting.name}: this law's distances to obstacles are those of a robot that turns in a circle of "
            f"{STATED_FOR:.2f} m; {who} up to {max(across):.2f} m across and may touch what is to be avoided. "
            "fuzzy-team goes by the robots' own sizes",
        )

    equation = avoid_obstacles
    says, remembers, works, derived = ObstacleMessage, ObstacleMemory, ObstacleWork, ObstacleDerived
    aims = progresses = has_modes = True

    def derive(self, setting: Setting) -> Mapping[str, Any]:
        """Where Θ begins and the ends of its range, the robots' size, and where their sonars are."""
        begin, (close, far) = sum(map(len, self.cooperation.rule_rows())), self.turn.fis.inputs[0].universe
        sizes = {"widening": wider(setting.robots), "mount": mounting(setting.sensors)}
        return {"theta_begin": begin, "close": close, "far": far, **sizes}

    def rule_rows(self) -> Sequence[np.ndarray]:
        """The rule bases of the cooperation, and Θ."""
        return *self.cooperation.rule_rows(), self.turn.system

    def begin(self, setting: Setting, runs: int) -> np.ndarray:
        """Let all robots track. Raises ControllerError where the graph is not connected."""
        memory = ObstacleMemory.zeros(runs, len(setting.robots))
        memory.array[: CooperationMemory.size] = self.cooperation.begin(setting, runs)
        memory.ranges[...] = np.inf
        nothing_watched(memory.watch)
        return memory.array
