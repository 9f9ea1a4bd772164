"""What the commands of all packages that read tables share: their options, and how tables are read.

The reader is :mod:`fuzzy.files.table`, imported when a command runs, so that ``--help`` is quick.
"""

import sys
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from fuzzy.errors import quoted
from fuzzy.shell.options import option

if TYPE_CHECKING:
    from fuzzy.files.table import Table, TableText
    from fuzzy.system import Variable

SkipBad = Annotated[
    bool, option("Leave out rows without a number in a column that is used, and say how many.", "--skip-bad")
]

Folds = Annotated[int | None, option("First cross-validate: learn K times, each time without one K-th.", "K", min=2)]
FoldsOrder = Annotated[str, option("Folds of shuffled rows, or for time series of blocks: shuffled, blocks.", "ORDER")]


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
