"""The kinds of TOML files that one writes oneself: for each its keys, its reader, and values to begin with.

A kind that is registered here has its explanation, its JSON schema and its commented file.
"""

import tomllib
from collections.abc import Mapping
from dataclasses import dataclass
from importlib import resources
from pkgutil import resolve_name
from typing import Any

from fuzzy.errors import InputError
from fuzzy.naming import expected
from robotics.tables.keys import KeyTable


@dataclass(frozen=True)
class FileKind:
    """One kind of file. Its keys and its reader are functions, "module:function", imported when they are called."""

    title: str
    keys: str  # describes the file's outermost table
    reader: str  # of a file's text, and of what messages call it
    use: str  # the command that uses a file, with FILE for its name
    templates: Mapping[str, str]  # in robotics/data/templates/, without .toml, by --kind; the first is the default

    def table(self) -> KeyTable:
        """The description of the file's outermost table."""
        found: KeyTable = resolve_name(self.keys)()
        return found

    def read(self, text: str) -> Any:
        """What a file's text describes. Raises an InputError for one that cannot be read."""
        return resolve_name(self.reader)(text, "new")

    @property
    def values(self) -> dict[str, dict[str, Any]]:
        """What files begin with, as they have it, by --kind."""
        folder = resources.files("robotics") / "data" / "templates"
        return {
            kind: tomllib.loads((folder / f"{file}.toml").read_text(encoding="utf-8"))
            for kind, file in self.templates.items()
        }


FILE_KINDS: dict[str, FileKind] = {
    "scenario": FileKind(
        "a scenario",
        "robotics.simulation.scenario.keys:scenario_table",
        "robotics.simulation.scenario.reading:parse_scenario",
        "robotics check FILE, then robotics run FILE",
        {kind: f"scenario-{kind}" for kind in ("tracking", "team", "formation")},
    ),
    "robot": FileKind(
        "a robot",
        "robotics.simulation.scenario.keys:robot_file_table",
        "robotics.simulation.scenario.robots:parse_robot",
        "robotics robot FILE",
        {"robot": "robot"},
    ),
    "sweep": FileKind(
        "a sweep",
        "robotics.show.report.keys:sweep_table",
        "robotics.show.report.plan:parse_study",
        "robotics sweep FILE",
        {"sweep": "sweep"},
    ),
    "tuning": FileKind(
        "a tuning",
        "robotics.studies.tuning.file:tuning_table",
        "robotics.studies.tuning.file:parse_tuning",
        "robotics tune fuzzy lyapunov-sine --space FILE",
        {"tuning": "tuning"},
    ),
    "study": FileKind(
        "a study",
        "robotics.show.report.keys:study_table",
        "robotics.show.report.plan:parse_study",
        "robotics study FILE",
        {"study": "study"},
    ),
}


def file_kind(name: str) -> FileKind:
    """The kind of file of that name. Raises InputError for another."""
    if name not in FILE_KINDS:
        raise InputError(expected(name, FILE_KINDS, "kind of file"))
    return FILE_KINDS[name]
