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

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import partial
from types import MappingProxyType
from typing import Any

import numpy as np

from fuzzy.compiled.columns import Columns, column, several
from fuzzy.system import Sugeno
from robotics.laws.avoidance.crash_avoidance import CrashAvoidance, CrashMessage, CrashWork, danger, eta_input
from robotics.laws.avoidance.obstacle_avoidance import (
    LITERAL_RISE,
    SONARS,
    ObstacleAvoidance,
    sight_of,
    stalled,
    theta_input,
)
from robotics.laws.avoidance.obstacle_modes import SonarColumns
from robotics.laws.equation import EquationLaw, equation
from robotics.laws.law import ControllerError
from robotics.laws.modes import AVOID, LEFT_BEHIND, TRACK, YIELD, StateBox, StateDiagram, Transition
from robotics.laws.setting import Setting
from robotics.laws.teams.cooperation import CooperationMemory, steered
from robotics.laws.tracking.fuzzy_tracking import tell_inputs
from robotics.world.sensing.sonar import SONAR

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


class HierarchyMemory(CooperationMemory):
    """What the law remembers."""

    ranges = several(SONARS, "m", "the readings, with lost echoes filled in")
    best = column("m", "the largest place on the path")
    stalled = column("s", "for which the robot has avoided since that grew")


class HierarchyDerived(Columns):
    """What the law makes of its rule bases."""

    theta_begin = column("1", "where Θ begins in the packed rule bases")


@equation
def obey_printed_rules(robot, gain, memory, command, work, known, i, rules):  # type: ignore[no-untyped-def]
    """Look and listen, add η and Θ to α, and stand by (6.5)."""
    crash, obstacles, dt = gain.crash, gain.obstacles, known.dt
    eta, theta = rules[int(crash.eta_begin) :], rules[int(gain.theta_begin) :]
    for q in range(SONARS):
        memory.ranges[q] = min(known.ranges[q, i], memory.ranges[q] + LITERAL_RISE * dt)
    stands, away, nearest = danger(i, robot, known.heard, crash.d_min, crash.eta, eta, work)
    avoids, aside, slowing, front = sight_of(SonarColumns(memory.ranges), obstacles, theta, work)
    alone = memory.stalled > obstacles.patience
    steered(robot, crash.cooperation, memory, command, work.tracking, known, i, away + aside, alone, avoids)
    told = tell_inputs(command.inputs, crash.cooperation.tracker, work.tracking)
    command.inputs[told], command.inputs[told + 1] = eta_input(nearest, crash.d_min, eta), theta_input(front, obstacles)
    lost = dt if avoids and not stands else 0.0
    memory.best, memory.stalled = stalled(memory.best, memory.stalled, memory.place, lost)
    v, w, mode = command.first, command.second, TRACK
    if avoids:
        v, mode = v * slowing, AVOID
    if stands:
        v, w, mode = 0.0, 0.0, YIELD
    command.first, command.second, command.wish_v, command.wish_w = v, w, v, w
    command.mode = mode + LEFT_BEHIND if alone else mode
    command.say.x, command.say.y = robot.x, robot.y


@dataclass(frozen=True, kw_only=True)
class FuzzyHierarchy(EquationLaw):
    """The printed rules in one law: crash avoidance with its cooperation, and obstacle avoidance, as its parts."""

    crash: CrashAvoidance = field(default_factory=partial(CrashAvoidance, variant="lag-clock", lateral="world"))
    obstacles: ObstacleAvoidance = field(default_factory=partial(ObstacleAvoidance, variant="literal", ro_min=0.8))

    yields = True
    needs = tuple(SONAR)
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

    equation = obey_printed_rules
    says, remembers, works, derived = CrashMessage, HierarchyMemory, CrashWork, HierarchyDerived
    aims = progresses = has_modes = True

    def derive(self, setting: Setting) -> Mapping[str, Any]:
        """Where Θ begins."""
        return {"theta_begin": sum(map(len, self.crash.rule_rows()))}

    def rule_rows(self) -> Sequence[np.ndarray]:
        """The rule bases of the cooperation, of η and of Θ."""
        return *self.crash.rule_rows(), self.obstacles.turn.system

    def begin(self, setting: Setting, runs: int) -> np.ndarray:
        """Let all robots track. Raises ControllerError where the graph is not connected."""
        memory = HierarchyMemory.zeros(runs, len(setting.robots))
        memory.array[: CooperationMemory.size] = self.crash.begin(setting, runs)
        memory.ranges[...] = np.inf
        return memory.array
