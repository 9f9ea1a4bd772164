"""
Random crossings, with and without right of way
===============================================

Two hundred random sets of three paths that cross. With the rules of right of way, with the rules as the thesis
prints them, and with no rule against crashes: in how many runs robots touch, and in how many not all arrive.
"""

import numpy as np
from matplotlib.figure import Figure

import robotics

laws = {"right of way": "right-of-way", "as printed": "crash-literal", "no such rule": "virtual-structure"}
outcomes = [robotics.stress_crossing(law, 3, range(200)) for law in laws.values()]

figure = Figure(figsize=(6, 2.6), layout="constrained")
ax = figure.subplots()
places = np.arange(len(laws))
touched = np.array([outcome.collided.sum() for outcome in outcomes])
late = np.array([(outcome.deadlocked & ~outcome.collided).sum() for outcome in outcomes])
ax.barh(places + 0.2, touched, 0.38, label="robots touch")
ax.barh(places - 0.2, late, 0.38, label="not all arrive")
for place, counts in enumerate(zip(touched, late, strict=True)):
    for count, shift in zip(counts, (0.2, -0.2), strict=True):
        ax.annotate(str(count), (count, place + shift), xytext=(3, 0), textcoords="offset points", va="center")
ax.set_yticks(places, laws)
ax.invert_yaxis()
ax.set_xlabel("runs of 200")
ax.legend()

# %%
# The nearest that two robots' centers came, run by run:

nearest = Figure(figsize=(6, 3), layout="constrained")
ax = nearest.subplots()
for name, outcome, style in zip(laws, outcomes, ("-", "--", ":"), strict=True):
    ax.plot(np.sort(outcome.min_distance), np.linspace(0, 1, 200), style, label=name)
ax.set_xlabel("least distance between two robots [m]")
ax.set_ylabel("share of the runs")
ax.legend()
