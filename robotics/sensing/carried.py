"""The range sensors of a team, of which each robot may carry its own."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from robotics.environment.world import Geometry
from robotics.sensing.sonar import Echoes, Ranges, RangeSensor, SensorArray


def sensor_names(sensors: Sequence[Mapping[str, RangeSensor]]) -> tuple[str, ...]:
    """The names of all sensors that any robot carries, in the order of the first robot that has them."""
    return tuple(dict.fromkeys(name for carried in sensors for name in carried))


@dataclass(frozen=True)
class _Group:
    """Robots that carry the same sensors."""

    array: SensorArray
    robots: np.ndarray  # their places, from 0
    columns: np.ndarray  # of their sensors, in the readings of all sensors


@dataclass(frozen=True)
class CarriedSensors:
    """The range sensors of all robots of a simulation; their state is one :class:`Echoes` a group of like robots.

    Crosstalk is heard between robots that carry the same sensors.
    """

    names: tuple[str, ...]
    groups: tuple[_Group, ...]
    robots: int

    @classmethod
    def opened(
        cls, sensors: Sequence[Mapping[str, RangeSensor]], seeds: Sequence[int], tick: float
    ) -> "CarriedSensors":
        """Make the sensors of a simulation. Raises SonarError where a sensor's period does not suit ``tick``.

        Args:
            sensors: The sensors of each robot, by name.
            seeds: One for each run.
            tick: The control period [s].
        """
        names = sensor_names(sensors)
        groups: list[_Group] = []
        kinds: list[Mapping[str, RangeSensor]] = []
        for carried in sensors:
            if carried and carried not in kinds:
                kinds.append(carried)
        for kind in kinds:
            mine = np.array([i for i, carried in enumerate(sensors) if carried == kind])
            columns = np.array([names.index(name) for name in kind])
            groups.append(_Group(SensorArray.opened(tuple(kind.values()), seeds, tick), mine, columns))
        return cls(names, tuple(groups), len(sensors))

    def init(self) -> tuple[Echoes, ...]:
        """Return the state at the start: nothing was seen yet."""
        return tuple(group.array.init(self.robots) for group in self.groups)

    def sense(
        self, state: tuple[Echoes, ...], k: int, pose: np.ndarray, sizes: np.ndarray, geometry: Geometry
    ) -> tuple[Ranges, tuple[Echoes, ...]]:
        """Return the readings of all sensors, and the state after them.

        Args:
            state: As of the period before.
            k: The control period.
            pose: The true x [m], y [m] and heading [rad] (3, runs, robots).
            sizes: The robots' sizes, of :func:`robotics.environment.collision.footprints`.
            geometry: The obstacles, of as many runs or of one world for all.
        """
        found = [
            group.array.sense(echoes, k, pose[0], pose[1], pose[2], sizes, geometry)
            for group, echoes in zip(self.groups, state, strict=True)
        ]
        if len(found) == 1 and len(self.groups[0].robots) == self.robots:
            readings = found[0][0]
        else:
            readings = np.full((*pose.shape[1:], len(self.names)), np.inf)
            for group, (own, _) in zip(self.groups, found, strict=True):
                readings[:, group.robots[:, None], group.columns] = own[:, group.robots]
        return Ranges(self.names, readings), tuple(echoes for _, echoes in found)
