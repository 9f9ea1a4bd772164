"""
Every packaged scenario, driven
===============================

Each scenario that comes with the package under the controller that its file names, or the usual one, one seed:
path dotted, driven solid, obstacles grey.
"""

import math

import numpy as np
from matplotlib.figure import Figure

import robotics

names = robotics.scenario_names()
usual = {"tracking": "fuzzy", "formation": "formation", "team": "virtual-structure"}
columns = 4
figure = Figure(figsize=(10, 2.5 * math.ceil(len(names) / columns)), layout="constrained")
axes = figure.subplots(math.ceil(len(names) / columns), columns).flat
for ax, name in zip(axes, names, strict=False):
    scenario = robotics.load_scenario(name)
    run = robotics.simulate(scenario, scenario.controller or usual[scenario.kind], seeds=[1])
    for thing in scenario.obstacles:
        turned = np.exp(1j * thing.heading) * (np.array(thing.corners) @ [1, 1j])
        ax.fill(turned.real + thing.position[0], turned.imag + thing.position[1], color="0.7")
    for robot, path in enumerate(scenario.trajectory.paths):
        ax.plot(*path.table[:2, ::20], ":", color="0.4", linewidth=0.8)
        ax.plot(run["x"][0, robot], run["y"][0, robot], linewidth=1.2)
    ax.set_title(name, fontsize=8)
    ax.set_aspect("equal", adjustable="datalim")
    ax.tick_params(labelsize=6)
figure.supxlabel("x [m]")
figure.supylabel("y [m]")

# %%
# One of them alone, to scale: paths with their times, robots with the cones of their sonars, obstacles that they do not
# know.

obstacles = robotics.plot_scenario(robotics.load_scenario("obstacles-on-two-paths"))

# %%
# Robots that would meet in one point, if each kept to its time:
meeting = robotics.plot_scenario(robotics.load_scenario("three-cross"))

# %%
# A team whose robots arrive together on paths of unequal length:
team = robotics.plot_scenario(robotics.load_scenario("unequal-lengths"))
