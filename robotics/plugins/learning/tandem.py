"""A tandem of two laws on each robot: one drives, and both are asked what they would do in every state that it meets.

A law is a pure function of what the robots see and of its memory, so a second law can be asked beside the one that
drives; its own memory goes on in step. Each law's robots talk to each other on one radio, under names of their own.
"""

from dataclasses import dataclass, field, replace
from itertools import takewhile
from typing import Any, Literal, NamedTuple

import numpy as np

from robotics.laws.equation import Memory
from robotics.laws.law import Command, Law, Observation
from robotics.laws.rules.own_rules import OwnRules
from robotics.laws.setting import Setting
from robotics.plugins.learning.onlooker import Onlooker
from robotics.world.radio.channel import Heard
from robotics.world.vehicle.plant import Level

Driver = Literal["teacher", "pupil"]


class TandemMemory(NamedTuple):
    """What both laws remember, and what was found out in the last period."""

    teacher: Any
    pupil: Memory
    asked: Memory
    onlooker: Memory | None
    period: int  # the number of the next one
    said: Command | None  # by the teacher; none before the first period
    # The inputs of the pupil's rule base (runs, robots, 1, inputs), of pairs (runs, robots, others, inputs); all
    # not-a-number: it is not asked about that robot
    known: np.ndarray


@dataclass(frozen=True, kw_only=True, eq=False)
class TeacherAndPupil(Law[TandemMemory]):
    """Two laws on each robot, one of which drives; ``pushes`` are added to the velocities that it commands."""

    teacher: Law[Any]
    pupil: Any  # drives by rule bases of named inputs, as fuzzy and fuzzy-team do
    learns: str  # the task of the rule base that learns
    driver: Driver = "teacher"
    every: int = 1  # periods from one look at each other robot, of a rule base of pairs, to the next
    pushes: np.ndarray | None = None  # (periods, 2, runs, robots) m/s and rad/s; the last one holds on
    asked: Any = field(init=False, repr=False)  # the pupil without what it is given: tells the inputs of its rule base

    def __post_init__(self) -> None:
        super().__post_init__()
        asked = replace(self.pupil, lead=0.0, smooth=0.0)
        if not getattr(self.pupil, "corrects", False):
            object.__setattr__(self, "pupil", asked)
        object.__setattr__(self, "asked", asked)
        object.__setattr__(self, "estimator", self.pupil.estimator)

    @property
    def message(self) -> tuple[str, ...]:
        """The values that both laws broadcast."""
        both = (("teacher", self.teacher), ("pupil", self.pupil))
        return tuple(f"{who}.{name}" for who, law in both for name in law.message)

    @property
    def needs(self) -> tuple[str, ...]:
        """The range sensors that either law needs."""
        return tuple(dict.fromkeys((*self.teacher.needs, *self.pupil.needs)))

    @property
    def looks(self) -> bool:
        """Whether either law uses range sensors."""
        return self.teacher.looks or self.pupil.looks

    @property
    def level(self) -> Level:
        """What the law that drives commands."""
        return self._driving.level

    @property
    def watchdog(self) -> float:
        """That of the law that drives [s]."""
        return self._driving.watchdog

    @property
    def _driving(self) -> Law[Any]:
        return self.teacher if self.driver == "teacher" else self.pupil

    def init(self, setting: Setting, runs: int) -> TandemMemory:
        """Begin with the memories of both. Raises what they raise."""
        asked = self.asked.init(setting, runs)
        pupil = asked if self.pupil is self.asked else self.pupil.init(setting, runs)
        robots = len(setting.robots)
        base = self.asked.rule_bases[self.learns]
        onlooker = self._onlooker(robots).ready(setting, runs) if base.of_pairs else None
        known = np.full((runs, robots, robots if base.of_pairs else 1, len(base.inputs)), np.nan)
        return TandemMemory(self.teacher.init(setting, runs), pupil, asked, onlooker, 0, None, known)

    def _onlooker(self, robots: int) -> Onlooker:
        """What looks at each other robot as the pupil does; a rule base tells its inputs of the most urgent only."""
        rules = self.asked if isinstance(self.asked, OwnRules) else None
        return Onlooker(
            base=self.asked.rule_bases[self.learns],
            each=robots,
            ahead=0.0 if rules is None or rules.corrects else rules.look_ahead,
            by_time=rules is not None and "rate" not in rules.rule_bases["own"].outputs,
        )

    def control(self, seen: Observation, memory: TandemMemory, dt: float) -> tuple[Command, TandemMemory]:
        """Ask both laws, and command what the driving one says."""
        mine, theirs = _share(seen, "pupil", self.pupil), _share(seen, "teacher", self.teacher)
        said, teacher = self.teacher.control(theirs, memory.teacher, dt)
        told, asked = self.asked.control(mine, memory.asked, dt)
        done, pupil = told, asked
        if self.pupil is not self.asked:
            done, pupil = self.pupil.control(mine, memory.pupil, dt)
        known = memory.known
        if memory.onlooker is None:
            systems = self.asked.fuzzy_systems
            first = sum(len(systems[task].inputs) for task in takewhile(lambda task: task != self.learns, systems))
            known = np.moveaxis(told.inputs[first : first + known.shape[-1]], 0, -1)[:, :, None]
        elif memory.period % self.every == 0:
            onlooker = self._onlooker(seen.x.shape[1])
            looks, _ = onlooker.control(mine, onlooker.through(memory.asked, memory.onlooker), dt)
            assert looks.inputs is not None
            known = np.moveaxis(looks.inputs.reshape(*known.shape[2:], *seen.x.shape), (0, 1), (2, 3))
        command = said if self.driver == "teacher" else done
        pairs = (("teacher", said.message or {}), ("pupil", done.message or {}))
        message = {f"{who}.{name}": value for who, values in pairs for name, value in values.items()}
        command = command._replace(message=message or None, inputs=None, guarded=None)
        if self.pushes is not None and self.level == "velocity":
            v, w = self.pushes[min(memory.period, len(self.pushes) - 1)]
            command = command._replace(first=command.first + v, second=command.second + w)
        return command, TandemMemory(teacher, pupil, asked, memory.onlooker, memory.period + 1, said, known)


def _share(seen: Observation, who: Driver, law: Law[Any]) -> Observation:
    """What one of the two laws sees and hears: its own messages, and ranges only if it looks."""
    names = law.message
    heard = seen.heard
    if names:
        first = heard.fields.index(f"{who}.{names[0]}")
        heard = replace(heard, fields=names, values=heard.values[first : first + len(names)])
    else:
        heard = Heard.nothing(*seen.x.shape)
    return seen._replace(heard=heard, ranges=seen.ranges if law.looks else None)
