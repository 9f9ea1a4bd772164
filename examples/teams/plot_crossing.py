"""
Paths that cross
================

Three robots whose paths meet; right of way is agreed over the radio.
"""

import robotics

run = robotics.simulate(robotics.load_scenario("three-cross"), "right-of-way", seeds=[1])
figure = robotics.plot_meetings(run)

# %%
# The distances between them:
distances = robotics.plot_distances(run)
