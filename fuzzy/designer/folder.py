"""The folder that was opened: nothing outside it is read or written."""

import os
import warnings
from dataclasses import dataclass
from pathlib import Path

from fuzzy.errors import InputError
from fuzzy.files.fisfile import FisFileError, parse_fis
from fuzzy.system import Sugeno

LARGEST_FILE = 2_000_000  # bytes
MOST_RULES = 2000
_MOST_FILES, _DEPTH = 500, 3
_DEVICES = {"con", "prn", "aux", "nul", *(f"{port}{n}" for port in ("com", "lpt") for n in range(10))}  # on Windows


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
        if not real.is_relative_to(self.path):
            raise FolderError(f"{name!r} leads out of the opened folder")
        if real.is_dir():
            raise FolderError(f"{name!r} is a folder")
        return real

    def name(self, path: Path) -> str:
        """The name of a file of the folder, as :meth:`inside` takes it."""
        return path.relative_to(self.path).as_posix()

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

    def free_name(self, stem: str = "untitled") -> str:
        """A name that no file has: untitled.fis, untitled-2.fis, ..."""
        count, name = 1, f"{stem}.fis"
        while self.path.joinpath(name).exists():
            count += 1
            name = f"{stem}-{count}.fis"
        return name

    def read(self, name: str) -> Sugeno:
        """The system in a file of the folder. Raises FolderError, FisFileError, OSError."""
        path = self.inside(name)
        if not path.is_file():
            raise FolderError(f"there is no file {name!r} in the opened folder")
        if path.stat().st_size > LARGEST_FILE:
            raise FolderError(f"{name!r} is larger than {LARGEST_FILE / 1e6:g} MB")
        return read_bytes(path.read_bytes(), name)[0]


def open_folder(path: Path) -> Folder:
    """The folder at ``path``. Raises FolderError where there is none."""
    real = path.resolve()
    if not real.is_dir():
        raise FolderError(f"there is no folder {str(path)!r}")
    return Folder(real)


def read_bytes(data: bytes, name: str) -> tuple[Sugeno, list[str]]:
    """The system in the bytes of a .fis file called ``name``, and what the reader warned of.

    Raises FisFileError with the line, or FolderError for a system of more than 2000 rules.
    """
    if b"\0" in data:
        raise FisFileError(name, None, "is no .fis file: it holds binary data")
    try:
        text = data.decode("utf-8-sig")
    except UnicodeDecodeError:
        text = data.decode("latin-1")
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        fis = parse_fis(text, name)
    if len(fis.rules) > MOST_RULES:
        raise FolderError(f"{name}: {len(fis.rules)} rules; the designer shows at most {MOST_RULES}")
    return fis, [str(w.message) for w in caught]
