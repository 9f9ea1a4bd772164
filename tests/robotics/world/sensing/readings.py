"""Range sensors that are read period by period, without a simulation."""

import numpy as np

from robotics.world.environment.world import Geometry, Moving
from robotics.world.sensing.carried import CarriedSensors, look

TICK = 0.05


class Readings:
    """The readings of robots that all carry the same sensors, or each its own, in runs of some seeds."""

    def __init__(self, sensors, seeds, sizes, geometry: Geometry, *, carried=None):
        """``sensors`` is a sequence, ``carried`` the sensors by name of each robot instead; ``sizes`` (3, robots)."""
        self.robots, self.runs = sizes.shape[1], len(seeds)
        named = {str(n): sensor for n, sensor in enumerate(sensors)}
        self.carried = CarriedSensors.opened(carried or [named] * self.robots, self.robots, seeds, TICK)
        self.looks = self.carried.looks(geometry, Moving.nothing(), np.tile(sizes, self.runs))

    def at(self, k, x, y, heading):
        """What all sensors read in period ``k`` (runs, robots, sensors) [m]; poses are (runs, robots)."""
        self.carried.supply(self.looks, k)
        poses = np.stack([np.ravel(row).astype(float) for row in (x, y, heading)])
        look(self.looks, k, poses, self.robots, np.empty((0, poses.shape[1])), np.ones(self.runs, dtype=bool))
        return self.looks.readings.reshape(self.runs, self.robots, -1).copy()
