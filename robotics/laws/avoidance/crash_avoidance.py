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

from collections.abc import Mapping
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import Any, Literal, NamedTuple

import numpy as np

from fuzzy.compiled.sugeno import CompiledSugeno
from fuzzy.system import Sugeno
from robotics.laws.avoidance.ends import near_ends, told
from robotics.laws.law import Command, ControllerError, Law, Observation
from robotics.laws.modes import TRACK, YIELD, Box, StateDiagram, Transition
from robotics.laws.setting import Setting
from robotics.laws.teams.cooperation import FuzzyCooperation
from robotics.laws.tracking.fuzzy_tracking import compiled_curve
from robotics.paths.posture import wrapped
from robotics.quantity import check_quantities, quantity

# Thesis Fig 6.7
DIAGRAM = StateDiagram(
    {
        TRACK: Box("tracking", "Table 5.6 at λ + α + η (6.4); η is 0 unless another robot is within d_min"),
        YIELD: Box("standing", "v = ω = 0 (6.5)"),
    },
    (
        Transition(TRACK, YIELD, "a robot of lower number is within d_min"),
        Transition(YIELD, TRACK, "no robot of lower number is within d_min"),
    ),
)
TOUCHING = 0.3  # m: where two robots touch; η is 1.2 rad there, whatever d_min is


class Danger(NamedTuple):
    """What follows from how near the other robots are; each field is (runs, robots)."""

    stands: np.ndarray  # bool: a robot of lower number is within d_min (6.5)
    turn: np.ndarray  # rad: η of (6.4), with its sign; 0 unless a robot is within d_min
    nearest: np.ndarray  # m to the nearest robot that was heard; infinite where none was


@dataclass(frozen=True, kw_only=True)
class CrashAvoidance(Law[Any]):
    """Crash avoidance: how near is too near, how far to turn, and the cooperation underneath."""

    variant: Literal["literal", "lag-clock", "yielding"] = "literal"
    d_min: float = quantity(0.6, "m", above=0.31, most=5)
    eta: float = quantity(1.0, "1", least=0, most=5)  # a factor on η(d_ij)
    rule_base: str | Sugeno = ""  # for tracking; if empty, Table 5.6 as printed, or for "yielding" as repaired
    eta_rule_base: str | Sugeno = "eta"
    lateral: Literal["none", "path", "world"] = "none"  # the frame of y_err for λ; "world" is the thesis's
    cooperation: FuzzyCooperation = field(init=False, repr=False)
    turn: CompiledSugeno = field(init=False, repr=False, compare=False)

    message = (*FuzzyCooperation.message, "x", "y")
    yields = True
    tasks = MappingProxyType({"tracking": "rule_base", "eta": "eta_rule_base"})

    def __post_init__(self) -> None:
        check_quantities(self, ControllerError)
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
    def kept_distance(self) -> float:
        """d_min of (6.1) [m]."""
        return self.d_min

    @property
    def diagrams(self) -> tuple[StateDiagram, ...]:
        """Tracking and standing, thesis Fig 6.7."""
        return (DIAGRAM,)

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
                    f"{setting.name}: {', '.join(told(what, pair) for pair in pairs)}, no farther than "
                    f"d_min = {self.d_min:g} m: {then}; move them farther apart, or set d_min below {nearest:.2f} m"
                )
        touching = float(max(np.hypot(robot.length, robot.width) for robot in setting.robots))
        if touching > self.d_min:
            found.append(
                f"{setting.name}: robots as large as these may touch with centers {touching:.2f} m apart, and they "
                f"avoid each other from d_min = {self.d_min:g} m on: make d_min greater"
            )
        return tuple(found)

    def init(self, setting: Setting, runs: int) -> Any:
        """Return the memory of the cooperation. Raises ControllerError where the graph is not connected."""
        return self.cooperation.init(setting, runs)

    def control(self, seen: Observation, memory: Any, dt: float) -> tuple[Command, Any]:
        """Stand still by (6.5), or turn by (6.4)."""
        stands, turn, nearest = self.danger(seen)
        excused = stands if self.variant == "yielding" else None
        wish, memory = self.cooperation.steered(seen, memory, dt, turn, excused)
        assert wish.message is not None
        assert wish.inputs is not None
        v, w = np.where(stands, 0.0, wish.v), np.where(stands, 0.0, wish.w)
        message = {**wish.message, "x": seen.x, "y": seen.y}
        mode = np.where(stands, YIELD, TRACK)
        inputs = np.concatenate([wish.inputs, self.eta_input(nearest)[None]])
        return wish._replace(first=v, second=w, v=v, w=w, message=message, mode=mode, inputs=inputs), memory

    def danger(self, seen: Observation) -> Danger:
        """Judge by the messages "x" and "y" who stands, and who turns how far."""
        heard = seen.heard
        dx = heard["x"] - seen.x[:, :, None]  # (runs, receivers, senders)
        dy = heard["y"] - seen.y[:, :, None]
        distance = np.hypot(dx, dy)
        close = heard.hears & (distance <= self.d_min)  # false for a robot that was never heard
        number = np.arange(seen.x.shape[1])
        stands = (close & (number < number[:, None])).any(axis=-1)
        bearing = wrapped(np.arctan2(dy, dx) - seen.heading[:, :, None])
        turn = -np.where(close, np.sign(bearing) * self.turn_at(distance), 0.0).sum(axis=-1)
        nearest = np.where(heard.hears, distance, np.inf).min(axis=-1)
        return Danger(stands, turn, nearest)

    def turn_at(self, distance: np.ndarray) -> np.ndarray:
        """|η| [rad] at ``distance`` [m], of any shape: the rule base, stretched so that it ends at d_min."""
        return np.asarray(self.eta * self.turn(self.eta_input(distance)[..., None])[..., 0])

    def eta_input(self, distance: np.ndarray) -> np.ndarray:
        """The rule base's input [m] for ``distance`` [m], of any shape; d_min is the far end of its range."""
        near, far = self.turn.fis.inputs[0].universe
        stretched = far - (self.d_min - distance) * (far - TOUCHING) / (self.d_min - TOUCHING)
        return np.clip(np.where(np.isnan(stretched), far, stretched), near, far)
