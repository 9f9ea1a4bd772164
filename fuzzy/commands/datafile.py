"""What the commands of all packages that read tables share: their options, and how columns are chosen.

The reader is :mod:`fuzzy.files.table`, imported when a command runs, so that ``--help`` is quick.
"""

import sys
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, NamedTuple

import typer

from fuzzy.errors import InputError, quoted

if TYPE_CHECKING:
    from fuzzy.files.table import Table, TableText
    from fuzzy.system import Variable

SkipBad = Annotated[
    bool,
    typer.Option("--skip-bad", help="Leave out rows without a number in a column that is used, and say how many."),
]

Folds = Annotated[
    int | None,
    typer.Option(min=2, metavar="K", help="First cross-validate: learn K times, each time without one K-th."),
]
FoldsOrder = Annotated[
    str,
    typer.Option(metavar="ORDER", help="Folds of shuffled rows, or for time series of blocks: shuffled, blocks."),
]


class Choice(NamedTuple):
    """Which columns are inputs and which are outputs: their places."""

    inputs: list[int]
    outputs: list[int]


def chosen_columns(text: "TableText", inputs: str | None, outputs: str | None) -> Choice:
    """The columns that options --inputs and --outputs name, by titles, names or numbers with commas between them.

    By default the last column is the output, and all that are no outputs are the inputs.
    """
    count = len(text.columns)
    if count < 2:
        raise InputError(f"{text.file}: one column; inputs and outputs need at least two")
    of = None if inputs is None else _places(text, inputs)
    to = [count - 1] if outputs is None else _places(text, outputs)
    both = [place for place in of or () if place in to]
    if both and outputs is None:
        raise InputError(f"{text.file}: the last column is among the inputs: say which are the --outputs")
    if both:
        name = text.columns[both[0]].name
        raise InputError(f"{text.file}: column {quoted(name)} is both an input and an output")
    of = [place for place in range(count) if place not in to] if of is None else of
    if not of:
        raise InputError(f"{text.file}: every column is an output: no inputs are left")
    return Choice(of, to)


def columns_of(text: "TableText", variables: "Sequence[Variable]") -> list[int]:
    """The places of the columns of a system's ``variables``, found by name. Raises DataError.

    Says on stderr where a column has another unit than its variable.
    """
    places = [text.place(v.name, v.unit) for v in variables]
    for place, variable in zip(places, variables, strict=True):
        unit = text.columns[place].unit
        if unit and variable.unit and unit != variable.unit:
            name = quoted(variable.name)
            print(f"{text.file}: {name} is in {unit}, but the system's in {variable.unit}", file=sys.stderr)
    return places


def numbers(text: "TableText", columns: Sequence[int], skip_bad: bool) -> "Table":
    """The numbers in ``columns``; rows that are left out are said on stderr. Raises DataError."""
    from fuzzy.files.table import BadRowsError

    try:
        table = text.numbers(columns, skip_bad)
    except BadRowsError as error:
        raise BadRowsError(f"{error}; --skip-bad leaves such rows out") from None
    if table.skipped:
        print(table.omission, file=sys.stderr)
    return table


def opened(path: Path) -> "TableText":
    """The table in the file ``path``. Raises DataError."""
    from fuzzy.files.table import open_table

    return open_table(path)


def _places(text: "TableText", names: str) -> list[int]:
    from fuzzy.files.table import DataError

    try:  # a title that holds a comma is taken whole
        return [text.place(names)]
    except DataError:
        parts = [part.strip() for part in names.split(",")]
    places: list[int] = []
    for part in filter(None, parts):
        place = text.place(part)
        if place in places:
            raise InputError(f"{text.file}: column {quoted(part)} is named twice")
        places.append(place)
    if not places:
        raise InputError("at least one column's name is needed")
    return places
