"""Tables of numbers in text files: the one reader of all commands and of the designer, and the writer.

    table = read_table("plant.csv", columns=["Coolant temp", "Oil pressure"])
    table.names, table.units, table.values

A table is a row a line, with or without a header of titles "name [unit]" (:mod:`fuzzy.files.header`). Commas,
semicolons or tabs separate the columns, and the first line shows which. Numbers have a decimal point or a decimal comma
(:mod:`fuzzy.files.decimals`). The text is UTF-8, or UTF-16 with a byte order mark; blank lines are skipped. Only
columns that are asked for need to hold numbers.
"""

import csv
import io
import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from fuzzy.errors import quoted
from fuzzy.files.atomic import replacing, write_whole
from fuzzy.files.decimals import Marks, Numbers, is_number, numbers_of, sure_marks, why_no_number
from fuzzy.files.header import DataError as DataError
from fuzzy.files.header import HeaderColumn as HeaderColumn
from fuzzy.files.header import columns_of, numbered, place_of
from fuzzy.files.header import titled as titled
from fuzzy.naming import file_beside
from fuzzy.words import listed

_LARGEST = 1_000_000_000  # bytes of a file
LONGEST_LINE = 1_000_000  # characters
_MOST_COLUMNS = 10_000
MOST_FIELDS = 20_000_000  # rows times columns
_MOST_CATEGORIES = 50  # of a column of texts
_LISTED = 5  # lines and columns that a message names


class BadRowsError(DataError):
    """The error for rows without a number in a column that is used; who reads may leave such rows out."""

    texts: tuple[str, ...] = ()  # the columns in which no row has a number


@dataclass(frozen=True, eq=False)
class Table:
    """Columns of numbers as they were read from a file."""

    file: str
    names: tuple[str, ...]  # of the columns that were asked for; without a header column1, column2, ... by their place
    units: tuple[str, ...]  # "" where the header says none
    values: np.ndarray  # (rows, columns) float64, all finite
    lines: np.ndarray  # (rows,) int: the line of the file, from 1, at which each row begins
    skipped: tuple[int, ...] = ()  # the lines of rows that were left out, as one of the columns has no number there
    headed: bool = True  # is there a header?

    @property
    def omission(self) -> str:
        """What was left out, as a sentence; empty where nothing was."""
        if not self.skipped:
            return ""
        count, rows = len(self.skipped), len(self.skipped) + len(self.values)
        verb = "was" if count == 1 else "were"
        return f"{self.file}: {count} of {rows} rows {verb} left out, {on_lines(self.skipped)}"


class AllColumns(NamedTuple):
    """Every column of a table, whatever it holds."""

    values: np.ndarray  # (rows, columns): not-a-number where there is none
    lines: np.ndarray  # (rows,) int: at which each row begins
    doubts: tuple[str, ...]  # a column: why its numbers cannot be told, as :class:`fuzzy.files.decimals.Numbers` says


class _Rows(NamedTuple):
    """The texts of some columns."""

    texts: list[list[str]]  # a column each
    lines: list[int]
    ragged: dict[int, int]  # of rows with too many or too few fields: how many


class ColumnCode(NamedTuple):
    """How a column of texts became columns of 0 and 1."""

    name: str  # of the column
    place: int
    categories: tuple[str, ...]  # its texts, a column each

    @property
    def names(self) -> list[str]:
        """The names of the columns: "colour=red"."""
        return [f"{self.name}={category}" for category in self.categories]

    def coded(self, row: list[str]) -> list[str]:
        """A row with 0 and 1 in the place of the text; with empty fields in that of an empty one."""
        text = row[self.place].strip()
        fields = [str(int(text == category)) if text else "" for category in self.categories]
        return [*row[: self.place], *fields, *row[self.place + 1 :]]


@dataclass(frozen=True, eq=False)
class TableText:
    """A table whose header is known and whose numbers are still text: choose columns, then read :meth:`numbers`."""

    file: str  # what messages call it
    columns: tuple[HeaderColumn, ...]
    headed: bool  # is there a header?
    separator: str
    _text: str
    _begin: int  # the line before the first one
    codes: tuple[ColumnCode, ...] = ()  # columns of texts that were replaced, one after the other

    def place(self, wanted: str, unit: str = "") -> int:
        """The place (from 0) of a column by its title, name or number; raises DataError, which names the file."""
        try:
            return place_of(self.columns, wanted, unit)
        except DataError as error:
            raise DataError(f"{self.file}: {error}") from None

    def places(self, wanted: str) -> list[int]:
        """The place of a column, or those of the columns that it became by :meth:`coded`. Raises DataError."""
        names = next((code.names for code in self.codes if code.name == wanted), [wanted])
        return [self.place(name) for name in names]

    def coded(self, wanted: str, categories: Sequence[str] | None = None) -> "TableText":
        """The same table with a column of texts as columns of 0 and 1, one a category, "colour=red" (one-hot).

        Args:
            wanted: The column.
            categories: Its texts; by default those that are there, in alphabetical order.

        Raises:
            DataError: A text that is none of the categories, and a column of no or of too many texts.
        """
        place = self.place(wanted)
        called, there = self._called(place), sorted({text.strip() for text in self._fields([place]).texts[0]} - {""})
        if not there or len(there) > _MOST_CATEGORIES:
            what = f"has {len(there)} different texts" if there else "is empty"
            raise DataError(f"{self.file}: {called} {what}; a column that is coded has 1 to {_MOST_CATEGORIES}")
        unseen = [quoted(text) for text in there if categories is not None and text not in categories]
        if unseen:
            more = " and others" if len(unseen) > _LISTED else ""
            known = ", ".join(categories or ())
            raise DataError(f"{self.file}: {called} holds {listed(unseen[:_LISTED])}{more}, which is none of {known}")
        code = ColumnCode(self.columns[place].name, place, tuple(there if categories is None else categories))
        new = [HeaderColumn(name, "", name) for name in code.names]
        columns = (*self.columns[:place], *new, *self.columns[place + 1 :])
        return replace(self, columns=columns, codes=(*self.codes, code))

    def numbers(self, columns: Sequence[str | int] | None = None, skip_bad: bool = False) -> Table:
        """Read the numbers in ``columns`` (titles, names or places from 0), by default in all.

        With ``skip_bad`` rows that have no number in one of them are left out. Raises DataError; BadRowsError, a
        DataError, for such rows without it.
        """
        if columns is None:
            places = list(range(len(self.columns)))
        else:
            places = [column if isinstance(column, int) else self.place(column) for column in columns]
        self._check_names(places)
        found = self._fields(places)
        if not found.lines:
            header = quoted(self.separator.join(column.title for column in self.columns))
            raise DataError(f"{self.file}: no row of numbers follows the header {header}")
        values = np.empty((len(found.lines), len(places)))
        for k, (place, texts) in enumerate(zip(places, found.texts, strict=True)):
            values[:, k], doubt = self._numbers_of(texts)
            if doubt:
                raise DataError(f"{self.file}: {self._called(place)} {doubt}")
        bad = np.flatnonzero(np.isnan(values).any(axis=1))
        lines = np.array(found.lines)
        if len(bad) and (not skip_bad or len(bad) == len(lines)):
            error = BadRowsError(self._bad_rows(places, found, values, bad) + (": none is left" if skip_bad else ""))
            lacking = np.flatnonzero(np.isnan(values).all(axis=0)).tolist()
            error.texts = tuple(self.columns[places[k]].name for k in lacking if any(found.texts[k]))
            raise error
        names = tuple(self.columns[place].name for place in places)
        units = tuple(self.columns[place].unit for place in places)
        skipped = tuple(lines[bad].tolist())
        if skipped:
            values, lines = np.delete(values, bad, axis=0), np.delete(lines, bad)
        return Table(self.file, names, units, values, lines, skipped, self.headed)

    def all_columns(self) -> AllColumns:
        """Read every column, with what is no number as not-a-number. Raises DataError for what is no table."""
        found = self._fields(range(len(self.columns)))
        read = [self._numbers_of(texts) for texts in found.texts]
        values = np.column_stack([column.values for column in read])
        return AllColumns(values, np.array(found.lines, dtype=int), tuple(column.doubt for column in read))

    def _numbers_of(self, texts: list[str]) -> Numbers:
        return numbers_of(texts, lambda: self._marks, self.separator == ";")

    def _check_names(self, places: Sequence[int]) -> None:
        """Refuse columns without a title, twice the same, and two with one name."""
        known: dict[str, int] = {}
        for place in places:
            name, _, title = self.columns[place]
            if not title:
                raise DataError(
                    f"{self.file}: the header leaves column {place + 1} without a name; give it one, or choose columns"
                )
            if known.get(name) == place:
                raise DataError(f"{self.file}: column {quoted(name)} is named twice")
            if name in known:
                raise DataError(
                    f"{self.file}: columns {known[name] + 1} and {place + 1} are both called {quoted(name)}; give each "
                    "a name of its own in the header, or choose columns"
                )
            known[name] = place

    @cached_property
    def _marks(self) -> Marks:
        """The decimal marks of the whole table."""
        comma = point = False
        for _, row in self._rows():
            for field in row:
                if "," in field or "." in field:
                    sure = sure_marks(field)
                    comma, point = comma or sure.comma, point or sure.point
            if comma and point:
                break
        return Marks(comma, point)

    def _rows(self) -> Iterator[tuple[int, list[str]]]:
        """The rows below the header that are not blank, each with its first line."""
        rows = _rows(self._text, self.separator, self.file, self._begin)
        if self.headed:
            next(rows)
        return ((line, self._coded(row)) for line, row in rows) if self.codes else rows

    def _coded(self, row: list[str]) -> list[str]:
        count = len(self.columns) - sum(len(code.categories) - 1 for code in self.codes)
        if len(row) != count:
            return []  # it is ragged, also where it has as many fields as there are columns now
        for code in self.codes:
            row = code.coded(row)
        return row

    def _fields(self, places: Sequence[int]) -> _Rows:
        count = len(self.columns)
        texts: list[list[str]] = [[] for _ in places]
        lines: list[int] = []
        ragged: dict[int, int] = {}
        most = max(1, MOST_FIELDS // count)
        chosen = list(zip(places, texts, strict=True))
        for line, row in self._rows():
            if len(lines) == most:
                raise DataError(
                    f"{self.file}: more than {most} rows of {count} columns; a table has at most {MOST_FIELDS} fields"
                )
            if len(row) != count:
                ragged[len(lines)] = len(row)
                row = [""] * count
            for place, column in chosen:
                column.append(row[place])
            lines.append(line)
        return _Rows(texts, lines, ragged)

    def _called(self, place: int) -> str:
        return quoted(self.columns[place].name) if self.headed else f"column {place + 1}"

    def _bad_rows(self, places: Sequence[int], found: _Rows, values: np.ndarray, bad: np.ndarray) -> str:
        """Say which rows have no number where, and what the first of them holds."""
        lines = [found.lines[row] for row in bad]
        verb = "has" if len(bad) == 1 else "have"
        first = int(bad[0])
        if first in found.ragged:
            of = "header" if self.headed else "first row"
            fields = found.ragged[first]
            what, why = "other columns", f"{fields} where the {of} has {len(self.columns)}"
        else:
            lacking = np.flatnonzero(np.isnan(values[[r for r in bad.tolist() if r not in found.ragged]]).any(axis=0))
            called = [self._called(places[k]) for k in lacking.tolist()]
            what = "no number in " + ", ".join(called[:_LISTED]) + (" and others" if len(called) > _LISTED else "")
            why = why_no_number(found.texts[int(np.flatnonzero(np.isnan(values[first]))[0])][first])
        begin = ":" if len(bad) == 1 else "; the first:"
        return f"{self.file}: {len(bad)} of {len(found.lines)} rows {verb} {what} ({on_lines(lines)}{begin} {why})"


def read_table(path: str | Path, columns: Sequence[str | int] | None = None, *, skip_bad: bool = False) -> Table:
    """Read the numbers of a table in a file.

    Args:
        path: The file.
        columns: Titles, names or places (from 0) of the columns that are wanted, in that order; by default all. What
            others hold does not matter.
        skip_bad: Leave out rows that have no number in one of these columns.

    Raises DataError for a file that cannot be read, a column that is not there, and columns that do not hold finite
    numbers. It names the line and the column.
    """
    return open_table(path).numbers(columns, skip_bad)


def open_table(path: str | Path) -> TableText:
    """Read the header of the table in the file ``path``. Raises DataError."""
    try:
        with Path(path).open("rb") as file:
            data = file.read(_LARGEST + 1)
    except OSError as error:
        raise DataError(f"cannot read {path}: {error.strerror or error}{file_beside(path)}") from None
    if len(data) > _LARGEST:
        raise DataError(f"{path}: more than {_LARGEST / 1e9:g} GB, the most that is read")
    return parse_table(data, str(path))


def parse_table(text: str | bytes, file: str) -> TableText:
    """Read the header of the table in the ``text`` of a file, which messages call ``file``. Raises DataError."""
    if isinstance(text, bytes):
        text = _decoded(text, file)
    text = text.removeprefix("\ufeff")
    begin = 0
    for number, line in enumerate(io.StringIO(text, newline=""), 1):
        if "\0" in line:
            raise DataError(f"{file}, line {number}: a zero byte, so this is no text file")
        if len(line) > LONGEST_LINE:
            raise DataError(f"{file}, line {number}: more than {LONGEST_LINE} characters, the most in a line")
    told = re.match(r"sep=([,;\t])(?:\r\n|\r|\n)", text)  # Excel's own first line
    if told:
        text, begin = text[told.end() :], 1
    separator = told[1] if told else _separator(text)
    first = next(_rows(text, separator, file, begin), None)
    if first is None:
        raise DataError(f"{file}: the file is empty, expected rows of numbers")
    place, row = first
    if len(row) > _MOST_COLUMNS:
        raise DataError(f"{file}, line {place}: {len(row)} columns; a table has at most {_MOST_COLUMNS}")
    titles = [field.strip() for field in row]
    headed = not any(is_number(title) or any(sure_marks(title)) for title in titles)
    return TableText(file, columns_of(titles) if headed else numbered(len(row)), headed, separator, text, begin)


def write_table(
    path: str | Path, names: Sequence[str] | None, values: np.ndarray, units: Sequence[str] | None = None
) -> None:
    """Write ``values`` (rows, columns) with 17 significant digits, under a header if there are ``names``.

    The file appears whole or not at all. Raises DataError if it cannot be written.
    """
    text = table_text(names, values, units)
    try:
        write_whole(path, text)
    except OSError as error:
        raise DataError(f"cannot write {path}: {error.strerror or error}") from None


def write_frame(frame: Any, path: str | Path) -> None:
    """Write a pandas table of numbers or texts as CSV with every digit. The file appears whole or not at all.

    Raises OSError if it cannot be written.
    """
    with replacing(path) as temporary:
        frame.to_csv(temporary, index=False, lineterminator="\n")


def table_text(names: Sequence[str] | None, values: np.ndarray, units: Sequence[str] | None = None) -> str:
    """Format ``values`` (rows, columns) as CSV with 17 significant digits, which read back to the same float64.

    The header holds the ``names``, with ``units`` as "name [unit]"; without units the names are titles as they are.
    """
    values = np.atleast_2d(values)
    for what, given in (("names", names), ("units", units)):
        if given is not None and len(given) != values.shape[1]:
            raise DataError(f"{len(given)} {what} for {values.shape[1]} columns")
    lines = [",".join(f"{value:.17g}" for value in row) for row in values.tolist()]
    if names is not None:
        titles = names if units is None else [titled(*pair) for pair in zip(names, units, strict=True)]
        lines.insert(0, ",".join(_field(title) for title in titles))
    return "".join(line + "\n" for line in lines)


def _field(name: str) -> str:
    return '"' + name.replace('"', '""') + '"' if set(name) & set(',;\t"\r\n\ufeff') else name


def _decoded(data: bytes, file: str) -> str:
    wide = data.startswith((b"\xff\xfe", b"\xfe\xff"))
    try:
        return data.decode("utf-16" if wide else "utf-8-sig")
    except UnicodeDecodeError as error:
        where = f"byte {error.start + 1} is {data[error.start]:#04x}"
        raise DataError(
            f"{file}: not text in {'UTF-16' if wide else 'UTF-8'} ({where}); save it as UTF-8, in Excel as CSV UTF-8"
        ) from None


def _separator(text: str) -> str:
    # Up to the first line end that is not in quotes; a comma beside semicolons or tabs is a decimal comma or in a name.
    first = re.match(r'(?: *[\r\n])*((?:"[^"]*"|[^"\r\n])*)', text)
    unquoted = re.sub(r'"[^"]*"', "", first[1] if first else "")
    return next((mark for mark in (";", "\t", ",") if mark in unquoted), ",")


def _rows(text: str, separator: str, file: str, begin: int) -> Iterator[tuple[int, list[str]]]:
    """The rows that are not blank, each with the line at which it begins."""
    reader = csv.reader(io.StringIO(text, newline=""), delimiter=separator, strict=True)
    line = begin + 1
    try:
        for row in reader:
            if "".join(row).strip():
                yield line, row
            line = begin + reader.line_num + 1
    except csv.Error as error:
        raise DataError(f"{file}, line {line}: {_in_words(str(error))}") from None


def _in_words(error: str) -> str:
    if "field larger" in error:
        return f"a field of more than {csv.field_size_limit()} characters; is a quotation mark not closed?"
    if "expected after" in error:
        return 'after a closing quotation mark a field must end; a quotation mark within a field is written ""'
    return "a quotation mark is not closed"


def on_lines(lines: Sequence[int]) -> str:
    """Name ``lines`` of a file in words; of many the first."""
    more = len(lines) - _LISTED
    names = [*map(str, lines[:_LISTED]), *([f"{more} more"] if more > 0 else [])]
    return f"line{'s' * (len(lines) != 1)} {listed(names)}"
