"""
The thirteen membership functions
=================================

Every membership function of MATLAB's Fuzzy Logic Toolbox, with its parameters in MATLAB's order. The dashed
line is "not": 1 - μ.
"""

import numpy as np
from matplotlib.figure import Figure

import fuzzy

functions = {
    "trimf": (2, 5, 8),
    "trapmf": (1, 4, 6, 9),
    "gaussmf": (1.5, 5),
    "gauss2mf": (1, 4, 2, 6),
    "gbellmf": (2, 4, 5),
    "sigmf": (2, 5),
    "dsigmf": (4, 3, 4, 7),
    "psigmf": (3, 3, -3, 7),
    "zmf": (3, 7),
    "smf": (3, 7),
    "pimf": (1, 4, 6, 9),
    "linzmf": (3, 7),
    "linsmf": (3, 7),
}
x = np.linspace(0, 10, 401)
with fuzzy.style():
    figure = Figure(figsize=(4.6, 6.4), layout="constrained")
    axes = figure.subplots(5, 3, sharey=True)
    for ax, (name, parameters) in zip(axes.flat, functions.items(), strict=False):
        degree = fuzzy.membership_function(name, parameters)(x)
        ax.plot(x, degree, "-C0", x, 1 - degree, "--C0", linewidth=1)
        ax.set_title(f"{name}\n({', '.join(map(str, parameters))})")
        ax.set_xticks([0, 5, 10])
    for ax in axes.flat[len(functions) :]:
        ax.axis("off")
    axes[-1, 1].legend(axes[0, 0].lines, ["degree", "not"], loc="center")
    figure.supxlabel("x")
    figure.supylabel("degree of membership [1]")

# %%
# Each is a class, whose fields say which parameter is which; ``fuzzy.trimf(2, 5, 8)`` is ``fuzzy.Triangle(2, 5, 8)``.

for name, parameters in functions.items():
    print(f"{name:8}", fuzzy.membership_function(name, parameters))
