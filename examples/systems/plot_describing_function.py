"""
Will it oscillate? A describing function
========================================

To a sine, a rule base of one input is a gain N that depends on the amplitude. Where 1 + N(A) G = 0, the loop has
a limit cycle: here it is predicted, and then simulated.
"""

import numpy as np
from matplotlib.figure import Figure

import fuzzy

relay = fuzzy.Sugeno(
    [fuzzy.Variable("e", (-3, 3), {"low": fuzzy.linzmf(-0.05, 0.05), "high": fuzzy.linsmf(-0.05, 0.05)})],
    [fuzzy.Variable("u", (-2, 2), {"down": -1, "up": 1})],
    ["if e is low then u is down", "if e is high then u is up"],
    name="relay",
)
amplitudes = np.linspace(0.02, 2, 100)
gain = fuzzy.describing_function(relay, amplitudes).real  # falls with the amplitude
predicted = np.interp(2, gain[::-1], amplitudes[::-1])

# %%
# The plant 1/(s (s + 1)²) turns by 180° at 1 rad/s, where its gain is 1/2: there is a limit cycle where N(A) = 2.

figure = fuzzy.plot_describing_function(relay, amplitudes)
(ax,) = figure.axes
ax.plot([0, predicted, predicted], [2, 2, 0], ":k", linewidth=1)
ax.annotate(f"N = 2 at A = {predicted:.2f}", (predicted, 2), xytext=(6, 6), textcoords="offset points", fontsize=8)

# %%
# The loop with this relay after a step of its reference from 0 to 1. It oscillates about as predicted, a little wider
# and slower: the prediction takes the oscillation for a sine.

plant = fuzzy.TransferFunction([1], [1, 2, 1, 0])
response = fuzzy.step_response(relay, plant, duration=60, sample_time=0.01)
late = response.time > 40
found = np.ptp(response.output[late]) / 2
rising = np.flatnonzero(np.diff(np.sign(response.error[late])) > 0)
print(f"amplitude: predicted {predicted:.3f}, simulated {found:.3f}")
print(f"frequency: predicted 1 rad/s, simulated {2 * np.pi / (0.01 * np.diff(rising).mean()):.3f} rad/s")
with fuzzy.style():
    loop = Figure(figsize=(4.6, 2.6), layout="constrained")
    ax = loop.subplots()
    ax.plot(response.time, response.output, "-", label="output")
    ax.axhline(1 + predicted, linestyle=":", color="black", linewidth=1, label="reference ± predicted amplitude")
    ax.axhline(1 - predicted, linestyle=":", color="black", linewidth=1)
    ax.set_xlabel("time [s]")
    ax.set_ylabel("output y [1]")
    ax.legend(loc="lower right")
