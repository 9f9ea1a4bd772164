"""Distances between robots and to obstacles at a run's samples; contacts are those of robotics.measures.contacts."""

from itertools import combinations

import numpy as np

from robotics.simulation.run import Run
from robotics.world.environment.collision import footprints, obstacle_clearance


def robot_gaps(run: Run, place: int) -> dict[tuple[int, int], np.ndarray]:
    """The distance (6.1) [m] between the centers of every two robots (samples,), of the run's seed at ``place``."""
    x, y = run["x"][place], run["y"][place]
    return {(i, j): np.hypot(x[i] - x[j], y[i] - y[j]) for i, j in combinations(range(len(x)), 2)}


def clearances(run: Run, place: int) -> np.ndarray:
    """The distance [m] of each robot's rectangle from the nearest obstacle (robots, samples); infinite without any.

    ``place`` is that of the seed in the run.
    """
    x, y, heading = (run[name][place].T for name in ("x", "y", "heading"))
    if run.obstacles is None:
        return np.full(x.T.shape, np.inf)
    return obstacle_clearance(x, y, heading, footprints(run.about.robots), run.obstacles).T
