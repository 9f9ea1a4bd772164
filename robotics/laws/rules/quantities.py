"""The table of what a robot can know: the quantities that a rule base may name as its inputs.

Each has a unit and a sentence, of which ``docs/reference/quantitiespage.py`` makes ``docs/reference/quantities.md``.
A quantity of pairs is told of each other robot: a rule base with one among its inputs is evaluated for every other
robot, and its outputs are joined.

:mod:`robotics.laws.rules.perception` computes them, in compiled code. Another package adds one of the robot itself with
a function that tells it, before it imports a law: laws are compiled with it when they first drive.

    @compiled_only
    def east(robot, memory, known, i, now):
        return robot.x

    RULE_QUANTITIES["east"] = Quantity("m", "how far east the robot is", of=east)
"""

import re
from dataclasses import dataclass, field, replace
from typing import Any

from fuzzy.naming import expected
from robotics.laws.law import ControllerError
from robotics.laws.rules.meetings import INSIDE
from robotics.laws.rules.of_reference import later
from robotics.laws.rules.situation import BACK_TO_PATH, ONWARD, SMOOTH_TIME

QUANTITIES_PAGE = "docs/reference/quantities.md"  # made of this table; messages name it
CRUISE = 0.2  # m/s: a robot that is slower is taken to go on at this speed


@dataclass(frozen=True)
class Quantity:
    """One quantity that a robot can know."""

    unit: str
    meaning: str
    pair: bool = False  # whether it is told of each other robot
    radio: bool = False  # whether robots must tell each other where they are
    ranges: bool = False  # whether it needs range sensors; without them it tells that nothing is near
    sensor: str = ""  # the range sensor that it needs
    robot: int = 0  # the number of the robot that it is of
    # Of another package: a compiled function of RobotColumns, RecallColumns, Known, the lane and PerceivedColumns
    of: Any = field(default=None, compare=False)


_OWN = {
    "time": Quantity("s", "time since the start"),
    "v": Quantity("m/s", "the robot's speed, by its encoders"),
    "w": Quantity("rad/s", "its turn rate, by its encoders"),
    "v_command": Quantity("m/s", "the speed that was commanded last, before a low-pass"),
    "w_command": Quantity("rad/s", "the turn rate that was commanded last, before a low-pass"),
}
_TARGET = {
    "distance": Quantity("m", "distance to the target, d_RP of (2.35)"),
    "alpha": Quantity("rad", "bearing of the target; > 0: to the left"),
    "x_err": Quantity("m", "the target is so far ahead, (5.9)"),
    "y_err": Quantity("m", "the target is so far to the left, (5.9)"),
    "heading_err": Quantity("rad", "heading of the target from the robot's, (5.9)"),
    "x_err_smooth": Quantity("m", f"x_err, smoothed over {SMOOTH_TIME:g} s"),
    "y_err_smooth": Quantity("m", f"y_err, smoothed over {SMOOTH_TIME:g} s"),
    "heading_err_smooth": Quantity("rad", f"heading_err, smoothed over {SMOOTH_TIME:g} s"),
    "target_v": Quantity("m/s", "speed of the target, v_d"),
    "target_w": Quantity("rad/s", "turn rate of the target, ω_d"),
}
_PATH = {
    "cross_track": Quantity("m", "the robot is so far to the left of its path"),
    "path_bearing": Quantity(
        "rad",
        f"bearing of the path's point {BACK_TO_PATH:g} m beyond the nearest one; > 0: to the left",
    ),
    "curvature": Quantity("1/m", "of the path at the nearest point"),
    "progress": Quantity("1", "share of the path that lies behind"),
    "remaining": Quantity("m", "way to the path's end"),
    "lag": Quantity("m", "the robot's place on its path is so far behind the sample due"),
    "late": Quantity("s", "the clock is so far behind the timetable"),
    "gives_way": Quantity("1", "how much the robot gives way to others"),
    "stuck": Quantity("s", "time without progress along the path"),
}
_FORMATION = {
    "leader_ahead": Quantity(
        "m",
        "robot 1 is so far ahead, along its path, of the place level with the robot; for robot 1: ahead of the others' "
        "mean",
        radio=True,
    ),
    "stretch": Quantity("1", "way on the own path for each metre of the path of robot 1, here"),
    "onward_bearing": Quantity(
        "rad",
        f"bearing of the path's point {ONWARD:g} m beyond the nearest one; beyond its end the path goes on in an arc",
    ),
}
_ROOM = {
    "front": Quantity(
        "m",
        "room ahead",
    ),
    "front_left": Quantity("m", "room ahead on the left"),
    "front_right": Quantity("m", "room ahead on the right"),
    "left": Quantity("m", "room on the left"),
    "right": Quantity("m", "room on the right"),
    "behind": Quantity("m", "room behind"),
    "room": Quantity("m", "the least room on all sides"),
    "coming": Quantity("m", "how much nearer the nearest thing came within the last second than the robot drove"),
    "way_back": Quantity("m", "the ground behind that the robot has just driven, straight"),
    "kept": Quantity("1", "how firmly the robot keeps to one side of an obstacle"),
    "wall": Quantity("m", "room on the side of the obstacle that the robot goes round"),
    "beyond": Quantity("m", "room on the other side"),
    "front_wall": Quantity("m", "room ahead on that side"),
    "front_open": Quantity("m", "room ahead on the other side"),
    "lean": Quantity("m", "how much more room there is ahead on that other side, smoothed"),
    "lost": Quantity("s", "time since that obstacle was seen"),
    "path_away": Quantity("rad", "bearing of the path; > 0: away from the obstacle"),
}
_UNSENSED = {"way_back", "kept", "path_away"}  # what of it the robot remembers, or knows by its path
_PAIRS = {
    "gap": Quantity("m", "between the circles in which the two robots turn"),
    "bearing": Quantity("rad", "of the other robot; > 0: it is on the left"),
    "closing": Quantity("m/s", "speed by which the gap shrinks"),
    "right_of_way": Quantity("1", "1: the robot goes before the other; -1: the other does"),
    "meeting": Quantity("m", f"way to the line before the place where the paths meet; {INSIDE:g}: beyond it"),
    "their_meeting": Quantity("m", "the same for the other robot"),
    "lead": Quantity("s", "the robot would be through the meeting so much before the other comes"),
    "age": Quantity("s", "of what was heard last of the other robot"),
    "their_lag": Quantity("m", "the other robot is so far behind the sample due"),
    "their_yield": Quantity("1", "how much the other robot gives way"),
    "their_stuck": Quantity("s", "time for which the other robot has made no progress"),
}
QUANTITY_GROUPS: dict[str, dict[str, Quantity]] = {
    "Its own motion": _OWN,
    "The target": _TARGET,
    "The path and the timetable": _PATH,
    "The formation": _FORMATION,
    "The room around it": {name: replace(q, ranges=name not in _UNSENSED) for name, q in _ROOM.items()},
    "Each other robot": {name: replace(quantity, pair=True, radio=True) for name, quantity in _PAIRS.items()},
}
RULE_QUANTITIES: dict[str, Quantity] = {
    name: quantity for group in QUANTITY_GROUPS.values() for name, quantity in group.items()
}
NUMBERED: dict[str, Quantity] = {
    "ahead": Quantity("m", "robot N is so far ahead, along the robot's heading"),
    "left": Quantity("m", "robot N is so far to the left"),
    "v": Quantity("m/s", "speed of robot N"),
    "gap": _PAIRS["gap"],
    "bearing": _PAIRS["bearing"],
    "closing": _PAIRS["closing"],
    "lag": _PAIRS["their_lag"],
    "age": _PAIRS["age"],
}
_LATER = {
    "target_v": Quantity("m/s", "speed of the reference so many seconds from now"),
    "target_w": Quantity("rad/s", "turn rate of the reference so many seconds from now"),
    "target_curvature": Quantity(
        "1/m", "curvature of the reference's path so many seconds from now; 0 where it stands"
    ),
}
PATTERNS: dict[str, tuple[str, str]] = {  # the quantities with a number or a name in theirs: unit and meaning
    **{f"robotN_{name}": (q.unit, q.meaning) for name, q in NUMBERED.items()},
    **{f"{name}:SECONDS": (q.unit, q.meaning) for name, q in _LATER.items()},
    "range:NAME": ("m", "what the range sensor of that name reads"),
}
_ROBOT = re.compile(r"robot([1-9]\d*)_(\w+)")
_RANGE = "range:"


def quantity_of(name: str, where: str) -> Quantity:
    """The quantity that a rule base calls ``name``. Raises ControllerError with the table for an unknown one.

    ``where`` is what the message calls the rule base.
    """
    if name in RULE_QUANTITIES:
        return RULE_QUANTITIES[name]
    if name.startswith(_RANGE) and name != _RANGE:
        sensor = name.removeprefix(_RANGE)
        return Quantity("m", f"what {sensor} reads", ranges=True, sensor=sensor)
    if at := later(name):
        return _LATER[at[0]]
    if found := numbered(name):
        return replace(NUMBERED[found[1]], radio=True, robot=found[0] + 1)
    known = [*RULE_QUANTITIES, *PATTERNS]
    raise ControllerError(
        f"{where}: " + expected(name, known, "quantity that a robot knows") + f"; {QUANTITIES_PAGE} tells what each is"
    )


def numbered(name: str) -> tuple[int, str] | None:
    """The number of a robot, from 0, and which of NUMBERED a quantity is of it; None of any other."""
    found = _ROBOT.fullmatch(name)
    return (int(found[1]) - 1, found[2]) if found and found[2] in NUMBERED else None
