"""Files of one kind: those that come with the package, by name, and a user's own, by path."""

from collections.abc import Iterator
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

from fuzzy.entrypoints import entry_points
from fuzzy.errors import InputError
from fuzzy.files.packaged import folder_named
from fuzzy.naming import expected
from robotics.tables.text import read_text

DATA_GROUP = "fuzzyfleet.data"  # entry points that name folders like robotics/data, with scenarios/, studies/ ...
_OWN = Path(__file__).parents[1] / "data"


class TomlFile(NamedTuple):
    """The text of a file, and where it comes from."""

    text: str
    name: str  # of what it describes
    file: str  # what messages call the file
    folder: Path  # to which paths in it are relative
    path: Path


def placed_beside(path: Path, folder: Path) -> Path:
    """``path`` as seen from ``folder`` if there is a file, else as it is, from the current folder."""
    with suppress(OSError):  # a name that is too long
        return folder / path if (folder / path).is_file() else path
    return path


def names_in(folder: str) -> list[str]:
    """The names of the .toml files in a folder of the packaged data, such as ``scenarios``; also those of plug-ins."""
    return sorted({file.stem for file in _packaged(folder)})


def _packaged(folder: str) -> Iterator[Path]:
    """The .toml files in a folder of the packaged data, those of the core first."""
    yield from (_OWN / folder).glob("*.toml")
    for point in sorted(entry_points(group=DATA_GROUP), key=lambda each: each.name):
        if (place := folder_named(point.value)) is not None:
            yield from (place / folder).glob("*.toml")


@dataclass(frozen=True)
class TomlFiles:
    """The files of one kind; its errors are ``fault``."""

    folder: str  # of those that come with the package
    kind: str  # what messages call one
    fault: type[InputError]

    def names(self) -> list[str]:
        """The names of those that come with the package."""
        return names_in(self.folder)

    def find(self, name: str | Path, beside: Path = Path()) -> TomlFile:
        """Read the packaged file of that name, or the ``.toml`` file of that path.

        Args:
            name: The name, or the path.
            beside: The folder where a relative path is looked for first; then in the current one.

        Raises ``fault`` for an unknown name and a file that cannot be read.
        """
        path = next((file for file in _packaged(self.folder) if file.stem == str(name)), None)
        if path is not None:
            return TomlFile(read_text(path, self.fault), str(name), path.name, Path(), path)
        path = Path(name)
        if path.suffix != ".toml":
            raise self.fault(f"{expected(str(name), self.names(), self.kind)}; or the path of a .toml file")
        path = placed_beside(path, beside)
        return TomlFile(read_text(path, self.fault), path.stem, str(path), path.parent, path)
