"""Leader and followers on any paths: a law by quantities that rule bases can learn.

Robot 1 leads. Each robot drives along its own path, which may close, cross itself and turn back in x; its place there
is the nearest point about where it was before. With d the leader's lead over a robot, along the leader's path, and over
the followers' mean for the leader itself (``leader_ahead``), λ the way on the own path for each metre of the leader's
(``stretch``), and β the bearing of the own path's point L further on (``onward_bearing``),

    v_1 = v_d S(d; 3/2, 0, 2)        the leader hurries from behind and waits in front
    v_i = v_d λ S(d; 1/4, 7/4, 4)    the followers wait for a leader behind and hurry after one ahead
    ω = 2 v sin(β)/L                 along the arc through that point: pure pursuit

with S of :func:`robotics.laws.formation.leader_follower.pace`, which is 1 at d = 0. The law is a smooth function of
three quantities, so a network of them can learn it. Of the S curves the forms are those of thesis 5.2.1, the numbers
are choices: the wheels must not saturate, and a follower must come into its place by itself, not only when the leader
waits for the mean.

Stability: with e_i = d_i − d_1 a follower's lead beside the mean, e_i' = −v_d S'(0) e_i = −(3/2) v_d e_i, and the mean
lead decays with v_d (3/2 + 1). A lateral error obeys e'' + (2/L) e' + (2/L²) e = 0 per metre: a damping of 0.71; where
the curvature changes by κ' per metre it is κ' L³/6 (4.5 mm for L = 0.3 m and κ' = 1 1/m²).

All robots stop when the leader reaches the end of its path. One computer commands all robots: nothing is heard by
radio, late or lost.
"""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from fuzzy.quantity import quantity
from robotics.laws.formation.leader_follower import pace
from robotics.laws.law import Command, ControllerError, Law, Observation
from robotics.laws.rules.situation import ONWARD, Fixed, Recall, Situation
from robotics.laws.setting import Setting
from robotics.world.paths.references import Reference

_AT_END = 1e-3  # m: a leader this near to the end of its path has arrived
_MARGIN = 0.2  # m: between the turning circles of robots whose paths do not meet


class FormationMemory(NamedTuple):
    """What is known before the start, what robots remember, and in which runs the leader has arrived."""

    fixed: Fixed
    recall: Recall
    over: np.ndarray  # (runs,) bool: then all stand still

    @classmethod
    def start(cls, setting: Setting, runs: int, *, meetings: bool = False) -> "FormationMemory":
        """Begin. ``meetings``: whether to look where paths meet.

        Raises ControllerError for a single robot.
        """
        if len(setting.robots) < 2:
            raise ControllerError(f"{setting.name}: a formation needs a leader and followers, at least two robots")
        fixed, recall = Fixed.of(setting, _MARGIN, meetings=meetings), Recall.start(setting, runs)
        # Where a path closes, its end is as near as its beginning: look no farther than the robot may be
        begin = setting.references.at(0.0)
        x, y, _ = np.moveaxis(np.broadcast_to(setting.starts, (*recall.place.shape, 3)), -1, 0)
        reach = 0.2 + 1.2 * np.hypot(x - begin.x, y - begin.y)
        near = setting.references.joined.nearest(x, y, np.broadcast_to(begin.s, x.shape), reach)
        return cls(fixed, recall._replace(place=near, best=near), np.zeros(runs, dtype=bool))

    def situation(self, seen: Observation, dt: float) -> Situation:
        """All that robots know now; the clock shows the time, and the target is the sample due."""
        return Situation(seen, self.fixed, self.recall._replace(clock=np.full_like(self.recall.clock, seen.time)), dt)

    def after(self, now: Situation, v: np.ndarray, w: np.ndarray) -> "FormationMemory":
        """What is remembered of a period with its command, all that quantities may ask for."""
        zero = np.zeros_like(now.place)
        recall = now.remembered(pace=zero + 1.0, keep=zero, yields=zero, v=v, w=w)
        return self._replace(recall=recall, over=self.arrived(now))

    def arrived(self, now: Situation) -> np.ndarray:
        """In which runs the leader has reached the end of its path by now (runs,) bool."""
        length = np.broadcast_to(now.fixed.lengths, now.place.shape)[:, 0]
        return np.asarray(self.over | (now.place[:, 0] >= length - _AT_END))


@dataclass(frozen=True, kw_only=True)
class FollowLeader(Law[FormationMemory]):
    """The law of the module's head."""

    speed: float = quantity(0.0, "m/s", least=0, doc="Speed v_d of the leader; 0: that of its timing.")
    leader_rate: float = quantity(2.0, "1/m", above=0, doc="How steeply the leader's speed falls with its lead.")
    rate: float = quantity(4.0, "1/m", above=0, doc="How steeply the followers' speed grows with the leader's lead.")

    def init(self, setting: Setting, runs: int) -> FormationMemory:
        """Find the robots on their paths. Raises ControllerError for a single robot."""
        return FormationMemory.start(setting, runs)

    def control(self, seen: Observation, memory: FormationMemory, dt: float) -> tuple[Command, FormationMemory]:
        """Evaluate the law at the measured postures."""
        now = Situation(seen, memory.fixed, memory.recall, dt)
        v = self.speed_of(seen) * now.stretch * pace(now.leader_ahead, 0.25, 1.75, self.rate)
        v[:, 0] = (self.speed_of(seen) * pace(now.leader_ahead, 1.5, 0.0, self.leader_rate))[:, 0]
        w = 2 * v * np.sin(now.onward_bearing) / ONWARD
        memory = memory._replace(recall=memory.recall._replace(place=now.place), over=memory.arrived(now))
        v[memory.over], w[memory.over] = 0.0, 0.0
        return Command(v, w, v, w, target=level_target(now, v[:, :1])), memory

    def speed_of(self, seen: Observation) -> np.ndarray | float:
        """v_d [m/s], one number or (runs, 1)."""
        if self.speed:
            return self.speed
        references = seen.references
        way = references.joined.lengths - references.at(0.0).s
        return np.asarray((way / references.ends)[..., :1])


def level_target(now: Situation, speed: np.ndarray) -> Reference:
    """The places of all robots that are level with the leader, which drives at ``speed`` (runs, 1) [m/s]."""
    level = now.fixed.level
    assert level is not None
    s = level.place(np.broadcast_to(level.share(now.place)[:, :1], now.place.shape))
    point, v = now.paths.at(s), speed * level.stretch(s)
    return Reference(point.x, point.y, point.heading, v, v * point.curvature, s)
