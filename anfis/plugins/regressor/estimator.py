"""ANFIS as a scikit-learn regressor. Importing this module imports scikit-learn, which is an optional extra."""

from dataclasses import KW_ONLY, dataclass, fields
from typing import Any

import numpy as np

from anfis.methods.options import Options
from anfis.training import train
from fuzzy.errors import InputError
from fuzzy.extras import install_command
from fuzzy.fitting.identification import identify
from fuzzy.naming import expected
from fuzzy.system import Sugeno


class EstimatorError(InputError):
    """Settings that make no estimator, or scikit-learn is missing. The message says what is accepted."""


try:
    from sklearn.base import BaseEstimator, RegressorMixin
    from sklearn.utils import check_random_state
    from sklearn.utils.validation import check_is_fitted, validate_data
except ImportError as error:
    raise EstimatorError(
        f"ANFISRegressor needs scikit-learn 1.6 or newer ({error}): {install_command('sklearn')}"
    ) from None

_STARTS = ("subtractive", "grid")


@dataclass(eq=False, repr=False)  # scikit-learn compares and shows estimators its own way
class ANFISRegressor(RegressorMixin, BaseEstimator):
    """A Sugeno system identified from the data and trained by :func:`anfis.train`.

    Fitted: ``system_`` (:class:`fuzzy.Sugeno`), ``training_`` (:class:`anfis.Training`), ``n_iter_``,
    ``n_features_in_``, ``feature_names_in_``. A column's name is its input's, ``x1`` ... without names. An input
    outside the data's range is not clipped: the linear consequents go on.

    Args:
        start: "subtractive" (clusters), "grid", or a :class:`fuzzy.Sugeno`, whose inputs and outputs are the columns in
            their order and units.
        radius: Of clusters, a share of the ranges.
        mfs: Of a grid: terms an input, one number or one for each.
        kind: Of a grid: the membership function by MATLAB's name.
        order: Of the consequents: 1 linear, 0 constant.
        method: As of :class:`anfis.Options`, as are the following up to ``keep_order``.
        epochs: The most epochs.
        step: Hybrid: the length of the first premise step, in units of the universes.
        rate: Backprop: its learning rate.
        patience: Epochs without a new least error after which it stops; 0: never.
        goal: The error at which it stops, in the outputs' unit.
        ridge: Of the least squares, without a unit.
        batch: Backprop: samples a step; 0: all.
        keep_order: Whether memberships of an input stay ordered and covering.
        validation_fraction: In (0, 1): that share of the samples is not learnt from, and the system of least error on
            it is kept; 0: none.
        random_state: Chooses these samples, and orders mini-batches.
    """

    start: Any = "subtractive"
    _: KW_ONLY
    radius: Any = 0.5
    mfs: Any = 2
    kind: Any = "gaussmf"
    order: int = 1
    method: str = "hybrid"
    epochs: int = 10
    step: float = 0.01
    rate: float = 0.01
    patience: int = 0
    goal: float = 0.0
    ridge: float = 0.0
    batch: int = 0
    keep_order: bool = False
    validation_fraction: float = 0.0
    random_state: Any = None

    def __sklearn_tags__(self) -> Any:
        tags = super().__sklearn_tags__()
        tags.target_tags.multi_output = True
        return tags

    def fit(self, X: Any, y: Any) -> "ANFISRegressor":
        """Learn from ``X`` (samples, features) and ``y`` (samples,) or (samples, outputs).

        Returns:
            The estimator itself.

        Raises:
            EstimatorError: Settings that cannot be used.
            ValueError: Data that cannot be learnt from.
        """
        names = _names_of(y)
        X, y = validate_data(self, X, y, dtype=np.float64, multi_output=True, y_numeric=True, ensure_min_samples=2)
        targets = np.asarray(y, dtype=np.float64).reshape(len(X), -1)
        random = check_random_state(self.random_state)
        given = {f.name: getattr(self, f.name) for f in fields(Options) if hasattr(self, f.name)}
        options = Options(**given, seed=int(random.randint(2**31 - 1)))
        learnt, held = self._split(len(X), random)
        fis = self._start(X[learnt], targets[learnt], names)
        check = (X[held], targets[held]) if len(held) else None
        self.training_ = train(fis, X[learnt], targets[learnt], options, check=check)
        self.system_ = self.training_.system
        self.n_iter_ = len(self.training_.history)
        self._flat = np.ndim(y) == 1
        return self

    def predict(self, X: Any) -> np.ndarray:
        """The outputs, (samples,) or (samples, outputs) as ``y`` was, at ``X`` (samples, features)."""
        check_is_fitted(self)
        X = validate_data(self, X, dtype=np.float64, reset=False)
        found = np.asarray(self.system_(X))
        return found[:, 0] if self._flat else found

    def _split(self, count: int, random: np.random.RandomState) -> tuple[np.ndarray, np.ndarray]:
        """The rows to learn from, and those held back."""
        share = self.validation_fraction
        if not (isinstance(share, (int, float)) and 0 <= share < 1):
            raise EstimatorError(f"validation_fraction must be in [0, 1), got {share!r}")
        if not share:
            return np.arange(count), np.arange(0)
        size = max(1, round(share * count))
        if count - size < 2:
            raise EstimatorError(f"validation_fraction {share!r} leaves less than 2 of {count} samples to learn from")
        rows = random.permutation(count)
        return np.sort(rows[size:]), np.sort(rows[:size])

    def _start(self, X: np.ndarray, y: np.ndarray, names: list[str] | None) -> Sugeno:
        if isinstance(self.start, Sugeno):
            return self.start
        if not isinstance(self.start, str) or self.start not in _STARTS:
            raise EstimatorError(expected(str(self.start), _STARTS, "start") + ", or a fuzzy.Sugeno")
        columns = getattr(self, "feature_names_in_", None)
        inputs = [f"x{i + 1}" for i in range(X.shape[1])] if columns is None else [str(name) for name in columns]
        outputs = names or (["y"] if y.shape[1] == 1 else [f"y{j + 1}" for j in range(y.shape[1])])
        settings = {"radius": self.radius} if self.start == "subtractive" else {"mfs": self.mfs, "kind": self.kind}
        fis = identify(
            X,
            y,
            self.start,  # type: ignore[arg-type]
            input_names=inputs,
            output_names=outputs,
            name="anfis",
            order=self.order,  # type: ignore[arg-type]
            fit=False,
            **settings,
        )
        return Sugeno(fis.inputs, fis.outputs, fis.rules, fis.name, out_of_range="ignore")


def _names_of(y: Any) -> list[str] | None:
    """The names of a pandas (or like) table's or column's, None without."""
    if hasattr(y, "columns"):
        return [str(name) for name in y.columns]
    name = getattr(y, "name", None)
    return None if name is None else [str(name)]
