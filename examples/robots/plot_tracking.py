"""
A rule base steers a robot
==========================

A rule base, Lyapunov's law and an exponential sliding mode on the thesis's sine, from one metre behind it, with the
same noise: 3 mm and 3 mrad, five seeds. Below, how far each is off its path, with the band in which its seeds are.
"""

from dataclasses import replace

import robotics

scenario = robotics.load_scenario("lyapunov-sine")
noisy = robotics.Sensing(posture="pose", position_noise=0.003, heading_noise=0.003)
scenario = replace(scenario, sensing=noisy)
runs = [robotics.simulate(scenario, law, seeds=range(5), name=law) for law in ("fuzzy", "lyapunov", "esm")]
figure = robotics.plot_paths(runs)

# %%
# The errors of the first seed in the robot's own frame, x ahead, and the second half of them magnified:

errors = robotics.plot_errors(runs)
