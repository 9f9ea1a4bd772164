"""The kinds of arenas, which entry points name, and the reading of an arena's file, whatever its kind.

A file's key ``kind`` says what robots do in it: "tracking", which is meant where it is left out, "tasks", or that of a
plug-in of one's own. The kinds share the plan (:mod:`robotics.plugins.arena.plan`), the searches, the resuming
(:mod:`robotics.plugins.arena.holding`) and the command.
"""

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any, NamedTuple

from fuzzy.entrypoints import entry_points
from fuzzy.naming import check_known
from robotics.plugins.arena.plan import ArenaError, ArenaPlan
from robotics.tables.files import TomlFiles
from robotics.tables.text import parse_table, reading

ARENA_GROUP = "fuzzyfleet.arenas"  # entry points: kinds of arenas, each an ArenaKind
_USUAL = "tracking"
_FILES = TomlFiles("arenas", "arena", ArenaError)


class ArenaKind(NamedTuple):
    """A kind of arenas.

    Attributes:
        read: Makes a plan of a file's table, its name and its folder; its InputErrors are about the keys of what is
            wrong.
        run: Holds a plan in a folder, and writes its page: (plan, folder, workers=, fresh=, begin=, announce=,
            command=), which returns the outcome.
        answer: The sentences that answer it, of an outcome.
        show: The table that the command prints, of an outcome.
        tell: What the command tells as JSON beside the answer, of an outcome.
        page: The name of the page's file.
        preload: The modules that workers import.
    """

    read: Callable[[Mapping[str, Any], str, Path], ArenaPlan]
    run: Callable[..., Any]
    answer: Callable[[Any], list[str]]
    show: Callable[[Any], str]
    tell: Callable[[Any], dict[str, Any]]
    page: str
    preload: tuple[str, ...]


def arena_kind(name: str) -> ArenaKind:
    """A kind by its name. Raises ArenaError."""
    kinds = {point.name: point for point in entry_points(group=ARENA_GROUP)}
    check_known(name, kinds, "kind of arena", ArenaError, "kind")
    kind: ArenaKind = kinds[name].load()
    return kind


def arena_names() -> list[str]:
    """The names of the arenas that come with the package."""
    return _FILES.names()


def load_plan(name: str | Path = "default") -> ArenaPlan:
    """Read an arena of any kind: the name of one that comes with the package, or a ``.toml`` file.

    Raises ArenaError: no such arena, or a file that makes none; the message names file, line and key.
    """
    found = _FILES.find(name)
    return parse_plan(found.text, found.name, found.file, found.folder)


def parse_plan(text: str, name: str = "arena", file: str = "<text>", folder: Path = Path()) -> ArenaPlan:
    """Read the arena of any kind that a TOML text describes. Raises ArenaError.

    A key ``like`` names a packaged arena, whose keys count where the text has none.

    Args:
        text: The TOML text.
        name: The arena's name.
        file: The file's name in messages.
        folder: The folder to which paths in it are relative.
    """
    with reading(text, file, ArenaError) as table:
        return plan_from_table(table, name, folder)


def plan_from_table(table: Mapping[str, Any], name: str, folder: Path) -> ArenaPlan:
    """Make the arena of a file's table. Raises an InputError whose ``at`` holds the keys that it is about."""
    whole = _alike(dict(table))
    return arena_kind(whole.pop("kind", _USUAL)).read(whole, name, folder)


def _alike(table: dict[str, Any]) -> dict[str, Any]:
    """The table with the keys of the packaged arena that it is ``like``, where it gives none itself."""
    like = table.pop("like", None)
    if like is None:
        return table
    check_known(like, arena_names(), "arena", ArenaError, "like", where="like")
    return {**_alike(parse_table(_FILES.find(like).text, f"{like}.toml", ArenaError)), **table}
