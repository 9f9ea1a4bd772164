"""What the plans of all arenas have: who takes part, with what budget each is tuned, and three blocks of scenarios.

Three blocks of scenarios, and of seeds, have nothing in common: laws are tuned on the first, what was tuned is chosen
among on the second, and what is said of the chosen ones is measured on the third. Scenario number k of a block, and its
seeds, count from the first number of the block: 1,000,000 for tuning, 2,000,000 for choosing, 3,000,000 for testing.

What robots do, how they are judged and what is asked of the table are the kind's: see
:mod:`robotics.plugins.arena.kinds`.
"""

from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path
from typing import Any, ClassVar, Literal, Self

from fuzzy.errors import InputError
from fuzzy.naming import check_known
from fuzzy.quantity import check_quantities, described, whole
from fuzzy.tuning.engines import ENGINES
from robotics.laws.catalogue import as_law, located
from robotics.laws.law import Law
from robotics.studies.tuning.space import PARTS, PARTS_MOVED, LawSpace, NothingMovesError
from robotics.studies.tuning.tune import CHOOSING, TESTING, TUNING
from robotics.tables.build import Builder, Keys

Block = Literal["tune", "choose", "test"]
BLOCKS: Mapping[Block, int] = {"tune": TUNING, "choose": CHOOSING, "test": TESTING}
MOST_SEEDS = 900_000  # of a block, so that it ends before the next one begins


class ArenaError(InputError):
    """An arena that cannot be held. The message names the file, line, key and what is accepted."""


@dataclass(frozen=True, kw_only=True)
class ArenaPlan(ABC):
    """An arena before it is held, whatever robots do in it; a kind's dataclass adds what they do.

    Attributes:
        name: What it is called: its file's name.
        folder: Where files that it names are looked for first.

    Raises:
        ArenaError: An arena that cannot be held.
    """

    kind: ClassVar[str]  # of robotics.plugins.arena.kinds
    filled: ClassVar[tuple[str, ...]] = ("laws", "engines", *BLOCKS)  # the lists that have one entry at least

    name: str
    title: str = described("What is asked, in a line.", "", example="Which law for my robot?")
    laws: tuple[str, ...] = described(
        "The laws: names with gains, mine.fis, mylaw.py:MyLaw; files are relative to this one.",
        example=["fuzzy", "lyapunov"],
    )
    engines: tuple[str, ...] = described("The engines that search: of cmaes, random.", ("cmaes", "random"))
    move: tuple[str, ...] = described(f"What may move of a law: of {', '.join(PARTS)}.", PARTS_MOVED)
    evaluations: int = whole(300, least=1, most=1_000_000, doc="How many candidates each search tries.")
    repeats: int = whole(2, least=1, most=100, doc="How often each engine searches, each time with other seeds.")
    seed: int = whole(1, least=0, most=10**9, doc="The seed of the searches and of the intervals.")
    exceptions: Mapping[str, int] = described(
        "Evaluations of laws that compute for too long: no longer the same budget, and said so.", default_factory=dict
    )
    folder: Path = field(default=Path(), compare=False)

    def __post_init__(self) -> None:
        check_quantities(self, ArenaError)
        for name in self.filled:
            values = getattr(self, name)
            if not values:
                raise ArenaError(f"{name} must have at least one").about(name)
            if name in ("laws", "engines") and len({*values}) < len(values):
                raise ArenaError(f"{name}: one of {', '.join(values)} is given twice").about(name)
        for engine in self.engines:
            check_known(engine, ENGINES, "engine", ArenaError, "engines")
        for part in self.move:
            check_known(part, PARTS, "part that can move", ArenaError, "move")
        for i, law in enumerate(self.laws):
            try:
                self._movable(law)
            except InputError as error:
                raise ArenaError(f"laws: {error}").about("laws", i) from None
        if len(self.untuned) == len(self.laws):
            raise ArenaError(f"laws: none has anything that moves, of {', '.join(self.move)}").about("laws")
        for law in self.exceptions:
            check_known(law, self.laws, "law of the arena", ArenaError, "exceptions", law)

    @abstractmethod
    def scenarios(self, block: Block) -> Sequence[Any]:
        """The scenarios of ``block``: "tune", "choose" or "test". Raises ArenaError, and RobotError."""

    @abstractmethod
    def about(self) -> dict[str, Any]:
        """All that determines its numbers, as JSON can hold it."""

    @property
    def tested(self) -> str:
        """What is said of the tests beside the number of scenarios."""
        return ""

    def law(self, specification: str) -> Law[Any]:
        """The law of a ``specification``, its files looked for beside the arena's first."""
        return as_law(located(specification, self.folder))

    def space(self, law: str) -> LawSpace | None:
        """What may move of ``law``, a specification, by the one rule for all; None: it takes part as published."""
        if law not in self._spaces:
            whole = self._movable(law)
            self._spaces[law] = whole and self.reached(whole)
        return self._spaces[law]

    def reached(self, space: LawSpace) -> LawSpace:
        """A ``space`` without what no tuning run says anything of; here as it is."""
        return space

    def _movable(self, law: str) -> LawSpace | None:
        """The same with what no tuning run reaches."""
        try:
            return LawSpace(self.law(law), self.move)
        except NothingMovesError:
            return None

    @cached_property
    def _spaces(self) -> dict[str, LawSpace | None]:
        """What may move, by law, as far as it was asked for."""
        return {}

    @cached_property
    def untuned(self) -> tuple[str, ...]:
        """The laws of which nothing moves: they take part as published."""
        return tuple(law for law in self.laws if self._movable(law) is None)

    def said_of_untuned(self) -> list[str]:
        """A sentence for each of them."""
        what = f"nothing of it moves, of {', '.join(self.move)}; it takes part as published"
        return [f"{law}: {what}" for law in self.untuned]

    def budget(self, law: str) -> int:
        """How many candidates each search of ``law``, a specification, tries: 0 where nothing of it moves."""
        return 0 if law in self.untuned else self.exceptions.get(law, self.evaluations)

    def count(self, block: Block) -> int:
        """How many scenarios ``block`` has: "tune", "choose" or "test"."""
        return sum(family.count for family in getattr(self, block))

    def labels(self, block: Block) -> list[str]:
        """What the scenarios of ``block`` are called, no two alike."""
        said = [family.label for family in getattr(self, block) for _ in range(family.count)]
        return [f"{text} {said[: n + 1].count(text)}" if said.count(text) > 1 else text for n, text in enumerate(said)]

    def with_laws(self, laws: Sequence[str]) -> Self:
        """The same arena with other ``laws``, their specifications. Raises ArenaError."""
        kept = {law: count for law, count in self.exceptions.items() if law in laws}
        return replace(self, laws=tuple(laws), exceptions=kept)


def _exceptions(value: Any, keys: Keys) -> dict[str, int]:
    table = PLAN_BUILDER.table(value, keys)
    for law, count in table.items():
        if type(count) is not int or count < 1:
            raise ArenaError(f"the evaluations of {law} must be a whole number >= 1; got {count!r}").about(*keys, law)
    return table


PLAN_BUILDER = Builder(ArenaError, {Mapping[str, int]: _exceptions})
