"""
What a robot measures
=====================

The error of the measured position under two kinds of sensing: a pose with 3 mm of noise, which stays as good as it
is, and odometry with wheels whose radii are 1 % off, whose error grows with the way.
"""

from dataclasses import replace

import numpy as np
from matplotlib.figure import Figure

import fuzzy
import robotics

scenario = robotics.load_scenario("lyapunov-sine")
sensing = {
    "pose, 3 mm and 3 mrad": robotics.Sensing(posture="pose", position_noise=0.003, heading_noise=0.003),
    "odometry, wheels 1 % off": robotics.Sensing(posture="odometry", wheel_error=0.01),
}
with fuzzy.style():
    figure = Figure(figsize=(4.6, 4), layout="constrained")
    axes = figure.subplots(2, 1, sharex=True)
    for ax, (name, eyes), (unit, size) in zip(axes, sensing.items(), (("mm", 1e3), ("m", 1.0)), strict=True):
        run = robotics.simulate(replace(scenario, sensing=eyes), "lyapunov", seeds=range(5))
        error = np.hypot(run["x_measured"] - run["x"], run["y_measured"] - run["y"])[:, 0]
        ax.plot(run.time, size * error.T, "-", color="0.6", linewidth=0.6)
        ax.plot(run.time, size * error.mean(axis=0), "-k", label="mean of 5 seeds")
        ax.set_title(name)
        ax.set_ylabel(f"error of the position [{unit}]")
    axes[1].set_xlabel("time [s]")
    axes[1].legend(loc="upper left")
