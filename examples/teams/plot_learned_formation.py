"""
A formation that was learned
============================

Four ANFIS networks, learned from generated formation data as in chapter 5 of the thesis, drive a leader that
starts three metres behind its followers. It hurries, they drive slowly until it has caught up; then all keep level.
"""

import robotics

run = robotics.simulate(robotics.load_scenario("formation-behind"), "formation", seeds=[1])
figure = robotics.plot_formation(run)
for name, value in robotics.measure_formation(run).items():
    print(f"{name:32} {value.mean():.4f}")
