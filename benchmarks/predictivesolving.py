"""One problem of predictive control by itself, as a law solves it every period."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from fuzzy.compiled.jit import kernel
from robotics.plugins.predictive.ilqr import NODE, FixedColumns, PeriodColumns, SolverColumns, solve, working
from robotics.plugins.predictive.model import response
from robotics.plugins.predictive.terminal import Weights
from robotics.world.vehicle.plant import MotionColumns


@dataclass(frozen=True, kw_only=True, eq=False)
class Problem:
    """A plan of N periods that is to be found; see :mod:`robotics.plugins.predictive.ilqr`."""

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
    tail: np.ndarray  # (TAIL,) of the terminal cost
    guess: np.ndarray  # (N, 2) m/s, rad/s: from which the search starts; not-a-number: as the Lyapunov law says
    discs: Sequence[Sequence[float]] = ()  # x, y [m], v_x, v_y [m/s], radius [m] of each that it keeps out of
    disc_weight: float = 0.0  # 1/m²

    @property
    def row(self) -> np.ndarray:
        """The numbers that the solver works in, with this problem in them."""
        work = SolverColumns(np.zeros(working(len(self.to))))
        fixed = {"after": response(self.period, self.lag), "weights": self.weights, "half_axle": self.half_axle}
        fixed |= {"tops": self.tops, "rates": self.rates}
        work.fixed = FixedColumns(np.array(FixedColumns.stacked(fixed)))
        work.state = MotionColumns(self.state)
        (work.before_v, work.before_w), (work.end_v, work.end_w) = self.before, self.end
        work.tail[:] = self.tail
        work.around.count, work.around.weight = len(self.discs), self.disc_weight
        work.around.discs[: 5 * len(self.discs)] = np.ravel(self.discs)
        node = _nodes(work)
        to, plan = node.to, node.plan
        to.x[:-1], to.y[:-1], to.heading[:-1] = self.to.T
        to.cos[:-1], to.sin[:-1] = np.cos(self.to[:, 2]), np.sin(self.to[:, 2])
        to.v, to.w = self.follow.T
        plan.v_c[:-1], plan.w_c[:-1] = self.guess.T
        return work.array


def _nodes(work: SolverColumns) -> PeriodColumns:
    """The periods that a problem, or several, is solved in: each column is (..., periods)."""
    numbers = work.nodes
    return PeriodColumns(np.moveaxis(numbers.reshape(-1, NODE, *numbers.shape[1:]), 0, -1))


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
    work = SolverColumns(rows.T)
    plan = _nodes(work).plan
    states = np.stack([plan.x, plan.y, plan.heading, plan.v, plan.w], axis=-1)
    commands = np.stack([plan.v_c, plan.w_c], axis=-1)[:, :-1]
    return Plans(work.cost, work.count.astype(int), commands, states)


@kernel(nogil=True)
def solve_rows(rows, horizon, iterations, tolerance):  # type: ignore[no-untyped-def]
    """Solve the problem of every row in place."""
    for n in range(len(rows)):
        solve(SolverColumns(rows[n]), horizon, iterations, tolerance)
