"""The laws that can be written in C: what their numbers are called there."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from fuzzy.ccode.numbertype import ExportError
from fuzzy.system import Sugeno
from robotics.laws.law import Law
from robotics.laws.rules.own_rules import OwnRules
from robotics.laws.tracking.fuzzy_tracking import FuzzyTracking
from robotics.laws.tracking.linear_quadratic import LinearQuadratic
from robotics.laws.tracking.lyapunov import Lyapunov
from robotics.laws.tracking.pid import PID
from robotics.laws.tracking.sliding_mode import SlidingMode

# The numbers of a robot: its limits, and its nominal dynamics
LIMITS = ("V_MAX m/s", "W_MAX rad/s", "HALF_AXLE m", "WHEEL_SPEED_LIMIT m/s, of the rim")
_DYNAMICS = ("MASS kg", "INERTIA kg m²", "WHEEL_RADIUS m", "HALF_AXLE m")
_LYAPUNOV = ("KX 1/s", "KY 1/m²", "KPSI 1/m", "CATCH_UP m/s", "", "", "")


@dataclass(frozen=True)
class Carried:
    """What the numbers of a law are called in C, each "NAME unit"; "" is an option, which chooses what is written."""

    gains: Sequence[str]
    memory: Sequence[str] = ()
    work: Mapping[str, int] | None = None  # names of places, by where they begin
    bases: Callable[[Any], Mapping[str, Sugeno]] | None = None
    sections: str = ""  # of the thesis


_FUZZY = Carried(
    gains=("", "", "LOOK_AHEAD s", "STEERING_DISTANCE m", "DEADBAND m", "", "", "", "", "", "", ""),
    work={"ASKED": 0, "Y_ERR": 4, "ALL": 5, "SAID": 9, "WORK": 12},
    bases=lambda law: {"rules": law.tracking.fis, "turn": law.turn.fis},
    sections="(2.35), (2.36), 5.3.1",
)
CARRIED: dict[type[Law[Any]], Carried] = {
    FuzzyTracking: _FUZZY,
    OwnRules: _FUZZY,
    Lyapunov: Carried(_LYAPUNOV, sections="(2.30) to (2.32)"),
    LinearQuadratic: Carried(
        (
            *("Q_X 1/m²", "Q_Y 1/m²", "Q_HEADING 1/rad²", "R_V s²/m²", "R_W s²/rad²"),
            *("SLOWEST m/s", "CATCH_UP m/s", ""),
        ),
    ),
    PID: Carried(
        (
            *(*LIMITS, "KX 1/s", "IX 1/s²", "KY rad/(m s)", "IY rad/(m s²)", "KPSI 1/s", "DPSI 1", "FILTER_TIME s"),
            *("BAND m", "MOST_V m/s", "MOST_W rad/s", "SLOWEST m/s", "CATCH_UP m/s", ""),
        ),
        memory=("along m s", "aside m s", "before rad: the heading error of the period before", "rate rad/s"),
    ),
    SlidingMode: Carried(
        (
            *LIMITS,
            *_DYNAMICS,
            "",
            "",
            "K m/s² (rad/s²)",
            "LAMBDA 1/s",
            "MU0 1",
            "ALPHA s/m",
            "",
            "LEAD m/s",
            *_LYAPUNOV,
        ),
        memory=(
            *("integral_v m: of the error", "integral_w rad", "s_v m/s: the surface", "s_w rad/s"),
            *("push_v m/s²: of the reaching law", "push_w rad/s²", "desired_v m/s", "desired_w rad/s"),
            *("command_v m/s", "command_w rad/s"),
        ),
        sections="(2.13) to (2.23)",
    ),
}
NAMES = "fuzzy (with any rule base of fuzzy tracking), fuzzy-lateral, lyapunov, lqr, pid, csm, assm, qssm, esm"


def carried(law: Law[Any], specification: str) -> Carried:
    """How a law is written. Raises ExportError, listing those that can be, for one that cannot."""
    found = CARRIED.get(type(law))
    if found is None or not getattr(law, "has_equation", False):
        why = "its rule base asks for more than fuzzy tracking knows" if isinstance(law, OwnRules) else (
            "it looks ahead, hears others, or has a control step that is not translated"
        )  # fmt: skip
        raise ExportError(f"{specification} cannot be written in C: {why}; those that can be: {NAMES}")
    return found


def rule_bases(law: Any, how: Carried) -> dict[int, tuple[str, Sugeno]]:
    """The rule bases of a law by where each begins in its packed rows: what it is called, and the system."""
    found, place = {}, 0
    for (name, fis), row in zip((how.bases(law) if how.bases else {}).items(), law.rule_rows(), strict=False):
        found[place] = (name, fis)
        place += len(row)
    return found


def first_numbers(law: Any, setting: Any) -> np.ndarray:
    """What a law remembers at the start, (numbers,), of one robot."""
    rows = np.asarray(law.begin(setting, 1), dtype=float)
    return rows[:, 0, 0] if len(rows) else np.empty(0)
