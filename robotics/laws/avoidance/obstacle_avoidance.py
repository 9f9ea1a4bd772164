"""Obstacle avoidance, thesis 6.2: fuzzy cooperation whose robots look around with sonars.

    ro ≤ ro_min  ⇒  α** = α + Θ(ro)                                      (6.7)

with ro the nearest front reading and Θ the rule base ``theta``, 0 at ro_min. The thesis prints the condition as ≥ in
one place, and gives no sign; here the robot turns away from the smaller of the two front readings.

"literal": the thesis's two modes. While ro ≤ ro_min the robot turns by Θ; a side reading below ``push_range`` turns it
``push`` away; v is reduced to ro / ro_min of itself (at least a quarter; 0 below 0.12 m). Otherwise the robot tracks.
It forgets an obstacle as soon as no cone sees it, and its target pulls it back: it grazes corners, and
never leaves a trap.

"committed": the modes of :mod:`robotics.laws.avoidance.obstacle_modes`. Chosen here:

* Rule 11 does not act while a robot avoids (one that was turned away from its target would stand still), and the
  target is held ``reach`` ahead of the robot's place on the path.
* Robots tell each other where they are, and stop before another robot ahead, as in
  :mod:`robotics.laws.avoidance.right_of_way`.
* A thing that is very near may be coming nearer: the robot stands still, or leaves straight ahead if that is free,
  until it has seen that nothing moves (:func:`robotics.laws.avoidance.obstacle_modes.stand_still`). It may be run into,
  but does not drive into a thing that moves.

Chosen for both variants:

* A robot stops for another that is nearer than ``d_pass``, ahead of it and going round an obstacle (case studies 2 and
  3). The robot with the lower number goes first; in "committed" a robot that avoids also goes before one that tracks,
  and nobody waits longer than 6 s. In "literal" there is no limit.
* A reading grows no faster than 2 m/s ("committed": 1 m/s in front, 0.6 m/s at the sides), so that an echo lost for a
  moment is not taken for an obstacle gone. Without that the literal scheme hits in 26 % of class A instead of 2 %.
* A robot that avoids and has made no progress along its path for longer than ``patience`` no longer slows the clock of
  the others (case study 4). As soon as it comes free they wait for it as before.

Stability: the tracking below is that of :mod:`robotics.laws.teams.cooperation`; avoidance is shown by sampling only.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import Any, Literal, NamedTuple

import numpy as np

from fuzzy.compiled.sugeno import CompiledSugeno
from fuzzy.system import Sugeno
from robotics.laws.avoidance.echoes import in_own_frame, without_echoes
from robotics.laws.avoidance.obstacle_modes import (
    BEST,
    GROWTH,
    MODE,
    ROWS,
    STALLED,
    STOP_DISTANCE,
    WAY,
    Mounting,
    next_mode,
    nothing_watched,
    stand_still,
)
from robotics.laws.avoidance.priority import CONE, STATED_FOR, WHEREABOUTS, Others, blocked, others, whereabouts, wider
from robotics.laws.law import Command, ControllerError, Law, Observation
from robotics.laws.modes import AVOID, FOLLOW, LEFT_BEHIND, TRACK, YIELD, Box, StateDiagram, Transition
from robotics.laws.setting import Setting
from robotics.laws.teams.cooperation import ON_PATH, PLACE, FuzzyCooperation
from robotics.laws.tracking.fuzzy_tracking import compiled_curve
from robotics.paths.posture import wrapped
from robotics.quantity import check_quantities, quantity
from robotics.sensing.sonar import FRONT_LEFT, FRONT_RIGHT, LEFT, RIGHT, SONAR

TOO_LARGE = 1.5  # 1: times the robot for which the distances are stated
ABEAM = 1.45  # rad from the heading: a robot beyond that comes no nearer by driving on
SIDE_MARGIN = 0.06  # m: a robot turns away from another at its side that is nearer than ``near`` and this
TURN_AWAY = 0.8  # rad/s, from that one
PASSING_CONE = 1.3  # rad from the heading: a robot that avoids is let pass where it is within
LONGEST_WAIT = 6.0  # s: a robot lets others pass for no longer
LITERAL_RISE = 2.0  # m/s: a reading grows no faster
COMMITTED_RISE = np.array([1.0, 1.0, 0.6, 0.6])  # m/s, in the order of SONAR; the side ones lose echoes at corners
ROBOT_RADIUS = 0.16  # m: of robots as large as the EtsRo, whose echoes are left out
IN_THE_WAY = 0.6  # m: likewise; robots that are known to be farther away are not avoided as obstacles
LEAVING_ROOM = 0.4  # m: with more ahead, a robot drives away from a thing that is too near
LEAVING_SPEED = 0.5  # m/s: no faster than this
CATCH_UP_SPEED = 0.6  # m/s: a robot that catches up drives no faster among obstacles it does not know
EARLY_TIME = 1.0  # s in which a robot loses its lead
JOINING_SPEED = 0.1  # m/s: a robot ahead of time drives back to its path no slower
CREEP_SPEED = 0.06  # m/s: a robot ahead of time that avoids drives no slower

# Thesis Fig 6.26, and what became of it here; below each, whether the group waits for the robot
LITERAL_DIAGRAM = StateDiagram(
    {
        TRACK: Box("tracking", "Table 5.6 at α"),
        AVOID: Box("avoiding", "Table 5.6 at α + Θ(ro) (6.7), slower"),
        YIELD: Box("standing", "v = ω = 0"),
    },
    (
        Transition(TRACK, AVOID, "ro ≤ ro_min, or a side sonar reads too little"),
        Transition(AVOID, TRACK, "all sonars read enough"),
        Transition(TRACK, YIELD, "a robot of lower number avoids ahead, within d_pass"),
        Transition(AVOID, YIELD, "a robot of lower number avoids ahead, within d_pass"),
        Transition(YIELD, TRACK, "it is past; all sonars read enough"),
        Transition(YIELD, AVOID, "it is past; an obstacle is near"),
    ),
)
_IN_THE_WAY = "another robot, or what may move, is too near"
COMMITTED_DIAGRAM = StateDiagram(
    {
        TRACK: Box("tracking", "Table 5.6 at α, no faster than the front reading allows"),
        AVOID: Box("avoiding", "Table 5.6 at α + Θ(ro), round one side, which is kept"),
        FOLLOW: Box("following the wall", "along the wall, on the same side"),
        YIELD: Box("yielding", "stands; on the spot it may turn away from who is beside it"),
    },
    (
        Transition(TRACK, AVOID, "a front sonar reads less than ro_min"),
        Transition(AVOID, TRACK, "front and side have been free for 1.2 s"),
        Transition(AVOID, FOLLOW, "no progress on the path for 6 s"),
        Transition(FOLLOW, AVOID, "past where it got stuck, and free ahead"),
        Transition(TRACK, YIELD, _IN_THE_WAY),
        Transition(AVOID, YIELD, _IN_THE_WAY),
        Transition(FOLLOW, YIELD, _IN_THE_WAY),
        Transition(YIELD, TRACK, "its way is free, and no obstacle is near"),
        Transition(YIELD, AVOID, "its way is free, beside an obstacle"),
        Transition(YIELD, FOLLOW, "its way is free, along a wall"),
    ),
)
GROUP_DIAGRAM = StateDiagram(
    {
        0: Box("in the group", "the clock waits for the robot"),
        LEFT_BEHIND: Box("left behind", "the clock does not wait for it"),
    },
    (
        Transition(0, LEFT_BEHIND, "no progress on the path for longer than patience"),
        Transition(LEFT_BEHIND, 0, "progress, or it tracks again"),
    ),
    mask=LEFT_BEHIND,
)


class Sight(NamedTuple):
    """What the printed rules make of the sonars; each field is (runs, robots)."""

    avoids: np.ndarray  # bool: an obstacle is within ro_min in front, or within push_range at a side
    turn: np.ndarray  # rad: Θ of (6.7) and the push from the sides, with their signs; 0 unless it avoids
    slowing: np.ndarray  # 1: the factor on v while it avoids
    front: np.ndarray  # m: ro, the nearest front reading


class _Memory(NamedTuple):
    """The memory of the cooperation, and what the robots saw."""

    below: Any
    state: np.ndarray  # (ROWS, runs, robots) of robotics.laws.avoidance.obstacle_modes
    ranges: np.ndarray  # (runs, robots, sensors) m
    waits: np.ndarray  # (runs, robots) s for which it has let another robot pass
    watch: np.ndarray  # (WATCH, runs, robots) of robotics.laws.avoidance.obstacle_modes
    mounting: Mounting
    wider: float  # m: what the robots' size adds to the distances between them


@dataclass(frozen=True, kw_only=True)
class ObstacleAvoidance(Law[_Memory]):
    """Obstacle avoidance: from where on and how far to turn away, and the cooperation underneath."""

    variant: Literal["committed", "literal"] = "committed"
    ro_min: float = quantity(0.5, "m", above=0.15, most=2)  # the thesis's scheme wants 0.8
    theta: float = quantity(1.0, "1", least=0, most=2)  # what Θ(ro) is multiplied by
    reach: float = quantity(0.5, "m", above=0)  # "committed": how far ahead the target is held while avoiding
    patience: float = quantity(15.0, "s", above=0)  # the group waits no longer for a robot without progress
    near: float = quantity(0.34, "m", above=0)  # "committed": at rest, another ahead and nearer (by centers) stops it
    d_pass: float = quantity(0.75, "m", least=0, most=5)  # a robot that avoids is let pass where it is nearer
    push: float = quantity(0.6, "rad", least=0, most=3)  # "literal": the turn away from a side reading
    push_range: float = quantity(0.35, "m", least=0)  # "literal": a side reading below this turns the robot
    rule_base: str | Sugeno = "tracking"
    theta_rule_base: str | Sugeno = "theta"
    cooperation: FuzzyCooperation = field(init=False, repr=False)
    turn: CompiledSugeno = field(init=False, repr=False, compare=False)

    yields = True
    tasks = MappingProxyType({"tracking": "rule_base", "theta": "theta_rule_base"})
    needs = tuple(SONAR)  # two on the nose and one on each side
    message = (*FuzzyCooperation.message, "avoids", *WHEREABOUTS)

    def __post_init__(self) -> None:
        check_quantities(self, ControllerError)
        kind: Any = "repaired" if self.variant == "committed" else "lag-clock"
        # No steering distance: a robot that comes round an obstacle must be back on its path within decimetres. And no
        # catching up: no robot hurries among obstacles that it does not know.
        below = FuzzyCooperation(variant=kind, rule_base=self.rule_base, steering_distance=0.0, catch_up=1.0)
        object.__setattr__(self, "cooperation", below)
        object.__setattr__(self, "turn", compiled_curve(self.theta_rule_base, "Θ", "the distance"))

    @property
    def idle(self) -> frozenset[str]:
        """The parameters that have no effect in this variant."""
        return frozenset({"push", "push_range"} if self.variant == "committed" else {"reach", "near"})

    @property
    def fuzzy_systems(self) -> Mapping[str, Sugeno]:
        """For "literal" those of the cooperation, and "theta" with ro as its input; "committed" is not only rules."""
        if self.variant == "committed":
            return {}
        return {**self.cooperation.fuzzy_systems, "theta": self.turn.fis}

    @property
    def diagrams(self) -> tuple[StateDiagram, ...]:
        """The modes of its variant, thesis Fig 6.26; and whether the group waits for the robot."""
        return (COMMITTED_DIAGRAM if self.variant == "committed" else LITERAL_DIAGRAM, GROUP_DIAGRAM)

    def misgivings(self, setting: Setting) -> tuple[str, ...]:
        """Say which robots are so large that its distances to obstacles do not suit them."""
        across = [float(np.hypot(robot.length, robot.width)) for robot in setting.robots]
        large = [i for i, diameter in enumerate(across, start=1) if diameter > TOO_LARGE * STATED_FOR]
        if not large:
            return ()
        who = f"robot{'s' * (len(large) > 1)} {', '.join(map(str, large))} {'are' if len(large) > 1 else 'is'}"
        return (
            f"{setting.name}: this law's distances to obstacles are those of a robot that turns in a circle of "
            f"{STATED_FOR:.2f} m; {who} up to {max(across):.2f} m across and may touch what is to be avoided. "
            "fuzzy-team goes by the robots' own sizes",
        )

    def init(self, setting: Setting, runs: int) -> _Memory:
        """Let all robots track. Raises ControllerError where the graph is not connected."""
        shape = (runs, len(setting.robots))
        state = np.zeros((ROWS, *shape))
        nothing = np.full((*shape, len(self.needs)), np.inf)
        below = self.cooperation.init(setting, runs)
        mounting = Mounting.of([[carried[name] for name in self.needs] for carried in setting.sensors])
        return _Memory(below, state, nothing, np.zeros(shape), nothing_watched(*shape), mounting, wider(setting.robots))

    def control(self, seen: Observation, memory: _Memory, dt: float) -> tuple[Command, _Memory]:
        """Look, choose a mode, steer."""
        fresh = memory.ranges
        them = others(seen) if seen.x.shape[1] > 1 else None
        if seen.ranges is not None:
            fresh = seen.ranges.of(self.needs)
            if self.variant == "committed" and them is not None:
                fresh = _without_robots(seen, them, fresh, memory)
            rise = LITERAL_RISE if self.variant == "literal" else COMMITTED_RISE
            memory = memory._replace(ranges=np.minimum(fresh, memory.ranges + rise * dt))
        if self.variant == "literal":
            return self._literal(seen, them, memory, dt)
        return self._committed(seen, them, memory, fresh, dt)

    def theta_at(self, distance: np.ndarray) -> np.ndarray:
        """|Θ| [rad] at ``distance`` [m], of any shape: the rule base, its range stretched to end at ro_min."""
        return np.asarray(self.theta * self.turn(self.theta_input(distance)[..., None])[..., 0])

    def theta_input(self, distance: np.ndarray) -> np.ndarray:
        """The rule base's input [m] for ``distance`` [m], of any shape; ro_min is the far end of its range."""
        close, far = self.turn.fis.inputs[0].universe
        stretched = far - (self.ro_min - distance) * (far - close) / (self.ro_min - close)
        return np.clip(stretched, close, far)

    def sight(self, ranges: np.ndarray) -> Sight:
        """Judge by (6.7) what four sonars read, ``ranges`` (runs, robots, sensors) [m]."""
        left, right = ranges[..., FRONT_LEFT], ranges[..., FRONT_RIGHT]
        front = np.minimum(left, right)
        turn = np.where(left < right, -1.0, 1.0) * self.theta_at(front)
        for sensor, sign in ((LEFT, -1.0), (RIGHT, 1.0)):
            turn += np.where(ranges[..., sensor] < self.push_range, sign * self.push, 0.0)
        avoids = (front <= self.ro_min) | (ranges.min(axis=-1) < self.push_range)
        slowing = np.where(front < 0.12, 0.0, np.clip(front / self.ro_min, 0.25, 1.0))
        return Sight(avoids, np.where(avoids, turn, 0.0), slowing, front)

    def _literal(self, seen: Observation, them: Others | None, memory: _Memory, dt: float) -> tuple[Command, _Memory]:
        avoids, turn, slowing, front = self.sight(memory.ranges)
        state = memory.state.copy()
        alone = state[STALLED] > self.patience
        wish, below = self.cooperation.steered(seen, memory.below, dt, turn, alone)
        state[BEST], state[STALLED] = stalled(
            state[BEST], state[STALLED], below.rows[PLACE].reshape(seen.x.shape), dt * avoids
        )
        v = np.where(avoids, wish.v * slowing, wish.v)
        assert wish.inputs is not None
        wish = wish._replace(inputs=np.concatenate([wish.inputs, self.theta_input(front)[None]]))
        mode = np.where(avoids, np.where(alone, AVOID + LEFT_BEHIND, AVOID), TRACK)
        stands = self._lets_pass(seen, them, avoids)
        v, w = np.where(stands, 0.0, v), np.where(stands, 0.0, wish.w)
        mode = np.where(stands, YIELD + (mode & LEFT_BEHIND), mode)
        return self._said(seen, wish, v, w, mode, avoids & ~alone), memory._replace(below=below, state=state)

    def _committed(
        self, seen: Observation, them: Others | None, memory: _Memory, fresh: np.ndarray, dt: float
    ) -> tuple[Command, _Memory]:
        before = memory.state
        alone = (before[MODE] != TRACK) & (before[STALLED] > self.patience)
        wish, below = self.cooperation.steered(seen, memory.below, dt, None, alone)
        paths, place = seen.references.joined, below.rows[PLACE].reshape(seen.x.shape)
        nearest, end = paths.at(place), paths.at(np.broadcast_to(paths.lengths, place.shape))
        ahead = paths.at(np.minimum(place + self.reach, paths.lengths))
        alpha = wrapped(np.arctan2(ahead.y - seen.y, ahead.x - seen.x) - seen.heading)
        off = np.hypot(nearest.x - seen.x, nearest.y - seen.y)
        state, steer = next_mode(
            before,
            memory.ranges,
            fresh,
            np.stack([seen.x, seen.y, seen.heading]),
            alpha,
            place,
            off,
            np.hypot(end.x - seen.x, end.y - seen.y),
            self.ro_min,
            dt,
            memory.mounting.walls,
        )
        mode = state[MODE]
        away = state[WAY] * self.theta_at(steer.front)
        aim = wish.target._replace(x=ahead.x, y=ahead.y, heading=ahead.heading)  # type: ignore[union-attr]
        # Rule 11 does not act: the target counts as ahead.
        _, turning = self.cooperation.tracker.toward(seen, aim, np.ones_like(alpha), steer.alpha - alpha + away)
        v = np.where(mode == TRACK, np.minimum(np.minimum(wish.v, steer.v), CATCH_UP_SPEED), steer.v)
        v = np.minimum(v, self._in_time(wish, place, off, mode))
        w = np.where(mode == TRACK, wish.w, np.where(mode == AVOID, turning, steer.w))
        # The others wait for the way back to the path as well.
        assert wish.message is not None
        said = wish.message["place"] - np.where(mode == TRACK, 0.0, off)
        wish = wish._replace(message={**wish.message, "place": said})
        code = mode.astype(int)
        avoids = mode != TRACK
        # Case studies 2 and 3. The wait is bounded: the other may be waiting as well, which would be a deadlock.
        passing = self._lets_pass(seen, them, avoids)
        waits = np.where(passing, memory.waits + dt, 0.0)
        stands = passing & (waits <= LONGEST_WAIT)
        state[STALLED] -= np.where(stands & avoids, dt, 0.0)  # a robot that lets another pass is not stuck
        stops, aside = self._stops(seen, them, memory.wider)
        stops |= stands
        v = np.where(stops | (aside != 0), 0.0, v)
        w = np.where(stands | (stops & (mode == TRACK)), 0.0, np.where(aside != 0, TURN_AWAY * aside, w))
        stops |= aside != 0
        watch, halted = stand_still(memory.watch, fresh, seen.v, seen.w, dt)
        front = memory.ranges[..., [FRONT_LEFT, FRONT_RIGHT]].min(axis=-1)
        leaves = halted & (front > LEAVING_ROOM) & ~stops
        v = np.where(halted, np.where(leaves, np.minimum(front - STOP_DISTANCE, LEAVING_SPEED), 0.0), v)
        w = np.where(halted, 0.0, w)
        code = np.where(stops | (halted & ~leaves), YIELD, code) + np.where(alone & (mode != TRACK), LEFT_BEHIND, 0)
        command = self._said(seen, wish._replace(inputs=None), v, w, code, avoids & ~alone)
        return command, memory._replace(below=below, state=state, waits=waits, watch=watch)

    def _in_time(self, wish: Command, place: np.ndarray, off: np.ndarray, mode: np.ndarray) -> np.ndarray:
        """The speed [m/s] (runs, robots) above which a robot would get farther along its path than the others are.

        The bound holds off the path only, where the target is not the sample due. The way back to the path counts as
        way still to be driven. The bound is never 0, for a robot that stops counts as stuck.
        """
        due = wish.target
        assert due is not None
        tracks = mode == TRACK
        early = np.where(tracks, place, place - off) - due.s
        free = np.where(tracks, off <= ON_PATH, mode == FOLLOW)
        slowest = np.where(tracks, JOINING_SPEED, CREEP_SPEED)
        return np.where(free, np.inf, np.maximum(due.v - early / EARLY_TIME, slowest))

    def _said(
        self, seen: Observation, wish: Command, v: np.ndarray, w: np.ndarray, mode: np.ndarray, avoids: np.ndarray
    ) -> Command:
        assert wish.message is not None
        message = {**wish.message, "avoids": avoids, **whereabouts(seen)}
        return wish._replace(first=v, second=w, v=v, w=w, message=message, mode=mode)

    def _lets_pass(self, seen: Observation, them: Others | None, avoids: np.ndarray) -> np.ndarray:
        """Whether each robot stops for another that goes round an obstacle (runs, robots) bool.

        Where both go round one, the robot with the lower number goes first.
        """
        if them is None:
            return np.zeros(seen.x.shape, dtype=bool)
        number = np.arange(seen.x.shape[1])
        first = number < number[:, None]
        if self.variant == "committed":
            first = first | ~avoids[:, :, None]
        passing = seen.heard.hears & (seen.heard["avoids"] > 0.5) & (them.distance < self.d_pass)
        return np.asarray((passing & first & (np.abs(them.bearing) < PASSING_CONE)).any(axis=-1))

    def _stops(self, seen: Observation, them: Others | None, wider: float) -> tuple[np.ndarray, np.ndarray]:
        """Whether each robot stops for another ahead, and which way it turns from one at its side; both (runs, robots).

        The way is 1 to the left, -1 to the right, and 0 where no other is too near at its side.
        """
        if them is None:
            return np.zeros(seen.x.shape, dtype=bool), np.zeros(seen.x.shape)
        near = self.near + wider
        stops = blocked(seen, them, near)
        bearing = np.abs(them.bearing)
        side = (bearing >= CONE) & (bearing < ABEAM) & seen.heard.hears
        side &= them.distance < (near + SIDE_MARGIN + 0.2 * np.abs(seen.v))[:, :, None]
        aside = -np.sign(np.where(side, np.sign(them.bearing), 0.0).sum(axis=-1))
        return stops, np.where(stops, 0.0, aside)


def stalled(best: np.ndarray, before: np.ndarray, place: np.ndarray, lost: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The largest place [m] on each robot's path so far, and the time [s] lost since it last grew; both (runs, robots).

    Args:
        best: The largest place [m] before, (runs, robots) as all.
        before: The time lost [s] before.
        place: The place [m] now.
        lost: The time [s] lost in this period, unless the place has grown by GROWTH.
    """
    grows = place > best + GROWTH
    return np.where(grows, place, best), np.where(grows, 0.0, before + lost)


def _without_robots(seen: Observation, them: Others, ranges: np.ndarray, memory: _Memory) -> np.ndarray:
    """``ranges`` [m] without the echoes of other robots that are known and not so near as to be in the way.

    ``ranges`` and the result are (runs, robots, sensors); an echo that is left out reads infinite.
    """
    ahead, left = in_own_frame(seen, them.dx, them.dy)
    apart = np.hypot(ahead, left) > IN_THE_WAY + memory.wider
    mounts = tuple(row.T for row in memory.mounting[:4])
    return without_echoes(ranges, mounts, ahead, left, apart, radius=ROBOT_RADIUS + memory.wider / 2)
