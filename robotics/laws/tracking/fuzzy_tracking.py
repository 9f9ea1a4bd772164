"""Fuzzy trajectory tracking, thesis 2.3 and 5.3.1: the eleven rules of Table 5.6, and λ(y_err) of (2.36).

The target is the trajectory's point ``look_ahead`` seconds from now (the thesis's next sample, some samples on).

    d_RP = distance to the target,   α = its bearing from the heading,   x_err as in (5.9)
    (v, ω) = tracking rule base(d_RP, α, x_err [, heading error])        (2.35)
    α(new) = λ(y_err) + α, with the second rule base                     (2.36), optional

With the bearing as α the rule base is pure pursuit: both lateral poles are those of s² + (2/T) s + 2/T² for a
look-ahead of T (damping 0.71, √2/T rad/s), at any speed. That is a local certificate; convergence from afar is
shown by sampling, not proved. With the path's heading as α the cross-track error is unseen: λ is then needed, with
y_err in the path's frame (the thesis's global y works on paths along +x only; errata A22, A23).

The target of a slow robot is near, 3 cm at 0.08 m/s, where its bearing is noise. Nearer than D, ``steering_distance``,
α is the bearing of a point D − d_RP beyond the target, straight on along ψ_d − ω_d T/2, the chord from the place due to
the target; v is still that of the target. And a robot that has passed a target at rest, which is the path's end, stops
at once: over its 2 cm rule 11 would let it creep on.

* Choice of D: a noise σ of the position, new in every period Δt, turns the heading, ψ' = −(2/T)(ψ + y/D), by
  σ/D √(Δt/T). In the error norm, where 1 rad counts as 1 m, that is no more than σ from D = √(Δt/T) m = 0.35 m on.
* Cost: the lateral poles are those of s² + (2/T) s + (2/T) v/D, so that errors decay over D metres, and an error β of
  the heading or ω̃ of the turn rate leads D (β + ω̃ T/2) off the path, where D was v T. Corners are not cut more than
  before: along the chord α is the same on any arc for every D.
* Torques: a wheel's speed is as noisy as σ √((1/T)² + (2b/T)² (1/D² + (σ_ψ/σ)²)), with b half the axle, and under the
  Lyapunov law as σ √(K_x² + (b v)² (K_y² + (K_ψ σ_ψ/σ)²)). What remains is 1/T = 2.5 1/s against K_x = 1 1/s; a
  ``filter_gain`` of the posture sensor takes it away, for all laws alike.

With D = 0, as printed, there is nothing of that, and α is 0 nearer to the target than ``deadband``.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cache
from pathlib import Path
from types import MappingProxyType
from typing import Any, ClassVar, Literal

import numpy as np

from fuzzy.compiled.columns import Columns, codes, column, several, within
from fuzzy.compiled.jit import compiled_only
from fuzzy.compiled.packed import evaluate_packed
from fuzzy.compiled.sugeno import CompiledSugeno, compile_sugeno
from fuzzy.files.fisfile import read_fis
from fuzzy.files.packaged import FisNameError, find_fis, fis_files, packaged_fis_files
from fuzzy.naming import check_known
from fuzzy.quantity import quantity
from fuzzy.system import Sugeno
from robotics.laws.equation import AimColumns, EquationLaw, equation
from robotics.laws.knowledge import share_of
from robotics.laws.law import ControllerError
from robotics.laws.setting import Setting
from robotics.world.paths.posture import wrapped_compiled
from robotics.world.paths.road import moving
from robotics.world.sensing.posture import KALMAN
from robotics.world.vehicle.plant import velocity_limits

_RESTLESS = 1.5  # rad/s²: noise that makes the demanded turn rate vary by more is said; a cost counts 1 as 1
_SMALL = 0.02  # rad: of α, over which the slope of ω is taken
TRACKING_INPUTS = (
    "distance",
    "alpha",
    "x_err",
    "heading_err",
)  # the names of the inputs that a tracking rule base may have
Steering = Literal["bearing", "heading"]
Lateral = Literal["none", "path", "world"]
STEERING, LATERAL = codes(Steering), codes(Lateral)
RULE_BASES = Path(__file__).parents[2] / "data" / "rulebases"
RULE_TIME = 0.4  # s: T of the package's rule bases, v = d_RP / T and ω = 2 α / T
_AHEAD = 0.1  # m: a robot that is so far ahead of its target stands by rule 11


class TrackingDerived(Columns):
    """What the law makes of its rule bases."""

    lateral_begin = column("", "where λ begins in the packed rule bases")
    count = column("", "of the inputs of the tracking rule base")
    places = several(len(TRACKING_INPUTS), "", "of these in INPUTS")


class TrackingWork(Columns):
    """What the law works in."""

    aim = within(AimColumns)  # that it drives towards
    asked = several(len(TRACKING_INPUTS), "", "the inputs of the tracking rule base")
    y_err = several(1, "m", "the input of λ")
    known = several(len(TRACKING_INPUTS), "", "all of INPUTS")
    said = several(2, "", "what a rule base answers")
    rest = several(0)


@compiled_only
def toward(robot, aim, x_err, turn, no_lateral, gain, rules, work):  # type: ignore[no-untyped-def]
    """v [m/s] and ω [rad/s] by which one robot drives towards an aim, and what was wrong, as of evaluate_packed.

    The inputs are left in ``work``.

    Args:
        robot: Its posture.
        aim: Where it drives.
        x_err: How far it is behind [m]; not-a-number: the aim's x in its frame (5.9).
        turn: Added to α [rad], such as η of (6.4).
        no_lateral: Whether y_err is taken as 0.
        gain: The numbers of FuzzyTracking.
        rules: The packed rule bases.
        work: What it works in, TrackingWork.
    """
    dx, dy = aim.x - robot.x, aim.y - robot.y
    cos, sin = math.cos(robot.heading), math.sin(robot.heading)
    if gain.lateral != LATERAL.none:
        y_err = dy if gain.lateral == LATERAL.world else math.cos(aim.heading) * dy - math.sin(aim.heading) * dx
        work.y_err[0] = 0.0 if no_lateral else y_err
        evaluate_packed(rules[int(gain.lateral_begin) :], work.y_err, work.said, work.rest)
        turn = work.said[0] + turn  # (2.36)
    distance = math.hypot(dx, dy)  # d_RP
    heading_err = wrapped_compiled(aim.heading - robot.heading)
    ahead = cos * dx + sin * dy  # (5.9)
    nearest = gain.steering_distance
    beyond = nearest - distance
    if gain.steering == STEERING.heading:
        alpha = heading_err
    elif beyond > 0:
        chord = heading_err - aim.w * RULE_TIME / 2
        aside = cos * dy - sin * dx
        alpha = math.atan2(aside + beyond * math.sin(chord), ahead + beyond * math.cos(chord))
    elif distance < gain.deadband:
        alpha = 0.0
    else:
        alpha = wrapped_compiled(math.atan2(dy, dx) - robot.heading)
    if math.isnan(x_err):
        x_err = min(ahead, -_AHEAD) if ahead < 0 and aim.v == 0 and nearest > 0 else ahead
    known = work.known
    known[0], known[1], known[2], known[3] = distance, alpha + turn, x_err, heading_err
    for n in range(int(gain.count)):
        work.asked[n] = known[int(gain.places[n])]
    wrong = evaluate_packed(rules, work.asked, work.said, work.rest)
    return work.said[0], work.said[1], wrong  # (2.35)


@equation
def track_by_rules(robot, gain, command, work, time, road, path, rules):  # type: ignore[no-untyped-def]
    """Drive towards the point ``look_ahead`` seconds from now by (2.35), (2.36)."""
    aim = work.aim
    aim.x, aim.y, aim.heading, aim.v, aim.w, aim.s = moving(road, path, time + gain.look_ahead)
    v, w, _ = toward(robot, aim, math.nan, 0.0, False, gain, rules, work)
    command.first, command.second, command.wish_v, command.wish_w = v, w, v, w
    tell_inputs(command.inputs, gain, work)


@compiled_only
def tell_inputs(inputs, gain, work):  # type: ignore[no-untyped-def]
    """Write the inputs of the rule bases, which :func:`toward` left in ``work``, and return how many they are."""
    count = int(gain.count)
    for n in range(count):
        inputs[n] = work.asked[n]
    if gain.lateral != LATERAL.none:
        inputs[count] = work.y_err[0]
        count += 1
    return count


@dataclass(frozen=True, kw_only=True)
class FuzzyTracking(EquationLaw):
    """Fuzzy tracking: a rule base, and how its target and its inputs are chosen."""

    rule_base: str | Sugeno = "tracking"  # a name in robotics/data/rulebases, a .fis file's path, or the system itself
    look_ahead: float = quantity(0.4, "s", least=0, most=10)
    steering_distance: float = quantity(0.35, "m", least=0)  # D: α is the bearing of a point that is no nearer
    deadband: float = quantity(0.03, "m", least=0)  # nearer to the target α is 0; with D below it only
    steering: Steering = "bearing"  # α is the angle to the target point, or to the path's heading
    lateral: Lateral = "none"  # the frame of y_err for λ; "world" is the thesis's
    lateral_rule_base: str | Sugeno = "lateral"
    tracking: CompiledSugeno = field(init=False, repr=False, compare=False)
    turn: CompiledSugeno = field(init=False, repr=False, compare=False)
    inputs: tuple[int, ...] = field(init=False, repr=False)  # places in TRACKING_INPUTS of the rule base's inputs

    tasks = MappingProxyType({"tracking": "rule_base", "lateral": "lateral_rule_base"})

    def __post_init__(self) -> None:
        super().__post_init__()
        fis, name = load_rule_base(self.tracking_rule_base), called(self.tracking_rule_base)
        for variable in fis.inputs:
            check_known(variable.name, TRACKING_INPUTS, "tracking input", ControllerError, where=name)
        if len(fis.outputs) != 2:
            raise ControllerError(f"{name}: a tracking rule base has the outputs v and w, in this order")
        object.__setattr__(self, "inputs", tuple(TRACKING_INPUTS.index(v.name) for v in fis.inputs))
        object.__setattr__(self, "tracking", compile_sugeno(fis, sample=True))
        object.__setattr__(self, "turn", compiled_curve(self.lateral_rule_base, "λ", "y_err"))

    @property
    def tracking_rule_base(self) -> str | Sugeno:
        """The rule base by which it tracks."""
        return self.rule_base

    @property
    def idle(self) -> frozenset[str]:
        """The parameters that have no effect as the others are set."""
        idle = {"lateral_rule_base"} if self.lateral == "none" else set()
        idle |= {"deadband"} if self.steering == "heading" or self.steering_distance >= self.deadband else set()
        return frozenset(idle)

    @property
    def barred(self) -> Mapping[str, str]:
        """No lead: look_ahead moves the whole target."""
        return {**super().barred, "lead": "its target is look_ahead ahead"}

    @property
    def fuzzy_systems(self) -> Mapping[str, Sugeno]:
        """The tracking rule base, and λ(y_err) where it acts."""
        systems = {"tracking": self.tracking.fis}
        return systems if self.lateral == "none" else systems | {"lateral": self.turn.fis}

    def misgivings(self, setting: Setting) -> tuple[str, ...]:
        """Say which robots weave about their paths, and which the noise of their posture makes restless."""
        return (*self._weaving(setting), *self._restless(setting))

    def _restless(self, setting: Setting) -> tuple[str, ...]:
        """White noise σ, σ_ψ of the pose makes ω as noisy as ω(α)' √(σ²/D² + σ_ψ²).

        |ω_k − ω_(k−1)| is then 2/√π times that on average. A low-pass that takes the share s of what is new takes that
        to s/√(2 − s) of it: one in the sensing, as filter_gain, and one behind the law, by ``smooth``.
        """
        if setting.ensemble:
            return ()
        most, i = max((self._variation(setting, i), i) for i in range(len(setting.robots)))
        if most <= _RESTLESS:
            return ()
        wanted = share_of_noise(share_of(self._smoothed(setting), setting.period)) / most
        share = (math.sqrt(wanted**4 + 8 * wanted**2) - wanted**2) / 2  # s/√(2 − s) = wanted
        enough = math.ceil(-100 * setting.period / math.log1p(-share)) / 100
        return (
            f"{setting.name}: the noise of robot {i + 1}'s posture makes its demanded turn rate vary by about "
            f"{most:.2g} rad/s²; with smooth={enough:g} it is about 1",
        )

    def _smoothed(self, setting: Setting) -> float:
        return setting.knowledge.smooth if self.smooth is None else self.smooth

    def _variation(self, setting: Setting, robot: int) -> float:
        """By how much noise makes the demanded turn rate vary [rad/s²]; 0 where a Kalman filter takes it away."""
        sensing = setting.sensing[robot].joined_by(self.estimator)
        if sensing.posture != "pose" or sensing.estimator == KALMAN or self.steering != "bearing":
            return 0.0
        v = float(np.abs(setting.references.sampled(setting.times).v[..., robot]).max())
        far = v * self.look_ahead
        near = max(self.steering_distance, far, 1e-3)
        asked = np.zeros((2, len(TRACKING_INPUTS)))
        asked[:, :3] = [(far, _SMALL, far), (far, -_SMALL, far)]
        ahead, back = np.nan_to_num(self.tracking.quietly(asked[:, self.inputs])[:, 1])
        noise = math.hypot(sensing.position_noise / near, sensing.heading_noise)
        shares = share_of_noise(sensing.filter_gain), share_of_noise(share_of(self._smoothed(setting), setting.period))
        turning = abs(ahead - back) / (2 * _SMALL) * noise
        return float(2 / math.sqrt(math.pi) * turning * math.prod(shares) / setting.period)

    def _weaving(self, setting: Setting) -> tuple[str, ...]:
        """Which robots cannot turn towards a point as near as the steering distance D.

        A robot that drives v and turns by at most ω_max reaches no point within the two circles of radius v/ω_max
        beside it: D must not be less than their diameter.
        """
        if setting.ensemble or self.steering != "bearing" or self.steering_distance == 0:
            return ()
        fastest = np.abs(setting.references.sampled(setting.times).v).max(axis=0)
        turns = velocity_limits(setting.robots)[1]
        needed = 2 * fastest / turns
        slow = np.flatnonzero(needed > self.steering_distance)
        if not len(slow):
            return ()
        i = int(slow[np.argmax(needed[slow])])
        circle = f"a circle {needed[i]:.2f} m across at {fastest[i]:.3g} m/s"
        enough = np.ceil(10 * needed[i] - 1e-9) / 10
        return (
            f"{setting.name}: robot {i + 1} turns by at most {turns[i]:.3g} rad/s, {circle}, and steers towards a "
            f"point {self.steering_distance:g} m away: off its path it may weave; with steering_distance={enough:.1f} "
            "it comes back",
        )

    knows = ("reference", "reference velocity", "preview")
    equation = track_by_rules
    derived: ClassVar[type[Columns]] = TrackingDerived
    works: ClassVar[type[Columns]] = TrackingWork

    def derive(self, setting: Setting) -> Mapping[str, Any]:
        """Where λ begins, and which inputs the tracking rule base has."""
        places = [*self.inputs, *[0] * (len(TRACKING_INPUTS) - len(self.inputs))]
        return {"lateral_begin": len(self.tracking.system), "count": len(self.inputs), "places": places}

    def rule_rows(self) -> Sequence[np.ndarray]:
        """The tracking rule base and λ(y_err)."""
        return self.tracking.system, self.turn.system


def rule_base_files() -> dict[str, Path]:
    """The rule bases that come with this package and with others: files by their names, in alphabetical order."""
    return dict(sorted((packaged_fis_files() | fis_files(RULE_BASES)).items()))


def called(rule_base: str | Sugeno) -> str:
    """What messages call a rule base: its name or file, or the system's own name."""
    return rule_base if isinstance(rule_base, str) else rule_base.name


def share_of_noise(share: float) -> float:
    """What a low-pass that takes the ``share`` s of what is new leaves of the steps of white noise: s/√(2 − s)."""
    return share / math.sqrt(2 - share)


def load_rule_base(name: str | Sugeno) -> Sugeno:
    """Read the packaged rule base of that name, or a ``.fis`` file; a system is its own rule base.

    A name of this package means its rule base from wherever it is run: a law's default does not change with a file
    of that name in the present folder. Raises ControllerError or FisFileError.
    """
    if isinstance(name, Sugeno):
        return name
    if name in _own_rule_bases():
        return _own_rule_base(name)
    try:
        return read_fis(find_fis(name, rule_base_files()))
    except FisNameError as error:
        raise ControllerError(str(error)) from None


@cache
def _own_rule_bases() -> dict[str, Path]:
    return fis_files(RULE_BASES)


@cache
def _own_rule_base(name: str) -> Sugeno:
    """A rule base of this package, which is read once: laws are made anew at every step of a drag or of a search."""
    return read_fis(_own_rule_bases()[name])


def compiled_curve(name: str | Sugeno, symbol: str, argument: str) -> CompiledSugeno:
    """Compile the rule base of that name, which must be a curve: one input, the ``argument``, and one output.

    ``symbol`` is what messages call the curve. Raises ControllerError or FisFileError.
    """
    own = isinstance(name, str) and name in _own_rule_bases()
    return (_own_curve if own else _curve)(name, symbol, argument)


def _curve(name: str | Sugeno, symbol: str, argument: str) -> CompiledSugeno:
    fis = load_rule_base(name)
    if len(fis.inputs) != 1 or len(fis.outputs) != 1:
        raise ControllerError(f"{called(name)}: {symbol} has one input, {argument}, and one output")
    return compile_sugeno(fis, sample=True)


_own_curve = cache(_curve)  # likewise
