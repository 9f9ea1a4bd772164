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
``lead`` at most. ``discretisation`` says how the second-order laws run in steps: "integrated" as S'', or as printed.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any, Literal

import numpy as np

from fuzzy.compiled.jit import uncounted
from robotics.laws.equation import (
    AT_HEADING,
    AT_V,
    AT_W,
    AT_X,
    AT_Y,
    FIRST,
    HEADING,
    SECOND,
    WISH_V,
    WISH_W,
    EquationLaw,
    V,
    W,
    X,
    Y,
    equation,
)
from robotics.laws.law import ControllerError
from robotics.laws.setting import Setting
from robotics.laws.tracking.lyapunov import Lyapunov, track
from robotics.quantity import check_quantities, quantity
from robotics.vehicle.inverse_dynamics import InverseDynamics, wheel_torques
from robotics.vehicle.plant import Level, velocity_limits, within

MODES = ("csm", "assm", "qssm", "esm")
READINGS = ("integrated", "algebraic", "memory")
CSM, ASSM, QSSM, ESM = range(4)  # places in MODES
INTEGRATED, ALGEBRAIC, AS_MEMORY = range(3)  # places in READINGS
# Places of the gains: first the limits of the velocities, last those of the outer loop
LIMITS, MASS, INERTIA, RADIUS, HALF_AXLE = 0, 4, 5, 6, 7
MODE, READING, K, LAMBDA, MU0, ALPHA, TORQUE, LEAD, OUTER = range(8, 17)
# Places of what is remembered, for v and, behind it, for ω
INTEGRAL, S, PUSH, DESIRED, COMMAND = range(0, 10, 2)  # ∫ e dt, S, the reaching law's push, u_d, the velocity command
REMEMBERED = 10


# The reaching laws ------------------------------------------------------------------------------------------------
# Each returns the acceleration that is added to the equivalent control: of v in m/s², of ω in rad/s².


def attraction(s: Any, mu0: Any, alpha: Any) -> Any:
    """Q(S) = μ0 + (1 − μ0) e^{−α|S|}, from 1 at S = 0 to μ0 far from it   thesis (2.22); of any one shape."""
    return mu0 + (1 - mu0) * np.exp(-alpha * np.abs(s))


attraction_compiled = uncounted(attraction)  # the same, for one robot in a compiled loop


@uncounted
def sign(s):  # type: ignore[no-untyped-def]
    """1, 0 or −1."""
    return 1.0 if s > 0 else -1.0 if s < 0 else s


@uncounted
def conventional(s, k):  # type: ignore[no-untyped-def]
    """K sign S   thesis (2.16)."""
    return k * sign(s)


@uncounted
def exponential(s, k, mu0, alpha):  # type: ignore[no-untyped-def]
    """K / Q(S) sign S   thesis (2.22), (2.23)."""
    return k / attraction_compiled(s, mu0, alpha) * sign(s)


@uncounted
def arbitrary_second_order(s, s_dot, push, k, reading, dt):  # type: ignore[no-untyped-def]
    """∫ K sign(S' + |S|^½ sign S) dt if integrated; else (2.20) as printed, with S' on the left.

    ``push`` is that of the period before, ``reading`` a place in READINGS, and ``dt`` the control period [s].
    """
    root = math.sqrt(abs(s))
    if reading == INTEGRATED:
        return push + dt * k * sign(s_dot + root * sign(s))
    if reading == AS_MEMORY:
        return k * sign(s_dot + root * sign(s))
    # As printed, (2.20) is an equation for S' with the solution S' = −min(K, |S|^½) sign S.
    return min(k, root) * sign(s)


@uncounted
def quasi_continuous(s, s_dot, push, k, reading, dt):  # type: ignore[no-untyped-def]
    """∫ K (S' + |S|^½ sign S)/(|S'| + |S|^½) dt if integrated; else (2.21) as printed.

    The arguments are those of :func:`arbitrary_second_order`.
    """
    root = math.sqrt(abs(s))
    if reading == ALGEBRAIC:
        # S' = −w sign S with w² + (|S|^½ + K) w = K |S|^½
        b = root + k
        return (math.sqrt(b * b + 4 * k * root) - b) / 2 * sign(s)
    size = abs(s_dot) + root
    quotient = (s_dot + root * sign(s)) / (size if size > 0 else 1.0)
    return push + dt * k * quotient if reading == INTEGRATED else k * quotient


# The law ----------------------------------------------------------------------------------------------------------


@uncounted
def slide(axis, desired, u, feasible, memory, i, gains, g, dt):  # type: ignore[no-untyped-def]
    """The acceleration u' that (2.18) asks for along an ``axis``: 0 of v [m/s²], 1 of ω [rad/s²].

    ``desired`` is u_d and ``u`` the speed, both in m/s or rad/s. ∫ e dt stops where u_d is not ``feasible``.
    """
    e = desired - u  # (2.13)
    integral = memory[INTEGRAL + axis, i] + dt * (e if feasible else 0.0)
    s = e + gains[LAMBDA, g] * integral  # (2.14)
    first = math.isnan(memory[S + axis, i])
    s_dot = 0.0 if first else (s - memory[S + axis, i]) / dt
    rate = 0.0 if first else (desired - memory[DESIRED + axis, i]) / dt
    mode, k, push = gains[MODE, g], gains[K, g], memory[PUSH + axis, i]
    if mode == CSM:
        push = conventional(s, k)
    elif mode == ESM:
        push = exponential(s, k, gains[MU0, g], gains[ALPHA, g])
    elif mode == ASSM:
        push = arbitrary_second_order(s, s_dot, push, k, gains[READING, g], dt)
    else:
        push = quasi_continuous(s, s_dot, push, k, gains[READING, g], dt)
    memory[INTEGRAL + axis, i], memory[S + axis, i] = integral, s
    memory[PUSH + axis, i], memory[DESIRED + axis, i] = push, desired
    return rate + gains[LAMBDA, g] * e + push  # (2.18)


@uncounted
def led(before, acceleration, u, lead, dt):  # type: ignore[no-untyped-def]
    """The velocity command: the integral of an acceleration, ``lead`` at most from the speed ``u``."""
    before = u if math.isnan(before) else before
    return min(max(before + dt * acceleration, u - lead), u + lead)


@equation
def sliding_mode(i, known, memory, command, work):  # type: ignore[no-untyped-def]
    """Command (2.13)-(2.19) with the mode's reaching law."""
    seen, gains, g, dt = known.seen, known.gains, known.column[i], known.dt
    wish_v, wish_w = track(
        seen[X, i], seen[Y, i], seen[HEADING, i],
        seen[AT_X, i], seen[AT_Y, i], seen[AT_HEADING, i], seen[AT_V, i], seen[AT_W, i],
        gains, OUTER, g,
    )  # fmt: skip
    v, w = within(gains, g, wish_v, wish_w)
    # Anti-windup (a choice; the thesis has none): no integration while the demand is beyond what the wheels can
    # do, as it is far from the path. Otherwise the integral of the missing speed takes many seconds to decay.
    feasible = v == wish_v and w == wish_w
    v_rate = slide(0, v, seen[V, i], feasible, memory, i, gains, g, dt)
    w_rate = slide(1, w, seen[W, i], feasible, memory, i, gains, g, dt)
    if gains[TORQUE, g] > 0:
        command[FIRST, i], command[SECOND, i] = wheel_torques(v_rate, w_rate, gains, MASS, g)  # (2.19)
    else:
        lead, half_axle = gains[LEAD, g], gains[HALF_AXLE, g]
        command[FIRST, i] = led(memory[COMMAND, i], v_rate, seen[V, i], lead, dt)
        command[SECOND, i] = led(memory[COMMAND + 1, i], w_rate, seen[W, i], lead / half_axle, dt)
        memory[COMMAND, i], memory[COMMAND + 1, i] = command[FIRST, i], command[SECOND, i]
    command[WISH_V, i], command[WISH_W, i] = v, w


@dataclass(frozen=True, kw_only=True)
class SlidingMode(EquationLaw):
    """Sliding-mode control, one law for all four modes: the surface, its realisation, and the reaching law.

    Default gains are the thesis's (2.1.3.2): K = 1 (csm), 0.8 (assm, qssm), 0.2 (esm); λ = 10; μ0 = 0.1, α = 3.
    """

    mode: Literal["csm", "assm", "qssm", "esm"] = "esm"
    k: float = quantity(0.2, "m/s² (rad/s²)", above=0)  # m/s³ (rad/s³) for the second-order modes
    lam: float = quantity(10.0, "1/s", least=0)  # λ
    mu0: float = quantity(0.1, "1", above=0, most=1)  # μ0, esm only
    alpha: float = quantity(3.0, "s/m (s/rad)", above=0)  # α, esm only
    realisation: Literal["torque", "velocity"] = "torque"
    discretisation: Literal["integrated", "algebraic", "memory"] = "integrated"  # assm and qssm only
    lead: float = quantity(0.4, "m/s", above=0)  # velocity realisation: how far the command may lead the speed
    outer: Lyapunov = field(default_factory=Lyapunov)  # makes the desired velocities

    def __post_init__(self) -> None:
        check_quantities(self, ControllerError)

    knows = ("reference", "reference velocity", "wheel speeds")
    equation = sliding_mode

    @property
    def level(self) -> Level:
        """Wheel torques (2.19), or velocities for the wheel loops."""
        return self.realisation

    @property
    def idle(self) -> frozenset[str]:
        """The gains that have no effect in this mode and realisation."""
        gains = {"mu0", "alpha"} if self.mode != "esm" else set()
        gains |= {"discretisation"} if self.mode in ("csm", "esm") else set()
        return frozenset(gains | ({"lead"} if self.realisation == "torque" else set()))

    def gain_rows(self, setting: Setting) -> Sequence[Any]:
        """The limits, the nominal dynamics with d = 0, the gains, and those of the outer loop."""
        options = MODES.index(self.mode), READINGS.index(self.discretisation)
        return (
            *velocity_limits(setting.robots),
            *InverseDynamics.nominal(setting.robots),
            *options,
            *(self.k, self.lam, self.mu0, self.alpha),
            *(self.realisation == "torque", self.lead),
            *self.outer.gain_rows(setting),
        )

    def begin(self, setting: Setting, runs: int) -> np.ndarray:
        """Begin with the integrals at 0, and nothing known of a period before."""
        rows = np.zeros((REMEMBERED, runs, len(setting.robots)))
        rows[S : S + 2] = rows[COMMAND : COMMAND + 2] = np.nan
        return rows
