"""Right of way: robots on crossing paths that never touch and never deadlock; thesis 6.1, by another method.

The plan of :mod:`robotics.laws.avoidance.planned_way` says where each robot is at each moment of a common clock; where
there is none, the team is refused before it starts. Every robot keeps a copy z of the clock, follows its own plan by
it, and tells the others how far it has come:

    z_i' = clip(1 − (d_i − d0)/d1, 0, 1) (1 − e^{−t}),  then  z_i := min(z_i, z_j)

with d_i the largest lag [m] behind the plan of which robot i knows, its own or another's, d0 = ``slack`` and d1 =
``softness``. A robot that is late, or not heard of any more, thus slows the clocks of all: robots that the plan keeps
apart by the clock stay apart in space, whichever is held up. Each robot drives to its place due by the tracker,
(2.30) and (2.32) of :mod:`robotics.laws.tracking.lyapunov`, whose stability condition holds here too. The clocks of two
robots may differ by ``margin`` before the plan's clearance is lost.

Against what no plan foresees (a robot off its path, a message too late) each robot brakes by itself: it stops while
another is ahead of it, within ``near`` and its own braking distance. Both distances between centers are stated for
robots as large as the EtsRo; between others there is the same room. Where two robots stand in each other's way, the
one with the lower number goes first (:mod:`robotics.laws.avoidance.priority`).
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from fuzzy.compiled.columns import Columns, column, within
from fuzzy.compiled.jit import compiled_only
from fuzzy.quantity import quantity
from robotics.laws.avoidance.planned_way import CLOCK_MARGIN, planned_timing
from robotics.laws.avoidance.priority import WhereaboutsColumns, stops_for, tell_whereabouts, wider
from robotics.laws.equation import EquationLaw, HeardColumns, Memory, equation
from robotics.laws.law import check_connected, check_team
from robotics.laws.modes import TRACK, YIELD, StateBox, StateDiagram, Transition
from robotics.laws.setting import Setting
from robotics.laws.teams.neighbours import OUTAGE, SEARCH_REACH_AFTER_OUTAGE, reach
from robotics.laws.tracking.lyapunov import Lyapunov, track
from robotics.world.paths.road import CELLS, at, nearest, planned
from robotics.world.radio.channel import predicted
from robotics.world.vehicle.robot import Robot


class WayMessage(Columns):
    """What every robot broadcasts."""

    place = column("1", "share of its path")
    clock = column("s", "of the nominal duration")
    pace = column("1", "of that clock")
    where = within(WhereaboutsColumns)


class WayHeard(HeardColumns):
    """What one robot has heard of another."""

    said = within(WayMessage)


class WayMemory(Columns):
    """What the law remembers."""

    clock = column("s", "of the nominal duration, up to the plan's end")
    pace = column("1", "of that clock")
    place = column("m", "the abscissa of its nearest point")


class WayDerived(Columns):
    """What the law makes of its setting."""

    near = column("m", "the emergency rule's distance at rest, for robots of this size")
    found = column("1", "1: the run has a plan")


_DIAGRAM = StateDiagram(
    {
        TRACK: StateBox("tracking", "the Lyapunov law to the place that the plan has due, by the clock of all"),
        YIELD: StateBox("standing", "v = ω = 0; the clocks of all slow down"),
    },
    (
        Transition(TRACK, YIELD, "another robot is ahead, nearer than near and the braking distance"),
        Transition(YIELD, TRACK, "none is, or that one has the higher number and drives towards it"),
    ),
)


@equation
def right_of_way(robot, gain, memory, command, known, i, road, path):  # type: ignore[no-untyped-def]
    """Run the clock, look up the plan, track it, and brake."""
    clock, found, length, robots = memory.clock, gain.found > 0, road.lengths[path], known.heard.shape[2]
    place = nearest(road, path, robot.x, robot.y, memory.place, reach(known.heard, i, known.time))
    own, slope = planned(road, path, clock)
    worst = max(own * length - place, _worst_lag(i, known))
    pace = min(max(1 - (worst - gain.slack) / gain.softness, 0.0), 1.0) * (1 - math.exp(-known.time))
    pace = pace if found else 0.0
    # the plan and the tracker
    v_d = slope * CELLS / road.durations[path] * pace * length
    s = min(own * length, place + gain.reach)
    target = command.target
    target.x, target.y, target.heading, curvature = at(road, path, s)
    target.v, target.w, target.s = v_d, v_d * curvature, s
    v, w = track(robot, target, gain.tracker)
    stops = False
    for j in range(robots):
        heard = WayHeard(known.heard, i, j)
        if heard.hears > 0 and stops_for(heard.said.where, heard.age, robot, gain.near, i % robots < j):
            stops = True
            break
    if stops or not found:
        v, w = 0.0, 0.0
    command.first, command.second, command.wish_v, command.wish_w = v, w, v, w
    command.progress = place / length
    command.mode = YIELD if stops and found else TRACK
    command.refused = 0.0 if found else 1.0
    say = command.say
    say.place, say.clock, say.pace = place / length, clock, pace
    tell_whereabouts(say.where, robot)
    memory.clock = _least_clock(i, known, min(clock + known.dt * pace, road.ends[path]))
    memory.pace, memory.place = pace, place


@compiled_only(forceinline=True)
def _worst_lag(i, known):  # type: ignore[no-untyped-def]
    """The largest lag [m] behind the plan that lane i has heard of.

    A message says where its sender was and what its clock showed then: its delay adds no lag of its own.
    """
    road, robots, worst = known.road, known.heard.shape[2], -np.inf
    first = known.path[i] - i % robots
    for j in range(robots):
        heard = WayHeard(known.heard, i, j)
        if heard.hears > 0 and not math.isnan(heard.said.place):
            due, _ = planned(road, first + j, heard.said.clock)
            worst = max(worst, (due - heard.said.place) * road.lengths[first + j])
    return worst


@compiled_only(forceinline=True)
def _least_clock(i, known, clock):  # type: ignore[no-untyped-def]
    """z := min(z, z_j) over the clocks that lane i has heard of, as they will be in the next period."""
    for j in range(known.heard.shape[2]):
        heard = WayHeard(known.heard, i, j)
        theirs = predicted(heard.said.clock, heard.said.pace, heard.age) + known.dt
        if heard.hears > 0 and theirs < clock:
            clock = theirs
    return clock


@dataclass(frozen=True, kw_only=True)
class RightOfWay(EquationLaw):
    """Right of way: distances of the plan and of the emergency rule, and the tracker."""

    clearance: float = quantity(0.5, "m", above=0.31)  # between centers of robots as large as the EtsRo, in the plan
    margin: float = quantity(CLOCK_MARGIN, "s", least=0, most=60)  # how far two clocks may differ
    slack: float = quantity(0.05, "m", least=0)  # d0: a lag that does not slow the clock
    softness: float = quantity(0.15, "m", above=0)  # d1: a lag of d0 + d1 stops it
    near: float = quantity(0.34, "m", above=0)  # likewise: the emergency rule's distance at rest
    reach: float = quantity(0.5, "m", above=0)  # the target is no farther ahead of the robot's place
    tracker: Lyapunov = field(default_factory=Lyapunov)

    yields = True
    watchdog = OUTAGE  # s
    diagrams = (_DIAGRAM,)  # tracking and standing
    equation = right_of_way
    says, remembers, derived = WayMessage, WayMemory, WayDerived
    aims = progresses = has_modes = may_refuse = True

    @property
    def safety_distance(self) -> float:
        """The clearance of its plan [m], for robots as large as the EtsRo."""
        return self.clearance

    def distance_between(self, robots: Sequence[Robot]) -> float:
        """The clearance of its plan [m], with as much room beyond the turning circles whatever the robots' size."""
        return self.clearance + wider(robots)

    def init(self, setting: Setting, runs: int) -> Memory:
        """Make the plans. Raises ControllerError where the graph is not connected, or a scenario has no safe plan.

        In an ensemble the runs without a plan are refused: ``Command.refused`` says which.
        """
        check_team(setting)
        check_connected(setting)
        plan = planned_timing(setting, self.distance_between(setting.robots), self.margin)
        return super().init(replace(setting, references=plan), runs)  # from now on it is what they refer to

    def derive(self, setting: Setting) -> Mapping[str, Any]:
        """The distance of the brake, and whether each run has a plan."""
        plan: Any = setting.references  # of :meth:`init`
        found = np.repeat(plan.found, len(setting.robots), axis=1)
        return {"near": self.near + wider(setting.robots), "found": found}

    def begin(self, setting: Setting, runs: int) -> np.ndarray:
        """The clocks at 0, and where on its path each robot starts."""
        memory = WayMemory.zeros(runs, len(setting.robots))
        memory.place = setting.starting_places(runs, np.zeros(1), SEARCH_REACH_AFTER_OUTAGE)
        return memory.array
