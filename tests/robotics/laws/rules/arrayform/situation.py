"""The situation of robots on arrays: all that each of them can know in one period, computed where it is asked for."""

from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np

from robotics.laws.avoidance.planned_way import PlannedTiming
from robotics.laws.knowledge import share_of
from robotics.laws.law import Observation
from robotics.laws.rules.clearances import RISE, SECTOR, Sensors
from robotics.laws.rules.meetings import CELL, Meetings
from robotics.laws.rules.situation import (
    ACCELERATING,
    AHEAD_SEEN,
    BACK_TO_PATH,
    BESIDE,
    BEST_GROWTH,
    CORRIDOR,
    EXPECTATION_LOSS,
    FARTHEST,
    LONGEST_WAY_BACK,
    LOOK_ALONG_PATH,
    NEAR_END,
    NOTHING_NEAR,
    NOTICED,
    ON_PLAN,
    ONWARD,
    QUICK,
    SIDE_TIME,
    SLOW,
    SMOOTH_TIME,
    SMOOTHING,
    STANDS,
    STUCK_PATIENCE,
    SWING,
    SWINGING,
    turning_circles,
)
from robotics.laws.setting import Setting
from robotics.laws.teams.neighbours import SEARCH_REACH_AFTER_OUTAGE
from robotics.world.paths.path import PathPoint
from robotics.world.paths.posture import PostureError, posture_error, wrapped
from robotics.world.paths.references import Reference
from tests.robotics.laws.rules.arrayform.clearances import (
    EchoMarks,
    in_own_frame,
    room_for_braking,
    sensed,
    standing_robots,
    without_robots,
)
from tests.robotics.laws.rules.arrayform.meetings import Meeting, in_the_way, next_meetings, planned_order
from tests.robotics.laws.rules.arrayform.neighbours import (
    Level,
    level_places,
    planned_share,
    search_reach,
    smallest_heard,
)


class Fixed(NamedTuple):
    """What a team knows before the start, and never changes."""

    radii: np.ndarray  # (robots,) m: of the circles in which the robots turn
    sensors: Sensors
    meetings: Meetings | None  # of the paths; none for a single robot
    lengths: np.ndarray  # (robots,) or (runs, robots) m
    end: np.ndarray  # (1,) or (runs, 1) s: the last reference arrives
    plan: PlannedTiming | None = None  # what the references are where they are a plan's
    reached: np.ndarray | None = None  # (runs, robots, cells) s: when that has each robot at the cells of the meetings
    level: Level | None = None  # which places are level with each other; none: that of a single robot

    @classmethod
    def of(
        cls, setting: Setting, margin: float, plan: PlannedTiming | None = None, *, meetings: bool = True
    ) -> "Fixed":
        """Look at the robots, their sensors and paths.

        Args:
            setting: The setting of the law.
            margin: What lies between the circles of robots that do not meet [m].
            plan: References in the place of the setting's.
            meetings: Whether to look where the paths meet, which takes a while.
        """
        robots = len(setting.robots)
        radii = turning_circles(setting)
        references = plan or setting.references
        paths = references.joined
        found = Meetings.of(paths, robots, radii, margin) if robots > 1 and meetings else None
        ends = references.ends.max(axis=-1, keepdims=True)
        reached = None if plan is None or found is None else plan.reached(CELL, found.last.shape[-1])
        sensors = Sensors.of(setting.robots, setting.sensors)
        level = Level.of(references) if robots > 1 else None
        return cls(radii, sensors, found, paths.lengths, ends, plan, reached, level)


class Recall(NamedTuple):
    """What robots remember from one period to the next; each field is (runs, robots) unless it says otherwise."""

    place: np.ndarray  # m: the abscissa of the path's nearest point
    speed: np.ndarray  # m/s: by which that grew
    clock: np.ndarray  # s of the timetable: each robot's copy of the group's clock
    pace: np.ndarray  # 1: of that copy
    best: np.ndarray  # m: the largest place, less the way back to the path
    stuck: np.ndarray  # s since that grew
    side: np.ndarray  # from -1 to 1: the side that the robot keeps of an obstacle; > 0: it goes round to the left of it
    clear: np.ndarray  # (sectors, runs, robots) m: the clearances, which grow slowly
    yields: np.ndarray  # 0 to 1: how much the robot gives way
    way_back: np.ndarray  # m of ground behind that the robot has just driven
    lost: np.ndarray  # s for which nothing was seen on the side that is kept
    driven: np.ndarray  # m within the last second
    fast: np.ndarray  # m: the least clearance, smoothed over QUICK
    slow: np.ndarray  # m: the same, over SLOW
    lean: np.ndarray  # m: how much more room there is ahead on the left than on the right, smoothed
    x_err: np.ndarray  # m: smoothed over SMOOTH_TIME; not-a-number: there was no period before
    y_err: np.ndarray  # m, likewise
    heading_err: np.ndarray  # rad, likewise
    v_command: np.ndarray  # m/s: the last
    w_command: np.ndarray  # rad/s: the last
    marks: EchoMarks  # where something was seen

    @classmethod
    def start(cls, setting: Setting, runs: int, plan: PlannedTiming | None = None) -> "Recall":
        """What robots remember before the first period: nothing but where they are.

        ``plan`` stands in the place of the setting's references.
        """
        references = plan or setting.references
        robots = len(setting.robots)
        zero = np.zeros((runs, robots))
        pose = np.broadcast_to(setting.starts, (runs, robots, 3))
        begin = references.at(0.0).s
        near = references.joined.nearest(pose[..., 0], pose[..., 1], begin, zero + SEARCH_REACH_AFTER_OUTAGE)
        far = zero + FARTHEST
        start = dict.fromkeys(cls._fields, zero) | {"place": near, "best": near, "fast": far, "slow": far}
        start |= dict.fromkeys(("x_err", "y_err", "heading_err"), zero + np.nan)
        clear = np.full((len(SECTOR), runs, robots), np.inf)
        return cls(**start | {"clear": clear, "marks": EchoMarks.none(runs, robots)})


@dataclass(frozen=True, eq=False)
class OtherRobots:
    """The other robots as each one knows them; each field is (runs, robots, others), not-a-number: never heard."""

    x: np.ndarray  # m
    y: np.ndarray  # m
    ahead: np.ndarray  # m along the robot's heading
    left: np.ndarray  # m
    v_x: np.ndarray  # m/s
    v_y: np.ndarray  # m/s
    gap: np.ndarray  # m between the circles in which the two robots turn
    bearing: np.ndarray  # rad from the robot's own heading
    closing: np.ndarray  # m/s: by which the gap shrinks
    place: np.ndarray  # m: their abscissae on their own paths
    age: np.ndarray  # s since the message was sent


class Situation:
    """All that robots can know in one period. Arrays are (runs, robots), of pairs (runs, robots, others)."""

    def __init__(
        self, seen: Observation, fixed: Fixed, recall: Recall, dt: float, target: Reference | None = None
    ) -> None:
        """Take what robots see and hear, what they knew before the start, what they remember, and their target.

        The target is by default the sample due.
        """
        self.seen, self.fixed, self.recall, self.dt = seen, fixed, recall, dt
        self._target = target
        self.paths = seen.references.joined
        self.place = self.paths.nearest(seen.x, seen.y, recall.place, search_reach(seen.heard, seen.time))

    @cached_property
    def nearest(self) -> PathPoint:
        """The path's nearest point."""
        return self.paths.at(self.place)

    @cached_property
    def off(self) -> np.ndarray:
        """The distance from the path [m]."""
        return np.hypot(self.nearest.x - self.seen.x, self.nearest.y - self.seen.y)

    @cached_property
    def cross_track(self) -> np.ndarray:
        """The cross-track error [m]: the robot is so far to the left of its path."""
        n = self.nearest
        return np.cos(n.heading) * (self.seen.y - n.y) - np.sin(n.heading) * (self.seen.x - n.x)

    @cached_property
    def onwards(self) -> PathPoint:
        """The path's point BACK_TO_PATH beyond the nearest one."""
        return self.paths.at(np.minimum(self.place + BACK_TO_PATH, self.fixed.lengths))

    @cached_property
    def path_bearing(self) -> np.ndarray:
        """The bearing of that point from the heading [rad]."""
        seen = self.seen
        return wrapped(np.arctan2(self.onwards.y - seen.y, self.onwards.x - seen.x) - seen.heading)

    @cached_property
    def onward_bearing(self) -> np.ndarray:
        """The bearing [rad] of the path's point ONWARD beyond the nearest one; beyond its end it goes on in an arc."""
        s = self.place + ONWARD
        point, beyond = self.paths.at(s), np.maximum(s - self.fixed.lengths, 0.0)
        half = point.curvature * beyond / 2
        chord = beyond * np.sinc(half / np.pi)
        x, y = point.x + chord * np.cos(point.heading + half), point.y + chord * np.sin(point.heading + half)
        return wrapped(np.arctan2(y - self.seen.y, x - self.seen.x) - self.seen.heading)

    @cached_property
    def known_places(self) -> np.ndarray:
        """The places of all robots as each knows them (runs, robots, others) [m]; not-a-number: never heard.

        Where robots tell each other nothing, one computer drives them all, and knows all.
        """
        if self.seen.heard.fields:
            number = np.arange(self.place.shape[1])
            return np.where(number == number[:, None], self.place[:, :, None], self.others.place)
        return np.broadcast_to(self.place[:, None, :], (*self.place.shape, self.place.shape[1]))

    @cached_property
    def leader_ahead(self) -> np.ndarray:
        """How far robot 1 is ahead, along its path, of the place that is level with each robot [m].

        Of robot 1 itself: how far it is ahead of the others' mean. Of what is not heard: 0.
        """
        if self.fixed.level is None:
            return np.zeros_like(self.place)
        level, known = self.fixed.level, self.known_places
        ahead = known[:, :, 0] - level.on_leader(self.place)
        followers = level.on_leader(known[:, 0])[:, 1:]
        heard = ~np.isnan(followers)
        mean = np.where(heard, followers, 0.0).sum(axis=1) / np.maximum(heard.sum(axis=1), 1)
        ahead[:, 0] = np.where(heard.any(axis=1), self.place[:, 0] - mean, 0.0)
        return np.nan_to_num(ahead)

    @cached_property
    def stretch(self) -> np.ndarray:
        """The way on the robot's own path for each metre of the path of robot 1, where the robot is."""
        return np.ones_like(self.place) if self.fixed.level is None else self.fixed.level.stretch(self.place)

    @cached_property
    def due(self) -> Reference:
        """The sample due by the robot's copy of the clock."""
        return self.seen.references.each_at(np.minimum(self.recall.clock, self.fixed.end))

    @cached_property
    def their_due(self) -> np.ndarray:
        """Where the others should be by the robot's copy of the clock [m] (runs, robots, others)."""
        if self.fixed.plan is None:
            return level_places(self.paths, self.due.s)
        shape = (*self.place.shape, self.place.shape[1])
        share = planned_share(self.fixed.plan, np.broadcast_to(self.recall.clock[..., None], shape))
        return np.asarray(share * self.fixed.lengths[..., None, :])

    @cached_property
    def target(self) -> Reference:
        """The point that the robot tracks."""
        return self._target or self.due

    @cached_property
    def error(self) -> PostureError:
        """The target as the robot sees it."""
        return posture_error(self.seen.x, self.seen.y, self.seen.heading, self.target)

    @cached_property
    def smooth_error(self) -> PostureError:
        """The same, smoothed over SMOOTH_TIME."""
        before, now, share = self.recall, self.error, share_of(SMOOTH_TIME, self.dt)
        x, y, heading = (
            np.where(np.isnan(old), new, old + share * (wrapped(new - old) if turns else new - old))
            for old, new, turns in zip((before.x_err, before.y_err, before.heading_err), now, (0, 0, 1), strict=True)
        )
        return PostureError(x, y, heading)

    def later(self, seconds: float) -> Reference:
        """The reference so many ``seconds`` after the robot's copy of the clock."""
        return self.seen.references.each_at(self.recall.clock + seconds)

    @cached_property
    def remaining(self) -> np.ndarray:
        """The way to the end of the path [m], the way back to it included."""
        return self.fixed.lengths - self.place + self.off

    @cached_property
    def best(self) -> np.ndarray:
        """The largest place less the way back to the path [m], updated where it has grown by BEST_GROWTH.

        A robot that has been stuck for long expects less: else it might go round and round what it cannot leave there.
        """
        net, before = self.place - self.off, self.recall.best
        relaxed = before - np.where(self.recall.stuck > STUCK_PATIENCE, EXPECTATION_LOSS * self.dt, 0.0)
        return np.where(net > before + BEST_GROWTH, net, relaxed)

    @cached_property
    def stuck(self) -> np.ndarray:
        """The time [s] without progress, other than by giving way or at the end."""
        on_time = self.due.s < self.place - self.off + (0.0 if self.fixed.plan is None else ON_PLAN)
        waits = (self.recall.yields > 0.5) | (self.remaining < NEAR_END) | on_time
        grown = self.recall.stuck + np.where(waits, 0.0, self.dt)
        return np.where(self.best > self.recall.best, 0.0, grown)

    @cached_property
    def others(self) -> OtherRobots:
        """The other robots as their messages predict them for now."""
        seen, heard = self.seen, self.seen.heard
        if not heard.fields:
            none = np.full(heard.age.shape, np.nan)
            return OtherRobots(*[*[none] * 10, heard.age])
        unheard = ~heard.hears
        x, y, v_x, v_y = heard.now("x", by="v_x"), heard.now("y", by="v_y"), heard["v_x"], heard["v_y"]
        dx, dy = x - seen.x[:, :, None], y - seen.y[:, :, None]
        distance, bearing = np.hypot(dx, dy), wrapped(np.arctan2(dy, dx) - seen.heading[:, :, None])
        cos, sin = np.cos(seen.heading)[:, :, None], np.sin(seen.heading)[:, :, None]
        towards = dx * (seen.v[:, :, None] * cos - v_x) + dy * (seen.v[:, :, None] * sin - v_y)
        radii = self.fixed.radii
        ahead, left = in_own_frame(seen, dx, dy)
        gap, closing, place = (
            distance - radii[:, None] - radii,
            towards / np.maximum(distance, 1e-6),
            heard.now("place", by="speed"),
        )
        rows = (x, y, ahead, left, v_x, v_y, gap, bearing, closing, place, heard.age)
        return OtherRobots(*(np.where(unheard, np.nan, row) for row in rows))

    @cached_property
    def meeting(self) -> Meeting:
        """Where each robot's path meets each other's next. A robot that is parked is met nowhere."""
        if self.fixed.meetings is None:
            none = np.full((*self.place.shape, 1), NOTHING_NEAR)
            return Meeting(none, none, none)
        theirs = self.others.place
        lengths = np.broadcast_to(self.fixed.lengths, self.place.shape)[:, None, :]
        parked = theirs > lengths - NEAR_END
        return next_meetings(self.fixed.meetings, 2 * self.fixed.radii, self.place, np.where(parked, np.nan, theirs))

    @cached_property
    def right_of_way(self) -> np.ndarray:
        """1 where the robot goes before the other, -1 where the other does; 0 for itself.

        A plan tells it, then the ends of the paths, then the robots' numbers.
        """
        number = np.arange(self.place.shape[1])
        by_number = np.sign(number - number[:, None]).astype(float)
        if self.fixed.meetings is None:
            return np.broadcast_to(by_number, (*self.place.shape, self.place.shape[1]))
        first = self.fixed.meetings.first
        demanded = first.astype(float) - np.swapaxes(first, -1, -2)
        rule = np.broadcast_to(np.where(demanded != 0, demanded, by_number), (len(self.place), *by_number.shape))
        if self.fixed.reached is None:
            return rule
        planned = planned_order(self.fixed.meetings, self.fixed.reached, self.place, self.others.place)
        return np.where(planned != 0, planned, rule)

    @cached_property
    def in_the_way(self) -> np.ndarray:
        """Whether another robot stands on the way ahead (runs, robots, others) bool.

        One that stands where a plan has it stand is in nobody's way: it goes on in time.
        """
        if self.fixed.meetings is None:
            return np.zeros((*self.place.shape, 1), dtype=bool)
        them, radii = self.others, self.fixed.radii
        off = in_the_way(self.fixed.meetings, self.place, them.x, them.y, LOOK_ALONG_PATH)
        stands = np.hypot(them.v_x, them.v_y) < STANDS
        if self.fixed.plan is not None:
            stands &= np.abs(self.their_due - them.place) > ON_PLAN
        return stands & (off < radii[:, None] + radii + CORRIDOR)

    @cached_property
    def echoes(self) -> np.ndarray:
        """The room to brake in each sector [m] (sectors, runs, robots) by what sensors read now, robots included."""
        if self.seen.ranges is None:
            return np.full_like(self.recall.clear, np.inf)
        return room_for_braking(self.fixed.sensors, self.seen.ranges.values)

    @cached_property
    def _values(self) -> np.ndarray:
        """What the sensors read [m] (runs, robots, sensors), without the other robots that are in nobody's way."""
        assert self.seen.ranges is not None
        values = self.seen.ranges.values
        if self.fixed.meetings is None:
            return values
        them, seen = self.others, self.seen
        dx, dy = them.x - seen.x[:, :, None], them.y - seen.y[:, :, None]
        speed = np.hypot(them.v_x, them.v_y)
        unsure = (speed + ACCELERATING * them.age) * them.age
        return without_robots(self.fixed.sensors, seen, values, dx, dy, speed > STANDS, unsure, self.fixed.radii)

    @cached_property
    def marks(self) -> EchoMarks:
        """Where something was seen that may be there still."""
        if self.seen.ranges is None:
            return self.recall.marks
        return self.recall.marks.renewed(self.fixed.sensors, self.seen, self._values, self.fixed.radii, self.dt)

    @cached_property
    def clear(self) -> np.ndarray:
        """The clearance in each sector [m] (sectors, runs, robots); infinite: nothing is seen."""
        now = self.marks.clearances(self.seen, self.fixed.radii)
        if self.seen.ranges is not None:
            now = np.minimum(now, sensed(self.fixed.sensors, self._values))
        if self.fixed.meetings is not None:
            now = np.minimum(now, standing_robots(self.others.gap, self.others.bearing, self.in_the_way))
        return np.minimum(now, self.recall.clear + (RISE * self.dt)[:, None, None])

    @cached_property
    def lean(self) -> np.ndarray:
        """How much more room there is ahead on the left than on the right [m], smoothed while something is near."""
        left, right = (np.minimum(self.clear[sector], FARTHEST) for sector in (SECTOR.front_left, SECTOR.front_right))
        now, before = left - right, self.recall.lean
        near = (np.minimum(left, right) < NOTICED) & (before != 0)
        return np.where(near, before + self.dt / SMOOTHING * (now - before), now)

    @cached_property
    def way(self) -> np.ndarray:
        """1 where the robot goes round to the left of an obstacle, or has not chosen yet; -1: to the right."""
        return np.where(self.recall.side >= 0, 1.0, -1.0)

    def on_wall_side(self, left: int, right: int) -> np.ndarray:
        """The clearance [m] of the sector ``left`` where the robot goes round to the right, else that of ``right``."""
        return np.where(self.recall.side >= 0, self.clear[right], self.clear[left])

    @cached_property
    def lost(self) -> np.ndarray:
        """The time [s] since the obstacle was seen that the robot goes round."""
        beside, ahead = (
            self.on_wall_side(SECTOR.left, SECTOR.right),
            self.on_wall_side(SECTOR.front_left, SECTOR.front_right),
        )
        sees = (beside < BESIDE) | (ahead < AHEAD_SEEN) | (self.recall.side == 0)
        return np.where(sees, 0.0, self.recall.lost + self.dt)

    @cached_property
    def way_back(self) -> np.ndarray:
        """The ground behind that the robot has just driven, straight [m]."""
        driven = self.dt * (self.seen.v - SWING * np.abs(self.seen.w))
        return np.clip(self.recall.way_back + driven, 0.0, LONGEST_WAY_BACK)

    @cached_property
    def least_room(self) -> np.ndarray:
        """The least clearance on all sides [m], as it is seen now."""
        return np.minimum(self.clear.min(axis=0), FARTHEST)

    @cached_property
    def nearest_room(self) -> np.ndarray:
        """The least clearance on all sides [m], without noise."""
        return self.recall.fast + self.dt / QUICK * (self.least_room - self.recall.fast)

    @cached_property
    def slow_room(self) -> np.ndarray:
        """The same as it was about a second ago."""
        return self.recall.slow + self.dt / SLOW * (self.least_room - self.recall.slow)

    @cached_property
    def coming(self) -> np.ndarray:
        """How much nearer the nearest thing has come within the last second than the robot has driven [m]."""
        return self.nearing - self.driven

    @cached_property
    def nearing(self) -> np.ndarray:
        """How much nearer the nearest thing has come within the last second, or the robot to it [m]."""
        return self.slow_room - self.nearest_room

    @cached_property
    def driven(self) -> np.ndarray:
        """The way that the robot has driven within about the last second, and by which its corners have swung [m]."""
        rate = np.abs(self.seen.v) + SWINGING * np.abs(self.seen.w)
        return self.recall.driven + self.dt / SLOW * (SLOW * rate - self.recall.driven)

    def remembered(
        self, *, pace: np.ndarray, keep: np.ndarray, yields: np.ndarray, v: np.ndarray, w: np.ndarray
    ) -> Recall:
        """What robots remember of this period. Their copies of the clock agree on the slowest.

        Args:
            pace: The rate of each robot's copy of the clock.
            keep: The side of an obstacle to keep: 1 this one, -1 the other, 0 none.
            yields: How much it gives way.
            v, w: The command [m/s], [rad/s].
        """
        heard, clock = self.seen.heard, self.recall.clock + self.dt * pace
        if heard.fields:
            theirs = heard.now("clock", by="pace") + self.dt * np.maximum(heard["pace"], 1.0)
            clock = smallest_heard(clock, theirs, heard.hears)
        return Recall(
            place=self.place,
            speed=(self.place - self.recall.place) / self.dt,
            clock=clock,
            pace=pace,
            best=self.best,
            stuck=self.stuck,
            side=self.recall.side + self.dt / SIDE_TIME * (self.way * keep - self.recall.side),
            clear=self.clear,
            yields=yields,
            way_back=self.way_back,
            lost=self.lost,
            driven=self.driven,
            fast=self.nearest_room,
            slow=self.slow_room,
            lean=self.lean,
            x_err=self.smooth_error.x,
            y_err=self.smooth_error.y,
            heading_err=self.smooth_error.heading,
            v_command=v,
            w_command=w,
            marks=self.marks,
        )

    def message(self, after: Recall) -> dict[str, np.ndarray]:
        """What each robot tells the others, by TEAM_MESSAGE; ``after`` is what it remembers of this period."""
        return {
            "place": self.place,
            "speed": after.speed,
            "clock": self.recall.clock,
            "pace": after.pace,
            "yields": after.yields,
            "stuck": after.stuck,
            "x": self.seen.x,
            "y": self.seen.y,
            "v_x": self.seen.v * np.cos(self.seen.heading),
            "v_y": self.seen.v * np.sin(self.seen.heading),
        }
