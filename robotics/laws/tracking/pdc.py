"""Parallel distributed compensation of a Takagi-Sugeno model of tracking, thesis (2.37)-(2.41) as corrected.

Seen by the robot, a target at the distance d and the bearing α, whose heading is ψ ahead of the robot's, moves as

    d' = −v cos α + v_r cos(ψ − α)                               (2.37), with γ = −α
    α' = −ω + (v sin α + v_r sin(ψ − α)) / d
    ψ' = ω_r − ω

The thesis keeps d and α only, which is not closed, and linearises about the rules' operating points without a value for
the bearing's rate; its B has the wrong signs. Here each rule of Table 5.6's sets of distance and α has the operating
point in which robot and target go round the same circle, the target ``look_ahead`` = T ahead:

    ψ = 2 α,   v = v_r = d α / (T sin α),   ω = ω_r = 2 α / T

which is an equilibrium, so that no constant remains. d = 0 is none: that set has no rule. There

          |      0         2 v sin α     −v sin α   |         | −cos α      0 |
    A^j = | −2 v sin α/d²      0         v cos α/d  |   B^j = | sin α/d    −1 |
          |      0             0             0      |         |    0       −1 |

and K^j is the linear-quadratic regulator's gain, by Bryson's rule from the five scales below. With X = (d, α, ψ) as
measured, X_d as of a robot that is where it shall be, and h_j the rules' firing strengths,

    (v, ω) = (v_r, ω_r) − Σ_j h_j K^j (X − X_d)                  (2.41), whose minus the thesis lost

Stability: local, by a common P of (2.42), for those rules that the plug-in certificates finds one for.
Where the reference rests nearer than the smallest operating distance, the target is held that far ahead of it.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cache, cached_property
from typing import Any

import numpy as np

from fuzzy.compiled.columns import Columns, column, several
from fuzzy.compiled.jit import without_refcounts
from fuzzy.compiled.packed import evaluate_packed, packed
from fuzzy.membershipfunction import MembershipFunction
from fuzzy.quantity import quantity
from fuzzy.rule import Clause, Rule
from fuzzy.system import Constant, Sugeno, Variable
from robotics.laws.equation import EquationLaw, equation
from robotics.laws.law import ControllerError
from robotics.laws.setting import Setting
from robotics.laws.tracking.fuzzy_tracking import load_rule_base
from robotics.world.paths.posture import wrapped_compiled
from robotics.world.paths.road import moving


class CompensationDerived(Columns):
    """What the law makes of its rule base."""

    nearest = column("m", "the smallest operating distance")


class CompensationWork(Columns):
    """What the equation works in."""

    state = several(2, "m, rad", "the distance and the bearing")
    gains = several(6, "1", "entries of K^j: those of v, and those of ω")
    rest = several(0, "1", "what blending works in")


@without_refcounts
def seen_from(robot, x, y, heading):  # type: ignore[no-untyped-def]
    """The distance [m], the bearing [rad] and the heading [rad] of a target, from where a robot is, or shall be."""
    dx, dy = x - robot.x, y - robot.y
    alpha = wrapped_compiled(math.atan2(dy, dx) - robot.heading)
    return math.hypot(dx, dy), alpha, wrapped_compiled(heading - robot.heading)


@equation
def compensate(robot, aim, gain, work, rules, time, road, path):  # type: ignore[no-untyped-def]
    """Command (2.41)."""
    x, y, heading, _, _, _ = moving(road, path, time + gain.look_ahead)
    lead = max(gain.nearest - math.hypot(x - aim.x, y - aim.y), 0.0)
    x += lead * math.cos(heading)
    y += lead * math.sin(heading)
    d, alpha, psi = seen_from(robot, x, y, heading)
    d_d, alpha_d, psi_d = seen_from(aim, x, y, heading)
    e_d, e_alpha, e_psi = d - d_d, wrapped_compiled(alpha - alpha_d), wrapped_compiled(psi - psi_d)
    state, k = work.state, work.gains
    state[0], state[1] = d, alpha
    evaluate_packed(rules, state, k, work.rest)  # Σ_j h_j K^j
    v = aim.v - (k[0] * e_d + k[1] * e_alpha + k[2] * e_psi)
    w = aim.w - (k[3] * e_d + k[4] * e_alpha + k[5] * e_psi)
    return v, w


@dataclass(frozen=True, kw_only=True)
class ParallelCompensation(EquationLaw):
    """Parallel distributed compensation: the rule base whose sets it uses, and what weighs errors and commands."""

    rule_base: str = "tracking"  # of its inputs distance and alpha the sets are used, of its rules nothing
    look_ahead: float = quantity(0.4, "s", above=0, most=10)
    # Errors and commands that weigh alike
    distance_scale: float = quantity(0.1, "m", above=0)
    alpha_scale: float = quantity(0.3, "rad", above=0)
    heading_scale: float = quantity(0.5, "rad", above=0)
    v_scale: float = quantity(0.2, "m/s", above=0)
    w_scale: float = quantity(1.0, "rad/s", above=0)
    # The operating points: the peaks of the sets
    sets: tuple[tuple[MembershipFunction, ...], ...] = field(init=False, repr=False, compare=False)
    distances: np.ndarray = field(init=False, repr=False, compare=False)  # m, rising
    alphas: np.ndarray = field(init=False, repr=False, compare=False)  # rad, rising

    def __post_init__(self) -> None:
        super().__post_init__()
        inputs = {variable.name: variable for variable in load_rule_base(self.rule_base).inputs}
        for name in ("distance", "alpha"):
            if name not in inputs:
                raise ControllerError(f"{self.rule_base}: parallel compensation needs the inputs distance and alpha")
        distance, alpha = ([(_peak(mf), mf) for mf in inputs[n].terms.values()] for n in ("distance", "alpha"))
        distance = sorted((pair for pair in distance if pair[0] > 0), key=lambda pair: pair[0])
        alpha = sorted(alpha, key=lambda pair: pair[0])
        if not distance or not all(abs(peak) < np.pi / 2 for peak, _ in alpha):
            raise ControllerError(
                f"{self.rule_base}: parallel compensation needs a set of distance that peaks above 0, and sets of "
                "alpha that peak within ±π/2"
            )
        object.__setattr__(self, "sets", (tuple(mf for _, mf in distance), tuple(mf for _, mf in alpha)))
        object.__setattr__(self, "distances", np.array([peak for peak, _ in distance]))
        object.__setattr__(self, "alphas", np.array([peak for peak, _ in alpha]))

    @property
    def scales(self) -> np.ndarray:
        """The scales of d [m], α [rad] and ψ [rad] (3,)."""
        return np.array([self.distance_scale, self.alpha_scale, self.heading_scale])

    def model(self) -> tuple[np.ndarray, np.ndarray]:
        """A^j (distances, alphas, 3, 3) and B^j (distances, alphas, 3, 2) of every rule's operating point."""
        d, alpha = (part.ravel() for part in np.meshgrid(self.distances, self.alphas, indexing="ij"))
        v = d / (self.look_ahead * np.sinc(alpha / np.pi))  # d α / (T sin α)
        sin, cos, zero, one = np.sin(alpha), np.cos(alpha), np.zeros_like(d), np.ones_like(d)
        a = [[zero, 2 * v * sin, -v * sin], [-2 * v * sin / d**2, zero, v * cos / d], [zero, zero, zero]]
        b = [[-cos, zero], [sin / d, -one], [zero, -one]]
        of_rules, of_inputs = (np.moveaxis(np.array(matrix), -1, 0) for matrix in (a, b))
        shape = (len(self.distances), len(self.alphas))
        return of_rules.reshape(*shape, 3, 3), of_inputs.reshape(*shape, 3, 2)

    @cached_property
    def gains(self) -> np.ndarray:
        """The gains K^j (distances, alphas, 2, 3) of every rule, from its Riccati equation."""
        from scipy.linalg import solve_continuous_are

        weight, cost = np.diag(self.scales**-2), np.diag([self.v_scale**-2, self.w_scale**-2])
        a, b = self.model()
        gains = np.empty((*a.shape[:2], 2, 3))
        for j in np.ndindex(*a.shape[:2]):
            riccati = solve_continuous_are(a[j], b[j], weight, cost)
            gains[j] = np.linalg.solve(cost, b[j].T @ riccati)
        return gains

    def strengths(self, distance: np.ndarray, alpha: np.ndarray) -> np.ndarray:
        """The rules' firing strengths h_j (..., distances, alphas), whose sum is 1, at ``distance`` [m], ``alpha``."""
        d = np.clip(distance, self.distances[0], self.distances[-1])
        turn = np.clip(alpha, self.alphas[0], self.alphas[-1])
        near, side = (np.stack([mf(x) for mf in sets], axis=-1) for sets, x in zip(self.sets, (d, turn), strict=True))
        product = near[..., :, None] * side[..., None, :]
        return np.asarray(product / product.sum(axis=(-2, -1), keepdims=True))

    @cached_property
    def blend(self) -> Sugeno:
        """Σ_j h_j K^j as a system: of d and α, the six entries of the gain one after the other.

        Beyond the outermost operating points the strengths are those at them.
        """
        near, side = (
            Variable(name, (points[0], points[-1]), {f"{name}{n}": mf for n, mf in enumerate(sets)})
            for name, points, sets in zip(("d", "alpha"), (self.distances, self.alphas), self.sets, strict=True)
        )
        gains = self.gains.reshape(-1, CompensationWork.gains.rows)
        outputs = [
            Variable(f"k{m}", (row.min(), row.max()), {f"k{m} {j}": Constant(k) for j, k in enumerate(row)})
            for m, row in enumerate(gains.T)
        ]
        pairs = [(d, alpha) for d in near.terms for alpha in side.terms]
        rules = [
            Rule((Clause("d", d), Clause("alpha", alpha)), tuple((v.name, f"{v.name} {j}") for v in outputs))
            for j, (d, alpha) in enumerate(pairs)
        ]
        return Sugeno([near, side], outputs, rules, name="gains", out_of_range="clip")

    knows = ("reference", "reference velocity", "preview")
    equation, derived, works = compensate, CompensationDerived, CompensationWork

    def derive(self, setting: Setting) -> Mapping[str, Any]:
        """The smallest operating distance."""
        return {"nearest": self.distances[0]}

    def rule_rows(self) -> Sequence[np.ndarray]:
        """The gains, blended."""
        return (packed(self.blend, sample=True),)


@cache
def _peak(mf: MembershipFunction) -> float:
    """Where a set's degree is greatest; of a plateau the end that is nearer to 0."""
    x = np.linspace(-4.0, 4.0, 80_001)
    degree = np.asarray(mf(x))
    top = x[degree >= degree.max() - 1e-9]
    return round(float(top[np.abs(top).argmin()]), 4)
