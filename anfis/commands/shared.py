"""What the commands of ``anfis`` share: arguments, and the columns of a table by their names."""

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, NamedTuple

import typer

from fuzzy.commands.completion import rule_bases
from fuzzy.errors import InputError

if TYPE_CHECKING:
    import numpy as np

Data = Annotated[
    Path, typer.Argument(metavar="DATA.csv", help="Samples, a row each, with a header line.", show_default=False)
]
Fis = Annotated[
    Path,
    typer.Argument(
        metavar="NET",
        help="A Sugeno system: a .fis file, or a packaged one's name.",
        show_default=False,
        autocompletion=rule_bases,
    ),
]
Json = Annotated[bool, typer.Option("--json", help="Print one JSON object instead of text.")]


class CommandError(InputError):
    """Options of the command line that do not go together, or columns that a table lacks."""


class Table(NamedTuple):
    """A table as a command reads it."""

    file: Path
    names: tuple[str, ...]
    values: "np.ndarray"  # (samples, columns)

    def columns(self, wanted: Sequence[str]) -> "np.ndarray":
        """The columns called ``wanted``, (samples, wanted). Raises CommandError for a name that is not there."""
        from fuzzy.naming import expected

        for name in wanted:
            if name not in self.names:
                raise CommandError(f"{self.file}: {expected(name, self.names, 'column')}")
        return self.values[:, [self.names.index(name) for name in wanted]]


def read(path: Path) -> Table:
    """The table in the file ``path``; columns without a header are column1, column2, ... Raises DataError, OSError."""
    from fuzzy.files.table import read_table

    names, values = read_table(path)
    return Table(path, names or tuple(f"column{k + 1}" for k in range(values.shape[1])), values)


def listed(text: str) -> list[str]:
    """The names in a comma-separated option. Raises CommandError for none and for one that is named twice."""
    names = [part.strip() for part in text.split(",") if part.strip()]
    if not names:
        raise CommandError("at least one column's name is needed")
    twice = next((name for name in names if names.count(name) > 1), None)
    if twice is not None:
        raise CommandError(f"column {twice!r} is named twice")
    return names
