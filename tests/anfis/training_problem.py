"""A small problem to learn from, shared by the tests of training."""

import warnings
from dataclasses import replace
from typing import Literal

import numpy as np

import fuzzy
from fuzzy.inference import InferenceWarning

RNG = np.random.default_rng(11)
X = RNG.uniform([-1, 10], [3, 30], (80, 2))
Y = np.sin(X[:, 0]) + 0.002 * X[:, 1] ** 2 + 0.02 * RNG.normal(size=80)
CHECK = X[:30] + 0.1, Y[:30]
TRAINED = ("hybrid", "backprop", "second-order")


def grid(x: np.ndarray, kind: str = "gaussmf", mfs: int = 2, order: Literal[0, 1] = 1, **choices) -> fuzzy.Sugeno:
    """A grid over ``x``, all consequents 0."""
    return replace(
        fuzzy.identify(x, np.linspace(-1, 2, len(x)), "grid", mfs=mfs, kind=kind, order=order, fit=False), **choices
    )


def rmse(fis: fuzzy.Sugeno, x: np.ndarray, y: np.ndarray) -> float:
    """Root mean square error over samples and outputs, without a warning."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", InferenceWarning)
        return float(np.sqrt(np.mean((fis(x) - y.reshape(len(x), -1)) ** 2)))


FIS = grid(X)
