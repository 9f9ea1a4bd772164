"""A rule base's closed loop as one sampled system, with bounds of all rounding: what a certificate is about.

    z(k+1) = A z + B v + c,   q = C z + l,   v = φ(q)

z are the plant's states, the controls that are on their way through the dead time, and what the controller remembers:
the error before and its filtered rate, the error's sum, the integral of du. q are the inputs of the rules that move, v
what they add to u and to the integral in a sample. The hold is exact (see :mod:`fuzzy.plugins.loop.plant`). Matrices
are balls: a middle and a radius by entry, which grow by what is rounded [Rump 1999].
"""

import math
from dataclasses import dataclass
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np

from fuzzy.compiled.intervals import ranges
from fuzzy.compiled.packed import packed
from fuzzy.inference import infer_quietly
from fuzzy.plugins.loop.controller import LoopError, Roles, factor_of
from fuzzy.plugins.loop.plant import FunctionPlant, TransferFunction, split_dead_time, state_space
from fuzzy.plugins.loop.response import Loop
from fuzzy.plugins.loop.scheduledplant import along
from fuzzy.system import Sugeno

_EPS = 2.3e-16  # more than half a unit in the last place, relative
_ORDER = 18  # of the exponential's Taylor series, at a norm of 1/2: the rest is below 1e-22
_TRIED = 20  # points at which a plant that says it is linear is asked


class Ball(NamedTuple):
    """A real matrix of which each entry is known up to a radius."""

    mid: np.ndarray
    rad: np.ndarray

    def __matmul__(self, other: "Ball") -> "Ball":
        mid, size = self.mid @ other.mid, abs(self.mid) @ abs(other.mid)
        rad = abs(self.mid) @ other.rad + self.rad @ (abs(other.mid) + other.rad)
        return Ball(mid, (rad + (self.mid.shape[-1] + 2) * _EPS * size) * (1 + 1e-12) + 1e-300)

    def plus(self, other: "Ball", sign: int = 1) -> "Ball":
        """The sum, or the difference."""
        mid = self.mid + sign * other.mid
        return Ball(mid, (self.rad + other.rad + _EPS * abs(mid)) * (1 + 1e-12) + 1e-300)

    @property
    def T(self) -> "Ball":
        """The transpose."""
        return Ball(self.mid.T, self.rad.T)

    def part(self, *place: Any) -> "Ball":
        """Some of the entries."""
        return Ball(self.mid[place], self.rad[place])


def ball(mid: Any, ulps: float = 0.0) -> Ball:
    """Numbers that are exact, or rounded a few times."""
    mid = np.asarray(mid, dtype=float)
    return Ball(mid, ulps * _EPS * abs(mid))


def exponential(matrix: Ball) -> Ball:
    """exp of a square matrix: scaled to a norm of at most 1/2, by its Taylor series, and squared again."""
    norm = float((abs(matrix.mid) + matrix.rad).sum(axis=1).max(initial=0.0))
    halvings = max(0, math.ceil(math.log2(max(norm, 1e-300))) + 1)
    small = Ball(matrix.mid / 2.0**halvings, matrix.rad / 2.0**halvings)
    term = total = ball(np.eye(len(matrix.mid)))
    for k in range(1, _ORDER + 1):
        term = term @ small
        term = Ball(term.mid / k, term.rad / k + _EPS * abs(term.mid))
        total = total.plus(term)
    total = Ball(total.mid, total.rad + 1e-22)
    for _ in range(halvings):
        total = total @ total
    return total


def linear_plant(plant: Any) -> tuple[np.ndarray, np.ndarray, np.ndarray, float, float]:
    """A, B, C, D and the dead time [s] of a plant that is linear.

    A transfer function is, and a Python plant that says so by ``linear = True``. Raises LoopError for others, and for a
    Python plant that is not what it says.
    """
    if isinstance(plant, TransferFunction):
        return *state_space(plant.numerator, plant.denominator), plant.dead_time
    if not isinstance(plant, FunctionPlant):
        raise LoopError("a plant is certified at values of its operating variable, not while the variable moves")
    if not plant.linear:
        raise LoopError(
            f"{plant.name}: a Python plant is certified where it says linear = True, which stands for "
            "dx/dt = A x + B u, y = C x. For one that is not, certify its transfer function at a working point "
            "(--plant 'numerator; denominator; dead time'): that holds for the model alone, and near the point"
        )
    order = plant.states
    moving = plant.sampled(1.0)

    def asked(z: np.ndarray, time: float = 0.0) -> np.ndarray:
        slope = np.asarray(plant.derivative(z[:order].copy(), float(z[order]), time), dtype=float).ravel()
        return np.append(slope, moving.output(z[:order], 0.0))

    matrix = np.column_stack([asked(unit) for unit in np.eye(order + 1)])
    rng = np.random.default_rng(0)
    for _ in range(_TRIED):
        z, time = rng.normal(size=order + 1) * 10.0 ** rng.uniform(-2, 2), rng.uniform(0, 100)
        if not np.allclose(asked(z, time), matrix @ z, rtol=1e-9, atol=1e-9 * (abs(matrix) @ abs(z)).max()):
            raise LoopError(f"{plant.name}: it says linear = True, but plant(x, u, t) is not A x + B u at x, u = {z}")
    return matrix[:order, :order], matrix[:order, order], matrix[order, :order], 0.0, plant.dead_time


@dataclass(frozen=True, eq=False)
class SampledLoop:
    """A rule base's closed loop.

    Attributes:
        fis: The rule base.
        roles: Of its variables.
        loop: Reference, sample time, limits, scale factors.
        states: The names (n,) of z.
        rows: (n + m + 1, n + p + 1): the next states, the rules' inputs q and the control u, each by z, v and 1.
        start: z (n,) at rest, when the reference steps.
        moving: Which (m,) inputs of the rules move; the others are the operating variable.
        clips: Whether the limits belong to v: rules of u alone, without a sum, which remember nothing of them.
    """

    fis: Sugeno
    roles: Roles
    loop: Loop
    states: tuple[str, ...]
    rows: Ball
    start: np.ndarray
    moving: tuple[int, ...]
    clips: bool

    @property
    def sizes(self) -> tuple[int, int, int]:
        """n, m and p."""
        return len(self.states), len(self.moving), len(self.roles.outputs)

    @property
    def factors(self) -> np.ndarray:
        """By what the outputs (p,) of the rules are multiplied to be v."""
        period = {"u": 1.0, "du": self.loop.period}
        return np.array([factor_of(self.loop.scale, role) * period[role] for role in self.roles.outputs])

    def _known(self, q: np.ndarray) -> np.ndarray:
        x = np.full((*q.shape[:-1], len(self.fis.inputs)), self.loop.operating_at(0.0))
        x[..., self.moving] = q
        return x

    def rules(self, q: np.ndarray) -> np.ndarray:
        """v (..., p) at inputs (..., m)."""
        v = infer_quietly(self.fis, self._known(q)).output * self.factors
        return np.clip(v, self.loop.low, self.loop.high) if self.clips else v

    def enclosed(self, low: np.ndarray, high: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Bounds (N, p) of v over boxes (N, m) of inputs, and over which boxes (N,) it may be that no rule fires."""
        boxes = np.stack([self._known(low), self._known(high)], axis=1)
        out = np.empty((len(boxes), 2, len(self.factors)))
        holes = ranges(packed(self.fis), boxes, out)
        v = np.sort(out * self.factors, axis=1) + np.array([[-1.0], [1.0]]) * 2e-15 * abs(out * self.factors)
        if self.clips:
            v = np.clip(v, self.loop.low, self.loop.high)
        return v[:, 0], v[:, 1], holes

    def advance(self, z: np.ndarray) -> np.ndarray:
        """z (..., n) a sample later, within the limits."""
        n, m, _ = self.sizes
        one = np.ones((*z.shape[:-1], 1))
        q = np.concatenate([z, one], axis=-1) @ self.rows.mid[n : n + m][:, [*range(n), -1]].T
        whole: np.ndarray = np.concatenate([z, self.rules(q), one], axis=-1) @ self.rows.mid[:n].T
        return whole


def sampled_loop(fis: Sugeno, plant: Any, loop: Loop, roles: Roles) -> SampledLoop:
    """The closed loop of a rule base and a linear plant.

    Raises LoopError for a plant that is not linear, and a loop that is not time-invariant.
    """
    if "scheduling" in roles.inputs and (loop.operating is None or not loop.operating.constant):
        raise LoopError("scheduled rules are certified at values of the operating variable: give --operating a value")
    a, b, c, d, dead_time = linear_plant(along(plant, loop.operating))
    period, order = loop.period, len(a)
    whole, late = split_dead_time(dead_time, period)
    moved, older = _held(a, b, late)
    rest, newer = _held(a, b, period - late)
    moved, older = rest @ moved, rest @ older
    on_way = [f"u({-k})" for k in range(whole + 1, 0, -1)]  # the oldest first
    if late == 0 and d == 0:
        del on_way[0]
    rate, summed, integral = "error_rate" in roles.inputs, "error_sum" in roles.inputs, "du" in roles.outputs
    keep = loop.rate_filter / (loop.rate_filter + period)
    remembered = {"error before": rate, "rate before": rate and keep > 0, "sum": summed, "integral": integral}
    states = (*[f"x{k + 1}" for k in range(order)], *on_way, *[name for name, there in remembered.items() if there])
    width = len(states) + len(roles.outputs) + 1
    unit = dict(zip((*states, *roles.outputs, ""), np.eye(width), strict=True))
    nothing = np.zeros(width)
    oldest = unit[on_way[0]] if on_way else unit[""] * 0
    x = np.eye(order, width)
    error = loop.reference * unit[""] - c @ x - d * oldest
    rated = keep * unit.get("rate before", nothing) + (1 - keep) / period * (error - unit.get("error before", nothing))
    total = unit.get("sum", nothing) + period * error
    integrated = unit.get("integral", nothing) + unit.get("du", nothing)
    control = unit.get("u", nothing) + integrated
    known = {"error": error, "error_rate": rated, "error_sum": total}
    moving = tuple(i for i, role in enumerate(roles.inputs) if role in known)
    later = {name: unit[after] for name, after in pairwise(on_way)} | dict.fromkeys(on_way[-1:], control)
    later |= {"error before": error, "rate before": rated, "sum": total, "integral": integrated}
    acting = unit[on_way[-whole]] if whole else control
    given = np.stack([oldest if late > 0 or d else nothing, acting])
    plant_rows = (moved @ ball(x)).plus(
        Ball(np.stack([older.mid, newer.mid], 1), np.stack([older.rad, newer.rad], 1)) @ ball(given)
    )
    other = [later[name] for name in states[order:]]
    other += [known[roles.inputs[i]] * factor_of(loop.scale, roles.inputs[i]) for i in moving] + [control]
    rest_rows = ball(np.array(other), 8)
    rows = Ball(np.vstack([plant_rows.mid, rest_rows.mid]), np.vstack([plant_rows.rad, rest_rows.rad]))
    start = np.array([loop.reference if name == "error before" else 0.0 for name in states])
    clips = roles.outputs == ("u",) and not summed
    return SampledLoop(fis, roles, loop, states, rows, start, moving, clips)


def _held(a: np.ndarray, b: np.ndarray, span: float) -> tuple[Ball, Ball]:
    """exp(A t), and the integral of exp(A s) B from 0 to t, for t = ``span`` [s]."""
    order = len(a)
    both = np.zeros((order + 1, order + 1))
    both[:order, :order], both[:order, order] = a * span, b * span
    moved = exponential(ball(both, 4))
    return moved.part(slice(order), slice(order)), moved.part(slice(order), order)
