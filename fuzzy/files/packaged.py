"""Rule bases by name: the .fis files that installed packages bring.

A package names its folders of .fis files by entry points of the group ``fuzzyfleet.rulebases``, in ``pyproject.toml``:

    [project.entry-points."fuzzyfleet.rulebases"]
    mine = "mypackage.rules"

The value is a folder, ``mypackage/rules``; nothing of the package is imported. The name of a file is its path in the
folder without .fis: ``tracking``, ``formation/v_l``.
"""

import os
from collections.abc import Mapping
from importlib.metadata import EntryPoint
from importlib.util import find_spec
from pathlib import Path

from fuzzy.entrypoints import entry_points
from fuzzy.errors import InputError
from fuzzy.files.fislines import LINE_END
from fuzzy.naming import expected

RULE_BASE_GROUP = "fuzzyfleet.rulebases"
_OWN = "fuzzyfleet"  # the distribution whose names come first


class FisNameError(InputError):
    """The error for a text that is neither a packaged rule base's name nor the path of a .fis file."""


def find_fis(name: str | os.PathLike[str], known: Mapping[str, Path] | None = None) -> Path:
    """The .fis file that ``name`` means: a path, or the name of a packaged rule base; a file that exists comes first.

    A path that ends in .fis is handed back even where there is no such file.

    Args:
        name: The path or the name.
        known: The files by their names, by default :func:`packaged_fis_files`.

    Raises:
        FisNameError: Any other text that is no name.
    """
    path = Path(name)
    # Not by Path's methods: these raise OSError for a text that no file can have as its name.
    folder = os.path.isdir(path)  # noqa: PTH112
    if os.path.exists(path) and not folder:  # noqa: PTH110
        return path
    known, text = packaged_fis_files() if known is None else known, path.as_posix()
    if text in known:
        return known[text]
    if path.suffix.lower() == ".fis" or folder:
        bare = text.removesuffix(".fis")
        if bare in known:
            raise FisNameError(f"there is no file {text!r}; the packaged rule base is called {bare!r}, without .fis")
        return path
    raise FisNameError(expected(text, known, "rule base") + "; or the path of a .fis file")


def packaged_fis_files() -> dict[str, Path]:
    """The .fis files of all installed packages by their names, in alphabetical order.

    Where two packages have a file of one name, the one of fuzzyfleet counts, else that of the entry point whose name
    comes first: see :func:`unusable_rule_bases` for the others.
    """
    return dict(sorted(_found()[0].items()))


def unusable_rule_bases() -> list[str]:
    """A sentence for each folder that an entry point names and that is not there, and for each name that is taken."""
    return _found()[1]


def fis_files(folder: Path) -> dict[str, Path]:
    """The .fis files in ``folder`` and in folders in it, by their paths without .fis, in alphabetical order."""
    return dict(sorted((f.relative_to(folder).with_suffix("").as_posix(), f) for f in folder.rglob("*.fis")))


def fis_title(file: Path) -> str:
    """The first line of the comment with which a .fis file begins, or "" without one. Raises OSError."""
    for line in LINE_END.split(file.read_text(encoding="utf-8-sig", errors="replace")):
        text = line.strip()
        if text.startswith("["):
            break
        if text.startswith(("%", "#", "//")) and not text.startswith("%!") and (words := text.lstrip("%#/ ")):
            return words
    return ""


def _found() -> tuple[dict[str, Path], list[str]]:
    files: dict[str, Path] = {}
    owners: dict[str, str] = {}
    problems = []
    entries = entry_points(group=RULE_BASE_GROUP)
    for entry in sorted(entries, key=lambda e: (_distribution(e) != _OWN, e.name, e.value)):
        folder, origin = folder_named(entry.value), origin_of(entry)
        if folder is None:
            problems.append(f"the rule bases {entry.name!r} of {origin} are not there: no folder {entry.value}")
            continue
        for name, file in fis_files(folder).items():
            if files.setdefault(name, file) == file:
                owners[name] = origin
            else:
                problems.append(f"the rule base {name!r} of {origin} has the name of one of {owners[name]}")
    return files, problems


def folder_named(value: str) -> Path | None:
    """The folder that a dotted name means, without importing anything; None where there is none."""
    package, *rest = value.strip().split(".")
    try:
        spec = find_spec(package)
    except (ImportError, ValueError):
        spec = None
    places = [] if spec is None else spec.submodule_search_locations or []
    return next((folder for place in places if (folder := Path(place, *rest)).is_dir()), None)


def _distribution(entry: EntryPoint) -> str:
    return entry.dist.name if entry.dist is not None else ""


def origin_of(entry: EntryPoint) -> str:
    """Whose an entry point is, in words."""
    return f"the package {entry.dist.name}" if entry.dist is not None else entry.value
