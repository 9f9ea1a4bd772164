"""The laws that can be written in C: what their numbers are called there."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from fuzzy.plugins.ccode.numbertype import ExportError
from fuzzy.system import Sugeno
from robotics.laws.law import Law
from robotics.laws.rules.own_rules import OwnRules
from robotics.laws.tracking.fuzzy_tracking import FuzzyTracking
from robotics.laws.tracking.linear_quadratic import LinearQuadratic
from robotics.laws.tracking.lyapunov import Lyapunov
from robotics.laws.tracking.pid import TrackingPID
from robotics.laws.tracking.sliding_mode import SlidingMode

# What a number is called in C, where that is not its name in capitals
SYMBOLS = {"lam": "LAMBDA", "radius": "WHEEL_RADIUS"}


@dataclass(frozen=True)
class Carried:
    """What a law in C has beside its columns."""

    sections: str = ""  # of the thesis
    bases: Callable[[Any], Mapping[str, Sugeno]] | None = None


_FUZZY = Carried("(2.35), (2.36), 5.3.1", lambda law: {"rules": law.tracking.fis, "turn": law.turn.fis})
CARRIED: dict[type[Law[Any]], Carried] = {
    FuzzyTracking: _FUZZY,
    OwnRules: _FUZZY,
    Lyapunov: Carried("(2.30) to (2.32)"),
    LinearQuadratic: Carried(),
    TrackingPID: Carried(),
    SlidingMode: Carried("(2.13) to (2.23)"),
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
