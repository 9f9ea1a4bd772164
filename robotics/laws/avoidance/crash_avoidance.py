"""Crash avoidance by priorities, thesis 6.1: fuzzy cooperation whose robots turn away from each other, and stop.

Robots tell each other where they are. A robot that is no farther than d_min from a robot of lower number stands still
until that one has moved away; a robot that is as near to robots of higher number only drives on, and turns:

    d_ij ≤ d_min, j < i  ⇒  v_i = ω_i = 0                                (6.5)
    otherwise  α_i(new) = λ_i + α_i + η_i                                (6.4), λ of (2.36)
    η_i = −Σ_j sign(bearing of j) η(d_ij)                                away from the others

with η(d_ij) the rule base ``eta``: 0 at d_min, and still growing where two robots overlap, so that a robot that has
driven into another is turned away from it and not let through. Bearings and distances follow from the messages, whose
places are measured.

Chosen here: a robot that stands has ω = 0, where the printed ω(n + 1) = ω(n) would leave it spinning. The number alone
decides who stands, as the thesis's text says; the printed condition x_j < x_i says nothing of two robots side by side.

Variants, by the clock of :mod:`robotics.laws.teams.cooperation`:

"literal": the clock as printed, 1 − tanh(Σ d_RP²); it all but stops while a robot waits. λ as printed is that of the
global y (``lateral`` "world"), which is wrong on every path that does not run along +x.
"lag-clock": the clock waits only for robots that lag.
"yielding": the clock does not wait for robots that yield either; the target is held near the robot, which may turn on
the spot. A d_min of 0.9 to 1 m suits it best.

There is no proof that robots keep apart, and they do not always: a robot that waits on another's path is run into, and
the other waits for nobody. The law shows how far local rules carry, and is measured beside
:mod:`robotics.laws.avoidance.right_of_way`.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import Any, Literal

import numpy as np

from fuzzy.compiled.columns import Columns, codes, column, several, within
from fuzzy.compiled.jit import compiled_only, without_refcounts
from fuzzy.compiled.packed import PackedColumns, evaluate_packed
from fuzzy.compiled.sugeno import CompiledSugeno
from fuzzy.quantity import quantity
from fuzzy.system import Sugeno
from robotics.laws.avoidance.ends import near_ends
from robotics.laws.avoidance.ends import told as told_of_ends
from robotics.laws.equation import EquationLaw, HeardColumns, equation
from robotics.laws.modes import TRACK, YIELD, StateBox, StateDiagram, Transition
from robotics.laws.setting import Setting
from robotics.laws.teams.cooperation import CooperationMemory, CooperationMessage, FuzzyCooperation, steered
from robotics.laws.tracking.fuzzy_tracking import Lateral, TrackingWork, compiled_curve, tell_inputs
from robotics.world.paths.posture import wrapped_compiled

# Thesis Fig 6.7
_DIAGRAM = StateDiagram(
    {
        TRACK: StateBox("tracking", "Table 5.6 at λ + α + η (6.4); η is 0 unless another robot is within d_min"),
        YIELD: StateBox("standing", "v = ω = 0 (6.5)"),
    },
    (
        Transition(TRACK, YIELD, "a robot of lower number is within d_min"),
        Transition(YIELD, TRACK, "no robot of lower number is within d_min"),
    ),
)
TOUCHING = 0.3  # m: where two robots touch; η is 1.2 rad there, whatever d_min is
Variant = Literal["literal", "lag-clock", "yielding"]
_VARIANT = codes(Variant)


class CrashMessage(CooperationMessage):
    """What every robot broadcasts: what the cooperation says, and its place."""

    x = column("m")
    y = column("m")


class CrashHeard(HeardColumns):
    """What one robot has heard of another."""

    said = within(CrashMessage)


class CrashDerived(Columns):
    """What the law makes of its rule bases."""

    eta_begin = column("1", "where η begins in the packed rule bases")


class CrashWork(Columns):
    """What the law works in; ``tracking.rest`` is what η is evaluated in, too."""

    asked = several(1, "m", "the input of η")
    said = several(1, "rad", "η")
    tracking = within(TrackingWork)


@without_refcounts
def eta_input(distance, d_min, eta):  # type: ignore[no-untyped-def]
    """The input [m] of the packed rule base ``eta`` for a ``distance`` [m]; d_min [m] is the far end of its range."""
    header = PackedColumns(eta)
    near, far = eta[int(header.low)], eta[int(header.high)]
    stretched = far - (d_min - distance) * (far - TOUCHING) / (d_min - TOUCHING)
    return far if math.isnan(stretched) else min(max(stretched, near), far)


@compiled_only
def turn_at(distance, d_min, factor, eta, work):  # type: ignore[no-untyped-def]
    """|η| [rad] at a ``distance`` [m]: the packed rule base ``eta``, stretched so that it ends at d_min [m]."""
    work.asked[0] = eta_input(distance, d_min, eta)
    evaluate_packed(eta, work.asked, work.said, work.tracking.rest)
    return factor * work.said[0]


@compiled_only
def danger(i, robot, heard, d_min, factor, eta, work):  # type: ignore[no-untyped-def]
    """Judge who is near one robot.

    Args:
        i: The lane.
        robot: Its posture.
        heard: As of Known; what is said are the rows of CrashMessage.
        d_min: [m]
        factor: On η.
        eta: The packed rule base of η.
        work: What it works in, CrashWork.

    Returns whether the robot stands (6.5), η [rad] with its sign (6.4), and how far the nearest robot is that was heard
    [m].
    """
    robots = heard.shape[2]
    stands, turn, nearest = False, 0.0, math.inf
    for j in range(robots):
        one = CrashHeard(heard, i, j)
        if not one.hears > 0:
            continue
        dx, dy = one.said.x - robot.x, one.said.y - robot.y
        distance = math.hypot(dx, dy)
        if distance < nearest:
            nearest = distance
        if not distance <= d_min:  # or never heard
            continue
        stands = stands or j < i % robots
        bearing = wrapped_compiled(math.atan2(dy, dx) - robot.heading)
        size = turn_at(distance, d_min, factor, eta, work)
        if bearing > 0:
            turn += size
        elif bearing < 0:
            turn -= size
    return stands, -turn, nearest


@equation
def avoid_crashes(robot, gain, memory, command, work, known, i, rules):  # type: ignore[no-untyped-def]
    """Stand still by (6.5), or turn by (6.4)."""
    eta, below, tracking = rules[int(gain.eta_begin) :], gain.cooperation, work.tracking
    stands, turn, nearest = danger(i, robot, known.heard, gain.d_min, gain.eta, eta, work)
    excused = stands and gain.variant == _VARIANT.yielding
    steered(robot, below, memory, command, tracking, known, i, turn, excused, False)
    told = tell_inputs(command.inputs, below.tracker, tracking)
    command.inputs[told] = eta_input(nearest, gain.d_min, eta)
    command.say.x, command.say.y = robot.x, robot.y
    command.mode = YIELD if stands else TRACK
    if stands:
        command.first = command.second = command.wish_v = command.wish_w = 0.0


@dataclass(frozen=True, kw_only=True)
class CrashAvoidance(EquationLaw):
    """Crash avoidance: how near is too near, how far to turn, and the cooperation underneath."""

    variant: Variant = "literal"
    d_min: float = quantity(0.6, "m", above=0.31, most=5)
    eta: float = quantity(1.0, "1", least=0, most=5)  # a factor on η(d_ij)
    rule_base: str | Sugeno = ""  # for tracking; if empty, Table 5.6 as printed, or for "yielding" as repaired
    eta_rule_base: str | Sugeno = "eta"
    lateral: Lateral = "none"  # the frame of y_err for λ; "world" is the thesis's
    cooperation: FuzzyCooperation = field(init=False, repr=False)
    turn: CompiledSugeno = field(init=False, repr=False, compare=False)

    yields = True
    diagrams = (_DIAGRAM,)  # tracking and standing, thesis Fig 6.7
    tasks = MappingProxyType({"tracking": "rule_base", "eta": "eta_rule_base"})

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.variant == "yielding":
            # The clock does not make up for the waiting: no robot hurries where others stand in its way.
            below = FuzzyCooperation(rule_base=self.rule_base or "tracking", lateral=self.lateral, catch_up=1.0)
        else:
            below = FuzzyCooperation(
                variant=self.variant,
                rule_base=self.rule_base or "tracking-literal",
                look_ahead=0.05,
                steering_distance=0.0,
                lateral=self.lateral,
            )
        object.__setattr__(self, "cooperation", below)
        object.__setattr__(self, "turn", compiled_curve(self.eta_rule_base, "η", "the distance"))

    @property
    def fuzzy_systems(self) -> Mapping[str, Sugeno]:
        """Those of the cooperation, and "eta", whose input is the distance of the nearest robot."""
        return {**self.cooperation.fuzzy_systems, "eta": self.turn.fis}

    @property
    def safety_distance(self) -> float:
        """d_min of (6.1) [m]."""
        return self.d_min

    def misgivings(self, setting: Setting) -> tuple[str, ...]:
        """Say whose starts or goals are within d_min of each other: by (6.5) one robot then stands until it is not."""
        near = near_ends(setting, self.d_min)
        starts = [pair for pair in near["starts"] if pair[2] < self.d_min]
        found = []
        for what, pairs, then in (
            ("starts", starts, "the robot of higher number does not start before the other is farther away"),
            ("goals", near["goals"], "the robot of higher number may wait for ever once the other is at its goal"),
        ):
            if pairs:
                nearest = min(distance for *_, distance in pairs)
                found.append(
                    f"{setting.name}: {', '.join(told_of_ends(what, pair) for pair in pairs)}, no farther than "
                    f"d_min = {self.d_min:g} m: {then}; move them farther apart, or set d_min below {nearest:.2f} m"
                )
        touching = 2 * max(robot.turning_circle for robot in setting.robots)
        if touching > self.d_min:
            found.append(
                f"{setting.name}: robots as large as these may touch with centers {touching:.2f} m apart, and they "
                f"avoid each other from d_min = {self.d_min:g} m on: make d_min greater"
            )
        return tuple(found)

    equation = avoid_crashes
    says, remembers, works, derived = CrashMessage, CooperationMemory, CrashWork, CrashDerived
    aims = progresses = has_modes = True

    def derive(self, setting: Setting) -> Mapping[str, Any]:
        """Where η begins."""
        return {"eta_begin": sum(map(len, self.cooperation.rule_rows()))}

    def rule_rows(self) -> Sequence[np.ndarray]:
        """The rule bases of the cooperation, and η."""
        return *self.cooperation.rule_rows(), self.turn.system

    def begin(self, setting: Setting, runs: int) -> np.ndarray:
        """Return the memory of the cooperation. Raises ControllerError where the graph is not connected."""
        return self.cooperation.begin(setting, runs)
