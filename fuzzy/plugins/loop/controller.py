"""Controllers of a single loop: a Sugeno system that says by its names what it takes, and the classical PID.

The error is e = r - y, its rate de/dt, its sum the integral of e. An output ``u`` acts directly, an output ``du`` is a
rate that the loop integrates: PD has u, PI has du, PID has both (W. Z. Qiao and M. Mizumoto, 1996).
"""

import re
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, Protocol

import numpy as np

from fuzzy.compiled.packed import evaluate_one, one_point, packed
from fuzzy.compiled.tables import NUMBERS
from fuzzy.errors import InputError
from fuzzy.inference import infer
from fuzzy.naming import check_known
from fuzzy.quantity import check_quantities, quantity
from fuzzy.system import Sugeno

INPUT_ROLES = ("error", "error_rate", "error_sum", "scheduling")
OUTPUT_ROLES = ("u", "du")
FACTOR_OF = {"error": "Ke", "error_rate": "Kde", "error_sum": "Kie", "u": "Ku", "du": "Kdu"}  # of Scale, by role; the
# scheduling variable, as gain scheduling calls what the plant depends on, comes as it is
_ALIASES = {
    "error": "e err controlerror",
    "error_rate": "de derror dedt edot ce deltae deltaerror changeoferror changeinerror errorchange rateoferror",
    "error_sum": "ie ierror errorintegral interror integraloferror sumoferror sumerror",
    "scheduling": "schedulingvariable operating operatingvariable operatingpoint",
    "u": "control controlsignal controlaction controleffort",
    "du": "deltau dudt udot changeofcontrol changeincontrol changeofu controlrate controlchange",
}
_ROLE_OF = {word: role for role, words in _ALIASES.items() for word in (role.replace("_", ""), *words.split())}


class LoopError(InputError):
    """A controller or a setting with which no loop can be closed. The message says what is accepted."""


@dataclass(frozen=True)
class Scale:
    """Scale factors: what the loop multiplies by before it asks the rules, and after.

    Attributes:
        Ke: Of the error: 1 / its unit for rules on [-1, 1].
        Kde: Of the error's rate.
        Kie: Of the error's sum.
        Ku: Of the output u.
        Kdu: Of the output du, per second.

    Raises:
        LoopError: A factor that is no finite number.
    """

    Ke: float = quantity(1.0, "1")
    Kde: float = quantity(1.0, "1")
    Kie: float = quantity(1.0, "1")
    Ku: float = quantity(1.0, "1")
    Kdu: float = quantity(1.0, "1")

    def __post_init__(self) -> None:
        check_quantities(self, LoopError)


@dataclass(frozen=True)
class Roles:
    """What each input and output of a system is to the loop, in the system's order."""

    inputs: tuple[str, ...]  # of INPUT_ROLES
    outputs: tuple[str, ...]  # of OUTPUT_ROLES

    def __post_init__(self) -> None:
        for given, known in ((self.inputs, INPUT_ROLES), (self.outputs, OUTPUT_ROLES)):
            for role in given:
                check_known(role, known, "role", LoopError)
            if len(set(given)) < len(given):
                twice = next(role for role in given if given.count(role) > 1)
                raise LoopError(f"two variables are {twice}: each role is given once")


def factor_of(scale: Scale, role: str) -> float:
    """What the loop multiplies a variable of this role by."""
    return float(getattr(scale, FACTOR_OF[role])) if role in FACTOR_OF else 1.0


def role_of(name: str) -> str | None:
    """The role that a variable's name says, in any case, with blanks and signs left out; None if it says none.

    >>> role_of("Change of error"), role_of("dE/dt"), role_of("distance")
    ('error_rate', 'error_rate', None)
    """
    return _ROLE_OF.get(re.sub(r"[\W_]+", "", name).casefold())


def is_controller(system: Sugeno) -> bool:
    """Whether a system holds a loop, or the names of its variables are those of a loop's controller."""
    return bool(system.loop) or all(role_of(v.name) for v in (*system.inputs, *system.outputs))


def roles_of(fis: Sugeno, chosen: Mapping[str, str] | None = None) -> Roles:
    """What the variables of a system are to the loop, by their names.

    Args:
        fis: The system.
        chosen: Roles by the names of variables, which go before what the names say.

    Raises LoopError for names that say nothing, and for two with one role.
    """
    chosen = chosen or {}
    names = [v.name for v in (*fis.inputs, *fis.outputs)]
    for name, role in chosen.items():
        check_known(name, names, "variable", LoopError)
        check_known(role, (*INPUT_ROLES, *OUTPUT_ROLES), "role", LoopError)
    found: list[tuple[str, ...]] = []
    for what, variables, known in (("input", fis.inputs, INPUT_ROLES), ("output", fis.outputs, OUTPUT_ROLES)):
        roles = [chosen.get(v.name) or role_of(v.name) for v in variables]
        strange = [v.name for v, role in zip(variables, roles, strict=True) if role not in known]
        if strange:
            accepted = (
                "error (e), error_rate (de, change of error), error_sum (ie) and scheduling (operating point)"
                if what == "input"
                else "u, which acts directly, and du, which is integrated"
            )
            raise LoopError(
                f"{fis.name}: a loop's {what}s are called {accepted}; {', '.join(map(repr, strange))} "
                f"{'is' if len(strange) == 1 else 'are'} none of them"
            )
        found.append(tuple(str(role) for role in roles))
    return Roles(*found)


class LoopController(Protocol):
    """What a loop asks at each sample."""

    def __call__(self, error: float, rate: float, total: float, operating: float = 0.0) -> tuple[float, float]:
        """The control u and the rate du/dt of its integrated part, from the error, its rate, its sum, and the
        operating variable."""


@dataclass(frozen=True)
class PID:
    """u = Kp e + Ki · integral of e + Kd de/dt, the classical controller. It is called with the error, its rate and its
    sum.

    Attributes:
        Kp: The proportional gain, in the control's unit over the error's.
        Ki: The integral gain, that unit / s.
        Kd: The derivative gain, that unit · s.
        rule: Where the gains come from, such as a tuning rule's name; for legends.
    """

    Kp: float
    Ki: float = 0.0
    Kd: float = 0.0
    rule: str = field(default="", kw_only=True)

    def __call__(self, error: float, rate: float, total: float, operating: float = 0.0) -> tuple[float, float]:
        """The control, of which no part is integrated by the loop."""
        return self.Kp * error + self.Ki * total + self.Kd * rate, 0.0


class RuleController:
    """A Sugeno system in a loop: its inputs are scaled, its outputs too. One loop at a time uses one of these."""

    def __init__(self, fis: Sugeno, roles: Roles, scale: Scale) -> None:
        if (len(roles.inputs), len(roles.outputs)) != (len(fis.inputs), len(fis.outputs)):
            raise LoopError(f"{fis.name}: there must be one role for each input and output")
        self.fis, self.roles = fis, roles
        self.factors = np.array([factor_of(scale, role) for role in roles.inputs])
        self._from = [INPUT_ROLES.index(role) for role in roles.inputs]
        self._u = roles.outputs.index("u") if "u" in roles.outputs else None
        self._du = roles.outputs.index("du") if "du" in roles.outputs else None
        self._scale = scale
        self._compiled = all(type(f) in NUMBERS for v in fis.inputs for f in v.terms.values())
        if self._compiled:
            self._memory, self._point, self._values = one_point(packed(fis))

    def __call__(self, error: float, rate: float, total: float, operating: float = 0.0) -> tuple[float, float]:
        """The control and the rate of its integrated part."""
        known = (error, rate, total, operating)
        point = [known[source] * factor for source, factor in zip(self._from, self.factors, strict=True)]
        values = self._evaluated(point)
        u = 0.0 if self._u is None else self._scale.Ku * values[self._u]
        du = 0.0 if self._du is None else self._scale.Kdu * values[self._du]
        return float(u), float(du)

    def known(self, error: np.ndarray, rate: np.ndarray, total: np.ndarray, operating: np.ndarray) -> np.ndarray:
        """The inputs (..., inputs) of the system, in its order and scaled, at errors, rates, sums, operating (...)."""
        known = np.stack([error, rate, total, operating], axis=-1)
        scaled: np.ndarray = known[..., self._from] * self.factors
        return scaled

    def _evaluated(self, point: list[float]) -> Any:
        if not self._compiled:
            with np.errstate(all="ignore"):
                return infer(self.fis, np.array(point)).output
        self._point[:] = point
        evaluate_one(self._memory)
        return self._values
