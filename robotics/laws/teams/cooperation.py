"""Hierarchical fuzzy cooperation: the tracking rule base under a clock that all share, thesis 5.3.

Every path is cut into the same number of samples, which lie farther apart on a longer path, so that it is driven
faster; ς_i = s_i / L_i is a robot's progress, z the clock that says which sample is due. The upper level runs it,

    z' = (1/T) (1 − e^{−t}) (1 − tanh((d − d0)₊² / d1²))        after (5.14)

with d the lag [m] along its path of the robot that is most behind; the lower level drives each robot towards the sample
due by the rule base of Table 5.6. The factor e^{k2 (t − t0)} of (5.14) must decay, and is here the (1 − e^{−t}).

Variants:

``literal``: the clock as printed, (1 − tanh(Σ d_RP²)). It counts robots that are ahead as well: they wait for a clock
that waits for them, and test 2 never starts.
``lag-clock``: the same with the clock above.
``repaired``: the clock above, and four choices. The target is held at most ``reach`` metres ahead of the robot's own
place on the path, so that a robot far off its path drives to the path and not across it, even before it is due. Rule
11 takes "ahead" along the path, since off the path the robot's own x says nothing. The target is taken ``look_ahead``
seconds ahead, which removes the lag. And a late clock runs faster, by the factor 1 + (catch_up − 1) min(late, 1 s), as
in :mod:`robotics.laws.teams.virtual_structure`: (1 − e^{−t}) alone leaves it 1 s behind the scenario's timetable for
good. With 1.5 the robots drive half as fast again at most, and where nobody lags the lateness decays in 2 s.

Each robot keeps a copy of the clock, and the copies agree on the slowest (a choice: the thesis has one clock). The
clock all but stops for a robot that lags by much more than d0. Stability: the lower level's local certificate is that
of :mod:`robotics.laws.tracking.fuzzy_tracking`; there is no proof for the whole.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import Any, Literal

import numpy as np

from fuzzy.compiled.jit import inner, kernel
from fuzzy.system import Sugeno
from robotics.laws.equation import (
    FIRST,
    HEADING,
    PROGRESS,
    SAYS,
    SECOND,
    TO_HEADING,
    TO_S,
    TO_V,
    TO_W,
    TO_X,
    TO_Y,
    WISH_V,
    WISH_W,
    EquationLaw,
    Memory,
    X,
    Y,
    equation,
)
from robotics.laws.law import Command, ControllerError, Observation, check_connected, check_team
from robotics.laws.modes import Box, StateDiagram, Transition
from robotics.laws.setting import Setting
from robotics.laws.teams.neighbours import OUTAGE, SEARCH_REACH, SEARCH_REACH_AFTER_OUTAGE
from robotics.laws.tracking.fuzzy_tracking import NUMBERS as TRACKER_NUMBERS
from robotics.laws.tracking.fuzzy_tracking import FuzzyTracking, told, toward
from robotics.paths.road import at as point_at
from robotics.paths.road import moving, nearest, share
from robotics.paths.road import place as place_at
from robotics.paths.trajectory import Reference
from robotics.quantity import check_quantities, quantity
from robotics.radio.channel import AGE, BELIEVED, HEARD, HEARS

AT_END = 0.04  # m: a robot that is nearer to the end of its path has arrived
ON_PATH = 0.03  # m: a robot that is no farther from its path is on it


# What a robot does, as the lower level chooses it in every period
FOLLOWING, WAITING, JOINING, ARRIVED = range(4)
# Thesis Fig 5.24 as printed: rule 11 decides
RULE_11_DIAGRAM = StateDiagram(
    {
        FOLLOWING: Box("following", "rules 1-10 of Table 5.6: to the sample due"),
        WAITING: Box("waiting", "rule 11 of Table 5.6: v and ω fall to 0"),
    },
    (
        Transition(FOLLOWING, WAITING, "the sample due is behind: x_err < 0"),
        Transition(WAITING, FOLLOWING, "the sample due is ahead: x_err ≥ 0"),
    ),
)
_OFF, _ON, _END = "off its path", "on its path", "the target is the path's end, and near"
REPAIRED_DIAGRAM = StateDiagram(
    {
        WAITING: Box("waiting", "rule 11 of Table 5.6: v and ω fall to 0"),
        JOINING: Box("joining its path", "Table 5.6 to a point of the path ahead, though it may not be due"),
        ARRIVED: Box("arrived", "Table 5.6 to the path's end; rule 11 by the robot's own x"),
        FOLLOWING: Box("following", "Table 5.6 to the sample due, at most reach ahead"),
    },
    (
        Transition(WAITING, JOINING, _OFF),
        Transition(JOINING, WAITING, f"{_ON}, the target is behind"),
        Transition(JOINING, ARRIVED, _END),
        Transition(ARRIVED, JOINING, "the end is not near, off its path"),
        Transition(WAITING, ARRIVED, _END),
        Transition(WAITING, FOLLOWING, "the target is ahead"),
        Transition(FOLLOWING, WAITING, "the target is behind"),
        Transition(JOINING, FOLLOWING, f"{_ON}, the target is ahead"),
        Transition(FOLLOWING, JOINING, _OFF),
        Transition(ARRIVED, FOLLOWING, f"the end is not near, {_ON}"),
        Transition(FOLLOWING, ARRIVED, _END),
    ),
)


VARIANTS = ("repaired", "lag-clock", "literal")
# Places of the equation's numbers, in known.gains; those of the tracker come after them
VARIANT, AHEAD, REACH, LAG, SOFTNESS, CATCH_UP, END, TRACKER = range(8)  # END: s, when the last reference arrives
NUMBERS = TRACKER + TRACKER_NUMBERS
# The memory: the scenario's time [s] that each robot's copy of the clock shows, the abscissa [m] of its nearest point,
# and what it does: FOLLOWING, WAITING, JOINING or ARRIVED
CLOCK, PLACE, PHASE, REMEMBERED = range(4)
# The message: abscissa [m] ("literal": d_RP) and its rate [m/s], the copy of the clock [s] and its pace
SAID_PLACE, SAID_SPEED, SAID_CLOCK, SAID_PACE = range(4)


@inner
def steered(  # type: ignore[no-untyped-def]
    i, known, memory, first, command, work, turn, excused, no_lateral, at
):
    """Run one robot's copy of the clock, drive it towards the sample due, and say so; what :data:`cooperate` does.

    It leaves the inputs of the rule bases in ``work``, for :func:`robotics.laws.tracking.fuzzy_tracking.told`.

    Args:
        i: The lane.
        known: What the law knows; the message's first four values are those of this law.
        memory: Whose rows from ``first`` on are CLOCK, PLACE, PHASE.
        first: See there.
        command: All of it is written but the message's other values, and the inputs of the rule bases.
        work: What the rule bases work in.
        turn: Added to α [rad].
        excused: Whether the clock does not wait for the robot; it then broadcasts a place that is not a number.
        no_lateral: Whether λ is not added.
        at: The row at which the numbers of this law begin in ``known.gains``.
    """
    gains, g, road, path = known.gains, known.column[i], known.road, known.path[i]
    x, y, heading = known.seen[X, i], known.seen[Y, i], known.seen[HEADING, i]
    variant, end = gains[at + VARIANT, g], gains[at + END, g]
    repaired, literal = variant == 0, variant == 2
    clock, before = memory[first + CLOCK, i], memory[first + PLACE, i]
    due_x, due_y, due_heading, due_v, due_w, due_s = moving(road, path, min(clock, end))
    newest, apart, worst, slowest = _listened(i, known, due_s, literal)
    place = nearest(road, path, x, y, before, SEARCH_REACH_AFTER_OUTAGE if newest > OUTAGE else SEARCH_REACH)
    if literal:
        said = math.hypot(due_x - x, due_y - y)  # d_RP
        rate = 0.0
        slowing = math.tanh(said * said + apart)  # (5.14) as printed
    else:
        said, rate = math.nan if excused else place, (place - before) / known.dt
        own = 0.0 if excused else due_s - place
        beyond = (worst if own < worst else own) - gains[at + LAG, g]
        late = beyond / gains[at + SOFTNESS, g] if not beyond < 0 else 0.0
        slowing = math.tanh(late * late)
    pace = (1 - math.exp(-known.time)) * (1 - slowing)  # after (5.14)
    look_ahead, x_err = gains[at + AHEAD, g], math.nan
    if repaired:
        pace = pace * (1 + (gains[at + CATCH_UP, g] - 1) * min(max(known.time - clock, 0.0), 1.0))
        look_ahead = look_ahead * pace
    # The sample to drive to
    to_x, to_y, to_heading, to_v, to_w, to_s = moving(road, path, min(clock + look_ahead, end))
    if repaired:
        to_x, to_y, to_heading, to_w, to_s, x_err, phase = held_one(
            road, path, x, y, heading, place, to_x, to_y, to_heading, to_v, to_w, to_s, gains[at + REACH, g]
        )
    else:
        ahead = math.cos(heading) * (to_x - x) + math.sin(heading) * (to_y - y)
        phase = FOLLOWING if ahead >= 0 else WAITING
    v, w, _ = toward(
        x, y, heading, to_x, to_y, to_heading, to_v, to_w, x_err, turn, no_lateral,
        gains, at + TRACKER, g, known.rules[known.base[i]], work,
    )  # fmt: skip
    command[FIRST, i], command[WISH_V, i] = v, v
    command[SECOND, i], command[WISH_W, i] = w, w
    command[TO_X, i], command[TO_Y, i], command[TO_HEADING, i] = due_x, due_y, due_heading
    command[TO_V, i], command[TO_W, i], command[TO_S, i] = due_v * pace, due_w * pace, due_s
    command[PROGRESS, i] = share(road, path, place)
    command[SAYS + SAID_PLACE, i], command[SAYS + SAID_SPEED, i] = said, rate
    command[SAYS + SAID_CLOCK, i], command[SAYS + SAID_PACE, i] = clock, pace
    clock = clock + known.dt * pace
    memory[first + CLOCK, i] = slowest if slowest < clock and not literal else clock
    memory[first + PLACE, i], memory[first + PHASE, i] = place, phase


@inner
def _listened(i, known, due, literal):  # type: ignore[no-untyped-def]
    """What one robot makes of the messages it has heard.

    Returns the age [s] of the newest message, at most the time; Σ d_RP² [m²] of the others if the clock is ``literal``;
    the greatest lag [m] of another behind what is level with the abscissa ``due`` [m], at least 0; and the time [s]
    that the slowest copy of the clock may show in the next period.
    """
    heard, road, path = known.heard, known.road, known.path
    robots = heard.shape[2]
    run = i - i % robots  # the lane of the run's first robot
    # All paths have the same timing: what is level with the own place due is due on every path.
    progress = share(road, path[i], due)
    newest, apart, worst, slowest = known.time, 0.0, 0.0, math.inf
    for j in range(robots):
        if not heard[HEARS, i, j] > 0:
            continue
        age = heard[AGE, i, j]
        newest = min(newest, age)
        ahead = min(age, BELIEVED)  # s for which what was heard is predicted
        theirs = heard[HEARD + SAID_PLACE, i, j] + heard[HEARD + SAID_SPEED, i, j] * ahead
        if not math.isnan(theirs):
            if literal:
                apart += theirs * theirs
            else:
                worst = max(worst, place_at(road, path[run + j], progress) - theirs)
        pace = heard[HEARD + SAID_PACE, i, j]
        shown = heard[HEARD + SAID_CLOCK, i, j] + pace * ahead + known.dt * (1.0 if pace < 1.0 else pace)
        if shown < slowest:  # false where nothing was heard yet
            slowest = shown
    return newest, apart, worst, slowest


@inner
def held_one(  # type: ignore[no-untyped-def]
    road, path, x, y, heading, place, to_x, to_y, to_heading, to_v, to_w, to_s, reach
):
    """Hold the sample due near one robot; see :func:`held`. ``to_x`` to ``to_s`` are the sample due.

    Returns the target's x, y [m], heading [rad], turn rate [rad/s] and abscissa [m], how far it is ahead [m], and the
    phase.
    """
    near_x, near_y, _, _ = point_at(road, path, place)
    off = math.hypot(near_x - x, near_y - y)
    dx, dy = to_x - x, to_y - y
    ahead = math.cos(heading) * dx + math.sin(heading) * dy
    behind, s = to_s - place, min(to_s, place + reach)
    if to_s >= road.lengths[path] and math.hypot(dx, dy) < AT_END:
        # At the path's end the nearest point is the end from both sides: there the robot's own x tells.
        phase, behind = ARRIVED, ahead if ahead > 0 else -1.0
    elif off > ON_PATH:
        # A robot that is ahead of time but off its path drives to the path before it waits.
        phase, behind, s = JOINING, max(behind, off), max(s, place + min(off, reach) / 2)
    else:
        phase = FOLLOWING if to_s >= place else WAITING
    if s != to_s:
        to_x, to_y, to_heading, curvature = point_at(road, path, s)
        to_w = to_v * curvature
    return to_x, to_y, to_heading, to_w, s, behind, phase


@equation
def cooperate(i, known, memory, command, work):  # type: ignore[no-untyped-def]
    """Run the clock, and drive towards the sample due by Table 5.6."""
    steered(i, known, memory, 0, command, work, 0.0, False, False, 0)
    told(i, command, SAYS + SAID_PACE + 1, known.gains, TRACKER, known.column[i], work)


@equation
def cooperate_otherwise(i, known, memory, command, work):  # type: ignore[no-untyped-def]
    """The same, with three more rows of memory: turn, excused and no_lateral of :func:`steered`."""
    turn, excused, no_lateral = memory[REMEMBERED, i], memory[REMEMBERED + 1, i], memory[REMEMBERED + 2, i]
    steered(i, known, memory, 0, command, work, turn, excused > 0, no_lateral > 0, 0)
    told(i, command, SAYS + SAID_PACE + 1, known.gains, TRACKER, known.column[i], work)


@dataclass(frozen=True, kw_only=True)
class FuzzyCooperation(EquationLaw):
    """Fuzzy cooperation: the rule base, how its target is chosen, and the clock."""

    variant: Literal["repaired", "lag-clock", "literal"] = "repaired"
    rule_base: str | Sugeno = "tracking"
    look_ahead: float = quantity(0.4, "s", least=0, most=10)
    steering_distance: float = quantity(0.35, "m", least=0)  # as of the tracking law
    lateral: Literal["none", "path", "world"] = "none"  # as of the tracking law
    reach: float = quantity(0.4, "m", above=0)  # "repaired": the target is no farther ahead of the robot's place
    lag: float = quantity(0.25, "m", least=0)  # d0: a lag that does not slow the clock
    softness: float = quantity(0.4, "m", above=0)  # d1: the lag beyond d0 at which the clock runs at 24 %
    catch_up: float = quantity(1.5, "1", least=1, most=5)  # pace of a clock that is late; "repaired"
    tracker: FuzzyTracking = field(init=False, repr=False)

    message = ("place", "speed", "clock", "pace")
    tasks = MappingProxyType({"tracking": "rule_base"})

    def __post_init__(self) -> None:
        check_quantities(self, ControllerError)
        tracker = FuzzyTracking(
            rule_base=self.rule_base, steering_distance=self.steering_distance, lateral=self.lateral
        )
        object.__setattr__(self, "tracker", tracker)

    @property
    def idle(self) -> frozenset[str]:
        """The parameters that have no effect in this variant."""
        idle = {"literal": {"reach", "lag", "softness", "catch_up"}, "lag-clock": {"reach", "catch_up"}}
        return frozenset(idle.get(self.variant, ()))

    @property
    def diagrams(self) -> tuple[StateDiagram, ...]:
        """The choices of the lower level, thesis Fig 5.24."""
        return (REPAIRED_DIAGRAM if self.variant == "repaired" else RULE_11_DIAGRAM,)

    @property
    def fuzzy_systems(self) -> Mapping[str, Sugeno]:
        """The rule bases of the lower level."""
        return self.tracker.fuzzy_systems

    equation = cooperate
    aims = progresses = True

    def gain_rows(self, setting: Setting) -> Sequence[Any]:
        """The numbers of the equation, in the order of the places above."""
        ends = setting.references.ends
        end = np.broadcast_to(ends.max(axis=-1, keepdims=True), ends.shape) if ends.ndim > 1 else float(ends.max())
        clock = self.reach, self.lag, self.softness, self.catch_up, end
        return float(VARIANTS.index(self.variant)), self.look_ahead, *clock, *self.tracker.gain_rows(setting)

    def rule_rows(self) -> Sequence[np.ndarray]:
        """The rule bases of the lower level."""
        return self.tracker.rule_rows()

    @property
    def working(self) -> int:
        """The numbers that the rule bases are evaluated in."""
        return self.tracker.working

    def begin(self, setting: Setting, runs: int) -> np.ndarray:
        """Set the clocks to 0. Raises ControllerError where the robots are no team, or the graph is not connected."""
        robots = len(setting.robots)
        if robots > 1:
            check_team(setting)
        check_connected(setting)
        zero = np.zeros((runs, robots))
        pose = np.broadcast_to(setting.starts, (runs, robots, 3))
        start = setting.references.at(0.0).s
        paths, reach = setting.references.joined, zero + SEARCH_REACH_AFTER_OUTAGE
        near = paths.nearest(pose[..., 0], pose[..., 1], start, reach)
        return np.stack([zero, near, zero + WAITING])

    def steered(
        self,
        seen: Observation,
        memory: Memory,
        dt: float,
        turn: np.ndarray | None = None,
        excused: np.ndarray | None = None,
        no_lateral: np.ndarray | None = None,
    ) -> tuple[Command, Memory]:
        """Do as :meth:`control`, with a turn added and some robots excused from the clock.

        Args:
            seen: What the robots know.
            memory: As of the period before.
            dt: The control period [s].
            turn: Added to α (runs, robots) [rad]; none by default.
            excused: Robots for which the clock does not wait (runs, robots) bool; they broadcast a place that is not a
                number. None by default.
            no_lateral: Robots to which λ is not added (runs, robots) bool; none by default.
        """
        more = np.zeros((3, memory.rows.shape[1]))
        for row, given in zip(more, (turn, excused, no_lateral), strict=True):
            if given is not None:
                row[...] = given.ravel()
        command, after = self.by(
            cooperate_otherwise, seen, Memory(memory.setup, np.concatenate([memory.rows, more])), dt
        )
        return command, Memory(memory.setup, after.rows[:REMEMBERED])


def held(
    seen: Observation, target: Reference, place: np.ndarray, reach: float
) -> tuple[Reference, np.ndarray, np.ndarray]:
    """Hold the sample due near the robot, along its path; so that it drives to the path before it drives across it.

    Args:
        seen: What the robots know.
        target: The samples due, each field (runs, robots).
        place: The abscissae of the paths' nearest points (runs, robots) [m].
        reach: How far ahead of the robot's place the target is at most [m].

    Returns the target, how far it is ahead [m], as rule 11 takes it, and what the robot does: FOLLOWING, WAITING,
    JOINING or ARRIVED; each (runs, robots).
    """
    given = seen.x, seen.y, seen.heading, place, *target
    rows = np.empty((len(given), *place.shape))
    for row, values in zip(rows, given, strict=True):
        row[...] = values
    found = _held(seen.references.road, rows.reshape(len(rows), -1), float(reach)).reshape(-1, *place.shape)
    x, y, heading, w, s, behind, phase = found
    return Reference(x, y, heading, target.v, w, s), behind, phase.astype(int)


@kernel
def _held(road, rows, reach):  # type: ignore[no-untyped-def]
    found = np.empty((7, rows.shape[1]))
    for i in range(rows.shape[1]):
        one = held_one(
            road, i % len(road.lengths), rows[0, i], rows[1, i], rows[2, i], rows[3, i],
            rows[4, i], rows[5, i], rows[6, i], rows[7, i], rows[8, i], rows[9, i], reach,
        )  # fmt: skip
        found[0, i], found[1, i], found[2, i], found[3, i], found[4, i], found[5, i], found[6, i] = one
    return found
