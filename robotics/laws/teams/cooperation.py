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

from collections.abc import Mapping
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import Literal, NamedTuple

import numpy as np

from fuzzy.system import Sugeno
from robotics.laws.law import Command, ControllerError, Law, Observation, check_connected, check_team
from robotics.laws.modes import Box, StateDiagram, Transition
from robotics.laws.setting import Setting
from robotics.laws.teams.neighbours import SEARCH_REACH_AFTER_OUTAGE, search_reach, smallest_heard
from robotics.laws.tracking.fuzzy_tracking import FuzzyTracking
from robotics.paths.trajectory import Reference
from robotics.quantity import check_quantities, quantity

AT_END = 0.04  # m: a robot that is nearer to the end of its path has arrived
ON_PATH = 0.03  # m: a robot that is no farther from its path is on it


# What a robot does, as the lower level chooses it in every period
FOLLOWING, WAITING, JOINING, ARRIVED = range(4)
# Thesis Fig 5.24 as printed: rule 11 decides
RULE_11_DIAGRAM = StateDiagram(
    {
        FOLLOWING: Box("following", "rules 1-10 of Table 5.6: to the sample due"),
        WAITING: Box("waiting", "rule 11 of Table 5.6: v and ω fall to 0"),
    },
    (
        Transition(FOLLOWING, WAITING, "the sample due is behind: x_err < 0"),
        Transition(WAITING, FOLLOWING, "the sample due is ahead: x_err ≥ 0"),
    ),
)
_OFF, _ON, _END = "off its path", "on its path", "the target is the path's end, and near"
REPAIRED_DIAGRAM = StateDiagram(
    {
        WAITING: Box("waiting", "rule 11 of Table 5.6: v and ω fall to 0"),
        JOINING: Box("joining its path", "Table 5.6 to a point of the path ahead, though it may not be due"),
        ARRIVED: Box("arrived", "Table 5.6 to the path's end; rule 11 by the robot's own x"),
        FOLLOWING: Box("following", "Table 5.6 to the sample due, at most reach ahead"),
    },
    (
        Transition(WAITING, JOINING, _OFF),
        Transition(JOINING, WAITING, f"{_ON}, the target is behind"),
        Transition(JOINING, ARRIVED, _END),
        Transition(ARRIVED, JOINING, "the end is not near, off its path"),
        Transition(WAITING, ARRIVED, _END),
        Transition(WAITING, FOLLOWING, "the target is ahead"),
        Transition(FOLLOWING, WAITING, "the target is behind"),
        Transition(JOINING, FOLLOWING, f"{_ON}, the target is ahead"),
        Transition(FOLLOWING, JOINING, _OFF),
        Transition(ARRIVED, FOLLOWING, f"the end is not near, {_ON}"),
        Transition(FOLLOWING, ARRIVED, _END),
    ),
)


class _Memory(NamedTuple):
    """Each field is (runs, robots) unless it says otherwise."""

    clock: np.ndarray  # s: the scenario's time that each robot's copy of the clock shows
    pace: np.ndarray  # 1: of that copy
    place: np.ndarray  # m: abscissa of the nearest point
    lengths: np.ndarray  # (robots,) or (runs, robots) m
    end: np.ndarray  # (1,) or (runs, 1) s: the last reference arrives
    phase: np.ndarray  # FOLLOWING, WAITING, JOINING or ARRIVED


@dataclass(frozen=True, kw_only=True)
class FuzzyCooperation(Law[_Memory]):
    """Fuzzy cooperation: the rule base, how its target is chosen, and the clock."""

    variant: Literal["repaired", "lag-clock", "literal"] = "repaired"
    rule_base: str | Sugeno = "tracking"
    look_ahead: float = quantity(0.4, "s", least=0, most=10)
    steering_distance: float = quantity(0.35, "m", least=0)  # as of the tracking law
    lateral: Literal["none", "path", "world"] = "none"  # as of the tracking law
    reach: float = quantity(0.4, "m", above=0)  # "repaired": the target is no farther ahead of the robot's place
    lag: float = quantity(0.25, "m", least=0)  # d0: a lag that does not slow the clock
    softness: float = quantity(0.4, "m", above=0)  # d1: the lag beyond d0 at which the clock runs at 24 %
    catch_up: float = quantity(1.5, "1", least=1, most=5)  # pace of a clock that is late; "repaired"
    tracker: FuzzyTracking = field(init=False, repr=False)

    message = ("place", "speed", "clock", "pace")
    tasks = MappingProxyType({"tracking": "rule_base"})

    def __post_init__(self) -> None:
        check_quantities(self, ControllerError)
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

    def init(self, setting: Setting, runs: int) -> _Memory:
        """Set the clocks to 0. Raises ControllerError where the robots are no team, or the graph is not connected."""
        robots = len(setting.robots)
        if robots > 1:
            check_team(setting)
        check_connected(setting)
        zero = np.zeros((runs, robots))
        paths = setting.references.joined
        pose = np.broadcast_to(setting.starts, (runs, robots, 3))
        begin = setting.references.at(0.0).s
        near = paths.nearest(pose[..., 0], pose[..., 1], begin, zero + SEARCH_REACH_AFTER_OUTAGE)
        return _Memory(
            zero,
            zero,
            near,
            paths.lengths,
            setting.references.ends.max(axis=-1, keepdims=True),
            np.full(zero.shape, WAITING),
        )

    def control(self, seen: Observation, memory: _Memory, dt: float) -> tuple[Command, _Memory]:
        """Run the clock, and drive towards the sample due by Table 5.6."""
        return self.steered(seen, memory, dt)

    def steered(
        self,
        seen: Observation,
        memory: _Memory,
        dt: float,
        turn: np.ndarray | None = None,
        excused: np.ndarray | None = None,
        no_lateral: np.ndarray | None = None,
    ) -> tuple[Command, _Memory]:
        """Do as :meth:`control`, with a turn added and some robots excused from the clock.

        Args:
            seen: What the robots know.
            memory: As of the period before.
            dt: The control period [s].
            turn: Added to α (runs, robots) [rad]; none by default.
            excused: Robots for which the clock does not wait (runs, robots) bool; they broadcast a place that is not a
                number. None by default.
            no_lateral: Robots to which λ is not added (runs, robots) bool; none by default.
        """
        heard = seen.heard
        paths, lengths = seen.references.joined, memory.lengths
        place = paths.nearest(seen.x, seen.y, memory.place, search_reach(heard, seen.time))
        clock = memory.clock
        due = seen.references.each_at(np.minimum(clock, memory.end))
        theirs = heard.now("place", by="speed")
        if self.variant == "literal":
            apart = np.hypot(due.x - seen.x, due.y - seen.y)  # d_RP
            said, said_rate = apart, np.zeros_like(apart)
            others = np.where(heard.hears & ~np.isnan(theirs), theirs, 0.0)
            slowing = np.tanh(apart**2 + (others**2).sum(axis=-1))
        else:
            said, said_rate = place, (place - memory.place) / dt
            own = due.s - place
            if excused is not None:
                said, own = np.where(excused, np.nan, said), np.where(excused, 0.0, own)
            # All paths have the same timing: what is level with the own place due is due on every path.
            lags = paths.level(due.s) - theirs
            lags = np.where(heard.hears & ~np.isnan(lags), lags, 0.0)
            worst = np.maximum(own, lags.max(axis=-1))
            slowing = np.tanh((np.maximum(worst - self.lag, 0.0) / self.softness) ** 2)
        pace = (1 - np.exp(-seen.time)) * (1 - slowing)
        if self.variant == "repaired":
            pace = pace * (1 + (self.catch_up - 1) * np.clip(seen.time - clock, 0.0, 1.0))
        # The sample to drive to
        late = self.look_ahead * pace if self.variant == "repaired" else self.look_ahead
        target = seen.references.each_at(np.minimum(clock + late, memory.end))
        if self.variant == "repaired":
            target, behind, phase = held(seen, target, place, lengths, self.reach)
        else:
            behind = None
            ahead = np.cos(seen.heading) * (target.x - seen.x) + np.sin(seen.heading) * (target.y - seen.y)
            phase = np.where(ahead >= 0, FOLLOWING, WAITING)
        v, w, inputs = self.tracker.toward_with_inputs(seen, target, behind, turn, no_lateral)
        message = {"place": said, "speed": said_rate, "clock": clock, "pace": pace}
        clock = clock + dt * pace
        if self.variant != "literal":
            theirs = heard.now("clock", by="pace") + dt * np.maximum(heard["pace"], 1.0)
            clock = np.minimum(clock, smallest_heard(clock, theirs, heard.hears))
        after = memory._replace(clock=clock, pace=pace, place=place, phase=phase)
        moving = due._replace(v=due.v * pace, w=due.w * pace)
        return Command(v, w, v, w, message, moving, paths.share(place), inputs=inputs), after


def held(
    seen: Observation, target: Reference, place: np.ndarray, lengths: np.ndarray, reach: float
) -> tuple[Reference, np.ndarray, np.ndarray]:
    """Hold the sample due near the robot, along its path; so that it drives to the path before it drives across it.

    Args:
        seen: What the robots know.
        target: The samples due, each field (runs, robots).
        place: The abscissae of the paths' nearest points (runs, robots) [m].
        lengths: Of the paths [m], (robots,) or (runs, robots).
        reach: How far ahead of the robot's place the target is at most [m].

    Returns the target, how far it is ahead [m], as rule 11 takes it, and what the robot does: FOLLOWING, WAITING,
    JOINING or ARRIVED; each (runs, robots).
    """
    paths = seen.references.joined
    near = paths.at(place)
    off = np.hypot(near.x - seen.x, near.y - seen.y)
    dx, dy = target.x - seen.x, target.y - seen.y
    ahead = np.cos(seen.heading) * dx + np.sin(seen.heading) * dy
    phase = np.where(target.s >= place, FOLLOWING, WAITING)
    phase = np.where(off > ON_PATH, JOINING, phase)
    phase = np.where((target.s >= lengths) & (np.hypot(dx, dy) < AT_END), ARRIVED, phase)
    over, joining = phase == ARRIVED, phase == JOINING
    # At the path's end the nearest point is the end from both sides: there the robot's own x tells.
    behind = np.where(over, np.where(ahead > 0, ahead, -1.0), target.s - place)
    at = np.minimum(target.s, place + reach)
    # A robot that is ahead of time but off its path drives to the path before it waits.
    behind = np.where(joining, np.maximum(behind, off), behind)
    at = np.where(joining, np.maximum(at, place + np.minimum(off, reach) / 2), at)
    point = paths.at(at)
    return Reference(point.x, point.y, point.heading, target.v, target.v * point.curvature, at), behind, phase
