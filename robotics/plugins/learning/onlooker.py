"""An onlooker: a law that finds out what robots know, tells it as the inputs of its rule base, and commands nothing."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from fuzzy.compiled.columns import Columns, column, several, within
from fuzzy.membership import Gaussian
from fuzzy.system import Sugeno, Variable
from robotics.laws.equation import AimColumns, Memory, equation
from robotics.laws.knowledge import SmoothedColumns
from robotics.laws.rules.asking import AskColumns, ask_numbers, told_of
from robotics.laws.rules.evaluation import RuleBase
from robotics.laws.rules.formation_networks import FormationPerceiving, FormationWanted, find_others
from robotics.laws.rules.perception import PerceivedColumns, TeamMessage, find_out, look_up, other_of, remember, tell
from robotics.laws.rules.quantities import quantity_of
from robotics.laws.rules.situation import NOTHING_NEAR, RecallColumns, TeamColumns
from robotics.laws.setting import Setting


class OnlookerColumns(RecallColumns):
    """What is remembered of a robot."""

    over = column("", "1: robot 1 has arrived")
    target = within(AimColumns)  # where it is told
    places = several(0, "m", "(robots,): the abscissae of all")


class OnlookerDerived(FormationWanted):
    """How it looks, and what for."""

    ask = within(AskColumns)


class OnlookerWork(Columns):
    """What it works in."""

    now = within(PerceivedColumns)
    rest = several(0)


@equation
def look_on(robot, aim, gain, memory, command, work, known, i, table):  # type: ignore[no-untyped-def]
    """Perceive, and tell what is asked for: of the robot, or of each other robot where that is heard."""
    now, rest, ask, due, target = work.now, work.rest, gain.ask, work.now.due, work.now.target
    if gain.by_time > 0:
        memory.clock = known.time
    if gain.along > 0:
        due.x, due.y, due.heading, due.v, due.w, due.s = aim.x, aim.y, aim.heading, aim.v, aim.w, aim.s
        to = memory.target
        target.x, target.y, target.heading, target.v, target.w, target.s = to.x, to.y, to.heading, to.v, to.w, to.s
    else:
        look_up(memory, gain.asks, known, i, table, now)
    find_out(robot, memory, gain.asks, known, i, table, now, rest)
    find_others(robot, gain, memory, known, i, table, now, rest)
    inputs, readings = command.inputs[int(gain.told) :], rest[int(gain.asks.readings) :]
    head, robots, count = TeamColumns(table), known.heard.shape[2], int(ask.count)
    for j in range(int(gain.each)):
        other = other_of(readings, head, robots, j)
        for n in range(count):
            value = told_of(other, int(ask.places[n]), ask.numbers[n], memory, known, i, head, now, readings)
            inputs[j * count + n] = np.nan if ask.pairs == 1 and other.counts == 0 else value
    if gain.radio == 1:
        tell(TeamMessage(command.inputs), robot, memory, now, known.dt, 1.0, 0.0)
    remember(memory, known, i, now, 1.0, 0.0, 0.0, robot.v, robot.w)  # what was commanded it does not hear


@dataclass(frozen=True, kw_only=True, eq=False)
class Onlooker(FormationPerceiving):
    """Looks at a formation, of whose commands it hears nothing; or through the memory of another law."""

    base: RuleBase  # whose inputs it tells, as they are
    each: int = 1  # the number of robots of whom it tells them, those that nobody hears as not-a-number
    ahead: float = 0.0  # s: so far ahead of what is due is the target
    by_time: bool = True  # whether the robots' clocks show the time
    along: bool = False  # whether it is told what is due, as its reference, and the target, in its memory

    equation, derived, remembers, works = look_on, OnlookerDerived, OnlookerColumns, OnlookerWork

    @property
    def rule_bases(self) -> Mapping[str, RuleBase]:
        """The one, by the name that :class:`robotics.plugins.learning.tandem.TeacherAndPupil` learns."""
        return {"inputs": self.base}

    @property
    def fuzzy_systems(self) -> Mapping[str, Sugeno]:
        """The same."""
        return {"inputs": self.base.fis}

    @property
    def rule_inputs(self) -> int:
        """How many numbers it tells."""
        return len(self.base.inputs) * self.each

    def derive(self, setting: Setting) -> Mapping[str, Any]:
        """How it perceives, and what it is asked for."""
        return {**self.perceives(setting, self.ahead), "ask": ask_numbers(self.base, {}, 0, 0, self.reads(setting))}

    def through(self, seen: Memory, begun: Memory) -> Memory:
        """The memory by which it looks through that of another law, ``seen``; it has ``begun`` in the same setting."""
        setup = seen.setup._replace(column=begun.setup.column, gains=begun.setup.gains)
        rows = np.zeros_like(begun.rows)
        rows[: RecallColumns.size] = seen.rows[: RecallColumns.size]
        return Memory(setup, rows, seen.reads)

    def ready(self, setting: Setting, runs: int) -> Memory:
        """A memory to be seen :meth:`through` another."""
        robots = len(setting.robots)
        rows = np.zeros((self.remembers.size + robots + SmoothedColumns.size, runs * robots))
        return Memory(self.setup(setting, runs), rows, self.reads(setting))


def inputs_of(names: Sequence[str]) -> list[Variable]:
    """Inputs that are these quantities, each with the set "any". Raises ControllerError for an unknown one."""
    some, span = {"any": Gaussian(NOTHING_NEAR, 0.0)}, (-NOTHING_NEAR, NOTHING_NEAR)
    return [Variable(name, span, some, quantity_of(name, "inputs").unit) for name in names]


def asking_for(names: Sequence[str]) -> RuleBase:
    """A rule base without rules that asks for these quantities. Raises ControllerError for an unknown one."""
    output = Variable("v", (0.0, 1.0), {"none": 0.0})
    return RuleBase.of(Sugeno(inputs_of(names), [output], [], "inputs"), {"v": "m/s"}, "inputs")
