"""An extended Kalman filter that joins a pose sensor with odometry, and learns what odometry has a little wrong.

The state is the pose (x, y, ψ) and the scales s_r, s_l, b: the true radii of the wheels and the true axle over those
that odometry assumes [Martinelli, Tomatis, Siegwart 2007]. With the ways a_r, a_l that the assumed radii make of the
encoders in a period,

    d_r = s_r a_r,  d_l = s_l a_l,  f = (d_r + d_l)/2,  t = (d_r − d_l)/(2 L b)
    x' = x + f cos(ψ + t/2),  y' = y + f sin(ψ + t/2),  ψ' = ψ + t

the scales stay. The variance of a wheel's way grows with the way, slip² |d| [Chong, Kleeman 1997]. The sensor measures
x, y and ψ with independent noise, so each is put in by itself, in Joseph's form, which keeps the covariance symmetric
and positive whatever is rounded [Bar-Shalom, Li, Kirubarajan 2001, 5.2.3]:

    k = P h / (h' P h + r),  z' = z + k (m − h' z),  P' = (I − k h') P (I − k h')' + k r k'

It begins with the first measurement, and with the spreads of wheels and axle that the sensing tells.
"""

import math

from fuzzy.compiled.columns import Columns, column, several
from fuzzy.compiled.jit import compiled_only

_STATES = 6  # x, y, heading, right, left, axle
_LEAST_VARIANCE = 1e-12  # m², rad²: of a sensor without noise


class EstimateColumns(Columns):
    """What the filter knows beside the pose."""

    right = column("1", "scale of the right wheel")
    left = column("1", "scale of the left wheel")
    axle = column("1", "scale of the axle")
    covariance = several(_STATES * _STATES, "m, m, rad, 1, 1, 1", "of pose and scales, row after row")


@compiled_only
def begin(lane: EstimateColumns, variance, wheel, axle):  # type: ignore[no-untyped-def]
    """Begin at a measurement with these three ``variance``, and with the spreads of wheels and axle."""
    lane.right = lane.left = lane.axle = 1.0
    p = lane.covariance
    p[:] = 0.0
    for n in range(3):
        p[7 * n] = max(variance[n], _LEAST_VARIANCE)
    p[21] = p[28] = wheel * wheel
    p[35] = axle * axle


@compiled_only
def predict(lane: EstimateColumns, x, y, heading, way_r, way_l, half_axle, slip):  # type: ignore[no-untyped-def]
    """Go on by the ways of the wheels [m], as odometry takes them; return the pose."""
    p = lane.covariance
    right, left = lane.right * way_r, lane.left * way_l
    axle = 2 * half_axle * lane.axle
    forward, turn = (right + left) / 2, (right - left) / axle
    cos, sin = math.cos(heading + turn / 2), math.sin(heading + turn / 2)
    # How the pose follows the heading, a wheel's way and the axle
    of_heading = -forward * sin, forward * cos
    of_right = cos / 2 - forward * sin / (2 * axle), sin / 2 + forward * cos / (2 * axle), 1 / axle
    of_left = cos / 2 + forward * sin / (2 * axle), sin / 2 - forward * cos / (2 * axle), -1 / axle
    of_axle = forward * sin * turn / 2 / lane.axle, -forward * cos * turn / 2 / lane.axle, -turn / lane.axle
    # F P F', in place: rows, then columns; x and y first, since they need the old heading
    for n in range(3):
        for m in range(_STATES):
            change = of_right[n] * way_r * p[18 + m] + of_left[n] * way_l * p[24 + m] + of_axle[n] * p[30 + m]
            p[6 * n + m] += change + (of_heading[n] * p[12 + m] if n < 2 else 0.0)
    for n in range(3):
        for m in range(0, _STATES * _STATES, _STATES):
            change = of_right[n] * way_r * p[m + 3] + of_left[n] * way_l * p[m + 4] + of_axle[n] * p[m + 5]
            p[m + n] += change + (of_heading[n] * p[m + 2] if n < 2 else 0.0)
    slip_r, slip_l = slip * slip * abs(right), slip * slip * abs(left)
    for n in range(3):
        for m in range(3):
            p[6 * n + m] += slip_r * of_right[n] * of_right[m] + slip_l * of_left[n] * of_left[m]
    return x + forward * cos, y + forward * sin, heading + turn


@compiled_only
def correct(lane: EstimateColumns, x, y, heading, n, measured, variance):  # type: ignore[no-untyped-def]
    """Put a measurement of the ``n``-th number of the pose in, with its variance; return the pose."""
    p = lane.covariance
    whole = p[7 * n] + variance
    gain = p[n] / whole, p[6 + n] / whole, p[12 + n] / whole, p[18 + n] / whole, p[24 + n] / whole, p[30 + n] / whole
    rest = variance / whole  # 1 - gain[n]
    for i in range(_STATES):
        for m in range(_STATES):
            if i != n:
                p[6 * i + m] -= gain[i] * p[6 * n + m]
    for m in range(_STATES):
        p[6 * n + m] *= rest
    for m in range(0, _STATES * _STATES, _STATES):
        for i in range(_STATES):
            if i != n:
                p[m + i] -= gain[i] * p[m + n]
        p[m + n] *= rest
    for i in range(_STATES):
        for m in range(i, _STATES):
            p[6 * i + m] = p[6 * m + i] = p[6 * i + m] + variance * gain[i] * gain[m]
    more = measured - (x if n == 0 else y if n == 1 else heading)
    lane.right += gain[3] * more
    lane.left += gain[4] * more
    lane.axle += gain[5] * more
    return x + gain[0] * more, y + gain[1] * more, heading + gain[2] * more


@compiled_only
def joined(lane: EstimateColumns, pose, ways, half_axle, slip, measured, variances):  # type: ignore[no-untyped-def]
    """The pose a period later, by the ways of both wheels and by what the sensor measures of it."""
    x, y, heading = predict(lane, pose[0], pose[1], pose[2], ways[0], ways[1], half_axle, slip)
    for n in range(3):
        x, y, heading = correct(lane, x, y, heading, n, measured[n], max(variances[n], _LEAST_VARIANCE))
    return x, y, heading
