"""What the commands of ``anfis`` share: arguments and the error of options."""

from collections.abc import Callable
from pathlib import Path
from typing import Annotated

from fuzzy.commands.completion import rule_bases
from fuzzy.errors import InputError
from fuzzy.shell.options import argument
from fuzzy.shell.progress import Advance

Data = Annotated[
    Path, argument('Samples, a row each, below a header of names "speed [m/s]" or "speed (m/s)".', "DATA.csv")
]
Fis = Annotated[
    Path, argument("A Sugeno system: a .fis file, or a packaged one's name.", "NET", autocompletion=rule_bases)
]


class CommandError(InputError):
    """Options of the command line that do not go together."""


def reaching(advance: Advance) -> Callable[[int, str], None]:
    """A function that advances a bar until the step of this number, from 0, is done, with this description."""
    done = 0

    def reach(step: int, description: str) -> None:
        nonlocal done
        while done <= step:  # several at once where a training ended early, or goes on from a checkpoint
            advance(description)
            done += 1

    return reach
