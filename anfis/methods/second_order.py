"""Second-order learning: the premises by Levenberg-Marquardt on the reduced cost, consequents eliminated.

The consequents are those of least squares everywhere, so the cost depends on the premises only: variable projection
[Golub & Pereyra 2003], with Kaufman's approximation of the Jacobian.
"""

import numpy as np

from anfis.methods.method import LearningProblem, Method
from anfis.methods.options import Options
from anfis.point import Point, numbers
from anfis.state import TrainingState

_DAMPING = 0.1  # of the first step, relative to the diagonal of Jᵀ J
_LEAST = 3e-2  # of the diagonal's largest element: what counts at least, so that no parameter is let loose
_GROWTH = 2.0  # of the damping after a step that failed
_TRIALS = 32  # dampings tried for one step


class SecondOrder(Method):
    """A Levenberg-Marquardt step that makes the error less; its step size is the damping."""

    reads = ("ridge", "batch")
    compiled = True

    def first_step(self, options: Options) -> float:
        """The first damping, without a unit."""
        return _DAMPING

    def advance(self, problem: LearningProblem, state: TrainingState) -> TrainingState | None:
        """One accepted step; the damping grows until there is one. None where none helps.

        After it the damping falls, or grows, by how much of the reduction that the Jacobian promises has come true
        [Nielsen 1999].
        """
        network = problem.network
        jtj, jtr = (numbers(part) for part in network.reduced(state.point, problem.data))
        # Marquardt's scaling, but no parameter is let loose just because the error hardly depends on it yet.
        diagonal = jtj.diagonal()
        if not float(diagonal.max()) > 0:
            return None  # the error does not depend on the premises
        scale = np.diag(np.maximum(diagonal, max(_LEAST * float(diagonal.max()), np.finfo(np.float64).tiny)))
        damping, present = state.step, state.history[-1].train
        count = problem.data.count * len(network.fis.outputs)
        flat = np.concatenate([numbers(p).ravel() for p in state.point.free])
        for _ in range(_TRIALS):
            step = _solved(jtj + damping * scale, jtr)
            if step is None:
                damping *= _GROWTH
                continue
            free = network.premises.valid(network.unflatten(network.array(flat + step)))
            fit = network.fit(free, problem.data)
            if fit.rmse < present:
                point = Point(free, [solution.values for solution in fit.solutions])
                promised = float(step @ (2 * jtr - jtj @ step))
                found = (present - fit.rmse) * (present + fit.rmse) * count
                damping *= _change(found / promised) if promised > 0 else 1.0
                return state._replace(point=point, epoch=state.epoch + 1, step=max(damping, 1e-12))
            damping *= _GROWTH
        return None


def _change(gain: float) -> float:
    """The factor of the damping after a step with that share of the promised reduction   [Nielsen 1999]."""
    return max(1 / 3, 1 - (2 * gain - 1) ** 3)


def _solved(matrix: np.ndarray, target: np.ndarray) -> np.ndarray | None:
    """The solution of the linear equations, if there is one of finite numbers."""
    try:
        found = np.linalg.solve(matrix, target)
    except np.linalg.LinAlgError:
        return None
    return found if np.isfinite(found).all() else None
