"""The laws that an arena of any kind was held with, and what they are called."""

from collections.abc import Sequence
from functools import cached_property
from typing import Any, Protocol

from robotics.laws.catalogue import law_title
from robotics.laws.law import Law
from robotics.laws.specification import Specification
from robotics.plugins.arena.plan import ArenaPlan


def short_title(law: str) -> str:
    """What a law is called without its gains, by its specification."""
    return law_title(str(Specification.of(law)._replace(gains="")))


class EnteredLaw(Protocol):
    """What is known of one law."""

    @property
    def law(self) -> str:
        """Its specification."""


class ArenaOutcome:
    """What came of an arena of any kind: a kind's dataclass says the arena and the entries, in the arena's order."""

    arena: ArenaPlan
    entries: Sequence[EnteredLaw]

    @property
    def laws(self) -> list[str]:
        """The specifications of the laws."""
        return [entry.law for entry in self.entries]

    @cached_property
    def titles(self) -> list[str]:
        """What the laws are called: without their gains, unless two would be called the same."""
        short = [short_title(law) for law in self.laws]
        return [t if short.count(t) == 1 else law_title(law) for t, law in zip(short, self.laws, strict=True)]

    @cached_property
    def made(self) -> list[Law[Any]]:
        """The laws as published."""
        return [self.arena.law(law) for law in self.laws]
