"""The folds of a cross-validation: which rows each one holds back."""

from typing import Literal, get_args

import numpy as np

from fuzzy.errors import InputError
from fuzzy.naming import check_known

FoldOrder = Literal["shuffled", "blocks"]
FOLD_ORDERS: tuple[str, ...] = get_args(FoldOrder)


class FoldError(InputError):
    """The error for folds that cannot be made."""


def fold_rows(samples: int, folds: int, order: FoldOrder | str = "shuffled", seed: int = 0) -> list[np.ndarray]:
    """The rows (held,) that each fold holds back: every row once, ascending, sizes that differ by 1 at most.

    With the order "blocks" they are contiguous, which a time series needs: of a shuffled one the neighbours in time of
    what is held back are learnt from. They are then those of scikit-learn's ``KFold(folds)``. ``seed`` is that of the
    shuffling. Raises FoldError for a number of folds below 2 or above that of the samples, and for another order.
    """
    check_known(order, FOLD_ORDERS, "fold order", FoldError)
    if isinstance(folds, bool) or not isinstance(folds, (int, np.integer)) or not 2 <= folds <= samples:
        raise FoldError(f"folds must be a whole number from 2 to the number of samples ({samples}), got {folds!r}")
    rows = np.arange(samples) if order == "blocks" else np.random.default_rng(seed).permutation(samples)
    return [np.sort(part) for part in np.array_split(rows, folds)]
