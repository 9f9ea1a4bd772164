"""How well a system's outputs agree with data."""

import warnings
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from fuzzy.inference import InferenceWarning, forgiving
from fuzzy.system import Sugeno

if TYPE_CHECKING:
    from fuzzy import Type2Sugeno

_PORTION = 50_000  # samples inferred together: their memory stays small


class Accuracy(NamedTuple):
    """The errors of one output over some samples, all but ``r2`` in the output's unit."""

    rmse: float  # root mean square error
    mae: float  # mean absolute error
    max: float  # largest absolute error
    r2: float  # coefficient of determination: 1 minus squared errors over squared deviations from the mean


def accuracy(fis: "Sugeno | Type2Sugeno", x: np.ndarray, y: np.ndarray) -> dict[str, Accuracy]:
    """The accuracy of every output of ``fis``, by name, at ``x`` (samples, inputs) against ``y`` (samples, outputs).

    ``r2`` is not-a-number for an output that is constant in the data.
    """
    error = fis(x) - y
    spread = ((y - y.mean(axis=0)) ** 2).sum(axis=0)
    return {
        variable.name: Accuracy(
            float(np.sqrt(np.mean(error[:, k] ** 2))),
            float(np.mean(np.abs(error[:, k]))),
            float(np.max(np.abs(error[:, k]))),
            float(1 - (error[:, k] ** 2).sum() / spread[k]) if spread[k] > 0 else float("nan"),
        )
        for k, variable in enumerate(fis.outputs)
    }


def total_rmse(fis: "Sugeno | Type2Sugeno", x: Any, y: Any) -> float:
    """The root mean square error over samples and outputs, as learning counts it, of the numbers that ``fis`` holds.

    ``x`` is (samples, inputs), ``y`` (samples, outputs); both may lie on disk. Where no rule fires the middle of the
    output's range stands. Nothing is said of inputs outside their universes.
    """
    total = 0.0
    fis = forgiving(fis, "midrange")
    with np.errstate(all="ignore"), warnings.catch_warnings(action="ignore", category=InferenceWarning):
        for start in range(0, len(x), _PORTION):
            rows = slice(start, start + _PORTION)
            output = np.asarray(fis(np.asarray(x[rows])))
            total += float(np.sum((output - np.asarray(y[rows])) ** 2))
    return float((total / (len(x) * len(fis.outputs))) ** 0.5)
