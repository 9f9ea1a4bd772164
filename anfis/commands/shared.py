"""What the commands of ``anfis`` share: arguments and the error of options."""

from pathlib import Path
from typing import Annotated

from fuzzy.commands.completion import rule_bases
from fuzzy.errors import InputError
from fuzzy.shell.options import argument

Data = Annotated[
    Path, argument('Samples, a row each, below a header of names "speed [m/s]" or "speed (m/s)".', "DATA.csv")
]
Fis = Annotated[
    Path, argument("A Sugeno system: a .fis file, or a packaged one's name.", "NET", autocompletion=rule_bases)
]


class CommandError(InputError):
    """Options of the command line that do not go together."""
