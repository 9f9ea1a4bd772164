"""
What learning does to membership functions
==========================================

A steep step: hybrid learning moves the membership functions to where the data change.
"""

import numpy as np

import anfis
import fuzzy

x = np.linspace(-1, 1, 120)[:, None]
y = np.tanh(12 * (x[:, 0] - 0.3))
start = fuzzy.identify(x, y, "grid", mfs=4)
trained = anfis.train(start, x, y, anfis.Options(epochs=80))
figure = anfis.plot_premises(start, trained.system)

# %%
# And the fit:
fit = anfis.plot_fit(trained.system, x, y)
