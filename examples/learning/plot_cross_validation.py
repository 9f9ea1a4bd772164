"""
How many terms? Cross-validation
================================

More terms fit the data that they learn from better; too many fit other data worse. Five folds say where that
begins: each fifth of the data is left out once. Bars are the standard deviation between the folds.
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
with fuzzy.style():
    figure = Figure(figsize=(4.6, 3), layout="constrained")
    ax = figure.subplots()
    means, deviations = [each.mean for each in found], [each.std for each in found]
    ax.errorbar(counts, means, deviations, fmt="s--C1", capsize=3, label="on the fold that is left out")
    ax.plot(counts, [each.table()["train"].mean() for each in found], "o-C0", label="on the data learnt from")
    ax.axhline(0.25, color="black", linestyle=":", linewidth=1, label="noise in the data")
    ax.set_xlabel("terms of the input")
    ax.set_ylabel("root mean square error [1]")
    ax.set_ylim(bottom=0)
    ax.legend(loc="upper center")

# %%
# The least error on what was left out:

for terms, each in zip(counts, found, strict=True):
    print(f"{terms:2} terms: {each.mean:.3f} ± {each.std:.3f}")
