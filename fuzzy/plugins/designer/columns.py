"""Tables of samples as the page's panels choose from them: columns by name, whatever they hold."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from fuzzy.errors import quoted
from fuzzy.files.header import labels
from fuzzy.files.table import DataError, on_lines, parse_table


class LoadedTable(NamedTuple):
    """A table of samples with named columns."""

    name: str  # of the file or the generator
    names: tuple[str, ...]  # what the columns are called when they are chosen; all different
    values: np.ndarray  # (samples, columns); not-a-number where a file has none
    inputs: int = 0  # how many of the first columns are inputs; 0: not known
    units: tuple[str, ...] = ()  # of the columns; (): not known
    variables: tuple[str, ...] = ()  # what variables made of the columns are called; (): as the columns
    lines: np.ndarray | None = None  # (samples,) int: the line of the file at which each begins
    doubts: tuple[str, ...] = ()  # why a column's numbers cannot be told, as the end of a sentence; (): they can
    untitled: tuple[str, ...] = ()  # columns that the file's header leaves without a name

    def unit(self, name: str) -> str:
        """The unit of the column ``name``; empty where it is not known."""
        return self.units[self.names.index(name)] if self.units else ""

    @property
    def begins(self) -> np.ndarray:
        """(samples,) int: the line of the file at which each begins, or without a file its number from 1."""
        return np.arange(1, len(self.values) + 1) if self.lines is None else self.lines

    @property
    def usable(self) -> list[str]:
        """The columns that have a name and numbers."""
        some = np.isfinite(self.values).any(axis=0).tolist()
        return [n for n, numbers in zip(self.names, some, strict=True) if numbers and n not in self.untitled]

    def lacking(self, chosen: Sequence[str]) -> np.ndarray:
        """(samples,) bool: which samples have no number in one of the ``chosen`` columns.

        Raises DataError for a column that holds none at all.
        """
        some = np.isfinite(self.values)
        places = [self.names.index(name) for name in chosen]
        for place in places:
            if self.doubts and self.doubts[place]:
                raise DataError(f"{self.name}: {quoted(self.names[place])} {self.doubts[place]}")
            if not some[:, place].any():
                raise DataError(f"{self.name}: {quoted(self.names[place])} holds no numbers")
        return ~some[:, places].all(axis=1)

    def lack(self, chosen: Sequence[str]) -> str:
        """Say which samples have no number in which of the ``chosen`` columns; empty where all have one."""
        rows = np.flatnonzero(self.lacking(chosen))
        if not len(rows):
            return ""
        of = [quoted(name) for name in chosen if not np.isfinite(self.values[rows, self.names.index(name)]).all()]
        lines, verb = self.begins[rows].tolist(), "has" if len(rows) == 1 else "have"
        return f"{len(rows)} of {len(self.values)} rows {verb} no number in {', '.join(of[:5])} ({on_lines(lines)})"


def read_columns(name: str, text: str | bytes) -> LoadedTable:
    """Read the table in the ``text`` of a file called ``name``, with whatever its columns hold.

    Raises DataError where it is no table.
    """
    table = parse_table(text, name)
    read = table.all_columns()
    if not len(read.values):
        raise DataError(f"{name}: no row of numbers follows the header")
    called = labels(table.columns)
    return LoadedTable(
        name,
        called,
        read.values,
        units=tuple(c.unit for c in table.columns),
        variables=tuple(c.name for c in table.columns),
        lines=read.lines,
        doubts=read.doubts,
        untitled=tuple(label for label, c in zip(called, table.columns, strict=True) if not c.title),
    )


def read_file(path: Path, most: int, larger: str) -> LoadedTable:
    """Read the table in a file of at most ``most`` bytes; ``larger`` ends the sentence about a larger one.

    Raises DataError.
    """
    try:
        if not path.is_file():
            raise DataError(f"there is no file {quoted(path.name)} in the opened folder")
        if path.stat().st_size > most:
            raise DataError(f"{path.name} is larger than {most / 1e6:g} MB; {larger}")
        data = path.read_bytes()
    except OSError as error:
        raise DataError(f"cannot read {path.name}: {error.strerror or error}") from None
    return read_columns(path.name, data)


def matching(data: LoadedTable, variables: Sequence[str]) -> dict[str, str]:
    """The column of each of the ``variables`` that has one of its name, with or without the unit, in any case.

    It is the one in its place if no name fits and there are as many columns with numbers as variables.
    """
    folded: dict[str, str] = {}
    for k, name in enumerate(data.names):
        unit = f" [{data.units[k]}]" if data.units and data.units[k] else ""
        for known in (name, f"{name}{unit}", *data.variables[k : k + 1]):
            folded.setdefault(known.casefold(), name)
    found = {name: folded[name.casefold()] for name in variables if name.casefold() in folded}
    usable = data.usable
    if not found and len(variables) == len(usable):
        return dict(zip(variables, usable, strict=True))
    return found


def columns_data(data: LoadedTable) -> dict[str, Any]:
    """A table as the page lists it: its name, the number of rows, and each column with its unit and range."""
    columns = []
    for name, values in zip(data.names, data.values.T, strict=True):
        numbers = values[np.isfinite(values)]
        low, high = (float(numbers.min()), float(numbers.max())) if len(numbers) else (None, None)
        columns.append({"name": name, "unit": data.unit(name), "low": low, "high": high})
    return {"name": data.name, "rows": len(data.values), "columns": columns}
