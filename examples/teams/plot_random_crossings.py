"""
Random crossings, with and without right of way
===============================================

Two hundred random sets of three paths that cross. The picture counts in how many robots touch, and in how many
not all arrive: with the rules of right of way, with those that the thesis prints, and with no rule against crashes.
"""

import numpy as np
from matplotlib.figure import Figure

import fuzzy
import robotics

laws = {"right of way": "right-of-way", "as printed": "crash-literal", "no such rule": "virtual-structure"}
outcomes = [robotics.stress_crossing(law, 3, range(200)) for law in laws.values()]
touched = [int(outcome.collided.sum()) for outcome in outcomes]
late = [int((outcome.deadlocked & ~outcome.collided).sum()) for outcome in outcomes]

with fuzzy.style():
    figure = Figure(figsize=(4.6, 2.6), layout="constrained")
    ax = figure.subplots()
    places = np.arange(len(laws))
    for counts, shift, color, label in ((touched, -0.2, "C0", "robots touch"), (late, 0.2, "C5", "not all arrive")):
        bars = ax.barh(places + shift, counts, 0.38, color=color, label=label)
        ax.bar_label(bars, padding=3)
    ax.set_yticks(places, laws)
    ax.invert_yaxis()
    ax.set_xlim(0, 200)
    ax.set_xlabel("runs of 200")
    ax.legend(loc="upper right")

# %%
# The least distance between two robots' centers, run by run, as the share of runs in which it was no more. The rule
# keeps half a metre.

with fuzzy.style():
    nearest = Figure(figsize=(4.6, 2.8), layout="constrained")
    ax = nearest.subplots()
    for name, outcome in zip(laws, outcomes, strict=True):
        ax.ecdf(outcome.min_distance, label=name)
    ax.set_xlabel("least distance between two robots [m]")
    ax.set_ylabel("share of the runs [1]")
    nearest.legend(loc="outside upper center", ncols=3)
