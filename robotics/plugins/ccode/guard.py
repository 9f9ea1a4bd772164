"""The monitor of passive safety for C: what its compiled functions read, as terms of C, and what the robot keeps."""

import math
from typing import Any, NamedTuple

import numpy as np

from fuzzy.plugins.ccode.numbertype import ExportError
from robotics.laws.law import Law
from robotics.laws.setting import Setting
from robotics.plugins.ccode.terms import CArray, CTable, Lane
from robotics.simulation.safety.coverage import blind_spots
from robotics.simulation.safety.opening import guard_on_board, is_guarded

_LANE = 0  # of an axis of lanes: C has none
_NO_BOUND = 1e299  # m/s²: what is more bounds nothing


class _Silence(NamedTuple):
    """The radio of a robot that is alone."""

    values: int = 0


class CGuard:
    """The monitor of one robot that is alone; its attributes are those of MonitorLanes, as terms of C."""

    def __init__(self, law: Law[Any], setting: Setting) -> None:
        known = guard_on_board(setting, law)
        self.air = _Silence()
        self.sees, self.latency = known.sees, known.latency
        self.numbers, self.sensors = known.given[:, 0], np.asarray(known.table)
        self.given, self.table = CTable("given"), CTable("sensors")
        self.names = tuple(setting.sensors[0])
        self.told = blind_spots(setting, law, on_board=True)
        cells = known.ground.shape[1]
        self.ground = CArray("state->ground", "int", (_LANE, cells, cells), "guard")
        self.window = CArray("state->window", "int", (_LANE, 2), "guard")
        self.sent = CArray("state->sent", "real", (len(known.sent), 2, _LANE), "guard")
        self.held = CArray("state->held", "real", (2, _LANE), "guard")
        first, last = known.begin[0], known.end[0]
        self.begin = CArray("BEGIN", "int", (_LANE,), values=np.array([first]))
        self.end = CArray("END", "int", (_LANE,), values=np.array([last]))
        self.every = CArray("EVERY", "int", (len(known.every),), values=known.every)
        self.column = CArray("READING", "int", (len(known.column),), values=known.column)
        self.rays = CArray("RAYS", "real", known.rays.shape, values=known.rays)
        self.first_ray = CArray("FIRST_RAY", "int", known.first_ray.shape, values=known.first_ray)
        self.readings = CArray("input->ranges", "real", (_LANE, len(self.names)), "readings")

    def __repr__(self) -> str:
        """One name for all: there is but one in a file of C."""
        return "guard"

    @property
    def kept(self) -> dict[str, str]:
        """The declarations of what the robot keeps, each with what it is."""
        cells, flights = self.ground.shape[1], self.sent.shape[0]
        return {
            "int k": "the period, from 0",
            f"int ground[{cells}][{cells}]": "0: never seen; -1: free; others: when there was an echo from there",
            "int window[2]": "its first cell in x and in y",
            f"REAL sent[{flights}][2]": "m/s and rad/s: orders on their way to the wheels",
            "REAL held[2]": "likewise: the order that the wheels have",
        }

    @property
    def room(self) -> int:
        """How many numbers that is at most."""
        return 8 + math.prod(self.ground.shape[1:]) + 2 * self.sent.shape[0]

    def number(self, lane: Lane, name: str) -> float | CArray:
        """What is known of a column of GuardColumns or of SensorColumns: a number, or one for each sensor."""
        if lane.name == "given":
            value = float(self.numbers[lane.first + lane.of.columns[name].row])
            return value if abs(value) < _NO_BOUND else math.inf
        row = self.sensors[lane.of.columns[name].row]
        if (row == row[0]).all():
            return float(row[0])
        return CArray(f"SENSOR_{name.upper()}", "real", row.shape, values=row)


def guard_of(law: Law[Any], setting: Setting, name: str) -> CGuard | None:
    """The monitor below a law, or None. Raises ExportError where it has to hear other robots."""
    if not is_guarded(setting, law):
        return None
    if len(setting.robots) > 1:
        raise ExportError(
            f"{name}: passive safety in C is of a robot that is alone, and {setting.name} has {len(setting.robots)}, "
            "whose monitors hear each other by radio; accepted: a scenario of one robot, the ROS 2 controller, or "
            "safe=no behind the law"
        )
    if not setting.sensors[0]:
        raise ExportError(f"{name}: passive safety needs range sensors, and the robot of {setting.name} has none")
    return CGuard(law, setting)
