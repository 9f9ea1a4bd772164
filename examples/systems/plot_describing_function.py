"""
Will it oscillate? A describing function
========================================

To a sine, a rule base of one input is a gain that depends on the amplitude. Where 1 + N(A) G = 0, the loop has
a limit cycle: here it is predicted, and then simulated.
"""

import numpy as np

import fuzzy

relay = fuzzy.Sugeno(
    [fuzzy.Variable("e", (-3, 3), {"low": fuzzy.linzmf(-0.05, 0.05), "high": fuzzy.linsmf(-0.05, 0.05)})],
    [fuzzy.Variable("u", (-2, 2), {"down": -1, "up": 1})],
    ["if e is low then u is down", "if e is high then u is up"],
    name="relay",
)
figure = fuzzy.plot_describing_function(relay, np.linspace(0.02, 2, 200))

# %%
# The plant 1/(s (s + 1)²) turns by 180° at 1 rad/s, where its gain is 1/2: N(A) = 2 there.

amplitudes = np.linspace(0.1, 2, 2000)
predicted = amplitudes[np.argmin(abs(fuzzy.describing_function(relay, amplitudes).real - 2))]
plant = fuzzy.TransferFunction([1], [1, 2, 1, 0])
response = fuzzy.step_response(relay, plant, duration=60, sample_time=0.01)
late = response.output[response.time > 40]
print(f"amplitude predicted: {predicted:.3f}, simulated: {np.ptp(late) / 2:.3f}")
