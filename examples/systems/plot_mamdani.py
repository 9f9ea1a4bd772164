"""
A Mamdani system, and the Sugeno systems near it
================================================

MATLAB's conversion puts a constant at the centroid of each output set. Constants that are fitted to the Mamdani
system's answers on a grid come nearer, and planes nearer still.
"""

import numpy as np
from matplotlib.figure import Figure

import fuzzy

comfort = fuzzy.Mamdani(
    inputs=[fuzzy.Variable("temperature", (0, 40), {"cold": fuzzy.zmf(10, 22), "hot": fuzzy.smf(18, 32)}, "°C")],
    outputs=[fuzzy.Variable("fan", (0, 1), {"slow": fuzzy.trimf(0, 0.1, 0.5), "fast": fuzzy.trimf(0.3, 0.9, 1)})],
    rules=["if temperature is cold then fan is slow", "if temperature is hot then fan is fast"],
)
centroids, _ = comfort.as_sugeno()
near = {
    "at the centroids": centroids,
    "fitted constants": fuzzy.fit_to_mamdani(comfort, centroids, "constants"),
    "fitted planes": fuzzy.fit_to_mamdani(comfort, centroids, "planes"),
}

t = np.linspace(0, 40, 201)[:, None]
with fuzzy.style():
    figure = Figure(figsize=(4.6, 3.2), layout="constrained")
    ax = figure.subplots()
    ax.plot(t, comfort(t), "-k", label="Mamdani")
    for (name, system), style in zip(near.items(), ("--C0", "-.C1", ":C2"), strict=True):
        ax.plot(t, system(t), style, label=f"Sugeno, {name}")
    ax.set_xlabel("temperature [°C]")
    ax.set_ylabel("fan [1]")
    ax.legend(loc="lower right")

# %%
# How far each is from the Mamdani system, as a share of the output's range:

for name, system in near.items():
    (difference,) = fuzzy.mamdani_difference(comfort, system)
    print(f"{name:16} at most {100 * difference.greatest:.1f} %, {100 * difference.root_mean_square:.1f} % RMS")
