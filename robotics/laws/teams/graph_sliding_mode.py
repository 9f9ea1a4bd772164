"""Exponential sliding mode with a communication graph, thesis chapter 3.

Chosen here, where (3.4) leaves it open or prints it wrongly:

* the error is one of position, of a hand point ``hand`` metres ahead of the axle: with a velocity error (3.4) holds an
  algebraic loop (relative degree 0). h = p + b (cos ψ, sin ψ), h_d likewise on the reference.
* errors are taken in the frame of the path, e = R_dᵀ (h_d − h): e_x along it, e_y across.
* robots couple along their paths only, each in shares of its own path's length,
      ē_i = e_i + Σ_j a_ij (e_i − L_i/L_j e_j)     (the x components)
  with a_ij = −l_ij: the Laplacian's own entries, as (3.5) prints them, push apart. Coupling in the world's frame
  pushes robots off their paths.
* ē, not e, stands in every term of the surface. As printed, the coupling is in the surface only and acts as damping,
  which slows synchronisation (the slow pole of the difference modes goes from −1.0 to −0.21 for a = 1).

    S_i = e_i' + λ_d ē_i + λ_p ∫ ē_i dt                               (3.4), (3.5)
    e_i'' := −λ_d ē_i' − λ_p ē_i − K/Q(S_i) sign S_i                  (2.22), (2.23)
    [v'; ω'] = G⁻¹ (h'' − G' [v; ω]),  G = [cos ψ, −b sin ψ; sin ψ, b cos ψ]
    τ = Γ⁻¹ [v'; ω']                                                  (2.19), or v and ω by integration

The paths' frames turn slowly compared with these errors; their turning is left out of e'. ∫ ē stops while |ē| > 0.6 m.

Stability: on S = 0 the modes of e obey e'' + μ λ_d e' + μ λ_p e = 0 with μ an eigenvalue of the coupling from e to ē.
An undirected graph has μ >= 1, so that λ_d, λ_p > 0 suffice; synchronisation needs it connected (theorem 3.1). S is
reached as in :mod:`robotics.laws.tracking.sliding_mode`.

Forms: ``cross-coupled`` as above; ``thesis`` with e for ē and the coupling Σ a_ij (e_i − e_j) in S only; ``literal``
the same with a_ij = l_ij in the world's frame, which diverges for a = 1, λ_d = 2.
"""

from dataclasses import dataclass
from typing import Literal, NamedTuple

import numpy as np

from robotics.laws.law import Command, ControllerError, Law, Observation, check_connected, check_team
from robotics.laws.setting import Setting
from robotics.laws.teams.neighbours import differences
from robotics.laws.tracking.sliding_mode import attraction
from robotics.paths.trajectory import Reference
from robotics.quantity import check_quantities, quantity
from robotics.radio.graph import weights
from robotics.vehicle.inverse_dynamics import InverseDynamics
from robotics.vehicle.plant import Level, saturate, velocity_limits

INTEGRATED_ERROR = 0.6  # m: no integration of larger errors


class _Memory(NamedTuple):
    """What a robot remembers, and what does not change."""

    integral: np.ndarray  # (2, runs, robots) m s: ∫ ē dt
    command: np.ndarray  # (2, runs, robots) v [m/s], ω [rad/s]
    reference: Reference | None  # of the period before
    weights: np.ndarray  # (robots, robots): a_ij
    ratio: np.ndarray  # (robots, robots): L_i / L_j
    limits: np.ndarray  # (4, robots): of the velocities
    dynamics: InverseDynamics


@dataclass(frozen=True, kw_only=True)
class GraphSlidingMode(Law[_Memory]):
    """Graph sliding mode: form and gains. The defaults of the reaching law are the thesis's (2.1.3.2)."""

    form: Literal["cross-coupled", "thesis", "literal"] = "cross-coupled"
    coupling: float = quantity(1.0, "1", least=0)  # a: the weight of every link
    lam_d: float = quantity(2.0, "1/s", above=0)  # λ_d
    lam_p: float = quantity(1.0, "1/s²", least=0)  # λ_p
    k: float = quantity(0.2, "m/s²", above=0)
    mu0: float = quantity(0.1, "1", above=0, most=1)  # μ0
    alpha: float = quantity(3.0, "s/m", above=0)  # α
    hand: float = quantity(0.1, "m", above=0)  # b
    realisation: Literal["velocity", "torque"] = "velocity"

    message = ("e_x", "e_x_rate", "e_y", "e_y_rate")

    def __post_init__(self) -> None:
        check_quantities(self, ControllerError)

    @property
    def level(self) -> Level:
        """Wheel torques (2.19), or velocities for the wheel loops."""
        return self.realisation

    def init(self, setting: Setting, runs: int) -> _Memory:
        """Begin at rest. Raises ControllerError where the graph is not connected, or each run has its own paths."""
        check_team(setting)
        if setting.ensemble:
            raise ControllerError(f"{setting.name}: this law drives runs with the same paths only, not random ones")
        if self.coupling > 0:
            check_connected(setting)  # theorem 3.1
        robots = len(setting.robots)
        a = weights(setting.radio.adjacency(robots))
        lengths = setting.references.joined.lengths
        zero = np.zeros((2, runs, robots))
        sign = -1.0 if self.form == "literal" else 1.0
        ratio = lengths[:, None] / lengths if self.form == "cross-coupled" else np.ones_like(a)
        return _Memory(
            zero,
            zero,
            None,
            sign * self.coupling * a,
            ratio,
            velocity_limits(setting.robots),
            InverseDynamics.effective(setting.robots),
        )

    def control(self, seen: Observation, memory: _Memory, dt: float) -> tuple[Command, _Memory]:
        """Reach the surface (3.4)-(3.6) by (2.22), (2.23), with torques (2.19) or their integral."""
        heard = seen.heard
        b, ref = self.hand, seen.reference
        before = memory.reference or ref
        a_ref, w_ref_rate = (ref.v - before.v) / dt, (ref.w - before.w) / dt
        place_d, velocity_d, acceleration_d = _hand(ref, a_ref, w_ref_rate, b)
        cos, sin = np.cos(seen.heading), np.sin(seen.heading)
        place = np.stack([seen.x + b * cos, seen.y + b * sin])
        velocity = np.stack([seen.v * cos - b * seen.w * sin, seen.v * sin + b * seen.w * cos])
        frame = np.zeros_like(ref.heading) if self.form == "literal" else ref.heading
        e, rate = _into(frame, place_d[:, None] - place), _into(frame, velocity_d[:, None] - velocity)
        # Coupling
        pulls, pull_rates = np.zeros_like(e), np.zeros_like(rate)
        components = ("e_x",) if self.form == "cross-coupled" else ("e_x", "e_y")
        for i, name in enumerate(components):
            theirs, their_rates = heard.now(name, by=f"{name}_rate"), heard[f"{name}_rate"]
            pulls[i] = differences(e[i], memory.ratio * theirs, memory.weights)
            pull_rates[i] = differences(rate[i], memory.ratio * their_rates, memory.weights)
        message = {"e_x": e[0], "e_x_rate": rate[0], "e_y": e[1], "e_y_rate": rate[1]}
        if self.form == "cross-coupled":
            e, rate_bar = e + pulls, rate + pull_rates  # ē, ē'
            s = rate + self.lam_d * e + self.lam_p * memory.integral
        else:
            rate_bar = rate
            s = rate + self.lam_d * e + pulls + self.lam_p * memory.integral  # (3.4), (3.5)
        push = self.k / attraction(s, self.mu0, self.alpha) * np.sign(s)  # (2.23)
        wish = self.lam_d * rate_bar + self.lam_p * e + push  # −e''
        if self.form != "cross-coupled":
            wish = wish + pull_rates  # (3.6)
        hand = acceleration_d[:, None] + _into(-frame, wish)
        # [v'; ω'] = G⁻¹ (h'' − G' [v; ω])
        turning = np.stack([-seen.v * sin - b * seen.w * cos, seen.v * cos - b * seen.w * sin]) * seen.w
        free = hand - turning
        acceleration = np.stack([cos * free[0] + sin * free[1], (cos * free[1] - sin * free[0]) / b])
        near = np.hypot(*e) < INTEGRATED_ERROR
        integral = memory.integral + dt * np.where(near, e, 0.0)
        v = np.maximum(memory.command[0] + dt * acceleration[0], 0.0)  # it never reverses
        w = memory.command[1] + dt * acceleration[1]
        command = np.stack(saturate(memory.limits, v, w))
        if self.realisation == "torque":
            first, second = memory.dynamics.torques(acceleration)  # (2.19)
            demand = seen.v + dt * acceleration[0], seen.w + dt * acceleration[1]
        else:
            first, second = command
            demand = first, second
        progress = np.clip(seen.references.joined.share(ref.s - message["e_x"]), 0.0, 1.0)
        after = memory._replace(integral=integral, command=command, reference=ref)
        return Command(first, second, *demand, message, None, progress), after


def _hand(ref: Reference, a: np.ndarray, w_rate: np.ndarray, b: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Place, velocity and acceleration (2, robots) of the reference's hand point.

    ``a`` [m/s²] is v' and ``w_rate`` [rad/s²] is ω' of the reference; ``b`` [m] is how far ahead the hand is.
    """
    cos, sin = np.cos(ref.heading), np.sin(ref.heading)
    ahead, left = np.stack([cos, sin]), np.stack([-sin, cos])
    place = np.stack([ref.x, ref.y]) + b * ahead
    velocity = ref.v * ahead + b * ref.w * left
    acceleration = (a - b * ref.w**2) * ahead + (ref.v * ref.w + b * w_rate) * left
    return place, velocity, acceleration


def _into(heading: np.ndarray, vector: np.ndarray) -> np.ndarray:
    """``vector`` (2, runs, robots) in the frame turned by ``heading`` (robots,)."""
    cos, sin = np.cos(heading), np.sin(heading)
    return np.stack([cos * vector[0] + sin * vector[1], cos * vector[1] - sin * vector[0]])
