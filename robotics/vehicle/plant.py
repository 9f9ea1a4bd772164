"""The plant: encoders, wheel loops, motors and the rigid body of all robots of all runs in one pass.

A commanded velocity is bounded in itself, then in how fast it may change where the robot has such bounds (thesis
(5.1)), then by what the wheels can turn. Commanded torques are bounded by the motors only.

A tick is the high-level period (50 ms). It consists of steps of 10 ms, as in the robot's microcontroller: read the
encoders, run the wheel loops, hold the voltage. Inside a step the velocities are integrated by Runge-Kutta
(order 4) and the pose follows the exact arc of each substep.

The state is an array (channels, lanes): a lane is one robot of one run, and no lane sees another. Lanes are computed
in blocks of a constant size, which the compiler turns into vector instructions without changing a bit of the result.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from math import pi, tan
from typing import Literal

import numpy as np

from fuzzy.compiled.jit import inner, uncounted
from robotics.vehicle.robot import Robot

Level = Literal["velocity", "torque"]
STEP = 0.01  # s: the wheel loops' period (thesis 2.1.3.1)

# Channels of the state -----------------------------------------------------------------------------------------
X, Y, HEADING = 0, 1, 2  # m, m, rad: the true pose of the axle midpoint
V, W = 3, 4  # m/s, rad/s: the true velocity
ANGLE_R, ANGLE_L = 5, 6  # rad: wheel angles
INTEGRAL_R, INTEGRAL_L = 7, 8  # V: the wheel loops' integral parts
SPEED_R, SPEED_L = 9, 10  # rad/s: wheel speeds as the loops see them (encoders, filter)
RAW1_R, RAW2_R, RAW1_L, RAW2_L = 11, 12, 13, 14  # rad/s: the filters' past inputs
PAST_R, PAST_L = 15, 16  # rad/s: the filters' outputs one step before SPEED_R, SPEED_L
ODO_X, ODO_Y, ODO_HEADING = 17, 18, 19  # m, m, rad: the pose by odometry
TORQUE_R, TORQUE_L = 20, 21  # N m: motor torques at the start of the last step
WORK, LOSS = 22, 23  # J: done by the motors; lost to friction
EFFORT, VARIATION = 24, 25  # N² m² s: ∫ τr² + τl² dt; N m: Σ |Δτr| + |Δτl| from step to step
HELD_V, HELD_W = 26, 27  # m/s, rad/s: the commanded velocity within all its bounds, as the last step held it
CHANNELS = 28

# Rows of the parameters
(
    P_MASS, P_INERTIA, P_COUPLING, P_RADIUS, P_HALF_AXLE, P_VOLTAGE, P_KT, P_KE, P_TORQUE_LIMIT, P_FRICTION,
    P_FRICTION_SPEED, P_COUNT, P_KP, P_KI, P_KD, P_B0, P_B1, P_B2, P_A1, P_A2, P_V_MAX, P_W_MAX, P_WHEEL_MAX,
    P_ODO_RIGHT, P_ODO_LEFT, P_ODO_HALF_AXLE,  # the wheels' radii and the half axle that odometry assumes
    P_V_RATE, P_W_RATE,
    P_LOOP_RADIUS,  # the wheels' radius that the wheel loops assume
) = range(29)  # fmt: skip
PARAMETERS = 29

_ANY_RATE = 1e300
_BLOCK = 32  # lanes of a block, whose rows of numbers stay in the first cache
_VECTOR = 8  # lanes: a block is filled up to a multiple of it
# Rows of a block's scratch beyond the state and the parameters
_S = CHANNELS + PARAMETERS
(
    _VOLT_R, _VOLT_L, _COS, _SIN, _OCOS, _OSIN, _OLD_R, _OLD_L, _PER_MASS, _PER_INERTIA, _PER_R,
    _V, _W, _SUM_A, _SUM_B, _SUM_V, _SUM_W, _SUM_P, _SUM_Q,  # of the four stages of Runge-Kutta
) = range(_S, _S + 19)  # fmt: skip
_ROWS = _S + 19
SCRATCH = _ROWS * _BLOCK  # numbers that :func:`tick_into` works in
CODES = {"velocity": 0, "torque": 1}  # of what a command is,
KINEMATIC = 2  # or of the plant that needs no wheel loops
SUBSTEPS = 4  # Runge-Kutta steps a step: the pose is then within 1e-7 m of the limit after 5 s


def parameters(robot: Robot, step: float = 0.01, believed: Robot | None = None) -> np.ndarray:
    """Return one lane's parameters (PARAMETERS,) of ``robot``, with the filter's coefficients for ``step`` [s].

    Its wheel loops and its odometry take it for the robot ``believed``, where that is given: they assume the wheels'
    radius and the axle of that one.
    """
    believed = believed or robot
    b0, b1, b2, a1, a2 = _low_pass(robot.filter_frequency, step)
    rows = {
        P_MASS: robot.effective_mass,
        P_INERTIA: robot.effective_inertia,
        P_COUPLING: robot.body_mass * robot.mass_offset,  # m_c d, not m d: the wheels sit on the axle
        P_RADIUS: robot.wheel_radius,
        P_HALF_AXLE: robot.half_axle,
        P_VOLTAGE: robot.supply_voltage,
        P_KT: robot.torque_constant,
        P_KE: robot.back_emf,
        P_TORQUE_LIMIT: robot.torque_limit,
        P_FRICTION: robot.friction_torque,
        P_FRICTION_SPEED: robot.friction_speed,
        P_COUNT: robot.counts_per_turn / (2 * pi),
        P_KP: robot.kp,
        P_KI: robot.ki,
        P_KD: robot.kd,
        P_B0: b0,
        P_B1: b1,
        P_B2: b2,
        P_A1: a1,
        P_A2: a2,
        P_V_MAX: robot.v_max,
        P_W_MAX: robot.w_max,
        P_WHEEL_MAX: robot.wheel_speed_max,
        P_ODO_RIGHT: believed.wheel_radius,
        P_ODO_LEFT: believed.wheel_radius,
        P_ODO_HALF_AXLE: believed.half_axle,
        P_V_RATE: _ANY_RATE if robot.v_rate_max is None else robot.v_rate_max,
        P_W_RATE: _ANY_RATE if robot.w_rate_max is None else robot.w_rate_max,
        P_LOOP_RADIUS: believed.wheel_radius,
    }
    return np.array([rows[i] for i in range(PARAMETERS)])


def _low_pass(frequency: float, step: float) -> tuple[float, float, float, float, float]:
    """A Butterworth-like low-pass (damping 0.7) by the bilinear transform: y = b0 u + b1 u₁ + b2 u₂ − a1 y₁ − a2 y₂."""
    if frequency == 0.0:
        return 1.0, 0.0, 0.0, 0.0, 0.0
    k = tan(pi * frequency * step)
    scale = 1 / (1 + 2 * 0.7 * k + k * k)
    return k * k * scale, 2 * k * k * scale, k * k * scale, 2 * (k * k - 1) * scale, (1 - 1.4 * k + k * k) * scale


def initial_state(pose: np.ndarray, believed: np.ndarray | None = None) -> np.ndarray:
    """The state (CHANNELS, lanes) of robots at rest at ``pose`` (lanes, 3): x [m], y [m], heading [rad].

    Odometry starts from ``believed`` (lanes, 3), the poses that the robots believe to have; by default the true ones.
    """
    state = np.zeros((CHANNELS, len(pose)))
    state[[X, Y, HEADING]] = pose.T
    state[[ODO_X, ODO_Y, ODO_HEADING]] = (pose if believed is None else believed).T
    return state


@dataclass(frozen=True)
class Plant:
    """The plant of a simulation, which turns commands into motion: the robots' parameters and the time grid."""

    parameters: np.ndarray  # (PARAMETERS, lanes)
    steps: int = 5  # steps a tick
    step: float = 0.01  # s
    substeps: int = SUBSTEPS
    kinematic: bool = False  # the velocity is the command within its bounds, without delay

    def advance(
        self, state: np.ndarray, earlier: np.ndarray, command: np.ndarray, late_steps: int, level: Level
    ) -> np.ndarray:
        """Return the state one tick later (CHANNELS, lanes).

        Args:
            state: The state now (CHANNELS, lanes).
            earlier: The command before ``command`` (2, lanes).
            command: v [m/s] and ω [rad/s] for the level "velocity", the right and the left wheel's torque [N m] for
                "torque" (2, lanes).
            late_steps: The number of steps that still hold ``earlier`` (latency).
            level: "velocity" or "torque".
        """
        code = KINEMATIC if self.kinematic else CODES[level]
        out, steps = np.empty_like(state), (late_steps, self.steps, self.step, self.substeps)
        tick_into(out, state, self.parameters, earlier, command, *steps, code, np.empty(SCRATCH))
        return out


def velocity_limits(robots: Sequence[Robot]) -> np.ndarray:
    """The bounds of each robot's velocity (4, robots): v_max [m/s], ω_max [rad/s], half axle L [m], r ω_wheel [m/s]."""
    return np.array([(r.v_max, r.w_max, r.half_axle, r.wheel_speed_limit) for r in robots]).T


def saturate(limits: np.ndarray, v: np.ndarray, w: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the velocities v [m/s] and ω [rad/s] within the limits that the plant makes of a command.

    Each is clamped; then both are scaled onto the wheels' diamond |v| + L |ω| <= r ω_wheel, which keeps the curvature.
    How fast they may change, where a robot has such bounds, plays no part here: it is what the plant makes in the end.

    Args:
        limits: As of :func:`velocity_limits` (4, robots).
        v: The commanded speed (..., robots) [m/s].
        w: The commanded angular velocity (..., robots) [rad/s].
    """
    v_max, w_max, half_axle, wheel = limits
    v = np.minimum(np.maximum(v, -v_max), v_max)
    w = np.minimum(np.maximum(w, -w_max), w_max)
    scale = np.minimum(1.0, wheel / np.maximum(np.abs(v) + half_axle * np.abs(w), 1e-12))
    return v * scale, w * scale


@inner
def within(limits, robot, v, w):  # type: ignore[no-untyped-def]
    """The same as :func:`saturate` for one robot, the ``robot``-th of ``limits``, in compiled functions."""
    v_max, w_max, half_axle, wheel = limits[0, robot], limits[1, robot], limits[2, robot], limits[3, robot]
    v = v if not abs(v) > v_max else (v_max if v > 0 else -v_max)
    w = w if not abs(w) > w_max else (w_max if w > 0 else -w_max)
    scale = min(1.0, wheel / max(abs(v) + half_axle * abs(w), 1e-12))
    return v * scale, w * scale


@inner
def _wheel_torque(voltage, speed, kt, ke, hold, supply, limit):  # type: ignore[no-untyped-def]
    """A motor's torque at a wheel speed. ``hold`` 1: the voltage is held; 0: the drive holds the torque kt · voltage.

    Either way the supply minus the back-EMF bounds the torque, and the tyre slips at the limit.
    """
    back = ke * speed
    torque = kt * min(max(voltage - hold * back, -supply - back), supply - back)
    return min(max(torque, -limit), limit)


@inner
def _accelerations(  # type: ignore[no-untyped-def]
    v, w, ur, ul, per_mass, per_inertia, coupling, per_r, half, kt, ke, hold, supply, limit, friction, slow
):
    """Return v' and ω' at the axle midpoint, the motors' power and the friction's, from the wheels' drives.

    (m + 2 J_w/r²) v'     = (τr + τl)/r + m_c d ω²
    (I0 + 2 J_w L²/r²) ω' = L (τr − τl)/r − m_c d v ω

    the reduced form of thesis (2.1)-(2.9) with d ≠ 0 at the axle midpoint; d = 0 gives (2.10). Radius, mass and
    inertia are given as their reciprocals, since this is the innermost loop.
    """
    speed_r = (v + half * w) * per_r
    speed_l = (v - half * w) * per_r
    motor_r = _wheel_torque(ur, speed_r, kt, ke, hold, supply, limit)
    motor_l = _wheel_torque(ul, speed_l, kt, ke, hold, supply, limit)
    # Coulomb friction, smooth through standstill
    drag_r = friction * speed_r / np.sqrt(speed_r * speed_r + slow * slow)
    drag_l = friction * speed_l / np.sqrt(speed_l * speed_l + slow * slow)
    tr = motor_r - drag_r
    tl = motor_l - drag_l
    a = ((tr + tl) * per_r + coupling * w * w) * per_mass
    b = (half * (tr - tl) * per_r - coupling * v * w) * per_inertia
    return a, b, motor_r * speed_r + motor_l * speed_l, drag_r * speed_r + drag_l * speed_l


@uncounted
def tick_into(  # type: ignore[no-untyped-def]
    out, state, parameters, earlier, command, late_steps, steps, step, substeps, code, z
):
    """Write the state one tick later into ``out`` (CHANNELS, lanes), which may be ``state``; nothing is allocated.

    The arguments are as of :meth:`Plant.advance`; ``code`` is 0 for velocities, 1 for torques, 2 for the kinematic
    plant, and ``z`` has SCRATCH numbers to work in, one such array for each thread.
    """
    tick_lanes(
        0, state.shape[1], out, state, parameters, earlier, command, late_steps, steps, step, substeps, code, z
    )  # fmt: skip


@inner
def tick_lanes(  # type: ignore[no-untyped-def]
    first, last, out, state, parameters, earlier, command, late_steps, steps, step, substeps, code, z
):
    """Do the same for the lanes from ``first`` to before ``last`` alone."""
    hold = 0.0 if code == 1 else 1.0
    for start in range(first, last, _BLOCK):
        count = min(_BLOCK, last - start)
        width = -(-count // _VECTOR) * _VECTOR
        _load(z, width, state, start, count)
        _load(z[CHANNELS * _BLOCK :], width, parameters, start, count)
        _begin(z, width)
        for k in range(steps):
            held = earlier if k < late_steps else command
            _load(z[_VOLT_R * _BLOCK :], width, held, start, count)
            _loops(z, width, step, code)
            if code == 2:
                _glide(z, width, step)
            else:
                for _ in range(substeps):
                    _move(z, width, step / substeps, hold)
            _odometry(z, width, step)
        for c in range(CHANNELS):
            for i in range(count):
                out[c, start + i] = z[c * _BLOCK + i]


@inner
def _load(z, width, array, start, count):  # type: ignore[no-untyped-def]
    """Copy a block's columns of ``array`` to the rows of ``z``; the last lane fills up an incomplete vector."""
    for r in range(len(array)):
        for i in range(count):
            z[r * _BLOCK + i] = array[r, start + i]
        for i in range(count, width):
            z[r * _BLOCK + i] = array[r, start + count - 1]


@inner
def _begin(z, width):  # type: ignore[no-untyped-def]
    """Make what all steps of a tick need of the parameters and of the state."""
    for i in range(width):
        z[_PER_MASS * _BLOCK + i] = 1 / z[(CHANNELS + P_MASS) * _BLOCK + i]
        z[_PER_INERTIA * _BLOCK + i] = 1 / z[(CHANNELS + P_INERTIA) * _BLOCK + i]
        z[_PER_R * _BLOCK + i] = 1 / z[(CHANNELS + P_RADIUS) * _BLOCK + i]
        z[_OLD_R * _BLOCK + i] = np.floor(z[ANGLE_R * _BLOCK + i] * z[(CHANNELS + P_COUNT) * _BLOCK + i])
        z[_OLD_L * _BLOCK + i] = np.floor(z[ANGLE_L * _BLOCK + i] * z[(CHANNELS + P_COUNT) * _BLOCK + i])
    for i in range(width):
        z[_COS * _BLOCK + i] = np.cos(z[HEADING * _BLOCK + i])
        z[_SIN * _BLOCK + i] = np.sin(z[HEADING * _BLOCK + i])
        z[_OCOS * _BLOCK + i] = np.cos(z[ODO_HEADING * _BLOCK + i])
        z[_OSIN * _BLOCK + i] = np.sin(z[ODO_HEADING * _BLOCK + i])


@inner
def _loops(z, width, step, code):  # type: ignore[no-untyped-def]
    """Turn the held command (in the voltage rows) into the voltages of this step, or the velocity if kinematic."""
    for i in range(width):
        r = z[(CHANNELS + P_RADIUS) * _BLOCK + i]
        half = z[(CHANNELS + P_HALF_AXLE) * _BLOCK + i]
        kt = z[(CHANNELS + P_KT) * _BLOCK + i]
        ke = z[(CHANNELS + P_KE) * _BLOCK + i]
        limit = z[(CHANNELS + P_TORQUE_LIMIT) * _BLOCK + i]
        volts = z[(CHANNELS + P_VOLTAGE) * _BLOCK + i]
        first = z[_VOLT_R * _BLOCK + i]
        second = z[_VOLT_L * _BLOCK + i]
        true_r = (z[V * _BLOCK + i] + half * z[W * _BLOCK + i]) / r
        true_l = (z[V * _BLOCK + i] - half * z[W * _BLOCK + i]) / r
        hold = 1.0
        if code == 1:
            # The drive holds the commanded torque, as a current loop faster than 10 ms does.
            hold = 0.0
            ur = first / kt
            ul = second / kt
        else:
            top_v = z[(CHANNELS + P_V_MAX) * _BLOCK + i]
            top_w = z[(CHANNELS + P_W_MAX) * _BLOCK + i]
            v = min(max(first, -top_v), top_v)
            w = min(max(second, -top_w), top_w)
            # thesis (5.1): |v'| and |ω'| of the command are bounded. The wheels' limit comes last, and wins.
            most_v = z[(CHANNELS + P_V_RATE) * _BLOCK + i] * step
            most_w = z[(CHANNELS + P_W_RATE) * _BLOCK + i] * step
            held_v = z[HELD_V * _BLOCK + i]
            held_w = z[HELD_W * _BLOCK + i]
            v = min(max(v, held_v - most_v), held_v + most_v)
            w = min(max(w, held_w - most_w), held_w + most_w)
            assumed = z[(CHANNELS + P_LOOP_RADIUS) * _BLOCK + i]
            ref_r = (v + half * w) / assumed  # thesis (2.6), with the labels the right way round
            ref_l = (v - half * w) / assumed
            fastest = max(abs(ref_r), abs(ref_l))
            top = z[(CHANNELS + P_WHEEL_MAX) * _BLOCK + i]
            scale = min(1.0, top / max(fastest, 1e-12))
            ref_r = ref_r * scale
            ref_l = ref_l * scale
            z[HELD_V * _BLOCK + i] = v * scale
            z[HELD_W * _BLOCK + i] = w * scale
            if code == 2:
                z[V * _BLOCK + i] = v * scale
                z[W * _BLOCK + i] = w * scale
            kp = z[(CHANNELS + P_KP) * _BLOCK + i]
            ki = z[(CHANNELS + P_KI) * _BLOCK + i]
            kd = z[(CHANNELS + P_KD) * _BLOCK + i]
            speed_r = z[SPEED_R * _BLOCK + i]
            speed_l = z[SPEED_L * _BLOCK + i]
            rate_r = (speed_r - z[PAST_R * _BLOCK + i]) / step
            rate_l = (speed_l - z[PAST_L * _BLOCK + i]) / step
            wish_r = kp * (ref_r - speed_r) + z[INTEGRAL_R * _BLOCK + i] - kd * rate_r
            wish_l = kp * (ref_l - speed_l) + z[INTEGRAL_L * _BLOCK + i] - kd * rate_l
            ur = min(max(wish_r, -volts), volts)
            ul = min(max(wish_l, -volts), volts)
            # Back-calculation: the part that saturation cuts off leaves the integral with the loop's own time kp/ki.
            back = ki / max(kp, 1e-12)
            z[INTEGRAL_R * _BLOCK + i] += step * (ki * (ref_r - speed_r) + back * (ur - wish_r))
            z[INTEGRAL_L * _BLOCK + i] += step * (ki * (ref_l - speed_l) + back * (ul - wish_l))
        z[_VOLT_R * _BLOCK + i] = ur
        z[_VOLT_L * _BLOCK + i] = ul
        torque_r = _wheel_torque(ur, true_r, kt, ke, hold, volts, limit)
        torque_l = _wheel_torque(ul, true_l, kt, ke, hold, volts, limit)
        if code == 2:
            torque_r = 0.0
            torque_l = 0.0
        change = abs(torque_r - z[TORQUE_R * _BLOCK + i]) + abs(torque_l - z[TORQUE_L * _BLOCK + i])
        z[VARIATION * _BLOCK + i] += change
        z[EFFORT * _BLOCK + i] += step * (torque_r * torque_r + torque_l * torque_l)
        z[TORQUE_R * _BLOCK + i] = torque_r
        z[TORQUE_L * _BLOCK + i] = torque_l


@inner
def _move(z, width, h, hold):  # type: ignore[no-untyped-def]
    """Do one Runge-Kutta step of the velocities over ``h`` seconds, and move the pose along its arc meanwhile."""
    for i in range(width):
        z[_V * _BLOCK + i] = z[V * _BLOCK + i]
        z[_W * _BLOCK + i] = z[W * _BLOCK + i]
        for row in range(_SUM_A, _SUM_Q + 1):
            z[row * _BLOCK + i] = 0.0
    _stage(z, width, 1.0, 0.5 * h, hold)
    _stage(z, width, 2.0, 0.5 * h, hold)
    _stage(z, width, 2.0, h, hold)
    _stage(z, width, 1.0, 0.0, hold)
    for i in range(width):
        half = z[(CHANNELS + P_HALF_AXLE) * _BLOCK + i]
        per_r = z[_PER_R * _BLOCK + i]
        v1 = z[V * _BLOCK + i]
        w1 = z[W * _BLOCK + i]
        v5 = v1 + h / 6 * z[_SUM_A * _BLOCK + i]
        w5 = w1 + h / 6 * z[_SUM_B * _BLOCK + i]
        z[V * _BLOCK + i] = v5
        z[W * _BLOCK + i] = w5
        z[WORK * _BLOCK + i] += h / 6 * z[_SUM_P * _BLOCK + i]
        z[LOSS * _BLOCK + i] += h / 6 * z[_SUM_Q * _BLOCK + i]
        forward = h / 6 * z[_SUM_V * _BLOCK + i]
        turn = h / 6 * z[_SUM_W * _BLOCK + i]
        # v and ω changing together leave the arc a little sideways (Magnus expansion, second term).
        sideways = h * h / 12 * (v5 * w1 - v1 * w5)
        z[ANGLE_R * _BLOCK + i] += (forward + half * turn) * per_r
        z[ANGLE_L * _BLOCK + i] += (forward - half * turn) * per_r
        _arc(z, i, X, Y, HEADING, _COS, _SIN, forward, sideways, turn)


@inner
def _stage(z, width, weight, reach, hold):  # type: ignore[no-untyped-def]
    """Do one stage of Runge-Kutta: add what it finds, times ``weight``, to the sums; the next is ``reach`` [s] on.

    The loop is short: a lane is a chain of arithmetic that waits for a root and a division, and others fill the gap.
    """
    for i in range(width):
        v = z[_V * _BLOCK + i]
        w = z[_W * _BLOCK + i]
        a, b, p, q = _accelerations(
            v, w, z[_VOLT_R * _BLOCK + i], z[_VOLT_L * _BLOCK + i], z[_PER_MASS * _BLOCK + i],
            z[_PER_INERTIA * _BLOCK + i], z[(CHANNELS + P_COUPLING) * _BLOCK + i], z[_PER_R * _BLOCK + i],
            z[(CHANNELS + P_HALF_AXLE) * _BLOCK + i], z[(CHANNELS + P_KT) * _BLOCK + i],
            z[(CHANNELS + P_KE) * _BLOCK + i], hold, z[(CHANNELS + P_VOLTAGE) * _BLOCK + i],
            z[(CHANNELS + P_TORQUE_LIMIT) * _BLOCK + i], z[(CHANNELS + P_FRICTION) * _BLOCK + i],
            z[(CHANNELS + P_FRICTION_SPEED) * _BLOCK + i],
        )  # fmt: skip
        z[_SUM_A * _BLOCK + i] += weight * a
        z[_SUM_B * _BLOCK + i] += weight * b
        z[_SUM_P * _BLOCK + i] += weight * p
        z[_SUM_Q * _BLOCK + i] += weight * q
        z[_SUM_V * _BLOCK + i] += weight * v
        z[_SUM_W * _BLOCK + i] += weight * w
        z[_V * _BLOCK + i] = z[V * _BLOCK + i] + reach * a
        z[_W * _BLOCK + i] = z[W * _BLOCK + i] + reach * b


@inner
def _glide(z, width, step):  # type: ignore[no-untyped-def]
    """Move the kinematic plant: the velocity is the command, and the arc is exact."""
    for i in range(width):
        r = z[(CHANNELS + P_RADIUS) * _BLOCK + i]
        half = z[(CHANNELS + P_HALF_AXLE) * _BLOCK + i]
        forward = z[V * _BLOCK + i] * step
        turn = z[W * _BLOCK + i] * step
        z[ANGLE_R * _BLOCK + i] += (forward + half * turn) / r
        z[ANGLE_L * _BLOCK + i] += (forward - half * turn) / r
        _arc(z, i, X, Y, HEADING, _COS, _SIN, forward, 0.0, turn)


@inner
def _arc(z, i, x, y, heading, cos, sin, forward, sideways, turn):  # type: ignore[no-untyped-def]
    """Move a pose along the arc of a constant twist: the exact solution of thesis (2.27)."""
    q = turn * turn
    # sin(θ)/θ, (1 − cos θ)/θ and cos θ by their series, exact in float64 for the |θ| < 0.1 rad of one step
    s = 1 - q / 6 * (1 - q / 20 * (1 - q / 42 * (1 - q / 72)))
    c = turn / 2 * (1 - q / 12 * (1 - q / 30 * (1 - q / 56 * (1 - q / 90))))
    cos_turn = 1 - turn * c
    sin_turn = turn * s
    along = forward * s - sideways * c
    across = forward * c + sideways * s
    ch = z[cos * _BLOCK + i]
    sh = z[sin * _BLOCK + i]
    z[x * _BLOCK + i] += along * ch - across * sh
    z[y * _BLOCK + i] += along * sh + across * ch
    z[heading * _BLOCK + i] += turn
    z[cos * _BLOCK + i] = ch * cos_turn - sh * sin_turn
    z[sin * _BLOCK + i] = sh * cos_turn + ch * sin_turn


@inner
def _odometry(z, width, step):  # type: ignore[no-untyped-def]
    """Read the encoders after the step: the wheel speeds for the loops, and the pose by odometry."""
    for i in range(width):
        per_radian = z[(CHANNELS + P_COUNT) * _BLOCK + i]
        radius_r = z[(CHANNELS + P_ODO_RIGHT) * _BLOCK + i]
        radius_l = z[(CHANNELS + P_ODO_LEFT) * _BLOCK + i]
        half = z[(CHANNELS + P_ODO_HALF_AXLE) * _BLOCK + i]
        count_r = np.floor(z[ANGLE_R * _BLOCK + i] * per_radian)
        count_l = np.floor(z[ANGLE_L * _BLOCK + i] * per_radian)
        turn_r = (count_r - z[_OLD_R * _BLOCK + i]) / per_radian
        turn_l = (count_l - z[_OLD_L * _BLOCK + i]) / per_radian
        z[_OLD_R * _BLOCK + i] = count_r
        z[_OLD_L * _BLOCK + i] = count_l
        raw_r = turn_r / step
        raw_l = turn_l / step
        b0 = z[(CHANNELS + P_B0) * _BLOCK + i]
        b1 = z[(CHANNELS + P_B1) * _BLOCK + i]
        b2 = z[(CHANNELS + P_B2) * _BLOCK + i]
        f1 = z[(CHANNELS + P_A1) * _BLOCK + i]
        f2 = z[(CHANNELS + P_A2) * _BLOCK + i]
        smooth_r = (
            b0 * raw_r
            + b1 * z[RAW1_R * _BLOCK + i]
            + b2 * z[RAW2_R * _BLOCK + i]
            - f1 * z[SPEED_R * _BLOCK + i]
            - f2 * z[PAST_R * _BLOCK + i]
        )
        smooth_l = (
            b0 * raw_l
            + b1 * z[RAW1_L * _BLOCK + i]
            + b2 * z[RAW2_L * _BLOCK + i]
            - f1 * z[SPEED_L * _BLOCK + i]
            - f2 * z[PAST_L * _BLOCK + i]
        )
        z[RAW2_R * _BLOCK + i] = z[RAW1_R * _BLOCK + i]
        z[RAW2_L * _BLOCK + i] = z[RAW1_L * _BLOCK + i]
        z[RAW1_R * _BLOCK + i] = raw_r
        z[RAW1_L * _BLOCK + i] = raw_l
        z[PAST_R * _BLOCK + i] = z[SPEED_R * _BLOCK + i]
        z[PAST_L * _BLOCK + i] = z[SPEED_L * _BLOCK + i]
        z[SPEED_R * _BLOCK + i] = smooth_r
        z[SPEED_L * _BLOCK + i] = smooth_l
        forward = (radius_r * turn_r + radius_l * turn_l) / 2
        turn = (radius_r * turn_r - radius_l * turn_l) / (2 * half)  # thesis (2.25), with 2 L between the wheels
        _arc(z, i, ODO_X, ODO_Y, ODO_HEADING, _OCOS, _OSIN, forward, 0.0, turn)
