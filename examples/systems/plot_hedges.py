"""
Very, somewhat, not: hedges in a sentence
=========================================

A rule is an English sentence. Hedges change the degree of membership: "very" squares it, "somewhat" takes its
root, and "not" gives 1 less the degree.
"""

import numpy as np
from matplotlib.figure import Figure

import fuzzy

warm = fuzzy.Variable("temperature", (0, 40), {"warm": fuzzy.Gaussian(6, 24)}, unit="°C")
fan = fuzzy.Variable("fan", (0, 1), {"on": 1.0})
t = np.linspace(0, 40, 200)  # not at 24 °C itself, where "not warm" does not fire
with fuzzy.style():
    figure = Figure(figsize=(4.6, 2.8), layout="constrained")
    ax = figure.subplots()
    for words in ("warm", "very warm", "somewhat warm", "not warm"):
        system = fuzzy.Sugeno([warm], [fan], [f"if temperature is {words} then fan is on"])
        ax.plot(t, fuzzy.infer(system, t[:, None]).firing[:, 0], label=words)
    ax.set_xlabel("temperature [°C]")
    ax.set_ylabel("firing strength [1]")
    figure.legend(loc="outside upper center", ncols=4)
