"""One problem of predictive control by itself, as a law solves it every period: for benchmarks, tests and questions."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from fuzzy.compiled.jit import kernel
from robotics.laws.predictive.ilqr import (
    AT_END_V,
    COST,
    COUNT,
    FIXED,
    FROM_V,
    NODE,
    NODES,
    PLAN,
    STATE,
    TAIL,
    TAIL_NUMBERS,
    TO_COS,
    TO_HEADING,
    TO_SIN,
    TO_V,
    TO_X,
    V_C,
    solve,
    working,
)
from robotics.laws.predictive.model import response
from robotics.laws.predictive.terminal import Weights


@dataclass(frozen=True, kw_only=True, eq=False)
class Problem:
    """A plan of N periods that is to be found; see :mod:`robotics.laws.predictive.ilqr`."""

    period: float  # s
    lag: float  # s: of the wheels
    weights: Weights
    half_axle: float  # m
    tops: np.ndarray  # (4,) limits of the speed [m/s], of the turn rate [rad/s], of the right and the left wheel [m/s]
    rates: np.ndarray  # (4,) those of their change from one command to the next
    before: np.ndarray  # (2,) m/s, rad/s: the command before the first
    state: np.ndarray  # (5,) x, y [m], heading [rad], v [m/s], ω [rad/s] when the first command begins to act
    to: np.ndarray  # (N, 3) x, y [m], heading [rad]: the reference at the end of every period
    follow: np.ndarray  # (N + 1, 2) m/s, rad/s: the command with which a robot follows it, and that after the last
    end: np.ndarray  # (2,) m/s, rad/s: the reference's velocities at the end
    tail: np.ndarray  # (16,) of the terminal cost
    guess: np.ndarray  # (N, 2) m/s, rad/s: from which the search starts; not-a-number: as the Lyapunov law says

    @property
    def row(self) -> np.ndarray:
        """The numbers that the solver works in, with this problem in them."""
        horizon = len(self.to)
        row = np.zeros(working(horizon))
        row[:FIXED] = [*response(self.period, self.lag), *self.weights, self.half_axle, *self.tops, *self.rates]
        row[FROM_V : FROM_V + 2], row[STATE : STATE + 5] = self.before, self.state
        row[AT_END_V : AT_END_V + 2], row[TAIL : TAIL + TAIL_NUMBERS] = self.end, self.tail
        nodes = row[NODES:].reshape(horizon + 1, NODE)
        nodes[:-1, TO_X : TO_HEADING + 1] = self.to
        nodes[:-1, TO_COS], nodes[:-1, TO_SIN] = np.cos(self.to[:, 2]), np.sin(self.to[:, 2])
        nodes[:, TO_V : TO_V + 2] = self.follow
        nodes[:-1, PLAN + V_C : PLAN + V_C + 2] = self.guess
        return row


class Plans(NamedTuple):
    """The plans that were found for several problems of the same horizon N."""

    cost: np.ndarray  # (problems,)
    iterations: np.ndarray  # (problems,) int
    commands: np.ndarray  # (problems, N, 2) m/s, rad/s
    states: np.ndarray  # (problems, N + 1, 5) x, y [m], heading [rad], v [m/s], ω [rad/s]


def plans_of(problems: Sequence[Problem], iterations: int = 100, tolerance: float = 1e-7) -> Plans:
    """Solve ``problems`` of the same horizon with at most so many ``iterations``.

    A search ends earlier where its quadratic model promises less than ``tolerance`` of the cost.
    """
    rows = np.array([problem.row for problem in problems])
    horizon = len(problems[0].to)
    solve_rows(rows, horizon, iterations, tolerance)
    nodes = rows[:, NODES:].reshape(len(rows), horizon + 1, NODE)
    plan = nodes[..., PLAN : PLAN + V_C + 2]
    return Plans(rows[:, COST], rows[:, COUNT].astype(int), plan[:, :-1, V_C:].copy(), plan[..., :V_C].copy())


@kernel(nogil=True)
def solve_rows(rows, horizon, iterations, tolerance):  # type: ignore[no-untyped-def]
    """Solve the problem of every row in place."""
    for n in range(len(rows)):
        solve(rows[n], horizon, iterations, tolerance)
