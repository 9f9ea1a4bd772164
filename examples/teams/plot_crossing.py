"""
Paths that cross
================

Three robots would meet in one point. They agree on a right of way over the radio: two wait, each before the path of
the one that goes first. The picture shows where each pair comes nearest.
"""

import robotics

run = robotics.simulate(robotics.load_scenario("three-cross"), "right-of-way", seeds=[1])
figure = robotics.plot_meetings(run)

# %%
# The distances between their centers, and the one that the rule keeps; in the grey they would touch however they stand.

distances = robotics.plot_distances(run)
