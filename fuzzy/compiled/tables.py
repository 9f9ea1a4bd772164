"""The numbers by which the compiled inference knows the membership functions."""

from fuzzy import membership as mf
from fuzzy.membershipfunction import MembershipFunction

NUMBERS: dict[type[MembershipFunction], int] = {}  # of the membership functions that the kernel has a branch for


def _number(function: type[MembershipFunction]) -> int:
    """Give the next number to a membership function that the kernel has a branch for."""
    return NUMBERS.setdefault(function, len(NUMBERS))


# Of straight lines and parabolas.
TRIANGLE, TRAPEZOID, LINEAR_S, LINEAR_Z = map(_number, (mf.Triangle, mf.Trapezoid, mf.LinearS, mf.LinearZ))
S_SHAPE, Z_SHAPE, PI_SHAPE = map(_number, (mf.SShape, mf.ZShape, mf.PiShape))
SIGMOID_DIFFERENCE = _number(mf.SigmoidDifference)
# With a logarithm: the Gaussian is the first of them.
GAUSSIAN, TWO_SIDED_GAUSSIAN, BELL = map(_number, (mf.Gaussian, mf.TwoSidedGaussian, mf.Bell))
SIGMOID, SIGMOID_PRODUCT = map(_number, (mf.Sigmoid, mf.SigmoidProduct))
