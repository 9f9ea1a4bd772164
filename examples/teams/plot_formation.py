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
# When the last one arrived, how long after the first, and how near two of them ever came:

found = robotics.measure_team(run)
print(f"arrival {found['arrival_time_s'].max():.1f} s, spread {found['arrival_spread_s'].max():.1f} s")
print(f"least distance {found['min_distance_m'].min():.2f} m")
