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

from fuzzy.compiled.columns import Columns, column
from fuzzy.compiled.columns import within as rows_of
from fuzzy.compiled.jit import compiled_only, without_refcounts
from robotics.world.vehicle.robot import IMPERFECTIONS, Robot

Level = Literal["velocity", "torque"]
STEP = 0.01  # s: the wheel loops' period (thesis 2.1.3.1)

# Channels of the state -----------------------------------------------------------------------------------------


class WheelColumns(Columns):
    """The state of a wheel, of its loop and of its motor."""

    angle = column("rad")
    integral = column("V", "the loop's integral part")
    speed = column("rad/s", "as the loop sees it (encoder, filter)")
    raw1 = column("rad/s", "the filter's past inputs")
    raw2 = column("rad/s")
    past = column("rad/s", "the filter's output one step before ``speed``")
    torque = column("N m", "of the motor at the start of the last step")


class MotionColumns(Columns):
    """Where a robot's axle midpoint is, and how it moves."""

    x = column("m")
    y = column("m")
    heading = column("rad")
    v = column("m/s")
    w = column("rad/s")


class TruthColumns(MotionColumns):
    """The plant's state; the motion is the true one."""

    right = rows_of(WheelColumns)
    left = rows_of(WheelColumns)
    odo_x = column("m", "the pose by odometry")
    odo_y = column("m")
    odo_heading = column("rad")
    work = column("J", "done by the motors")
    loss = column("J", "lost to friction")
    effort = column("N² m² s", "∫ τr² + τl² dt")
    variation = column("N m", "Σ |Δτr| + |Δτl| from step to step")
    held_v = column("m/s", "the commanded velocity within all its bounds, as the last step held it")
    held_w = column("rad/s")


class OdometryColumns(Columns):
    """What odometry assumes of a robot."""

    right = column("m", "the wheels' radii")
    left = column("m")
    half_axle = column("m")


class ParameterColumns(Columns):
    """The plant's parameters."""

    mass = column("kg")
    inertia = column("kg m²")
    coupling = column("kg m", "m_c d")
    radius = column("m", "of the wheels")
    half_axle = column("m")
    voltage = column("V", "of the supply")
    kt = column("N m/A")
    ke = column("V s/rad")
    torque_limit = column("N m")
    friction = column("N m")
    friction_speed = column("rad/s")
    count = column("1/rad", "of the encoders")
    kp = column("V s/rad", "of the wheel loops")
    ki = column("V/rad")
    kd = column("V s²/rad")
    b0 = column("1", "of the low-pass filter")
    b1 = column("1")
    b2 = column("1")
    a1 = column("1")
    a2 = column("1")
    v_max = column("m/s")
    w_max = column("rad/s")
    wheel_max = column("rad/s")
    odometry = rows_of(OdometryColumns)
    v_rate = column("m/s²")
    w_rate = column("rad/s²")
    loop_radius = column("m", "the wheels' radius that the wheel loops assume")
    dead_band = column("m/s", "of a wheel's rim")
    v_resolution = column("m/s", "of commands")
    w_resolution = column("rad/s")
    longitudinal_slip = column("s²/m")
    lateral_slip = column("s²/m")
    castor_drag = column("N")
    castor_offset = column("m")
    imperfect = column("1", "1: some of these are above 0; 0: the plant does not look at them")


class BlockColumns(Columns):
    """What a lane of a block works in."""

    state = rows_of(TruthColumns)
    parameter = rows_of(ParameterColumns)
    volt_r = column("V", "or what is commanded, before it becomes voltages")
    volt_l = column("V")
    cos = column("1", "of the true heading")
    sin = column("1")
    odo_cos = column("1", "of the heading by odometry")
    odo_sin = column("1")
    old_r = column("1", "counts of the encoders")
    old_l = column("1")
    per_mass = column("1/kg")
    per_inertia = column("1/(kg m²)")
    per_r = column("1/m")
    stage_v = column("m/s", "of a stage of Runge-Kutta")
    stage_w = column("rad/s")
    sum_a = column("m/s²", "over its four stages")
    sum_b = column("rad/s²")
    sum_v = column("m/s")
    sum_w = column("rad/s")
    sum_p = column("W")
    sum_q = column("W")
    was_v = column("m/s", "at the begin of a step, of an imperfect robot")
    was_w = column("rad/s")


_ANY_RATE = 1e300
_BLOCK = 32  # lanes of a block, whose rows of numbers stay in the first cache
_VECTOR = 4  # lanes: a block is filled up to a multiple of it
# Where a block's parameters and commands begin
_PARAMETERS = BlockColumns.parameter.row * _BLOCK
_COMMANDS = BlockColumns.volt_r.row * _BLOCK
_CHANNELS = TruthColumns.size
SCRATCH = BlockColumns.size * _BLOCK  # numbers that :func:`tick_into` works in
CODES = {"velocity": 0, "torque": 1}  # of what a command is,
KINEMATIC = 2  # or of the plant that needs no wheel loops
SUBSTEPS = 4  # Runge-Kutta steps a step: the pose is then within 1e-7 m of the limit after 5 s


def parameters(robot: Robot, step: float = 0.01, believed: Robot | None = None) -> np.ndarray:
    """Return one lane's parameters (ParameterColumns,) of ``robot``, with the filter's coefficients for ``step`` [s].

    Its wheel loops and its odometry take it for the robot ``believed``, where that is given: they assume the wheels'
    radius and the axle of that one.
    """
    believed = believed or robot
    low_pass = zip(("b0", "b1", "b2", "a1", "a2"), _low_pass(robot.filter_frequency, step), strict=True)
    own = "half_axle", "torque_limit", "friction_speed", "kp", "ki", "kd", "v_max", "w_max", "castor_offset"
    values = {name: getattr(robot, name) for name in (*own, *IMPERFECTIONS)} | dict(low_pass)
    values |= {
        "mass": robot.effective_mass,
        "inertia": robot.effective_inertia,
        "coupling": robot.body_mass * robot.mass_offset,  # m_c d, not m d: the wheels sit on the axle
        "radius": robot.wheel_radius,
        "voltage": robot.supply_voltage,
        "kt": robot.torque_constant,
        "ke": robot.back_emf,
        "friction": robot.friction_torque,
        "count": robot.counts_per_turn / (2 * pi),
        "wheel_max": robot.wheel_speed_max,
        "odometry": (believed.wheel_radius, believed.wheel_radius, believed.half_axle),
        "v_rate": _ANY_RATE if robot.v_rate_max is None else robot.v_rate_max,
        "w_rate": _ANY_RATE if robot.w_rate_max is None else robot.w_rate_max,
        "loop_radius": believed.wheel_radius,
        "imperfect": float(bool(robot.imperfections)),
    }
    return np.array(ParameterColumns.stacked(values))


def _low_pass(frequency: float, step: float) -> tuple[float, float, float, float, float]:
    """A Butterworth-like low-pass (damping 0.7) by the bilinear transform: y = b0 u + b1 u₁ + b2 u₂ − a1 y₁ − a2 y₂."""
    if frequency == 0.0:
        return 1.0, 0.0, 0.0, 0.0, 0.0
    k = tan(pi * frequency * step)
    scale = 1 / (1 + 2 * 0.7 * k + k * k)
    return k * k * scale, 2 * k * k * scale, k * k * scale, 2 * (k * k - 1) * scale, (1 - 1.4 * k + k * k) * scale


def initial_state(pose: np.ndarray, believed: np.ndarray | None = None) -> np.ndarray:
    """The state (TruthColumns, lanes) of robots at rest at ``pose`` (lanes, 3): x [m], y [m], heading [rad].

    Odometry starts from ``believed`` (lanes, 3), the poses that the robots believe to have; by default the true ones.
    """
    state = TruthColumns.zeros(len(pose))
    state.x, state.y, state.heading = pose.T
    state.odo_x, state.odo_y, state.odo_heading = (pose if believed is None else believed).T
    return state.array


@dataclass(frozen=True)
class Plant:
    """The plant of a simulation, which turns commands into motion: the robots' parameters and the time grid."""

    parameters: np.ndarray  # (ParameterColumns, lanes)
    steps: int = 5  # steps a tick
    step: float = 0.01  # s
    substeps: int = SUBSTEPS
    kinematic: bool = False  # the velocity is the command within its bounds, without delay

    def advance(
        self, state: np.ndarray, earlier: np.ndarray, command: np.ndarray, late_steps: int, level: Level
    ) -> np.ndarray:
        """Return the state one tick later (TruthColumns, lanes).

        Args:
            state: The state now (TruthColumns, lanes).
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
        w: The commanded turn rate (..., robots) [rad/s].
    """
    v_max, w_max, half_axle, wheel = limits
    v = np.minimum(np.maximum(v, -v_max), v_max)
    w = np.minimum(np.maximum(w, -w_max), w_max)
    scale = np.minimum(1.0, wheel / np.maximum(np.abs(v) + half_axle * np.abs(w), 1e-12))
    return v * scale, w * scale


class LimitColumns(Columns):
    """The bounds of a robot's velocity."""

    v_max = column("m/s")
    w_max = column("rad/s")
    half_axle = column("m")
    wheel_speed_limit = column("m/s", "of the rim")


@compiled_only
def within_limits(limit: LimitColumns, v, w):  # type: ignore[no-untyped-def]
    """The same as :func:`saturate` for one robot, whose ``limit`` is as LimitColumns, in compiled functions."""
    v = v if not abs(v) > limit.v_max else (limit.v_max if v > 0 else -limit.v_max)
    w = w if not abs(w) > limit.w_max else (limit.w_max if w > 0 else -limit.w_max)
    scale = min(1.0, limit.wheel_speed_limit / max(abs(v) + limit.half_axle * abs(w), 1e-12))
    return v * scale, w * scale


@compiled_only
def within(limits, robot, v, w):  # type: ignore[no-untyped-def]
    """The same for the ``robot``-th column of ``limits``."""
    return within_limits(LimitColumns(limits, robot), v, w)


@compiled_only
def _wheel_torque(robot: ParameterColumns, voltage, speed, hold):  # type: ignore[no-untyped-def]
    """A motor's torque at a wheel speed. ``hold`` 1: the voltage is held; 0: the drive holds the torque kt · voltage.

    Either way the supply minus the back-EMF bounds the torque, and the tyre slips at the limit.
    """
    back = robot.ke * speed
    torque = robot.kt * min(max(voltage - hold * back, -robot.voltage - back), robot.voltage - back)
    return min(max(torque, -robot.torque_limit), robot.torque_limit)


@compiled_only
def _drag(robot: ParameterColumns, speed):  # type: ignore[no-untyped-def]
    """Coulomb friction at a wheel speed, smooth through standstill."""
    return robot.friction * speed / np.sqrt(speed * speed + robot.friction_speed * robot.friction_speed)


@without_refcounts
def tick_into(  # type: ignore[no-untyped-def]
    out, state, parameters, earlier, command, late_steps, steps, step, substeps, code, z
):
    """Write the state one tick later into ``out`` (TruthColumns, lanes), which may be ``state``; nothing is allocated.

    The arguments are as of :meth:`Plant.advance`; ``code`` is 0 for velocities, 1 for torques, 2 for the kinematic
    plant, and ``z`` has SCRATCH numbers to work in, one such array for each thread.
    """
    tick_lanes(
        0, state.shape[1], out, state, parameters, earlier, command, late_steps, steps, step, substeps, code, z
    )  # fmt: skip


@compiled_only
def tick_lanes(  # type: ignore[no-untyped-def]
    first, last, out, state, parameters, earlier, command, late_steps, steps, step, substeps, code, z
):
    """Do the same for the lanes from ``first`` to before ``last`` alone."""
    hold = 0.0 if code == 1 else 1.0
    for start in range(first, last, _BLOCK):
        count = min(_BLOCK, last - start)
        width, imperfect = _open(z, state, parameters, start, count)
        for k in range(steps):
            held = earlier if k < late_steps else command
            _load(z[_COMMANDS:], width, held, start, count)
            if imperfect:
                _spoil(z, width, code)
            _loops(z, width, step, code)
            if code == 2:
                _glide(z, width, step)
            else:
                for _ in range(substeps):
                    if imperfect:
                        _castor(z, width, step / substeps)
                    _move(z, width, step / substeps, hold)
                if imperfect:
                    _slide(z, width, step)
            _odometry(z, width, step)
        _store(z, out, start, count)


# For a plant whose bodies move by other physics: what a robot's microcontroller does before and after each step


@without_refcounts
def run_wheel_loops(volts, state, parameters, command, step, code, z):  # type: ignore[no-untyped-def]
    """Run the wheel loops of a step: ``volts`` (2, lanes) are those of the right and the left motor, to be held.

    Other arguments are as of :func:`tick_into`; of ``state`` the loops' own numbers change.
    """
    for start in range(0, state.shape[1], _BLOCK):
        count = min(_BLOCK, state.shape[1] - start)
        width, imperfect = _open(z, state, parameters, start, count)
        _load(z[_COMMANDS:], width, command, start, count)
        if imperfect:
            _spoil(z, width, code)
        _loops(z, width, step, code)
        _store(z, state, start, count)
        for i in range(count):
            lane = BlockColumns(z, i, _BLOCK)
            volts[0, start + i], volts[1, start + i] = lane.volt_r, lane.volt_l


@without_refcounts
def read_wheels(state, parameters, before, step, z):  # type: ignore[no-untyped-def]
    """Read the encoders after a step that turned the wheels from the angles ``before`` (2, lanes) to those of now."""
    for start in range(0, state.shape[1], _BLOCK):
        count = min(_BLOCK, state.shape[1] - start)
        width, _ = _open(z, state, parameters, start, count)
        for i in range(count):
            lane = BlockColumns(z, i, _BLOCK)
            lane.old_r = np.floor(before[0, start + i] * lane.parameter.count)
            lane.old_l = np.floor(before[1, start + i] * lane.parameter.count)
        _odometry(z, width, step)
        _store(z, state, start, count)


@compiled_only
def _open(z, state, parameters, start, count):  # type: ignore[no-untyped-def]
    """Load a block; return its width, and whether a robot of it is imperfect."""
    width = -(-count // _VECTOR) * _VECTOR
    _load(z, width, state, start, count)
    _load(z[_PARAMETERS:], width, parameters, start, count)
    _begin(z, width)
    imperfect = False
    for i in range(count):
        imperfect = imperfect or ParameterColumns(parameters, start + i).imperfect > 0
    return width, imperfect


@compiled_only
def _store(z, out, start, count):  # type: ignore[no-untyped-def]
    """Write the state of a block's lanes to ``out``."""
    for c in range(_CHANNELS):
        for i in range(count):
            out[c, start + i] = z[c * _BLOCK + i]


@compiled_only
def _load(z, width, array, start, count):  # type: ignore[no-untyped-def]
    """Copy a block's columns of ``array`` to the rows of ``z``; the last lane fills up an incomplete vector."""
    for r in range(len(array)):
        for i in range(count):
            z[r * _BLOCK + i] = array[r, start + i]
        for i in range(count, width):
            z[r * _BLOCK + i] = array[r, start + count - 1]


@compiled_only
def _begin(z, width):  # type: ignore[no-untyped-def]
    """Make what all steps of a tick need of the parameters and of the state."""
    for i in range(width):
        lane = BlockColumns(z, i, _BLOCK)
        state, robot = lane.state, lane.parameter
        lane.per_mass = 1 / robot.mass
        lane.per_inertia = 1 / robot.inertia
        lane.per_r = 1 / robot.radius
        lane.old_r = np.floor(state.right.angle * robot.count)
        lane.old_l = np.floor(state.left.angle * robot.count)
    for i in range(width):
        lane = BlockColumns(z, i, _BLOCK)
        state = lane.state
        lane.cos = np.cos(state.heading)
        lane.sin = np.sin(state.heading)
        lane.odo_cos = np.cos(state.odo_heading)
        lane.odo_sin = np.sin(state.odo_heading)


@compiled_only
def _loops(z, width, step, code):  # type: ignore[no-untyped-def]
    """Turn the held command (in the voltage rows) into the voltages of this step, or the velocity if kinematic."""
    for i in range(width):
        lane = BlockColumns(z, i, _BLOCK)
        state, robot = lane.state, lane.parameter
        half = robot.half_axle
        first = lane.volt_r
        second = lane.volt_l
        true_r = (state.v + half * state.w) / robot.radius
        true_l = (state.v - half * state.w) / robot.radius
        hold = 1.0
        if code == 1:
            # The drive holds the commanded torque, as a current loop faster than 10 ms does.
            hold = 0.0
            lane.volt_r = first / robot.kt
            lane.volt_l = second / robot.kt
        else:
            v = min(max(first, -robot.v_max), robot.v_max)
            w = min(max(second, -robot.w_max), robot.w_max)
            # thesis (5.1): |v'| and |ω'| of the command are bounded. The wheels' limit comes last, and wins.
            most_v = robot.v_rate * step
            most_w = robot.w_rate * step
            v = min(max(v, state.held_v - most_v), state.held_v + most_v)
            w = min(max(w, state.held_w - most_w), state.held_w + most_w)
            ref_r = (v + half * w) / robot.loop_radius  # thesis (2.6), with the labels the right way round
            ref_l = (v - half * w) / robot.loop_radius
            scale = min(1.0, robot.wheel_max / max(max(abs(ref_r), abs(ref_l)), 1e-12))
            state.held_v = v * scale
            state.held_w = w * scale
            if code == 2:
                state.v = v * scale
                state.w = w * scale
            lane.volt_r = _loop(state.right, robot, ref_r * scale, step)
            lane.volt_l = _loop(state.left, robot, ref_l * scale, step)
        torque_r = _wheel_torque(robot, lane.volt_r, true_r, hold)
        torque_l = _wheel_torque(robot, lane.volt_l, true_l, hold)
        if code == 2:
            torque_r = 0.0
            torque_l = 0.0
        state.variation += abs(torque_r - state.right.torque) + abs(torque_l - state.left.torque)
        state.effort += step * (torque_r * torque_r + torque_l * torque_l)
        state.right.torque = torque_r
        state.left.torque = torque_l


@compiled_only
def _loop(wheel: WheelColumns, robot: ParameterColumns, reference, step):  # type: ignore[no-untyped-def]
    """The voltage of a wheel's loop, whose integral part goes on."""
    error = reference - wheel.speed
    wish = robot.kp * error + wheel.integral - robot.kd * ((wheel.speed - wheel.past) / step)
    voltage = min(max(wish, -robot.voltage), robot.voltage)
    # Back-calculation: the part that saturation cuts off leaves the integral with the loop's own time kp/ki.
    back = robot.ki / max(robot.kp, 1e-12)
    wheel.integral += step * (robot.ki * error + back * (voltage - wish))
    return voltage


@compiled_only
def _move(z, width, h, hold):  # type: ignore[no-untyped-def]
    """Do one Runge-Kutta step of the velocities over ``h`` seconds, and move the pose along its arc meanwhile."""
    for i in range(width):
        lane = BlockColumns(z, i, _BLOCK)
        state = lane.state
        lane.stage_v = state.v
        lane.stage_w = state.w
        lane.sum_a = lane.sum_b = lane.sum_v = lane.sum_w = lane.sum_p = lane.sum_q = 0.0
    _stage(z, width, 1.0, 0.5 * h, hold)
    _stage(z, width, 2.0, 0.5 * h, hold)
    _stage(z, width, 2.0, h, hold)
    _stage(z, width, 1.0, 0.0, hold)
    for i in range(width):
        lane = BlockColumns(z, i, _BLOCK)
        state, robot = lane.state, lane.parameter
        half = robot.half_axle
        v1 = state.v
        w1 = state.w
        state.v += h / 6 * lane.sum_a
        state.w += h / 6 * lane.sum_b
        state.work += h / 6 * lane.sum_p
        state.loss += h / 6 * lane.sum_q
        forward = h / 6 * lane.sum_v
        turn = h / 6 * lane.sum_w
        # v and ω changing together leave the arc a little sideways (Magnus expansion, second term).
        sideways = h * h / 12 * (state.v * w1 - v1 * state.w)
        state.right.angle += (forward + half * turn) * lane.per_r
        state.left.angle += (forward - half * turn) * lane.per_r
        dx, dy, lane.cos, lane.sin = _arc(lane.cos, lane.sin, forward, sideways, turn)
        state.x += dx
        state.y += dy
        state.heading += turn


@compiled_only
def _stage(z, width, weight, reach, hold):  # type: ignore[no-untyped-def]
    """Do one stage of Runge-Kutta: add what it finds, times ``weight``, to the sums; the next is ``reach`` [s] on.

    (m + 2 J_w/r²) v'     = (τr + τl)/r + m_c d ω²
    (I0 + 2 J_w L²/r²) ω' = L (τr − τl)/r − m_c d v ω

    the reduced form of thesis (2.1)-(2.9) with d ≠ 0 at the axle midpoint; d = 0 gives (2.10). Radius, mass and
    inertia are given as their reciprocals, since this is the innermost loop. It is short: a lane is a chain of
    arithmetic that waits for a root and a division, and others fill the gap.
    """
    for i in range(width):
        lane = BlockColumns(z, i, _BLOCK)
        state, robot = lane.state, lane.parameter
        v = lane.stage_v
        w = lane.stage_w
        half = robot.half_axle
        speed_r = (v + half * w) * lane.per_r
        speed_l = (v - half * w) * lane.per_r
        motor_r = _wheel_torque(robot, lane.volt_r, speed_r, hold)
        motor_l = _wheel_torque(robot, lane.volt_l, speed_l, hold)
        drag_r = _drag(robot, speed_r)
        drag_l = _drag(robot, speed_l)
        tr = motor_r - drag_r
        tl = motor_l - drag_l
        a = ((tr + tl) * lane.per_r + robot.coupling * w * w) * lane.per_mass
        b = (half * (tr - tl) * lane.per_r - robot.coupling * v * w) * lane.per_inertia
        power = motor_r * speed_r + motor_l * speed_l
        loss = drag_r * speed_r + drag_l * speed_l
        lane.sum_a += weight * a
        lane.sum_b += weight * b
        lane.sum_p += weight * power
        lane.sum_q += weight * loss
        lane.sum_v += weight * v
        lane.sum_w += weight * w
        lane.stage_v = state.v + reach * a
        lane.stage_w = state.w + reach * b


@compiled_only
def _glide(z, width, step):  # type: ignore[no-untyped-def]
    """Move the kinematic plant: the velocity is the command, and the arc is exact."""
    for i in range(width):
        lane = BlockColumns(z, i, _BLOCK)
        state, robot = lane.state, lane.parameter
        forward = state.v * step
        turn = state.w * step
        state.right.angle += (forward + robot.half_axle * turn) / robot.radius
        state.left.angle += (forward - robot.half_axle * turn) / robot.radius
        dx, dy, lane.cos, lane.sin = _arc(lane.cos, lane.sin, forward, 0.0, turn)
        state.x += dx
        state.y += dy
        state.heading += turn


@compiled_only
def _spoil(z, width, code):  # type: ignore[no-untyped-def]
    """Round the held command of imperfect robots, and let wheels stand within their dead band; keep v and ω."""
    for i in range(width):
        lane = BlockColumns(z, i, _BLOCK)
        state, robot = lane.state, lane.parameter
        if robot.imperfect > 0:
            lane.was_v = state.v
            lane.was_w = state.w
            if code != 1:
                v = _rounded(lane.volt_r, robot.v_resolution)
                w = _rounded(lane.volt_l, robot.w_resolution)
                turn = robot.half_axle * w
                stands_r = abs(v + turn) < robot.dead_band
                stands_l = abs(v - turn) < robot.dead_band
                if stands_r or stands_l:
                    right = 0.0 if stands_r else v + turn
                    left = 0.0 if stands_l else v - turn
                    v = (right + left) / 2
                    w = (right - left) / (2 * robot.half_axle)
                lane.volt_r = v
                lane.volt_l = w


@compiled_only
def _rounded(value, resolution):  # type: ignore[no-untyped-def]
    """The nearest multiple of a resolution, where there is one."""
    return resolution * np.rint(value / resolution) if resolution > 0 else value


@compiled_only
def _castor(z, width, h):  # type: ignore[no-untyped-def]
    """Brake imperfect robots over ``h`` seconds by the dry friction of a castor, along its way over the floor.

    F = −D u / |u| with u = (v, ω x_c) where the castor is; the speed over which it changes its sign is the wheels'.
    """
    for i in range(width):
        lane = BlockColumns(z, i, _BLOCK)
        state, robot = lane.state, lane.parameter
        if robot.imperfect > 0:
            aside = state.w * robot.castor_offset
            smooth = robot.friction_speed * robot.radius
            squared = state.v * state.v + aside * aside
            push = h * robot.castor_drag / np.sqrt(squared + smooth * smooth)  # N s for each m/s
            state.loss += push * squared
            lever = robot.castor_offset * robot.castor_offset
            state.v -= state.v * min(1.0, push * lane.per_mass)
            state.w -= state.w * min(1.0, push * lever * lane.per_inertia)


@compiled_only
def _slide(z, width, step):  # type: ignore[no-untyped-def]
    """Let imperfect robots slip behind their wheels and outwards, by what a step's accelerations make of it.

    κ = k_x a of each wheel, whose rim has the speed u and the acceleration a; the floor goes by at u − κ |u|.
    α = k_y v ω of the robot, which drifts aside by −α |v|. Both are 1 at most. v and ω stay those of the wheels.
    """
    for i in range(width):
        lane = BlockColumns(z, i, _BLOCK)
        state, robot = lane.state, lane.parameter
        if robot.imperfect > 0:
            half, v, w = robot.half_axle, state.v, state.w
            gain_r = (v - lane.was_v) + half * (w - lane.was_w)  # a times the step
            gain_l = (v - lane.was_v) - half * (w - lane.was_w)
            most = step / max(robot.longitudinal_slip, 1e-12)
            mean_v, mean_w = (v + lane.was_v) / 2, (w + lane.was_w) / 2
            lost_r = robot.longitudinal_slip * min(max(gain_r, -most), most) * abs(mean_v + half * mean_w)
            lost_l = robot.longitudinal_slip * min(max(gain_l, -most), most) * abs(mean_v - half * mean_w)
            outwards = min(max(robot.lateral_slip * v * w, -1.0), 1.0) * abs(v) * step
            turn = (lost_l - lost_r) / (2 * half)
            dx, dy, lane.cos, lane.sin = _arc(lane.cos, lane.sin, -(lost_r + lost_l) / 2, -outwards, turn)
            state.x += dx
            state.y += dy
            state.heading += turn


@compiled_only
def _arc(cos, sin, forward, sideways, turn):  # type: ignore[no-untyped-def]
    """The way of a pose along the arc of a constant twist, and its heading's cosine and sine then: thesis (2.27)."""
    q = turn * turn
    # sin(θ)/θ, (1 − cos θ)/θ and cos θ by their series, exact in float64 for the |θ| < 0.1 rad of one step. Divisions
    # are what the plant waits for, and in the small terms a product does as well.
    s = 1 - q / 6 * (1 - q * (1 / 20) * (1 - q * (1 / 42) * (1 - q * (1 / 72))))
    c = turn / 2 * (1 - q / 12 * (1 - q * (1 / 30) * (1 - q * (1 / 56) * (1 - q * (1 / 90)))))
    cos_turn = 1 - turn * c
    sin_turn = turn * s
    along = forward * s - sideways * c
    across = forward * c + sideways * s
    dx, dy = along * cos - across * sin, along * sin + across * cos
    return dx, dy, cos * cos_turn - sin * sin_turn, sin * cos_turn + cos * sin_turn


@compiled_only
def _odometry(z, width, step):  # type: ignore[no-untyped-def]
    """Read the encoders after the step: the wheel speeds for the loops, and the pose by odometry."""
    for i in range(width):
        lane = BlockColumns(z, i, _BLOCK)
        state, robot = lane.state, lane.parameter
        right, left = robot.odometry.right, robot.odometry.left
        turn_r, lane.old_r = _read_encoder(state.right, robot, lane.old_r, step)
        turn_l, lane.old_l = _read_encoder(state.left, robot, lane.old_l, step)
        forward = (right * turn_r + left * turn_l) / 2
        # thesis (2.25), with 2 L between the wheels
        turn = (right * turn_r - left * turn_l) / (2 * robot.odometry.half_axle)
        dx, dy, lane.odo_cos, lane.odo_sin = _arc(lane.odo_cos, lane.odo_sin, forward, 0.0, turn)
        state.odo_x += dx
        state.odo_y += dy
        state.odo_heading += turn


@compiled_only
def _read_encoder(wheel: WheelColumns, robot: ParameterColumns, old, step):  # type: ignore[no-untyped-def]
    """Read a wheel's encoder, and filter its speed; return its turn [rad] since it read ``old``, and what it reads."""
    count = np.floor(wheel.angle * robot.count)
    turn = (count - old) / robot.count
    raw = turn / step
    smooth = robot.b0 * raw + robot.b1 * wheel.raw1 + robot.b2 * wheel.raw2
    smooth = smooth - robot.a1 * wheel.speed - robot.a2 * wheel.past
    wheel.raw2, wheel.raw1 = wheel.raw1, raw
    wheel.past, wheel.speed = wheel.speed, smooth
    return turn, count
