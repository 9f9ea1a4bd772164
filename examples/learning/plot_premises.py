"""
What learning does to membership functions
==========================================

Data with a steep step at 0.3. Learning moves the membership functions: the left edge of the fourth becomes steep and
comes to lie where the step is; the others make way.
"""

import numpy as np

import anfis
import fuzzy

x = np.linspace(-1, 1, 120)[:, None]
y = np.tanh(12 * (x[:, 0] - 0.3))
start = fuzzy.identify(x, y, "grid", mfs=4)
trained = anfis.train(start, x, y, anfis.Options(method="second-order", epochs=30))
figure = anfis.plot_premises(start, trained.system)

# %%
# And the fit, sample by sample; the error is now a few ten-thousandths:

print(f"RMSE {trained.history[0].train:.4f} before, {trained.rmse:.4f} after")
fit = anfis.plot_fit(trained.system, x, y)
