"""
Inference step by step
======================

A rule base with sixteen rules that tracks a path, asked at one point. The rule viewer shows the four rules that
fire: the degrees of membership, the firing strengths, what each proposes, and the average of the proposals.
"""

import numpy as np

import fuzzy

tracking = fuzzy.read_fis(fuzzy.find_fis("tracking"))
point = [0.3, 0.4, 0.05, 0.1]  # distance [m], bearing of the target, error ahead [m], error of the heading [rad]
figure = fuzzy.plot_rules(tracking, point, only_fired=True)

# %%
# The same as numbers, in the five layers of [Jang 1993]: degrees, firing strengths w, shares w / Σw, proposals f, and
# the output, Σ f w / Σw.

layers = fuzzy.infer(tracking, point)
for variable, degrees in zip(tracking.inputs, layers.memberships, strict=True):
    print(f"{variable.name:12}", dict(zip(variable.terms, degrees.round(3).tolist(), strict=True)))
fired = layers.firing > 0
print("rules           ", np.flatnonzero(fired) + 1)
print("firing strengths", layers.firing[fired].round(3))
print("shares          ", layers.weights[fired].round(3))
print("proposed v      ", layers.rule_outputs[fired, 0].round(3), "m/s")
print("proposed w      ", layers.rule_outputs[fired, 1].round(3), "rad/s")
print("output          ", layers.output.round(3))
assert np.allclose(layers.output, layers.weights @ layers.rule_outputs)

# %%
# In words:

print(fuzzy.explain(tracking, point))

# %%
# The whole rule base as a network: these layers from left to right.

structure = fuzzy.plot_structure(tracking)
