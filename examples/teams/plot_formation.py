"""
A triangle along a sine
=======================

A formation by offsets from a virtual robot.
"""

import robotics

run = robotics.simulate(robotics.load_scenario("formation-triangle"), "virtual-structure", seeds=[2])
figure = robotics.plot_team(run)
