"""Least squares: the consequents only, once; the premises stay as they are."""

from anfis.methods.method import Method, Problem
from anfis.network import Network, Point
from anfis.state import State


class LeastSquares(Method):
    """The consequents that fit best, without a step."""

    reads = ("ridge", "batch")
    once = True

    def start(self, network: Network) -> Point:
        """The system's own premises to the last bit, legal for learning or not."""
        return network.start()._replace(free=network.premises.start())

    def advance(self, problem: Problem, state: State) -> State | None:
        """No step: the consequents are solved already."""
        return None
