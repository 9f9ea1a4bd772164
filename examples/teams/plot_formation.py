"""
A triangle along a sine
=======================

Each robot keeps its offset from a virtual robot that drives along a sine. They tell each other their progress s along
the path, wait for one another, and arrive together.
"""

import robotics

run = robotics.simulate(robotics.load_scenario("formation-triangle"), "virtual-structure", seeds=[2])
figure = robotics.plot_team(run)

# %%
# How far they were ever apart in progress, and off their paths:

for name, value in robotics.measure_team(run).items():
    print(f"{name:32} {value.mean():.4g}")
