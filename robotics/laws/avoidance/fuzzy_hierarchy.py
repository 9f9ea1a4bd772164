"""The printed rules of thesis 6 in one law: fuzzy cooperation, crash avoidance and obstacle avoidance, (6.4) to (6.7).

Each rule is that of the law that has it alone, and is evaluated there:

    a robot of lower number within d_min      ⇒  v = ω = 0                (6.5)
    ro ≤ ro_min                               ⇒  α** = α + η + Θ(ro)      (6.7)
    otherwise                                     α(new) = λ + α + η      (6.4), λ of (2.36)

with η, 0 unless a robot is within d_min, of :mod:`robotics.laws.avoidance.crash_avoidance` from what the robots tell
each other; Θ, with the push from the sides and a speed that falls with ro, of the variant "literal" of
:mod:`robotics.laws.avoidance.obstacle_avoidance` from the sonars; and v, ω by Table 5.6 as printed at that α. The modes
are the two of Fig 6.26, tracking and avoiding, and the standing of (6.5).

Chosen here, where the source is silent:

* η, which knows the robots from their messages, and Θ, which sees whatever is there, are added where both apply: robots
  are obstacles for each other, too. λ is not: (6.7) is printed without it, and it would turn the robot back to its path
  and into the obstacle.
* Θ turns away from the smaller of the two front readings, η away from the other robots.
* The stop of case studies 2 and 3, by which "the robot with less priority" lets another round its obstacle, is (6.5):
  the number alone decides who stands, whether or not anyone avoids. A robot that stands has ω = 0.
* The clock is that of the lag, for the printed one waits for robots that wait for it; it does not wait for a robot that
  has avoided obstacles for longer than ``obstacles.patience`` without progress (case study 4), until it has some. The
  time for which a robot stands is not counted.

Where a scenario has no obstacles, no sonar is read, and this is crash avoidance with the clock of the lag.

There is no proof that robots keep clear of anything or arrive. What is known of the parts holds here: who stands on
another's path is run into; a target pulls its robot back as soon as no cone sees the obstacle, so that it grazes
corners and stays in traps. And a robot may stand for one that waits for the clock, which waits for the robot that
stands.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import partial
from types import MappingProxyType
from typing import Any, NamedTuple

import numpy as np

from fuzzy.system import Sugeno
from robotics.laws.avoidance.crash_avoidance import CrashAvoidance, CrashMessage
from robotics.laws.avoidance.obstacle_avoidance import LITERAL_RISE, ObstacleAvoidance
from robotics.laws.avoidance.obstacle_modes import GROWTH
from robotics.laws.law import Command, ControllerError, Law, Observation
from robotics.laws.modes import AVOID, LEFT_BEHIND, TRACK, YIELD, StateBox, StateDiagram, Transition
from robotics.laws.setting import Setting
from robotics.laws.teams.cooperation import CooperationMemory
from robotics.sensing.sonar import SONAR

_NEAR, _FREE = "ro ≤ ro_min, or a side sonar reads too little", "all sonars read enough"
_STOP, _GO = "a robot of lower number is within d_min", "none is"
# Thesis Fig 6.26, with the stop of Fig 6.7
_DIAGRAM = StateDiagram(
    {
        TRACK: StateBox("tracking", "Table 5.6 at λ + α + η (6.4)"),
        AVOID: StateBox("avoiding", "Table 5.6 at α + η + Θ(ro) (6.7), slower"),
        YIELD: StateBox("standing", "v = ω = 0 (6.5)"),
    },
    (
        Transition(TRACK, AVOID, _NEAR),
        Transition(AVOID, TRACK, _FREE),
        Transition(TRACK, YIELD, _STOP),
        Transition(AVOID, YIELD, _STOP),
        Transition(YIELD, TRACK, f"{_GO}; {_FREE}"),
        Transition(YIELD, AVOID, f"{_GO}; an obstacle is near"),
    ),
)
_GROUP_DIAGRAM = StateDiagram(
    {
        0: StateBox("in the group", "the clock waits for the robot"),
        LEFT_BEHIND: StateBox("left behind", "the clock does not wait for it"),
    },
    (
        Transition(0, LEFT_BEHIND, "it avoids without progress for longer than patience"),
        Transition(LEFT_BEHIND, 0, "progress on its path"),
    ),
    mask=LEFT_BEHIND,
)


class _Memory(NamedTuple):
    """The memory of the cooperation, and what the robots saw; arrays are (runs, robots)."""

    below: Any
    ranges: np.ndarray  # (runs, robots, sensors) m
    best: np.ndarray  # m: the largest place on the path
    stalled: np.ndarray  # s for which the robot has avoided since that grew


@dataclass(frozen=True, kw_only=True)
class FuzzyHierarchy(Law[_Memory]):
    """The printed rules in one law: crash avoidance with its cooperation, and obstacle avoidance, as its parts."""

    crash: CrashAvoidance = field(default_factory=partial(CrashAvoidance, variant="lag-clock", lateral="world"))
    obstacles: ObstacleAvoidance = field(default_factory=partial(ObstacleAvoidance, variant="literal", ro_min=0.8))

    yields = True
    needs = tuple(SONAR)
    message = CrashMessage.leaves()
    tasks = MappingProxyType({"tracking": "crash", "eta": "crash", "theta": "obstacles"})

    def __post_init__(self) -> None:
        if self.crash.variant == "yielding":
            raise ControllerError("crash.variant must be one of 'literal', 'lag-clock'; got 'yielding'")
        if self.obstacles.variant != "literal":
            raise ControllerError(f"obstacles.variant must be 'literal'; got {self.obstacles.variant!r}")

    @property
    def safety_distance(self) -> float:
        """d_min of (6.5) [m]."""
        return self.crash.d_min

    @property
    def idle(self) -> frozenset[str]:
        """The parameters of parts that have no effect: the cooperation is that of ``crash``, and so is who stands."""
        return frozenset({"obstacles.rule_base", "obstacles.d_pass"})

    @property
    def diagrams(self) -> tuple[StateDiagram, ...]:
        """The modes of Fig 6.26 with the stop of Fig 6.7; and whether the group waits for the robot."""
        return (_DIAGRAM, _GROUP_DIAGRAM)

    @property
    def fuzzy_systems(self) -> Mapping[str, Sugeno]:
        """The rule bases of the cooperation, of η and of Θ."""
        return {**self.crash.fuzzy_systems, "theta": self.obstacles.turn.fis}

    def misgivings(self, setting: Setting) -> tuple[str, ...]:
        """Say whose starts or goals are within d_min of each other."""
        return self.crash.misgivings(setting)

    def init(self, setting: Setting, runs: int) -> _Memory:
        """Let all robots track. Raises ControllerError where the graph is not connected."""
        zero = np.zeros((runs, len(setting.robots)))
        nothing = np.full((*zero.shape, len(self.needs)), np.inf)
        return _Memory(self.crash.cooperation.init(setting, runs), nothing, zero, zero)

    def control(self, seen: Observation, memory: _Memory, dt: float) -> tuple[Command, _Memory]:
        """Look and listen, add η and Θ to α, and stand by (6.5)."""
        ranges = memory.ranges
        if seen.ranges is not None:
            ranges = np.minimum(seen.ranges.of(self.needs), ranges + LITERAL_RISE * dt)
        stands, eta, nearest = self.crash.danger(seen)
        avoids, theta, slowing, front = self.obstacles.sight(ranges)
        alone = memory.stalled > self.obstacles.patience
        wish, below = self.crash.cooperation.steered(seen, memory.below, dt, eta + theta, alone, avoids)
        place = CooperationMemory(below.rows).place.reshape(avoids.shape)
        grows = place > memory.best + GROWTH
        best = np.where(grows, place, memory.best)
        lost = np.where(grows, 0.0, memory.stalled + dt * (avoids & ~stands))
        v = np.where(stands, 0.0, np.where(avoids, wish.v * slowing, wish.v))
        w = np.where(stands, 0.0, wish.w)
        mode = np.where(stands, YIELD, np.where(avoids, AVOID, TRACK)) + np.where(alone, LEFT_BEHIND, 0)
        assert wish.message is not None
        assert wish.inputs is not None
        message = {**wish.message, "x": seen.x, "y": seen.y}
        turns = np.stack([self.crash.eta_input(nearest), self.obstacles.theta_input(front)])
        inputs = np.concatenate([wish.inputs, turns])
        command = wish._replace(first=v, second=w, v=v, w=w, message=message, mode=mode, inputs=inputs)
        return command, _Memory(below, ranges, best, lost)
