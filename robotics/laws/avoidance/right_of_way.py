"""Right of way: robots on crossing paths that never touch and never deadlock; thesis 6.1, by another method.

The plan of :mod:`robotics.laws.avoidance.reservation` says where each robot is at each moment of a common clock. Every
robot keeps a copy z of the clock, follows its own plan by it, and tells the others how far it has come:

    z_i' = clip(1 − (d_i − d0)/d1, 0, 1) (1 − e^{−t}),  then  z_i := min(z_i, z_j)

with d_i the largest lag [m] behind the plan of which robot i knows, its own or another's, d0 = ``slack`` and d1 =
``softness``. A robot that is late, or not heard of any more, thus slows the clocks of all: robots that the plan keeps
apart by the clock stay apart in space, whichever is held up. Each robot drives to its place due by the tracker,
(2.30) and (2.32) of :mod:`robotics.laws.tracking.lyapunov`, whose stability condition holds here too. The clocks of two
robots may differ by ``margin`` before the plan's clearance is lost.

Where there is no plan because a robot waits at its start or is parked at its end on another's path, the other's path is
bent around it (:mod:`robotics.laws.avoidance.sidestep`); where many meet in one place, they go round it. If that is not
enough, robots come a little nearer to each other, and at last some may arrive early. Where there is still no plan, the
team is refused before it starts.

Against what no plan foresees (a robot off its path, a message too late) each robot brakes by itself: it stops while
another is ahead of it, within ``near`` and its own braking distance. Where two robots stand in each other's way, the
one with the lower number goes first (:mod:`robotics.laws.avoidance.priority`).
"""

from dataclasses import dataclass, field, replace
from typing import NamedTuple

import numpy as np

from fuzzy.compiled.jit import kernel
from robotics.laws.avoidance.ends import near_ends, told
from robotics.laws.avoidance.priority import WHEREABOUTS, blocked, others, whereabouts
from robotics.laws.avoidance.reservation import CELLS, Plan, plan_right_of_way
from robotics.laws.avoidance.sidestep import roundabout, sidestepped
from robotics.laws.law import Command, ControllerError, Law, Observation, check_connected, check_team
from robotics.laws.modes import TRACK, YIELD, Box, StateDiagram, Transition
from robotics.laws.setting import Setting
from robotics.laws.teams.neighbours import OUTAGE, SEARCH_REACH_AFTER_OUTAGE, search_reach, smallest_heard
from robotics.laws.tracking.lyapunov import Lyapunov
from robotics.paths.joined import PathTable, join_tables
from robotics.paths.trajectory import Reference
from robotics.quantity import check_quantities, quantity

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
PLANNED_SPREAD = 0.6  # s: within which the plan lets all arrive
SIDESTEP_MARGIN = 0.1  # m: how much farther than the clearance a side-step goes
LONG = 1.6  # times the nominal duration: for a longer plan, a roundabout is tried too


class _Way(NamedTuple):
    """One way to find a plan where the paths as they are have none."""

    bent: bool  # paths are bent around who waits or is parked on them
    mirrored: bool = False  # they are bent to the other side
    clearance_scale: float = 1.0  # a factor on the clearance
    together: bool = True  # all arrive together
    rounded: bool = False  # a roundabout where many meet

    def bent_paths(self, tables: list[np.ndarray], clear: float) -> list[np.ndarray] | None:
        """The tables of one run's paths bent to keep ``clear`` [m] in this way; None where it does not apply."""
        if self.rounded:
            around = roundabout(tables, clear)
            if around is None:
                return None
            tables = around
        return sidestepped(tables, clear, self.mirrored) if self.bent else tables


_WAYS = (
    _Way(False, rounded=True),
    _Way(False, clearance_scale=0.9, rounded=True),
    _Way(False, clearance_scale=0.85, rounded=True),
    _Way(True),
    _Way(True, True),
    _Way(False, clearance_scale=0.9),
    _Way(True, clearance_scale=0.9),
    _Way(True, True, clearance_scale=0.9),
    _Way(False, together=False),
    _Way(True, together=False),
    _Way(True, True, together=False),
    _Way(True, clearance_scale=0.85, together=False),
)


class _Memory(NamedTuple):
    """Each field is (runs, robots) unless it says otherwise."""

    clock: np.ndarray  # s of the nominal duration, up to the plan's end
    pace: np.ndarray  # 1: of that clock
    place: np.ndarray  # m: abscissa of the nearest point
    plan: np.ndarray  # (runs, robots, ticks + 1)
    end: np.ndarray  # (runs, 1) s: the plan's duration
    duration: np.ndarray  # (runs, 1) s: the nominal one
    found: np.ndarray  # (runs, 1) bool: whether there is a plan; robots without one stay where they are
    paths: PathTable  # the paths as they are driven, side-steps included


@dataclass(frozen=True, kw_only=True)
class RightOfWay(Law[_Memory]):
    """Right of way: distances of the plan and of the emergency rule, and the tracker."""

    clearance: float = quantity(0.5, "m", above=0.31)  # between centers, in the plan
    margin: float = quantity(1.2, "s", least=0, most=60)  # how far two clocks may differ
    slack: float = quantity(0.05, "m", least=0)  # d0: a lag that does not slow the clock
    softness: float = quantity(0.15, "m", above=0)  # d1: a lag of d0 + d1 stops it
    near: float = quantity(0.34, "m", above=0)  # the emergency rule's distance at rest
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
        """The clearance of its plan [m]."""
        return self.clearance

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
        robots = len(setting.robots)
        spans = np.atleast_2d(setting.references.ends)[:, :1]
        plan, paths, longer = self._planned(setting.references.joined, robots, spans[:, 0])
        if not setting.ensemble and not plan.found.any():
            near = near_ends(setting, self.clearance)
            pairs = "".join(f"{told(what, pair)}; " for what in near for pair in near[what])
            raise ControllerError(
                f"{setting.name}: there is no safe plan: {pairs}no order of the robots, no side-step around who "
                f"waits or is parked, and no horizon up to 3.4 times the duration keeps them {self.clearance:g} m "
                "apart; move starts or ends away from each other's paths"
            )
        duration = longer[:, None] * spans
        zero = np.zeros((runs, robots))
        pose = np.broadcast_to(setting.starts, (runs, robots, 3))
        place = paths.nearest(pose[..., 0], pose[..., 1], zero, zero + SEARCH_REACH_AFTER_OUTAGE)
        return _Memory(
            zero,
            zero,
            place,
            np.ascontiguousarray(np.broadcast_to(plan.progress, (runs, *plan.progress.shape[1:]))),
            np.broadcast_to(plan.factor[:, None] * duration, (runs, 1)),
            np.broadcast_to(duration, (runs, 1)),
            np.broadcast_to(plan.found[:, None], (runs, 1)),
            paths,
        )

    def _planned(self, paths: PathTable, robots: int, durations: np.ndarray) -> tuple[Plan, PathTable, np.ndarray]:
        """The plan of every run, the paths that it is for, and a factor (runs,) on the nominal duration.

        The plan is that of the first of the ways that has one, or that of the quickest roundabout where there are any.
        The nominal duration grows with the longest path. ``durations`` [s] is () or (runs,).
        """
        nodes = _nodes(paths, robots)
        durations = np.broadcast_to(durations, len(nodes))
        longer = np.ones(len(nodes))
        margin, together = np.minimum(self.margin / durations, 1.0), np.minimum(PLANNED_SPREAD / durations, 1.0)
        plan = plan_right_of_way(nodes, self.clearance, margin, together=together)
        if (plan.found & (plan.factor <= LONG)).all():
            return plan, paths, longer
        tables = [
            [paths.table[:, f : f + c + 1] for f, c in zip(first, cells, strict=True)]
            for first, cells in zip(paths.first.reshape(-1, robots), paths.cells.reshape(-1, robots), strict=True)
        ]
        original = list(tables)
        longest = np.broadcast_to(paths.lengths.reshape(-1, robots).max(axis=1), len(nodes))
        for way in _WAYS:
            rest = np.flatnonzero(~plan.found | (way.rounded & (longer * plan.factor > LONG)))
            clear = way.clearance_scale * self.clearance
            bent = [way.bent_paths(original[r], clear + SIDESTEP_MARGIN) for r in rest]
            rest = rest[[tables is not None for tables in bent]]
            tried = [tables for tables in bent if tables is not None]
            if not tried:
                continue
            bends = join_tables(tried)
            growth = np.maximum(bends.lengths.reshape(-1, robots).max(axis=1) / longest[rest], 1.0)
            span = together[rest] / growth if way.together else None
            found = plan_right_of_way(_nodes(bends, robots), clear, margin[rest] / growth, together=span)
            quicker = ~plan.found[rest] | (growth * found.factor < longer[rest] * plan.factor[rest])
            for k in np.flatnonzero(found.found & quicker):
                tables[rest[k]] = tried[k]
                longer[rest[k]] = growth[k]
                for mine, theirs in zip(
                    (plan.progress, plan.found, plan.factor), (found.progress, found.found, found.factor), strict=True
                ):
                    mine[rest[k]] = theirs[k]
        joined = join_tables(tables)
        return plan, replace(joined, lengths=joined.lengths.reshape(paths.lengths.shape)), longer

    def control(self, seen: Observation, memory: _Memory, dt: float) -> tuple[Command, _Memory]:
        """Run the clock, look up the plan, track it, and brake."""
        heard = seen.heard
        paths, lengths = memory.paths, memory.paths.lengths
        place = paths.nearest(seen.x, seen.y, memory.place, search_reach(heard, seen.time))
        # the clock
        own, rate = _due(memory.plan, memory.clock[:, None] / memory.duration[..., None] * CELLS)
        own, rate = own[:, 0], rate[:, 0]
        # A message says where its sender was and what its clock showed then: its delay adds no lag of its own.
        their_share, their_clock = heard["place"], heard["clock"]
        due, _ = _due(memory.plan, np.nan_to_num(their_clock) / memory.duration[..., None] * CELLS)
        lags = np.where(heard.hears & ~np.isnan(their_share), (due - their_share) * lengths[..., None, :], -np.inf)
        worst = np.maximum(own * lengths - place, lags.max(axis=-1))
        pace = np.clip(1 - (worst - self.slack) / self.softness, 0.0, 1.0) * (1 - np.exp(-seen.time)) * memory.found
        # the plan and the tracker
        speed = rate * CELLS / memory.duration * pace * lengths
        wanted = np.minimum(own * lengths, place + self.reach)
        point = paths.at(wanted)
        target = Reference(point.x, point.y, point.heading, speed, speed * point.curvature, wanted)
        wish, _ = self.tracker.control(seen._replace(reference=target), None, dt)
        stops = blocked(seen, others(seen), self.near)
        brake = stops | ~memory.found
        mode = np.where(stops & memory.found, YIELD, TRACK)
        v, w = np.where(brake, 0.0, wish.v), np.where(brake, 0.0, wish.w)
        share = place / lengths
        message = {"place": share, "clock": memory.clock, "pace": pace, **whereabouts(seen)}
        clock = np.minimum(memory.clock + dt * pace, memory.end)
        clock = np.minimum(clock, smallest_heard(clock, heard.now("clock", by="pace") + dt, heard.hears))
        after = memory._replace(clock=clock, pace=pace, place=place)
        return Command(v, w, v, w, message, target, share, ~memory.found[:, 0], mode), after


def _nodes(paths: PathTable, robots: int) -> np.ndarray:
    """Points of the paths at equal shares of their lengths (runs, robots, CELLS + 1, 2) [m]."""
    shares = np.linspace(0, 1, CELLS + 1)
    points = [np.stack(paths.at(share * paths.lengths)[:2], axis=-1) for share in shares]
    return np.stack(points, axis=-2).reshape(-1, robots, CELLS + 1, 2)


@kernel
def _due(plan, ticks):  # type: ignore[no-untyped-def]
    """Each robot's planned share, and its slope a tick, at ``ticks`` (runs, rows, robots); both have that shape."""
    due, rate = np.empty(ticks.shape), np.empty(ticks.shape)
    last = plan.shape[2] - 1
    for r in range(ticks.shape[0]):
        for i in range(ticks.shape[1]):
            for j in range(ticks.shape[2]):
                t = min(max(ticks[r, i, j], 0.0), last - 1e-9)
                k = int(t)
                a, b = plan[r, j, k], plan[r, j, k + 1]
                due[r, i, j] = a + (t - k) * (b - a)
                rate[r, i, j] = b - a
    return due, rate
