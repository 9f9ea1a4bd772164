"""
Obstacles that nobody knows
===========================

Sonars see them; five rule bases, blended by urgency, go round.
"""

import robotics

run = robotics.simulate(robotics.load_scenario("obstacles-on-two-paths"), "fuzzy-team", seeds=[1])
figure = robotics.plot_avoidance(run)

# %%
# What the sonars read:
sonar = robotics.plot_sonar(run)
