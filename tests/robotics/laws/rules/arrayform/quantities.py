"""What robots know of each quantity, on arrays: (runs, robots), of pairs (runs, robots, others)."""

from collections.abc import Callable
from typing import Any

import numpy as np

from robotics.laws.rules.clearances import SECTOR
from robotics.laws.rules.of_reference import later
from robotics.laws.rules.quantities import CRUISE, numbered
from robotics.laws.rules.situation import NOTHING_NEAR
from robotics.world.paths.references import Reference
from tests.robotics.laws.rules.arrayform.situation import Situation


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


KNOWN: dict[str, Callable[[Situation], Any]] = {
    "time": lambda s: np.full_like(s.place, s.seen.time),
    "v": lambda s: s.seen.v,
    "w": lambda s: s.seen.w,
    "v_command": lambda s: s.recall.v_command,
    "w_command": lambda s: s.recall.w_command,
    "distance": lambda s: np.hypot(s.error.x, s.error.y),
    "alpha": lambda s: np.arctan2(s.error.y, s.error.x),
    "x_err": lambda s: s.error.x,
    "y_err": lambda s: s.error.y,
    "heading_err": lambda s: s.error.heading,
    "x_err_smooth": lambda s: s.smooth_error.x,
    "y_err_smooth": lambda s: s.smooth_error.y,
    "heading_err_smooth": lambda s: s.smooth_error.heading,
    "target_v": lambda s: np.broadcast_to(s.target.v, s.place.shape),
    "target_w": lambda s: np.broadcast_to(s.target.w, s.place.shape),
    "cross_track": lambda s: s.cross_track,
    "path_bearing": lambda s: s.path_bearing,
    "curvature": lambda s: s.nearest.curvature,
    "progress": lambda s: s.paths.share(s.place),
    "remaining": lambda s: s.remaining,
    "lag": lambda s: s.due.s - s.place,
    "late": lambda s: s.seen.time - s.recall.clock,
    "gives_way": lambda s: s.recall.yields,
    "stuck": lambda s: s.stuck,
    "leader_ahead": lambda s: s.leader_ahead,
    "stretch": lambda s: s.stretch,
    "onward_bearing": lambda s: s.onward_bearing,
    "front": lambda s: np.minimum(np.minimum(s.clear[SECTOR.front_left], s.clear[SECTOR.front_right]), NOTHING_NEAR),
    "front_left": _sector(SECTOR.front_left),
    "front_right": _sector(SECTOR.front_right),
    "left": _sector(SECTOR.left),
    "right": _sector(SECTOR.right),
    "behind": _sector(SECTOR.behind),
    "room": lambda s: s.nearest_room,
    "coming": lambda s: s.coming,
    "way_back": lambda s: s.way_back,
    "kept": lambda s: np.abs(s.recall.side),
    "wall": _mirrored(SECTOR.left, SECTOR.right),
    "beyond": _mirrored(SECTOR.right, SECTOR.left),
    "front_wall": _mirrored(SECTOR.front_left, SECTOR.front_right),
    "front_open": _mirrored(SECTOR.front_right, SECTOR.front_left),
    "lean": lambda s: s.way * s.lean,
    "lost": lambda s: s.lost,
    "path_away": lambda s: s.way * s.path_bearing,
    "gap": lambda s: s.others.gap,
    "bearing": lambda s: s.others.bearing,
    "closing": lambda s: s.others.closing,
    "right_of_way": lambda s: s.right_of_way,
    "meeting": lambda s: s.meeting.way,
    "their_meeting": lambda s: s.meeting.theirs,
    "lead": _lead,
    "age": lambda s: np.minimum(s.seen.heard.age, NOTHING_NEAR),
    "their_lag": _their_lag,
    "their_yield": _heard("yields"),
    "their_stuck": _heard("stuck"),
}
_NUMBERED: dict[str, Callable[[Situation], Any]] = {
    "ahead": lambda s: s.others.ahead,
    "left": lambda s: s.others.left,
    "v": lambda s: np.hypot(s.others.v_x, s.others.v_y),
    "gap": KNOWN["gap"],
    "bearing": KNOWN["bearing"],
    "closing": KNOWN["closing"],
    "lag": KNOWN["their_lag"],
    "age": KNOWN["age"],
}
_LATER: dict[str, Callable[[Reference], Any]] = {
    "target_v": lambda r: r.v,
    "target_w": lambda r: r.w,
    "target_curvature": lambda r: np.divide(r.w, r.v, out=np.zeros_like(r.w), where=r.v != 0),
}


def known(name: str, s: Situation) -> np.ndarray:
    """What the robots know of the quantity ``name``."""
    if name in KNOWN:
        return np.asarray(KNOWN[name](s), dtype=float)
    if name.startswith("range:"):
        return np.full_like(s.place, np.inf) if s.seen.ranges is None else s.seen.ranges[name.removeprefix("range:")]
    if at := later(name):
        return np.broadcast_to(_LATER[at[0]](s.later(at[1])), s.place.shape)
    found = numbered(name)
    assert found, name
    return _of_robot(found[0], np.asarray(_NUMBERED[found[1]](s)), s)


def _of_robot(number: int, row: np.ndarray, s: Situation) -> np.ndarray:
    """What is known of one robot, counted from 0; of itself it is 0, and of a robot that does not exist unknown."""
    if number >= s.place.shape[1]:
        return np.full_like(s.place, np.nan)
    one = np.array(np.broadcast_to(row, (*s.place.shape, s.place.shape[1]))[..., number])
    one[:, number] = 0.0
    return one
