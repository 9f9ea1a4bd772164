"""All that is wrong with a TOML file, and not only the first fault, at which its reader refuses it.

What a fault is about is left out, and the rest is read again, until nothing is wrong. What is wrong only because
something else was left out is not told.
"""

import copy
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from fuzzy.errors import InputError
from robotics.tables.build import Keys

_MOST = 200  # faults that are looked for


@dataclass(frozen=True)
class FileFault:
    """Something in a file that the reader refuses."""

    sentence: str
    at: Keys  # the keys that it is about, as the file has them


class Remains:
    """A file's table, from which more and more is left out."""

    def __init__(self, table: dict[str, Any]) -> None:
        self.table = copy.deepcopy(table)
        self.dropped: list[Keys] = []  # as the file has them
        self.numbers: dict[int, list[int]] = {}  # by a list's identity: the numbers that its entries have in the file

    def faults(self, read: Callable[[dict[str, Any]], Any]) -> list[FileFault]:
        """Everything that ``read`` refuses of the table; in the end it reads what is left of it, if it can."""
        found = []
        for _ in range(_MOST):
            try:
                read(self.table)
                break
            except InputError as error:
                if not self.explains(error.at):
                    found.append(FileFault(str(error), self.original(error.at)))
                if not self.mend(error.at):
                    break
        return found

    def mend(self, at: Keys) -> bool:
        """Change the table for a fault at ``at``, so that the rest can be read; False if nothing helps."""
        return self.drop(at)

    def explains(self, at: Keys) -> bool:
        """Whether something that was left out, a part of what stands at ``at``, explains a fault there."""
        here = self.original(at)
        return any(gone[: len(here)] == here for gone in self.dropped)

    def original(self, at: Keys) -> Keys:
        """The keys in the file of what now stands at ``at``."""
        node: Any = self.table
        found: list[str | int] = []
        for key in at:
            numbers = self.numbers.get(id(node), []) if isinstance(node, list) else []
            found.append(numbers[key] if isinstance(key, int) and key < len(numbers) else key)
            try:
                node = node[key]
            except (KeyError, IndexError, TypeError):
                node = None
        return tuple(found)

    def drop(self, at: Keys) -> bool:
        """Leave out what stands at ``at``, or the innermost table around it; False if there is nothing."""
        places: list[tuple[Any, Any]] = []
        node: Any = self.table
        step: Any
        for step in at:
            known: Any = node if isinstance(node, dict) else range(len(node)) if isinstance(node, list) else ()
            if step in known:
                places.append((node, step))
                node = node[step]
            else:
                break
        if not places:
            return False
        inside, last = places[-1]
        self.dropped.append(self.original(at[: len(places)]))
        if isinstance(inside, list):
            self.numbers.setdefault(id(inside), list(range(len(inside)))).pop(last)
        del inside[last]
        return True
