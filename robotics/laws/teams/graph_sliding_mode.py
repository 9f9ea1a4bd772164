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

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np

from fuzzy.compiled.columns import Columns, codes, column, within
from fuzzy.compiled.jit import without_refcounts
from fuzzy.quantity import quantity
from robotics.laws.equation import EquationLaw, HeardColumns, equation
from robotics.laws.law import ControllerError, check_connected, check_team
from robotics.laws.setting import Setting
from robotics.laws.tracking.sliding_mode import exponential
from robotics.world.paths.road import share
from robotics.world.radio.channel import predicted
from robotics.world.radio.graph import weights
from robotics.world.vehicle.inverse_dynamics import DynamicsColumns, effective_dynamics, wheel_torques
from robotics.world.vehicle.plant import Level, LimitColumns, velocity_limits, within_limits

INTEGRATED_ERROR = 0.6  # m: no integration of larger errors
Form = Literal["cross-coupled", "thesis", "literal"]
_FORM, _REALISATION = codes(Form), codes(Level)


class ErrorColumns(Columns):
    """The error of the hand along one axis of its frame."""

    e = column("m")
    rate = column("m/s")


class SurfaceMessage(Columns):
    """What every robot broadcasts."""

    e_x = column("m", "the error along the path")
    e_x_rate = column("m/s")
    e_y = column("m", "the error across it")
    e_y_rate = column("m/s")


class SurfaceHeard(HeardColumns):
    """What one robot has heard of another."""

    x = within(ErrorColumns)
    y = within(ErrorColumns)


class SurfaceMemory(Columns):
    """What the law remembers."""

    integral_x = column("m s", "∫ ē dt along the path")
    integral_y = column("m s", "across it")
    command_v = column("m/s", "the velocity command")
    command_w = column("rad/s")
    reference_v = column("m/s", "of the reference in the period before; not-a-number: there was none")
    reference_w = column("rad/s")


class SurfaceDerived(Columns):
    """What the law makes of its setting."""

    limit = within(LimitColumns)
    dynamics = within(DynamicsColumns)
    a_ij = column("1", "the same for all links of a robot")


@without_refcounts
def into(cos, sin, x, y):  # type: ignore[no-untyped-def]
    """A vector in the frame that is turned by the angle with that cosine and sine."""
    return cos * x + sin * y, cos * y - sin * x


@without_refcounts
def hand_velocity(v, w, cos, sin, b):  # type: ignore[no-untyped-def]
    """The velocity [m/s] of a point ``b`` [m] ahead of what moves with ``v`` and turns with ``w``."""
    return v * cos - b * w * sin, v * sin + b * w * cos


@without_refcounts
def hand_acceleration(v, w, v_rate, w_rate, cos, sin, b):  # type: ignore[no-untyped-def]
    """The acceleration [m/s²] of that point, v' being ``v_rate`` and ω' being ``w_rate``."""
    ahead, left = v_rate - b * (w * w), v * w + b * w_rate
    return ahead * cos - left * sin, ahead * sin + left * cos


@without_refcounts
def coupling(e, rate, across, i, known, gain):  # type: ignore[no-untyped-def]
    """Σ_j a_ij (e_i − L_i/L_j e_j), and the same of the rates, over the neighbours that were heard.

    The errors are those ``across`` the path, or along it. The paths' lengths count if the form is cross-coupled.
    """
    road, robots = known.road, known.heard.shape[2]
    team = i - i % robots
    pull, pull_rate, ratio = 0.0, 0.0, 1.0
    for j in range(robots):
        heard = SurfaceHeard(known.heard, i, j)
        if heard.hears > 0:
            if gain.form == _FORM.cross_coupled:
                ratio = road.lengths[known.path[i]] / road.lengths[known.path[team + j]]
            theirs = heard.y if across else heard.x
            gap = e - ratio * predicted(theirs.e, theirs.rate, heard.age)
            if not math.isnan(gap):
                pull += gap * gain.a_ij
                pull_rate += (rate - ratio * theirs.rate) * gain.a_ij
    return pull, pull_rate


@equation
def graph_sliding_mode(robot, aim, gain, memory, command, known, i, dt):  # type: ignore[no-untyped-def]
    """Reach the surface (3.4)-(3.6) by (2.22), (2.23), with torques (2.19) or their integral."""
    b, v, w = gain.hand, robot.v, robot.w
    v_d, w_d = aim.v, aim.w
    first = math.isnan(memory.reference_v)
    v_d_rate = 0.0 if first else (v_d - memory.reference_v) / dt
    w_d_rate = 0.0 if first else (w_d - memory.reference_w) / dt
    memory.reference_v, memory.reference_w = v_d, w_d
    # The hand points, and e, e' in the frame of the path
    cos, sin = math.cos(robot.heading), math.sin(robot.heading)
    cos_d, sin_d = math.cos(aim.heading), math.sin(aim.heading)
    vx_d, vy_d = hand_velocity(v_d, w_d, cos_d, sin_d, b)
    ax_d, ay_d = hand_acceleration(v_d, w_d, v_d_rate, w_d_rate, cos_d, sin_d, b)
    dx = aim.x + b * cos_d - (robot.x + b * cos)
    dy = aim.y + b * sin_d - (robot.y + b * sin)
    vx, vy = hand_velocity(v, w, cos, sin, b)
    if gain.form == _FORM.literal:
        cos_d, sin_d = 1.0, 0.0
    e_x, e_y = into(cos_d, sin_d, dx, dy)
    x_rate, y_rate = into(cos_d, sin_d, vx_d - vx, vy_d - vy)
    say = command.say
    say.e_x, say.e_x_rate, say.e_y, say.e_y_rate = e_x, x_rate, e_y, y_rate
    command.progress = min(max(share(known.road, known.path[i], aim.s - e_x), 0.0), 1.0)
    # The surface
    pull_x, pull_x_rate = coupling(e_x, x_rate, False, i, known, gain)
    if gain.form == _FORM.cross_coupled:
        e_x, bar_rate = e_x + pull_x, x_rate + pull_x_rate  # ē, ē'
        s_x = x_rate + gain.lam_d * e_x + gain.lam_p * memory.integral_x
        s_y = y_rate + gain.lam_d * e_y + gain.lam_p * memory.integral_y
        pull_x_rate = pull_y_rate = 0.0
    else:
        pull_y, pull_y_rate = coupling(e_y, y_rate, True, i, known, gain)
        bar_rate = x_rate
        s_x = x_rate + gain.lam_d * e_x + pull_x + gain.lam_p * memory.integral_x  # (3.4), (3.5)
        s_y = y_rate + gain.lam_d * e_y + pull_y + gain.lam_p * memory.integral_y
    push_x = exponential(s_x, gain.k, gain.mu0, gain.alpha)  # (2.23)
    push_y = exponential(s_y, gain.k, gain.mu0, gain.alpha)
    wish_x = gain.lam_d * bar_rate + gain.lam_p * e_x + push_x + pull_x_rate  # −e''; (3.6)
    wish_y = gain.lam_d * y_rate + gain.lam_p * e_y + push_y + pull_y_rate
    # [v'; ω'] = G⁻¹ (h'' − G' [v; ω])
    hand_x, hand_y = into(cos_d, -sin_d, wish_x, wish_y)
    free_x = ax_d + hand_x - (-v * sin - b * w * cos) * w
    free_y = ay_d + hand_y - (v * cos - b * w * sin) * w
    v_rate, w_rate = cos * free_x + sin * free_y, (cos * free_y - sin * free_x) / b
    if math.hypot(e_x, e_y) < INTEGRATED_ERROR:
        memory.integral_x += dt * e_x
        memory.integral_y += dt * e_y
    v_next, w_next = max(memory.command_v + dt * v_rate, 0.0), memory.command_w + dt * w_rate  # never reverses
    v_next, w_next = within_limits(gain.limit, v_next, w_next)
    memory.command_v, memory.command_w = v_next, w_next
    if gain.realisation == _REALISATION.torque:
        command.first, command.second = wheel_torques(v_rate, w_rate, gain.dynamics)  # (2.19)
        command.wish_v, command.wish_w = v + dt * v_rate, w + dt * w_rate
    else:
        command.first, command.second, command.wish_v, command.wish_w = v_next, w_next, v_next, w_next


@dataclass(frozen=True, kw_only=True)
class GraphSlidingMode(EquationLaw):
    """Graph sliding mode: form and gains. The defaults of the reaching law are the thesis's (2.1.3.2)."""

    form: Form = "cross-coupled"
    coupling: float = quantity(1.0, "1", least=0)  # a: the weight of every link
    lam_d: float = quantity(2.0, "1/s", above=0)  # λ_d
    lam_p: float = quantity(1.0, "1/s²", least=0)  # λ_p
    k: float = quantity(0.2, "m/s²", above=0)
    mu0: float = quantity(0.1, "1", above=0, most=1)  # μ0
    alpha: float = quantity(3.0, "s/m", above=0)  # α
    hand: float = quantity(0.1, "m", above=0)  # b
    realisation: Level = "velocity"

    equation = graph_sliding_mode
    says, remembers, derived = SurfaceMessage, SurfaceMemory, SurfaceDerived
    progresses = True

    @property
    def level(self) -> Level:
        """Wheel torques (2.19), or velocities for the wheel loops."""
        return self.realisation

    def derive(self, setting: Setting) -> Mapping[str, Any]:
        """The limits, the dynamics, and the weights of the graph."""
        links = weights(setting.radio.adjacency(len(setting.robots)))
        sign = -1.0 if self.form == "literal" else 1.0
        return {
            "limit": velocity_limits(setting.robots),
            "dynamics": effective_dynamics(setting.robots),
            "a_ij": sign * self.coupling * links.max(axis=1),
        }

    def begin(self, setting: Setting, runs: int) -> np.ndarray:
        """Begin at rest. Raises ControllerError where the graph is not connected, or each run has its own paths."""
        check_team(setting)
        if setting.ensemble:
            raise ControllerError(f"{setting.name}: this law drives runs with the same paths only, not random ones")
        if self.coupling > 0:
            check_connected(setting)  # theorem 3.1
        memory = SurfaceMemory.zeros(runs, len(setting.robots))
        memory.reference_v = memory.reference_w = np.nan
        return memory.array
