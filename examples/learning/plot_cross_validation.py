"""
How many terms? Cross-validation
================================

More terms fit the data that they learn from better, and other data worse. Five folds say where that begins.
"""

import numpy as np
from matplotlib.figure import Figure

import anfis
import fuzzy

rng = np.random.default_rng(5)
x = rng.uniform(-3, 3, (90, 1))
y = np.sin(2 * x[:, 0]) + 0.25 * rng.normal(size=90)
ends = np.array([[-3.0], [3.0]])  # the universe of discourse is that of the problem, not of a fold


def start(terms):
    """A grid whose universe does not depend on which samples a fold leaves out."""
    return lambda x, y: fuzzy.fit_consequents(fuzzy.identify(ends, [0, 1], "grid", mfs=terms, fit=False), x, y)


counts = range(2, 13, 2)
found = [anfis.cross_validate(start(terms), x, y, anfis.Options(epochs=15)) for terms in counts]
figure = Figure(figsize=(6, 3.4), layout="constrained")
ax = figure.subplots()
ax.errorbar(counts, [each.mean for each in found], [each.std for each in found], fmt="s--", capsize=3, label="left out")
ax.plot(counts, [each.table()["train"].mean() for each in found], "o-", label="learnt from")
ax.axhline(0.25, color="0.6", linewidth=0.8)
ax.annotate("noise", (12, 0.25), xytext=(0, 3), textcoords="offset points", ha="right", fontsize=8)
ax.set_xlabel("terms of the input")
ax.set_ylabel("root mean square error")
ax.legend()
