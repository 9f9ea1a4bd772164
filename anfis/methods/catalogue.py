"""The methods of learning by name. Nothing heavy is imported here, so that lists and ``--help`` are quick."""

from typing import NamedTuple


class Listed(NamedTuple):
    """A method's line in the table."""

    title: str  # what the designer's list calls it
    home: str  # "module:class" of a Method, imported when it is first used


METHODS: dict[str, Listed] = {
    "hybrid": Listed("hybrid (Jang)", "anfis.methods.hybrid:Hybrid"),
    "backprop": Listed("gradient descent (Adam)", "anfis.methods.backprop:Backprop"),
    "least-squares": Listed("least squares only", "anfis.methods.least_squares:LeastSquares"),
    "second-order": Listed("Levenberg–Marquardt", "anfis.methods.second_order:SecondOrder"),
}
