"""
How many rules?
===============

A grid has too many rules. Pruning takes away those that contribute least, and the rest learns again; data that it has
not learned from say when to stop.
"""

import numpy as np

import anfis
import fuzzy

rng = np.random.default_rng(1)
x = rng.uniform(-1, 1, (240, 2))
y = np.sin(3 * x[:, 0]) * x[:, 1] + 0.05 * rng.normal(size=240)
grid = fuzzy.identify(x, y, "grid", mfs=5)
pruned = anfis.prune(grid, x[:160], y[:160], anfis.Options(epochs=5), check=(x[160:], y[160:]))
figure = anfis.plot_pruning(pruned)
print(f"{len(grid.rules)} rules before, {len(pruned.training.system.rules)} after")
