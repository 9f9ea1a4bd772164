"""Hybrid learning: least squares for the consequents, a gradient step for the premises   [Jang 1993]."""

from collections.abc import Sequence
from itertools import pairwise
from typing import Any

from anfis.methods.method import LearningProblem, Method
from anfis.methods.options import Options
from anfis.point import Array, Point
from anfis.state import TrainingState


class Hybrid(Method):
    """A step of given length down the gradient of the squared error, the consequents solved at both ends."""

    reads = ("step", "increase", "decrease", "ridge", "batch")
    gradient = True
    compiled = True

    def first_step(self, options: Options) -> float:
        """The length of the first step, in units of the universes."""
        return options.step

    def remembers(self, problem: LearningProblem, point: Point, memory: dict[str, Any]) -> bool:
        """Whether a gradient is there, of the shapes of the premises."""
        gradient = memory.get("gradient")
        return isinstance(gradient, list) and [g.shape for g in gradient] == [p.shape for p in point.free]

    def advance(self, problem: LearningProblem, state: TrainingState) -> TrainingState | None:
        """One step of Jang's length; None where the gradient is 0."""
        gradient: list[Array] = state.memory["gradient"]
        norm = sum(float((g * g).sum()) for g in gradient) ** 0.5
        if not norm > 0:
            return None
        recent = state.history[-6:]  # more than these the rules do not look at
        errors, steps = [row.train for row in recent], [row.step for row in recent]
        step = jang_step(errors, steps, problem.options.increase, problem.options.decrease)
        free = [p - step * g / norm for p, g in zip(state.point.free, gradient, strict=True)]
        point = state.point._replace(free=problem.network.premises.valid(free))
        return state._replace(point=point, epoch=state.epoch + 1, step=step)


def jang_step(errors: Sequence[float], steps: Sequence[float], increase: float, decrease: float) -> float:
    """The length of the next step by Jang's two rules   [Jang 1993, section III].

    The step grows by the factor ``increase`` after four reductions of the error in a row, and shrinks by ``decrease``
    after two combinations of one increase and one reduction in a row. ``errors`` and ``steps`` are those of all epochs
    so far, the present one last; epochs before the last change of the step do not count again.
    """
    step = steps[-1]
    changed = max((k for k in range(1, len(steps)) if steps[k] != steps[k - 1]), default=1)
    counted = errors[changed - 1 :]  # the change was decided at the first of these
    if len(counted) < 5:
        return step
    last = list(pairwise(counted[-5:]))
    if all(b < a for a, b in last):
        return step * increase
    if [b > a for a, b in last] == [True, False, True, False] and all(a != b for a, b in last):
        return step * decrease
    return step
