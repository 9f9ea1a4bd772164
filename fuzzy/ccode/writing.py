"""The files of a system in C, written whole or not at all."""

from pathlib import Path
from typing import NamedTuple

from fuzzy.ccode.lookup import Lookup, lookup_of, with_lookup
from fuzzy.ccode.source import CSources, c_sources
from fuzzy.files.atomic import check_folder, replacing
from fuzzy.system import Sugeno


class CFiles(NamedTuple):
    """The files of a system in C, and in which numbers they are."""

    header: Path
    source: Path
    name: str  # the prefix of the functions
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

    Raises:
        ExportError: What C, or the type of numbers, does not have.
        OSError: Nothing can be written.
    """
    table = None if lookup is None else lookup_of(fis, lookup)
    sources = c_sources(fis, name, number) if table is None else with_lookup(fis, table, name, number)
    return _written(sources, Path(folder), number, table)


def _written(sources: CSources, folder: Path, number: str, table: Lookup | None) -> CFiles:
    check_folder(folder)
    folder.mkdir(parents=True, exist_ok=True)
    paths = folder / f"{sources.name}.h", folder / f"{sources.name}.c"
    with replacing(paths[0]) as header, replacing(paths[1]) as source:
        header.write_text(sources.header, encoding="utf-8")
        source.write_text(sources.source, encoding="utf-8")
    return CFiles(*paths, sources.name, number, table)
