"""
ANFIS learns sinc
=================

Jang's first example: sin(x)/x · sin(y)/y on 121 points, four bells for each input, 16 rules. Hybrid learning, as he
has it, and second order, from the same start.
"""

import numpy as np

import anfis
import fuzzy

side = np.linspace(-10, 10, 11)
x = np.stack(np.meshgrid(side, side), axis=-1).reshape(-1, 2)
y = np.prod(np.sinc(x / np.pi), axis=1)
start = fuzzy.identify(x, y, "grid", mfs=4, kind="gbellmf", input_names=["x", "y"], output_names=["z"])
for method in ("hybrid", "second-order"):
    trained = anfis.train(start, x, y, anfis.Options(method=method, epochs=100))
    print(f"{method}: RMSE {trained.history[0].train:.4f} before, {trained.rmse:.4f} after")
figure = anfis.plot_training(trained.history)

# %%
# What second order has learned:

surface = fuzzy.plot_surface(trained.system)
