"""
The thirteen membership functions
=================================

Every membership function of MATLAB is a class, and a function by MATLAB's name. The dashed one is the
complement, "not".
"""

import numpy as np
from matplotlib.figure import Figure

import fuzzy

functions = {
    "trimf": fuzzy.trimf(2, 5, 8),
    "trapmf": fuzzy.trapmf(1, 4, 6, 9),
    "gaussmf": fuzzy.gaussmf(1.5, 5),
    "gauss2mf": fuzzy.gauss2mf(1, 4, 2, 6),
    "gbellmf": fuzzy.gbellmf(2, 4, 5),
    "sigmf": fuzzy.sigmf(2, 5),
    "dsigmf": fuzzy.dsigmf(4, 3, 4, 7),
    "psigmf": fuzzy.psigmf(3, 3, -3, 7),
    "zmf": fuzzy.zmf(3, 7),
    "smf": fuzzy.smf(3, 7),
    "pimf": fuzzy.pimf(1, 4, 6, 9),
    "linzmf": fuzzy.linzmf(3, 7),
    "linsmf": fuzzy.linsmf(3, 7),
}
x = np.linspace(0, 10, 401)
figure = Figure(figsize=(8, 6), layout="constrained")
for ax, (name, function) in zip(figure.subplots(4, 4, sharex=True, sharey=True).flat, functions.items(), strict=False):
    ax.plot(x, function(x), color="#0072B2")
    ax.plot(x, 1 - function(x), color="#0072B2", linestyle="--", linewidth=0.7)
    ax.set_title(name, fontsize=9)
for ax in figure.axes[13:]:
    ax.set_visible(False)
figure.supxlabel("x")
figure.supylabel("degree of membership")
