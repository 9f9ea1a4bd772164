"""The laws of an arena as their makers know them: what sort they are, what they know, at which level they command."""

from typing import Any, Literal, NamedTuple

from robotics.laws.law import Law
from robotics.laws.specification import Specification

Sort = Literal["fuzzy", "lyapunov", "geometric", "linear", "predictive", "other"]
_SORTS: dict[str, Sort] = {
    "fuzzy": "fuzzy",
    "fuzzy-lateral": "fuzzy",
    "fuzzy-literal": "fuzzy",
    "pdc": "fuzzy",
    "lyapunov": "lyapunov",
    "lyapunov-thesis": "lyapunov",
    "csm": "lyapunov",
    "assm": "lyapunov",
    "qssm": "lyapunov",
    "esm": "lyapunov",
    "pursuit": "geometric",
    "pid": "linear",
    "lqr": "linear",
    "mppi": "predictive",
    "nmpc": "predictive",
}


def sort_of(specification: str, law: Law[Any]) -> Sort:
    """What sort of law it is; one of the user's own with rule bases is fuzzy, and any other "other"."""
    known = _SORTS.get(Specification.of(specification).name)
    return known or ("fuzzy" if law.fuzzy_systems else "other")


class Terms(NamedTuple):
    """The terms on which a law takes part, in words."""

    level: str
    knows: str


def terms_of(law: Law[Any]) -> Terms:
    """What a law commands, and what it uses beside its robot's measured posture."""
    said = law.knows
    return Terms("wheel torques" if law.level == "torque" else "velocities", ", ".join(said) or "not stated")
