"""Which columns of a table are inputs and which outputs, by titles, names or numbers with commas between them."""

from typing import TYPE_CHECKING, NamedTuple

from fuzzy.errors import InputError, quoted
from fuzzy.files.header import DataError

if TYPE_CHECKING:
    from fuzzy.files.table import Table, TableText


class ColumnChoice(NamedTuple):
    """Which columns are inputs and which are outputs: their places."""

    inputs: list[int]
    outputs: list[int]


def names_of(table: "Table", inputs: int) -> dict[str, list[str]]:
    """Names and units of a table's columns, the first ``inputs`` of which are inputs, as identification takes them."""
    of, to = slice(None, inputs), slice(inputs, None)
    return {
        "input_names": list(table.names[of]),
        "output_names": list(table.names[to]),
        "input_units": list(table.units[of]),
        "output_units": list(table.units[to]),
    }


def chosen_columns(text: "TableText", inputs: str | None, outputs: str | None) -> ColumnChoice:
    """The columns that ``inputs`` and ``outputs`` name, by titles, names or numbers with commas between them.

    By default the last column is the output, and all that are no outputs are the inputs. Raises InputError.
    """
    count = len(text.columns)
    if count < 2:
        raise InputError(f"{text.file}: one column; inputs and outputs need at least two")
    of = None if inputs is None else _places(text, inputs)
    to = [count - 1] if outputs is None else _places(text, outputs)
    both = [place for place in of or () if place in to]
    if both and outputs is None:
        raise InputError(f"{text.file}: the last column is among the inputs: say which are the outputs")
    if both:
        name = text.columns[both[0]].name
        raise InputError(f"{text.file}: column {quoted(name)} is both an input and an output")
    of = [place for place in range(count) if place not in to] if of is None else of
    if not of:
        raise InputError(f"{text.file}: every column is an output: no inputs are left")
    return ColumnChoice(of, to)


def _places(text: "TableText", names: str) -> list[int]:
    try:  # a title that holds a comma is taken whole
        return text.places(names)
    except DataError:
        parts = [part.strip() for part in names.split(",")]
    places: list[int] = []
    for part in filter(None, parts):
        found = text.places(part)
        if not set(found).isdisjoint(places):
            raise InputError(f"{text.file}: column {quoted(part)} is named twice")
        places += found
    if not places:
        raise InputError("at least one column's name is needed")
    return places
