"""
Hybrid against second order
===========================

The same data and the same start, where least squares alone ends, and three ways to go on. Second order (variable
projection, Levenberg-Marquardt) needs a few epochs where hybrid learning needs many; an epoch of it costs more. What is
below the noise is noise learned by heart.
"""

from time import perf_counter

import numpy as np
from matplotlib.figure import Figure

import anfis
import fuzzy

rng = np.random.default_rng(3)
x = rng.uniform(-1, 1, (400, 2))
y = np.sin(3 * x[:, 0]) * np.exp(-x[:, 1]) + 0.02 * rng.normal(size=400)
start = fuzzy.identify(x, y, "grid", mfs=3)

with fuzzy.style():
    figure = Figure(figsize=(4.6, 3.2), layout="constrained")
    ax = figure.subplots()
    for method in ("second-order", "hybrid", "backprop"):
        anfis.train(start, x, y, anfis.Options(method=method, epochs=1))  # what is loaded first, no clock counts
        began = perf_counter()
        trained = anfis.train(start, x, y, anfis.Options(method=method, epochs=60))
        spent = perf_counter() - began
        errors = [epoch.train for epoch in trained.history]
        ax.semilogy(range(len(errors)), errors, label=method)
        print(f"{method:12} {errors[0]:.4f} -> {min(errors):.4f}, {1e3 * spent / (len(errors) - 1):.1f} ms an epoch")
    ax.axhline(0.02, color="black", linestyle=":", linewidth=1, label="noise in the data")
    ax.set_yticks([0.02, 0.03, 0.04, 0.06], ["0.02", "0.03", "0.04", "0.06"])
    ax.minorticks_off()
    ax.set_xlabel("epoch")
    ax.set_ylabel("root mean square error [1]")
    ax.legend()
