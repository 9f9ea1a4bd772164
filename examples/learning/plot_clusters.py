"""
Rules from data: subtractive clusters
=====================================

Chiu's subtractive clustering finds where data are dense. Each cluster becomes a rule: a Gaussian round its
center, and a line; least squares fits the lines so that their average comes near the data. There is no grid, and no
number of rules to choose, only how far a center reaches.
"""

import numpy as np
from matplotlib.figure import Figure

import fuzzy

rng = np.random.default_rng(1)
x = np.sort(rng.uniform(0, 10, 200))
y = np.sin(x) + 0.1 * x + 0.1 * rng.normal(size=200)
clusters = fuzzy.subtractive_clusters(np.column_stack([x, y]), radius=0.4)
system = fuzzy.identify(x[:, None], y, "subtractive", radius=0.4, input_names=["x"], output_names=["y"])

with fuzzy.style():
    figure = Figure(figsize=(4.6, 3.8), layout="constrained")
    above, below = figure.subplots(2, 1, sharex=True, height_ratios=(2, 1))
    above.plot(x, y, ".", color="0.6", label="data")
    above.plot(x, system(x[:, None]), "-k", label="the system")
    above.plot(*clusters.centers.T, "PC1", markersize=8, label="centers")
    above.set_ylabel("y")
    for term in system.inputs[0].terms.values():
        below.plot(x, term(x))
    below.set_ylabel("degree [1]")
    below.set_xlabel("x")
    figure.legend(loc="outside upper center", ncols=3)

# %%
# The rules that came of it, and the error; the noise in the data is 0.1:

for near, line in zip(system.inputs[0].terms.values(), system.outputs[0].terms.values(), strict=True):
    print(f"if x is about {near.c:.1f} then y = {line.slopes[0]:+.2f} x {line.constant:+.2f}")
print(f"RMSE {np.sqrt(np.mean((system(x[:, None])[:, 0] - y) ** 2)):.3f}")
