"""The folder that was opened: nothing outside it is read or written."""

import os
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

from fuzzy.errors import InputError, quoted
from fuzzy.files.fisfile import FisText, MamdaniError, parse_bytes
from fuzzy.plugins.designer.autosave import FOLDER
from fuzzy.system import Sugeno

LARGEST_FILE = 2_000_000  # bytes
# What a page can show; the reader of files takes more.
_MOST_VARIABLES = 100  # inputs or outputs
_MOST_TERMS = 500  # of a variable
_MOST_RULES = 2000
_MOST_CLAUSES = 20_000  # of all rules together
_MOST_FILES = 500  # that are listed
_DEPTH = 3  # of the folders whose files are listed
_NOT_ON_WINDOWS = '<>:"|?*'
_PORTS = (f"{port}{n}" for port in ("com", "lpt") for n in range(10))
_DEVICES = {"con", "prn", "aux", "nul", "conin$", "conout$", *_PORTS}  # on Windows


class FolderError(InputError):
    """A file that is not in the opened folder, or not one that the designer works with."""


@dataclass(frozen=True)
class Folder:
    """A folder, as :func:`open_folder` gives it: absolute, without links in its path."""

    path: Path

    def inside(self, name: str, ending: str = ".fis") -> Path:
        """The path of the file ``name`` with that ``ending``, relative to the folder; the file need not exist.

        Raises FolderError for a name that leads out of the folder, also by a link, or into a hidden folder.
        """
        parts = name.split("/")
        if not name or len(name) > 300 or any(c in name for c in "\\:") or not name.isprintable():
            raise FolderError(f"{name[:80]!r} cannot be the name of a file; use letters, digits, '-', '_' and '/'")
        if any(part == "" or part.startswith(".") for part in parts):
            raise FolderError(f"{name!r}: use a file in the opened folder, without a name that begins with a dot")
        if any(part.partition(".")[0].strip().casefold() in _DEVICES for part in parts):
            raise FolderError(f"{name!r}: Windows reserves this name for a device; choose another one")
        if not name.lower().endswith(ending):
            raise FolderError(f"{name!r}: the designer works with {ending} files; end the name in {ending}")
        path = self.path.joinpath(*parts)
        try:
            real = path.resolve()
        except (OSError, RuntimeError, ValueError):
            raise FolderError(f"{name!r} cannot be opened") from None
        if not real.exists() and (any(c in name for c in _NOT_ON_WINDOWS) or any(p[-1] in " ." for p in parts)):
            raise FolderError(f"{name!r}: Windows knows no such name; use letters, digits, '-', '_' and '.'")
        if not real.is_relative_to(self.path):
            raise FolderError(f"{name!r} leads out of the opened folder")
        if real.is_dir():
            raise FolderError(f"{name!r} is a folder")
        return real

    def name(self, path: Path) -> str:
        """The name of a file of the folder, as :meth:`inside` takes it."""
        return path.relative_to(self.path).as_posix()

    def without_place(self, sentence: str) -> str:
        """A sentence that calls the folder's files by name alone: who reads it knows where they are."""
        return sentence.replace(f"{self.path}{os.sep}", "")

    def files(self, ending: str = ".fis") -> list[str]:
        """The files of the folder and of folders in it with that ``ending``, at most 500, down to the third level."""
        found = []
        for root, folders, names in os.walk(self.path):
            here = Path(root)
            depth = len(here.relative_to(self.path).parts)
            folders[:] = sorted(f for f in folders if not f.startswith(".")) if depth + 1 < _DEPTH else []
            for name in sorted(names):
                relative = self.name(here / name)
                try:
                    if (here / name).is_file() and self.inside(relative, ending):
                        found.append(relative)
                except FolderError:
                    continue
            if len(found) > _MOST_FILES:
                break
        return sorted(found[:_MOST_FILES], key=str.casefold)

    def unsaved(self, files: Iterable[str]) -> list[str]:
        """The names of designs without a file whose unsaved work is kept, in the folder or beside its ``files``."""
        folders = {Path(), *(Path(name).parent for name in files)}
        kept = {
            self.name(self.path / here / work.name.removesuffix(".json"))
            for here in folders
            for work in self.path.joinpath(here, FOLDER).glob("*.fis.json")
        }
        return sorted((name for name in kept if not self.path.joinpath(name).exists()), key=str.casefold)

    def free_name(self, stem: str = "untitled") -> str:
        """A name that no file has: untitled.fis, untitled-2.fis, ..."""
        count, name = 1, f"{stem}.fis"
        while self.path.joinpath(name).exists():
            count += 1
            name = f"{stem}-{count}.fis"
        return name

    def read(self, name: str) -> Sugeno:
        """The system in a file of the folder. Raises FolderError, FisFileError, OSError."""
        read = self.read_any(name)
        if read.changes:
            raise MamdaniError(name, None, "is a Mamdani system; open it, and save it as a Sugeno system first")
        return read.system

    def read_any(self, name: str) -> FisText:
        """What a file of the folder holds, a Mamdani system as a Sugeno system; raises as :meth:`read` does."""
        path = self.inside(name)
        if not path.is_file():
            raise FolderError(f"there is no file {name!r} in the opened folder")
        check_size(path, name)
        return read_bytes(path.read_bytes(), name)


def open_folder(path: Path) -> Folder:
    """The folder at ``path``. Raises FolderError where there is none."""
    real = path.resolve()
    if not real.is_dir():
        raise FolderError(f"there is no folder {str(path)!r}")
    return Folder(real)


def check_size(path: Path, name: str) -> None:
    """Raise FolderError for a file of more than 2 MB; there may be none."""
    if path.is_file():
        check_length(path.stat().st_size, name)


def check_length(size: int, name: str) -> None:
    """Raise FolderError for more than 2 MB."""
    if size > LARGEST_FILE:
        raise FolderError(f"{name!r} is larger than {LARGEST_FILE / 1e6:g} MB")


def read_bytes(data: bytes, name: str) -> FisText:
    """What the bytes of a .fis file called ``name`` hold, a Mamdani system as a Sugeno system.

    Raises FisFileError with the line, or FolderError for a system that is too large for a page.
    """
    read = parse_bytes(data, name, mamdani=True)
    check_shown(read.system, name)
    return read


def check_shown(fis: Sugeno, name: str) -> None:
    """Raise FolderError for a system that is too large for a page; ``name`` is its file."""
    counts = [
        (len(fis.inputs), _MOST_VARIABLES, "inputs"),
        (len(fis.outputs), _MOST_VARIABLES, "outputs"),
        *((len(v.terms), _MOST_TERMS, f"terms of {quoted(v.name)}") for v in (*fis.inputs, *fis.outputs)),
        (len(fis.rules), _MOST_RULES, "rules"),
        (sum(len(rule.when) for rule in fis.rules), _MOST_CLAUSES, "clauses in its rules"),
    ]
    for count, most, what in counts:
        if count > most:
            raise FolderError(f"{name}: {count} {what}; the designer shows at most {most}")
