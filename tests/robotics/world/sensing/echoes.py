"""What range sensors without noise, least range and failures read: an oracle of tests that look at walls."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from robotics.world.environment.collision import for_runs
from robotics.world.environment.world import Geometry, Moving
from robotics.world.sensing.carried import CarriedSensors, look
from robotics.world.sensing.sonar import RangeSensor


def exact_echoes(
    sensors: Sequence[RangeSensor],
    x: np.ndarray,
    y: np.ndarray,
    heading: np.ndarray,
    sizes: np.ndarray,
    geometry: Geometry,
) -> np.ndarray:
    """The exact distances [m] that robots which all carry ``sensors`` would read (runs, robots, sensors).

    There is no noise, no minimum and no failure. The other arguments are as of
    :func:`robotics.world.environment.collision.obstacle_contacts`.
    """
    carried = {str(n): _exact(sensor) for n, sensor in enumerate(sensors)}
    opened = CarriedSensors.opened([carried], x.shape[1], [0] * x.shape[0], 1.0)
    looks = opened.looks(for_runs(geometry, len(x)), Moving.nothing(), np.tile(sizes, len(x)))
    poses = np.stack([np.ravel(row) for row in (x, y, heading)]).astype(float)
    look(looks, 0, poses, x.shape[1], np.empty((0, x.size)), np.ones(len(x), dtype=bool))
    return looks.readings.reshape(*x.shape, len(sensors))


def _exact(sensor: RangeSensor) -> RangeSensor:
    """A sensor that reads the distance itself, every second."""
    sensor = replace(sensor, noise=0.0, relative_noise=0.0, minimum=0.0, dropout=0.0, crosstalk=0.0)
    return replace(sensor, period=1.0, failure_start=None, failure_end=None)
