"""The table of what a robot can know: the quantities that a rule base may name as its inputs.

Each has a unit and a sentence, of which ``docs/reference/quantitiespage.py`` makes ``docs/reference/quantities.md``.
A quantity of pairs is told of each other robot: a rule base with one among its inputs is evaluated for every other
robot, and its outputs are joined.
"""

import re
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from fuzzy.naming import expected
from robotics.laws.law import ControllerError
from robotics.laws.rules.clearances import SECTOR
from robotics.laws.rules.meetings import INSIDE
from robotics.laws.rules.of_reference import later
from robotics.laws.rules.situation import BACK_TO_PATH, NOTHING_NEAR, ONWARD, SMOOTH_TIME, Situation
from robotics.world.paths.references import Reference

QUANTITIES_PAGE = "docs/reference/quantities.md"  # made of this table; messages name it
CRUISE = 0.2  # m/s: a robot that is slower is taken to go on at this speed


@dataclass(frozen=True)
class Quantity:
    """One quantity that a robot can know."""

    unit: str
    meaning: str
    of: Callable[[Situation], Any]  # (runs, robots), of pairs (runs, robots, others)
    pair: bool = False  # whether it is told of each other robot
    radio: bool = False  # whether robots must tell each other where they are
    ranges: bool = False  # whether it needs range sensors; without them it tells that nothing is near
    sensor: str = ""  # the range sensor that it needs
    robot: int = 0  # the number of the robot that it is of


def _sector(number: int) -> Callable[[Situation], np.ndarray]:
    return lambda s: np.minimum(s.clear[number], NOTHING_NEAR)


def _mirrored(left: int, right: int) -> Callable[[Situation], np.ndarray]:
    return lambda s: np.minimum(s.on_wall_side(left, right), NOTHING_NEAR)


def _lead(s: Situation) -> np.ndarray:
    """How much earlier the robot would be through than the other would come [s]."""
    m, heard = s.meeting, s.seen.heard
    mine = np.maximum(np.abs(s.seen.v), CRUISE)[:, :, None]
    them = np.maximum(np.hypot(heard["v_x"], heard["v_y"]), CRUISE) if heard.fields else CRUISE
    return np.clip(m.theirs / them - (np.maximum(m.way, 0.0) + m.through) / mine, -NOTHING_NEAR, NOTHING_NEAR)


def _heard(name: str) -> Callable[[Situation], np.ndarray]:
    return lambda s: np.nan_to_num(s.seen.heard[name]) if s.seen.heard.fields else np.zeros_like(s.seen.heard.age)


def _their_lag(s: Situation) -> np.ndarray:
    lags = s.their_due - s.others.place
    return np.nan_to_num(lags)


_OWN = {
    "time": Quantity("s", "time since the start", lambda s: np.full_like(s.place, s.seen.time)),
    "v": Quantity("m/s", "the robot's speed, by its encoders", lambda s: s.seen.v),
    "w": Quantity("rad/s", "its turn rate, by its encoders", lambda s: s.seen.w),
    "v_command": Quantity("m/s", "the speed that was commanded last, before a low-pass", lambda s: s.recall.v_command),
    "w_command": Quantity(
        "rad/s", "the turn rate that was commanded last, before a low-pass", lambda s: s.recall.w_command
    ),
}
_TARGET = {
    "distance": Quantity("m", "distance to the target, d_RP of (2.35)", lambda s: np.hypot(s.error.x, s.error.y)),
    "alpha": Quantity("rad", "bearing of the target; > 0: to the left", lambda s: np.arctan2(s.error.y, s.error.x)),
    "x_err": Quantity("m", "the target is so far ahead, (5.9)", lambda s: s.error.x),
    "y_err": Quantity("m", "the target is so far to the left, (5.9)", lambda s: s.error.y),
    "heading_err": Quantity("rad", "heading of the target from the robot's, (5.9)", lambda s: s.error.heading),
    "x_err_smooth": Quantity("m", f"x_err, smoothed over {SMOOTH_TIME:g} s", lambda s: s.smooth_error.x),
    "y_err_smooth": Quantity("m", f"y_err, smoothed over {SMOOTH_TIME:g} s", lambda s: s.smooth_error.y),
    "heading_err_smooth": Quantity(
        "rad", f"heading_err, smoothed over {SMOOTH_TIME:g} s", lambda s: s.smooth_error.heading
    ),
    "target_v": Quantity("m/s", "speed of the target, v_d", lambda s: np.broadcast_to(s.target.v, s.place.shape)),
    "target_w": Quantity("rad/s", "turn rate of the target, ω_d", lambda s: np.broadcast_to(s.target.w, s.place.shape)),
}
_PATH = {
    "cross_track": Quantity("m", "the robot is so far to the left of its path", lambda s: s.cross_track),
    "path_bearing": Quantity(
        "rad",
        f"bearing of the path's point {BACK_TO_PATH:g} m beyond the nearest one; > 0: to the left",
        lambda s: s.path_bearing,
    ),
    "curvature": Quantity("1/m", "of the path at the nearest point", lambda s: s.nearest.curvature),
    "progress": Quantity("1", "share of the path that lies behind", lambda s: s.paths.share(s.place)),
    "remaining": Quantity("m", "way to the path's end", lambda s: s.remaining),
    "lag": Quantity("m", "the robot's place on its path is so far behind the sample due", lambda s: s.due.s - s.place),
    "late": Quantity("s", "the clock is so far behind the timetable", lambda s: s.seen.time - s.recall.clock),
    "gives_way": Quantity("1", "how much the robot gives way to others", lambda s: s.recall.yields),
    "stuck": Quantity("s", "time without progress along the path", lambda s: s.stuck),
}
_FORMATION = {
    "leader_ahead": Quantity(
        "m",
        "robot 1 is so far ahead, along its path, of the place level with the robot; for robot 1: ahead of the others' "
        "mean",
        lambda s: s.leader_ahead,
        radio=True,
    ),
    "stretch": Quantity("1", "way on the own path for each metre of the path of robot 1, here", lambda s: s.stretch),
    "onward_bearing": Quantity(
        "rad",
        f"bearing of the path's point {ONWARD:g} m beyond the nearest one; beyond its end the path goes on in an arc",
        lambda s: s.onward_bearing,
    ),
}
_ROOM = {
    "front": Quantity(
        "m",
        "room ahead",
        lambda s: np.minimum(np.minimum(s.clear[SECTOR.front_left], s.clear[SECTOR.front_right]), NOTHING_NEAR),
    ),
    "front_left": Quantity("m", "room ahead on the left", _sector(SECTOR.front_left)),
    "front_right": Quantity("m", "room ahead on the right", _sector(SECTOR.front_right)),
    "left": Quantity("m", "room on the left", _sector(SECTOR.left)),
    "right": Quantity("m", "room on the right", _sector(SECTOR.right)),
    "behind": Quantity("m", "room behind", _sector(SECTOR.behind)),
    "room": Quantity("m", "the least room on all sides", lambda s: s.nearest_room),
    "coming": Quantity(
        "m", "how much nearer the nearest thing came within the last second than the robot drove", lambda s: s.coming
    ),
    "way_back": Quantity("m", "the ground behind that the robot has just driven, straight", lambda s: s.way_back),
    "kept": Quantity("1", "how firmly the robot keeps to one side of an obstacle", lambda s: np.abs(s.recall.side)),
    "wall": Quantity(
        "m", "room on the side of the obstacle that the robot goes round", _mirrored(SECTOR.left, SECTOR.right)
    ),
    "beyond": Quantity("m", "room on the other side", _mirrored(SECTOR.right, SECTOR.left)),
    "front_wall": Quantity("m", "room ahead on that side", _mirrored(SECTOR.front_left, SECTOR.front_right)),
    "front_open": Quantity("m", "room ahead on the other side", _mirrored(SECTOR.front_right, SECTOR.front_left)),
    "lean": Quantity("m", "how much more room there is ahead on that other side, smoothed", lambda s: s.way * s.lean),
    "lost": Quantity("s", "time since that obstacle was seen", lambda s: s.lost),
    "path_away": Quantity("rad", "bearing of the path; > 0: away from the obstacle", lambda s: s.way * s.path_bearing),
}
_UNSENSED = {"way_back", "kept", "path_away"}  # what of it the robot remembers, or knows by its path
_PAIRS = {
    "gap": Quantity("m", "between the circles in which the two robots turn", lambda s: s.others.gap),
    "bearing": Quantity("rad", "of the other robot; > 0: it is on the left", lambda s: s.others.bearing),
    "closing": Quantity("m/s", "speed by which the gap shrinks", lambda s: s.others.closing),
    "right_of_way": Quantity("1", "1: the robot goes before the other; -1: the other does", lambda s: s.right_of_way),
    "meeting": Quantity(
        "m", f"way to the line before the place where the paths meet; {INSIDE:g}: beyond it", lambda s: s.meeting.way
    ),
    "their_meeting": Quantity("m", "the same for the other robot", lambda s: s.meeting.theirs),
    "lead": Quantity("s", "the robot would be through the meeting so much before the other comes", _lead),
    "age": Quantity(
        "s", "of what was heard last of the other robot", lambda s: np.minimum(s.seen.heard.age, NOTHING_NEAR)
    ),
    "their_lag": Quantity("m", "the other robot is so far behind the sample due", _their_lag),
    "their_yield": Quantity("1", "how much the other robot gives way", _heard("yields")),
    "their_stuck": Quantity("s", "time for which the other robot has made no progress", _heard("stuck")),
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
    "ahead": Quantity("m", "robot N is so far ahead, along the robot's heading", lambda s: s.others.ahead),
    "left": Quantity("m", "robot N is so far to the left", lambda s: s.others.left),
    "v": Quantity("m/s", "speed of robot N", lambda s: np.hypot(s.others.v_x, s.others.v_y)),
    "gap": _PAIRS["gap"],
    "bearing": _PAIRS["bearing"],
    "closing": _PAIRS["closing"],
    "lag": _PAIRS["their_lag"],
    "age": _PAIRS["age"],
}
_LATER: dict[str, tuple[str, str, Callable[[Reference], Any]]] = {  # unit, meaning, and how it is made
    "target_v": ("m/s", "speed of the reference so many seconds from now", lambda r: r.v),
    "target_w": ("rad/s", "turn rate of the reference so many seconds from now", lambda r: r.w),
    "target_curvature": (
        "1/m",
        "curvature of the reference's path so many seconds from now; 0 where it stands",
        lambda r: np.divide(r.w, r.v, out=np.zeros_like(r.w), where=r.v != 0),
    ),
}
PATTERNS: dict[str, tuple[str, str]] = {  # the quantities with a number or a name in theirs: unit and meaning
    **{f"robotN_{name}": (q.unit, q.meaning) for name, q in NUMBERED.items()},
    **{f"{name}:SECONDS": (unit, meaning) for name, (unit, meaning, _) in _LATER.items()},
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
        return _reading(name.removeprefix(_RANGE))
    if at := later(name):
        (unit, meaning, of), ahead = _LATER[at[0]], at[1]
        return Quantity(unit, meaning, lambda s: np.broadcast_to(of(s.later(ahead)), s.place.shape))
    if found := numbered(name):
        return _of_robot(found[0], NUMBERED[found[1]])
    known = [*RULE_QUANTITIES, *PATTERNS]
    raise ControllerError(
        f"{where}: " + expected(name, known, "quantity that a robot knows") + f"; {QUANTITIES_PAGE} tells what each is"
    )


def numbered(name: str) -> tuple[int, str] | None:
    """The number of a robot, from 0, and which of NUMBERED a quantity is of it; None of any other."""
    found = _ROBOT.fullmatch(name)
    return (int(found[1]) - 1, found[2]) if found and found[2] in NUMBERED else None


def _reading(sensor: str) -> Quantity:
    def of(s: Situation) -> np.ndarray:
        return np.full_like(s.place, np.inf) if s.seen.ranges is None else s.seen.ranges[sensor]

    return Quantity("m", f"what {sensor} reads", of, ranges=True, sensor=sensor)


def _of_robot(number: int, quantity: Quantity) -> Quantity:
    """The quantity of one robot, counted from 0; of itself it is 0, and of a robot that does not exist unknown."""

    def of(s: Situation) -> np.ndarray:
        row = np.broadcast_to(quantity.of(s), (*s.place.shape, s.place.shape[1]))
        if number >= s.place.shape[1]:
            return np.full_like(s.place, np.nan)
        one = np.array(row[..., number])
        one[:, number] = 0.0
        return one

    return replace(quantity, of=of, radio=True, robot=number + 1)
