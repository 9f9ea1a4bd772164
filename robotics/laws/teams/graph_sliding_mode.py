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
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np

from fuzzy.compiled.jit import uncounted
from robotics.laws.equation import (
    AT_HEADING,
    AT_S,
    AT_V,
    AT_W,
    AT_X,
    AT_Y,
    FIRST,
    HEADING,
    PROGRESS,
    SAYS,
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
from robotics.laws.law import ControllerError, check_connected, check_team
from robotics.laws.setting import Setting
from robotics.laws.teams.neighbours import heard_now
from robotics.laws.tracking.sliding_mode import exponential
from robotics.paths.road import share
from robotics.quantity import check_quantities, quantity
from robotics.radio.channel import HEARD, HEARS
from robotics.radio.graph import weights
from robotics.vehicle.inverse_dynamics import InverseDynamics, wheel_torques
from robotics.vehicle.plant import Level, velocity_limits, within

INTEGRATED_ERROR = 0.6  # m: no integration of larger errors
FORMS = ("cross-coupled", "thesis", "literal")
CROSS_COUPLED, THESIS, LITERAL = range(3)  # places in FORMS
# Places of the gains: first the limits of the velocities. a_ij is the same for all links of a robot.
LIMITS, MASS, FORM, A_IJ, LAMBDA_D, LAMBDA_P, K, MU0, ALPHA, HAND, TORQUE = 0, 4, *range(8, 17)
# Places of what is remembered: ∫ ē dt [m s], v [m/s] and ω [rad/s] of the command, and of the reference before
INTEGRAL_X, INTEGRAL_Y, COMMAND_V, COMMAND_W, REFERENCE_V, REFERENCE_W = range(6)
REMEMBERED = 6
E_X, E_X_RATE, E_Y, E_Y_RATE = range(4)  # places in the message


@uncounted
def into(cos, sin, x, y):  # type: ignore[no-untyped-def]
    """A vector in the frame that is turned by the angle with that cosine and sine."""
    return cos * x + sin * y, cos * y - sin * x


@uncounted
def hand_velocity(v, w, cos, sin, b):  # type: ignore[no-untyped-def]
    """The velocity [m/s] of a point ``b`` [m] ahead of what moves with ``v`` and turns with ``w``."""
    return v * cos - b * w * sin, v * sin + b * w * cos


@uncounted
def hand_acceleration(v, w, v_rate, w_rate, cos, sin, b):  # type: ignore[no-untyped-def]
    """The acceleration [m/s²] of that point, v' being ``v_rate`` and ω' being ``w_rate``."""
    ahead, left = v_rate - b * (w * w), v * w + b * w_rate
    return ahead * cos - left * sin, ahead * sin + left * cos


@uncounted
def coupling(e, rate, value, i, known, form):  # type: ignore[no-untyped-def]
    """Σ_j a_ij (e_i − L_i/L_j e_j), and the same of the rates, over the neighbours that were heard.

    ``value`` is the place of e in the message, its rate follows. The paths' lengths count if ``form`` is cross-coupled.
    """
    heard, road, a = known.heard, known.road, known.gains[A_IJ, known.column[i]]
    team = i - i % heard.shape[2]
    pull, pull_rate, ratio = 0.0, 0.0, 1.0
    for j in range(heard.shape[2]):
        if heard[HEARS, i, j] > 0:
            if form == CROSS_COUPLED:
                ratio = road.lengths[known.path[i]] / road.lengths[known.path[team + j]]
            gap = e - ratio * heard_now(heard, i, j, value, value + 1)
            if not math.isnan(gap):
                pull += gap * a
                pull_rate += (rate - ratio * heard[HEARD + value + 1, i, j]) * a
    return pull, pull_rate


@equation
def graph_sliding_mode(i, known, memory, command, work):  # type: ignore[no-untyped-def]
    """Reach the surface (3.4)-(3.6) by (2.22), (2.23), with torques (2.19) or their integral."""
    seen, gains, g, dt = known.seen, known.gains, known.column[i], known.dt
    form, b, v, w = gains[FORM, g], gains[HAND, g], seen[V, i], seen[W, i]
    v_d, w_d = seen[AT_V, i], seen[AT_W, i]
    first = math.isnan(memory[REFERENCE_V, i])
    v_d_rate = 0.0 if first else (v_d - memory[REFERENCE_V, i]) / dt
    w_d_rate = 0.0 if first else (w_d - memory[REFERENCE_W, i]) / dt
    memory[REFERENCE_V, i], memory[REFERENCE_W, i] = v_d, w_d
    # The hand points, and e, e' in the frame of the path
    cos, sin = math.cos(seen[HEADING, i]), math.sin(seen[HEADING, i])
    cos_d, sin_d = math.cos(seen[AT_HEADING, i]), math.sin(seen[AT_HEADING, i])
    vx_d, vy_d = hand_velocity(v_d, w_d, cos_d, sin_d, b)
    ax_d, ay_d = hand_acceleration(v_d, w_d, v_d_rate, w_d_rate, cos_d, sin_d, b)
    dx = seen[AT_X, i] + b * cos_d - (seen[X, i] + b * cos)
    dy = seen[AT_Y, i] + b * sin_d - (seen[Y, i] + b * sin)
    vx, vy = hand_velocity(v, w, cos, sin, b)
    if form == LITERAL:
        cos_d, sin_d = 1.0, 0.0
    e_x, e_y = into(cos_d, sin_d, dx, dy)
    x_rate, y_rate = into(cos_d, sin_d, vx_d - vx, vy_d - vy)
    command[SAYS + E_X, i], command[SAYS + E_X_RATE, i] = e_x, x_rate
    command[SAYS + E_Y, i], command[SAYS + E_Y_RATE, i] = e_y, y_rate
    command[PROGRESS, i] = min(max(share(known.road, known.path[i], seen[AT_S, i] - e_x), 0.0), 1.0)
    # The surface
    lambda_d, lambda_p = gains[LAMBDA_D, g], gains[LAMBDA_P, g]
    pull_x, pull_x_rate = coupling(e_x, x_rate, E_X, i, known, form)
    if form == CROSS_COUPLED:
        e_x, bar_rate = e_x + pull_x, x_rate + pull_x_rate  # ē, ē'
        s_x = x_rate + lambda_d * e_x + lambda_p * memory[INTEGRAL_X, i]
        s_y = y_rate + lambda_d * e_y + lambda_p * memory[INTEGRAL_Y, i]
        pull_x_rate = pull_y_rate = 0.0
    else:
        pull_y, pull_y_rate = coupling(e_y, y_rate, E_Y, i, known, form)
        bar_rate = x_rate
        s_x = x_rate + lambda_d * e_x + pull_x + lambda_p * memory[INTEGRAL_X, i]  # (3.4), (3.5)
        s_y = y_rate + lambda_d * e_y + pull_y + lambda_p * memory[INTEGRAL_Y, i]
    push_x = exponential(s_x, gains[K, g], gains[MU0, g], gains[ALPHA, g])  # (2.23)
    push_y = exponential(s_y, gains[K, g], gains[MU0, g], gains[ALPHA, g])
    wish_x = lambda_d * bar_rate + lambda_p * e_x + push_x + pull_x_rate  # −e''; (3.6)
    wish_y = lambda_d * y_rate + lambda_p * e_y + push_y + pull_y_rate
    # [v'; ω'] = G⁻¹ (h'' − G' [v; ω])
    hand_x, hand_y = into(cos_d, -sin_d, wish_x, wish_y)
    free_x = ax_d + hand_x - (-v * sin - b * w * cos) * w
    free_y = ay_d + hand_y - (v * cos - b * w * sin) * w
    v_rate, w_rate = cos * free_x + sin * free_y, (cos * free_y - sin * free_x) / b
    if math.hypot(e_x, e_y) < INTEGRATED_ERROR:
        memory[INTEGRAL_X, i] += dt * e_x
        memory[INTEGRAL_Y, i] += dt * e_y
    v_next, w_next = max(memory[COMMAND_V, i] + dt * v_rate, 0.0), memory[COMMAND_W, i] + dt * w_rate  # never reverses
    v_next, w_next = within(gains, g, v_next, w_next)
    memory[COMMAND_V, i], memory[COMMAND_W, i] = v_next, w_next
    if gains[TORQUE, g] > 0:
        command[FIRST, i], command[SECOND, i] = wheel_torques(v_rate, w_rate, gains, MASS, g)  # (2.19)
        command[WISH_V, i], command[WISH_W, i] = v + dt * v_rate, w + dt * w_rate
    else:
        command[FIRST, i] = command[WISH_V, i] = v_next
        command[SECOND, i] = command[WISH_W, i] = w_next


@dataclass(frozen=True, kw_only=True)
class GraphSlidingMode(EquationLaw):
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

    equation = graph_sliding_mode
    progresses = True

    def __post_init__(self) -> None:
        check_quantities(self, ControllerError)

    @property
    def level(self) -> Level:
        """Wheel torques (2.19), or velocities for the wheel loops."""
        return self.realisation

    def gain_rows(self, setting: Setting) -> Sequence[Any]:
        """The limits, the dynamics, and the gains."""
        links = weights(setting.radio.adjacency(len(setting.robots)))
        sign = -1.0 if self.form == "literal" else 1.0
        return (
            *velocity_limits(setting.robots),
            *InverseDynamics.effective(setting.robots),
            FORMS.index(self.form),
            sign * self.coupling * links.max(axis=1),
            *(self.lam_d, self.lam_p, self.k, self.mu0, self.alpha, self.hand),
            self.realisation == "torque",
        )

    def begin(self, setting: Setting, runs: int) -> np.ndarray:
        """Begin at rest. Raises ControllerError where the graph is not connected, or each run has its own paths."""
        check_team(setting)
        if setting.ensemble:
            raise ControllerError(f"{setting.name}: this law drives runs with the same paths only, not random ones")
        if self.coupling > 0:
            check_connected(setting)  # theorem 3.1
        rows = np.zeros((REMEMBERED, runs, len(setting.robots)))
        rows[REFERENCE_V:] = np.nan
        return rows
