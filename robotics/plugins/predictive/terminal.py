"""The terminal cost: what following the reference on and on costs from the end of the horizon, by a Riccati equation.

Along a straight reference driven at v_r the errors of the model are linear, and those along and across the path do not
depend on each other. With u − u_r as the input, p the command before and the weights of the stage cost,

    (along, v, p):      along' = along + own v + given u
    (across, ψ, ω, p):  across' = across + v_r h (ψ + own_half ω + given_half u),   ψ' = ψ + own ω + given u

and v, ω as of :mod:`robotics.plugins.predictive.model`.

P solves the discrete algebraic Riccati equation of each: it is what the linearised problem without bounds costs over an
infinite horizon [Rawlings, Mayne & Diehl 2017, 2.5]. The curvature of the reference is left out, and so is what bounds
cost. P depends on v_r, and grows without bound as the reference slows down: it is tabulated from 1/32 of the top speed
of the wheels up to it, linear between, and constant beyond the ends.
"""

from functools import lru_cache
from typing import NamedTuple

import numpy as np

from fuzzy.compiled.columns import Columns, column
from robotics.plugins.predictive.model import Response

SPEEDS = 6  # of the table: the top speed and its halves
_DOUBLINGS = 60


class Weights(NamedTuple):
    """The weights of the stage cost: 1 / scale² each."""

    along: float  # 1/m²
    cross: float  # 1/m²
    turned: float  # 1/rad²
    deviation_v: float  # s²/m²
    deviation_w: float  # s²/rad²
    change_v: float  # s²/m²
    change_w: float  # s²/rad²


WeightColumns = Columns.named("WeightColumns", {name: column("") for name in Weights._fields})


@lru_cache(maxsize=256)
def tail_table(weights: Weights, after: Response, top: float) -> np.ndarray:
    """The table (SPEEDS, 17): the speed v_r [m/s] up to ``top``, and the numbers of P there in the order of the solver.

    ``after`` is the response over one period. The array cannot be written to.
    """
    speeds = top / 2.0 ** np.arange(SPEEDS - 1, -1, -1)
    along = riccati(*straight_along(weights, after))[None].repeat(SPEEDS, axis=0)
    across = riccati(
        *(np.array(part) for part in zip(*(straight_across(weights, after, v) for v in speeds), strict=True))
    )
    triangles = [solution[:, *np.triu_indices(solution.shape[-1])] for solution in (along, across)]
    table = np.concatenate([speeds[:, None], *triangles], axis=1)
    table.flags.writeable = False
    return table


def riccati(a: np.ndarray, b: np.ndarray, q: np.ndarray, r: np.ndarray, s: np.ndarray) -> np.ndarray:
    """The solutions P (..., n, n) of P = Q + A'PA − (A'PB + S) (R + B'PB)⁻¹ (B'PA + S').

    By doubling [Chu, Fan, Lin & Wang 2004]: each pass squares what is left of the first state. Their number is bounded,
    and with it the time that gains take that are far apart; a state that is left for 2^60 periods is one that costs
    nothing.

    Args:
        a: (..., n, n).
        b: (..., n, m).
        q: (..., n, n) the cost of states.
        r: (..., m, m) that of inputs.
        s: (..., n, m) of both together.
    """
    gain = b @ np.linalg.inv(r)
    left, cost, reach = a - gain @ s.mT, q - s @ np.linalg.inv(r) @ s.mT, gain @ b.mT
    for _ in range(_DOUBLINGS):
        inverse = np.linalg.inv(np.eye(a.shape[-1]) + reach @ cost)
        shorter, more = left @ inverse, left.mT @ cost @ inverse @ left
        reach, cost, left = reach + shorter @ reach @ left.mT, cost + more, shorter @ left
        if np.all(np.abs(more) <= 1e-15 * np.abs(cost).max(axis=(-2, -1), keepdims=True)):
            break
    return np.asarray((cost + cost.mT) / 2)


def straight_along(weights: Weights, after: Response) -> tuple[np.ndarray, ...]:
    """A, B, Q, R, S of the error along the reference, of v, and of the command before."""
    a = np.array([[1, after.own, 0], [0, after.decay, 0], [0, 0, 0]])
    b = np.array([[after.given], [1 - after.decay], [1]])
    q, r, s = _costs([weights.along, 0.0], weights.deviation_v, weights.change_v)
    return a, b, q, r, s


def straight_across(weights: Weights, after: Response, v: float) -> tuple[np.ndarray, ...]:
    """A, B, Q, R, S of the error across the reference driven at ``v`` [m/s], of ψ, ω and the command before."""
    way = v * (after.own + after.given)
    a = np.array([[1, way, way * after.own_half, 0], [0, 1, after.own, 0], [0, 0, after.decay, 0], [0, 0, 0, 0]])
    b = np.array([[way * after.given_half], [after.given], [1 - after.decay], [1]])
    q, r, s = _costs([weights.cross, weights.turned, 0.0], weights.deviation_w, weights.change_w)
    return a, b, q, r, s


def _costs(errors: list[float], deviation: float, change: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Q, R and S of the stage cost of some errors, of a command, and of its change from the one before."""
    q, s = np.diag([*errors, change]), np.zeros((len(errors) + 1, 1))
    s[-1] = -change
    return q, np.array([[deviation + change]]), s
