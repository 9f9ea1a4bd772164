"""
Rules from data: subtractive clusters
=====================================

Chiu's subtractive clustering finds where data are dense. Each cluster becomes a rule: a Gaussian round its
center, and a line that least squares fits. No grid, and no number of rules to choose, only how far a center reaches.
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
    figure = Figure(figsize=(4.6, 3.4), layout="constrained")
    ax = figure.subplots()
    ax.plot(x, y, ".", color="0.6", label="data")
    layers = fuzzy.infer(system, x[:, None])
    for rule, center in enumerate(clusters.centers):
        near = abs(x - center[0]) < clusters.sigma[0]
        ax.plot(x[near], layers.rule_outputs[near, rule, 0], "-C0", label=None if rule else "what each rule says")
    ax.plot(x, layers.output, "--k", label="the system")
    ax.plot(*clusters.centers.T, "PC1", markersize=8, label="centers")
    ax.set_xlabel("x")
    ax.set_ylabel("y")
    figure.legend(loc="outside upper center", ncols=2)

# %%
# The system that came of it, and its error; the noise in the data is 0.1:

for rule in system.rules:
    print(rule)
print(f"RMSE {np.sqrt(np.mean((system(x[:, None])[:, 0] - y) ** 2)):.3f}")
