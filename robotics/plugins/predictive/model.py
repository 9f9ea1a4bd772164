"""The model that predictive laws simulate: a unicycle whose wheels follow their commands with a lag.

Over a duration h a command (v_c, ω_c) is held, and the velocities (v, ω) follow it with the time constant τ:

    v(t) = v_c + (v − v_c) e^{−t/τ},  ω likewise

so that the distance d = ∫ v dt and the turn ∫ ω dt are exact. The pose moves by d along the heading at h/2, which is
right to the second order of h: for a turn of 0.25 rad a period, the most that the EtsRo makes, d is 0.3 % too long.

τ is the area above the step response of the wheel loop, sampled every T_s = 10 ms, of which the lag of first order has
the same. The PI loop's integral ends where it holds the back-EMF k_e of a step by 1 rad/s, so that the errors that it
saw add up to k_e/k_i; the error of the first sample, before anything can move, is T_s of this, and a low-pass on the
measured speed sees the rest later by its delay T_f:

    τ = k_e/k_i − T_s − T_f

Neither masses nor inertias enter, so that v and ω have the same τ. Left out: the shape of the response (it is that of
second order), dry friction, the coupling of v and ω by a center of mass off the axle, and the limits of voltage and
torque, for which the rate of the command is bounded instead (:func:`wheel_rate`).
"""

import math
from typing import NamedTuple

from fuzzy.compiled.columns import Columns, column
from fuzzy.compiled.jit import compiled_only
from fuzzy.compiled.trigonometry import sincos
from robotics.world.vehicle.robot import Robot


def wheel_rate(robot: Robot) -> float:
    """How fast [m/s²] both wheels can be made to change their speed, straight on and on the spot.

    Straight on two torques τ_m − τ_friction move the mass, on the spot they turn the inertia: the smaller one counts. A
    twentieth of τ_m is taken to be left over by friction in any case.
    """
    motor = min(robot.torque_limit, robot.torque_constant * robot.supply_voltage)
    torque = max(motor - robot.friction_torque, motor / 20)
    straight = 2 * torque / (robot.wheel_radius * robot.effective_mass)
    spot = 2 * torque * robot.half_axle**2 / (robot.wheel_radius * robot.effective_inertia)
    return min(straight, spot)


class Response(NamedTuple):
    """How the velocities, and what they add up to, depend on those at first and on the command, after a duration h."""

    decay: float  # e^{−h/τ}: what is left of the difference from the command
    own: float  # s: τ (1 − e^{−h/τ}): the distance for 1 m/s of the first speed, or the turn
    given: float  # s: h − own: likewise of the command
    own_half: float  # s: as own, after h/2
    given_half: float  # s


ResponseColumns = Columns.named("ResponseColumns", {name: column("") for name in Response._fields})


def response(duration: float, lag: float) -> Response:
    """The response of velocities that follow with the time constant ``lag`` [s] after a ``duration`` [s]."""
    decay, own = _followed(duration, lag)
    _, half = _followed(duration / 2, lag)
    return Response(decay, own, duration - own, half, duration / 2 - half)


def _followed(duration: float, lag: float) -> tuple[float, float]:
    left = math.exp(-duration / lag) if lag > 0 else float(duration == 0)
    return left, lag * (1 - left)


class Shares(NamedTuple):
    """The weights, whose sum is 1, of what tells a velocity now."""

    mean: float  # of the mean velocity over the last period, which the encoders measure
    older: float  # of the command that acted in the period's first part
    newer: float  # and of that which acted in the rest


ShareColumns = Columns.named("ShareColumns", {name: column("1") for name in Shares._fields})


def velocity_shares(period: float, change: float, lag: float) -> Shares:
    """The weights by which a velocity follows from its mean over a ``period`` [s], and from the commands in it.

    The newer command acts from ``change`` [s] on. The mean's weight is (h/τ)/(e^{h/τ} − 1), at most 1: the noise of the
    encoders does not grow.
    """
    if lag == 0:
        return Shares(0.0, 0.0, 1.0)
    first, second = response(change, lag), response(period - change, lag)
    # mean · h = older δ + (start − older) m(δ) + newer (h − δ) + (middle − newer) m(h − δ)
    start = first.own + first.decay * second.own  # s: of the mean, for 1 m/s at the start of the period
    older = first.given + (1 - first.decay) * second.own
    left = first.decay * second.decay
    # now = newer + (middle − newer) e^{...},  middle = older + (start − older) e^{...}
    mean = left * period / start
    before = (1 - first.decay) * second.decay - mean * older / period
    return Shares(mean, before, (1 - second.decay) - mean * second.given / period)


@compiled_only
def moved(x, y, heading, v, w, v_c, w_c, after):  # type: ignore[no-untyped-def]
    """The state after a duration in which a command is held; ``after`` is its :class:`Response`.

    Returns x, y [m], heading [rad], v [m/s], ω [rad/s], and for derivatives the distance [m], and the sine and the
    cosine of the heading along which it was driven.
    """
    distance = after.own * v + after.given * v_c
    sin, cos = sincos(heading + after.own_half * w + after.given_half * w_c)
    return (
        x + distance * cos, y + distance * sin, heading + after.own * w + after.given * w_c,
        v_c + after.decay * (v - v_c), w_c + after.decay * (w - w_c), distance, sin, cos,
    )  # fmt: skip
