"""The monitor of passive safety for C: what its compiled functions read, as terms of C, and what the robot keeps."""

import math
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from fuzzy.plugins.ccode.numbertype import ExportError
from robotics.laws.equation import EquationLaw, equation
from robotics.laws.law import Law
from robotics.laws.setting import Setting
from robotics.plugins.ccode.terms import CArray, CTable, CTerm, KnownValue, Lane
from robotics.simulation.safety.coverage import blind_spots
from robotics.simulation.safety.opening import guard_on_board, is_guarded
from robotics.simulation.safety.others import HeardPosture, PromiseColumns

_LANE = 0  # of an axis of lanes: C has none
_NO_BOUND = 1e299  # m/s²: what is more bounds nothing


@equation
def pass_on(aim):  # type: ignore[no-untyped-def]
    """Want what is handed."""
    return aim.v, aim.w


@dataclass(frozen=True, kw_only=True, eq=False)
class HandedOrder(EquationLaw):
    """The place of a law that is not written in C, above its monitor: in C its order is handed to it."""

    equation = pass_on


class _Air(NamedTuple):
    """The radio as the robot has it: what its input says that it has heard."""

    values: int
    heard: CArray


class CGuard:
    """The monitor of one robot, alone or of a team; its attributes are those of MonitorLanes, as terms of C.

    Raises ExportError where the robots of a team differ.
    """

    def __init__(self, law: Law[Any], setting: Setting, name: str) -> None:
        known = guard_on_board(setting, law)
        if (known.given != known.given[:, :1]).any() or any(own != setting.sensors[0] for own in setting.sensors):
            raise ExportError(
                f"{name}: passive safety of a team in C is of robots that are alike, and those of {setting.name} "
                "differ in size, brakes, noise or sensors; accepted: robots of one file with the same sensors, the "
                "ROS 2 controller, or safe=no behind the law"
            )
        self.robots, team = len(setting.robots), known.air.values > 0
        self.lane = CTerm("state->robot", "int") if team else KnownValue(0)
        self.air = _Air(known.air.values, CArray("input->heard", "real", (HeardPosture.size, _LANE, self.robots)))
        self.delay, self.holds, self.said = known.delay, known.holds, CTable("said")
        self.promises = CArray("state->promises", "real", (*known.promises.shape[:2], _LANE), "guard")
        self.sees, self.latency = known.sees, known.latency
        self.numbers, self.sensors = known.given[:, 0], np.asarray(known.table)
        self.given, self.table = CTable("given"), CArray("sensors", "real", self.sensors.shape)
        self.names = tuple(setting.sensors[0])
        self.told = [*blind_spots(setting, law, on_board=True)]
        if isinstance(law, HandedOrder):
            self.told.append(
                "passive safety: wish_v and wish_w are what a law of yours wants, which is not in this file"
            )
        cells = known.ground.shape[1]
        self.ground = CArray("state->ground", "int", (_LANE, cells, cells), "guard")
        self.window = CArray("state->window", "int", (_LANE, 2), "guard")
        self.barred = CArray("state->barred", "int", (cells, cells), "guard")
        self.sent = CArray("state->sent", "real", (len(known.sent), 2, _LANE), "guard")
        self.held = CArray("state->held", "real", (2, _LANE), "guard")
        self.backed = CArray("state->backed", "real", (1, _LANE), "guard")
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
        promises = f"REAL promises[{PromiseColumns.size}][{self.promises.shape[1]}]"
        said = "m/s, m/s, rad/s and 1/s: how fast it has promised to drive, back and turn at most, and how that grows"
        team = {"int robot": "which of the team it is, from 0", promises: said} if self.air.values else {}
        return team | {
            "int k": "the period, from 0",
            f"int ground[{cells}][{cells}]": "0: never seen; -1: free; others: when there was an echo from there",
            "int window[2]": "its first cell in x and in y",
            f"int barred[{cells}][{cells}]": "where it is not free, found anew in every period",
            f"REAL sent[{flights}][2]": "m/s and rad/s: orders on their way to the wheels",
            "REAL held[2]": "likewise: the order that the wheels have",
            "REAL backed[1]": "s: for how long it has backed lately",
        }

    @property
    def room(self) -> int:
        """How many numbers that is at most."""
        return 9 + 2 * math.prod(self.ground.shape[1:]) + 2 * self.sent.shape[0] + math.prod(self.promises.shape[:2])

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
    """The monitor below a law, or None. Raises ExportError where it sees nothing, or the robots of a team differ."""
    if not is_guarded(setting, law):
        return None
    if not setting.sensors[0]:
        raise ExportError(f"{name}: passive safety needs range sensors, and the robot of {setting.name} has none")
    return CGuard(law, setting, name)
