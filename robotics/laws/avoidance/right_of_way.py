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

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np

from robotics.laws.avoidance.planned_way import CLOCK_MARGIN, PlannedTiming, planned_timing
from robotics.laws.avoidance.priority import WHEREABOUTS, blocked, others, whereabouts, wider
from robotics.laws.avoidance.reservation import CELLS
from robotics.laws.law import Command, ControllerError, Law, Observation, check_connected, check_team
from robotics.laws.modes import TRACK, YIELD, Box, StateDiagram, Transition
from robotics.laws.setting import Setting
from robotics.laws.teams.neighbours import OUTAGE, SEARCH_REACH_AFTER_OUTAGE, search_reach, smallest_heard
from robotics.laws.tracking.lyapunov import Lyapunov
from robotics.paths.trajectory import Reference
from robotics.quantity import check_quantities, quantity
from robotics.vehicle.robot import Robot

DIAGRAM = StateDiagram(
    {
        TRACK: Box("tracking", "the Lyapunov law to the place that the plan has due, by the clock of all"),
        YIELD: Box("standing", "v = ω = 0; the clocks of all slow down"),
    },
    (
        Transition(TRACK, YIELD, "another robot is ahead, nearer than near and the braking distance"),
        Transition(YIELD, TRACK, "none is, or that one has the higher number and drives towards it"),
    ),
)


class _Memory(NamedTuple):
    """Each field is (runs, robots) unless it says otherwise."""

    clock: np.ndarray  # s of the nominal duration, up to the plan's end
    pace: np.ndarray  # 1: of that clock
    place: np.ndarray  # m: abscissa of the nearest point
    plan: PlannedTiming
    wider: float  # m: what the robots' size adds to the distances


@dataclass(frozen=True, kw_only=True)
class RightOfWay(Law[_Memory]):
    """Right of way: distances of the plan and of the emergency rule, and the tracker."""

    clearance: float = quantity(0.5, "m", above=0.31)  # between centers of robots as large as the EtsRo, in the plan
    margin: float = quantity(CLOCK_MARGIN, "s", least=0, most=60)  # how far two clocks may differ
    slack: float = quantity(0.05, "m", least=0)  # d0: a lag that does not slow the clock
    softness: float = quantity(0.15, "m", above=0)  # d1: a lag of d0 + d1 stops it
    near: float = quantity(0.34, "m", above=0)  # likewise: the emergency rule's distance at rest
    reach: float = quantity(0.5, "m", above=0)  # the target is no farther ahead of the robot's place
    tracker: Lyapunov = field(default_factory=Lyapunov)

    message = ("place", "clock", "pace", *WHEREABOUTS)
    yields = True

    def __post_init__(self) -> None:
        check_quantities(self, ControllerError)

    @property
    def watchdog(self) -> float:
        """After how long [s] without a new command a robot stops."""
        return OUTAGE

    @property
    def kept_distance(self) -> float:
        """The clearance of its plan [m], for robots as large as the EtsRo."""
        return self.clearance

    def kept_between(self, robots: Sequence[Robot]) -> float:
        """The clearance of its plan [m], with as much room beyond the turning circles whatever the robots' size."""
        return self.clearance + wider(robots)

    @property
    def diagrams(self) -> tuple[StateDiagram, ...]:
        """Tracking and standing."""
        return (DIAGRAM,)

    def init(self, setting: Setting, runs: int) -> _Memory:
        """Make the plans. Raises ControllerError where the graph is not connected, or a scenario has no safe plan.

        In an ensemble the runs without a plan are refused: ``Command.refused`` says which.
        """
        check_team(setting)
        check_connected(setting)
        plan = planned_timing(setting, self.kept_between(setting.robots), self.margin)
        zero = np.zeros((runs, len(setting.robots)))
        pose = np.broadcast_to(setting.starts, (runs, len(setting.robots), 3))
        place = plan.joined.nearest(pose[..., 0], pose[..., 1], zero, zero + SEARCH_REACH_AFTER_OUTAGE)
        return _Memory(zero, zero, place, plan, wider(setting.robots))

    def control(self, seen: Observation, memory: _Memory, dt: float) -> tuple[Command, _Memory]:
        """Run the clock, look up the plan, track it, and brake."""
        heard, plan = seen.heard, memory.plan
        paths, lengths, found = plan.joined, plan.joined.lengths, plan.found
        place = paths.nearest(seen.x, seen.y, memory.place, search_reach(heard, seen.time))
        # the clock
        own, rate = plan.due(memory.clock[:, None])
        own, rate = own[:, 0], rate[:, 0]
        # A message says where its sender was and what its clock showed then: its delay adds no lag of its own.
        their_share, their_clock = heard["place"], heard["clock"]
        due, _ = plan.due(np.nan_to_num(their_clock))
        lags = np.where(heard.hears & ~np.isnan(their_share), (due - their_share) * lengths[..., None, :], -np.inf)
        worst = np.maximum(own * lengths - place, lags.max(axis=-1))
        pace = np.clip(1 - (worst - self.slack) / self.softness, 0.0, 1.0) * (1 - np.exp(-seen.time)) * found
        # the plan and the tracker
        speed = rate * CELLS / plan.durations * pace * lengths
        wanted = np.minimum(own * lengths, place + self.reach)
        point = paths.at(wanted)
        target = Reference(point.x, point.y, point.heading, speed, speed * point.curvature, wanted)
        wish, _ = self.tracker.control(seen._replace(reference=target), None, dt)
        stops = blocked(seen, others(seen), self.near + memory.wider)
        brake = stops | ~found
        refused = np.broadcast_to(~found[:, 0], len(place))
        mode = np.where(stops & found, YIELD, TRACK)
        v, w = np.where(brake, 0.0, wish.v), np.where(brake, 0.0, wish.w)
        share = place / lengths
        message = {"place": share, "clock": memory.clock, "pace": pace, **whereabouts(seen)}
        clock = np.minimum(memory.clock + dt * pace, plan.end)
        clock = np.minimum(clock, smallest_heard(clock, heard.now("clock", by="pace") + dt, heard.hears))
        after = memory._replace(clock=clock, pace=pace, place=place)
        return Command(v, w, v, w, message, target, share, refused, mode), after
