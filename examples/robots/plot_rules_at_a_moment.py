"""
Why did it do that?
===================

A run remembers what the rule base was asked: the rules that fired, five seconds after the start.
"""

import robotics

run = robotics.simulate(robotics.load_scenario("fuzzy-off-path"), "fuzzy", seeds=[3])
print(robotics.explain_decision(run, robot=1, time=5.0))
figure = robotics.plot_rules_at(run, 5.0)
