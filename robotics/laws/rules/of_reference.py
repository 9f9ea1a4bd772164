"""Rule bases of a robot's own motion, path and reference, in compiled code: what it knows without anybody else.

Their inputs are those of :data:`SEEN`, and quantities of a later time such as ``target_v:0.5``; what they give may
correct the velocity (v_r, ω_r) of the reference, which is read ``lead`` ahead (:mod:`robotics.laws.knowledge`):

    v = v_r cos ψ_e + dv,   ω = ω_r + dw + max(|v_r|, min(|v|, catch_up)) bend

``bend`` is a curvature, so that a correction of the path costs the same way at any speed, as in (2.32), and at rest
as much as ``catch_up`` gives. The errors are then those of the reference at the present time. That form is a choice;
thesis 2.3 has rules for v and ω themselves.
"""

import math
import re
from collections.abc import Sequence

from fuzzy.compiled.columns import Columns, codes, column, several
from fuzzy.compiled.jit import compiled_only
from fuzzy.system import Sugeno
from robotics.laws.knowledge import share_of
from robotics.laws.rules.situation import BACK_TO_PATH, SMOOTH_TIME, TURN_TIME
from robotics.laws.teams.neighbours import OUTAGE, SEARCH_REACH, SEARCH_REACH_AFTER_OUTAGE
from robotics.world.paths.posture import wrapped_compiled
from robotics.world.paths.road import at, moving, nearest, share, timed

# The quantities that are compiled, by their names in robotics.laws.rules.quantities
BY_PATH = ("cross_track", "path_bearing", "curvature", "progress", "remaining", "lag")
SEEN = (
    "time", "v", "w", "distance", "alpha", "x_err", "y_err", "heading_err", "target_v", "target_w",
    "x_err_smooth", "y_err_smooth", "heading_err_smooth", "v_command", "w_command", *BY_PATH,
)  # fmt: skip
LATER = ("target_v", "target_w", "target_curvature")  # each with ":SECONDS" behind it
OUTPUTS = ("v", "w", "turn", "speed", "speed_factor", "dv", "dw", "bend")  # what a rule base may give here
CORRECTIONS = frozenset({"dv", "dw", "bend"})
INPUTS = 12  # at most
_SEEN, _LATER, GIVEN = codes(SEEN), codes(LATER), codes(OUTPUTS)
_NOW = len(SEEN)
HEADING_ERR = _SEEN.heading_err
_AT = re.compile(r"(\w+):(\d+(?:\.\d+)?)")


def later(name: str) -> tuple[str, float] | None:
    """The name and the time [s] of a quantity of a later time; None of any other."""
    found = _AT.fullmatch(name)
    return (found[1], float(found[2])) if found and found[1] in LATER else None


def is_of_reference(fis: Sugeno) -> bool:
    """Whether compiled code can ask a rule base: by its inputs, its outputs, and what is to be beyond its universes."""
    return asks_for_reference(fis) and bool(fis.rules) and fis.out_of_range != "error"


def asks_for_reference(fis: Sugeno) -> bool:
    """Whether inputs and outputs are those that compiled code here knows."""
    known = all(v.name in SEEN or later(v.name) for v in fis.inputs) and 0 < len(fis.inputs) <= INPUTS
    return known and all(v.name in OUTPUTS for v in fis.outputs)


class AskedColumns(Columns):
    """How a rule base is asked."""

    count = column("", "of its inputs; 0: there is none")
    begin = column("", "where it begins among the packed rule bases")
    composite = column("", "1: it is a tree or a type-2 system")
    places = several(INPUTS, "", "of its inputs in SEEN, and behind those in LATER")
    times = several(INPUTS, "s", "from now, of those of a later time")
    given = several(len(OUTPUTS), "", "where it gives each of OUTPUTS; -1: it does not")
    corrects = column("", "1: the velocity of the reference")
    on_path = column("", "1: for some of BY_PATH")
    smoothing = column("1", "of a new error in the smoothed one")


class RecalledColumns(Columns):
    """What is remembered for it."""

    started = column("", "1: there was a period before")
    x_err = column("m", "smoothed")
    y_err = column("m", "smoothed")
    heading_err = column("rad", "smoothed")
    v = column("m/s", "the last command")
    w = column("rad/s", "the last command")
    place = column("m", "the abscissa of the path's nearest point")


class AskingColumns(Columns):
    """What it is asked in."""

    seen = several(len(SEEN), "", "all of SEEN")
    asked = several(INPUTS, "", "its inputs")
    said = several(len(OUTPUTS), "", "what it gives")


def asked_columns(fis: Sugeno, begin: int, period: float) -> dict[str, float | Sequence[float]]:
    """The numbers of :class:`AskedColumns` for a rule base that begins at ``begin``, asked every ``period`` [s]."""
    names, gives = [v.name for v in fis.inputs], [v.name for v in fis.outputs]
    at = [later(name) for name in names]
    places = [SEEN.index(n) if t is None else len(SEEN) + LATER.index(t[0]) for n, t in zip(names, at, strict=True)]
    rest = [0] * (INPUTS - len(names))
    return {
        "count": len(names),
        "begin": begin,
        "composite": 0.0,
        "places": [*places, *rest],
        "times": [*(0.0 if t is None else t[1] for t in at), *rest],
        "given": [gives.index(name) if name in gives else -1 for name in OUTPUTS],
        "corrects": float(bool(CORRECTIONS & {*gives})),
        "on_path": float(bool({*BY_PATH} & {*names})),
        "smoothing": share_of(SMOOTH_TIME, period),
    }


@compiled_only
def see(robot, aim, time, ask, recalled, work):  # type: ignore[no-untyped-def]
    """Write what a robot knows of itself and of an aim into ``work.seen``, and remember the smoothed errors."""
    dx, dy = aim.x - robot.x, aim.y - robot.y
    cos, sin = math.cos(robot.heading), math.sin(robot.heading)
    x_err, y_err = cos * dx + sin * dy, cos * dy - sin * dx  # (5.9)
    heading_err = wrapped_compiled(aim.heading - robot.heading)
    part = 1.0 if recalled.started == 0 else ask.smoothing
    recalled.started = 1.0
    recalled.x_err += part * (x_err - recalled.x_err)
    recalled.y_err += part * (y_err - recalled.y_err)
    recalled.heading_err += part * wrapped_compiled(heading_err - recalled.heading_err)
    seen = work.seen
    seen[_SEEN.time], seen[_SEEN.v], seen[_SEEN.w] = time, robot.v, robot.w
    seen[_SEEN.distance], seen[_SEEN.alpha] = math.hypot(dx, dy), math.atan2(y_err, x_err)
    seen[_SEEN.x_err], seen[_SEEN.y_err], seen[_SEEN.heading_err] = x_err, y_err, heading_err
    seen[_SEEN.target_v], seen[_SEEN.target_w] = aim.v, aim.w
    seen[_SEEN.x_err_smooth], seen[_SEEN.y_err_smooth] = recalled.x_err, recalled.y_err
    seen[_SEEN.heading_err_smooth] = recalled.heading_err
    seen[_SEEN.v_command], seen[_SEEN.w_command] = recalled.v, recalled.w


@compiled_only
def see_path(robot, time, recalled, work, road, path):  # type: ignore[no-untyped-def]
    """Write what a robot knows by its path's nearest point into ``work.seen``, and remember it; before :func:`see`."""
    due, _ = timed(road, path, time)
    first = recalled.started == 0
    reach = SEARCH_REACH_AFTER_OUTAGE if first or time > OUTAGE else SEARCH_REACH
    place = nearest(road, path, robot.x, robot.y, due if first else recalled.place, reach)
    recalled.place = place
    x, y, heading, curvature = at(road, path, place)
    off, length = math.hypot(x - robot.x, y - robot.y), road.lengths[path]
    onwards_x, onwards_y, _, _ = at(road, path, min(place + BACK_TO_PATH, length))
    seen = work.seen
    seen[_SEEN.cross_track] = math.cos(heading) * (robot.y - y) - math.sin(heading) * (robot.x - x)
    bearing = math.atan2(onwards_y - robot.y, onwards_x - robot.x)
    seen[_SEEN.path_bearing] = wrapped_compiled(bearing - robot.heading)
    seen[_SEEN.curvature], seen[_SEEN.progress] = curvature, share(road, path, place)
    seen[_SEEN.remaining], seen[_SEEN.lag] = length - place + off, due - place


@compiled_only
def pick(n, ask, work, time, road, path):  # type: ignore[no-untyped-def]
    """The input ``n`` of a rule base: of what is seen, or of the reference at a later time."""
    place = int(ask.places[n])
    if place < _NOW:
        return work.seen[place]
    _, _, _, v, w, _ = moving(road, path, time + ask.times[n])
    if place == _NOW + _LATER.target_v:
        return v
    if place == _NOW + _LATER.target_w:
        return w
    return w / v if v != 0 else 0.0


@compiled_only
def tell_asked(inputs, ask, work):  # type: ignore[no-untyped-def]
    """Write the inputs of the rule base where runs record them."""
    for n in range(int(ask.count)):
        inputs[n] = work.asked[n]


@compiled_only
def given_or(said, ask, output, otherwise):  # type: ignore[no-untyped-def]
    """What a rule base gives, or something else where it does not give that."""
    place = int(ask.given[output])
    return said[place] if place >= 0 else otherwise


@compiled_only
def answered(said, ask, aim, heading_err, v, w, catch_up):  # type: ignore[no-untyped-def]
    """v [m/s] and ω [rad/s] of a rule base: what it makes of the reference's velocity, or of that of fuzzy tracking."""
    if ask.corrects == 1:
        v, w = aim.v * math.cos(heading_err), aim.w
    v = given_or(said, ask, GIVEN.v, v * given_or(said, ask, GIVEN.speed_factor, 1.0))
    v = min(v + given_or(said, ask, GIVEN.dv, 0.0), given_or(said, ask, GIVEN.speed, math.inf))
    speed = max(abs(aim.v), min(abs(v), catch_up))  # as in (2.32)
    w = given_or(said, ask, GIVEN.w, w) + given_or(said, ask, GIVEN.turn, 0.0) / TURN_TIME
    return v, w + given_or(said, ask, GIVEN.dw, 0.0) + speed * given_or(said, ask, GIVEN.bend, 0.0)
