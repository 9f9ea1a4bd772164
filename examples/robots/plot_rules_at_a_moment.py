"""
Why did it do that?
===================

A run remembers what its rule base was asked. Here are the rules that fired five seconds after the start, when the
robot was 0.11 m behind its target: how strongly each, and what it proposed.
"""

import robotics

run = robotics.simulate(robotics.load_scenario("fuzzy-off-path"), "fuzzy", seeds=[3])
figure = robotics.plot_rules_at(run, 5.0)

# %%
# The same in words:

print(robotics.explain_decision(run, robot=1, time=5.0))
