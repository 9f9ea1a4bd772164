"""
Radio faults
============

A team that keeps together over the radio. Robot 1 measures its position with 10 % noise for 30 s. Hatched: robot 2
fails for 20 s, and robot 3 is held up for 20 s, in which it hears and sends nothing. The law waits, and the team goes
on together.
"""

import robotics

run = robotics.simulate(robotics.load_scenario("outage-20s"), "virtual-structure", seeds=[4])
figure = robotics.plot_progress(run)

# %%
# How long an outage may last: the share of runs in which the team comes together again, by the outage's length, with
# Wilson's intervals. Ten seeds for each point. Of a law that does not wait, fewer recover from longer outages.

found = robotics.recovery_curve(["virtual-structure", "graph-esm"], outages=[2, 8, 14, 20], seeds=range(10))
recovery = robotics.plot_recovery(found)
