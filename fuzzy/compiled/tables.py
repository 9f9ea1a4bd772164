"""A Sugeno system as arrays, for :mod:`fuzzy.compiled.kernel`, and the arrays that it works in."""

from typing import NamedTuple

import numpy as np

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


class Tables(NamedTuple):
    """A system as arrays. The terms of all inputs are numbered in one sequence."""

    low: np.ndarray  # (inputs,) float: ends of the universe of discourse
    high: np.ndarray  # (inputs,) float
    clip: bool  # are inputs clipped to their universe?
    kind: np.ndarray  # (terms,) int: the membership function's number, of NUMBERS
    parameters: np.ndarray  # (terms, 4) float: those of the function's class in their order, filled up with 0
    place: np.ndarray  # (terms,) int: the term's input
    logarithmic: bool  # are firing strengths sums of logarithms?
    clause: np.ndarray  # (rules, inputs) int: the term's number, or -1 where the rule leaves the input out
    negated: np.ndarray  # (rules, inputs) bool
    power: np.ndarray  # (rules, inputs) float
    is_or: np.ndarray  # (rules,) bool
    weight: np.ndarray  # (rules,) float
    and_min: bool  # "and" is the minimum, otherwise the product
    or_max: bool  # "or" is the maximum, otherwise the probabilistic or
    takes_part: np.ndarray  # (outputs, rules) bool: has the rule a consequent for the output?
    constant: np.ndarray  # (outputs, rules) float: the consequents, 0 where there is none
    slopes: np.ndarray  # (outputs, rules, inputs) float
    linear: np.ndarray  # (outputs,) bool: has the output any first-order consequent?
    weighted_sum: bool  # wtsum, otherwise wtaver
    default: np.ndarray  # (outputs,) float: the value where no rule fires


class Workspace(NamedTuple):
    """The rows that a block is computed in. What they hold beforehand does not matter."""

    x: np.ndarray  # (inputs, lanes)
    degree: np.ndarray  # (terms, lanes): degrees of membership, or their logarithms
    firing: np.ndarray  # (rules, lanes): firing strengths w, or their logarithms
    weights: np.ndarray  # (rules, lanes): w / Σ w
    firing_flat: np.ndarray  # the same memory as one row
    weights_flat: np.ndarray
    scale: np.ndarray  # (max(rules, 1) * lanes,)
    bits: np.ndarray  # the same memory as int64
    row: np.ndarray  # (2, lanes)
    output: np.ndarray  # (outputs, lanes)
    missing: np.ndarray  # (outputs, lanes) bool: does no rule fire, although the inputs are known?
