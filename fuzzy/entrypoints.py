"""Entry points of installed packages, by which plug-ins are found; looked up once."""

import sys
from functools import lru_cache
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from importlib.metadata import EntryPoints


def entry_points(group: str, name: str | None = None) -> "EntryPoints":
    """The entry points of a group, or those of one name in it, as ``importlib.metadata`` finds them.

    It opens the description of every installed package each time, which takes longer than a law is made in. Here these
    are opened again only where ``sys.path`` or a folder of it has changed since.
    """
    return _found(group, name, tuple(_state(place) for place in sys.path))


def _state(place: str) -> tuple[str, int, int]:
    try:
        about = Path(place).stat()
    except OSError:
        return place, 0, 0
    return place, about.st_ino, about.st_mtime_ns


@lru_cache(maxsize=256)
def _found(group: str, name: str | None, _: tuple[tuple[str, int, int], ...]) -> "EntryPoints":
    from importlib import metadata  # for which most commands need not wait

    found = metadata.entry_points(group=group)
    return found if name is None else found.select(name=name)
