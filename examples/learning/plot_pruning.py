"""
How many rules?
===============

A grid has too many rules. Pruning takes away those that contribute least, and data that have not taught say
when to stop.
"""

import numpy as np

import anfis
import fuzzy

rng = np.random.default_rng(1)
x = rng.uniform(-1, 1, (240, 2))
y = np.sin(3 * x[:, 0]) * x[:, 1] + 0.05 * rng.normal(size=240)
pruned = anfis.prune(
    fuzzy.identify(x, y, "grid", mfs=5), x[:160], y[:160], anfis.Options(epochs=5), check=(x[160:], y[160:])
)
figure = anfis.plot_pruning(pruned)
