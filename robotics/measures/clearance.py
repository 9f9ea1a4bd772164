"""Distances between robots and to obstacles, and the one definition of a touch: a distance of 0 between surfaces."""

from itertools import combinations

import numpy as np

from robotics.environment.collision import footprints, obstacle_clearance, robot_contacts
from robotics.simulation.run import Run

TOUCH = 0.0  # m between two surfaces: at this distance they touch


def touching(clearance: np.ndarray) -> np.ndarray:
    """Whether surfaces at the distance ``clearance`` [m] touch; an array of bool of the same shape."""
    return np.asarray(clearance <= TOUCH)


def robots_touch(x: np.ndarray, y: np.ndarray, heading: np.ndarray, sizes: np.ndarray) -> np.ndarray:
    """Whether any two robots touch (runs,) bool, by their exact rectangles.

    Args:
        x: The robots' centers (runs, robots) [m].
        y: Likewise.
        heading: The robots' headings (runs, robots) [rad].
        sizes: The rectangles, as :func:`robotics.environment.collision.footprints` gives them.
    """
    return np.asarray((robot_contacts(x, y, heading, sizes) >= 0).any(axis=1))


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
