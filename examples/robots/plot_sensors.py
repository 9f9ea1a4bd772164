"""
What a robot measures
=====================

The true posture and the measured one: 3 mm and 3 mrad of noise, and odometry by encoders with wheels whose
radii are a percent off: its error grows with the way.
"""

from dataclasses import replace

import numpy as np
from matplotlib.figure import Figure

import robotics

scenario = robotics.load_scenario("lyapunov-sine")
sensing = {
    "pose, 3 mm and 3 mrad": robotics.Sensing(posture="pose", position_noise=0.003, heading_noise=0.003),
    "odometry, wheels 1 % off": robotics.Sensing(posture="odometry", wheel_error=0.01),
}
figure = Figure(figsize=(7, 3), layout="constrained")
for ax, (name, eyes) in zip(figure.subplots(1, 2), sensing.items(), strict=True):
    run = robotics.simulate(replace(scenario, sensing=eyes), "lyapunov", seeds=range(5))
    error = np.hypot(run["x_measured"] - run["x"], run["y_measured"] - run["y"])[:, 0]
    ax.plot(run.time, 1e3 * error.T, color="0.6", linewidth=0.6)
    ax.plot(run.time, 1e3 * error.mean(axis=0), color="black", label="mean of 5 seeds")
    ax.set_title(name)
    ax.set_xlabel("time [s]")
    ax.set_ylabel("error of the measured position [mm]")
    ax.legend()
