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
Know how sure it is:
    calibrate, a Conformal comes back, which gives a PredictionInterval
Learn as samples come:
    recursive_start, recursive_step, Recursive
Look:
    plot_training, plot_fit, plot_premises, plot_pruning

Each name is imported from its module when it is first used, so that the command line starts quickly.
"""

import _fuzzyfleet

_fuzzyfleet.check()

from fuzzy.lazynames import lazy_names  # noqa: E402
from fuzzy.renamed import redirect  # noqa: E402

__getattr__, __dir__, __all__ = lazy_names(__name__)
redirect({"anfis.designer": "anfis.plugins.designer", "anfis.estimator": "anfis.plugins.regressor.estimator"})
