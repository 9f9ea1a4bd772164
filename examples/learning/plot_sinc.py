"""
ANFIS learns sinc
=================

Jang's second example: sin(x)/x · sin(y)/y on 121 points, 16 rules, hybrid learning.
"""

import numpy as np

import anfis
import fuzzy

side = np.linspace(-10, 10, 11)
x = np.stack(np.meshgrid(side, side), axis=-1).reshape(-1, 2)
y = np.prod(np.sinc(x / np.pi), axis=1)
start = fuzzy.identify(x, y, "grid", mfs=4, kind="gbellmf")
trained = anfis.train(start, x, y, anfis.Options(epochs=60))
print(f"training error: {trained.history[0].train:.4f} before, {trained.history[trained.best].train:.4f} after")
figure = anfis.plot_training(trained.history)

# %%
# What it has learnt:
surface = fuzzy.plot_surface(trained.system)
