"""What the commands of all packages that read tables share: their options, and how tables are read.

The reader is :mod:`fuzzy.files.table`, imported when a command runs, so that ``--help`` is quick.
"""

import sys
from collections.abc import Sequence
from pathlib import Path
from shlex import quote
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


def numbers(text: "TableText", columns: Sequence[int], skip_bad: bool, chosen: int = 0) -> "Table":
    """The numbers in ``columns``; rows that are left out are said on stderr. Raises DataError.

    The first ``chosen`` columns are inputs that --inputs chooses.
    """
    from fuzzy.files.table import BadRowsError, DataError

    try:
        table = text.numbers(columns, skip_bad)
    except BadRowsError as error:
        inputs = [text.columns[place].name for place in columns[:chosen]]
        of_texts = [name for name in inputs if name in error.texts]
        if of_texts:
            rest = quote(",".join(name for name in inputs if name not in of_texts))
            leave = f"leave it out with --inputs {rest}, or " if rest != "''" else ""
            code = f"let anfis train --one-hot {quote(of_texts[0])} code it as 0/1 columns"
            raise DataError(f"{error}; {leave}{code}") from None
        if skip_bad or error.texts:
            raise
        raise BadRowsError(f"{error}; --skip-bad leaves such rows out") from None
    if table.skipped:
        print(table.omission, file=sys.stderr)
    return table


def opened(path: Path, inputs: "Sequence[Variable]" = ()) -> "TableText":
    """The table in the file ``path``, with columns of texts coded as a system's ``inputs`` were. Raises DataError."""
    from fuzzy.files.table import open_table

    text = open_table(path)
    known, coded = {column.name for column in text.columns}, dict[str, list[str]]()
    for variable in inputs:
        name, sign, category = variable.name.partition("=")
        if sign and variable.name not in known and name in known:
            coded.setdefault(name, []).append(category)
    for name, categories in coded.items():
        text = text.coded(name, categories)
    return text
