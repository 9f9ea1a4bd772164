"""The laws of an arena as their makers know them: what sort they are, what they know, at which level they command."""

from collections.abc import Mapping
from typing import Any, Literal

from robotics.laws.law import Law
from robotics.laws.tracking.linear_quadratic import LinearQuadratic
from robotics.laws.tracking.lyapunov import Lyapunov
from robotics.laws.tracking.pdc import ParallelCompensation
from robotics.laws.tracking.pid import TrackingPID
from robotics.laws.tracking.pure_pursuit import PurePursuit
from robotics.laws.tracking.sliding_mode import SlidingMode

Sort = Literal["fuzzy", "lyapunov", "geometric", "linear", "predictive", "other"]
_SORTS: Mapping[type[Law[Any]], Sort] = {
    ParallelCompensation: "fuzzy",
    Lyapunov: "lyapunov",
    SlidingMode: "lyapunov",
    PurePursuit: "geometric",
    TrackingPID: "linear",
    LinearQuadratic: "linear",
}


def sort_of(law: Law[Any]) -> Sort:
    """What sort of law it is; one of the user's own with rule bases is fuzzy, and any other "other"."""
    return _SORTS.get(type(law)) or vars(type(law)).get("sort_of_law") or ("fuzzy" if law.fuzzy_systems else "other")


def terms_of(law: Law[Any]) -> tuple[str, str]:
    """At which level a law commands, and what it uses beside its robot's measured posture, in words."""
    said = [*law.knows, *filter(None, [law.learnt_how])]
    return "wheel torques" if law.level == "torque" else "velocities", ", ".join(said) or "not stated"
