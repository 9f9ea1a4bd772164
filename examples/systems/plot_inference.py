"""
Inference step by step
======================

The rule viewer shows how an answer comes about: the degrees of membership at a point, each rule's firing
strength, and what it contributes.
"""

import fuzzy

tracking = fuzzy.read_fis(fuzzy.find_fis("tracking"))
point = [0.3, 0.4, 0.2, 0.1][: len(tracking.inputs)]
figure = fuzzy.plot_rules(tracking, point, only_fired=True)

# %%
# The whole rule base as a network of five layers: inputs, terms, rules, consequents, outputs.

structure = fuzzy.plot_structure(tracking)

# %%
# The same in words, and as numbers layer by layer:

print(fuzzy.explain(tracking, point))
layers = fuzzy.infer(tracking, point)
print("firing strengths:", layers.firing.round(3))
