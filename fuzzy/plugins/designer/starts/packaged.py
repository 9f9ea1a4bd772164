"""Shipped rule bases as starts: every .fis file that an installed package brings."""

from functools import partial
from pathlib import Path

from fuzzy.files.fisfile import read_fis
from fuzzy.files.packaged import fis_title, packaged_fis_files
from fuzzy.plugins.designer.starts.start import Start, StartError
from fuzzy.system import Sugeno

SHIPPED = "Shipped rule bases"


def packaged_starts() -> list[Start]:
    """A start for each packaged rule base, which begins with a copy of it."""
    return [
        Start(
            name,
            SHIPPED,
            name,
            (_title(file) or "A packaged rule base without a comment.").rstrip("."),
            partial(read_fis, file),
            own_name=True,
        )
        for name, file in packaged_fis_files().items()
    ]


def packaged(name: str) -> Sugeno:
    """The packaged rule base of that name. Raises StartError where it is not there."""
    files = packaged_fis_files()
    if name not in files:
        raise StartError(f"the rule base {name!r} that should come with the package is not there")
    return read_fis(files[name])


def _title(file: Path) -> str:
    try:
        return fis_title(file)
    except OSError:
        return ""
