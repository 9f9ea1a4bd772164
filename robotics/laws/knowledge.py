"""What any law can be given beside its errors: a feed-forward that is read ahead, and a low-pass of its correction.

A command acts late: the latency L passes, the wheels follow with the time constant τ, and a command that is held for
the period T stands for the reference in its middle. A law that feeds v_r and ω_r forward at t follows every change by
that much too late; one that reads them at

    t + lead,   lead = L + τ + T/2   ("auto": τ of robotics.world.vehicle.wheel_loop; none for wheel torques)

does not. The posture of the reference stays that of t: errors are not predicted.

The correction of a law of velocities is its command less that feed-forward, c = u − (v_r, ω_r). With ``smooth`` τ_s it
goes through a low-pass of first order, exact for a command held over T, that begins at 0:

    c_k' = c_{k-1}' + (1 − e^{−T/τ_s}) (c_k − c_{k-1}'),   u' = (v_r, ω_r) + c'

It takes white noise of the pose sensor away, by √(share/(2 − share)), and the phase of a delay of about τ_s.

An estimator joins the pose sensor with odometry, before a law sees the posture: a number is the gain of the
complementary filter, "kalman" the extended Kalman filter (:mod:`robotics.world.sensing.posture`). Any law can have it
by the scenario's sensing, and a law with an equation, of torques too, may say its own.

All are choices: no law of the thesis has them; predictive laws have the one by their model and the other by the
penalty of changes, so that what a comparison ranks without them is who has them.
"""

from dataclasses import dataclass
from math import exp
from typing import Any, Literal

from fuzzy.compiled.columns import Columns, column, within
from fuzzy.compiled.jit import compiled_only
from fuzzy.errors import InputError
from fuzzy.quantity import check_quantities, quantity
from robotics.world.paths.road import moving
from robotics.world.sensing.posture import KALMAN
from robotics.world.vehicle.plant import LimitColumns, within_limits

Lead = float | Literal["auto"]
Estimator = float | Literal["kalman"]
Safe = Literal["", "yes", "no"]
AUTO = "auto"
# What the fields are, here and of a law
LEAD: dict[str, Any] = {
    "unit": "s",
    "least": 0,
    "most": 5,
    "word": AUTO,
    "doc": 'How far ahead a law reads its reference\'s velocity; "auto": latency, wheel lag and half a period.',
}
SMOOTH: dict[str, Any] = {
    "unit": "s",
    "least": 0,
    "most": 10,
    "doc": "The time constant of the low-pass through which a law's correction of that velocity goes; 0: none.",
}


ESTIMATOR: dict[str, Any] = {
    "unit": "1",
    "above": 0,
    "most": 1,
    "word": KALMAN,
    "doc": 'How pose sensor and odometry are joined: filter_gain of a complementary filter, or "kalman".',
}


SAFE = "Whether the monitor of passive safety is below it: yes or no; left out: what the scenario says."


class KnowledgeError(InputError):
    """A lead or a low-pass that cannot be. The message names the field, its value and what is accepted."""


@dataclass(frozen=True, kw_only=True)
class Knowledge:
    """What every law that can use it is given, unless it is told otherwise itself.

    Raises:
        KnowledgeError: A number out of range.
    """

    lead: Lead = quantity(0.0, **LEAD)
    smooth: float = quantity(0.0, **SMOOTH)

    def __post_init__(self) -> None:
        check_quantities(self, KnowledgeError)


NOTHING_GIVEN = Knowledge()


def share_of(time_constant: float, period: float) -> float:
    """The share 1 − e^{−T/τ_s} of a new correction in the smoothed one; 1 where the time constant [s] is 0."""
    return 1.0 - exp(-period / time_constant) if time_constant > 0 else 1.0


class KnowledgeColumns(Columns):
    """What the loop over an equation reads beside the law's gains."""

    lead = column("s", "how far ahead the reference's velocity is read")
    share = column("1", "of a new correction in the smoothed one")
    limit = within(LimitColumns)


class SmoothedColumns(Columns):
    """What it remembers beside the law's memory: the smoothed correction."""

    v = column("m/s", "the smoothed correction of the speed")
    w = column("rad/s", "the smoothed correction of the turn rate")


@compiled_only
def read_ahead(aim, road, path, time):  # type: ignore[no-untyped-def]
    """Let an aim have the velocity of its reference at a later time [s] of the run."""
    _, _, _, aim.v, aim.w, _ = moving(road, path, time)


@compiled_only
def smooth_correction(command, aim, share, limit, smoothed):  # type: ignore[no-untyped-def]
    """Smooth the correction that a command is of the velocity of its aim, and remember what of it can be driven."""
    smooth_v = smoothed.v + share * (command.first - aim.v - smoothed.v)
    smooth_w = smoothed.w + share * (command.second - aim.w - smoothed.w)
    v, w = within_limits(limit, aim.v + smooth_v, aim.w + smooth_w)
    smoothed.v, smoothed.w = v - aim.v, w - aim.w
    command.first, command.second, command.wish_v, command.wish_w = v, w, v, w
