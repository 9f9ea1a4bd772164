"""Which inputs a system needs: one after the other is added, by the cross-validated error of what it makes.

Sequential forward search, as MATLAB's ``seqsrch`` does it for ANFIS [Jang 1996],
but judged on samples that were held back, and ended by the one-standard-error rule [Breiman et al. 1984, section
3.4.3]: the fewest inputs whose error is above the least one by no more than one standard error of that.
"""

import warnings
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from fuzzy.errors import InputError
from fuzzy.fitting.clustering import DataWarning
from fuzzy.fitting.consequents import IdentificationError
from fuzzy.fitting.folds import FoldOrder, fold_rows
from fuzzy.inference import InferenceWarning


@dataclass(frozen=True)
class SelectionStep:
    """One input more.

    Attributes:
        inputs: The columns of ``x`` so far, in the order in which they were added.
        error: The cross-validated error: RMSE over samples and outputs, each output in units of its own spread.
        deviation: Its standard error over the folds.
    """

    inputs: tuple[int, ...]
    error: float
    deviation: float


@dataclass(frozen=True)
class InputSelection:
    """The inputs that were added, step by step; ``chosen`` are the columns of ``x`` to take (ascending)."""

    steps: tuple[SelectionStep, ...]
    chosen: tuple[int, ...]


def select_inputs(
    x: Any,
    y: Any,
    make: Callable[[np.ndarray, np.ndarray], Callable[[np.ndarray], Any]],
    *,
    folds: int = 5,
    order: FoldOrder | str = "shuffled",
    most: int | None = None,
    seed: int = 0,
    progress: Callable[[int, int], None] | None = None,
) -> InputSelection:
    """Choose inputs one after the other, each time the one with the least error on held-back samples.

    Args:
        x: The candidates (samples, candidates).
        y: The outputs (samples,) or (samples, outputs).
        make: Makes a system, such as :func:`fuzzy.identify`, or what else is called as one, of some columns of ``x``
            (samples, inputs), in the order in which they were added, and all of ``y`` (samples, outputs).
        folds: Number of folds.
        order: Which rows a fold holds back, see :func:`fuzzy.fitting.folds.fold_rows`.
        most: The most inputs; by default all, or until two more have made the error no less.
        seed: Seed of shuffled folds.
        progress: Called with how many sets of inputs have been tried, and how many there are in this step.

    Returns:
        The steps, and the inputs of the fewest that err as little as the best, within one standard error.

    Raises:
        IdentificationError: No columns, or no set of inputs of which a system can be made.
        FoldError: Folds that cannot be made.
    """
    x, y = np.asarray(x, dtype=float), np.asarray(y, dtype=float)
    y = y.reshape(len(y), -1)
    if x.ndim != 2 or x.shape[1] == 0:
        raise IdentificationError(f"x must be (samples, candidates) with a candidate; got the shape {x.shape}")
    if most is not None and not 1 <= most <= x.shape[1]:
        raise IdentificationError(f"most must be from 1 to the number of candidates, {x.shape[1]}; got {most}")
    held = fold_rows(len(x), folds, order, seed)
    spread = spread_of(y)
    steps: list[SelectionStep] = []
    while len(steps) < (most or x.shape[1]):
        taken = steps[-1].inputs if steps else ()
        left = [k for k in range(x.shape[1]) if k not in taken]
        tried = []
        for n, k in enumerate(left, 1):
            errors = held_back_error(x[:, [*taken, k]], y / spread, held, make)
            if errors is not None:
                tried.append(SelectionStep((*taken, k), *errors))
            if progress is not None:
                progress(n, len(left))
        if not tried:
            break
        steps.append(min(tried, key=lambda step: step.error))
        best = min(range(len(steps)), key=lambda k: steps[k].error)
        if most is None and len(steps) > best + 2:
            break
    if not steps:
        raise IdentificationError("of no single input a system can be made: give more samples, or other settings")
    best_step = min(steps, key=lambda step: step.error)
    chosen = next(step for step in steps if step.error <= best_step.error + best_step.deviation)
    return InputSelection(tuple(steps), tuple(sorted(chosen.inputs)))


def spread_of(y: np.ndarray) -> np.ndarray:
    """The standard deviation of each output (outputs,) of ``y`` (samples, outputs); 1 for one that is constant."""
    return np.where(np.ptp(y, axis=0) > 0, y.std(axis=0), 1.0)


def held_back_error(
    x: np.ndarray,
    y: np.ndarray,
    held: list[np.ndarray],
    make: Callable[[np.ndarray, np.ndarray], Callable[[np.ndarray], Any]],
) -> tuple[float, float] | None:
    """The root of the mean over folds of the mean square error, with its standard error; None: no system comes.

    Args:
        x: The inputs (samples, inputs).
        y: The outputs (samples, outputs).
        held: The rows that each fold holds back.
        make: Makes a system of the samples that are left.
    """
    squares = []
    for rows in held:
        rest = np.setdiff1d(np.arange(len(x)), rows)
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", DataWarning)
            warnings.simplefilter("ignore", InferenceWarning)
            try:
                said = make(x[rest], y[rest])(x[rows])
            except InputError:
                return None
        squares.append(float(np.mean((said - y[rows]) ** 2)))
    error = float(np.sqrt(np.mean(squares)))
    return error, float(np.std(squares, ddof=1) / np.sqrt(len(squares)) / (2 * error)) if error > 0 else 0.0
