"""What the commands of ``anfis`` share: arguments and the error of options."""

from pathlib import Path
from typing import Annotated

import typer

from fuzzy.commands.completion import rule_bases
from fuzzy.errors import InputError

Data = Annotated[
    Path,
    typer.Argument(
        metavar="DATA.csv",
        help='Samples, a row each, below a header of names "speed [m/s]" or "speed (m/s)".',
        show_default=False,
    ),
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
    """Options of the command line that do not go together."""
