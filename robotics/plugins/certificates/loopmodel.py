"""What a certificate of a closed loop assumes, and the numbers of a law's loop under these assumptions."""

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from fuzzy.compiled.packed import packed
from fuzzy.quantity import check_quantities, quantity
from fuzzy.system import Sugeno
from robotics.laws.catalogue import make_controller
from robotics.laws.knowledge import AUTO, NOTHING_GIVEN, share_of
from robotics.laws.rules.of_reference import INPUTS, OUTPUTS
from robotics.laws.rules.own_rules import OwnRules
from robotics.laws.tracking.fuzzy_tracking import FuzzyTracking
from robotics.laws.tracking.lyapunov import Lyapunov
from robotics.plugins.certificates.certificate import CertificateError
from robotics.plugins.certificates.loopcolumns import ASKED, GROUPS, LoopColumns
from robotics.plugins.certificates.wheels import (
    HULL_SHARE,
    RIPPLE_SHARE,
    SLOW_RIM,
    TURNING_PERIODS,
    USABLE,
    WINDOW,
    WheelModel,
    measure_wheels,
)
from robotics.world.vehicle.robot import Robot
from robotics.world.vehicle.wheel_loop import wheel_lag

MEMORY = 6  # periods, within which commands are bounded one by one
_MOST_MORE = 20  # periods, at most, that are added to them behind a low-pass
_FORGOTTEN = 1e-5  # of a correction, in what is smoothed: less is counted as anything between the robot's limits


@dataclass(frozen=True, kw_only=True)
class LoopModel:
    """The assumptions: the references that are to be tracked, the sampling and the sensors.

    Raises CertificateError for numbers out of range.
    """

    speed_low: float = quantity(0.1, "m/s", above=0, doc="Least v_r of the reference.")
    speed_high: float = quantity(0.4, "m/s", above=0, doc="Greatest v_r of the reference.")
    curvature: float = quantity(1.2, "1/m", least=0, doc="Bound of the path's |curvature|.")
    v_rate: float = quantity(0.0, "m/s²", least=0, doc="Bound of |v_r'|.")
    w_rate: float = quantity(0.0, "rad/s²", least=0, doc="Bound of |ω_r'|.")
    period: float = quantity(0.05, "s", above=0, most=0.5, doc="Control period T.")
    latency: float = quantity(0.0, "s", least=0, most=0.5, doc="How late a command acts.")
    position_noise: float = quantity(0.0, "m", least=0, doc="Bound of the position's noise.")
    heading_noise: float = quantity(0.0, "rad", least=0, doc="Bound of the heading's noise.")

    def __post_init__(self) -> None:
        check_quantities(self, CertificateError)
        if self.speed_low > self.speed_high:
            raise CertificateError(
                f"speed_low must be at most speed_high, {self.speed_high:g} m/s; got {self.speed_low:g} m/s"
            )

    @property
    def noise(self) -> np.ndarray:
        """Bounds of the noise of X [m], Y [m] and ψ [rad] (3,)."""
        return np.array([self.position_noise, self.position_noise, self.heading_noise])


@dataclass(frozen=True, eq=False)
class ClosedLoop:
    """A law with its robot under the assumptions, in numbers."""

    model: LoopModel
    wheels: WheelModel
    numbers: np.ndarray  # (LoopColumns,)
    law: Any  # as it drives
    rules: Sugeno | None  # None: a formula
    title: str
    system: np.ndarray  # the packed rule base


def closed_loop(law: Any, robot: Robot, model: LoopModel | None = None) -> ClosedLoop:
    """The closed loop of a law.

    Args:
        law: A law, its specification such as ``lyapunov`` or ``mine.fis``, or a rule base.
        robot: The robot that it drives; its wheels are measured on the simulated plant.
        model: The assumptions; by default those of :class:`LoopModel`.

    Raises CertificateError for a law or a quantity of which nothing can be certified, ControllerError for a name.
    """
    model = model or LoopModel()
    title = law if isinstance(law, str) else law.name if isinstance(law, Sugeno) else type(law).__name__
    if isinstance(law, str):
        law = make_controller(law)
    if isinstance(law, Sugeno):
        law = OwnRules(rule_base=law)
    values: dict[str, Any] = dict.fromkeys(LoopColumns.columns, 0.0)
    values |= {"places": [0.0] * INPUTS, "given": [-1.0] * len(OUTPUTS)}
    rules: Sugeno | None = None
    if isinstance(law, Lyapunov):
        if law.form != "2.32" or law.signs != "corrected" or law.feed_forward != "full":
            raise CertificateError("of the Lyapunov law the form 2.32 is certified, with its feed-forward")
        values |= {"formula": 1.0, "kx": law.kx, "ky": law.ky, "kpsi": law.kpsi, "catch_up": law.catch_up}
    elif isinstance(law, FuzzyTracking):
        own = getattr(law, "own", None)
        rules = law.tracking.fis if own is None else own.fis
        values |= _of_rules(law, rules, own is not None and bool(getattr(law, "corrects", False)))
    else:
        raise CertificateError(
            f"{title}: no certificate is known for this law; there is one for rule bases that correct the reference's "
            "velocity (fuzzy-correcting, mine.fis) and for the Lyapunov law"
        )
    references = (model.speed_low, model.speed_high), model.curvature
    wheels = measure_wheels(robot, *references, model.period, model.latency)
    told = law.lead if law.lead is not None else NOTHING_GIVEN.lead
    lead = model.latency + wheel_lag(robot) + model.period / 2 if told == AUTO else float(told or 0.0)
    values |= _of_wheels(wheels) | _of_low_pass(law.smooth or 0.0, model.period)
    same = ("period", "v_rate", "w_rate", "curvature", "speed_low", "speed_high", "position_noise", "heading_noise")
    values |= {name: getattr(model, name) for name in same}
    values |= {
        "memory": values["memory"] + min(math.ceil(2 * values["smooth"] / model.period), _MOST_MORE),
        "span": (values["memory"] + WINDOW + values["forgotten"] + 2) * model.period + lead,
        "v_max": robot.v_max,
        "w_max": robot.w_max,
        "half_axle": robot.half_axle,
        "wheel_limit": USABLE * robot.wheel_speed_limit,
    }
    numbers = np.array(LoopColumns.stacked(values), dtype=float).ravel()
    return ClosedLoop(model, wheels, numbers, law, rules, title, np.zeros(64) if rules is None else packed(rules))


def _of_wheels(wheels: WheelModel) -> dict[str, Any]:
    """The numbers of the wheels."""
    ages = len(wheels.weights)
    if ages > GROUPS:
        raise CertificateError(
            f"latency and lag of the wheels must be at most {GROUPS - 2} periods; they take {ages - 2}"
        )
    pad = [0.0] * (GROUPS - ages)
    numbers: dict[str, Any] = {
        "memory": float(max(MEMORY, ages - 1)),
        "groups": float(ages),
        "last": [*map(float, range(ages)), *pad],
        "v_weight": [*wheels.weights[:, 0], *pad],
        "w_weight": [*wheels.weights[:, 1], *pad],
        "prompt": float(wheels.prompt),
        "turning": float(TURNING_PERIODS),
        "share": HULL_SHARE,
        "overshoot": RIPPLE_SHARE,
        "slow": SLOW_RIM,
    }
    for name in ("error", "reversal", "ripple"):
        numbers |= {f"{axis}_{name}": bound for axis, bound in zip("vw", getattr(wheels, name), strict=True)}
    return numbers


def _of_low_pass(smooth: float, period: float) -> dict[str, float]:
    """The numbers of the low-pass behind a law."""
    fresh = share_of(smooth, period)
    forgotten = math.ceil(math.log(_FORGOTTEN) / math.log(1 - fresh)) if fresh < 1 else 0
    return {"smooth": smooth, "fresh": fresh, "forgotten": float(forgotten)}


def history(numbers: np.ndarray) -> int:
    """How many samples of the past the proof tells of."""
    loop = LoopColumns(numbers)
    return int(loop.memory) + int(loop.forgotten) + WINDOW


def fall(numbers: np.ndarray, share: float) -> float:
    """μ, for which μ^N is the ``share`` ν."""
    return math.exp(math.log(share) / history(numbers)) * (1 + 1e-12)


def _of_rules(law: FuzzyTracking, rules: Sugeno, corrects: bool) -> dict[str, Any]:
    """The numbers of a law of a rule base; raises CertificateError for what is not enclosed."""
    if rules.out_of_range == "error":
        raise CertificateError(f"{rules.name}: out_of_range must be 'clip', 'warn' or 'ignore'; got 'error'")
    if not corrects:
        raise CertificateError(
            f"{rules.name}: certified are rule bases that correct the reference's velocity (outputs dv, bend, dw), "
            "not those that drive towards a target ahead (v, w)"
        )
    for variable in rules.inputs:
        if variable.name not in ASKED:
            raise CertificateError(
                f"{rules.name}: input {variable.name!r} is not one of the errors of a closed loop; certified are rule "
                f"bases of {', '.join(ASKED)}"
            ).about(variable.name)
    outputs = [v.name for v in rules.outputs]
    if unknown := {*outputs} - {"dv", "dw", "bend"}:
        raise CertificateError(
            f"{rules.name}: of the output {min(unknown)!r} nothing is certified; known are dv, dw, bend"
        )
    places = [float(ASKED.index(v.name)) for v in rules.inputs]
    return {
        "catch_up": getattr(law, "catch_up", 0.0),
        "count": float(len(places)),
        "places": places + [0.0] * (INPUTS - len(places)),
        "given": [float(outputs.index(n)) if n in outputs else -1.0 for n in OUTPUTS],
    }
