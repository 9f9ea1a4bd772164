"""
Hybrid against second order
===========================

The same start and the same data, four ways to learn. Second order (variable projection, Levenberg-Marquardt)
needs a few epochs where hybrid learning needs many; its epochs cost more.
"""

import numpy as np
from matplotlib.figure import Figure

import anfis
import fuzzy

rng = np.random.default_rng(3)
x = rng.uniform(-1, 1, (400, 2))
y = np.sin(3 * x[:, 0]) * np.exp(-x[:, 1]) + 0.02 * rng.normal(size=400)
start = fuzzy.identify(x, y, "grid", mfs=3)

figure = Figure(figsize=(6, 3.6), layout="constrained")
ax = figure.subplots()
looks = {"second-order": "-", "hybrid": "--", "backprop": "-.", "least-squares": ":"}
for method, style in looks.items():
    trained = anfis.train(start, x, y, anfis.Options(method=method, epochs=60))
    errors = [epoch.train for epoch in trained.history]
    ax.semilogy(range(len(errors)), errors, style, label=method)
    print(f"{method:14} {errors[0]:.4f} -> {min(errors):.4f} in {len(errors) - 1} epochs")
ax.axhline(0.02, color="0.6", linewidth=0.8)
ax.annotate("noise", (60, 0.02), xytext=(0, 3), textcoords="offset points", ha="right", fontsize=8)
ax.set_xlabel("epoch")
ax.set_ylabel("root mean square error")
ax.legend()
