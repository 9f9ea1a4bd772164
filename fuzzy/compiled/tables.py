"""The numbers by which the compiled inference knows the membership functions."""

from collections import namedtuple
from typing import Any

from fuzzy import membership as mf
from fuzzy.membershipfunction import MembershipFunction

_EDGES = (mf.Triangle, mf.Trapezoid, mf.LinearS, mf.LinearZ, mf.SShape, mf.ZShape, mf.PiShape, mf.SigmoidDifference)
# With a logarithm: the Gaussian is the first of them.
_SMOOTH = (mf.Gaussian, mf.TwoSidedGaussian, mf.Bell, mf.Sigmoid, mf.SigmoidProduct)
NUMBERS: dict[type[MembershipFunction], int] = {  # those that the kernel knows
    function: number for number, function in enumerate((*_EDGES, *_SMOOTH))
}
_NAMES = {f.__name__: number for f, number in NUMBERS.items()} | {"Sampled": -2}  # the last: every other function
KIND: Any = namedtuple("Kind", _NAMES)(**_NAMES)  # the same by name
READ_STEPS = 4096  # steps of its universe in which such a function is read
LEAST_STRENGTH = 1e-300  # of a firing strength of type-2: a weaker one is 0, for a product with it has too few digits
