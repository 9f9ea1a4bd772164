"""The titles of a table's columns: a name and a unit each, "speed [m/s]" or "speed (m/s)", and how one is asked for."""

from collections import Counter
from collections.abc import Sequence
from difflib import get_close_matches
from typing import NamedTuple

from fuzzy.errors import InputError, quoted
from fuzzy.files.decimals import is_number
from fuzzy.naming import expected

_LISTED = 30  # names that a message lists
_SAME = 5  # titles that have one name
_BRACKETS = {"]": "[", ")": "("}


class DataError(InputError):
    """The error for a file that holds no table of finite numbers, with the file, the line, the column and the text."""


class HeaderColumn(NamedTuple):
    """What the header says of a column."""

    name: str
    unit: str
    title: str  # as it stands in the file; empty where a header leaves the column without one


def titled(name: str, unit: str) -> str:
    """The title of a column, which :func:`columns_of` takes apart into the same ``name`` and ``unit``.

    A unit whose brackets do not pair, as in "m]", is left out.

    >>> titled("speed", "m/s"), titled("speed", ""), titled("speed (left)", "")
    ('speed [m/s]', 'speed', 'speed (left) []')
    """
    title = f"{name} [{unit}]"
    if unit and _parted(title) == (name, unit):
        return title
    return f"{name} []" if _parted(name) != (name, "") or is_number(name) else name


def columns_of(titles: Sequence[str]) -> tuple[HeaderColumn, ...]:
    """The columns that a header's ``titles`` describe.

    What stands in brackets at the end is the unit. So are parentheses after a blank, but where two columns would then
    have one name they are a part of it: "speed (left)", "speed (right)". A column without a title is column1, column2,
    ... by its place.
    """
    parted = [_parted(title) for title in titles]
    names = Counter(name for name, _ in parted)
    columns = []
    for place, (title, (name, unit)) in enumerate(zip(titles, parted, strict=True), 1):
        if title.endswith(")") and names[name] > 1:
            name, unit = title, ""
        columns.append(HeaderColumn(name or f"column{place}", unit, title))
    return tuple(columns)


def numbered(count: int) -> tuple[HeaderColumn, ...]:
    """The columns of a table of ``count`` columns without a header: column1, column2, ..."""
    return tuple(HeaderColumn(f"column{place}", "", f"column{place}") for place in range(1, count + 1))


def labels(columns: Sequence[HeaderColumn]) -> tuple[str, ...]:
    """A label of each column, all different: its name, where others have that too its title, or also its place."""
    names, titles = Counter(c.name for c in columns), Counter(c.title for c in columns)
    found = []
    for place, (name, _, title) in enumerate(columns, 1):
        alone = name if names[name] == 1 else title if titles[title] == 1 else f"{title or name} (column {place})"
        found.append(alone)
    return tuple(found)


def place_of(columns: Sequence[HeaderColumn], wanted: str, unit: str = "") -> int:
    """The place (from 0) of the column that is called ``wanted``: its title, its name or its number from 1.

    Where several have the name, that with the ``unit`` is taken. Raises DataError for a column that is not there, and
    for a name that several have.
    """
    if not wanted:
        raise DataError(expected(wanted, _near(wanted, columns), "column"))
    full = (wanted, f"{wanted} [{unit}]", f"{wanted} ({unit})") if unit else (wanted,)
    for title in full:
        found = [place for place, column in enumerate(columns) if column.title == title]
        if len(found) == 1:
            return found[0]
        if found:
            raise DataError(
                f"{len(found)} columns are titled {quoted(title)}, the first two in the places "
                f"{found[0] + 1} and {found[1] + 1}: give each a title of its own"
            )
    found = [place for place, column in enumerate(columns) if column.name == wanted]
    if len(found) == 1:
        return found[0]
    if found:
        same = ", ".join(quoted(columns[place].title) for place in found[:_SAME]) + (
            " ..." if len(found) > _SAME else ""
        )
        raise DataError(f"{len(found)} columns are called {quoted(wanted)}: {same}; say which by its whole title")
    if wanted.isascii() and wanted.isdecimal() and len(wanted) < 10 and 1 <= int(wanted) <= len(columns):
        return int(wanted) - 1
    raise DataError(expected(wanted, _near(wanted, columns), "column"))


def _near(wanted: str, columns: Sequence[HeaderColumn]) -> list[str]:
    """The names to list where ``wanted`` is none of them: all, or of many the nearest and the first."""
    names = [label[:100] for label in labels(columns)]
    if len(names) <= _LISTED:
        return names
    close = get_close_matches(wanted[:100], names, n=3, cutoff=0.5)
    return [*close, *[name for name in names if name not in close][:_LISTED], f"... ({len(names)} columns)"]


def _parted(title: str) -> tuple[str, str]:
    """The name and the unit in a ``title``; the unit's brackets are balanced."""
    opening = _BRACKETS.get(title[-1:])
    if opening is None:
        return title, ""
    depth = 0
    for place in range(len(title) - 1, -1, -1):
        depth += (title[place] == title[-1]) - (title[place] == opening)
        if depth == 0:
            break
    else:
        return title, ""
    name, unit = title[:place].rstrip(), title[place + 1 : -1].strip()
    if not name or (opening == "(" and (not unit or name == title[:place])):
        return title, ""
    return name, unit
