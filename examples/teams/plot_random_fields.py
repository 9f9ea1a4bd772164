"""
Fields of obstacles that nobody knows
=====================================

Fifty random courses for each law: five rule bases blended by urgency, the thesis's rules as printed, and a law
that has no rules for obstacles. The picture shows how many arrive untouched, with Wilson's 95 % interval.
"""

import numpy as np
from matplotlib.figure import Figure
from scipy.stats import binomtest

import fuzzy
import robotics

laws = {"fuzzy-team": "blended rule bases", "obstacles-literal": "rules as printed", "lyapunov": "no such rules"}
with fuzzy.style():
    figure = Figure(figsize=(4.6, 2), layout="constrained")
    ax = figure.subplots()
    for place, (law, title) in enumerate(laws.items()):
        outcome = robotics.stress_obstacles(law, range(50))
        good = int(outcome.succeeded.sum())
        low, high = binomtest(good, 50).proportion_ci(method="wilson")
        ax.plot([100 * low, 100 * high], [place, place], "-", color="0.5")
        ax.plot(2 * good, place, "ok")
        ax.annotate(f"{good} of 50", (2 * good, place), xytext=(0, 6), textcoords="offset points", ha="center")
        print(f"{title}: {good} of 50 untouched, {int(outcome.hit.sum())} touched an obstacle")
    ax.set_yticks(np.arange(len(laws)), laws.values())
    ax.set_ylim(len(laws) - 0.5, -0.7)
    ax.set_xlim(0, 110)
    ax.set_xticks(range(0, 101, 20))
    ax.set_xlabel("courses driven untouched [%]")
