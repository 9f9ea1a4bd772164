"""The methods of learning by name. Nothing heavy is imported here, so that lists and ``--help`` are quick."""

from importlib import import_module
from typing import TYPE_CHECKING, NamedTuple

if TYPE_CHECKING:
    from anfis.methods.method import Method


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


def make_method(name: str) -> "Method":
    """The method called ``name``, one of METHODS (KeyError otherwise)."""
    module, _, kind = METHODS[name].home.partition(":")
    method: Method = getattr(import_module(module), kind)()
    return method
