"""
Obstacles that nobody knows
===========================

Two of three robots meet an obstacle. Their sonars see it; five rule bases, blended by urgency, take them round it, and
the others wait meanwhile, so that the team goes on together.
"""

import robotics

run = robotics.simulate(robotics.load_scenario("obstacles-on-two-paths"), "fuzzy-team", seeds=[1])
figure = robotics.plot_avoidance(run)

# %%
# What the sonars read, and how far the nearest obstacle truly was. They see the other robots, too.

sonar = robotics.plot_sonar(run)
