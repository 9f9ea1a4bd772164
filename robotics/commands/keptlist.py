"""What `robotics list` told last, kept in the user's cache folder: to make it anew, every law must be imported.

It counts as long as nothing has changed on which it depends: the files of the package, Python, and what is installed.
Where other packages have laws, metrics or the like, nothing is kept, since their files are not watched.
"""

import hashlib
import os
import sys
from collections.abc import Callable, Iterator
from contextlib import suppress
from pathlib import Path

from fuzzy.entrypoints import entry_points
from fuzzy.files.atomic import write_whole

CACHE_FOLDER = "FUZZYFLEET_CACHE"  # the environment's variable that names another folder; "": nothing is kept
_PACKAGES = Path(__file__).parents[2]
_WATCHED = (".py", ".toml", ".fis")
_GROUPS = ("laws", "metrics", "rulebases", "data", "shapes")  # of entry points that change what is listed
_OWN = "fuzzyfleet"


def kept_or_made(what: str, make: Callable[[], tuple[str, bool]]) -> str:
    """A text that is kept, or that ``make`` makes.

    Args:
        what: The name of its file.
        make: Gives the text, and whether it may be kept.
    """
    folder, state = _folder(), _state()
    if folder is None or state is None:
        return make()[0]
    file = folder / what
    with suppress(OSError, ValueError):
        known, _, text = file.read_text(encoding="utf-8").partition("\n")
        if known == state:
            return text
    text, lasting = make()
    if lasting:
        with suppress(OSError):  # a home that cannot be written into
            folder.mkdir(parents=True, exist_ok=True)
            write_whole(file, f"{state}\n{text}")
    return text


def _folder() -> Path | None:
    if (named := os.environ.get(CACHE_FOLDER)) is not None:
        return Path(named) if named else None
    usual = os.environ.get("XDG_CACHE_HOME") or os.environ.get("LOCALAPPDATA")
    with suppress(RuntimeError):  # a user without a home
        return (Path(usual) if usual else Path.home() / ".cache") / _OWN
    return None


def _state() -> str | None:
    """A digest of all that the list depends on; None where other packages have a part in it."""
    points = [point for group in _GROUPS for point in entry_points(group=f"{_OWN}.{group}")]
    if any(point.dist is None or point.dist.name != _OWN for point in points):
        return None
    known = [sys.version, *_files(), *(f"{point.name}={point.value}" for point in points)]
    for place in sys.path[1:]:  # a package that is installed changes its folder
        with suppress(OSError):
            known.append(f"{place} {Path(place).stat().st_mtime_ns}")
    return hashlib.sha256("\n".join(known).encode()).hexdigest()


def _files() -> Iterator[str]:
    """The files of the three packages, each with its size and when it was changed."""
    for package in ("fuzzy", "anfis", "robotics"):
        for folder, folders, names in os.walk(_PACKAGES / package):
            folders[:] = sorted(set(folders) - {"__pycache__", "static"})
            for name in sorted(names):
                if name.endswith(_WATCHED):
                    about = Path(folder, name).stat()
                    yield f"{folder}/{name} {about.st_size} {about.st_mtime_ns}"
