"""Tables of numbers in CSV files, with an optional header."""

import csv
import math
import re
from collections.abc import Sequence
from pathlib import Path
from typing import Any, NoReturn

import numpy as np

from fuzzy.errors import InputError
from fuzzy.files.atomic import replacing

_SEPARATORS = {",": "commas", ";": "semicolons", "\t": "tabs"}


class DataError(InputError):
    """The error for a file that holds no table of finite numbers, with the file, the line, the column and the text."""


def read_table(path: str | Path) -> tuple[tuple[str, ...] | None, np.ndarray]:
    """Read the column names (None without a header) and the numbers (rows, columns), float64.

    The first line is a header if none of its fields is a number. Commas, semicolons or tabs separate the columns, and
    the first line shows which. The decimal sign is a point. Blank lines are skipped.

    Raises DataError for a file that is no table of finite numbers or cannot be read.
    """
    path = Path(path)
    lines = _lines(path)
    separator = _separator(lines)
    rows: list[list[str]] = []
    numbers: list[int] = []  # each row's line, from 1
    reader = csv.reader(lines, delimiter=separator, strict=True)
    try:
        for row in reader:
            if any(field.strip() for field in row):
                rows.append([field.strip() for field in row])
                numbers.append(reader.line_num)
    except csv.Error as error:
        raise DataError(f"{path}, line {reader.line_num}: {error}") from None
    if not rows:
        raise DataError(f"{path}: the file is empty, expected rows of numbers")
    names = None
    if not any(_is_number(field) for field in rows[0]):
        names = _header(path, numbers[0], rows[0])
        rows, numbers = rows[1:], numbers[1:]
        if not rows:
            raise DataError(f"{path}: no row of numbers follows the header {separator.join(names)!r}")
    columns = len(names or rows[0])
    for row, number in zip(rows, numbers, strict=True):
        if len(row) != columns:
            first = "header" if names else "first row"
            raise DataError(
                f"{path}, line {number}: {len(row)} columns where the {first} has {columns}: {separator.join(row)!r}"
            )
    try:
        values = np.array([[float(field) for field in row] for row in rows])
    except ValueError:
        _complain(path, numbers, rows, names, separator)
    # float reads 1_000, by which a table means something else.
    if not np.isfinite(values).all() or any("_" in field for row in rows for field in row):
        _complain(path, numbers, rows, names, separator)
    return names, values


def write_table(path: str | Path, names: Sequence[str] | None, values: np.ndarray) -> None:
    """Write ``values`` (rows, columns) with 17 significant digits, under a header if there are ``names``.

    The file appears whole or not at all. Raises DataError if it cannot be written.
    """
    text = table_text(names, values)
    try:
        with replacing(path) as target:
            target.write_text(text, encoding="utf-8", newline="")
    except OSError as error:
        raise DataError(f"cannot write {path}: {error.strerror or error}") from None


def write_frame(frame: Any, path: str | Path) -> None:
    """Write a pandas table of numbers or texts as CSV with every digit. The file appears whole or not at all.

    Raises OSError if it cannot be written.
    """
    with replacing(path) as temporary:
        frame.to_csv(temporary, index=False, lineterminator="\n")


def table_text(names: Sequence[str] | None, values: np.ndarray) -> str:
    """Format ``values`` (rows, columns) as CSV with 17 significant digits, which read back to the same float64."""
    values = np.atleast_2d(values)
    if names is not None and len(names) != values.shape[1]:
        raise DataError(f"{len(names)} names for {values.shape[1]} columns")
    lines = [",".join(f"{value:.17g}" for value in row) for row in values.tolist()]
    if names is not None:
        lines.insert(0, ",".join(_field(name) for name in names))
    return "".join(line + "\n" for line in lines)


def _field(name: str) -> str:
    return '"' + name.replace('"', '""') + '"' if set(name) & set(',;\t"\r\n') else name


def _lines(path: Path) -> list[str]:
    try:
        with path.open(encoding="utf-8-sig", newline="") as file:
            lines = file.readlines()
    except UnicodeDecodeError as error:
        raise DataError(
            f"{path}: not text in UTF-8 (byte {error.start + 1} is {error.object[error.start]:#04x})"
        ) from None
    except OSError as error:
        raise DataError(f"cannot read {path}: {error.strerror or error}") from None
    for number, line in enumerate(lines, 1):
        if "\0" in line:
            raise DataError(f"{path}, line {number}: a zero byte, so this is no text file")
    return lines


def _separator(lines: Sequence[str]) -> str:
    first = next((line for line in lines if line.strip()), "")
    unquoted = re.sub(r'"[^"]*"', "", first).strip()
    # A comma beside semicolons or tabs is a decimal comma, or stands in a name.
    return next((mark for mark in (";", "\t", ",") if mark in unquoted), ",")


def _is_number(text: str) -> bool:
    try:
        float(text)
    except ValueError:
        return False
    return "_" not in text


def _header(path: Path, line: int, names: Sequence[str]) -> tuple[str, ...]:
    for place, name in enumerate(names, 1):
        if not name:
            raise DataError(f"{path}, line {line}, column {place}: the header leaves this column without a name")
        if name in names[: place - 1]:
            raise DataError(f"{path}, line {line}, column {place}: a second column is named {name!r}")
    return tuple(names)


def _complain(
    path: Path, numbers: Sequence[int], rows: Sequence[Sequence[str]], names: Sequence[str] | None, separator: str
) -> NoReturn:
    """Raise DataError for the first field that is no finite number."""
    for number, row in zip(numbers, rows, strict=True):
        for place, field in enumerate(row, 1):
            if _is_number(field) and math.isfinite(float(field)):
                continue
            name = f" ({names[place - 1]})" if names else ""
            where = f"{path}, line {number}, column {place}{name}"
            if not field:
                raise DataError(f"{where}: the field is empty, expected a number")
            hint = ""
            if _is_number(field):
                hint = " finite"
            elif separator != "," and _is_number(field.replace(",", ".", 1)):
                raise DataError(f"{where}: {field!r} has a decimal comma; write {field.replace(',', '.', 1)!r}")
            elif len(row) == 1 and all(map(_is_number, field.split())):
                raise DataError(
                    f"{where}: {field!r} holds several numbers; separate the columns with "
                    + ", ".join(_SEPARATORS.values())
                )
            raise DataError(f"{where}: expected a{hint} number, got {field!r}")
    raise AssertionError("every field is a finite number")
