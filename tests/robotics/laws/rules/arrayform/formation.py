"""Networks of single robots that drive a formation, on arrays."""

from typing import Any, NamedTuple

import numpy as np

from robotics.laws.law import Command, Observation
from robotics.laws.rules.formation_networks import RobotNetworks
from robotics.laws.rules.perceiving import MEETING_MARGIN
from robotics.laws.setting import Setting
from robotics.world.paths.references import Reference
from tests.robotics.laws.rules.arrayform.evaluation import answer, told
from tests.robotics.laws.rules.arrayform.situation import Fixed, Recall, Situation

AT_END = 1e-3  # m


class FormationMemory(NamedTuple):
    """What is known before the start, what robots remember, and in which runs the leader has arrived."""

    fixed: Fixed
    recall: Recall
    over: np.ndarray  # (runs,) bool: then all stand still

    @classmethod
    def start(cls, setting: Setting, runs: int, *, meetings: bool = False) -> "FormationMemory":
        """Begin. ``meetings``: whether to look where paths meet."""
        fixed, recall = Fixed.of(setting, MEETING_MARGIN, meetings=meetings), Recall.start(setting, runs)
        begin = setting.references.at(0.0)
        x, y, _ = np.moveaxis(np.broadcast_to(setting.starts, (*recall.place.shape, 3)), -1, 0)
        reach = 0.2 + 1.2 * np.hypot(x - begin.x, y - begin.y)
        near = setting.references.joined.nearest(x, y, np.broadcast_to(begin.s, x.shape), reach)
        return cls(fixed, recall._replace(place=near, best=near), np.zeros(runs, dtype=bool))

    def situation(self, seen: Observation, dt: float) -> Situation:
        """All that robots know now; the clock shows the time, and the target is the sample due."""
        return Situation(seen, self.fixed, self.recall._replace(clock=np.full_like(self.recall.clock, seen.time)), dt)

    def after(self, now: Situation, v: np.ndarray, w: np.ndarray) -> "FormationMemory":
        """What is remembered of a period with its command."""
        zero = np.zeros_like(now.place)
        recall = now.remembered(pace=zero + 1.0, keep=zero, yields=zero, v=v, w=w)
        return self._replace(recall=recall, over=self.arrived(now))

    def arrived(self, now: Situation) -> np.ndarray:
        """In which runs the leader has reached the end of its path by now (runs,) bool."""
        length = np.broadcast_to(now.fixed.lengths, now.place.shape)[:, 0]
        return np.asarray(self.over | (now.place[:, 0] >= length - AT_END))


def level_target(now: Situation, speed: np.ndarray) -> Reference:
    """The places of all robots that are level with the leader, which drives at ``speed`` (runs, robots) [m/s]."""
    level = now.fixed.level
    assert level is not None
    s = level.place(np.broadcast_to(level.share(now.place)[:, :1], now.place.shape))
    point, v = now.paths.at(s), speed * level.stretch(s)
    return Reference(point.x, point.y, point.heading, v, v * point.curvature, s)


class InterpretedNetworks(RobotNetworks):
    """Two networks for each robot of a formation, on arrays."""

    def init(self, setting: Setting, runs: int) -> Any:
        """Find the robots on their paths."""
        return FormationMemory.start(setting, runs, meetings=bool(self.message) or self.looks)

    def control(self, seen: Observation, memory: Any, dt: float) -> tuple[Command, Any]:
        """Ask each robot's networks."""
        now = memory.situation(seen, dt)
        wish = {"v": np.zeros_like(seen.x), "w": np.zeros_like(seen.x)}
        rows = []
        for network in self.own:
            place = network.robot - 1
            known = np.ascontiguousarray(told(network.rules, now)[:, place])
            wish[network.output][:, place] = answer(network.rules, known)[network.name]
            row = np.full((known.shape[1], *seen.x.shape), np.nan)
            row[..., place] = known.T
            rows.append(row)
        over = memory.arrived(now)[:, None]
        v, w = (np.where(over, 0.0, wish[name]) for name in ("v", "w"))
        after = memory.after(now, v, w)
        leads = np.where(over, 0.0, np.repeat(seen.v[:, :1], seen.x.shape[1], axis=1))
        leads[:, 0] = v[:, 0]
        message = now.message(after.recall) if self.message else None
        progress = now.paths.share(now.place)
        target = level_target(now, leads)
        return Command(v, w, v, w, message, target, progress, inputs=np.concatenate(rows)), after
