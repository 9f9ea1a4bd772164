"""
A rule base steers a robot
==========================

The fuzzy tracking law and Lyapunov's on the thesis's sine, with the same noise: 3 mm and 3 mrad, five seeds.
"""

from dataclasses import replace

import robotics

scenario = robotics.load_scenario("lyapunov-sine")
noisy = robotics.Sensing(posture="pose", position_noise=0.003, heading_noise=0.003)
scenario = replace(scenario, sensing=noisy)
runs = [robotics.simulate(scenario, law, seeds=range(5), name=law) for law in ("fuzzy", "lyapunov", "esm")]
figure = robotics.plot_paths(runs)

# %%
# Their errors over time, as a band over the seeds:
errors = robotics.plot_errors(runs)
