"""
Radio faults
============

A team whose messages are lost or delayed: noise on the position of one robot, a failure of another, a delay of
the third. The shaded times are the faults.
"""

import robotics

run = robotics.simulate(robotics.load_scenario("outage-20s"), "virtual-structure", seeds=[4])
figure = robotics.plot_progress(run)

# %%
# Distances between the robots meanwhile:
distances = robotics.plot_distances(run)

# %%
# How long an outage may last: the share of runs in which the team comes together again, by the outage's length, with
# Wilson's intervals. Ten seeds for each point.

found = robotics.recovery_curve(["virtual-structure", "graph-esm"], outages=[2, 8, 14, 20], seeds=range(10))
recovery = robotics.plot_recovery(found)
