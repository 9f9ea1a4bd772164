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

from dataclasses import dataclass, field
from typing import Literal, NamedTuple, Protocol

import numpy as np

from robotics.laws.law import Command, ControllerError, Law, Observation
from robotics.laws.setting import Setting
from robotics.laws.tracking.lyapunov import Lyapunov
from robotics.quantity import check_quantities, quantity
from robotics.vehicle.inverse_dynamics import InverseDynamics
from robotics.vehicle.plant import Level, saturate, velocity_limits

Array = np.ndarray


class ReachingLaw(Protocol):
    """A law that drives the surface S to 0."""

    def push(self, s: Array, s_dot: Array, push: Array, dt: float) -> Array:
        """Return the acceleration [m/s², rad/s²] that is added to the equivalent control; all are (2, runs, robots).

        Args:
            s: S [m/s, rad/s].
            s_dot: S' [m/s², rad/s²].
            push: The result of the period before.
            dt: The control period [s].
        """
        ...


@dataclass(frozen=True, kw_only=True)
class Conventional:
    """The conventional reaching law (2.16)."""

    k: float

    def push(self, s: Array, s_dot: Array, push: Array, dt: float) -> Array:
        """Return K sign S."""
        return self.k * np.sign(s)


@dataclass(frozen=True, kw_only=True)
class Exponential:
    """The exponential reaching law (2.22), (2.23)."""

    k: float
    mu0: float
    alpha: float

    def push(self, s: Array, s_dot: Array, push: Array, dt: float) -> Array:
        """Return K / Q(S) sign S."""
        return self.k / attraction(s, self.mu0, self.alpha) * np.sign(s)


def attraction(s: Array, mu0: float, alpha: float) -> Array:
    """Q(S) = μ0 + (1 − μ0) e^{−α|S|}, from 1 at S = 0 to μ0 far from it   thesis (2.22)."""
    return mu0 + (1 - mu0) * np.exp(-alpha * np.abs(s))


Discretisation = Literal["integrated", "algebraic", "memory"]


@dataclass(frozen=True, kw_only=True)
class ArbitrarySecondOrder:
    """The arbitrary second-order reaching law (2.20)."""

    k: float
    discretisation: Discretisation

    def push(self, s: Array, s_dot: Array, push: Array, dt: float) -> Array:
        """Return ∫ K sign(S' + |S|^½ sign S) dt if integrated; else (2.20) as printed, with S' on the left."""
        root = np.sqrt(np.abs(s))
        if self.discretisation == "integrated":
            return push + dt * self.k * np.sign(s_dot + root * np.sign(s))
        if self.discretisation == "memory":
            return self.k * np.sign(s_dot + root * np.sign(s))
        # As printed, (2.20) is an equation for S' with the solution S' = −min(K, |S|^½) sign S.
        return np.minimum(self.k, root) * np.sign(s)


@dataclass(frozen=True, kw_only=True)
class QuasiContinuous:
    """The quasi-continuous second-order reaching law (2.21)."""

    k: float
    discretisation: Discretisation

    def push(self, s: Array, s_dot: Array, push: Array, dt: float) -> Array:
        """Return ∫ K (S' + |S|^½ sign S)/(|S'| + |S|^½) dt if integrated; else (2.21) as printed."""
        root = np.sqrt(np.abs(s))
        if self.discretisation == "algebraic":
            # S' = −w sign S with w² + (|S|^½ + K) w = K |S|^½
            b = root + self.k
            return (np.sqrt(b * b + 4 * self.k * root) - b) / 2 * np.sign(s)
        size = np.abs(s_dot) + root
        quotient = (s_dot + root * np.sign(s)) / np.where(size > 0, size, 1.0)
        return push + dt * self.k * quotient if self.discretisation == "integrated" else self.k * quotient


class _Memory(NamedTuple):
    """Each array is (2, runs, robots), for v and for ω; None before the first period."""

    integral: Array  # ∫ e dt
    s: Array | None  # S
    push: Array  # of the reaching law
    desired: Array | None  # u_d
    command: Array | None  # the velocity command
    dynamics: InverseDynamics  # nominal, with d = 0
    limits: Array  # (4, robots): of the velocities


@dataclass(frozen=True, kw_only=True)
class SlidingMode(Law[_Memory]):
    """Sliding-mode control, one law for all four modes: the surface, its realisation, and the reaching law.

    Default gains are the thesis's (2.1.3.2): K = 1 (csm), 0.8 (assm, qssm), 0.2 (esm); λ = 10; μ0 = 0.1, α = 3.
    """

    mode: Literal["csm", "assm", "qssm", "esm"] = "esm"
    k: float = quantity(0.2, "m/s² (rad/s²)", above=0)  # m/s³ (rad/s³) for the second-order modes
    lam: float = quantity(10.0, "1/s", least=0)  # λ
    mu0: float = quantity(0.1, "1", above=0, most=1)  # μ0, esm only
    alpha: float = quantity(3.0, "s/m (s/rad)", above=0)  # α, esm only
    realisation: Literal["torque", "velocity"] = "torque"
    discretisation: Discretisation = "integrated"  # assm and qssm only
    lead: float = quantity(0.4, "m/s", above=0)  # velocity realisation: how far the command may lead the speed
    outer: Lyapunov = field(default_factory=Lyapunov)  # makes the desired velocities
    law: ReachingLaw = field(init=False, repr=False)

    def __post_init__(self) -> None:
        check_quantities(self, ControllerError)
        law: ReachingLaw
        if self.mode == "csm":
            law = Conventional(k=self.k)
        elif self.mode == "esm":
            law = Exponential(k=self.k, mu0=self.mu0, alpha=self.alpha)
        else:
            second_order = ArbitrarySecondOrder if self.mode == "assm" else QuasiContinuous
            law = second_order(k=self.k, discretisation=self.discretisation)
        object.__setattr__(self, "law", law)

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

    def init(self, setting: Setting, runs: int) -> _Memory:
        """Begin with the integrals at 0 and the nominal dynamics of every robot."""
        zero = np.zeros((2, runs, len(setting.robots)))
        return _Memory(
            integral=zero,
            s=None,
            push=zero,
            desired=None,
            command=None,
            dynamics=InverseDynamics.nominal(setting.robots),
            limits=velocity_limits(setting.robots),
        )

    def control(self, seen: Observation, memory: _Memory, dt: float) -> tuple[Command, _Memory]:
        """Command (2.13)-(2.19) with the mode's reaching law."""
        wish, _ = self.outer.control(seen, None, dt)
        desired = np.stack(saturate(memory.limits, wish.v, wish.w))
        u = np.stack([seen.v, seen.w])
        e = desired - u  # (2.13)
        # Anti-windup (a choice; the thesis has none): no integration while the demand is beyond what the wheels can
        # do, as it is far from the path. Otherwise the integral of the missing speed takes many seconds to decay.
        feasible = (desired[0] == wish.v) & (desired[1] == wish.w)
        integral = memory.integral + dt * np.where(feasible, e, 0.0)
        s = e + self.lam * integral  # (2.14)
        s_dot = (s - memory.s) / dt if memory.s is not None else np.zeros_like(s)
        push = self.law.push(s, s_dot, memory.push, dt)
        rate = (desired - memory.desired) / dt if memory.desired is not None else np.zeros_like(desired)
        acceleration = rate + self.lam * e + push  # what (2.18) asks of u'
        if self.realisation == "torque":
            command = memory.dynamics.torques(acceleration)  # (2.19)
        else:
            lead = np.stack(
                [np.full_like(e[0], self.lead), self.lead / memory.dynamics.half_axle + np.zeros_like(e[1])]
            )
            before = memory.command if memory.command is not None else u
            command = np.clip(before + dt * acceleration, u - lead, u + lead)
        after = memory._replace(integral=integral, s=s, push=push, desired=desired, command=command)
        return Command(command[0], command[1], desired[0], desired[1]), after
