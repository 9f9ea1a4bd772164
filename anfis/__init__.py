"""ANFIS: learning a Sugeno system from data. The network *is* the system; this package holds only the learning.

>>> import anfis, fuzzy
>>> x = [[0.0], [0.25], [0.5], [0.75], [1.0]]
>>> start = fuzzy.identify(x, [0.0, 1.0, 0.0, -1.0, 0.0], "grid", mfs=3, order=0)
>>> trained = anfis.train(start, x, [0.0, 1.0, 0.0, -1.0, 0.0], anfis.Options(epochs=20))
>>> trained.history[trained.best].train < trained.history[0].train
True

Learn:
    train with Options and one of METHODS, a Training comes back; ANFISRegressor, the same for scikit-learn
    cross_validate, a CrossValidation comes back; prune, a Pruned
Learn as samples come:
    recursive_start, recursive_step, Recursive
Look:
    plot_training, plot_fit, plot_premises, plot_pruning

Each name is imported from its module when it is first used, so that the command line starts quickly.
"""

from fuzzy.lazynames import lazy_names

TYPE_CHECKING = False  # type checkers take it as true by its name; importing typing would double the time

if TYPE_CHECKING:
    from anfis.consequents import Recursive, recursive_start, recursive_step
    from anfis.data import DataError, DataWarning
    from anfis.estimator import ANFISRegressor
    from anfis.folds import CrossValidation, Fold, cross_validate
    from anfis.methods.catalogue import METHODS
    from anfis.methods.options import Options, TrainingError
    from anfis.plot import plot_fit, plot_premises, plot_pruning, plot_training
    from anfis.pruning import Pruned, PruningStep, prune
    from anfis.state import Epoch
    from anfis.training import Training, train

_HOMES = {
    "anfis.consequents": (
        "Recursive",
        "recursive_start",
        "recursive_step",
    ),
    "anfis.data": (
        "DataError",
        "DataWarning",
    ),
    "anfis.estimator": ("ANFISRegressor",),
    "anfis.folds": (
        "CrossValidation",
        "Fold",
        "cross_validate",
    ),
    "anfis.methods.catalogue": ("METHODS",),
    "anfis.methods.options": (
        "Options",
        "TrainingError",
    ),
    "anfis.plot": (
        "plot_fit",
        "plot_premises",
        "plot_pruning",
        "plot_training",
    ),
    "anfis.pruning": (
        "Pruned",
        "PruningStep",
        "prune",
    ),
    "anfis.state": ("Epoch",),
    "anfis.training": (
        "Training",
        "train",
    ),
}
if not TYPE_CHECKING:  # a type checker has the names above, and sees which there are not
    __getattr__, __dir__ = lazy_names(__name__, _HOMES)

__all__ = [
    "METHODS",
    "ANFISRegressor",
    "CrossValidation",
    "DataError",
    "DataWarning",
    "Epoch",
    "Fold",
    "Options",
    "Pruned",
    "PruningStep",
    "Recursive",
    "Training",
    "TrainingError",
    "cross_validate",
    "plot_fit",
    "plot_premises",
    "plot_pruning",
    "plot_training",
    "prune",
    "recursive_start",
    "recursive_step",
    "train",
]
