"""Sliding-mode velocity tracking, thesis 2.1.2: conventional, two second-order modes, exponential.

An outer loop (Kanayama's, :mod:`robotics.laws.tracking.lyapunov`) gives the desired velocities u_d = (v_d, ω_d).

    e = u_d − u                         (2.13)
    S = e + λ ∫ e dt                    (2.14)
    S' = u_d' − u' + λ e                (2.18), to be made  S' = −reaching(S)

    conventional   S' = −K sign S                                                            (2.16)
    exponential    S' = −K / Q(S) sign S,   Q(S) = μ0 + (1 − μ0) e^{−α|S|}                   (2.22), (2.23)
    arbitrary second order (ASSM)           S'' = −K sign(S' + |S|^½ sign S)                 (2.20)
    quasi-continuous second order (QSSM)    S'' = −K (S' + |S|^½ sign S) / (|S'| + |S|^½)    (2.21)

(2.20) and (2.21) print S' on the left; Levant's laws, whose right sides these are, give S'' [Levant 2003, 2005].

Stability: V = S²/2 gives V' = −K|S| (or −K|S|/Q) < 0 for S ≠ 0 as long as the disturbance stays below K (below
K/Q(S) for the exponential one); the second-order modes converge in finite time for K above the bound of the
disturbance's rate. At equal K the exponential law never pushes less than the conventional one, since Q ≤ 1.

Realisations: ``torque``, the inverse dynamics (2.19) with the nominal mass and inertia and d = 0; ``velocity``, the
thesis's architecture, where the velocity command is the integral of the same acceleration and the wheel loops
follow it.

Chosen here: ∫ e dt stops while the demand is beyond the wheels (anti-windup), and a velocity command leads the speed by
``command_lead`` at most. ``discretisation`` says how the second-order laws run in steps: "integrated" as S'', or as
printed.
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, Literal

import numpy as np

from fuzzy.compiled.columns import Columns, codes, column, within
from fuzzy.compiled.jit import without_refcounts
from fuzzy.quantity import quantity
from robotics.laws.equation import EquationLaw, equation
from robotics.laws.setting import Setting
from robotics.laws.tracking.lyapunov import Lyapunov, track
from robotics.world.vehicle.inverse_dynamics import DynamicsColumns, nominal_dynamics, wheel_torques
from robotics.world.vehicle.plant import Level, LimitColumns, velocity_limits, within_limits

Mode = Literal["csm", "assm", "qssm", "esm"]
Reading = Literal["integrated", "algebraic", "memory"]  # of (2.20) and (2.21), in steps
Realisation = Literal["torque", "velocity"]
MODE, READING, _REALISATION = codes(Mode), codes(Reading), codes(Realisation)


class AxisMemory(Columns):
    """What the law remembers of v, or of ω."""

    integral = column("m (rad)", "∫ e dt")
    s = column("m/s (rad/s)", "the surface S of the period before; not-a-number: there was none")
    push = column("m/s² (rad/s²)", "of the reaching law")
    desired = column("m/s (rad/s)", "u_d of the period before")
    command = column("m/s (rad/s)", "the velocity command")


class SlidingMemory(Columns):
    """What the law remembers."""

    v = within(AxisMemory)
    w = within(AxisMemory)


class SlidingDerived(Columns):
    """What the law reads of its robot."""

    limit = within(LimitColumns)
    dynamics = within(DynamicsColumns)


# The reaching laws ------------------------------------------------------------------------------------------------
# Each returns the acceleration that is added to the equivalent control: of v in m/s², of ω in rad/s².


def attraction(s: Any, mu0: Any, alpha: Any) -> Any:
    """Q(S) = μ0 + (1 − μ0) e^{−α|S|}, from 1 at S = 0 to μ0 far from it   thesis (2.22); of any one shape."""
    return mu0 + (1 - mu0) * np.exp(-alpha * np.abs(s))


attraction_compiled = without_refcounts(attraction)  # the same, for one robot in a compiled loop


@without_refcounts
def sign(s):  # type: ignore[no-untyped-def]
    """1, 0 or −1."""
    return 1.0 if s > 0 else -1.0 if s < 0 else s


@without_refcounts
def conventional(s, k):  # type: ignore[no-untyped-def]
    """K sign S   thesis (2.16)."""
    return k * sign(s)


@without_refcounts
def exponential(s, k, mu0, alpha):  # type: ignore[no-untyped-def]
    """K / Q(S) sign S   thesis (2.22), (2.23)."""
    return k / attraction_compiled(s, mu0, alpha) * sign(s)


@without_refcounts
def arbitrary_second_order(s, s_dot, push, k, reading, dt):  # type: ignore[no-untyped-def]
    """∫ K sign(S' + |S|^½ sign S) dt if integrated; else (2.20) as printed, with S' on the left.

    ``push`` is that of the period before, ``reading`` one of READING, and ``dt`` the control period [s].
    """
    root = math.sqrt(abs(s))
    if reading == READING.integrated:
        return push + dt * k * sign(s_dot + root * sign(s))
    if reading == READING.memory:
        return k * sign(s_dot + root * sign(s))
    # As printed, (2.20) is an equation for S' with the solution S' = −min(K, |S|^½) sign S.
    return min(k, root) * sign(s)


@without_refcounts
def quasi_continuous(s, s_dot, push, k, reading, dt):  # type: ignore[no-untyped-def]
    """∫ K (S' + |S|^½ sign S)/(|S'| + |S|^½) dt if integrated; else (2.21) as printed.

    The arguments are those of :func:`arbitrary_second_order`.
    """
    root = math.sqrt(abs(s))
    if reading == READING.algebraic:
        # S' = −w sign S with w² + (|S|^½ + K) w = K |S|^½
        b = root + k
        return (math.sqrt(b * b + 4 * k * root) - b) / 2 * sign(s)
    size = abs(s_dot) + root
    quotient = (s_dot + root * sign(s)) / (size if size > 0 else 1.0)
    return push + dt * k * quotient if reading == READING.integrated else k * quotient


# The law ----------------------------------------------------------------------------------------------------------


@without_refcounts
def slide(desired, u, feasible, memory: AxisMemory, gain, dt):  # type: ignore[no-untyped-def]
    """The acceleration u' that (2.18) asks for: of v [m/s²], or of ω [rad/s²].

    ``desired`` is u_d and ``u`` the speed, both in m/s or rad/s. ∫ e dt stops where u_d is not ``feasible``.
    """
    e = desired - u  # (2.13)
    memory.integral += dt * (e if feasible else 0.0)
    s = e + gain.lam * memory.integral  # (2.14)
    first = math.isnan(memory.s)
    s_dot = 0.0 if first else (s - memory.s) / dt
    rate = 0.0 if first else (desired - memory.desired) / dt
    if gain.mode == MODE.csm:
        memory.push = conventional(s, gain.k)
    elif gain.mode == MODE.esm:
        memory.push = exponential(s, gain.k, gain.mu0, gain.alpha)
    elif gain.mode == MODE.assm:
        memory.push = arbitrary_second_order(s, s_dot, memory.push, gain.k, gain.discretisation, dt)
    else:
        memory.push = quasi_continuous(s, s_dot, memory.push, gain.k, gain.discretisation, dt)
    memory.s, memory.desired = s, desired
    return rate + gain.lam * e + memory.push  # (2.18)


@without_refcounts
def led(before, acceleration, u, lead, dt):  # type: ignore[no-untyped-def]
    """The velocity command: the integral of an acceleration, ``lead`` at most from the speed ``u``."""
    before = u if math.isnan(before) else before
    return min(max(before + dt * acceleration, u - lead), u + lead)


@equation
def sliding_mode(robot, aim, gain, memory, command, dt):  # type: ignore[no-untyped-def]
    """Command (2.13)-(2.19) with the mode's reaching law."""
    wish_v, wish_w = track(robot, aim, gain.outer)
    v, w = within_limits(gain.limit, wish_v, wish_w)
    # Anti-windup (a choice; the thesis has none): no integration while the demand is beyond what the wheels can
    # do, as it is far from the path. Otherwise the integral of the missing speed takes many seconds to decay.
    feasible = v == wish_v and w == wish_w
    v_rate = slide(v, robot.v, feasible, memory.v, gain, dt)
    w_rate = slide(w, robot.w, feasible, memory.w, gain, dt)
    if gain.realisation == _REALISATION.torque:
        command.first, command.second = wheel_torques(v_rate, w_rate, gain.dynamics)  # (2.19)
    else:
        command.first = led(memory.v.command, v_rate, robot.v, gain.command_lead, dt)
        command.second = led(memory.w.command, w_rate, robot.w, gain.command_lead / gain.dynamics.half_axle, dt)
        memory.v.command, memory.w.command = command.first, command.second
    command.wish_v, command.wish_w = v, w


@dataclass(frozen=True, kw_only=True)
class SlidingMode(EquationLaw):
    """Sliding-mode control, one law for all four modes: the surface, its realisation, and the reaching law.

    Default gains are the thesis's (2.1.3.2): K = 1 (csm), 0.8 (assm, qssm), 0.2 (esm); λ = 10; μ0 = 0.1, α = 3.
    """

    mode: Mode = "esm"
    k: float = quantity(0.2, "m/s² (rad/s²)", above=0)  # m/s³ (rad/s³) for the second-order modes
    lam: float = quantity(10.0, "1/s", least=0)  # λ
    mu0: float = quantity(0.1, "1", above=0, most=1)  # μ0, esm only
    alpha: float = quantity(3.0, "s/m (s/rad)", above=0)  # α, esm only
    realisation: Realisation = "torque"
    discretisation: Reading = "integrated"  # assm and qssm only
    command_lead: float = quantity(0.4, "m/s", above=0)  # velocity realisation: how far the command may lead the speed
    outer: Lyapunov = field(default_factory=Lyapunov)  # makes the desired velocities

    knows = ("reference", "reference velocity", "wheel speeds")
    equation = sliding_mode
    remembers, derived = SlidingMemory, SlidingDerived

    @property
    def level(self) -> Level:
        """Wheel torques (2.19), or velocities for the wheel loops."""
        return self.realisation

    @property
    def idle(self) -> frozenset[str]:
        """The gains that have no effect in this mode and realisation."""
        gains = {"mu0", "alpha"} if self.mode != "esm" else set()
        gains |= {"discretisation"} if self.mode in ("csm", "esm") else set()
        return frozenset(gains | ({"command_lead"} if self.realisation == "torque" else set()))

    def derive(self, setting: Setting) -> Mapping[str, Any]:
        """The limits, and the nominal dynamics with d = 0."""
        return {"limit": velocity_limits(setting.robots), "dynamics": nominal_dynamics(setting.robots)}

    def begin(self, setting: Setting, runs: int) -> np.ndarray:
        """Begin with the integrals at 0, and nothing known of a period before."""
        memory = SlidingMemory.zeros(runs, len(setting.robots))
        for axis in (memory.v, memory.w):
            axis.s = axis.command = np.nan
        return memory.array
