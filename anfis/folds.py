"""k-fold cross-validation: how well what is learnt holds on samples that were not learnt from."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from anfis.accuracy import total_rmse
from anfis.data import DataError
from anfis.methods.options import Options
from anfis.state import Epoch
from anfis.training import Training, train
from fuzzy.fitting.clustering import finite_table
from fuzzy.fitting.consequents import output_table
from fuzzy.fitting.folds import FoldOrder, fold_rows
from fuzzy.system import Sugeno

Start = Sugeno | Callable[[np.ndarray, np.ndarray], Sugeno]


@dataclass(frozen=True, eq=False)
class Fold:
    """One of the folds: what was held back, and what the rest taught.

    Attributes:
        held: (held,) int: the rows that were not learnt from, ascending.
        rmse: The error on them, over samples and outputs, in the outputs' unit.
        training: The training of all other rows.
    """

    held: np.ndarray
    rmse: float
    training: Training


@dataclass(frozen=True, eq=False)
class CrossValidation:
    """The errors of all folds, in the outputs' unit.

    Attributes:
        folds: The folds, in their order.
    """

    folds: tuple[Fold, ...]

    @property
    def rmse(self) -> np.ndarray:
        """The error of each fold on the samples that it held back (folds,)."""
        return np.array([fold.rmse for fold in self.folds])

    @property
    def mean(self) -> float:
        """The mean of the folds' errors."""
        return float(self.rmse.mean())

    @property
    def std(self) -> float:
        """The standard deviation between the folds' errors, with folds − 1 in the denominator."""
        return float(self.rmse.std(ddof=1))

    def table(self) -> Any:
        """A row for each fold as a pandas table: the samples held back, both errors, the rules, the last epoch."""
        import pandas as pd

        rows = [
            (k + 1, len(f.held), f.training.rmse, f.rmse, len(f.training.system.rules), f.training.history[-1].epoch)
            for k, f in enumerate(self.folds)
        ]
        return pd.DataFrame(rows, columns=["fold", "held", "train", "rmse", "rules", "epochs"])


def cross_validate(
    start: Start,
    x: Any,
    y: Any,
    options: Options | None = None,
    *,
    folds: int = 5,
    order: FoldOrder = "shuffled",
    seed: int = 0,
    check: tuple[Any, Any] | None = None,
    callback: Callable[[int, Epoch], bool | None] | None = None,
) -> CrossValidation:
    """Train ``folds`` times, each time without one part of the samples, and measure the error on that part.

    What is held back takes no part in a fold's training, not even in the choice of its best epoch; that is what
    ``check`` is for, which are other samples.

    Args:
        start: Makes the system to train from the x (samples, inputs) and y (samples, outputs) that a fold learns from,
            such as ``lambda x, y: fuzzy.identify(x, y, "grid", mfs=3)``; or a system, which must not have been made
            from these data, for then each fold would have seen what it holds back.
        x: The inputs (samples, inputs).
        y: The outputs (samples,) or (samples, outputs).
        options: How to train, as for :func:`anfis.train`.
        folds: How many parts there are, at least 2.
        order: "shuffled", or "blocks" of neighbouring rows for time series, see :func:`fuzzy.fitting.folds.fold_rows`.
        seed: The seed of the shuffling.
        check: Checking data, as for :func:`anfis.train`.
        callback: Sees the number of the fold (from 0) and every epoch of its training, and may return False to stop it.

    Returns:
        The folds, each with its error and its training. The same data, options and seed give the same result.

    Raises:
        FoldError: No folds can be made.
        TrainingError: As of :func:`anfis.train`.
        DataError: As of :func:`anfis.train`.
        KeyboardInterrupt: It is interrupted: some of the folds are not an answer.
    """
    x, y = finite_table(x, "x"), output_table(y)
    if len(x) != len(y):
        raise DataError(f"the training data have {len(x)} rows of inputs but {len(y)} of outputs")
    found = []
    for k, held in enumerate(fold_rows(len(x), folds, order, seed)):
        learnt = np.delete(np.arange(len(x)), held)
        fis: Any = start if hasattr(start, "upper") else start(x[learnt], y[learnt])
        told = None if callback is None else lambda row, k=k: callback(k, row)
        training = train(fis, x[learnt], y[learnt], options, check=check, callback=told)
        if training.stopped == "interrupted":
            raise KeyboardInterrupt
        found.append(Fold(held, total_rmse(training.system, x[held], y[held]), training))
    return CrossValidation(tuple(found))
