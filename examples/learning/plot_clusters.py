"""
Rules from data: subtractive clusters
=====================================

Chiu's subtractive clustering finds where data are dense; every cluster becomes a rule.
"""

import numpy as np
from matplotlib.figure import Figure

import fuzzy

rng = np.random.default_rng(1)
data = np.concatenate([rng.normal(center, 0.3, (60, 2)) for center in ((0, 0), (2, 1), (1, 3))])
clusters = fuzzy.subtractive_clusters(data, radius=0.4)

figure = Figure(figsize=(4.5, 3.6), layout="constrained")
ax = figure.subplots()
ax.plot(*data.T, ".", color="#999999", label="data")
ax.plot(*clusters.centers.T, "P", color="#D55E00", markersize=10, label="clusters")
ax.set_xlabel("first input")
ax.set_ylabel("second input")
ax.legend()
