"""Least squares: the consequents only, once; the premises stay as they are."""

from typing import TYPE_CHECKING

from anfis.methods.method import LearningProblem, Method
from anfis.point import Point
from anfis.state import TrainingState

if TYPE_CHECKING:
    from anfis.compiled.network import CompiledNetwork
    from anfis.network import Network


class LeastSquares(Method):
    """The consequents that fit best, without a step."""

    reads = ("ridge", "batch")
    compiled = True
    once = True

    def start(self, network: "Network | CompiledNetwork") -> Point:
        """The system's own premises to the last bit, legal for learning or not."""
        return network.start()._replace(free=network.premises.start())

    def advance(self, problem: LearningProblem, state: TrainingState) -> TrainingState | None:
        """No step: the consequents are solved already."""
        return None
