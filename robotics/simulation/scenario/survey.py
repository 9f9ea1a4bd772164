"""Reading a scenario's file as far as it can be read, with all that is wrong with it and not only the first fault.

The reader refuses a file at its first fault. Here what a fault is about is left out, and the rest is read again, until
nothing is wrong. What is wrong only because something else was left out is not told.
"""

import copy
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from fuzzy.errors import InputError
from robotics.laws.catalogue import located
from robotics.simulation.scenario.description import InfeasibleError, Scenario, ScenarioError
from robotics.simulation.scenario.reading import scenario_file, scenario_from_table
from robotics.tables.build import Keys
from robotics.tables.text import line_of, parse_table

_MOST = 200  # faults that are looked for
# The keys that count the robots, without the numbers of entries: wrong as soon as one robot is left out
_COUNTING: tuple[tuple[str, ...], ...] = (
    (),
    ("robots",),
    ("virtual",),
    ("radio", "hub"),
    ("radio", "edges"),
    ("faults", "robot"),
    ("faults", "other"),
)


@dataclass(frozen=True)
class FileFault:
    """Something in a file that the reader refuses."""

    sentence: str
    at: Keys  # the keys that it is about, as the file has them


@dataclass(frozen=True)
class Survey:
    """A scenario's file as far as it can be read."""

    text: str
    file: str
    scenario: Scenario | None  # without what is wrong, and without its controller; its references may be infeasible
    controller: str  # that the file names
    faults: tuple[FileFault, ...]
    robots: tuple[int, ...] = ()  # the number in the file, from 0, of each robot that could be read

    def line(self, at: Keys) -> int:
        """The line (from 1) on which ``at`` stands."""
        return line_of(self.text, at)


def survey(name: str) -> Survey:
    """Read the packaged scenario of that name, or a ``.toml`` file.

    Raises ScenarioError for a file that is not there or is not TOML.
    """
    found = scenario_file(name)
    return survey_text(found.text, found.name, found.file, found.folder)


def survey_text(text: str, name: str, file: str = "<text>", folder: Path = Path()) -> Survey:
    """As :func:`survey`, of a file's text.

    Args:
        text: The TOML text.
        name: The name of the scenario.
        file: The name of the file in messages.
        folder: Where files of robots and controllers are looked for before the current folder.
    """
    table = parse_table(text, file, ScenarioError)
    controller = table.get("controller", "")
    if isinstance(controller, str):
        table.pop("controller", None)
        controller = located(controller, folder)
    rest = _Rest(table)
    faults: list[FileFault] = []
    scenario = None
    for _ in range(_MOST):
        try:
            scenario = scenario_from_table(rest.table, name, folder)
            break
        except InfeasibleError as error:
            scenario = error.scenario
            break
        except InputError as error:
            at = rest.original(error.at)
            if not rest.explains(error.at):
                faults.append(FileFault(str(error), at))
            if not rest.drop(error.at):
                break
    count = len(scenario.robots) if scenario is not None else 0
    numbers = tuple(int(rest.original(("robots", i))[1]) for i in range(count))
    return Survey(text, file, scenario, controller if isinstance(controller, str) else "", tuple(faults), numbers)


class _Rest:
    """A file's table, from which more and more is left out."""

    def __init__(self, table: dict[str, Any]) -> None:
        self.table = copy.deepcopy(table)
        self.dropped: list[Keys] = []  # as the file has them
        self.numbers: dict[int, list[int]] = {}  # by a list's identity: the numbers that its entries have in the file

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

    def explains(self, at: Keys) -> bool:
        """Whether something that was left out explains a fault at ``at``: a part of it, or a robot that is counted."""
        here = self.original(at)
        if any(gone[: len(here)] == here for gone in self.dropped):
            return True
        fewer = any(len(gone) == 2 and gone[0] == "robots" for gone in self.dropped)
        return fewer and tuple(key for key in at if isinstance(key, str)) in _COUNTING

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
