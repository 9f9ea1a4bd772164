"""
A Mamdani system, and the Sugeno systems near it
================================================

A Mamdani system's output sets become constants at their centroids. Constants, or planes, that are fitted on a
grid come nearer: the greatest and the mean difference are printed, as shares of the output's range.
"""

import numpy as np
from matplotlib.figure import Figure

import fuzzy

comfort = fuzzy.Mamdani(
    inputs=[fuzzy.Variable("temperature", (0, 40), {"cold": fuzzy.zmf(10, 22), "hot": fuzzy.smf(18, 32)}, "°C")],
    outputs=[fuzzy.Variable("fan", (0, 1), {"slow": fuzzy.trimf(0, 0.1, 0.5), "fast": fuzzy.trimf(0.3, 0.9, 1)})],
    rules=["if temperature is cold then fan is slow", "if temperature is hot then fan is fast"],
)
constants, _ = comfort.as_sugeno()
fitted = fuzzy.fit_to_mamdani(comfort, constants, "constants")
planes = fuzzy.fit_to_mamdani(comfort, constants, "planes")

t = np.linspace(0, 40, 201)[:, None]
figure = Figure(figsize=(6, 3.4), layout="constrained")
ax = figure.subplots()
ax.plot(t, comfort(t), color="black", label="Mamdani, centroid")
for name, system, style in (("centroids", constants, "--"), ("fitted", fitted, "-."), ("planes", planes, ":")):
    print(f"{name:10}", *fuzzy.mamdani_difference(comfort, system))
    ax.plot(t, system(t), linestyle=style, label=f"Sugeno, {name}")
ax.set_xlabel("temperature [°C]")
ax.set_ylabel("fan")
ax.legend()
