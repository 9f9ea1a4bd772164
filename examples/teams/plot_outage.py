"""
A robot of a team falls silent
==============================

Three robots that arrive together; the radio of one of them fails for ten seconds.
"""

import robotics

run = robotics.simulate(robotics.load_scenario("outage-10s"), "virtual-structure", seeds=range(3))
figure = robotics.plot_team(run)

# %%
# How far each is along its path, and the differences:
progress = robotics.plot_progress(run)
