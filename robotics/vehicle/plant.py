"""The plant: encoders, wheel loops, motors and the rigid body of all robots of all runs in one pass.

A commanded velocity is bounded in itself, then in how fast it may change where the robot has such bounds (thesis
(5.1)), then by what the wheels can turn. Commanded torques are bounded by the motors only.

A tick is the high-level period (50 ms). It consists of steps of 10 ms, as in the robot's microcontroller: read the
encoders, run the wheel loops, hold the voltage. Inside a step the velocities are integrated by Runge-Kutta
(order 4) and the pose follows the exact arc of each substep.

The state is an array (channels, lanes): a lane is one robot of one run, and no lane sees another. Lanes are computed
in blocks of a few vectors: the compiler turns every loop over a block into vector instructions without changing a bit
of the result, and the loops are short, so that the processor works at several vectors at a time.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from math import pi, tan
from typing import Literal

import numpy as np

from fuzzy.compiled.jit import kernel
from fuzzy.compiled.trigonometry import sincos
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
) = range(28)  # fmt: skip
PARAMETERS = 28

_ANY_RATE = 1e300  # m/s², rad/s²: no bound of the acceleration; finite, so that parameters can be subtracted
_VECTOR = 8  # lanes: a multiple of every vector width in use
_BLOCK = 32  # lanes at most: a few vectors, whose chains of arithmetic the processor overlaps
_ROW = _BLOCK + _VECTOR  # of the scratch: no power of two, which would fall on few lines of the cache
# Rows of a block's scratch beyond the state: its parameters, what is made of them once a tick, what a step passes on
(
    _PER_R, _RADIAN, _ODO_R, _ODO_L, _ODO_TURN_R, _ODO_TURN_L, _KT_KE, _KT_SUPPLY, _SLOW2, _BACK,
    _OWN, _CROSS, _OWN_DRAG, _CROSS_DRAG, _SPIN, _BEND, _FORWARD, _TURN, _SIDEWAYS,
    _DRIVE_R, _DRIVE_L, _WHEEL_R, _WHEEL_L, _COS, _SIN, _OCOS, _OSIN, _OLD_R, _OLD_L,
    _STAGE_R, _STAGE_L, _SUM_R, _SUM_L, _GAIN_R, _GAIN_L, _WORK, _LOSS,
) = range(CHANNELS + PARAMETERS, CHANNELS + PARAMETERS + 37)  # fmt: skip
_ROWS = CHANNELS + PARAMETERS + 37
CODES = {"velocity": 0, "torque": 1}  # of what a command is,
KINEMATIC = 2  # or of the plant that needs no wheel loops
SUBSTEPS = 4  # Runge-Kutta steps a step: the pose is then within 1e-7 m of the limit after 5 s
SCRATCH = _ROWS * _ROW  # numbers of scratch that tick_into needs


def parameters(robot: Robot, step: float = 0.01) -> np.ndarray:
    """Return one lane's parameters (PARAMETERS,) of ``robot``, with the filter's coefficients for ``step`` [s]."""
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
        P_ODO_RIGHT: robot.wheel_radius,
        P_ODO_LEFT: robot.wheel_radius,
        P_ODO_HALF_AXLE: robot.half_axle,
        P_V_RATE: _ANY_RATE if robot.v_rate_max is None else robot.v_rate_max,
        P_W_RATE: _ANY_RATE if robot.w_rate_max is None else robot.w_rate_max,
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


@kernel(nogil=True, _nrt=False)
def within(limits, robot, v, w):  # type: ignore[no-untyped-def]
    """The same as :func:`saturate` for one robot, the ``robot``-th of ``limits``, in compiled functions."""
    v_max, w_max, half_axle, wheel = limits[0, robot], limits[1, robot], limits[2, robot], limits[3, robot]
    v = v if not abs(v) > v_max else (v_max if v > 0 else -v_max)
    w = w if not abs(w) > w_max else (w_max if w > 0 else -w_max)
    scale = min(1.0, wheel / max(abs(v) + half_axle * abs(w), 1e-12))
    return v * scale, w * scale


@kernel
def _wheel_torque(drive, speed, kt_ke, hold, most, limit):  # type: ignore[no-untyped-def]
    """A motor's torque at a wheel speed, of ``drive``, the voltage times kt, as are ``most``, the supply, and kt_ke.

    ``hold`` 1: the voltage is held; 0: the drive holds the torque. Either way the supply minus the back-EMF bounds the
    torque, and the tyre slips at the limit.
    """
    back = kt_ke * speed
    return min(max(min(max(drive - hold * back, -most - back), most - back), -limit), limit)


@kernel(nogil=True)
def tick_into(  # type: ignore[no-untyped-def]
    out, state, parameters, earlier, command, late_steps, steps, step, substeps, code, scratch
):
    """Write the state one tick later into ``out`` (CHANNELS, lanes), which may be ``state``; nothing is allocated.

    Arguments as of :meth:`Plant.advance`; ``code`` is 0 for velocities, 1 for torques, 2 for the kinematic plant, and
    ``scratch`` (SCRATCH,) of the caller's, one for each thread.
    """
    lanes = state.shape[1]
    z = scratch
    hold = 0.0 if code == 1 else 1.0
    for start in range(0, lanes, _BLOCK):
        count = min(_BLOCK, lanes - start)
        width = -(-count // _VECTOR) * _VECTOR
        _load(z, width, state, start, count)
        _load(z[CHANNELS * _ROW :], width, parameters, start, count)
        _begin(z, width, step / substeps)
        for k in range(steps):
            held = earlier if k < late_steps else command
            _load(z[_DRIVE_R * _ROW :], width, held, start, count)
            _loops(z, width, step, code)
            if code == 2:
                _glide(z, width, step)
            else:
                for _ in range(substeps):
                    _move(z, width, step / substeps, hold)
            _odometry(z, width, step)
        if code != 2:
            _body_speed(z, width)
        for c in range(CHANNELS):
            for i in range(count):
                out[c, start + i] = z[c * _ROW + i]


@kernel
def _load(z, width, array, start, count):  # type: ignore[no-untyped-def]
    """Copy a block's columns of ``array`` to the rows of ``z``; the last lane fills up an incomplete vector."""
    for r in range(len(array)):
        for i in range(count):
            z[r * _ROW + i] = array[r, start + i]
        for i in range(count, width):
            z[r * _ROW + i] = array[r, start + count - 1]


@kernel
def _begin(z, width, h):  # type: ignore[no-untyped-def]
    """Make what all steps of a tick need of the parameters, ``h`` being a substep [s], and of the state."""
    for i in range(width):
        radius = z[(CHANNELS + P_RADIUS) * _ROW + i]
        per_r = 1 / radius
        half = z[(CHANNELS + P_HALF_AXLE) * _ROW + i]
        kt = z[(CHANNELS + P_KT) * _ROW + i]
        slow = z[(CHANNELS + P_FRICTION_SPEED) * _ROW + i]
        z[_PER_R * _ROW + i] = per_r
        z[_KT_KE * _ROW + i] = kt * z[(CHANNELS + P_KE) * _ROW + i]
        z[_KT_SUPPLY * _ROW + i] = kt * z[(CHANNELS + P_VOLTAGE) * _ROW + i]
        z[_SLOW2 * _ROW + i] = slow * slow
        z[_BACK * _ROW + i] = z[(CHANNELS + P_KI) * _ROW + i] / max(z[(CHANNELS + P_KP) * _ROW + i], 1e-12)
        # A wheel's acceleration by its own torque and by the other's; by ω² and by v ω, if the mass is off the axle
        forth = per_r * per_r / z[(CHANNELS + P_MASS) * _ROW + i]
        around = (half * per_r) * (half * per_r) / z[(CHANNELS + P_INERTIA) * _ROW + i]
        coupling = z[(CHANNELS + P_COUPLING) * _ROW + i] * radius
        z[_OWN * _ROW + i] = h / 2 * (forth + around)
        z[_CROSS * _ROW + i] = h / 2 * (forth - around)
        z[_OWN_DRAG * _ROW + i] = z[_OWN * _ROW + i] * z[(CHANNELS + P_FRICTION) * _ROW + i]
        z[_CROSS_DRAG * _ROW + i] = z[_CROSS * _ROW + i] * z[(CHANNELS + P_FRICTION) * _ROW + i]
        z[_SPIN * _ROW + i] = h / 2 * coupling / (4 * half * half) / z[(CHANNELS + P_MASS) * _ROW + i]
        z[_BEND * _ROW + i] = h / 2 * coupling / 4 / z[(CHANNELS + P_INERTIA) * _ROW + i]
        # Of the sums of the wheels' four speeds in a substep to the way, the turn, and the second term of Magnus
        z[_FORWARD * _ROW + i] = h / 12 * radius
        z[_TURN * _ROW + i] = h / 12 * radius / half
        z[_SIDEWAYS * _ROW + i] = h * h / 24 * radius * radius / half
        # thesis (2.25), with 2 L between the wheels
        radian = 1 / z[(CHANNELS + P_COUNT) * _ROW + i]
        odo_half = z[(CHANNELS + P_ODO_HALF_AXLE) * _ROW + i]
        z[_RADIAN * _ROW + i] = radian
        z[_ODO_R * _ROW + i] = radian * z[(CHANNELS + P_ODO_RIGHT) * _ROW + i] / 2
        z[_ODO_L * _ROW + i] = radian * z[(CHANNELS + P_ODO_LEFT) * _ROW + i] / 2
        z[_ODO_TURN_R * _ROW + i] = z[_ODO_R * _ROW + i] / odo_half
        z[_ODO_TURN_L * _ROW + i] = z[_ODO_L * _ROW + i] / odo_half
    for i in range(width):
        way = z[(CHANNELS + P_HALF_AXLE) * _ROW + i] * z[W * _ROW + i]
        per_r = z[_PER_R * _ROW + i]
        _enter(z, i, (z[V * _ROW + i] + way) * per_r, (z[V * _ROW + i] - way) * per_r)
        z[_OLD_R * _ROW + i] = np.floor(z[ANGLE_R * _ROW + i] * z[(CHANNELS + P_COUNT) * _ROW + i])
        z[_OLD_L * _ROW + i] = np.floor(z[ANGLE_L * _ROW + i] * z[(CHANNELS + P_COUNT) * _ROW + i])
        z[_SIN * _ROW + i], z[_COS * _ROW + i] = sincos(z[HEADING * _ROW + i])
        z[_OSIN * _ROW + i], z[_OCOS * _ROW + i] = sincos(z[ODO_HEADING * _ROW + i])


@kernel
def _loops(z, width, step, code):  # type: ignore[no-untyped-def]
    """Turn the held command (in the rows of the drives) into the drives of this step, or the velocity if kinematic."""
    per_step = 1 / step
    for i in range(width):
        per_r = z[_PER_R * _ROW + i]
        half = z[(CHANNELS + P_HALF_AXLE) * _ROW + i]
        kt = z[(CHANNELS + P_KT) * _ROW + i]
        limit = z[(CHANNELS + P_TORQUE_LIMIT) * _ROW + i]
        volts = z[(CHANNELS + P_VOLTAGE) * _ROW + i]
        first = z[_DRIVE_R * _ROW + i]
        second = z[_DRIVE_L * _ROW + i]
        true_r = z[_WHEEL_R * _ROW + i]
        true_l = z[_WHEEL_L * _ROW + i]
        hold = 1.0
        if code == 1:
            # The drive holds the commanded torque, as a current loop faster than 10 ms does.
            hold = 0.0
            drive_r = first
            drive_l = second
        else:
            top_v = z[(CHANNELS + P_V_MAX) * _ROW + i]
            top_w = z[(CHANNELS + P_W_MAX) * _ROW + i]
            v = min(max(first, -top_v), top_v)
            w = min(max(second, -top_w), top_w)
            # thesis (5.1): |v'| and |ω'| of the command are bounded. The wheels' limit comes last, and wins.
            most_v = z[(CHANNELS + P_V_RATE) * _ROW + i] * step
            most_w = z[(CHANNELS + P_W_RATE) * _ROW + i] * step
            held_v = z[HELD_V * _ROW + i]
            held_w = z[HELD_W * _ROW + i]
            v = min(max(v, held_v - most_v), held_v + most_v)
            w = min(max(w, held_w - most_w), held_w + most_w)
            ref_r = (v + half * w) * per_r  # thesis (2.6), with the labels the right way round
            ref_l = (v - half * w) * per_r
            fastest = max(abs(ref_r), abs(ref_l))
            top = z[(CHANNELS + P_WHEEL_MAX) * _ROW + i]
            scale = min(1.0, top / max(fastest, 1e-12))
            ref_r = ref_r * scale
            ref_l = ref_l * scale
            z[HELD_V * _ROW + i] = v * scale
            z[HELD_W * _ROW + i] = w * scale
            if code == 2:
                z[V * _ROW + i] = v * scale
                z[W * _ROW + i] = w * scale
            kp = z[(CHANNELS + P_KP) * _ROW + i]
            ki = z[(CHANNELS + P_KI) * _ROW + i]
            kd = z[(CHANNELS + P_KD) * _ROW + i]
            speed_r = z[SPEED_R * _ROW + i]
            speed_l = z[SPEED_L * _ROW + i]
            rate_r = (speed_r - z[PAST_R * _ROW + i]) * per_step
            rate_l = (speed_l - z[PAST_L * _ROW + i]) * per_step
            wish_r = kp * (ref_r - speed_r) + z[INTEGRAL_R * _ROW + i] - kd * rate_r
            wish_l = kp * (ref_l - speed_l) + z[INTEGRAL_L * _ROW + i] - kd * rate_l
            ur = min(max(wish_r, -volts), volts)
            ul = min(max(wish_l, -volts), volts)
            # Back-calculation: the part that saturation cuts off leaves the integral with the loop's own time kp/ki.
            back = z[_BACK * _ROW + i]
            z[INTEGRAL_R * _ROW + i] += step * (ki * (ref_r - speed_r) + back * (ur - wish_r))
            z[INTEGRAL_L * _ROW + i] += step * (ki * (ref_l - speed_l) + back * (ul - wish_l))
            drive_r = kt * ur
            drive_l = kt * ul
        z[_DRIVE_R * _ROW + i] = drive_r
        z[_DRIVE_L * _ROW + i] = drive_l
        kt_ke = z[_KT_KE * _ROW + i]
        most = z[_KT_SUPPLY * _ROW + i]
        torque_r = _wheel_torque(drive_r, true_r, kt_ke, hold, most, limit)
        torque_l = _wheel_torque(drive_l, true_l, kt_ke, hold, most, limit)
        if code == 2:
            torque_r = 0.0
            torque_l = 0.0
        change = abs(torque_r - z[TORQUE_R * _ROW + i]) + abs(torque_l - z[TORQUE_L * _ROW + i])
        z[VARIATION * _ROW + i] += change
        z[EFFORT * _ROW + i] += step * (torque_r * torque_r + torque_l * torque_l)
        z[TORQUE_R * _ROW + i] = torque_r
        z[TORQUE_L * _ROW + i] = torque_l


@kernel
def _move(z, width, h, hold):  # type: ignore[no-untyped-def]
    """Do one Runge-Kutta step of the wheels' speeds over ``h`` seconds, and move the pose along its arc meanwhile."""
    _stage(z, width, 1.0, 1.0, hold)
    _stage(z, width, 2.0, 1.0, hold)
    _stage(z, width, 2.0, 2.0, hold)
    _stage(z, width, 1.0, 0.0, hold)
    for i in range(width):
        r1 = z[_WHEEL_R * _ROW + i]
        l1 = z[_WHEEL_L * _ROW + i]
        r5 = r1 + z[_GAIN_R * _ROW + i] * (1 / 3)
        l5 = l1 + z[_GAIN_L * _ROW + i] * (1 / 3)
        sum_r = z[_SUM_R * _ROW + i]
        sum_l = z[_SUM_L * _ROW + i]
        z[WORK * _ROW + i] += h / 6 * z[_WORK * _ROW + i]
        z[LOSS * _ROW + i] += h / 6 * z[_LOSS * _ROW + i]
        _enter(z, i, r5, l5)
        z[ANGLE_R * _ROW + i] += h / 6 * sum_r
        z[ANGLE_L * _ROW + i] += h / 6 * sum_l
        forward = z[_FORWARD * _ROW + i] * (sum_r + sum_l)
        turn = z[_TURN * _ROW + i] * (sum_r - sum_l)
        # v and ω changing together leave the arc a little sideways (Magnus expansion, second term).
        sideways = z[_SIDEWAYS * _ROW + i] * (r1 * l5 - r5 * l1)
        _arc(z, i, X, Y, HEADING, _COS, _SIN, forward, sideways, turn)


@kernel
def _enter(z, i, right, left):  # type: ignore[no-untyped-def]
    """Begin a step of Runge-Kutta at two wheel speeds: nothing is summed up yet."""
    z[_WHEEL_R * _ROW + i] = right
    z[_WHEEL_L * _ROW + i] = left
    z[_STAGE_R * _ROW + i] = right
    z[_STAGE_L * _ROW + i] = left
    z[_SUM_R * _ROW + i] = 0.0
    z[_SUM_L * _ROW + i] = 0.0
    z[_GAIN_R * _ROW + i] = 0.0
    z[_GAIN_L * _ROW + i] = 0.0
    z[_WORK * _ROW + i] = 0.0
    z[_LOSS * _ROW + i] = 0.0


@kernel
def _stage(z, width, weight, reach, hold):  # type: ignore[no-untyped-def]
    """Do one stage of Runge-Kutta: add its findings, times ``weight``, to the sums; go on by ``reach`` half steps.

    (m + 2 J_w/r²) v'     = (τr + τl)/r + m_c d ω²
    (I0 + 2 J_w L²/r²) ω' = L (τr − τl)/r − m_c d v ω

    the reduced form of thesis (2.1)-(2.9) with d ≠ 0 at the axle midpoint; d = 0 gives (2.10). It is solved here for
    the wheels' speeds (v ± L ω)/r, in which the motors and the friction are given: this is the innermost loop, and
    short, since a lane is a chain of arithmetic that waits for a root and a division.
    """
    for i in range(width):
        right = z[_STAGE_R * _ROW + i]
        left = z[_STAGE_L * _ROW + i]
        kt_ke = z[_KT_KE * _ROW + i]
        most = z[_KT_SUPPLY * _ROW + i]
        limit = z[(CHANNELS + P_TORQUE_LIMIT) * _ROW + i]
        slow2 = z[_SLOW2 * _ROW + i]
        # Coulomb friction, smooth through standstill
        drag_r = right / np.sqrt(right * right + slow2)
        drag_l = left / np.sqrt(left * left + slow2)
        motor_r = _wheel_torque(z[_DRIVE_R * _ROW + i], right, kt_ke, hold, most, limit)
        motor_l = _wheel_torque(z[_DRIVE_L * _ROW + i], left, kt_ke, hold, most, limit)
        difference = right - left
        along = z[_SPIN * _ROW + i] * difference * difference
        around = z[_BEND * _ROW + i] * (right + left) * difference
        own = z[_OWN * _ROW + i]
        cross = z[_CROSS * _ROW + i]
        own_drag = z[_OWN_DRAG * _ROW + i]
        cross_drag = z[_CROSS_DRAG * _ROW + i]
        gain_r = ((own * motor_r + cross * motor_l) + (along - around)) - (own_drag * drag_r + cross_drag * drag_l)
        gain_l = ((own * motor_l + cross * motor_r) + (along + around)) - (own_drag * drag_l + cross_drag * drag_r)
        friction = z[(CHANNELS + P_FRICTION) * _ROW + i]
        z[_SUM_R * _ROW + i] += weight * right
        z[_SUM_L * _ROW + i] += weight * left
        z[_GAIN_R * _ROW + i] += weight * gain_r
        z[_GAIN_L * _ROW + i] += weight * gain_l
        z[_WORK * _ROW + i] += weight * (motor_r * right + motor_l * left)
        z[_LOSS * _ROW + i] += weight * friction * (drag_r * right + drag_l * left)
        z[_STAGE_R * _ROW + i] = z[_WHEEL_R * _ROW + i] + reach * gain_r
        z[_STAGE_L * _ROW + i] = z[_WHEEL_L * _ROW + i] + reach * gain_l


@kernel
def _body_speed(z, width):  # type: ignore[no-untyped-def]
    """Return from the wheels' speeds to the body's."""
    for i in range(width):
        right = z[_WHEEL_R * _ROW + i]
        left = z[_WHEEL_L * _ROW + i]
        way = 0.5 * z[(CHANNELS + P_RADIUS) * _ROW + i]
        z[V * _ROW + i] = way * (right + left)
        z[W * _ROW + i] = way * (right - left) / z[(CHANNELS + P_HALF_AXLE) * _ROW + i]


@kernel
def _glide(z, width, step):  # type: ignore[no-untyped-def]
    """Move the kinematic plant: the velocity is the command, and the arc is exact."""
    for i in range(width):
        per_r = z[_PER_R * _ROW + i]
        half = z[(CHANNELS + P_HALF_AXLE) * _ROW + i]
        forward = z[V * _ROW + i] * step
        turn = z[W * _ROW + i] * step
        z[ANGLE_R * _ROW + i] += (forward + half * turn) * per_r
        z[ANGLE_L * _ROW + i] += (forward - half * turn) * per_r
        _arc(z, i, X, Y, HEADING, _COS, _SIN, forward, 0.0, turn)


@kernel
def _arc(z, i, x, y, heading, cos, sin, forward, sideways, turn):  # type: ignore[no-untyped-def]
    """Move a pose along the arc of a constant twist: the exact solution of thesis (2.27)."""
    q = turn * turn
    # sin(θ)/θ, (1 − cos θ)/θ and cos θ by their series, exact in float64 for the |θ| < 0.1 rad of one step
    s = 1 - q * (1 / 6 - q * (1 / 120 - q * (1 / 5040 - q * (1 / 362880))))
    c = turn * (1 / 2 - q * (1 / 24 - q * (1 / 720 - q * (1 / 40320 - q * (1 / 3628800)))))
    cos_turn = 1 - turn * c
    sin_turn = turn * s
    along = forward * s - sideways * c
    across = forward * c + sideways * s
    ch = z[cos * _ROW + i]
    sh = z[sin * _ROW + i]
    z[x * _ROW + i] += along * ch - across * sh
    z[y * _ROW + i] += along * sh + across * ch
    z[heading * _ROW + i] += turn
    z[cos * _ROW + i] = ch * cos_turn - sh * sin_turn
    z[sin * _ROW + i] = sh * cos_turn + ch * sin_turn


@kernel
def _odometry(z, width, step):  # type: ignore[no-untyped-def]
    """Read the encoders after the step: the wheel speeds for the loops, and the pose by odometry."""
    per_step = 1 / step
    for i in range(width):
        per_radian = z[(CHANNELS + P_COUNT) * _ROW + i]
        count_r = np.floor(z[ANGLE_R * _ROW + i] * per_radian)
        count_l = np.floor(z[ANGLE_L * _ROW + i] * per_radian)
        turn_r = count_r - z[_OLD_R * _ROW + i]
        turn_l = count_l - z[_OLD_L * _ROW + i]
        z[_OLD_R * _ROW + i] = count_r
        z[_OLD_L * _ROW + i] = count_l
        raw_r = turn_r * z[_RADIAN * _ROW + i] * per_step
        raw_l = turn_l * z[_RADIAN * _ROW + i] * per_step
        b0 = z[(CHANNELS + P_B0) * _ROW + i]
        b1 = z[(CHANNELS + P_B1) * _ROW + i]
        b2 = z[(CHANNELS + P_B2) * _ROW + i]
        f1 = z[(CHANNELS + P_A1) * _ROW + i]
        f2 = z[(CHANNELS + P_A2) * _ROW + i]
        smooth_r = (
            b0 * raw_r
            + b1 * z[RAW1_R * _ROW + i]
            + b2 * z[RAW2_R * _ROW + i]
            - f1 * z[SPEED_R * _ROW + i]
            - f2 * z[PAST_R * _ROW + i]
        )
        smooth_l = (
            b0 * raw_l
            + b1 * z[RAW1_L * _ROW + i]
            + b2 * z[RAW2_L * _ROW + i]
            - f1 * z[SPEED_L * _ROW + i]
            - f2 * z[PAST_L * _ROW + i]
        )
        z[RAW2_R * _ROW + i] = z[RAW1_R * _ROW + i]
        z[RAW2_L * _ROW + i] = z[RAW1_L * _ROW + i]
        z[RAW1_R * _ROW + i] = raw_r
        z[RAW1_L * _ROW + i] = raw_l
        z[PAST_R * _ROW + i] = z[SPEED_R * _ROW + i]
        z[PAST_L * _ROW + i] = z[SPEED_L * _ROW + i]
        z[SPEED_R * _ROW + i] = smooth_r
        z[SPEED_L * _ROW + i] = smooth_l
        forward = z[_ODO_R * _ROW + i] * turn_r + z[_ODO_L * _ROW + i] * turn_l
        turn = z[_ODO_TURN_R * _ROW + i] * turn_r - z[_ODO_TURN_L * _ROW + i] * turn_l
        _arc(z, i, ODO_X, ODO_Y, ODO_HEADING, _OCOS, _OSIN, forward, 0.0, turn)
