"""The files of a system in C, written whole or not at all."""

from collections.abc import Mapping
from io import BytesIO
from pathlib import Path
from typing import NamedTuple
from zipfile import ZIP_DEFLATED, ZipFile, ZipInfo

from fuzzy.files.atomic import write_together
from fuzzy.plugins.ccode.lookup import Lookup, lookup_of, with_lookup
from fuzzy.plugins.ccode.source import CSources, c_sources
from fuzzy.system import Sugeno


class CFiles(NamedTuple):
    """The files of a system in C, and in which numbers they are.

    Attributes:
        header: The header (.h).
        source: The source (.c).
        name: The prefix of the functions.
        number: "double", "float" or "q16.16".
        lookup: The table that stands in place of the rules; None: the rules themselves are written.
    """

    header: Path
    source: Path
    name: str
    number: str
    lookup: Lookup | None


def write_c(
    fis: Sugeno,
    folder: str | Path,
    number: str = "double",
    *,
    name: str = "",
    lookup: tuple[int, ...] | None = None,
) -> CFiles:
    """Write a system as one header and one source of C99, that allocate nothing and need only math.h.

    Args:
        fis: The system; also one that ANFIS has learnt.
        folder: Where to write, made if it is not there.
        number: "double", "float", or "q16.16", fixed point without floating point at run time.
        name: The files' name and the functions' prefix; by default the system's.
        lookup: For one or two inputs, the points of a table that is written in place of the rules, such as (33, 33);
            between them the function is interpolated.

    Returns:
        The files that were written.

    Raises:
        ExportError: What C, or the type of numbers, does not have.
        OSError: Nothing can be written.
    """
    sources, table = _sources(fis, name, number, lookup)
    header, source = write_together(folder, sources.texts)
    return CFiles(header, source, sources.name, number, table)


def c_zip(fis: Sugeno, name: str, number: str, points: int | None) -> bytes:
    """A system in C as a zip of both files, with the same bytes each time. Raises ExportError as :func:`write_c`.

    Args:
        fis: The system.
        name: The files' name and the functions' prefix.
        number: The type of numbers.
        points: Those of a table along each input, or none for the rules.
    """
    sources, _ = _sources(fis, name, number, None if points is None else (points,))
    return zipped(sources.texts)


def zipped(texts: Mapping[str, str]) -> bytes:
    """Texts by their files' names as a zip, with the same bytes each time."""
    packed = BytesIO()
    with ZipFile(packed, "w", ZIP_DEFLATED) as archive:
        for name, text in texts.items():
            archive.writestr(ZipInfo(name, (1980, 1, 1, 0, 0, 0)), text)
    return packed.getvalue()


def _sources(fis: Sugeno, name: str, number: str, lookup: tuple[int, ...] | None) -> tuple[CSources, Lookup | None]:
    if lookup is None:
        return c_sources(fis, name, number), None
    table = lookup_of(fis, lookup)
    return with_lookup(fis, table, name, number), table
