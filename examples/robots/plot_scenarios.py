"""
Every packaged scenario, driven
===============================

Each scenario that comes with the package under the law that its file names, or the usual one, one seed: path
dotted, driven solid, obstacles grey. First one robot, then formations, then teams.
"""

import math

import numpy as np
from matplotlib.figure import Figure

import fuzzy
import robotics

usual = {"tracking": "fuzzy", "formation": "formation", "team": "virtual-structure"}
scenarios = [robotics.load_scenario(name) for name in robotics.scenario_names()]


def driven(kind):
    """A panel for each scenario of a kind."""
    chosen = [scenario for scenario in scenarios if scenario.kind == kind]
    rows = math.ceil(len(chosen) / 3)
    with fuzzy.style():
        figure = Figure(figsize=(6, 1.8 * rows + 0.2), layout="constrained")
        axes = figure.subplots(rows, 3, squeeze=False).flat
        for ax, scenario in zip(axes[: len(chosen)], chosen, strict=True):
            law = scenario.controller or usual[kind]
            run = robotics.simulate(scenario, law, seeds=[1])
            for thing in scenario.obstacles:
                turned = np.exp(1j * thing.heading) * (np.array(thing.corners) @ [1, 1j])
                ax.fill(turned.real + thing.position[0], turned.imag + thing.position[1], color="0.7")
            for robot, path in enumerate(scenario.trajectory.paths):
                ax.plot(*path.table[:2, ::20], ":", color="0.4", linewidth=0.8)
                ax.plot(run["x"][0, robot], run["y"][0, robot], f"-C{robot}")
            ax.set_title(scenario.name)
            ax.set_aspect("equal", adjustable="datalim")
            print(f"{scenario.name:25} {law:26} {scenario.title}")
        for ax in axes[len(chosen) :]:
            ax.set_visible(False)
        figure.supxlabel("x [m]", fontsize=8)
        figure.supylabel("y [m]", fontsize=8)
    return figure


one = driven("tracking")

# %%
# A leader with two followers, whose networks are learned:

formations = driven("formation")

# %%
# Teams. In the outages one robot fails and another holds its last command, under a law that does not wait. In
# ``trap-u-middle`` the rules as the thesis prints them drive, and robot 2 stays in the trap.

teams = driven("team")

# %%
# One of them alone, to scale: paths with their times, robots with the cones of their sonars, and obstacles that they do
# not know. ``robotics check`` draws the same of a scenario of yours.

obstacles = robotics.plot_scenario(robotics.load_scenario("obstacles-on-two-paths"))
