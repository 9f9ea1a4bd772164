"""Reading a scenario's file as far as it can be read, with all that is wrong with it and not only the first fault."""

import copy
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from robotics.laws.catalogue import located
from robotics.simulation.scenario.description import InfeasibleError, Scenario, ScenarioError
from robotics.simulation.scenario.reading import scenario_file, scenario_from_table
from robotics.tables.build import Keys
from robotics.tables.faults import FileFault, Remains
from robotics.tables.text import line_of, parse_table

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


# A robot in the place of those that cannot be read
_LANE = {"path": {"shape": "line", "start": [0.0, 0.0], "end": [1.0, 0.0]}, "timing": {"duration": 60.0}}


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
    rest, made = _Rest(table), list[Scenario]()

    def read(left: dict[str, Any]) -> None:
        try:
            made.append(scenario_from_table(left, name, folder))
        except InfeasibleError as error:
            made.append(error.scenario)

    faults = rest.faults(read)
    scenario = made[0] if made and not rest.stood_in else None
    count = len(scenario.robots) if scenario is not None else 0
    numbers = tuple(int(rest.original(("robots", i))[1]) for i in range(count))
    return Survey(text, file, scenario, controller if isinstance(controller, str) else "", tuple(faults), numbers)


class _Rest(Remains):
    """A scenario's table, from which more and more is left out."""

    stood_in = False  # whether its robots are none of the file's

    def mend(self, at: Keys) -> bool:
        """Put robots in the place of those of which too few can be read, or leave out what is wrong."""
        if self.stood_in or at != ("robots",):
            return self.drop(at)
        self.stood_in = True
        kind = self.table.get("kind")
        some = {"start": [0.0, 0.0, 0.0]} | ({"goal": {"at": [1.0, 0.0]}} if kind == "goal" else _LANE)
        self.table["robots"] = [copy.deepcopy(some) for _ in range(2 if kind == "team" else 1)]
        return True

    def explains(self, at: Keys) -> bool:
        """Likewise; also a robot that is missing where robots are counted, and the virtual robot of an offset."""
        here = self.original(at)
        if super().explains(at):
            return True
        if here[:1] == ("robots",) and (self.stood_in or (here[-1] == "offset" and ("virtual",) in self.dropped)):
            return True
        fewer = self.stood_in or any(len(gone) == 2 and gone[0] == "robots" for gone in self.dropped)
        return fewer and tuple(key for key in at if isinstance(key, str)) in _COUNTING
