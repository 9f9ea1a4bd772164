"""ANFIS: learning a Sugeno system from data. The network *is* the system; this package holds only the learning.

>>> import anfis, fuzzy
>>> x = [[0.0], [0.25], [0.5], [0.75], [1.0]]
>>> start = fuzzy.identify(x, [0.0, 1.0, 0.0, -1.0, 0.0], "grid", mfs=3, order=0)
>>> trained = anfis.train(start, x, [0.0, 1.0, 0.0, -1.0, 0.0], anfis.Options(epochs=20))
>>> trained.history[trained.best].train < trained.history[0].train
True

Each name is imported from its module when it is first used, so that the command line starts quickly.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from anfis.consequents import Recursive, recursive_start, recursive_step
    from anfis.data import DataError, DataWarning
    from anfis.estimator import ANFISRegressor
    from anfis.methods.catalogue import METHODS
    from anfis.methods.options import Options, TrainingError
    from anfis.plot import plot_fit, plot_premises, plot_training
    from anfis.state import Epoch
    from anfis.training import Training, train

_MODULES = {
    "anfis.consequents": ("Recursive", "recursive_start", "recursive_step"),
    "anfis.data": ("DataError", "DataWarning"),
    "anfis.estimator": ("ANFISRegressor",),
    "anfis.methods.catalogue": ("METHODS",),
    "anfis.methods.options": ("Options", "TrainingError"),
    "anfis.plot": ("plot_fit", "plot_premises", "plot_training"),
    "anfis.state": ("Epoch",),
    "anfis.training": ("Training", "train"),
}
_HOME = {name: module for module, names in _MODULES.items() for name in names}


def __getattr__(name: str) -> Any:
    if name in _HOME:
        return getattr(import_module(_HOME[name]), name)
    raise AttributeError(f"module 'anfis' has no attribute {name!r}")


__all__ = [
    "METHODS",
    "ANFISRegressor",
    "DataError",
    "DataWarning",
    "Epoch",
    "Options",
    "Recursive",
    "Training",
    "TrainingError",
    "plot_fit",
    "plot_premises",
    "plot_training",
    "recursive_start",
    "recursive_step",
    "train",
]
