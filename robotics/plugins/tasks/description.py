"""Arenas of tasks as data: the teams' scenarios, the laws, and what rare contacts weigh while a law is tuned."""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, ClassVar

from fuzzy.quantity import described, part, quantity
from robotics.laws.catalogue import gains_of
from robotics.laws.law import Law
from robotics.plugins.arena.plan import BLOCKS, MOST_SEEDS, PLAN_BUILDER, ArenaError, ArenaPlan, Block
from robotics.plugins.tasks.families import TaskFamily, TaskScenario
from robotics.studies.tuning.space import LawSpace, NothingMovesError

TASKS_PAGE = "tasks.html"
CLASSES = ("own sensors", "radio", "everything beforehand")
GUARD = "guard.on"  # the gain by which a law's emergency rule acts, or does not


@dataclass(frozen=True, kw_only=True)
class TaskArena(ArenaPlan):
    """An arena of tasks before it is held.

    Laws are ranked on the test by contacts caused, then deadlocks, then the time over nominal, then the spread of the
    arrivals, the gap, restlessness and least clearance. A search needs one number: what a candidate costs is

        contact (share of runs with a contact caused) + tail CVaR + deadlock (share of deadlocks) + mean time − 1

    with CVaR the mean, over the share ``worst`` of the runs with the least clearances, of max(1 − clearance/near, 0):
    contacts are rare, and how nearly there were some is not.

    Raises:
        ArenaError: An arena that cannot be held.
    """

    kind: ClassVar[str] = "tasks"

    contact: float = quantity(100.0, "1", least=0, most=1e6, doc="What contacts caused in all runs cost in a search.")
    deadlock: float = quantity(10.0, "1", least=0, most=1e6, doc="What deadlocks in all runs cost in a search.")
    tail: float = quantity(5.0, "1", least=0, most=1e6, doc="What the tail of the clearances costs in a search.")
    worst: float = part(0.1, doc="The share of the runs, those with the least clearances, that the tail is of.")
    near: float = quantity(0.1, "m", above=0, most=10, doc="The clearance from which on the tail costs nothing.")
    tune: tuple[TaskFamily, ...] = described("The scenarios that are tuned on.")
    choose: tuple[TaskFamily, ...] = described("The scenarios by which is chosen among what was tuned.")
    test: tuple[TaskFamily, ...] = described("The scenarios that nobody has seen before.")

    def __post_init__(self) -> None:
        super().__post_init__()
        for block in BLOCKS:
            count = self.count(block) * (self.repeats if block == "tune" else 1)
            if count > MOST_SEEDS:
                raise ArenaError(f"{block} must have at most {MOST_SEEDS} scenarios; got {count}").about(block)

    def scenario(self, block: Block, place: int, repeat: int = 0) -> TaskScenario:
        """The scenario at a place of a block, from 0; each repeat of the searches has others to tune on."""
        left = place
        for family in getattr(self, block):
            if left < family.count:
                found: TaskScenario = family.scenario(BLOCKS[block] + repeat * self.count(block) + place)
                return found
            left -= family.count
        raise IndexError(place)

    def scenarios(self, block: Block) -> list[TaskScenario]:
        """The scenarios of ``block``: "tune", "choose" or "test", drawn. Raises ArenaError, and RobotError."""
        return [self.scenario(block, place) for place in range(self.count(block))]

    def about(self) -> dict[str, Any]:
        """All that determines its numbers, as JSON can hold it."""
        plain = ("engines", "move", "evaluations", "repeats", "seed", "contact", "deadlock", "tail", "worst", "near")
        return {
            "kind": self.kind,
            "laws": {law: repr(self.law(law)) for law in self.laws},
            **{name: getattr(self, name) for name in plain},
            "exceptions": dict(self.exceptions),
            "families": {block: [repr(family) for family in getattr(self, block)] for block in BLOCKS},
        }

    def _movable(self, law: str) -> LawSpace | None:
        """The same without the switch of the emergency rule, which is no number to be tuned."""
        made = self.law(law)
        try:
            space = LawSpace(made, self.move)
            guarded = any(p.name == GUARD for p in space.parameters)
            return LawSpace(made, self.move, fixed=(GUARD,)) if guarded else space
        except NothingMovesError:
            return None


def tasks_from_table(table: Mapping[str, Any], name: str, folder: Path) -> TaskArena:
    """Make an arena of tasks of a table. Raises an InputError whose ``at`` holds the keys that it is about."""
    made: TaskArena = PLAN_BUILDER.build(TaskArena, table, (), ("like", "kind"), name=name, folder=folder)
    return made


def knowledge_of(law: Law[Any]) -> str:
    """What a law knows of others, one of CLASSES.

    A law that plans before the start knows all paths and their timing; one that broadcasts knows what others tell, with
    loss and latency, and what its sensors see; any other knows what its sensors see, or nothing.
    """
    return CLASSES[2] if getattr(law, "may_refuse", False) else CLASSES[1] if law.message else CLASSES[0]


def guarded(law: Law[Any]) -> bool:
    """Whether a law has an emergency rule that can be left out, and that acts."""
    return bool(gains_of(law).get(GUARD))
