"""How well a system's outputs agree with data."""

from typing import NamedTuple

import numpy as np

from fuzzy.system import Sugeno


class Accuracy(NamedTuple):
    """The errors of one output over some samples, all but ``r2`` in the output's unit."""

    rmse: float  # root mean square error
    mae: float  # mean absolute error
    max: float  # largest absolute error
    r2: float  # coefficient of determination: 1 minus squared errors over squared deviations from the mean


def accuracy(fis: Sugeno, x: np.ndarray, y: np.ndarray) -> dict[str, Accuracy]:
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
