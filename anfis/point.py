"""Where learning is, and what a fit there finds: numpy arrays in compiled learning, torch tensors otherwise."""

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

Array = Any  # numpy.ndarray or torch.Tensor


class Point(NamedTuple):
    """The numbers that are learnt, as learning holds them."""

    free: tuple[Array, ...]  # the premises, see :class:`anfis.premises.Premises`
    values: list[Array]  # the consequents in scaled units, (parameters, outputs) a group


class Solution(NamedTuple):
    """Least-squares consequents, and how well they are determined."""

    values: Array  # (parameters, outputs)
    rank: int


class PointFit(NamedTuple):
    """The least-squares consequents for given premises, and the error that they leave."""

    solutions: list[Solution]  # one a group
    rmse: float  # over samples and outputs
    gradient: Sequence[Array] | None  # of the sum of squares, to the free premises


def numbers(array: Array) -> np.ndarray:
    """The numbers of an array of either library, in double precision."""
    return np.asarray(array.detach().cpu() if hasattr(array, "detach") else array, dtype=np.float64)
